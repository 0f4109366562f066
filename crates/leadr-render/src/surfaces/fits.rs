//! The measured materials of a scene's objects, each once.

use std::sync::Arc;

use crate::constants::MAX_FITS;
use crate::scene::Object;
use leadr_gpu::{GpuError, Result};
use leadr_reflectance::materials::fitted_table::FittedTable;

/// Most numbers of all together: where each begins is a float, which counts so far.
const MOST_WORDS: usize = (1 << 24) - MAX_FITS as usize;

/// Those of a scene.
#[derive(Clone, Debug, Default)]
pub struct Fits(Vec<Arc<FittedTable>>);

impl Fits {
    /// Of all these objects.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for more than `MAX_FITS`, or tables too large for a float to count.
    pub fn of(objects: &[Object]) -> Result<Self> {
        let mut all: Vec<Arc<FittedTable>> = Vec::new();
        for fit in objects.iter().filter_map(fit_of) {
            if !all.contains(fit) {
                all.push(fit.clone());
            }
        }
        if all.len() > MAX_FITS as usize {
            let fault = format!("{} measured materials are more than {MAX_FITS}", all.len());
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        let words: usize = all.iter().map(|fit| fit.words().len()).sum();
        if words > MOST_WORDS {
            let fault = format!("its measured materials take {words} numbers, more than {MOST_WORDS}");
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        Ok(Self(all))
    }

    /// The number of an object's, from 1, or 0 if it has none.
    pub fn number_of(&self, object: &Object) -> u32 {
        let place = fit_of(object).and_then(|fit| self.0.iter().position(|known| known == fit));
        place.map_or(0, |place| place as u32 + 1)
    }

    /// Where each material begins, then one after another (`passes/shade/fits.glsl`).
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
