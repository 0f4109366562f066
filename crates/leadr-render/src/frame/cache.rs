//! A cache of pipelines.

use std::collections::HashMap;
use std::hash::Hash;

use leadr_gpu::Result;

/// A cache of pipelines, with one pipeline for each kind. Clones of a pipeline share its data.
pub struct Cache<K, V>(HashMap<K, V>);

impl<K, V> Default for Cache<K, V> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<K: Eq + Hash, V: Clone> Cache<K, V> {
    /// Returns the cached value for a kind. Makes the value first if it is missing.
    pub fn get(&mut self, kind: K, make: impl FnOnce() -> Result<V>) -> Result<V> {
        if let Some(made) = self.0.get(&kind) {
            return Ok(made.clone());
        }
        let made = make()?;
        self.0.insert(kind, made.clone());
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_gpu::GpuError;

    #[test]
    fn things_are_made_once_and_failures_are_tried_again() {
        let mut cache = Cache::default();
        let fault = || Err(GpuError::Usage { name: "pipeline".to_owned(), fault: "none yet".to_owned() });
        assert!(cache.get(1, fault).is_err());
        assert_eq!(cache.get(1, || Ok("made")).unwrap(), "made");
        assert_eq!(cache.get(1, || Ok("again")).unwrap(), "made");
    }
}
