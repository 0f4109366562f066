//! The sky that the facets of each class see, averaged over all facets of the class.
//!
//! A sky of constant radiance sends the flux `π` through each unit of the mesosurface. Without other facets, a facet with the normal `n`
//! receives `π (1 + n·g)/2` per unit of its area, where `g` is the normal of the mesosurface. A class with the facet area `N_k` per unit of
//! mesosurface, of which `p_k` is its projection, therefore receives `π (N_k + p_k)/2`. Other facets leave the part `1 / (1 + x_k)` of it,
//! where `x_k` is the optical depth of the class towards the sky (`leadr_maps::derive::Openness::sky_depths`). The flux of all classes sums
//! to `π`, because the relief loses no light.

use glam::DVec2;

use super::classes::{Class, MOST_CLASSES};
use crate::facets::normal_length::mean_normal_length;

/// The sky above the classes of a footprint, independent of the viewer. Areas are relative to the mesosurface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassSky {
    /// The mean slope of all facets.
    pub mean: DVec2,
    /// The share of each class times its facet area.
    pub areas: [f64; MOST_CLASSES],
    /// The share of each class in the flux of the sky. The shares sum to one.
    pub flux: [f64; MOST_CLASSES],
    /// The optical depth of each class towards the sky.
    pub depths: [f64; MOST_CLASSES],
}

impl ClassSky {
    /// Computes the sky of at most [`MOST_CLASSES`] classes, from their optical depths towards the sky.
    pub fn new(classes: &[Class], depths: [f64; MOST_CLASSES]) -> Self {
        let whole: f64 = classes.iter().map(|class| class.share).sum::<f64>().max(1e-30);
        let mean: DVec2 = classes.iter().map(|class| class.share / whole * class.mean).sum();
        let per_square = 1.0 / (1.0 + mean.length_squared());
        let (mut areas, mut flux) = ([0.0; MOST_CLASSES], [0.0; MOST_CLASSES]);
        for (k, class) in classes.iter().enumerate() {
            let area = mean_normal_length(class.mean, class.covariance) * per_square.sqrt();
            let projected = (1.0 + mean.dot(class.mean)) * per_square;
            areas[k] = class.share / whole * area;
            flux[k] = class.share / whole * 0.5 * (area + projected).max(0.0) / (1.0 + depths[k]);
        }
        let all = flux.iter().sum::<f64>().max(1e-30);
        flux.iter_mut().for_each(|flux| *flux /= all);
        Self { mean, areas, flux, depths }
    }

    /// Returns the fraction of the sky's directions that other facets or the mesosurface block, weighted by the cosine, averaged over all
    /// facets of each class.
    pub fn blocked(&self) -> [f64; MOST_CLASSES] {
        std::array::from_fn(|k| ((self.areas[k] - self.flux[k]) / self.areas[k].max(1e-30)).clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Facets of one class see the part `1/E[|N|]` of the sky, because no light of the sky is lost.
    #[test]
    fn one_class_receives_all_light() {
        let (mean, covariance) = (DVec2::new(0.3, -0.1), DVec3::new(0.5, 0.3, 0.1));
        let class = Class { share: 1.0, mean, covariance, height: 0.0, height_variance: 1.0 };
        let sky = ClassSky::new(&[class], [0.2, 0.0, 0.0, 0.0]);
        let area = mean_normal_length(mean, covariance) / (1.0 + mean.length_squared()).sqrt();
        assert!((sky.areas[0] - area).abs() < 1e-12 && (sky.flux[0] - 1.0).abs() < 1e-12);
        assert!((sky.blocked()[0] - (1.0 - 1.0 / area)).abs() < 1e-12);
    }

    #[test]
    fn depth_takes_flux_from_a_class() {
        let flat =
            |share| Class { share, mean: DVec2::ZERO, covariance: DVec3::ZERO, height: 0.0, height_variance: 0.0 };
        let sky = ClassSky::new(&[flat(0.8), flat(1.2)], [0.0; MOST_CLASSES]);
        assert!((sky.flux[0] - 0.4).abs() < 1e-12 && sky.blocked().iter().all(|&blocked| blocked < 1e-12));
        let sky = ClassSky::new(&[flat(0.8), flat(1.2)], [1.0, 0.0, 0.0, 0.0]);
        assert!((sky.flux[0] - 0.25).abs() < 1e-12 && (sky.blocked()[0] - 0.375).abs() < 1e-12);
    }
}
