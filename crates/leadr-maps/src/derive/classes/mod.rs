//! Classes of facets with similar slopes, heights and materials, such as the tops, walls and bottoms of bricks.
//!
//! The moments of a class are linear in its facets, so a filter keeps them. One class is one Gaussian of slopes, as in the LEADR
//! paper. [`classes`] divides the facets into many small parts, and tries every way to join these to classes. The best way has the
//! smallest error of what the renderer reflects. Within a class, colour and roughness do not depend on the relief. Where they do, or if
//! a material has two roughnesses, they separate classes, too.
//!
//! Slopes are per unit of texture coordinate, and heights are in the unit of the map.

mod axes;
mod facets;
mod mixture;
mod reflections;
mod search;

use glam::{DVec2, DVec3};
use leadr_reflectance::limits::at_least;
use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};
use rayon::prelude::*;

pub(crate) use facets::{CORNERS, Cell, Facet, FacetsAt, MaterialAt};
pub use facets::{ClassMaterial, Facets};

use super::openness::{Field, OpennessWindow};
use axes::{ColorSums, MaterialAxes, change_within, color_axis, double_ranks};
use facets::{Sample, sampled_of_windows};
use mixture::{Density, MOST_PARTS, Part, fitted, nearest, parts};
use reflections::{Light, Reflections};
use search::for_each_division;

/// The number of facets that are compared.
const SAMPLES: usize = 4096;
/// The variance that is added to slopes, and to heights relative to their variance, so that flat classes have a density.
const SLOPE_FLOOR: f64 = 2e-4;
const HEIGHT_FLOOR: f64 = 1e-3;
/// An error that needs no further class, and the gain per class that justifies one.
const GOOD: f64 = 0.07;
const GAIN: f64 = 4.0 / 3.0;
/// The share of the peak of a highlight whose loss needs roughness as a coordinate.
const LOST: f64 = 0.25;
/// The smallest `α²` in this comparison, relative to the mean. A few smooth texels would otherwise decide alone.
const LEAST_SQUARE: f64 = 0.08;
/// The largest change of the mean colour that needs no further class, relative to the mean of the brightest channel. The value is half
/// the smallest difference that is visible side by side. The change is from no hidden facets to half of the facets hidden, or for a
/// shift of the slopes by one standard deviation.
const LEAST_CHANGE: f64 = 0.01;

/// The classes of a relief, and a rule that assigns its facets to them.
#[derive(Clone, Debug)]
pub struct Classes {
    /// The error for 1, 2, … classes: the relative RMS error of reflections at a base roughness of 0.35, where an error of the diffuse
    /// reflection counts three times. Colours that follow the relief by more than 1 % within the classes add seven times their change,
    /// and roughnesses that differ add the part of the highlight that the classes lose. The list ends with the first number of classes
    /// that needs no further class, and has at most [`MOST_CLASSES`] entries.
    pub errors: Vec<f64>,
    axes: MaterialAxes,
    classes: Vec<Part>,
    /// The parts that are joined to classes, and the class of each.
    parts: Vec<Density>,
    class_of_part: Vec<usize>,
}

impl Classes {
    /// Returns the number of classes, from 1 to [`MOST_CLASSES`].
    pub fn count(&self) -> usize {
        self.classes.len()
    }

    /// Returns the class of a facet of the relief with a slope per texture coordinate and a height, without its material.
    pub fn of_relief(&self, slope: DVec2, height: f64) -> usize {
        self.of(&Facet { point: slope.extend(height), ..Facet::default() })
    }

    /// Returns the class of a facet.
    pub(crate) fn of(&self, facet: &Facet) -> usize {
        self.class_of_part[nearest(&self.parts, facet)]
    }

    /// Returns the rule that gives the material of facets for [`of`](Self::of).
    pub(crate) fn material<'a>(&self, material: Option<&'a ClassMaterial<'a>>) -> MaterialAt<'a> {
        MaterialAt { axes: self.axes, material }
    }

    /// Returns the classes of the sampled facets. `scale` multiplies slopes along `s` and `t`.
    pub fn sampled(&self, scale: [f64; 2]) -> Vec<Class> {
        let by = DVec2::from(scale);
        let class = |part: &Part| {
            let c = part.covariance;
            Class {
                share: part.share,
                mean: part.mean.truncate() * by,
                covariance: DVec3::new(c.x_axis.x, c.y_axis.y, c.x_axis.y)
                    * DVec3::new(by.x * by.x, by.y * by.y, by.x * by.y),
                height: part.mean.z,
                height_variance: c.z_axis.z,
            }
        };
        self.classes.iter().map(class).collect()
    }

    /// Returns the mean slope and height of the sampled facets of each class, and the mean of their variances.
    pub(crate) fn centers(&self) -> (Vec<DVec3>, DVec3) {
        let variance = |part: &Part| {
            let c = part.covariance;
            part.share * DVec3::new(c.x_axis.x, c.y_axis.y, c.z_axis.z)
        };
        (self.classes.iter().map(|part| part.mean).collect(), self.classes.iter().map(variance).sum())
    }
}

/// Finds the classes of a relief and of the material on it. `scale` converts slopes along `s` and `t` to rise over run: for an object,
/// the height factor divided by the width and by the height of the texture. Negative factors invert the heights. The result does not
/// depend on the number of threads.
pub fn classes(facets: Facets<'_>, scale: [f64; 2], material: Option<&ClassMaterial<'_>>) -> Classes {
    let samples = facets.sampled(SAMPLES, material);
    found(samples, Heights::of(facets), scale, material, None)
}

/// Finds the classes of a relief in some of its parts, like [`classes`]. `scale` converts the slopes of the windows.
pub fn classes_of_windows(
    windows: &[OpennessWindow],
    scale: [f64; 2],
    material: Option<&ClassMaterial<'_>>,
) -> Classes {
    found(sampled_of_windows(windows, SAMPLES), Heights::OfWindows(windows), scale, material, None)
}

/// Finds this number of classes of a relief, from 1 to [`MOST_CLASSES`], like [`classes`].
pub fn classes_of_count(facets: Facets<'_>, scale: [f64; 2], count: usize) -> Classes {
    found(facets.sampled(SAMPLES, None), Heights::of(facets), scale, None, Some(count.clamp(1, MOST_CLASSES)))
}

/// The heights that hide facets.
#[derive(Clone, Copy)]
enum Heights<'a> {
    /// Those of the facets. Flat surfaces hide nothing.
    Flat,
    OfFacets(Facets<'a>),
    OfWindows(&'a [OpennessWindow]),
}

impl<'a> Heights<'a> {
    fn of(facets: Facets<'a>) -> Self {
        if matches!(facets, Facets::Flat) { Self::Flat } else { Self::OfFacets(facets) }
    }

    /// Returns the fields of the samples' windows, or `None` for a flat surface.
    fn fields(self, sign: f64) -> Option<Vec<Field>> {
        match self {
            Self::Flat => None,
            Self::OfFacets(facets) => Some(vec![Field::new(facets, sign)]),
            Self::OfWindows(windows) => Some(Field::of_windows(windows, sign)),
        }
    }
}

fn found(
    samples: Vec<Sample>,
    heights: Heights<'_>,
    scale: [f64; 2],
    material: Option<&ClassMaterial<'_>>,
    given: Option<usize>,
) -> Classes {
    let sampled: Vec<Facet> = samples.iter().map(|sample| sample.facet).collect();
    let scale = DVec2::from(scale.map(|scale| at_least(scale.abs(), 1e-9).copysign(scale)));
    let one = vec![0; sampled.len()];
    let whole = parts(&sampled, &one, 1)[0];
    let floor = match heights {
        // Only the material counts, also for facets of heights that are all equal.
        Heights::Flat => DVec3::splat(1e9),
        _ => (SLOPE_FLOOR / (scale * scale)).extend(HEIGHT_FLOOR * at_least(whole.covariance.z_axis.z, 1e-20)),
    };
    let texels: Vec<[f64; 4]> = material
        .map_or_else(Vec::new, |material| samples.iter().map(|sample| material.at(sample.material_at)).collect());
    let weights = if material.is_some_and(|material| material.follows_relief) {
        correlated(&sampled, &whole)
    } else {
        Vec::new()
    };
    let squares: Vec<f64> = texels.iter().map(|texel| texel[3] * texel[3]).collect();
    let judge = Judge {
        reflections: heights.fields(scale.x.signum()).map(|fields| Reflections::new(&fields, &samples, scale)),
        colors: texels.iter().map(|&[r, g, b, _]| DVec3::new(r, g, b)).collect(),
        weights,
        lost: lost_peak(peaks(&squares, &one, 1).iter()),
        squares,
    };
    let all = &judge.traits(&one, 1).remove(0).with_light(&judge);
    let mut errors = vec![judge.error(&[all])];
    let single = Classes {
        errors: Vec::new(),
        axes: MaterialAxes::default(),
        classes: vec![whole],
        parts: vec![whole.density(floor)],
        class_of_part: vec![0],
    };
    let most = given.unwrap_or(MOST_CLASSES);
    if most == 1 || given.is_none() && errors[0] <= GOOD {
        return Classes { errors, ..single };
    }

    // Mixtures of the relief alone can be better even if the material varies.
    let mut axes = vec![MaterialAxes::default()];
    let by_color = if judge.follows(all) { color_axis(&judge.colors, &all.color) } else { DVec3::ZERO };
    let by_material = MaterialAxes { roughness: judge.lost > LOST, color: by_color };
    if !by_material.is_none() {
        axes.push(by_material);
    }
    let mixtures = axes.into_iter().flat_map(|axes| {
        let material = |texel: Option<&[f64; 4]>| texel.map_or(DVec2::ZERO, |texel| axes.of(*texel));
        let facets: Vec<Facet> = sampled
            .iter()
            .enumerate()
            .map(|(i, facet)| Facet { material: material(texels.get(i)), ..*facet })
            .collect();
        fitted(&facets, floor).into_iter().map(|densities| Mixture::new(axes, &facets, densities)).collect::<Vec<_>>()
    });
    let mixtures: Vec<Mixture> = mixtures.collect();
    let lights: Vec<Vec<Traits>> = mixtures.par_iter().map(|mixture| judge.of_all_sets(mixture)).collect();
    let mut best = vec![single];
    while errors.len() < most && (given.is_some() || errors[errors.len() - 1] > GOOD) {
        let count = errors.len() + 1;
        let found = mixtures.par_iter().zip(&lights).map(|(mixture, sets)| {
            let mut best = (f64::INFINITY, Vec::new());
            for_each_division(mixture.densities.len(), count, |division| {
                let mut traits = [&sets[0]; MOST_CLASSES];
                traits.iter_mut().zip(division).for_each(|(of, set)| *of = &sets[*set]);
                let error = judge.error(&traits[..division.len()]);
                if error < best.0 {
                    best = (error, division.to_vec());
                }
            });
            best
        });
        let found: Vec<(f64, Vec<usize>)> = found.collect();
        // A flat surface can have fewer parts than classes.
        let Some((mixture, (error, division))) = mixtures
            .iter()
            .zip(found)
            .min_by(|a, b| a.1.0.total_cmp(&b.1.0))
            .filter(|(_, (error, _))| error.is_finite())
        else {
            break;
        };
        errors.push(error);
        best.push(mixture.joined(&sampled, &division));
    }
    let cost = |i: &usize| errors[*i].max(GOOD) * GAIN.powi(*i as i32);
    let cheapest = (0..errors.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
    let best = best.swap_remove(given.map_or(cheapest, |count| count.min(errors.len()) - 1));
    Classes { errors, ..best }
}

/// A division of the facets into small parts.
struct Mixture {
    axes: MaterialAxes,
    densities: Vec<Density>,
    part_of: Vec<usize>,
}

impl Mixture {
    /// Divides the facets. Parts without facets are left out.
    fn new(axes: MaterialAxes, facets: &[Facet], mut densities: Vec<Density>) -> Self {
        let part_of = |densities: &[Density]| facets.iter().map(|facet| nearest(densities, facet)).collect::<Vec<_>>();
        let mut used = [false; MOST_PARTS];
        part_of(&densities).into_iter().for_each(|part| used[part] = true);
        let mut keep = used.into_iter();
        densities.retain(|_| keep.next().unwrap_or(false));
        Self { axes, part_of: part_of(&densities), densities }
    }

    /// Returns the classes of a division of the parts.
    fn joined(&self, facets: &[Facet], division: &[usize]) -> Classes {
        let class_of = |part: usize| division.iter().position(|set| set >> part & 1 == 1).unwrap_or(0);
        let class_of_part: Vec<usize> = (0..self.densities.len()).map(class_of).collect();
        let class_of_facet: Vec<usize> = self.part_of.iter().map(|part| class_of_part[*part]).collect();
        Classes {
            errors: Vec::new(),
            axes: self.axes,
            classes: parts(facets, &class_of_facet, division.len()),
            parts: self.densities.clone(),
            class_of_part,
        }
    }
}

/// What decides about classes.
struct Judge {
    reflections: Option<Reflections>,
    /// The colours of the facets, and the weights of [`ColorSums`]. There are none if colours do not matter.
    colors: Vec<DVec3>,
    weights: Vec<DVec3>,
    /// The `α²` of the facets.
    squares: Vec<f64>,
    /// The share of the peak of a highlight that a single class loses.
    lost: f64,
}

/// What counts of a class.
#[derive(Clone)]
struct Traits {
    sums: Option<reflections::Sums>,
    light: Option<Light>,
    color: ColorSums,
    peak: Peak,
}

impl Judge {
    /// Returns the traits of each class, without its light.
    fn traits(&self, class_of: &[usize], count: usize) -> Vec<Traits> {
        let mut colors = vec![ColorSums::default(); count];
        for ((color, weights), class) in self.colors.iter().zip(&self.weights).zip(class_of) {
            colors[*class].add(*color, *weights);
        }
        let mut sums = self.reflections.as_ref().map(|reflections| reflections.sums(class_of, count).into_iter());
        let traits = colors.into_iter().zip(peaks(&self.squares, class_of, count)).map(|(color, peak)| {
            let sums = sums.as_mut().and_then(Iterator::next);
            Traits { light: None, sums, color, peak }
        });
        traits.collect()
    }

    /// Returns the traits of every set of parts, by the bits of the set.
    fn of_all_sets(&self, mixture: &Mixture) -> Vec<Traits> {
        let parts = self.traits(&mixture.part_of, mixture.densities.len());
        let mut sets: Vec<Traits> = vec![parts[0].clone()];
        for set in 1..1_usize << parts.len() {
            let part = &parts[set.trailing_zeros() as usize];
            let rest = set & (set - 1);
            sets.push(if rest == 0 { part.clone() } else { sets[rest].joined(part) });
        }
        sets.into_par_iter().map(|traits| Traits { sums: None, ..traits.with_light(self) }).collect()
    }

    /// Whether colours follow the relief if all facets are one class.
    fn follows(&self, all: &Traits) -> bool {
        !self.weights.is_empty() && change_within([&all.color].into_iter()) > LEAST_CHANGE
    }

    /// Returns the error of these classes.
    fn error(&self, classes: &[&Traits]) -> f64 {
        let mut squares = 0.0;
        if let Some(reflections) = &self.reflections {
            let mut lights = [None; MOST_CLASSES];
            lights.iter_mut().zip(classes).for_each(|(light, class)| *light = class.light.as_ref());
            squares += reflections.error(lights.into_iter().flatten()).powi(2);
        }
        if !self.weights.is_empty() {
            let change = change_within(classes.iter().map(|class| &class.color));
            squares += if change > LEAST_CHANGE { (GOOD * change / LEAST_CHANGE).powi(2) } else { 0.0 };
        }
        if self.lost > LOST {
            squares += lost_peak(classes.iter().map(|class| &class.peak)).powi(2);
        }
        squares.sqrt()
    }
}

impl Traits {
    fn joined(&self, other: &Self) -> Self {
        let mut joined = self.clone();
        if let (Some(sums), Some(other)) = (&mut joined.sums, &other.sums) {
            sums.join(other);
        }
        joined.color.join(&other.color);
        joined.peak.join(&other.peak);
        joined
    }

    fn with_light(mut self, judge: &Judge) -> Self {
        self.light = judge.reflections.as_ref().zip(self.sums.as_ref()).map(|(of, sums)| of.of_class(sums));
        self
    }
}

/// The peak of the highlight of a class on a flat surface, and the sum of its `α²`.
#[derive(Clone, Copy, Debug, Default)]
struct Peak {
    number: f64,
    peak: f64,
    square: f64,
}

impl Peak {
    fn add(&mut self, square: f64) {
        self.join(&Self { number: 1.0, peak: square.recip(), square });
    }

    fn join(&mut self, other: &Self) {
        self.number += other.number;
        self.peak += other.peak;
        self.square += other.square;
    }
}

/// Returns the peaks of classes of facets with these `α²`.
fn peaks(squares: &[f64], class_of: &[usize], count: usize) -> Vec<Peak> {
    let mut peaks = vec![Peak::default(); count];
    let least = LEAST_SQUARE * squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    for (square, class) in squares.iter().zip(class_of) {
        peaks[*class].add(square.max(least).max(1e-12));
    }
    peaks
}

/// Returns the share of the peak of a highlight that is lost if each class has one lobe of its mean `α²`.
fn lost_peak<'a>(classes: impl Iterator<Item = &'a Peak>) -> f64 {
    let (mut peak, mut kept) = (0.0, 0.0);
    for class in classes.filter(|class| class.number > 0.0) {
        peak += class.peak;
        kept += class.number * class.number / class.square;
    }
    if peak > 0.0 { 1.0 - kept / peak } else { 0.0 }
}

/// Returns the weights of [`ColorSums`]. The result is empty for flat surfaces.
fn correlated(facets: &[Facet], whole: &Part) -> Vec<DVec3> {
    let c = whole.covariance;
    let unit =
        DVec2::new(c.x_axis.x, c.y_axis.y).map(|variance| if variance > 0.0 { variance.sqrt().recip() } else { 0.0 });
    if unit == DVec2::ZERO && c.z_axis.z <= 0.0 {
        return Vec::new();
    }
    let heights: Vec<f64> = facets.iter().map(|facet| facet.point.z).collect();
    let slope = |facet: &Facet| (facet.point - whole.mean).truncate() * unit;
    facets.iter().zip(double_ranks(&heights)).map(|(facet, rank)| slope(facet).extend(rank)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ClassMap, HeightMap, MomentLevel, Moments, Wrap, procedural};

    fn of(size: u32, height: impl Fn(f64, f64) -> f64) -> (Classes, ClassMap) {
        let at = |i: u32| (f64::from(i % size) / f64::from(size), f64::from(i / size) / f64::from(size));
        let texels = (0..size * size).map(|i| height(at(i).0, at(i).1) as f32).collect();
        let map = HeightMap { width: size, height: size, texels };
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let classes = classes(facets, [1.0; 2], None);
        let map = ClassMap::new(facets, &classes, None);
        (classes, map)
    }

    #[test]
    fn noise_is_one_class() {
        let rock = procedural::fbm(128, 128, 3, 8, 4, 0.5);
        let facets = Facets::OfHeights(&rock, Wrap::Repeat);
        let found = classes(facets, [0.1; 2], None);
        assert_eq!(found.count(), 1, "{:?}", found.errors);
        let mean = ClassMap::new(facets, &found, None).mean();
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
            let x = if i.is_multiple_of(4) { 2.0 } else { 0.0 };
            Moments { mean_slope: [x, 0.0], second: [x * x, 0.0], ..Moments::default() }
        };
        let level = MomentLevel { width: 64, height: 64, texels: (0..4096).map(texel).collect() };
        let facets = Facets::OfTexels(&level, Wrap::Repeat);
        let found = classes(facets, [1.0; 2], None);
        let mut mean = ClassMap::new(facets, &found, None).mean();
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
