//! The BRDF of Bagher, Soler and Holzschuch (2012), known as SGD: shifted gamma facets over a diffuse base. Each colour channel has its own
//! parameters.
//!
//! ```text
//! f_r = ρ_d / π + ρ_s / π · F D G₁(o) G₁(i) / (cos θ_i cos θ_o),   F = F₀ − F₁ cos θ_d + (1 − F₀)(1 − cos θ_d)⁵
//! ```
//!
//! `G₁` is Smith's masking of the distribution, which the authors approximate by a fitted curve.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::brdf::Brdf;
use super::microfacet::microfacet_eval;
use crate::facets::fresnel::schlick_weight;
use crate::facets::parametric_curve::ParametricCurve;
use crate::facets::radial_table::RadialTable;
use crate::masking::variants::Masking;

/// The parameters of one colour channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShiftedGammaChannel {
    /// The width `α` of the distribution, above 0.
    pub alpha: f64,
    /// The exponent `p` of the distribution.
    pub p: f64,
    /// The albedo `ρ_d` of the diffuse base, at least 0.
    pub diffuse: f64,
    /// The strength `ρ_s` of the specular term, at least 0.
    pub specular: f64,
    /// The parameters `F₀` and `F₁` of the Fresnel term.
    pub fresnel: [f64; 2],
}

impl ShiftedGammaChannel {
    /// Returns the curve of the normal density.
    pub const fn curve(&self) -> ParametricCurve {
        ParametricCurve::ShiftedGamma { alpha: self.alpha, p: self.p }
    }

    /// Returns the Fresnel term at `cosine = cos θ_d`. The printed term can be negative, which counts as 0.
    pub fn fresnel_at(&self, cosine: f64) -> f64 {
        let [f0, f1] = self.fresnel;
        (f0 - f1 * cosine + (1.0 - f0) * schlick_weight(cosine)).max(0.0)
    }
}

/// The BRDF of three colour channels.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiftedGamma {
    channels: [(ShiftedGammaChannel, RadialTable); 3],
}

impl ShiftedGamma {
    /// Creates the BRDF for red, green and blue. Returns `None` if the curve of a channel has no table.
    pub fn new(channels: [ShiftedGammaChannel; 3]) -> Option<Self> {
        let [r, g, b] = channels.map(|channel| channel.curve().table().map(|table| (channel, table)));
        Some(Self { channels: [r?, g?, b?] })
    }

    /// Returns the parameters of red, green and blue.
    pub fn channels(&self) -> [ShiftedGammaChannel; 3] {
        self.channels.each_ref().map(|(channel, _)| *channel)
    }
}

impl Brdf for ShiftedGamma {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        let cosine = 0.5 * (wo + wi).length();
        let value = |(channel, table): &(ShiftedGammaChannel, RadialTable)| {
            // The library's facets have the factor 1/4 instead of 1/π.
            let specular = 4.0 * FRAC_1_PI * channel.specular * channel.fresnel_at(cosine);
            FRAC_1_PI * channel.diffuse * wi.z + specular * microfacet_eval(Masking::SmithSeparable, table, wo, wi)
        };
        DVec3::from_array(self.channels.each_ref().map(value))
    }
}
