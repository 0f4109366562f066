//! Measures irradiance errors of nine spherical harmonics for a panorama whose lights are kept in the image or extracted.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use leadr_maps::RgbImage;
use leadr_reflectance::color::luminance;
use leadr_reflectance::integrals::sh::{Sh9, sh_basis, sh_irradiance};
use leadr_render::light::panorama::{EnvironmentLight, LightExtraction, split};

/// The luminance errors of the irradiance from nine harmonics plus the extracted lights.
#[derive(Clone, Debug)]
pub struct IrradianceErrors {
    /// The extracted lights.
    pub lights: Vec<EnvironmentLight>,
    /// The RMS error over all normals, relative to the RMS irradiance.
    pub rms: f64,
    /// The largest signed error, relative to the irradiance of the same normal.
    pub worst: f64,
    /// The relative error on level ground.
    pub level: f64,
}

/// The number of evenly spread normals for the errors.
const NORMALS: usize = 2000;
/// The largest number of texel blocks around the horizon. Each block is one direction of the exact sum.
const BLOCKS: usize = 256;

/// Light from one direction together with its flux.
struct Ray {
    direction: DVec3,
    flux: f64,
}

/// Computes the errors for a panorama whose lights are extracted by `how`.
pub fn irradiance_errors(image: &RgbImage, how: LightExtraction) -> IrradianceErrors {
    let parts = split(image, how);
    let mut rest = image.clone();
    for &(index, texel) in &parts.rest {
        rest.texels[index] = texel;
    }
    // The exact sum and the harmonics both add bright texels one by one.
    let exact: Vec<Ray> = rays(image);
    let mut sh: Sh9 = [DVec3::ZERO; 9];
    for_texels(&rest, |direction, flux| {
        for (c, basis) in sh.iter_mut().zip(sh_basis(direction)) {
            *c += DVec3::splat(flux * basis);
        }
    });
    let truth = |n: DVec3| exact.iter().map(|ray| ray.flux * ray.direction.dot(n).max(0.0)).sum::<f64>();
    let ours = |n: DVec3| {
        let direct =
            parts.lights.iter().map(|l| luminance(l.irradiance.as_dvec3()) * l.direction.as_dvec3().dot(n).max(0.0));
        sh_irradiance(&sh, n).x.max(0.0) + direct.sum::<f64>()
    };
    let (mut squares, mut whole, mut worst) = (0.0, 0.0, 0.0f64);
    for i in 0..NORMALS {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / NORMALS as f64;
        let (sin, cos) = (i as f64 * PI * (3.0 - 5f64.sqrt())).sin_cos();
        let n = DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z);
        let (t, o) = (truth(n), ours(n));
        squares += (o - t).powi(2);
        whole += t * t;
        if (o / t - 1.0).abs() > worst.abs() {
            worst = o / t - 1.0;
        }
    }
    let level = ours(DVec3::Z) / truth(DVec3::Z) - 1.0;
    IrradianceErrors { lights: parts.lights, rms: (squares / whole).sqrt(), worst, level }
}

/// Reduces a panorama to so few directions that sums over many normals are fast.
fn rays(image: &RgbImage) -> Vec<Ray> {
    let blocks = (image.width as usize).min(BLOCKS);
    let mut sums = vec![DVec3::ZERO; blocks * blocks];
    let mut fluxes = vec![0.0; sums.len()];
    let mut index = 0;
    let (width, height) = (image.width as usize, image.height as usize);
    for_texels(image, |direction, flux| {
        let (row, column) = (index / width, index % width);
        let block = row * blocks / 2 / height.max(1) * blocks + column * blocks / width;
        sums[block] += flux * direction;
        fluxes[block] += flux;
        index += 1;
    });
    let rays = sums.into_iter().zip(fluxes).filter(|(_, flux)| *flux > 0.0);
    // The direction is not normalised, because the mean cosine of a block is the cosine of its mean direction.
    rays.map(|(sum, flux)| Ray { direction: sum / flux, flux }).collect()
}

/// Calls `each` for every texel in row order. The arguments are the texel's direction, and its luminance times its solid
/// angle.
fn for_texels(image: &RgbImage, mut each: impl FnMut(DVec3, f64)) {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    for (row, texels) in image.texels.chunks_exact(image.width as usize).enumerate() {
        let edge = |row: f64| (PI * row / height).cos();
        let solid_angle = 2.0 * PI / width * (edge(row as f64) - edge(row as f64 + 1.0));
        let (sin, cos) = (PI * (row as f64 + 0.5) / height).sin_cos();
        for (column, &texel) in texels.iter().enumerate() {
            let (y, x) = (2.0 * PI * (0.5 - (column as f64 + 0.5) / width)).sin_cos();
            each(DVec3::new(sin * x, sin * y, cos), luminance(Vec3::from(texel).as_dvec3()) * solid_angle);
        }
    }
}
