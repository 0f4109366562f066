//! The diffuse reflection of the visible facets, without a slope grid.
//!
//! Let `N = (−slope, 1)` and `n = N/|N|` be the normal. Irradiance by order-2 harmonics needs two moments over Gaussian slopes:
//!
//! ```text
//! E[n] = E[⟨wo·N⟩ N / |N|] / A(wo),   E[n nᵀ] = E[⟨wo·N⟩ N Nᵀ / |N|²] / A(wo)
//! ```
//!
//! The moments contain polynomials of the slope, a clamp, and `|N|`. Only `|N|` prevents a closed form. Sums of two or three exponentials
//! closely approximate the inverses of `|N|` and `|N|²`, such as `1/|N| ≈ Σ c_i exp(−t_i |N|²)`. An exponential of `|N|²` times a Gaussian
//! of slopes is another Gaussian of slopes ([`damped_gaussian`]), with the clamped moments of [`visible_slopes`](super::slopes). Two or
//! three evaluations of a closed form therefore replace a slope grid. The clamp is exact for every viewer. The result does not depend on
//! the choice of axes, and is smooth in every argument.
//!
//! The exponents are inversely proportional to the mean of `|N|²`. The scaled exponents and the weights are linear functions of the
//! relative spread of `|N|²`. They are fitted to the radiance of random surfaces (`lab::quadrature_study::fit`). For one light, a clamped
//! cosine replaces the harmonics, and a product of two clamps ([`clamped_product`]) replaces the single clamp.

use super::slopes::{VISIBLE_TAIL, tilted_area};
use crate::facets::normal_distribution::normal_ramp;
use crate::facets::projected_area::{face_viewer, meso_area, rough_area, slope_spread, spread_along};
use crate::integrals::diffuse::NormalMoments;
use crate::limits::at_least;
use crate::masking::smith::shadowing_given_masking;
use crate::slopes::statistics::clamp_covariance;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// One exponential of the sums that approximate `1/|N|` and `1/|N|²`. Each constant is the `[value, slope]` of a linear function of the
/// relative spread of `|N|²` ([`squared_normal_spread`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The exponent multiplied by the mean of `|N|²`.
    pub exponent: [f64; 2],
    /// The weight of this exponential in the sum for `1/|N|`.
    pub first: [f64; 2],
    /// The weight of this exponential in the sum for `1/|N|²`, up to a common factor.
    pub second: [f64; 2],
}

/// The two-term sum, fitted by `lab::quadrature_study::fit`.
const TWO: [Term; 2] = [
    Term { exponent: [0.22494464, -0.0331644], first: [1.06858219, -0.00712735], second: [1.0, -0.48494877] },
    Term { exponent: [2.04868504, 0.81002255], first: [1.1378407, 0.80030971], second: [4.51732387, 0.43471584] },
];

/// The three-term sum, fitted in the same way.
const THREE: [Term; 3] = [
    Term { exponent: [0.14774869, -0.02798132], first: [0.88324551, -0.06272688], second: [1.0, -0.26540236] },
    Term { exponent: [1.51173948, 0.09430317], first: [1.05317881, 0.31866379], second: [4.4142949, 1.2978556] },
    Term { exponent: [5.97573614, 3.11562463], first: [2.29040276, 0.48355783], second: [19.03758878, 4.88965078] },
];

/// Returns the fitted terms. `terms` is 2 or 3.
pub fn visible_diffuse_terms(terms: u32) -> &'static [Term] {
    if terms == 2 { &TWO } else { &THREE }
}

/// Returns the mean of `|N|²`, and its standard deviation divided by its mean, for slopes of mean `m` and covariance `s`.
pub fn squared_normal_spread(m: DVec2, s: DVec3) -> DVec2 {
    let mean = 1.0 + m.dot(m) + s.x + s.y;
    let variance = 4.0 * (s.x * m.x * m.x + s.y * m.y * m.y + 2.0 * s.z * m.x * m.y)
        + 2.0 * (s.x * s.x + s.y * s.y + 2.0 * s.z * s.z);
    DVec2::new(mean, variance.max(0.0).sqrt() / mean)
}

/// A Gaussian distribution of slopes times a weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeGaussian {
    /// The integral of the weighted Gaussian.
    pub weight: f64,
    /// The mean slope.
    pub m: DVec2,
    /// The covariance `(s_xx, s_yy, s_xy)`.
    pub s: DVec3,
}

/// Returns `exp(−t |N|²) P22(m, S)` for `t ≥ 0`, which is exactly a Gaussian of covariance `(S⁻¹ + 2 t)⁻¹`.
pub fn damped_gaussian(m: DVec2, s: DVec3, t: f64) -> SlopeGaussian {
    let tt = 2.0 * t;
    let det = (s.x * s.y - s.z * s.z).max(0.0);
    let per = 1.0 / (1.0 + tt * (s.x + s.y + tt * det));
    let mean = per * (m + tt * DVec2::new(s.y * m.x - s.z * m.y, s.x * m.y - s.z * m.x));
    let cov = per * (s + DVec3::new(tt * det, tt * det, 0.0));
    SlopeGaussian { weight: (-t * (1.0 + m.dot(mean))).exp() * per.sqrt(), m: mean, s: cov }
}

/// Returns `E[max(0, x)]` of a normal variable `x` with mean `a` and standard deviation `b`. For `a(w)` and `b(w)`, the result is the
/// visible area `A(w)`.
pub fn clamped_mean(a: f64, b: f64) -> f64 {
    a.max(0.0) + rough_area(a, b)
}

/// Returns the moments of the normals visible from `wo`, without the slope grid of `visible_normal_moments`. `terms` is 2 (rms error of
/// 1.2e-3 of the mean radiance) or 3 (2e-4).
pub fn visible_diffuse_moments(wo: DVec3, m: DVec2, s: DVec3, terms: u32) -> NormalMoments {
    moments_by_terms(wo, m, s, visible_diffuse_terms(terms))
}

/// Computes [`visible_diffuse_moments`] with the given exponential terms.
pub fn moments_by_terms(wo: DVec3, m: DVec2, s: DVec3, terms: &[Term]) -> NormalMoments {
    let s = clamp_covariance(s);
    let ao = tilted_area(wo, m, slope_spread(wo, s));
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let spread = squared_normal_spread(m, s);
    let (mut first, mut diag, mut off) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for term in terms {
        let [t, c, d] = [term.exponent, term.first, term.second].map(|[value, slope]| value + slope * spread.y);
        let t = t / spread.x;
        let g = damped_gaussian(m, s, t);
        let (across, b) = spread_along(wo, g.s);
        let per_b = 1.0 / b.max(1e-18);
        let a = ao + 2.0 * t * across.dot(m); // meso_area(wo, g.m) without cancellation
        let n = normal_ramp(a * per_b);
        let axis = across * per_b;
        let area = if b <= 1e-18 { a.max(0.0) } else { b * n.ramp };
        // Stein's lemma gives the moments over the clamped facet areas: E[1] = area, E[slope] = m area − across Φ, and so on.
        let slope = g.m * area - across * n.cdf;
        let (c, d) = (g.weight * c, g.weight * d);
        first += c * DVec3::new(-slope.x, -slope.y, area);
        let twice = slope - across * n.cdf;
        let bend = b * n.pdf;
        diag += d * (g.m * twice + g.s.xy() * area + axis * axis * bend).extend(area);
        let xy = g.m.x * slope.y - across.x * g.m.y * n.cdf + g.s.z * area + axis.x * axis.y * bend;
        off += d * DVec3::new(-slope.y, -slope.x, xy);
    }
    // The first moments are per visible area. The second moments have trace one.
    let area = clamped_mean(ao, slope_spread(wo, s)).max(1e-30);
    let scale = 1.0 / diag.element_sum().max(1e-30);
    NormalMoments { mean: first / (area * spread.x.sqrt()), diag: diag * scale, off: off * scale }
}

/// Returns `E[max(0, x) max(0, y)]` of two normal variables with means `ax` and `ay`, standard deviations `bx` and `by`, and covariance
/// `k`.
///
/// By Plackett's identity, the first derivative with respect to the correlation `r` is the probability that both variables are positive.
/// The second derivative is their joint density at 0. Let `X` and `Y` be the means of the clamped variables, all in standard deviations.
/// Then `E = X Y + r Φ(x) Φ(y) + ∫₀ʳ (r − t) φ₂(x, y; t) dt`. A two-point Gauss–Jacobi rule evaluates the integral.
pub fn clamped_product(ax: f64, bx: f64, ay: f64, by: f64, k: f64) -> f64 {
    const AT: [f64; 2] = [0.155_051_03, 0.644_948_97];
    const WEIGHT: [f64; 2] = [0.050_617_86, 0.028_959_61]; // divided by 2π
    let (px, py) = (1.0 / bx.max(1e-18), 1.0 / by.max(1e-18));
    let (x, y) = (ax * px, ay * py);
    let (nx, ny) = (normal_ramp(x), normal_ramp(y));
    let area_x = if bx <= 1e-18 { ax.max(0.0) } else { bx * nx.ramp };
    let area_y = if by <= 1e-18 { ay.max(0.0) } else { by * ny.ramp };
    let r = (k * px * py).clamp(-1.0, 1.0);
    // Beyond 13 standard deviations the density is 0 in 32 bits.
    let (x, y) = (x.clamp(-13.0, 13.0), y.clamp(-13.0, 13.0));
    let density: f64 = AT
        .iter()
        .zip(WEIGHT)
        .map(|(at, weight)| {
            let t = at * r;
            let per = 1.0 / (1.0 - t * t);
            weight * per.sqrt() * (-0.5 * (x * x + y * y - 2.0 * x * y * t) * per).exp()
        })
        .sum();
    at_least(area_x * area_y + k * (nx.cdf * ny.cdf + r * density), 0.0)
}

/// Returns the diffuse radiance per unit of albedo, under one light from `wi` that has unit irradiance on a plane facing it. The clamped
/// cosine is integrated over the visible facets (LEADR eq. 21 without harmonics). `terms` is 2 or 3.
pub fn leadr_diffuse_light_visible(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool, terms: u32) -> f64 {
    let s = clamp_covariance(s);
    let ao = tilted_area(wo, m, slope_spread(wo, s));
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let spread = squared_normal_spread(m, s);
    let sum: f64 = visible_diffuse_terms(terms)
        .iter()
        .map(|term| {
            let [t, c] = [term.exponent, term.first].map(|[value, slope]| value + slope * spread.y);
            let t = t / spread.x;
            let g = damped_gaussian(m, s, t);
            let (across, bo) = spread_along(wo, g.s);
            let (a, ai) = (ao + 2.0 * t * across.dot(m), meso_area(wi, g.m));
            g.weight * c * clamped_product(a, bo, ai, slope_spread(wi, g.s), across.dot(wi.xy()))
        })
        .sum();
    let mean = sum / (clamped_mean(ao, slope_spread(wo, s)).max(1e-30) * spread.x.sqrt());
    shadowing_given_masking(wo, wi, m, s, shadowing) * mean / PI
}
