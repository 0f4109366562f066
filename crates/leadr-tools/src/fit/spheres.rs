//! Renders spheres of several materials under the same light on the CPU. All spheres use equal sample directions and thus
//! have equal noise.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use crate::fit::reflected::{LightLobe, Surroundings, reflected};
use crate::metrics::delta_e::{delta_e_2000, lab};
use leadr_maps::RgbImage;
use leadr_reflectance::color::luminance;
use leadr_reflectance::frame::Frame;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::random::Random;

/// The number of sample directions per pixel, for each of the three sampling strategies.
const DIRECTIONS: u32 = 48;
/// The quantile of a sphere's pixel luminance that the exposure maps to `GREY`.
const EXPOSED: f64 = 0.9;
const GREY: f64 = 0.7;

/// A lamp whose radiance is a lobe.
struct Lamp {
    lobe: LightLobe,
    /// The radiance of the middle.
    radiance: DVec3,
}

/// Returns the lights: a bright window above, a wide warm wall, and a small lamp behind the sphere.
fn lamps() -> [Lamp; 3] {
    let lamp = |x, y, z, sharpness, radiance| {
        let toward = DVec3::new(x, y, z).normalize();
        Lamp { lobe: LightLobe { toward, sharpness }, radiance }
    };
    [
        lamp(-0.5, 0.7, 0.6, 60.0, DVec3::new(16.0, 17.0, 18.0)),
        lamp(0.9, 0.1, 0.3, 12.0, DVec3::new(1.9, 1.6, 1.2)),
        lamp(0.5, 0.6, -0.5, 300.0, DVec3::new(45.0, 42.0, 38.0)),
    ]
}

/// Returns the radiance from a direction. y points up, and z points to the viewer.
fn light(lamps: &[Lamp], w: DVec3) -> DVec3 {
    let sky = DVec3::new(0.16, 0.18, 0.22).lerp(DVec3::new(0.55, 0.62, 0.75), 0.5 + 0.5 * w.y);
    sky + lamps.iter().map(|lamp| lamp.radiance * lamp.lobe.value(w)).sum::<DVec3>()
}

/// Renders an orthographic sphere of each material in linear RGB. Each picture is `size` pixels across and black outside the
/// sphere. `guide` is importance sampled.
pub fn spheres(materials: &[&(dyn Brdf + Sync)], guide: &(dyn Brdf + Sync), size: u32) -> Vec<RgbImage> {
    let lamps = lamps();
    let lobes = lamps.each_ref().map(|lamp| lamp.lobe);
    let around = Surroundings { radiance: &|w| light(&lamps, w), lobes: &lobes, directions: DIRECTIONS };
    let pixels: Vec<Vec<DVec3>> = (0..size * size)
        .into_par_iter()
        .map(|i| match normal_of(i, size) {
            Some(normal) => pixel(materials, guide, &around, normal, i),
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
    around: &Surroundings<'_>,
    normal: DVec3,
    seed: u32,
) -> Vec<DVec3> {
    let tangent = DVec3::Y.cross(normal).normalize_or(DVec3::X);
    let frame = Frame { x: tangent, y: normal.cross(tangent), z: normal };
    let mut random = Random::stream(1, u64::from(seed));
    let shift = DVec2::new(random.unit(), random.unit());
    reflected(materials, guide, around, &frame, DVec3::Z, shift)
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
    use leadr_reflectance::materials::brdf::cosine_sample;
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
