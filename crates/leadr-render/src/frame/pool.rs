//! A pool of objects. A frame holds an object from its preparation until the device has drawn the frame.

use std::sync::Arc;

use leadr_gpu::Result;

/// A pool of objects. An object that no frame holds is reused.
pub struct Pool<T>(Vec<Arc<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Pool<T> {
    /// Returns an unused object, or else a new one.
    pub fn take(&mut self, make: impl FnOnce() -> Result<T>) -> Result<Arc<T>> {
        if let Some(free) = self.0.iter().find(|made| Arc::strong_count(made) == 1) {
            return Ok(free.clone());
        }
        let made = Arc::new(make()?);
        self.0.push(made.clone());
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_resources_are_exclusive() {
        let (mut pool, mut made) = (Pool::default(), 0);
        let mut take = || {
            pool.take(|| {
                made += 1;
                Ok(made)
            })
        };
        let first = take().unwrap();
        let second = take().unwrap();
        assert_eq!((*first, *second), (1, 2));
        drop(first);
        for _ in 0..2 {
            // The object is dropped immediately.
            assert_eq!(*take().unwrap(), 1);
        }
        assert_eq!(*second, 2);
    }
}
