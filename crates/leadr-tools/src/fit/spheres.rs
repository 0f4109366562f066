//! Renders spheres of several materials under the same light on the CPU. All spheres use equal sample directions and thus
//! have equal noise.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use crate::metrics::delta_e::{delta_e_2000, lab};
use leadr_maps::RgbImage;
use leadr_reflectance::color::luminance;
use leadr_reflectance::materials::brdf::{Brdf, cosine_sample};
use leadr_reflectance::random::Random;

/// The number of sample directions per pixel, for each of the three sampling strategies.
const DIRECTIONS: u32 = 48;
/// The quantile of a sphere's pixel luminance that the exposure maps to `GREY`.
const EXPOSED: f64 = 0.9;
const GREY: f64 = 0.7;

/// A lamp whose radiance is a von Mises–Fisher lobe.
struct Lamp {
    toward: DVec3,
    sharpness: f64,
    radiance: DVec3,
}

/// Returns the lights: a bright window above, a wide warm wall, and a small lamp behind the sphere.
fn lamps() -> [Lamp; 3] {
    let lamp = |x, y, z, sharpness, radiance| Lamp { toward: DVec3::new(x, y, z).normalize(), sharpness, radiance };
    [
        lamp(-0.5, 0.7, 0.6, 60.0, DVec3::new(16.0, 17.0, 18.0)),
        lamp(0.9, 0.1, 0.3, 12.0, DVec3::new(1.9, 1.6, 1.2)),
        lamp(0.5, 0.6, -0.5, 300.0, DVec3::new(45.0, 42.0, 38.0)),
    ]
}

impl Lamp {
    fn radiance(&self, w: DVec3) -> DVec3 {
        self.radiance * (self.sharpness * (w.dot(self.toward) - 1.0)).exp()
    }

    fn pdf(&self, w: DVec3) -> f64 {
        let norm = self.sharpness / (TAU * -(-2.0 * self.sharpness).exp_m1());
        norm * (self.sharpness * (w.dot(self.toward) - 1.0)).exp()
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let z = 1.0 + (u.x + (1.0 - u.x) * (-2.0 * self.sharpness).exp()).ln() / self.sharpness;
        let (x, y) = self.toward.any_orthonormal_pair();
        let (sine, cosine) = (TAU * u.y).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        x * (r * cosine) + y * (r * sine) + self.toward * z
    }
}

/// Returns the radiance from a direction. y points up, and z points to the viewer.
fn light(lamps: &[Lamp], w: DVec3) -> DVec3 {
    let sky = DVec3::new(0.16, 0.18, 0.22).lerp(DVec3::new(0.55, 0.62, 0.75), 0.5 + 0.5 * w.y);
    sky + lamps.iter().map(|lamp| lamp.radiance(w)).sum::<DVec3>()
}

/// Renders an orthographic sphere of each material in linear RGB. Each picture is `size` pixels across and black outside the
/// sphere. `guide` is importance sampled.
pub fn spheres(materials: &[&(dyn Brdf + Sync)], guide: &(dyn Brdf + Sync), size: u32) -> Vec<RgbImage> {
    let lamps = lamps();
    let pixels: Vec<Vec<DVec3>> = (0..size * size)
        .into_par_iter()
        .map(|i| match normal_of(i, size) {
            Some(normal) => pixel(materials, guide, &lamps, normal, i),
            None => vec![DVec3::ZERO; materials.len()],
        })
        .collect();
    (0..materials.len())
        .map(|k| RgbImage {
            width: size,
            height: size,
            texels: pixels.iter().map(|values| values[k].as_vec3().to_array()).collect(),
        })
        .collect()
}

/// Returns the normal of the sphere at a pixel, or `None` outside the sphere.
fn normal_of(i: u32, size: u32) -> Option<DVec3> {
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(size) * 2.0 - 1.0;
    let p = DVec2::new(at(i % size), -at(i / size));
    let z2 = 1.0 - p.length_squared();
    (z2 > 0.0).then(|| p.extend(z2.sqrt()))
}

fn pixel(
    materials: &[&(dyn Brdf + Sync)],
    guide: &(dyn Brdf + Sync),
    lamps: &[Lamp],
    normal: DVec3,
    seed: u32,
) -> Vec<DVec3> {
    let tangent = DVec3::Y.cross(normal).normalize_or(DVec3::X);
    let bitangent = normal.cross(tangent);
    let local = |w: DVec3| DVec3::new(w.dot(tangent), w.dot(bitangent), w.dot(normal));
    let world = |w: DVec3| tangent * w.x + bitangent * w.y + normal * w.z;
    let wo = local(DVec3::Z);
    let mut sums = vec![DVec3::ZERO; materials.len()];
    let mut add = |wi: DVec3| {
        if wi.z <= 1e-6 {
            return;
        }
        let w = world(wi);
        let of_lamps = lamps.iter().map(|lamp| lamp.pdf(w)).sum::<f64>() / lamps.len() as f64;
        // The balance heuristic combines the three strategies.
        let pdf = wi.z / PI + guide.pdf(wo, wi) + of_lamps;
        let incident = light(lamps, w) / (pdf * f64::from(DIRECTIONS));
        for (sum, material) in sums.iter_mut().zip(materials) {
            *sum += material.eval_cos(wo, wi) * incident;
        }
    };
    // The samples form Roberts' low-discrepancy sequence, with a random shift per pixel.
    let mut random = Random::stream(1, u64::from(seed));
    let shift = DVec2::new(random.unit(), random.unit());
    for k in 0..DIRECTIONS {
        let u = (DVec2::new(0.754_877_666_25, 0.569_840_290_99) * (f64::from(k) + 0.5) + shift).fract();
        add(cosine_sample(u));
        if let Some(sample) = guide.sample(wo, u) {
            add(sample.wi);
        }
        let which = k as usize % lamps.len();
        add(local(lamps[which].sample(u)));
    }
    sums
}

/// The error of a sphere compared with the sphere of the measured material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SphereError {
    /// The RMS of the radiance difference, relative to the RMS of the measured radiance.
    pub rrmse: f64,
    /// The mean ΔE₀₀ of the displayed colours.
    #[serde(rename = "delta_e_2000")]
    pub delta_e: f64,
}

/// Returns the exposure factor with which a sphere is displayed.
pub fn exposure(sphere: &RgbImage) -> f64 {
    let mut all: Vec<f64> = inside(sphere).map(|(_, color)| luminance(color)).collect();
    all.sort_by(f64::total_cmp);
    let bright = all.get((EXPOSED * all.len() as f64) as usize).copied().unwrap_or(1.0);
    GREY / bright.max(1e-9)
}

fn inside(sphere: &RgbImage) -> impl Iterator<Item = (usize, DVec3)> + '_ {
    let texels = sphere.texels.iter().enumerate();
    texels
        .filter(|(i, _)| normal_of(*i as u32, sphere.width).is_some())
        .map(|(i, c)| (i, DVec3::from_array(c.map(f64::from))))
}

/// Returns ΔE₀₀ of the displayed colours at every pixel, which is 0 outside the sphere.
pub fn delta_e_of(measured: &RgbImage, fitted: &RgbImage) -> Vec<f64> {
    let exposure = exposure(measured);
    let mut all = vec![0.0; measured.texels.len()];
    for ((i, m), (_, f)) in inside(measured).zip(inside(fitted)) {
        all[i] = delta_e_2000(lab((m * exposure).to_array()), lab((f * exposure).to_array()));
    }
    all
}

/// Compares a sphere with the sphere of the measured material.
pub fn sphere_error(measured: &RgbImage, fitted: &RgbImage) -> SphereError {
    let (mut difference, mut all, mut count) = (0.0, 0.0, 0.0);
    for ((_, m), (_, f)) in inside(measured).zip(inside(fitted)) {
        difference += (m - f).length_squared();
        all += m.length_squared();
        count += 1.0;
    }
    let delta: f64 = delta_e_of(measured, fitted).iter().sum();
    SphereError { rrmse: (difference / all).sqrt(), delta_e: delta / count }
}

/// The space around the spheres of a contact sheet, in pixels.
pub const GAP: u32 = 8;
/// The colour between the spheres of a contact sheet.
const BACKGROUND: [f32; 3] = [0.12; 3];

/// Returns the pictures below each other. Narrow pictures are filled with the background at the right.
pub fn stacked(rows: &[RgbImage]) -> RgbImage {
    let width = rows.iter().map(|row| row.width).max().unwrap_or(0);
    let height = rows.iter().map(|row| row.height).sum();
    let mut texels = Vec::with_capacity((width * height) as usize);
    for row in rows {
        for line in row.texels.chunks_exact(row.width.max(1) as usize) {
            texels.extend_from_slice(line);
            texels.extend(std::iter::repeat_n(BACKGROUND, (width - row.width) as usize));
        }
    }
    RgbImage { width, height, texels }
}

/// Returns the spheres side by side on grey, all with the exposure of the first sphere.
pub fn contact_sheet(spheres: &[RgbImage]) -> RgbImage {
    let size = spheres.first().map_or(1, |sphere| sphere.width);
    let scale = spheres.first().map_or(1.0, exposure) as f32;
    let (width, height) = (spheres.len() as u32 * (size + GAP) + GAP, size + 2 * GAP);
    let mut texels = vec![BACKGROUND; (width * height) as usize];
    for (k, sphere) in spheres.iter().enumerate() {
        for (i, color) in inside(sphere) {
            let (x, y) = (i as u32 % size + GAP + k as u32 * (size + GAP), i as u32 / size + GAP);
            texels[(y * width + x) as usize] = color.as_vec3().to_array().map(|c| c * scale);
        }
    }
    RgbImage { width, height, texels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::materials::lambert::Lambert;

    #[test]
    fn a_white_sphere_shows_the_mean_light() {
        // A pixel of a diffuse sphere is the cosine-weighted mean of the light over the hemisphere of the pixel's normal.
        let white = Lambert { albedo: DVec3::ONE };
        let grey = Lambert { albedo: DVec3::splat(0.5) };
        let images = spheres(&[&white, &grey], &white, 24);
        let at = |image: &RgbImage| DVec3::from_array(image.at(12, 12).map(f64::from));
        let lamps = lamps();
        let normal = normal_of(12 * 24 + 12, 24).unwrap();
        let (x, y) = normal.any_orthonormal_pair();
        let (mut mean, n) = (DVec3::ZERO, 300);
        for i in 0..n {
            for j in 0..n {
                let u = DVec2::new((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
                let w = cosine_sample(u);
                mean += light(&lamps, x * w.x + y * w.y + normal * w.z) / f64::from(n * n);
            }
        }
        assert!((at(&images[0]) - mean).length() < 0.03 * mean.length(), "{} {mean}", at(&images[0]));
        assert!((at(&images[0]) - 2.0 * at(&images[1])).length() < 1e-5);
        let error = sphere_error(&images[0], &images[1]);
        assert!((error.rrmse - 0.5).abs() < 1e-6 && error.delta_e > 10.0, "{error:?}");
        assert_eq!(sphere_error(&images[0], &images[0]), SphereError { rrmse: 0.0, delta_e: 0.0 });
        let map = delta_e_of(&images[0], &images[1]);
        assert!(map[0] == 0.0 && map[12 * 24 + 12] > 10.0, "{} {}", map[0], map[12 * 24 + 12]);
        let (wide, narrow) = (contact_sheet(&images), contact_sheet(&images[..1]));
        let sheet = stacked(&[narrow.clone(), wide.clone()]);
        assert_eq!((sheet.width, sheet.height), (wide.width, narrow.height + wide.height));
        assert_eq!((sheet.at(20, 20), sheet.at(wide.width - 1, 20)), (narrow.at(20, 20), BACKGROUND));
        assert_eq!(sheet.at(50, narrow.height + 20), wide.at(50, 20));
    }
}
