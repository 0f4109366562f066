//! Pipelines that are made again of newer shaders, while those that there are stay until all of them work.

use std::sync::{Arc, PoisonError, Weak};

use super::shaders::Shader;
use super::{Gpu, Result};

/// Puts what was made again in place of what there was. Nothing may be recorded meanwhile.
pub(super) type Put = Box<dyn FnOnce()>;

/// A pipeline that knows how it is made.
pub(super) trait Remake: Send + Sync {
    /// Whether one of its entry points is among these.
    fn uses(&self, names: &[&str]) -> bool;

    /// Makes it again, beside what there is.
    fn make_again(self: Arc<Self>) -> Result<Put>;
}

impl Gpu {
    /// Notes a pipeline, to make it again.
    pub(super) fn remember(&self, recipe: Weak<dyn Remake>) {
        let mut recipes = self.recipes.lock().unwrap_or_else(PoisonError::into_inner);
        // Those that are gone are forgotten now and then, so that the list grows no longer than twice what there is.
        if recipes.len() == recipes.capacity() {
            recipes.retain(|known| known.strong_count() > 0);
        }
        recipes.push(recipe);
    }

    /// Draws with these shaders in place of those of the same name from now on. Every pipeline that has one is made again, and those that
    /// are not made yet will have them. If one fails, all stay as they are. Returns how many were made. Nothing may be recorded
    /// meanwhile.
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
