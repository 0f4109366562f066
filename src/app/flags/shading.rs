//! Flags of filtering and shading.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::values::whole;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{BaseFrame, DiffuseLights, Probes, Quadrature, Shading, ShadingOptions, Technique, Terms};
use leadr_tools::command::error::AppError;

/// How the integrals over visible slopes are sampled.
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
    /// How the integrals over slopes are sampled [default: grid with --grid, else visible]
    #[arg(long, value_enum)]
    pub rule: Option<Rule>,
    /// Slope samples per pixel: N by N, 1 to 128 [default of --rule grid: 5]
    #[arg(long, value_name = "N", value_parser = |text: &str| whole(text, 1_u32, 128))]
    pub grid: Option<u32>,
    /// Look the environment up N times per pixel: 5, 9 or 16 [default: 16]
    #[arg(long, value_name = "N", conflicts_with = "grid", value_parser = probes)]
    pub probes: Option<Probes>,
    /// Shadowing model: which visible facets stay dark because others hide them from the light [default: correlated]
    #[arg(long, value_name = "KIND", value_parser = shadowing_models())]
    pub masking: Option<Shadowing>,
    /// Light to include: all, or some of specular-lights, diffuse-lights, specular-environment, diffuse-environment
    #[arg(long, value_name = "all|NAME,...", value_parser = terms, default_value = "all")]
    pub terms: Terms,
    /// How diffuse facets reflect the sun and point lights [default: cosine]
    #[arg(long, value_name = "KIND", value_parser = diffuse_lights())]
    pub diffuse_lights: Option<DiffuseLights>,
    /// The frame in which the base material is rough [default: facet]
    #[arg(long, value_name = "KIND", value_parser = base_frames())]
    pub base_frame: Option<BaseFrame>,
    /// Count the curvature of the smooth surface under a pixel as roughness, which the paper does not [default: on]
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub pixel_kernel: Option<bool>,
    /// Let bumps larger than a pixel hide the environment and the lights from each other, which the paper does not [default: on]
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub relief_occlusion: Option<bool>,
    /// Let colours that follow heights or slopes be those of what is seen and lit, which the paper does not [default: off]
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub relief_color: Option<bool>,
    /// Let the facets of materials light each other, which the paper does not: mirrors lose no light, and diffuse bodies flatten where they
    /// are rough [default: off]
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub multiscattering: Option<bool>,
    /// Let large shapes hide the environment from each other and from the ground, which the paper does not [default: on]
    #[arg(long, value_name = "on|off", value_parser = on_off)]
    pub sky_occlusion: Option<bool>,
}

/// Probes of the rules when only `--rule visible` is given.
const DEFAULT_PROBES: Probes = Probes::Sixteen;
/// Side of the grid when only `--rule grid` is given: the paper's.
const DEFAULT_GRID: u32 = 5;

impl ShadingArgs {
    /// The shading that these flags ask for, together with the scene's flags `--edge-samples` (1: none) and `--relief-shadows`.
    ///
    /// # Errors
    /// [`AppError::Usage`] if they contradict each other.
    pub fn resolve(&self, edge_samples: u32, relief_shadows: bool) -> Result<Shading, AppError> {
        let quadrature = self.quadrature()?;
        self.refuse_foreign_flags(edge_samples, relief_shadows)?;
        let default = ShadingOptions::default();
        let shading = self.technique.with(ShadingOptions {
            terms: self.terms,
            quadrature,
            shadowing: self.masking.unwrap_or(default.shadowing),
            diffuse_lights: self.diffuse_lights.unwrap_or(default.diffuse_lights),
            base_frame: self.base_frame.unwrap_or(default.base_frame),
            pixel_kernel: self.pixel_kernel.unwrap_or(default.pixel_kernel),
            relief_occlusion: self.relief_occlusion.unwrap_or(default.relief_occlusion),
            relief_color: self.relief_color.unwrap_or(default.relief_color),
            multiscattering: self.multiscattering.unwrap_or(default.multiscattering),
            // Comparisons leave it out; pictures of scenes have it, but where rays find it.
            sky_occlusion: self.sky_occlusion.unwrap_or(!relief_shadows),
            edge_samples,
            relief_shadows,
        });
        shading.check().map_err(AppError::Usage)?;
        Ok(shading)
    }

    fn quadrature(&self) -> Result<Quadrature, AppError> {
        let usage = |fault: &str| Err(AppError::Usage(fault.to_owned()));
        Ok(match (self.rule, self.grid, self.probes) {
            (Some(Rule::Visible), Some(_), _) => {
                return usage("--grid is for --rule grid; --rule visible takes --probes");
            }
            (Some(Rule::Grid), _, Some(_)) => {
                return usage("--probes is for --rule visible; --rule grid takes --grid");
            }
            (_, _, Some(probes)) => Quadrature::VisibleSlopes(probes),
            (_, Some(n), _) => Quadrature::Grid(n),
            (Some(Rule::Visible), ..) => Quadrature::VisibleSlopes(DEFAULT_PROBES),
            (Some(Rule::Grid), ..) => Quadrature::Grid(DEFAULT_GRID),
            (None, ..) => ShadingOptions::default().quadrature,
        })
    }

    /// Refuses flags of settings that the technique does not have.
    fn refuse_foreign_flags(&self, edge_samples: u32, relief_shadows: bool) -> Result<(), AppError> {
        let technique = self.technique;
        let integral = [
            ("--rule", self.rule.is_some()),
            ("--grid", self.grid.is_some()),
            ("--probes", self.probes.is_some()),
            ("--masking", self.masking.is_some()),
            ("--diffuse-lights", self.diffuse_lights.is_some()),
            ("--relief-occlusion", self.relief_occlusion.is_some()),
        ];
        let name = technique.name();
        let fault = if let Some((flag, _)) = integral.iter().find(|(_, given)| *given)
            && !technique.integrates()
        {
            let techniques = names_where(Technique::integrates);
            format!("{flag} is for techniques that integrate over slopes ({techniques}), not {name}")
        } else if self.pixel_kernel.is_some() && !technique.has_pixel_kernel() {
            let techniques = names_where(Technique::has_pixel_kernel);
            format!("--pixel-kernel is for techniques with a pixel kernel ({techniques}), not {name}")
        } else if self.relief_color.is_some() && !technique.has_relief_color() {
            let techniques = names_where(Technique::has_relief_color);
            format!("--relief-color is for techniques that integrate over a covariance ({techniques}), not {name}")
        } else if self.multiscattering.is_some() && !technique.has_multiscattering() {
            let techniques = names_where(Technique::has_multiscattering);
            format!("--multiscattering is for techniques whose base has tables of energy ({techniques}), not {name}")
        } else if self.base_frame.is_some() && !technique.has_base_frame() {
            let techniques = names_where(Technique::has_base_frame);
            format!("--base-frame is for techniques that integrate over a Beckmann base ({techniques}), not {name}")
        } else if self.terms != Terms::ALL && !technique.is_lit() {
            format!("--terms chooses light, and --technique {name} has none")
        } else if relief_shadows && !technique.has_relief_shadows() {
            "--relief-shadows is for --technique reference; --masking chooses the shadowing of the others".to_owned()
        } else if relief_shadows && self.multiscattering == Some(true) {
            "--multiscattering is not among what --relief-shadows knows: leave one of them out".to_owned()
        } else if self.sky_occlusion == Some(true) && !technique.is_lit() {
            format!("--sky-occlusion is about light, and --technique {name} has none")
        } else if relief_shadows && self.sky_occlusion == Some(true) {
            "--relief-shadows asks the casters themselves what they hide: leave --sky-occlusion out".to_owned()
        } else if edge_samples > 1 && technique.is_reference() {
            format!("--edge-samples is for techniques that filter; --technique {name} takes --samples")
        } else {
            return Ok(());
        };
        Err(AppError::Usage(fault))
    }
}

/// Names of the techniques for which `so` holds, as a list.
fn names_where(so: fn(Technique) -> bool) -> String {
    Technique::ALL.into_iter().filter(|&technique| so(technique)).map(Technique::name).collect::<Vec<_>>().join(", ")
}

/// A flag whose values are known by name, each with a line of help.
pub fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
    help: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(move |&value| PossibleValue::new(name(value)).help(help(value)));
    PossibleValuesParser::new(values)
        .try_map(move |text| all.iter().copied().find(|&v| name(v) == text).ok_or("no such name"))
}

pub fn techniques() -> impl TypedValueParser<Value = Technique> {
    choice(&Technique::ALL, Technique::name, Technique::help)
}

fn shadowing_models() -> impl TypedValueParser<Value = Shadowing> {
    const MODELS: [Shadowing; 4] = [Shadowing::NormalMap, Shadowing::None, Shadowing::Smith, Shadowing::Correlated];
    choice(&MODELS, Shadowing::name, Shadowing::help)
}

fn diffuse_lights() -> impl TypedValueParser<Value = DiffuseLights> {
    choice(&DiffuseLights::ALL, DiffuseLights::name, DiffuseLights::help)
}

fn base_frames() -> impl TypedValueParser<Value = BaseFrame> {
    choice(&BaseFrame::ALL, BaseFrame::name, BaseFrame::help)
}

/// What `on` or `off` says.
///
/// # Errors
/// Any other word.
pub fn on_off(text: &str) -> Result<bool, &'static str> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("this is on or off"),
    }
}

fn probes(text: &str) -> Result<Probes, String> {
    let known = Probes::ALL.map(Probes::count);
    text.parse().ok().and_then(Probes::of).ok_or_else(|| format!("probes are one of {known:?}"))
}

fn terms(text: &str) -> Result<Terms, String> {
    if text == "all" {
        return Ok(Terms::ALL);
    }
    text.split(',').try_fold(Terms::NONE, |terms, name| {
        let term = Terms::NAMES.iter().find(|(_, known)| *known == name.trim()).map(|(term, _)| *term);
        let known = Terms::ALL.names().collect::<Vec<_>>().join(", ");
        Ok(terms | term.ok_or(format!("'{name}' is not a term: use all, or some of {known}"))?)
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

    fn resolve(flags: &[&str]) -> Result<Shading, String> {
        let flags = Flags::try_parse_from([&["leadr"], flags].concat()).map_err(|e| e.to_string())?;
        flags.shading.resolve(1, false).map_err(|e| e.to_string())
    }

    #[test]
    fn flags_become_settings() {
        let options = |flags: &[&str]| resolve(flags).unwrap().options();
        assert_eq!(resolve(&["--sky-occlusion", "off"]).unwrap(), Shading::default());
        assert_eq!(options(&["--grid", "7"]).quadrature, Quadrature::Grid(7));
        assert_eq!(options(&["--probes", "9"]).quadrature, Quadrature::VisibleSlopes(Probes::Nine));
        assert!(!options(&["--pixel-kernel", "off"]).pixel_kernel);
        assert!(!options(&["--relief-occlusion", "off"]).relief_occlusion);
        assert!(options(&["--multiscattering", "on"]).multiscattering && !options(&[]).multiscattering);
        assert!(options(&["--technique", "gloss", "--multiscattering", "on"]).multiscattering);
        assert!(!options(&["--sky-occlusion", "off"]).sky_occlusion && options(&[]).sky_occlusion);
        assert_eq!(options(&["--masking", "normal-map"]).shadowing, Shadowing::NormalMap);
        assert!(options(&["--relief-color", "on"]).relief_color && !options(&[]).relief_color);
        let terms = resolve(&["--terms", "specular-lights,diffuse-environment"]).unwrap().terms();
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
            (&["--technique", "lean", "--relief-occlusion", "on"], "--relief-occlusion"),
            (&["--technique", "leadr-ggx", "--multiscattering", "off"], "--multiscattering"),
            (&["--technique", "reference", "--relief-color", "on"], "--relief-color"),
            (&["--technique", "constant", "--sky-occlusion", "on"], "--sky-occlusion"),
            (&["--pixel-kernel", "maybe"], "on or off"),
            (&["--technique", "constant", "--terms", "diffuse-lights"], "constant"),
        ] {
            let fault = resolve(flags).expect_err(&flags.join(" "));
            assert!(fault.contains(word), "{flags:?}: {fault}");
        }
    }
}
