//! The techniques and rules compared with the truth, with their names on the page.

use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{Probes, Quadrature, RenderSettings, Shading, ShadingOptions, Technique, Terms};

/// The program's default with the rasterised truth's shadowing: lights only (Smith), because that truth does not block the environment by
/// bumps.
/// Ray casts do; the other shadowing models are compared with them.
fn options() -> ShadingOptions {
    ShadingOptions { shadowing: Shadowing::Smith, relief_occlusion: false, ..Default::default() }
}

/// A shading configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// Name on the page and in the data.
    pub name: String,
    /// Its settings.
    pub shading: Shading,
}

impl Configuration {
    /// A technique with the default rule.
    pub fn of(technique: Technique) -> Self {
        Self { name: technique.name().to_owned(), shading: technique.with(options()) }
    }

    /// LEADR with the paper's grid of `n × n` samples.
    pub fn grid(n: u32) -> Self {
        Self::leadr(format!("leadr {n}×{n}"), Quadrature::Grid(n))
    }

    /// LEADR with the visible-slope rules and `probes` environment probes.
    pub fn visible(probes: Probes) -> Self {
        Self::leadr(format!("leadr visible {}", probes.count()), Quadrature::VisibleSlopes(probes))
    }

    fn leadr(name: String, quadrature: Quadrature) -> Self {
        Self { name, shading: Technique::Leadr.with(ShadingOptions { quadrature, ..options() }) }
    }

    /// Whether it uses the paper's grid.
    pub fn is_grid(&self) -> bool {
        matches!(self.shading.quadrature(), Some(Quadrature::Grid(_)))
    }

    /// LEADR with the default rules.
    pub fn best() -> Self {
        Self { name: "leadr, default rules".to_owned(), shading: Technique::Leadr.with(options()) }
    }

    /// LEADR with the program's default settings, for truths with all shadows.
    pub fn program_default() -> Self {
        Self { name: "leadr, as by default".to_owned(), shading: Shading::default() }
    }

    /// Every technique except the references; LEADR with the paper's grid and with the rules.
    pub fn techniques() -> Vec<Self> {
        let others = |t: &Technique| *t != Technique::Leadr && !t.is_reference();
        let mut configs: Vec<Self> = Technique::ALL.into_iter().filter(others).map(Self::of).collect();
        configs.push(Self::grid(5));
        configs.push(Self::visible(Probes::Nine));
        configs
    }

    /// The same configuration with these light terms and shadowing model.
    #[must_use]
    pub fn with(mut self, terms: Terms, shadowing: Shadowing) -> Self {
        self.shading = self.shading.adjusted(|options| ShadingOptions { terms, shadowing, ..options });
        self
    }

    /// Settings of a picture. Occlusion of the sky by large shapes is not part of the comparison.
    pub fn settings(&self, size: (u32, u32), samples: u32) -> RenderSettings {
        let shading = self.shading.adjusted(|options| ShadingOptions { sky_occlusion: false, ..options });
        RenderSettings { size, samples, shading, ..RenderSettings::default() }
    }

    /// The name in a form for file names.
    pub fn file(&self) -> String {
        self.name.replace(", ", "-").replace(' ', "-").replace('×', "x")
    }
}
