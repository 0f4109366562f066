//! Computes the ambient visibility of relief from horizons (Jimenez et al. 2016, "Practical Realtime Strategies for Accurate
//! Indirect Occlusion"), for a view from straight above.
//!
//! Every direction above a height field lies in one half of a vertical slice. A direction is free if it is above the horizon
//! of its half slice. If the horizon is at angle `h` from z, the free directions of half a slice sum to
//!
//! `∫ ω sin θ dθ = ½ (h − sin h cos h) along the slice, ½ sin² h along z`.
//!
//! The dot product of the sum with a normal is the inner integral of GTAO. The sum over slices, divided by π, is the
//! visibility vector `b`, which determines all results ([`Cone`](leadr_reflectance::masking::occlusion::Cone)). Apart from
//! interpolation between texels ([`sweep`](super::sweep)), the number of slices is the only approximation.
//!
//! Directions below the horizontal are blocked, because repeating relief and the ground around a non-repeating map are
//! unlimited. If occluders count only up to a distance ([`reach`](super::reach)), those directions can be free.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::reach::Reach;
use super::slopes::{Difference, slopes_of_heights};
use super::spectral::transpose;
use super::sweep::{Field, Horizons, NEAR};
use crate::horizon::{Heights, Sampled};
use crate::limits::zeroed;
use crate::{HeightMap, MapFault, Wrap};

/// The default number of slices, which keeps errors below 0.01 on scanned materials. Four times as many slices reduce the
/// errors by a tenth to a third.
pub const SLICES: u32 = 8;

/// The hemisphere for which visibility is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum About {
    /// Directions in front of the texel's own normal. The visible fraction is an occlusion map for use with the matching
    /// normal map, as in glTF.
    #[default]
    Surface,
    /// All free directions, weighted by their cosine to the mesh normal. Use occlusion by the mesh normal where the normal
    /// map is not used or is filtered away.
    Flat,
}

/// The rules by which [`visibility`] is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion {
    /// How texels outside the map are addressed.
    pub wrap: Wrap,
    /// The hemisphere.
    pub about: About,
    /// The number of slices per texel, at least 2.
    pub slices: u32,
    /// The distance in texture widths up to which occluders count, as the length of a ray. The default is infinite.
    pub distance: f32,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { wrap: Wrap::Repeat, about: About::Surface, slices: SLICES, distance: f32::INFINITY }
    }
}

/// The visibility vectors of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityMap {
    /// The width in texels.
    pub width: u32,
    /// The height in texels.
    pub height: u32,
    /// The hemisphere of the vectors.
    pub about: About,
    /// The components `b.x`, `b.y` and `b.z` of the vectors, each as a row-major image.
    pub vectors: [Vec<f32>; 3],
    /// The occlusion map: the visible fraction of the sky, weighted by the cosine to the normal. The value 1 means no
    /// occlusion.
    pub visibility: Vec<f32>,
}

impl VisibilityMap {
    /// Returns the visibility vector of a texel. Panics outside the map.
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        assert!(x < self.width, "column {x} of a map {} wide", self.width);
        let texel = y as usize * self.width as usize + x as usize;
        [0, 1, 2].map(|i| self.vectors[i][texel])
    }
}

/// The sums over all slices of the components along columns, along rows, and along z.
type Planes = [Vec<f32>; 3];

/// Computes the visibility of heights. `scale` converts heights to texture widths. The computation needs about 44 bytes per
/// texel. `progress` receives the completed fraction, from 0 to 1.
///
/// # Errors
/// Fails if memory runs out.
pub fn visibility(
    heights: &HeightMap,
    scale: f32,
    how: &Occlusion,
    progress: &dyn Fn(f32),
) -> Result<VisibilityMap, MapFault> {
    let Occlusion { wrap, about, slices, distance } = *how;
    let (width, height) = (heights.width as usize, heights.height as usize);
    let slices = slices.clamp(2, 1024);
    let azimuths: Vec<f64> = (0..slices).map(|k| PI * (f64::from(k) + 0.5) / f64::from(slices)).collect();
    // Slices closer to the direction of columns are processed on the transposed map.
    let (along, down): (Vec<f64>, Vec<f64>) = azimuths.into_iter().partition(|a| a.cos().abs() >= a.sin().abs());
    let sweep = Sweep { about, slices, reach: (distance < f32::INFINITY).then_some(distance * width as f32) };
    let done = std::cell::Cell::new(0);
    let step = || {
        done.set(done.get() + 1);
        progress(done.get() as f32 / (slices + 1) as f32);
    };
    let (range, middle) = (1e6, heights.mean());
    // Heights are measured in texels from the middle height, for precision in 32 bits. The clamp allows slopes that occlude
    // everything.
    let in_texels = |h: &f32| (f64::from(h - middle) * f64::from(scale) * width as f64).clamp(-range, range) as f32;
    let texels: Vec<f32> = heights.texels.par_iter().map(in_texels).collect();
    let plane = || zeroed(width * height);
    let mut planes: Planes = [plane()?, plane()?, plane()?];
    let mut transposed = plane()?;
    if !down.is_empty() {
        transpose(&texels, width, &mut transposed);
        let mut sums: Planes = [plane()?, plane()?, plane()?];
        let field = Field::new(height, width, transposed, wrap);
        let tangents: Vec<f64> = down.iter().map(|a| a.cos() / a.sin()).collect();
        sweep.accumulate(&field, &tangents, &mut sums, &step);
        transposed = field.texels;
        for (plane, sum) in planes.iter_mut().zip([1, 0, 2]) {
            transpose(&sums[sum], height, plane);
        }
    }
    drop(transposed);
    let field = Field::new(width, height, texels, wrap);
    sweep.accumulate(&field, &along.iter().map(|a| a.tan()).collect::<Vec<_>>(), &mut planes, &step);
    drop(field);
    let mut visibility = zeroed::<f32>(width * height)?;
    match about {
        About::Flat => visibility.par_iter_mut().zip(&planes[2]).for_each(|(v, z)| *v = z.clamp(0.0, 1.0)),
        About::Surface => {
            let slopes = slopes_of_heights(heights, scale, wrap, Difference::Triangles);
            let [x, y, z] = &planes;
            let texels = slopes.texels().par_iter().zip(x).zip(y).zip(z).zip(&mut visibility);
            texels.for_each(|((((slope, x), y), z), v)| {
                let length = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
                *v = ((z - slope[0] * x - slope[1] * y) / length).clamp(0.0, 1.0);
            });
        }
    }
    progress(1.0);
    Ok(VisibilityMap { width: heights.width, height: heights.height, about, vectors: planes, visibility })
}

/// The rules of all slices.
struct Sweep {
    about: About,
    slices: u32,
    /// The distance in texels up to which occluders count, if it is limited.
    reach: Option<f32>,
}

impl Sweep {
    /// Adds the slices whose lines rise by `tangents` rows per column.
    fn accumulate(&self, field: &Field, tangents: &[f64], planes: &mut Planes, step: &dyn Fn()) {
        let width = field.width;
        let heights = Heights::new(width, field.height, &field.texels, field.wrap);
        for &tangent in tangents {
            let slice = Slice::new(tangent, self);
            let horizons = field.horizons(tangent, slice.reach.as_ref());
            let [x, y, z] = planes;
            let rows = x.par_chunks_mut(width).zip(y.par_chunks_mut(width)).zip(z.par_chunks_mut(width));
            rows.enumerate().with_min_len(16).for_each_init(
                || Row::new(width),
                |row, (k, ((x, y), z))| {
                    row.measure(&heights, &horizons, self.about, &slice, k);
                    row.add(&slice, [x, y, z]);
                },
            );
            step();
        }
    }
}

struct Slice {
    tangent: f32,
    /// The inverse of the distance between adjacent columns along the slice.
    per_column: f32,
    /// The slice direction, multiplied by the slice's fraction of the sum.
    along: [f32; 2],
    share: f32,
    reach: Option<Reach>,
}

impl Slice {
    fn new(tangent: f64, sweep: &Sweep) -> Self {
        let per_column = 1.0 / (1.0 + tangent * tangent).sqrt();
        // The weight is half of the slice's angle π / slices, divided by π.
        let share = 0.5 / f64::from(sweep.slices);
        let along = [share * per_column, share * tangent * per_column].map(|v| v as f32);
        let reach = sweep.reach.map(|distance| Reach::new(distance, tangent));
        Self { tangent: tangent as f32, per_column: per_column as f32, along, share: share as f32, reach }
    }
}

struct Row {
    /// The rise per column of the horizon ahead and of the horizon behind.
    rises: [Vec<f32>; 2],
    plane: Vec<f32>,
    there: Sampled,
}

impl Row {
    fn new(width: usize) -> Self {
        let zeros = || vec![0.0; width];
        Self { rises: [zeros(), zeros()], plane: zeros(), there: Sampled::new(width) }
    }

    fn measure(&mut self, heights: &Heights<'_>, horizons: &Horizons, about: About, slice: &Slice, y: usize) {
        horizons.row(y, &mut self.rises);
        let own = &heights.texels[y * heights.width..][..heights.width];
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            for column in (1..=NEAR).map(|column| column as f32) {
                self.there.fetch(heights, heights.texels, [0, y], [sign * column, sign * column * slice.tangent]);
                let rises = self.rises[side].iter_mut().zip(self.there.values.iter().zip(own));
                match &slice.reach {
                    None => rises.for_each(|(rise, (there, own))| *rise = rise.max((there - own) / column)),
                    Some(reach) => {
                        rises.for_each(|(rise, (there, own))| {
                            *rise = rise.max(reach.clip(column, (there - own) / column));
                        });
                    }
                }
            }
        }
        match about {
            About::Surface => self.tilt(heights, slice.tangent, y),
            About::Flat => self.plane.fill(0.0),
        }
        let [ahead, behind] = &mut self.rises;
        for ((ahead, behind), plane) in ahead.iter_mut().zip(behind).zip(&self.plane) {
            (*ahead, *behind) = (ahead.max(*plane), behind.max(-plane));
        }
    }

    /// Computes the rise per column of the plane of mean slope, with the weights of [`Difference::Triangles`] along both
    /// axes.
    fn tilt(&mut self, heights: &Heights<'_>, tangent: f32, y: usize) {
        let clamped = heights.wrap == Wrap::Clamp;
        let edge = |k: usize, of: usize| if clamped && of > 1 && (k == 0 || k + 1 == of) { 1.0 } else { 0.5 };
        let width = heights.width;
        self.plane.fill(0.0);
        let down = tangent * edge(y, heights.height);
        for (at, weight) in [(-1.0, 0.125), (0.0, 0.75), (1.0, 0.125)] {
            for sign in [-1.0, 1.0] {
                self.there.fetch(heights, heights.texels, [0, y], [sign, at]);
                // All columns except the first and last have the same weights.
                for (plane, there) in self.plane.iter_mut().zip(&self.there.values) {
                    *plane += 0.5 * sign * weight * there;
                }
                if edge(0, width) > 0.5 {
                    for x in [0, width - 1] {
                        self.plane[x] += 0.5 * sign * weight * self.there.values[x];
                    }
                }
                self.there.fetch(heights, heights.texels, [0, y], [at, sign]);
                for (plane, there) in self.plane.iter_mut().zip(&self.there.values) {
                    *plane += down * sign * weight * there;
                }
            }
        }
    }

    fn add(&self, slice: &Slice, [x, y, z]: [&mut [f32]; 3]) {
        let rises = self.rises[0].iter().zip(&self.rises[1]);
        for ((x, y), (z, (ahead, behind))) in x.iter_mut().zip(y).zip(z.iter_mut().zip(rises)) {
            let (ahead, behind) = (half(ahead * slice.per_column), half(behind * slice.per_column));
            let along = ahead[0] - behind[0];
            *x += slice.along[0] * along;
            *y += slice.along[1] * along;
            *z += slice.share * (ahead[1] + behind[1]);
        }
    }
}

/// Returns twice the sum of the free directions of half a slice, as components along the slice and along z. `slope` is the
/// slope of the horizon.
fn half(slope: f32) -> [f32; 2] {
    let square = 1.0 / (1.0 + slope * slope);
    [to_horizon(slope) - slope * square, square]
}

/// Returns the angle from z to a horizon with the given slope, which is the arc cotangent. The error of the polynomial is at
/// most 1e-5.
fn to_horizon(slope: f32) -> f32 {
    let size = slope.abs();
    let flat = size <= 1.0;
    let v = if flat { size } else { 1.0 / size };
    let s = v * v;
    let p = 0.193_543_46 + s * (-0.116_432_87 + s * (0.052_653_32 - 0.011_721_2 * s));
    let angle = v * (0.999_977_26 + s * (-0.332_623_47 + s * p));
    let angle = if flat { std::f32::consts::FRAC_PI_2 - angle } else { angle };
    if slope < 0.0 { std::f32::consts::PI - angle } else { angle }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn map(width: u32, height: u32, f: impl Fn(u32, u32) -> f64) -> HeightMap {
        let texels = (0..width * height).map(|i| f(i % width, i / width) as f32).collect();
        HeightMap::new(width, height, texels).unwrap()
    }

    fn of(map: &HeightMap, wrap: Wrap, about: About, slices: u32) -> VisibilityMap {
        let how = Occlusion { wrap, about, slices, ..Occlusion::default() };
        visibility(map, 1.0 / map.width as f32, &how, &|_| {}).unwrap()
    }

    #[test]
    fn angles_to_horizons() {
        for i in 0..2000 {
            let slope = (f64::from(i) / 100.0 - 10.0).exp2();
            for slope in [slope, -slope] {
                let error = f64::from(to_horizon(slope as f32)) - 1f64.atan2(slope);
                assert!(error.abs() < 2e-5, "{slope}: {error}");
            }
        }
    }

    #[test]
    fn flat_ground_sees_all() {
        for (width, height) in [(16, 16), (1, 7), (7, 1), (1, 1), (13, 6)] {
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                for about in [About::Surface, About::Flat] {
                    let found = of(&map(width, height, |_, _| 7.0), wrap, about, 4);
                    let off = |i: usize, to: f32| found.vectors[i].iter().all(|v| (v - to).abs() < 1e-4);
                    assert!(off(0, 0.0) && off(1, 0.0) && off(2, 1.0) && found.visibility.iter().all(|&v| v > 0.9999));
                }
            }
        }
    }

    #[test]
    fn tilted_plane_visibility_matches_closed_form() {
        // The plane has slope 1 and falls along t. Of the sky about the plane's normal, the cosine-weighted fraction (1 +
        // cos 45°)/2 is above the horizontal.
        let slope = map(65, 65, |_, y| -f64::from(y));
        for (slices, tolerance) in [(16, 3e-3), (64, 1e-3)] {
            let found = of(&slope, Wrap::Clamp, About::Surface, slices);
            let at = 32 * 65 + 32;
            let expected = 0.5 * (1.0 + 0.5f32.sqrt());
            assert!(
                (found.visibility[at] - expected).abs() < tolerance,
                "{slices}: {} {expected}",
                found.visibility[at]
            );
            // The sum of all directions between two planes lies on the bisector of the planes' normals.
            let [x, y, z] = found.at(32, 32);
            assert!(x.abs() < 1e-3 && (y / z - 22.5f32.to_radians().tan()).abs() < 3.0 * tolerance, "{x} {y} {z}");
        }
    }

    #[test]
    fn trench_floor_visibility_matches_closed_form() {
        // A repeating trench along t is 41 texels wide and 20 deep. By the view factor of a slot, the fraction cos² of the
        // half angle is hidden at the trench's middle.
        let trench = |x: u32| if x.abs_diff(64) <= 20 { 0.0 } else { 20.0 };
        // On a non-repeating map the ends of the trench are open.
        for (transposed, wrap, tolerance) in
            [(false, Wrap::Repeat, 5e-3), (true, Wrap::Repeat, 5e-3), (false, Wrap::Clamp, 8e-3)]
        {
            let trench = map(128, 128, |x, y| trench(if transposed { y } else { x }));
            for about in [About::Surface, About::Flat] {
                let found = of(&trench, wrap, about, 64);
                let half_angle = (21.0f32 / 20.0).atan();
                let error = found.visibility[64 * 128 + 64] - half_angle.sin();
                assert!(error.abs() < tolerance, "{transposed} {wrap:?} {about:?}: {error}");
            }
        }
    }

    #[test]
    fn rotating_the_map_rotates_the_vectors() {
        let hills = |x: u32, y: u32| f64::from((x * 7 + y * 13 + x * y) % 17) / 4.0;
        for (wrap, width, height) in [(Wrap::Repeat, 24, 24), (Wrap::Clamp, 24, 24), (Wrap::Clamp, 17, 30)] {
            let (a, b) = (map(width, height, hills), map(height, width, |x, y| hills(y, x)));
            let (a, b) = (of(&a, wrap, About::Surface, 8), of(&b, wrap, About::Surface, 8));
            for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                let ([ax, ay, az], [by, bx, bz]) = (a.at(x, y), b.at(y, x));
                let apart = (ax - bx).abs().max((ay - by).abs()).max((az - bz).abs());
                assert!(apart < 1e-4, "{wrap:?} {x} {y}: {:?} {:?}", a.at(x, y), b.at(y, x));
            }
        }
    }

    /// Rough relief on hills, in texels. It repeats.
    fn rough(x: u32, y: u32) -> f64 {
        let noise = x.wrapping_mul(2_654_435_761).wrapping_add(y.wrapping_mul(2_246_822_519)).rotate_left(13) % 1009;
        f64::from(noise) / 1009.0 + 4.0 * (f64::from(x) * TAU / 48.0).sin() + 3.0 * (f64::from(y) * TAU / 32.0).cos()
    }

    fn within(map: &HeightMap, wrap: Wrap, about: About, distance: f32) -> VisibilityMap {
        let how = Occlusion { wrap, about, distance, ..Occlusion::default() };
        visibility(map, 1.0 / map.width as f32, &how, &|_| {}).unwrap()
    }

    #[test]
    fn occlusion_grows_with_the_distance() {
        let map = map(48, 32, rough);
        for (wrap, about) in
            [(Wrap::Repeat, About::Surface), (Wrap::Repeat, About::Flat), (Wrap::Clamp, About::Surface)]
        {
            let distances = [1e-6, 0.021, 0.05, 0.1, 0.3, 1.0, 4.0, 1e3, f32::INFINITY];
            let maps = distances.map(|distance| within(&map, wrap, about, distance).visibility);
            let mean = |map: &[f32]| map.iter().sum::<f32>() / map.len() as f32;
            for (pair, distance) in maps.windows(2).zip(&distances[1..]) {
                let most = pair[1].iter().zip(&pair[0]).map(|(far, near)| far - near).fold(f32::MIN, f32::max);
                let less = mean(&pair[0]) - mean(&pair[1]);
                println!("{wrap:?} {about:?} {distance}: at most {most:+.2e}, mean {less:.4} less");
                assert!(most < 2e-5, "{wrap:?} {about:?} {distance}: {most}");
            }
            // Nothing is within a distance of less than a texel, except the ground beyond the edges of a map that does not repeat.
            let inside = (1..31).flat_map(|y| (1..47).map(move |x| y * 48 + x));
            let least = inside.map(|texel: usize| maps[0][texel]).fold(1.0, f32::min);
            assert!(least > if about == About::Surface { 0.999 } else { 0.5 }, "{wrap:?} {about:?} {least}");
            assert!(mean(&maps[1]) > mean(&maps[3]) + 0.02 && mean(&maps[3]) > mean(&maps[7]) + 0.02);
            // Rays that end below the horizontal have slopes of at most the range of the heights over the distance.
            for (at, most) in [(6, 0.02), (7, 0.002)] {
                let apart = maps[at].iter().zip(&maps[8]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                println!("{wrap:?} {about:?} distance {}: {apart:.2e} from all", distances[at]);
                assert!(apart < most, "{wrap:?} {about:?} {}: {apart}", distances[at]);
            }
        }
    }

    #[test]
    fn a_slope_is_open_to_rays_that_end_before_the_ground() {
        // Half of the rays below the horizontal are in front of the slope, and end in the air.
        let slope = map(65, 65, |_, y| -f64::from(y));
        for about in [About::Surface, About::Flat] {
            let found = within(&slope, Wrap::Clamp, about, 0.2);
            let at = 32 * 65 + 32;
            // About the mesh normal, the slope hides the same as without a limit.
            let expected = if about == About::Surface { 1.0 } else { 0.5 * (1.0 + 0.5f32.sqrt()) };
            assert!((found.visibility[at] - expected).abs() < 3e-3, "{about:?} {}", found.visibility[at]);
        }
        let [x, y, z] = within(&slope, Wrap::Clamp, About::Surface, 0.2).at(32, 32);
        assert!(x.abs() < 1e-3 && (y - 0.5f32.sqrt()).abs() < 3e-3 && (z - y).abs() < 3e-3, "{x} {y} {z}");
    }

    #[test]
    fn a_wall_fades_out_towards_the_distance() {
        // A wall of 80 texels begins 20 texels from the texel, along t or along s. The part of it within a sphere hides less.
        for (transposed, wrap) in
            [(false, Wrap::Repeat), (true, Wrap::Repeat), (false, Wrap::Clamp), (true, Wrap::Clamp)]
        {
            let wall = |x: u32| if (60..100).contains(&x) { 80.0 } else { 0.0 };
            let wall = map(128, 128, |x, y| wall(if transposed { y } else { x }));
            let texel = if transposed { 40 * 128 + 64 } else { 64 * 128 + 40 };
            for radius in [19f32, 24.0, 40.0, 60.0] {
                let how = Occlusion { wrap, slices: 64, distance: radius / 128.0, ..Occlusion::default() };
                let found = 1.0 - visibility(&wall, 1.0 / 128.0, &how, &|_| {}).unwrap().visibility[texel];
                // Only azimuths within acos(20 / radius) reach the wall. Each hides the squared sine of the elevation of the edge.
                let (steps, edge) = (4000, (20.0 / radius).min(1.0).acos());
                let sine_square = |k| 1.0 - (20.0 / ((edge * (k as f32 + 0.5) / steps as f32).cos() * radius)).powi(2);
                let expected = (0..steps).map(sine_square).sum::<f32>() * edge / steps as f32 / std::f32::consts::PI;
                println!("{transposed} {wrap:?} {radius}: {found:.4} {expected:.4}");
                // Half a texel in front of the wall, the relief between texels already rises.
                let off = found - expected;
                assert!((-2e-3..6e-3).contains(&off), "{transposed} {wrap:?} {radius}: {found} {expected}");
            }
        }
    }

    #[test]
    fn heights_of_any_size_are_finite() {
        for scale in [0.0, 1e-30, 1e30, f32::MAX] {
            let rough = map(9, 5, |x, y| f64::from((x * 5 + y * 3) % 7) * 1e11 - 3e11);
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                for distance in [f32::INFINITY, f32::MAX, 1.0, f32::MIN_POSITIVE, 0.0, -1.0, f32::NAN] {
                    let how = Occlusion { wrap, slices: 4, distance, ..Occlusion::default() };
                    let found = visibility(&rough, scale, &how, &|_| {}).unwrap();
                    // Four slices make a vertical half of all directions 2.6 % too long.
                    let good = |v: &f32| v.is_finite() && v.abs() <= 1.03;
                    assert!(
                        found.vectors.iter().flatten().all(good) && found.visibility.iter().all(good),
                        "{scale} {distance}"
                    );
                }
            }
        }
    }
}
