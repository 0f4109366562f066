//! Numbers made elsewhere (`LEADR_SHARED/oracles`), and the comparison with them.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::DVec3;
use serde_json::Value;

/// Collects comparisons; the worst one per name is printed, the ones beyond tolerance fail.
#[derive(Default)]
pub struct Comparison {
    worst: std::collections::BTreeMap<&'static str, (f64, String)>,
    pub failures: String,
    count: usize,
}

impl Comparison {
    /// `|got − want| ≤ tolerance · max(|want|, floor)`.
    pub fn check(&mut self, name: &'static str, id: &str, got: f64, want: f64, tolerance: f64, floor: f64) {
        self.count += 1;
        let error = (got - want).abs() / want.abs().max(floor);
        let worst = self.worst.entry(name).or_insert((-1.0, String::new()));
        if error > worst.0 || error.is_nan() {
            *worst = (error, id.to_owned());
        }
        if error > tolerance || error.is_nan() {
            writeln!(self.failures, "{name} of {id}: {got:.9e} instead of {want:.9e} ({error:.1e})").unwrap();
        }
    }

    pub fn merge(mut self, other: Self) -> Self {
        for (name, value) in other.worst {
            let worst = self.worst.entry(name).or_insert((-1.0, String::new()));
            if value.0 > worst.0 {
                *worst = value;
            }
        }
        self.failures += &other.failures;
        self.count += other.count;
        self
    }

    pub fn finish(self, at_least: usize) {
        for (name, (error, id)) in &self.worst {
            println!("{name}: worst error {error:.1e} ({id})");
        }
        assert!(self.count >= at_least, "only {} comparisons", self.count);
        assert!(self.failures.is_empty(), "{}", self.failures);
    }
}

pub fn oracle(file: &str) -> Option<Value> {
    let Some(root) = std::env::var_os("LEADR_SHARED") else {
        println!("skipped: LEADR_SHARED is not set, so oracles/{file} cannot be found");
        return None;
    };
    let path = PathBuf::from(root).join("oracles").join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Some(serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

pub fn vector(value: &Value) -> DVec3 {
    DVec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}
