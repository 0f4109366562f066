//! Statistics of times that are measured on a busy machine: medians, percentiles, paired ratios and straight lines.

use serde::Serialize;

/// Returns the quantile `p` (0 to 1), interpolated linearly between the two nearest values. Returns 0 if there are no
/// values.
pub fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let position = p.clamp(0.0, 1.0) * last as f64;
    let (low, high) = (sorted[position.floor() as usize], sorted[position.ceil() as usize]);
    low + (high - low) * position.fract()
}

/// Returns the median: the middle value, or the mean of the two middle values.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// A ratio of two rows' times, from interleaved rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// The median of the ratios within each round.
    pub median: f64,
    /// The lower quartile of the ratios within rounds.
    pub low: f64,
    /// The upper quartile of the ratios within rounds.
    pub high: f64,
    /// The ratio of the fastest frames over all rounds. Other programs disturb the fastest frames least.
    pub fastest: f64,
    /// The number of rounds that measured both rows.
    pub pairs: usize,
}

/// Computes the ratios `of[i] / to[i]` over all rounds with both values. A slowdown of a whole round thus cancels. Returns
/// `None` if no round has both values.
pub fn paired_ratio(of: &[Option<f64>], to: &[Option<f64>]) -> Option<Ratio> {
    let pairs = of.iter().zip(to).filter_map(|(of, to)| Some(((*of)?, (*to)?))).filter(|(_, to)| *to > 0.0);
    let (of, to): (Vec<f64>, Vec<f64>) = pairs.unzip();
    let ratios: Vec<f64> = of.iter().zip(&to).map(|(of, to)| of / to).collect();
    let at = |p| quantile(&ratios, p);
    let fastest = quantile(&of, 0.0) / quantile(&to, 0.0);
    let ratio = Ratio { median: at(0.5), low: at(0.25), high: at(0.75), fastest, pairs: ratios.len() };
    (!ratios.is_empty()).then_some(ratio)
}

/// A least-squares line through points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Line {
    /// The value of the line at 0.
    #[serde(rename = "intercept_ms")]
    pub intercept: f64,
    /// The slope of the line, per unit.
    #[serde(rename = "per_sample_ms")]
    pub slope: f64,
    /// The fraction of the variance that the line explains, at most 1.
    pub r_squared: f64,
    /// The largest deviation of a point from the line, relative to the line's value at the point.
    pub worst: f64,
}

/// Fits `y = intercept + slope · x`. Returns `None` for fewer than two different `x`.
pub fn least_squares(points: &[(f64, f64)]) -> Option<Line> {
    let count = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / count;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|&(x, y)| f(x - mx, y - my)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    if points.len() < 2 || xx <= 0.0 {
        return None;
    }
    let slope = xy / xx;
    let intercept = my - slope * mx;
    let miss = |&(x, y): &(f64, f64)| y - (intercept + slope * x);
    let residual = points.iter().map(|p| miss(p).powi(2)).sum::<f64>();
    let worst = points.iter().map(|p| (miss(p) / (intercept + slope * p.0)).abs()).fold(0.0, f64::max);
    Some(Line { intercept, slope, r_squared: if yy > 0.0 { 1.0 - residual / yy } else { 1.0 }, worst })
}

/// Returns each value once, in the order of first occurrence.
pub(super) fn in_order<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut seen, value| {
        if !seen.contains(&value) {
            seen.push(value);
        }
        seen
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_known_values() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&[]), 0.0);
        let hundred: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(quantile(&hundred, 0.95), 95.0);
        assert_eq!((quantile(&hundred, 0.0), quantile(&hundred, 2.0)), (0.0, 100.0));
    }

    #[test]
    fn paired_ratios_cancel_slow_rounds() {
        // The machine slows down eightfold in the middle, and one frame is interrupted.
        let load = [1.0, 1.0, 2.0, 8.0, 8.0, 8.0, 3.0];
        let of: Vec<_> = load.iter().map(|l| Some(1.5 * l)).collect();
        let mut to: Vec<_> = load.iter().map(|l| Some(*l)).collect();
        to[2] = Some(90.0);
        let ratio = paired_ratio(&of, &to).unwrap();
        assert_eq!((ratio.median, ratio.high, ratio.pairs), (1.5, 1.5, 7));
        let uneven = paired_ratio(&[Some(8.0), Some(2.0)], &[Some(1.0), Some(5.0)]).unwrap();
        assert_eq!((uneven.fastest, uneven.median), (2.0, 4.2));
        // The ratio of the rows' medians is wrong, because the rows were measured in different rounds.
        let alone = median(&[1.5, 1.5, 3.0]) / median(&[8.0, 8.0, 3.0]);
        assert!(alone < 0.5);
    }

    #[test]
    fn rounds_without_both_are_left_out() {
        let ratio = paired_ratio(&[Some(2.0), None, Some(9.0)], &[Some(1.0), Some(1.0), None]).unwrap();
        assert_eq!((ratio.median, ratio.pairs), (2.0, 1));
        assert_eq!(paired_ratio(&[None], &[Some(1.0)]), None);
        assert_eq!(paired_ratio(&[Some(1.0)], &[Some(0.0)]), None, "nothing can be compared with a time of 0");
    }

    #[test]
    fn lines_are_distinguished_from_curves() {
        let on =
            |f: fn(f64) -> f64| -> Vec<(f64, f64)> { (1..=16).map(|n| (f64::from(n * n), f(f64::from(n)))).collect() };
        let line = least_squares(&on(|n| 14.0 + 7.5 * n * n)).unwrap();
        assert!((line.intercept - 14.0).abs() < 1e-9 && (line.slope - 7.5).abs() < 1e-12);
        assert!(line.r_squared > 1.0 - 1e-12 && line.worst < 1e-9);
        let curve = least_squares(&on(|n| n.powi(4))).unwrap();
        assert!(curve.r_squared < 0.95 && curve.worst > 0.5, "{curve:?}");
        assert_eq!(least_squares(&[(1.0, 1.0), (1.0, 2.0)]), None);
    }
}
