//! The baking loop, which passes bands of rows through the mip pyramid into a file.

use glam::{DVec2, DVec3};
use half::f16;
use leadr_reflectance::slopes::moments::SlopeMoments;
use leadr_reflectance::slopes::packing::pack_clean_conservative;
use rayon::prelude::*;

use super::blocks::{self, BlockPlan};
use super::classes::ClassPlan;
use super::keys::packed;
use super::kind::{HEIGHT_REST, OIIO_CHANNELS};
use super::normals::{self, GlossOfShortening};
use super::{
    CLASS_CHANNELS, FoundClasses, Inputs, Kind, Layout, LevelError, Precision, Report, channels_before_classes,
};
use crate::halves::{self, half};
use crate::pyramid::{Pyramid, Row, level_sizes};
use crate::{HeightMap, MapFault, Wrap, bc5};

const BAND: u32 = 64;
const SIDE: u32 = bc5::SIDE as u32;
/// The maximum slope that the power-of-two factors aim at in 16-bit floats. The square of a slope then stays far below the
/// format's maximum of 65504.
const FULL_SLOPE: f64 = 128.0;
/// The maximum height, `α²` and `α⁴` that the power-of-two factors aim at in 16-bit floats.
const FULL_VALUE: f64 = 16384.0;

/// The description of the baked map that is written to the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The kind of map.
    pub kind: Kind,
    /// The channel layout.
    pub layout: Layout,
    /// The number format.
    pub precision: Precision,
    /// The width and height of the inputs in texels.
    pub size: [u32; 2],
    /// The number of finest levels that the file leaves out.
    pub dropped_levels: usize,
    /// The names of the channels.
    pub channels: Vec<&'static str>,
    /// The power-of-two factor by which the file multiplies each channel.
    pub factors: Vec<f64>,
    /// The factor that multiplies the input heights.
    pub height_scale: f32,
    /// The height that lies at the mesh surface: the mean height times the height factor.
    pub middle: f32,
    /// Whether heights are in texture widths, instead of the unit of the height map.
    pub in_widths: bool,
    /// How texels outside the map are addressed.
    pub wrap: Wrap,
    pub(super) has_heights: bool,
    pub(super) has_normals: bool,
    /// The conversion from the length of a mean normal to gloss, for kind gloss.
    pub(super) gloss: Option<GlossOfShortening>,
    pub(super) blocks: Option<BlockPlan>,
    /// The centres and units of the classes, if the map has several.
    pub(super) classes: Option<ClassPlan>,
}

/// A file that receives the baked rows.
pub trait Target {
    /// Takes the next rows of a level. Channels are interleaved and multiplied by [`Plan::factors`].
    ///
    /// # Errors
    /// Fails if the rows cannot be written.
    fn rows(&mut self, level: usize, first: u32, rows: &[Vec<f32>]) -> Result<(), MapFault>;

    /// Takes the next row of blocks of each layer of a level. Only targets for block-compressed files implement the method.
    ///
    /// # Errors
    /// Fails if the blocks cannot be written, or if the file is not block-compressed.
    fn blocks(&mut self, _level: usize, _row: u32, _layers: &[Vec<u8>]) -> Result<(), MapFault> {
        Err(MapFault::unsupported("this file format cannot hold blocks", "write a .ktx2 file"))
    }
}

impl Plan {
    /// Plans the bake of `inputs`.
    ///
    /// # Errors
    /// Fails if both heights and normals are missing, if sizes differ, or if the layout has no channels for an input.
    pub fn new(inputs: &Inputs, kind: Kind, layout: Layout, precision: Precision) -> Result<Self, MapFault> {
        let size = inputs.size()?;
        if layout == Layout::Oiio && (kind != Kind::Leadr || inputs.roughness.is_some() || inputs.color.is_some()) {
            let what = "the layout oiio holds only the moments of slopes and heights";
            let remedy = "bake kind leadr without roughness and colour, or use the layout leadr";
            return Err(MapFault::unsupported(what, remedy));
        }
        let mut channels = if layout == Layout::Oiio { OIIO_CHANNELS.to_vec() } else { kind.channels().to_vec() };
        if inputs.roughness.is_some() && kind.stores_variance() {
            channels.extend(["alpha2", "alpha4"]);
        }
        if inputs.color.is_some() && kind.has_color() {
            channels.extend(["red", "green", "blue"]);
        }
        let has_heights = inputs.heights.is_some() && channels.contains(&"height");
        if precision == Precision::F16 && layout == Layout::Leadr && has_heights {
            channels.push(HEIGHT_REST);
        }
        let classes = inputs.classes.as_ref().filter(|found| kind == Kind::Leadr && found.count() > 1);
        if let Some(found) = classes {
            if layout == Layout::Oiio {
                let what = "the layout oiio holds no classes";
                return Err(MapFault::unsupported(what, "bake one class, or use the layout leadr"));
            }
            channels.extend(CLASS_CHANNELS[..found.count()].as_flattened());
        }
        // Normals give heights in texture widths. A height map without normals keeps its own unit.
        let height_scale = inputs.usual_height_scale();
        let mut plan = Self {
            kind,
            layout,
            precision,
            size,
            dropped_levels: 0,
            factors: vec![1.0; channels.len()],
            channels,
            height_scale,
            middle: inputs.heights.as_ref().map_or(0.0, HeightMap::mean) * height_scale,
            in_widths: inputs.height_scale.is_some() || inputs.normals.is_some(),
            wrap: inputs.wrap,
            has_heights: has_heights || layout == Layout::Oiio && inputs.heights.is_some(),
            has_normals: inputs.normals.is_some(),
            gloss: (kind == Kind::Gloss).then(|| GlossOfShortening::new(inputs.gloss, inputs.area)),
            blocks: None,
            classes: classes.map(FoundClasses::plan),
        };
        match precision {
            Precision::F16 if layout == Layout::Leadr => {
                plan.fill_half_floats(inputs.bounds(height_scale.into()), inputs.roughest())
            }
            Precision::Bc if layout == Layout::Oiio => {
                let what = "the layout oiio is an EXR, which cannot hold blocks";
                return Err(MapFault::unsupported(what, "use the format f16 or the layout leadr"));
            }
            Precision::Bc => plan.blocks = Some(BlockPlan::new(kind, &plan.channels, &plan.block_ranges(inputs))),
            _ => {}
        }
        Ok(plan)
    }

    /// Leaves out the `count` finest levels, so that the file is about `4^count` times smaller. The other levels do not change: their
    /// moments include the slopes of the levels that are left out (Dupuy 2015, section 5.1).
    ///
    /// # Errors
    /// Fails if no level would remain, or if the layout gives slopes per texel of the finest level.
    pub fn without_levels(self, count: usize) -> Result<Self, MapFault> {
        if self.layout == Layout::Oiio && count > 0 {
            let what = "the layout oiio holds slopes per texel of the finest level, which must be there";
            return Err(MapFault::unsupported(what, "drop no levels, or use the layout leadr"));
        }
        let [width, height] = self.size;
        let most = level_sizes(self.size).len() - 1;
        if count > most {
            let what = format!("a map of {width} x {height} texels has no level {count}");
            return Err(MapFault::unsupported(what, format!("drop at most {most} levels")));
        }
        Ok(Self { dropped_levels: count, ..self })
    }

    /// Returns the sizes of the levels in the file, largest first.
    pub fn level_sizes(&self) -> Vec<[u32; 2]> {
        level_sizes(self.size).split_off(self.dropped_levels)
    }

    /// Returns the number of classes that the file stores.
    pub fn stored_classes(&self) -> usize {
        self.classes.as_ref().map_or(1, |classes| classes.frame.centers.len())
    }

    /// Returns the number of bytes of a texel in memory, in layers of the file. EXR files have one layer per channel, and compress.
    pub fn bytes_per_texel(&self) -> usize {
        match &self.blocks {
            // A block of two channels has as many bytes as texels.
            Some(blocks) => blocks.layers(),
            None if self.channels.len() <= 2 => self.channels.len() * self.precision.bytes(),
            None => packed(&self.channels).len() * self.precision.bytes(),
        }
    }

    /// Returns the number of values of a texel in the pyramid. A level of kind clean-conservative is made of all second moments.
    fn pyramid_channels(&self) -> usize {
        self.channels.len() + if self.kind == Kind::CleanConservative { 2 } else { 0 }
    }

    /// Sets the power-of-two factors, which bring the steepest slope, the greatest height and the largest roughness near the
    /// maximum of 16-bit floats.
    fn fill_half_floats(&mut self, [slope, height]: [f64; 2], alpha: f64) {
        let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
        let slope = if self.kind == Kind::Leadr { slope } else { slope * aspect.max(1.0) };
        let factor = |full: f64, most: f64| {
            if most > 0.0 { (full / most).log2().floor().clamp(-60.0, 60.0).exp2() } else { 1.0 }
        };
        let (slope, height) = (factor(FULL_SLOPE, slope), factor(FULL_VALUE, height));
        for channel in 0..self.kind.channels().len() {
            self.factors[channel] = self.kind.power(channel).map_or(height, |power| slope.powi(power));
        }
        for (name, power) in [("alpha2", 2), ("alpha4", 4)] {
            if let Some(channel) = self.channels.iter().position(|other| *other == name) {
                self.factors[channel] = factor(FULL_VALUE, alpha.powi(power));
            }
        }
        if let Some((height, rest)) = self.height_and_rest() {
            self.factors[rest] = self.factors[height];
        }
    }

    /// Returns the channel indices of the height and of its 16-bit residual, if the file has both.
    fn height_and_rest(&self) -> Option<(usize, usize)> {
        let rest = self.channels.iter().position(|name| *name == HEIGHT_REST)?;
        Some((self.kind.channels().len() - 1, rest))
    }

    /// Returns the value range of each channel that is stored in blocks.
    fn block_ranges(&self, inputs: &Inputs) -> Vec<[f32; 2]> {
        let aspect = self.size[0] as f32 / self.size[1] as f32;
        let slope = match self.kind {
            Kind::Leadr => inputs.steepest(self.height_scale),
            _ => inputs.steepest(self.height_scale) * aspect.max(1.0),
        };
        let scaled = inputs.height_range().map(|h| h * self.height_scale);
        let deviations = self.classes.as_ref().map_or(1.0, |ClassPlan { frame, .. }| {
            let farthest = |axis: usize, bound: f32| {
                frame.centers.iter().map(|center| bound + center[axis].abs()).fold(0.0, f32::max) / frame.units[axis]
            };
            let height = scaled[0].abs().max(scaled[1].abs());
            farthest(0, slope).max(farthest(1, slope)).max(farthest(2, height))
        });
        let bounds = [slope, inputs.roughest() as f32, inputs.brightest(), deviations];
        blocks::ranges(self.kind, &self.channels, bounds, scaled)
    }

    /// Returns a row of level 0, and the sums of the row's slopes and second moments in texture space.
    fn row(&self, inputs: &Inputs, y: u32) -> (Row, Sums) {
        let mut sums = Sums::default();
        let mut row = Row::with_capacity(self.size[0] as usize * self.pyramid_channels());
        let [width, height] = self.size.map(f64::from);
        let aspect = width / height;
        let has_rest = self.height_and_rest().is_some();
        if self.kind == Kind::Leadr {
            // Heights are in texels if normals give the slopes. If not, heights are in the unit of the map, as in `maketx`.
            let unit = if self.has_normals { width } else { 1.0 };
            let [s, t] = [unit / width, unit / height].map(|v| v as f32);
            for (x, m) in inputs.moments(self.height_scale, y).into_iter().enumerate() {
                let wide = m.map(f64::from);
                let [a, b, .., h] = wide;
                // The square of a single slope is exact here, but would be rounded in the texel.
                sums.add(if self.has_normals { [a, b, a * a, b * b, a * b, h] } else { wide });
                if self.layout == Layout::Oiio {
                    let h = if self.has_heights { m[5] * unit as f32 } else { -1.0 };
                    row.extend([h, m[0] * s, m[1] * t, m[2] * s * s, m[3] * t * t, m[4] * s * t]);
                } else {
                    row.extend(m);
                }
                inputs.beside(self.kind, x as u32, y, &mut row);
                row.extend(has_rest.then_some(0.0));
            }
            return (row, sums);
        }
        let normals = match self.kind {
            Kind::Normal => inputs.normals_of_row(self.height_scale, y),
            Kind::Gloss => inputs.shortened_normals_of_row(self.height_scale, y),
            _ => Vec::new(),
        };
        for (x, [s, t, h]) in inputs.slopes(self.height_scale, y).into_iter().enumerate() {
            sums.add([s, t, s * s, t * t, s * t, h]);
            // The components are n.xy / n.z with y up.
            let (bx, by) = (-s, t * aspect);
            let mut put = |values: &[f64]| row.extend(values.iter().map(|&v| v as f32));
            match self.kind {
                Kind::Lean | Kind::CleanConservative => put(&[bx, by, bx * bx, by * by, bx * by, h]),
                Kind::Clean => put(&[bx, by, bx * bx + by * by, h]),
                Kind::Toksvig | Kind::Leadr => {
                    let length = (1.0 + bx * bx + by * by).sqrt();
                    put(&[bx / length, by / length, 1.0 / length, h]);
                }
                Kind::Normal => put(&normals[x][..3]),
                Kind::Gloss => put(&normals[x]),
                Kind::Height => put(&[h]),
                Kind::Occlusion => row.push(inputs.visible_from(x as u32, y)[3]),
                Kind::Cones => row.extend(inputs.visible_from(x as u32, y)),
            }
            inputs.beside(self.kind, x as u32, y, &mut row);
            row.extend(has_rest.then_some(0.0));
        }
        (row, sums)
    }
}

/// Returns a texel of kind clean-conservative from mean slope, second moments and further channels.
fn conservative_texel(texel: &[f32]) -> impl Iterator<Item = f32> {
    let [x, y, xx, yy, xy] = std::array::from_fn(|i| f64::from(texel[i]));
    let moments = SlopeMoments { first: DVec2::new(x, y), second: DVec3::new(xx, yy, xy) };
    let packed = pack_clean_conservative(moments).to_array().map(|v| v as f32);
    packed.into_iter().chain(texel[5..].iter().copied())
}

#[derive(Clone, Copy)]
struct Sums {
    sums: [f64; 6],
    /// The ranges of the slopes along `s`, the slopes along `t`, and the heights.
    ranges: [[f64; 2]; 3],
}

impl Default for Sums {
    fn default() -> Self {
        Self { sums: [0.0; 6], ranges: [[f64::INFINITY, f64::NEG_INFINITY]; 3] }
    }
}

impl Sums {
    fn add(&mut self, m: [f64; 6]) {
        self.sums.iter_mut().zip(m).for_each(|(sum, v)| *sum += v);
        for (range, v) in self.ranges.iter_mut().zip([m[0], m[1], m[5]]) {
            *range = [range[0].min(v), range[1].max(v)];
        }
    }

    fn join(&mut self, other: &Self) {
        self.sums.iter_mut().zip(other.sums).for_each(|(sum, v)| *sum += v);
        for (range, other) in self.ranges.iter_mut().zip(other.ranges) {
            *range = [range[0].min(other[0]), range[1].max(other[1])];
        }
    }
}

/// The sums of squared differences and of squared values over a level. There is one pair per channel, and one more for the
/// variance.
#[derive(Clone)]
struct Differences(Vec<[f64; 2]>);

impl Differences {
    fn of_row(plan: &Plan, exact: &[f32], stored: &[f32]) -> Self {
        let channels = plan.channels.len();
        let mut sums = vec![[0.0; 2]; channels + 1];
        let kept = plan.kind.channels().len();
        let height = plan.height_and_rest();
        let plain = |texel: &[f32]| -> Vec<f64> {
            texel[..kept].iter().zip(&plan.factors).map(|(&v, f)| f64::from(v) / f).collect()
        };
        for (exact, stored) in exact.chunks_exact(channels).zip(stored.chunks_exact(channels)) {
            for (i, (sum, (&a, &b))) in sums.iter_mut().zip(exact.iter().zip(stored)).enumerate() {
                let (a, mut b) = (f64::from(a), f64::from(b));
                match height {
                    Some((height, rest)) if height == i => b += f64::from(stored[rest]),
                    // The residual has a meaning only together with the height.
                    Some((_, rest)) if rest == i => continue,
                    _ => {}
                }
                *sum = [sum[0] + (b - a).powi(2), sum[1] + a * a];
            }
            if plan.layout == Layout::Leadr {
                let [a, b] = [exact, stored].map(|texel| plan.kind.variance(&plain(texel)));
                sums[channels] = [sums[channels][0] + (b - a).powi(2), sums[channels][1] + a * a];
            }
        }
        Self(sums)
    }

    fn add(&mut self, plan: &Plan, exact: &[Row], stored: &[Row]) {
        let of_rows: Vec<Self> = exact.par_iter().zip(stored).map(|(a, b)| Self::of_row(plan, a, b)).collect();
        for row in of_rows {
            let all = self.0.iter_mut().zip(row.0);
            all.for_each(|(sum, v)| *sum = [sum[0] + v[0], sum[1] + v[1]]);
        }
    }

    /// Returns the errors of a level of this size. Channel errors are relative to the finest level, because means on
    /// coarser levels are close to 0. The variance error is relative to the whole map.
    fn error(&self, plan: &Plan, finest: &Self, [size, finest_size]: [[u32; 2]; 2], whole: &Self) -> LevelError {
        let [texels, finest_texels] = [size, finest_size].map(|[w, h]| f64::from(w) * f64::from(h));
        let relative =
            |difference: f64, value: f64| if difference > 0.0 { (difference / texels / value).sqrt() } else { 0.0 };
        let channels = self.0.len() - 1;
        let before = channels_before_classes(&plan.channels);
        let worst = self.0[..before].iter().zip(&finest.0).map(|(d, of)| relative(d[0], of[1] / finest_texels));
        let mean = |sums: &[[f64; 2]], which: usize, texels: f64| -> Vec<f64> {
            sums[before..channels].iter().map(|sum| sum[which] / texels).collect()
        };
        let classes = plan
            .classes
            .as_ref()
            .map_or(0.0, |classes| classes.error(&mean(&self.0, 0, texels), &mean(&finest.0, 1, finest_texels)));
        LevelError {
            channels: worst.fold(0.0, f64::max),
            classes,
            variance: relative(self.0[channels][0], whole.0[channels][1]),
        }
    }
}

/// Bakes `inputs` into `target` according to `plan`, in bands on all cores. `progress` receives the completed fraction, 0 to 1.
///
/// # Errors
/// Fails if `target` cannot be written.
pub fn bake(inputs: &Inputs, plan: &Plan, target: &mut dyn Target, progress: &dyn Fn(f32)) -> Result<Report, MapFault> {
    let channels = plan.channels.len();
    let [width, height] = plan.size;
    let levels = plan.level_sizes();
    let mut pyramid = Pyramid::new(plan.size, plan.pyramid_channels());
    let mut sums = Sums::default();
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; channels];
    let mut differences = vec![Differences(vec![[0.0; 2]; channels + 1]); levels.len()];
    let mut pending: Vec<Vec<Row>> = vec![Vec::new(); levels.len()];
    for start in (0..height).step_by(BAND as usize) {
        let rows: Vec<_> = (start..height.min(start + BAND)).into_par_iter().map(|y| plan.row(inputs, y)).collect();
        let mut band = Vec::with_capacity(rows.len());
        for (row, of_row) in rows {
            sums.join(&of_row);
            band.push(row);
        }
        if let (Some(found), Some(classes)) = (&inputs.classes, &plan.classes) {
            found.append(&classes.frame, &mut band, start..height.min(start + BAND));
        }
        pyramid.push(band, &mut |level, first, rows| {
            let Some(level) = level.checked_sub(plan.dropped_levels) else { return Ok(()) };
            let exact: Vec<Vec<f32>> = rows.par_iter().map(|row| plan.stored(row)).collect();
            if level == 0 {
                for row in &exact {
                    for texel in row.chunks_exact(channels) {
                        for ((range, &v), factor) in ranges.iter_mut().zip(texel).zip(&plan.factors) {
                            let v = f64::from(v) / factor;
                            *range = [range[0].min(v), range[1].max(v)];
                        }
                    }
                }
            }
            if plan.precision == Precision::F32 {
                return target.rows(level, first, &exact);
            }
            let Some(blocks) = &plan.blocks else {
                let stored: Vec<Vec<f32>> = exact.par_iter().map(|row| plan.halves(row)).collect();
                differences[level].add(plan, &exact, &stored);
                return target.rows(level, first, &stored);
            };
            // A row of blocks needs four rows of texels. Only the last row of blocks may have fewer.
            let pending = &mut pending[level];
            let mut made = (first - pending.len() as u32) / SIDE;
            let all = first + exact.len() as u32 == levels[level][1];
            pending.extend(exact);
            while pending.len() >= SIDE as usize || all && !pending.is_empty() {
                let rows: Vec<Row> = pending.drain(..pending.len().min(SIDE as usize)).collect();
                let (layers, stored) = blocks.encode(&rows);
                differences[level].add(plan, &rows, &stored);
                target.blocks(level, made, &layers)?;
                made += 1;
            }
            Ok(())
        })?;
        progress((start + BAND).min(height) as f32 / height as f32);
    }
    let count = f64::from(width) * f64::from(height);
    let [x, y, xx, yy, xy, _] = sums.sums.map(|sum| sum / count);
    let whole = &differences[levels.len() - 1];
    let errors =
        differences.iter().zip(&levels).map(|(d, size)| d.error(plan, &differences[0], [*size, levels[0]], whole));
    Ok(Report {
        errors: errors.collect(),
        levels,
        mean_slope: [x, y],
        slope_variance: [(xx - x * x).max(0.0), (yy - y * y).max(0.0), xy - x * y],
        slope_range: [sums.ranges[0], sums.ranges[1]],
        height_range: sums.ranges[2],
        channel_ranges: ranges,
    })
}

impl Plan {
    /// Returns the values times the factors as 32-bit floats. All factors are powers of two, so multiplication causes no
    /// rounding.
    fn stored(&self, row: &Row) -> Vec<f32> {
        let conservative;
        let row = if self.kind == Kind::CleanConservative {
            conservative = row.chunks_exact(self.pyramid_channels()).flat_map(conservative_texel).collect();
            &conservative
        } else {
            row
        };
        let factors = self.factors.iter().cycle();
        let mut stored: Vec<f32> = row.iter().zip(factors).map(|(&v, &factor)| v * factor as f32).collect();
        // Normals and gloss are stored without a factor.
        let texels = stored.chunks_exact_mut(self.channels.len());
        match (self.kind, &self.gloss) {
            (Kind::Normal, _) => texels.for_each(normals::restore_length),
            (Kind::Gloss, Some(gloss)) => texels.for_each(|texel| normals::to_normal_and_gloss(texel, gloss)),
            _ => {}
        }
        if let Some((height, rest)) = self.height_and_rest() {
            stored.chunks_exact_mut(self.channels.len()).for_each(|t| t[rest] = t[height] - half(t[height]).to_f32());
        }
        stored
    }

    /// Returns the values as 16-bit floats. Second moments are corrected for the rounding of the means.
    fn halves(&self, row: &Row) -> Vec<f32> {
        if self.layout == Layout::Oiio || !matches!(self.kind, Kind::Leadr | Kind::Lean) {
            return row.iter().map(|&v| half(v).to_f32()).collect();
        }
        let mut stored = Vec::with_capacity(row.len());
        for texel in row.chunks_exact(self.channels.len()) {
            let ([x, y, xx, yy], xy) = halves::nearest([texel[0], texel[1], texel[2], texel[3]], texel[4]);
            stored.extend([x, y, xx, yy, xy].map(f16::to_f32));
            stored.extend(texel[5..].iter().map(|&v| half(v).to_f32()));
        }
        stored
    }
}
