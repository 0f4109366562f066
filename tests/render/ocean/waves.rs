//! The sea on the device against 64-bit Fourier transforms, and its statistics against the spectrum's integrals.

use glam::{DVec2, Vec3};
use leadr::gpu::Image;
use leadr::render::camera::Camera;
use leadr::render::frame::Layer;
use leadr::render::light::sky::Sky;
use leadr::render::passes::ocean::fields::{Content, OceanFields};
use leadr::render::scene::FrameState;
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::ocean::Ocean;
use leadr::render::surfaces::ocean::waves::{Cascade, PERIOD, foam_weight};
use leadr::scenes::ocean::cascades::divide;
use leadr::scenes::ocean::sea::ocean;
use leadr::scenes::ocean::spectrum::Sea;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::seascape;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// Height, displacement, gradient, and derivatives of the displacement at every sample, by two-dimensional inverse transforms.
struct Truth {
    height: Vec<f64>,
    moved: [Vec<f64>; 2],
    gradient: [Vec<f64>; 2],
    jacobian: [Vec<f64>; 3],
}

/// Real parts of a two-dimensional inverse transform of `n` × `n` values, without normalisation.
pub fn inverse(field: &mut [Complex64], n: usize) -> Vec<f64> {
    let fft = FftPlanner::new().plan_fft_inverse(n);
    for _ in 0..2 {
        field.chunks_mut(n).for_each(|row| fft.process(row));
        for j in 0..n {
            for i in 0..j {
                field.swap(j * n + i, i * n + j);
            }
        }
    }
    field.iter().map(|c| c.re).collect()
}

fn truth(cascade: &Cascade, time: f64) -> Truth {
    let n = cascade.resolution as usize;
    let at = |i: usize, j: usize| cascade.waves[(j % n) * n + i % n].map(f64::from);
    let spectrum = |factor: &dyn Fn(DVec2, Complex64) -> Complex64| {
        let mut field: Vec<Complex64> = (0..n * n)
            .map(|index| {
                let (i, j) = (index % n, index / n);
                let (w, back) = (at(i, j), at(n - i, n - j));
                let phase = |cycles: f64| Complex64::cis(TAU * (cycles * time / PERIOD).fract());
                let h = Complex64::new(w[0], w[1]) * phase(w[2]).conj()
                    + Complex64::new(back[0], -back[1]) * phase(back[2]);
                let k = cascade.wave_vector(i as u32, j as u32);
                if k.length() > 0.0 { factor(k, h) } else { Complex64::ZERO }
            })
            .collect();
        inverse(&mut field, n)
    };
    let i = Complex64::I;
    Truth {
        height: spectrum(&|_, h| h),
        moved: [spectrum(&|k, h| i * k.x / k.length() * h), spectrum(&|k, h| i * k.y / k.length() * h)],
        gradient: [spectrum(&|k, h| i * k.x * h), spectrum(&|k, h| i * k.y * h)],
        jacobian: [
            spectrum(&|k, h| -k.x * k.x / k.length() * h),
            spectrum(&|k, h| -k.y * k.y / k.length() * h),
            spectrum(&|k, h| -k.x * k.y / k.length() * h),
        ],
    }
}

fn read(image: &Image, mip: u32, layer: u32) -> Vec<[f64; 4]> {
    let texels: Vec<[f32; 4]> = image.read(mip, layer).unwrap();
    texels.into_iter().map(|t| t.map(f64::from)).collect()
}

/// Expected values of the twelve channels of the finest maps.
fn channels(truth: &Truth, index: usize, choppiness: f64, size: f64) -> [[f64; 4]; 3] {
    let [xx, yy, xy] = [0, 1, 2].map(|c| choppiness * truth.jacobian[c][index]);
    let (jxx, jyy) = (1.0 + xx, 1.0 + yy);
    let area = jxx * jyy - xy * xy;
    let held = area.max(0.1);
    let (gx, gy) = (truth.gradient[0][index], truth.gradient[1][index]);
    let (fx, fy) = (jyy * gx - xy * gy, jxx * gy - xy * gx);
    let stretch = 1.0 + foam_weight(size) * (xx + yy);
    [
        [choppiness * truth.moved[0][index], choppiness * truth.moved[1][index], truth.height[index], area],
        [fx, fy, fx * fx / held, fy * fy / held],
        [fx * fy / held, held, stretch, stretch * stretch],
    ]
}

#[test]
fn the_transforms_match_64_bit_ones() {
    let Some(gpu) = test_gpu() else { return };
    let sea = Sea { wind_speed: 11.0, wind_direction: 0.9, ..Sea::default() };
    for resolution in [16, 32, 64, 256] {
        let cascades = divide(&sea, resolution, 7).cascades;
        let fields = OceanFields::new(&gpu, &cascades, Content::Moments).unwrap();
        for (time, choppiness) in [(0.0, 1.0f32), (1e6 + 0.375, 0.7)] {
            gpu.submit("ocean", |cmd| fields.record(cmd, time, choppiness)).unwrap();
            let mut worst = 0.0f64;
            for (layer, cascade) in cascades.iter().enumerate() {
                let truth = truth(cascade, time);
                let maps = [&fields.displacement, &fields.slopes, &fields.joint].map(|m| read(m, 0, layer as u32));
                for (map, texels) in maps.iter().enumerate() {
                    for channel in 0..4 {
                        let expected: Vec<f64> = (0..truth.height.len())
                            .map(|i| channels(&truth, i, f64::from(choppiness), cascade.size)[map][channel])
                            .collect();
                        let scale = expected.iter().fold(1e-9f64, |a, v| a.max(v.abs()));
                        let error =
                            expected.iter().zip(texels).map(|(e, m)| (e - m[channel]).abs()).fold(0.0, f64::max);
                        worst = worst.max(error / scale);
                    }
                }
            }
            println!("{resolution}: {worst:.1e} of the largest value");
            assert!(worst < 3e-5, "{resolution}² at {time} s: {worst:.2e}");
        }
    }
}

#[test]
fn wrong_transform_is_detected() {
    // The comparison above must fail for a sea that runs backwards.
    let sea = Sea::default();
    let cascade = divide(&sea, 32, 7).cascades.remove(0);
    let (forward, back) = (truth(&cascade, 1.5), truth(&cascade, -1.5));
    let scale = forward.height.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    let difference = forward.height.iter().zip(&back.height).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference > 0.1 * scale);
}

#[test]
fn the_variances_are_the_spectrums_and_the_mips_keep_the_means() {
    let Some(gpu) = test_gpu() else { return };
    let sea = Sea { wind_speed: 9.0, wind_direction: 0.4, ..Sea::default() };
    let divided = divide(&sea, 128, 3);
    let fields = OceanFields::new(&gpu, &divided.cascades, Content::Moments).unwrap();
    // Without choppiness the slope moments equal the spectrum's; averaging over several times suppresses interference.
    let times = [3.0, 77.0, 301.0];
    let (mut height, mut slopes) = (0.0, [0.0; 3]);
    for time in times {
        gpu.submit("ocean", |cmd| fields.record(cmd, time, 0.0)).unwrap();
        let last = fields.slopes.desc().mips - 1;
        for layer in 0..fields.slopes.desc().layers {
            let squares: f64 = read(&fields.displacement, 0, layer).iter().map(|t| t[2] * t[2]).sum();
            height += squares / (128.0 * 128.0) / times.len() as f64;
            let (s, j) = (read(&fields.slopes, last, layer)[0], read(&fields.joint, last, layer)[0]);
            assert!(s[0].abs() < 1e-4 && s[1].abs() < 1e-4, "mean slope {s:?}");
            assert!((j[1] - 1.0).abs() < 1e-5 && (j[2] - 1.0).abs() < 1e-5);
            for (sum, v) in slopes.iter_mut().zip([s[2], s[3], j[0]]) {
                *sum += v / times.len() as f64;
            }
            let mean: f64 = read(&fields.slopes, 0, layer).iter().map(|t| t[2]).sum::<f64>() / (128.0 * 128.0);
            assert!((mean / s[2] - 1.0).abs() < 1e-5, "mips lose the mean: {mean} {}", s[2]);
        }
    }
    let exact = sea.moments(0.0, divided.cut);
    println!("height {:.4}, slopes {slopes:?} of {:?}", height / exact.height, exact.slopes);
    assert!((height / exact.height - 1.0).abs() < 0.04, "{height} {exact:?}");
    for i in 0..3 {
        assert!((slopes[i] - exact.slopes[i]).abs() < 0.03 * exact.slopes[0], "{i}: {slopes:?} {exact:?}");
    }
}

#[test]
fn impossible_seas_are_explained() {
    let Some(gpu) = test_gpu() else { return };
    let cascade = |resolution| Cascade::new(10.0, 0.0, resolution, [0.0, 1.0], 1.0, 0, |_, _| 0.0, f64::sqrt);
    for (cascades, word) in
        [(vec![], "at least one"), (vec![cascade(24)], "power of two"), (vec![cascade(16), cascade(32)], "differ")]
    {
        let fault = OceanFields::new(&gpu, &cascades, Content::Moments).err().expect("refused").to_string();
        assert!(fault.contains(word), "{fault}");
    }
}

/// Area-weighted mean slope and second moments of one surface sample.
#[derive(Clone, Copy, Default)]
struct Moments {
    area: f64,
    first: [f64; 2],
    second: [f64; 3],
}

impl Moments {
    fn add(&mut self, jacobian: [f64; 3], gradient: [f64; 2]) {
        let [xx, yy, xy] = jacobian;
        let (jxx, jyy) = (1.0 + xx, 1.0 + yy);
        let area = (jxx * jyy - xy * xy).max(0.1);
        let flux = [jyy * gradient[0] - xy * gradient[1], jxx * gradient[1] - xy * gradient[0]];
        self.area += area;
        self.first[0] += flux[0];
        self.first[1] += flux[1];
        self.second[0] += flux[0] * flux[0] / area;
        self.second[1] += flux[1] * flux[1] / area;
        self.second[2] += flux[0] * flux[1] / area;
    }

    fn covariance(&self) -> [f64; 3] {
        let [x, y] = self.first.map(|v| v / self.area);
        let [xx, yy, xy] = self.second.map(|v| v / self.area);
        [xx - x * x, yy - y * y, xy - x * y]
    }
}

#[test]
fn the_moment_sum_over_cascades_is_that_of_the_whole_choppy_sea() {
    // Cascades are independent and homogeneous, so a random sample of each is a random sample of the sea.
    for wind_speed in [5.0, 9.0, 14.0] {
        let sea = Sea { wind_speed, wind_direction: 0.3, ..Sea::default() };
        let cascades = divide(&sea, 64, 5).cascades;
        let fields: Vec<Truth> = cascades.iter().map(|c| truth(c, 40.0)).collect();
        let mut whole = Moments::default();
        let mut alone = vec![Moments::default(); fields.len()];
        let mut state = 7u64;
        for _ in 0..400_000 {
            let (mut jacobian, mut gradient) = ([0.0; 3], [0.0; 2]);
            for (field, moments) in fields.iter().zip(&mut alone) {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let i = (state >> 33) as usize % field.height.len();
                let j = [0, 1, 2].map(|c| field.jacobian[c][i]);
                let g = [field.gradient[0][i], field.gradient[1][i]];
                moments.add(j, g);
                (0..3).for_each(|c| jacobian[c] += j[c]);
                (0..2).for_each(|c| gradient[c] += g[c]);
            }
            whole.add(jacobian, gradient);
        }
        let exact = whole.covariance();
        let sum = alone.iter().fold([0.0; 3], |sum, m| std::array::from_fn(|i| sum[i] + m.covariance()[i]));
        let linear: [f64; 3] = fields.iter().fold([0.0; 3], |sum, f| {
            let n = f.height.len() as f64;
            let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / n;
            let [x, y] = &f.gradient;
            [sum[0] + mean(x, x), sum[1] + mean(y, y), sum[2] + mean(x, y)]
        });
        println!("{wind_speed} m/s: {exact:.5?}, sum of the cascades {sum:.5?}, without choppiness {linear:.5?}");
        for i in 0..3 {
            assert!((sum[i] - exact[i]).abs() < 0.015 * exact[0], "{i}: {sum:?} {exact:?}");
        }
    }
}

/// The sea seen from `height`, looking `down` (radians below the horizon).
fn view(height: f32, down: f32) -> FrameState {
    let eye = Vec3::Z * height;
    let camera = Camera::looking_at(eye, eye + Vec3::new(down.cos(), 0.0, -down.sin()) * height, 40.0);
    FrameState { time: 5.0, ..FrameState::new(camera, Vec::new()).under(&Sky::default()) }
}

#[test]
fn far_pixels_match_spectrum_and_surface_is_closed() {
    let Some(gpu) = test_gpu() else { return };
    let sea = Sea { wind_speed: 9.0, wind_direction: 0.4, ..Sea::default() };
    let mut renderer = seascape(&gpu, Ocean { choppiness: 0.0, ..ocean(&sea, 128, 2) });
    let size = (96, 64);
    let settings = RenderSettings { size, ..RenderSettings::default() };
    let all = sea.moments(0.0, f64::INFINITY).slopes;
    for (height, down) in [(20.0f32, 0.9f32), (300.0, 0.7), (4000.0, 0.9)] {
        let output = renderer.render(&view(height, down), &settings).unwrap();
        assert!(output.color.iter().all(|c| c[3] == 1.0 && c[..3].iter().all(|v| v.is_finite() && *v >= 0.0)));
        let (m, s) = (renderer.layer(Layer::MeanSlope).unwrap(), renderer.layer(Layer::Covariance).unwrap());
        let (mut sum, pixels) = ([0.0f64; 3], m.len() as f64);
        for (m, s) in m.iter().zip(&s) {
            let (x, y) = (f64::from(m[0]), f64::from(m[1]));
            for (sum, v) in
                sum.iter_mut().zip([x * x, y * y, x * y].iter().zip(&s[..3]).map(|(a, b)| a + f64::from(*b)))
            {
                *sum += v / pixels;
            }
        }
        println!("{height} m: {sum:.5?} of {all:.5?}");
        // From 20 m a picture shows only a few of the long waves.
        let tolerance = if height < 100.0 { 0.25 } else { 0.015 };
        for i in 0..3 {
            assert!((sum[i] - all[i]).abs() < tolerance * all[0], "{height} m: {sum:?} {all:?}");
        }
    }
    // Looking at the horizon: water covers everything below it.
    let output = renderer.render(&view(2.5, 0.0), &settings).unwrap();
    let row = |y: u32| &output.color[(y * size.0) as usize..((y + 1) * size.0) as usize];
    assert!((40..64).all(|y| row(y).iter().all(|c| c[3] == 1.0)), "holes in the sea");
    assert!((0..20).all(|y| row(y).iter().all(|c| c[3] == 0.0)), "water in the sky");
}
