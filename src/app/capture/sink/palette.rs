//! Few colours for many: the palette of a frame of a GIF, and dithering with it.

use std::collections::BTreeSet;

/// Colours of a palette: one of the 256 is kept for what is transparent.
const COLORS: usize = 255;

/// About so many pixels choose the colours.
const SAMPLES: usize = 40_000;

/// The share of an error that goes on to neighbours: below 1, so that a colour outside the palette is not chased across the
/// picture.
const DIFFUSED: f32 = 0.9;

/// At most [`COLORS`] colours.
pub struct Palette {
    colors: Vec<[u8; 3]>,
    /// For each cube of 16³ colours, when it has been asked for, the colours that may be nearest to one of them.
    near: Vec<Vec<u8>>,
}

impl Palette {
    /// Colours for those pixels that are there: their own, if they are few.
    pub fn of(pixels: &[Option<[u8; 3]>]) -> Self {
        let mut own = BTreeSet::new();
        let few = pixels.iter().flatten().all(|color| {
            own.insert(*color);
            own.len() <= COLORS
        });
        let colors = if few { own.into_iter().collect() } else { chosen(pixels) };
        Self { colors, near: vec![Vec::new(); 1 << 12] }
    }

    /// The table of a file, `R, G, B`, with a last colour that stands for none.
    pub fn table(&self) -> Vec<u8> {
        [self.colors.as_flattened(), &[0; 3]].concat()
    }

    /// The index of what is transparent.
    pub fn transparent(&self) -> u8 {
        self.colors.len() as u8
    }

    /// The index of the nearest colour in sRGB codes, of several the first.
    fn nearest(&mut self, color: [u8; 3]) -> u8 {
        let cube = color.map(|code| code / 16);
        let near = &mut self.near[cube.iter().fold(0, |index, &c| index * 16 + usize::from(c))];
        if near.is_empty() {
            *near = candidates(&self.colors, cube.map(|c| c * 16 + 8));
        }
        let distance = |&&index: &&u8| squared_distance(self.colors[usize::from(index)], color);
        near.iter().min_by_key(distance).copied().unwrap_or_default()
    }

    /// The indices of pixels in rows of `width`: Floyd and Steinberg's diffusion of errors, every second row backwards.
    pub fn dither(&mut self, pixels: &[Option<[u8; 3]>], width: usize) -> Vec<u8> {
        let mut indices = vec![self.transparent(); pixels.len()];
        // A column on either side takes what leaves the picture.
        let (mut errors, mut below) = (vec![[0.0_f32; 3]; width + 2], vec![[0.0_f32; 3]; width + 2]);
        for (y, (row, indices)) in pixels.chunks(width).zip(indices.chunks_mut(width)).enumerate() {
            let backwards = y % 2 == 1;
            for step in 0..width {
                let x = if backwards { width - 1 - step } else { step };
                let Some(color) = row[x] else { continue };
                let at = x + 1;
                let (ahead, behind) = if backwards { (at - 1, at + 1) } else { (at + 1, at - 1) };
                let wanted: [f32; 3] = std::array::from_fn(|c| (f32::from(color[c]) + errors[at][c]).clamp(0.0, 255.0));
                indices[x] = self.nearest(wanted.map(|v| v.round() as u8));
                let got = self.colors[usize::from(indices[x])];
                for c in 0..3 {
                    let sixteenth = (wanted[c] - f32::from(got[c])) * DIFFUSED / 16.0;
                    errors[ahead][c] += 7.0 * sixteenth;
                    below[behind][c] += 3.0 * sixteenth;
                    below[at][c] += 5.0 * sixteenth;
                    below[ahead][c] += sixteenth;
                }
            }
            std::mem::swap(&mut errors, &mut below);
            below.fill([0.0; 3]);
        }
        indices
    }
}

/// Colours for more pixels than there are colours: the extremes, which errors are diffused between, and the means of boxes.
fn chosen(pixels: &[Option<[u8; 3]>]) -> Vec<[u8; 3]> {
    let extremes: BTreeSet<[u8; 3]> =
        (0..27).filter(|&direction| direction != 13).filter_map(|direction| farthest(pixels, direction)).collect();
    let count = pixels.iter().flatten().count();
    let mut samples: Vec<_> = pixels.iter().flatten().step_by((count / SAMPLES).max(1)).copied().collect();
    let mut colors: Vec<_> = extremes.into_iter().collect();
    colors.extend(boxes(&mut samples, COLORS - colors.len()));
    colors
}

/// The colour farthest in one of the 26 directions towards the sides, edges and corners of a cube; the 13th has none.
fn farthest(pixels: &[Option<[u8; 3]>], direction: i32) -> Option<[u8; 3]> {
    let axes = [direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1];
    let along = |color: &[u8; 3]| (0..3).map(|c| axes[c] * i32::from(color[c])).sum::<i32>();
    pixels.iter().flatten().copied().max_by_key(along)
}

/// A box of colours, as a range of the samples.
struct ColorBox {
    start: usize,
    end: usize,
    mean: [f64; 3],
    /// The channel that varies most, and the sum of its squared deviations.
    channel: usize,
    deviation: f64,
}

impl ColorBox {
    fn of(samples: &[[u8; 3]], start: usize, end: usize) -> Self {
        let count = (end - start) as f64;
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        for (color, c) in samples[start..end].iter().flat_map(|color| (0..3).map(move |c| (color, c))) {
            let value = f64::from(color[c]);
            sum[c] += value;
            squares[c] += value * value;
        }
        let mean = sum.map(|s| s / count);
        // Whole numbers: exact.
        let deviations: [f64; 3] = std::array::from_fn(|c| squares[c] - sum[c] * sum[c] / count);
        let channel = (1..3).fold(0, |most, c| if deviations[c] > deviations[most] { c } else { most });
        Self { start, end, mean, channel, deviation: deviations[channel] }
    }
}

/// The means of `count` boxes, or fewer: the box that varies most is cut at its mean, again and again.
fn boxes(samples: &mut [[u8; 3]], count: usize) -> Vec<[u8; 3]> {
    let mut boxes = vec![ColorBox::of(samples, 0, samples.len())];
    while boxes.len() < count {
        let most =
            (0..boxes.len()).fold(0, |most, i| if boxes[i].deviation > boxes[most].deviation { i } else { most });
        let ColorBox { start, end, mean, channel, .. } = boxes[most];
        let mut middle = start;
        for at in start..end {
            if f64::from(samples[at][channel]) <= mean[channel] {
                samples.swap(middle, at);
                middle += 1;
            }
        }
        if middle == end {
            // All colours of every box are the same.
            break;
        }
        boxes[most] = ColorBox::of(samples, start, middle);
        boxes.push(ColorBox::of(samples, middle, end));
    }
    boxes.iter().map(|b| b.mean.map(|v| v.round() as u8)).collect()
}

fn squared_distance(a: [u8; 3], b: [u8; 3]) -> i32 {
    (0..3).map(|c| (i32::from(a[c]) - i32::from(b[c])).pow(2)).sum()
}

/// Which colours may be nearest to one in the cube of 16³ about `middle`.
fn candidates(colors: &[[u8; 3]], middle: [u8; 3]) -> Vec<u8> {
    // A colour of the cube is at most so far from its middle.
    let radius = f64::from(3 * 8 * 8).sqrt();
    let distance = |color: &[u8; 3]| f64::from(squared_distance(*color, middle)).sqrt();
    let least = colors.iter().map(distance).fold(f64::INFINITY, f64::min);
    let near = (0..colors.len()).filter(|&i| distance(&colors[i]) <= least + 2.0 * radius);
    near.map(|i| i as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_holes_stay_holes() {
        let pixels: Vec<_> = (0..12).map(|i| (i != 5).then_some([i * 20, 7, 255 - i])).collect();
        let mut palette = Palette::of(&pixels);
        let table = palette.table();
        for (pixel, index) in pixels.iter().zip(palette.dither(&pixels, 4)) {
            match pixel {
                Some(color) => assert_eq!(table[3 * usize::from(index)..][..3], color[..]),
                None => assert_eq!(index, palette.transparent()),
            }
        }
        let mut none = Palette::of(&[None]);
        assert_eq!((none.dither(&[None], 1), none.table().len()), (vec![0], 3));
    }

    #[test]
    fn the_nearest_colour_is_the_nearest_of_all() {
        let color = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8).to_le_bytes();
        let pixels: Vec<_> = (0..900).map(|i| Some([color(i)[0], color(i)[1] / 2, color(i)[2]])).collect();
        let mut palette = Palette::of(&pixels);
        assert!((250..=COLORS).contains(&palette.colors.len()), "{}", palette.colors.len());
        for i in 0..2000 {
            let [r, g, b, _] = color(i + 5000);
            let index = palette.nearest([r, g, b]);
            let found = palette.colors[usize::from(index)];
            let least = palette.colors.iter().map(|c| squared_distance(*c, [r, g, b])).min();
            assert_eq!(Some(squared_distance(found, [r, g, b])), least);
        }
    }

    #[test]
    fn a_gradient_is_right_in_the_mean_and_shows_no_bands() {
        let (width, height) = (256, 96);
        let color = |x: usize, y: usize| [(60 + x / 3) as u8, (80 + y) as u8, (200 - (x + y) / 4) as u8];
        let pixels: Vec<_> = (0..width * height).map(|i| Some(color(i % width, i / width))).collect();
        let mut palette = Palette::of(&pixels);
        let (table, indices) = (palette.table(), palette.dither(&pixels, width));
        let shown = |x: usize, y: usize, c: usize| f32::from(table[3 * usize::from(indices[y * width + x]) + c]);
        let (mut worst, block) = (0.0_f32, 8);
        for (y, x) in (0..height).step_by(block).flat_map(|y| (0..width).step_by(block).map(move |x| (y, x))) {
            for c in 0..3 {
                let cells = (0..block * block).map(|i| (x + i % block, y + i / block));
                let off: f32 = cells.map(|(x, y)| shown(x, y, c) - f32::from(color(x, y)[c])).sum();
                worst = worst.max((off / (block * block) as f32).abs());
            }
        }
        // The extremes are exact; a colour on the border between two of them has others on one side only.
        assert!(worst < 2.5, "the mean of a block is off by {worst} codes");
    }
}
