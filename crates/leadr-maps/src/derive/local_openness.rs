//! How much more or less open a texel is than its classes are in the mean.
//!
//! The openness of a class is a mean over the whole map. A footprint that is smaller than the bumps has facets of a class that are more
//! open than others, and open to other sides. Around each texel, the horizons in several azimuths give its own openness, a function of
//! the direction. Its difference from the openness of the classes is described by the principal components of these differences over the
//! map: a few functions of the direction, with an amount of each per texel. The amounts are linear in the openness, so texture filters
//! average them, and their means over the map are 0 for each class.

use std::f64::consts::TAU;

use glam::DVec2;
use half::f16;
use leadr_reflectance::masking::classes::{Class, LOCAL_COMPONENTS, MOST_CLASSES};
use leadr_reflectance::random::Random;
use rayon::prelude::*;

use super::classes::Facets;
use super::openness::{Field, OPENNESS_SIDE, Openness, Polar, distance};
use crate::ClassMap;
use crate::class_map::ClassLevel;
use crate::pyramid::{Pyramid, level_sizes};

/// The largest number of texels whose horizons are searched. Finer levels repeat the texels of this level.
const MOST_TEXELS: usize = 1 << 16;
/// The number of azimuths of horizons.
const AZIMUTHS: usize = 16;
/// The number of elevations at which the openness is compared.
const ELEVATIONS: usize = 16;
const DIRECTIONS: usize = AZIMUTHS * ELEVATIONS;
/// The sides of the blocks of texels whose means have the components. Single texels would spend them on what filters average.
const BLOCKS: [usize; 3] = [4, 8, 16];
/// The number of steps of the search for components, and of vectors beside them, which make it converge.
const STEPS: usize = 48;
const SPARE: usize = 4;

/// A level of the local openness: the amount of each component, per texel of the class map.
pub type LocalLevel = Vec<[f16; LOCAL_COMPONENTS]>;

/// The openness of texels, as a difference from that of their classes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalOpenness {
    /// The components as a table over directions, like that of the [`Openness`].
    pub components: Vec<[f16; LOCAL_COMPONENTS]>,
    /// The amounts, with the levels of the class map. Smooth surfaces and atlases have no levels.
    pub levels: Vec<LocalLevel>,
}

/// The openness of a texel, minus that of its classes, in each direction.
type Difference = [f32; DIRECTIONS];

/// The texels of a level, for measurements.
struct Texels<'a> {
    map: &'a ClassMap,
    number: usize,
    /// The azimuths.
    along: [DVec2; AZIMUTHS],
    /// The openness of the classes in each direction.
    of_classes: Vec<[f64; MOST_CLASSES]>,
    /// The reach in each azimuth of each texel.
    reaches: Vec<[f32; AZIMUTHS]>,
    sign: f64,
}

impl Openness {
    /// Measures the local openness of a relief, with the levels of its class map. If `upside_down` is true, the heights are negated.
    pub fn local(&self, facets: Facets<'_>, map: &ClassMap, upside_down: bool) -> LocalOpenness {
        let sign = if upside_down { -1.0 } else { 1.0 };
        let small = |level: &&ClassLevel| level.width as usize * level.height as usize <= MOST_TEXELS;
        let searched = map.levels.iter().take_while(|level| !small(level)).count().min(map.levels.len() - 1);
        let level = &map.levels[searched];
        let texels = self.texels(&Field::new(facets, sign), map, searched, sign);
        let weights = weights();
        let components = texels.components(&weights);
        let amounts = |i: usize| {
            let difference = texels.difference(i);
            std::array::from_fn(|n| {
                let of_direction = |((c, d), w): ((&f64, &f32), &f64)| c * f64::from(*d) * w.sqrt();
                components[n].iter().zip(&difference).zip(&weights).map(of_direction).sum::<f64>() as f32
            })
        };
        let found = (0..level.width as usize * level.height as usize).into_par_iter().map(amounts).collect();
        let mut levels = filtered(&centred(found, map, searched), level);
        for pair in map.levels[..=searched].windows(2).rev() {
            let repeated = repeated(&levels[0], &pair[1], &pair[0]);
            levels.insert(0, repeated);
        }
        let halves = |level: Vec<[f32; LOCAL_COMPONENTS]>| -> LocalLevel {
            level.into_iter().map(|texel| texel.map(f16::from_f32)).collect()
        };
        let polar = Polar {
            elevations: ELEVATIONS,
            values: (0..DIRECTIONS).map(|i| std::array::from_fn(|n| components[n][i] / weights[i].sqrt())).collect(),
            above: [0.0; LOCAL_COMPONENTS],
        };
        LocalOpenness {
            components: polar.table(OPENNESS_SIDE).into_iter().map(|texel| texel.map(f16::from_f64)).collect(),
            levels: levels.into_iter().map(halves).collect(),
        }
    }

    fn texels<'a>(&self, field: &Field, map: &'a ClassMap, number: usize, sign: f64) -> Texels<'a> {
        let level = &map.levels[number];
        let units = DVec2::new(f64::from(map.units[0]), f64::from(map.units[1]));
        let size = DVec2::new(f64::from(level.width), f64::from(level.height));
        let azimuths: [DVec2; AZIMUTHS] = std::array::from_fn(|i| DVec2::from_angle(TAU * i as f64 / AZIMUTHS as f64));
        let along = azimuths.map(|v| v / units);
        let most = distance(ELEVATIONS - 1, ELEVATIONS);
        let reaches = |i: usize| {
            let at =
                DVec2::new((i % level.width as usize) as f64 + 0.5, (i / level.width as usize) as f64 + 0.5) / size;
            let height = field.height(number, at);
            along.map(|along| field.reach_over(number, at, height, along, most) as f32)
        };
        let towards = |i: usize| {
            let q = azimuths[i / ELEVATIONS] * distance(i % ELEVATIONS, ELEVATIONS);
            self.towards(q.extend(1.0), DVec2::ONE)
        };
        Texels {
            map,
            number,
            along,
            of_classes: (0..DIRECTIONS).map(towards).collect(),
            reaches: (0..level.width as usize * level.height as usize).into_par_iter().map(reaches).collect(),
            sign,
        }
    }
}

impl Texels<'_> {
    /// Returns the difference of a texel. It is 0 in directions from which the back of the texel is seen.
    fn difference(&self, i: usize) -> Difference {
        let classes = self.map.classes_of_texel(self.number, i);
        let slope = self.sign * classes.iter().map(|class| class.share * class.mean).sum::<DVec2>();
        let mut difference = [0.0; DIRECTIONS];
        for (azimuth, of_azimuth) in difference.chunks_exact_mut(ELEVATIONS).enumerate() {
            let tilt = self.along[azimuth].dot(slope);
            let reach = f64::from(self.reaches[i][azimuth]);
            for (row, difference) in of_azimuth.iter_mut().enumerate() {
                let q = distance(row, ELEVATIONS);
                let open = &self.of_classes[azimuth * ELEVATIONS + row];
                let open: f64 = classes.iter().zip(open).map(|(class, open)| class.share * open).sum();
                let own = if q < reach { 1.0 } else { 0.0 };
                *difference = if q * tilt < 1.0 { (own - open) as f32 } else { 0.0 };
            }
        }
        difference
    }

    /// Returns the principal components of the differences of blocks of texels, as unit vectors of the weighted differences.
    fn components(&self, weights: &[f64]) -> Vec<Vec<f64>> {
        let ClassLevel { width, height, .. } = self.map.levels[self.number];
        let (width, height) = (width as usize, height as usize);
        let mut covariance = vec![0.0; DIRECTIONS * DIRECTIONS];
        for side in BLOCKS {
            let (across, down) = (width.div_ceil(side), height.div_ceil(side));
            let block = |i: usize| {
                let [first, row] = [i % across * side, i / across * side];
                let mut mean = vec![0.0; DIRECTIONS];
                let mut count = 0.0;
                for texel in (row..height.min(row + side))
                    .flat_map(|y| (first..width.min(first + side)).map(move |x| y * width + x))
                {
                    mean.iter_mut().zip(self.difference(texel)).for_each(|(sum, d)| *sum += f64::from(d));
                    count += 1.0;
                }
                mean.iter_mut().zip(weights).for_each(|(mean, weight)| *mean *= weight.sqrt() / count);
                mean
            };
            let mut blocks: Vec<Vec<f64>> = (0..across * down).into_par_iter().map(block).collect();
            let mut mean = vec![0.0; DIRECTIONS];
            blocks.iter().for_each(|block| mean.iter_mut().zip(block).for_each(|(sum, v)| *sum += v));
            let share = 1.0 / blocks.len() as f64;
            blocks.iter_mut().for_each(|block| block.iter_mut().zip(&mean).for_each(|(v, sum)| *v -= share * sum));
            covariance.par_chunks_exact_mut(DIRECTIONS).enumerate().for_each(|(i, row)| {
                for block in &blocks {
                    let factor = share * block[i];
                    row.iter_mut().zip(block).for_each(|(sum, v)| *sum += factor * v);
                }
            });
        }
        largest_eigenvectors(&covariance, DIRECTIONS, LOCAL_COMPONENTS)
    }
}

/// Returns the weight of each direction: its solid angle and part of its height, if the slopes have the unit 1.
fn weights() -> Vec<f64> {
    let elevation = |row: f64| (ELEVATIONS as f64 / row - 1.0).atan();
    let weight = |i: usize| {
        let row = (i % ELEVATIONS) as f64;
        let angle = elevation(row + 0.5);
        let height = if row == 0.0 { TAU / 4.0 } else { elevation(row) } - elevation(row + 1.0);
        height * angle.cos() * angle.sin().sqrt()
    };
    let weights: Vec<f64> = (0..DIRECTIONS).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// Returns unit eigenvectors of the largest eigenvalues of a symmetric matrix without negative ones, by orthogonal iteration. Vectors of
/// the eigenvalue 0 can be 0.
fn largest_eigenvectors(matrix: &[f64], side: usize, count: usize) -> Vec<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut random = Random(1);
    let mut vectors: Vec<Vec<f64>> =
        (0..count + SPARE).map(|_| (0..side).map(|_| random.range(-1.0, 1.0)).collect()).collect();
    for _ in 0..STEPS {
        let product = |vector: &Vec<f64>| matrix.chunks_exact(side).map(|row| dot(row, vector)).collect();
        let mut products: Vec<Vec<f64>> = vectors.par_iter().map(product).collect();
        for i in 0..products.len() {
            let (before, rest) = products.split_at_mut(i);
            let vector = &mut rest[0];
            for other in before {
                let along = dot(vector, other);
                vector.iter_mut().zip(other).for_each(|(v, other)| *v -= along * *other);
            }
            let length = dot(vector, vector).sqrt();
            let factor = if length > 1e-12 { 1.0 / length } else { 0.0 };
            vector.iter_mut().for_each(|v| *v *= factor);
        }
        vectors = products;
    }
    vectors.truncate(count);
    vectors
}

type Amounts = [f32; LOCAL_COMPONENTS];

/// Subtracts the means of each class.
fn centred(mut values: Vec<Amounts>, map: &ClassMap, level: usize) -> Vec<Amounts> {
    let mut sums = vec![([0.0; LOCAL_COMPONENTS], 0.0); map.count()];
    for (i, value) in values.iter().enumerate() {
        for (sum, Class { share, .. }) in sums.iter_mut().zip(map.classes_of_texel(level, i)) {
            (0..LOCAL_COMPONENTS).for_each(|n| sum.0[n] += share * f64::from(value[n]));
            sum.1 += share;
        }
    }
    let means: Vec<Amounts> = sums.into_iter().map(|(sum, all)| sum.map(|v| (v / all.max(1e-9)) as f32)).collect();
    values.par_iter_mut().enumerate().for_each(|(i, value)| {
        for (mean, Class { share, .. }) in means.iter().zip(map.classes_of_texel(level, i)) {
            (0..LOCAL_COMPONENTS).for_each(|n| value[n] -= share as f32 * mean[n]);
        }
    });
    values
}

/// Returns all levels from this one.
fn filtered(texels: &[Amounts], level: &ClassLevel) -> Vec<Vec<Amounts>> {
    let mut levels = vec![Vec::new(); level_sizes([level.width, level.height]).len()];
    let rows = texels.chunks_exact(level.width as usize).map(|row| row.as_flattened().to_vec()).collect();
    let pushed = Pyramid::new([level.width, level.height], LOCAL_COMPONENTS).push(rows, &mut |level, _, rows| {
        levels[level].extend(rows.iter().flat_map(|row| row.as_chunks().0));
        Ok(())
    });
    pushed.expect("the callback never fails");
    levels
}

/// Returns the level before, with the texels of this level.
fn repeated(from: &[Amounts], coarse: &ClassLevel, fine: &ClassLevel) -> Vec<Amounts> {
    let texel = |i: usize| {
        let (x, y) = (i % fine.width as usize / 2, i / fine.width as usize / 2);
        from[y.min(coarse.height as usize - 1) * coarse.width as usize + x.min(coarse.width as usize - 1)]
    };
    (0..fine.width as usize * fine.height as usize).into_par_iter().map(texel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::classes;
    use crate::{HeightMap, Wrap, procedural};

    fn plateaus() -> HeightMap {
        let mut map = procedural::fbm(64, 48, 3, 4, 3, 0.5);
        map.texels.iter_mut().for_each(|h| *h = 0.2 * (6.0 * *h - 2.5).clamp(0.0, 1.0) + 0.02 * *h);
        map
    }

    /// The openness of a block of texels is nearer to its own horizons than that of its classes is.
    #[test]
    fn texels_differ_from_their_classes() {
        let map = plateaus();
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [1.0; 2], None);
        let table = ClassMap::new(facets, &found, None);
        let open = Openness::new(facets, &found, None, table.units, false);
        let local = open.local(facets, &table, false);
        assert!(local.levels.iter().zip(&table.levels).all(|(local, level)| local.len() == level.layers[0].len()));
        let texels = open.texels(&Field::new(facets, 1.0), &table, 0, 1.0);
        let weights = weights();
        let components: Vec<[f64; LOCAL_COMPONENTS]> = (0..DIRECTIONS)
            .map(|i| {
                let q = DVec2::from_angle(TAU * (i / ELEVATIONS) as f64 / AZIMUTHS as f64)
                    * distance(i % ELEVATIONS, ELEVATIONS);
                nearest(&local.components, q)
            })
            .collect();
        let (width, height) = (map.width as usize, map.height as usize);
        for (side, most) in [(1, 0.9), (4, 0.8), (8, 0.75)] {
            let (mut of_classes, mut of_texels, mut count) = (0.0, 0.0, 0.0);
            for block in 0..width / side * (height / side) {
                let (x, y) = (block % (width / side) * side, block / (width / side) * side);
                let (mut difference, mut amounts) = ([0.0; DIRECTIONS], [0.0; LOCAL_COMPONENTS]);
                for i in (0..side * side).map(|i| (y + i / side) * width + x + i % side) {
                    difference.iter_mut().zip(texels.difference(i)).for_each(|(sum, d)| *sum += f64::from(d));
                    amounts.iter_mut().zip(local.levels[0][i]).for_each(|(sum, amount)| *sum += amount.to_f64());
                }
                let texels = (side * side) as f64;
                for (i, weight) in weights.iter().enumerate() {
                    let truth = difference[i] / texels;
                    let found: f64 = components[i].iter().zip(amounts).map(|(c, amount)| c * amount / texels).sum();
                    of_classes += weight * truth * truth;
                    of_texels += weight * (truth - found).powi(2);
                }
                count += 1.0;
            }
            let [of_classes, of_texels] = [of_classes, of_texels].map(|sum: f64| (sum / count).sqrt());
            println!(
                "openness of {side} x {side} texels errs by {of_classes:.3} for its classes, {of_texels:.3} for itself"
            );
            assert!(of_texels < most * of_classes, "{of_texels} {of_classes}");
        }
    }

    /// Returns the value of a table at the texel of a direction.
    fn nearest(table: &[[f16; LOCAL_COMPONENTS]], q: DVec2) -> [f64; LOCAL_COMPONENTS] {
        let at = (q / (1.0 + q.length()) + 1.0) * (0.5 * OPENNESS_SIDE as f64);
        table[at.y as usize * OPENNESS_SIDE + at.x as usize].map(f64::from)
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
            let [mean] = local.levels.last().unwrap()[..] else { panic!("one texel") };
            assert!(mean.iter().all(|v| v.to_f64().abs() < 0.02), "{mean:?}");
            assert!(local.levels[0].iter().flatten().any(|v| v.to_f64().abs() > 0.1));
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
        assert_eq!(local.levels.iter().map(Vec::len).collect::<Vec<_>>()[..2], [512 * 256, 256 * 128]);
        assert!(
            (0..512 * 256).step_by(1001).all(|i| local.levels[0][i] == local.levels[1][i / 1024 * 256 + i % 512 / 2])
        );
    }
}
