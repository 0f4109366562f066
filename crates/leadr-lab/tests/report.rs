//! Tests `leadr-lab report`. A section runs from end to end on the device, and errors are tested.

use std::path::Path;
use std::process::{Command, Output};

use leadr_maps::load_color_srgb8;
use leadr_testing::gpu::test_gpu;
use serde_json::Value;

fn report(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leadr-lab"));
    command
        .arg("report")
        .args(arguments)
        .env_remove("LEADR_LOG")
        .env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
    command.output().expect("the program starts")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn data(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

/// Makes the quick form of a section, and returns its folder.
fn quick(section: &str, output: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let made = report(&["--quick", "--only", section, "--validation", output, "-o", text(folder.path())]);
    assert_eq!(made.status.code(), Some(0), "{}", String::from_utf8_lossy(&made.stderr));
    folder
}

#[test]
#[ignore = "long"]
fn a_section_is_measured_and_written_as_page_data_and_pictures() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("made");
    let output = report(&["--quick", "--only", "table10", "--validation", "--json", "-o", text(&folder)]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("[1/1]"), "no progress on stderr: {stderr}");
    let summary: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(summary["command"], "report");
    assert!(summary["device"].as_str().is_some_and(|device| !device.is_empty()), "{summary}");
    assert!(summary["sections"][0]["findings"].as_array().is_some_and(|f| !f.is_empty()), "{summary}");

    // The error of the paper's grid falls with the grid's size, and no picture equals the reference exactly.
    let data = data(&folder);
    let entries = data["sections"]["table10"]["data"].as_array().unwrap();
    let rrmse = |look: &str| {
        let of = entries.iter().filter(|e| e["look"] == look).map(|e| e["rrmse"].as_f64().unwrap());
        of.map(|e| e * e).sum::<f64>().sqrt()
    };
    let errors = ["leadr 1×1", "leadr 3×3", "leadr 5×5", "leadr 32×32"].map(rrmse);
    assert!(errors.windows(2).all(|pair| pair[0] > pair[1]), "{errors:?}");
    assert!(errors[3] > 0.0 && rrmse("leadr visible 9") < errors[1], "{errors:?}");

    // Every picture on the page exists, is complete and has its stated size. The page loads nothing from elsewhere.
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(!page.contains("http"), "the page refers to something outside");
    let mut pictures = 0;
    for tag in page.split("<img ").skip(1) {
        let attribute = |name: &str| tag.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap();
        let image = load_color_srgb8(folder.join(attribute("src"))).unwrap();
        assert_eq!(image.width.to_string(), attribute("width"));
        assert!(image.texels.iter().any(|t| *t != image.texels[0]), "{} is empty", attribute("src"));
        pictures += 1;
    }
    assert_eq!(pictures, std::fs::read_dir(folder.join("pictures")).unwrap().count());
    assert!(pictures > 10);
}

/// The section is computed on the CPU, but the report opens a device.
#[test]
#[ignore = "long"]
fn sections_keep_page_order() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let output = report(&["--quick", "--only", "model,quadrature", "-q", "-o", text(folder.path())]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "--quiet printed something");
    let page = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    let at = |name: &str| page.find(&format!("<section id=\"{name}\">")).expect(name);
    assert!(at("quadrature") < at("model"));
    // With light from the viewer, direction-correlated shadows are closer to ray casts than Smith's.
    let data = data(folder.path());
    let model = data["sections"]["model"]["data"].as_array().unwrap();
    let front = model.iter().find(|m| m["light"] == "diffuse, light from the viewer" && m["sigma"] == 1.0).unwrap();
    let error = |form: &str| front[form].as_f64().unwrap();
    assert!(error("correlated") < 0.25 * error("smith") && error("noise") < 0.02, "{front}");
}

#[test]
#[ignore = "long"]
fn the_figures_are_checked_by_their_numbers() {
    let Some(_) = test_gpu() else { return };
    let folder = quick("figures", "-q");
    let data = data(folder.path());
    let checks = data["sections"]["figures"]["data"].as_array().unwrap();
    let value = |figure: &str, what: &str| -> f64 {
        let check = checks.iter().find(|c| c["figure"] == figure && c["what"] == what);
        check.unwrap_or_else(|| panic!("{figure} has no {what}"))["value"].as_f64().unwrap()
    };
    // At a distance, a quick picture has only a few noisy pixels, whose error is not significant.
    let seen = |view: &str, look: &str| value("LEADR Figure 1", &format!("rRMSE, {view}, {look}"));
    assert!(seen("near", "leadr, default rules") < 0.5 * seen("near", "normal-mip"));
    assert!(seen("middle", "leadr, default rules") < seen("middle", "normal-mip"));
    let steep = value("LEADR Figure 2", "total variation distance, 80°");
    assert!(steep < 0.25 * value("LEADR Figure 2", "total variation distance to all slopes, 80°"), "{steep}");
    assert!(value("LEADR Figure 6", "largest relative error of the covariance, 128×128") < 1e-3);
    assert!(value("Supplement Figure 1", "largest relative difference up to 85°") < 1e-6);
    assert!(value("Supplement Figure 2", "largest difference relative to the peak") < 1e-9);
    assert!(value("Supplement Figure 3", "largest relative difference up to 85°") < 1e-6);
    let grid = value("Supplement Figure 5", "grid 5×5, 20°");
    assert!(2.0 * grid < value("Supplement Figure 5", "importance samples 5×5, 20°, mean"), "{grid}");
    assert!(2.0 * value("Supplement Figure 5", "16 probes, 20°") < grid, "{grid}");
    let radiance = |what: &str| value("Supplement Figure 5", &format!("radiance, {what}"));
    let [grid_radiance, random_radiance] = [radiance("grid 5×5, 20°"), radiance("importance samples 5×5, 20°, mean")];
    assert!(grid_radiance < random_radiance, "{grid_radiance} {random_radiance}");
    assert!(value("Supplement Figure 6", "pixels facing away, 400 pixels per triangle") > 0.0);
    assert_eq!(value("Supplement Figure 6", "black pixels by default, 400 pixels per triangle"), 0.0);
    assert!(value("Thesis Figure 2.3", "largest difference of masking alone from 1") < 1e-2);
    assert!(value("Thesis Figure 2.6", "rRMSE of half a turn") < 1e-6);
    let differences = |scheme: &str| value("Thesis Figure 3.6", &format!("rRMSE of the slopes, {scheme}"));
    assert!(differences("central") < 0.5 * differences("forward"));
    // Each of the seventeen figures has one line and at least one finding.
    let page = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    let figures: std::collections::BTreeSet<&str> = checks.iter().map(|c| c["figure"].as_str().unwrap()).collect();
    assert_eq!(figures.len(), 17, "{figures:?}");
    for figure in figures {
        assert!(page.contains(&format!("<h3>{figure}</h3>")) && page.contains(&format!("<li>{figure}: ")), "{figure}");
    }
}

#[test]
fn wrong_calls_are_explained_and_leave_no_files() {
    let line = |output: &Output, code: i32| {
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        assert!(
            output.stdout.is_empty() && stderr.lines().last().unwrap().starts_with("leadr-lab: error: "),
            "{stderr}"
        );
        stderr
    };
    assert!(line(&report(&["--only", "everything"]), 2).contains("everything"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, b"in the way").unwrap();
    assert!(line(&report(&["-o", text(&file)]), 1).contains(text(&file)));
    assert_eq!(std::fs::read(&file).unwrap(), b"in the way");
    let Some(_) = test_gpu() else { return };
    // There is no picture to judge. The error names the failed section, and the earlier report is kept.
    let made = folder.path().join("report");
    std::fs::create_dir(&made).unwrap();
    std::fs::write(made.join("index.html"), b"earlier report").unwrap();
    let fault = line(&report(&["--only", "misses", "-o", text(&made)]), 1);
    assert!(fault.contains("section misses") && fault.contains("--only"), "{fault}");
    assert_eq!(std::fs::read(made.join("index.html")).unwrap(), b"earlier report");
    assert_eq!(std::fs::read_dir(&made).unwrap().count(), 1, "the earlier report was overwritten");
}

/// Deformed surfaces are drawn near, in the middle and far.
#[test]
#[ignore = "long"]
fn shapes_are_drawn_near_and_far() {
    let Some(_) = test_gpu() else { return };
    let folder = quick("shapes", "-q");
    let data = data(folder.path());
    let cases = data["sections"]["shapes"]["data"].as_array().unwrap();
    for name in ["Stretching", "Shearing", "Height scale"] {
        for view in ["", ", near", ", far"] {
            let subject = format!("{name} by 100 %{view}");
            let case = cases.iter().find(|case| case["subject"] == subject.as_str()).expect(&subject);
            assert!(case["object"]["rrmse"].as_f64().is_some_and(f64::is_finite), "{case}");
        }
    }
}

/// Moments keep the appearance of a surface at falling resolution of its map. Mips of normals lose it.
#[test]
#[ignore = "long"]
fn maps_of_falling_resolution_are_compared() {
    let Some(_) = test_gpu() else { return };
    let folder = quick("resolution", "--json");
    let data = data(folder.path());
    let rows = data["sections"]["resolution"]["data"].as_array().unwrap();
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    assert_eq!(rows.len(), 24);
    for pair in rows.chunks_exact(2) {
        let [moments, naive] = pair else { unreachable!("pairs of both forms") };
        assert_eq!((&moments["form"], &naive["form"]), (&"moments".into(), &"mips of normals".into()));
        let [error, naive_error] = [moments, naive].map(|row| number(row, "rrmse_of_blocks"));
        assert!(error < 0.6 * naive_error, "{moments} {naive}");
    }
    for files in rows.chunks_exact(6) {
        assert!(40.0 * number(&files[4], "bytes") < number(&files[0], "bytes"), "{files:?}");
    }
}

/// At a distance, classes of facets are closer to the reference than one Gaussian.
#[test]
#[ignore = "long"]
fn classes_of_facets_are_compared_with_one_gaussian() {
    let Some(_) = test_gpu() else { return };
    let folder = quick("classes", "--json");
    let data = &data(folder.path())["sections"]["classes"]["data"];
    let list = |key: &str| data[key].as_array().unwrap().clone();
    let pair = |of: &Value| [0, 1].map(|way| of[way].as_f64().unwrap());
    let rows = list("pictures");
    let far: Vec<&Value> = rows.iter().filter(|row| row["view"] == "far" || row["view"] == "low").collect();
    assert_eq!(far.len(), 6);
    for row in far {
        let [gaussian, classes] = pair(&row["rrmse"]);
        assert!(classes < 0.6 * gaussian, "{row}");
    }
    let [gaussian, classes] = pair(&data["zoom"]["flicker"]);
    assert!(classes < gaussian, "{gaussian} {classes}");
    // A file with more classes is larger and describes reflections better, and blocks are smaller than 16-bit floats.
    let files = list("files");
    assert_eq!(files.len(), 8);
    let of = |index: usize, key: &str| files[index][key].as_f64().unwrap();
    for i in 0..6 {
        assert!(of(i, "bytes_per_texel") < of(i + 2, "bytes_per_texel"), "{files:?}");
        assert!(of(i, "error") > of(i + 2, "error"), "{files:?}");
    }
    for i in [0, 2, 4, 6] {
        assert!(of(i, "bytes_per_texel") > of(i + 1, "bytes_per_texel"), "{files:?}");
    }
}

/// The figures of Chan 2018 are drawn, each with its checks, and have the paper's numbers where it has any.
#[test]
fn the_figures_of_chan_are_drawn() {
    let Some(_) = test_gpu() else { return };
    let folder = quick("chan", "--json");
    let data = data(folder.path());
    let checks = data["sections"]["chan"]["data"].as_array().unwrap();
    let value = |figure: &str, what: &str| {
        let found = checks.iter().find(|c| c["figure"] == figure && c["what"].as_str().unwrap().contains(what));
        found.unwrap_or_else(|| panic!("{figure}: {what}"))["value"].as_f64().unwrap()
    };
    let names = "3 6 8 9 11 12 13 14 15 17 18 19 20 23 24 25 26 27 28 29 30 31 32 33 34";
    let others = ["Chan section 4.8", "Chan section 5.7", "Chan algorithm 5"].map(str::to_owned);
    for name in names.split(' ').map(|number| format!("Chan Figure {number}")).chain(others) {
        assert!(checks.iter().any(|check| check["figure"] == name.as_str()), "{name}");
    }
    let near = |figure: &str, what: &str, want: f64, most: f64| {
        let found = value(figure, what);
        assert!((found - want).abs() < most, "{figure}, {what}: {found} instead of {want}");
    };
    near("Chan Figure 6", "gloss 0, macrosurface", 0.66667, 1e-5);
    near("Chan Figure 6", "gloss 0, microsurface", 0.5, 1e-5);
    near("Chan Figure 12", "eq. 40", 5.4e-4, 2e-5);
    near("Chan Figure 12", "eq. 42", 3.2e-4, 2e-5);
    // Fits of the same forms end near the paper's.
    near("Chan Figure 12", "eq. 39, fitted", 4.2e-4, 2e-5);
    near("Chan Figure 12", "eq. 41, fitted", 3.2e-4, 2e-5);
    near("Chan Figure 12", "Listing 8, entries", 248.0, 0.1);
    near("Chan Figure 12", "Listing 8 less eq. 26, mean", 2.03e-6, 1e-8);
    near("Chan Figure 11", "largest", 0.0167, 2e-3);
    assert!(value("Chan Figure 11", "fitted again, rms") < value("Chan Figure 11", "rms"));
    assert!(value("Chan Figure 12", "16384 samples") < 2e-4);
    near("Chan Figure 19", "closed", 0.0, 1e-9);
    // The renderer draws the formulas: flatter where rough, rounder where smooth.
    for figure in ["Chan Figure 24", "Chan Figure 25"] {
        for model in ["lambert", "oren-nayar", "disney", "call-of-duty"] {
            let error = value(figure, &format!("{model}: picture"));
            assert!(error < 0.03, "{figure}, {model}: {error}");
        }
    }
    let rim = |figure, model: &str| value(figure, &format!("{model}: rim"));
    for model in ["oren-nayar", "disney", "call-of-duty", "multiscattering"] {
        assert!(rim("Chan Figure 24", model) > rim("Chan Figure 24", "lambert"), "{model}");
    }
    for model in ["disney", "call-of-duty", "multiscattering"] {
        assert!(rim("Chan Figure 25", model) < 0.9 * rim("Chan Figure 24", model), "{model}");
    }
    // The published fit is nearer to the walks than Lambert's law, and the model of this project nearer still.
    let of = |what: &str, gloss: u32| value("Chan Figure 33", &format!("{what}, gloss {gloss}"));
    assert!(of("less the published fit", 0) < value("Chan Figure 26", "full BRDF, gloss 0,"));
    assert!(of("less multiscattering_diffuse", 180) < of("less the published fit", 180));
    // LEADR is nearly as bright far as near, and shortened normals are too bright.
    near("Chan section 4.8", "lambert, sun 60° behind the viewer: far / near, LEADR", 1.0, 0.06);
    assert!(value("Chan section 4.8", "lambert, sun 60° behind the viewer: far / near, gloss") > 1.1);
    // The distant bricks are about as bright as the near ones, and coarse levels have less gloss.
    near("Chan Figure 9", "gloss: mean of distant", 1.0, 0.15);
    let gloss = [0, 1, 2, 3].map(|level| value("Chan Figure 8", &format!("level {level}")));
    assert!(gloss.is_sorted_by(|a, b| a > b), "{gloss:?}");
    // Relaxation converges to the direct solution at smoothness 1.
    let left = |sweeps: &str| value("Chan algorithm 5", &format!("{sweeps} sweeps"));
    assert!(left("3") > left("10") && left("10") > left("100"));
    let [open, soft] =
        ["open", "soft"].map(|edge| value("Chan Figure 17", &format!("light that the cones leave, edge {edge}")));
    assert!(soft < open && open < 1.0 && value("Chan Figure 14", "light that the cones leave") < 1.0);
    // One function of three arguments needs more coefficients for less error.
    let fit = |degree: u32| value("Chan section 5.7", &format!("degree {degree},"));
    assert!(fit(1) > fit(2) && fit(2) > fit(3));
    // The cone about the normal hides too much of smooth water.
    assert!(value("Chan Figure 20", "cone about the normal: mean") < -0.02);
    assert!(value("Chan Figure 20", "eq. 60 and listing 3: mean") > 0.0);
}
