//! A camera above the plane z = 0, and the light on it.

use glam::{Vec3, Vec4};

use crate::picture::Picture;

/// A camera and the light. Lengths are in metres, and z is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The position of the camera, above the plane.
    pub eye: Vec3,
    /// The point at the centre of the picture.
    pub target: Vec3,
    /// The vertical field of view in degrees.
    pub fov_degrees: f32,
    /// The width and height in pixels.
    pub size: [u32; 2],
    /// The distance at which the material repeats, in metres.
    pub repeat: f32,
    /// The height in metres of one unit of the map.
    pub height_scale: f32,
    /// The unit vector towards the sun.
    pub sun: Vec3,
    /// The irradiance of the sun on a plane that faces it.
    pub irradiance: Vec3,
    /// The spherical harmonics of the sky's radiance, in the order L00, L1-1, L10, L11, L2-2, L2-1, L20, L21, L22.
    pub sky: [Vec3; 9],
}

impl View {
    /// Returns a view of close bumps in front of the horizon, with a morning sun from the side.
    pub fn morning(size: [u32; 2]) -> Self {
        Self {
            eye: Vec3::new(0.0, -2.2, 0.75),
            target: Vec3::new(0.35, 0.0, 0.32),
            fov_degrees: 40.0,
            size,
            repeat: 1.5,
            height_scale: 1.5,
            sun: Vec3::new(0.8, 0.35, 0.36).normalize(),
            irradiance: Vec3::new(7.5, 6.2, 4.6),
            sky: harmonics(clear_sky),
        }
    }

    /// Returns the ray through the centre of the top left pixel, and the change of the ray per pixel to the right and down.
    pub fn rays(&self) -> [Vec3; 3] {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(Vec3::Z).normalize();
        let up = right.cross(forward);
        let [width, height] = self.size.map(|side| side as f32);
        let pixel = 2.0 * (0.5 * self.fov_degrees.to_radians()).tan() / height;
        let (across, down) = (right * pixel, -up * pixel);
        [forward - across * (0.5 * width - 0.5) - down * (0.5 * height - 0.5), across, down]
    }

    /// Returns the light as a panorama for other renderers, with twice as many columns as rows. The top row is up, the middle faces +x, and
    /// columns run clockwise when seen from above. The sun is one texel.
    pub fn panorama(&self, rows: u32) -> Picture {
        let step = std::f32::consts::PI / rows as f32;
        let direction = |index: u32| {
            let (row, column) = (index / (2 * rows), index % (2 * rows));
            let (down, around) = ((row as f32 + 0.5) * step, (rows as f32 - column as f32 - 0.5) * step);
            Vec3::new(around.cos() * down.sin(), around.sin() * down.sin(), down.cos())
        };
        let texels = 0..2 * rows * rows;
        let mut pixels: Vec<[f32; 4]> =
            texels.clone().map(|i| self.sky_in(direction(i)).extend(1.0).to_array()).collect();
        let sun =
            texels.max_by(|&a, &b| direction(a).dot(self.sun).total_cmp(&direction(b).dot(self.sun))).unwrap_or(0);
        let solid_angle = step * step * direction(sun).truncate().length();
        let disk = self.irradiance / solid_angle;
        pixels[sun as usize] = disk.extend(1.0).to_array();
        Picture { size: [2 * rows, rows], pixels }
    }

    /// Returns the radiance of the sky without the sun.
    fn sky_in(&self, d: Vec3) -> Vec3 {
        let sum: Vec3 = self.sky.iter().zip(basis(d)).map(|(c, basis)| *c * basis).sum();
        sum.max(Vec3::ZERO)
    }

    /// Returns the uniform block of the shader.
    pub fn block(&self) -> ViewBlock {
        let [corner, across, down] = self.rays();
        ViewBlock {
            eye: self.eye.extend(0.0),
            corner: corner.extend(0.0),
            across: across.extend(0.0),
            down: down.extend(0.0),
            sun: self.sun.extend(0.0),
            irradiance: self.irradiance.extend(0.0),
            sky: self.sky.map(|c| c.extend(0.0)),
            scales: Vec4::new(self.repeat, self.height_scale, 0.0, 0.0),
        }
    }
}

/// The block `View` of `plane.frag` in std140 layout.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ViewBlock {
    eye: Vec4,
    corner: Vec4,
    across: Vec4,
    down: Vec4,
    sun: Vec4,
    irradiance: Vec4,
    sky: [Vec4; 9],
    scales: Vec4,
}

/// Returns the radiance of a morning sky over slightly reflective ground.
fn clear_sky(d: Vec3) -> Vec3 {
    let haze = Vec3::new(1.05, 0.92, 0.78).lerp(Vec3::new(0.22, 0.40, 0.75), d.z.max(0.0).powf(0.45));
    let glow = Vec3::new(1.6, 1.0, 0.5) * (d.dot(Vec3::new(0.8, 0.35, 0.2).normalize()).max(0.0)).powi(6);
    let ground = Vec3::new(0.22, 0.19, 0.16);
    (haze + glow).lerp(ground, (0.5 - 8.0 * d.z).clamp(0.0, 1.0))
}

/// Returns the spherical harmonics of a radiance up to order 2, by the midpoint rule over the sphere.
pub fn harmonics(radiance: impl Fn(Vec3) -> Vec3) -> [Vec3; 9] {
    const RINGS: u32 = 128;
    let mut sums = [Vec3::ZERO; 9];
    for i in 0..RINGS {
        for j in 0..2 * RINGS {
            let z = 1.0 - (2 * i + 1) as f32 / RINGS as f32;
            let azimuth = (j as f32 + 0.5) * std::f32::consts::PI / RINGS as f32;
            let d = Vec3::new(azimuth.cos(), azimuth.sin(), 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z;
            let part = radiance(d) * (2.0 * std::f32::consts::PI / (RINGS * RINGS) as f32);
            sums.iter_mut().zip(basis(d)).for_each(|(sum, basis)| *sum += basis * part);
        }
    }
    sums
}

/// Returns the spherical harmonics up to order 2 for a unit direction.
fn basis(d: Vec3) -> [f32; 9] {
    [
        0.282_094_79,
        0.488_602_51 * d.y,
        0.488_602_51 * d.z,
        0.488_602_51 * d.x,
        1.092_548_4 * d.x * d.y,
        1.092_548_4 * d.y * d.z,
        0.315_391_57 * (3.0 * d.z * d.z - 1.0),
        1.092_548_4 * d.x * d.z,
        0.546_274_2 * (d.x * d.x - d.y * d.y),
    ]
}
