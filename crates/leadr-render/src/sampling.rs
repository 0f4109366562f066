//! Sample positions in a pixel.
//!
//! Every set of samples is point-symmetric about the centre of the pixel. The offsets therefore sum to exactly zero, and never
//! shift the image. Each of the `count` columns and rows of the pixel holds one sample.

use std::cell::Cell;
use std::collections::BTreeSet;

use glam::Vec2;
use leadr_reflectance::random::{Random, unit_of_bits};

/// Returns the offset of sample `index` of `samples` from the pixel centre, in `(-½, ½)²`. A single sample lies at the centre. Each
/// seed gives a different set of offsets.
pub fn jitter(index: u32, samples: u32, seed: u64) -> Vec2 {
    let count = samples.max(1);
    let (index, opposite) = (index % count, count - 1 - index % count);
    let lattice = Lattice::known(count, seed);
    // Each sample is jittered within its column and row, and the opposite sample is its mirror image. Seed 0 gives the lattice
    // without jitter.
    let within = |axis: u64| {
        let noise = |i: u32| unit_of_bits(mix(seed ^ mix(u64::from(i) << 1 | axis)));
        if seed == 0 { 0.0 } else { 0.5 * (noise(index) - noise(opposite)) / f64::from(count) }
    };
    let [x, y] = lattice.point(index);
    let flip = |axis: u32| if mix(seed ^ 0x6d69_7272).wrapping_shr(axis) & 1 == 1 && seed != 0 { -1.0 } else { 1.0 };
    Vec2::new((flip(0) * (x + within(0))) as f32, (flip(1) * (y + within(1))) as f32)
}

/// Returns a seed whose light samples and sample positions differ from those of `seed`. There are few lattices for small counts.
/// For example, 8 samples can only be in four sets of cells. Two random seeds would often have the same set, and the errors of
/// their images would be correlated.
pub fn independent_seed(samples: u32, seed: u64) -> u64 {
    let cells = |seed: u64| -> Vec<[i32; 2]> {
        (0..samples)
            .map(|i| ((jitter(i, samples, seed) + 0.5) * samples as f32).floor().as_ivec2().to_array())
            .collect()
    };
    // The sets are compared without regard to order.
    let taken: BTreeSet<[i32; 2]> = cells(seed).into_iter().collect();
    let shared = |other: u64| cells(other).iter().filter(|cell| taken.contains(*cell)).count();
    let others = (1..=TRIED).map(|k| seed ^ k << 32);
    // Of equally good seeds, the first is chosen.
    others.min_by_key(|&other| shared(other)).unwrap_or(seed)
}

/// Returns the offset of edge sample `index` of `count` in one cell of a pixel's grid, in cells, `[-½, ½]²`. The edge samples are
/// shifted by `offset`, the offset of the pixel's own sample, and wrap around in the cell. The offsets of edge samples also sum to
/// zero over all samples of a pixel.
pub fn edge_jitter(offset: Vec2, index: u32, count: u32) -> Vec2 {
    let count = count.max(1);
    let [x, y] = Lattice::known(count, 0).point(index % count);
    let moved = |position: f64, offset: f32| {
        let position = position + f64::from(offset);
        let wrapped = position - position.round();
        // A point on the border is put on the side of the offset. The mirrored offset then puts it on the opposite side.
        (if wrapped.abs() == 0.5 { 0.5f64.copysign(f64::from(offset)) } else { wrapped }) as f32
    };
    Vec2::new(moved(x, offset.x), moved(y, offset.y))
}

/// The points `i (a, b) / (count + 1)` of a rank-1 lattice, without the point for `i = 0`. Each of `count` columns and rows holds
/// one point. The set contains `-i` for every `i`, so it is symmetric about its centre.
#[derive(Clone, Copy)]
struct Lattice {
    count: u32,
    steps: [u64; 2],
}

thread_local! {
    /// The last lattice is cached, because callers sample one set at a time.
    static LAST: Cell<Option<(u64, Lattice)>> = const { Cell::new(None) };
}

/// The steps of the R2 sequence, which are the reciprocals of the plastic number and of its square. R2 spreads any number of points
/// well, and is independent of similar sequences, such as the one that selects the lights of the reference.
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
/// The number of seeds that one search tries.
const TRIED: u64 = 16;
/// The largest number of samples for which the best lattice is searched exhaustively.
const SEARCHED: u32 = 256;

impl Lattice {
    fn known(count: u32, seed: u64) -> Self {
        match LAST.get() {
            Some((known, lattice)) if known == seed && lattice.count == count => lattice,
            _ => {
                let lattice = Self::new(count, seed);
                LAST.set(Some((seed, lattice)));
                lattice
            }
        }
    }

    fn new(count: u32, seed: u64) -> Self {
        let modulus = u64::from(count) + 1;
        let near = |step: f64| -> Vec<u64> {
            let middle = (step * modulus as f64).round() as i64;
            (middle - 16..=middle + 16)
                .filter(|&s| s > 0 && (s as u64) < modulus && greatest_common_divisor(s as u64, modulus) == 1)
                .map(|s| s as u64)
                .collect()
        };
        let [across, down] = STEPS.map(near);
        let pairs = || across.iter().flat_map(|&a| down.iter().map(move |&b| [a, b]));
        // For large sets, only the first points are compared. R2 keeps the further points equally far apart.
        let score = |steps: [u64; 2]| shortest(steps, modulus, count.min(SEARCHED) / 2);
        let scored: Vec<([u64; 2], f64)> = pairs().map(|steps| (steps, score(steps))).collect();
        let best = scored.iter().map(|&(_, score)| score).fold(0.0, f64::max);
        let good: Vec<[u64; 2]> = scored.iter().filter(|&&(_, score)| score >= 0.6 * best).map(|&(s, _)| s).collect();
        let first = scored.iter().find(|&&(_, score)| score == best).map_or([1, 1], |&(steps, _)| steps);
        let steps = match good.len() as u64 {
            0 => [1, 1],
            _ if seed == 0 => first,
            many => good[(mix(seed) % many) as usize],
        };
        Self { count, steps }
    }

    /// Returns a point of the lattice, in `(-½, ½)²`.
    fn point(&self, index: u32) -> [f64; 2] {
        let modulus = u64::from(self.count) + 1;
        self.steps.map(|step| {
            let position = (u64::from(index) + 1) * step % modulus;
            (2.0 * position as f64 - modulus as f64) / f64::from(2 * self.count)
        })
    }
}

/// Returns the smallest squared distance between two points of a periodic lattice whose indices differ by at most `reach`.
fn shortest(steps: [u64; 2], modulus: u64, reach: u32) -> f64 {
    let along = |i: u64, step: u64| {
        let position = i * step % modulus;
        position.min(modulus - position) as f64
    };
    let square = |i: u64| along(i, steps[0]).powi(2) + along(i, steps[1]).powi(2);
    (1..=u64::from(reach.max(1))).map(square).fold(f64::INFINITY, f64::min)
}

/// Returns pseudorandom bits that are computed from a number.
fn mix(number: u64) -> u64 {
    Random(number).bits()
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_set_shifts_a_picture() {
        for seed in [0, 1, 99] {
            assert_eq!(jitter(0, 1, seed), Vec2::ZERO);
            for count in (1..=130).chain([256, 999, 4096]) {
                let points: Vec<Vec2> = (0..count).map(|i| jitter(i, count, seed)).collect();
                assert!(points.iter().all(|p| p.abs().max_element() < 0.5));
                // Each sample has an exact opposite. The offsets therefore sum to zero at any precision.
                for i in 0..count as usize {
                    assert_eq!(points[i], -points[count as usize - 1 - i], "{count} {seed}");
                }
                if count <= 130 {
                    for axis in [0, 1] {
                        let mut cells: Vec<u32> =
                            points.iter().map(|p| ((p[axis] + 0.5) * count as f32) as u32).collect();
                        cells.sort_unstable();
                        assert!(cells.into_iter().eq(0..count), "{count} {seed}: a column or row for each");
                    }
                }
            }
        }
    }

    /// Returns the root mean square error of the coverage of a half plane, over many edges through the pixel.
    fn edge_error(points: &[Vec2]) -> f32 {
        let (mut sum, mut n) = (0.0, 0.0);
        for i in 0..96 {
            let normal = Vec2::from_angle(std::f32::consts::TAU * i as f32 / 96.0);
            for k in 0..16 {
                let offset = 0.45 * ((k as f32 + 0.5) / 8.0 - 1.0);
                let inside = |p: &Vec2| f32::from(u8::from(p.dot(normal) < offset));
                let share = points.iter().map(inside).sum::<f32>() / points.len() as f32;
                let fine = 128;
                let mut truth = 0.0;
                for j in 0..fine * fine {
                    let p = Vec2::new((j % fine) as f32, (j / fine) as f32) + 0.5;
                    truth += inside(&(p / fine as f32 - 0.5));
                }
                sum += (share - truth / (fine * fine) as f32).powi(2);
                n += 1.0;
            }
        }
        (sum / n as f32).sqrt()
    }

    #[test]
    fn samples_find_edges_better_than_random_ones() {
        for (count, bound) in [(4u32, 0.125), (16, 0.05), (64, 0.018)] {
            for seed in [0, 7] {
                let error = edge_error(&(0..count).map(|i| jitter(i, count, seed)).collect::<Vec<_>>());
                println!("{count} samples, seed {seed}: {error:.4}; random ones {:.4}", 0.45 / (count as f32).sqrt());
                assert!(error < bound, "{count} {seed}: {error}");
            }
        }
    }

    #[test]
    fn seeds_are_other_sets() {
        for count in [4u32, 64, 512] {
            let sets: Vec<Vec<Vec2>> =
                (0..6).map(|seed| (0..count).map(|i| jitter(i, count, seed)).collect()).collect();
            for a in 0..6 {
                for b in 0..a {
                    // Counts the points that nearly coincide with a point of the second set.
                    let near = |p: &&Vec2| sets[b].iter().any(|q| p.distance(*q) < 0.02 / (count as f32).sqrt());
                    assert!(sets[a].iter().filter(near).count() <= count as usize / 4, "{count}: {a} and {b}");
                }
            }
        }
    }

    #[test]
    fn seeds_apart_share_few_cells() {
        for count in [4u32, 5, 6, 8, 12, 16, 32, 64, 256] {
            let cells = |seed: u64| -> Vec<[i32; 2]> {
                let mut cells: Vec<_> = (0..count)
                    .map(|i| ((jitter(i, count, seed) + 0.5) * count as f32).floor().as_ivec2().to_array())
                    .collect();
                cells.sort_unstable();
                cells
            };
            let shared = |a: u64, b: u64| {
                let b = cells(b);
                cells(a).iter().filter(|cell| b.binary_search(cell).is_ok()).count()
            };
            let apart = (0..64).map(|seed| shared(seed, independent_seed(count, seed))).max().unwrap();
            let next = (0..64).map(|seed| shared(seed, seed + 1)).max().unwrap();
            println!(
                "{count} samples: {apart} of them in the cells of the seed apart, up to {next} in those of the next seed"
            );
            assert!(apart <= count as usize / 4, "{count}: {apart}");
            // The next seed would have exactly the same cells.
            assert!(count != 8 || next == 8, "{next}");
        }
        assert_ne!(independent_seed(1, 3), 3);
    }

    #[test]
    fn edge_samples_cover_their_cell() {
        assert_eq!(edge_jitter(Vec2::ZERO, 0, 1), Vec2::ZERO);
        for count in 1..=64 {
            for offset in [Vec2::ZERO, jitter(3, 8, 5), Vec2::splat(-0.5)] {
                let points: Vec<Vec2> = (0..count).map(|i| edge_jitter(offset, i, count)).collect();
                assert!(points.iter().all(|p| p.abs().max_element() <= 0.5));
                // Every row and every column has one point.
                for axis in [0, 1] {
                    let mut coordinates: Vec<f32> = points.iter().map(|p| p[axis]).collect();
                    coordinates.sort_by(f32::total_cmp);
                    assert!(
                        coordinates.windows(2).all(|w| ((w[1] - w[0]) * count as f32 - 1.0).abs() < 1e-3),
                        "{coordinates:?}"
                    );
                }
            }
            // The edge samples of all samples of a pixel also sum to zero.
            for samples in [1, 2, 4, 7] {
                let offsets = (0..samples).map(|i| jitter(i, samples, 0));
                let mean: Vec2 = offsets.flat_map(|o| (0..count).map(move |i| edge_jitter(o, i, count))).sum();
                assert!(mean.length() < 1e-4 * (samples * count) as f32, "{samples} {count}: {mean}");
            }
        }
    }
}
