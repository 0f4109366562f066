//! Masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms. A class has its own slopes and its own
//! heights, so high classes hide low ones.
//!
//! Smith's derivation follows a ray upwards. At height `z`, the ray meets facets of class `j` at the rate `w_j p_j(z) b_j / F(z)`, with the
//! share `w_j` of the class, the density `p_j` of its heights, the fraction `F` of the surface below `z`, and the area `b_j` of the class that
//! faces away from the ray, relative to the projected area of the mesosurface. The mean optical depth over the facets of class `k` is linear
//! in `b`:
//!
//! ```text
//! τ_k = Σ d_kj b_j,   d_kj = w_j E[F_k(z) / F(z)],   z distributed as the heights of class j
//! ```
//!
//! `F_k` is the fraction of class `k` below `z`. The matrix `d` does not depend on the direction, and `Σ w_k d_kj = w_j`. Two heights per
//! class replace the mean. With the variance `v_k` of the depth relative to its square, the fraction of the facets of class `k` that is
//! visible is
//!
//! ```text
//! open(τ) = 1 / (1 + τ + ½ (1 − v_k) τ²)
//! ```
//!
//! The mean and the variance of the depth are those of the mean of `exp(−depth)`. Facets at one height have `v = 0`. The heights of one
//! class that hides only itself give `v = 1`, `τ = Λ` and Smith's `1 / (1 + Λ)`. The depths of all classes are scaled by a factor near 1,
//! so that their visible areas nearly sum to the projected area of the mesosurface. For one class, all results are Smith's.

use glam::{DVec2, DVec3};

use super::correlated::{decorrelation, whitened_direction};
use super::shadowing::Shadowing;
use crate::facets::projected_area::{meso_area, rough_area, slope_spread};
use crate::limits::{MIN_AREA, at_least};
use crate::slopes::grid::slope_cholesky;

/// The maximum number of classes in a pixel.
pub const MOST_CLASSES: usize = 4;
/// Half the distance of the two heights at which a class is evaluated, in standard deviations: the quantiles `½ ± 1/√12`.
const NODE: f64 = 0.801_832_716;
/// The relative variance of `−ln F` at the two heights of one class, whose true value is 1.
const NODE_VARIANCE: f64 = 0.485_702_660;
/// The smallest variance of heights, in the square of their unit.
const MIN_HEIGHT_VARIANCE: f64 = 1e-12;

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

/// The relation of the classes of a footprint, independent of the direction.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassHiding {
    classes: Vec<Class>,
    /// The mean slope of all facets.
    pub mean: DVec2,
    /// The lower Cholesky factor of the slope covariance of all facets ([`slope_cholesky`]).
    pub cholesky: DVec3,
    /// The matrix `d`: entry `[k][j]` is the mean optical depth of class `j` above the facets of class `k`, per unit of `b_j`.
    pub above: [[f64; MOST_CLASSES]; MOST_CLASSES],
    /// `½ (1 − v_k)` of each class, from 0 to ½.
    pub bend: [f64; MOST_CLASSES],
}

/// What the classes of a footprint hide from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassDepths {
    /// The share of each class times its visible area, without hiding by other facets.
    pub areas: [f64; MOST_CLASSES],
    /// The scaled optical depth `τ_k` above the facets of each class.
    pub depths: [f64; MOST_CLASSES],
    /// The [`ClassHiding::bend`] of each class.
    pub bend: [f64; MOST_CLASSES],
    /// `Λ` of all classes: the area that faces away, relative to the projected area of the mesosurface.
    pub lambda: f64,
    /// The direction in the space with isotropic slopes ([`whitened_direction`]).
    pub whitened: DVec2,
    /// The projected area of the mesosurface, which is negative if it faces away.
    pub meso: f64,
}

impl ClassHiding {
    /// Relates at most [`MOST_CLASSES`] classes. The shares are normalised to sum to one.
    pub fn new(classes: &[Class]) -> Self {
        let whole = at_least(classes.iter().map(|class| class.share).sum(), f64::MIN_POSITIVE);
        let classes: Vec<Class> = classes.iter().map(|&class| Class { share: class.share / whole, ..class }).collect();
        let (mut mean, mut square) = (DVec2::ZERO, DVec3::ZERO);
        for &Class { share, mean: m, covariance, .. } in &classes {
            mean += share * m;
            square += share * (covariance + DVec3::new(m.x * m.x, m.y * m.y, m.x * m.y));
        }
        let covariance = square - DVec3::new(mean.x * mean.x, mean.y * mean.y, mean.x * mean.y);
        let variance = |class: &Class| at_least(class.height_variance, MIN_HEIGHT_VARIANCE);
        let (mut above, mut bend) = ([[0.0; MOST_CLASSES]; MOST_CLASSES], [0.0; MOST_CLASSES]);
        for (j, class) in classes.iter().enumerate() {
            let depths = [-NODE, NODE].map(|node| {
                let z = class.height + node * variance(class).sqrt();
                let below: Vec<f64> = classes.iter().map(|of| below(z - of.height, variance(of))).collect();
                let all: f64 = classes.iter().zip(&below).map(|(of, below)| of.share * below).sum();
                for (row, below) in above.iter_mut().zip(&below) {
                    row[j] += 0.5 * class.share * below / at_least(all, f64::MIN_POSITIVE);
                }
                -all.clamp(1e-30, 1.0).ln()
            });
            let spread = (depths[0] - depths[1]) / at_least(depths[0] + depths[1], 1e-12);
            bend[j] = 0.5 - 0.5 * (spread * spread / NODE_VARIANCE).min(1.0);
        }
        Self { classes, mean, cholesky: slope_cholesky(covariance), above, bend }
    }

    /// Returns the areas and the optical depths of the classes from the direction `w`.
    pub fn depths(&self, w: DVec3) -> ClassDepths {
        let meso = meso_area(w, self.mean);
        let per_meso = 1.0 / at_least(meso, MIN_AREA);
        let (mut areas, mut blocking) = ([0.0; MOST_CLASSES], [0.0; MOST_CLASSES]);
        let mut lambda = 0.0;
        for (k, class) in self.classes.iter().enumerate() {
            let a = meso_area(w, class.mean);
            let rough = rough_area(a, slope_spread(w, class.covariance));
            areas[k] = class.share * (a.max(0.0) + rough);
            blocking[k] = ((-a).max(0.0) + rough) * per_meso;
            lambda += class.share * blocking[k];
        }
        let mut depths = self.above.map(|row| row.iter().zip(&blocking).map(|(d, b)| d * b).sum::<f64>());
        let (mut seen, mut hidden) = (0.0, 0.0);
        for ((area, &depth), bend) in areas.iter().zip(&depths).zip(&self.bend) {
            let more = depth + bend * depth * depth;
            let open = area / (1.0 + more);
            (seen, hidden) = (seen + open, hidden + open * more);
        }
        let scale = (lambda * seen + 1e-20) / (hidden + 1e-20);
        depths.iter_mut().for_each(|depth| *depth *= scale);
        ClassDepths { areas, depths, bend: self.bend, lambda, whitened: whitened_direction(w, self.cholesky), meso }
    }
}

/// Returns an approximation of the normal distribution for a variance, without an exponential. It is accurate to 0.05, as real heights
/// are not more Gaussian than that.
fn below(z: f64, variance: f64) -> f64 {
    0.5 + 0.5 * z / (z * z + std::f64::consts::FRAC_PI_2 * variance).sqrt()
}

impl ClassDepths {
    /// Returns the fraction of the facets of class `k` that are open at a `depth`.
    fn open(&self, k: usize, depth: f64) -> f64 {
        1.0 / (1.0 + depth + self.bend[k] * depth * depth)
    }

    /// Returns the fraction of the facets of each class that no other facet hides, among those that face the direction.
    pub fn open_fractions(&self) -> [f64; MOST_CLASSES] {
        std::array::from_fn(|k| self.open(k, self.depths[k]))
    }

    /// Returns the share of each class in the area that is visible. The shares sum to one.
    pub fn visible_shares(&self) -> [f64; MOST_CLASSES] {
        let areas: [f64; MOST_CLASSES] = std::array::from_fn(|k| self.areas[k] * self.open(k, self.depths[k]));
        let whole = at_least(areas.iter().sum(), 1e-30);
        areas.map(|area| area / whole)
    }

    /// Returns the fraction of the facets of each class that is lit from the direction of `light`, among those that are visible. Masking and
    /// shadowing are correlated by height, and by direction as in [`correlated`](super::correlated).
    pub fn lit_fractions(&self, shadowing: Shadowing, light: &Self) -> [f64; MOST_CLASSES] {
        if matches!(shadowing, Shadowing::None | Shadowing::NormalMap) {
            return [1.0; MOST_CLASSES];
        }
        if light.meso <= 0.0 {
            return [0.0; MOST_CLASSES];
        }
        let f = match shadowing {
            Shadowing::Smith => 1.0,
            _ => {
                let (more, less) = (self.lambda.max(light.lambda), self.lambda.min(light.lambda));
                let simple = shadowing == Shadowing::CorrelatedSimple;
                decorrelation(self.whitened, light.whitened, 1.0, more, less, simple)
            }
        };
        std::array::from_fn(|k| {
            let (o, i) = (self.depths[k], light.depths[k]);
            self.open(k, o.max(i) + f * o.min(i)) / self.open(k, o)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::projected_area::visible_area;
    use crate::masking::correlated::{direction_area, lit_fraction};
    use crate::masking::smith::{shadowing_given_masking, smith_lambda};
    use crate::random::Random;
    use std::f64::consts::PI;

    const LIT: [Shadowing; 3] = [Shadowing::Smith, Shadowing::Correlated, Shadowing::CorrelatedSimple];

    fn direction(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    const ONE: Class = Class {
        share: 1.0,
        mean: DVec2::new(0.1, -0.2),
        covariance: DVec3::new(0.3, 0.2, 0.1),
        height: 0.4,
        height_variance: 0.02,
    };

    #[test]
    fn one_class_is_smiths() {
        let one = ClassHiding::new(&[ONE]);
        // Equal classes are one class, too.
        let halves = ClassHiding::new(&[Class { share: 0.2, ..ONE }, Class { share: 0.8, ..ONE }]);
        for (to, ti) in [(0.1, 0.5), (0.9, 1.2), (1.4, 0.3)] {
            let (wo, wi) = (direction(to, 0.4), direction(ti, 2.5));
            let cholesky = slope_cholesky(ONE.covariance);
            let area = |w| direction_area(w, ONE.mean, cholesky);
            for shadowing in LIT {
                let want = lit_fraction(shadowing, &area(wo), &area(wi));
                for (hiding, class) in [(&one, 0), (&halves, 1)] {
                    let lit = hiding.depths(wo).lit_fractions(shadowing, &hiding.depths(wi))[class];
                    assert!((lit / want - 1.0).abs() < 1e-7, "{shadowing:?} {lit} {want}");
                }
            }
            let depth = one.depths(wo).depths[0];
            assert!((depth / smith_lambda(wo, ONE.mean, ONE.covariance) - 1.0).abs() < 1e-7);
            assert_eq!(one.depths(wo).visible_shares()[0], 1.0);
            assert!((halves.depths(wo).visible_shares()[0] - 0.2).abs() < 1e-12);
        }
    }

    /// Tops, walls and bottoms whose mean slopes cancel at every height.
    fn studs() -> [Class; 3] {
        let class = |share, steep: f64, height, height_variance| Class {
            share,
            mean: DVec2::ZERO,
            covariance: DVec3::new(steep, steep, 0.0),
            height,
            height_variance,
        };
        [class(0.3, 1e-4, 1.0, 1e-4), class(0.3, 2.0, 0.5, 0.08), class(0.4, 1e-4, 0.0, 1e-4)]
    }

    /// The visible areas sum to the projected area, within 4 % up to 88 degrees.
    #[test]
    fn visible_areas_sum_to_the_projected_area() {
        let hiding = ClassHiding::new(&studs());
        for theta in [0.0, 0.5, 1.0, 1.3, 1.5, 1.54] {
            let depths = hiding.depths(direction(theta, 0.3));
            let sum: f64 = depths.areas.iter().zip(depths.open_fractions()).map(|(area, open)| area * open).sum();
            println!("{theta}: {}", sum / depths.meso);
            assert!((sum / depths.meso - 1.0).abs() < 0.04, "{theta}: {sum}");
        }
    }

    #[test]
    fn tops_hide_bottoms() {
        let hiding = ClassHiding::new(&studs());
        let (low, high) = (hiding.depths(direction(1.4, 0.0)), hiding.depths(direction(0.4, 0.0)));
        let [top, wall, bottom, _] = low.open_fractions();
        assert!(top > 0.95 && (0.4..0.8).contains(&wall) && bottom < 0.3, "{top} {wall} {bottom}");
        let below = hiding.depths(direction(1.7, 0.0));
        assert_eq!(high.lit_fractions(Shadowing::Correlated, &below), [0.0; MOST_CLASSES]);
        assert_eq!(high.lit_fractions(Shadowing::None, &below), [1.0; MOST_CLASSES]);
        // A viewer beside the light sees what is lit.
        let lit = low.lit_fractions(Shadowing::Correlated, &low);
        assert!(lit[..3].iter().all(|&lit| lit > 0.999_99), "{lit:?}");
    }

    /// Each class is as often above the others as they are below it.
    #[test]
    fn depths_sum_to_the_shares() {
        let hiding = ClassHiding::new(&studs());
        for j in 0..3 {
            let sum: f64 = hiding.classes.iter().zip(&hiding.above).map(|(class, row)| class.share * row[j]).sum();
            assert!((sum - hiding.classes[j].share).abs() < 1e-12, "{sum}");
        }
    }

    /// A facet of a height field.
    struct Facet {
        at: DVec2,
        slope: DVec2,
        height: f64,
        class: usize,
    }

    impl Facet {
        /// Returns the projected area of the facet in a direction that it faces, or 0.
        fn area(&self, w: DVec3) -> f64 {
            meso_area(w, self.slope).max(0.0)
        }
    }

    /// A repeating height field of round studs at random places, in units of texels.
    struct Studs {
        heights: Vec<f64>,
    }

    const SIDE: usize = 384;
    const TALL: f64 = 6.0;

    impl Studs {
        /// Places studs of this radius, with walls of this width around them, whose areas sum to `cover` of the field.
        fn new(radius: f64, wall: f64, cover: f64) -> Self {
            let mut random = Random::stream(3, 0);
            let mut heights = vec![0.0f64; SIDE * SIDE];
            for _ in 0..(cover * (SIDE * SIDE) as f64 / (PI * radius * radius)) as usize {
                let centre = DVec2::new(random.unit(), random.unit()) * SIDE as f64;
                let reach = (radius + wall) as i64 + 1;
                for y in -reach..=reach {
                    for x in -reach..=reach {
                        let [x, y] = [centre.x as i64 + x, centre.y as i64 + y];
                        let distance = (DVec2::new(x as f64, y as f64) - centre).length();
                        let height = TALL * ((radius + wall - distance) / wall).clamp(0.0, 1.0);
                        let [x, y] = [x, y].map(|k| k.rem_euclid(SIDE as i64) as usize);
                        heights[y * SIDE + x] = heights[y * SIDE + x].max(height);
                    }
                }
            }
            Self { heights }
        }

        fn at(&self, at: DVec2) -> f64 {
            let (cell, part) = (at.floor(), at - at.floor());
            let texel = |x: f64, y: f64| {
                let [x, y] = [cell.x + x, cell.y + y].map(|k| k.rem_euclid(SIDE as f64) as usize);
                self.heights[y * SIDE + x]
            };
            let row = |y: f64| (1.0 - part.x) * texel(0.0, y) + part.x * texel(1.0, y);
            (1.0 - part.y) * row(0.0) + part.y * row(1.0)
        }

        /// Returns a seventh of all facets. The class is 0 on tops, 1 on walls and 2 on the ground.
        fn facets(&self) -> Vec<Facet> {
            let facet = |i: usize| {
                let at = DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5);
                let along = |step: DVec2| (self.at(at + step) - self.at(at - step)) / (2.0 * step.length());
                let height = self.at(at);
                let class = if height > 0.98 * TALL { 0 } else { 1 + usize::from(height < 0.02 * TALL) };
                Facet { at, slope: DVec2::new(along(0.25 * DVec2::X), along(0.25 * DVec2::Y)), height, class }
            };
            (0..SIDE * SIDE).step_by(7).map(facet).collect()
        }

        /// Whether a ray from a facet leaves the field. The ray is tested at every half texel.
        fn is_free(&self, facet: &Facet, w: DVec3) -> bool {
            let along = w.truncate().normalize();
            let rise = w.z / w.truncate().length();
            let last = (2.0 * (TALL - facet.height) / rise) as usize;
            (1..=last).map(|i| 0.5 * i as f64).all(|t| self.at(facet.at + t * along) <= facet.height + t * rise + 1e-6)
        }
    }

    fn class_of(facets: &[Facet], class: Option<usize>) -> Class {
        let of: Vec<&Facet> = facets.iter().filter(|facet| class.is_none_or(|class| facet.class == class)).collect();
        let mean = |f: &dyn Fn(&Facet) -> f64| of.iter().map(|facet| f(facet)).sum::<f64>() / of.len() as f64;
        let (slope, height) = (DVec2::new(mean(&|f| f.slope.x), mean(&|f| f.slope.y)), mean(&|f| f.height));
        let off = |f: &Facet| f.slope - slope;
        Class {
            share: of.len() as f64 / facets.len() as f64,
            mean: slope,
            covariance: DVec3::new(
                mean(&|f| off(f).x.powi(2)),
                mean(&|f| off(f).y.powi(2)),
                mean(&|f| off(f).x * off(f).y),
            ),
            height,
            height_variance: mean(&|f| (f.height - height).powi(2)),
        }
    }

    /// The visible share of each class, and the light that arrives on what is visible, agree with ray casts. The same lobes without
    /// heights are several times as far off.
    #[test]
    fn shares_and_light_follow_ray_casts() {
        for (radius, wall, cover) in [(9.0, 4.0, 0.5), (14.0, 10.0, 0.35), (5.0, 6.0, 0.9)] {
            let studs = Studs::new(radius, wall, cover);
            let facets = studs.facets();
            let classes = [0, 1, 2].map(|class| class_of(&facets, Some(class)));
            let (hiding, one) = (ClassHiding::new(&classes), class_of(&facets, None));
            // The largest errors: of the shares, with heights and without; of the arriving light, with classes and for one class.
            let mut worst = [0.0f64; 4];
            for theta in [20f64, 45.0, 60.0, 70.0, 80.0] {
                let wo = direction(theta.to_radians(), 0.3);
                let seen: Vec<&Facet> = facets.iter().filter(|f| f.area(wo) > 0.0 && studs.is_free(f, wo)).collect();
                let sums = |f: &dyn Fn(&Facet) -> f64| {
                    let mut sums = [0.0; 3];
                    seen.iter().for_each(|facet| sums[facet.class] += f(facet));
                    sums
                };
                let shares = |areas: [f64; 3]| areas.map(|area| area / areas.iter().sum::<f64>());
                let truth = shares(sums(&|f| f.area(wo)));
                let of_classes = hiding.depths(wo).visible_shares();
                let of_lobes =
                    shares(classes.map(|class| class.share * visible_area(wo, class.mean, class.covariance)));
                for class in 0..3 {
                    worst[0] = worst[0].max((of_classes[class] - truth[class]).abs());
                    worst[1] = worst[1].max((of_lobes[class] - truth[class]).abs());
                }
                for (theta, azimuth) in [(30f64, 0.3), (60.0, 2.0), (75.0, 3.4)] {
                    let wi = direction(theta.to_radians(), azimuth);
                    let facing = sums(&|f| f.area(wo) * f.area(wi));
                    let lit = sums(&|f| if studs.is_free(f, wi) { f.area(wo) * f.area(wi) } else { 0.0 });
                    let whole: f64 = facing.iter().sum();
                    let truth = lit.iter().sum::<f64>() / whole;
                    let fractions = hiding.depths(wo).lit_fractions(Shadowing::Correlated, &hiding.depths(wi));
                    let of_classes = facing.iter().zip(fractions).map(|(area, lit)| area * lit).sum::<f64>() / whole;
                    let of_one = shadowing_given_masking(wo, wi, one.mean, one.covariance, true);
                    worst[2] = worst[2].max((of_classes - truth).abs());
                    worst[3] = worst[3].max((of_one - truth).abs());
                }
            }
            println!("studs {radius} {wall} {cover}: {worst:.3?}");
            assert!(worst[0] < 0.04 && worst[0] < 0.3 * worst[1], "{worst:?}");
            assert!(worst[2] < 0.045 && worst[2] < 0.6 * worst[3], "{worst:?}");
        }
    }
}
