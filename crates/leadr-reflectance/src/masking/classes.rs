//! Masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms.
//!
//! The *openness* of a class towards a direction is the part of its projected area that no other facet hides. It is measured on the relief
//! (`leadr_maps::derive::Openness`), because regular relief differs from Smith's assumption that heights, slopes and positions are
//! independent. `Λ = 1 / open − 1` is the optical depth of Smith's form.

use glam::{DVec2, DVec3};

use super::shadowing::Shadowing;
use crate::facets::projected_area::visible_area;

/// The maximum number of classes in a pixel.
pub const MOST_CLASSES: usize = 4;
/// The number of components of the local openness ([`local_openness`]).
pub const LOCAL_COMPONENTS: usize = 4;
/// The smallest openness that is used as a divisor.
const MIN_OPEN: f64 = 1e-3;

/// A class of facets in a footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Class {
    /// The fraction of the mesosurface that the class covers, from 0 to 1.
    pub share: f64,
    /// The mean slope.
    pub mean: DVec2,
    /// The slope covariance `(xx, yy, xy)`.
    pub covariance: DVec3,
    /// The mean height, in any unit.
    pub height: f64,
    /// The variance of the heights, in the square of that unit.
    pub height_variance: f64,
}

/// How the openness of a class towards one direction depends on that towards another direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// The tangent of half the angle between the azimuths at which the facets that the lower direction sees are half as independent of the
    /// higher direction as facets of azimuths that are far apart.
    pub width: f64,
    /// 1 for facets that are open to both directions by their height, as in Smith's form, 0 for independent directions, and negative for
    /// facets that each direction hides from a different side. For azimuths up to a quarter turn apart.
    pub across: f64,
    /// The same for opposite azimuths.
    pub opposite: f64,
}

impl Correlation {
    /// Smith's form, with the mean width of Gaussian reliefs.
    pub const SMITH: Self = Self { width: 0.26, across: 1.0, opposite: 1.0 };
}

/// The angle between the azimuths of two directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Azimuths {
    /// The tangent of half the angle.
    pub half: f64,
    /// The cosine of the angle where it is more than a quarter turn, with the opposite sign, and 0 otherwise.
    pub opposite: f64,
}

impl Azimuths {
    /// Returns the angle between two directions of a plane.
    pub fn between(a: DVec2, b: DVec2) -> Self {
        let scale = (a.length_squared() * b.length_squared()).max(1e-36).sqrt().recip();
        let (cosine, sine) = (a.dot(b) * scale, a.perp_dot(b).abs() * scale);
        // tan(φ/2) = sin φ / (1 + cos φ) = (1 - cos φ) / sin φ
        let half = if cosine >= 0.0 { sine / (1.0 + cosine) } else { (1.0 - cosine) / sine.max(1e-6) };
        Self { half, opposite: (-cosine).max(0.0) }
    }
}

/// Returns the openness for a footprint that contains the fraction `inside` of the variance of the relief. The rest is larger than the
/// footprint, and hides nothing here.
pub fn openness_inside(open: [f64; MOST_CLASSES], inside: f64) -> [f64; MOST_CLASSES] {
    open.map(|open| open / (open + inside * (1.0 - open)))
}

/// Returns the openness of classes in a footprint whose facets can be more or less open than the mean facet of their class. `open` is that
/// of the mean, `components` are those of the local openness in the direction, and `amounts` are their amounts in the footprint
/// (`leadr_maps::derive::LocalOpenness`).
pub fn local_openness(
    open: [f64; MOST_CLASSES],
    components: [f64; LOCAL_COMPONENTS],
    amounts: [f64; LOCAL_COMPONENTS],
) -> [f64; MOST_CLASSES] {
    let more: f64 = components.iter().zip(amounts).map(|(component, amount)| component * amount).sum();
    open.map(|open| (open + more).clamp(0.0, 1.0))
}

/// The openness of the classes of a footprint towards a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassesSeen {
    /// The visible part of the projected area of each class, from 0 to 1.
    pub open: [f64; MOST_CLASSES],
    /// The direction in the space where the slopes of all classes together are isotropic
    /// ([`whitened_direction`](super::correlated::whitened_direction)).
    pub whitened: DVec2,
}

impl ClassesSeen {
    /// Returns the share of each class in the area that is visible from `wo`. The shares sum to one.
    pub fn visible_shares(&self, wo: DVec3, classes: &[Class]) -> [f64; MOST_CLASSES] {
        let mut areas = [0.0; MOST_CLASSES];
        for ((area, class), open) in areas.iter_mut().zip(classes).zip(self.open) {
            *area = class.share * visible_area(wo, class.mean, class.covariance) * open.max(MIN_OPEN);
        }
        let whole = areas.iter().sum::<f64>().max(1e-9);
        areas.map(|area| area / whole)
    }

    /// Returns the fraction of the facets of each class that is lit from the direction of `light`, among those that are visible.
    pub fn lit_fractions(
        &self,
        shadowing: Shadowing,
        correlation: &[Correlation; MOST_CLASSES],
        light: &Self,
    ) -> [f64; MOST_CLASSES] {
        let apart = Azimuths::between(self.whitened, light.whitened);
        std::array::from_fn(|k| class_lit_fraction(shadowing, &correlation[k], [self.open[k], light.open[k]], apart))
    }
}

/// Returns the fraction of the facets of a class that is lit, among those that are visible
/// ([`lit_fractions`](ClassesSeen::lit_fractions)). `open` belongs to the viewer and to the light, whose azimuths are `apart`.
///
/// For equal azimuths, one direction hides all that the other hides.
pub fn class_lit_fraction(shadowing: Shadowing, correlation: &Correlation, open: [f64; 2], apart: Azimuths) -> f64 {
    if matches!(shadowing, Shadowing::None | Shadowing::NormalMap) {
        return 1.0;
    }
    let [o, i] = open.map(|open| 1.0 / open.max(MIN_OPEN) - 1.0);
    let (more, less) = (o.max(i), o.min(i));
    let f = if shadowing == Shadowing::Smith { 1.0 } else { apart.half / (apart.half + correlation.width) };
    let dependent = correlation.across + (correlation.opposite - correlation.across) * apart.opposite;
    (1.0 + o) / (1.0 + more + f * less * (1.0 + (1.0 - dependent) * more))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: Class =
        Class { share: 0.5, mean: DVec2::ZERO, covariance: DVec3::ZERO, height: 0.0, height_variance: 0.0 };

    #[test]
    fn openness_decides() {
        let wall = Class { covariance: DVec3::new(1.0, 1.0, 0.0), ..FLAT };
        let classes = [FLAT, wall];
        let high = ClassesSeen { open: [1.0, 0.9, 1.0, 1.0], whitened: DVec2::new(0.1, 0.0) };
        let low = ClassesSeen { open: [0.2, 0.5, 1.0, 1.0], whitened: DVec2::new(0.9, 0.0) };
        let across = ClassesSeen { whitened: DVec2::new(0.0, 0.9), ..low };
        for wo in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
            let shares = low.visible_shares(wo, &classes);
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares[1] > shares[0]);
        }
        // All facets that are seen by a low viewer are lit by a high light of the same azimuth, and by a light at the viewer.
        let same = |c| [Correlation { width: 0.26, across: c, opposite: c }; MOST_CLASSES];
        let (smith, independent) = (same(1.0), same(0.0));
        for light in [&high, &low] {
            let lit = low.lit_fractions(Shadowing::Correlated, &independent, light);
            assert!(lit[..2].iter().all(|lit| *lit > 0.999), "{lit:?}");
        }
        // Smith's form is (1 + Λo) / (1 + Λo + Λi).
        let lit = low.lit_fractions(Shadowing::Smith, &smith, &across);
        assert!((lit[0] - 5.0 / 9.0).abs() < 1e-12 && (lit[1] - 2.0 / 3.0).abs() < 1e-12, "{lit:?}");
        let lit = low.lit_fractions(Shadowing::Smith, &independent, &across);
        assert!(lit.iter().zip(across.open).all(|(lit, open)| (lit - open).abs() < 1e-12), "{lit:?}");
        let lit = low.lit_fractions(Shadowing::Smith, &same(-1.0), &across);
        assert!(lit[0] < 0.2 && lit[2] == 1.0, "{lit:?}");
        assert_eq!(low.lit_fractions(Shadowing::None, &smith, &across), [1.0; MOST_CLASSES]);
        // Facets that each direction hides from its own side are dark from the opposite side.
        let sided = [Correlation { width: 0.26, across: 1.0, opposite: -3.0 }; MOST_CLASSES];
        let opposite = ClassesSeen { whitened: DVec2::new(-0.9, 0.0), ..low };
        let [a, b] = [&across, &opposite].map(|light| low.lit_fractions(Shadowing::Correlated, &sided, light)[0]);
        assert!(a > 0.6 && b < 0.1, "{a} {b}");
    }

    #[test]
    fn azimuths_are_apart_by_their_angle() {
        for degrees in [0.0f64, 1.0, 30.0, 89.0, 90.0, 91.0, 150.0, 179.0, 180.0, 270.0] {
            let turned = DVec2::from_angle(degrees.to_radians());
            let found = Azimuths::between(DVec2::new(0.0, 0.3), 2.0 * turned.rotate(DVec2::Y));
            let half = (0.5 * degrees.to_radians()).tan().abs().min(1e6);
            assert!(
                (found.half - half).abs() <= 1e-9 + 1e-9 * half || degrees == 180.0 && found.half > 1e5,
                "{degrees}"
            );
            assert!((found.opposite - (-degrees.to_radians().cos()).max(0.0)).abs() < 1e-12, "{degrees}");
        }
    }

    #[test]
    fn relief_outside_the_footprint_hides_nothing() {
        let open = [0.25, 0.5, 0.75, 1.0];
        assert_eq!(openness_inside(open, 0.0), [1.0; MOST_CLASSES]);
        assert_eq!(openness_inside(open, 1.0), open);
        assert!((openness_inside(open, 0.5)[0] - 0.4).abs() < 1e-12);
    }
}
