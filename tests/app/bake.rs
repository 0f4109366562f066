//! Runs `leadr bake`: files, output and errors.

use std::path::Path;
use std::process::{Command, Output};

use leadr::maps::baked::BakedMap;
use leadr::maps::save::{save_exr, save_png_grey16};
use leadr::maps::{HeightMap, LeadrMap, Wrap, load_height_map, load_picture, load_raster};
use leadr_testing::shared::shared_data;

fn bake(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
    command.arg("bake").args(arguments).env_remove("LEADR_LOG");
    command.output().expect("the program starts")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn bumps(file: &Path) {
    let texels =
        (0..48 * 20).map(|i| ((i % 48) as f32 * 0.4).sin() * 0.3 + ((i / 48) as f32 * 0.9).cos() * 0.2).collect();
    save_png_grey16(file, &HeightMap::new(48, 20, texels).unwrap(), -0.5, 0.5).unwrap();
}

#[test]
fn a_height_map_becomes_its_moments() {
    let folder = tempfile::tempdir().unwrap();
    let (heights, baked) = (folder.path().join("bumps.png"), folder.path().join("new/baked.ktx2"));
    bumps(&heights);
    let output = bake(&[text(&heights), "--json", "-o", text(&baked)]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = LeadrMap::new(&load_height_map(&heights).unwrap(), Wrap::Repeat);
    assert_eq!(BakedMap::load(&baked).unwrap().moments().unwrap(), expected);
    assert_eq!((report["kind"].as_str(), report["format"].as_str()), (Some("leadr"), Some("f32")));
    assert_eq!((report["size"][0].as_u64(), report["levels"].as_u64()), (Some(48), Some(6)));
    assert_eq!(report["error"].as_array().unwrap().len(), 6);
    let [xx, yy, _] = expected.mean().slope_covariance();
    for (i, variance) in [xx, yy].into_iter().enumerate() {
        let found = report["slope_variance"][i].as_f64().unwrap();
        assert!((found / variance - 1.0).abs() < 1e-4, "{found} {variance}");
    }
    assert!(report["seconds"].as_f64().unwrap() > 0.0 && report["bytes"].as_u64().unwrap() > 48 * 20 * 32);
    let files: Vec<_> = std::fs::read_dir(baked.parent().unwrap()).unwrap().collect();
    assert_eq!(files.len(), 1, "nothing is left beside it");
}

/// The picture has the table's texels: the open hemisphere first, and the closed cone black (Chan 2018, figure 19).
#[test]
fn the_table_of_cones_is_written() {
    use leadr::reflectance::facets::gloss::Gloss;
    use leadr::reflectance::visible::cone_specular::ConeTable;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cones.exr");
    let output = bake(&["--cone-table", "--gloss-scale", "wwii", "-o", text(&file)]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let picture = load_picture(&file).unwrap().image;
    assert_eq!((picture.width, picture.height), (256, 32));
    let table = ConeTable::new(|gloss| Gloss::Wwii.alpha(gloss));
    for (x, y, cone) in [(0, 0, 0), (31, 31, 0), (7, 20, 3), (31, 0, 6), (9, 9, 7)] {
        let [scale, bias, _] = picture.texels[32 * cone + x + 256 * y];
        let expected = table.albedo(x as f64 / 31.0, y as f64 / 31.0, cone as f64 / 7.0);
        let off = (f64::from(scale) - expected.scale()).abs() + (f64::from(bias) - expected.bias()).abs();
        assert!(
            off < 1e-6 && (cone < 7 || scale == 0.0) && (cone == 7 || scale > 0.0),
            "{x} {y} {cone}: {scale} {bias}"
        );
    }
    for (arguments, word) in [
        (vec!["--cone-table", "-o", "cones.png"], "must end in .exr"),
        (vec!["--cone-table", "a.png", "-o", "cones.exr"], "cannot be used with"),
    ] {
        let output = bake(&arguments);
        let line = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && line.contains(word), "{line}");
    }
}

#[test]
fn the_finest_levels_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let [heights, whole, coarse] = ["bumps.png", "whole.ktx2", "coarse.ktx2"].map(|name| folder.path().join(name));
    bumps(&heights);
    let report = |more: &[&str], file: &Path| -> serde_json::Value {
        let output = bake(&[&[text(&heights), "--json", "-o", text(file)], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (all, fewer) = (report(&[], &whole), report(&["--drop-levels", "2"], &coarse));
    assert_eq!((fewer["size"][0].as_u64(), fewer["levels"].as_u64()), (Some(12), Some(4)));
    assert_eq!((all["dropped_levels"].as_u64(), fewer["dropped_levels"].as_u64()), (Some(0), Some(2)));
    assert!(fewer["bytes"].as_u64().unwrap() * 8 < all["bytes"].as_u64().unwrap(), "{fewer}");
    let [all, fewer] = [&whole, &coarse].map(|file| BakedMap::load(file).unwrap().moments().unwrap());
    assert_eq!(fewer.levels, all.levels[2..]);
    let refused = bake(&[text(&heights), "--drop-levels", "6", "-o", text(&coarse)]);
    let error = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(1) && error.trim().lines().count() == 1, "{error}");
    assert!(error.contains("a map of 48 x 20 texels has no level 6; drop at most 5 levels"), "{error}");
    let printed = bake(&[text(&heights), "--drop-levels", "1", "-o", text(&coarse)]);
    let printed = String::from_utf8_lossy(&printed.stdout).into_owned();
    assert!(
        printed.contains("leadr 24x10, 5 levels") && printed.contains("dropped         1 finest level"),
        "{printed}"
    );
}

/// Writes a map of square tiles with steep borders.
fn tiles(file: &Path) {
    let wall = |i: u32| ((i % 32) as f32 - 15.5).abs();
    let height = |i: u32| ((15.0 - wall(i % 64).max(wall(i / 64))) / 3.0).clamp(0.0, 1.0);
    let map = HeightMap::new(64, 64, (0..64 * 64).map(height).collect()).unwrap();
    save_png_grey16(file, &map, 0.0, 1.0).unwrap();
}

#[test]
fn classes_are_found_stored_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let [heights, ktx2, exr] = ["tiles.png", "tiles.ktx2", "tiles.exr"].map(|name| folder.path().join(name));
    tiles(&heights);
    let one = bake(&[text(&heights), "-o", text(&ktx2)]);
    let report = String::from_utf8_lossy(&one.stdout).into_owned();
    assert!(report.contains("--classes auto stores these ") && report.contains("f32, 32 bytes per texel"), "{report}");
    assert!(report.contains("gentle, high"), "{report}");
    assert!(BakedMap::load(&ktx2).unwrap().class_map().is_none());
    for file in [&ktx2, &exr] {
        let auto = bake(&[text(&heights), "--classes", "auto", "--format", "f16", "--json", "-o", text(file)]);
        assert_eq!(auto.status.code(), Some(0), "{}", String::from_utf8_lossy(&auto.stderr));
        let report: serde_json::Value = serde_json::from_slice(&auto.stdout).unwrap();
        let classes = &report["classes"];
        let count = classes["stored"].as_u64().unwrap() as usize;
        let map = BakedMap::load(file).unwrap().class_map().unwrap();
        assert!(count > 1 && count == map.count() && count == classes["found"].as_array().unwrap().len());
        assert_eq!(report["bytes_per_texel"].as_u64().unwrap() as usize, 16 + 16 * count);
        let errors = classes["reflection_error"].as_array().unwrap();
        assert!(errors[0].as_f64().unwrap() > 2.0 * errors[count - 1].as_f64().unwrap(), "{errors:?}");
        for (class, found) in map.mean().iter().zip(classes["found"].as_array().unwrap()) {
            assert!((class.share - found["share"].as_f64().unwrap()).abs() < 0.02, "{class:?} {found}");
        }
    }
    for (wrong, message) in [
        (["--classes", "5"], "auto"),
        (["--classes", "0"], "auto"),
        (["--kind", "lean"], "--classes is for --kind leadr: leave it out"),
        (["--layout", "oiio"], "the layout oiio holds no classes"),
    ] {
        let mut arguments = vec![text(&heights), "-o", text(&exr)];
        if wrong[0] != "--classes" {
            arguments.extend(["--classes", "2"]);
        }
        arguments.extend(wrong);
        let failed = bake(&arguments);
        let error = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert!(failed.status.code() != Some(0) && error.contains(message), "{wrong:?}: {error}");
    }
}

#[test]
fn classes_that_blocks_would_damage_are_floats() {
    let folder = tempfile::tempdir().unwrap();
    let [heights, file] = ["spikes.png", "spikes.ktx2"].map(|name| folder.path().join(name));
    let bake_blocks = || {
        let baked = bake(&[text(&heights), "--classes", "3", "--format", "bc", "--json", "-o", text(&file)]);
        let report: serde_json::Value = serde_json::from_slice(&baked.stdout).unwrap();
        (report["format"].as_str().unwrap().to_owned(), String::from_utf8_lossy(&baked.stderr).into_owned())
    };
    tiles(&heights);
    let (format, _) = bake_blocks();
    assert_eq!(format, "bc");
    assert!(BakedMap::load(&file).unwrap().class_map().is_some());
    // White noise with heavy tails has steep and gentle texels in every block.
    let height = |i: u32| {
        let bits = i.wrapping_mul(2_654_435_761).rotate_left(15).wrapping_mul(2_246_822_519);
        let rise = 0.02 * ((bits >> 8) as f32 / (1 << 24) as f32).max(1e-6).powf(-0.55);
        (if bits & 1 == 0 { 0.5 + rise } else { 0.5 - rise }).clamp(0.0, 1.0)
    };
    save_png_grey16(&heights, &HeightMap::new(64, 64, (0..4096).map(height).collect()).unwrap(), 0.0, 1.0).unwrap();
    let (format, remarks) = bake_blocks();
    assert!(format == "f16" && remarks.contains("the file has 16-bit floats instead"), "{format} {remarks}");
    assert!(BakedMap::load(&file).unwrap().class_map().is_some());
}

#[test]
fn heights_of_8_bits_lose_their_steps() {
    let folder = tempfile::tempdir().unwrap();
    let (fine, coarse) = (folder.path().join("fine.png"), folder.path().join("coarse.png"));
    let wave = |i: u32| 0.5 + 0.02 * (std::f32::consts::TAU * ((i % 128) as f32 + (i / 128) as f32) / 128.0).sin();
    let heights: Vec<f32> = (0..128 * 128).map(wave).collect();
    for (file, codes) in [(&fine, 65535.0), (&coarse, 255.0)] {
        let texels = heights.iter().map(|h| (h * codes).round() / codes).collect();
        save_png_grey16(file, &HeightMap::new(128, 128, texels).unwrap(), 0.0, 1.0).unwrap();
    }
    let baked = |file: &Path, flags: &[&str]| -> serde_json::Value {
        let out = folder.path().join("out.ktx2");
        let output = bake(&[&[text(file), "--json", "-o", text(&out)], flags].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let [relief, restored, raw] = [(&fine, [].as_slice()), (&coarse, &[]), (&coarse, &["--heights-as-read"])]
        .map(|(file, flags)| baked(file, flags));
    let variance = |report: &serde_json::Value| report["slope_variance"][0].as_f64().unwrap();
    assert!(
        (variance(&restored) / variance(&relief) - 1.0).abs() < 0.1,
        "{} {}",
        variance(&restored),
        variance(&relief)
    );
    assert!(variance(&raw) > 2.0 * variance(&relief));
    assert!(relief["quantisation"].is_null() && raw["quantisation"].is_null());
    let share = |name: &str| restored["quantisation"][name].as_f64().unwrap();
    assert!((share("share_before") - (1.0 - variance(&restored) / variance(&raw))).abs() < 0.02);
    assert!((share("step") - 1.0 / 255.0).abs() < 1e-6 && share("share_after") < 0.1);
    let table = bake(&[text(&coarse), "-o", text(&folder.path().join("o.exr"))]).stdout;
    assert!(String::from_utf8(table).unwrap().contains("codes           the steps between its codes make"));
    let refused = bake(&["--normal", text(&fine), "--heights-as-read", "-o", text(&folder.path().join("o.exr"))]);
    assert_eq!(refused.status.code(), Some(2), "{}", String::from_utf8_lossy(&refused.stderr));
}

#[test]
fn text_and_quiet() {
    let folder = tempfile::tempdir().unwrap();
    let heights = folder.path().join("bumps.png");
    bumps(&heights);
    let out = folder.path().join("o.exr");
    let output = bake(&[text(&heights), "--format", "f16", "--kind", "lean", "-o", text(&out)]);
    let report = String::from_utf8(output.stdout).unwrap();
    assert!(report.starts_with("lean 48x20, 6 levels, f16") && report.contains("slope variance"), "{report}");
    let output = bake(&[text(&heights), "--layout", "oiio", "--quiet", "-o", text(&out)]);
    assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0));
}

#[test]
#[ignore = "long"]
fn baked_maps_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let heights = at("bumps.png");
    bumps(&heights);
    let capture = |map: &Path, picture: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
        let flags = ["capture", "--scene", "plane", "--size", "64x48", "--samples", "1", "--height-map"];
        command.args(flags).arg(map).arg("-o").arg(picture).output().expect("the program starts")
    };
    let expected = capture(&heights, &at("png.exr"));
    assert_eq!(expected.status.code(), Some(0), "{}", String::from_utf8_lossy(&expected.stderr));
    for (name, flags) in [("f32.ktx2", "f32"), ("f32.exr", "f32"), ("bc.ktx2", "bc")] {
        let baked = bake(&[text(&heights), "--format", flags, "--json", "-o", text(&at(name))]);
        let report: serde_json::Value = serde_json::from_slice(&baked.stdout).unwrap();
        assert_eq!(report["format"].as_str(), Some(flags));
        let drawn = capture(&at(name), &at("drawn.exr"));
        assert_eq!(drawn.status.code(), Some(0), "{}", String::from_utf8_lossy(&drawn.stderr));
        // The files differ in the recorded commands.
        let picture = |name| load_picture(at(name)).unwrap().image.texels;
        let (expected, drawn) = (picture("png.exr"), picture("drawn.exr"));
        let pairs = expected.as_flattened().iter().zip(drawn.as_flattened());
        let apart = pairs.fold(0.0f32, |apart, (a, b)| apart.max((a - b).abs()));
        // The mean is subtracted before or after baking, which differs in the last digits.
        println!("{name}: {apart:.1e}");
        assert_eq!(apart < 2e-5, flags == "f32", "{name}: {apart:.1e}");
    }
    // Maps of other kinds, and files of others.
    bake(&[text(&heights), "--kind", "lean", "-o", text(&at("lean.ktx2"))]);
    std::fs::write(at("cut.ktx2"), &std::fs::read(at("f32.ktx2")).unwrap()[..900]).unwrap();
    for (name, wanted) in [("lean.ktx2", "--kind leadr"), ("cut.ktx2", "truncated"), ("none.ktx2", "cannot be found")] {
        let refused = capture(&at(name), &at("no.png"));
        let stderr = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(1), "{stderr}");
        assert!(stderr.lines().count() == 1 && stderr.contains(wanted) && stderr.contains(name), "{stderr}");
    }
}

#[test]
fn folder_bakes_every_map() {
    let Some(folder) = shared_data("displacement") else { return };
    let out = tempfile::tempdir().unwrap();
    let baked = out.path().join("metal.ktx2");
    let output = bake(&[text(&folder.join("SheetMetal001")), "--json", "-o", text(&baked)]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(
        stderr.contains("Metalness.png (it does not affect slopes)") && stderr.contains("correlation 0.99"),
        "{stderr}"
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let scale = report["agreement"]["scale_texels"].as_f64().unwrap();
    assert!((report["height_scale"].as_f64().unwrap() * 1024.0 / scale - 1.0).abs() < 1e-6, "{report}");
    let read = BakedMap::load(&baked).unwrap();
    assert_eq!(read.channels.join(" "), "x y xx yy xy height alpha2 alpha4 red green blue -");
    assert_eq!(read.levels.len(), 11);
}

#[test]
fn the_bricks_become_a_set_of_textures() {
    let bricks = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/bricks");
    let out = tempfile::tempdir().unwrap();
    let maps = out.path().join("maps/");
    let folder = format!("{}/", text(&maps));
    let output = bake(&[text(&bricks), "--kind", "height,normal,gloss,occlusion,cones", "--json", "-o", &folder]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let files = report["files"].as_array().unwrap();
    let kinds: Vec<&str> = files.iter().map(|file| file["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["height", "normal", "gloss", "occlusion", "cones"]);
    for file in files {
        let kind = file["kind"].as_str().unwrap();
        let read = BakedMap::load(maps.join(format!("bricks_{kind}.ktx2"))).unwrap();
        assert_eq!((read.kind.name(), read.levels.len() as u64), (kind, file["levels"].as_u64().unwrap()));
    }
    // The bricks' occlusion from heights matches the material's own map, which has another source.
    let own = load_raster(bricks.join("bricks_AmbientOcclusion.png")).unwrap();
    let found = BakedMap::load(maps.join("bricks_occlusion.ktx2")).unwrap().channel("occlusion").unwrap();
    let own: Vec<f32> = (0..own.height())
        .flat_map(|y| (0..own.width()).map(move |x| (x, y)))
        .map(|(x, y)| own.value(x, y, 0))
        .collect();
    let mean = |v: &[f32]| v.iter().map(|&v| f64::from(v)).sum::<f64>() / v.len() as f64;
    let (a, b) = (mean(&own), mean(&found));
    let sums = own.iter().zip(&found).fold([0.0f64; 3], |[both, of_own, of_found], (x, y)| {
        let (x, y) = (f64::from(*x) - a, f64::from(*y) - b);
        [both + x * y, of_own + x * x, of_found + y * y]
    });
    let correlation = sums[0] / (sums[1] * sums[2]).sqrt();
    assert!(correlation > 0.5, "{correlation}, means {a} {b}");
}

#[test]
fn a_distance_limits_occlusion() {
    let folder = tempfile::tempdir().unwrap();
    let heights = folder.path().join("bumps.png");
    bumps(&heights);
    for kind in ["occlusion", "cones"] {
        let mean = |more: &[&str]| {
            let file = folder.path().join("baked.ktx2");
            let flags = [text(&heights), "--height-scale", "0.2", "--kind", kind, "-o", text(&file)];
            let done = bake(&[&flags[..], more].concat());
            assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
            let texels = BakedMap::load(&file).unwrap().channel("occlusion").unwrap();
            texels.iter().map(|&v| f64::from(v)).sum::<f64>() / texels.len() as f64
        };
        let of = |distance: &str| mean(&["--occlusion-distance", distance]);
        let [near, far, unlimited] = [of("0.06"), of("0.2"), mean(&[])];
        assert!(near > far + 0.01 && far > unlimited + 0.005, "{kind}: {near} {far} {unlimited}");
    }
}

#[test]
#[ignore = "long"]
fn heights_and_cones_of_normals_are_drawn() {
    let bricks = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/bricks");
    let out = tempfile::tempdir().unwrap();
    let normals = bricks.join("bricks_NormalGL.png");
    let cones = out.path().join("bricks_Cones.png");
    let output = bake(&["--normal", text(&normals), "--kind", "cones", "-o", text(&cones)]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && stderr.contains("heights from normals: slope RMS"), "{stderr}");
    let mean = |technique: &str, more: &[&str]| {
        let picture = out.path().join("drawn.exr");
        let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
        let flags = [
            "capture",
            "--scene",
            "plane",
            "--size",
            "64x48",
            "--normal-map",
            text(&normals),
            "--technique",
            technique,
        ];
        let done = command.args(flags).args(more).arg("-o").arg(&picture).output().expect("the program starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let image = load_picture(&picture).unwrap().image;
        image.texels.iter().flatten().map(|&v| f64::from(v)).sum::<f64>() / (3 * image.texels.len()) as f64
    };
    for technique in ["gloss", "leadr"] {
        let (open, hidden) = (mean(technique, &[]), mean(technique, &["--cone-map", text(&cones)]));
        assert!(hidden < 0.99 * open && hidden > 0.5 * open, "{technique}: {hidden} of {open}");
    }
}

#[test]
fn sizes_that_differ_are_resampled_by_choice() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    bumps(&at("bumps.png"));
    save_png_grey16(at("gloss.png"), &HeightMap::new(7, 5, vec![0.5; 35]).unwrap(), 0.0, 1.0).unwrap();
    let flags =
        [text(&at("bumps.png")), "--gloss", text(&at("gloss.png")), "--kind", "gloss", "-o", text(&at("o.ktx2"))]
            .map(str::to_owned);
    let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
    let refused = bake(&flags);
    let stderr = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(1) && stderr.contains("7 x 5") && stderr.lines().count() == 1, "{stderr}");
    let done = bake(&[&flags[..], &["--resample"]].concat());
    let stderr = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success() && stderr.contains("resampled from 7 x 5 to 48 x 20"), "{stderr}");
}

#[test]
fn unbakeable_input_gives_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    bumps(&at("bumps.png"));
    save_png_grey16(at("small.png"), &HeightMap::new(2, 2, vec![0.5; 4]).unwrap(), 0.0, 1.0).unwrap();
    save_exr(at("nan.exr"), 3, 1, &[("height", &[1.0, f32::NAN, f32::NAN])]).unwrap();
    std::fs::write(at("cut.png"), &std::fs::read(at("bumps.png")).unwrap()[..60]).unwrap();
    let [bumps, small, nan, cut, out, exr] =
        ["bumps.png", "small.png", "nan.exr", "cut.png", "o.ktx2", "o.exr"].map(|name| text(&at(name)).to_owned());
    let nowhere = format!("{bumps}/under/o.ktx2");
    let cases: [(&[&str], i32, &str); 22] = [
        (&["-o", &out], 2, "<FILE|FOLDER>"),
        (&[&bumps], 2, "--output"),
        (&[&bumps, "-o", "x.gif"], 2, "must end in .ktx2, .exr or .png"),
        (&[&bumps, "-o", "x.png"], 2, "for kind leadr write .ktx2 or .exr"),
        (&[&bumps, "--kind", "height,gloss", "-o", &out], 2, "name a folder"),
        (&[&bumps, "--kind", "gloss,gloss", "-o", "x/"], 2, "gloss twice"),
        (&[&bumps, "--texels", "smooth", "-o", &out], 2, "--texels is for --kind gloss"),
        (&[&bumps, "--detail", &small, "-o", &out], 2, "--detail is for --kind normal and gloss"),
        (
            &[&bumps, "--kind", "height", "--occlusion-distance", "0.1", "-o", &out],
            2,
            "--occlusion-distance is for --kind occlusion and cones: leave it out",
        ),
        (&[&bumps, "--kind", "cones", "--occlusion-distance", "0", "-o", &out], 2, "must be above 0"),
        (&[&bumps, "--kind", "cones", "--occlusion-distance=-1", "-o", &out], 2, "must be above 0"),
        (&[&bumps, "--kind", "cones", "--occlusion-distance", "nan", "-o", &out], 2, "is not a finite number"),
        (&[&bumps, "--format", "bc", "-o", &exr], 2, "choose f32 or f16"),
        (&[&bumps, "--layout", "oiio", "-o", &out], 2, "--layout oiio needs"),
        (&[&bumps, "--layout", "oiio", "--color", &small, "-o", &exr], 2, "no channels for --roughness"),
        (&[&bumps, "--normal-y", "up", "-o", &out], 2, "--normal-y"),
        (&[&bumps, "--height-scale", "0", "-o", &out], 2, "--height-scale"),
        (
            &[&bumps, "--roughness", &small, "-o", &out],
            1,
            "2 x 2 texels, and the height map 48 x 20; give maps of one size, or let leadr bake --resample",
        ),
        (&[&nan, "-o", &out], 1, "66.7 % of its heights are missing"),
        (&[&cut, "-o", &out], 1, "damaged"),
        (&[text(folder.path()), "-o", &out], 1, "NAME_Color.png"),
        (&[&bumps, "-o", &nowhere], 1, "cannot be written (Not a directory"),
    ];
    for (arguments, code, wanted) in cases {
        let output = bake(arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
        assert!(stderr.lines().count() == 1 && stderr.contains(wanted), "{arguments:?}: {stderr}");
        assert!(!at("o.ktx2").exists() && !at("o.exr").exists(), "{arguments:?}");
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 4, "{left:?}");
}

#[test]
fn downloaded_folders_of_every_kind_are_baked() {
    let Some(reports) = shared_data("reports") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (none, out) = ("", folder.path().join("out.ktx2"));
    for (name, used, aside) in [
        ("freepbr/worn-metal", "worn-metal_height.png", "worn-metal_preview.jpg (a preview)"),
        ("freepbr/smooth-stone", "smooth-stone_normal-ogl.png", "smooth-stone_preview.jpg (a preview)"),
        ("polyhaven/rough_wood", "rough_wood_disp_1k.png", "rough_wood_spec_1k.jpg (specular maps"),
        ("poliigon/Ground", "Ground_Displacement.tiff", none),
        ("texturescom/Wall", "TexturesCom_Wall_1K_height.tif", none),
        ("unity/mat", "mat_MetallicSmoothness.png", none),
        ("ue/T_Rock", "T_Rock_ORM.png", none),
        ("substance/mat", "mat_Normal_OpenGL.png", "mat_Normal.png (mat_Normal_OpenGL.png is used instead)"),
        ("ambientcg/Metal055A", "Metal055A_1K-JPG_Roughness.jpg", "Metal055A.png (its name matches no role"),
        ("upper/mat", "MAT_NRM.PNG", "MAT_SPEC.PNG (specular maps"),
    ] {
        let made = bake(&[text(&reports.join(name)), "--resample", "--json", "-o", text(&out)]);
        let [stdout, stderr] = [&made.stdout, &made.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        assert!(made.status.success() && stdout.contains(used) && stderr.contains(aside), "{name}: {stdout} {stderr}");
    }
    // The roughness of a polished material is small.
    let options = ["--height-scale", "0.02", "--format", "f16", "--json", "-o", text(&out)];
    let polished = bake(&[&[text(&reports.join("f16/polished"))], &options[..]].concat());
    let report: serde_json::Value = serde_json::from_slice(&polished.stdout).unwrap();
    let errors: Vec<f64> = report["error"].as_array().unwrap().iter().map(|error| error.as_f64().unwrap()).collect();
    assert!(errors.iter().all(|&error| error < 1e-3), "{errors:?}");
}

/// A model keeps its meshes, and its textures become KTX2 images.
#[cfg(feature = "textures")]
#[test]
fn a_model_gets_filtered_textures() {
    use leadr::models::{Document, LoadOptions, Model};
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/snail.glb");
    let (glb, gltf) = (folder.path().join("snail.glb"), folder.path().join("out/snail.gltf"));
    let output = bake(&[text(&source), "--json", "-o", text(&glb)]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(!report["textures"].as_array().unwrap().is_empty());
    assert_eq!(report["files"].as_array().unwrap().len(), 1);
    assert_eq!(report["bytes"].as_u64().unwrap(), std::fs::metadata(&glb).unwrap().len());
    let mesh = |path: &Path| Model::load(path, LoadOptions::default()).unwrap().meshes;
    assert_eq!(mesh(&glb), mesh(&source));
    let output = bake(&[text(&source), "--for", "godot", "-q", "-o", text(&gltf)]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let document = Document::open(&gltf, &LoadOptions::default()).unwrap();
    assert!(document.images.iter().any(|image| image.file.is_some()));
    assert_eq!(mesh(&gltf), mesh(&source));
    for (wrong, expected) in [
        (vec![text(&source), "--for", "godot", "-o", "x.glb"], "name a .gltf"),
        (vec![text(&source), "--kind", "gloss", "-o", "x.glb"], "--kind is for maps"),
        (vec![text(&source), "-o", "x.ktx2"], "must end in .glb or .gltf"),
        (vec![text(&source), "-o", text(&source)], "is also an input"),
        (vec!["nothing.glb", "-o", "x.glb"], "nothing.glb: cannot be found"),
        (vec!["a.png", "--for", "bevy", "-o", "x/"], "--for takes a model, a material folder"),
        (vec![text(&source), "--for", "unreal", "-o", "x.glb"], "bake the folder of its material"),
        (vec![text(&source), "--for", "unity", "-o", "x.glb"], "use --for gltf"),
    ] {
        let output = bake(&wrong);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() != Some(0) && message.contains(expected), "{wrong:?}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
    assert!(!Path::new("x.glb").exists());
}

/// A material folder becomes a folder of textures for an engine, also from single files.
#[cfg(feature = "textures")]
#[test]
fn a_material_gets_textures_for_an_engine() {
    let folder = tempfile::tempdir().unwrap();
    let bricks = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/bricks");
    let [all, single] = ["unreal/", "single/"].map(|name| folder.path().join(name));
    let output = bake(&[text(&bricks), "--for", "unreal", "--json", "-o", text(&all)]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let files: Vec<std::path::PathBuf> =
        report["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap().into()).collect();
    let names = ["bricks_BaseColor.dds", "bricks_Normal.dds", "bricks_ORM.dds"];
    assert_eq!(files, names.map(|name| all.join(name)));
    let sizes: u64 = files.iter().map(|file| std::fs::metadata(file).unwrap().len()).sum();
    assert_eq!(report["bytes"].as_u64().unwrap(), sizes);
    let roughness = &report["textures"][2]["roughness"];
    assert!(roughness[1].as_f64().unwrap() > roughness[0].as_f64().unwrap(), "{roughness}");
    // The programs of this project read them too.
    let normals = load_raster(&files[1]).unwrap();
    assert_eq!(normals.size(), load_raster(bricks.join("bricks_NormalGL.png")).unwrap().size());

    // The name of the result is that of its source folder, so the textures could replace themselves. A direction of green applies to folders.
    let again = folder.path().join("bricks");
    let turned = folder.path().join("turned/");
    for (target, more) in [(&again, &[][..]), (&turned, &["--normal-y", "down"][..])] {
        std::fs::create_dir_all(target).unwrap();
        let output = bake(&[&[text(&bricks), "--for", "godot", "-q", "-o", text(target)], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let codes = |folder: &Path| load_raster(folder.join("bricks_Normal.dds")).unwrap();
    let (up, down) = (codes(&again), codes(&turned));
    assert!((up.value(9, 9, 1) + down.value(9, 9, 1) - 1.0).abs() < 0.01 && up.value(9, 9, 0) == down.value(9, 9, 0));
    let snail = bricks.with_file_name("snail.glb");

    let normal = bricks.join("bricks_NormalGL.png");
    let output = bake(&[text(&normal), "--for", "bevy", "--json", "-o", text(&single)]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(single.join("bricks_NormalGL_Normal.ktx2").exists() && single.join("bricks_NormalGL_ORM.ktx2").exists());
    for (wrong, expected) in [
        (vec![text(&again), "--for", "godot", "-o", text(&again)], "is also an input"),
        (vec![text(&bricks), "--normal", text(&snail), "--for", "unity", "-o", "x/"], "--normal"),
        (vec!["--roughness", text(&normal), "--normal", text(&bricks), "--for", "unity", "-o", "x/"], "--normal"),
        (vec![text(&bricks), "--for", "unreal", "-o", "x.dds"], "must be a folder or end in /"),
        (vec![text(&bricks), "--for", "unity", "--kind", "gloss", "-o", "x/"], "--kind is for maps"),
        (vec!["--normal", "nothing.png", "--for", "unity", "-o", "x/"], "nothing.png: cannot be found"),
    ] {
        let output = bake(&wrong);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() != Some(0) && message.contains(expected), "{wrong:?}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
    assert!(!Path::new("x").exists());
}
