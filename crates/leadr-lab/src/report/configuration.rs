//! The techniques and rules that are compared with the truth, and their names on the page.

use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{Probes, Quadrature, RenderSettings, Shading, ShadingOptions, Technique, Terms};

/// Returns the program's default options with the shadowing of the rasterised truth. The rasterised truth has shadows only
/// for lights (Smith), because its bumps do not block the environment. Ray-cast bumps block the environment, so the other
/// shadowing models are compared with ray casts.
fn options() -> ShadingOptions {
    ShadingOptions { shadowing: Shadowing::Smith, relief_occlusion: false, ..Default::default() }
}

/// A named shading configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// The name on the page and in the data.
    pub name: String,
    /// The shading settings.
    pub shading: Shading,
}

impl Configuration {
    /// Returns a technique with the default rule.
    pub fn of(technique: Technique) -> Self {
        Self { name: technique.name().to_owned(), shading: technique.with(options()) }
    }

    /// Returns LEADR with the paper's grid of `n × n` samples.
    pub fn grid(n: u32) -> Self {
        Self::leadr(format!("leadr {n}×{n}"), Quadrature::Grid(n))
    }

    /// Returns LEADR with the visible-slope rules and `probes` environment probes.
    pub fn visible(probes: Probes) -> Self {
        Self::leadr(format!("leadr visible {}", probes.count()), Quadrature::VisibleSlopes(probes))
    }

    fn leadr(name: String, quadrature: Quadrature) -> Self {
        Self { name, shading: Technique::Leadr.with(ShadingOptions { quadrature, ..options() }) }
    }

    /// Whether the configuration uses the paper's grid.
    pub fn is_grid(&self) -> bool {
        matches!(self.shading.quadrature(), Some(Quadrature::Grid(_)))
    }

    /// Returns LEADR with the default rules.
    pub fn best() -> Self {
        Self { name: "leadr, default rules".to_owned(), shading: Technique::Leadr.with(options()) }
    }

    /// Returns LEADR with the program's default settings, for comparison with truths that have all shadows.
    pub fn program_default() -> Self {
        Self { name: "leadr, as by default".to_owned(), shading: Shading::default() }
    }

    /// Returns every technique except the references, and LEADR with both the paper's grid and the rules.
    pub fn techniques() -> Vec<Self> {
        let others = |t: &Technique| *t != Technique::Leadr && !t.is_reference();
        let mut configs: Vec<Self> = Technique::ALL.into_iter().filter(others).map(Self::of).collect();
        configs.push(Self::grid(5));
        configs.push(Self::visible(Probes::Nine));
        configs
    }

    /// Returns a copy of the configuration with these light terms and this shadowing model.
    #[must_use]
    pub fn with(mut self, terms: Terms, shadowing: Shadowing) -> Self {
        self.shading = self.shading.adjusted(|options| ShadingOptions { terms, shadowing, ..options });
        self
    }

    /// Returns the settings of a picture. Occlusion of the sky by large shapes is not part of the comparison.
    pub fn settings(&self, size: (u32, u32), samples: u32) -> RenderSettings {
        let shading = self.shading.adjusted(|options| ShadingOptions { sky_occlusion: false, ..options });
        RenderSettings { size, samples, shading, ..RenderSettings::default() }
    }

    /// Returns the name in a form that is valid in file names.
    pub fn file(&self) -> String {
        self.name.replace(", ", "-").replace(' ', "-").replace('×', "x")
    }
}
