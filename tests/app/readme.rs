//! The commands of README.md and of the guide's first hour, on a fresh clone.

use std::collections::HashSet;
use std::path::Path;
use std::process::Command;

/// The commands of a document, split into words.
fn commands(document: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(document)).unwrap();
    let mut within = false;
    let mut commands = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            within = line == "```sh";
        } else if within && let Some(rest) = line.strip_prefix("leadr ") {
            let command = rest.split("  ").next().unwrap_or_default().split(" # ").next().unwrap_or_default();
            commands.push(command.split_whitespace().map(|word| word.trim_matches('\'').to_owned()).collect());
        }
    }
    commands
}

/// Input files of a command.
fn inputs(command: &[String]) -> Vec<&str> {
    let is_file = |word: &str| {
        let extension = Path::new(word).extension().and_then(|e| e.to_str()).unwrap_or_default();
        word.starts_with("assets/") || ["png", "hdr", "exr", "glb", "gltf", "ktx2"].contains(&extension)
    };
    let mut output = false;
    let mut files = Vec::new();
    for word in command {
        // `MATERIAL=FILE` reads the file.
        let file = word.rsplit('=').next().unwrap_or_default();
        if !output && is_file(file) {
            files.push(file);
        }
        output = word == "-o";
    }
    files
}

/// Whether a command draws a scene whose maps are an atlas: the sphere or the T-rex, which is the scene of commands that name none.
fn has_atlas(command: &[String]) -> bool {
    let scene = command.iter().position(|word| word == "--scene").map(|at| command[at + 1].as_str());
    scene.is_none_or(|scene| ["sphere", "trex"].contains(&scene))
}

#[test]
fn files_that_commands_read_are_there_or_made_before() {
    let commands = commands("README.md");
    assert!(commands.len() > 15, "{commands:?}");
    let mut made = HashSet::new();
    for command in &commands {
        for file in inputs(command) {
            let there = Path::new(env!("CARGO_MANIFEST_DIR")).join(file).exists();
            assert!(there || made.contains(file), "{}: no {file}", command.join(" "));
        }
        made.extend(command.iter().skip_while(|word| *word != "-o").skip(1).take(1).map(String::as_str));
    }
}

#[test]
#[ignore = "long"]
fn commands_on_assets_run() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(concat!(env!("CARGO_MANIFEST_DIR"), "/assets"), folder.path().join("assets")).unwrap();
    let mut count = 0;
    for command in commands("README.md") {
        let reads = inputs(&command);
        if reads.is_empty() || !reads.iter().all(|file| file.starts_with("assets/")) {
            continue;
        }
        let mut run = Command::new(env!("CARGO_BIN_EXE_leadr"));
        run.args(&command).current_dir(folder.path()).env_remove("LEADR_LOG");
        run.env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
        if command[0] == "capture" {
            run.args(["--camera", "mid", "--size", "48x27", "--samples", "1"]);
            if has_atlas(&command) {
                run.args(["--atlas-tile", "8"]);
            }
        }
        let output = run.output().expect("the program starts");
        assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
        count += 1;
    }
    assert!(count >= 6, "{count} commands read assets/");
}

/// Literally, except for smaller pictures and fewer samples.
#[test]
#[ignore = "long"]
fn first_hour_commands_work() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(concat!(env!("CARGO_MANIFEST_DIR"), "/assets"), folder.path().join("assets")).unwrap();
    let commands = commands("docs/guide/first-hour.md");
    assert!(commands.len() >= 14, "{commands:?}");
    for command in commands {
        let mut words: Vec<&str> = command.iter().map(String::as_str).collect();
        for (flag, smaller) in [("--size", "48x27"), ("--samples", "1"), ("--frames", "0..2"), ("--max-flip", "1")] {
            let value = words.iter().position(|word| *word == flag).map(|at| at + 1);
            match value {
                // For the bench it is a count.
                Some(at) if flag == "--frames" && words[0] == "bench" => words[at] = "1",
                Some(at) => words[at] = smaller,
                None if words[0] == "capture" && ["--size", "--samples"].contains(&flag) => {
                    words.extend([flag, smaller])
                }
                None => {}
            }
        }
        if has_atlas(&command) && words[0] == "capture" {
            words.extend(["--atlas-tile", "8"]);
        }
        let mut run = Command::new(env!("CARGO_BIN_EXE_leadr"));
        run.args(&words).current_dir(folder.path()).env_remove("LEADR_LOG");
        run.env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
        let output = run.output().expect("the program starts");
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        for file in words.iter().skip_while(|word| **word != "-o").skip(1).take(1) {
            assert!(folder.path().join(file).exists(), "{words:?} wrote no {file}");
        }
    }
}
