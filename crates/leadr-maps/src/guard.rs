//! The last resort against decoders that panic over damaged bytes: the panic becomes an error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use super::MapFault;

thread_local! {
    /// Whether this thread's panics are expected and become an error.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder; if it panics, the file is called damaged and nothing is printed. Other threads, and this one afterwards, keep the
/// panic hook that was there.
pub(crate) fn guarded<T>(format: &str, decode: impl FnOnce() -> Result<T, MapFault>) -> Result<T, MapFault> {
    static INSTALL: Once = Once::new();
    INSTALL.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                before(info);
            }
        }));
    });
    QUIET.set(true);
    let decoded = catch_unwind(AssertUnwindSafe(decode));
    QUIET.set(false);
    decoded.unwrap_or_else(|_| Err(MapFault::damaged(format!("the {format} decoder gave up on it (internal panic)"))))
}
