//! Random lights from the environment. Each sample of the reference is lit from a few random directions of the environment.
//!
//! A shadow map serves only one light, but the light of a sky is the mean of many random lights. The draws are importance-sampled
//! by the luminance of the texels and the cosines at the visible surfaces, so every draw contributes about the same amount of
//! light.

use glam::{Vec2, Vec3};

use crate::light::environment::Environment;
use leadr_gpu::Result;
use leadr_reflectance::color::luminance;

/// The largest face size, in texels, from which lights are drawn. A texel covers 0.35°.
const FACE_SIZE: u32 = 256;
/// The fraction of the draws that is uniform over the sphere. Uniform draws also reach colours without luminance.
const EVEN: f64 = 0.05;
/// The number of bands of equal area on the sphere. With bands, uniform points in a square become uniform points on the sphere.
const BANDS: usize = 48;

/// A light that was drawn at random from an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnLight {
    /// The unit direction towards the light, in world space.
    pub direction: Vec3,
    /// The irradiance on a plane that faces the light, divided by the probability of the draw. The mean over all draws is the
    /// irradiance of the environment.
    pub irradiance: Vec3,
    /// The density of the draw per solid angle.
    pub density: f32,
}

/// The texels of an environment from which lights are drawn.
#[derive(Clone, Debug)]
pub struct EnvironmentLights {
    size: u32,
    texels: Vec<Vec3>,
    /// The indices of the texels, sorted into [`BANDS`] bands by the height of their centres, and within a band by azimuth.
    order: Vec<u32>,
    /// The cumulative probability of the texels, in the order of `order`.
    cumulative: Vec<f64>,
    /// The end index of each band in `order`.
    ends: Vec<usize>,
}

impl EnvironmentLights {
    /// Reads an environment back from the device, which must be idle. Returns `None` if the environment is black. `receiving`
    /// weights a world direction by how much light from this direction the visible surfaces receive. The weight is above 0, in any
    /// unit.
    pub fn read(environment: &Environment, receiving: impl Fn(Vec3) -> f64) -> Result<Option<Self>> {
        let mip = (environment.face_size() / FACE_SIZE).max(1).ilog2().min(environment.levels() - 1);
        let mut texels = Vec::new();
        for face in 0..6 {
            let face: Vec<[f32; 4]> = environment.image().read(mip, face)?;
            texels.extend(face.into_iter().map(|[r, g, b, _]| Vec3::new(r, g, b)));
        }
        let size = environment.face_size() >> mip;
        Ok(Self::new(size, texels, receiving))
    }

    /// Takes the faces +x, −x, +y, −y, +z, −z of an environment, with `size`² texels of linear Rec. 709 radiance each. Returns
    /// `None` if all texels are black. For `receiving`, see [`read`](Self::read).
    ///
    /// # Panics
    /// Panics if the number of texels is not `6 size²`.
    pub fn new(size: u32, texels: Vec<Vec3>, receiving: impl Fn(Vec3) -> f64) -> Option<Self> {
        assert_eq!(texels.len(), 6 * (size * size) as usize, "texels of six faces");
        let centre = |i: u32| {
            let (face, texel) = (i / (size * size), i % (size * size));
            let position = Vec2::new((texel % size) as f32, (texel / size) as f32) + 0.5;
            face_direction(face as usize, position * (2.0 / size as f32) - 1.0).normalize()
        };
        let luminance = |c: Vec3| luminance(c.max(Vec3::ZERO).as_dvec3());
        // The solid angle of each texel is weighted by how much of its light the visible surfaces receive.
        let angles: Vec<f64> =
            (0..texels.len()).map(|i| solid_angle(size, i) * receiving(centre(i as u32)).max(0.0)).collect();
        let total: f64 = texels.iter().zip(&angles).map(|(&c, a)| luminance(c) * a).sum();
        if total <= 0.0 || !total.is_finite() {
            return None;
        }
        let whole: f64 = angles.iter().sum();
        let band = |d: Vec3| (((d.z + 1.0) * 0.5 * BANDS as f32) as usize).min(BANDS - 1);
        let mut keyed: Vec<(usize, f32, u32)> =
            (0..texels.len() as u32).map(|i| (band(centre(i)), centre(i).y.atan2(centre(i).x), i)).collect();
        keyed.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let ends = (0..BANDS).map(|b| keyed.partition_point(|k| k.0 <= b)).collect();
        let order: Vec<u32> = keyed.into_iter().map(|k| k.2).collect();
        let mut sum = 0.0;
        let cumulative = order
            .iter()
            .map(|&i| {
                let (color, angle) = (texels[i as usize], angles[i as usize]);
                sum += (1.0 - EVEN) * luminance(color) * angle / total + EVEN * angle / whole;
                sum
            })
            .collect();
        Some(Self { size, texels, order, cumulative, ends })
    }

    /// Returns the light for a point of the unit square. The first coordinate selects the band, and the second selects the texel.
    /// The remainders of both are the position in the texel.
    pub fn draw(&self, u: [f64; 2]) -> DrawnLight {
        let before = |i: usize| if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let last = before(self.order.len());
        let at = u[0] * last;
        let band = self.ends.partition_point(|&end| before(end) <= at).min(self.ends.len() - 1);
        let (first, end) = (if band == 0 { 0 } else { self.ends[band - 1] }, self.ends[band]);
        let down = (at - before(first)) / (before(end) - before(first));
        let at = before(first) + u[1] * (before(end) - before(first));
        let index = (first + self.cumulative[first..end].partition_point(|&c| c <= at)).min(end - 1);
        let probability = (self.cumulative[index] - before(index)) / last;
        let across = (at - before(index)) / (self.cumulative[index] - before(index));
        let within = Vec2::new(across as f32, down as f32).clamp(Vec2::ZERO, Vec2::ONE);
        let texel = self.order[index];
        let (face, on_face) = (texel / (self.size * self.size), texel % (self.size * self.size));
        let corner = Vec2::new((on_face % self.size) as f32, (on_face / self.size) as f32);
        let point = face_direction(face as usize, (corner + within) * (2.0 / self.size as f32) - 1.0);
        // The position is uniform on the face, so the solid angle is that of the point, not of the texel's centre.
        let area = 4.0 / f64::from(self.size * self.size);
        let angle = area / f64::from(point.length()).powi(3);
        DrawnLight {
            direction: point.normalize(),
            irradiance: self.texels[texel as usize] * (angle / probability) as f32,
            density: (probability / angle) as f32,
        }
    }

    /// Returns the radiance and the density at the texels of a cube of [`size`](Self::size). The density is per area on a face with
    /// side length 2. Multiply it by the cubed distance to the face along the direction to get the density per solid angle.
    pub fn table(&self) -> Vec<[f32; 4]> {
        let area = 4.0 / f64::from(self.size * self.size);
        let last = self.cumulative.last().copied().unwrap_or(1.0);
        let mut table: Vec<[f32; 4]> = self.texels.iter().map(|radiance| radiance.extend(0.0).to_array()).collect();
        let mut before = 0.0;
        for (&texel, &sum) in self.order.iter().zip(&self.cumulative) {
            table[texel as usize][3] = ((sum - before) / (last * area)) as f32;
            before = sum;
        }
        table
    }

    /// Returns the number of texels along a face.
    pub fn size(&self) -> u32 {
        self.size
    }
}

/// Returns the solid angle of a texel, approximated at its centre.
fn solid_angle(size: u32, index: usize) -> f64 {
    let texel = index % (size * size) as usize;
    let at = |i: usize| (2.0 * i as f64 + 1.0) / f64::from(size) - 1.0;
    let (s, t) = (at(texel % size as usize), at(texel / size as usize));
    4.0 / f64::from(size * size) / (1.0 + s * s + t * t).powf(1.5)
}

/// Returns the point on a cube's face that Vulkan's cube lookup maps to `st`, where `st` is in [−1, 1]².
fn face_direction(face: usize, st: Vec2) -> Vec3 {
    let Vec2 { x: s, y: t } = st;
    match face {
        0 => Vec3::new(1.0, -t, -s),
        1 => Vec3::new(-1.0, -t, s),
        2 => Vec3::new(s, 1.0, t),
        3 => Vec3::new(s, -1.0, -t),
        4 => Vec3::new(s, -t, 1.0),
        _ => Vec3::new(-s, -t, -1.0),
    }
}

/// Returns the point of the unit square that selects the light of sample `index`. The points are the first two dimensions of the
/// Sobol sequence, and the seed scrambles their digits. If the unit square is divided into `2ⁿ` equal boxes of any shape, each box
/// contains one of the first `2ⁿ` points.
///
/// The point is independent of the pixel offset ([`jitter`](crate::sampling::jitter)), so the samples of a pixel fill all four
/// dimensions evenly.
pub fn light_point(index: u32, seed: u64) -> [f64; 2] {
    let mut state = seed.wrapping_mul(0xd605_1ccb_05a6_2b0f) ^ 0x2545_f491_4f6c_dd1d;
    let mut scramble = || {
        state ^= state >> 29;
        state = state.wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 32;
        (state >> 16) as u32
    };
    let mut second = 0;
    let mut direction = 1u32 << 31;
    for bit in 0..32 {
        if index >> bit & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
    }
    [index.reverse_bits() ^ scramble(), second ^ scramble()].map(|digits| (f64::from(digits) + 0.5) / 4_294_967_296.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(size: u32, radiance: impl Fn(Vec3) -> Vec3) -> EnvironmentLights {
        let n = (size * size) as usize;
        let at = |i: usize| (2 * i + 1) as f32 / size as f32 - 1.0;
        let texel = |i: usize| {
            face_direction(i / n, Vec2::new(at(i % n % size as usize), at(i % n / size as usize))).normalize()
        };
        EnvironmentLights::new(size, (0..6 * n).map(|i| radiance(texel(i))).collect(), |_| 1.0).unwrap()
    }

    #[test]
    fn the_mean_of_the_draws_is_the_environment() {
        let lights = sky(32, |d| Vec3::new(1.0 + 0.5 * d.x, 0.8 + 0.3 * d.z, 0.2 + 3.0 * d.y.max(0.0).powi(8)));
        let normal = Vec3::new(0.3, -0.5, 0.8).normalize();
        let (mut irradiance, mut even) = (Vec3::ZERO, Vec3::ZERO);
        let n = 4096;
        for index in 0..n {
            let light = lights.draw(light_point(index, 3));
            assert!((light.direction.length() - 1.0).abs() < 1e-5);
            if index == 15 {
                let few = irradiance * (n as f32 / 15.0) / std::f32::consts::PI;
                assert!((few.x - 1.0).abs() < 0.25, "{few} after 15 draws");
            }
            irradiance += light.irradiance * light.direction.dot(normal).max(0.0) / n as f32;
            even += light.irradiance / n as f32;
        }
        // The red irradiance is ∫ (1 + d·x/2) max(0, d·n) = π + π n.x/3. The blue lobe faces away.
        let pi = std::f32::consts::PI;
        let want = Vec3::new(pi * (1.0 + normal.x / 3.0), pi * (0.8 + 0.2 * normal.z), irradiance.z);
        assert!((irradiance / want - 1.0).abs().max_element() < 0.01, "{irradiance} {want}");
        assert!((even.truncate() / (4.0 * pi * Vec2::new(1.0, 0.8)) - 1.0).abs().max_element() < 0.01, "{even}");
    }

    #[test]
    fn bright_texels_are_sampled_more_often() {
        let sun = Vec3::new(0.2, 0.6, 0.7).normalize();
        let lights = sky(64, |d| if d.dot(sun) > 0.999 { Vec3::splat(1e4) } else { Vec3::new(0.0, 0.0, 1e-6) });
        let near = (0..1000).filter(|&i| lights.draw(light_point(i, 0)).direction.dot(sun) > 0.995).count();
        assert!((930..=970).contains(&near), "{near}");
        assert!(EnvironmentLights::new(1, vec![Vec3::ZERO; 6], |_| 1.0).is_none());
    }

    #[test]
    fn receiver_normal_changes_samples_not_their_mean() {
        let (size, normal) = (16u32, Vec3::new(0.6, 0.0, 0.8));
        let n = (size * size) as usize;
        let facing = |d: Vec3| 0.05 + f64::from(d.dot(normal).max(0.0));
        let lights = EnvironmentLights::new(size, vec![Vec3::splat(2.0); 6 * n], facing).unwrap();
        let (mut irradiance, mut behind, count) = (0.0, 0, 2048);
        for index in 0..count {
            let light = lights.draw(light_point(index, 1));
            irradiance += f64::from(light.irradiance.x * light.direction.dot(normal).max(0.0)) / f64::from(count);
            behind += usize::from(light.direction.dot(normal) < -0.1);
        }
        assert!((irradiance / (2.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{irradiance}");
        assert!(behind < 400, "{behind} of {count} draws light nothing; evenly drawn, 922 would");
    }

    #[test]
    fn densities_are_those_of_the_draws_and_integrate_to_one() {
        let lights = sky(16, |d| Vec3::new(0.1, 1.0 + d.x, 5.0 * d.z.max(0.0).powi(9)));
        let (n, table) = (16 * 16, lights.table());
        let sum: f64 = table.iter().map(|t| f64::from(t[3]) * 4.0 / f64::from(n)).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        for index in 0..500 {
            let light = lights.draw(light_point(index, 9));
            let d = light.direction;
            // The direction is nearest to the axis of its face. An exhaustive search finds its texel.
            let at = |i: usize| (2 * i + 1) as f32 / 16.0 - 1.0;
            let nearest = (0..6 * n as usize).max_by(|&a, &b| {
                let centre = |i: usize| {
                    let point = face_direction(i / n as usize, Vec2::new(at(i % 16), at(i % n as usize / 16)));
                    let scale = d.abs().max_element();
                    // This is infinity for faces that do not contain the direction.
                    let on_face = (d / scale).dot(face_direction(i / n as usize, Vec2::ZERO)) > 0.9999;
                    if on_face { -(d / scale - point).abs().max_element() } else { f32::NEG_INFINITY }
                };
                centre(a).total_cmp(&centre(b))
            });
            let [r, g, b, density] = table[nearest.unwrap()];
            let want = density / d.abs().max_element().powi(3);
            assert!((light.density / want - 1.0).abs() < 1e-3, "{light:?}: {want}");
            assert!((light.irradiance * light.density - Vec3::new(r, g, b)).abs().max_element() < 1e-4 * (r + g + b));
        }
    }

    #[test]
    fn draws_fill_the_square_beside_the_offsets_in_the_pixel() {
        // Each axis is halved, which gives 16 boxes that must contain about equal numbers of points.
        let mut boxes = [0; 16];
        for i in 0..1024 {
            let (p, q) = (crate::sampling::jitter(i, 1024, 5), light_point(i, 5));
            let bits = [p.x > 0.0, p.y > 0.0, q[0] > 0.5, q[1] > 0.5];
            boxes[bits.iter().fold(0, |a, &b| 2 * a + usize::from(b))] += 1;
        }
        // Each box should contain about 64 points. With random numbers, one box would deviate by about 16.
        assert!(boxes.iter().all(|&n| (53..=76).contains(&n)), "{boxes:?}");
    }
}
