//! A photo studio environment with soft boxes that have sharp edges, a strip light, broad gradients on walls and floor, and small bulbs.
//! Rough surfaces must blur these features, and smooth surfaces must not.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::light::SunDirection;
use leadr_maps::RgbImage;

/// The width of the panorama in texels. The height is half the width.
pub const WIDTH: u32 = 1024;

/// A flat lamp on a sphere around the viewer, shaped as a rounded rectangle.
struct Lamp {
    /// The azimuth (counter-clockwise from +x) and elevation of the lamp's centre in degrees.
    at: Vec2,
    /// Half the width and half the height of the lamp, as tangents of angles.
    half: Vec2,
    /// The radius of the lamp's corners.
    corner: f32,
    /// The radiance of the lamp.
    color: Vec3,
}

const fn lamp(azimuth: f32, elevation: f32, half: [f32; 2], corner: f32, color: [f32; 3]) -> Lamp {
    Lamp { at: Vec2::new(azimuth, elevation), half: Vec2::from_array(half), corner, color: Vec3::from_array(color) }
}

/// The lamps for cameras that look along +y. The centre of a sphere then reflects −y.
const LAMPS: [Lamp; 7] = [
    // The key light is above and to the left, behind the viewer. A large cool fill light is on the right.
    lamp(-128.0, 38.0, [0.42, 0.42], 0.06, [9.0, 8.4, 7.4]),
    lamp(-38.0, 16.0, [0.34, 0.62], 0.06, [1.7, 2.3, 3.1]),
    // A strip is above, a warm strip is low on the left, and a rim light is on each side behind the subject.
    lamp(-90.0, 76.0, [0.9, 0.1], 0.1, [6.0, 6.0, 6.0]),
    lamp(-165.0, -4.0, [0.07, 0.8], 0.07, [5.5, 2.6, 0.9]),
    // They stand high, so that cameras that look level do not show them.
    lamp(35.0, 48.0, [0.16, 0.5], 0.04, [3.4, 3.9, 4.6]),
    lamp(140.0, 50.0, [0.3, 0.3], 0.06, [6.5, 4.4, 3.4]),
    // A small bulb.
    lamp(-72.0, -22.0, [0.05, 0.05], 0.05, [16.0, 13.0, 8.0]),
];

/// The exposure that gives an irradiance of about π on a plane facing up. White cloth on this plane has the brightness of paper.
const EXPOSURE: f32 = 0.52;

/// Returns the radiance toward a unit direction, z up.
fn radiance(d: Vec3) -> Vec3 {
    // The walls are lighter above. The key light makes a bright spot on the warm floor.
    let wall = Vec3::new(0.16, 0.18, 0.22).lerp(Vec3::new(0.5, 0.52, 0.56), (0.5 + 0.5 * d.z).powi(2));
    let pool = (-(d + Vec3::Z * 0.9 + Vec3::Y * 0.3).length_squared() * 2.5).exp();
    let floor = Vec3::new(0.14, 0.11, 0.09) + pool * Vec3::new(0.55, 0.47, 0.38);
    let mut sum = floor.lerp(wall, ((d.z + 0.03) / 0.06).clamp(0.0, 1.0));
    for lamp in &LAMPS {
        let azimuth = lamp.at.x.to_radians();
        let towards = SunDirection { azimuth: lamp.at.x, elevation: lamp.at.y }.vector();
        let right = Vec3::new(azimuth.sin(), -azimuth.cos(), 0.0);
        let depth = d.dot(towards);
        if depth > 0.1 {
            let p = Vec2::new(d.dot(right), d.dot(right.cross(towards))) / depth;
            let corner = Vec2::splat(lamp.corner);
            let outside = (p.abs() - lamp.half + corner).max(Vec2::ZERO).length() - lamp.corner;
            // A lamp has an edge two texels wide. The cloth of the lamp is brighter at the centre.
            let edge = (0.5 - outside / (4.0 * PI / WIDTH as f32)).clamp(0.0, 1.0);
            let cloth = 1.0 - 0.35 * (p / lamp.half).length_squared().min(2.0) / 2.0;
            sum = sum.lerp(lamp.color * cloth, edge);
        }
    }
    sum * EXPOSURE
}

/// Builds the panorama in the convention of `render::equirect`: z is up, +x is at the centre, and columns run clockwise when seen from
/// above.
pub fn studio() -> RgbImage {
    let (width, height) = (WIDTH, WIDTH / 2);
    let texels = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let (u, v) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let (phi, theta) = ((0.5 - u / width as f32) * TAU, v / height as f32 * PI);
            radiance(Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())).to_array()
        })
        .collect();
    RgbImage { width, height, texels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::color::luminance;

    #[test]
    fn the_studio_has_sharp_lamps_on_dim_walls() {
        let image = studio();
        let of = |texel: &[f32; 3]| luminance(Vec3::from(*texel).as_dvec3()) as f32;
        let luminance: Vec<f32> = image.texels.iter().map(of).collect();
        assert!(luminance.iter().all(|&l| l > 0.03 && l < 20.0));
        let bright = luminance.iter().filter(|&&l| l > 1.0).count() as f32 / luminance.len() as f32;
        assert!((0.02..0.25).contains(&bright), "{bright}");
        let height = image.height as usize;
        let irradiance: f32 = (0..height / 2)
            .map(|row| {
                let theta = (row as f32 + 0.5) / height as f32 * PI;
                let sum: f32 = luminance[row * WIDTH as usize..][..WIDTH as usize].iter().sum();
                sum * theta.cos() * theta.sin() * (TAU / WIDTH as f32) * (PI / height as f32)
            })
            .sum();
        assert!((irradiance / PI - 1.0).abs() < 0.3, "{}", irradiance / PI);
        let sharpest = luminance.windows(2).map(|w| (w[0] - w[1]).abs()).fold(0.0, f32::max);
        assert!(sharpest > 2.0, "{sharpest}");
    }
}
