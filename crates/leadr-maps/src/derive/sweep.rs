//! Horizons along parallel lines, found by convex hulls (Timonen and Westerholm 2010, "Scalable height field
//! self-shadowing").
//!
//! Parallel lines cross every column of the map, and each texel belongs to its closest line. Where a line passes between two
//! texels of a column, the heights of the texels are interpolated. The upper hull of a line's points is updated as the line
//! advances. A texel's horizon is the tangent from the texel to the hull, which is found in one or two steps. The reach is
//! unlimited ([`reach`](super::reach) limits it), and the cost per texel does not depend on the relief.
//!
//! A texel uses its own height, extrapolated along its slope to the line, instead of the height of the line. The two nearest
//! columns on either side are computed exactly, at the crossings of a ray that starts at the texel itself
//! ([`occlusion`](super::occlusion)).

use rayon::prelude::*;

use super::reach::{Nearby, Reach};
use crate::Wrap;

/// The number of columns on either side of a texel where ray crossings are exact. Hulls begin beyond the exact columns.
pub(super) const NEAR: usize = 2;
/// The ratio of cell sizes between successive coarser copies of the map. Each copy is used beyond this number of its own
/// cells.
const COARSER: usize = 8;

/// A height field with row-major heights in units of texels.
pub(super) struct Field {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<f32>,
    pub wrap: Wrap,
    /// The means over 8 x 8, 64 x 64 … texels, which approximate distant ground before the start of a line.
    coarse: Vec<Coarse>,
}

struct Coarse {
    width: usize,
    height: usize,
    texels: Vec<f32>,
}

/// The rise per column of the horizons ahead (towards higher columns) and behind. With an unlimited reach, negative rises become
/// 0.
pub(super) struct Horizons {
    /// The row offset of the lines in each column, relative to column 0.
    pub shifts: Vec<i64>,
    /// The row of the first line in column 0.
    first: i64,
    width: usize,
    lines: usize,
    wrap: Wrap,
    values: Vec<[f32; 2]>,
}

impl Field {
    pub fn new(width: usize, height: usize, texels: Vec<f32>, wrap: Wrap) -> Self {
        let mut coarse: Vec<Coarse> = Vec::new();
        if wrap == Wrap::Repeat {
            let mut size = [width, height];
            while size[0].max(size[1]) > 1 {
                let from = coarse.last().map_or(&texels[..], |level| &level.texels);
                let next = Coarse::averaged(from, size);
                size = [next.width, next.height];
                coarse.push(next);
            }
        }
        Self { width, height, texels, wrap, coarse }
    }

    /// Returns the interpolated height at a fractional row of a column. The position may lie outside the map.
    fn at(&self, x: i64, y: f32) -> f32 {
        let low = y.floor();
        let part = y - low;
        let column = self.wrap.texel(x, self.width as u32);
        let [a, b] =
            [0, 1].map(|k| self.texels[self.wrap.texel(low as i64 + k, self.height as u32) * self.width + column]);
        a + part * (b - a)
    }

    /// Returns the mean height of the coarse cell at a position.
    fn far(&self, level: usize, x: f64, y: f64) -> f32 {
        let coarse = &self.coarse[level];
        let cell = |v: f64, of: usize, cells: usize| {
            let part = v / of as f64;
            (((part - part.floor()) * cells as f64) as usize).min(cells - 1)
        };
        coarse.texels[cell(y, self.height, coarse.height) * coarse.width + cell(x, self.width, coarse.width)]
    }

    /// Returns the horizons along all lines that rise by `tangent` rows per column. `tangent` is from -1 to 1. `reach` limits the
    /// occluders that count.
    pub fn horizons(&self, tangent: f64, reach: Option<&Reach>) -> Horizons {
        let shifts: Vec<i64> = (0..self.width).map(|x| (x as f64 * tangent).round() as i64).collect();
        let (low, high) = (shifts[self.width - 1].min(0), shifts[self.width - 1].max(0));
        // On a non-repeating map, lines also enter through the top and bottom edges.
        let (first, lines) =
            if self.wrap == Wrap::Repeat { (0, self.height) } else { (-high, self.height + (high - low) as usize) };
        let mut values = vec![[0.0; 2]; lines * self.width];
        let range = self.texels.iter().fold([f32::MAX, f32::MIN], |[a, b], &h| [a.min(h), b.max(h)]);
        let before = self.before(tangent, f64::from(range[1] - range[0]), reach);
        values.par_chunks_mut(self.width).enumerate().with_min_len(16).for_each_init(
            || (Vec::with_capacity(self.width), Hull::default(), Nearby::default()),
            |(line, hull, nearby), (k, out)| {
                let start = first + k as i64;
                let inside =
                    |x: &usize| self.wrap == Wrap::Repeat || (0..self.height as i64).contains(&(start + shifts[*x]));
                // The texels of a line are contiguous.
                let Some(from) = (0..self.width).find(inside) else { return };
                let to = (from..self.width).find(|x| !inside(x)).unwrap_or(self.width);
                let own = |x: usize| self.moved(x, start + shifts[x], (start as f64 + x as f64 * tangent) as f32);
                let more = if self.wrap == Wrap::Repeat { NEAR as i64 } else { 0 };
                let first = from as i64 - more;
                self.fill(line, start, tangent, first..to as i64 + more);
                let last = self.width as f32 - 1.0;
                if let Some(reach) = reach {
                    nearby.clear();
                    for &[distance, level] in before.iter().rev() {
                        nearby.points.push([-distance, self.beyond(start, tangent, -distance, level)]);
                    }
                    nearby.points.extend((first..).zip(&*line).map(|(x, &z)| [x as f32, z]));
                    for &[distance, level] in &before {
                        let x = last + distance;
                        nearby.points.push([x, self.beyond(start, tangent, x, level)]);
                    }
                    nearby.texels.extend((from..to).map(|x| [x as f32, own(x)]));
                    nearby.rises(reach, self.wrap, &mut out[from..to]);
                    return;
                }
                let on_line = |x: i64| line.get(usize::try_from(x - first).ok()?).copied();
                hull.clear();
                for &[distance, level] in before.iter().rev() {
                    hull.push(-distance, self.beyond(start, tangent, -distance, level));
                }
                for (x, rises) in out.iter_mut().enumerate().take(to).skip(from) {
                    let own = own(x);
                    *rises = [own, hull.rise(x as f32, own)];
                    // The next column treats its nearest columns exactly, so its hull excludes them.
                    let passed = x as i64 - NEAR as i64;
                    if let Some(z) = on_line(passed) {
                        hull.push(passed as f32, z);
                    }
                }
                // The reverse direction counts columns from the end.
                hull.clear();
                for &[distance, level] in before.iter().rev() {
                    hull.push(-distance, self.beyond(start, tangent, last + distance, level));
                }
                for x in (from..to).rev() {
                    out[x][0] = hull.rise(last - x as f32, out[x][0]);
                    let passed = (x + NEAR) as i64;
                    if let Some(z) = on_line(passed) {
                        hull.push(last - passed as f32, z);
                    }
                }
            },
        );
        Horizons { shifts, first, width: self.width, lines, wrap: self.wrap, values }
    }

    /// Returns the sample distances before the first column, from near to far, each with the index of the coarse copy to
    /// sample. Index 0 is the map itself. The list ends at the reach, or where no rise of 1/64 is possible. Within a limited
    /// reach, the first repeat of the map is exact.
    fn before(&self, tangent: f64, range: f64, reach: Option<&Reach>) -> Vec<[f32; 2]> {
        let mut found = Vec::new();
        if self.wrap == Wrap::Clamp {
            return found;
        }
        let (most, exact) = (64.0 * range / (1.0 + tangent * tangent).sqrt(), (COARSER * COARSER) as f64);
        let (most, exact) = reach.map_or((most, exact), |reach| {
            let columns = f64::from(reach.columns());
            (most.min(columns), exact.max(columns.min(self.width.max(self.height) as f64)))
        });
        let (mut distance, mut level, mut cell) = ((NEAR + 1) as f64, 0, 1usize);
        // The coarsest copy has a single height.
        while distance <= most && level < self.coarse.len() {
            if distance >= exact * cell as f64 {
                level += 1;
                cell *= COARSER;
                continue;
            }
            found.push([distance as f32, level as f32]);
            distance += cell as f64;
        }
        found
    }

    /// Returns the height of a texel, extrapolated along its slope to the point where a line crosses the texel's column.
    fn moved(&self, x: usize, row: i64, line: f32) -> f32 {
        let aside = line - row as f32;
        let [a, own, b] = [-1, 0, 1].map(|step| {
            let y = row + step;
            let inside = (0..self.height as i64).contains(&y);
            self.texels[(if inside { y as usize } else { self.wrap.texel(y, self.height as u32) }) * self.width + x]
        });
        own + 0.5 * aside * (b - a)
    }

    /// Returns the height along a line before the first column or after the last column.
    fn beyond(&self, start: i64, tangent: f64, x: f32, level: f32) -> f32 {
        let y = start as f64 + f64::from(x) * tangent;
        match level as usize {
            0 => self.at(x as i64, y as f32),
            level => self.far(level - 1, f64::from(x) + 0.5, y + 0.5),
        }
    }

    fn fill(&self, line: &mut Vec<f32>, start: i64, tangent: f64, columns: std::ops::Range<i64>) {
        line.clear();
        let (height, width) = (self.height as i64, self.width);
        line.extend(columns.map(|x| {
            let y = start as f64 + x as f64 * tangent;
            let low = y.floor();
            let part = (y - low) as f32;
            let mut low = low as i64;
            if self.wrap == Wrap::Repeat && !(0..height).contains(&low) {
                low = low.rem_euclid(height);
            }
            if low >= 0 && low + 1 < height && (0..width as i64).contains(&x) {
                let at = low as usize * width + x as usize;
                let (a, b) = (self.texels[at], self.texels[at + width]);
                return a + part * (b - a);
            }
            self.at(x, low as f32 + part)
        }));
    }
}

impl Coarse {
    fn averaged(from: &[f32], [width, height]: [usize; 2]) -> Self {
        let [w, h] = [width.div_ceil(COARSER), height.div_ceil(COARSER)];
        let mut texels = vec![0.0; w * h];
        texels.par_chunks_mut(w).enumerate().for_each(|(y, out)| {
            for (x, out) in out.iter_mut().enumerate() {
                let part = |k: usize, of: usize, cells: usize| k * of / cells..((k + 1) * of).div_ceil(cells).min(of);
                let (columns, rows) = (part(x, width, w), part(y, height, h));
                let sum: f32 = rows.clone().map(|y| from[y * width..][columns.clone()].iter().sum::<f32>()).sum();
                *out = sum / (columns.len() * rows.len()) as f32;
            }
        });
        Self { width: w, height: h, texels }
    }
}

impl Horizons {
    /// Copies the horizons of a row of texels.
    pub fn row(&self, y: usize, [ahead, behind]: &mut [Vec<f32>; 2]) {
        for (x, shift) in self.shifts.iter().enumerate() {
            let line = y as i64 - shift - self.first;
            let line = if self.wrap == Wrap::Repeat && !(0..self.lines as i64).contains(&line) {
                line.rem_euclid(self.lines as i64)
            } else {
                line
            };
            [ahead[x], behind[x]] = self.values[line as usize * self.width + x];
        }
    }
}

/// The upper hull of points that are added in order of increasing `x`.
#[derive(Default)]
pub(super) struct Hull {
    points: Vec<[f32; 2]>,
}

impl Hull {
    pub fn clear(&mut self) {
        self.points.clear();
    }

    pub fn push(&mut self, x: f32, z: f32) {
        while let [.., a, b] = self.points[..] {
            if (b[1] - a[1]) * (x - a[0]) > (z - a[1]) * (b[0] - a[0]) {
                break;
            }
            self.points.pop();
        }
        self.points.push([x, z]);
    }

    /// Returns the steepest rise from a position beyond the last point to the hull's points, at least 0.
    fn rise(&self, x: f32, z: f32) -> f32 {
        self.steepest(x, z)[0].max(0.0)
    }

    /// Returns the steepest rise from a position beyond the last point to the hull's points, with the distance of the point.
    /// Without points, the rise is [`f32::MIN`].
    pub fn steepest(&self, x: f32, z: f32) -> [f32; 2] {
        let mut best = [f32::MIN, 0.0];
        for point in self.points.iter().rev() {
            let distance = x - point[0];
            let rise = (point[1] - z) / distance;
            if rise <= best[0] {
                break;
            }
            best = [rise, distance];
        }
        best
    }

    /// Returns the same as [`steepest`](Self::steepest) for a position before the first point, which can be far from it.
    pub fn steepest_far(&self, x: f32, z: f32) -> [f32; 2] {
        let rise = |[at, height]: [f32; 2]| [(height - z) / (at - x), at - x];
        // The rises increase up to the tangent point, and decrease beyond.
        let (mut low, mut high) = (0, self.points.len());
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            let [before, after] = [self.points[middle - 1], self.points[middle]].map(|point| rise(point)[0]);
            if after > before { low = middle } else { high = middle }
        }
        self.points.get(low).map_or([f32::MIN, 0.0], |&point| rise(point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(width: usize, height: usize, wrap: Wrap) -> Field {
        let texel = |i: usize| ((i * 7919 + 5) % 127) as f32 / 30.0 + ((i % width) as f32 * 0.3).sin() * 4.0;
        Field::new(width, height, (0..width * height).map(texel).collect(), wrap)
    }

    /// Compares the horizons within a reach with a search among all columns, also beyond the edges of a repeating map.
    #[test]
    fn horizons_within_reach_match_exhaustive_search() {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            for (width, height, distance) in [(40, 24, 7.0), (40, 24, 38.0), (23, 37, 60.0), (5, 1, 20.0), (1, 5, 9.0)]
            {
                let field = field(width, height, wrap);
                for tangent in [0.0, 0.37, -0.8, 1.0] {
                    let reach = Reach::new(distance, tangent);
                    let horizons = field.horizons(tangent, Some(&reach));
                    let mut row = [vec![0.0; width], vec![0.0; width]];
                    for y in 0..height {
                        horizons.row(y, &mut row);
                        for (x, found) in row[0].iter().zip(&row[1]).map(|(a, b)| [*a, *b]).enumerate() {
                            let start = y as i64 - horizons.shifts[x];
                            let own = field.moved(x, y as i64, (start as f64 + x as f64 * tangent) as f32);
                            let there = |c: i64| {
                                let inside = (0..width as i64).contains(&c);
                                wrap == Wrap::Repeat
                                    || inside && (0..height as i64).contains(&(start + horizons.shifts[c as usize]))
                            };
                            for (found, side) in found.into_iter().zip([1, -1]) {
                                let rise = |step: i64| {
                                    let c = x as i64 + side * step;
                                    let z = field.at(c, (start as f64 + c as f64 * tangent) as f32);
                                    if there(c) { reach.clip(step as f32, (z - own) / step as f32) } else { f32::MIN }
                                };
                                let wanted = (NEAR as i64 + 1..=distance as i64).map(rise).fold(f32::MIN, f32::max);
                                // Level ground beyond the edges of a map that does not repeat is only below the texel.
                                let ground = wrap == Wrap::Clamp && wanted < found && found <= 0.0;
                                let apart = (found - wanted).abs();
                                assert!(
                                    apart < 1e-4 || ground,
                                    "{wrap:?} {width} {distance} {tangent} {x} {y}: {found} {wanted}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }

    /// Compares the hulls with an exhaustive search over all columns.
    #[test]
    fn hulls_match_exhaustive_search() {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            for (width, height) in [(40, 24), (23, 37), (5, 1), (1, 5), (2, 2)] {
                let field = field(width, height, wrap);
                for tangent in [0.0, 0.37, -0.8, 1.0] {
                    let horizons = field.horizons(tangent, None);
                    let mut row = [vec![0.0; width], vec![0.0; width]];
                    for y in 0..height {
                        horizons.row(y, &mut row);
                        let [ahead, behind] = &row;
                        for (x, found) in ahead.iter().zip(behind).map(|(a, b)| [*a, *b]).enumerate() {
                            let start = y as i64 - horizons.shifts[x];
                            let line = (start as f64 + x as f64 * tangent) as f32;
                            let own = field.moved(x, start + horizons.shifts[x], line);
                            // The search covers only the range in which the hulls read the map itself.
                            let seen = |side: i64| {
                                let columns = match (wrap, side) {
                                    (Wrap::Repeat, 1) => x as i64 + 3..width as i64 + 63,
                                    (Wrap::Repeat, _) => -63..x as i64 - 2,
                                    (_, 1) => x as i64 + 3..width as i64,
                                    _ => 0..x as i64 - 2,
                                };
                                let there = |c: &i64| {
                                    wrap == Wrap::Repeat
                                        || (0..height as i64).contains(&(start + horizons.shifts[*c as usize]))
                                };
                                let rise = |c: i64| {
                                    (field.at(c, (start as f64 + c as f64 * tangent) as f32) - own)
                                        / (c - x as i64).abs() as f32
                                };
                                columns.filter(there).map(rise).fold(0.0, f32::max)
                            };
                            let (ahead, behind) = (seen(1), seen(-1));
                            let apart = (found[0] - ahead).abs().max((found[1] - behind).abs());
                            // More distant ground is approximated by coarse cells.
                            let far = if wrap == Wrap::Repeat { 0.13 } else { 1e-4 };
                            assert!(
                                apart < 1e-4 || found[0].max(found[1]) < far,
                                "{wrap:?} {tangent} {x} {y}: {found:?} {ahead} {behind}"
                            );
                        }
                    }
                }
            }
        }
    }
}
