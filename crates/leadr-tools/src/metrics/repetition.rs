//! A measure of visible tiling: the autocorrelation of a picture.

use leadr_maps::RgbImage;

/// Returns the autocorrelation of a picture's luminance at an offset of `lag` pixels, from -1 to 1 (exact repetition). Means
/// over squares as wide as the lag are subtracted first, because slow changes correlate without repetition. The result is 0
/// for a constant picture, and for a picture that is no larger than the lag.
pub fn repetition(image: &RgbImage, lag: [u32; 2]) -> f64 {
    let [width, height] = [image.width as usize, image.height as usize];
    let [right, down] = lag.map(|pixels| pixels as usize);
    if right >= width || down >= height {
        return 0.0;
    }
    let luminance = |c: &[f32; 3]| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
    let mut left: Vec<f64> = image.texels.iter().map(luminance).collect();
    let side = right.max(down).max(1);
    let slow = box_means(&box_means(&left, width, side), height, side);
    left.iter_mut().zip(slow).for_each(|(value, slow)| *value -= slow);
    let (mut here, mut there, mut both) = (0.0, 0.0, 0.0);
    for y in 0..height - down {
        for x in 0..width - right {
            let (a, b) = (left[y * width + x], left[(y + down) * width + x + right]);
            here += a * a;
            there += b * b;
            both += a * b;
        }
    }
    if here * there > 0.0 { both / (here * there).sqrt() } else { 0.0 }
}

/// Returns the transposed sliding means over `side` values along rows of `width` values. Fewer values count at the ends of a
/// row.
fn box_means(values: &[f64], width: usize, side: usize) -> Vec<f64> {
    let height = values.len() / width;
    let mut means = vec![0.0; values.len()];
    for (y, row) in values.chunks(width).enumerate() {
        let mut sums = vec![0.0; width + 1];
        for (x, value) in row.iter().enumerate() {
            sums[x + 1] = sums[x] + value;
        }
        for x in 0..width {
            let (low, high) = (x.saturating_sub(side / 2), (x + side / 2 + 1).min(width));
            means[x * height + y] = (sums[high] - sums[low]) / (high - low) as f64;
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::random::Random;

    fn picture(of: impl Fn(usize, usize) -> f32) -> RgbImage {
        let texels = (0..96 * 80).map(|i| [of(i % 96, i / 96); 3]).collect();
        RgbImage::new(96, 80, texels).unwrap()
    }

    #[test]
    fn repetition_is_detected() {
        let mut r = Random::stream(1, 0);
        let noise: Vec<f32> = (0..96 * 80).map(|_| r.unit() as f32).collect();
        let repeats = picture(|x, y| noise[y % 10 * 96 + x % 12]);
        assert!((repetition(&repeats, [12, 0]) - 1.0).abs() < 0.05);
        assert!((repetition(&repeats, [12, 10]) - 1.0).abs() < 0.05);
        assert!(repetition(&repeats, [7, 0]).abs() < 0.5);
        assert!(repetition(&picture(|x, y| noise[y * 96 + x]), [12, 0]).abs() < 0.05);
    }

    #[test]
    fn slow_changes_are_no_repeats() {
        let mut r = Random::stream(2, 0);
        let noise: Vec<f32> = (0..96 * 80).map(|_| r.unit() as f32).collect();
        let drift = picture(|x, y| noise[y * 96 + x] + (x + y) as f32 * 0.05);
        assert!(repetition(&drift, [12, 0]).abs() < 0.15);
        assert_eq!(repetition(&picture(|_, _| 0.5), [12, 0]), 0.0);
        assert_eq!(repetition(&drift, [96, 0]), 0.0);
    }
}
