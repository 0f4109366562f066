//! The reference of the sea against an independent 64-bit ray march on the CPU, with small even steps through waves from oversampled
//! Fourier transforms.

use std::f64::consts::TAU;

use super::waves::inverse;
use glam::{DVec2, DVec3, Vec2, Vec3};
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::sky::Sky;
use leadr::render::scene::FrameState;
use leadr::render::settings::{RenderSettings, Technique};
use leadr::render::surfaces::ocean::Ocean;
use leadr::render::surfaces::ocean::mesh::EARTH;
use leadr::render::surfaces::ocean::waves::{Cascade, PERIOD};
use leadr::scenes::ocean::sea::ocean;
use leadr::scenes::ocean::spectrum::Sea;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::seascape;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

const TIME: f64 = 5.0;
/// Transform samples per cascade sample; equal to the reference's, so that linear interpolation affects the shortest waves equally.
const OVER: usize = 2;
/// `h, Dx, Dy, ∂h/∂x, ∂h/∂y, ∂Dx/∂x, ∂Dy/∂y, ∂Dx/∂y`.
type Fields = [f64; 8];

struct Tile {
    n: usize,
    size: f64,
    rotation: DVec2,
    texels: Vec<Fields>,
}

impl Tile {
    fn new(cascade: &Cascade, choppiness: f64) -> Self {
        let (m, n) = (cascade.resolution as usize, cascade.resolution as usize * OVER);
        let at = |i: usize, j: usize| cascade.waves[(j % m) * m + i % m].map(f64::from);
        // Negative frequencies stay at the end of the longer transform.
        let index_in = |i: usize| if i < m / 2 { i } else { i + n - m };
        let mut texels = vec![[0.0; 8]; n * n];
        for channel in 0..8 {
            let mut field = vec![Complex64::ZERO; n * n];
            for j in 0..m {
                for i in 0..m {
                    let (w, back) = (at(i, j), at(m - i, m - j));
                    let phase = |cycles: f64| Complex64::cis(TAU * (cycles * TIME / PERIOD).fract());
                    let h = Complex64::new(w[0], w[1]) * phase(w[2]).conj()
                        + Complex64::new(back[0], -back[1]) * phase(back[2]);
                    let k = cascade.wave_vector(i as u32, j as u32);
                    let (length, i1) = (k.length().max(1e-9), Complex64::I);
                    field[index_in(j) * n + index_in(i)] = h * match channel {
                        0 => Complex64::ONE,
                        1 => i1 * (choppiness * k.x / length),
                        2 => i1 * (choppiness * k.y / length),
                        3 => i1 * k.x,
                        4 => i1 * k.y,
                        5 => Complex64::from(-choppiness * k.x * k.x / length),
                        6 => Complex64::from(-choppiness * k.y * k.y / length),
                        _ => Complex64::from(-choppiness * k.x * k.y / length),
                    };
                }
            }
            for (texel, value) in texels.iter_mut().zip(inverse(&mut field, n)) {
                texel[channel] = value;
            }
        }
        Self { n, size: cascade.size, rotation: DVec2::from_angle(cascade.rotation), texels }
    }

    fn add(&self, point: DVec2, channels: std::ops::Range<usize>, sum: &mut Fields) {
        // Samples are at texel centres, as on the device.
        let local = DVec2::new(self.rotation.dot(point), self.rotation.perp_dot(point)) * (self.n as f64 / self.size);
        let local = local - DVec2::splat(0.5);
        let (base, f) = (local.floor(), local - local.floor());
        let wrap = |v: f64, by: usize| (v.rem_euclid(self.n as f64) as usize + by) % self.n;
        for (dy, wy) in [(0, 1.0 - f.y), (1, f.y)] {
            for (dx, wx) in [(0, 1.0 - f.x), (1, f.x)] {
                let texel = &self.texels[wrap(base.y, dy) * self.n + wrap(base.x, dx)];
                for c in channels.clone() {
                    sum[c] += wx * wy * texel[c];
                }
            }
        }
    }
}

/// Sum of all tiles at a point of the undisplaced sea.
fn fields(tiles: &[Tile], point: DVec2, channels: std::ops::Range<usize>) -> Fields {
    let mut sum = [0.0; 8];
    tiles.iter().for_each(|tile| tile.add(point, channels.clone(), &mut sum));
    sum
}

/// Height of the displaced sea above a point.
fn height(tiles: &[Tile], position: DVec2, shift: &mut DVec2) -> f64 {
    for _ in 0..60 {
        let f = fields(tiles, position - *shift, 0..3);
        let moved = DVec2::new(f[1], f[2]);
        let settled = moved.distance(*shift) < 1e-4;
        *shift = moved;
        if settled {
            return f[0];
        }
    }
    fields(tiles, position - *shift, 0..1)[0]
}

/// Distance along a ray to the sea, and the slope there.
fn cast(tiles: &[Tile], bound: f64, eye: DVec3, direction: DVec3, step: f64) -> Option<(f64, DVec2)> {
    let curve = direction.truncate().length_squared() / (2.0 * f64::from(EARTH));
    let ray = |s: f64| eye.z + direction.z * s + curve * s * s;
    let mut s = (0.0f64).max((bound - eye.z) / direction.z);
    let (mut shift, end) = (DVec2::ZERO, 20_000.0);
    let above = |s: f64, shift: &mut DVec2| ray(s) - height(tiles, eye.truncate() + direction.truncate() * s, shift);
    while above(s, &mut shift) > 0.0 {
        s += step;
        if s > end {
            return None;
        }
    }
    let (mut low, mut high) = (s - step, s);
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if above(middle, &mut shift) > 0.0 { low = middle } else { high = middle }
    }
    let position = eye.truncate() + direction.truncate() * high;
    height(tiles, position, &mut shift);
    let f = fields(tiles, position - shift, 0..8);
    let (jxx, jyy, jxy) = (1.0 + f[5], 1.0 + f[6], f[7]);
    let area = (jxx * jyy - jxy * jxy).max(0.1);
    let slope = DVec2::new(jyy * f[3] - jxy * f[4], jxx * f[4] - jxy * f[3]) / area;
    Some((high, slope - (position - eye.truncate() - shift) / f64::from(EARTH)))
}

fn reference(size: (u32, u32), samples: u32) -> RenderSettings {
    let shading = Technique::Reference.into();
    RenderSettings { size, samples, shading, ..RenderSettings::default() }
}

fn frame(camera: Camera) -> FrameState {
    FrameState { time: TIME, ..FrameState::new(camera, Vec::new()).under(&Sky::default()) }
}

#[test]
fn rays_meet_the_sea_where_an_independent_march_does() {
    let Some(gpu) = test_gpu() else { return };
    let sea = Sea { wind_speed: 7.0, wind_direction: 0.4, ..Sea::default() };
    let sea = ocean(&sea, 128, 2);
    let tiles: Vec<Tile> = sea.cascades.par_iter().map(|c| Tile::new(c, f64::from(sea.choppiness))).collect();
    let bound = 5.0 * f64::from(sea.height);
    let mut renderer = seascape(&gpu, sea);
    let size = (24, 16);
    // Eye height, angle below the horizon, field of view in degrees.
    for (eye_height, down, fov) in [(2.5, 0.25f32, 20.0), (100.0, 0.4, 30.0), (20.0, 0.07, 3.0)] {
        let eye = Vec3::new(3.0, -2.0, eye_height);
        let camera = Camera::looking_at(eye, eye + Vec3::new(down.cos(), 0.0, -down.sin()), fov);
        renderer.render(&frame(camera), &reference(size, 1)).unwrap();
        let (depth, slopes) = (renderer.layer(Layer::Depth).unwrap(), renderer.layer(Layer::MeanSlope).unwrap());
        let [x, y, z] = camera.rays(size, Vec2::ZERO);
        let step = if eye_height < 10.0 { 0.01 } else { 0.02 };
        let pixels: Vec<u32> = (0..size.0 * size.1).filter(|p| p % 5 == 0).collect();
        let truth: Vec<_> = pixels
            .par_iter()
            .map(|&p| {
                let ndc = |v: u32, n: u32| (2.0 * v as f32 + 1.0) / n as f32 - 1.0;
                let ray = (z + x * ndc(p % size.0, size.0) + y * ndc(p / size.0, size.1)).as_dvec3();
                let (s, slope) = cast(&tiles, bound, eye.as_dvec3(), ray.normalize(), step).expect("water");
                (s / ray.length(), slope)
            })
            .collect();
        let (mut same, mut errors) = (0, [0.0f64; 2]);
        let mut sums = [[0.0f64; 4]; 2];
        for (&p, (along, slope)) in pixels.iter().zip(&truth) {
            let d = f64::from(depth[p as usize][0]);
            let s = DVec2::new(f64::from(slopes[p as usize][0]), f64::from(slopes[p as usize][1]));
            if (d - along).abs() < 0.005 / f64::from(down) && s.distance(*slope) < 0.05 {
                same += 1;
                errors[0] += (d - along).abs();
                errors[1] += s.distance_squared(*slope);
            }
            for (sum, s) in sums.iter_mut().zip([*slope, s]) {
                [s.x, s.y, s.x * s.x, s.y * s.y].iter().zip(sum).for_each(|(v, sum)| *sum += v / pixels.len() as f64);
            }
        }
        let part = f64::from(same) / pixels.len() as f64;
        println!(
            "{eye_height} m: {:.1} % of {} rays meet the same place; there depths differ by {:.4} m, slopes by {:.4} rms; \
             means and squares of the slopes {:.4?} of {:.4?}",
            100.0 * part,
            pixels.len(),
            errors[0] / f64::from(same),
            (errors[1] / f64::from(same)).sqrt(),
            sums[1],
            sums[0]
        );
        assert!(part >= 0.97, "{eye_height} m: {part}");
        for c in 0..4 {
            let tolerance = 0.05 * (sums[0][2] + sums[0][3]).powf(if c < 2 { 0.5 } else { 1.0 });
            assert!((sums[0][c] - sums[1][c]).abs() < tolerance, "{eye_height} m: {sums:?}");
        }
    }
}

#[test]
#[ignore = "long"]
fn samples_from_above_have_the_slopes_of_the_spectrum_and_repeat() {
    let Some(gpu) = test_gpu() else { return };
    let sea = Sea { wind_speed: 8.0, wind_direction: 0.4, ..Sea::default() };
    let flat = Ocean { choppiness: 0.0, ..ocean(&sea, 256, 2) };
    let exact: Vec<f64> = {
        let (all, tail) = (sea.moments(0.0, f64::INFINITY).slopes, flat.tail);
        [tail.x, tail.y, tail.z].iter().zip(all).map(|(t, a)| a - f64::from(*t)).collect()
    };
    let mut renderer = seascape(&gpu, flat);
    let eye = Vec3::Z * 3000.0;
    let camera = Camera { up: Vec3::Y, ..Camera::looking_at(eye, Vec3::ZERO, 40.0) };
    let settings = reference((96, 64), 1);
    let first = renderer.render(&frame(camera), &settings).unwrap();
    let slopes = renderer.layer(Layer::MeanSlope).unwrap();
    let mean = |f: &dyn Fn(f64, f64) -> f64| {
        slopes.iter().map(|s| f(f64::from(s[0]), f64::from(s[1]))).sum::<f64>() / slopes.len() as f64
    };
    let found = [mean(&|x, _| x * x), mean(&|_, y| y * y), mean(&|x, y| x * y)];
    println!("slopes {found:.5?} of {exact:.5?}");
    for i in 0..3 {
        // 6144 samples: 2 % of noise.
        assert!((found[i] - exact[i]).abs() < 0.05 * exact[0], "{i}: {found:?} {exact:?}");
    }
    assert_eq!(
        first.color,
        renderer.render(&frame(camera), &settings).unwrap().color,
        "the same call gave other bytes"
    );
    // Pictures of different seeds converge with more samples.
    let apart = |renderer: &mut Renderer, samples: u32| {
        let [a, b] = [1, 2].map(|seed| {
            renderer.render(&frame(camera), &RenderSettings { seed, ..reference((24, 16), samples) }).unwrap().color
        });
        let (mut difference, mut sum) = (0.0, 0.0);
        for (a, b) in a.iter().zip(&b) {
            difference += f64::from(a[1] - b[1]).powi(2);
            sum += f64::from(a[1]).powi(2);
        }
        (difference / sum).sqrt()
    };
    let (few, many) = (apart(&mut renderer, 4), apart(&mut renderer, 64));
    println!("4 samples {few:.4} apart, 64 samples {many:.4}");
    assert!(many < 0.4 * few, "{few} {many}");
}
