//! The rational functions of the study, and their arguments.

use super::quotient::{MOST_TERMS, Quotient, Sample, Terms};
use crate::quadrature_study::light::LightSet;
use crate::quadrature_study::surfaces::Surface;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::normal_distribution::clamped_lean;
use leadr_reflectance::facets::projected_area::{meso_area, slope_spread, visible_area};
use leadr_reflectance::slopes::statistics::covariance_times;
use leadr_reflectance::visible::diffuse::squared_normal_spread;

/// The arguments of a rational function. They must describe a surface, a viewer and a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The eight numbers of LEADR §6: `ωo`, `ωi`, `E[ñ]`, `σx` and `σy`, in the axes of [`principal`].
    Paper,
    /// Eight numbers that do not change with a rotation about the displacement direction, so that no axes are needed.
    Invariants,
    /// Five numbers. The quotient multiplies the light's visible area in closed form.
    Areas,
    /// Four numbers, for centred isotropic slopes only, where the term is that of Oren and Nayar.
    Centred,
}

/// Rotates a surface and a light about the displacement direction, so that the axes of the covariance become x and y, the major axis first.
/// Reflects both so that the viewer is in the first quadrant. The diffuse term stays the same.
pub fn principal(surface: &Surface, wi: DVec3) -> (Surface, DVec3) {
    let Surface { wo, m, s } = *surface;
    let half = DVec2::new(0.5 * (s.x - s.y), s.z);
    let back = DVec2::from_angle(-0.5 * half.y.atan2(half.x));
    let (middle, radius) = (0.5 * (s.x + s.y), half.length());
    let first = back.rotate(wo.xy());
    let to_axes = |v: DVec2| back.rotate(v) * DVec2::ONE.copysign(first);
    let direction = |w: DVec3| to_axes(w.xy()).extend(w.z);
    let s = DVec3::new(middle + radius, (middle - radius).max(0.0), 0.0);
    (Surface { wo: direction(wo), m: to_axes(m), s }, direction(wi))
}

/// The projected area of the mesosurface along a direction, the spread of the slopes, and the shift of the mean slope where facets are
/// weighted by their visible area.
struct Seen {
    a: f64,
    b: f64,
    across: DVec2,
    shift: DVec2,
}

impl Seen {
    fn new(w: DVec3, surface: &Surface) -> Self {
        let (a, b) = (meso_area(w, surface.m), slope_spread(w, surface.s));
        let across = covariance_times(surface.s, w.xy());
        let per_b = 1.0 / b.max(1e-18);
        Self { a, b, across, shift: across * (-per_b * clamped_lean(a * per_b)) }
    }
}

impl Form {
    /// All forms.
    pub const ALL: [Self; 4] = [Self::Paper, Self::Invariants, Self::Areas, Self::Centred];

    /// Returns the name of the form.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper's arguments",
            Self::Invariants => "invariants",
            Self::Areas => "areas in closed form",
            Self::Centred => "centred, isotropic",
        }
    }

    /// Returns the number of arguments.
    pub fn arguments(self) -> usize {
        match self {
            Self::Paper | Self::Invariants => 8,
            Self::Areas => 5,
            Self::Centred => 4,
        }
    }

    /// Returns the known factor of the mean cosine, and the arguments of the quotient. Only the first [`Form::arguments`] count.
    /// [`Form::Paper`] requires the axes of [`principal`].
    fn point(self, surface: &Surface, wi: DVec3) -> (f64, [f64; 8]) {
        let Surface { wo, m, s } = *surface;
        match self {
            Self::Paper => (1.0, [wo.x, wo.y, wi.x, wi.y, m.x, m.y, s.x.sqrt(), s.y.sqrt()]),
            Self::Invariants => {
                let spread = squared_normal_spread(m, s);
                let product = covariance_times(s, wo.xy()).dot(wi.xy());
                let [[ao, bo], [ai, bi]] = [wo, wi].map(|w| [meso_area(w, m), slope_spread(w, s)]);
                (1.0, [ao, ai, bo, bi, product, 1.0 / spread.x.sqrt(), spread.y, wo.dot(wi)])
            }
            Self::Areas => {
                let [o, i] = [wo, wi].map(|w| Seen::new(w, surface));
                let [ho, hi] = [&o, &i].map(|seen| seen.a.hypot(seen.b));
                // The slopes of the facets that both see, to first order.
                let spread = squared_normal_spread(m + o.shift + i.shift, s);
                let longer = ((1.0 + m.length_squared() + s.x + s.y) / spread.x).sqrt();
                let product = o.across.dot(wi.xy()) / (ho * hi);
                let scale = visible_area(wi, m, s) / spread.x.sqrt();
                (scale, [o.a / ho, i.a / hi, product, spread.y, longer, 0.0, 0.0, 0.0])
            }
            Self::Centred => (1.0, [wo.z, wi.z, wo.dot(wi), s.x.sqrt(), 0.0, 0.0, 0.0, 0.0]),
        }
    }
}

/// A rational function that approximates the mean cosine.
#[derive(Clone, Debug)]
pub struct Fit {
    form: Form,
    /// The fitted quotient.
    pub quotient: Quotient,
}

impl Fit {
    /// Fits polynomials of the `degrees` above and below the line to a set in the axes of [`principal`].
    pub fn new(form: Form, degrees: [usize; 2], set: &LightSet) -> Self {
        let sample = |(surface, wi, value): (&Surface, DVec3, f64)| {
            let (scale, at) = form.point(surface, wi);
            Sample { at: at[..form.arguments()].to_vec(), scale, value }
        };
        let samples: Vec<Sample> = set.samples().map(sample).collect();
        Self { form, quotient: Quotient::fit(&samples, degrees) }
    }

    /// Returns the mean cosine.
    pub fn cosine(&self, surface: &Surface, wi: DVec3, terms: &mut Terms) -> f64 {
        let (scale, at) = self.form.point(surface, wi);
        let [p, q] = self.quotient.parts(&at[..self.form.arguments()], terms);
        scale * p / q
    }

    /// Returns the smallest denominator over a set, divided by the mean denominator. A pole is near where it is small.
    pub fn smallest_denominator(&self, set: &LightSet) -> f64 {
        let mut terms = [0.0; MOST_TERMS];
        let denominators = set.samples().map(|(surface, wi, _)| {
            let (_, at) = self.form.point(surface, wi);
            self.quotient.parts(&at[..self.form.arguments()], &mut terms)[1]
        });
        let start = (f64::INFINITY, 0.0, 0u32);
        let (smallest, sum, count) = denominators.fold(start, |(least, sum, n), q| (q.min(least), sum + q, n + 1));
        smallest * f64::from(count) / sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature_study::light::random_lights;
    use crate::quadrature_study::surfaces::surfaces;
    use leadr_reflectance::integrals::reference::diffuse_directional;

    #[test]
    fn rotation_keeps_the_term_and_the_invariants() {
        for (surface, wi) in surfaces(20, 3).iter().zip(random_lights(20, 4)) {
            let (rotated, light) = principal(surface, wi);
            assert!(rotated.wo.x >= 0.0 && rotated.wo.y >= 0.0 && rotated.s.x >= rotated.s.y && rotated.s.z == 0.0);
            let [a, b] =
                [(surface, wi), (&rotated, light)].map(|(s, wi)| diffuse_directional(s.wo, wi, s.m, s.s, false, 8));
            assert!((a - b).abs() < 1e-6, "{a} {b}");
            for form in [Form::Invariants, Form::Areas] {
                let [a, b] = [form.point(surface, wi), form.point(&rotated, light)];
                let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * a.abs().max(1.0);
                assert!(near(a.0, b.0) && a.1.iter().zip(b.1).all(|(&a, b)| near(a, b)), "{form:?}: {a:?} {b:?}");
            }
        }
    }
}
