//! Specular reflection of an environment by a line of probes.
//!
//! The visible slopes ([`visible_slopes`](super::visible_slopes)), carried onto the sphere of reflected directions, cover an
//! ellipse. What an environment offers is lookups filtered isotropically: its minor axis is theirs, and along the major
//! axis lie the probes. Their weights sum to one, so a constant environment gives its own value without a division.
//!
//! With `C` the covariance of the visible slopes and `G` the metric of reflection (`|dwi|² = dsᵀ G ds`), the axes are the
//! eigenvectors of `C G`, and with `λ₁ ≥ λ₂` its eigenvalues, `C − (det C / λ₁) adj G` is of rank one: `(λ₁ − λ₂) x xᵀ` of the
//! major axis `x`. Its square root is the line. Neither angles nor eigenvectors are needed, and nothing jumps where the
//! ellipse is a circle, since there the line has no length.

use super::fresnel::fresnel_schlick;
use super::projected_area::meso_area;
use super::slope_grid::normal_of_slope;
use super::visible_slopes::visible_slopes;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// A rule of equally spaced probes of unit variance with normal weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineRule {
    /// Number of probes.
    pub n: u32,
    /// Distance of neighbouring probes, in standard deviations.
    pub step: f64,
    /// Weight of probe `i`: `norm exp(−decay (i − (n − 1)/2)²)`.
    pub decay: f64,
    /// See [`decay`](Self::decay).
    pub norm: f64,
    /// Least variance of the environment's kernel, over that of the major axis.
    pub kernel: f64,
    /// Added to the level of detail that matches variances: 0 hides the probes, less shows more of narrow lights.
    pub bias: f64,
}

/// The rule of 3, 5, 7, 9 or 16 probes; of the next greater number that exists for others.
#[must_use]
pub fn line_rule(n: u32) -> LineRule {
    let rule = |n, step, decay, norm, kernel| LineRule { n, step, decay, norm, kernel, bias: -0.45 };
    match n {
        0..=3 => rule(3, 1.593_771_76, 1.125, 0.606_316_018, 0.25),
        4..=5 => rule(5, 0.967_347_788, 0.405, 0.366_333_776, 0.15),
        6..=7 => rule(7, 0.710_108_375, 0.222_222_222, 0.270_682_149, 0.09),
        8..=9 => rule(9, 0.576_461_842, 0.15125, 0.222_126_564, 0.06),
        _ => rule(16, 0.343_818_118, 0.055_555_555_6, 0.133_969_879, 0.025),
    }
}

/// The line of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleLine {
    /// Mean visible slope.
    pub mean: DVec2,
    /// From it along the line, per unit of `z`.
    pub major: DVec2,
    /// Shift by the skewness, per unit of `z² − 1`.
    pub bend: DVec2,
    /// The other axis: one standard deviation of the visible slopes across the line.
    pub minor: DVec2,
    /// Visible area `A(wo)`.
    pub area: f64,
    /// Level of detail of a probe, less its own Jacobian.
    pub lod: f64,
}

/// Jacobian of slopes to reflected directions over four, `|wn·wo| wn.z³`. `facet`: `wo.z − wo.xy·slope`, signed;
/// `squared_normal`: `1 + |slope|²`.
#[must_use]
pub fn reflection_jacobian(facet: f64, squared_normal: f64) -> f64 {
    facet.abs() / (squared_normal * squared_normal)
}

/// `log2` of the texels per radian at the centre of a face, per texel of the edge, plus what makes the variance of a
/// box-filtered level, `h²/4` with its bilinear lookup, that of the wanted kernel.
pub const LOD_OF_DEVIATION: f64 = 0.467;

/// The line seen from `wo`. `size`: texels per edge of the environment's cube map.
#[must_use]
pub fn visible_line(wo: DVec3, m: DVec2, s: DVec3, size: f64, rule: &LineRule) -> VisibleLine {
    let v = visible_slopes(wo, m, s);
    // |dwi|² = 4/|N|² ((p·ds)² + facet²/|N|² (|ds|² − (s·ds)²/|N|²)) at the mean.
    let s = v.mean;
    let per = 1.0 / (1.0 + s.dot(s));
    let facet = meso_area(wo, s).max(1e-6);
    let p = wo.xy() + s * (facet * per);
    let q = facet * facet * per;
    let metric = 4.0
        * per
        * DVec3::new(
            p.x * p.x + q * (1.0 - s.x * s.x * per),
            p.y * p.y + q * (1.0 - s.y * s.y * per),
            p.x * p.y - q * s.x * s.y * per,
        );
    // Eigenvalues of C G: variances along the axes of the ellipse of reflected directions.
    let c = v.cov;
    let half_trace = 0.5 * (c.x * metric.x + c.y * metric.y) + c.z * metric.z;
    let det = (c.x * c.y - c.z * c.z).max(0.0);
    let jacobian = 4.0 * facet * per * per;
    let difference = (half_trace * half_trace - det * jacobian * jacobian).max(0.0).sqrt();
    let wide = (half_trace + difference).max(1e-20);
    let narrow = det * jacobian * jacobian / wide;
    let less = det / wide;
    let (xx, yy) = ((c.x - less * metric.y).max(1e-20), (c.y - less * metric.x).max(1e-20));
    let bound = (xx * yy).sqrt();
    let xy = (c.z + less * metric.z).clamp(-bound, bound);
    let major = if xx > yy { DVec2::new(xx, xy) / xx.sqrt() } else { DVec2::new(xy, yy) / yy.sqrt() };
    let kept = ((1.0 - rule.kernel) * wide / (wide - narrow).max(1e-20)).min(1.0);
    let along = major * kept.max(0.0).sqrt();
    let u = (along.dot(wo.xy()) / v.b.max(1e-18)).clamp(-1.0, 1.0) / v.variance;
    let h = DVec2::new(metric.x * major.x + metric.z * major.y, metric.z * major.x + metric.y * major.y);
    let kernel = (rule.kernel * wide).max(narrow).max(1e-12);
    VisibleLine {
        mean: s,
        major: along,
        bend: v.axis * (v.third * u * u / 6.0),
        minor: DVec2::new(-h.y, h.x) * (det / (wide * h.dot(major)).max(1e-30)).sqrt(),
        area: v.area,
        lod: 0.5 * (kernel / jacobian.max(1e-12)).log2() + size.log2() + LOD_OF_DEVIATION + rule.bias,
    }
}

/// One lookup of the environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbe {
    /// Slope of the facet.
    pub slope: DVec2,
    /// Reflected direction, unit.
    pub wi: DVec3,
    /// `wo·wn`.
    pub cosine: f64,
    /// `wo.z − wo.xy·slope`: projected area of the facet.
    pub facet: f64,
    /// Weight; those of a line sum to one.
    pub weight: f64,
    /// Level of detail; may be negative.
    pub lod: f64,
}

/// The probe at `z` standard deviations along the line.
#[must_use]
pub fn visible_probe_at(line: &VisibleLine, wo: DVec3, z: f64, weight: f64) -> VisibleProbe {
    let slope = line.mean + z * line.major + (z * z - 1.0) * line.bend;
    let wn = normal_of_slope(slope);
    let facet = meso_area(wo, slope);
    let cosine = wo.dot(wn);
    let jacobian = 4.0 * reflection_jacobian(facet, 1.0 + slope.length_squared());
    VisibleProbe {
        slope,
        wi: 2.0 * cosine * wn - wo,
        cosine,
        facet,
        weight,
        lod: line.lod + 0.5 * jacobian.max(1e-12).log2(),
    }
}

/// Probe `i` of `0..rule.n`.
#[must_use]
pub fn visible_probe(line: &VisibleLine, wo: DVec3, i: u32, rule: &LineRule) -> VisibleProbe {
    let j = f64::from(i) - 0.5 * f64::from(rule.n - 1);
    visible_probe_at(line, wo, j * rule.step, rule.norm * (-rule.decay * j * j).exp())
}

/// Radiance towards `wo` under an environment of cube edge `size`, masking only (LEADR eq. 19), and the mean Fresnel
/// reflectance of the visible facets. `radiance` is asked for each probe.
#[must_use]
pub fn leadr_specular_environment_visible(
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    size: f64,
    rule: &LineRule,
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> (DVec3, DVec3) {
    let line = visible_line(wo, m, s, size, rule);
    (0..rule.n).fold((DVec3::ZERO, DVec3::ZERO), |(sum, fresnel), i| {
        let probe = visible_probe(&line, wo, i, rule);
        let f = probe.weight * fresnel_schlick(f0, probe.cosine);
        (sum + f * radiance(&probe), fresnel + f)
    })
}
