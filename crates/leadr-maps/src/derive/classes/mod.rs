//! Classes of facets with similar slopes, heights and materials, such as the tops, walls and bottoms of bricks.
//!
//! The moments of a class are linear in its facets, so a filter keeps them. One class is one Gaussian of slopes, as in the LEADR
//! paper. [`classes`] chooses the number of classes by the error of specular reflections. Within a class, colour and roughness do not
//! depend on the relief. Where they do, or if a material has two roughnesses, they separate classes, too.
//!
//! Slopes are per unit of texture coordinate, and heights are in the unit of the map.

mod axes;
mod facets;
mod mixture;
mod reflections;

use glam::{DVec2, DVec3};
use leadr_reflectance::limits::at_least;
use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};

pub(crate) use facets::{CORNERS, Cell, Facet, FacetsAt, MaterialAt};
pub use facets::{ClassMaterial, Facets};

use axes::{Correlation, MaterialAxes, double_ranks};
use mixture::{Density, Part, fitted, nearest, parts};
use reflections::Truth;

/// The number of facets whose reflections are computed. Mixtures are fitted to one of every [`FIT_STEP`] of them.
const SAMPLES: usize = 8192;
const FIT_STEP: usize = 3;
/// The variance that is added to slopes, and to heights relative to their variance, so that flat classes have a density.
const SLOPE_FLOOR: f64 = 2e-4;
const HEIGHT_FLOOR: f64 = 1e-3;
/// An error that needs no further class, and the gain per class that justifies one.
const GOOD: f64 = 0.1;
const GAIN: f64 = 1.25;
/// The share of the peak of a highlight whose loss needs roughness as a coordinate, and the part of it that classes may still lose.
const LOST: f64 = 0.25;
const STILL_LOST: f64 = 0.5;
/// The smallest `α²` in this comparison, relative to the mean. A few smooth texels would otherwise decide alone.
const LEAST_SQUARE: f64 = 0.08;
/// The largest change of the mean colour that needs no further class, relative to the mean of the brightest channel. The value is half
/// the smallest difference that is visible side by side. The change is from no hidden facets to half of the facets hidden, or for a
/// shift of the slopes by one standard deviation.
const LEAST_CHANGE: f64 = 0.01;

/// The classes of a relief, and a rule that assigns its facets to them.
#[derive(Clone, Debug)]
pub struct Classes {
    /// The error for 1, 2, … classes: the relative RMS error of specular reflections at a base roughness of 0.35, without masking. If colours follow the relief by more than 1 %, the error is at least ten times the part of their change within the classes. The
    /// list ends with the first number of classes that needs no further class, and has at most [`MOST_CLASSES`] entries.
    pub errors: Vec<f64>,
    axes: MaterialAxes,
    parts: Vec<Part>,
    densities: Vec<Density>,
}

impl Classes {
    /// Returns the number of classes, from 1 to [`MOST_CLASSES`].
    pub fn count(&self) -> usize {
        self.densities.len()
    }

    /// Returns the class of a facet of the relief with a slope per texture coordinate and a height, without its material.
    pub fn of_relief(&self, slope: DVec2, height: f64) -> usize {
        self.of(&Facet { point: slope.extend(height), ..Facet::default() })
    }

    /// Returns the class of a facet.
    pub(crate) fn of(&self, facet: &Facet) -> usize {
        nearest(&self.densities, facet)
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
        self.parts.iter().map(class).collect()
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

/// Finds the classes of a relief and of the material on it. `scale` converts slopes along `s` and `t` to rise over run: for an object,
/// the height factor divided by the width and by the height of the texture. The result does not depend on the number of threads.
pub fn classes(facets: Facets<'_>, scale: [f64; 2], material: Option<&ClassMaterial<'_>>) -> Classes {
    found(facets, scale, material, None)
}

/// Finds this number of classes of a relief, from 1 to [`MOST_CLASSES`], like [`classes`].
pub fn classes_of_count(facets: Facets<'_>, scale: [f64; 2], count: usize) -> Classes {
    found(facets, scale, None, Some(count.clamp(1, MOST_CLASSES)))
}

fn found(facets: Facets<'_>, scale: [f64; 2], material: Option<&ClassMaterial<'_>>, given: Option<usize>) -> Classes {
    let samples = facets.sampled(SAMPLES, material);
    let mut sampled: Vec<Facet> = samples.iter().map(|(facet, _)| *facet).collect();
    let squares = DVec2::from(scale.map(|scale| at_least(scale.abs(), 1e-9).powi(-2)));
    let one = vec![0; sampled.len()];
    let whole = parts(&sampled, &one, 1)[0];
    let floor = (SLOPE_FLOOR * squares).extend(HEIGHT_FLOOR * at_least(whole.covariance.z_axis.z, 1e-20));
    let texels: Vec<[f64; 4]> =
        material.map_or_else(Vec::new, |material| samples.iter().map(|&(_, at)| material.at(at)).collect());
    // All facets of a flat surface are alike.
    let truth = Truth::new(if matches!(facets, Facets::Flat) { &sampled[..1] } else { &sampled }, squares);
    let colors: Vec<DVec3> = texels.iter().map(|&[r, g, b, _]| DVec3::new(r, g, b)).collect();
    let weights = if material.is_some_and(|material| material.follows_relief) {
        correlated(&sampled, &whole)
    } else {
        Vec::new()
    };
    let correlation = (!weights.is_empty()).then_some(Correlation { colors: &colors, weights: &weights });
    let fit_of = |axes: MaterialAxes, parts: Vec<Part>, densities: Vec<Density>, class_of: Vec<usize>| {
        let change = correlation.as_ref().map_or(0.0, |of| of.change(of.within(&class_of, parts.len())));
        let of_color = if change > LEAST_CHANGE { GOOD * change / LEAST_CHANGE } else { 0.0 };
        Fit { error: truth.error(&parts).max(of_color), axes, parts, densities, class_of }
    };
    let mut fit = |axes: MaterialAxes, count: usize| {
        sampled.iter_mut().zip(&texels).for_each(|(facet, texel)| facet.material = axes.of(*texel));
        let fit_to: Vec<Facet> = sampled.iter().step_by(FIT_STEP).copied().collect();
        let fits = fitted(&fit_to, count, floor).into_iter().map(|densities| {
            let class_of: Vec<usize> = sampled.iter().map(|facet| nearest(&densities, facet)).collect();
            fit_of(axes, parts(&sampled, &class_of, count), densities, class_of)
        });
        fits.min_by(|a, b| a.error.total_cmp(&b.error)).expect("there are several starts")
    };

    let by_color =
        MaterialAxes { color: correlation.as_ref().map_or(DVec3::ZERO, |of| of.axis(&one)), ..Default::default() };
    let mut fits = vec![fit_of(MaterialAxes::default(), vec![whole], vec![whole.density(floor)], one.clone())];
    while fits.len() < given.unwrap_or(MOST_CLASSES) && (given.is_some() || fits[fits.len() - 1].error > GOOD) {
        let count = fits.len() + 1;
        let mut best = fit(MaterialAxes::default(), count);
        if !by_color.is_none() {
            // Classes of the relief alone can be better even if the colour varies.
            let other = fit(by_color, count);
            best = if other.error < best.error { other } else { best };
        }
        fits.push(best);
    }
    let errors: Vec<f64> = fits.iter().map(|fit| fit.error).collect();
    let cost = |i: &usize| errors[*i].max(GOOD) * GAIN.powi(*i as i32);
    let cheapest = (0..errors.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
    let best = given.map_or(cheapest, |count| count - 1);
    let mut best = fits.swap_remove(best);
    let squares: Vec<f64> = texels.iter().map(|texel| texel[3] * texel[3]).collect();
    let lost = lost_peak(&squares, &one, 1);
    if lost > LOST && lost_peak(&squares, &best.class_of, best.parts.len()) > STILL_LOST * lost {
        let axes = MaterialAxes { roughness: true, ..best.axes };
        let good = GOOD.max(GAIN * best.error);
        let mut found = (best.parts.len().max(2)..=MOST_CLASSES).map(|count| fit(axes, count));
        let is_good =
            |fit: &Fit| fit.error <= good && lost_peak(&squares, &fit.class_of, fit.parts.len()) <= STILL_LOST * lost;
        best = found.find(is_good).unwrap_or(best);
    }
    Classes { errors, axes: best.axes, parts: best.parts, densities: best.densities }
}

/// Classes of the samples.
struct Fit {
    error: f64,
    axes: MaterialAxes,
    parts: Vec<Part>,
    densities: Vec<Density>,
    class_of: Vec<usize>,
}

/// Returns the share of the peak of a highlight on a flat surface that is lost if each class has one lobe of its mean `α²`. `squares`
/// has the `α²` of the samples.
fn lost_peak(squares: &[f64], class_of: &[usize], count: usize) -> f64 {
    let least = LEAST_SQUARE * squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    let mut sums = vec![(0.0, 0.0); count];
    let mut peak = 0.0;
    for (&square, &class) in squares.iter().zip(class_of) {
        let square = square.max(least).max(1e-12);
        peak += square.recip();
        sums[class].0 += 1.0;
        sums[class].1 += square;
    }
    let kept: f64 = sums.iter().filter(|(number, _)| *number > 0.0).map(|(number, sum)| number * number / sum).sum();
    if peak > 0.0 { 1.0 - kept / peak } else { 0.0 }
}

/// Returns the weights of [`Correlation`]. The result is empty for flat surfaces.
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
        let facets = Facets::OfTexels(&level);
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
