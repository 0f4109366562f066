//! Periodic lattice noise, which is a pure function of seed and position. Coordinates are in lattice cells, and the noise
//! repeats after `period` cells.

/// The source text of this module, which is part of cache keys.
pub const SOURCE: &str = include_str!("noise.rs");

/// Returns a 32-bit hash of a seed and a cell. Murmur's finaliser is applied after each word.
pub fn hash(seed: u32, x: i32, y: i32) -> u32 {
    let mix = |mut h: u32| {
        h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^ (h >> 16)
    };
    let h = mix(seed.wrapping_mul(0x9e37_79b1).wrapping_add(0x7f4a_7c15));
    let h = mix(h ^ (x as u32).wrapping_mul(0x9e37_79b1));
    mix(h ^ (y as u32).wrapping_mul(0x27d4_eb2f))
}

/// Converts a hash to a uniform number in 0..1.
pub fn unit(h: u32) -> f32 {
    (h >> 8) as f32 / (1 << 24) as f32
}

/// Returns a smooth Hermite step: 0 below `low`, 1 above `high`.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Transposes an image with rows of `width` texels.
pub fn transpose(texels: &[f32], width: usize) -> Vec<f32> {
    let height = texels.len() / width;
    (0..texels.len()).map(|i| texels[i % height * width + i / height]).collect()
}

fn corner_gradient(seed: u32, x: i32, y: i32) -> [f32; 2] {
    let (sin, cos) = (unit(hash(seed, x, y)) * std::f32::consts::TAU).sin_cos();
    [cos, sin]
}

/// Blends the gradients at the corners `(i, j)` of a cell, where `i` and `j` are 0 or 1, by a quintic. The result is scaled
/// into -1..1.
fn blended(fx: f32, fy: f32, gradient: impl Fn(usize, usize) -> [f32; 2]) -> f32 {
    let corner = |i: usize, j: usize| {
        let [cos, sin] = gradient(i, j);
        cos * (fx - i as f32) + sin * (fy - j as f32)
    };
    let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let (u, v) = (fade(fx), fade(fy));
    let value = mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v);
    value * std::f32::consts::SQRT_2
}

/// Returns gradient noise with unit gradients and quintic blending. The noise has mean 0 and is scaled into -1..1.
/// `Gradients` is faster for many positions.
pub fn gradient(seed: u32, x: f32, y: f32, period: i32) -> f32 {
    let (cx, cy) = (x.floor(), y.floor());
    blended(x - cx, y - cy, |i, j| {
        corner_gradient(seed, (cx as i32 + i as i32).rem_euclid(period), (cy as i32 + j as i32).rem_euclid(period))
    })
}

/// Returns a sum of octaves of [`gradient`]. Octaves double in frequency, and `gain` scales the amplitude of each octave.
/// `Fractal` is faster for many positions.
pub fn fractal(seed: u32, x: f32, y: f32, period: i32, octaves: u32, gain: f32) -> f32 {
    let octave = |k: u32, scale: f32| gradient(seed.wrapping_add(k), x * scale, y * scale, period << k);
    sum_of_octaves(octaves, gain, octave)
}

/// Returns a sum of octaves. `at` receives the number and frequency of an octave.
fn sum_of_octaves(octaves: u32, gain: f32, at: impl Fn(u32, f32) -> f32) -> f32 {
    let (mut sum, mut amplitude) = (0.0, 1.0);
    for octave in 0..octaves {
        sum += amplitude * at(octave, (1 << octave) as f32);
        amplitude *= gain;
    }
    sum
}

fn cell_and_next(cell: f32, period: usize) -> [usize; 2] {
    let here = (cell as i32).rem_euclid(period as i32) as usize;
    [here, if here + 1 == period { 0 } else { here + 1 }]
}

/// Like [`gradient`], but with precomputed gradients.
pub(crate) struct Gradients {
    period: usize,
    corners: Vec<[f32; 2]>,
}

impl Gradients {
    pub(crate) fn new(seed: u32, period: i32) -> Self {
        let corners = (0..period).flat_map(|y| (0..period).map(move |x| corner_gradient(seed, x, y))).collect();
        Self { period: period as usize, corners }
    }

    pub(crate) fn at(&self, x: f32, y: f32) -> f32 {
        let (cx, cy) = (x.floor(), y.floor());
        let (columns, rows) = (cell_and_next(cx, self.period), cell_and_next(cy, self.period));
        blended(x - cx, y - cy, |i, j| self.corners[rows[j] * self.period + columns[i]])
    }
}

/// Like [`fractal`], but with precomputed gradients.
pub(crate) struct Fractal {
    octaves: Vec<Gradients>,
    gain: f32,
}

impl Fractal {
    pub(crate) fn new(seed: u32, period: i32, octaves: u32, gain: f32) -> Self {
        let octave = |k: u32| Gradients::new(seed.wrapping_add(k), period << k);
        Self { octaves: (0..octaves).map(octave).collect(), gain }
    }

    pub(crate) fn at(&self, x: f32, y: f32) -> f32 {
        let octave = |k: u32, scale: f32| self.octaves[k as usize].at(x * scale, y * scale);
        sum_of_octaves(self.octaves.len() as u32, self.gain, octave)
    }
}

/// Like [`gradient`], but on a rotated lattice. The period is the unit square.
struct RotatedLattice {
    /// The lattice steps `(a, b)` along one period in s.
    along: [i32; 2],
    /// The first lattice corner of the table, and the number of corners per row.
    first: i32,
    width: usize,
    corners: Vec<[f32; 2]>,
}

impl RotatedLattice {
    /// Creates a lattice with about `cells` cells per period. The lattice is rotated by the angle nearest to `degrees` for
    /// which the noise repeats.
    fn new(seed: u32, cells: i32, degrees: f32) -> Self {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let [a, b] = [cos, sin].map(|part| (cells as f32 * part).round() as i32);
        // Corners that differ by whole periods, (a, −b) or (b, a), have equal gradients.
        let count = a * a + b * b;
        let (reach, first) = (a.abs() + b.abs(), -(a.abs() + b.abs()) - 1);
        let width = (2 * reach + 4) as usize;
        let corner = |i: i32, j: i32| {
            corner_gradient(seed, (a * i - b * j).rem_euclid(count), (b * i + a * j).rem_euclid(count))
        };
        let ends = first..first + width as i32;
        let corners = ends.clone().flat_map(|j| ends.clone().map(move |i| corner(i, j))).collect();
        Self { along: [a, b], first, width, corners }
    }

    fn at(&self, s: f32, t: f32) -> f32 {
        let ([a, b], s, t) = (self.along.map(|n| n as f32), s - s.floor(), t - t.floor());
        let (x, y) = (a * s + b * t, a * t - b * s);
        let (cx, cy) = (x.floor(), y.floor());
        let [column, row] = [cx, cy].map(|c| (c as i32 - self.first) as usize);
        blended(x - cx, y - cy, |i, j| self.corners[(row + j) * self.width + column + i])
    }
}

/// Isotropic gradient noise whose period is the unit square. The noise sums three rotated lattices, because a single lattice
/// with few cells shows its rows. The sum is scaled to the amplitude of one lattice.
pub(crate) struct RotatedGradients([RotatedLattice; 3]);

impl RotatedGradients {
    pub(crate) fn new(seed: u32, cells: i32) -> Self {
        // Each octave has a different rotation.
        let rotation = 10.0 + 17.0 * (seed % 3) as f32;
        Self([0, 1, 2].map(|k| RotatedLattice::new(seed.wrapping_add(0x1000 * k), cells, rotation + 30.0 * k as f32)))
    }

    pub(crate) fn at(&self, s: f32, t: f32) -> f32 {
        self.0.iter().map(|lattice| lattice.at(s, t)).sum::<f32>() / 3f32.sqrt()
    }
}

/// Octaves of [`RotatedGradients`], with the unit square as period. Octaves double in frequency, and `gain` scales the
/// amplitude of each octave.
pub(crate) struct RotatedFractal {
    octaves: Vec<RotatedGradients>,
    gain: f32,
}

impl RotatedFractal {
    pub(crate) fn new(seed: u32, cells: i32, octaves: u32, gain: f32) -> Self {
        Self { octaves: (0..octaves).map(|k| RotatedGradients::new(seed.wrapping_add(k), cells << k)).collect(), gain }
    }

    pub(crate) fn at(&self, s: f32, t: f32) -> f32 {
        self.octaves.iter().rev().fold(0.0, |sum, octave| octave.at(s, t) + self.gain * sum)
    }
}

/// Calls `visit` for the `(2 reach + 1)^2` cells around a position. Each cell contains one random point. The arguments are
/// the offset in cells from the point to the position, and the cell's random number.
pub fn features(seed: u32, x: f32, y: f32, period: i32, reach: i32, mut visit: impl FnMut([f32; 2], u32)) {
    let (cx, cy) = (x.floor() as i32, y.floor() as i32);
    for j in -reach..=reach {
        for i in -reach..=reach {
            let id = hash(seed, (cx + i).rem_euclid(period), (cy + j).rem_euclid(period));
            let (px, py) = (unit(id), unit(hash(id, 1, 2)));
            let offset = [x - (cx + i) as f32 - px, y - (cy + j) as f32 - py];
            visit(offset, id);
        }
    }
}

/// Like [`features`], but with a precomputed value per cell.
pub(crate) struct Scattered<T> {
    period: usize,
    /// The position of each cell's point within the cell, and the cell's value.
    cells: Vec<([f32; 2], T)>,
}

impl<T> Scattered<T> {
    /// Builds the table. `value` maps a cell's random number to the cell's value.
    pub(crate) fn new(seed: u32, period: i32, value: impl Fn(u32) -> T) -> Self {
        let cell = |x, y| {
            let id = hash(seed, x, y);
            ([unit(id), unit(hash(id, 1, 2))], value(id))
        };
        let cells = (0..period).flat_map(|y| (0..period).map(move |x| (x, y))).map(|(x, y)| cell(x, y)).collect();
        Self { period: period as usize, cells }
    }

    /// Calls `visit` for the points of the `(2 reach + 1)^2` cells around a position. The arguments are the offset to the
    /// position and the cell's value.
    pub(crate) fn visit(&self, x: f32, y: f32, reach: i32, mut visit: impl FnMut([f32; 2], &T)) {
        let (cx, cy) = (x.floor() as i32, y.floor() as i32);
        let first = |c: i32| (c - reach).rem_euclid(self.period as i32) as usize;
        let next = |k: usize| if k + 1 == self.period { 0 } else { k + 1 };
        let mut row = first(cy);
        for j in -reach..=reach {
            let mut column = first(cx);
            for i in -reach..=reach {
                let ([px, py], value) = &self.cells[row * self.period + column];
                visit([x - (cx + i) as f32 - px, y - (cy + j) as f32 - py], value);
                column = next(column);
            }
            row = next(row);
        }
    }

    /// Returns the distances to the nearest and second nearest points, in cells. On cell borders the two distances are
    /// equal.
    pub(crate) fn nearest_two(&self, x: f32, y: f32) -> [f32; 2] {
        let mut best = [f32::MAX; 2];
        self.visit(x, y, 2, |[dx, dy], _| {
            let d = dx * dx + dy * dy;
            if d < best[0] {
                best = [d, best[0]];
            } else if d < best[1] {
                best[1] = d;
            }
        });
        best.map(f32::sqrt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotated_noise_repeats_and_favours_no_direction() {
        for cells in [3, 12, 48] {
            let noise = RotatedGradients::new(7, cells);
            let n = 256;
            let at = |i: u32, j: u32| noise.at(i as f32 / n as f32, j as f32 / n as f32);
            let step = 1.0 / (cells as f32 * 50.0);
            let (mut square, mut along, mut across, mut diagonal) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
            for i in 0..n {
                for j in 0..n {
                    let (s, t) = (i as f32 / n as f32, j as f32 / n as f32);
                    let here = at(i, j);
                    // A shift by whole periods causes rounding errors.
                    assert!((noise.at(s + 3.0, t - 2.0) - here).abs() < 1e-3);
                    let change = |ds: f32, dt: f32| f64::from(noise.at(s + ds, t + dt) - here).powi(2);
                    square += f64::from(here * here);
                    along += change(step, 0.0);
                    across += change(0.0, step);
                    diagonal += 0.5 * (change(0.707 * step, 0.707 * step) + change(0.707 * step, -0.707 * step));
                }
            }
            let rms = (square / f64::from(n * n)).sqrt();
            println!(
                "{cells} cells: rms {rms:.3}, slopes {:.3} {:.3}",
                across / along,
                2.0 * diagonal / (along + across)
            );
            assert!((0.2..0.5).contains(&rms), "{rms}");
            assert!(cells < 12 || (across / along - 1.0).abs() < 0.15, "{cells} cells: {}", across / along);
            assert!((2.0 * diagonal / (along + across) - 1.0).abs() < 0.1, "{cells} cells");
        }
    }

    #[test]
    fn tables_match_the_functions() {
        let (gradients, octaves) = (Gradients::new(7, 5), Fractal::new(9, 3, 4, 0.6));
        let points = Scattered::new(11, 6, |id| id);
        for k in 0..500 {
            let (x, y) = (0.37 * k as f32 - 40.0, 0.23 * k as f32 - 61.0);
            assert_eq!(gradients.at(x, y), gradient(7, x, y, 5));
            assert_eq!(octaves.at(x, y), fractal(9, x, y, 3, 4, 0.6));
            let mut seen = Vec::new();
            points.visit(x, y, 2, |offset, &id| seen.push((offset, id)));
            let mut wanted = Vec::new();
            features(11, x, y, 6, 2, |offset, id| wanted.push((offset, id)));
            assert_eq!(seen, wanted);
            let mut distances: Vec<f32> = wanted.iter().map(|([dx, dy], _)| dx.hypot(*dy)).collect();
            distances.sort_by(f32::total_cmp);
            let [first, second] = points.nearest_two(x, y);
            assert!((first - distances[0]).abs() < 1e-6 && (second - distances[1]).abs() < 1e-6);
        }
    }
}
