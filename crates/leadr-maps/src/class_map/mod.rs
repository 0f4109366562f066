//! Slope and height moments per class of facets, with all mip levels.
//!
//! A texel holds the weight of each class, and its weighted moments. All values are linear, so every filter of a texture keeps
//! them. The sums over the classes are the moments of a [`LeadrMap`].
//!
//! Values are 16-bit floats. Each class has its own centre, so the variance of a narrow class is not the difference of two large
//! numbers.
//!
//! [`LeadrMap`]: crate::LeadrMap

mod colors;
mod stored;

use std::ops::Range;

use glam::{DVec2, DVec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use leadr_reflectance::limits::{at_least, within};
use leadr_reflectance::masking::classes::Class;
use rayon::prelude::*;

pub use colors::ClassColors;

use crate::derive::{CORNERS, Cell, ClassMaterial, Classes, Facet, Facets, MaterialAt};
use crate::pyramid::{Pyramid, Row, level_sizes};
use crate::{HeightMap, Moments, Wrap};

/// The source code that determines classes, class maps and their openness, as part of cache keys.
pub const CLASS_SOURCES: [&str; 13] = [
    include_str!("mod.rs"),
    include_str!("colors.rs"),
    include_str!("stored.rs"),
    include_str!("../derive/classes/mod.rs"),
    include_str!("../derive/classes/axes.rs"),
    include_str!("../derive/classes/facets.rs"),
    include_str!("../derive/classes/mixture.rs"),
    include_str!("../derive/classes/reflections.rs"),
    include_str!("../derive/classes/search.rs"),
    include_str!("../derive/openness.rs"),
    include_str!("../derive/local_openness.rs"),
    include_str!("../moments.rs"),
    include_str!("../pyramid.rs"),
];

/// The number of rows that are filtered together.
const BAND: u32 = 64;
/// The largest deviation from a class centre, in units. Its square is below the maximum of 16-bit floats.
const MOST_UNITS: f64 = 200.0;
/// The smallest ratio of the units of the two slopes.
const LEAST_RATIO: f64 = 0.25;
/// The largest 16-bit float.
const MOST: f32 = 65504.0;

/// The moments of each class of texels.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassMap {
    /// The centre of each class: the slopes per unit of texture coordinate `s` and `t`, and the height in the unit of the map.
    pub centers: Vec<[f32; 3]>,
    /// The units of the stored values: slope `s`, slope `t`, height. All are positive.
    pub units: [f32; 3],
    /// The mip levels, with the sizes of the levels of a [`LeadrMap`](crate::LeadrMap). Level 0 comes first.
    pub levels: Vec<ClassLevel>,
}

/// A mip level of a [`ClassMap`].
#[derive(Clone, Debug, PartialEq)]
pub struct ClassLevel {
    /// The width in texels.
    pub width: u32,
    /// The height in texels.
    pub height: u32,
    /// Two layers of row-major texels per class. Layer `2k` holds `(w, w x, w y, w z)`, and layer `2k + 1` holds
    /// `(w xx, w yy, w xy, w zz)`. `w` is the share of class `k` in the texel. `x`, `y` and `z` are the deviations of the slopes and of
    /// the height from the centre, in units. Double letters are their second moments.
    pub layers: Vec<Vec<[f16; 4]>>,
}

impl ClassMap {
    /// Creates the map. The classes must be those of the facets and of the material. The result does not depend on the number of
    /// threads.
    pub fn new(facets: Facets<'_>, classes: &Classes, material: Option<&ClassMaterial<'_>>) -> Self {
        Self::in_frame(facets, classes, material, ClassFrame::new(facets, classes), 0)
    }

    /// Creates the map of an atlas, whose tiles lie in different directions. The slopes of all classes are about zero and in one unit, so
    /// they can be rotated. The `skipped` finest levels are left out.
    pub fn of_tiles(
        facets: Facets<'_>,
        classes: &Classes,
        material: Option<&ClassMaterial<'_>>,
        skipped: usize,
    ) -> Self {
        Self::in_frame(facets, classes, material, ClassFrame::new(facets, classes).about_zero(classes), skipped)
    }

    fn in_frame(
        facets: Facets<'_>,
        classes: &Classes,
        material: Option<&ClassMaterial<'_>>,
        frame: ClassFrame,
        skipped: usize,
    ) -> Self {
        let source = ClassRows::new(facets, classes, material, &frame);
        let levels = filtered(source.size, 2 * classes.count(), skipped, |rows| source.rows(rows));
        Self { centers: frame.centers, units: frame.units, levels }
    }

    /// Returns the number of classes.
    pub fn count(&self) -> usize {
        self.centers.len()
    }

    /// Returns the classes of the whole map, from the smallest level.
    pub fn mean(&self) -> Vec<Class> {
        self.classes_of_texel(self.levels.len() - 1, 0)
    }

    /// Returns the classes in a texel of a level: slopes per unit of texture coordinate, and heights in the unit of the map. A class
    /// with share 0 is at its centre.
    ///
    /// # Panics
    /// Panics if the level or the texel does not exist.
    pub fn classes_of_texel(&self, level: usize, texel: usize) -> Vec<Class> {
        let layers = &self.levels[level].layers;
        let unit = DVec3::from(self.units.map(f64::from));
        let class = |(k, center): (usize, &[f32; 3])| {
            let [first, second] = [2 * k, 2 * k + 1].map(|layer| layers[layer][texel].map(f64::from));
            let share = first[0];
            let part = at_least(share, f64::MIN_POSITIVE).recip();
            let [x, y, z] = [1, 2, 3].map(|i| first[i] * part);
            let [xx, yy, xy, zz] = second.map(|v| v * part);
            let (xx, yy, zz) = (at_least(xx - x * x, 0.0), at_least(yy - y * y, 0.0), at_least(zz - z * z, 0.0));
            let xy = within(xy - x * y, (xx * yy).sqrt());
            let mean = DVec3::from(center.map(f64::from)) + unit * DVec3::new(x, y, z);
            Class {
                share,
                mean: mean.truncate(),
                covariance: DVec3::new(xx, yy, xy) * DVec3::new(unit.x * unit.x, unit.y * unit.y, unit.x * unit.y),
                height: mean.z,
                height_variance: zz * unit.z * unit.z,
            }
        };
        self.centers.iter().enumerate().map(class).collect()
    }
}

/// Filters rows of layers of four channels into all levels from `skipped`. `rows` makes rows of the finest level.
fn filtered(size: [u32; 2], layers: usize, skipped: usize, rows: impl Fn(Range<u32>) -> Vec<Row>) -> Vec<ClassLevel> {
    let empty = |[width, height]: [u32; 2]| {
        let layer = || Vec::with_capacity(width as usize * height as usize);
        ClassLevel { width, height, layers: (0..layers).map(|_| layer()).collect() }
    };
    let mut levels: Vec<ClassLevel> = level_sizes(size).into_iter().skip(skipped).map(empty).collect();
    let mut pyramid = Pyramid::new(size, 4 * layers);
    for first in (0..size[1]).step_by(BAND as usize) {
        let band = rows(first..size[1].min(first + BAND));
        let pushed = pyramid.push(band, &mut |level, _, rows| {
            let Some(level) = level.checked_sub(skipped).and_then(|level| levels.get_mut(level)) else {
                return Ok(());
            };
            let half = |row: &Row| {
                let row: Vec<f32> = row.iter().map(|v| v.clamp(-MOST, MOST)).collect();
                let mut halves = vec![f16::ZERO; row.len()];
                halves.convert_from_f32_slice(&row);
                halves
            };
            let rows: Vec<Vec<f16>> = rows.par_iter().map(half).collect();
            level.layers.par_iter_mut().enumerate().for_each(|(layer, texels)| {
                texels.extend(rows.iter().flat_map(|row| row.as_chunks().0.iter().skip(layer).step_by(layers)));
            });
            Ok(())
        });
        pushed.expect("the callback never fails");
    }
    levels
}

/// The centres of the classes and the units of a [`ClassMap`].
#[derive(Clone, Debug, PartialEq)]
pub struct ClassFrame {
    /// The centre of each class ([`ClassMap::centers`]).
    pub centers: Vec<[f32; 3]>,
    /// The units of the stored values ([`ClassMap::units`]).
    pub units: [f32; 3],
}

/// The finest level of a [`ClassMap`].
pub(crate) struct ClassRows<'a> {
    facets: Facets<'a>,
    classes: &'a Classes,
    material: MaterialAt<'a>,
    size: [u32; 2],
    centers: Vec<DVec3>,
    /// The reciprocals of the units.
    by: DVec3,
}

impl<'a> ClassRows<'a> {
    pub fn new(
        facets: Facets<'a>,
        classes: &'a Classes,
        material: Option<&'a ClassMaterial<'a>>,
        frame: &ClassFrame,
    ) -> Self {
        let wide = |v: &[f32; 3]| DVec3::from(v.map(f64::from));
        Self {
            facets,
            classes,
            material: classes.material(material),
            size: facets.size(material),
            centers: frame.centers.iter().map(wide).collect(),
            by: wide(&frame.units).recip(),
        }
    }

    /// Returns rows of the finest level. The eight values of each class follow each other in the order of the layers.
    pub fn rows(&self, rows: Range<u32>) -> Vec<Row> {
        let (centers, by) = (&self.centers, self.by);
        let count = centers.len();
        let row_of = |sums: Vec<Sums>| -> Row {
            let mut row = vec![0.0; 8 * sums.len()];
            for (i, (sums, values)) in sums.iter().zip(row.as_chunks_mut().0).enumerate() {
                if sums.weight > 0.0 {
                    *values = sums.about(centers[i % count], by);
                }
            }
            row
        };
        if let Facets::OfHeights(map, wrap) = self.facets {
            return self.rows_of_heights(map, wrap, rows).into_par_iter().map(row_of).collect();
        }
        let [width, height] = self.size;
        let row = |y: u32| {
            let mut sums = vec![Sums::default(); width as usize * count];
            for (x, sums) in (0..width).zip(sums.chunks_exact_mut(count)) {
                let texel = match self.facets {
                    Facets::OfTexels(level, _) => level.texels[(y * width + x) as usize],
                    _ => Moments::default(),
                };
                let [s, t] = texel.mean_slope.map(f64::from);
                let [ss, tt] = texel.second.map(f64::from);
                let st = f64::from(texel.cross);
                let facet = Facet::of_texel(&texel);
                let mut add = |weight: f64, material: DVec2| {
                    let sums = &mut sums[self.classes.of(&Facet { material, ..facet })];
                    sums.add(weight, [s, t, ss, tt, st]);
                    sums.height = facet.point.z;
                };
                if self.material.varies() {
                    for [below, right] in CORNERS {
                        add(0.25, self.material.at([quarter(x, right, width), quarter(y, below, height)]));
                    }
                } else {
                    add(1.0, DVec2::ZERO);
                }
            }
            row_of(sums)
        };
        rows.into_par_iter().map(row).collect()
    }

    /// Returns the sums of each class in each texel of rows.
    fn rows_of_heights(&self, map: &HeightMap, wrap: Wrap, rows: Range<u32>) -> Vec<Vec<Sums>> {
        let first = i64::from(rows.start) - 1;
        // The classes of the four triangles of each cell, from the cell above and left of the first texel. They are not used if the
        // classes of the quarters of a cell can differ.
        let cells = (first..i64::from(rows.end)).into_par_iter().map(|y| {
            let class = |cell: &Cell, edge| self.classes.of(&cell.facet(edge));
            let of_cell = |cell: Cell| {
                let classes = if self.material.varies() { [0; 4] } else { [0, 1, 2, 3].map(|edge| class(&cell, edge)) };
                (cell, classes.map(|class| class as u8))
            };
            Cell::row(map, wrap, y).map(of_cell).collect()
        });
        let cells: Vec<Vec<(Cell, [u8; 4])>> = cells.collect();
        let (count, varies) = (self.classes.count(), self.material.varies());
        let row = |y: u32| {
            let width = map.width as usize;
            let mut sums = vec![Sums::default(); width * count];
            let above = (i64::from(y) - 1 - first) as usize;
            for (x, sums) in sums.chunks_exact_mut(count).enumerate() {
                for [below, right] in CORNERS {
                    let (cell, of_cell) = &cells[above + below][x + right];
                    let material = varies.then(|| {
                        self.material.at([quarter(x as u32, right, map.width), quarter(y, below, map.height)])
                    });
                    for edge in Cell::of_quarter([1 - below, 1 - right]) {
                        let facet = cell.facet(edge);
                        let class = match material {
                            Some(material) => self.classes.of(&Facet { material, ..facet }),
                            None => usize::from(of_cell[edge]),
                        };
                        let DVec3 { x: s, y: t, .. } = facet.point;
                        sums[class].add(0.125, [s, t, s * s, t * t, s * t]);
                    }
                }
                let height = f64::from(map.texels[y as usize * width + x]);
                sums.iter_mut().for_each(|sums| sums.height = height);
            }
            sums
        };
        rows.into_par_iter().map(row).collect()
    }
}

/// Returns the texture coordinate of the centre of the first or second half of a texel.
fn quarter(texel: u32, second: usize, side: u32) -> f64 {
    (f64::from(texel) + 0.25 + 0.5 * second as f64) / f64::from(side)
}

/// Sums over the facets of a class in a texel, which has one height.
#[derive(Clone, Copy, Default)]
struct Sums {
    weight: f64,
    /// Weighted `x`, `y`, `xx`, `yy` and `xy`.
    slopes: [f64; 5],
    height: f64,
}

impl Sums {
    #[inline]
    fn add(&mut self, weight: f64, values: [f64; 5]) {
        self.weight += weight;
        self.slopes.iter_mut().zip(values).for_each(|(sum, v)| *sum += weight * v);
    }

    /// Returns the weighted moments about a centre, in the order of the layers. `by` has the reciprocal units.
    fn about(&self, center: DVec3, by: DVec3) -> [f32; 8] {
        let (weight, [x, y, xx, yy, xy]) = (self.weight, self.slopes);
        let z = (self.height - center.z) * by.z;
        let square = |second: f64, first: f64, center: f64, by: f64| {
            at_least(second - center * (2.0 * first - center * weight), 0.0) * (by * by)
        };
        let values = [
            weight,
            (x - weight * center.x) * by.x,
            (y - weight * center.y) * by.y,
            weight * z,
            square(xx, x, center.x, by.x),
            square(yy, y, center.y, by.y),
            (xy - center.x * y - center.y * x + weight * center.x * center.y) * (by.x * by.y),
            weight * z * z,
        ];
        values.map(|v| v as f32)
    }
}

impl ClassFrame {
    /// Returns the centres and units of these classes. The unit of an axis is the RMS deviation from the centres. It is larger if a single facet deviates so much that its square exceeds
    /// the range of 16-bit floats.
    pub(crate) fn new(facets: Facets<'_>, classes: &Classes) -> Self {
        let (centers, square) = classes.centers();
        let most_of_row = |y: u32| match facets {
            Facets::OfHeights(map, wrap) => {
                let heights = &map.texels[y as usize * map.width as usize..][..map.width as usize];
                let most = heights.iter().fold(0.0, |most, h| h.abs().max(most));
                let steepest = Cell::row(map, wrap, y.into())
                    .fold(DVec2::ZERO, |most, cell| most.max(DVec2::new(cell.s[0].abs(), cell.t[1].abs())));
                steepest.extend(most.into())
            }
            Facets::OfTexels(level, _) => {
                let texels = &level.texels[y as usize * level.width as usize..][..level.width as usize];
                texels.iter().fold(DVec3::ZERO, |most, texel| {
                    let [xx, yy] = texel.second.map(|v| f64::from(v).sqrt());
                    most.max(DVec3::new(xx, yy, f64::from(texel.height).abs()))
                })
            }
            Facets::Flat => DVec3::ZERO,
        };
        let most = (0..facets.size(None)[1]).into_par_iter().map(most_of_row).reduce(|| DVec3::ZERO, DVec3::max);
        let most = most + centers.iter().fold(DVec3::ZERO, |most, center| most.max(center.abs()));
        let unit = |square: f64, most: f64| {
            let unit = at_least(square, 0.0).sqrt().max(most / MOST_UNITS) as f32;
            if unit > 1e-30 { unit } else { 1.0 }
        };
        // Azimuths in these units are not far from those of the map, even if only one slope varies.
        let least = LEAST_RATIO * LEAST_RATIO * square.x.max(square.y);
        let slope = |square: f64, most: f64| unit(square.max(least), most);
        let units = [slope(square.x, most.x), slope(square.y, most.y), unit(square.z, most.z)];
        Self { centers: centers.into_iter().map(|center| center.as_vec3().into()).collect(), units }
    }

    /// Moves the slopes of all centres to zero, and makes the units of both slopes equal.
    fn about_zero(self, classes: &Classes) -> Self {
        let square = |class: &Class| class.share * (class.covariance.truncate() + class.mean * class.mean);
        let squares: DVec2 = classes.sampled([1.0; 2]).iter().map(square).sum();
        let [s, t, h] = self.units;
        let unit = s.max(t).max(squares.max_element().sqrt() as f32);
        Self { centers: self.centers.iter().map(|[_, _, z]| [0.0, 0.0, *z]).collect(), units: [unit, unit, h] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::classes;
    use crate::{LeadrMap, MomentLevel, procedural};

    /// Returns the moments of all classes, in the order of [`Moments`].
    fn joined(classes: &[Class]) -> [f64; 7] {
        let mut sums = [0.0; 7];
        for c in classes {
            let values = [
                1.0,
                c.mean.x,
                c.mean.y,
                c.covariance.x + c.mean.x * c.mean.x,
                c.covariance.y + c.mean.y * c.mean.y,
                c.covariance.z + c.mean.x * c.mean.y,
                c.height,
            ];
            sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += c.share * v);
        }
        sums
    }

    /// Returns ramps between two plateaus, with ripples, and their facets' classes.
    fn ramps(width: u32, height: u32) -> HeightMap {
        let mut map = procedural::fbm(width, height, 3, 4, 3, 0.5);
        map.texels.iter_mut().for_each(|h| *h = (4.0 * *h - 1.5).clamp(0.0, 1.0) + 0.05 * *h);
        map
    }

    #[test]
    fn sums_over_classes_are_leadr_moments_on_every_level() {
        for (width, height, wrap) in [
            (64, 64, Wrap::Repeat),
            (37, 23, Wrap::Repeat),
            (40, 9, Wrap::Clamp),
            (1, 19, Wrap::Clamp),
            (1, 1, Wrap::Repeat),
        ] {
            let relief = ramps(width, height);
            let leadr = LeadrMap::new(&relief, wrap);
            for facets in [Facets::OfHeights(&relief, wrap), Facets::OfTexels(&leadr.levels[0], wrap)] {
                let found = classes(facets, [1.0; 2], None);
                assert!(width < 64 || found.count() > 1, "{:?}", found.errors);
                let map = ClassMap::new(facets, &found, None);
                assert_eq!(map.levels.len(), leadr.levels.len());
                let steepest = leadr.levels[0].texels.iter().flat_map(|t| t.second).fold(0.0, f32::max).sqrt();
                let steepest = f64::from(steepest).max(1e-6);
                for (i, level) in leadr.levels.iter().enumerate() {
                    assert_eq!([map.levels[i].width, map.levels[i].height], [level.width, level.height]);
                    for (at, texel) in level.texels.iter().enumerate() {
                        let [share, x, y, xx, yy, xy, z] = joined(&map.classes_of_texel(i, at));
                        let errors = [
                            share - 1.0,
                            (x - f64::from(texel.mean_slope[0])) / steepest,
                            (y - f64::from(texel.mean_slope[1])) / steepest,
                            (xx - f64::from(texel.second[0])) / (steepest * steepest),
                            (yy - f64::from(texel.second[1])) / (steepest * steepest),
                            (xy - f64::from(texel.cross)) / (steepest * steepest),
                            z - f64::from(texel.height),
                        ];
                        let worst = errors.into_iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
                        assert!(worst < 1e-3, "{width}x{height} {wrap:?} level {i} texel {at}: {errors:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn narrow_classes_keep_their_variance() {
        // The ground is nearly flat, and a ramp has a slope of 40 with a fine ripple.
        let height = |i: u32| {
            let x = i % 256;
            let ripple = 0.02 * (std::f32::consts::TAU * x as f32 / 8.0).sin();
            if x < 192 { 0.02 * ripple } else { 40.0 * (x - 192) as f32 / 256.0 + ripple }
        };
        let relief = HeightMap { width: 256, height: 4, texels: (0..1024).map(height).collect() };
        let leadr = LeadrMap::new(&relief, Wrap::Clamp);
        let facets = Facets::OfHeights(&relief, Wrap::Clamp);
        let map = ClassMap::new(facets, &classes(facets, [1.0; 2], None), None);
        // Sixteen texels in the middle of each part.
        for texel in [6, 14] {
            let truth = leadr.levels[4].texels[texel];
            let [xx, ..] = truth.slope_covariance();
            let [share, x, _, second, ..] = joined(&map.classes_of_texel(4, texel));
            let mean = f64::from(truth.mean_slope[0]);
            assert!((share - 1.0).abs() < 1e-3 && (x - mean).abs() < 2e-3 * mean.abs().max(1.0), "{x} {mean}");
            let variance = second - x * x;
            assert!(xx > 1e-3 && (variance / xx - 1.0).abs() < 0.02, "{texel}: {variance} of {xx}");
        }
    }

    #[test]
    fn threads_and_extreme_heights_are_harmless() {
        let relief = ramps(64, 32);
        let facets = Facets::OfHeights(&relief, Wrap::Repeat);
        let map = || ClassMap::new(facets, &classes(facets, [1.0; 2], None), None);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(map(), one.install(map));

        for (low, high) in [(0.0, 0.0), (-1e12, 1e12), (1e-30, 2e-30), (1e12, 1e12)] {
            let texels = (0..64).map(|i| if i == 9 { high } else { low }).collect();
            let spike = HeightMap { width: 8, height: 8, texels };
            let level = MomentLevel::of_heights(&spike, Wrap::Repeat);
            for facets in [Facets::OfHeights(&spike, Wrap::Repeat), Facets::OfTexels(&level, Wrap::Repeat)] {
                for scale in [0.0, 1.0, -1e6] {
                    let map = ClassMap::new(facets, &classes(facets, [scale; 2], None), None);
                    let values = map.levels.iter().flat_map(|level| level.layers.iter().flatten().flatten());
                    assert!(values.into_iter().all(|v| v.is_finite()), "{low} {high} {scale}");
                    let share: f64 = map.mean().iter().map(|class| class.share).sum();
                    assert!((share - 1.0).abs() < 1e-3, "{low} {high} {scale}: {share}");
                }
            }
        }
    }
}
