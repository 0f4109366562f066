//! Measures the accuracy of the library's rules for integrals over visible slopes, against converged integrals over random surfaces,
//! viewers and environments. `docs/measurements/quadrature.md` has the tables.
//!
//! The module [`diffuse`] measures order-2 irradiance, and [`light`] measures the clamped cosine of one light. The module
//! [`specular`] measures environments of smooth or sharp lobes, prefiltered like a mip chain. The modules [`fit`] and
//! [`fit_probes`] fit the constants of the rules. The module [`sweep`] measures how much the result changes per step of a
//! slow sweep. The module [`samplers`] measures the other samplers that the papers name, [`printed`] what the papers
//! print about their grid, and [`micronormal`] the pixels whose mesonormal faces away.

pub mod diffuse;
pub mod fit;
pub mod fit_probes;
pub mod light;
pub mod micronormal;
pub mod printed;
pub mod samplers;
pub mod specular;
pub mod surfaces;
pub mod sweep;

use surfaces::Surface;

/// The upper bounds of the roughness classes of [`Row::classes`]. The larger slope deviation selects the class. The last
/// class has no upper bound.
pub const CLASSES: [f64; 5] = [0.1, 0.3, 0.7, 1.2, 2.0];

/// The errors of one quadrature rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name of the rule.
    pub rule: String,
    /// The number of slopes, terms or lookups per pixel.
    pub evaluations: u32,
    /// The RMS error, in units of the environment's mean radiance or the light's irradiance.
    pub rms: f64,
    /// The 95th percentile of the absolute error.
    pub p95: f64,
    /// The largest absolute error.
    pub max: f64,
    /// The RMS error per class of [`CLASSES`], which is NaN for classes without surfaces.
    pub classes: [f64; 5],
}

impl Row {
    /// The header line for [`Row::line`].
    pub const HEADER: &str =
        "rule                          n      rms      p95      max | rms by roughness <.1 <.3 <.7 <1.2 <2";

    /// Computes statistics of the absolute errors `errors[surface]`. A surface may have any number of errors.
    pub fn new(rule: &str, evaluations: u32, surfaces: &[Surface], errors: &[Vec<f64>]) -> Self {
        let rms = |e: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = e.fold((0.0, 0u32), |(s, n), e| (s + e * e, n + 1));
            (sum / f64::from(n)).sqrt()
        };
        let mut all: Vec<f64> = errors.iter().flatten().map(|e| e.abs()).collect();
        all.sort_by(f64::total_cmp);
        let classes = std::array::from_fn(|i| {
            let class = |s: &Surface| CLASSES.iter().position(|&top| s.roughness() < top).unwrap_or(4) == i;
            rms(&mut surfaces.iter().zip(errors).filter(|(s, _)| class(s)).flat_map(|(_, e)| e.iter().copied()))
        });
        Self {
            rule: rule.to_owned(),
            evaluations,
            rms: rms(&mut all.iter().copied()),
            p95: all[(all.len() * 95 / 100).min(all.len() - 1)],
            max: all[all.len() - 1],
            classes,
        }
    }

    /// Formats one line of text, with the columns of [`Row::HEADER`].
    pub fn line(&self) -> String {
        let classes: Vec<String> = self.classes.iter().map(|c| format!("{c:.1e}")).collect();
        format!(
            "{:<28} {:>4} {:>8.2e} {:>8.2e} {:>8.2e} | {}",
            self.rule,
            self.evaluations,
            self.rms,
            self.p95,
            self.max,
            classes.join(" ")
        )
    }
}
