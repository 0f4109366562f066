//! Horizons of the occluders within a distance (Chan 2018, eq. 43, "for some finite distance d").
//!
//! A ray of length `d` meets the relief at `x` columns only if its rise is at most that of the sphere of radius `d` about the
//! texel. The horizon is therefore the largest of the rises within the sphere, each limited by the sphere. Below the horizon, all
//! directions count as hidden. Unlike those of an unlimited reach, horizons may be below the horizontal.
//!
//! The points within the reach of a texel are a window that moves along the line. The line is cut into blocks of the length of the
//! window, so that the window is the end of a block and the start of the next block. Both parts only grow if the texels are
//! processed in the order that suits the part, and so the hull of each part is updated like that of
//! [`sweep`](super::sweep). A search among all points is left for the few texels whose steepest point is outside the sphere.

use super::sweep::{Hull, NEAR};
use crate::Wrap;

/// The rise of a horizon without occluders.
const NO_RISE: f32 = f32::MIN;

/// The distance up to which occluders count, in the units of a line: columns along the line, and texels of height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// The square of the distance in texels.
    square: f32,
    /// The square of the length of a column along the line, in texels.
    column_square: f32,
}

impl Reach {
    /// The largest distance in texels. The square of a larger one would lose the heights.
    const MOST: f32 = 1e9;

    /// Creates the reach of `distance` texels along lines that rise by `tangent` rows per column.
    pub fn new(distance: f32, tangent: f64) -> Self {
        let distance = distance.clamp(0.0, Self::MOST);
        Self { square: distance * distance, column_square: (1.0 + tangent * tangent) as f32 }
    }

    /// Returns the number of columns within reach.
    pub fn columns(&self) -> f32 {
        (self.square / self.column_square).sqrt().floor()
    }

    /// Returns the square of the sphere's rise at a number of columns. Outside the sphere, it is negative.
    fn edge_square(&self, columns: f32) -> f32 {
        self.square / (columns * columns) - self.column_square
    }

    /// Returns the rise of the part within reach of an occluder with this rise, at a number of columns.
    pub fn clip(&self, columns: f32, rise: f32) -> f32 {
        let edge = self.edge_square(columns);
        if rise * rise <= edge {
            rise
        } else if rise > 0.0 && edge > 0.0 {
            edge.sqrt()
        } else {
            NO_RISE
        }
    }

    /// Returns the rise to the most distant point within reach on level ground, which begins at a number of columns. Ground
    /// above the texel hides at least the directions below the horizontal.
    fn ground(&self, fall: f32, columns: f32) -> f32 {
        let fall = fall.max(0.0);
        let far = ((self.square - fall * fall) / self.column_square).max(0.0).sqrt();
        if far > 0.0 && far >= columns { -fall / far } else { NO_RISE }
    }
}

/// The points of a line, and the search for the horizons of its texels.
#[derive(Default)]
pub(super) struct Nearby {
    /// The points as whole columns and heights, in order of increasing columns.
    pub points: Vec<[f32; 2]>,
    /// The texels as columns and heights. The columns are consecutive.
    pub texels: Vec<[f32; 2]>,
    hull: Hull,
    /// The steepest rise of each texel and its distance, for the end of the block in front of the texel's own.
    steepest: Vec<[f32; 2]>,
}

impl Nearby {
    /// Removes all points and texels.
    pub fn clear(&mut self) {
        self.points.clear();
        self.texels.clear();
    }

    /// Computes the rises ahead and behind of all texels, which are [`f32::MIN`] without an occluder. On a map that does not
    /// repeat, level ground continues the line on both sides. The points and texels are mirrored.
    pub fn rises(&mut self, reach: &Reach, wrap: Wrap, rises: &mut [[f32; 2]]) {
        self.behind(reach, wrap, |k, rise| rises[k][1] = rise);
        for list in [&mut self.points, &mut self.texels] {
            list.reverse();
            list.iter_mut().for_each(|point| point[0] = -point[0]);
        }
        let last = self.texels.len() - 1;
        self.behind(reach, wrap, |k, rise| rises[last - k][0] = rise);
    }

    /// Calls `store` with each texel's index and the rise towards smaller columns.
    fn behind(&mut self, reach: &Reach, wrap: Wrap, mut store: impl FnMut(usize, f32)) {
        let columns = reach.columns();
        // The nearest columns of a texel are not in its window.
        let window = columns as i64 - NEAR as i64;
        if window > 0 {
            self.search_ends(window);
        } else {
            self.steepest.clear();
            self.steepest.resize(self.texels.len(), [NO_RISE, 0.0]);
        }
        let Self { points, texels, hull, steepest } = self;
        hull.clear();
        let (mut next, mut block_end) = (0, i64::MIN);
        for (k, (&[x, z], &of_end)) in texels.iter().zip(&*steepest).enumerate() {
            let near = x as i64 - NEAR as i64 - 1;
            while let Some(&[at, height]) = points.get(next).filter(|point| point[0] as i64 <= near && window > 0) {
                if at as i64 >= block_end {
                    block_end = ((at as i64).div_euclid(window) + 1) * window;
                    hull.clear();
                }
                hull.push(at, height);
                next += 1;
            }
            let of_start = if near < block_end { hull.steepest(x, z) } else { [NO_RISE, 0.0] };
            let [rise, distance] = if of_start[0] >= of_end[0] { of_start } else { of_end };
            let mut best = reach.clip(distance.max(1.0), rise);
            if best < rise {
                best = NO_RISE;
                for &[at, height] in points[..next].iter().rev() {
                    let distance = x - at;
                    let edge = reach.edge_square(distance);
                    if edge < 0.0 || best >= 0.0 && best * best >= edge {
                        break;
                    }
                    best = best.max(reach.clip(distance, (height - z) / distance));
                }
            }
            if wrap == Wrap::Clamp {
                let [at, height] = points[0];
                best = best.max(reach.ground(z - height, x - at));
            }
            store(k, best);
        }
    }

    /// Finds the steepest point of each texel among those points of its window that are in the block before the block of its
    /// nearest point.
    fn search_ends(&mut self, window: i64) {
        let Self { points, texels, hull, steepest } = self;
        steepest.clear();
        hull.clear();
        let (mut next, mut block_start) = (points.len(), i64::MAX);
        for &[x, z] in texels.iter().rev() {
            let near = x as i64 - NEAR as i64 - 1;
            if near < block_start {
                block_start = near.div_euclid(window) * window;
                hull.clear();
                while next > 0 && points[next - 1][0] as i64 >= block_start {
                    next -= 1;
                }
            }
            while next > 0 && points[next - 1][0] as i64 > near - window {
                next -= 1;
                // The hull is that of the mirrored line.
                hull.push(-points[next][0], points[next][1]);
            }
            steepest.push(hull.steepest_far(-x, z));
        }
        steepest.reverse();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / (1 << 24) as f32
    }

    /// Returns the horizon towards smaller columns by a search among all points.
    fn searched(points: &[[f32; 2]], [x, z]: [f32; 2], reach: &Reach, wrap: Wrap) -> f32 {
        let mut best = NO_RISE;
        for &[at, height] in points.iter().filter(|point| x - point[0] > NEAR as f32) {
            best = best.max(reach.clip(x - at, (height - z) / (x - at)));
        }
        if wrap == Wrap::Clamp {
            let [at, height] = points[0];
            for step in 0..=4096 {
                let far = x - at + step as f32 * (reach.columns() + 1.0) / 4096.0;
                best = best.max(if far > 0.0 { reach.clip(far, (height.min(z) - z) / far) } else { NO_RISE });
            }
        }
        best
    }

    #[test]
    fn windows_match_a_search_among_all_points() {
        let mut state = 7;
        let mut nearby = Nearby::default();
        let (mut clipped, mut below, mut most) = (0, 0, [0.0f32; 2]);
        for case in 0..600 {
            let wrap = if case % 2 == 0 { Wrap::Repeat } else { Wrap::Clamp };
            let count = 1 + (60.0 * random(&mut state)) as usize;
            let amplitude = [0.3, 3.0, 40.0][case % 3];
            let distance = [0.5, 1.0, 2.5, 3.0, 3.7, 5.0, 8.0, 21.0, 40.0, 1e4][case % 10];
            let reach = Reach::new(distance, 2.0 * f64::from(random(&mut state)) - 1.0);
            let mut height = |x: f32| amplitude * (random(&mut state) + (0.3 * x).sin());
            // Repeats have points beyond both ends, with gaps.
            let mut columns: Vec<f32> = (0..count).map(|x| x as f32).collect();
            if wrap == Wrap::Repeat {
                let end = count as f32;
                columns.splice(0..0, [-40.0, -32.0, -24.0, -9.0, -8.0, -7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0]);
                columns.extend([0.0, 1.0, 2.0, 3.0, 4.0, 11.0, 19.0].map(|x| end + x));
            }
            nearby.clear();
            nearby.points.extend(columns.iter().map(|&x| [x, height(x)]));
            nearby.texels.extend((0..count).map(|x| [x as f32, height(x as f32)]));
            let (points, texels) = (nearby.points.clone(), nearby.texels.clone());
            let mirrored: Vec<[f32; 2]> = points.iter().rev().map(|&[x, z]| [-x, z]).collect();
            let mut rises = vec![[0.0; 2]; count];
            nearby.rises(&reach, wrap, &mut rises);
            for (&[x, z], found) in texels.iter().zip(rises) {
                let wanted = [searched(&mirrored, [-x, z], &reach, wrap), searched(&points, [x, z], &reach, wrap)];
                for (found, wanted) in found.into_iter().zip(wanted) {
                    if found == NO_RISE || wanted == NO_RISE {
                        // The search may miss the small part of the ground that is within reach.
                        assert!(found == wanted || wrap == Wrap::Clamp && found < 0.0, "{case} {x}: {found} {wanted}");
                        continue;
                    }
                    let tolerance = if wrap == Wrap::Clamp && wanted < 0.0 { 0.01 } else { 1e-5 };
                    let apart = (found - wanted) / wanted.abs().max(1.0);
                    most = [most[0].min(apart), most[1].max(apart)];
                    assert!(apart > -1e-5 && apart < tolerance, "{case} {x}: {found} {wanted}");
                    below += u32::from(found < 0.0);
                }
                let all = Reach::new(1e8, 0.0);
                clipped += u32::from(wanted[0] < searched(&mirrored, [-x, z], &all, wrap));
            }
        }
        println!("{clipped} clipped, {below} below the horizontal, errors {most:?}");
        assert!(clipped > 1000 && below > 1000, "{clipped} {below}");
    }

    #[test]
    fn the_sphere_limits_rises() {
        // The distance is 5 texels, along a line whose columns are one texel apart.
        let reach = Reach::new(5.0, 0.0);
        assert_eq!(reach.columns(), 5.0);
        assert_eq!([reach.clip(3.0, 1.0), reach.clip(3.0, -1.0)], [1.0, -1.0]);
        // At 3 texels, the sphere is 4 texels high and deep.
        assert!((reach.clip(3.0, 2.0) - 4.0 / 3.0).abs() < 1e-6);
        assert_eq!([reach.clip(3.0, -2.0), reach.clip(5.1, 1.0), reach.clip(5.1, 0.0)], [NO_RISE; 3]);
        assert_eq!(Reach::new(5.0, 1.0).columns(), 3.0);
        assert!((reach.ground(3.0, 2.0) + 0.75).abs() < 1e-6);
        assert_eq!([reach.ground(3.0, 4.5), reach.ground(6.0, 0.0)], [NO_RISE; 2]);
    }
}
