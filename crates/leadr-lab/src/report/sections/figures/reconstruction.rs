//! Draws Figure 5 of the LEADR supplement: the reconstruction filters of the grid and of importance samples, for two views, and the
//! environment that they reconstruct.

use glam::{DVec2, DVec3};

use super::environment::{Directions, EXPOSURE, Lookups, reconstructions};
use crate::quadrature_study::fit_probes::{kernel, reflected_density};
use crate::quadrature_study::samplers::{Filter, Sampler, solid_angle};
use crate::quadrature_study::surfaces::{Surface, spherical};
use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_maps::RgbImage;
use leadr_reflectance::integrals::specular::environment_sample_at;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::visible::specular::{VisibleProbe, probe_rule, visible_probe, visible_probes};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};
use std::f64::consts::PI;

/// The slope deviation.
const SIGMA: f64 = 0.25;
/// The angles of the two viewers, in degrees.
const VIEWS: [f64; 2] = [20.0, 70.0];
const ORDERS: [u32; 4] = [3, 5, 7, 9];
/// The number of random configurations of the importance samples.
const CONFIGURATIONS: u64 = 16;
/// The number of pixels between two filters.
const GAP: u32 = 4;

/// A filter: weights, directions and variances of round kernels. The weights sum to 1.
pub type Kernels = Vec<(f64, DVec3, f64)>;

fn surface(degrees: f64) -> Surface {
    Surface {
        wo: spherical(degrees.to_radians(), 0.0),
        m: DVec2::ZERO,
        s: DVec3::new(SIGMA * SIGMA, SIGMA * SIGMA, 0.0),
    }
}

/// Returns the kernels of a sampler. A lookup that covers the solid angle `Ω` of a mip level has the variance `Ω/4`.
pub fn kernels(surface: &Surface, sampler: Sampler, n: u32, filter: Filter) -> Kernels {
    let nodes = sampler.nodes(surface, n);
    let sum: f64 = nodes.iter().map(|p| p.weight).sum();
    let of = |p| solid_angle(surface, p, filter) / 4.0;
    nodes.iter().map(|p| (p.weight / sum, environment_sample_at(surface.wo, p.slope).wi, of(p))).collect()
}

/// Returns the kernels of a rule with `n` probes.
pub fn probe_kernels(surface: &Surface, n: u32) -> Kernels {
    let Surface { wo, m, s } = *surface;
    let rule = probe_rule(n);
    let probes = visible_probes(Shadowing::None, wo, m, s, rule.kernel);
    let kernel = |p: VisibleProbe| (p.weight, p.wi, p.variance);
    let mut kernels: Kernels = rule.nodes(probes.wide).map(|node| kernel(visible_probe(&probes, wo, &node))).collect();
    let sum: f64 = kernels.iter().map(|k| k.0).sum();
    kernels.iter_mut().for_each(|k| k.0 /= sum);
    kernels
}

/// Returns the density of a filter per steradian.
pub fn density(kernels: &Kernels, wi: DVec3) -> f64 {
    kernels.iter().map(|&(w, axis, variance)| w * kernel(variance, axis.dot(wi))).sum()
}

/// Computes the RMS difference of two densities over all directions, relative to the RMS of the second.
fn difference(a: &dyn Fn(DVec3) -> f64, b: &dyn Fn(DVec3) -> f64, rings: u32) -> f64 {
    let (mut error, mut truth) = (0.0, 0.0);
    for i in 0..rings {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(rings);
        for k in 0..2 * rings {
            let wi = ((1.0 - z * z).sqrt() * DVec2::from_angle(PI * (f64::from(k) + 0.5) / f64::from(rings))).extend(z);
            let (a, b) = (a(wi), b(wi));
            error += (a - b).powi(2);
            truth += b * b;
        }
    }
    (error / truth.max(1e-12)).sqrt()
}

/// Draws densities side by side, over the hemisphere seen from above. White is the largest density of the last one.
fn sheet(densities: &[&dyn Fn(DVec3) -> f64], size: u32) -> RgbImage {
    let (width, height) = (densities.len() as u32 * (size + GAP) + GAP, size + 2 * GAP);
    let mut values = vec![f64::NAN; (width * height) as usize];
    let mut white = 0.0;
    for (k, density) in (0u32..).zip(densities) {
        white = 0.0;
        for i in 0..size * size {
            let at = |j: u32| (2.0 * f64::from(j) + 1.0) / f64::from(size) - 1.0;
            let p = DVec2::new(at(i % size), -at(i / size));
            if p.length_squared() < 1.0 {
                let value = density(p.extend((1.0 - p.length_squared()).sqrt()));
                white = f64::max(white, value);
                let (x, y) = (GAP + k * (size + GAP) + i % size, GAP + i / size);
                values[(y * width + x) as usize] = value;
            }
        }
    }
    // Directions outside the hemisphere are grey.
    let color = |v: f64| if v.is_nan() { [0.2; 3] } else { [(v / white.max(1e-12)) as f32; 3] };
    RgbImage { width, height, texels: values.into_iter().map(color).collect() }
}

/// Returns the mean and the largest of some errors.
fn mean_and_max(errors: &[f64]) -> (f64, f64) {
    (errors.iter().sum::<f64>() / errors.len() as f64, errors.iter().copied().fold(0.0, f64::max))
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Supplement Figure 5",
        "Reconstruction filters of specular facets with slope deviation .25, for viewers at 20° and 70° on the right: the directions of \
        light, seen from above, with the weight of each in the picture. Left to right: 3×3, 5×5, 7×7 and 9×9 samples, and the exact \
        density. Importance samples are stratified and random; two configurations are shown. Footprints match the density of samples. \
        Probes: 5, 9 and 16. Then the studio as the same filters reconstruct it, where their weight is at least 2 % of its largest: the \
        whole studio, the part that the facets reflect, and the reconstructions.",
    );
    let (size, rings) = studio.pick((48, 60), (128, 160));
    let environment = Directions::new(rings);
    let mut table = Table::new(
        "RMS difference from the exact density, relative to its RMS",
        [
            "viewer",
            "samples",
            "grid",
            "importance: mean",
            "importance: largest",
            "Hammersley",
            "visible normals, centred",
        ],
    );
    for degrees in VIEWS {
        let surface = surface(degrees);
        let exact = |wi: DVec3| reflected_density(&surface, wi)[0];
        let mut draw_row = |name: &str, filters: &[Kernels]| -> Result<(), LabError> {
            let densities: Vec<_> = filters.iter().map(|k| move |wi: DVec3| density(k, wi)).collect();
            let mut all: Vec<&dyn Fn(DVec3) -> f64> = densities.iter().map(|d| d as &dyn Fn(DVec3) -> f64).collect();
            all.push(&exact);
            let file = format!("figures-reconstruction-{}-{degrees}", name.replace(' ', "-"));
            let caption = vec![format!("{name}, {degrees}°")];
            let figure = studio.picture(&file, &sheet(&all, size), 1.0, name, caption)?;
            page.html.figures(&[figure]);
            Ok(())
        };
        let of = |sampler: Sampler| ORDERS.map(|n| kernels(&surface, sampler, n, Filter::Density));
        draw_row("uniform grid", &of(Sampler::Grid))?;
        draw_row("importance samples 1", &of(Sampler::Stratified { seed: 1 }))?;
        draw_row("importance samples 2", &of(Sampler::Stratified { seed: 2 }))?;
        draw_row("probes", &[5, 9, 16].map(|n| probe_kernels(&surface, n)))?;
        let mut draw_studio = |name: &str, filters: &[Kernels]| -> Result<(), LabError> {
            let lookups: Vec<Lookups> = filters.iter().map(|k| Lookups::new(k.clone(), &environment)).collect();
            let image = reconstructions(&surface, &lookups, &environment, size);
            let file = format!("figures-reconstruction-{}-{degrees}-studio", name.replace(' ', "-"));
            let caption = vec![format!("studio by {name}, {degrees}°")];
            page.html.figures(&[studio.picture(&file, &image, EXPOSURE, "reconstructed environment", caption)?]);
            Ok(())
        };
        draw_studio("uniform grid", &of(Sampler::Grid))?;
        draw_studio("importance samples 1", &of(Sampler::Stratified { seed: 1 }))?;
        draw_studio("importance samples 2", &of(Sampler::Stratified { seed: 2 }))?;
        let reflected = environment.mean(exact);
        let radiance_error =
            |k: Kernels| (Lookups::new(k, &environment).sum() - reflected).length() / reflected.length();
        let error = |k: &Kernels| difference(&|wi| density(k, wi), &exact, rings);
        for n in ORDERS {
            let of = |sampler: Sampler| error(&kernels(&surface, sampler, n, Filter::Density));
            let random: Vec<f64> = (1..=CONFIGURATIONS).map(|seed| of(Sampler::Stratified { seed })).collect();
            let (mean, largest) = mean_and_max(&random);
            let grid = of(Sampler::Grid);
            let rest = [of(Sampler::Hammersley), of(Sampler::VisibleNormals { centred: true })];
            let names = [Cell::from(format!("{degrees}°")), Cell::from(format!("{n}×{n}"))];
            table.row(names.into_iter().chain([grid, mean, largest, rest[0], rest[1]].map(Cell::from)));
            page.check(format!("grid {n}×{n}, {degrees}°"), grid);
            page.check(format!("importance samples {n}×{n}, {degrees}°, mean"), mean);
            page.check(format!("importance samples {n}×{n}, {degrees}°, largest"), largest);
            if n == 5 {
                let probes = error(&probe_kernels(&surface, 16));
                page.check(format!("16 probes, {degrees}°"), probes);
                let radiance = |sampler: Sampler| radiance_error(kernels(&surface, sampler, n, Filter::Density));
                let random: Vec<f64> =
                    (1..=CONFIGURATIONS).map(|seed| radiance(Sampler::Stratified { seed })).collect();
                let (of_grid, (of_random, worst)) = (radiance(Sampler::Grid), mean_and_max(&random));
                page.check(format!("radiance, grid 5×5, {degrees}°"), of_grid);
                page.check(format!("radiance, importance samples 5×5, {degrees}°, mean"), of_random);
                page.check(format!("radiance, importance samples 5×5, {degrees}°, largest"), worst);
                page.find(&format!(
                    "the pixel's radiance from the studio, seen from {degrees}° with 5×5 samples, differs from the integral by {} with the \
                    grid, and by {} on average and up to {} with importance samples.",
                    number(of_grid),
                    number(of_random),
                    number(worst)
                ));
                page.find(&format!(
                    "with 5×5 samples seen from {degrees}°, the grid's filter differs from the exact density by {} of its RMS, importance \
                    samples by {} on average and up to {} over {CONFIGURATIONS} configurations, and 16 probes by {}.",
                    number(grid),
                    number(mean),
                    number(largest),
                    number(probes)
                ));
            }
        }
    }
    page.html.table(&table);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_densities() {
        let surface = surface(VIEWS[0]);
        let total = |of: &dyn Fn(DVec3) -> f64| {
            let rings = 200;
            let cell = 2.0 * PI / f64::from(rings * rings);
            let mut sum = 0.0;
            for i in 0..rings {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(rings);
                for k in 0..2 * rings {
                    let at = DVec2::from_angle(PI * (f64::from(k) + 0.5) / f64::from(rings));
                    sum += cell * of(((1.0 - z * z).sqrt() * at).extend(z));
                }
            }
            sum
        };
        let grid = kernels(&surface, Sampler::Grid, 5, Filter::Density);
        assert!((total(&|wi| density(&grid, wi)) - 1.0).abs() < 1e-3);
        assert!((total(&|wi| reflected_density(&surface, wi)[0]) - 1.0).abs() < 1e-3);
        assert!((total(&|wi| density(&probe_kernels(&surface, 16), wi)) - 1.0).abs() < 1e-3);
    }

    /// At 70°, the grid's radiance is not nearer than the mean of importance samples, because its bias is larger.
    #[test]
    fn random_configurations_change_the_radiance_more_than_the_grid() {
        let environment = Directions::new(60);
        let surface = surface(VIEWS[0]);
        let reflected = environment.mean(|wi| reflected_density(&surface, wi)[0]);
        let of = |sampler: Sampler| {
            let lookups = Lookups::new(kernels(&surface, sampler, 5, Filter::Density), &environment);
            (lookups.sum() - reflected).length() / reflected.length()
        };
        let random: Vec<f64> = (1..=CONFIGURATIONS).map(|seed| of(Sampler::Stratified { seed })).collect();
        let (mean, largest) = mean_and_max(&random);
        let grid = of(Sampler::Grid);
        println!("grid {grid:.4}, importance samples {mean:.4} on average, {largest:.4} at most");
        assert!(3.0 * grid < mean && grid < 0.02, "{grid} {mean}");
    }

    #[test]
    fn random_configurations_differ_more_than_the_grid() {
        let surface = surface(VIEWS[0]);
        let exact = |wi: DVec3| reflected_density(&surface, wi)[0];
        let of = |sampler: Sampler| {
            let k = kernels(&surface, sampler, 5, Filter::Density);
            difference(&|wi| density(&k, wi), &exact, 60)
        };
        let random: Vec<f64> = (1..=8).map(|seed| of(Sampler::Stratified { seed })).collect();
        let (mean, largest) = mean_and_max(&random);
        let grid = of(Sampler::Grid);
        println!("grid {grid:.3}, importance samples {mean:.3} on average, {largest:.3} at most");
        assert!(mean > 2.5 * grid && largest > 1.1 * mean && grid < 0.12);
    }
}
