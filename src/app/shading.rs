//! Flags of how surfaces are shaded.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::error::AppError;
use crate::reflectance::masking::shadowing::Shadowing;
use crate::render::settings::{DiffuseLights, Quadrature, ShadingSettings, Technique, Terms};

/// Where the integrals over visible slopes are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// The paper's N by N grid, see --grid.
    Grid,
    /// Few samples placed by what the viewer sees, see --probes.
    Visible,
}

/// Flags of the shading.
#[derive(Clone, Debug, Args)]
pub struct ShadingArgs {
    /// How the surface is filtered and shaded
    #[arg(long, value_name = "NAME", value_parser = techniques(), default_value = "leadr")]
    pub technique: Technique,
    /// Where light is sampled [default: grid with --grid, else visible]
    #[arg(long, value_enum)]
    pub rule: Option<Rule>,
    /// Light each pixel through N by N slope samples, 1 to 128 [default of --rule grid: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=128))]
    pub grid: Option<u32>,
    /// Look the environment up N times per pixel: 5, 9 or 16 [default: 16]
    #[arg(long, value_name = "N", conflicts_with = "grid", value_parser = probes)]
    pub probes: Option<u32>,
    /// Which facets that the viewer sees are left dark because others hide the light from them [default: correlated]
    #[arg(long, value_name = "KIND", value_parser = shadowing_models())]
    pub masking: Option<Shadowing>,
    /// Which light counts: all, or some of specular-lights, diffuse-lights, specular-environment, diffuse-environment
    #[arg(long, value_name = "all|NAME,...", value_parser = terms, default_value = "all")]
    pub terms: Terms,
    /// Diffuse light of the sun and of point lights [default: cosine]
    #[arg(long, value_name = "KIND", value_parser = diffuse_lights())]
    pub diffuse_lights: Option<DiffuseLights>,
    /// Count the turn of the smooth surface under a pixel as roughness, which the paper does not [default: on]
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub pixel_kernel: Option<bool>,
}

/// Probes of the rules when only `--rule visible` is given.
const DEFAULT_PROBES: u32 = 16;
/// Side of the grid when only `--rule grid` is given: the paper's.
const DEFAULT_GRID: u32 = 5;

impl ShadingArgs {
    /// The settings these flags mean.
    ///
    /// # Errors
    /// [`AppError::Usage`] if they contradict each other.
    pub fn resolve(&self) -> Result<ShadingSettings, AppError> {
        let usage = |fault: &str| Err(AppError::Usage(fault.to_owned()));
        let quadrature = match (self.rule, self.grid, self.probes) {
            (Some(Rule::Visible), Some(_), _) => {
                return usage("--grid is for --rule grid; --rule visible takes --probes");
            }
            (Some(Rule::Grid), _, Some(_)) => {
                return usage("--probes is for --rule visible; --rule grid takes --grid");
            }
            (_, _, Some(n)) => Quadrature::VisibleSlopes(n),
            (_, Some(n), _) => Quadrature::Grid(n),
            (Some(Rule::Visible), ..) => Quadrature::VisibleSlopes(DEFAULT_PROBES),
            (Some(Rule::Grid), ..) => Quadrature::Grid(DEFAULT_GRID),
            (None, ..) => ShadingSettings::default().quadrature,
        };
        let integral = [
            ("--rule", self.rule.is_some()),
            ("--grid", self.grid.is_some()),
            ("--probes", self.probes.is_some()),
            ("--masking", self.masking.is_some()),
            ("--diffuse-lights", self.diffuse_lights.is_some()),
        ];
        if let Some((flag, _)) = integral.iter().find(|(_, given)| *given)
            && !self.technique.integrates()
        {
            let integrating = Technique::ALL.into_iter().filter(|t| t.integrates()).map(Technique::name);
            let (name, integrating) = (self.technique.name(), integrating.collect::<Vec<_>>().join(", "));
            return usage(&format!("{flag} is for techniques that integrate over slopes ({integrating}), not {name}"));
        }
        if self.pixel_kernel.is_some() && !self.technique.has_pixel_kernel() {
            let name = self.technique.name();
            return usage(&format!(
                "--pixel-kernel is for leadr and leadr-ggx, the techniques that have one, not {name}"
            ));
        }
        if self.technique == Technique::Constant && self.terms != Terms::ALL {
            return usage("--terms chooses light, and --technique constant has none");
        }
        let default = ShadingSettings::default();
        let settings = ShadingSettings {
            technique: self.technique,
            quadrature,
            shadowing: self.masking.unwrap_or(default.shadowing),
            terms: self.terms,
            diffuse_lights: self.diffuse_lights.unwrap_or(default.diffuse_lights),
            pixel_kernel: self.pixel_kernel.unwrap_or(default.pixel_kernel),
        };
        settings.check().map_err(AppError::Usage)?;
        Ok(settings)
    }
}

/// A flag whose values are known by name, each with a line of help.
fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
    help: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(move |&value| PossibleValue::new(name(value)).help(help(value)));
    PossibleValuesParser::new(values)
        .try_map(move |text| all.iter().copied().find(|&v| name(v) == text).ok_or("no such name"))
}

pub(super) fn techniques() -> impl TypedValueParser<Value = Technique> {
    choice(&Technique::ALL, Technique::name, |technique| match technique {
        Technique::Constant => "Albedo without light",
        Technique::BlinnPhong => "Mipmapped normals, Blinn-Phong",
        Technique::NormalMip => "Mipmapped normals, LEADR's BRDF: what goes wrong without slope statistics",
        Technique::Toksvig => "Mipmapped normals, roughness from their length",
        Technique::Clean => "One slope variance (CLEAN mapping)",
        Technique::Lean => "Slope covariance without projected areas (LEAN mapping)",
        Technique::Leadr => "Slope covariance and projected areas (LEADR mapping)",
        Technique::LeadrGgx => "LEADR mapping of a GGX base",
        Technique::Reference => "The finest maps at every distance, as many samples as it takes",
    })
}

fn shadowing_models() -> impl TypedValueParser<Value = Shadowing> {
    choice(&Shadowing::MAIN, Shadowing::name, Shadowing::help)
}

fn diffuse_lights() -> impl TypedValueParser<Value = DiffuseLights> {
    choice(&DiffuseLights::ALL, DiffuseLights::name, |kind| match kind {
        DiffuseLights::Cosine => "The clamped cosine at every slope sample",
        DiffuseLights::Sh => "Order-2 spherical harmonics, as in the LEADR paper; up to 9 % off",
    })
}

fn on_off(text: &str) -> Result<bool, &'static str> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("this is on or off"),
    }
}

fn probes(text: &str) -> Result<u32, String> {
    let known = Quadrature::PROBES;
    text.parse().ok().filter(|n| known.contains(n)).ok_or(format!("probes are one of {known:?}"))
}

fn terms(text: &str) -> Result<Terms, String> {
    if text == "all" {
        return Ok(Terms::ALL);
    }
    text.split(',').try_fold(Terms::NONE, |terms, name| {
        let term = Terms::NAMES.iter().find(|(_, known)| *known == name.trim()).map(|(term, _)| *term);
        let known = Terms::ALL.names().collect::<Vec<_>>().join(", ");
        Ok(terms | term.ok_or(format!("'{name}' is no term; there are all, or some of {known}"))?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        shading: ShadingArgs,
    }

    fn resolve(flags: &[&str]) -> Result<ShadingSettings, String> {
        let flags = Flags::try_parse_from([&["leadr"], flags].concat()).map_err(|e| e.to_string())?;
        flags.shading.resolve().map_err(|e| e.to_string())
    }

    #[test]
    fn flags_become_settings() {
        assert_eq!(resolve(&[]).unwrap(), ShadingSettings::default());
        assert_eq!(resolve(&["--grid", "7"]).unwrap().quadrature, Quadrature::Grid(7));
        assert!(!resolve(&["--pixel-kernel", "off"]).unwrap().pixel_kernel);
        let terms = resolve(&["--terms", "specular-lights,diffuse-environment"]).unwrap().terms;
        assert_eq!(terms, Terms::SPECULAR_LIGHTS | Terms::DIFFUSE_ENVIRONMENT);
        assert_eq!(terms.names().collect::<Vec<_>>(), ["specular-lights", "diffuse-environment"]);
    }

    #[test]
    fn contradictions_and_unknown_names_are_refused() {
        for (flags, word) in [
            (&["--rule", "visible", "--grid", "5"][..], "--probes"),
            (&["--rule", "grid", "--probes", "5"], "--grid"),
            (&["--grid", "5", "--probes", "5"], "--grid"),
            (&["--probes", "4"], "16"),
            (&["--grid", "129"], "128"),
            (&["--technique", "phong"], "blinn-phong"),
            (&["--terms", "specular"], "specular-lights"),
            (&["--technique", "lean", "--grid", "7"], "leadr-ggx"),
            (&["--technique", "toksvig", "--masking", "smith"], "--masking"),
            (&["--technique", "lean", "--pixel-kernel", "off"], "--pixel-kernel"),
            (&["--pixel-kernel", "maybe"], "on or off"),
            (&["--technique", "constant", "--terms", "diffuse-lights"], "constant"),
        ] {
            let fault = resolve(flags).expect_err(&flags.join(" "));
            assert!(fault.contains(word), "{flags:?}: {fault}");
        }
    }
}
