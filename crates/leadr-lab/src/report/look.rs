//! What is compared with the truth: techniques and rules under the names that the page gives them.

use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{Probes, Quadrature, RenderSettings, Shading, ShadingOptions, Technique, Terms};

/// The program's default, but shadowed like the rasterised truth: lights alone (Smith), because that truth lets the environment
/// through the bumps. The other shadowing models are compared with ray casts, which do not.
fn options() -> ShadingOptions {
    ShadingOptions { shadowing: Shadowing::Smith, relief_occlusion: false, ..Default::default() }
}

/// A way to shade.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Name on the page and in the data.
    pub name: String,
    /// Its settings.
    pub shading: Shading,
}

impl Look {
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

    /// Whether it integrates on the paper's grid.
    pub fn is_grid(&self) -> bool {
        matches!(self.shading.quadrature(), Some(Quadrature::Grid(_)))
    }

    /// LEADR with the rules that the program uses by default.
    pub fn best() -> Self {
        Self { name: "leadr, default rules".to_owned(), shading: Technique::Leadr.with(options()) }
    }

    /// LEADR as the program draws it by default, for truths with all shadows.
    pub fn default_of_the_program() -> Self {
        Self { name: "leadr, as by default".to_owned(), shading: Shading::default() }
    }

    /// Every technique but the references; LEADR with the paper's grid and with the rules.
    pub fn techniques() -> Vec<Self> {
        let others = |t: &Technique| *t != Technique::Leadr && !t.is_reference();
        let mut looks: Vec<Self> = Technique::ALL.into_iter().filter(others).map(Self::of).collect();
        looks.push(Self::grid(5));
        looks.push(Self::visible(Probes::Nine));
        looks
    }

    /// The same look with some terms of the light and one shadowing model.
    #[must_use]
    pub fn with(mut self, terms: Terms, shadowing: Shadowing) -> Self {
        self.shading = self.shading.adjusted(|options| ShadingOptions { terms, shadowing, ..options });
        self
    }

    /// Settings of a picture. What large shapes hide of the sky is no part of what techniques are compared by.
    pub fn settings(&self, size: (u32, u32), samples: u32) -> RenderSettings {
        let shading = self.shading.adjusted(|options| ShadingOptions { sky_occlusion: false, ..options });
        RenderSettings { size, samples, shading, ..RenderSettings::default() }
    }

    /// The name as part of a file's name.
    pub fn file(&self) -> String {
        self.name.replace(", ", "-").replace(' ', "-").replace('×', "x")
    }
}
