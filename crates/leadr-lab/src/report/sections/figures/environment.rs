//! Draws LEADR Figure 7: an environment as the samples of a pixel see it.

use glam::{DVec2, DVec3, Vec3};

use super::reconstruction::{Kernels, density, kernels, probe_kernels};
use crate::quadrature_study::fit_probes::{kernel, reflected_density};
use crate::quadrature_study::samplers::{Filter, Sampler};
use crate::quadrature_study::surfaces::{Surface, spherical};
use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_maps::RgbImage;
use leadr_scenes::studio::studio as panorama;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};
use std::f64::consts::{PI, TAU};

const ORDERS: [u32; 4] = [3, 5, 7, 9];
/// The slope deviations of the two surfaces.
const SIGMAS: [f64; 2] = [0.1, 0.2];
/// The angle of the viewer, in degrees.
const VIEW: f64 = 45.0;
/// Directions are shown down to this fraction of the largest density.
const SHOWN: f64 = 0.02;
/// The exposure of the studio in pictures of directions.
pub const EXPOSURE: f32 = 0.4;
/// The number of pixels between two pictures.
const GAP: u32 = 4;

/// An environment, with its radiance in directions of equal solid angles.
pub struct Directions(Vec<(DVec3, DVec3)>);

impl Directions {
    /// Samples the studio on `rings` rings of equal solid angle.
    pub fn new(rings: u32) -> Self {
        let image = panorama();
        let of_ring = |i: u32| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(rings);
            (0..2 * rings).map(move |k| {
                ((1.0 - z * z).sqrt() * DVec2::from_angle(PI * (f64::from(k) + 0.5) / f64::from(rings))).extend(z)
            })
        };
        Self((0..rings).flat_map(of_ring).map(|d| (d, radiance(&image, d))).collect())
    }

    /// Returns the mean radiance with these weights, which need not sum to 1.
    pub fn mean(&self, weight: impl Fn(DVec3) -> f64) -> DVec3 {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        for &(d, radiance) in &self.0 {
            let w = weight(d);
            sum += w * radiance;
            all += w;
        }
        sum / all.max(1e-12)
    }
}

/// Returns the texel of a panorama in a direction.
fn radiance(image: &RgbImage, d: DVec3) -> DVec3 {
    let (u, v) = (0.5 - d.y.atan2(d.x) / TAU, d.z.clamp(-1.0, 1.0).acos() / PI);
    let at = |share: f64, size: u32| ((share * f64::from(size)) as u32).min(size - 1);
    let texel = image.texels[(at(v, image.height) * image.width + at(u, image.width)) as usize];
    Vec3::from(texel).as_dvec3()
}

/// A filter with the radiance that each of its kernels looks up.
pub struct Lookups {
    kernels: Kernels,
    radiance: Vec<DVec3>,
}

impl Lookups {
    /// Looks up the mean radiance of the environment over each kernel.
    pub fn new(kernels: Kernels, environment: &Directions) -> Self {
        // A narrow kernel lies between the directions, so it looks up at least the nearest ones.
        let least = 2.0 / environment.0.len() as f64;
        let of = |&(_, axis, variance): &(f64, DVec3, f64)| {
            environment.mean(|d| kernel(variance.max(least), axis.normalize().dot(d)))
        };
        let radiance = kernels.iter().map(of).collect();
        Self { kernels, radiance }
    }

    /// Returns the radiance of the pixel.
    pub fn sum(&self) -> DVec3 {
        self.kernels.iter().zip(&self.radiance).map(|(k, &radiance)| k.0 * radiance).sum()
    }

    /// Returns the environment in a direction as the kernels reconstruct it.
    fn reconstructed(&self, wi: DVec3) -> DVec3 {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        for (&(w, axis, variance), &radiance) in self.kernels.iter().zip(&self.radiance) {
            let w = w * kernel(variance, axis.normalize().dot(wi));
            sum += w * radiance;
            all += w;
        }
        sum / all.max(1e-30)
    }
}

/// Draws colours over the hemisphere seen from above, side by side. `None` is grey.
fn sheet(pictures: &[&dyn Fn(DVec3) -> Option<DVec3>], size: u32) -> RgbImage {
    let (width, height) = (pictures.len() as u32 * (size + GAP) + GAP, size + 2 * GAP);
    let mut texels = vec![[0.2f32; 3]; (width * height) as usize];
    for (k, picture) in (0u32..).zip(pictures) {
        for i in 0..size * size {
            let at = |j: u32| (2.0 * f64::from(j) + 1.0) / f64::from(size) - 1.0;
            let p = DVec2::new(at(i % size), -at(i / size));
            let color =
                (p.length_squared() < 1.0).then(|| picture(p.extend((1.0 - p.length_squared()).sqrt()))).flatten();
            if let Some(color) = color {
                let (x, y) = (GAP + k * (size + GAP) + i % size, GAP + i / size);
                texels[(y * width + x) as usize] = color.as_vec3().to_array();
            }
        }
    }
    RgbImage { width, height, texels }
}

/// Draws the studio, the part that the facets of a surface reflect, and its reconstruction by each filter, over the hemisphere seen from
/// above. Directions whose density is below [`SHOWN`] of the largest are grey.
pub fn reconstructions(surface: &Surface, filters: &[Lookups], environment: &Directions, size: u32) -> RgbImage {
    let image = panorama();
    let exact = |wi: DVec3| reflected_density(surface, wi)[0];
    let largest = environment.0.iter().map(|&(d, _)| exact(d)).fold(0.0, f64::max);
    let whole = |wi: DVec3| Some(radiance(&image, wi));
    let seen = |wi: DVec3| (exact(wi) > SHOWN * largest).then(|| radiance(&image, wi));
    let drawn: Vec<_> = filters
        .iter()
        .map(|filter| {
            let most = filter.kernels.iter().map(|k| density(&filter.kernels, k.1.normalize())).fold(0.0, f64::max);
            move |wi: DVec3| (density(&filter.kernels, wi) > SHOWN * most).then(|| filter.reconstructed(wi))
        })
        .collect();
    let mut pictures: Vec<&dyn Fn(DVec3) -> Option<DVec3>> = vec![&whole, &seen];
    pictures.extend(drawn.iter().map(|d| d as &dyn Fn(DVec3) -> Option<DVec3>));
    sheet(&pictures, size)
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "LEADR Figure 7",
        "The studio as the samples of one pixel see it, for specular facets of slope deviations .1 and .2 and a viewer at 45° on the right: \
        directions of light, seen from above, where the weight of the filter is at least 2 % of its largest. Left to right: the whole \
        studio, the part that the facets reflect, and its reconstruction from 3×3, 5×5, 7×7 and 9×9 samples of the paper and from 16 probes.",
    );
    let (size, rings) = studio.pick((64, 90), (160, 240));
    let environment = Directions::new(rings);
    let mut table = Table::new(
        "Radiance of the pixel: difference from the integral, relative to it",
        ["slope deviation", "3×3", "5×5", "7×7", "9×9", "16 probes"],
    );
    for sigma in SIGMAS {
        let wo = spherical(VIEW.to_radians(), 0.0);
        let surface = Surface { wo, m: DVec2::ZERO, s: DVec3::new(sigma * sigma, sigma * sigma, 0.0) };
        let exact = |wi: DVec3| reflected_density(&surface, wi)[0];
        let truth = environment.mean(exact);
        let mut filters: Vec<Lookups> = ORDERS
            .map(|n| Lookups::new(kernels(&surface, Sampler::Grid, n, Filter::Widest), &environment))
            .into_iter()
            .collect();
        filters.push(Lookups::new(probe_kernels(&surface, 16), &environment));
        let name = format!("figures-environment-{}", format!("{sigma}").replace('.', "_"));
        let caption = vec![format!("slope deviation {sigma}")];
        let picture = reconstructions(&surface, &filters, &environment, size);
        page.html.figures(&[studio.picture(&name, &picture, EXPOSURE, "reconstructed environment", caption)?]);
        let errors: Vec<f64> = filters.iter().map(|f| (f.sum() - truth).length() / truth.length()).collect();
        table.row(std::iter::once(Cell::from(format!("{sigma}"))).chain(errors.iter().map(|&e| Cell::from(e))));
        for (what, &error) in ["3×3", "5×5", "7×7", "9×9", "16 probes"].iter().zip(&errors) {
            page.check(format!("{what}, slope deviation {sigma}"), error);
        }
        page.find(&format!(
            "at a slope deviation of {sigma}, the pixel's radiance from 5×5 samples differs by {} of the integral, from 9×9 by {}, and from 16 \
            probes by {}.",
            number(errors[1]),
            number(errors[3]),
            number(errors[4])
        ));
    }
    page.html.table(&table);
    Ok(())
}
