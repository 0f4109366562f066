//! The measured materials of a scene's objects. Each material occurs once.

use std::sync::Arc;

use crate::constants::MAX_FITS;
use crate::scene::Object;
use leadr_gpu::{GpuError, Result};
use leadr_reflectance::materials::fitted_table::FittedTable;

/// The largest number of values in all tables together. Start offsets are stored as floats, which are exact up to this number.
const MOST_WORDS: usize = (1 << 24) - MAX_FITS as usize;

/// The measured materials of a scene.
#[derive(Clone, Debug, Default)]
pub struct Fits(Vec<Arc<FittedTable>>);

impl Fits {
    /// Collects the materials of these objects.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for more than `MAX_FITS` materials, or if the tables are too large for offsets in floats.
    pub fn of(objects: &[Object]) -> Result<Self> {
        let mut all: Vec<Arc<FittedTable>> = Vec::new();
        for fit in objects.iter().filter_map(fit_of) {
            if !all.contains(fit) {
                all.push(fit.clone());
            }
        }
        if all.len() > MAX_FITS as usize {
            let fault = format!("{} measured materials exceed the limit of {MAX_FITS}", all.len());
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        let words: usize = all.iter().map(|fit| fit.words().len()).sum();
        if words > MOST_WORDS {
            let fault = format!("the measured materials contain {words} numbers, above the limit of {MOST_WORDS}");
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        Ok(Self(all))
    }

    /// Returns the number of an object's measured material, counted from 1, or 0 without one.
    pub fn number_of(&self, object: &Object) -> u32 {
        let index = fit_of(object).and_then(|fit| self.0.iter().position(|known| known == fit));
        index.map_or(0, |index| index as u32 + 1)
    }

    /// Returns the start offsets of the materials, followed by the tables of the materials (`passes/shade/fits.glsl`).
    pub fn words(&self) -> Vec<f32> {
        let mut at = self.0.len();
        let mut words = Vec::new();
        for fit in &self.0 {
            words.push(at as f32);
            at += fit.words().len();
        }
        words.extend(self.0.iter().flat_map(|fit| fit.words()));
        words
    }
}

fn fit_of(object: &Object) -> Option<&Arc<FittedTable>> {
    object.material.as_ref()?.fit.as_ref()
}
