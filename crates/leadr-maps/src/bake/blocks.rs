//! Block compression of baked maps: the quantities that blocks store, and the encoding of rows into blocks.
//!
//! **Stored quantities.** Blocks are too coarse for raw second moments. If the stored values have errors of a few percent,
//! `E[x²] − E[x]²` is useless (measured in docs/measurements/maps.md). Blocks therefore store deviations and correlation. A
//! reader computes the moments of a texel from the deviations, the correlation and the stored means. Deviations cannot be
//! interpolated linearly, so convert each texel to moments before interpolation.
//!
//! **Residual layers.** A BC5 block resolves a value to 1/14 of the block's range. A second layer stores the residual of the
//! first, and a third layer the residual of the second. Heights, which are visible directly, and mean slopes use four layers.
//! All other quantities use two.

use rayon::prelude::*;

use super::{Kind, channels_before_classes};
use crate::bc5;

/// The upper bound of a layer's residual, relative to the layer's range: the block error plus one step of the byte
/// endpoints.
const REST: f32 = 1.0 / 7.0 + 1.0 / 127.0;

/// The content of one channel of a layer: the index of the map channel, and the index of the residual. Residual index 0
/// means the value itself.
pub(crate) type Slot = (usize, usize);

fn depth(name: &str) -> usize {
    match name {
        "height" | "x" | "y" | "B.x" | "B.y" => 4,
        name if name.starts_with("class") && !name.ends_with(".w") && name.rfind('.') == Some(name.len() - 2) => 3,
        _ => 2,
    }
}

/// Returns the content of each two-channel layer: first pairs of map channels, then further residuals of single channels.
fn slots(channels: &[&str]) -> Vec<Option<Slot>> {
    let mut slots = Vec::new();
    for (pair, names) in channels.chunks(2).enumerate() {
        let depths: Vec<usize> = names.iter().map(|name| depth(name)).collect();
        let both = if let [a, b] = depths[..] { a.min(b) } else { 0 };
        slots.extend((0..both).flat_map(|rest| [Some((2 * pair, rest)), Some((2 * pair + 1, rest))]));
        slots.extend(
            depths.iter().enumerate().flat_map(|(i, &depth)| (both..depth).map(move |rest| Some((2 * pair + i, rest)))),
        );
        slots.resize(slots.len().next_multiple_of(2), None);
    }
    slots
}

/// Returns the name of the residual with index `rest` of a channel.
pub(crate) fn rest_name(name: &str, rest: usize) -> String {
    match rest {
        0 => name.to_owned(),
        1 => format!("{name}.rest"),
        _ => format!("{name}.rest{rest}"),
    }
}

/// Parses a name into the channel name and the residual index. Inverse of [`rest_name`].
pub(crate) fn of_rest_name(name: &str) -> Option<(&str, usize)> {
    Some(match name.split_once(".rest") {
        None => (name, 0),
        Some((name, "")) => (name, 1),
        Some((name, rest)) => (name, rest.parse().ok().filter(|rest| (2..10).contains(rest))?),
    })
}

/// Returns the names of the stored quantities for the channels of a map.
pub(crate) fn stored_names(kind: Kind, channels: &[String]) -> Vec<String> {
    let stored = |name: &String| match (kind, name.as_str()) {
        (Kind::Leadr, "xx") => "x.deviation".to_owned(),
        (Kind::Leadr, "yy") => "y.deviation".to_owned(),
        (Kind::Lean, "M.xx") => "B.x.deviation".to_owned(),
        (Kind::Lean, "M.yy") => "B.y.deviation".to_owned(),
        (Kind::Clean | Kind::CleanConservative, "M") => "deviation".to_owned(),
        (Kind::Leadr | Kind::Lean, "xy" | "M.xy") => "correlation".to_owned(),
        (_, name) if name.starts_with("class") => {
            let (class, axis) = name.split_once('.').unwrap_or((name, ""));
            match axis {
                "x" | "y" | "z" => format!("{name}.mean"),
                "xx" | "yy" | "zz" => format!("{class}.{}.deviation", &axis[..1]),
                "xy" => format!("{class}.correlation"),
                _ => name.to_owned(),
            }
        }
        _ => name.clone(),
    };
    channels.iter().map(stored).collect()
}

/// Replaces the weighted moments of the classes of a texel by means, deviations and correlations.
fn to_stored_classes(texel: &mut [f32]) {
    for class in texel.as_chunks_mut::<8>().0 {
        let part = if class[0] > 0.0 { class[0].recip() } else { 0.0 };
        class[1..].iter_mut().for_each(|v| *v *= part);
        let [_, x, y, z, xx, yy, xy, zz] = class;
        let deviation = |second: f32, mean: f32| (second - mean * mean).max(0.0).sqrt();
        (*xx, *yy, *zz) = (deviation(*xx, *x), deviation(*yy, *y), deviation(*zz, *z));
        *xy = ((*xy - *x * *y) / (*xx * *yy).max(1e-30)).clamp(-1.0, 1.0);
    }
}

/// Restores the weighted moments of the classes of a texel. Inverse of [`to_stored_classes`].
fn of_stored_classes(texel: &mut [f32]) {
    for class in texel.as_chunks_mut::<8>().0 {
        let [w, x, y, z, xx, yy, xy, zz] = class;
        *w = w.clamp(0.0, 1.0);
        let [sx, sy, sz] = [*xx, *yy, *zz].map(|deviation| deviation.max(0.0));
        *xy = xy.clamp(-1.0, 1.0) * sx * sy + *x * *y;
        (*xx, *yy, *zz) = (sx * sx + *x * *x, sy * sy + *y * *y, sz * sz + *z * *z);
        let share = *w;
        class[1..].iter_mut().for_each(|v| *v *= share);
    }
}

/// Replaces the second moments of a texel by deviations and correlation.
fn to_stored(kind: Kind, texel: &mut [f32]) {
    let deviation = |second: f32, square: f32| (second - square).max(0.0).sqrt();
    let [x, y] = [texel[0], texel.get(1).copied().unwrap_or(0.0)];
    match kind {
        Kind::Leadr | Kind::Lean => {
            let covariance = texel[4] - x * y;
            texel[2] = deviation(texel[2], x * x);
            texel[3] = deviation(texel[3], y * y);
            texel[4] = (covariance / (texel[2] * texel[3]).max(1e-30)).clamp(-1.0, 1.0);
        }
        Kind::Clean | Kind::CleanConservative => texel[2] = deviation(texel[2], x * x + y * y),
        _ => {}
    }
}

/// Restores the second moments of a texel. Inverse of [`to_stored`].
fn of_stored(kind: Kind, texel: &mut [f32]) {
    let [x, y] = [texel[0], texel.get(1).copied().unwrap_or(0.0)];
    match kind {
        Kind::Leadr | Kind::Lean => {
            let [sx, sy] = [texel[2].max(0.0), texel[3].max(0.0)];
            texel[4] = texel[4].clamp(-1.0, 1.0) * sx * sy + x * y;
            texel[2] = sx * sx + x * x;
            texel[3] = sy * sy + y * y;
        }
        Kind::Clean | Kind::CleanConservative => texel[2] = texel[2] * texel[2] + x * x + y * y,
        _ => {}
    }
}

/// Returns the ranges of the stored quantities. The bounds are of slopes, roughness, radiance, and deviations from the centres of
/// classes. Heights lie in `heights`.
pub(super) fn ranges(
    kind: Kind,
    channels: &[&str],
    [slope, alpha, light, deviation]: [f32; 4],
    heights: [f32; 2],
) -> Vec<[f32; 2]> {
    let wide = |[low, high]: [f32; 2]| if high > low { [low, high] } else { [low - 1e-6, low + 1e-6] };
    let range = |name: &str| match (kind, name) {
        (_, "height") => heights,
        (_, "alpha2") => [0.0, alpha.powi(2)],
        (_, "alpha4") => [0.0, alpha.powi(4)],
        (_, "gloss" | "occlusion") => [0.0, 1.0],
        (_, "red" | "green" | "blue") => [0.0, light],
        (_, name) if name.starts_with("class") => match name.rsplit('.').next() {
            Some("w") => [0.0, 1.0],
            Some("xy") => [-1.0, 1.0],
            Some("x" | "y" | "z") => [-deviation, deviation],
            _ => [0.0, deviation],
        },
        (Kind::Toksvig | Kind::Normal | Kind::Gloss | Kind::Cones, _) | (_, "xy" | "M.xy") => [-1.0, 1.0],
        (_, "xx" | "yy" | "M.xx" | "M.yy") => [0.0, slope],
        // The single deviation of a CLEAN map covers both axes.
        (_, "M") => [0.0, 1.5 * slope],
        _ => [-slope, slope],
    };
    channels.iter().map(|name| wide(range(name))).collect()
}

/// The assignment of a map's channels to two-channel layers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BlockPlan {
    kind: Kind,
    channels: usize,
    /// The number of channels before those of classes.
    before_classes: usize,
    /// The content of each channel of each layer. The residuals of a map channel follow its values.
    pub slots: Vec<Option<Slot>>,
    /// The factor and offset of each slot. The value of a map channel is the sum of `value / factor + offset` over its
    /// slots.
    pub scales: Vec<[f32; 2]>,
}

impl BlockPlan {
    /// Creates the layout for channels with the given value ranges.
    pub fn new(kind: Kind, channels: &[&str], ranges: &[[f32; 2]]) -> Self {
        let slots = slots(channels);
        let scale = |&slot: &Option<Slot>| {
            let Some((channel, rest)) = slot else { return [1.0, 0.0] };
            let [low, high] = ranges[channel];
            let factor = (0..rest).fold(2.0 / (high - low), |factor, _| factor / REST);
            [factor, if rest == 0 { 0.5 * (low + high) } else { 0.0 }]
        };
        let before_classes = channels_before_classes(channels);
        Self { kind, channels: channels.len(), before_classes, scales: slots.iter().map(scale).collect(), slots }
    }

    /// Creates the layout that a file describes. The file gives the content, factor and offset of each slot.
    pub fn of_slots(
        kind: Kind,
        channels: &[impl AsRef<str>],
        slots: Vec<Option<Slot>>,
        factors: &[f64],
        offsets: &[f64],
    ) -> Self {
        let scales = factors.iter().zip(offsets).map(|(&factor, &offset)| [factor as f32, offset as f32]).collect();
        Self { kind, channels: channels.len(), before_classes: channels_before_classes(channels), slots, scales }
    }

    /// Returns the number of layers.
    pub fn layers(&self) -> usize {
        self.slots.len() / 2
    }

    /// Encodes up to four rows of interleaved channels. Returns the blocks of each layer, and the decoded rows.
    pub fn encode(&self, rows: &[Vec<f32>]) -> (Vec<Vec<u8>>, Vec<Vec<f32>>) {
        let (channels, width) = (self.channels, rows[0].len() / self.channels);
        let across = width.div_ceil(bc5::SIDE);
        let blocks: Vec<Vec<[u8; bc5::BYTES]>> =
            (0..across).into_par_iter().map(|block| self.encode_block(rows, block)).collect();
        let layers: Vec<Vec<u8>> = (0..self.layers())
            .map(|layer| blocks.iter().flat_map(|block| [block[2 * layer], block[2 * layer + 1]].concat()).collect())
            .collect();
        let mut decoded = vec![vec![0.0; width * channels]; rows.len()];
        for (index, block) in blocks.iter().enumerate() {
            self.decode_block(block, |x, y, texel| {
                if let Some(row) = decoded.get_mut(y)
                    && let Some(to) = row.chunks_exact_mut(channels).nth(bc5::SIDE * index + x)
                {
                    to.copy_from_slice(texel);
                }
            });
        }
        (layers, decoded)
    }

    /// Encodes one block for every channel of every layer. Texels beyond the map's edge repeat the edge texel.
    fn encode_block(&self, rows: &[Vec<f32>], block: usize) -> Vec<[u8; bc5::BYTES]> {
        let width = rows[0].len() / self.channels;
        let texels: Vec<Vec<f32>> = (0..16)
            .map(|i| {
                let (x, y) = ((bc5::SIDE * block + i % bc5::SIDE).min(width - 1), (i / bc5::SIDE).min(rows.len() - 1));
                let mut texel = rows[y][x * self.channels..][..self.channels].to_vec();
                to_stored(self.kind, &mut texel);
                to_stored_classes(&mut texel[self.before_classes..]);
                texel
            })
            .collect();
        let mut left: Vec<[f32; 16]> = (0..self.channels).map(|c| std::array::from_fn(|i| texels[i][c])).collect();
        let slots = self.slots.iter().zip(&self.scales).map(|(&slot, &[factor, offset])| {
            let Some((channel, _)) = slot else { return [0; bc5::BYTES] };
            let left = &mut left[channel];
            let values = left.map(|v| ((v - offset) * factor).clamp(-1.0, 1.0));
            let encoded = bc5::encode(&values);
            let found = bc5::decode(&encoded);
            *left = std::array::from_fn(|i| (values[i] - found[i]) / factor);
            encoded
        });
        slots.collect()
    }

    /// Decodes the blocks of all channels of all layers. Calls `put` for each of the 16 texels, with the texel's position in
    /// the block and its channel values.
    pub fn decode_block(&self, blocks: &[[u8; bc5::BYTES]], mut put: impl FnMut(usize, usize, &[f32])) {
        let mut texels = vec![vec![0.0; self.channels]; 16];
        for ((slot, &[factor, offset]), block) in self.slots.iter().zip(&self.scales).zip(blocks) {
            let Some((channel, _)) = *slot else { continue };
            for (texel, value) in texels.iter_mut().zip(bc5::decode(block)) {
                texel[channel] += value / factor + offset;
            }
        }
        for (i, texel) in texels.iter_mut().enumerate() {
            of_stored(self.kind, texel);
            of_stored_classes(&mut texel[self.before_classes..]);
            put(i % bc5::SIDE, i / bc5::SIDE, texel);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_come_back_with_their_variance() {
        // The texels have steep mean slopes and little variance. Raw second moments would lose the variance.
        let texel = |i: usize| {
            let (x, y) = (3.0 + 0.2 * (i as f32 * 0.7).sin(), -2.0 + 0.1 * (i as f32 * 1.3).cos());
            let (sx, sy, rho) = (0.05 + 0.01 * (i % 5) as f32, 0.08, 0.5 - 0.1 * (i % 3) as f32);
            [x, y, x * x + sx * sx, y * y + sy * sy, x * y + rho * sx * sy, 0.01 * i as f32]
        };
        let rows: Vec<Vec<f32>> = (0..3).map(|y| (0..6).flat_map(|x| texel(6 * y + x)).collect()).collect();
        let names = ["x", "y", "xx", "yy", "xy", "height"];
        let plan = BlockPlan::new(Kind::Leadr, &names, &ranges(Kind::Leadr, &names, [4.0, 1.0, 1.0, 1.0], [0.0, 0.2]));
        let (layers, decoded) = plan.encode(&rows);
        assert_eq!((layers.len(), layers[0].len()), (9, 2 * 16));
        for (row, decoded) in rows.iter().zip(&decoded) {
            for (a, b) in row.chunks_exact(6).zip(decoded.chunks_exact(6)) {
                // Means span a range of 8 and heights a range of 0.2. The tolerances are 1/8000 and 1/4000 of the ranges.
                assert!((a[0] - b[0]).abs() < 1e-3 && (a[5] - b[5]).abs() < 5e-5, "{a:?} {b:?}");
                let variance = |m: &[f32]| [m[2] - m[0] * m[0], m[3] - m[1] * m[1], m[4] - m[0] * m[1]];
                for (va, vb) in variance(a).into_iter().zip(variance(b)) {
                    assert!((va - vb).abs() < 1e-3, "{a:?} {b:?}");
                }
            }
        }
        // Reading the plan back from a file must give an identical plan.
        let [factors, offsets] = [0, 1].map(|i| plan.scales.iter().map(|s| f64::from(s[i])).collect::<Vec<_>>());
        assert_eq!(BlockPlan::of_slots(Kind::Leadr, &names, plan.slots.clone(), &factors, &offsets), plan);
    }

    #[test]
    fn leftover_names_are_parsed() {
        for (name, rest) in [("x", 0), ("B.x.deviation", 1), ("height", 2), ("height", 3)] {
            assert_eq!(of_rest_name(&rest_name(name, rest)), Some((name, rest)));
        }
        assert!(["x.rest1", "x.rest0", "x.restless", "x.rest99"].iter().all(|name| of_rest_name(name).is_none()));
    }

    /// Returns the RMS error of the slope variances along both axes for one map level. Each error is relative to the
    /// variance plus the variance of a base material with α = 0.35.
    fn variance_error(exact: &[Vec<f32>], stored: &[Vec<f32>], raw: bool) -> f64 {
        let channels = if raw { 5 } else { 6 };
        let (mut sum, mut count) = (0.0, 0.0);
        for (a, b) in exact.iter().zip(stored) {
            for (a, b) in a.chunks_exact(channels).zip(b.chunks_exact(channels)) {
                for axis in 0..2 {
                    let variance = |m: &[f32]| f64::from((m[2 + axis] - m[axis] * m[axis]).max(0.0));
                    let base = 0.35f64.powi(2) / 2.0;
                    sum += ((variance(b) - variance(a)) / (variance(a) + base)).powi(2);
                    count += 1.0;
                }
            }
        }
        (sum / count).sqrt()
    }

    #[test]
    fn raw_second_moments_do_not_survive_blocks() {
        let mut map = crate::procedural::rock(256, 256, 1);
        // The plane scene has 0.12 m of relief per 2 m, and generated rock scales the relief by 0.6.
        map.texels.iter_mut().for_each(|height| *height *= 0.6 * 0.12 / 2.0);
        let leadr = crate::LeadrMap::new(&map, crate::Wrap::Repeat);
        println!("level   raw     raw twice   deviations   deviations twice");
        for (index, level) in leadr.levels.iter().enumerate().take(4) {
            let texels: Vec<[f32; 6]> = level.texels.iter().map(|m| bytemuck::cast(*m)).collect();
            let rows = |channels: usize| -> Vec<Vec<f32>> {
                let row = |row: &[[f32; 6]]| row.iter().flat_map(|texel| texel[..channels].to_vec()).collect();
                texels.chunks_exact(level.width as usize).map(row).collect()
            };
            let most = |channel: usize| texels.iter().fold(0.0f32, |most, texel| most.max(texel[channel].abs()));
            let slope = most(0).max(most(1)).max(most(2).max(most(3)).sqrt());
            let [low, high] = [-most(5), most(5)];
            let deviations =
                ranges(Kind::Leadr, &["x", "y", "xx", "yy", "xy", "height"], [slope, 1.0, 1.0, 1.0], [low, high]);
            let square = slope * slope;
            // The channels are stored unchanged.
            let raw = [[-slope, slope], [-slope, slope], [0.0, square], [0.0, square], [-square, square]];
            let mut errors = Vec::new();
            for (kind, ranges, channels) in [(Kind::Toksvig, &raw[..], 5), (Kind::Leadr, &deviations[..], 6)] {
                for once in [true, false] {
                    let names = ["x", "y", "xx", "yy", "xy", "height"];
                    let mut plan = BlockPlan::new(kind, &names[..channels], ranges);
                    if once {
                        let rests =
                            plan.scales.iter_mut().zip(&plan.slots).filter(|(_, slot)| slot.is_some_and(|s| s.1 > 0));
                        rests.for_each(|(scale, _)| scale[0] = 1e30);
                    }
                    let exact = rows(channels);
                    let stored: Vec<Vec<f32>> = exact.chunks(4).flat_map(|rows| plan.encode(rows).1).collect();
                    errors.push(variance_error(&exact, &stored, channels == 5));
                }
            }
            println!("{index:5}   {}", errors.iter().map(|e| format!("{e:.4}")).collect::<Vec<_>>().join("   "));
            assert!(
                errors[0] > 2.0 * errors[2] && errors[1] > 2.1 * errors[3] && errors[3] < 0.01,
                "{index}: {errors:?}"
            );
        }
    }
}
