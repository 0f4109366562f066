//! Counts allocations. A test that measures memory runs alone, even if all tests share one process.
//!
//! A measuring binary declares `#[global_allocator] static ALLOCATOR: Counting = Counting;`.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// An allocator that counts the live bytes and their peak. Zeroed requests count in full, although the system may not back them with memory
/// yet.
pub struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn grow(size: usize) {
    let live = LIVE.fetch_add(size, Ordering::Relaxed) + size;
    PEAK.fetch_max(live, Ordering::Relaxed);
}

// SAFETY: every call is forwarded unchanged to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller upholds the contract of the same method of the system allocator.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: the caller upholds the contract of the same method of the system allocator.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller upholds the contract of the same method of the system allocator.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        grow(size);
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller upholds the contract of the same method of the system allocator.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

static MEASURING: RwLock<()> = RwLock::new(());

/// Returns the lock for a measuring test. No other test runs at the same time.
pub fn alone() -> RwLockWriteGuard<'static, ()> {
    MEASURING.write().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Returns the lock for the tests that do not measure. These tests may run at the same time as each other.
pub fn unmeasured() -> RwLockReadGuard<'static, ()> {
    MEASURING.read().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Runs `work`. Returns its result, the peak number of bytes that it allocated, and its duration.
pub fn measured<T>(work: impl FnOnce() -> T) -> (T, usize, Duration) {
    let before = LIVE.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let start = Instant::now();
    let result = work();
    (result, PEAK.load(Ordering::Relaxed).saturating_sub(before), start.elapsed())
}
