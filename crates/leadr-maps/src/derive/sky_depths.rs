//! The openness of classes towards one direction, and towards the sky.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::projected_area::visible_area;
use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};

use super::openness::{OPENNESS_SIDE, Openness};

/// The number of azimuths and of elevations of the sky.
const AZIMUTHS: usize = 24;
const ELEVATIONS: usize = 16;

impl Openness {
    /// Returns the openness of each class towards a direction. `units` converts the slope units of the class map to rise over run: for an
    /// object, the height factor divided by the width and by the height of the texture. Directions on or below the horizon give 0.
    pub fn towards(&self, w: DVec3, units: DVec2) -> [f64; MOST_CLASSES] {
        if w.z <= 0.0 {
            return [0.0; MOST_CLASSES];
        }
        let q = w.truncate() * units;
        let at = (q / (q.length() + w.z) + 1.0) * (0.5 * OPENNESS_SIDE as f64) - 0.5;
        let (cell, part) = (at.floor(), at - at.floor());
        let last = OPENNESS_SIDE as f64 - 1.0;
        let texel = |x: f64, y: f64| {
            let [x, y] = [cell.x + x, cell.y + y].map(|k| k.clamp(0.0, last) as usize);
            self.texels[y * OPENNESS_SIDE + x].map(f64::from)
        };
        let corners = [texel(0.0, 0.0), texel(1.0, 0.0), texel(0.0, 1.0), texel(1.0, 1.0)];
        std::array::from_fn(|k| {
            let [a, b, c, d] = corners.map(|corner| corner[k]);
            (1.0 - part.y) * ((1.0 - part.x) * a + part.x * b) + part.y * ((1.0 - part.x) * c + part.x * d)
        })
    }

    /// Returns the optical depth of each class towards the sky, for
    /// [`ClassSky`](leadr_reflectance::masking::class_sky::ClassSky): the part `1 / (1 + depth)` of the light that the facets of a class
    /// would receive alone from a sky of constant radiance reaches them. The slopes of `classes` are rise over run, and `units` are those of
    /// [`towards`](Self::towards).
    pub fn sky_depths(&self, classes: &[Class], units: DVec2) -> [f64; MOST_CLASSES] {
        let (mut all, mut seen) = ([0.0; MOST_CLASSES], [0.0; MOST_CLASSES]);
        for i in 0..AZIMUTHS * ELEVATIONS {
            let z = ((i / AZIMUTHS) as f64 + 0.5) / ELEVATIONS as f64;
            let (sin, cos) = (TAU * (i % AZIMUTHS) as f64 / AZIMUTHS as f64).sin_cos();
            let w = (DVec2::new(cos, sin) * (1.0 - z * z).sqrt()).extend(z);
            for (k, (class, open)) in classes.iter().zip(self.towards(w, units)).enumerate() {
                let area = visible_area(w, class.mean, class.covariance);
                all[k] += area;
                seen[k] += area * open;
            }
        }
        std::array::from_fn(|k| if all[k] > 0.0 { all[k] / seen[k].max(1e-3 * all[k]) - 1.0 } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::{Facets, classes};
    use crate::{ClassMap, HeightMap, Wrap};

    /// Deeper pits see less of the sky, and flat ones see all of it.
    #[test]
    fn deep_pits_see_less_of_the_sky() {
        let pit = |x: f64, y: f64| ((x - 0.5).hypot(y - 0.5) * 20.0 - 5.0).clamp(0.0, 1.0);
        let at = |i: u32| (f64::from(i % 64) / 64.0, f64::from(i / 64) / 64.0);
        let texels = (0..64 * 64).map(|i| pit(at(i).0, at(i).1) as f32).collect();
        let map = HeightMap { width: 64, height: 64, texels };
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [0.2; 2], None);
        let class_map = ClassMap::new(facets, &found, None);
        let open = Openness::new(facets, &found, None, class_map.units, false);
        let depths = |scale: f64| {
            let physical: Vec<Class> = class_map
                .mean()
                .into_iter()
                .map(|class| Class { mean: scale * class.mean, covariance: scale * scale * class.covariance, ..class })
                .collect();
            let unit = scale * DVec2::new(class_map.units[0].into(), class_map.units[1].into());
            open.sky_depths(&physical, unit)
        };
        let (deep, shallow, flat) = (depths(0.4), depths(0.1), depths(1e-6));
        for k in 0..class_map.count() {
            // Nothing hides the tops.
            let is_top = deep[k] < 1e-3;
            assert!(is_top || deep[k] > 2.0 * shallow[k] && shallow[k] > 0.0, "{deep:?} {shallow:?} {flat:?}");
            assert!(flat[k].abs() < 1e-3, "{flat:?}");
        }
        assert!(deep.iter().any(|&depth| depth > 0.2), "{deep:?}");
        assert_eq!(open.towards(DVec3::NEG_Z, DVec2::ONE), [0.0; MOST_CLASSES]);
    }
}
