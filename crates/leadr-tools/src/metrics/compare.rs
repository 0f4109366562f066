//! Differences between two pictures, measured by FLIP on the displayed colours and by norms of the linear values.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageFloat, FlipImageRgb8, flip, magma_lut};

use super::Mask;
use leadr_maps::tonemap::{Tonemap, display_image};
use leadr_maps::{MapFault, Rgb8Image, RgbImage};

/// The result of [`compare`].
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The mean FLIP error, from 0 (equal) to 1.
    pub flip: f64,
    /// The relative root mean square error, as in [`rrmse`].
    pub rrmse: f64,
    /// The largest absolute difference of a linear channel.
    pub max_abs: f64,
    /// The width in texels.
    pub width: u32,
    /// The height in texels.
    pub height: u32,
    /// The FLIP error of each texel, from 0 to 1, in row-major order.
    pub flip_map: Vec<f32>,
}

/// Compares two linear pictures of the same size.
///
/// FLIP is the LDR metric of Andersson et al. 2020 at 67 pixels per degree, for a 4K screen that is 0.7 m wide and 0.7 m
/// away. FLIP compares the pictures after the same `exposure` and `tonemap`. For pictures from PNG files use exposure 1 and
/// [`Tonemap::Clamp`], which restore the codes of the file. The norms compare the linear values. Fails if the sizes differ,
/// or if either picture has a NaN or infinity. Without this check, a NaN would pass every threshold.
pub fn compare(reference: &RgbImage, test: &RgbImage, exposure: f32, tonemap: Tonemap) -> Result<Comparison, MapFault> {
    compare_over(reference, test, exposure, tonemap, &Mask::all(reference.width, reference.height))
}

/// Like [`compare`], but measures only the pixels of `mask`. FLIP blurs the whole pictures, so pixels within a few pixels of the mask
/// still affect the error at its border. The error map is 0 outside the mask. Also fails if the size of the mask differs.
pub fn compare_over(
    reference: &RgbImage,
    test: &RgbImage,
    exposure: f32,
    tonemap: Tonemap,
    mask: &Mask,
) -> Result<Comparison, MapFault> {
    same_size("the reference is", size_of(reference), "the test", size_of(test))?;
    reference.check_finite()?;
    test.check_finite()?;
    let flip_image = |image: &RgbImage| {
        let codes = display_image(image, exposure, tonemap);
        FlipImageRgb8::with_data(image.width, image.height, codes.texels.as_flattened())
    };
    let (width, height) = size_of(reference);
    let mut max_abs = 0.0f64;
    for_each_channel(reference, test, mask, |r, t| max_abs = max_abs.max((r - t).abs()))?;
    let mut flip_map = flip(flip_image(reference), flip_image(test), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    flip_map.iter_mut().zip(&mask.inside).filter(|(_, inside)| !**inside).for_each(|(error, _)| *error = 0.0);
    let measured =
        Comparison { flip: 0.0, rrmse: rrmse_over(reference, test, mask)?, max_abs, width, height, flip_map };
    Ok(Comparison { flip: measured.flip_over(mask), ..measured })
}

/// Returns the relative root mean square error over all channels: the norm of the difference divided by the norm of the
/// reference. The error is 0 for equal pictures, 1 for a black test picture, and infinite if only the reference is black.
/// Fails if the sizes differ.
pub fn rrmse(reference: &RgbImage, test: &RgbImage) -> Result<f64, MapFault> {
    rrmse_over(reference, test, &Mask::all(reference.width, reference.height))
}

/// Returns the [`rrmse`] over the pixels of `mask`, or 0 for an empty mask. Fails if the sizes differ.
pub fn rrmse_over(reference: &RgbImage, test: &RgbImage, mask: &Mask) -> Result<f64, MapFault> {
    let (mut difference, mut norm) = (0.0f64, 0.0f64);
    for_each_channel(reference, test, mask, |r, t| {
        difference += (r - t) * (r - t);
        norm += r * r;
    })?;
    // For two black pictures, the quotient would be 0/0.
    Ok(if difference == 0.0 { 0.0 } else { (difference / norm).sqrt() })
}

/// Returns the relative bias over the pixels of `mask`: the sum of the test over the sum of the reference, minus 1. A
/// positive bias means that the test is too bright. The bias is 0 if both pictures are black, and infinite if only the
/// reference is black. Fails if the sizes differ.
pub fn bias_over(reference: &RgbImage, test: &RgbImage, mask: &Mask) -> Result<f64, MapFault> {
    let (mut difference, mut sum) = (0.0f64, 0.0f64);
    for_each_channel(reference, test, mask, |r, t| {
        difference += t - r;
        sum += r;
    })?;
    Ok(if difference == 0.0 { 0.0 } else { difference / sum })
}

fn for_each_channel(
    reference: &RgbImage,
    test: &RgbImage,
    mask: &Mask,
    mut visit: impl FnMut(f64, f64),
) -> Result<(), MapFault> {
    same_size("the reference is", size_of(reference), "the test", size_of(test))?;
    same_size("the pictures are", size_of(test), "the mask", (mask.width, mask.height))?;
    let pixels = reference.texels.iter().zip(&test.texels).zip(&mask.inside);
    for ((r, t), _) in pixels.filter(|&(_, &inside)| inside) {
        for c in 0..3 {
            visit(f64::from(r[c]), f64::from(t[c]));
        }
    }
    Ok(())
}

impl Comparison {
    /// Returns the larger one of each error. Panics if the sizes differ.
    #[must_use]
    pub fn larger(self, other: Self) -> Self {
        assert_eq!((self.width, self.height), (other.width, other.height), "pictures of two sizes");
        let flip_map = self.flip_map.iter().zip(&other.flip_map).map(|(a, b)| a.max(*b)).collect();
        let [flip, rrmse, max_abs] =
            [(self.flip, other.flip), (self.rrmse, other.rrmse), (self.max_abs, other.max_abs)].map(|(a, b)| a.max(b));
        Self { flip, rrmse, max_abs, flip_map, ..self }
    }

    /// Returns the mean FLIP error over the pixels of `mask`, or 0 for an empty mask. FLIP blurs the whole pictures, so a few
    /// pixels around the mask still affect the mean. Panics if the sizes differ.
    pub fn flip_over(&self, mask: &Mask) -> f64 {
        assert_eq!((self.width, self.height), (mask.width, mask.height), "a mask of another size");
        let errors = self.flip_map.iter().zip(&mask.inside).filter(|&(_, &inside)| inside);
        let sum: f64 = errors.map(|(&e, _)| f64::from(e)).sum();
        sum / mask.count().max(1) as f64
    }

    /// Returns the FLIP error of each texel in the magma colour map, from black (0) to pale yellow (1).
    pub fn error_image(&self) -> Rgb8Image {
        magma(self.width, self.height, &self.flip_map)
    }
}

/// Returns values from 0 to 1 in the magma colour map, from black (0) to pale yellow (1).
pub fn magma(width: u32, height: u32, values: &[f32]) -> Rgb8Image {
    let codes = FlipImageFloat::with_data(width, height, values).apply_color_lut(&magma_lut()).to_vec();
    Rgb8Image { width, height, texels: codes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect() }
}

/// Checks that two sizes are equal. `a` and `b` name the sizes in the error message.
pub(super) fn same_size(a: &str, of_a: (u32, u32), b: &str, of_b: (u32, u32)) -> Result<(), MapFault> {
    if of_a == of_b {
        return Ok(());
    }
    Err(MapFault::SizeMismatch { what: format!("{a} {} x {} and {b} {} x {}", of_a.0, of_a.1, of_b.0, of_b.1) })
}

pub(super) fn size_of(image: &RgbImage) -> (u32, u32) {
    (image.width, image.height)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: u32 = 64;

    /// Returns a picture of textured ground under a gradient, scaled by `gain`. A ball is drawn at a position, if given.
    fn scene(ball: Option<[f32; 2]>, gain: f32) -> RgbImage {
        let texels = (0..SIZE * SIZE).map(|i| {
            let (x, y) = ((i % SIZE) as f32, (i / SIZE) as f32);
            let stripes = 0.2 + 0.1 * (x * 0.9).sin() * (y * 0.7).cos() + 0.2 * y / SIZE as f32;
            let inside = ball.is_some_and(|[bx, by]| (x - bx).hypot(y - by) < 4.0);
            let color = if inside { [0.9, 0.2, 0.1] } else { [stripes, stripes, 1.2 * stripes] };
            color.map(|v| v * gain)
        });
        RgbImage::new(SIZE, SIZE, texels.collect()).unwrap()
    }

    fn against(test: &RgbImage) -> Comparison {
        compare(&scene(Some([40.0, 24.0]), 1.0), test, 1.0, Tonemap::Filmic).unwrap()
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let c = against(&scene(Some([40.0, 24.0]), 1.0));
        assert_eq!((c.flip, c.rrmse, c.max_abs), (0.0, 0.0, 0.0));
        let black = RgbImage::new(4, 4, vec![[0.0; 3]; 16]).unwrap();
        assert_eq!(rrmse(&black, &black).unwrap(), 0.0);
        assert!(c.error_image().texels.iter().all(|&t| t == c.error_image().texels[0]));
    }

    #[test]
    fn a_mask_limits_every_measure() {
        let test = scene(Some([40.0, 24.0]), 1.0);
        let mut reference = test.clone();
        reference.texels[0] = [1.0; 3];
        let at = |index: usize| Mask { width: SIZE, height: SIZE, inside: (0..64 * 64).map(|i| i == index).collect() };
        let over = |mask: &Mask| compare_over(&reference, &test, 1.0, Tonemap::Clamp, mask).unwrap();
        let (there, away) = (over(&at(0)), over(&at(40 * 64 + 40)));
        assert_eq!((away.flip, away.rrmse, away.max_abs), (0.0, 0.0, 0.0));
        assert!(there.flip > 0.3 && there.rrmse > 0.3 && there.max_abs > 0.5, "{} {}", there.flip, there.rrmse);
        assert!(there.flip_map[1..].iter().all(|&error| error == 0.0));
        let narrow = compare_over(&reference, &test, 1.0, Tonemap::Clamp, &Mask::all(3, 2));
        assert!(narrow.unwrap_err().to_string().contains("3 x 2"));
    }

    /// Checks faults that a threshold of 0.01 mean FLIP must detect, and the further metrics that must detect them.
    #[test]
    fn faults_are_detected() {
        let vanished = against(&scene(None, 1.0));
        // The ball covers one percent of the picture, so the mean is small but the peak is large.
        let peak = vanished.flip_map.iter().fold(0.0f32, |a, &b| a.max(b));
        assert!(vanished.flip > 0.01 && peak > 0.4 && vanished.rrmse > 0.1, "{} {peak}", vanished.flip);
        let moved = against(&scene(Some([41.0, 24.0]), 1.0));
        assert!(moved.flip > 0.001 && moved.flip < vanished.flip && moved.max_abs > 0.3, "{}", moved.flip);
        let original = scene(Some([40.0, 24.0]), 1.0);
        let mut shifted = original.clone();
        for row in shifted.texels.chunks_exact_mut(SIZE as usize) {
            row.rotate_right(1);
        }
        let shifted = against(&shifted);
        assert!(shifted.flip > 0.01 && shifted.rrmse > 0.05, "{}", shifted.flip);
        let brighter = against(&scene(Some([40.0, 24.0]), 1.2));
        assert!(brighter.flip > 0.01 && (brighter.rrmse - 0.2).abs() < 1e-5, "{} {}", brighter.flip, brighter.rrmse);
        let black = RgbImage::new(SIZE, SIZE, vec![[0.0; 3]; (SIZE * SIZE) as usize]).unwrap();
        assert!(against(&black).rrmse == 1.0 && against(&black).flip > 0.3);
        // FLIP hardly detects a change that is far below one code, but the norms do.
        let nudged = against(&scene(Some([40.0, 24.0]), 1.00001));
        assert!(nudged.flip < 1e-3 && (nudged.rrmse / 1e-5 - 1.0).abs() < 0.05, "{} {}", nudged.flip, nudged.rrmse);
    }

    /// The mask excludes two thirds of the picture, including the fault.
    #[test]
    fn masks_exclude_faults() {
        let coverage: Vec<f32> = (0..SIZE * SIZE).map(|i| if i % SIZE < SIZE / 3 { 1.0 } else { 0.0 }).collect();
        let left = Mask::covered(SIZE, SIZE, &coverage, 0.5).unwrap();
        let all = Mask::all(SIZE, SIZE);
        let (reference, test) = (scene(Some([40.0, 24.0]), 1.0), scene(None, 1.0));
        let c = against(&test);
        assert!(c.flip_over(&left) < 1e-3 && (c.flip_over(&all) - c.flip).abs() < 1e-12);
        assert_eq!(rrmse_over(&reference, &test, &left).unwrap(), 0.0);
        assert_eq!(rrmse_over(&reference, &test, &all).unwrap(), c.rrmse);
        assert!(rrmse_over(&reference, &test, &all.without(&left)).unwrap() > c.rrmse);
        let brighter = scene(Some([40.0, 24.0]), 1.25);
        assert!((bias_over(&reference, &brighter, &left).unwrap() - 0.25).abs() < 1e-6);
        assert!(bias_over(&reference, &test, &all).unwrap() < -0.001, "a bright ball is gone");
        let none = left.without(&left);
        assert_eq!((none.count(), rrmse_over(&reference, &brighter, &none).unwrap()), (0, 0.0));
        assert_eq!((c.flip_over(&none), bias_over(&reference, &brighter, &none).unwrap()), (0.0, 0.0));
        assert!(rrmse_over(&reference, &test, &Mask::all(2, 2)).is_err());
    }

    #[test]
    fn error_image_is_bright_where_the_error_is() {
        let c = against(&scene(None, 1.0));
        let image = c.error_image();
        let brightness =
            |x: u32, y: u32| image.texels[(y * SIZE + x) as usize].iter().map(|&v| u32::from(v)).sum::<u32>();
        assert!(brightness(40, 24) > 200 && brightness(5, 60) < 30);
    }

    #[test]
    fn sizes_and_nan_are_refused() {
        let small = RgbImage::new(2, 2, vec![[0.5; 3]; 4]).unwrap();
        let message = compare(&scene(None, 1.0), &small, 1.0, Tonemap::Clamp).unwrap_err().to_string();
        assert!(message.contains("64 x 64") && message.contains("2 x 2"), "{message}");
        let mut nan = small.clone();
        nan.texels[3][1] = f32::NAN;
        let message = compare(&small, &nan, 1.0, Tonemap::Clamp).unwrap_err().to_string();
        assert!(message.contains("channel G at x = 1, y = 1"), "{message}");
        assert_eq!(rrmse(&RgbImage::new(2, 2, vec![[0.0; 3]; 4]).unwrap(), &small).unwrap(), f64::INFINITY);
    }
}
