//! How much more or less open a texel is than its classes are in the mean.
//!
//! The openness of a class is a mean over the whole map. A footprint that is smaller than the bumps has facets of a class that are more
//! open than others, and open to other sides. Around each texel, the horizons in several azimuths give its own openness. It differs from
//! that of its classes by about `(a + b·v) S`, where `v` is the unit vector of the azimuth and `S` is the mean of `open (1 − open)` over all
//! classes. The numbers `a` and `b` are fitted by least squares. They are linear in the openness, so texture filters average them, and their
//! means over the map are 0 for each class.

use std::f64::consts::TAU;

use glam::{DMat3, DVec2, DVec3};
use half::f16;
use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};
use rayon::prelude::*;

use super::classes::Facets;
use super::openness::{Field, Openness, distance};
use crate::ClassMap;
use crate::class_map::ClassLevel;
use crate::pyramid::{Pyramid, level_sizes};

/// The largest number of texels whose horizons are searched. Finer levels repeat the texels of this level.
const MOST_TEXELS: usize = 1 << 16;
/// The number of azimuths of horizons.
const AZIMUTHS: usize = 16;
/// The number of elevations of the fit.
const ELEVATIONS: usize = 8;
/// The weight of the fit's preference for small numbers.
const RIDGE: f64 = 0.01;
/// The largest number, which is that of a texel without any openness.
const MOST: f64 = 8.0;

/// A level of the local openness, with one texel per texel of the class map: `a`, `b.x` and `b.y`.
pub type LocalLevel = Vec<[f16; 3]>;

/// The openness of the classes in one azimuth, and the mean of `open (1 − open)`, by elevation.
struct Curve {
    open: [[f64; MOST_CLASSES]; ELEVATIONS],
    shape: [f64; ELEVATIONS],
}

impl Openness {
    /// Measures the local openness of a relief, with the levels of its class map. If `upside_down` is true, the heights are negated.
    pub fn local(&self, facets: Facets<'_>, map: &ClassMap, upside_down: bool) -> Vec<LocalLevel> {
        let sign = if upside_down { -1.0 } else { 1.0 };
        let small = |level: &&ClassLevel| level.width as usize * level.height as usize <= MOST_TEXELS;
        let searched = map.levels.iter().take_while(|level| !small(level)).count().min(map.levels.len() - 1);
        let field = Field::new(facets, sign);
        let level = &map.levels[searched];
        let found = self.fitted(&field, map, searched, sign);
        let mut levels = filtered(&centred(found, map, searched), level);
        for pair in map.levels[..=searched].windows(2).rev() {
            let repeated = repeated(&levels[0], &pair[1], &pair[0]);
            levels.insert(0, repeated);
        }
        let halves =
            |level: Vec<[f32; 3]>| -> LocalLevel { level.into_iter().map(|texel| texel.map(f16::from_f32)).collect() };
        levels.into_iter().map(halves).collect()
    }

    fn fitted(&self, field: &Field, map: &ClassMap, number: usize, sign: f64) -> Vec<[f32; 3]> {
        let level = &map.levels[number];
        let units = DVec2::new(f64::from(map.units[0]), f64::from(map.units[1]));
        let size = DVec2::new(f64::from(level.width), f64::from(level.height));
        let whole = map.mean();
        let azimuths: [DVec2; AZIMUTHS] =
            std::array::from_fn(|i| DVec2::from_angle(TAU * (i as f64 + 0.5) / AZIMUTHS as f64));
        let curves = azimuths.map(|v| self.curve(v, &whole));
        let texel = |i: usize| {
            let at = [i % level.width as usize, i / level.width as usize].map(|k| k as f64 + 0.5);
            let at = DVec2::from(at) / size;
            let classes = map.classes_of_texel(number, i);
            let slope = sign * classes.iter().map(|class| class.share * class.mean).sum::<DVec2>();
            let height = field.height(number, at);
            let (mut product, mut normal) = (DVec3::ZERO, DMat3::ZERO);
            for (v, curve) in azimuths.iter().zip(&curves) {
                let along = *v / units;
                let reach = field.reach_over(number, at, height, along, distance(ELEVATIONS - 1, ELEVATIONS));
                let tilt = along.dot(slope);
                let mut sums = [0.0; 2];
                for row in 0..ELEVATIONS {
                    let q = distance(row, ELEVATIONS);
                    let area = (1.0 - q * tilt).max(0.0);
                    let open: f64 = classes.iter().zip(curve.open[row]).map(|(class, open)| class.share * open).sum();
                    let own = if q < reach { 1.0 } else { 0.0 };
                    sums[0] += area * curve.shape[row] * (own - open);
                    sums[1] += area * curve.shape[row] * curve.shape[row];
                }
                let terms = DVec3::new(1.0, v.x, v.y);
                product += sums[0] * terms;
                normal += DMat3::from_cols(terms, v.x * terms, v.y * terms) * sums[1];
            }
            let ridge = RIDGE * (normal.x_axis.x + normal.y_axis.y + normal.z_axis.z) / 3.0 + 1e-9;
            let found = (normal + DMat3::from_diagonal(DVec3::splat(ridge))).inverse() * product;
            found.clamp(DVec3::splat(-MOST), DVec3::splat(MOST)).as_vec3().to_array()
        };
        (0..level.width as usize * level.height as usize).into_par_iter().map(texel).collect()
    }

    fn curve(&self, v: DVec2, whole: &[Class]) -> Curve {
        let mut curve = Curve { open: [[0.0; MOST_CLASSES]; ELEVATIONS], shape: [0.0; ELEVATIONS] };
        for row in 0..ELEVATIONS {
            let open = self.towards((v * distance(row, ELEVATIONS)).extend(1.0), DVec2::ONE);
            curve.open[row] = open;
            curve.shape[row] = whole.iter().zip(open).map(|(class, open)| class.share * open * (1.0 - open)).sum();
        }
        curve
    }
}

/// Subtracts the means of each class.
fn centred(mut values: Vec<[f32; 3]>, map: &ClassMap, level: usize) -> Vec<[f32; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); map.count()];
    for (i, value) in values.iter().enumerate() {
        for (sum, Class { share, .. }) in sums.iter_mut().zip(map.classes_of_texel(level, i)) {
            (0..3).for_each(|n| sum.0[n] += share * f64::from(value[n]));
            sum.1 += share;
        }
    }
    let means: Vec<[f32; 3]> = sums.into_iter().map(|(sum, all)| sum.map(|v| (v / all.max(1e-9)) as f32)).collect();
    values.par_iter_mut().enumerate().for_each(|(i, value)| {
        for (mean, Class { share, .. }) in means.iter().zip(map.classes_of_texel(level, i)) {
            (0..3).for_each(|n| value[n] -= share as f32 * mean[n]);
        }
    });
    values
}

/// Returns all levels from this one.
fn filtered(texels: &[[f32; 3]], level: &ClassLevel) -> Vec<Vec<[f32; 3]>> {
    let mut levels = vec![Vec::new(); level_sizes([level.width, level.height]).len()];
    let rows = texels.chunks_exact(level.width as usize).map(|row| row.as_flattened().to_vec()).collect();
    let pushed = Pyramid::new([level.width, level.height], 3).push(rows, &mut |level, _, rows| {
        levels[level].extend(rows.iter().flat_map(|row| row.as_chunks().0));
        Ok(())
    });
    pushed.expect("the callback never fails");
    levels
}

/// Returns the level before, with the texels of this level.
fn repeated(from: &[[f32; 3]], coarse: &ClassLevel, fine: &ClassLevel) -> Vec<[f32; 3]> {
    let texel = |i: usize| {
        let (x, y) = (i % fine.width as usize / 2, i / fine.width as usize / 2);
        from[y.min(coarse.height as usize - 1) * coarse.width as usize + x.min(coarse.width as usize - 1)]
    };
    (0..fine.width as usize * fine.height as usize).into_par_iter().map(texel).collect()
}

#[cfg(test)]
mod tests {
    use leadr_reflectance::masking::classes::local_openness;

    use super::*;
    use crate::derive::classes;
    use crate::{HeightMap, Wrap, procedural};

    fn plateaus() -> HeightMap {
        let mut map = procedural::fbm(64, 48, 3, 4, 3, 0.5);
        map.texels.iter_mut().for_each(|h| *h = 0.2 * (6.0 * *h - 2.5).clamp(0.0, 1.0) + 0.02 * *h);
        map
    }

    /// The openness of a texel is nearer to its own horizons than that of its classes is.
    #[test]
    fn texels_differ_from_their_classes() {
        let map = plateaus();
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [1.0; 2], None);
        let table = ClassMap::new(facets, &found, None);
        let open = Openness::new(facets, &found, None, table.units, false);
        let local = open.local(facets, &table, false);
        assert!(local.iter().zip(&table.levels).all(|(local, level)| local.len() == level.layers[0].len()));
        let field = Field::new(facets, 1.0);
        let units = DVec2::new(f64::from(table.units[0]), f64::from(table.units[1]));
        let whole = table.mean();
        let (mut of_classes, mut of_texels, mut count) = (0.0, 0.0, 0.0);
        for i in (0..64 * 48).step_by(7) {
            let at = DVec2::new((f64::from(i % 64) + 0.5) / 64.0, (f64::from(i / 64) + 0.5) / 48.0);
            let own = table.classes_of_texel(0, i as usize);
            let slope: DVec2 = own.iter().map(|class| class.share * class.mean).sum();
            for (k, q) in [0.4, 0.8, 1.6].into_iter().enumerate() {
                let v = DVec2::from_angle(2.4 * f64::from(i) + k as f64);
                if q * (v / units).dot(slope) >= 0.9 {
                    continue;
                }
                let truth = if q < field.reach(at, field.height(0, at), v / units, 10.0) { 1.0 } else { 0.0 };
                let of_class = open.towards((q * v).extend(1.0), DVec2::ONE);
                let shape: f64 =
                    whole.iter().zip(of_class).map(|(class, open)| class.share * open * (1.0 - open)).sum();
                let texel = local[0][i as usize].map(f16::to_f64);
                let mean = |open: [f64; MOST_CLASSES]| {
                    own.iter().zip(open).map(|(class, open)| class.share * open).sum::<f64>()
                };
                of_classes += (mean(of_class) - truth).powi(2);
                of_texels += (mean(local_openness(of_class, shape, v, texel)) - truth).powi(2);
                count += 1.0;
            }
        }
        let [of_classes, of_texels] = [of_classes, of_texels].map(|sum| (sum / count).sqrt());
        println!("openness of a texel errs by {of_classes:.3} for its classes, {of_texels:.3} for itself");
        assert!(of_texels < 0.9 * of_classes, "{of_texels} {of_classes}");
    }

    #[test]
    fn classes_keep_their_openness() {
        let map = plateaus();
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [1.0; 2], None);
        let table = ClassMap::new(facets, &found, None);
        for upside_down in [false, true] {
            let open = Openness::new(facets, &found, None, table.units, upside_down);
            let local = open.local(facets, &table, upside_down);
            let [mean] = local.last().unwrap()[..] else { panic!("one texel") };
            assert!(mean.iter().all(|v| v.to_f64().abs() < 0.02), "{mean:?}");
            assert!(local[0].iter().flatten().any(|v| v.to_f64().abs() > 0.5));
        }
    }

    #[test]
    fn large_maps_repeat_the_texels_of_a_coarser_level() {
        let fine = procedural::fbm(512, 256, 3, 4, 3, 0.5);
        let map = HeightMap { texels: fine.texels.iter().map(|h| (4.0 * h - 1.5).clamp(0.0, 1.0)).collect(), ..fine };
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [0.2; 2], None);
        assert!(found.count() > 1);
        let table = ClassMap::new(facets, &found, None);
        let local = Openness::new(facets, &found, None, table.units, false).local(facets, &table, false);
        assert_eq!(local.iter().map(Vec::len).collect::<Vec<_>>()[..2], [512 * 256, 256 * 128]);
        assert!((0..512 * 256).step_by(1001).all(|i| local[0][i] == local[1][i / 1024 * 256 + i % 512 / 2]));
    }
}
