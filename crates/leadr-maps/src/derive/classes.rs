//! Classes of texels with similar slopes and heights, such as the tops, walls and bottoms of bricks.
//!
//! The moments of a class are linear in its texels, so a filter keeps them. One class is one Gaussian of slopes, as in the LEADR
//! paper. [`classes`] chooses the number of classes by the error of the filtered slopes.

use glam::{DMat3, DVec2, DVec3};
use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};
use leadr_reflectance::random::Random;
use rayon::prelude::*;

use crate::{HeightMap, Wrap};

/// The number of texels to which mixtures are fitted.
const SAMPLES: usize = 8192;
/// The number of steps of a fit, and the number of fits from different starts.
const STEPS: usize = 60;
const STARTS: u64 = 3;
/// The variance that is added to slopes and to heights relative to their variance, so that flat classes have a density.
const SLOPE_FLOOR: f64 = 2e-4;
const HEIGHT_FLOOR: f64 = 1e-3;
/// The slope variance of the base material at which slope densities are compared, for a Beckmann roughness of 0.35.
const BASE: f64 = 0.5 * 0.35 * 0.35;
/// An error of the slope density that needs no further class, and the gain per class that justifies one.
const GOOD: f64 = 0.1;
const GAIN: f64 = 1.25;

/// The classes of a height map.
#[derive(Clone, Debug)]
pub struct Classes {
    /// The class of each texel.
    pub of_texels: Vec<u8>,
    /// The share, slopes and heights of each class.
    pub classes: Vec<Class>,
    /// The relative error of the slope density, filtered by a base of roughness 0.35, for 1 to [`MOST_CLASSES`] classes.
    pub errors: [f64; MOST_CLASSES],
}

/// A slope and a height.
type Point = DVec3;

/// A weighted Gaussian of points.
#[derive(Clone, Copy, Debug)]
struct Part {
    share: f64,
    mean: Point,
    covariance: DMat3,
}

impl Part {
    /// Returns a function for the logarithm of the weighted density.
    fn log_density(&self, floor: DVec3) -> impl Fn(Point) -> f64 + use<> {
        let covariance = self.covariance + DMat3::from_diagonal(floor);
        let (inverse, mean) = (covariance.inverse(), self.mean);
        let constant = self.share.max(1e-300).ln() - 0.5 * covariance.determinant().max(1e-300).ln();
        move |point| {
            let off = point - mean;
            constant - 0.5 * off.dot(inverse * off)
        }
    }
}

/// Sums over weighted points.
#[derive(Clone, Copy, Debug)]
struct Moments {
    weight: f64,
    first: DVec3,
    second: DMat3,
}

impl Moments {
    const NONE: Self = Self { weight: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    fn of(points: impl Iterator<Item = (f64, Point)>) -> Self {
        let mut moments = Self::NONE;
        points.for_each(|(weight, point)| moments.add(weight, point));
        moments
    }

    fn add(&mut self, weight: f64, point: Point) {
        self.weight += weight;
        self.first += weight * point;
        self.second += outer(point) * weight;
    }

    fn join(&mut self, other: &Self) {
        self.weight += other.weight;
        self.first += other.first;
        self.second += other.second;
    }

    /// Returns the part of these points among `all` points.
    fn part(&self, all: usize) -> Part {
        let mean = self.first / self.weight.max(1e-300);
        let covariance = self.second * self.weight.max(1e-300).recip() - outer(mean);
        Part { share: self.weight / all as f64, mean, covariance }
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Finds the classes of a height map. `scale` converts heights to texture widths. The classes do not depend on the number of threads.
pub fn classes(map: &HeightMap, wrap: Wrap, scale: f64) -> Classes {
    let field = Field { map, wrap, scale };
    let texels = map.texels.len();
    let stride = texels.div_ceil(SAMPLES).max(1);
    // A stride without a common factor with the width reaches all columns.
    let stride = (stride..).find(|stride| gcd(*stride, map.width as usize) == 1).unwrap_or(1);
    let sampled: Vec<Point> = (0..texels).step_by(stride).map(|texel| field.point(texel)).collect();
    let whole = Moments::of(sampled.iter().map(|&point| (1.0, point))).part(sampled.len());
    let floor = DVec3::new(SLOPE_FLOOR, SLOPE_FLOOR, HEIGHT_FLOOR * whole.covariance.z_axis.z.max(1e-20));
    let fits: Vec<Vec<Part>> = (1..=MOST_CLASSES).map(|count| fitted(&sampled, count, whole, floor)).collect();
    let errors: [f64; MOST_CLASSES] = std::array::from_fn(|k| {
        let nearest = nearest(&fits[k], floor);
        let parts = (0..=k).map(|class| {
            let own = sampled.iter().filter(|&&point| nearest(point) == class).map(|&point| (1.0, point));
            Moments::of(own).part(sampled.len())
        });
        error(&sampled, whole, &parts.collect::<Vec<_>>())
    });
    let least = errors.into_iter().fold(f64::MAX, f64::min);
    let count = 1 + errors.iter().position(|&error| error <= GOOD.max(GAIN * least)).unwrap_or(0);
    let nearest = nearest(&fits[count - 1], floor);
    let mut of_texels = vec![0; texels];
    let rows: Vec<[Moments; MOST_CLASSES]> = of_texels
        .par_chunks_mut(map.width as usize)
        .enumerate()
        .map(|(y, row)| {
            let mut moments = [Moments::NONE; MOST_CLASSES];
            for (x, class) in row.iter_mut().enumerate() {
                let point = field.point(y * map.width as usize + x);
                *class = nearest(point) as u8;
                moments[usize::from(*class)].add(1.0, point);
            }
            moments
        })
        .collect();
    let class = |k: usize| {
        let mut sum = Moments::NONE;
        rows.iter().for_each(|row| sum.join(&row[k]));
        let Part { share, mean, covariance: c } = sum.part(texels);
        Class {
            share,
            mean: DVec2::new(mean.x, mean.y),
            covariance: DVec3::new(c.x_axis.x, c.y_axis.y, c.x_axis.y),
            height: mean.z,
            height_variance: c.z_axis.z,
        }
    };
    Classes { of_texels, classes: (0..count).map(class).collect(), errors }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// A height map whose heights are converted to texture widths.
struct Field<'a> {
    map: &'a HeightMap,
    wrap: Wrap,
    scale: f64,
}

impl Field<'_> {
    /// Returns the height of a texel, and the slope of the triangle below and to the right of it.
    fn point(&self, texel: usize) -> Point {
        let (width, height) = (self.map.width, self.map.height);
        let (x, y) = ((texel % width as usize) as i64, (texel / width as usize) as i64);
        let at = |x: i64, y: i64| {
            f64::from(self.map.texels[self.wrap.texel(y, height) * width as usize + self.wrap.texel(x, width)])
        };
        let here = at(x, y);
        let along = |h: f64| (h - here) * self.scale * f64::from(width);
        Point::new(along(at(x + 1, y)), along(at(x, y + 1)), here * self.scale)
    }
}

/// Returns a function for the part with the largest density at a point.
fn nearest(parts: &[Part], floor: DVec3) -> impl Fn(Point) -> usize + use<> {
    let densities: Vec<_> = parts.iter().map(|part| part.log_density(floor)).collect();
    move |point| {
        let best = (0..densities.len()).max_by(|&a, &b| densities[a](point).total_cmp(&densities[b](point)));
        best.unwrap_or(0)
    }
}

/// Fits a mixture by expectation maximisation, from several starts.
fn fitted(points: &[Point], count: usize, whole: Part, floor: DVec3) -> Vec<Part> {
    if count == 1 {
        return vec![whole];
    }
    let fits = (0..STARTS).into_par_iter().map(|start| {
        let mut parts = started(points, count, whole, &mut Random::stream(start, count as u64));
        let mut likelihood = f64::MIN;
        for _ in 0..STEPS {
            let densities: Vec<_> = parts.iter().map(|part| part.log_density(floor)).collect();
            let mut sum = 0.0;
            let shares: Vec<[f64; MOST_CLASSES]> = points
                .iter()
                .map(|&point| {
                    let mut logs = [f64::MIN; MOST_CLASSES];
                    logs.iter_mut().zip(&densities).for_each(|(log, density)| *log = density(point));
                    let most = logs.iter().copied().fold(f64::MIN, f64::max);
                    let weights = logs.map(|log| (log - most).exp());
                    let all: f64 = weights.iter().sum();
                    sum += most + all.ln();
                    weights.map(|weight| weight / all)
                })
                .collect();
            let part = |k: usize| {
                Moments::of(points.iter().zip(&shares).map(|(&point, shares)| (shares[k], point))).part(points.len())
            };
            parts = (0..count).map(part).collect();
            if sum - likelihood < 1e-5 * points.len() as f64 {
                break;
            }
            likelihood = sum;
        }
        (likelihood, parts)
    });
    let best = fits.collect::<Vec<_>>().into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Vec::new, |(_, parts)| parts)
}

/// Returns parts around points that are far from each other (k-means++).
fn started(points: &[Point], count: usize, whole: Part, random: &mut Random) -> Vec<Part> {
    let deviations = DVec3::new(whole.covariance.x_axis.x, whole.covariance.y_axis.y, whole.covariance.z_axis.z);
    let unit = deviations.max(DVec3::splat(1e-20)).map(f64::sqrt);
    let mut centres = vec![points[(random.unit() * points.len() as f64) as usize % points.len()]];
    while centres.len() < count {
        let away = |&point: &Point| {
            let squares = centres.iter().map(|&centre| ((point - centre) / unit).length_squared());
            squares.fold(f64::MAX, f64::min)
        };
        let squares: Vec<f64> = points.iter().map(away).collect();
        let mut left = random.unit() * squares.iter().sum::<f64>();
        let next = squares.iter().position(|square| {
            left -= square;
            left <= 0.0
        });
        centres.push(points[next.unwrap_or(0)]);
    }
    let covariance = whole.covariance * (0.5 / count as f64);
    centres.into_iter().map(|mean| Part { share: 1.0 / count as f64, mean, covariance }).collect()
}

/// Returns the relative RMS difference of the slope density of parts from that of the points. Both are filtered by the base material.
fn error(points: &[Point], whole: Part, parts: &[Part]) -> f64 {
    const SIDE: usize = 25;
    let (mean, c) = (whole.mean, whole.covariance);
    let reach = DVec2::new(3.0 * (c.x_axis.x + BASE).sqrt(), 3.0 * (c.y_axis.y + BASE).sqrt());
    let lobes: Vec<_> = parts
        .iter()
        .map(|part| {
            let (xx, yy, xy) =
                (part.covariance.x_axis.x + BASE, part.covariance.y_axis.y + BASE, part.covariance.x_axis.y);
            (part, xx, yy, xy, xx * yy - xy * xy)
        })
        .collect();
    let squares = |i: usize| {
        let unit = |k: usize| 2.0 * (k as f64 + 0.5) / SIDE as f64 - 1.0;
        let at = DVec2::new(mean.x, mean.y) + DVec2::new(unit(i % SIDE), unit(i / SIDE)) * reach;
        let truth: f64 =
            points.iter().map(|p| (-0.5 * (DVec2::new(p.x, p.y) - at).length_squared() / BASE).exp()).sum::<f64>()
                / (BASE * points.len() as f64);
        let found: f64 = lobes
            .iter()
            .map(|(part, xx, yy, xy, det)| {
                let d = DVec2::new(part.mean.x, part.mean.y) - at;
                let square = (yy * d.x * d.x - 2.0 * xy * d.x * d.y + xx * d.y * d.y) / det;
                part.share * (-0.5 * square).exp() / det.max(1e-300).sqrt()
            })
            .sum();
        [truth * truth, (truth - found) * (truth - found)]
    };
    let sums: Vec<[f64; 2]> = (0..SIDE * SIDE).into_par_iter().map(squares).collect();
    let sum = |k: usize| sums.iter().map(|pair| pair[k]).sum::<f64>();
    (sum(1) / sum(0).max(1e-300)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural;

    fn of(size: u32, height: impl Fn(f64, f64) -> f64) -> Classes {
        let at = |i: u32| (f64::from(i % size) / f64::from(size), f64::from(i / size) / f64::from(size));
        let texels = (0..size * size).map(|i| height(at(i).0, at(i).1) as f32).collect();
        classes(&HeightMap { width: size, height: size, texels }, Wrap::Repeat, 1.0)
    }

    #[test]
    fn noise_is_one_class() {
        let rock = procedural::fbm(128, 128, 3, 8, 4, 0.5);
        let found = classes(&rock, Wrap::Repeat, 0.1);
        println!("{:?}", found.errors);
        assert_eq!(found.classes.len(), 1);
        assert!(found.of_texels.iter().all(|&class| class == 0));
        assert!(found.classes[0].share == 1.0 && found.classes[0].mean.length() < 1e-6);
    }

    #[test]
    fn grooves_are_classes() {
        // Grooves across x: ground, two walls and tops in equal parts, with slopes of 0, 2, -2 and 0.
        let found = of(64, |x, _| 0.5 * (4.0 * (x - 0.5).abs() - 0.5).clamp(0.0, 1.0));
        println!("{:?} {:.3?}", found.errors, found.classes);
        assert!(found.errors[0] > 0.5 && found.errors[found.classes.len() - 1] < 0.1, "{:?}", found.errors);
        let share: f64 = found.classes.iter().map(|class| class.share).sum();
        let mean: f64 = found.classes.iter().map(|class| class.share * class.mean.x).sum();
        let square: f64 =
            found.classes.iter().map(|class| class.share * (class.covariance.x + class.mean.x * class.mean.x)).sum();
        assert!((share - 1.0).abs() < 1e-12 && mean.abs() < 1e-12 && (square - 2.0).abs() < 0.1, "{square}");
        for (i, &class) in found.of_texels.iter().enumerate() {
            assert_eq!(class, found.of_texels[i % 64], "rows are equal");
        }
    }

    #[test]
    fn a_flat_map_is_one_class() {
        let found = of(16, |_, _| 0.25);
        let Classes { classes, errors, .. } = &found;
        assert!(classes.len() == 1 && classes[0].covariance.length() < 1e-12, "{classes:?} {errors:?}");
        assert!((found.classes[0].height - 0.25).abs() < 1e-12);
    }
}
