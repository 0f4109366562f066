//! Classes of facets with similar slopes and heights, such as the tops, walls and bottoms of bricks.
//!
//! The moments of a class are linear in its facets, so a filter keeps them. One class is one Gaussian of slopes, as in the LEADR
//! paper. [`classes`] chooses the number of classes by the error of specular reflections.
//!
//! Slopes are per unit of texture coordinate, and heights are in the unit of the map.

use glam::{DMat3, DVec2, DVec3};
use leadr_reflectance::limits::at_least;
use leadr_reflectance::masking::classes::MOST_CLASSES;
use leadr_reflectance::random::Random;
use rayon::prelude::*;

use crate::{HeightMap, MomentLevel, Moments, Wrap};

/// The number of facets whose reflections are computed. Mixtures are fitted to one of every [`FIT_STEP`] of them.
const SAMPLES: usize = 8192;
const FIT_STEP: usize = 2;
/// The number of steps of a fit, and the number of fits from different starts.
const STEPS: usize = 60;
const STARTS: u64 = 3;
/// The variance that is added to slopes, and to heights relative to their variance, so that flat classes have a density.
const SLOPE_FLOOR: f64 = 2e-4;
const HEIGHT_FLOOR: f64 = 1e-3;
/// The slope variance of the base material at which reflections are compared, for a Beckmann roughness of 0.35.
const BASE: f64 = 0.5 * 0.35 * 0.35;
/// An error of the reflections that needs no further class, and the gain per class that justifies one.
const GOOD: f64 = 0.1;
const GAIN: f64 = 1.25;

/// The facets of a relief.
#[derive(Clone, Copy, Debug)]
pub enum Facets<'a> {
    /// The triangles between the texels of a height map. A texel can contain facets of several classes.
    OfHeights(&'a HeightMap, Wrap),
    /// The texels of the finest level of a [`LeadrMap`](crate::LeadrMap), for slopes of a normal map or of a baked file.
    OfTexels(&'a MomentLevel),
}

/// The mean slope and height of a facet, and the slope covariance in the facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub point: DVec3,
    pub spread: DVec3,
}

impl Facet {
    pub fn of_texel(texel: &Moments) -> Self {
        let [x, y] = texel.mean_slope.map(f64::from);
        Self { point: DVec3::new(x, y, texel.height.into()), spread: DVec3::from(texel.slope_covariance()) }
    }
}

/// A cell between four texels: slopes along its upper and lower edge, and along its left and right edge.
pub(crate) struct Cell {
    pub s: [f64; 2],
    pub t: [f64; 2],
    /// The heights of the upper and of the lower texels.
    heights: [[f64; 2]; 2],
}

impl Cell {
    pub fn new(heights: [[f32; 2]; 2], [width, height]: [f64; 2]) -> Self {
        let heights = heights.map(|row| row.map(f64::from));
        let [upper, lower] = heights;
        let along_t = |column: usize| (lower[column] - upper[column]) * height;
        Self { s: heights.map(|[left, right]| (right - left) * width), t: [along_t(0), along_t(1)], heights }
    }

    /// Returns the cells of a row, from the cell left of the first texel to the cell right of the last one. `y` is the row of the upper
    /// texels, and may be outside the map.
    pub fn row(map: &HeightMap, wrap: Wrap, y: i64) -> impl Iterator<Item = Self> {
        let width = map.width as usize;
        let row = |y: i64| &map.texels[wrap.texel(y, map.height) * width..][..width];
        let (upper, lower) = (row(y), row(y + 1));
        let size = [map.width, map.height].map(f64::from);
        let [before, after] = [-1, i64::from(map.width)].map(|x| wrap.texel(x, map.width));
        let column = move |x: usize| [upper[x], lower[x]];
        let columns = (0..width).chain([after]).map(column);
        columns.scan(column(before), move |left, right| {
            let cell = Self::new([[left[0], right[0]], [left[1], right[1]]], size);
            *left = right;
            Some(cell)
        })
    }

    /// Returns the triangle with its right angle at a corner: `row` 0 is above, `column` 0 is left.
    pub fn facet(&self, row: usize, column: usize) -> Facet {
        let at = |row: usize, column: usize| self.heights[row][column];
        let height = (at(row, column) + at(row, 1 - column) + at(1 - row, column)) / 3.0;
        Facet { point: DVec3::new(self.s[row], self.t[column], height), spread: DVec3::ZERO }
    }
}

impl Facets<'_> {
    /// Returns the width and the height of the map in texels.
    pub(crate) fn size(&self) -> [u32; 2] {
        match self {
            Self::OfHeights(map, _) => [map.width, map.height],
            Self::OfTexels(level) => [level.width, level.height],
        }
    }

    /// Returns about [`SAMPLES`] facets from all parts of the map.
    fn sampled(&self) -> Vec<Facet> {
        let [width, height] = self.size().map(|side| side as usize);
        let of_texel = if matches!(self, Self::OfHeights(..)) { 4 } else { 1 };
        let count = of_texel * width * height;
        // A stride without a common factor with the facets of a row reaches all columns.
        let stride = (count.div_ceil(SAMPLES).max(1)..).find(|stride| gcd(*stride, of_texel * width) == 1).unwrap_or(1);
        let facet = |i: usize| match self {
            Self::OfHeights(map, wrap) => {
                let texel = i / 4;
                let (x, y) = ((texel % width) as i64, (texel / width) as i64);
                let heights = [0, 1].map(|down| [0, 1].map(|right| map.beyond(x + right, y + down, *wrap)));
                Cell::new(heights, [map.width, map.height].map(f64::from)).facet(i / 2 % 2, i % 2)
            }
            Self::OfTexels(level) => Facet::of_texel(&level.texels[i]),
        };
        (0..count).step_by(stride).map(facet).collect()
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The classes of a relief, and a rule that assigns its facets to them.
#[derive(Clone, Debug)]
pub struct Classes {
    /// The relative RMS error of specular reflections at a base roughness of 0.35, without masking, for 1, 2, … classes. The list ends
    /// with the first number of classes that needs no further class, and has at most [`MOST_CLASSES`] entries.
    pub errors: Vec<f64>,
    parts: Vec<Part>,
    densities: Vec<Density>,
}

impl Classes {
    /// Returns the number of classes, from 1 to [`MOST_CLASSES`].
    pub fn count(&self) -> usize {
        self.densities.len()
    }

    /// Returns the class of a facet.
    pub(crate) fn of(&self, facet: &Facet) -> usize {
        nearest(&self.densities, facet)
    }

    /// Returns the mean slope and height of the sampled facets of each class, and the mean of their variances.
    pub(crate) fn centers(&self) -> (Vec<DVec3>, DVec3) {
        let variance = |part: &Part| {
            let c = part.covariance;
            part.share * DVec3::new(c.x_axis.x, c.y_axis.y, c.z_axis.z)
        };
        (self.parts.iter().map(|part| part.mean).collect(), self.parts.iter().map(variance).sum())
    }
}

/// A weighted Gaussian of slopes and heights.
#[derive(Clone, Copy, Debug)]
struct Part {
    share: f64,
    mean: DVec3,
    covariance: DMat3,
}

impl Part {
    /// Returns the logarithm of the weighted density.
    fn density(&self, floor: DVec3) -> Density {
        let covariance = self.covariance + DMat3::from_diagonal(floor);
        let inverse = covariance.inverse();
        Density {
            mean: self.mean,
            inverse,
            of_spread: DVec3::new(inverse.x_axis.x, inverse.y_axis.y, 2.0 * inverse.x_axis.y),
            constant: self.share.max(1e-300).ln() - 0.5 * covariance.determinant().max(1e-300).ln(),
        }
    }
}

/// The logarithm of the weighted density of a part.
#[derive(Clone, Copy, Debug)]
struct Density {
    mean: DVec3,
    inverse: DMat3,
    of_spread: DVec3,
    constant: f64,
}

impl Density {
    /// Returns the mean over the slopes of a facet.
    fn at(&self, facet: &Facet) -> f64 {
        let off = facet.point - self.mean;
        self.constant - 0.5 * (off.dot(self.inverse * off) + self.of_spread.dot(facet.spread))
    }
}

/// Sums over weighted facets.
#[derive(Clone, Copy, Debug)]
struct Sums {
    weight: f64,
    first: DVec3,
    second: DMat3,
    spread: DVec3,
}

impl Sums {
    const NONE: Self = Self { weight: 0.0, first: DVec3::ZERO, second: DMat3::ZERO, spread: DVec3::ZERO };

    fn add(&mut self, weight: f64, facet: &Facet) {
        self.weight += weight;
        self.first += weight * facet.point;
        self.second += outer(facet.point) * weight;
        self.spread += weight * facet.spread;
    }

    /// Returns the part of these facets among `all` facets.
    fn part(&self, all: usize) -> Part {
        let of_one = self.weight.max(1e-300).recip();
        let mean = self.first * of_one;
        let [xx, yy, xy] = (self.spread * of_one).to_array();
        let spread = DMat3::from_cols(DVec3::new(xx, xy, 0.0), DVec3::new(xy, yy, 0.0), DVec3::ZERO);
        Part { share: self.weight / all as f64, mean, covariance: self.second * of_one - outer(mean) + spread }
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Finds the classes of a relief. `scale` converts slopes along `s` and `t` to rise over run: for an object, the height factor divided
/// by the width and by the height of the texture. The result does not depend on the number of threads.
pub fn classes(facets: Facets<'_>, scale: [f64; 2]) -> Classes {
    let sampled = facets.sampled();
    let whole = parts(&sampled, 1, |_| 0)[0];
    let squares = DVec2::from(scale.map(|scale| at_least(scale.abs(), 1e-9).powi(-2)));
    let floor = (SLOPE_FLOOR * squares).extend(HEIGHT_FLOOR * at_least(whole.covariance.z_axis.z, 1e-20));
    let truth = Truth::new(&sampled, squares);
    let fit_to: Vec<Facet> = sampled.iter().step_by(FIT_STEP).copied().collect();
    let (mut fits, mut errors) = (Vec::new(), Vec::new());
    for count in 1..=MOST_CLASSES {
        let densities: Vec<_> = fitted(&fit_to, count, whole, floor).iter().map(|part| part.density(floor)).collect();
        let parts = parts(&sampled, count, |facet| nearest(&densities, facet));
        errors.push(truth.error(&parts));
        fits.push((parts, densities));
        if errors[count - 1] <= GOOD {
            break;
        }
    }
    let cost = |i: &usize| errors[*i].max(GOOD) * GAIN.powi(*i as i32);
    let best = (0..errors.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
    let (parts, densities) = fits.swap_remove(best);
    Classes { errors, parts, densities }
}

/// Returns the parts of facets whose classes are given.
fn parts(facets: &[Facet], count: usize, class_of: impl Fn(&Facet) -> usize) -> Vec<Part> {
    let mut sums = vec![Sums::NONE; count];
    facets.iter().for_each(|facet| sums[class_of(facet)].add(1.0, facet));
    sums.iter().map(|sum| sum.part(facets.len())).collect()
}

/// Returns the part with the largest density at a facet.
fn nearest(densities: &[Density], facet: &Facet) -> usize {
    let mut best = (f64::NEG_INFINITY, 0);
    for (i, density) in densities.iter().enumerate() {
        let density = density.at(facet);
        if density > best.0 {
            best = (density, i);
        }
    }
    best.1
}

/// Fits a mixture by expectation maximisation, from several starts.
fn fitted(facets: &[Facet], count: usize, whole: Part, floor: DVec3) -> Vec<Part> {
    if count == 1 {
        return vec![whole];
    }
    let fits = (0..STARTS).into_par_iter().map(|start| {
        let mut parts = started(facets, count, whole, &mut Random::stream(start, count as u64));
        let mut likelihood = f64::MIN;
        for _ in 0..STEPS {
            let densities: Vec<_> = parts.iter().map(|part| part.density(floor)).collect();
            let mut sums = [Sums::NONE; MOST_CLASSES];
            let mut all = 0.0;
            for facet in facets {
                let mut logs = [f64::NEG_INFINITY; MOST_CLASSES];
                logs.iter_mut().zip(&densities).for_each(|(log, density)| *log = density.at(facet));
                let most = logs.iter().copied().fold(f64::MIN, f64::max);
                let weights = logs.map(|log| (log - most).exp());
                let whole: f64 = weights.iter().sum();
                all += most + whole.ln();
                // Tiny weights change nothing.
                sums.iter_mut()
                    .zip(weights)
                    .filter(|(_, weight)| *weight > 1e-9)
                    .for_each(|(sum, weight)| sum.add(weight / whole, facet));
            }
            parts = sums[..count].iter().map(|sum| sum.part(facets.len())).collect();
            if all - likelihood < 1e-5 * facets.len() as f64 {
                break;
            }
            likelihood = all;
        }
        (likelihood, parts)
    });
    let best = fits.collect::<Vec<_>>().into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Vec::new, |(_, parts)| parts)
}

/// Returns parts around facets that are far from each other (k-means++).
fn started(facets: &[Facet], count: usize, whole: Part, random: &mut Random) -> Vec<Part> {
    let deviations = DVec3::new(whole.covariance.x_axis.x, whole.covariance.y_axis.y, whole.covariance.z_axis.z);
    let unit = deviations.max(DVec3::splat(1e-20)).map(f64::sqrt);
    let mut centres = vec![facets[(random.unit() * facets.len() as f64) as usize % facets.len()].point];
    let mut squares = vec![f64::MAX; facets.len()];
    while centres.len() < count {
        let newest = centres[centres.len() - 1];
        for (square, facet) in squares.iter_mut().zip(facets) {
            *square = square.min(((facet.point - newest) / unit).length_squared());
        }
        let mut left = random.unit() * squares.iter().sum::<f64>();
        let next = squares.iter().position(|square| {
            left -= square;
            left <= 0.0
        });
        centres.push(facets[next.unwrap_or(0)].point);
    }
    let covariance = whole.covariance * (0.5 / count as f64);
    centres.into_iter().map(|mean| Part { share: 1.0 / count as f64, mean, covariance }).collect()
}

/// Returns slopes of half vectors between twelve directions of light and five of view, and the factor from the density of slopes there
/// to a specular reflection.
fn half_vectors() -> impl Iterator<Item = (DVec2, f64)> {
    let direction = |polar: f64, azimuth: f64| {
        let ((sin, cos), (y, x)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        DVec3::new(sin * x, sin * y, cos)
    };
    let views = [(0.0, 0.0), (45.0, -50.0), (45.0, 70.0), (70.0, -50.0), (70.0, 160.0)];
    let lights =
        [25.0, 50.0, 70.0].into_iter().flat_map(|polar| [25.0, 115.0, 205.0, 295.0].map(|azimuth| (polar, azimuth)));
    lights.flat_map(move |light| {
        views.map(|view| {
            let (light, view) = (direction(light.0, light.1), direction(view.0, view.1));
            let half = (light + view).normalize();
            (half.truncate() / -half.z, half.z.powi(-4) / view.z)
        })
    })
}

/// Specular reflections of facets, filtered by the base material.
struct Truth {
    base: DVec2,
    half_vectors: Vec<(DVec2, f64)>,
    reflections: Vec<f64>,
}

impl Truth {
    fn new(facets: &[Facet], squares: DVec2) -> Self {
        let share = 1.0 / facets.len() as f64;
        let base = BASE * squares;
        let lobes: Vec<Lobe> =
            facets.iter().map(|facet| Lobe::new(share, facet.point.truncate(), facet.spread, base)).collect();
        let half_vectors: Vec<_> = half_vectors().map(|(at, factor)| (at * squares.map(f64::sqrt), factor)).collect();
        let reflections = half_vectors.par_iter().map(|half_vector| reflection(&lobes, half_vector)).collect();
        Self { base, half_vectors, reflections }
    }

    /// Returns the relative RMS difference of the reflections of parts.
    fn error(&self, parts: &[Part]) -> f64 {
        let lobe = |part: &Part| {
            let c = part.covariance;
            Lobe::new(part.share, part.mean.truncate(), DVec3::new(c.x_axis.x, c.y_axis.y, c.x_axis.y), self.base)
        };
        let lobes: Vec<Lobe> = parts.iter().map(lobe).collect();
        let (mut difference, mut square) = (0.0, 0.0);
        for (half_vector, truth) in self.half_vectors.iter().zip(&self.reflections) {
            difference += (truth - reflection(&lobes, half_vector)).powi(2);
            square += truth * truth;
        }
        (difference / square.max(1e-300)).sqrt()
    }
}

fn reflection(lobes: &[Lobe], &(at, factor): &(DVec2, f64)) -> f64 {
    factor * lobes.iter().map(|lobe| lobe.density(at)).sum::<f64>()
}

/// A Gaussian of slopes, filtered by the base material.
struct Lobe {
    mean: DVec2,
    /// The coefficients of the squares and of the product of the deviations in the exponent.
    exponent: DVec3,
    factor: f64,
}

impl Lobe {
    fn new(share: f64, mean: DVec2, covariance: DVec3, base: DVec2) -> Self {
        let (xx, yy, xy) = (covariance.x + base.x, covariance.y + base.y, covariance.z);
        let det = (xx * yy - xy * xy).max(1e-300);
        Self { mean, exponent: DVec3::new(-0.5 * yy, -0.5 * xx, xy) / det, factor: share / det.sqrt() }
    }

    fn density(&self, at: DVec2) -> f64 {
        let d = at - self.mean;
        self.factor * self.exponent.dot(DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ClassMap, procedural};

    fn of(size: u32, height: impl Fn(f64, f64) -> f64) -> (Classes, ClassMap) {
        let at = |i: u32| (f64::from(i % size) / f64::from(size), f64::from(i / size) / f64::from(size));
        let texels = (0..size * size).map(|i| height(at(i).0, at(i).1) as f32).collect();
        let map = HeightMap { width: size, height: size, texels };
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let classes = classes(facets, [1.0; 2]);
        let map = ClassMap::new(facets, &classes);
        (classes, map)
    }

    #[test]
    fn noise_is_one_class() {
        let rock = procedural::fbm(128, 128, 3, 8, 4, 0.5);
        let facets = Facets::OfHeights(&rock, Wrap::Repeat);
        let found = classes(facets, [0.1; 2]);
        assert_eq!(found.count(), 1, "{:?}", found.errors);
        let mean = ClassMap::new(facets, &found).mean();
        assert!(mean[0].share == 1.0 && mean[0].mean.length() < 1e-3, "{mean:?}");
    }

    #[test]
    fn grooves_are_classes() {
        // Grooves across x: ground, two walls and tops in equal parts, with slopes of 0, 2, -2 and 0.
        let (found, map) = of(64, |x, _| 0.5 * (4.0 * (x - 0.5).abs() - 0.5).clamp(0.0, 1.0));
        let errors = &found.errors;
        assert!(errors[0] > 0.5 && errors[found.count() - 1] < 0.1, "{errors:?}");
        // Each class has a single slope, also in texels on the edge of a wall.
        for class in map.mean() {
            assert!(class.share > 0.2 && class.covariance.x < 1e-3, "{class:?}");
        }
        for (at, _) in map.levels[0].layers[0].iter().enumerate() {
            assert_eq!(map.classes_of_texel(0, at), map.classes_of_texel(0, at % 64), "rows are equal");
        }
    }

    #[test]
    fn slopes_without_heights_have_classes() {
        // Two kinds of texels: flat, or steep in the manner of a normal map.
        let texel = |i: u32| {
            let x = if i % 4 == 0 { 2.0 } else { 0.0 };
            Moments { mean_slope: [x, 0.0], second: [x * x, 0.0], ..Moments::default() }
        };
        let level = MomentLevel { width: 64, height: 64, texels: (0..4096).map(texel).collect() };
        let facets = Facets::OfTexels(&level);
        let found = classes(facets, [1.0; 2]);
        let mut mean = ClassMap::new(facets, &found).mean();
        mean.sort_by(|a, b| a.share.total_cmp(&b.share));
        assert!(mean.len() == 2 && mean[0].share == 0.25 && (mean[0].mean.x - 2.0).abs() < 1e-3, "{mean:?}");
    }

    #[test]
    fn a_flat_map_is_one_class() {
        let (found, map) = of(16, |_, _| 0.25);
        let mean = map.mean();
        assert!(found.count() == 1 && mean[0].covariance.length() < 1e-12, "{mean:?} {:?}", found.errors);
        assert!((mean[0].height - 0.25).abs() < 1e-6);
    }
}
