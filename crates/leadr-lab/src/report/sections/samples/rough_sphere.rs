//! A Gaussian rough sphere of a common material. LEADR's model describes the sphere exactly if bumps are smaller than a
//! pixel.
//!
//! The sphere's heights are a Gaussian field. In every footprint with enough bumps, the slopes are therefore normally
//! distributed, with the same statistics everywhere.
//!
//! The base material is a matt dielectric. The slopes are those of plaster or rough concrete, and steep enough for masking
//! near the edge of the sphere.

use std::f64::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use leadr_render::camera::Camera;
use leadr_scenes::spheres::cell::{DISTANCE, Facets, views};
use leadr_scenes::spheres::surface::{Detail, Surface};
use leadr_scenes::stage::{Stage, Views};

/// The diffuse albedo of the base material.
pub const ALBEDO: f32 = 0.5;
/// The Beckmann roughness `α` of the base material.
pub const ROUGHNESS: f32 = 0.3;
/// The reflectance of the base material at normal incidence.
pub const F0: f32 = 0.04;
/// The standard deviation of the slopes, in all directions.
pub const SLOPE: f32 = 0.4;
/// The standard deviation of the noise's kernel in texels ([`Detail::texel`]). A bump is eight texels wide.
const KERNEL_TEXELS: f64 = 2.5;

/// A unit sphere, and the size of its bumps.
pub struct RoughSphere {
    /// The stage with the sphere. The [`views`] are from the side and slightly above, as for the rock.
    pub stage: Stage,
    /// The area of a bump in squares of the radius: the integral of the heights' autocorrelation over the surface.
    pub bump_area: f64,
}

impl RoughSphere {
    /// Bakes the sphere with the finest bumps that `detail` can hold.
    pub fn new(detail: Detail) -> Self {
        let length = KERNEL_TEXELS * detail.texel();
        let mut object =
            Surface::of_length(Vec2::splat(SLOPE), length, detail).object("rough sphere", SLOPE, Facets::Diffuse);
        object.mesh.colors.fill([ALBEDO, ALBEDO, ALBEDO, ROUGHNESS]);
        object.specular_f0 = F0;
        let toward = Vec3::new(0.66, -0.66, 0.35).normalize();
        let turned = |camera: Camera| Camera { position: toward * camera.position.distance(camera.target), ..camera };
        let Views { near, mid, far } = views();
        let views = Views { near: turned(near), mid: turned(mid), far: turned(far) };
        Self { stage: Stage::still(vec![object], views), bump_area: bump_area(length) }
    }

    /// Returns the mean number of bumps per pixel of the disc, in a picture of the `mid` view that is `height` pixels high.
    /// The centre of the disc has half as many bumps per pixel, and the edge has more.
    pub fn bumps_per_pixel(&self, height: u32) -> f64 {
        let (distance, focal) = (f64::from(DISTANCE), f64::from(self.stage.views.mid.lens(height).focal_pixels));
        let visible = TAU * (1.0 - distance.recip());
        let radius = focal / (distance * distance - 1.0).sqrt();
        visible / self.bump_area / (PI * radius * radius)
    }
}

/// Computes [`RoughSphere::bump_area`] of a round kernel of standard deviation `length`. The area is `(∫f)² / ∫f²` of `f(r)
/// = (1 − r²)⁶` over the kernel's support, a disc of radius `√12 · length`.
fn bump_area(length: f64) -> f64 {
    let (whole, square) = (PI / 7.0, PI / 13.0);
    whole * whole / square * 12.0 * length * length
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use leadr_scenes::spheres::cell::FILL;
    use leadr_scenes::spheres::noise::SphereNoise;

    #[test]
    fn bump_area_is_the_height_correlation_area() {
        // The mean over a disc of many bumps has the variance of the heights times bump area / disc area.
        let (length, radius) = (0.01, 0.12f32);
        let (mut square, mut single) = (0.0f64, 0.0f64);
        for seed in 0..16 {
            let noise = SphereNoise::new(seed, DVec2::ONE, length);
            // The discs surround points that are more than a disc width apart.
            for i in 0..60 {
                let z = 1.0 - (2.0 * i as f32 + 1.0) / 60.0;
                let axis = (Vec2::from_angle(i as f32 * 2.399_963_2) * (1.0 - z * z).sqrt()).extend(z);
                let (x, y) = axis.any_orthonormal_pair();
                let n = 900;
                let (mut sum, mut squares) = (0.0f64, 0.0f64);
                for k in 0..n {
                    let r = radius * ((k as f32 + 0.5) / n as f32).sqrt();
                    let at = Vec2::from_angle(k as f32 * 2.399_963_2) * r;
                    let h = f64::from(noise.at((axis + x * at.x + y * at.y).normalize()));
                    sum += h;
                    squares += h * h;
                }
                square += (sum / f64::from(n)).powi(2);
                single += squares / f64::from(n);
            }
        }
        // The factor corrects for correlation across the disc's edge, over a mean distance of 1.65 lengths.
        let rim = 1.0 - 2.0 / PI * 1.65 * length / f64::from(radius);
        let expected = rim * bump_area(length) / (PI * f64::from(radius).powi(2));
        let measured = square / single;
        println!("{measured} {expected}");
        // 960 discs estimate a variance to 4.6 %.
        assert!((measured / expected - 1.0).abs() < 0.14, "{measured} {expected}");
    }

    #[test]
    fn pixels_hold_more_bumps_the_finer_the_tiles_and_the_smaller_the_picture() {
        let bumps = |tile, size| RoughSphere::new(Detail { patches: 2, tile }).bumps_per_pixel(size);
        let one = bumps(16, 24);
        assert!((bumps(16, 12) / one - 4.0).abs() < 1e-3);
        assert!((bumps(32, 24) / one - (28.0f64 / 12.0).powi(2)).abs() < 1e-3);
        // Computed by hand, the value is 11/24 of the sphere over a disc that is 0.8 of 24 pixels wide.
        let pixel = 11.0 / 24.0 * 4.0 / (12.0 * f64::from(FILL)).powi(2);
        let length = 2.5 * std::f64::consts::FRAC_PI_2 / 24.0;
        assert!((one / (pixel / (10.0 * length * length)) - 1.0).abs() < 1e-3, "{one}");
    }
}
