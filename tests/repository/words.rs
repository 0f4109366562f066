//! Keeps words out of user documents that are not terms of the field or are hard to read (docs/style.md).

use std::fs;

use crate::source::{files_under, prose, root};

/// The word or phrase, and its replacement.
const REFUSED: [(&str, &str); 16] = [
    ("mirrors", "the specular term"),
    ("what of the", "a noun"),
    ("by which it is", "a noun"),
    ("of which the", "a noun"),
    ("where that", "a noun"),
    ("whoever", "you"),
    ("from afar", "at a distance"),
    ("turn and turn about", "interleaved"),
    ("settled constants", "specialised constants"),
    ("so that nobody", "the reason"),
    ("is told", "recorded, declared or printed"),
    ("are told", "recorded, declared or printed"),
    ("tells what", "says or gives"),
    ("wants to know", "the reason"),
    ("the dip", "F82 tint"),
    ("the lack", "the shortening"),
];

/// The refused words of a text, with their lines. Code in backticks and fences is ignored.
fn refused(path: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    for (number, line) in prose(text) {
        let words = line.split('`').step_by(2).collect::<Vec<_>>().join("` `").to_lowercase();
        for (word, better) in REFUSED {
            let ends = |at: usize| !words[at..].starts_with(|c: char| c.is_alphanumeric());
            let starts = |at: usize| !words[..at].ends_with(|c: char| c.is_alphanumeric());
            if words.match_indices(word).any(|(at, _)| starts(at) && ends(at + word.len())) {
                faults.push(format!("{path}:{}: `{word}`; write {better}", number + 1));
            }
        }
    }
    faults
}

#[test]
fn guides_use_the_fields_words() {
    let mut files = files_under(&root().join("docs/guide"), &["md"]);
    files.extend(["README.md", "docs/theory.md"].map(|name| root().join(name)));
    assert!(files.len() > 20, "only {} pages were read", files.len());
    // Generated from the help texts.
    files.retain(|file| !file.ends_with("options.md"));
    let faults: Vec<String> = (files.iter())
        .flat_map(|file| {
            let name = file.strip_prefix(root()).unwrap().display().to_string();
            refused(&name, &fs::read_to_string(file).unwrap())
        })
        .collect();
    assert!(faults.is_empty(), "see docs/style.md:\n{}", faults.join("\n"));
}

#[test]
fn refused_words_are_found_in_prose_alone() {
    assert_eq!(refused("x", "Light\nthat the surface mirrors.").len(), 1);
    assert_eq!(refused("x", "From afar, `mirrors` is a name.").len(), 1);
    assert!(refused("x", "```\nwhoever\n```\nA mirrorsmith.").is_empty());
}
