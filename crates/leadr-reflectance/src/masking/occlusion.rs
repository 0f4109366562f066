//! Ambient occlusion of a point as a visibility or as a cone (Chan 2018, 4.4–4.7): albedo-aware ambient visibility, cones of a given
//! visibility, and lights occluded by cones.
//!
//! A *visibility* is the unoccluded fraction of the cosine-weighted hemisphere (eq. 43), so it is 1 without occluders. A [`Cone`] of
//! directions about an axis represents a visibility: directions inside are unoccluded, and all others are occluded.

use crate::limits::{at_least, unit};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// The assumption about the occluders (Chan 2018, 4.4), in a white environment of radiance 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Hidden {
    /// Occluders are black (eq. 45), as in common ambient occlusion.
    Black = 0,
    /// Occluders are white and as occluded as this point (eq. 46).
    WhiteOccluded = 1,
    /// Occluders have this point's albedo and are unoccluded (eq. 47).
    SameUnoccluded = 2,
    /// Occluders have this point's albedo and are as occluded as the point (eq. 48).
    SameOccluded = 3,
    /// Occluders have this point's radiance, which includes all bounces (eq. 49; Stewart and Langer 1996).
    #[default]
    SameRadiance = 4,
}

impl Hidden {
    /// All assumptions in numeric order.
    pub const ALL: [Self; 5] =
        [Self::Black, Self::WhiteOccluded, Self::SameUnoccluded, Self::SameOccluded, Self::SameRadiance];
}

impl Hidden {
    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Black => "black",
            Self::WhiteOccluded => "white",
            Self::SameUnoccluded => "unoccluded",
            Self::SameOccluded => "occluded",
            Self::SameRadiance => "bounces",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::Black => "Black, as in common ambient occlusion (Chan 2018, eq. 45)",
            Self::WhiteOccluded => "White, and as occluded as the surface (eq. 46)",
            Self::SameUnoccluded => "The colour of the surface, and not occluded (eq. 47)",
            Self::SameOccluded => "The colour of the surface, and as occluded (eq. 48)",
            Self::SameRadiance => "As bright as the surface, with all bounces (eq. 49)",
        }
    }
}

/// The visibility of a light by its direction relative to a cone (Chan 2018, figure 18). The numbers equal the `LEADR_CONE_EDGE_` constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConeEdge {
    /// The square of the linear edge (eq. 58).
    Soft = 0,
    /// The ratio of the light's cosine to the cone's.
    Linear = 1,
    /// No light outside the cone (eq. 57).
    Hard = 2,
    /// The cone hides no light.
    Open = 3,
}

impl ConeEdge {
    /// All edges in numeric order.
    pub const ALL: [Self; 4] = [Self::Soft, Self::Linear, Self::Hard, Self::Open];

    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Linear => "linear",
            Self::Hard => "hard",
            Self::Open => "open",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::Soft => "Fade by the squared ratio of the cosines of light and cone (Chan 2018, eq. 58)",
            Self::Linear => "Fade by the ratio of the cosines (figure 18)",
            Self::Hard => "Cut the light off at the cone (eq. 57)",
            Self::Open => "Do not shadow lights by cones",
        }
    }
}

/// The axis of the cone that shadows suns and lamps. The numbers equal the `LEADR_CONE_AXIS_` constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConeAxis {
    /// The direction of what is visible.
    Bent = 0,
    /// The normal (Chan 2018, eq. 57 and 58).
    Normal = 1,
}

impl ConeAxis {
    /// All axes in numeric order.
    pub const ALL: [Self; 2] = [Self::Bent, Self::Normal];

    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bent => "bent",
            Self::Normal => "normal",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::Bent => "The direction of what is visible",
            Self::Normal => "The normal, with a cone of the same visibility (Chan 2018, eq. 57 and 58)",
        }
    }
}

/// The cone that hides the specular reflection of the environment (Chan 2018, 4.7). The numbers equal the `LEADR_CONE_LOBE_` constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConeLobe {
    /// The cone itself, about the direction of what is visible.
    Bent = 0,
    /// A cone of the same visibility about the normal.
    Normal = 1,
    /// This cone, widened for smooth surfaces and grazing views (eq. 59).
    Adjusted = 2,
    /// This cone, widened for a gloss of 1.5 times the gloss (eq. 60 and listing 3).
    Biased = 3,
}

impl ConeLobe {
    /// All cones in numeric order.
    pub const ALL: [Self; 4] = [Self::Bent, Self::Normal, Self::Adjusted, Self::Biased];

    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bent => "bent",
            Self::Normal => "normal",
            Self::Adjusted => "adjusted",
            Self::Biased => "biased",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::Bent => "The cone about the direction of what is visible",
            Self::Normal => "A cone of the same visibility about the normal; too dark on smooth surfaces",
            Self::Adjusted => "The same, widened for smooth surfaces and grazing views (Chan 2018, eq. 59)",
            Self::Biased => "The same, for a gloss of 1.5 times the gloss (eq. 60); almost none on smooth surfaces",
        }
    }

    /// Returns the cone that hides the specular reflection of a point with this visibility and `cone`. `gloss` is on Chan's scale, and
    /// `n_v` is the viewer's cosine to the normal.
    pub fn of(self, cone: Cone, visibility: f64, gloss: f64, n_v: f64) -> Cone {
        let about_normal = Cone::about_normal(DVec3::Z, visibility);
        let adjusted = |biased, exponent| Cone {
            cosine: adjusted_cone_cosine(about_normal.cosine, gloss, n_v, biased, exponent),
            ..about_normal
        };
        match self {
            Self::Bent => cone,
            Self::Normal => about_normal,
            Self::Adjusted => adjusted(false, 8),
            Self::Biased => adjusted(true, 6),
        }
    }
}

/// Returns the fraction of the light from `wi` that a cone lets through.
pub fn cone_light_by_edge(edge: ConeEdge, cone: &Cone, wi: DVec3) -> f64 {
    match edge {
        ConeEdge::Soft => cone_light_smooth(cone, wi),
        ConeEdge::Linear => cone_light_smooth(cone, wi).sqrt(),
        ConeEdge::Hard => cone_light(cone, wi),
        ConeEdge::Open => 1.0,
    }
}

/// Returns the fraction of a white environment's light that reaches a point of this `visibility` and `albedo`, per colour channel (Chan
/// 2018, eq. 45–49). `hidden` is the appearance of the occluders. The arguments and the result are clamped to 0..1.
///
/// The point's radiance is `albedo / π` times the irradiance of the unoccluded sky times this fraction.
pub fn adjusted_visibility(hidden: Hidden, visibility: f64, albedo: DVec3) -> DVec3 {
    let (a, rho) = (unit(visibility), DVec3::from_array(albedo.to_array().map(unit)));
    match hidden {
        Hidden::Black => DVec3::splat(a),
        Hidden::WhiteOccluded => DVec3::splat(a + a * (1.0 - a)),
        Hidden::SameUnoccluded => a + rho * (1.0 - a),
        Hidden::SameOccluded => a + rho * (a * (1.0 - a)),
        Hidden::SameRadiance => interreflected_visibility(a, rho),
    }
}

/// Returns `A / (1 − ρ (1 − A))`, eq. 49 ([`Hidden::SameRadiance`]). `ρ = 1` gives 1 if anything is visible. `A = 0` gives 0 for every
/// albedo, which is the limit for all `ρ < 1`. The printed form is 0/0 at `ρ = 1`.
pub fn interreflected_visibility(visibility: f64, albedo: DVec3) -> DVec3 {
    let a = unit(visibility);
    // The bound of 1e-12 on the denominator is negligible, and the quotient is 0 where A is 0.
    DVec3::from_array(albedo.to_array().map(|rho| a / at_least((1.0 - unit(rho)) + unit(rho) * a, 1e-12)))
}

/// A cone of unoccluded directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The unit axis, in the tangent frame.
    pub axis: DVec3,
    /// The cosine of the half angle: 1 for an empty cone, 0 for a hemisphere about the axis.
    pub cosine: f64,
}

impl Cone {
    /// Returns the cone of a *visibility vector* `b = 1/π ∫ V(ω) ω dω`, the sum of the unoccluded directions. A facet of normal `m` that
    /// faces all of these directions sees the fraction `m · b` of a uniform sky. Any linear filter may average `b`. A cone of half angle θ
    /// about `u` has the vector `u sin²θ`. The direction of `b` is the axis, and its length is the visibility about the axis (eq. 54).
    ///
    /// A zero vector gives an empty cone about z.
    pub fn of_vector(b: DVec3) -> Self {
        let length = b.length();
        if (1e-12..1e30).contains(&length) {
            Self { axis: b / length, cosine: cone_cosine(length) }
        } else {
            Self { axis: DVec3::Z, cosine: 1.0 }
        }
    }

    /// Returns the cone about a unit normal that has this visibility (eq. 56).
    pub fn about_normal(normal: DVec3, visibility: f64) -> Self {
        Self { axis: normal, cosine: cone_cosine(visibility) }
    }
}

/// Returns the cosine of the half angle of a cone about the normal with this visibility: `√(1 − V)` (Chan 2018, eq. 56).
pub fn cone_cosine(visibility: f64) -> f64 {
    (1.0 - unit(visibility)).sqrt()
}

/// Returns the visibility of a cone about the normal, `1 − cos²` (eq. 55), the inverse of [`cone_cosine`].
pub fn cone_visibility(cosine: f64) -> f64 {
    let c = unit(cosine);
    (1.0 - c) * (1.0 + c)
}

/// Returns the visibility of a cone about any axis, clipped at the horizon. The result is exact for half angles up to 90°.
///
/// For a cone above the horizon, the visibility is `sin² cos θ_a` with `cos θ_a = axis.z`, the projection of a disc. For a clipped cone, it
/// is the form factor of a sphere clipped by the horizon (Snyder 1996).
pub fn bent_cone_visibility(cone: &Cone) -> f64 {
    let (cosine, z) = (unit(cone.cosine), cone.axis.z.clamp(-1.0, 1.0));
    let (sine, tilt) = (root(cosine), root(z));
    if z >= sine {
        return sine * sine * z;
    }
    if -z >= sine || sine < 1e-6 {
        return 0.0;
    }
    // cot(half) cot(tilt) is the cosine of the angle where the horizon intersects the cone's edge.
    let cut = (-cosine * z / at_least(sine * tilt, 1e-12)).clamp(-1.0, 1.0);
    let across = root(cut);
    let disc = sine * (sine * z * cut.acos() - cosine * tilt * across);
    ((disc + (sine * tilt * across).atan2(cosine)) * FRAC_1_PI).clamp(0.0, 1.0)
}

/// Returns the cosine of the half angle of a cone about `axis` with this visibility, the inverse of [`bent_cone_visibility`]. For a cone
/// above the horizon, the result is `√(1 − V / cos θ_a)`. Clipped cones use a cubic that is accurate to 1.3° for axes up to 75° from the
/// normal. The cone is a hemisphere if no cone is wide enough, and empty for an axis on or below the horizon.
pub fn bent_cone_cosine(visibility: f64, axis: DVec3) -> f64 {
    let (v, z) = (unit(visibility), axis.z.clamp(-1.0, 1.0));
    if z <= 1e-6 {
        return 1.0;
    }
    let tilt = root(z);
    let (touching, widest) = (z * z * z, 0.5 + 0.5 * z);
    if v <= touching {
        return cone_cosine(v / z);
    }
    // Use Hermite interpolation between the cone that touches the horizon and a hemisphere.
    let width = widest - touching;
    let t = ((v - touching) / at_least(width, 1e-9)).min(1.0);
    let s = 1.0 - t;
    let steep = -width / at_least(2.0 * tilt * z, 1e-9);
    let last = -width * PI / at_least(2.0 * tilt, 1e-9);
    unit(s * s * ((1.0 + 2.0 * t) * tilt + t * steep) - t * t * s * last)
}

fn root(x: f64) -> f64 {
    ((1.0 - x) * (1.0 + x)).max(0.0).sqrt()
}

/// Returns the cone about a bent normal that has this visibility.
pub fn bent_cone(visibility: f64, axis: DVec3) -> Cone {
    Cone { axis, cosine: bent_cone_cosine(visibility, axis) }
}

/// Returns 1 for a light from `wi` inside the cone, and 0 outside (Chan 2018, eq. 57, about any axis). The cone has a hard edge.
pub fn cone_light(cone: &Cone, wi: DVec3) -> f64 {
    f64::from(u8::from(cone.axis.dot(wi) > cone.cosine))
}

/// Returns the visibility of a light from `wi`, with a smooth falloff outside the cone: `clamp(axis·wi / cos, 0, 1)²` (Chan 2018, eq. 58
/// and listing 4, about any axis). A hemisphere gives 1, since its edge is the horizon.
pub fn cone_light_smooth(cone: &Cone, wi: DVec3) -> f64 {
    let along = cone.axis.dot(wi);
    let ratio = if along >= cone.cosine { 1.0 } else { unit(along / at_least(cone.cosine, 1e-12)) };
    ratio * ratio
}

/// Returns the cosine of a cone about the normal, widened for smooth surfaces and grazing viewers (Chan 2018, listing 3). `biased = false`
/// omits eq. 60 and uses eq. 59 alone. `gloss` is from 0 to 1, `n_v` is the cosine of the viewer's angle, and `exponent` is 6 or 8.
///
/// The paper's eq. 59 has `(1 − (n·v)⁴)` where the listing has `(1 − n·v)⁴`, and the listing's `gloss8` is `gloss4 · gloss2`. The listing
/// is the shipped code, and has a gloss exponent of 6. The text of the paper has an exponent of 8.
pub fn adjusted_cone_cosine(cosine: f64, gloss: f64, n_v: f64, biased: bool, exponent: u32) -> f64 {
    let gloss = unit(if biased { 1.5 * gloss } else { gloss });
    let grazing = (1.0 - unit(n_v)).powi(4);
    unit(cosine) * (1.0 - gloss.powi(if exponent == 6 { 6 } else { 8 })) * (1.0 - grazing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{frame_about, from_frame};
    use crate::quadrature::composite_gauss;

    #[test]
    fn cone_is_recovered_from_its_direction_sum() {
        for (axis, visibility) in [
            (DVec3::Z, 0.3),
            (DVec3::new(0.3, -0.2, 0.9), 0.7),
            (DVec3::new(0.0, 0.5, 0.5), 1.0),
            (DVec3::X + 2.0 * DVec3::Z, 0.02),
        ] {
            let cone = Cone::about_normal(axis.normalize(), visibility);
            let n = 400;
            let mut sum = DVec3::ZERO;
            for i in 0..n * n {
                let z = 1.0 - 2.0 * (f64::from(i / n) + 0.5) / f64::from(n);
                let (s, c) = (std::f64::consts::TAU * (f64::from(i % n) + 0.5) / f64::from(n)).sin_cos();
                let wi = ((1.0 - z * z).sqrt() * glam::DVec2::new(c, s)).extend(z);
                sum += cone_light(&cone, wi) * wi * (4.0 / f64::from(n * n));
            }
            let found = Cone::of_vector(sum);
            assert!(found.axis.dot(cone.axis) > 0.9999, "{cone:?} {found:?}");
            assert!((cone_visibility(cone.cosine) - cone_visibility(found.cosine)).abs() < 0.01, "{cone:?} {found:?}");
        }
        for b in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e35)] {
            assert_eq!(Cone::of_vector(b), Cone { axis: DVec3::Z, cosine: 1.0 }, "{b}");
        }
        assert_eq!(Cone::of_vector(DVec3::splat(9.0)).cosine, 0.0);
    }

    #[test]
    fn hidden_directions_look_as_assumed() {
        let rho = DVec3::new(0.0, 0.4, 0.9);
        for a in [0.0, 0.2, 0.7, 1.0] {
            for (hidden, radiance) in [
                (Hidden::Black, DVec3::ZERO),
                (Hidden::WhiteOccluded, DVec3::splat(a)),
                (Hidden::SameUnoccluded, rho),
                (Hidden::SameOccluded, rho * a),
            ] {
                let want = radiance * (1.0 - a) + a;
                assert!((adjusted_visibility(hidden, a, rho) - want).length() < 1e-15, "{hidden:?}");
            }
            let all = adjusted_visibility(Hidden::SameRadiance, a, rho);
            let bounced: DVec3 = (0..400).map(|k| a * (rho * (1.0 - a)).powf(f64::from(k))).sum();
            assert!((all - bounced).length() < 1e-12, "{all} {bounced}");
            assert!((rho * all * (1.0 - a) + a - all).length() < 1e-14);
        }
    }

    #[test]
    fn visibility_is_kept_within_bounds() {
        for hidden in Hidden::ALL {
            for a in [f64::NAN, -1.0, 0.0, 1e-300, 1e-9, 0.5, 1.0, 9.0] {
                for rho in [f64::NAN, -3.0, 0.0, 0.5, 1.0, 2.0] {
                    let v = adjusted_visibility(hidden, a, DVec3::splat(rho)).x;
                    assert!((0.0..=1.0).contains(&v), "{hidden:?} {a} {rho}: {v}");
                    assert!(v + 1e-12 >= a.clamp(0.0, 1.0) || hidden == Hidden::SameRadiance || a.is_nan());
                }
            }
        }
        assert_eq!(interreflected_visibility(0.0, DVec3::ONE), DVec3::ZERO);
        assert_eq!(interreflected_visibility(1e-6, DVec3::ONE), DVec3::ONE);
    }

    fn tilted(tilt: f64, half: f64) -> Cone {
        Cone { axis: DVec3::new(0.6 * tilt.sin(), 0.8 * tilt.sin(), tilt.cos()), cosine: half.cos() }
    }

    #[test]
    fn cones_have_the_visibility_of_their_directions() {
        for tilt in [0.0, 0.3, 1.0, 1.3, 1.57, 1.9] {
            for half in [0.05, 0.4, 1.0, 1.5, 1.5705] {
                let cone = tilted(tilt, half);
                let frame = frame_about(cone.axis);
                let mut sum = 0.0;
                for (z, w) in composite_gauss(cone.cosine, 1.0, 12, 8) {
                    for k in 0..720 {
                        let (sin, cos) = (0.5 * (0.5 + f64::from(k))).to_radians().sin_cos();
                        let r = ((1.0 - z) * (1.0 + z)).sqrt();
                        sum += w / 360.0 * from_frame(&frame, DVec3::new(r * cos, r * sin, z)).z.max(0.0);
                    }
                }
                let got = bent_cone_visibility(&cone);
                assert!((got - sum).abs() < 2e-5, "{tilt} {half}: {got} {sum}");
            }
        }
    }

    #[test]
    fn cones_are_found_again() {
        for i in 0..=200 {
            let v = f64::from(i) / 200.0;
            assert!((cone_visibility(cone_cosine(v)) - v).abs() < 1e-15);
        }
        let mut worst = 0.0f64;
        for (i, j) in (0..=52).flat_map(|i| (1..=100).map(move |j| (i, j))) {
            let (tilt, half) = (f64::from(i) / 40.0, f64::from(j) / 100.0 * std::f64::consts::FRAC_PI_2);
            let cone = tilted(tilt, half);
            let again = bent_cone(bent_cone_visibility(&cone), cone.axis);
            let off = (again.cosine.acos() - half).to_degrees().abs();
            // Cones that the horizon does not clip are found exactly.
            assert!(tilt + half > 1.5705 || off < 1e-4, "{tilt} {half}: {off}");
            worst = worst.max(off);
        }
        println!("cones clipped by the horizon: largest error of the half angle {worst:.2}°");
        assert!(worst < 1.3, "{worst}");
    }

    #[test]
    fn lights_fall_off_outside_a_cone() {
        let cone = Cone { axis: DVec3::Z, cosine: 0.8 };
        let at = |z: f64| DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
        for (z, hard, soft) in [(1.0, 1.0, 1.0), (0.81, 1.0, 1.0), (0.4, 0.0, 0.25), (0.0, 0.0, 0.0), (-0.5, 0.0, 0.0)]
        {
            assert_eq!(cone_light(&cone, at(z)), hard);
            assert!((cone_light_smooth(&cone, at(z)) - soft).abs() < 1e-15, "{z}");
        }
        // A hemispherical cone hides no light, not even at its edge.
        assert_eq!(cone_light_smooth(&Cone { axis: DVec3::Z, cosine: 0.0 }, DVec3::X), 1.0);
        for x in [DVec3::ZERO, DVec3::X, DVec3::splat(1e30)] {
            assert!(cone_light_smooth(&Cone { axis: x, cosine: 2.0 }, x).is_finite());
            assert!(bent_cone_cosine(0.5, x).is_finite() && bent_cone_visibility(&bent_cone(0.5, x)).is_finite());
        }
    }

    #[test]
    fn edges_and_lobes_are_those_of_the_equations() {
        let (cone, wi) = (Cone { axis: DVec3::Z, cosine: 0.8 }, DVec3::new((1.0 - 0.16f64).sqrt(), 0.0, 0.4));
        let by_edge = ConeEdge::ALL.map(|edge| cone_light_by_edge(edge, &cone, wi));
        assert!((DVec3::from_slice(&by_edge) - DVec3::new(0.25, 0.5, 0.0)).length() < 1e-15 && by_edge[3] == 1.0);
        let bent = Cone { axis: DVec3::X, cosine: 0.3 };
        let lobes = ConeLobe::ALL.map(|lobe| lobe.of(bent, 0.36, 0.5, 0.6));
        assert_eq!(lobes[0], bent);
        assert!(lobes[1..].iter().all(|cone| cone.axis == DVec3::Z));
        let step = (1.0 - 0.4f64.powi(4)) * 0.8;
        let want = [0.8, step * (1.0 - 0.5f64.powi(8)), step * (1.0 - 0.75f64.powi(6))];
        assert!([1, 2, 3].iter().all(|&k| (lobes[k].cosine - want[k - 1]).abs() < 1e-15), "{lobes:?}");
    }

    #[test]
    fn smooth_surfaces_open_the_published_cone() {
        // Chan writes: "Gloss above 0.67 is unaffected by the cone."
        assert_eq!(adjusted_cone_cosine(0.9, 0.67, 0.8, true, 6), 0.0);
        assert_eq!(adjusted_cone_cosine(0.9, 0.0, 1.0, true, 6), 0.9);
        assert_eq!(adjusted_cone_cosine(0.9, 0.0, 0.0, false, 8), 0.0);
        let step = adjusted_cone_cosine(1.0, 0.5, 1.0, false, 6) - (1.0 - 0.5f64.powi(6));
        assert!(step.abs() < 1e-15);
    }
}
