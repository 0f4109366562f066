//! Links between the documents point to existing files and headings.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::source::{files_under, prose, root};

/// The anchors of the headings, in GitHub's form.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text).filter(|(_, line)| line.starts_with('#'));
    let slug = |(_, line): (usize, &str)| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|&c| c.is_alphanumeric() || c == '-' || c == '_' || c == ' ');
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(slug).collect()
}

/// The targets of links and pictures in a line, without code.
fn targets(line: &str) -> Vec<String> {
    let line: String = line.split('`').step_by(2).collect();
    let links = line.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    links.map(|(target, _)| target.to_owned()).collect()
}

fn broken(file: &Path, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    for (number, line) in prose(text) {
        for target in targets(line) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let to = if path.is_empty() { file.to_owned() } else { file.parent().unwrap().join(path) };
            let found = if anchor.is_empty() {
                to.exists()
            } else {
                fs::read_to_string(&to).is_ok_and(|text| anchors(&text).contains(anchor))
            };
            if !found {
                faults.push(format!("{}:{}: {target}", file.display(), number + 1));
            }
        }
    }
    faults
}

#[test]
fn links_of_documents_lead_somewhere() {
    let mut files = files_under(&root().join("docs"), &["md"]);
    for folder in ["crates", "shaders-glsl", "examples", "assets", "scripts", "fuzz", "packages"] {
        files.extend(files_under(&root().join(folder), &["md"]));
    }
    files.extend(["README.md", "ARCHITECTURE.md", "CHANGELOG.md"].map(|name| root().join(name)));
    let built = |file: &Path| {
        file.components().any(|part| ["target", "node_modules"].iter().any(|name| part.as_os_str() == *name))
    };
    files.retain(|file| !built(file));
    assert!(files.len() > 50, "only {} documents were read", files.len());
    let faults: Vec<String> = files.iter().flat_map(|file| broken(file, &fs::read_to_string(file).unwrap())).collect();
    assert!(faults.is_empty(), "links lead nowhere:\n{}", faults.join("\n"));
}

#[test]
fn links_to_missing_files_and_headings_are_found() {
    let file = root().join("README.md");
    let text = "[a](ARCHITECTURE.md) [b](missing.md)\n[c](#try-it) [d](docs/theory.md#nowhere)\n`[e](f)`";
    let faults = broken(&file, text);
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert!(faults[0].ends_with("README.md:1: missing.md") && faults[1].ends_with("#nowhere"), "{faults:?}");
}
