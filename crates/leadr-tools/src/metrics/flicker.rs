//! Flicker of a sequence: the changes between consecutive pictures that a reference sequence does not have.
//!
//! A camera that moves away shrinks the picture, so consecutive pictures differ even without flicker. Two steps remove the
//! difference. First, [`shrunk`] resamples the earlier picture to the later view. The resampling is exact in the plane of
//! the camera's target, and approximate elsewhere. Second, [`excess`] subtracts the change of a reference. Resampling blur,
//! parallax and real changes of light occur in both sequences and cancel, but popping and aliasing remain.

use super::Mask;
use super::compare::{same_size, size_of};
use leadr_maps::{MapFault, RgbImage};

/// The magnitude of a change, in units of linear radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Magnitude {
    /// The mean of `|change|` over pixels and channels.
    pub mean: f64,
    /// The largest `|change|` of a pixel, averaged over channels.
    pub max: f64,
    /// The RMS of the change over pixels and channels.
    pub rms: f64,
}

/// Returns `image` as seen from `ratio` (at least 1) times the distance, scaled about the centre. Each pixel of the result
/// is the area-weighted mean over the `ratio × ratio` covered pixels of `image`. Colours at the border of `image` continue
/// beyond the border.
///
/// Fails if `ratio` is below 1 or not finite.
pub fn shrunk(image: &RgbImage, ratio: f64) -> Result<RgbImage, MapFault> {
    if !(ratio.is_finite() && ratio >= 1.0) {
        let what = format!("a picture cannot be seen from {ratio} times as far");
        return Err(MapFault::Unsupported { what, remedy: "give a ratio of at least 1".into() });
    }
    let columns = cover(image.width, ratio);
    let rows = cover(image.height, ratio);
    let mut texels = Vec::with_capacity(image.texels.len());
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0f64; 3];
            for &(y, v) in row {
                for &(x, u) in column {
                    let texel = image.texels[y as usize * image.width as usize + x as usize];
                    for (sum, value) in sum.iter_mut().zip(texel) {
                        *sum += u * v * f64::from(value);
                    }
                }
            }
            texels.push(sum.map(|s| s as f32));
        }
    }
    RgbImage::new(image.width, image.height, texels)
}

/// Returns the pixels that each of `size` pixels of a line covers in a line at `1 / ratio` of the distance. The weights of
/// each sum to 1.
fn cover(size: u32, ratio: f64) -> Vec<Vec<(u32, f64)>> {
    let middle = f64::from(size) / 2.0;
    (0..size)
        .map(|pixel| {
            let low = middle + (f64::from(pixel) - middle) * ratio;
            let high = low + ratio;
            let mut shares: Vec<(u32, f64)> = Vec::new();
            for source in low.floor() as i64..high.ceil() as i64 {
                let share = (high.min(source as f64 + 1.0) - low.max(source as f64)) / ratio;
                let source = source.clamp(0, i64::from(size) - 1) as u32;
                match shares.last_mut() {
                    Some(last) if last.0 == source => last.1 += share,
                    _ => shares.push((source, share)),
                }
            }
            shares
        })
        .collect()
}

/// Returns the signed change of every pixel from `before` to `after`, in the view of `after`. The camera of `after` is
/// `ratio` times as far away. Fails if the sizes differ, or if [`shrunk`] fails.
pub fn change(before: &RgbImage, after: &RgbImage, ratio: f64) -> Result<RgbImage, MapFault> {
    difference(after, &shrunk(before, ratio)?)
}

/// Returns `a − b` for every pixel. Fails if the sizes differ.
pub fn difference(a: &RgbImage, b: &RgbImage) -> Result<RgbImage, MapFault> {
    same_size("one picture is", size_of(a), "the other", size_of(b))?;
    let texels = a.texels.iter().zip(&b.texels).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect();
    RgbImage::new(a.width, a.height, texels)
}

/// Returns the magnitude of a change over the pixels of `mask`. The magnitude is zero for an empty mask. Fails if the sizes
/// differ.
pub fn magnitude(change: &RgbImage, mask: &Mask) -> Result<Magnitude, MapFault> {
    same_size("the change is", size_of(change), "its mask", (mask.width, mask.height))?;
    let (mut sum, mut max, mut squares, mut count) = (0.0, 0.0f64, 0.0, 0usize);
    for (texel, _) in change.texels.iter().zip(&mask.inside).filter(|&(_, &inside)| inside) {
        let pixel = texel.iter().map(|&v| f64::from(v).abs()).sum::<f64>() / 3.0;
        squares += texel.iter().map(|&v| f64::from(v) * f64::from(v)).sum::<f64>() / 3.0;
        sum += pixel;
        // `f64::max` would ignore a NaN.
        max = if pixel.is_nan() { pixel } else { max.max(pixel) };
        count += 1;
    }
    let count = count.max(1) as f64;
    Ok(Magnitude { mean: sum / count, max, rms: (squares / count).sqrt() })
}

/// Returns the flicker of one step, which is the magnitude of a technique's `change` minus the reference's `own` change.
/// Fails if the sizes differ.
pub fn excess(change: &RgbImage, own: &RgbImage, mask: &Mask) -> Result<Magnitude, MapFault> {
    magnitude(&difference(change, own)?, mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: u32 = 48;

    /// Returns a striped disc of radius 0.9, where the picture's half side is `distance`. Each pixel is the mean of `n × n`
    /// points.
    fn disc(distance: f64, n: u32, pop: bool) -> RgbImage {
        let texels = (0..SIZE * SIZE).map(|i| {
            let mut sum = 0.0;
            for k in 0..n * n {
                let at = |pixel: u32, k: u32| {
                    ((f64::from(pixel) + (f64::from(k) + 0.5) / f64::from(n)) / f64::from(SIZE) * 2.0 - 1.0) * distance
                };
                let (x, y) = (at(i % SIZE, k % n), at(i / SIZE, k / n));
                let stripes = 0.5 + 0.3 * (9.0 * x).sin() * (7.0 * y).cos();
                sum += if x.hypot(y) < 0.9 { stripes } else { 0.05 };
            }
            let value = (sum / f64::from(n * n)) as f32;
            let popped = pop && (20..24).contains(&(i % SIZE)) && (20..24).contains(&(i / SIZE));
            [if popped { value * 1.2 } else { value }; 3]
        });
        RgbImage::new(SIZE, SIZE, texels.collect()).unwrap()
    }

    fn step(before: &RgbImage, after: &RgbImage, ratio: f64) -> Magnitude {
        magnitude(&change(before, after, ratio).unwrap(), &Mask::all(SIZE, SIZE)).unwrap()
    }

    #[test]
    fn a_still_sequence_does_not_flicker() {
        let still = disc(1.0, 4, false);
        let none = Magnitude { mean: 0.0, max: 0.0, rms: 0.0 };
        assert_eq!(step(&still, &still, 1.0), none);
        let own = change(&still, &still, 1.0).unwrap();
        assert_eq!(excess(&own, &own, &Mask::all(SIZE, SIZE)).unwrap(), none);
    }

    #[test]
    fn a_zoom_is_aligned_before_it_is_compared() {
        let (near, far) = (disc(1.0, 16, false), disc(1.05, 16, false));
        let (aligned, raw) = (step(&near, &far, 1.05), step(&near, &far, 1.0));
        assert!(aligned.mean < raw.mean / 4.0, "{aligned:?} {raw:?}");
        // Shrinking by two averages four pixels.
        let half = shrunk(&near, 2.0).unwrap();
        let mean = (near.at(24, 24)[0] + near.at(25, 24)[0] + near.at(24, 25)[0] + near.at(25, 25)[0]) / 4.0;
        assert!((half.at(24, 24)[0] - mean).abs() < 1e-6);
        assert!((shrunk(&near, 1.3).unwrap().at(0, 0)[0] - 0.05).abs() < 1e-6, "the border colour must extend");
    }

    /// A change of 20 % in 16 of 2304 pixels is detected during a zoom, with the correct magnitude and mean.
    #[test]
    fn popping_is_detected_against_reference() {
        let (near, far, popped) = (disc(1.0, 8, false), disc(1.05, 8, false), disc(1.05, 8, true));
        let own = change(&near, &far, 1.05).unwrap();
        let all = Mask::all(SIZE, SIZE);
        let flicker = excess(&change(&near, &popped, 1.05).unwrap(), &own, &all).unwrap();
        let expected: f64 = (0..16)
            .map(|k| f64::from(popped.at(20 + k % 4, 20 + k / 4)[0] - far.at(20 + k % 4, 20 + k / 4)[0]))
            .sum::<f64>()
            / f64::from(SIZE * SIZE);
        assert!((flicker.mean / expected - 1.0).abs() < 1e-4, "{flicker:?} {expected}");
        assert!(flicker.max > 0.05 && flicker.max < 0.16, "{flicker:?}");
        assert_eq!(excess(&own, &own, &all).unwrap().max, 0.0);
        // Aliasing with one sample per pixel also counts as flicker.
        let aliased = change(&disc(1.0, 1, false), &disc(1.05, 1, false), 1.05).unwrap();
        assert!(excess(&aliased, &own, &all).unwrap().mean > 1e-3);
    }

    #[test]
    fn bad_arguments_and_nan_are_not_hidden() {
        let picture = disc(1.0, 1, false);
        for ratio in [0.5, 0.0, f64::NAN, f64::INFINITY] {
            assert!(shrunk(&picture, ratio).is_err(), "{ratio}");
        }
        let small = RgbImage::new(1, 1, vec![[0.0; 3]]).unwrap();
        assert!(change(&picture, &small, 1.0).is_err() && magnitude(&small, &Mask::all(2, 1)).is_err());
        let mut broken = picture.clone();
        broken.texels[7][1] = f32::NAN;
        let flicker = step(&picture, &broken, 1.0);
        assert!(flicker.max.is_nan() || flicker.mean.is_nan(), "{flicker:?}");
    }
}
