//! Streaming mip generation. Each level keeps only the few rows that the next level still needs.

use std::collections::VecDeque;

use rayon::prelude::*;

use crate::MapFault;

/// A row of texels with interleaved channels.
pub(super) type Row = Vec<f32>;

/// A callback for finished rows. The arguments are the level, the first row, and the rows.
pub(super) type Emit<'a> = dyn FnMut(usize, u32, &[Row]) -> Result<(), MapFault> + 'a;

/// Returns the sizes of all levels. Sides are halved and rounded down until both are 1.
pub(super) fn level_sizes(size: [u32; 2]) -> Vec<[u32; 2]> {
    let mut sizes = vec![size];
    while let Some(&[w, h]) = sizes.last().filter(|s| s[0] > 1 || s[1] > 1) {
        sizes.push([(w / 2).max(1), (h / 2).max(1)]);
    }
    sizes
}

/// The filter taps of a texel of the next level along one axis: the first source texel, and weights that sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taps {
    pub first: usize,
    weights: [f32; 3],
    count: usize,
}

impl Taps {
    /// Returns the taps for every texel of the next level. `from` is the number of texels along this level.
    pub fn of_level(from: u32) -> Vec<Self> {
        let half = from / 2;
        let odd = |i: u32| [half - i, half, i + 1].map(|weight| weight as f32 * (1.0 / from as f32));
        let tap = |i: u32| {
            let (weights, count) = match from {
                1 => ([1.0, 0.0, 0.0], 1),
                _ if from.is_multiple_of(2) => ([0.5, 0.5, 0.0], 2),
                _ => (odd(i), 3),
            };
            Self { first: 2 * i as usize, weights, count }
        };
        (0..half.max(1)).map(tap).collect()
    }

    /// Returns the index after the last source texel.
    pub const fn end(self) -> usize {
        self.first + self.count
    }

    /// Returns the source texels and their weights.
    pub fn weighted(self) -> impl Iterator<Item = (usize, f32)> {
        (0..self.count).map(move |i| (self.first + i, self.weights[i]))
    }
}

/// The downsampling state of one level.
struct Step {
    /// The taps for each column and row of the next level.
    columns: Vec<Taps>,
    rows: Vec<Taps>,
    pending: VecDeque<Row>,
    /// The row of this level that is first in `pending`.
    first: usize,
    /// The index of the next row to emit.
    next: usize,
}

/// A mip pyramid by area averages. Sums use the order of the moments pass, so results are bit-exact.
pub(super) struct Pyramid {
    channels: usize,
    steps: Vec<Step>,
    done: Vec<u32>,
}

impl Pyramid {
    pub(super) fn new(size: [u32; 2], channels: usize) -> Self {
        let sizes = level_sizes(size);
        let step = |pair: &[[u32; 2]]| Step {
            columns: Taps::of_level(pair[0][0]),
            rows: Taps::of_level(pair[0][1]),
            pending: VecDeque::new(),
            first: 0,
            next: 0,
        };
        Self { channels, steps: sizes.windows(2).map(step).collect(), done: vec![0; sizes.len()] }
    }

    /// Takes the next rows of level 0, and emits all rows of all levels that are now complete.
    pub(super) fn push(&mut self, mut rows: Vec<Row>, emit: &mut Emit<'_>) -> Result<(), MapFault> {
        for level in 0..self.done.len() {
            if rows.is_empty() {
                break;
            }
            emit(level, self.done[level], &rows)?;
            self.done[level] += rows.len() as u32;
            let Some(step) = self.steps.get_mut(level) else { break };
            step.pending.extend(rows);
            let there = step.first + step.pending.len();
            let ready = step.rows[step.next..].iter().take_while(|row| row.end() <= there);
            let ready = step.next + ready.count();
            let channels = self.channels;
            rows = (step.next..ready).into_par_iter().map(|row| step.filter(row, channels)).collect();
            step.next = ready;
            let needed = step.rows.get(ready).map_or(there, |row| row.first);
            step.pending.drain(..needed - step.first);
            step.first = needed;
        }
        Ok(())
    }
}

impl Step {
    fn filter(&self, row: usize, channels: usize) -> Row {
        let mut filtered = vec![0.0; self.columns.len() * channels];
        for (texel, column) in filtered.chunks_exact_mut(channels).zip(&self.columns) {
            for (y, wy) in self.rows[row].weighted() {
                let fine = &self.pending[y - self.first];
                for (x, wx) in column.weighted() {
                    let weight = wx * wy;
                    let from = &fine[x * channels..(x + 1) * channels];
                    texel.iter_mut().zip(from).for_each(|(sum, v)| *sum += weight * v);
                }
            }
        }
        filtered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_of_any_height_make_the_same_levels() {
        let size = [13, 37];
        let rows: Vec<Row> = (0..37).map(|y| (0..26).map(|x| ((x * 7 + y * 13) % 11) as f32).collect()).collect();
        let levels = |band: usize| {
            let mut levels = vec![Vec::<Row>::new(); level_sizes(size).len()];
            let mut pyramid = Pyramid::new(size, 2);
            for rows in rows.chunks(band) {
                let emit = &mut |level: usize, first: u32, rows: &[Row]| {
                    assert_eq!(first as usize, levels[level].len());
                    levels[level].extend_from_slice(rows);
                    Ok(())
                };
                pyramid.push(rows.to_vec(), emit).unwrap();
            }
            levels
        };
        let whole = levels(37);
        for (level, size) in whole.iter().zip(level_sizes(size)) {
            assert_eq!([level[0].len() as u32 / 2, level.len() as u32], size);
        }
        for band in [1, 2, 3, 5, 16] {
            assert_eq!(levels(band), whole, "bands of {band}");
        }
        let mean = rows.iter().flatten().step_by(2).sum::<f32>() / (13.0 * 37.0);
        assert!((whole.last().unwrap()[0][0] - mean).abs() < 1e-5);
    }
}
