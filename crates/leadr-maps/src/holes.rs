//! Holes in height maps: texels that scanners and elevation models mark as missing.

use super::MapFault;

/// Values that elevation models store where they know no height.
const MARKS: [f32; 5] = [-9999.0, -10_000.0, -32_768.0, -32_767.0, -99_999.0];
/// Values beyond this one mark a hole too: they are the limits of 32-bit floats.
const BEYOND: f32 = 1e37;
/// The largest share of holes that is filled.
const MOST: f64 = 0.5;

/// Fills the holes of a map from their neighbours, and returns a remark if there are any.
///
/// A hole is NaN, infinite, next to the limits of 32-bit floats, or `declared`. Marks of elevation models such as -9999 count if
/// they lie further below all other heights than those heights are apart. As a half float, -9999 is -10000. `is_cropped` says that
/// the file stores only a part of the map, and the rest is NaN.
///
/// # Errors
/// Fails if more than half of the map is missing.
pub(crate) fn fill(
    width: u32,
    texels: &mut [f32],
    declared: Option<f32>,
    is_cropped: bool,
) -> Result<Option<String>, MapFault> {
    let mark = declared.or_else(|| mark(texels));
    let is_hole = |h: f32| !h.is_finite() || h.abs() >= BEYOND || Some(h) == mark;
    let missing: Vec<bool> = texels.iter().map(|&h| is_hole(h)).collect();
    let count = missing.iter().filter(|&&hole| hole).count();
    if count == 0 {
        return Ok(None);
    }
    let share = count as f64 / texels.len() as f64;
    let percent = 100.0 * share;
    let named = match mark {
        Some(mark) => format!(" ({mark})"),
        None if is_cropped => " (its data window is a part of its display window)".to_owned(),
        None => String::new(),
    };
    let exact = if percent < 0.01 { 4 } else { 2 };
    if share > MOST {
        let what = format!("{percent:.1} % of its heights are missing{named}");
        return Err(MapFault::unsupported(what, "give a map with at least half of its heights"));
    }
    for (texel, _) in texels.iter_mut().zip(&missing).filter(|(_, hole)| **hole) {
        *texel = f32::NAN;
    }
    fill_from_coarser(width as usize, texels);
    Ok(Some(format!("{percent:.exact$} % of its heights are missing{named}; they are filled from their neighbours")))
}

/// Returns the value that marks holes.
fn mark(texels: &[f32]) -> Option<f32> {
    let finite = || texels.iter().copied().filter(|h| h.abs() < BEYOND);
    let least = finite().fold(f32::INFINITY, f32::min);
    let [low, high] = finite()
        .filter(|&h| h > least)
        .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)]);
    (MARKS.contains(&least) && low - least > high - low).then_some(least)
}

/// Replaces NaN by the heights of a map of half the size, whose texels are the means of the known texels.
fn fill_from_coarser(width: usize, texels: &mut [f32]) {
    if texels.iter().all(|h| !h.is_nan()) {
        return;
    }
    let height = texels.len() / width;
    let [half_width, half_height] = [width.div_ceil(2), height.div_ceil(2)];
    let mut coarse = Vec::with_capacity(half_width * half_height);
    for y in 0..half_height {
        for x in 0..half_width {
            let (mut sum, mut known) = (0.0f64, 0u32);
            for row in 2 * y..(2 * y + 2).min(height) {
                let columns = 2 * x..(2 * x + 2).min(width);
                for &h in texels[row * width..][columns].iter().filter(|h| !h.is_nan()) {
                    (sum, known) = (sum + f64::from(h), known + 1);
                }
            }
            coarse.push((sum / f64::from(known)) as f32);
        }
    }
    fill_from_coarser(half_width, &mut coarse);
    // The centre of a texel lies a quarter of a coarse texel beside the centre of its coarse texel.
    let beside = |k: usize, most: usize| {
        let near = k / 2;
        let far = if k.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(most - 1) };
        [(near, 0.75), (far, 0.25)]
    };
    for (index, texel) in texels.iter_mut().enumerate().filter(|(_, h)| h.is_nan()) {
        let (columns, rows) = (beside(index % width, half_width), beside(index / width, half_height));
        *texel = rows
            .iter()
            .flat_map(|(y, v)| columns.iter().map(move |(x, u)| (y * half_width + x, u * v)))
            .map(|(at, weight): (usize, f32)| weight * coarse[at])
            .sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a slope of 200 m to 263 m with holes.
    fn slope(hole: f32) -> Vec<f32> {
        let is_hole = |i: usize| (20..26).contains(&(i % 64)) && (8..14).contains(&(i / 64)) || i == 0;
        (0..64 * 32).map(|i| if is_hole(i) { hole } else { 200.0 + (i % 64) as f32 }).collect()
    }

    #[test]
    fn holes_are_filled_from_their_neighbours() {
        for hole in [-9999.0, -10_000.0, -32_768.0, -3.402_823_5e38, -3.4e38, f32::NAN, f32::INFINITY] {
            let mut texels = slope(hole);
            let remark = fill(64, &mut texels, None, false).unwrap().unwrap();
            assert!(remark.starts_with("1.81 % of its heights are missing"), "{remark}");
            for (i, h) in texels.iter().enumerate() {
                let expected = 200.0 + (i % 64) as f32;
                assert!((h - expected).abs() < 4.0, "{hole}: {h} instead of {expected}");
            }
        }
    }

    #[test]
    fn heights_that_look_like_marks_are_kept() {
        // A deep sea reaches -9999 m.
        let sea: Vec<f32> = (0..64 * 32).map(|i| -9999.0 + 5.0 * i as f32).collect();
        for heights in [sea, vec![0.0, -9000.0, -32.0, 7.0]] {
            let mut texels = heights.clone();
            assert_eq!(fill(2, &mut texels, None, false).unwrap(), None);
            assert_eq!(texels, heights);
        }
        let mut declared = vec![7.0, 1.0, 2.0, 3.0];
        assert!(
            fill(2, &mut declared, Some(7.0), false)
                .unwrap()
                .unwrap()
                .contains("25.00 % of its heights are missing (7)")
        );
        assert_eq!(declared[1..], [1.0, 2.0, 3.0]);
        assert!(declared[0] > 1.0 && declared[0] < 3.0);
    }

    #[test]
    fn mostly_missing_heights_are_refused() {
        let mut texels = vec![f32::NAN, f32::NAN, f32::NAN, 1.0];
        assert!(
            fill(2, &mut texels, None, false).unwrap_err().to_string().contains("75.0 % of its heights are missing")
        );
        assert!(fill(1, &mut [f32::NAN], None, false).is_err() && fill(2, &mut [-9999.0; 4], None, false).is_err());
        let mut half = vec![f32::NAN, f32::NAN, 1.0, 1.0];
        assert!(fill(2, &mut half, None, true).unwrap().is_some());
        assert_eq!(half, [1.0; 4]);
    }
}
