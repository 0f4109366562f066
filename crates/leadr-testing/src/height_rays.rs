//! Marches rays over height fields to measure the visibility of a texel without horizons or slices. Tests and `examples/21_derived_maps.rs`
//! use it.

#![allow(dead_code, reason = "each user has its own part")]

use leadr_maps::{HeightMap, Wrap};

/// A height field in units of texels. Heights are linear along the edges between neighbours.
pub struct HeightRays {
    width: i64,
    height: i64,
    texels: Vec<f32>,
    wrap: Wrap,
    highest: f64,
    /// The length of the rays in texels.
    reach: f64,
}

impl HeightRays {
    /// Creates the height field. `scale` converts heights to texture widths.
    pub fn new(map: &HeightMap, scale: f32, wrap: Wrap) -> Self {
        Self::within(map, scale, wrap, f64::INFINITY)
    }

    /// Like [`new`](Self::new), with rays of a length in texture widths.
    pub fn within(map: &HeightMap, scale: f32, wrap: Wrap, distance: f64) -> Self {
        let texels: Vec<f32> = map.texels.iter().map(|h| h * scale * map.width as f32).collect();
        let highest = texels.iter().fold(f32::MIN, |a, &b| a.max(b)).into();
        Self {
            width: map.width.into(),
            height: map.height.into(),
            texels,
            wrap,
            highest,
            reach: distance * f64::from(map.width),
        }
    }

    fn texel(&self, x: i64, y: i64) -> f64 {
        let (x, y) = match self.wrap {
            Wrap::Repeat => (x.rem_euclid(self.width), y.rem_euclid(self.height)),
            Wrap::Clamp => (x.clamp(0, self.width - 1), y.clamp(0, self.height - 1)),
        };
        self.texels[(y * self.width + x) as usize].into()
    }

    /// Whether a ray from the centre of a texel is unoccluded. Below the horizontal, rays of unlimited length are occluded.
    pub fn is_free(&self, x: u32, y: u32, direction: [f64; 3]) -> bool {
        let [dx, dy, dz] = direction;
        if dz <= 0.0 && self.reach == f64::INFINITY {
            return false;
        }
        let (x, y) = (i64::from(x), i64::from(y));
        let own = self.texel(x, y);
        let end = if dz > 0.0 { self.reach.min((self.highest - own) / dz) } else { self.reach };
        // The ray is tested at its crossings with the columns of texels, then with the rows.
        let crossings = |along: f64, across: f64, height: &dyn Fn(i64, f64) -> f64| {
            if along == 0.0 {
                return true;
            }
            let (step, per) = (along.signum() as i64, 1.0 / along.abs());
            let mut k = 1;
            loop {
                let t = k as f64 * per;
                if t > end {
                    return true;
                }
                if height(step * k, t * across) > own + t * dz + 1e-6 {
                    return false;
                }
                k += 1;
            }
        };
        let between = |a: f64, b: f64, v: f64| a + (v - v.floor()) * (b - a);
        crossings(dx, dy, &|k, v| {
            let low = y + v.floor() as i64;
            between(self.texel(x + k, low), self.texel(x + k, low + 1), v)
        }) && crossings(dy, dx, &|k, v| {
            let low = x + v.floor() as i64;
            between(self.texel(low, y + k), self.texel(low + 1, y + k), v)
        })
    }

    /// Returns the fraction of `n`² cosine-distributed directions about a normal of any length that are unoccluded.
    pub fn visibility(&self, x: u32, y: u32, normal: [f64; 3], n: u32) -> f64 {
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        let [a, b, c] = normal.map(|v| v / length);
        // The frame about the normal (Duff et al. 2017) needs c > 0.
        let (p, q) = (-1.0 / (1.0 + c), -a * b / (1.0 + c));
        let (u, v) = ([1.0 + p * a * a, q, -a], [q, 1.0 + p * b * b, -b]);
        let mut free = 0;
        let mut state = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b);
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for i in 0..n * n {
            let square = (f64::from(i % n) + random()) / f64::from(n);
            let azimuth = std::f64::consts::TAU * (f64::from(i / n) + random()) / f64::from(n);
            let (r, z) = (square.sqrt(), (1.0 - square).sqrt());
            let (s, t) = (r * azimuth.cos(), r * azimuth.sin());
            let direction = std::array::from_fn(|k| s * u[k] + t * v[k] + z * [a, b, c][k]);
            free += u32::from(self.is_free(x, y, direction));
        }
        f64::from(free) / f64::from(n * n)
    }
}
