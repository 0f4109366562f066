//! The environment that the visible facets of each class see, as one irradiance lookup per class.
//!
//! The fraction of the sky that a facet of class `k` sees is `T_k / (1 + x_k open_k)`. `T_k` is the mean of `(1 + n·g)/2` over the visible
//! facets, which is the part of their hemisphere above the mesosurface. `x_k` is the depth towards the
//! [sky](crate::masking::class_sky), and `open_k` is the openness towards the viewer. Facets that a low viewer sees are high, so they see
//! more of the sky. In Smith's form, `1 / (1 + x open)` is the part that sees both the viewer and the sky, `1 / (1 + Λ + x)`, divided by the
//! part that sees the viewer.
//!
//! The lookup's normal leans less than the visible facets, because the mesosurface and other facets block the light from below. The slope
//! relative to the mesosurface is divided by `1 + 0.53 μ + 0.27 σ + 2 x open`, with the mean `μ` and the deviation `σ` of the visible slopes.
//! The constants are fitted to the mean directions of light in ray casts of studs, bricks, tiles, grooves, scans and noise.

use glam::DVec3;

use super::slopes::visible_slopes;
use crate::facets::normal_length::mean_inverse_normal_length;
use crate::masking::class_sky::ClassSky;
use crate::masking::classes::Class;
use crate::slopes::grid::normal_of_slope;

/// The environment that the visible facets of a class see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassEnvironment {
    /// The unit normal of the irradiance lookup, in the tangent frame.
    pub normal: DVec3,
    /// The factor of the irradiance, from 0 to 1.
    pub open: f64,
    /// The fraction of the hemisphere, weighted by the cosine, in which the visible facets see the sky above the mesosurface. In the rest,
    /// they see other facets.
    pub seen: f64,
}

/// Returns the environment that class `k` of a sky sees from the viewer `wo`, towards which its openness is `open`.
pub fn class_environment(sky: &ClassSky, wo: DVec3, k: usize, class: &Class, open: f64) -> ClassEnvironment {
    let m = sky.mean;
    let per_square = 1.0 / (1.0 + m.length_squared());
    let up = normal_of_slope(m);
    let v = visible_slopes(wo, class.mean, class.covariance);
    let depth = sky.depths[k] * open;
    let cosine = mean_inverse_normal_length(v.mean, v.cov) * (1.0 + m.dot(v.mean)) * per_square.sqrt();
    let seen = ((0.5 + 0.5 * cosine) / (1.0 + depth)).clamp(0.0, 1.0);
    let off = v.mean - m;
    let (mean, deviation) = ((off.length_squared() * per_square).sqrt(), ((v.cov.x + v.cov.y) * per_square).sqrt());
    let normal = normal_of_slope(m + off / (1.0 + 0.53 * mean + 0.27 * deviation + 2.0 * depth));
    ClassEnvironment { normal, open: (seen / (0.5 + 0.5 * normal.dot(up))).min(1.0), seen }
}
