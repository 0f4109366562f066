//! Dependencies of the crates: licences and sources, duplicate versions, required Rust version, and dependency counts.
//!
//! The lists are those of `deny.toml`, which `cargo deny check` reads where it is installed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use serde_json::Value;

use crate::source::root;

/// Packages and their dependencies, from cargo.
struct Metadata {
    packages: BTreeMap<String, Package>,
    /// Dependencies of each package, and whether only its tests need them.
    needs: BTreeMap<String, Vec<(String, bool)>>,
    root: String,
}

struct Package {
    name: String,
    version: String,
    license: Option<String>,
    source: Option<String>,
    rust: Option<String>,
}

impl Metadata {
    /// The metadata of the crate with these features.
    fn of(features: &[&str]) -> Self {
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
        let ask = |how: &[&str]| {
            let mut command = Command::new(&cargo);
            command.current_dir(root()).args(["metadata", "--locked", "--format-version", "1"]);
            command.args(features).args(how).output().expect("cargo runs")
        };
        // For all platforms. If their packages were never fetched, for the built platform, or including packages of other workspace
        // members, which are fetched then.
        let mut output = ask(&["--offline"]);
        if !output.status.success() {
            let host = Command::new("rustc").arg("-vV").output().expect("rustc runs").stdout;
            let host = String::from_utf8(host).unwrap();
            let host = host.lines().find_map(|line| line.strip_prefix("host: ")).unwrap().to_owned();
            output = ask(&["--offline", "--filter-platform", &host]);
            if !output.status.success() {
                output = ask(&["--filter-platform", &host]);
            }
        }
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Self::read(&serde_json::from_slice(&output.stdout).unwrap())
    }

    fn read(json: &Value) -> Self {
        let text = |value: &Value| value.as_str().map(str::to_owned);
        let all = |value: &Value| value.as_array().unwrap().clone();
        let package = |p: &Value| Package {
            name: text(&p["name"]).unwrap(),
            version: text(&p["version"]).unwrap(),
            license: text(&p["license"]),
            source: text(&p["source"]),
            rust: text(&p["rust_version"]),
        };
        let packages: BTreeMap<_, _> =
            all(&json["packages"]).iter().map(|p| (text(&p["id"]).unwrap(), package(p))).collect();
        let need = |d: &Value| {
            let tests_only = all(&d["dep_kinds"]).iter().all(|kind| kind["kind"] == "dev");
            (text(&d["pkg"]).unwrap(), tests_only)
        };
        let node = |n: &Value| (text(&n["id"]).unwrap(), all(&n["deps"]).iter().map(need).collect());
        let needs = all(&json["resolve"]["nodes"]).iter().map(node).collect();
        let root = packages.iter().find(|(_, p)| p.name == env!("CARGO_PKG_NAME")).unwrap().0.clone();
        Self { packages, needs, root }
    }

    /// Packages of the program, with or without those only for tests.
    fn needed(&self, with_tests: bool) -> Vec<&Package> {
        self.needed_by(&self.root, with_tests)
    }

    fn needed_by(&self, id: &String, with_tests: bool) -> Vec<&Package> {
        let id = self.needs.get_key_value(id).expect("a package of the workspace").0;
        let (mut found, mut open) = (BTreeSet::new(), vec![id]);
        while let Some(id) = open.pop() {
            if found.insert(id) {
                let needs = self.needs[id].iter().filter(|(_, tests_only)| with_tests || !tests_only);
                open.extend(needs.map(|(id, _)| id));
            }
        }
        found.into_iter().map(|id| &self.packages[id]).collect()
    }
}

/// The strings of the array `key` in `deny.toml`.
fn listed(key: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join("deny.toml")).unwrap();
    let (_, after) = text.split_once(&format!("\n{key} = [\n")).unwrap_or_else(|| panic!("deny.toml has no {key}"));
    let lines = after.lines().take_while(|line| *line != "]").map(str::trim).filter(|line| !line.starts_with('#'));
    lines.map(|line| line.trim_end_matches(',').trim_matches('"').to_owned()).collect()
}

/// Whether the licences in `allowed` satisfy an expression: `OR` or `/` binds less than `AND`.
fn permits(expression: &str, allowed: &[String]) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let mut words = spaced.split_whitespace().peekable();
    let any = either(&mut words, allowed);
    any && words.next().is_none()
}

type Words<'a, 'b> = &'b mut std::iter::Peekable<std::str::SplitWhitespace<'a>>;

fn either(words: Words<'_, '_>, allowed: &[String]) -> bool {
    let mut any = both(words, allowed);
    while words.next_if_eq(&"OR").is_some() {
        any |= both(words, allowed);
    }
    any
}

fn both(words: Words<'_, '_>, allowed: &[String]) -> bool {
    let mut all = one(words, allowed);
    while words.next_if_eq(&"AND").is_some() {
        all &= one(words, allowed);
    }
    all
}

fn one(words: Words<'_, '_>, allowed: &[String]) -> bool {
    if words.next_if_eq(&"(").is_some() {
        let inside = either(words, allowed);
        return words.next_if_eq(&")").is_some() && inside;
    }
    let mut name = words.next().unwrap_or_default().to_owned();
    if words.next_if_eq(&"WITH").is_some() {
        name = format!("{name} WITH {}", words.next().unwrap_or_default());
    }
    allowed.contains(&name)
}

/// Major and minor number of a version.
fn minor(version: &str) -> [u32; 2] {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(0));
    [parts.next().unwrap_or(0), parts.next().unwrap_or(0)]
}

/// Packages that require a newer Rust than `rust`.
fn newer_than(rust: &str, packages: &[&Package]) -> Vec<String> {
    let newer = packages.iter().filter(|p| p.rust.as_deref().is_some_and(|requested| minor(requested) > minor(rust)));
    newer.map(|p| format!("{} {} asks for Rust {}", p.name, p.version, p.rust.as_deref().unwrap_or(""))).collect()
}

/// Whether an entry such as `syn:2` matches this package.
fn is_meant(entry: &str, package: &Package) -> bool {
    let Some((name, version)) = entry.split_once(':') else { return false };
    let same = package.version.strip_prefix(version).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    name == package.name && same
}

#[test]
fn licences_and_sources_are_those_that_are_allowed() {
    let allowed = listed("allow");
    let metadata = Metadata::of(&[]);
    assert!(metadata.packages.len() > 150, "only {} packages were read", metadata.packages.len());
    let mut faults = Vec::new();
    let mut registries = BTreeSet::new();
    for p in metadata.packages.values() {
        let license = p.license.as_deref();
        if p.source.is_some() && !license.is_some_and(|license| permits(license, &allowed)) {
            faults.push(format!("{} {}: licence {}", p.name, p.version, license.unwrap_or("unknown")));
        }
        match p.source.as_deref() {
            Some(source) if source.starts_with("registry+") => _ = registries.insert(source),
            Some(source) => faults.push(format!("{} {}: from {source}", p.name, p.version)),
            None => {}
        }
    }
    assert_eq!(registries.len(), 1, "more than one registry: {registries:?}");
    assert!(faults.is_empty(), "not allowed by deny.toml:\n{}", faults.join("\n"));
}

#[test]
fn one_version_of_a_crate_is_enough() {
    let skipped = listed("skip");
    let metadata = Metadata::of(&[]);
    let packages = metadata.needed(true);
    let mut versions = BTreeMap::<&str, Vec<&str>>::new();
    for p in packages.iter().filter(|p| !skipped.iter().any(|entry| is_meant(entry, p))) {
        versions.entry(&p.name).or_default().push(&p.version);
    }
    versions.retain(|_, all| all.len() > 1);
    assert!(versions.is_empty(), "depend on one version, or name the older under `skip` in deny.toml: {versions:?}");
}

#[test]
fn the_oldest_rust_is_the_one_that_is_stated() {
    let headless = Metadata::of(&["--no-default-features", "--features", "cli"]);
    let packages = headless.needed(false);
    assert!(packages.iter().any(|p| p.name == "clap") && !packages.iter().any(|p| p.name == "egui"));
    let faults = newer_than(env!("CARGO_PKG_RUST_VERSION"), &packages);
    assert!(faults.is_empty(), "newer than Cargo.toml says: {faults:?}");

    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let (_, after) = readme.split_once("[Rust](https://rustup.rs) ").expect("README.md says which Rust");
    let window = after.split_whitespace().next().unwrap();
    let whole = Metadata::of(&[]);
    let faults = newer_than(window, &whole.needed(false));
    assert!(faults.is_empty(), "newer than README.md says: {faults:?}");
}

/// Layers are crates, so the compiler keeps them separate. This test limits their dependencies.
#[test]
fn the_mathematics_and_the_renderer_stay_light() {
    let metadata = Metadata::of(&["--all-features"]);
    let brought_by = |name: &str| -> BTreeSet<&str> {
        let (id, _) = metadata.packages.iter().find(|(_, p)| p.name == name && p.source.is_none()).unwrap();
        metadata.needed_by(id, false).iter().map(|p| p.name.as_str()).collect()
    };
    for heavy in ["ash", "clap", "exr", "image", "serde", "shaderc"] {
        assert!(!brought_by("leadr-reflectance").contains(heavy), "the mathematics bring {heavy}");
    }
    for heavy in ["ash", "clap", "shaderc"] {
        assert!(!brought_by("leadr-maps").contains(heavy), "the maps bring {heavy}");
    }
    for heavy in ["clap", "egui", "indicatif", "nv-flip", "tracing-subscriber", "winit"] {
        assert!(!brought_by("leadr-scenes").contains(heavy), "the renderer brings {heavy}");
    }
    for (package, heavy) in [("leadr-gpu", "ash"), ("leadr-tools", "clap"), ("leadr-vk", "winit")] {
        assert!(brought_by(package).contains(heavy), "{heavy} is not found below {package}");
    }
    assert!(!brought_by("leadr-vk").contains("leadr-lab"), "the product needs the laboratory");
}

#[test]
fn what_is_not_allowed_is_refused() {
    let allowed = ["MIT".to_owned(), "Zlib".to_owned(), "Apache-2.0 WITH LLVM-exception".to_owned()];
    for fine in ["MIT", "GPL-3.0 OR MIT", "GPL-3.0/MIT", "(GPL-3.0 OR MIT) AND Zlib", "Apache-2.0 WITH LLVM-exception"]
    {
        assert!(permits(fine, &allowed), "{fine}");
    }
    for wrong in ["GPL-3.0", "MIT AND GPL-3.0", "GPL-3.0 OR MIT AND LGPL-2.1", "", "Apache-2.0", "(MIT", "MIT MIT"] {
        assert!(!permits(wrong, &allowed), "{wrong}");
    }
    let package = |rust: &str| Package {
        name: "syn".to_owned(),
        version: "2.0.119".to_owned(),
        license: None,
        source: None,
        rust: Some(rust.to_owned()),
    };
    assert!(newer_than("1.90", &[&package("1.90.0"), &package("1.9")]).is_empty());
    assert_eq!(newer_than("1.90", &[&package("1.91")]).len(), 1);
    assert!(is_meant("syn:2", &package("1")) && is_meant("syn:2.0", &package("1")));
    assert!(
        !is_meant("syn:20", &package("1")) && !is_meant("sync:2", &package("1")) && !is_meant("syn", &package("1"))
    );
}
