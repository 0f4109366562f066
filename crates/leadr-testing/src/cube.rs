//! Reads back cube maps. The directions and solid angles of texels are in 64 bits, and are derived independently of the shaders.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::f64::consts::PI;

use glam::DVec3;
use half::f16;
use leadr_gpu::{Image, vk};
use leadr_maps::RgbImage;
use leadr_render::light::environment::Environment;

/// Returns the direction through the centre of a texel, from the table "cube map face selection" of the Vulkan specification.
pub fn texel_direction(face: usize, x: usize, y: usize, size: usize) -> DVec3 {
    let (s, t) = ((2 * x + 1) as f64 / size as f64 - 1.0, (2 * y + 1) as f64 / size as f64 - 1.0);
    [
        DVec3::new(1.0, -t, -s),
        DVec3::new(-1.0, -t, s),
        DVec3::new(s, 1.0, t),
        DVec3::new(s, -1.0, -t),
        DVec3::new(s, -t, 1.0),
        DVec3::new(-s, -t, -1.0),
    ][face]
        .normalize()
}

/// Computes the exact solid angle of a texel.
pub fn solid_angle(x: usize, y: usize, size: usize) -> f64 {
    let corner = |i: usize, j: usize| {
        let (s, t) = (2.0 * i as f64 / size as f64 - 1.0, 2.0 * j as f64 / size as f64 - 1.0);
        (s * t).atan2((s * s + t * t + 1.0).sqrt())
    };
    corner(x, y) + corner(x + 1, y + 1) - corner(x + 1, y) - corner(x, y + 1)
}

/// Reads all texels of a level, with the direction, solid angle and radiance of each.
pub fn read_level(environment: &Environment, mip: u32) -> Vec<(DVec3, f64, DVec3)> {
    read_image_level(environment.image(), mip)
}

/// Reads all texels of a level of any cube image.
pub fn read_image_level(image: &Image, mip: u32) -> Vec<(DVec3, f64, DVec3)> {
    let size = (image.desc().width >> mip) as usize;
    let mut all = Vec::new();
    for face in 0..6 {
        let texels: Vec<[f32; 4]> = if image.desc().format == vk::Format::R16G16B16A16_SFLOAT {
            let halves: Vec<[f16; 4]> = image.read(mip, face as u32).unwrap();
            halves.into_iter().map(|texel| texel.map(f16::to_f32)).collect()
        } else {
            image.read(mip, face as u32).unwrap()
        };
        for (i, t) in texels.iter().enumerate() {
            let (x, y) = (i % size, i / size);
            let radiance = DVec3::new(t[0].into(), t[1].into(), t[2].into());
            // The filter weights sum to 1 up to rounding.
            assert!(radiance.is_finite() && (t[3] - 1.0).abs() < 1e-6, "face {face} {x},{y}: {t:?}");
            all.push((texel_direction(face, x, y, size), solid_angle(x, y, size), radiance));
        }
    }
    all
}

/// Returns the directions of the texel centres of a panorama that is twice as wide as high. The order is row-major, by the convention of
/// `render::equirect`.
fn panorama_directions(width: u32) -> Vec<DVec3> {
    let height = width / 2;
    let mut directions = Vec::new();
    for j in 0..height {
        for i in 0..width {
            let theta = PI * (f64::from(j) + 0.5) / f64::from(height);
            let phi = 2.0 * PI * (0.5 - (f64::from(i) + 0.5) / f64::from(width));
            directions.push(DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()));
        }
    }
    directions
}

/// Samples a function of direction at the texel centres of a panorama.
pub fn panorama(width: u32, f: impl Fn(DVec3) -> DVec3) -> RgbImage {
    let texels = panorama_directions(width).into_iter().map(|d| f(d).to_array().map(|v| v as f32)).collect();
    RgbImage::new(width, width / 2, texels).unwrap()
}
