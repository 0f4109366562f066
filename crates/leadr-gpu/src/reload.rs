//! Re-creates pipelines with newer shaders. The old pipelines stay until all new pipelines have been created.

use std::sync::{Arc, PoisonError, Weak};

use super::shaders::Shader;
use super::{Gpu, Result};

/// A function that replaces the old object by the re-created object. No recording may be in progress.
pub(super) type Put = Box<dyn FnOnce()>;

/// A pipeline with its recipe.
pub(super) trait Remake: Send + Sync {
    /// Whether the pipeline uses one of these entry points.
    fn uses(&self, names: &[&str]) -> bool;

    /// Creates a new pipeline next to the existing one, and returns the function that replaces the existing one.
    fn make_again(self: Arc<Self>) -> Result<Put>;
}

impl Gpu {
    /// Registers a pipeline for re-creation.
    pub(super) fn register(&self, recipe: Weak<dyn Remake>) {
        let mut recipes = self.recipes.lock().unwrap_or_else(PoisonError::into_inner);
        // Dropped pipelines are removed whenever the list is full. The list therefore has at most about twice as many entries as
        // there are pipelines.
        if recipes.len() == recipes.capacity() {
            recipes.retain(|known| known.strong_count() > 0);
        }
        recipes.push(recipe);
    }

    /// Replaces the shaders that have the same names as `newer`, for existing and new pipelines. Every pipeline that uses a
    /// replaced shader is re-created. If one pipeline fails, all pipelines stay unchanged. Returns the number of re-created
    /// pipelines. No recording may be in progress.
    ///
    /// # Errors
    /// Returns an error if a shader does not fit its pipeline, or if a Vulkan call fails.
    pub fn reload(self: &Arc<Self>, newer: Vec<&'static Shader>) -> Result<usize> {
        let names: Vec<&str> = newer.iter().map(|shader| shader.name).collect();
        let mut all = self.shaders().newer().clone();
        all.extend(newer.into_iter().map(|shader| (shader.name, shader)));
        let before = self.shaders().replace(all);
        let recipes = self.recipes.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let recipes = recipes.iter().filter_map(Weak::upgrade).filter(|recipe| recipe.uses(&names));
        let made: Result<Vec<_>> = recipes.map(Remake::make_again).collect();
        let done = made.and_then(|made| self.wait_idle().map(|()| made));
        match done {
            Ok(made) => {
                let count = made.len();
                made.into_iter().for_each(|put| put());
                Ok(count)
            }
            Err(error) => {
                self.shaders().replace(before);
                Err(error)
            }
        }
    }
}
