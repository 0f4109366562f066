//! Ambient occlusion of the environment by large shapes, stored as a volume of visibility around all shadow casters.
//!
//! Each node of the volume stores the visibility of all directions to first order, as `v(ω) = a + b·ω`. The mean visibility is `a`,
//! and the mean of visibility times direction is a third of `b`. A surface with normal `n` sees the cosine-weighted fraction `a + ⅔
//! b·n` of a constant environment. The fraction is exact if a half space is visible. The occluders are the [`Columns`], which do
//! not contain the relief, because slope statistics and horizons handle occlusion by bumps.
//!
//! For each azimuth, a node marches through the columns and stores the occluded elevations as bits (as in Therrien et al. 2023).

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::casters::{Columns, Span};
use crate::constants::{SKY_LAYERS, SKY_LAYERS_BELOW, SKY_NODES};
use leadr_gpu::shared_struct;

/// The maximum number of nodes per layer.
const MOST_ACROSS: f32 = (SKY_NODES / SKY_LAYERS) as f32;
const LAYERS: usize = SKY_LAYERS as usize;
/// The number of azimuths of a node. Every second node uses the azimuths halfway between them.
const AZIMUTHS: usize = 8;
/// The growth of the march steps, in metres per metre of distance.
const GROWTH: f32 = 0.2;
/// The extents of the volume, as multiples of the casters' height. The volume reaches beyond the sides of the casters, and above
/// and below their lowest point.
const ASIDE: f32 = 0.9;
const ABOVE: f32 = 1.4;
const BELOW: f32 = 0.4;

shared_struct! {
    /// The header of the volume on the device.
    pub struct SkyVisibilityGpu for "SkyVisibility" {
        /// The lowest corner and the floor of the volume, in metres.
        sky_corner: [f32; 4],
        /// The number of nodes per metre across, and the reciprocals of the extents above and below the floor.
        sky_rates: [f32; 4],
        /// The numbers of nodes across.
        sky_across: [f32; 2],
    }
}

/// The visibility volume.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyVisibility {
    /// The lowest corner. `floor` is the height of the densest layer.
    origin: Vec2,
    floor: f32,
    /// The horizontal spacing of the nodes in metres. `size` has the numbers of nodes across.
    step: Vec2,
    size: [usize; 2],
    /// The extents of the layers above and below the floor, in metres.
    reach: [f32; 2],
    /// The visibility `b` and `a` of each node.
    nodes: Vec<[f32; 4]>,
}

/// The visibility of the environment between large shapes, at a point: `mean + lean·ω` in the unit direction `ω`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyProbe {
    /// The position in metres.
    pub position: Vec3,
    /// The mean visibility of all directions, from 0 to 1.
    pub mean: f32,
    /// The gradient of the visibility, which points towards more visible directions.
    pub lean: Vec3,
}

impl SkyVisibility {
    /// Computes the volume around the shadow casters, given as columns.
    pub fn around(columns: &Columns) -> Self {
        let tall = (columns.height[1] - columns.height[0]).max(columns.cell);
        let matter = Vec2::new(columns.size[0] as f32, columns.size[1] as f32) * columns.cell;
        let extent = matter + 2.0 * ASIDE * tall;
        let step = (extent.x * extent.y / MOST_ACROSS).sqrt();
        let across = |side: f32| ((side / step) as usize + 1).max(2);
        let mut size = [across(extent.x), across(extent.y)];
        // Rounding may add one row of nodes too many.
        while size[0] * size[1] > MOST_ACROSS as usize {
            let longer = usize::from(size[1] > size[0]);
            size[longer] -= 1;
        }
        let mut volume = Self {
            origin: columns.origin - ASIDE * tall,
            floor: columns.height[0],
            step: extent / Vec2::new((size[0] - 1) as f32, (size[1] - 1) as f32),
            size,
            reach: [ABOVE * tall, BELOW * tall],
            nodes: Vec::new(),
        };
        let bins = Elevations::new();
        let (step, floor) = (volume.step, volume.floor);
        let index = |i: usize| (i / (size[0] * size[1]), i / size[0] % size[1], i % size[0]);
        let seen: Vec<Option<[f32; 4]>> = (0..size[0] * size[1] * LAYERS)
            .into_par_iter()
            .map(|i| {
                let (k, y, x) = index(i);
                let position = (volume.origin + step * Vec2::new(x as f32, y as f32)).extend(volume.layer(k));
                // Nodes of the floor layer lie just above the ground.
                let position =
                    if k == SKY_LAYERS_BELOW as usize { position.with_z(floor + 1e-3 * tall) } else { position };
                (!columns.is_solid(position)).then(|| bins.seen(columns, position, (x + y + k) % 2 == 1))
            })
            .collect();
        volume.nodes = filled(seen, size);
        volume
    }

    /// Returns the height of a layer. Layers are denser near the floor.
    fn layer(&self, k: usize) -> f32 {
        let (below, above) = (SKY_LAYERS_BELOW as f32, (SKY_LAYERS - 1 - SKY_LAYERS_BELOW) as f32);
        let k = k as f32 - below;
        self.floor + if k < 0.0 { -self.reach[1] * (k / below).powi(2) } else { self.reach[0] * (k / above).powi(2) }
    }

    /// Returns the nodes as probes.
    pub fn probes(&self) -> impl Iterator<Item = SkyProbe> + use<'_> {
        let [across, down] = self.size;
        self.nodes.iter().enumerate().map(move |(i, &[x, y, z, mean])| {
            let position = self.origin + self.step * Vec2::new((i % across) as f32, (i / across % down) as f32);
            SkyProbe { position: position.extend(self.layer(i / (across * down))), mean, lean: Vec3::new(x, y, z) }
        })
    }

    /// Returns the volume in the layout of `passes/shade/sky_visibility.glsl`: a header, followed by nodes with 16 bits per
    /// number. With eight bits, rounding would darken unoccluded surfaces by up to 0.4 %.
    pub fn bytes(&self) -> Vec<u8> {
        let [rate, above_and_below] = [self.step, Vec2::from(self.reach)].map(Vec2::recip);
        let head = SkyVisibilityGpu {
            sky_corner: [self.origin.x, self.origin.y, self.floor, 0.0],
            sky_rates: [rate.x, rate.y, above_and_below.x, above_and_below.y],
            sky_across: self.size.map(|nodes| nodes as f32),
        };
        let level = |v: f32| (v.clamp(-1.0, 1.0) * 32767.0).round() as i16;
        let node = |&[x, y, z, a]: &[f32; 4]| [x / 1.5, y / 1.5, z / 1.5, 2.0 * a - 1.0].map(level);
        let nodes: Vec<[i16; 4]> = self.nodes.iter().map(node).collect();
        [bytemuck::bytes_of(&head), bytemuck::cast_slice(&nodes)].concat()
    }

    /// Returns the first-order visibility `b` and `a` at a point of a surface, interpolated between nodes one node away from it.
    /// `sky_seen` in `passes/shade/sky_visibility.glsl` does the same.
    #[cfg(test)]
    fn seen(&self, position: Vec3, normal: Vec3) -> [f32; 4] {
        let (below, above) = (SKY_LAYERS_BELOW as f32, (SKY_LAYERS - 1 - SKY_LAYERS_BELOW) as f32);
        let up = position.z - self.floor;
        let layer = if up < 0.0 {
            below - (-up / self.reach[1]).sqrt() * below
        } else {
            below + (up / self.reach[0]).sqrt() * above
        };
        let at = ((position.truncate() - self.origin) / self.step).extend(layer) + normal;
        let last = Vec3::new(self.size[0] as f32, self.size[1] as f32, LAYERS as f32) - 1.0;
        let at = at.clamp(Vec3::ZERO, last - 1e-3);
        let (base, part) = (at.floor(), at.fract());
        let mut sum = [0.0; 4];
        for corner in 0..8 {
            let one = |axis: usize| corner >> axis & 1;
            let weight: f32 = (0..3).map(|axis| if one(axis) == 1 { part[axis] } else { 1.0 - part[axis] }).product();
            let [x, y, z] = [0, 1, 2].map(|axis| base[axis] as usize + one(axis));
            let node = self.nodes[(z * self.size[1] + y) * self.size[0] + x];
            (0..4).for_each(|i| sum[i] += weight * node[i]);
        }
        sum
    }
}

/// Bins of elevation, uniform in the sine, with prefix sums.
struct Elevations {
    /// The prefix sums of the sines and cosines, from the lowest elevation upwards.
    sines: [f32; 65],
    cosines: [f32; 65],
    /// The azimuths of even nodes, and the azimuths halfway between them for odd nodes.
    azimuths: [[Vec2; AZIMUTHS]; 2],
}

impl Elevations {
    fn new() -> Self {
        let (mut sines, mut cosines) = ([0.0; 65], [0.0; 65]);
        for i in 0..64 {
            let sine = (i as f32 + 0.5) / 32.0 - 1.0;
            sines[i + 1] = sines[i] + sine;
            cosines[i + 1] = cosines[i] + (1.0 - sine * sine).sqrt();
        }
        let azimuth = |i: usize, part: f32| Vec2::from_angle((i as f32 + part) * TAU / AZIMUTHS as f32);
        let azimuths = [0.25, 0.75].map(|part| std::array::from_fn(|i| azimuth(i, part)));
        Self { sines, cosines, azimuths }
    }

    /// Computes the visibility of all directions from a point, as `b` and `a`.
    fn seen(&self, columns: &Columns, position: Vec3, between: bool) -> [f32; 4] {
        let matter = Vec2::new(columns.size[0] as f32, columns.size[1] as f32) * columns.cell;
        let (low, high) = (columns.origin, columns.origin + matter);
        let (mut hidden, mut towards) = (0.0f32, Vec3::ZERO);
        // The spans at this sample of the march and at the last one, with the bins that they hide.
        let (mut here, mut last) = (Vec::<(Span, [u32; 2])>::new(), Vec::<(Span, [u32; 2])>::new());
        for direction in self.azimuths[usize::from(between)] {
            // The ray is only followed within the extent of the columns in x and y.
            let (a, b) = ((low - position.truncate()) / direction, (high - position.truncate()) / direction);
            let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
            let mut bits = 0u64;
            let mut t = near;
            last.clear();
            while t < far {
                let bin = |z: f32| {
                    let up = z - position.z;
                    (up / (up * up + t * t).sqrt() * 32.0 + 32.5).clamp(0.0, 64.0) as u32
                };
                let spans = columns.spans_at(position.truncate() + direction * t);
                here.extend(spans.map(|span| (span, span.map(bin))));
                for (span, bins) in &here {
                    // Matter that reaches from the last sample to this one also hides the directions between them.
                    let joined = last.iter().filter(|(other, _)| other[0] <= span[1] && span[0] <= other[1]);
                    let [from, to] =
                        joined.fold(*bins, |[from, to], (_, other)| [from.min(other[0]), to.max(other[1])]);
                    if to > from {
                        bits |= (u64::MAX >> (64 - (to - from))) << from;
                    }
                }
                std::mem::swap(&mut here, &mut last);
                here.clear();
                // Samples are dense near the node, whose own column comes first.
                t += if t > near { (0.8 * columns.cell).max(GROWTH * t) } else { 0.35 * columns.cell };
            }
            while bits != 0 {
                let from = bits.trailing_zeros() as usize;
                let to = from + (bits >> from).trailing_ones() as usize;
                hidden += (to - from) as f32;
                towards +=
                    (direction * (self.cosines[to] - self.cosines[from])).extend(self.sines[to] - self.sines[from]);
                bits &= if to == 64 { 0 } else { u64::MAX << to };
            }
        }
        let count = (64 * AZIMUTHS) as f32;
        let b = towards * (-3.0 / count);
        [b.x, b.y, b.z, 1.0 - hidden / count]
    }
}

/// Gives each node inside matter the mean of its visible neighbours, so that interpolation does not darken nearby points. A node below
/// the floor is like the node above it.
fn filled(mut seen: Vec<Option<[f32; 4]>>, [width, depth]: [usize; 2]) -> Vec<[f32; 4]> {
    let around = |seen: &[Option<[f32; 4]>], i: usize| {
        let (x, y, k) = ((i % width) as isize, (i / width % depth) as isize, (i / (width * depth)) as isize);
        let (mut sum, mut count) = ([0.0; 4], 0.0);
        for [dx, dy, dk] in [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]] {
            let (x, y, k) = (x + dx, y + dy, k + dk);
            let inside = x >= 0 && y >= 0 && k >= 0 && x < width as isize && y < depth as isize;
            let index = (k * depth as isize + y) * width as isize + x;
            if let Some(Some(node)) = inside.then(|| seen.get(index as usize)).flatten() {
                (0..4).for_each(|i| sum[i] += node[i]);
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum.map(|s| s / count))
    };
    // Only open surfaces on the floor reach below it. They contain their own bumps, which see as much as the surface.
    for i in (0..SKY_LAYERS_BELOW as usize * width * depth).rev() {
        seen[i] = seen[i].or(seen[i + width * depth]);
    }
    for _ in 0..2 {
        let missing = (0..seen.len()).filter(|&i| seen[i].is_none());
        let found: Vec<(usize, [f32; 4])> = missing.filter_map(|i| Some((i, around(&seen, i)?))).collect();
        found.into_iter().for_each(|(i, node)| seen[i] = Some(node));
    }
    // These nodes lie deep inside matter, where nothing is shaded.
    seen.into_iter().map(|node| node.unwrap_or([0.0, 0.0, 0.0, 1.0])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::casters::tests::ball;
    use super::*;

    fn cosine_share([x, y, z, a]: [f32; 4], n: Vec3) -> f32 {
        (a + 2.0 / 3.0 * Vec3::new(x, y, z).dot(n)).clamp(0.0, 1.0)
    }

    /// Returns the fraction of the hemisphere above a floor that a sphere hides. The fraction is exact while the sphere is above
    /// the horizon.
    fn truth(position: Vec2, height: f32, radius: f32) -> f32 {
        1.0 - radius * radius * height / (position.length_squared() + height * height).powf(1.5)
    }

    #[test]
    fn floor_visibility_past_a_sphere_matches_closed_form() {
        for height in [1.0f32, 1.6] {
            let volume = SkyVisibility::around(&Columns::of(ball(Vec3::Z * height, 1.0).into_iter(), 0.0).unwrap());
            let (mut square, mut without, mut count) = (0.0, 0.0, 0.0);
            for i in 0..900 {
                let position = Vec2::new((i % 30) as f32, (i / 30) as f32) * 0.2 - 2.9;
                let seen = cosine_share(volume.seen(position.extend(0.0), Vec3::Z), Vec3::Z);
                let wanted = truth(position, height, 1.0);
                square += (seen - wanted).powi(2);
                without += (1.0 - wanted).powi(2);
                count += 1.0;
            }
            let [error, without] = [square, without].map(|sum: f32| (sum / count).sqrt());
            println!("height {height}: rms {error:.4}, without {without:.4}");
            assert!(error < 0.05 && without > 0.1, "{error} {without}");
        }
    }

    #[test]
    fn convex_shapes_are_unoccluded() {
        let volume = SkyVisibility::around(&Columns::of(ball(Vec3::Z, 1.0).into_iter(), 0.0).unwrap());
        for i in 0..200 {
            let z = (i as f32 + 0.5) / 100.0 - 1.0;
            let n = (Vec2::from_angle(2.4 * i as f32) * (1.0 - z * z).sqrt()).extend(z);
            let seen = cosine_share(volume.seen(Vec3::Z + n, n), n);
            assert!(seen > 0.999, "{n}: {seen}");
        }
    }

    /// Returns the least visibility at points above a sheet of this slope, whose relief is this deep in metres.
    fn least_above_sheet(slope: Vec2, relief: f32, above: f32) -> f32 {
        let normal = (-slope).extend(1.0).normalize();
        let at = |p: Vec2| p.extend(slope.dot(p));
        let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|p| at(Vec2::from(p) * 4.0));
        let columns = Columns::of([[a, b, c], [a, c, d]].into_iter(), relief).unwrap();
        let volume = SkyVisibility::around(&columns);
        let seen = |i: i32| {
            let p = at(Vec2::new((i % 30) as f32, (i / 30) as f32) * 0.2 - 2.9) + normal * above;
            cosine_share(volume.seen(p, normal), normal)
        };
        (0..900).map(seen).fold(1.0, f32::min)
    }

    #[test]
    fn sheets_are_unoccluded() {
        for slope in [Vec2::ZERO, Vec2::new(0.05, 0.0), Vec2::new(0.18, 0.24), Vec2::new(0.0, 3.0)] {
            let least = least_above_sheet(slope, 0.0, 0.0);
            assert!(least > 0.999, "{slope}: {least}");
        }
    }

    #[test]
    fn relief_is_left_to_horizons() {
        for slope in [Vec2::ZERO, Vec2::new(0.05, 0.0), Vec2::new(0.18, 0.24)] {
            for relief in [0.03, 0.1, 0.3] {
                for above in [-relief, relief] {
                    let least = least_above_sheet(slope, relief, above);
                    assert!(least > 0.97, "{slope}, {above} m: {least}");
                }
            }
        }
    }

    #[test]
    fn distant_points_are_unoccluded() {
        let volume = SkyVisibility::around(&Columns::of(ball(Vec3::Z, 1.0).into_iter(), 0.0).unwrap());
        let rim = volume.nodes.iter().take(volume.size[0]).map(|node| cosine_share(*node, Vec3::Z));
        assert!(rim.into_iter().all(|seen| seen > 0.9));
        assert!(volume.nodes.len() <= SKY_NODES as usize);
    }
}
