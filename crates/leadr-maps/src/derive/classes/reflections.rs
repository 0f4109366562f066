//! What the facets of a relief reflect, and what classes of them reflect instead, each by the model of the renderer.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::projected_area::{meso_area, visible_area};
use leadr_reflectance::integrals::facet_specular::{
    FacetSpecular, facet_specular, facet_specular_density, single_facet_density,
};
use leadr_reflectance::masking::classes::{Azimuths, class_lit_fraction};
use leadr_reflectance::masking::correlated::whitened_direction;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::slope_cholesky;
use leadr_reflectance::visible::class_environment::mean_cosine;
use leadr_reflectance::visible::diffuse::visible_diffuse_moments;
use rayon::prelude::*;

use super::facets::Sample;
use crate::derive::openness::{CorrelationFit, Field, PairArea, turned};

/// The Beckmann roughness of the base material at which reflections are compared.
const ALPHA: f64 = 0.35;
/// The weight of an error of the diffuse reflection, relative to the same error of the specular reflection.
const DIFFUSE: f64 = 3.0;

/// The number of azimuths of viewers and lights.
const AZIMUTHS: usize = 8;
/// The first azimuth in radians, so that no direction is along the rows or columns of a map.
const FIRST_AZIMUTH: f64 = 0.2;
/// The polar angles in degrees and the azimuths of the viewers.
const VIEWS: [(f64, usize); 9] =
    [(15.0, 0), (15.0, 3), (15.0, 6), (50.0, 1), (50.0, 4), (50.0, 7), (75.0, 2), (75.0, 5), (75.0, 0)];
/// The polar angles of the lights in degrees, each at all azimuths.
const LIGHTS: [f64; 2] = [30.0, 60.0];

const LIGHT_COUNT: usize = LIGHTS.len() * AZIMUTHS;
const PAIRS: usize = VIEWS.len() * LIGHT_COUNT;

/// A direction of the space where slopes are rise over run.
#[derive(Clone, Copy)]
struct Direction {
    w: DVec3,
    azimuth: usize,
}

impl Direction {
    fn new(polar: f64, azimuth: usize) -> Self {
        let ((sin, cos), (y, x)) = (polar.to_radians().sin_cos(), angle(azimuth).sin_cos());
        Self { w: DVec3::new(sin * x, sin * y, cos), azimuth }
    }
}

fn angle(azimuth: usize) -> f64 {
    FIRST_AZIMUTH + TAU * azimuth as f64 / AZIMUTHS as f64
}

fn views() -> [Direction; VIEWS.len()] {
    VIEWS.map(|(polar, azimuth)| Direction::new(polar, azimuth))
}

fn lights() -> [Direction; LIGHT_COUNT] {
    std::array::from_fn(|i| Direction::new(LIGHTS[i / AZIMUTHS], i % AZIMUTHS))
}

/// A facet with its slope and slope covariance in rise over run.
struct Lit {
    slope: DVec2,
    covariance: DVec3,
    /// Whether no other facet hides it, as a bit for each view and for each light.
    open: [u32; 2],
}

impl Lit {
    fn specular(&self, light: &FacetSpecular) -> f64 {
        if self.covariance.x + self.covariance.y > 0.0 {
            facet_specular_density(light, self.slope, slope_cholesky(self.covariance), Shadowing::Correlated)
        } else {
            single_facet_density(light, self.slope, Shadowing::Correlated)
        }
    }
}

/// The light of a class or of all facets: for each view its visible area, and for each pair of view and light the specular and the
/// diffuse reflection, multiplied by this area.
#[derive(Clone)]
pub(super) struct Light {
    area: [f32; VIEWS.len()],
    reflected: [[f32; PAIRS]; 2],
}

impl Light {
    const NONE: Self = Self { area: [0.0; VIEWS.len()], reflected: [[0.0; PAIRS]; 2] };
}

/// Sums over the facets of a class.
#[derive(Clone)]
pub(super) struct Sums {
    number: f64,
    slope: DVec2,
    second: DVec3,
    /// The projected area towards each view and light, and the part of it that is open.
    area: [[f64; 2]; VIEWS.len() + LIGHT_COUNT],
    pairs: [PairArea; PAIRS],
}

impl Sums {
    pub fn join(&mut self, other: &Self) {
        self.number += other.number;
        self.slope += other.slope;
        self.second += other.second;
        self.area.as_flattened_mut().iter_mut().zip(other.area.as_flattened()).for_each(|(sum, area)| *sum += area);
        self.pairs.iter_mut().zip(&other.pairs).for_each(|(sum, pair)| sum.join(pair));
    }
}

/// The reflections of facets.
pub(super) struct Reflections {
    facets: Vec<Lit>,
    /// The lobe of each pair on a facet.
    lobes: Vec<FacetSpecular>,
    /// The Cholesky factor of the slope covariance of all facets.
    cholesky: DVec3,
    /// The specular and the diffuse reflection of each pair, and the weight of an error.
    truth: [[f32; PAIRS]; 2],
    weight: [[f32; PAIRS]; 2],
}

impl Reflections {
    /// Computes the reflections. `fields` are those of the windows. `scale` converts slopes to rise over run. It is negative if the
    /// heights are inverted.
    pub fn new(fields: &[Field], samples: &[Sample], scale: DVec2) -> Self {
        let seen = open_to(fields, samples, scale);
        let squares = DVec3::new(scale.x * scale.x, scale.y * scale.y, scale.x * scale.y);
        let facets: Vec<Lit> = samples
            .iter()
            .zip(seen)
            .map(|(Sample { facet, .. }, open)| Lit {
                slope: scale * facet.point.truncate(),
                covariance: squares * facet.spread,
                open,
            })
            .collect();
        let number = facets.len().max(1) as f64;
        let mean = facets.iter().map(|facet| facet.slope).sum::<DVec2>() / number;
        let covariance =
            facets.iter().map(|facet| facet.covariance + square(facet.slope - mean)).sum::<DVec3>() / number;
        let lobe = |view: Direction| lights().map(|light| facet_specular(view.w, light.w, ALPHA, 0.0));
        let lobes: Vec<FacetSpecular> = views().into_iter().flat_map(lobe).collect();
        let light = Self::of_facets(&facets, &lobes);
        let mut truth = light.reflected;
        for terms in &mut truth {
            for (terms, area) in terms.chunks_exact_mut(LIGHT_COUNT).zip(light.area) {
                terms.iter_mut().for_each(|term| *term /= area.max(1e-9));
            }
        }
        // Errors are relative to the mean of the reflection and of all reflections.
        let weight = truth.map(|terms| {
            let mean = (terms.iter().sum::<f32>() / PAIRS as f32).max(1e-9);
            terms.map(|term| 2.0 / (term + mean))
        });
        Self { facets, lobes, cholesky: slope_cholesky(covariance), truth, weight }
    }

    fn of_facets(facets: &[Lit], lobes: &[FacetSpecular]) -> Light {
        let lights = lights();
        let per = 1.0 / facets.len().max(1) as f64;
        let (mut area, mut reflected) = ([0.0; VIEWS.len()], [[0.0; PAIRS]; 2]);
        let rows: Vec<(f64, [[f64; 2]; LIGHT_COUNT])> = views()
            .par_iter()
            .enumerate()
            .map(|(v, view)| {
                let (mut area, mut terms) = (0.0, [[0.0; 2]; LIGHT_COUNT]);
                let lobes = &lobes[v * LIGHT_COUNT..][..LIGHT_COUNT];
                for facet in facets.iter().filter(|facet| facet.open[0] >> v & 1 == 1) {
                    let seen = meso_area(view.w, facet.slope).max(0.0);
                    let length = facet.slope.extend(1.0).length();
                    area += seen;
                    for (i, ([specular, diffuse], light)) in terms.iter_mut().zip(&lights).enumerate() {
                        if facet.open[1] >> i & 1 == 1 {
                            *specular += facet.specular(&lobes[i]);
                            *diffuse += seen * meso_area(light.w, facet.slope).max(0.0) / length;
                        }
                    }
                }
                (area, terms)
            })
            .collect();
        for (v, (of_view, terms)) in rows.into_iter().enumerate() {
            area[v] = (per * of_view) as f32;
            for (i, terms) in terms.into_iter().enumerate() {
                (0..2).for_each(|k| reflected[k][v * LIGHT_COUNT + i] = (per * terms[k]) as f32);
            }
        }
        Light { area, reflected }
    }

    /// Returns the sums over the facets of each class.
    pub fn sums(&self, class_of: &[usize], count: usize) -> Vec<Sums> {
        let (views, lights) = (views(), lights());
        let of_class = |class: usize| {
            let mut sums = Sums {
                number: 0.0,
                slope: DVec2::ZERO,
                second: DVec3::ZERO,
                area: [[0.0; 2]; VIEWS.len() + LIGHT_COUNT],
                pairs: [PairArea::default(); PAIRS],
            };
            for (facet, _) in self.facets.iter().zip(class_of).filter(|(_, of)| **of == class) {
                sums.number += 1.0;
                sums.slope += facet.slope;
                sums.second += facet.covariance + square(facet.slope);
                let area = |direction: &Direction| meso_area(direction.w, facet.slope).max(0.0);
                let (of_views, of_lights) = (views.each_ref().map(area), lights.each_ref().map(area));
                let open = |k: usize, i: usize| facet.open[k] >> i & 1 == 1;
                let directions = of_views.iter().enumerate().map(|(i, area)| (area, open(0, i)));
                let directions = directions.chain(of_lights.iter().enumerate().map(|(i, area)| (area, open(1, i))));
                for (sum, (area, open)) in sums.area.iter_mut().zip(directions) {
                    sum[0] += area;
                    sum[1] += if open { *area } else { 0.0 };
                }
                for (p, pair) in sums.pairs.iter_mut().enumerate() {
                    let (v, i) = (p / LIGHT_COUNT, p % LIGHT_COUNT);
                    pair.add(of_views[v] * of_lights[i], open(0, v), open(1, i));
                }
            }
            sums
        };
        (0..count).into_par_iter().map(of_class).collect()
    }

    /// Returns the light of a class by the model.
    pub fn of_class(&self, sums: &Sums) -> Light {
        let mut light = Light::NONE;
        if sums.number < 1.0 {
            return light;
        }
        let share = sums.number / self.facets.len() as f64;
        let mean = sums.slope / sums.number;
        let covariance = sums.second / sums.number - square(mean);
        let cholesky = slope_cholesky(covariance);
        let mut fit = CorrelationFit::default();
        let (views, lights) = (views(), lights());
        for (p, pair) in sums.pairs.iter().enumerate() {
            let steps = views[p / LIGHT_COUNT].azimuth.abs_diff(lights[p % LIGHT_COUNT].azimuth);
            if steps > 0 {
                fit.add(pair, sums.number, turned(steps, AZIMUTHS));
            }
        }
        let correlation = fit.correlation();
        let open = |at: usize| {
            let [all, open] = sums.area[at];
            if all > 0.0 { open / all } else { 0.0 }
        };
        let whitened = |direction: &Direction| whitened_direction(direction.w, self.cholesky);
        let of_lights: [_; LIGHT_COUNT] =
            std::array::from_fn(|i| (lights[i].w, open(VIEWS.len() + i), whitened(&lights[i])));
        for (v, view) in views.iter().enumerate() {
            let seen = open(v);
            let area = share * seen * visible_area(view.w, mean, covariance);
            let normals = visible_diffuse_moments(view.w, mean, covariance, 2);
            let own = whitened(view);
            light.area[v] = area as f32;
            for (i, (wi, open, other)) in of_lights.iter().enumerate() {
                let apart = Azimuths::between(own, *other);
                let lit = class_lit_fraction(Shadowing::Correlated, &correlation, [seen, *open], apart);
                let p = v * LIGHT_COUNT + i;
                let density = facet_specular_density(&self.lobes[p], mean, cholesky, Shadowing::Correlated);
                light.reflected[0][p] = (share * seen * lit * density) as f32;
                light.reflected[1][p] = (area * lit * mean_cosine(&normals, *wi)) as f32;
            }
        }
        light
    }

    /// Returns the relative RMS error of the light of all classes together, for single lights and for all lights of a viewer together.
    pub fn error<'a>(&self, classes: impl Iterator<Item = &'a Light> + Clone) -> f64 {
        let mut squares = 0.0;
        for (term, weight) in [1.0, DIFFUSE * DIFFUSE].into_iter().enumerate() {
            let (mut of_pairs, mut of_skies) = (0.0, 0.0);
            for v in 0..VIEWS.len() {
                let area: f32 = classes.clone().map(|light| light.area[v]).sum();
                let per = 1.0 / area.max(1e-9);
                let row = v * LIGHT_COUNT..(v + 1) * LIGHT_COUNT;
                let mut sums = [0.0; LIGHT_COUNT];
                for light in classes.clone() {
                    sums.iter_mut().zip(&light.reflected[term][row.clone()]).for_each(|(sum, part)| *sum += part);
                }
                let (truth, weights) = (&self.truth[term][row.clone()], &self.weight[term][row]);
                let (mut found, mut whole) = (0.0, 0.0);
                for ((sum, truth), weight) in sums.iter().zip(truth).zip(weights) {
                    let off = sum * per - truth;
                    of_pairs += (off * weight) * (off * weight);
                    found += off;
                    whole += truth;
                }
                of_skies += (found / whole.max(1e-9)).powi(2);
            }
            squares += weight * f64::from(of_pairs / PAIRS as f32 + of_skies / VIEWS.len() as f32);
        }
        squares.sqrt()
    }
}

/// Returns, for each facet, the views and the lights to which no other facet hides it.
fn open_to(fields: &[Field], samples: &[Sample], scale: DVec2) -> Vec<[u32; 2]> {
    let tangent = |direction: &Direction| direction.w.truncate().length() / direction.w.z;
    let (views, lights) = (views(), lights());
    let most = views.iter().chain(&lights).map(tangent).fold(0.0, f64::max);
    let of_facet = |Sample { facet, window, at, .. }: &Sample| {
        let height = scale.x.signum() * facet.point.z;
        let reaches: [f64; AZIMUTHS] = std::array::from_fn(|azimuth| {
            let (y, x) = angle(azimuth).sin_cos();
            fields[*window].reach(*at, height, scale.abs() * DVec2::new(x, y), most)
        });
        let bits = |directions: &[Direction]| {
            let open = |direction: &Direction| u32::from(tangent(direction) < reaches[direction.azimuth]);
            directions.iter().enumerate().map(|(i, direction)| open(direction) << i).sum()
        };
        [bits(&views), bits(&lights)]
    };
    samples.par_iter().map(of_facet).collect()
}

fn square(v: DVec2) -> DVec3 {
    DVec3::new(v.x * v.x, v.y * v.y, v.x * v.y)
}
