//! The atlas of displacements and colours, which has one tile per quad of the cage.
//!
//! A texel holds the distance along the patch normal `N(u, v)` from the limit surface `X(u, v)` to the animal's surface, including the
//! relief of the skin. A displaced surface folds over where `1 + hκ` is negative, so the curvature of adjacent patches bounds the
//! displacement per vertex.
//!
//! Edges are evaluated once for both tiles. The gutter of a tile is the point reflection of the tile's texels through the values on the
//! edge. Bilinear filtering on an edge therefore returns the exact value, at every mip level that keeps the gutter.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::sdf::TrexSdf;
use super::skin::Skin;
use crate::registry::Progress;
use crate::sphere::{color_code, fill_tiles};
use leadr_maps::noise::smoothstep as ss;
use leadr_render::surfaces::patch::{Patch, PatchPoint};
use leadr_render::surfaces::patch_mesh::{PatchMesh, TileLayout};

/// The largest displacements inwards and outwards, in metres.
const REACH: [f32; 2] = [0.16, 0.10];
/// The smallest ratio of displaced to undisplaced area, projected along the normal.
const LEAST_AREA: f32 = 0.3;
/// The x coordinate behind which the full model differs from the cage only in fingers and dew claws, which are props.
const HEAD_X: f32 = 3.0;

/// The properties of one point: height, linear albedo and `α`.
type Sample = [f32; 5];

/// The distance to the animal's surface along the normal, and quantities that vary smoothly with the position.
#[derive(Clone, Copy, Default)]
struct Node {
    distance: f32,
    /// The fraction of the skin relief that is applied. The fraction is small on walls that are nearly parallel to the normal.
    relief: f32,
    mouth: f32,
}

struct Baker<'a> {
    sdf: &'a TrexSdf,
    skin: &'a Skin,
    mesh: &'a PatchMesh,
    patches: Vec<Patch>,
    /// The limits of each vertex's displacement inwards and outwards, as positive metres.
    bounds: Vec<[f32; 2]>,
}

/// Limits `x` to the bounds without a kink. Values up to 60 % of a bound do not change.
fn soft_limit(x: f32, [inward, outward]: [f32; 2]) -> f32 {
    let bound = if x < 0.0 { inward } else { outward };
    let r = x.abs() / bound;
    if r <= 0.6 { x } else { (bound * (0.6 + 0.4 * ((r - 0.6) / 0.4).tanh())).copysign(x) }
}

/// Returns the largest displacements inwards and outwards that preserve the projected area at every sample of the patch.
fn patch_bounds(patch: &Patch) -> [f32; 2] {
    let mut bounds = REACH;
    let center = patch.at(Vec2::splat(0.5));
    let usual = center.du.cross(center.dv).length();
    for i in 0..36 {
        let uv = Vec2::new((i % 6) as f32, (i / 6) as f32) / 5.0;
        let p = patch.at(uv);
        let area = |h: f32| (p.du + p.normal_du * h).cross(p.dv + p.normal_dv * h).dot(p.normal);
        // Where the limit surface is degenerate, displacement cannot improve it.
        let least = LEAST_AREA * area(0.0).max(0.05 * usual);
        for (bound, sign) in bounds.iter_mut().zip([-1.0, 1.0]) {
            let mut h = 0.002;
            while h < *bound && area(sign * h) >= least {
                h *= 1.15;
            }
            *bound = bound.min(h);
        }
    }
    bounds
}

impl<'a> Baker<'a> {
    fn new(sdf: &'a TrexSdf, skin: &'a Skin, mesh: &'a PatchMesh) -> Self {
        let patches: Vec<Patch> = mesh
            .patches
            .iter()
            .map(|q| Patch::new(q.map(|v| mesh.positions[v as usize]), q.map(|v| mesh.normals[v as usize])))
            .collect();
        let per_patch: Vec<[f32; 2]> = patches.par_iter().map(patch_bounds).collect();
        let mut bounds = vec![REACH; mesh.positions.len()];
        for (quad, limit) in mesh.patches.iter().zip(&per_patch) {
            for &v in quad {
                let b = &mut bounds[v as usize];
                *b = [b[0].min(limit[0]), b[1].min(limit[1])];
            }
        }
        Self { sdf, skin, mesh, patches, bounds }
    }

    fn field(&self, p: Vec3) -> f32 {
        if p.x < HEAD_X { self.sdf.coarse.distance(p) } else { self.sdf.full.distance(p) }
    }

    /// Returns the distance along `n` to the surface, or the reach if there is no surface. The search goes inwards from outside points, and
    /// outwards from inside points. The result depends only on the arguments, so neighbours agree.
    fn cross(&self, x: Vec3, n: Vec3) -> f32 {
        let start = self.field(x);
        let sign = if start > 0.0 { -1.0 } else { 1.0 };
        let reach = if sign < 0.0 { 1.5 * REACH[0] } else { 1.5 * REACH[1] };
        // `near` is the distance along the march. `value` is positive until the surface is crossed.
        let (mut near, mut value) = (0.0_f32, start.abs());
        if value < 1e-6 {
            return 0.0;
        }
        for _ in 0..80 {
            let far = near + (0.9 * value).max(4e-4);
            let beyond = -sign * self.field(x + n * (sign * far));
            if beyond <= 0.0 {
                return sign * self.refine(x, n, sign, [near, far], [value, beyond]);
            }
            (near, value) = (far, beyond);
            if near > reach {
                break;
            }
        }
        sign * near.min(reach)
    }

    /// Finds the root within a bracket by the Illinois method.
    fn refine(&self, x: Vec3, n: Vec3, sign: f32, [mut a, mut b]: [f32; 2], [mut fa, mut fb]: [f32; 2]) -> f32 {
        for _ in 0..12 {
            if (b - a).abs() < 2e-6 || fa - fb < 1e-9 {
                break;
            }
            let c = a + (b - a) * (fa / (fa - fb));
            let fc = -sign * self.field(x + n * (sign * c));
            if fc > 0.0 {
                (a, fa) = (c, fc);
                fb *= 0.5;
            } else {
                (b, fb) = (c, fc);
                fa *= 0.5;
            }
            if fc.abs() < 2e-6 {
                return c;
            }
        }
        if fa - fb < 1e-9 { a } else { a + (b - a) * (fa / (fa - fb)) }
    }

    fn node(&self, x: Vec3, n: Vec3, bounds: [f32; 2]) -> Node {
        let distance = self.cross(x, n);
        let p = x + n * soft_limit(distance, bounds);
        let e = 3e-3;
        let d = |axis: Vec3| self.field(p + axis * e) - self.field(p - axis * e);
        let gradient = Vec3::new(d(Vec3::X), d(Vec3::Y), d(Vec3::Z)).normalize_or(n);
        let mouth = if p.x > 3.3 { 1.0 - ss(0.002, 0.014, self.sdf.mouth_distance(p)) } else { 0.0 };
        Node { distance, relief: ss(0.1, 0.6, gradient.dot(n)), mouth }
    }

    fn sample(&self, x: Vec3, n: Vec3, bounds: [f32; 2], node: &Node) -> Sample {
        let p = x + n * soft_limit(node.distance, bounds);
        let relief = self.skin.relief(p, node.mouth);
        let h = soft_limit(node.distance + relief.height * node.relief, bounds);
        let c = self.skin.shade(p, &relief, node.mouth);
        [h, c[0], c[1], c[2], c[3]]
    }

    fn exact(&self, x: Vec3, n: Vec3, bounds: [f32; 2]) -> Sample {
        self.sample(x, n, bounds, &self.node(x, n, bounds))
    }

    fn bounds_at(&self, patch: usize, uv: Vec2) -> [f32; 2] {
        let c = self.mesh.patches[patch].map(|v| self.bounds[v as usize]);
        let at = |k: usize| {
            let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
            lerp(lerp(c[0][k], c[1][k], uv.x), lerp(c[3][k], c[2][k], uv.x), uv.y)
        };
        [at(0), at(1)]
    }
}

/// Exact samples on vertices and edges. Each is evaluated once.
struct Borders {
    corners: Vec<Sample>,
    /// The samples of each edge, from the lower to the higher vertex.
    edges: Vec<Sample>,
    index: HashMap<[u32; 2], usize>,
    inner: usize,
}

/// The pairs of corners of the edges v=0, u=1, v=1 and u=0. Each pair is in the direction of increasing u or v.
const SIDES: [[usize; 2]; 4] = [[0, 1], [1, 2], [3, 2], [0, 3]];

fn side_uv(side: usize, s: f32) -> Vec2 {
    match side {
        0 => Vec2::new(s, 0.0),
        1 => Vec2::new(1.0, s),
        2 => Vec2::new(s, 1.0),
        _ => Vec2::new(0.0, s),
    }
}

impl Borders {
    fn new(baker: &Baker, inner: usize) -> Self {
        let mesh = baker.mesh;
        let corners = (0..mesh.positions.len())
            .into_par_iter()
            .map(|v| baker.exact(mesh.positions[v], mesh.normals[v], baker.bounds[v]))
            .collect();
        let mut index = HashMap::new();
        let mut owners = Vec::new();
        for (patch, quad) in mesh.patches.iter().enumerate() {
            for (side, [a, b]) in SIDES.iter().map(|s| s.map(|k| quad[k])).enumerate() {
                index.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    owners.push((patch, side, a > b));
                    owners.len() - 1
                });
            }
        }
        let edges = (0..owners.len() * inner)
            .into_par_iter()
            .with_min_len(64)
            .map(|i| {
                let (patch, side, reversed) = owners[i / inner];
                let s = ((i % inner) as f32 + 0.5) / inner as f32;
                let uv = side_uv(side, if reversed { 1.0 - s } else { s });
                let at = baker.patches[patch].at(uv);
                baker.exact(at.position, at.normal, baker.bounds_at(patch, uv))
            })
            .collect();
        Self { corners, edges, index, inner }
    }

    /// Returns sample `i` of a quad's side, along increasing u or v.
    fn edge(&self, quad: &[u32; 4], side: usize, i: usize) -> &Sample {
        let [a, b] = SIDES[side].map(|k| quad[k]);
        let start = self.index[&[a.min(b), a.max(b)]] * self.inner;
        &self.edges[start + if a > b { self.inner - 1 - i } else { i }]
    }
}

/// The weights of lattice nodes for a texel: the first node, the cubic weights, and the linear fraction.
struct Tap {
    first: usize,
    cubic: [f32; 4],
    fraction: f32,
}

fn taps(inner: usize, intervals: usize) -> Vec<Tap> {
    let tap = |i: usize| {
        let s = (i as f32 + 0.5) / inner as f32 * intervals as f32;
        let first = (s as usize).min(intervals - 1);
        let t = s - first as f32;
        let (t2, t3) = (t * t, t * t * t);
        let cubic =
            [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3];
        Tap { first, cubic, fraction: t }
    };
    (0..inner).map(tap).collect()
}

/// The lattice nodes of one tile, inside a ring of nodes whose distances are extrapolated linearly.
struct Lattice {
    nodes: Vec<Node>,
    padded: Vec<f32>,
    intervals: usize,
}

impl Lattice {
    fn new(baker: &Baker, patch: usize, intervals: usize) -> Self {
        let side = intervals + 1;
        let nodes: Vec<Node> = (0..side * side)
            .map(|i| {
                let uv = Vec2::new((i % side) as f32, (i / side) as f32) / intervals as f32;
                let at = baker.patches[patch].at(uv);
                baker.node(at.position, at.normal, baker.bounds_at(patch, uv))
            })
            .collect();
        let wide = side + 2;
        let mut padded = vec![0.0; wide * wide];
        for j in 0..side {
            for i in 0..side {
                padded[(j + 1) * wide + i + 1] = nodes[j * side + i].distance;
            }
            let row = (j + 1) * wide;
            padded[row] = 2.0 * padded[row + 1] - padded[row + 2];
            padded[row + wide - 1] = 2.0 * padded[row + wide - 2] - padded[row + wide - 3];
        }
        for i in 0..wide {
            padded[i] = 2.0 * padded[wide + i] - padded[2 * wide + i];
            let last = (wide - 1) * wide + i;
            padded[last] = 2.0 * padded[last - wide] - padded[last - 2 * wide];
        }
        Self { nodes, padded, intervals }
    }

    fn at(&self, u: &Tap, v: &Tap) -> Node {
        let wide = self.intervals + 3;
        let mut distance = 0.0;
        for (j, wv) in v.cubic.iter().enumerate() {
            let row = &self.padded[(v.first + j) * wide + u.first..][..4];
            distance += wv * (row[0] * u.cubic[0] + row[1] * u.cubic[1] + row[2] * u.cubic[2] + row[3] * u.cubic[3]);
        }
        let side = self.intervals + 1;
        let k = v.first * side + u.first;
        let n = [&self.nodes[k], &self.nodes[k + 1], &self.nodes[k + side], &self.nodes[k + side + 1]];
        let (low, high) = n.iter().fold((f32::MAX, f32::MIN), |(l, h), q| (l.min(q.distance), h.max(q.distance)));
        // Cubic interpolation would ring where the root jumps, for example into the mouth or under a lid.
        let slack = 0.25 * (high - low) + 1e-4;
        let blend = |f: fn(&Node) -> f32| {
            let bottom = f(n[0]) + (f(n[1]) - f(n[0])) * u.fraction;
            bottom + (f(n[2]) + (f(n[3]) - f(n[2])) * u.fraction - bottom) * v.fraction
        };
        Node {
            distance: distance.clamp(low - slack, high + slack),
            relief: blend(|q| q.relief),
            mouth: blend(|q| q.mouth),
        }
    }
}

/// Computes the samples of tile `patch`, including the gutter, row by row.
fn bake_tile(baker: &Baker, borders: &Borders, layout: &TileLayout, taps: &[Tap], patch: usize) -> Vec<Sample> {
    let (inner, gutter, size) = (layout.inner() as usize, layout.gutter as usize, layout.tile as usize);
    let intervals = intervals(inner);
    let lattice = Lattice::new(baker, patch, intervals);
    let quad = &baker.mesh.patches[patch];
    let mut tile = vec![[0.0; 5]; size * size];
    for j in 0..inner {
        for i in 0..inner {
            let uv = (Vec2::new(i as f32, j as f32) + 0.5) / inner as f32;
            let PatchPoint { position, normal, .. } = baker.patches[patch].at(uv);
            let node = lattice.at(&taps[i], &taps[j]);
            tile[(j + gutter) * size + i + gutter] = baker.sample(position, normal, baker.bounds_at(patch, uv), &node);
        }
    }
    let reflect = |about: &Sample, q: &Sample| std::array::from_fn(|k| 2.0 * about[k] - q[k]);
    let last = gutter + inner - 1;
    // The gutters to the right and left of the inner rows come first, and then the whole rows below and above.
    for j in 0..inner {
        let row = (j + gutter) * size;
        for k in 0..gutter {
            tile[row + gutter - 1 - k] = reflect(borders.edge(quad, 3, j), &tile[row + gutter + k]);
            tile[row + last + 1 + k] = reflect(borders.edge(quad, 1, j), &tile[row + last - k]);
        }
    }
    let corner = |k: usize| &borders.corners[quad[k] as usize];
    for side in [0, 2] {
        let edge = |i: usize| -> Sample {
            if i < gutter {
                reflect(corner(if side == 0 { 0 } else { 3 }), borders.edge(quad, side, gutter - 1 - i))
            } else if i > last {
                reflect(corner(if side == 0 { 1 } else { 2 }), borders.edge(quad, side, inner - 1 - (i - last - 1)))
            } else {
                *borders.edge(quad, side, i - gutter)
            }
        };
        for i in 0..size {
            let about = edge(i);
            for k in 0..gutter {
                let (to, from) = if side == 0 { (gutter - 1 - k, gutter + k) } else { (last + 1 + k, last - k) };
                tile[to * size + i] = reflect(&about, &tile[from * size + i]);
            }
        }
    }
    tile
}

/// Returns the number of lattice intervals along the edge of a tile. Fine tiles are interpolated between nodes.
fn intervals(inner: usize) -> usize {
    inner.min(20)
}

/// Bakes all tiles of `mesh` in `layout`. Returns the rows of the displacement along the patch normal in metres, and of the sRGB-encoded
/// albedo with linear Beckmann `α`. `progress` receives the completed fraction, from any thread.
///
/// The mesh must be in the bind pose, each of its edges must join two patches, and `layout` must have one tile per patch.
pub fn bake(
    sdf: &TrexSdf,
    skin: &Skin,
    mesh: &PatchMesh,
    layout: &TileLayout,
    progress: Progress<'_>,
) -> (Vec<f32>, Vec<[u8; 4]>) {
    let inner = layout.inner() as usize;
    let baker = Baker::new(sdf, skin, mesh);
    let borders = Borders::new(&baker, inner);
    let taps = taps(inner, intervals(inner));
    let done = AtomicUsize::new(0);
    let texels = fill_tiles(layout, mesh.patches.len(), |patch| {
        let samples = bake_tile(&baker, &borders, layout, &taps, patch);
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(count as f32 / mesh.patches.len() as f32);
        samples.into_iter().map(|[height, r, g, b, alpha]| (height, color_code([r, g, b], alpha))).collect()
    });
    texels.into_iter().unzip()
}
