//! No file depends on itself by way of others, and chapters only depend on earlier ones.

use std::collections::BTreeMap;

use crate::graph::Graph;

#[test]
fn no_file_depends_on_itself() {
    let graph = Graph::of_the_library();
    assert!(graph.arrows().count() > 300, "only {} arrows were read", graph.arrows().count());
    let circles: Vec<String> = graph.circles().values().map(|way| way.join(" -> ")).collect();
    assert!(circles.is_empty(), "{} files depend on themselves:\n{}", circles.len(), circles.join("\n"));
}

fn made_up(files: &[(&str, &str)]) -> Graph {
    Graph::new(files.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())))
}

#[test]
fn circles_are_found() {
    let circular =
        |files: &[(&str, &str)]| made_up(files).circles().keys().map(|k| (*k).to_owned()).collect::<Vec<_>>();
    let direct =
        [("x/a.rs", "use super::b::B;"), ("x/b.rs", "fn f() { crate::x::a::g() }"), ("x/mod.rs", "mod a; mod b;")];
    assert_eq!(circular(&direct), ["x/a.rs", "x/b.rs"]);
    let long = [
        ("a.rs", "use crate::{b, c::{self, D}};"),
        ("b.rs", ""),
        ("c.rs", "use crate::d::E as F;"),
        ("d.rs", "use crate::a;"),
    ];
    assert_eq!(circular(&long), ["a.rs", "c.rs", "d.rs"]);
    // Through a re-export, and through a module imported first.
    let facade =
        [("x/mod.rs", "mod a;\nmod b;\npub use a::A;"), ("x/a.rs", "use super::b;"), ("x/b.rs", "use super::A;")];
    assert_eq!(circular(&facade), ["x/a.rs", "x/b.rs"]);
    let module = [
        ("y.rs", "use crate::x; fn f() { x::A::new() }"),
        ("x/mod.rs", "pub use a::A;"),
        ("x/a.rs", "use crate::y::Y;"),
    ];
    assert_eq!(circular(&module), ["x/a.rs", "y.rs"]);
    let parent = [("x/mod.rs", "mod a; fn f() { a::f() } pub fn g() {}"), ("x/a.rs", "fn f() { super::g() }")];
    assert_eq!(circular(&parent), ["x/a.rs", "x/mod.rs"]);

    let re_exported = [("x/mod.rs", "mod a;\npub use a::A;\npub struct B;"), ("x/a.rs", "use super::B;")];
    assert!(circular(&re_exported).is_empty());
    let in_tests =
        [("a.rs", "use crate::b;"), ("b.rs", "#[cfg(test)]\nmod tests { use crate::a; fn f() { if x { '{' } } }")];
    assert!(circular(&in_tests).is_empty());
    let test_file = [
        ("x/mod.rs", "#[cfg(test)]\nmod look;\npub struct A;\nmod b;"),
        ("x/look.rs", "use super::A; use super::b;"),
        ("x/b.rs", "// use crate::x::look;"),
    ];
    assert!(circular(&test_file).is_empty());
}

/// Chapters of a floor in their order: a file depends on files of its own chapter and of those with a smaller number.
struct Chapters {
    floor: &'static str,
    numbers: BTreeMap<&'static str, u32>,
    /// Number of files on the floor's root that are not listed.
    others: u32,
}

impl Chapters {
    /// The number of a file of this floor: that of its folder, or its own on the floor's root. `mod.rs` comes last: it may
    /// re-export every chapter, and no chapter may depend on what it defines itself.
    fn number(&self, file: &str) -> Option<u32> {
        let below = file.strip_prefix(self.floor)?.strip_prefix('/')?;
        let name = below.split('/').next()?.trim_end_matches(".rs");
        let other = if name == "mod" { u32::MAX } else { self.others };
        Some(self.numbers.get(name).copied().unwrap_or(other))
    }

    fn arrows_to_later_ones(&self, graph: &Graph) -> Vec<String> {
        let numbered = graph.arrows().filter_map(|(from, to)| Some((from, to, self.number(from)?, self.number(to)?)));
        numbered.filter(|(.., from, to)| to > from).map(|(from, to, ..)| format!("{from} uses {to}")).collect()
    }
}

/// Files on the root that no chapter may use, such as a prelude, need not be listed.
fn reflectance() -> Chapters {
    let roots = ["color", "limits", "frame", "quadrature", "random", "roots", "least_squares", "rational_fit"];
    let roots = roots.map(|name| (name, 0));
    let chapters = ["slopes", "facets", "masking", "materials", "extraction", "integrals", "visible"];
    let numbers = roots.into_iter().chain(chapters.into_iter().zip(1..)).collect();
    Chapters { floor: "reflectance", numbers, others: u32::MAX }
}

/// Files on the root stand with surfaces and lights, before passes.
fn render() -> Chapters {
    let numbers = BTreeMap::from([("surfaces", 0), ("light", 0), ("passes", 1), ("frame", 2)]);
    Chapters { floor: "render", numbers, others: 0 }
}

#[test]
fn chapters_only_depend_on_earlier_ones() {
    let graph = Graph::of_the_library();
    for chapters in [reflectance(), render()] {
        let floor = chapters.floor;
        for name in chapters.numbers.keys() {
            let there = graph.files().any(|f| f.starts_with(&format!("{floor}/{name}")));
            assert!(there, "no file of {floor}/{name} was read");
        }
        let faults = chapters.arrows_to_later_ones(&graph);
        assert!(faults.is_empty(), "chapters of {floor} use later ones:\n{}", faults.join("\n"));
    }
}

#[test]
fn arrows_to_later_chapters_are_refused() {
    let refused = |file: &str, text: &str| {
        let files = [
            (file, text),
            ("render/frame/mod.rs", "pub struct A;"),
            ("render/passes/shade.rs", ""),
            ("render/mod.rs", ""),
            ("render/surfaces/atlas.rs", ""),
        ];
        !render().arrows_to_later_ones(&made_up(&files)).is_empty()
    };
    assert!(refused("render/passes/b.rs", "use crate::render::frame::A;"));
    assert!(refused("render/light/sky.rs", "use super::super::passes::shade;"));
    assert!(refused("render/scene.rs", "use super::passes::shade::S;"));
    assert!(!refused("render/passes/b.rs", "use crate::render::surfaces::atlas;"));
    assert!(refused("render/view.rs", "use super::frame::A;"), "a file on the root");
    assert!(!refused("render/light/sky.rs", "use crate::render::surfaces::atlas;"));
}
