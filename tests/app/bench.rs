//! Runs `leadr bench`, and proves that the timed frame is the drawn frame.

use std::process::{Command, Output};

use leadr::render::frame::Layer;
use leadr::render::light::sky::Sky;
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::stage::Lights;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::stage_under_sky;
use leadr_tools::bench::full_screen::full_screen_stage;
use serde_json::Value;

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
    command.args(arguments).env_remove("LEADR_LOG").env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
    command.output().expect("the program starts")
}

fn json(arguments: &[&str]) -> Value {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Checks the fields of every report and the passes of every row.
fn check(report: &Value) {
    for key in ["device", "driver", "commit"] {
        assert!(report[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {report}");
    }
    let rows = report["rows"].as_array().unwrap();
    assert!(!rows.is_empty());
    for row in rows {
        for key in ["table", "row", "technique", "pass", "rule", "visibility"] {
            assert!(row[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {row}");
        }
        assert!(row["samples"].as_u64().is_some_and(|n| n >= 1), "{row}");
        assert!(row["repeats"].as_u64().is_some_and(|n| n >= 1), "{row}");
        let [median, p95] = ["median_ms", "p95_ms"].map(|key| row[key].as_f64().unwrap());
        assert!(median >= 0.0 && median <= p95, "{row}");
        let of = |pass: &str| {
            let same = |r: &&Value| r["table"] == row["table"] && r["row"] == row["row"] && r["pass"] == pass;
            let found: Vec<_> = rows.iter().filter(same).collect();
            assert_eq!(found.len(), 1, "{pass} of {row}");
            found[0]["median_ms"].as_f64().unwrap()
        };
        assert!(of("geometry") > 0.0 && of("filter+shade") > 0.0 && of("total") > of("filter+shade"), "{row}");
    }
    for ratio in report["ratios"].as_array().unwrap() {
        let [low, median, high] = ["low", "median", "high"].map(|key| ratio[key].as_f64().unwrap());
        assert!(0.0 < low && low <= median && median <= high, "{ratio}");
    }
}

#[test]
fn a_scene_is_measured_near_and_far() {
    let Some(_) = test_gpu() else { return };
    let flags = ["bench", "--scene", "plane", "--tables", "techniques,distance", "--technique", "leadr"];
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("plane.csv");
    let flags = [&flags[..], &["--size", "24x16", "--frames", "2", "--validation", "--csv", table.to_str().unwrap()]];
    let report = json(&[&flags.concat()[..], &["--json"]].concat());
    let csv = std::fs::read_to_string(&table).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert!(
        csv.starts_with("table,row,pass,technique,")
            && csv.contains(",probes,")
            && csv.contains(",distance_m,")
            && csv.contains(",median_ms,")
    );
    assert_eq!(csv.lines().count(), rows.len() + 1, "{csv}");
    for (line, row) in csv.lines().skip(1).zip(rows) {
        let texts = [&row["pass"], &row["technique"]].map(|text| format!(",{},", text.as_str().unwrap()));
        let median: f64 = line.rsplit(',').nth(4).unwrap().parse().unwrap();
        assert!(texts.iter().all(|text| line.contains(text)), "{line}");
        // Decimals of single precision, such as 2.1999998, are not printed.
        let distance = row["distance"].as_f64().map(|metres| metres.to_string()).unwrap_or_default();
        assert!(line.contains(&format!(",{distance},")) && distance.len() <= 9, "{line}");
        assert!((median - row["median_ms"].as_f64().unwrap()).abs() < 1e-6, "{line}");
    }
    check(&report);
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["technique"] == "leadr" && row["measurements"] == 2), "{report}");
    assert!(rows.iter().all(|row| row["size"] == serde_json::json!([24, 16])), "{report}");
    let far: Vec<f64> = rows
        .iter()
        .filter(|row| row["table"] == "plane from afar" && row["pass"] == "total")
        .map(|row| row["distance"].as_f64().unwrap())
        .collect();
    assert!(far.len() >= 4 && far.windows(2).all(|pair| pair[0] < pair[1]), "{far:?}");
    assert_eq!(report["goals"], serde_json::json!([]), "nothing of the goals was measured");
}

/// Rows of a table with this pass, in order.
fn rows_of<'a>(report: &'a Value, table: &str, pass: &str) -> Vec<&'a Value> {
    report["rows"].as_array().unwrap().iter().filter(|r| r["table"] == table && r["pass"] == pass).collect()
}

#[test]
#[ignore = "long"]
fn frame_reports_triangles_and_cpu_time() {
    let Some(_) = test_gpu() else { return };
    let flags = ["bench", "--scene", "plane", "--tables", "views,resolution", "--size", "48x32"];
    let report = json(&[&flags[..], &["--frames", "2", "--validation", "--json"]].concat());
    check(&report);
    let frames = rows_of(&report, "plane views, 48x32", "frame");
    assert_eq!(frames.iter().map(|r| r["row"].as_str().unwrap()).collect::<Vec<_>>(), ["near", "mid", "far"]);
    for frame in &frames {
        let time = |pass: &str| {
            let cell = rows_of(&report, "plane views, 48x32", pass).into_iter().find(|r| r["row"] == frame["row"]);
            cell.unwrap()["min_ms"].as_f64().unwrap()
        };
        let parts = ["cpu prepare", "cpu record", "cpu wait"].map(time);
        assert!(parts.iter().all(|part| *part > 0.0), "{frame}: {parts:?}");
        assert!(time("frame") >= parts.iter().sum::<f64>() * 0.999, "{frame}: {parts:?}");
        assert!(frame["triangles"].as_u64() > frame["patches"].as_u64() && frame["patches"].as_u64() > Some(0));
    }
    let sizes: Vec<&Value> = rows_of(&report, "plane by size of picture", "total").iter().map(|r| &r["size"]).collect();
    assert_eq!(serde_json::json!(sizes), serde_json::json!([[12, 8], [24, 16], [48, 32], [96, 64]]));
    let flags = ["bench", "--scene", "plane", "--tables", "triangles", "--size", "320x240", "--technique", "lean"];
    let report = json(&[&flags[..], &["--frames", "1", "--json"]].concat());
    let counts: Vec<u64> = rows_of(&report, "plane by size of triangles", "frame")
        .iter()
        .map(|r| r["triangles"].as_u64().unwrap())
        .collect();
    assert!(
        counts.len() == 5 && counts.windows(2).all(|pair| pair[0] >= pair[1]) && counts[0] > counts[4],
        "{counts:?}"
    );
}

#[test]
#[ignore = "long"]
fn map_sizes_compare_leadr_with_lean() {
    let Some(_) = test_gpu() else { return };
    let flags = ["bench", "--scene", "pillow", "--tables", "maps", "--size", "16x16", "--frames", "1"];
    let report = json(&[&flags[..], &["--validation", "--json"]].concat());
    check(&report);
    let rows = rows_of(&report, "pillow by size of maps", "total");
    assert_eq!(rows.iter().filter(|r| r["technique"] == "leadr").count(), 4);
    let ratios = report["ratios"].as_array().unwrap();
    for row in rows.iter().filter(|r| r["technique"] == "leadr") {
        let lean = row["row"].as_str().unwrap().replace("leadr", "lean");
        assert!(
            ratios.iter().any(|r| r["of"] == row["row"] && r["to"] == *lean && r["pass"] == "filter+shade"),
            "{lean}"
        );
    }
    let across = |r: &&Value| r["pass"] == "total" && r["to"] == rows[0]["row"];
    assert_eq!(ratios.iter().filter(across).count(), rows.len() - 1);
}

#[test]
fn a_run_is_compared_with_an_earlier_one() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let flags = ["bench", "--scene", "plane", "--tables", "views", "--technique", "lean", "--frames", "2"];
    let report = json(&[&flags[..], &["--size", "16x12", "--json"]].concat());
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let old = write("old.json", &report.to_string());
    let again = json(&[&flags[..], &["--size", "16x12", "--against", &old, "--json"]].concat());
    let compared = &again["against"];
    assert!(compared["only_in_this"] == serde_json::json!([]) && compared["only_in_that"] == serde_json::json!([]));
    let rows = compared["rows"].as_array().unwrap();
    for row in report["rows"].as_array().unwrap().iter().filter(|row| row["min_ms"].as_f64().unwrap() > 0.0) {
        let same = |r: &&Value| ["table", "row", "pass", "size"].iter().all(|key| r[key] == row[key]);
        assert!(rows.iter().any(|r| same(&r)), "{row}");
    }
    assert!(compared["passes"].as_array().unwrap().iter().any(|mean| mean["pass"] == "total" && mean["rows"] == 3));

    // The same times doubled, another device name, other sizes.
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut changed = report.clone();
        change(&mut changed);
        changed.to_string()
    };
    let doubled = |report: &mut Value| {
        for row in report["rows"].as_array_mut().unwrap() {
            for key in ["median_ms", "min_ms"] {
                row[key] = serde_json::json!(2.0 * row[key].as_f64().unwrap());
            }
        }
    };
    let slow = write("slow.json", &changed(&doubled));
    let compare = |new: &str, more: &[&str]| {
        let output = run(&[&["bench", "--measured", new, "--against", &old], more].concat());
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (code, stdout, _) = compare(&slow, &["--json"]);
    let slower: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((code, &slower["command"]), (Some(0), &serde_json::json!("bench")));
    for row in slower["against"]["rows"].as_array().unwrap() {
        assert!(
            ["min_ratio", "median_ratio"].iter().all(|key| (row[key].as_f64().unwrap() - 2.0).abs() < 1e-9),
            "{row}"
        );
    }
    let (code, stdout, stderr) = compare(&slow, &["--max-ratio", "1.9"]);
    assert!(code == Some(1) && stdout.contains("2.000 2.000") && stderr.contains("over 1.9"), "{stdout}{stderr}");
    assert_eq!(compare(&slow, &["--max-ratio", "2.1"]).0, Some(0));

    let elsewhere = write("elsewhere.json", &changed(&|report| report["device"] = "another".into()));
    let other = write(
        "other.json",
        &changed(&|report| {
            report["rows"].as_array_mut().unwrap().iter_mut().for_each(|row| row["size"] = serde_json::json!([9, 9]));
        }),
    );
    let cut = write("cut.json", &report.to_string()[..400]);
    let refused = [(&elsewhere, "--any-device"), (&other, "no row in common"), (&cut, "cut.json"), (&cut, "too early")];
    for (new, reason) in refused {
        let (code, stdout, stderr) = compare(new, &[]);
        assert!(code == Some(1) && stdout.is_empty(), "{new}: {stderr}");
        assert!(stderr.lines().count() == 1 && stderr.contains(reason), "{stderr}");
    }
    assert_eq!(compare(&elsewhere, &["--any-device"]).0, Some(0));
    // A run on this device does not start.
    let output = run(&[&flags[..], &["--against", &elsewhere]].concat());
    assert!(output.status.code() == Some(1) && output.stdout.is_empty());
}

#[test]
fn a_forward_pass_is_timed_beside_the_renderer() {
    let Some(_) = test_gpu() else { return };
    let report = json(&["bench", "--forward", "--size", "16x16", "--frames", "1", "--validation", "--json"]);
    let (rows, ratios) = (report["rows"].as_array().unwrap(), report["ratios"].as_array().unwrap());
    let forward: Vec<&Value> = rows.iter().filter(|r| r["pass"] == "forward").collect();
    assert_eq!(forward.len(), 9);
    assert!(forward.iter().all(|r| r["min_ms"].as_f64().unwrap() > 0.0), "{report}");
    for technique in ["constant", "blinn-phong", "lean", "leadr"] {
        for pass in ["filter+shade", "geometry+filter+shade"] {
            let found = ratios
                .iter()
                .find(|r| r["of"] == technique && r["to"] == format!("forward {technique}") && r["pass"] == pass);
            assert!(found.is_some_and(|r| r["fastest"].as_f64().unwrap() > 0.0), "{technique}, {pass}: {report}");
        }
    }
    assert_eq!(report["goals"].as_array().unwrap().len(), 6, "{report}");
}

#[test]
#[ignore = "long"]
fn the_passes_of_the_sea_are_timed_one_by_one() {
    let Some(_) = test_gpu() else { return };
    let flags = ["bench", "--scene", "ocean", "--technique", "lean", "--size", "16x12", "--fft", "64", "--frames", "1"];
    let report = json(&[&flags[..], &["--validation", "--json"]].concat());
    check(&report);
    let rows = report["rows"].as_array().unwrap();
    let passes = ["wave rows", "wave columns", "wave mips", "sea geometry", "sea filter and shade"];
    for (table, name) in ["fft 64", "fft 128", "fft 256", "fft 512"]
        .map(|name| ("ocean, transforms", name))
        .into_iter()
        .chain(["8x6", "16x12", "32x24"].map(|name| ("ocean, pictures", name)))
    {
        let time = |pass: &str| {
            let row = rows.iter().find(|r| r["table"] == table && r["row"] == name && r["pass"] == pass);
            row.unwrap_or_else(|| panic!("{pass} of {name}"))["median_ms"].as_f64().unwrap()
        };
        assert!(passes.iter().all(|pass| time(pass) > 0.0), "{name}: {report}");
        assert!(time("total") >= passes.iter().map(|pass| time(pass)).sum::<f64>() * 0.999);
    }
    let ratio = |of: &str| {
        let found = report["ratios"].as_array().unwrap().iter().find(|r| {
            r["table"] == "ocean, transforms" && r["of"] == of && r["pass"] == "wave rows+wave columns+wave mips"
        });
        found.unwrap_or_else(|| panic!("ratio of {of}"))["median"].as_f64().unwrap()
    };
    assert!(ratio("fft 64") < 1.0 && ratio("fft 512") > 1.0, "transforms of more samples take longer");
}

#[test]
#[ignore = "long"]
fn frames_leave_nothing_in_memory() {
    let Some(_) = test_gpu() else { return };
    let soak = |scene: &str, frames: &str, more: &[&str]| {
        let flags = ["bench", "--scene", scene, "--soak", frames, "--size", "32x24", "--json"];
        let report = json(&[&flags[..], more].concat());
        let samples = report["samples"].as_array().unwrap();
        assert_eq!(samples.len(), 10);
        for key in ["allocated", "allocations"] {
            assert!(samples[0][key].as_u64().unwrap() > 0);
            assert!(samples.iter().all(|s| s[key] == samples[0][key]), "{key}: {report}");
        }
        report
    };
    // Techniques alternate, and samples are taken after equal numbers of frames: ten samples need ten frames of each technique.
    soak("plane", "140", &["--validation"]);
    soak("ocean", "20", &["--fft", "64", "--technique", "leadr", "--validation"]);
    // The validation layer keeps about 16 KiB per frame, so resident memory is checked without it.
    let report = soak("ocean", "50", &["--fft", "64", "--technique", "leadr"]);
    if let Some(growth) = report["resident_growth"].as_i64() {
        println!("resident memory grew by {growth} bytes over {} frames", report["frames"]);
        assert!(growth < 1 << 20, "{report}");
    }
}

#[test]
#[ignore = "long"]
fn the_papers_tables_have_their_rows_ratios_lines_and_goals() {
    let Some(_) = test_gpu() else { return };
    let report = json(&["bench", "--paper", "--size", "8x8", "--frames", "1", "--json"]);
    check(&report);
    let total = |table: &str, row: &str| {
        let rows = report["rows"].as_array().unwrap();
        rows.iter().any(|r| r["table"] == table && r["row"] == row && r["pass"] == "filter+shade")
    };
    for row in ["constant", "blinn-phong", "normal-mip", "toksvig", "clean", "lean", "leadr", "leadr-ggx"] {
        assert!(total("specular, one light", row), "{row}");
    }
    for row in ["one sample", "leadr 3x3", "leadr 5x5", "leadr 7x7", "leadr 32x32"] {
        assert!(total("specular environment", row) && total("diffuse environment", row), "{row}");
    }
    for probes in [5, 9, 16] {
        assert!(total("specular environment", &format!("leadr visible {probes}")), "{probes}");
    }
    assert_eq!(report["lines"].as_array().unwrap().len(), 2);
    let goals = report["goals"].as_array().unwrap();
    assert_eq!(goals.len(), 4, "{goals:?}");
    assert!(goals.iter().all(|goal| goal["met"].is_boolean() && goal["median"].as_f64().is_some_and(|m| m > 0.0)));
}

#[test]
fn the_printed_table_names_device_commit_and_rows() {
    let Some(_) = test_gpu() else { return };
    let flags = ["bench", "--scene", "plane", "--tables", "techniques,distance", "--technique", "normal-mip"];
    let output = run(&[&flags[..], &["--size", "8x8", "--frames", "1"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for word in ["commit", "plane, 8x8", "plane from afar", "normal-mip at 8x", "filter+shade"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    // On a busy machine it prints its progress every five seconds.
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.lines().all(|line| line.starts_with("leadr: ")), "something was logged: {message}");
}

#[test]
#[ignore = "long"]
fn page_is_written_for_any_device() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("pages/bench.md");
    let script = |flags: &[&str]| {
        let mut command = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/bench-gpu"));
        command.arg("-o").arg(&page).args(flags).env("LEADR", env!("CARGO_BIN_EXE_leadr")).env("SCENES", "sphere");
        command.output().expect("the script starts")
    };
    let output = script(&["--size", "8x8", "--frames", "1"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&page).unwrap();
    let device = json(&["bench", "--forward", "--size", "8x8", "--frames", "1", "--json"])["device"].clone();
    assert!(text.starts_with(&format!("# {}", device.as_str().unwrap())), "{text}");
    let parts = ["leadr bench --paper --size 8x8", "0.267 ms", "against a forward pass", "sphere views, 8x8"];
    for part in parts.into_iter().chain(["sphere by size of triangles", "sphere by size of maps"]) {
        assert!(text.contains(part), "{part}: {text}");
    }
    // A failing command keeps the page of the last run.
    let output = script(&["--size", "8x8", "--frames", "0"]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("--frames"));
    assert_eq!(std::fs::read_to_string(&page).unwrap(), text);
}

#[test]
fn wrong_usage_ends_with_2_and_names_the_flag() {
    let cases: [(&[&str], &str); 16] = [
        (&["--frames", "0"], "--frames"),
        (&["--size", "0x5"], "--size"),
        (&["--technique", "phong"], "phong"),
        (&["--scene", "cube"], "cube"),
        (&["--height-map", "a.png"], "--scene"),
        (&["--scene", "trex", "--height-map", "a.png"], "--height-map"),
        (&["--scene", "trex", "--fft", "64"], "--fft"),
        (&["--scene", "ocean", "--fft", "100"], "--fft"),
        (&["--soak", "9"], "--scene"),
        (&["--measured", "a.json"], "--against"),
        (&["--measured", "a.json", "--against", "b.json", "--frames", "3"], "--frames"),
        (&["--scene", "plane", "--tables", "maps", "--height-map", "a.png"], "leave --height-map out"),
        (&["--max-ratio", "0", "--against", "a.json"], "--max-ratio"),
        (&["--scene", "trex", "--tables", "speed"], "speed"),
        (&["--scene", "spheres", "--tables", "views,maps"], "--tables maps is for the scenes"),
        (&["--scene", "trex", "--tables", "waves"], "ocean, not trex"),
    ];
    for (flags, named) in cases {
        let output = run(&[&["bench"], flags].concat());
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {stderr}");
        assert!(
            stderr.lines().count() == 1 && stderr.contains(named) && output.stdout.is_empty(),
            "{flags:?}: {stderr}"
        );
    }
    let missing = run(&["bench", "--scene", "plane", "--height-map", "missing.png"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(String::from_utf8(missing.stderr).unwrap().contains("missing.png"));
}

#[test]
fn measured_frame_equals_drawn_frame() {
    let Some(gpu) = test_gpu() else { return };
    let size = (32, 24);
    let mut stage = full_screen_stage(size);
    let mut renderer = stage_under_sky(&gpu, &mut stage, 16);
    let state = stage.state(0.0, &stage.views.mid, &Lights::under(&Sky::default()));
    let settings = RenderSettings {
        size,
        tessellation: TessellationSettings { max_factor: 1.0, cull: false, ..Default::default() },
        displacement: false,
        shadows: false,
        ..Default::default()
    };
    let times = renderer.measure(&state, &settings, 0, 3).unwrap();
    let measured: Vec<[f32; 4]> = renderer.image().unwrap().read(0, 0).unwrap();
    let drawn = renderer.render(&state, &settings).unwrap();
    assert_eq!(measured, drawn.color);
    let passes = |times: &[leadr::render::frame::PassTime]| times.iter().map(|t| t.pass.clone()).collect::<Vec<_>>();
    assert_eq!(passes(&times), passes(&drawn.times), "every pass is timed");
    assert!(times.iter().all(|t| t.milliseconds >= 0.0));
    // The quad fills the picture with one texel per pixel, so its slopes are those of the map.
    assert!(drawn.color.iter().all(|c| c[3] == 1.0));
    assert!(renderer.layer(Layer::Lod).unwrap().iter().all(|lod| lod[0] == 0.0));
    let slopes = renderer.layer(Layer::MeanSlope).unwrap();
    let variance = slopes.iter().map(|s| f64::from(s[0] * s[0] + s[1] * s[1])).sum::<f64>() / slopes.len() as f64;
    assert!((0.1..1.0).contains(&variance), "{variance}");
}
