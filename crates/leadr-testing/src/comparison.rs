//! Reads the results of other programs (`crates/leadr-testing/data`), and compares them with the results of this library.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use serde_json::Value;

/// A collection of comparisons. [`Comparison::finish`] prints the worst comparison of each name, and fails the test if a value is outside
/// its tolerance.
#[derive(Default)]
pub struct Comparison {
    worst: BTreeMap<String, Worst>,
    /// The failures, with one line for each value outside its tolerance.
    pub failures: String,
}

/// The largest error among the comparisons of one name.
struct Worst {
    error: f64,
    id: String,
    count: usize,
}

impl Comparison {
    /// Checks that `|got − want| ≤ tolerance · max(|want|, floor)`.
    pub fn check(&mut self, name: &str, id: &str, got: f64, want: f64, tolerance: f64, floor: f64) {
        let error = (got - want).abs() / want.abs().max(floor);
        self.note(name, Worst { error, id: id.to_owned(), count: 1 });
        if error > tolerance || error.is_nan() {
            writeln!(self.failures, "{name} of {id}: {got:.9e} instead of {want:.9e} ({error:.1e})").unwrap();
        }
    }

    fn note(&mut self, name: &str, new: Worst) {
        let Some(old) = self.worst.get_mut(name) else {
            self.worst.insert(name.to_owned(), new);
            return;
        };
        let count = old.count + new.count;
        if new.error > old.error || new.error.is_nan() {
            *old = new;
        }
        old.count = count;
    }

    /// Merges two collections of comparisons.
    #[must_use]
    pub fn merge(mut self, other: Self) -> Self {
        for (name, worst) in other.worst {
            self.note(&name, worst);
        }
        self.failures += &other.failures;
        self
    }

    /// Fails if a value was outside its tolerance, or if fewer than `at_least` comparisons were made.
    pub fn finish(self, at_least: usize) {
        for (name, Worst { error, id, count }) in &self.worst {
            println!("{name:<32} {count:>4} values, worst error {error:.1e} ({id})");
        }
        let count: usize = self.worst.values().map(|w| w.count).sum();
        assert!(count >= at_least, "only {count} comparisons");
        assert!(self.failures.is_empty(), "{}", self.failures);
    }
}

/// Reads `crates/leadr-testing/data/<file>`, which `crates/leadr-testing/data/README.md` describes.
pub fn oracle(file: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Returns a list from an oracle file.
pub fn rows(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("{value} is not a list"))
}

/// Returns a number from an oracle file.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// Returns a vector of three numbers from an oracle file.
pub fn vector(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

/// Evaluates the environment that the oracle files call `smooth`. Its radiance is of order 2.
pub fn smooth(d: DVec3) -> f64 {
    1.0 + 0.4 * d.x - 0.25 * d.y + 0.3 * d.z + 0.2 * d.y * d.z + 0.15 * (d.x * d.x - d.y * d.y)
}
