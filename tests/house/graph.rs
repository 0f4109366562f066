//! Which source file names items of which other file.
//!
//! Paths are resolved through modules and their re-exports to the file that defines the item, so an item that `mod.rs`
//! re-exports counts as its own file's. A `pub use` in `mod.rs` itself is no dependency. Code under `#[cfg(test)]` is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::source::{code_only, files_under, identifier, root, words};

type Path = Vec<String>;

/// Files of the library, and for each the files whose items it names.
pub struct Graph(BTreeMap<String, BTreeSet<String>>);

/// One `use`, with the name under which the item is known afterwards.
struct Import {
    name: String,
    path: Path,
    public: bool,
}

/// What one file says.
#[derive(Default)]
struct Module {
    file: String,
    imports: Vec<Import>,
    /// Paths in the code besides imports.
    paths: Vec<Path>,
    /// Modules declared for tests only.
    test_modules: Vec<String>,
}

struct Sources(BTreeMap<Path, Module>);

impl Graph {
    /// The graph of `src`.
    pub fn of_the_library() -> Self {
        let folder = root().join("src");
        let files = files_under(&folder, &["rs"]).into_iter().map(|file| {
            let name = file.strip_prefix(&folder).unwrap().to_str().unwrap().to_owned();
            (name, fs::read_to_string(&file).unwrap())
        });
        Self::new(files)
    }

    /// The graph of files, by name below the crate's root, and text.
    pub fn new(files: impl IntoIterator<Item = (String, String)>) -> Self {
        let mut sources = Sources(BTreeMap::new());
        for (file, text) in files.into_iter().filter(|(file, _)| file != "main.rs") {
            sources.0.insert(module_path(&file), Module::read(file, &text));
        }
        let test_modules: Vec<Path> =
            sources.0.iter().flat_map(|(path, m)| m.test_modules.iter().map(|name| joined(path, &[name]))).collect();
        sources.0.retain(|path, _| !test_modules.iter().any(|test| path.starts_with(test)));
        Self(sources.0.iter().map(|(path, module)| (module.file.clone(), sources.used_by(path, module))).collect())
    }

    /// All pairs of a file and another whose items it names.
    pub fn arrows(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().flat_map(|(from, all)| all.iter().map(move |to| (from.as_str(), to.as_str())))
    }

    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// For each file that can be reached from itself, the shortest way round.
    pub fn circles(&self) -> BTreeMap<&str, Vec<&str>> {
        self.files().filter_map(|file| Some((file, self.way_round(file)?))).collect()
    }

    fn way_round<'a>(&'a self, start: &'a str) -> Option<Vec<&'a str>> {
        let mut ways = vec![vec![start]];
        let mut seen = BTreeSet::new();
        let mut next = 0;
        while next < ways.len() {
            let way = ways[next].clone();
            next += 1;
            for to in self.0.get(*way.last()?)?.iter().map(String::as_str) {
                if to == start {
                    return Some(way);
                }
                if seen.insert(to) {
                    ways.push(way.iter().copied().chain([to]).collect());
                }
            }
        }
        None
    }
}

impl Sources {
    fn used_by(&self, own: &Path, module: &Module) -> BTreeSet<String> {
        let facade = module.file.ends_with("mod.rs") || module.file == "lib.rs";
        let imports = module.imports.iter().filter(|import| !(facade && import.public)).map(|import| &import.path);
        let files = imports.chain(&module.paths).filter_map(|path| self.file_of(&self.absolute(own, path)?, 0));
        files.filter(|file| *file != module.file && file != "lib.rs").collect()
    }

    /// A path from the crate's root; none if it leads out of the crate.
    fn absolute(&self, own: &Path, path: &Path) -> Option<Path> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" | "leadr" => Some(rest.to_vec()),
            "self" => Some(joined(own, rest)),
            "super" => {
                let supers = path.iter().take_while(|name| *name == "super").count();
                let above = own.len().checked_sub(supers)?;
                Some(joined(&own[..above], &path[supers..]))
            }
            _ if self.0.contains_key(&joined(own, &path[..1])) => Some(joined(own, path)),
            _ => {
                let import = self.0.get(own)?.imports.iter().find(|import| import.name == *first)?;
                // `use a::a` names itself.
                let target = if import.path[0] == *first { None } else { self.absolute(own, &import.path) }?;
                Some(joined(&target, rest))
            }
        }
    }

    /// The file that defines what an absolute path names.
    fn file_of(&self, path: &[String], depth: usize) -> Option<String> {
        let length = (0..=path.len()).rev().find(|&length| self.0.contains_key(&path[..length]))?;
        let (own, rest) = path.split_at(length);
        let module = &self.0[own];
        let import = rest.first().and_then(|name| module.imports.iter().find(|import| import.name == *name));
        let through = import.filter(|_| depth < 8).and_then(|import| {
            let target = self.absolute(&own.to_vec(), &import.path)?;
            self.file_of(&joined(&target, &rest[1..]), depth + 1)
        });
        Some(through.unwrap_or_else(|| module.file.clone()))
    }
}

impl Module {
    fn read(file: String, text: &str) -> Self {
        let mut module = Self { file, ..Self::default() };
        let code = module.without_tests(&code_only(text));
        let mut read_to = 0;
        for (start, word) in words(&code) {
            if start < read_to || code[..start].trim_end().ends_with([':', '.']) {
                continue;
            }
            if word == "use" {
                let Some(end) = code[start..].find(';') else { continue };
                read_to = start + end;
                let before = code[..start].trim_end();
                let public = before.ends_with("pub") || (before.ends_with(')') && last_line(before).contains("pub("));
                for (path, name) in leaves(&code[start + word.len()..read_to]) {
                    module.imports.push(Import { name, path, public });
                }
            } else {
                let path = path_at(&code[start..]);
                if path.len() > 1 {
                    module.paths.push(path);
                }
            }
        }
        module
    }

    /// The code without items under `#[cfg(test)]`; notes the modules that are declared there.
    fn without_tests(&mut self, code: &str) -> String {
        let (mut kept, mut rest) = (String::new(), code);
        while let Some(at) = rest.find("#[cfg(test)]") {
            kept.push_str(&rest[..at]);
            let item = &rest[at..];
            let end = item.find(['{', ';']).unwrap_or(item.len());
            if item[end..].starts_with('{') {
                rest = &item[end + block_length(&item[end..])..];
            } else {
                self.test_modules.extend(item[..end].split_whitespace().last().map(str::to_owned));
                rest = &item[(end + 1).min(item.len())..];
            }
        }
        kept + rest
    }
}

/// `a/b.rs` and `a/b/mod.rs` are both `a::b`.
fn module_path(file: &str) -> Path {
    let mut parts: Path = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if parts.last().is_some_and(|last| last == "mod") || parts == ["lib"] {
        parts.pop();
    }
    parts
}

fn joined<S: AsRef<str>>(base: &[String], more: &[S]) -> Path {
    base.iter().cloned().chain(more.iter().map(|name| name.as_ref().to_owned())).collect()
}

fn last_line(text: &str) -> &str {
    text.lines().last().unwrap_or_default()
}

/// Length of the block that begins a text, braces included.
fn block_length(text: &str) -> usize {
    let mut depth = 0;
    for (i, c) in text.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            return i + 1;
        }
    }
    text.len()
}

/// The names of the path `a::b::c` that begins a text.
fn path_at(text: &str) -> Path {
    let first = identifier(text);
    let mut path = vec![first.to_owned()];
    let mut rest = &text[first.len()..];
    while let Some(after) = rest.strip_prefix("::") {
        let name = identifier(after);
        if name.is_empty() {
            break;
        }
        path.push(name.to_owned());
        rest = &after[name.len()..];
    }
    path
}

/// The paths of a use tree, each with the name it gives.
fn leaves(tree: &str) -> Vec<(Path, String)> {
    let tree = tree.trim();
    if let Some(open) = tree.find('{') {
        let prefix: Path = tree[..open].split("::").map(|n| n.trim().to_owned()).filter(|n| !n.is_empty()).collect();
        let inside = &tree[open + 1..open + block_length(&tree[open..]) - 1];
        let all = split_at_commas(inside).into_iter().flat_map(leaves);
        return all
            .map(|(path, name)| {
                let path = joined(&prefix, &path);
                match path.split_last() {
                    // `{self}` names the module itself.
                    Some((last, module)) if last == "self" && !module.is_empty() => {
                        let name = if name == "self" { module[module.len() - 1].clone() } else { name };
                        (module.to_vec(), name)
                    }
                    _ => (path, name),
                }
            })
            .collect();
    }
    let (path, alias) = tree.split_once(" as ").map_or((tree, None), |(path, alias)| (path, Some(alias)));
    let path: Path = path.split("::").map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect();
    let Some(last) = path.last().cloned() else { return Vec::new() };
    let name = alias.map_or(last, |alias| alias.trim().to_owned());
    vec![(path, name)]
}

fn split_at_commas(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, c) in text.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            parts.push(&text[start..i]);
            start = i + 1;
        }
    }
    parts.push(&text[start..]);
    parts
}
