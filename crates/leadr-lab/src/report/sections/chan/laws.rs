//! The diffuse laws that the figures compare, as `π f_r` of a white base.

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use crate::facet_walk::{Facets, facet_walks};
use crate::multiscattering_study::fitted;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::diffuse_models::{DiffuseModel, conserving_diffuse, diffuse_value};
use leadr_reflectance::materials::energy::EnergyTable;
use leadr_reflectance::materials::microfacet::half_vector;
use leadr_reflectance::materials::multiscattering::{BOUNCES_LOSSY, chan_rational_rough, slice_quotient};

/// The reflectance of the coat in all figures.
pub const F0: f64 = 0.04;

/// The reflectance of the coat's facets.
static GGX: LazyLock<EnergyTable> = LazyLock::new(EnergyTable::ggx);

/// A diffuse law.
#[derive(Clone, Copy)]
pub enum Law {
    /// Lambert's law.
    Lambert,
    /// Lambert's law for the light that the coat lets through from the light (listing 5).
    Conserving,
    /// The published fit (eq. 64–69).
    Published,
    /// The published rational fit for gloss 0 (eq. 63).
    Rational,
    /// The same function with other coefficients; see [`slice_quotient`].
    RationalFit([f64; 15]),
    /// The model of this project, with the loss of the paper's simulation.
    Ours,
    /// The mean of this many random walks, which is the paper's full BRDF.
    Walks(u64),
}

/// Returns the direction with this cosine to the normal and this azimuth.
pub fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let s = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    DVec3::new(s * azimuth.cos(), s * azimuth.sin(), cosine)
}

impl Law {
    /// Returns `π f_r` at a gloss on Chan's scale, for two directions above the horizon. `seed` selects the walks.
    pub fn value(self, wo: DVec3, wi: DVec3, gloss: f64, seed: u64) -> f64 {
        let alpha = Gloss::Wwii.alpha(gloss);
        let h = half_vector(wo, wi);
        match self {
            Self::Lambert => 1.0,
            Self::Conserving => conserving_diffuse(DVec3::splat(F0), GGX.albedo(alpha, wi.z)).x,
            Self::Published => diffuse_value(DiffuseModel::CallOfDuty, wo, wi, alpha, DVec3::ONE).x,
            Self::Rational => PI * chan_rational_rough(h.z, wi.dot(h)),
            Self::RationalFit(coefficients) => {
                let [above, below] = slice_quotient(h.z, wi.dot(h), &coefficients);
                PI * above / below
            }
            Self::Ours => fitted(&BOUNCES_LOSSY, &GGX, alpha, F0, 1.0, wo, wi),
            Self::Walks(count) => {
                let facets = Ggx::isotropic(DVec2::ZERO, alpha);
                let one_way = |o: DVec3, i: DVec3, seed: u64| {
                    let walks = facet_walks(&facets, Facets::Diffuse(F0), i, &[o], count.div_ceil(2), seed);
                    PI * walks.towards[0].iter().sum::<f64>() / o.z
                };
                // Both ways have the same value.
                0.5 * (one_way(wo, wi, seed) + one_way(wi, wo, !seed))
            }
        }
    }

    /// Returns the value of the slice at `φ_d = 90°` with the same `θ_h` and `θ_d` (section 5.6).
    pub fn on_slice(self, wo: DVec3, wi: DVec3, gloss: f64, seed: u64) -> f64 {
        let h = half_vector(wo, wi);
        let (x, y) = (h.z.clamp(0.0, 1.0), wi.dot(h).clamp(0.0, 1.0));
        let [o, i] = slice_pair(x, y);
        self.value(o, i, gloss, seed)
    }
}

/// Returns the pair of directions at `φ_d = 90°` with these cosines of `θ_h` and `θ_d`, at least 1e-3 above the horizon.
pub fn slice_pair(cos_h: f64, cos_d: f64) -> [DVec3; 2] {
    let [sin_h, sin_d] = [cos_h, cos_d].map(|c| ((1.0 - c) * (1.0 + c)).max(0.0).sqrt());
    [1.0, -1.0].map(|side| {
        let w = DVec3::new(sin_h * cos_d, side * sin_d, cos_h * cos_d);
        w.with_z(w.z.max(1e-3)).normalize()
    })
}

/// A law at one gloss as a BRDF.
pub struct AtGloss(pub Law, pub f64);

impl Brdf for AtGloss {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        DVec3::splat(self.0.value(wo, wi, self.1, 0) * wi.z / PI)
    }
}
