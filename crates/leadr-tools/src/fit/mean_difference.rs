//! The mean ΔE₀₀ image of several materials, for each model (thesis Figure 4.2).

use crate::fit::models::NAMES;
use crate::fit::spheres::delta_e_of;
use crate::metrics::compare::magma;
use leadr_maps::{Rgb8Image, RgbImage};

/// The ΔE₀₀ that the image draws in its brightest colour.
pub const MOST_DELTA_E: f64 = 20.0;

/// The sums of ΔE₀₀ over materials. All spheres have the same size.
pub struct MeanDifference {
    size: u32,
    models: [(Vec<f64>, u32); NAMES.len()],
}

impl MeanDifference {
    /// Creates empty sums for spheres of `size` pixels across.
    pub fn new(size: u32) -> Self {
        Self { size, models: std::array::from_fn(|_| (vec![0.0; (size * size) as usize], 0)) }
    }

    /// Adds the sphere of a model to the sums of this model. Unknown names are ignored.
    pub fn add(&mut self, model: &str, measured: &RgbImage, fitted: &RgbImage) {
        let Some(index) = NAMES.iter().position(|name| *name == model) else { return };
        let (sums, count) = &mut self.models[index];
        sums.iter_mut().zip(delta_e_of(measured, fitted)).for_each(|(sum, delta)| *sum += delta);
        *count += 1;
    }

    /// Returns the number of materials of each model, in the order of [`NAMES`].
    pub fn counts(&self) -> [u32; NAMES.len()] {
        self.models.each_ref().map(|(_, count)| *count)
    }

    /// Returns the mean ΔE₀₀ of every model side by side, in the magma colour map from 0 to [`MOST_DELTA_E`]. Models without materials are
    /// black.
    pub fn image(&self) -> Rgb8Image {
        let (size, width) = (self.size as usize, self.size as usize * NAMES.len());
        let mut values = vec![0.0; width * size];
        for (k, (sums, count)) in self.models.iter().enumerate() {
            for (i, sum) in sums.iter().enumerate() {
                let mean = sum / f64::from((*count).max(1));
                values[i / size * width + k * size + i % size] = (mean / MOST_DELTA_E).min(1.0) as f32;
            }
        }
        magma(width as u32, self.size, &values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_over_the_materials_of_a_model() {
        let sphere = |grey: f32| RgbImage { width: 8, height: 8, texels: vec![[grey; 3]; 64] };
        let mut mean = MeanDifference::new(8);
        mean.add("thesis", &sphere(0.5), &sphere(0.5));
        let once = mean.image();
        mean.add("thesis", &sphere(0.5), &sphere(0.1));
        mean.add("ABC", &sphere(0.5), &sphere(0.1));
        mean.add("unknown", &sphere(0.5), &sphere(0.1));
        assert_eq!(mean.counts(), [0, 0, 2, 0, 0, 0, 1]);
        let image = mean.image();
        assert_eq!((image.width, image.height), (56, 8));
        let bright = |image: &Rgb8Image, model: usize| {
            image.texels[4 * 56 + 8 * model + 4].iter().map(|&c| u32::from(c)).sum::<u32>()
        };
        assert!(bright(&once, 2) < 20 && bright(&image, 2) > 100, "{} {}", bright(&once, 2), bright(&image, 2));
        assert!(bright(&image, 6) > bright(&image, 2) && bright(&image, 0) < 20);
    }
}
