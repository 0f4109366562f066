//! Masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms.
//!
//! The *openness* of a class towards a direction is the part of its projected area that no other facet hides. It is measured on the relief
//! (`leadr_maps::derive::Openness`), because regular relief differs from Smith's assumption that heights, slopes and positions are
//! independent. `Λ = 1 / open − 1` is the optical depth of Smith's form.

use glam::{DVec2, DVec3};

use super::correlated::decorrelation;
use super::shadowing::Shadowing;
use crate::facets::projected_area::visible_area;

/// The maximum number of classes in a pixel.
pub const MOST_CLASSES: usize = 4;
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

/// Returns the openness for a footprint that contains the fraction `inside` of the variance of the relief. The rest is larger than the
/// footprint, and hides nothing here.
pub fn openness_inside(open: [f64; MOST_CLASSES], inside: f64) -> [f64; MOST_CLASSES] {
    open.map(|open| open / (open + inside * (1.0 - open)))
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

    /// Returns the fraction of the facets of each class that is lit from the direction of `light`, among those that are visible. For equal
    /// azimuths, one direction hides all that the other hides. For azimuths that are far apart, `correlation` is 1 for facets that are open
    /// to both by their height, as in Smith's form, 0 for independent directions, and negative for facets that each direction hides from a
    /// different side.
    pub fn lit_fractions(
        &self,
        shadowing: Shadowing,
        correlation: &[f64; MOST_CLASSES],
        light: &Self,
    ) -> [f64; MOST_CLASSES] {
        std::array::from_fn(|k| {
            let open = [self.open[k], light.open[k]];
            class_lit_fraction(shadowing, correlation[k], open, [self.whitened, light.whitened])
        })
    }
}

/// Returns the fraction of the facets of a class that is lit, among those that are visible
/// ([`lit_fractions`](ClassesSeen::lit_fractions)). `open` and `whitened` belong to the viewer and to the light.
pub fn class_lit_fraction(shadowing: Shadowing, correlation: f64, open: [f64; 2], whitened: [DVec2; 2]) -> f64 {
    if matches!(shadowing, Shadowing::None | Shadowing::NormalMap) {
        return 1.0;
    }
    let [o, i] = open.map(|open| 1.0 / open.max(MIN_OPEN) - 1.0);
    let (more, less) = (o.max(i), o.min(i));
    let f = match shadowing {
        Shadowing::Smith => 1.0,
        _ => decorrelation(whitened[0], whitened[1], 1.0, more, less, shadowing == Shadowing::CorrelatedSimple),
    };
    (1.0 + o) / (1.0 + more + f * less * (1.0 + (1.0 - correlation) * more))
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
        let (smith, independent) = ([1.0; MOST_CLASSES], [0.0; MOST_CLASSES]);
        for light in [&high, &low] {
            let lit = low.lit_fractions(Shadowing::Correlated, &independent, light);
            assert!(lit[..2].iter().all(|lit| *lit > 0.999), "{lit:?}");
        }
        // Smith's form is (1 + Λo) / (1 + Λo + Λi).
        let lit = low.lit_fractions(Shadowing::Smith, &smith, &across);
        assert!((lit[0] - 5.0 / 9.0).abs() < 1e-12 && (lit[1] - 2.0 / 3.0).abs() < 1e-12, "{lit:?}");
        let lit = low.lit_fractions(Shadowing::Smith, &independent, &across);
        assert!(lit.iter().zip(across.open).all(|(lit, open)| (lit - open).abs() < 1e-12), "{lit:?}");
        let lit = low.lit_fractions(Shadowing::Smith, &[-1.0; MOST_CLASSES], &across);
        assert!(lit[0] < 0.2 && lit[2] == 1.0, "{lit:?}");
        assert_eq!(low.lit_fractions(Shadowing::None, &smith, &across), [1.0; MOST_CLASSES]);
    }

    #[test]
    fn relief_outside_the_footprint_hides_nothing() {
        let open = [0.25, 0.5, 0.75, 1.0];
        assert_eq!(openness_inside(open, 0.0), [1.0; MOST_CLASSES]);
        assert_eq!(openness_inside(open, 1.0), open);
        assert!((openness_inside(open, 0.5)[0] - 0.4).abs() < 1e-12);
    }
}
