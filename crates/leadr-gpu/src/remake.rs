//! What can be made again of newer shaders.

use super::error::Result;

/// Puts what was made again in place of what there was. Nothing may be recorded meanwhile.
pub(super) type Put = Box<dyn FnOnce()>;

/// A pipeline that knows how it is made.
pub(super) trait Remake: Send + Sync {
    /// Whether one of its entry points is among these.
    fn uses(&self, names: &[&str]) -> bool;

    /// Makes it again, beside what there is.
    fn make_again(self: std::sync::Arc<Self>) -> Result<Put>;
}
