//! The shadow casters as columns of solid matter, which occlude the environment. The columns are coarse, contain no bumps, and are
//! recomputed for every frame.

use glam::{Vec2, Vec3};

/// The number of columns along the longer side of the casters.
const COLUMNS: f32 = 64.0;
/// The maximum number of spans of matter in a column. Further spans are merged into the lowest span.
const MOST_SPANS: usize = 4;

/// The bottom and top of a span of matter.
pub type Span = [f32; 2];

/// Vertical columns over the world's xy plane. Each column stores where its axis is inside matter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// The corner of the first column.
    pub origin: Vec2,
    /// The width of a column in metres.
    pub cell: f32,
    /// The numbers of columns along x and y.
    pub size: [usize; 2],
    /// The lowest bottom and the highest top of all matter.
    pub height: Span,
    spans: Vec<[Span; MOST_SPANS]>,
}

/// The empty span, whose bottom is above its top.
const EMPTY: Span = [f32::INFINITY, f32::NEG_INFINITY];

impl Columns {
    /// Returns columns through the solids that these triangles enclose. The triangles run counter-clockwise seen from outside. An
    /// open surface becomes as thick as a column is wide, plus twice the depth of its bumps, so that the bumps lie within it.
    /// `relief` is the depth of the deepest bump in metres. Returns `None` without triangles.
    pub fn of(triangles: impl Iterator<Item = [Vec3; 3]> + Clone, relief: f32) -> Option<Self> {
        let (low, high) = triangles
            .clone()
            .flatten()
            .filter(|p| p.is_finite())
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        if !low.is_finite() {
            return None;
        }
        let extent = (high - low).truncate();
        let cell = (extent.max_element() / COLUMNS).max(1e-4 * (high.z - low.z)).max(1e-6);
        let size = [extent.x, extent.y].map(|side| (side / cell).ceil().clamp(1.0, COLUMNS) as usize);
        let mut columns = Self { origin: low.truncate(), cell, size, height: [low.z, high.z], spans: Vec::new() };
        let mut crossings = vec![Vec::new(); size[0] * size[1]];
        for triangle in triangles.filter(|triangle| triangle.iter().all(|p| p.is_finite())) {
            columns.cross(triangle, &mut crossings);
        }
        let thin = cell + 2.0 * relief;
        columns.spans = crossings.into_iter().map(|crossings| spans(crossings, thin)).collect();
        Some(columns)
    }

    /// Adds the points where a triangle intersects the column axes. Each point also stores whether the triangle faces up.
    fn cross(&self, triangle: [Vec3; 3], crossings: &mut [Vec<(f32, bool)>]) {
        // Positions are measured in columns, relative to the axis of the first column.
        let [a, b, c] = triangle.map(|p| ((p.truncate() - self.origin) / self.cell - 0.5).extend(p.z));
        let twice = (b - a).truncate().perp_dot((c - a).truncate());
        if twice == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f32, high: f32, size: usize| {
            let last = high.floor().min(size as f32 - 1.0);
            let first = low.ceil().max(0.0);
            if first > last { 0..0 } else { first as usize..last as usize + 1 }
        };
        for y in range(low.y, high.y, self.size[1]) {
            for x in range(low.x, high.x, self.size[0]) {
                let p = Vec2::new(x as f32, y as f32);
                let part = |from: Vec3, to: Vec3| (to - from).truncate().perp_dot(p - from.truncate()) / twice;
                let (of_c, of_a) = (part(a, b), part(b, c));
                let of_b = 1.0 - of_a - of_c;
                if of_a.min(of_b).min(of_c) >= 0.0 {
                    crossings[y * self.size[0] + x].push((of_a * a.z + of_b * b.z + of_c * c.z, twice > 0.0));
                }
            }
        }
    }

    /// Returns the spans of matter at a position, from the top down. There are none outside the columns.
    pub fn spans_at(&self, position: Vec2) -> impl Iterator<Item = Span> + use<'_> {
        let at = ((position - self.origin) / self.cell).floor();
        let inside = at.cmpge(Vec2::ZERO).all() && at.x < self.size[0] as f32 && at.y < self.size[1] as f32;
        let index = if inside { at.y as usize * self.size[0] + at.x as usize } else { usize::MAX };
        self.spans.get(index).into_iter().flatten().copied().take_while(|span| span[0] <= span[1])
    }

    /// Whether a point is inside matter.
    pub fn is_solid(&self, position: Vec3) -> bool {
        self.spans_at(position.truncate()).any(|[low, high]| low <= position.z && position.z <= high)
    }
}

/// Returns the spans of matter that lie between the intersections of a column.
fn spans(mut crossings: Vec<(f32, bool)>, thin: f32) -> [Span; MOST_SPANS] {
    crossings.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut spans, mut count, mut inside) = ([EMPTY; MOST_SPANS], 0usize, false);
    for (z, up) in crossings {
        match (up, inside) {
            (true, false) => {
                if count < MOST_SPANS {
                    count += 1;
                    spans[count - 1][1] = z;
                }
                // The end of the span is provisional, until a lower intersection sets it.
                spans[count - 1][0] = z - thin;
                inside = true;
            }
            // A surface inside a solid does not end the span.
            (true, true) => {}
            (false, true) => {
                spans[count - 1][0] = z;
                inside = false;
            }
            // Either several solids end here, or a solid has no top.
            (false, false) if count > 0 => spans[count - 1][0] = z,
            (false, false) => {
                (count, spans[0]) = (1, [z, z + thin]);
            }
        }
    }
    spans
}

#[cfg(test)]
pub(super) mod tests {
    use std::f32::consts::{PI, TAU};

    use super::*;

    /// Returns the triangles of a sphere.
    pub fn ball(centre: Vec3, radius: f32) -> Vec<[Vec3; 3]> {
        let (around, up) = (32, 16);
        let at = |i: u32, j: u32| {
            let (angle, polar) = (i as f32 / around as f32 * TAU, (j as f32 / up as f32 - 0.5) * PI);
            centre + (Vec2::from_angle(angle) * polar.cos()).extend(polar.sin()) * radius
        };
        let quad = |i: u32, j: u32| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..around * up).flat_map(|k| quad(k % around, k / around)).collect()
    }

    #[test]
    fn columns_hold_the_matter_of_spheres() {
        let mut triangles = ball(Vec3::new(1.0, 2.0, 0.5), 0.5);
        triangles.extend(ball(Vec3::new(1.0, 2.0, 3.0), 1.0));
        let columns = Columns::of(triangles.into_iter(), 0.0).unwrap();
        let spans: Vec<Span> = columns.spans_at(Vec2::new(1.01, 2.01)).collect();
        assert_eq!(spans.len(), 2, "{spans:?}");
        for (span, want) in spans.iter().zip([[2.0, 4.0], [0.0, 1.0]]) {
            assert!((span[0] - want[0]).abs() < 0.02 && (span[1] - want[1]).abs() < 0.02, "{span:?}");
        }
        assert!(columns.is_solid(Vec3::new(1.0, 2.0, 3.5)) && !columns.is_solid(Vec3::new(1.0, 2.0, 1.5)));
        assert!(columns.spans_at(Vec2::new(9.0, 2.0)).next().is_none());
        assert_eq!(Columns::of(std::iter::empty(), 0.0), None);
    }

    #[test]
    fn open_and_nested_surfaces_are_solids() {
        let plate = |z: f32, up: bool| {
            let (a, b, c, d) = (Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y);
            let t = |p: [Vec2; 3]| p.map(|p| p.extend(z));
            if up { [t([a, b, c]), t([a, c, d])] } else { [t([a, c, b]), t([a, d, c])] }
        };
        let over = |triangles: &[[Vec3; 3]], relief: f32| -> Vec<Span> {
            Columns::of(triangles.iter().copied(), relief).unwrap().spans_at(Vec2::new(0.4, 0.7)).collect()
        };
        let at = |triangles: &[[Vec3; 3]]| over(triangles, 0.0);
        let thin = 1.0 / COLUMNS;
        assert_eq!(at(&plate(2.0, true)), [[2.0 - thin, 2.0]]);
        assert_eq!(at(&plate(2.0, false)), [[2.0, 2.0 + thin]]);
        assert_eq!(over(&plate(2.0, true), 0.25), [[1.5 - thin, 2.0]]);
        let nested = [plate(3.0, true), plate(2.0, true), plate(1.5, false), plate(1.0, false)].concat();
        assert_eq!(at(&nested), [[1.0, 3.0]]);
    }
}
