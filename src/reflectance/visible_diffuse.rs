//! Diffuse reflection of the visible facets without a grid of slopes.
//!
//! With `N = (−slope, 1)` and the normal `n = N/|N|`, irradiance by order-2 harmonics needs the moments
//!
//! ```text
//! E[n] = E[⟨wo·N⟩ N / |N|] / A(wo),   E[n nᵀ] = E[⟨wo·N⟩ N Nᵀ / |N|²] / A(wo)
//! ```
//!
//! over Gaussian slopes: polynomials of the slope, a clamp, and `|N|`. Only `|N|` stands in the way of a closed form. Its
//! inverses are very nearly sums of two or three exponentials, `1/|N| ≈ Σ c_i exp(−t_i |N|²)`, and an exponential of `|N|²`
//! times a Gaussian of slopes is another Gaussian of slopes ([`damped_gaussian`]), for which the clamped moments are those
//! of [`visible_slopes`](super::visible_slopes). So two evaluations of closed forms take the place of a grid: the clamp
//! is exact for every viewer, nothing depends on the choice of axes, and the result is smooth in every argument.
//!
//! The exponents scale with the mean of `|N|²` and, with the weights, follow its relative spread on a line: a fit, of this
//! project, of the moments of random surfaces (roughness .01–2.5, mean slopes to 4). One light, with its clamped
//! cosine instead of harmonics, replaces the one clamp by two: [`clamped_product`].

use super::diffuse::NormalMoments;
use super::masking::shadowing_given_masking;
use super::normal_distribution::normal_ramp;
use super::projected_area::{face_viewer, meso_area, slope_spread, visible_area};
use super::slope_statistics::clamp_covariance;
use super::visible_slopes::VISIBLE_TAIL;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// Exponent, its slope, weight in `1/|N|`, its slope.
const TWO: [[f64; 4]; 2] =
    [[0.24367799, -0.01511645, 1.09613514, 0.07478542], [2.05198045, 1.21774331, 1.0967844, 0.82113826]];
const THREE: [[f64; 4]; 3] = [
    [0.15669784, -0.02948724, 0.90433556, -0.05707912],
    [1.56526968, 0.13561935, 1.06243915, 0.33697349],
    [6.39379125, 3.23512178, 2.83733313, 0.1062973],
];
/// Weight in `1/|N|²` in any unit, and its slope.
const TWO_SECOND: [[f64; 2]; 2] = [[1.0, -0.33346642], [4.16885772, 1.98854807]];
const THREE_SECOND: [[f64; 2]; 3] = [[1.0, -0.34427111], [4.42731385, 0.72453821], [22.45304638, -1.15957088]];

/// Exponent and weight of term `i` of `1/|N|`, each a value and its slope by the relative spread; `terms` 2 or 3.
#[must_use]
pub fn visible_diffuse_exponent(i: u32, terms: u32) -> [f64; 4] {
    if terms == 2 { TWO[i as usize] } else { THREE[i as usize] }
}

/// Weight of term `i` of `1/|N|²` and its slope.
#[must_use]
pub fn visible_diffuse_second(i: u32, terms: u32) -> [f64; 2] {
    if terms == 2 { TWO_SECOND[i as usize] } else { THREE_SECOND[i as usize] }
}

/// Mean of `|N|²`, and its standard deviation over its mean, for slopes of mean `m` and covariance `s`.
#[must_use]
pub fn squared_normal_spread(m: DVec2, s: DVec3) -> DVec2 {
    let mean = 1.0 + m.dot(m) + s.x + s.y;
    let variance = 4.0 * (s.x * m.x * m.x + s.y * m.y * m.y + 2.0 * s.z * m.x * m.y)
        + 2.0 * (s.x * s.x + s.y * s.y + 2.0 * s.z * s.z);
    DVec2::new(mean, variance.max(0.0).sqrt() / mean)
}

/// A weight times a Gaussian of slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeGaussian {
    /// Integral.
    pub weight: f64,
    /// Mean.
    pub m: DVec2,
    /// Covariance `(s_xx, s_yy, s_xy)`.
    pub s: DVec3,
}

/// `exp(−t |N|²) P22(m, S)`, `t ≥ 0`: the Gaussian of covariance `(S⁻¹ + 2 t)⁻¹`, exactly.
#[must_use]
pub fn damped_gaussian(m: DVec2, s: DVec3, t: f64) -> SlopeGaussian {
    let tt = 2.0 * t;
    let det = (s.x * s.y - s.z * s.z).max(0.0);
    let per = 1.0 / (1.0 + tt * (s.x + s.y + tt * det));
    let mean = per * (m + tt * DVec2::new(s.y * m.x - s.z * m.y, s.x * m.y - s.z * m.x));
    let cov = per * (s + DVec3::new(tt * det, tt * det, 0.0));
    SlopeGaussian { weight: (-t * (1.0 + m.dot(mean))).exp() * per.sqrt(), m: mean, s: cov }
}

/// Moments of the normals seen from `wo`, in place of a grid's `visible_normal_moments`. `terms`: 2 (error of the radiance
/// 1.4e-3 rms of the mean radiance) or 3 (2e-4).
#[must_use]
pub fn visible_diffuse_moments(wo: DVec3, m: DVec2, s: DVec3, terms: u32) -> NormalMoments {
    let s = clamp_covariance(s);
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let spread = squared_normal_spread(m, s);
    let (mut first, mut diag, mut off) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for i in 0..terms {
        let e = visible_diffuse_exponent(i, terms);
        let second = visible_diffuse_second(i, terms);
        let g = damped_gaussian(m, s, (e[0] + e[1] * spread.y) / spread.x);
        let across = DVec2::new(g.s.x * wo.x + g.s.z * wo.y, g.s.z * wo.x + g.s.y * wo.y);
        let b = across.dot(wo.xy()).max(0.0).sqrt();
        let per_b = 1.0 / b.max(1e-18);
        let a = meso_area(wo, g.m);
        let n = normal_ramp(a * per_b);
        let axis = across * per_b;
        let area = if b > 1e-18 { b * n.ramp } else { a.max(0.0) };
        // Over the clamped facet areas: E[1] = area, E[slope] = m area − across Φ, and so on (Stein's lemma).
        let slope = g.m * area - across * n.cdf;
        let c = g.weight * (e[2] + e[3] * spread.y);
        let d = g.weight * (second[0] + second[1] * spread.y);
        first += c * DVec3::new(-slope.x, -slope.y, area);
        let twice = slope - across * n.cdf;
        let bend = b * n.pdf;
        diag += d * (g.m * twice + g.s.xy() * area + axis * axis * bend).extend(area);
        let xy = g.m.x * slope.y - across.x * g.m.y * n.cdf + g.s.z * area + axis.x * axis.y * bend;
        off += d * DVec3::new(-slope.y, -slope.x, xy);
    }
    // The first moments are per visible area; the second have trace one.
    let area = visible_area(wo, m, s).max(1e-30);
    let scale = 1.0 / diag.element_sum().max(1e-30);
    NormalMoments { mean: first / (area * spread.x.sqrt()), diag: diag * scale, off: off * scale }
}

/// `E[max(0, x) max(0, y)]` of two normal variables of means `ax`, `ay`, standard deviations `bx`, `by`, covariance `k`.
///
/// Plackett's identity: by the correlation `r`, the first derivative is the probability that both are positive and the
/// second their density at 0, so with `X`, `Y` the means of the clamped variables, all in standard deviations,
/// `E = X Y + r Φ(x) Φ(y) + ∫₀ʳ (r − t) φ₂(x, y; t) dt`. The integral is by the two-point Gauss–Jacobi rule.
#[must_use]
pub fn clamped_product(ax: f64, bx: f64, ay: f64, by: f64, k: f64) -> f64 {
    const AT: [f64; 2] = [0.155_051_03, 0.644_948_97];
    const WEIGHT: [f64; 2] = [0.050_617_86, 0.028_959_61]; // over 2π
    let (px, py) = (1.0 / bx.max(1e-18), 1.0 / by.max(1e-18));
    let (x, y) = (ax * px, ay * py);
    let (nx, ny) = (normal_ramp(x), normal_ramp(y));
    let area_x = if bx > 1e-18 { bx * nx.ramp } else { ax.max(0.0) };
    let area_y = if by > 1e-18 { by * ny.ramp } else { ay.max(0.0) };
    let r = (k * px * py).clamp(-1.0, 1.0);
    // Beyond 13 deviations the density is 0 in 32 bits.
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
    (area_x * area_y + k * (nx.cdf * ny.cdf + r * density)).max(0.0)
}

/// Radiance under one light from `wi` of unit irradiance on a plane facing it, its clamped cosine integrated over the
/// visible facets (LEADR eq. 21 without harmonics), per unit of albedo. `terms`: 2 or 3.
#[must_use]
pub fn leadr_diffuse_light_visible(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool, terms: u32) -> f64 {
    let s = clamp_covariance(s);
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let spread = squared_normal_spread(m, s);
    let sum: f64 = (0..terms)
        .map(|i| {
            let e = visible_diffuse_exponent(i, terms);
            let g = damped_gaussian(m, s, (e[0] + e[1] * spread.y) / spread.x);
            let across = DVec2::new(g.s.x * wo.x + g.s.z * wo.y, g.s.z * wo.x + g.s.y * wo.y);
            let bo = across.dot(wo.xy()).max(0.0).sqrt();
            let (ao, ai) = (meso_area(wo, g.m), meso_area(wi, g.m));
            g.weight
                * (e[2] + e[3] * spread.y)
                * clamped_product(ao, bo, ai, slope_spread(wi, g.s), across.dot(wi.xy()))
        })
        .sum();
    let mean = sum / (visible_area(wo, m, s).max(1e-30) * spread.x.sqrt());
    shadowing_given_masking(wo, wi, m, s, shadowing) * mean / PI
}
