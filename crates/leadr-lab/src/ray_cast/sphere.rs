//! Renders pictures of a sphere with infinitely fine relief. Every pixel is a [`Patch`](super::Patch) at its own angle.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::patch::{Facet, Patch};
use leadr_reflectance::frame::{Frame, to_frame};
use leadr_reflectance::random::Random;

/// One pixel of a unit sphere in an orthographic view from `+z`, with x to the right and y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpherePixel {
    /// The tangents and the normal of the sphere. The frame's x axis points along the pixel's meridian, towards the top of
    /// the sphere.
    pub frame: Frame,
    /// The view direction in `frame`.
    pub wo: DVec3,
}

impl SpherePixel {
    /// Returns the centre of pixel `(x, y)` of `size`² pixels, with row 0 on top. Returns `None` outside the sphere.
    /// `radius` is the radius of the sphere in half picture widths.
    pub fn new(x: u32, y: u32, size: u32, radius: f64) -> Option<Self> {
        let at = |i: u32| ((2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0) / radius;
        let p = DVec2::new(at(x), -at(y));
        let square = p.length_squared();
        if square >= 1.0 {
            return None;
        }
        let z = p.extend((1.0 - square).sqrt());
        let x = (DVec3::Y - z * z.y).normalize_or(DVec3::X);
        let frame = Frame { x, y: z.cross(x), z };
        Some(Self { frame, wo: to_frame(&frame, DVec3::Z) })
    }
}

/// `K` pictures of a sphere and their noise.
#[derive(Clone, Debug)]
pub struct SphereTruth<const K: usize> {
    /// The number of pixels along a side.
    pub size: u32,
    /// The radius of the sphere, in half picture widths.
    pub radius: f64,
    /// The values per pixel for two halves of the rays, row by row from the top. Pixels outside the sphere are `None`.
    pub halves: Vec<Option<[[f64; K]; 2]>>,
}

/// The difference between a picture and the truth, relative to the truth's mean over the same pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereError {
    /// The RMSE without the noise of the truth. If the estimated noise exceeds the difference, the value is negative (minus
    /// the root of the deficit), and the difference is too small to measure.
    pub rmse: f64,
    /// The RMSE including the noise.
    pub rmse_with_noise: f64,
    /// The standard error of a pixel of the truth.
    pub noise: f64,
    /// The mean difference, which is positive if the picture is too bright.
    pub bias: f64,
    /// The mean difference over pixels whose normal has `z < 0.35`, relative to the mean of the same pixels.
    pub rim_bias: f64,
}

impl<const K: usize> SphereTruth<K> {
    /// Casts `rays`² rays per pixel against `patch`. `rays` must be even. `value` returns the radiance of a facet towards
    /// the viewer. Normals and directions are in the frame of the pixel.
    pub fn cast(
        patch: &Patch<'_>,
        size: u32,
        radius: f64,
        rays: u32,
        seed: u64,
        value: impl Fn(&SpherePixel, &Facet, &mut Random) -> [f64; K] + Sync,
    ) -> Self {
        let halves = (0..size * size)
            .into_par_iter()
            .map(|i| {
                let pixel = SpherePixel::new(i % size, i / size, size, radius)?;
                let seed = seed.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(u64::from(i));
                let estimate =
                    patch.mean_over_visible(pixel.wo, rays.next_multiple_of(2), seed, |f, r| value(&pixel, f, r));
                estimate.map(|e| e.halves)
            })
            .collect();
        Self { size, radius, halves }
    }

    /// Returns the mean of both halves of picture `k` at a pixel.
    pub fn at(&self, k: usize, x: u32, y: u32) -> Option<f64> {
        self.halves[(y * self.size + x) as usize].map(|h| 0.5 * (h[0][k] + h[1][k]))
    }

    /// Compares picture `k` with `model`, which returns a pixel's value, or NaN to skip the pixel. The halves of the rays
    /// are independent, so the mean product of their differences is the mean squared difference without noise.
    pub fn compare(&self, k: usize, model: impl Fn(u32, u32, &SpherePixel) -> f64) -> SphereError {
        let mut sums = Sums::default();
        let mut rim = Sums::default();
        for (i, halves) in self.halves.iter().enumerate() {
            let (x, y) = (i as u32 % self.size, i as u32 / self.size);
            if let (Some([a, b]), Some(pixel)) = (halves, SpherePixel::new(x, y, self.size, self.radius)) {
                let value = model(x, y, &pixel);
                if value.is_nan() {
                    continue;
                }
                sums.add(value, a[k], b[k]);
                if pixel.frame.z.z < 0.35 {
                    rim.add(value, a[k], b[k]);
                }
            }
        }
        let (n, mean) = (sums.count.max(1.0), sums.truth / sums.count.max(1.0));
        let root = |square: f64| (square.abs() / n).sqrt().copysign(square) / mean;
        SphereError {
            rmse: root(sums.product),
            rmse_with_noise: root(sums.product + sums.noise),
            noise: root(sums.noise),
            bias: sums.difference / sums.truth,
            rim_bias: rim.difference / rim.truth,
        }
    }
}

#[derive(Default)]
struct Sums {
    count: f64,
    truth: f64,
    difference: f64,
    product: f64,
    noise: f64,
}

impl Sums {
    fn add(&mut self, value: f64, a: f64, b: f64) {
        let truth = 0.5 * (a + b);
        self.count += 1.0;
        self.truth += truth;
        self.difference += value - truth;
        self.product += (value - a) * (value - b);
        self.noise += 0.25 * (a - b) * (a - b);
    }
}
