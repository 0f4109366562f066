//! Converts panics of decoders into errors, as the last defence against damaged files.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use super::MapFault;

thread_local! {
    /// Whether this thread's panics print nothing, because they become errors.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder. A panic becomes a `Damaged` fault and prints nothing. The panic hook is unchanged for other threads and
/// after the call.
pub fn guarded<T>(format: &str, decode: impl FnOnce() -> Result<T, MapFault>) -> Result<T, MapFault> {
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
    decoded.unwrap_or_else(|_| Err(MapFault::damaged(format!("the {format} decoder failed (internal panic)"))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_while_decoding_is_an_error() {
        assert_eq!(guarded("EXR", || Ok(1)).unwrap(), 1);
        let message = guarded::<()>("EXR", || panic!("on purpose")).unwrap_err().to_string();
        assert!(message.contains("the EXR decoder failed (internal panic)"), "{message}");
    }
}
