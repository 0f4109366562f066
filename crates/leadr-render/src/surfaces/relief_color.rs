//! Colours that follow the relief, such as paint on the tops, dirt in the cracks, or snow on slopes that face one way
//! ([`relief_color`](leadr_reflectance::visible::relief_color)).
//!
//! Two layers of an image hold mean colours that are weighted by height rank, with the weight in alpha. Two more layers hold colour
//! times slope, with the slope in alpha. The layers for slopes need a single chart, because each tile of an atlas has its own axes.
//! The layers only matter for pixels that cover several bumps, so for large maps the image begins at a coarser level than the
//! colours.

use glam::DVec3;
use half::f16;
use rayon::prelude::*;

use super::displacement::{Border, HeightField};
use crate::constants::SOURCE_LEVEL;
use crate::scene::{MaterialMap, Object};
use leadr_maps::srgb::linear_of_srgb8;
use leadr_reflectance::visible::relief_color::height_weights;

/// Which properties of the relief an object's colours follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Follows {
    /// Whether the colours follow the heights.
    pub heights: bool,
    /// Whether the colours follow the slopes.
    pub slopes: bool,
}

impl Follows {
    /// Returns the number of layers of weighted means.
    pub const fn layers(self) -> u32 {
        2 * (self.heights as u32 + self.slopes as u32)
    }

    /// Whether the colours follow any property of the relief.
    pub const fn any(self) -> bool {
        self.heights || self.slopes
    }
}

/// The maximum side of an image of weighted colours, in texels. For larger colour maps, the image starts at a coarser level.
const MOST_TEXELS: u32 = 2048;
/// The number of texels along one side that are sampled to detect the correlation.
const SAMPLED: u32 = 256;
/// The smallest significant change of the mean colour, relative to the mean of the brightest channel. The value is half the
/// smallest difference that is visible side by side. For heights, the change is from no hidden facets to half of the facets hidden.
/// For slopes, it is the change for a shift by one standard deviation.
const LEAST_CHANGE: f64 = 0.01;
/// The number of intervals in the table of height ranks.
const RANKS: usize = 2048;

/// Returns how many of the finest colour levels have no weighted means. In an atlas, the number is at most the source mip of the
/// coarse levels.
pub(super) fn skipped_levels(map: &MaterialMap, border: Border) -> u32 {
    let most = if matches!(border, Border::Tiles(_)) { SOURCE_LEVEL } else { u32::MAX };
    let mut skipped = 0;
    while map.width.max(map.height) >> skipped > MOST_TEXELS && skipped < most {
        skipped += 1;
    }
    skipped
}

/// The height ranks and the slopes of an object, at the texels of its colours.
pub(super) struct ReliefColors<'a> {
    field: &'a HeightField,
    map: &'a MaterialMap,
    slopes: Option<&'a [[f32; 2]]>,
    /// The heights at uniform steps of the height rank.
    table: Vec<f32>,
    /// Whether the height scale is negative. The lowest heights are then on top.
    upside_down: bool,
    linear: [f32; 256],
    /// The relief properties that the colours follow.
    pub follows: Follows,
}

impl<'a> ReliefColors<'a> {
    /// Returns the relief colours of an object. The object must have heights and colours, and must still hold their texels.
    pub fn of(object: &'a Object) -> Option<Self> {
        let (field, map) = (object.heights.as_ref()?, object.material.as_ref()?);
        // With charts, the colours have different texture coordinates from the heights.
        if !object.follows_relief
            || object.charts.is_some()
            || field.map.texels.is_empty()
            || map.colors.len() != map.width as usize * map.height as usize
        {
            return None;
        }
        let mut colors = Self {
            field,
            map,
            slopes: object.slopes.as_deref(),
            table: Vec::new(),
            upside_down: object.height_scale < 0.0,
            linear: linear_of_srgb8(),
            follows: Follows::default(),
        };
        let texels: Vec<[u32; 2]> = {
            let steps = |side: u32| side.div_ceil(SAMPLED).max(1);
            let (across, down) = (steps(map.width) as usize, steps(map.height) as usize);
            let rows = (0..map.height).step_by(down);
            rows.flat_map(|y| (0..map.width).step_by(across).map(move |x| [x, y])).collect()
        };
        let mut heights: Vec<f32> = texels.iter().map(|&position| colors.height(position)).collect();
        heights.sort_unstable_by(f32::total_cmp);
        let last = heights.len() - 1;
        if heights[0] == heights[last] || colors.map.colors.iter().all(|c| c[..3] == colors.map.colors[0][..3]) {
            return None;
        }
        colors.table = (0..=RANKS).map(|i| heights[(i * last + RANKS / 2) / RANKS]).collect();
        colors.follows = colors.found(&texels, matches!(field.border, Border::Tiles(_)));
        Some(colors)
    }

    fn found(&self, texels: &[[u32; 2]], tiled: bool) -> Follows {
        let count = texels.len() as f64;
        let (mut mean, mut low, mut weight) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let (mut slope, mut square, mut joint) = ([0.0; 2], [0.0; 2], [DVec3::ZERO; 2]);
        for &texel in texels {
            let color = DVec3::from(self.color(texel).map(f64::from)) / count;
            let by_height = height_weights(self.rank(texel))[0];
            weight += by_height / count;
            mean += color;
            low += by_height * color;
            for (axis, g) in self.gradient(texel).map(f64::from).into_iter().enumerate() {
                slope[axis] += g / count;
                square[axis] += g * g / count;
                joint[axis] += g * color;
            }
        }
        let least = LEAST_CHANGE * mean.max_element();
        let heights = (low / weight - mean).abs().max_element() > least;
        let slopes = [0, 1].into_iter().any(|axis| {
            let deviation = (square[axis] - slope[axis] * slope[axis]).max(0.0).sqrt();
            (joint[axis] - mean * slope[axis]).abs().max_element() > least * deviation
        });
        Follows { heights, slopes: slopes && !tiled }
    }

    /// Returns the height texel that lies under a colour texel.
    fn texel(&self, [x, y]: [u32; 2]) -> [u32; 2] {
        let of = |i: u32, n: u32, to: u32| ((u64::from(2 * i + 1) * u64::from(to)) / u64::from(2 * n)) as u32;
        [of(x, self.map.width, self.field.map.width), of(y, self.map.height, self.field.map.height)]
    }

    fn height(&self, position: [u32; 2]) -> f32 {
        let [x, y] = self.texel(position);
        self.field.map.texels[y as usize * self.field.map.width as usize + x as usize]
    }

    fn color(&self, [x, y]: [u32; 2]) -> [f32; 3] {
        let [r, g, b, _] = self.map.colors[y as usize * self.map.width as usize + x as usize];
        [r, g, b].map(|code| self.linear[usize::from(code)])
    }

    /// Returns the rank of a height from 0 to 1, which is the fraction of heights that are lower.
    fn rank(&self, position: [u32; 2]) -> f64 {
        let height = self.height(position);
        let above = self.table.partition_point(|&h| h <= height);
        let below = self.table.partition_point(|&h| h < height);
        let rank = if above > below {
            // If several heights are equal, the rank is the middle of their ranks.
            0.5 * (above + below - 1) as f64
        } else {
            let (at, end) = (below.max(1), self.table.len() - 1);
            let (low, high) = (self.table[at - 1], self.table[at.min(end)]);
            (at - 1) as f64 + f64::from((height - low) / (high - low).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0)
        };
        let rank = (rank / RANKS as f64).clamp(0.0, 1.0);
        if self.upside_down { 1.0 - rank } else { rank }
    }

    /// Returns the slope in height units per unit of texture coordinate.
    fn gradient(&self, position: [u32; 2]) -> [f32; 2] {
        let [x, y] = self.texel(position);
        let (width, height) = (self.field.map.width, self.field.map.height);
        if let Some(slopes) = self.slopes {
            return slopes[y as usize * width as usize + x as usize];
        }
        let wraps = self.field.border == Border::Wrap;
        let beside = |i: u32, n: u32| {
            if wraps { [(i + n - 1) % n, (i + 1) % n] } else { [i.saturating_sub(1), (i + 1).min(n - 1)] }
        };
        let at = |x: u32, y: u32| self.field.map.texels[y as usize * width as usize + x as usize];
        let ([left, right], [above, below]) = (beside(x, width), beside(y, height));
        [(at(right, y) - at(left, y)) * 0.5 * width as f32, (at(x, below) - at(x, above)) * 0.5 * height as f32]
    }

    /// Returns the texels of a layer. Each texel is a weighted colour, with the weight in alpha. Layers of heights, if any, precede
    /// layers of slopes. `size` is at most the size of the colours.
    pub fn layer(&self, layer: u32, size: [u32; 2]) -> Vec<[f32; 4]> {
        let by_height = self.follows.heights && layer < 2;
        let which = (layer % 2) as usize;
        let most = f16::MAX.to_f32();
        let weighted = |position: [u32; 2]| {
            let weight = if by_height {
                height_weights(self.rank(position))[which] as f32
            } else {
                self.gradient(position)[which].clamp(-most, most)
            };
            let [r, g, b] = self.color(position).map(|channel| channel * weight);
            [r, g, b, weight]
        };
        let part = |i: u32, to: u32, of: u32| {
            let begin = |i: u32| (u64::from(i) * u64::from(of) / u64::from(to)) as u32;
            begin(i)..begin(i + 1)
        };
        let row = |y: u32| {
            let weighted = &weighted;
            (0..size[0]).map(move |x| {
                let (across, down) = (part(x, size[0], self.map.width), part(y, size[1], self.map.height));
                let share = 1.0 / (across.len() * down.len()) as f32;
                let texels = down.flat_map(|y| across.clone().map(move |x| [x, y]));
                texels.fold([0.0; 4], |sum, position| {
                    let texel = weighted(position);
                    std::array::from_fn(|i| sum[i] + share * texel[i])
                })
            })
        };
        (0..size[1]).into_par_iter().flat_map_iter(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::patch_mesh::PatchMesh;
    use leadr_maps::HeightMap;

    fn painted(paint: impl Fn(f32, f32) -> bool) -> Object {
        // Heights rise and fall along x. `paint` selects colours by height and direction of slope.
        let heights: Vec<f32> = (0..64 * 64).map(|i| ((i % 64) as f32 * 0.2).sin() + (i / 64) as f32 * 0.01).collect();
        let colors = heights.iter().enumerate().map(|(i, &h)| {
            let rise = ((i % 64) as f32 * 0.2).cos();
            if paint(h, rise) { [200, 20, 20, 128] } else { [100, 100, 100, 128] }
        });
        let map = MaterialMap::new(64, 64, colors.collect());
        let field = HeightField { map: HeightMap { width: 64, height: 64, texels: heights }, border: Border::Clamp };
        Object::new("painted", PatchMesh::default()).with_heights(field, 1.0).with_material(map).with_relief_color()
    }

    #[test]
    fn only_colours_that_follow_the_relief_are_found() {
        let follows = |object: &Object| ReliefColors::of(object).map_or(Follows::default(), |colors| colors.follows);
        assert!(follows(&painted(|h, _| h > 0.5)).heights);
        assert!(follows(&painted(|_, rise| rise > 0.0)).slopes);
        assert!(!follows(&painted(|_, _| true)).any());
        assert!(!follows(&Object { material: None, ..painted(|h, _| h > 0.5) }).any());
        assert!(!follows(&Object { follows_relief: false, ..painted(|h, _| h > 0.5) }).any());
    }

    #[test]
    fn ranks_run_from_bottom_to_top() {
        let object = painted(|h, _| h > 0.0);
        let colors = ReliefColors::of(&object).unwrap();
        let ranks: Vec<f64> = (0..64 * 64).map(|i| colors.rank([i % 64, i / 64])).collect();
        let mean = ranks.iter().sum::<f64>() / ranks.len() as f64;
        let square = ranks.iter().map(|u| u * u).sum::<f64>() / ranks.len() as f64;
        assert!((mean - 0.5).abs() < 2e-3 && (square - 1.0 / 3.0).abs() < 2e-3, "{mean} {square}");
        let inverted = Object { height_scale: -1.0, ..object.clone() };
        let inverted = ReliefColors::of(&inverted).unwrap();
        assert!((inverted.rank([5, 9]) - (1.0 - colors.rank([5, 9]))).abs() < 1e-12);
    }
}
