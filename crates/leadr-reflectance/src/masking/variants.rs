//! Masking and shadowing of any slope distribution (thesis Tables 2.III and 2.IV, eq. 2.13 and 3.3; LEADR eq. 13–17).
//!
//! Every form is written as the factor `G / a_o` in
//!
//! `f_r cos θ_i = F D (G / a_o) / 4`.
//!
//! The projected areas are per unit of macrosurface: `a` of the mesosurface and `A` of the visible microsurface
//! ([`crate::facets::projected_area`]). For a central distribution, `a = cos θ`, which gives thesis eq. 2.1. Where the mesosurface is
//! edge-on to the viewer (`a_o → 0`), `G` and `a_o` vanish but their quotient has a limit. The code uses this limit for edge-on and for
//! back-facing mesosurfaces. `G₁` is never clamped, because the visible facets per unit of macrosurface, `cos θ / A`, can exceed 1 on a
//! sheared surface.
//!
//! | form | `G / a_o` | shadowing | reciprocal in |
//! |---|---|---|---|
//! | [`Masking::SmithCorrelated`] | `a_i / (a_i A_o + a_o (A_i − a_i))` | yes | the mesosurface |
//! | [`Masking::SmithSeparable`] | `a_i / (A_o A_i)` | yes | the mesosurface |
//! | [`Masking::SmithUnshadowed`] | `1 / A_o` | no | – |
//! | [`Masking::SmithThesis`] | `z_i / (z_i A_o + z_o A_i − z_o z_i)` | yes | the macrosurface |
//! | [`Masking::VGroove`] | `min(f, 2 a_o, 2 a_i) / (f a_o)`, `f = (wo·wh) / wh.z` | yes | the mesosurface |
//! | [`Masking::VGrooveUnshadowed`] | `min(f, 2 a_o) / (f a_o)` | no | – |
//! | [`Masking::NormalMap`] | `1 / f` | no | – |
//! | [`Masking::SmithDirectionCorrelated`] | `a_i / (a_i A_o + max(0, h_i − h_o) + f min(h_o, h_i))` | yes | the mesosurface |
//! | [`Masking::SmithDirectionCorrelatedSimple`] | the same with a simpler `f` | yes | the mesosurface |
//!
//! In the table, `h_o = a_i (A_o − a_o)`, and `h_i` is the same with the directions exchanged.
//!
//! "Reciprocal in the mesosurface" means that `a_o f_r cos θ_i` is symmetric in `wo` and `wi`. For a central distribution this is
//! Helmholtz reciprocity.

use super::correlated::{DirectionArea, masking_shadowing_factor, whitened_direction};
use super::grooves::groove_factor;
use super::shadowing::Shadowing;
use crate::facets::slope_distribution::SlopeDistribution;
use crate::limits::MIN_AREA;
use crate::slopes::grid::slope_cholesky;
use glam::{DVec2, DVec3};

/// The masking-shadowing model of a microfacet BRDF. The GLSL library uses the same numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Masking {
    /// The height-correlated Smith form, `G = 1 / (1 + Λ_o + Λ_i)` (LEADR eq. 13; thesis eq. 2.13 for a central distribution).
    #[default]
    SmithCorrelated = 0,
    /// The Smith form with independent masking and shadowing, `G = G₁(o) G₁(i) = 1 / ((1 + Λ_o)(1 + Λ_i))`. This `G` never exceeds the
    /// height-correlated form.
    SmithSeparable = 1,
    /// Smith masking without shadowing, `G = G₁(o)` (LEADR eq. 16 without shadowing). It reflects all light of a white furnace.
    SmithUnshadowed = 2,
    /// The thesis' noncentral form: eq. 2.13 with the `G₁ = cos θ / A` of eq. 3.3, using the macrosurface's cosines.
    ///
    /// This form equals [`Masking::SmithCorrelated`] for a central distribution. For a sheared distribution, it is not shear-invariant and
    /// differs from LEADR's form by up to a factor of 19. Ray casting agrees with LEADR. It has a pole where `1/G₁(o) + 1/G₁(i) = 1`.
    /// Beyond the pole, the printed form is negative and this code returns 0. Use this form for comparison only.
    SmithThesis = 3,
    /// Symmetric V-grooves, `G = min(1, 2 z_o z_h / wo·wh, 2 z_i z_h / wi·wh)` (Torrance and Sparrow; thesis Table 2.IV), sheared by the
    /// mean slope: the opposite side of a groove has the slope `2 m − slope`.
    VGroove = 4,
    /// V-grooves with masking but without shadowing. They reflect all light of a white furnace.
    VGrooveUnshadowed = 5,
    /// A normal map without masking: facets are weighted by their macrosurface area, `G = z_o z_h / wo·wh` (thesis Table 2.IV). The form is
    /// not reciprocal, because `a_o` cancels. [`MIN_AREA`] bounds the pole at `wo·wh → 0`.
    NormalMap = 6,
    /// The Smith form correlated in height and direction, `G = 1 / (1 + max Λ + f min Λ)`, where `f` rises from 0 for equal azimuths to 1.
    /// This `G` lies between [`Masking::SmithCorrelated`] and [`Masking::SmithUnshadowed`] (see [`super::correlated`]).
    SmithDirectionCorrelated = 7,
    /// [`Masking::SmithDirectionCorrelated`] with the simple `f`.
    SmithDirectionCorrelatedSimple = 8,
}

impl Masking {
    /// All forms in numeric order.
    pub const ALL: [Self; 9] = [
        Self::SmithCorrelated,
        Self::SmithSeparable,
        Self::SmithUnshadowed,
        Self::SmithThesis,
        Self::VGroove,
        Self::VGrooveUnshadowed,
        Self::NormalMap,
        Self::SmithDirectionCorrelated,
        Self::SmithDirectionCorrelatedSimple,
    ];

    /// Returns the same form without shadowing, for sampling visible normals.
    #[must_use]
    pub fn unshadowed(self) -> Self {
        match self {
            Self::SmithCorrelated
            | Self::SmithSeparable
            | Self::SmithUnshadowed
            | Self::SmithThesis
            | Self::SmithDirectionCorrelated
            | Self::SmithDirectionCorrelatedSimple => Self::SmithUnshadowed,
            Self::VGroove | Self::VGrooveUnshadowed => Self::VGrooveUnshadowed,
            Self::NormalMap => Self::NormalMap,
        }
    }
}

/// Returns `f = (wo·wh) / wh.z = (wi·wh) / wh.z`, the projected area of the facet that reflects `wo` to `wi`, per unit of macrosurface.
///
/// Computes `wo·wh` as `|wo + wi| / 2`, because the dot product loses all its digits as `wi → −wo`.
pub fn half_facet_area(wo: DVec3, wi: DVec3, wh: DVec3) -> f64 {
    0.5 * (wo + wi).length() / wh.z.max(1e-12)
}

/// Returns `G / a_o`, from 0 to 1e6, which is the factor of `F D / 4` in `f_r cos θ_i` (see the table of the module). `wh` is the half
/// vector, and `m` is the mean slope. `area_o` and `area_i` are the visible projected areas `A(wo)` and `A(wi)` of the distribution, at
/// least [`MIN_AREA`]. `s` is the slope covariance or a multiple of it (a roughness matrix). The direction-correlated forms take the
/// correlation of `wo` and `wi` from `s`.
///
/// With shadowing, the factor is 0 for a light on or below the mesosurface.
pub fn masking_factor(
    masking: Masking,
    wo: DVec3,
    wi: DVec3,
    wh: DVec3,
    m: DVec2,
    area_o: f64,
    area_i: f64,
    s: DVec3,
) -> f64 {
    let meso = |w: DVec3| crate::facets::projected_area::meso_area(w, m).max(0.0);
    let (ao, ai) = (meso(wo), meso(wi));
    let (area_o, area_i) = (area_o.max(MIN_AREA), area_i.max(MIN_AREA));
    let facet = half_facet_area(wo, wi, wh);
    match masking {
        Masking::SmithCorrelated => ai / (ai * area_o + ao * (area_i - ai).max(0.0)).max(1e-30),
        Masking::SmithSeparable => ai / (area_o * area_i),
        Masking::SmithUnshadowed => 1.0 / area_o,
        Masking::SmithThesis => {
            let seen = wo.z > 0.0 && wi.z > 0.0 && ao > 0.0 && ai > 0.0;
            let denominator = wi.z * area_o + wo.z * area_i - wo.z * wi.z;
            if seen && denominator > 0.0 { wi.z / denominator.max(MIN_AREA * wi.z) } else { 0.0 }
        }
        Masking::VGroove => groove_factor(facet, ao, ai),
        Masking::VGrooveUnshadowed => 1.0 / ao.max(0.5 * facet).max(MIN_AREA),
        Masking::NormalMap => 1.0 / facet.max(MIN_AREA),
        Masking::SmithDirectionCorrelated | Masking::SmithDirectionCorrelatedSimple => {
            let cholesky = slope_cholesky(s);
            let side = |w: DVec3, meso, visible| {
                let whitened = whitened_direction(w, cholesky);
                DirectionArea { whitened, spread: whitened.length(), meso, visible }
            };
            let simple = masking == Masking::SmithDirectionCorrelatedSimple;
            let shadowing = if simple { Shadowing::CorrelatedSimple } else { Shadowing::Correlated };
            masking_shadowing_factor(shadowing, &side(wo, ao, area_o), &side(wi, ai, area_i))
        }
    }
}

/// Returns the [`masking_factor`] of a distribution, for the half vector `wh` of `wo` and `wi`.
pub fn attenuation(masking: Masking, distribution: &impl SlopeDistribution, wo: DVec3, wi: DVec3, wh: DVec3) -> f64 {
    let (area_o, area_i) = (distribution.visible_area(wo), distribution.visible_area(wi));
    masking_factor(masking, wo, wi, wh, distribution.mean_slope(), area_o, area_i, distribution.shape())
}

/// Returns the thesis' `G` in `f_r = F D G / (4 cos θ_i cos θ_o)` (eq. 2.1), which is [`attenuation`] times `cos θ_o`. `G` is at most 1 for
/// a central distribution, unbounded for a sheared one, and 0 for `wo` below the horizon.
pub fn geometric_attenuation(
    masking: Masking,
    distribution: &impl SlopeDistribution,
    wo: DVec3,
    wi: DVec3,
    wh: DVec3,
) -> f64 {
    wo.z.max(0.0) * attenuation(masking, distribution, wo, wi, wh)
}

/// Returns Smith's `G₁(w) = cos θ / A(w)` (thesis eq. 2.14 and 3.3), or 0 below the horizon or behind the mesosurface. The value is not
/// clamped, and exceeds 1 where a shear hides most of the macrosurface's projection.
pub fn smith_g1(distribution: &impl SlopeDistribution, w: DVec3) -> f64 {
    if w.z <= 0.0 || distribution.meso_area(w) <= 0.0 {
        return 0.0;
    }
    w.z / distribution.visible_area(w).max(MIN_AREA)
}
