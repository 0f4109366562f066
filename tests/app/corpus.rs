//! Runs `scripts/corpus` over files with odd names.

use std::path::Path;
use std::process::Command;

#[test]
fn every_file_of_a_folder_is_drawn_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([90, 120, 60]));
    for name in ["-x | `y`\nz<b>.png", "$(touch made).PNG", "stone/stone_Color.jpg", "stone/old_odd.png"] {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        picture.save(file).unwrap();
    }
    std::fs::write(folder.path().join("notes.txt"), "no picture").unwrap();
    std::fs::write(folder.path().join("damaged.glb"), "glTF").unwrap();
    let corpus = |seconds: &str| {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/corpus");
        let mut command = Command::new(script);
        command.env("LEADR", env!("CARGO_BIN_EXE_leadr")).env("SECONDS_EACH", seconds).env_remove("LEADR_LOG");
        let output = command.arg(".").current_dir(folder.path()).output().expect("the script starts");
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, table) = corpus("120");
    assert_eq!(code, Some(0), "{table}");
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with("| ./")).collect();
    assert_eq!(rows.len(), 6, "{table}");
    let row = |name: &str| *rows.iter().find(|row| row.contains(name)).unwrap_or_else(|| panic!("no {name}: {table}"));
    assert!(row("-x \\| \\`y\\` z\\<b\\>.png").ends_with("| picture | drawn |  |"), "{table}");
    assert!(row("$(touch made).PNG").contains("| drawn |") && !folder.path().join("made").exists(), "{table}");
    assert!(
        row("stone |").contains("| material | remarked |") && row("stone |").contains("not used: old\\_odd.png"),
        "{table}"
    );
    assert!(row("damaged.glb").contains("| model | refused | ./damaged.glb: "), "{table}");
    assert!(table.ends_with("4 drawn, 1 drawn with a remark, 1 refused, 0 failed.\n"), "{table}");
}
