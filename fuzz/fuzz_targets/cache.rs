//! Files of the cache: whatever they hold, what is remembered is what was made.
#![no_main]

use std::convert::Infallible;
use std::sync::LazyLock;

use leadr_maps::cache::MapCache;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    std::fs::write(FOLDER.path().join("fuzzed-0000000000000007.bin"), bytes).expect("room for a file");
    let read = |content: &[u8]| if content.len() == 3 { Ok(content.to_vec()) } else { Err("it has another length") };
    let make = || Ok::<_, Infallible>((vec![1, 2, 3], vec![1, 2, 3]));
    let Ok(value) = MapCache::in_folder(FOLDER.path()).load_or_make("fuzzed", 7, 3, read, make);
    assert_eq!(value.len(), 3);
});
