//! Re-creates pipelines with newer shaders. The old ones stay until all of the new ones work.

use std::sync::{Arc, PoisonError, Weak};

use super::shaders::Shader;
use super::{Gpu, Result};

/// Replaces the old with the re-created object. No recording may be in progress.
pub(super) type Put = Box<dyn FnOnce()>;

/// A pipeline with its recipe.
pub(super) trait Remake: Send + Sync {
    /// Whether it uses one of these entry points.
    fn uses(&self, names: &[&str]) -> bool;

    /// Re-creates it next to the existing one.
    fn make_again(self: Arc<Self>) -> Result<Put>;
}

impl Gpu {
    /// Registers a pipeline for re-creation.
    pub(super) fn register(&self, recipe: Weak<dyn Remake>) {
        let mut recipes = self.recipes.lock().unwrap_or_else(PoisonError::into_inner);
        // Removes dropped pipelines now and then, so that the list has at most twice as many entries as pipelines exist.
        if recipes.len() == recipes.capacity() {
            recipes.retain(|known| known.strong_count() > 0);
        }
        recipes.push(recipe);
    }

    /// Replaces the shaders of the same name from now on. Every pipeline that uses one is re-created, and new pipelines use
    /// them too. If one fails, all stay unchanged. Returns the number of re-created pipelines. No recording may be in progress.
    ///
    /// # Errors
    /// A shader that does not fit its pipeline; a failed Vulkan call.
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
