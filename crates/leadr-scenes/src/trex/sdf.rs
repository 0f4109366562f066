//! The signed distance field of the animal in its bind pose, with an acceleration grid.
//!
//! A part affects the combined value only near its surface. Each grid cell lists the parts (and the stations of long lofts) that can affect
//! points in the cell, so an evaluation needs a few primitives instead of eighty. The result must equal the result of
//! `Field::distance_unaccelerated`.

use glam::Vec3;
use rayon::prelude::*;

use super::parts::{Binding, GROUPS, Op, PartSpec, TOO_FINE_FOR_CAGE};
use super::primitive::{Bounds, Hit, Primitive, smooth_min};

/// The distance that is returned if no part is near, in metres.
const FAR: f32 = 1e3;
/// The largest distance that is returned, in metres. Further away, first-order distances are inaccurate.
const LARGEST: f32 = 1.0;
/// The edge of a grid cell in metres.
const CELL: f32 = 0.125;
/// The low corner of the grid (`y` is folded) and the number of cells along each axis. Outside the grid, every part is evaluated.
const LOW: Vec3 = Vec3::new(-7.25, 0.0, -0.5);
const SIZE: [usize; 3] = [102, 12, 43];
/// The largest change, in metres, of the difference of two distances between samples half a cell apart.
const MARGIN: f32 = 0.12;
/// The distance in metres beyond which the grid uses the distance to a part's box. The blend radius is added to it.
const REACH: f32 = 0.5;

/// A primitive with its position in the order of combination.
#[derive(Clone, Debug)]
struct Part {
    spec: PartSpec,
    primitive: Primitive,
    bounds: Bounds,
    group: usize,
}

/// The stations `first..=last` of a part. If consecutive entries belong to one part, their minimum is used.
#[derive(Clone, Copy, Debug)]
struct Entry {
    part: u8,
    first: u16,
    last: u16,
}

/// A distance field that combines parts, with its grid.
#[derive(Clone, Debug)]
pub struct Field {
    parts: Vec<Part>,
    /// The offsets of the cells. Cell `i` has the entries `entries[offsets[i]..offsets[i + 1]]`.
    offsets: Vec<u32>,
    entries: Vec<Entry>,
}

/// Combines distances in order: first the parts of a group, and then the groups.
struct Fold {
    total: f32,
    inner: f32,
    group: usize,
}

impl Fold {
    const fn new() -> Self {
        Self { total: FAR, inner: FAR, group: 0 }
    }

    #[inline]
    fn add(&mut self, part: &Part, distance: f32) {
        if part.group != self.group {
            self.close();
            self.group = part.group;
        }
        self.inner = match part.spec.op {
            Op::Add => smooth_min(self.inner, distance, part.spec.blend),
            Op::Carve => -smooth_min(-self.inner, distance, part.spec.blend),
        };
    }

    #[inline]
    fn close(&mut self) {
        self.total = smooth_min(self.total, self.inner, GROUPS[self.group].blend);
        self.inner = FAR;
    }

    /// Returns the distance after all parts are combined.
    #[inline]
    fn distance(mut self) -> f32 {
        self.close();
        self.total.min(LARGEST)
    }
}

fn fold_sides(p: Vec3) -> Vec3 {
    Vec3::new(p.x, p.y.abs(), p.z)
}

impl Field {
    /// Collects the parts, without a grid.
    fn new(leave_out: &[&str]) -> Self {
        let specs = GROUPS.iter().enumerate().flat_map(|(group, g)| g.parts.iter().map(move |spec| (group, spec)));
        let kept = specs.filter(|(_, spec)| !leave_out.contains(&spec.name));
        let part = |(group, spec): (usize, &PartSpec)| {
            let (primitive, bounds) = Primitive::new(spec);
            Part { spec: spec.clone(), primitive, bounds, group }
        };
        Self { parts: kept.map(part).collect(), offsets: vec![0], entries: Vec::new() }
    }

    /// Returns the distance by evaluating all parts.
    fn distance_unaccelerated(&self, p: Vec3) -> f32 {
        let p = fold_sides(p);
        let mut fold = Fold::new();
        for part in &self.parts {
            fold.add(part, part.primitive.hit(p).distance);
        }
        fold.distance()
    }

    /// Returns the signed distance in metres, at most 1 and negative inside. Near the surface, the distance is accurate to first order.
    pub fn distance(&self, p: Vec3) -> f32 {
        let p = fold_sides(p);
        let cell = (p - LOW) / CELL;
        let [x, y, z] = cell.to_array().map(|c| c as usize);
        let [nx, ny, nz] = SIZE;
        if cell.min_element() < 0.0 || x >= nx || y >= ny || z >= nz {
            return self.distance_unaccelerated(p);
        }
        let index = (x * ny + y) * nz + z;
        let entries = &self.entries[self.offsets[index] as usize..self.offsets[index + 1] as usize];
        let mut fold = Fold::new();
        let mut i = 0;
        while i < entries.len() {
            let Entry { part: id, first, last } = entries[i];
            let part = &self.parts[usize::from(id)];
            let mut distance = part.primitive.hit_in(p, first, last).distance;
            i += 1;
            while i < entries.len() && entries[i].part == id {
                distance = distance.min(part.primitive.hit_in(p, entries[i].first, entries[i].last).distance);
                i += 1;
            }
            fold.add(part, distance);
        }
        fold.distance()
    }

    /// Returns the gradient of [`Self::distance`] by central differences over `±step` metres. At the surface, the length of the gradient is
    /// close to one.
    pub fn gradient(&self, p: Vec3, step: f32) -> Vec3 {
        let d = |axis: Vec3| self.distance(p + axis * step) - self.distance(p - axis * step);
        Vec3::new(d(Vec3::X), d(Vec3::Y), d(Vec3::Z)) / (2.0 * step)
    }

    /// Computes the distances to the parts at a folded point. For parts far away, the distances are bounds.
    fn near_distances(&self, p: Vec3, out: &mut Vec<f32>) {
        out.clear();
        out.extend(self.parts.iter().map(|part| {
            let away = part.bounds.distance(p);
            if away > REACH + part.spec.blend { away } else { part.primitive.hit(p).distance }
        }));
    }

    /// Returns a bit mask of the parts that affect the result if the distances to the parts are within [`MARGIN`] of `distances`.
    ///
    /// A part has no effect if the combined distance before it is smaller by its blend radius. A part has no effect either if a later union
    /// overrides everything before this later union. The rule also applies to whole groups.
    fn relevant(&self, distances: &[f32]) -> u128 {
        let (mut mask, mut total) = (0_u128, FAR);
        for (group, g) in GROUPS.iter().enumerate() {
            let (mut inner, mut kept, mut carved) = (FAR, 0_u128, 0_u128);
            for (i, part) in self.parts.iter().enumerate().filter(|(_, q)| q.group == group) {
                let (d, k, bit) = (distances[i], part.spec.blend, 1_u128 << i);
                match part.spec.op {
                    Op::Add => {
                        if inner > d + k + MARGIN {
                            // Carvings are kept, because without them the value that is overridden would be lower.
                            kept = carved;
                        }
                        if d <= inner + k + MARGIN {
                            kept |= bit;
                        }
                        inner = smooth_min(inner, d, k);
                    }
                    Op::Carve => {
                        if d <= -inner + k + MARGIN {
                            kept |= bit;
                            carved |= bit;
                        }
                        inner = -smooth_min(-inner, d, k);
                    }
                }
            }
            let k = g.blend;
            if total > inner + k + MARGIN {
                mask = 0;
            }
            if inner <= total + k + MARGIN {
                mask |= kept;
            }
            total = smooth_min(total, inner, k);
        }
        mask
    }

    /// Fills the grid from part masks at twice the grid's resolution.
    fn build_grid(&mut self, masks: &[u128]) {
        let [nx, ny, nz] = SIZE;
        let (my, mz) = (2 * ny + 1, 2 * nz + 1);
        let cells: Vec<Vec<Entry>> = (0..nx * ny * nz)
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let (x, y, z) = (i / (ny * nz), i / nz % ny, i % nz);
                let mut mask = 0;
                for dx in 0..3 {
                    for dy in 0..3 {
                        let row = ((2 * x + dx) * my + 2 * y + dy) * mz + 2 * z;
                        mask |= masks[row] | masks[row + 1] | masks[row + 2];
                    }
                }
                let low = LOW + Vec3::new(x as f32, y as f32, z as f32) * CELL;
                let cell = Bounds { low, high: low + CELL };
                let near = self.parts.iter().enumerate().filter(|(i, _)| mask >> i & 1 == 1);
                let runs = near.flat_map(|(i, part)| part.primitive.facing(&cell).into_iter().map(move |run| (i, run)));
                runs.map(|(i, [first, last])| Entry { part: i as u8, first, last }).collect()
            })
            .collect();
        for cell in cells {
            self.entries.extend(cell);
            self.offsets.push(self.entries.len() as u32);
        }
    }
}

/// The whole animal as a signed distance field in metres. The field is in model space, and symmetric in `y`.
///
/// The field is immutable, so threads may share it.
#[derive(Clone, Debug)]
pub struct TrexSdf {
    /// The full model, including mouth cavity, tongue, lids and fingers.
    pub full: Field,
    /// The model for the cage, without the parts of [`TOO_FINE_FOR_CAGE`].
    pub coarse: Field,
}

impl TrexSdf {
    /// Builds the full and coarse fields with their grids, in a fraction of a second.
    pub fn new() -> Self {
        let (mut full, mut coarse) = (Field::new(&[]), Field::new(&TOO_FINE_FOR_CAGE));
        let kept: Vec<usize> =
            (0..full.parts.len()).filter(|&i| !TOO_FINE_FOR_CAGE.contains(&full.parts[i].spec.name)).collect();
        // Neighbouring cells share samples at half the cell spacing, and the two fields have the same primitives.
        let [mx, my, mz] = SIZE.map(|n| 2 * n + 1);
        let masks: Vec<[u128; 2]> = (0..mx * my * mz)
            .into_par_iter()
            .with_min_len(1024)
            .map_init(
                || (Vec::new(), Vec::new()),
                |(all, some), i| {
                    let node = Vec3::new((i / (my * mz)) as f32, (i / mz % my) as f32, (i % mz) as f32);
                    full.near_distances(LOW + node * (0.5 * CELL), all);
                    some.clear();
                    some.extend(kept.iter().map(|&k| all[k]));
                    [full.relevant(all), coarse.relevant(some)]
                },
            )
            .collect();
        let of = |variant: usize| masks.iter().map(|m| m[variant]).collect::<Vec<u128>>();
        full.build_grid(&of(0));
        coarse.build_grid(&of(1));
        Self { full, coarse }
    }

    /// Returns the distance in metres to the palate, the mouth floor or the tongue, whichever is nearest. The distance is close to zero or
    /// negative on the lining of the mouth.
    pub fn mouth_distance(&self, p: Vec3) -> f32 {
        let p = fold_sides(p);
        let mouth = self.full.parts.iter().filter(|q| matches!(q.spec.name, "palate" | "mouth_floor" | "tongue"));
        mouth
            .map(|q| {
                let away = q.bounds.distance(p);
                if away > 0.1 { away } else { q.primitive.hit(p).distance }
            })
            .fold(FAR, f32::min)
    }

    /// Returns the joints of each additive part of the full model whose box is within `reach` of `p`, and the distance to the part.
    pub fn near_parts(&self, p: Vec3, reach: f32) -> Vec<(Binding, Hit)> {
        let p = fold_sides(p);
        let near = self.full.parts.iter().filter(|q| q.spec.op == Op::Add && q.bounds.distance(p) <= reach);
        near.map(|q| (q.spec.binding, q.primitive.hit(p))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    /// Returns points that are spread over the animal's box by a low-discrepancy sequence (R3).
    fn spread(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(|i| {
            let t = |a: f64| ((i as f64 + 0.5) * a).fract() as f32;
            let unit = Vec3::new(t(0.819_172_513), t(0.671_043_607), t(0.549_700_478));
            Vec3::new(-7.0, -1.2, -0.3) + unit * Vec3::new(12.3, 2.4, 5.0)
        })
    }

    #[test]
    fn grid_reproduces_the_plain_fold() {
        let sdf = TrexSdf::new();
        let (mut near, mut worst_near, mut worst_mid) = (0, 0.0_f32, 0.0_f32);
        for field in [&sdf.full, &sdf.coarse] {
            for p in spread(200_000) {
                let (fast, plain) = (field.distance(p), field.distance_unaccelerated(p));
                if plain.abs() < 0.1 {
                    near += 1;
                    worst_near = worst_near.max((fast - plain).abs());
                } else {
                    if plain.abs() < 0.5 {
                        worst_mid = worst_mid.max((fast - plain).abs());
                    }
                    assert_eq!(fast < 0.0, plain < 0.0, "{p}");
                }
            }
        }
        println!("{near} near points, worst difference {worst_near:e} m; to 0.5 m {worst_mid:e} m");
        assert!(near > 5_000 && worst_near < 1e-5, "{worst_near}");
        assert!(worst_mid < 0.06, "{worst_mid}");
    }

    #[test]
    fn overall_measures_are_those_of_the_design() {
        let sdf = TrexSdf::new();
        // Finds the surface along an axis: at the nose tip, the tail tip, the top of the head, the back over the hips, or half the width.
        let along = |from: Vec3, to: Vec3| {
            let (mut inside, mut outside) = (from, to);
            for _ in 0..40 {
                let mid = (inside + outside) * 0.5;
                if sdf.full.distance(mid) < 0.0 { inside = mid } else { outside = mid }
            }
            inside
        };
        let tail = along(Vec3::new(-6.6, 0.0, 2.71), Vec3::new(-7.2, 0.0, 2.72)).x;
        let back = along(Vec3::new(0.0, 0.0, 3.0), Vec3::new(0.0, 0.0, 4.5)).z;
        assert!((tail + 6.74).abs() < 0.03, "{tail}");
        assert!((back - 3.61).abs() < 0.02, "{back}");
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for p in spread(2_000_000).filter(|p| sdf.full.distance(*p) < 0.0) {
            (low, high) = (low.min(p), high.max(p));
        }
        println!("inside points span {low} .. {high}");
        assert!((high.x - 4.89).abs() < 0.03 && (high.z - 4.33).abs() < 0.03, "{high}");
        assert!((high.y - 0.845).abs() < 0.02, "{high}");
        assert!(low.z > -0.005 && low.z < 0.02, "{low}");
    }

    #[test]
    #[ignore = "timing, for people"]
    fn timing() {
        let start = Instant::now();
        let sdf = TrexSdf::new();
        println!("build {:?}, entries {} + {}", start.elapsed(), sdf.full.entries.len(), sdf.coarse.entries.len());
        let near: Vec<Vec3> = spread(4_000_000).filter(|p| sdf.full.distance(*p).abs() < 0.05).collect();
        let start = Instant::now();
        let sum: f32 = near.iter().map(|p| sdf.full.distance(*p)).sum();
        println!("{} near points, {:?} each ({sum})", near.len(), start.elapsed() / near.len() as u32);
    }
}
