//! Masking and shadowing of a relief whose facets form classes, such as tops, walls and bottoms. A class has its own slopes and its own
//! heights, so high classes hide low ones.
//!
//! Smith's derivation follows a ray upwards. At height `z`, the ray meets the surface at the rate `Σ wₖ pₖ(z) Λₖ / F(z)`, with the density
//! of heights `pₖ` of a class and the fraction `F` of the surface below `z`. For one class, a facet at height `h` is visible with the
//! probability `F(h)^Λ`. Here, heights are divided into layers. In a layer, each class has a constant share of the facets, so the
//! probability is a product of powers. The sum over the layers telescopes: the visible areas of all classes add up to the projected area
//! of the relief, for any number of layers, and one class gives exactly `1 / (1 + Λ)`.

use glam::{DVec2, DVec3};

use crate::facets::normal_distribution::normal_cdf;
use crate::facets::projected_area::{meso_area, visible_area};
use crate::limits::{MIN_AREA, at_least};

/// The maximum number of classes in a pixel.
pub const MOST_CLASSES: usize = 4;
/// The heights that bound the layers of a class, in standard deviations about its mean height.
const BOUNDS: [f64; 3] = [-1.2, 0.0, 1.2];
/// The maximum number of layers.
const MOST_LAYERS: usize = BOUNDS.len() * MOST_CLASSES + 1;

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

/// The heights of several classes, divided into layers.
#[derive(Clone, Debug)]
pub struct Layers {
    classes: Vec<Class>,
    mean: DVec2,
    /// The share of each class in each layer, from the top down.
    shares: Vec<[f64; MOST_CLASSES]>,
}

impl Layers {
    /// Divides the heights of at most [`MOST_CLASSES`] classes into layers. The shares are normalised to sum to one.
    pub fn new(classes: &[Class]) -> Self {
        let whole = at_least(classes.iter().map(|class| class.share).sum(), f64::MIN_POSITIVE);
        let classes: Vec<Class> = classes.iter().map(|&class| Class { share: class.share / whole, ..class }).collect();
        let deviation = |class: &Class| at_least(class.height_variance, 0.0).sqrt();
        let mut bounds: Vec<f64> =
            classes.iter().flat_map(|class| BOUNDS.map(|x| class.height + x * deviation(class))).collect();
        bounds.sort_by(|a, b| b.total_cmp(a));
        bounds.push(f64::NEG_INFINITY);
        let below = |class: &Class, z: f64| class.share * normal_cdf((z - class.height) / deviation(class).max(1e-12));
        let mut left = [0.0; MOST_CLASSES];
        classes.iter().zip(&mut left).for_each(|(class, left)| *left = class.share);
        let mut shares = Vec::with_capacity(MOST_LAYERS);
        for &bound in &bounds {
            let mut layer = [0.0; MOST_CLASSES];
            for ((class, left), share) in classes.iter().zip(&mut left).zip(&mut layer) {
                let under = if bound == f64::NEG_INFINITY { 0.0 } else { below(class, bound) };
                *share = (*left - under).max(0.0);
                *left = under;
            }
            shares.push(layer);
        }
        let mean = classes.iter().map(|class| class.share * class.mean).sum();
        Self { classes, mean, shares }
    }

    /// Returns the fraction of the facets of each class that no other facet hides from any of the directions. `blocking` has the area of
    /// each class that faces away from the directions, summed over the directions, relative to the projected area of the mesosurface.
    fn unhidden(&self, blocking: &[f64; MOST_CLASSES]) -> [f64; MOST_CLASSES] {
        let mut open = [0.0; MOST_CLASSES];
        let (mut below, mut visible) = (1.0, 1.0);
        for layer in &self.shares {
            let mass: f64 = layer.iter().sum();
            if mass <= 0.0 {
                continue;
            }
            let lambda = layer.iter().zip(blocking).map(|(share, blocks)| share * blocks).sum::<f64>() / mass;
            // The bottom of the layer, relative to its top, as fractions of the surface below.
            let rest = ((below - mass) / below).clamp(0.0, 1.0);
            let power = rest.powf(lambda + 1.0);
            let mean = visible * (1.0 - power) / ((lambda + 1.0) * (1.0 - rest));
            open.iter_mut().zip(layer).for_each(|(open, share)| *open += share * mean);
            (below, visible) = (below - mass, if rest > 0.0 { visible * power / rest } else { 0.0 });
        }
        for (open, class) in open.iter_mut().zip(&self.classes) {
            *open /= at_least(class.share, f64::MIN_POSITIVE);
        }
        open
    }

    /// Returns the area of each class that faces away from `w`, relative to the projected area of the mesosurface.
    fn blocking(&self, w: DVec3) -> [f64; MOST_CLASSES] {
        let meso = at_least(meso_area(w, self.mean), MIN_AREA);
        let mut blocking = [0.0; MOST_CLASSES];
        for (class, blocks) in self.classes.iter().zip(&mut blocking) {
            *blocks = (visible_area(w, class.mean, class.covariance) - meso_area(w, class.mean)) / meso;
        }
        blocking
    }

    /// Returns the share of each class in the area that is visible from `wo`. The shares sum to one.
    pub fn visible_shares(&self, wo: DVec3) -> [f64; MOST_CLASSES] {
        let mut areas = self.unhidden(&self.blocking(wo));
        for (area, class) in areas.iter_mut().zip(&self.classes) {
            *area *= class.share * visible_area(wo, class.mean, class.covariance);
        }
        let whole = at_least(areas.iter().sum(), f64::MIN_POSITIVE);
        areas.map(|area| area / whole)
    }

    /// Returns the fraction of the facets of each class that is lit from `wi`, among those that are visible from `wo`. Masking and
    /// shadowing are correlated by height.
    pub fn lit_fractions(&self, wo: DVec3, wi: DVec3) -> [f64; MOST_CLASSES] {
        let seen = self.blocking(wo);
        if meso_area(wi, self.mean) <= 0.0 {
            return [0.0; MOST_CLASSES];
        }
        let lit = self.blocking(wi);
        let both: [f64; MOST_CLASSES] = std::array::from_fn(|k| seen[k] + lit[k]);
        let (seen, both) = (self.unhidden(&seen), self.unhidden(&both));
        std::array::from_fn(|k| if seen[k] > 0.0 { both[k] / seen[k] } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::masking::smith::{shadowing_given_masking, smith_lambda};
    use crate::random::Random;
    use std::f64::consts::PI;

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
        let layers = Layers::new(&[ONE]);
        // Equal classes are one class, too.
        let halves = Layers::new(&[Class { share: 0.2, ..ONE }, Class { share: 0.8, ..ONE }]);
        for (to, ti) in [(0.1, 0.5), (0.9, 1.2), (1.4, 0.3)] {
            let (wo, wi) = (direction(to, 0.4), direction(ti, 2.5));
            let smith = shadowing_given_masking(wo, wi, ONE.mean, ONE.covariance, true);
            assert!((layers.lit_fractions(wo, wi)[0] / smith - 1.0).abs() < 1e-12);
            assert!((halves.lit_fractions(wo, wi)[1] / smith - 1.0).abs() < 1e-12);
            let seen = layers.unhidden(&layers.blocking(wo))[0];
            assert!((seen * (1.0 + smith_lambda(wo, ONE.mean, ONE.covariance)) - 1.0).abs() < 1e-12);
            assert_eq!(layers.visible_shares(wo)[0], 1.0);
            assert!((halves.visible_shares(wo)[0] - 0.2).abs() < 1e-12);
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

    #[test]
    fn visible_areas_sum_to_the_projected_area() {
        let layers = Layers::new(&studs());
        for theta in [0.0, 0.5, 1.0, 1.3, 1.5, 1.56] {
            let wo = direction(theta, 0.3);
            let open = layers.unhidden(&layers.blocking(wo));
            let area = |k: usize| {
                let class = &layers.classes[k];
                class.share * open[k] * visible_area(wo, class.mean, class.covariance)
            };
            let sum: f64 = (0..3).map(area).sum();
            assert!((sum / wo.z - 1.0).abs() < 1e-9, "{theta}: {sum}");
        }
    }

    #[test]
    fn tops_hide_bottoms() {
        let layers = Layers::new(&studs());
        let [top, wall, bottom, _] = layers.unhidden(&layers.blocking(direction(1.4, 0.0)));
        assert!(top > 0.95 && (0.4..0.8).contains(&wall) && bottom < 0.3, "{top} {wall} {bottom}");
        assert_eq!(layers.lit_fractions(direction(0.4, 0.0), direction(1.7, 0.0)), [0.0; MOST_CLASSES]);
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
            let (layers, one) = (Layers::new(&classes), class_of(&facets, None));
            // The largest errors: of the shares, with layers and without; of the arriving light, with layers and for one class.
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
                let of_layers = layers.visible_shares(wo);
                let of_lobes =
                    shares(classes.map(|class| class.share * visible_area(wo, class.mean, class.covariance)));
                for class in 0..3 {
                    worst[0] = worst[0].max((of_layers[class] - truth[class]).abs());
                    worst[1] = worst[1].max((of_lobes[class] - truth[class]).abs());
                }
                for (theta, azimuth) in [(30f64, 0.3), (60.0, 2.0), (75.0, 3.4)] {
                    let wi = direction(theta.to_radians(), azimuth);
                    let facing = sums(&|f| f.area(wo) * f.area(wi));
                    let lit = sums(&|f| if studs.is_free(f, wi) { f.area(wo) * f.area(wi) } else { 0.0 });
                    let whole: f64 = facing.iter().sum();
                    let truth = lit.iter().sum::<f64>() / whole;
                    let fractions = layers.lit_fractions(wo, wi);
                    let of_layers = facing.iter().zip(fractions).map(|(area, lit)| area * lit).sum::<f64>() / whole;
                    let of_one = shadowing_given_masking(wo, wi, one.mean, one.covariance, true);
                    worst[2] = worst[2].max((of_layers - truth).abs());
                    worst[3] = worst[3].max((of_one - truth).abs());
                }
            }
            println!("studs {radius} {wall} {cover}: {worst:.3?}");
            assert!(worst[0] < 0.035 && worst[0] < 0.25 * worst[1], "{worst:?}");
            assert!(worst[2] < 0.03 && worst[2] < 0.4 * worst[3], "{worst:?}");
        }
    }
}
