//! The facets of a relief, and the material on them.

use glam::{DVec2, DVec3};

use super::axes::MaterialAxes;
use crate::derive::openness::{OpennessWindow, WindowFacet};
use crate::{HeightMap, MomentLevel, Moments, Wrap};

/// The facets of a relief.
#[derive(Clone, Copy, Debug)]
pub enum Facets<'a> {
    /// The triangles between the texels of a height map. A texel can contain facets of several classes.
    OfHeights(&'a HeightMap, Wrap),
    /// The texels of the finest level of a [`LeadrMap`](crate::LeadrMap), for slopes of a normal map or of a baked file.
    OfTexels(&'a MomentLevel, Wrap),
    /// A flat surface. Its only classes are those of its material.
    Flat,
}

/// The material on a relief, at texels of any resolution.
#[derive(Clone, Copy)]
pub struct ClassMaterial<'a> {
    /// The width and height in texels. Both are positive.
    pub size: [u32; 2],
    /// Returns the linear albedo and the Beckmann roughness `α` of a texel, by its index in row-major order.
    pub texel: &'a (dyn Fn(usize) -> [f32; 4] + Sync),
    /// Whether colours that follow the relief are found, such as paint on the tops or dirt in cracks.
    pub follows_relief: bool,
}

impl ClassMaterial<'_> {
    /// Returns the material at a texture coordinate.
    pub(super) fn at(&self, [s, t]: [f64; 2]) -> [f64; 4] {
        let [width, height] = self.size;
        let index = |v: f64, side: u32| (((v - v.floor()) * f64::from(side)) as u32).min(side - 1) as usize;
        (self.texel)(index(t, height) * width as usize + index(s, width)).map(f64::from)
    }
}

/// The mean slope and height of a facet, the slope covariance in the facet, and its material on [`MaterialAxes`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facet {
    pub point: DVec3,
    pub spread: DVec3,
    pub material: DVec2,
}

impl Facet {
    pub fn of_texel(texel: &Moments) -> Self {
        let [x, y] = texel.mean_slope.map(f64::from);
        let point = DVec3::new(x, y, texel.height.into());
        Self { point, spread: DVec3::from(texel.slope_covariance()), material: DVec2::ZERO }
    }
}

/// A cell between four texels: slopes along its upper and lower edge, and along its left and right edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub s: [f64; 2],
    pub t: [f64; 2],
    /// The heights of the upper and of the lower texels.
    heights: [[f64; 2]; 2],
}

/// The rows and columns of the corners of a cell, or of the quarters of a texel: row 0 is above, column 0 is left.
pub(crate) const CORNERS: [[usize; 2]; 4] = [[0, 0], [0, 1], [1, 0], [1, 1]];

impl Cell {
    pub fn new(heights: [[f32; 2]; 2], [width, height]: [f64; 2]) -> Self {
        let heights = heights.map(|row| row.map(f64::from));
        let [upper, lower] = heights;
        let along_t = |column: usize| (lower[column] - upper[column]) * height;
        Self { s: heights.map(|[left, right]| (right - left) * width), t: [along_t(0), along_t(1)], heights }
    }

    /// Returns the cells of a row, from the cell left of the first texel to the cell right of the last one. `y` is the row of the upper
    /// texels, and may be outside the map.
    pub fn row(map: &HeightMap, wrap: Wrap, y: i64) -> impl Iterator<Item = Self> {
        let width = map.width as usize;
        let row = |y: i64| &map.texels[wrap.texel(y, map.height) * width..][..width];
        let (upper, lower) = (row(y), row(y + 1));
        let size = [map.width, map.height].map(f64::from);
        let [before, after] = [-1, i64::from(map.width)].map(|x| wrap.texel(x, map.width));
        let column = move |x: usize| [upper[x], lower[x]];
        let columns = (0..width).chain([after]).map(column);
        let mut left = column(before);
        columns.map(move |right| {
            let cell = Self::new([[left[0], right[0]], [left[1], right[1]]], size);
            left = right;
            cell
        })
    }

    /// Returns the triangle on an edge, from 0 to 3: above, below, left and right. Its tip is at the centre of the cell. The slope across the
    /// edge is the mean of those along the two edges beside it.
    #[inline]
    pub fn facet(&self, edge: usize) -> Facet {
        let [[a, b], [c, d]] = self.heights;
        let (along_s, along_t) = (0.5 * (self.s[0] + self.s[1]), 0.5 * (self.t[0] + self.t[1]));
        let (s, t, ends) = match edge {
            0 => (self.s[0], along_t, a + b),
            1 => (self.s[1], along_t, c + d),
            2 => (along_s, self.t[0], a + c),
            _ => (along_s, self.t[1], b + d),
        };
        let middle = 0.25 * (a + b + c + d);
        Facet { point: DVec3::new(s, t, (ends + middle) / 3.0), ..Facet::default() }
    }

    /// Returns the edges whose triangles share the quarter of the cell at a corner equally.
    pub const fn of_quarter([row, column]: [usize; 2]) -> [usize; 2] {
        [row, 2 + column]
    }

    /// Returns the edge of the triangle at a position, from 0 to 1 along both sides of the cell.
    pub fn edge_at(position: DVec2) -> usize {
        let from_middle = position - 0.5;
        let along_s = from_middle.y.abs() > from_middle.x.abs();
        if along_s { usize::from(from_middle.y > 0.0) } else { 2 + usize::from(from_middle.x > 0.0) }
    }
}

/// A facet that stands for an equal part of the surface.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub facet: Facet,
    /// The number of the map or window of the heights, and the texture coordinate of the facet's centre there.
    pub window: usize,
    pub at: DVec2,
    /// The texture coordinate in the material.
    pub material_at: [f64; 2],
}

/// The fraction by which positions in successive parts of a list differ. No periodic pattern follows it.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

impl Facets<'_> {
    /// Returns the width and the height of the map in texels. Flat surfaces have the size of their material.
    pub(crate) fn size(&self, material: Option<&ClassMaterial<'_>>) -> [u32; 2] {
        match self {
            Self::OfHeights(map, _) => [map.width, map.height],
            Self::OfTexels(level, _) => [level.width, level.height],
            Self::Flat => material.map_or([1, 1], |material| material.size),
        }
    }

    /// Returns what surrounds the map.
    pub(crate) const fn wrap(&self) -> Wrap {
        match self {
            Self::OfHeights(_, wrap) | Self::OfTexels(_, wrap) => *wrap,
            Self::Flat => Wrap::Repeat,
        }
    }

    /// Returns at most this number of facets from all parts of the map.
    pub(super) fn sampled(&self, most: usize, material: Option<&ClassMaterial<'_>>) -> Vec<Sample> {
        let [width, height] = self.size(material).map(|side| side as usize);
        let of_texel = if matches!(self, Self::OfHeights(..)) { 4 } else { 1 };
        let count = of_texel * width * height;
        let sample = |i: usize| {
            let (x, y) = (i / of_texel % width, i / of_texel / width);
            let ([x, y], facet) = match self {
                Self::OfHeights(map, wrap) => {
                    let heights = [0, 1].map(|down| {
                        [0, 1].map(|right| map.beyond(x as i64 + right as i64, y as i64 + down as i64, *wrap))
                    });
                    let edge = i % 4;
                    // The centre of the triangle, relative to the centre of the cell.
                    let off = [[0.0, -1.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]][edge].map(|side| side / 3.0);
                    let centre = [x as f64 + 1.0 + off[0], y as f64 + 1.0 + off[1]];
                    (centre, Cell::new(heights, [map.width, map.height].map(f64::from)).facet(edge))
                }
                Self::OfTexels(level, _) => ([x, y].map(|k| k as f64 + 0.5), Facet::of_texel(&level.texels[i])),
                Self::Flat => ([x, y].map(|k| k as f64 + 0.5), Facet::default()),
            };
            let at = [x / width as f64, y / height as f64];
            Sample { facet, window: 0, at: DVec2::from(at), material_at: at }
        };
        spread(count, most).map(sample).collect()
    }
}

/// Returns at most this number of facets from all windows.
pub(super) fn sampled_of_windows(windows: &[OpennessWindow], most: usize) -> Vec<Sample> {
    let all = |(window, of): (usize, &'_ OpennessWindow)| {
        let sample = move |WindowFacet { at, moments, material_at }: &WindowFacet| Sample {
            facet: Facet::of_texel(moments),
            window,
            at: DVec2::from(*at),
            material_at: *material_at,
        };
        of.facets.iter().map(sample).collect::<Vec<_>>()
    };
    let all: Vec<Sample> = windows.iter().enumerate().flat_map(all).collect();
    spread(all.len(), most).map(|i| all[i]).collect()
}

/// Returns at most this number of indices, one in each of equal parts of a list.
fn spread(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let parts = most.min(count);
    (0..parts).map(move |part| {
        let [first, end] = [part, part + 1].map(|part| (part as u64 * count as u64 / parts as u64) as usize);
        first + ((part as f64 * GOLDEN_RATIO).fract() * (end - first) as f64) as usize
    })
}

/// The facets of rows of texels, for lookups by texture coordinate.
pub(crate) struct FacetsAt<'a> {
    facets: Facets<'a>,
    cells: Vec<Cell>,
    /// The row of texels, and whether the coordinate is in its lower half.
    row: (usize, usize),
}

impl<'a> FacetsAt<'a> {
    /// Prepares lookups in a row of the map. `t` is from 0 to 1.
    pub fn new(facets: Facets<'a>, t: f64) -> Self {
        let [_, height] = facets.size(None);
        let row = half_of(t, height);
        let cells = match facets {
            Facets::OfHeights(map, wrap) => Cell::row(map, wrap, row.0 as i64 - 1 + row.1 as i64).collect(),
            _ => Vec::new(),
        };
        Self { facets, cells, row }
    }

    /// Calls a function with the weight and the facet of everything at a texture coordinate in the row. The weights sum to 1.
    pub fn for_each(&self, s: f64, mut f: impl FnMut(f64, Facet)) {
        match self.facets {
            Facets::OfHeights(map, _) => {
                let ((x, right), (_, below)) = (half_of(s, map.width), self.row);
                let cell = &self.cells[x + right];
                for edge in Cell::of_quarter([1 - below, 1 - right]) {
                    f(0.5, cell.facet(edge));
                }
            }
            Facets::OfTexels(level, _) => {
                let (x, _) = half_of(s, level.width);
                f(1.0, Facet::of_texel(&level.texels[self.row.0 * level.width as usize + x]));
            }
            Facets::Flat => f(1.0, Facet::default()),
        }
    }
}

/// Returns the texel at a coordinate from 0 to 1, and 1 in its second half.
fn half_of(v: f64, side: u32) -> (usize, usize) {
    let half = ((v * f64::from(2 * side)) as usize).min(2 * side as usize - 1);
    (half / 2, half % 2)
}

/// The rule that gives the material of facets.
#[derive(Clone, Copy)]
pub(crate) struct MaterialAt<'a> {
    pub axes: MaterialAxes,
    pub material: Option<&'a ClassMaterial<'a>>,
}

impl MaterialAt<'_> {
    /// Returns the material at a texture coordinate. The result is zero if classes do not depend on the material.
    pub fn at(&self, at: [f64; 2]) -> DVec2 {
        match self.material {
            Some(material) if !self.axes.is_none() => self.axes.of(material.at(at)),
            _ => DVec2::ZERO,
        }
    }

    /// Whether classes depend on the material.
    pub const fn varies(&self) -> bool {
        self.material.is_some() && !self.axes.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_of_any_period_have_their_shares() {
        for period in 2..=12_u32 {
            // One column of every few is higher, so two of as many columns of cells have slopes.
            let size = 24 * period;
            let texels = (0..size * size).map(|i| f32::from(u8::from((i % size).is_multiple_of(period)))).collect();
            let map = HeightMap { width: size, height: size, texels };
            let sampled = Facets::OfHeights(&map, Wrap::Repeat).sampled(4096, None);
            let steep = sampled.iter().filter(|sample| sample.facet.point.x != 0.0).count();
            let (share, truth) = (steep as f64 / sampled.len() as f64, 2.0 / f64::from(period));
            assert!((share - truth).abs() < 0.02, "{period}: {share} of {truth}");
        }
    }
}
