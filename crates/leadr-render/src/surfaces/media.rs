//! The media behind the surfaces of a scene. Each medium occurs once.

use crate::constants::MAX_MEDIA;
use crate::scene::{Medium, Object};
use leadr_gpu::{GpuError, Result};

/// The media of a scene.
#[derive(Clone, Debug, Default)]
pub struct Media(Vec<Medium>);

impl Media {
    /// Collects the media of these objects.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for more than `MAX_MEDIA` media.
    pub fn of(objects: &[Object]) -> Result<Self> {
        let mut all: Vec<Medium> = Vec::new();
        for medium in objects.iter().filter_map(|object| object.medium) {
            if !all.contains(&medium) {
                all.push(medium);
            }
        }
        if all.len() > MAX_MEDIA as usize {
            let fault = format!("{} transparent materials exceed the limit of {MAX_MEDIA}", all.len());
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        Ok(Self(all))
    }

    /// Returns the number of the medium of an object, counted from 1, or 0 without one.
    pub fn number_of(&self, object: &Object) -> u32 {
        let index = object.medium.and_then(|medium| self.0.iter().position(|known| *known == medium));
        index.map_or(0, |index| index as u32 + 1)
    }

    /// Returns two vectors for each medium (`passes/shade/transmission.glsl`).
    pub fn words(&self) -> Vec<[f32; 4]> {
        let words = |medium: &Medium| {
            let [r, g, b] = medium.extinction;
            [[medium.weight, medium.ior, medium.thickness, 0.0], [r, g, b, 0.0]]
        };
        self.0.iter().flat_map(words).collect()
    }
}
