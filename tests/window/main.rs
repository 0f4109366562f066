//! The window under a real X server (Xvfb), driven like by a user and a window manager: keys, mouse, resizing, covering, minimising,
//! closing. Validation is on throughout and must be silent.
//!
//! Without Xvfb the test fails, unless `LEADR_SKIP_WINDOW=1` skips it. `LEADR_KEEP_SCREENSHOT=FILE.png` keeps a picture for inspection,
//! `LEADR_WINDOW_SIZES=500` sets the number of resizes. A filter selects parts of the test: `cargo test --test window -- storm`.

#[cfg(target_os = "linux")]
#[path = "../../examples/02_orbit.rs"]
mod orbit;
#[cfg(target_os = "linux")]
mod overlays;
#[cfg(target_os = "linux")]
mod server;

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("skipped: the test of the window needs Xvfb, which is there on Linux only");
}

#[cfg(target_os = "linux")]
fn main() {
    // Windows open on the main thread only, so the test restarts itself as the program under test.
    if std::env::var_os("LEADR_WINDOW_CHILD").is_some() {
        if let Err(error) = orbit::main() {
            eprintln!("{error}");
            std::process::exit(1);
        }
        return;
    }
    let requested = |flag: &str| std::env::args().skip(1).any(|argument| argument == flag);
    // cargo-nextest runs the listed tests and queries the ignored ones separately.
    if requested("--list") {
        if !requested("--ignored") {
            println!("window: test");
        }
        return;
    }
    // `cargo test NAME` passes its filter to every test binary.
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    let all = "window".contains(&filter);
    let parts: Vec<_> = linux::PARTS.iter().filter(|(name, _)| all || name.contains(&filter)).collect();
    if parts.is_empty() {
        return;
    }
    linux::no_display_is_a_sentence();
    let server = match server::Server::start() {
        Ok(server) => server,
        Err(reason) if std::env::var("LEADR_SKIP_WINDOW").is_ok_and(|value| value == "1") => {
            return println!("skipped, since LEADR_SKIP_WINDOW=1: {reason}");
        }
        Err(reason) => panic!("the test of the window needs Xvfb (LEADR_SKIP_WINDOW=1 skips it): {reason}"),
    };
    for (name, part) in parts {
        part(&server);
        println!("{name}: passed");
    }
    println!("window: all passed");
}

#[cfg(target_os = "linux")]
mod linux {
    use std::path::Path;
    use std::process::Command;

    use leadr::maps::{Rgb8Image, load_color_srgb8};

    use super::overlays;
    use super::server::{App, Server, until};

    /// A part of the test.
    type Part = fn(&Server);

    /// The parts and their names.
    pub const PARTS: [(&str, Part); 14] = [
        ("user", a_user_looks_around),
        ("frames", a_limited_run_ends),
        ("complete", after_a_coarse_first_picture_comes_all_detail),
        ("walk", the_demo_goes_along_with_the_walk),
        ("controls", every_control_can_be_clicked),
        ("dropped", dropped_files_are_applied),
        ("layout", the_window_opens_as_it_was_left),
        ("storm", a_storm_of_sizes_leaves_nothing_behind),
        ("destroyed", a_window_that_another_program_closes_ends_the_program),
        ("overlays", overlays::overlays_fit_and_escape_closes_them),
        ("moved", overlays::the_panel_moves_the_picture),
        ("limited", overlays::a_limited_run_of_a_still_scene_ends),
        ("opened", overlays::files_are_opened_and_animations_chosen),
        ("lost", overlays::a_lost_display_or_device_is_a_sentence),
    ];

    pub fn no_display_is_a_sentence() {
        let output = App::command(&["--frames", "1"])
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .output()
            .unwrap();
        let written = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{written}");
        assert!(written.contains("no window can be opened") && written.contains("leadr capture"), "{written}");
        assert!(!written.contains(".rs"), "{written}");
    }

    fn a_limited_run_ends(server: &Server) {
        let app = App::start(server, &["--frames", "4", "--width", "64", "--height", "48", "--validation"]);
        let (code, out, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
        assert!(out.contains("\"frames\":4"), "{out}");
    }

    /// Five seconds later the animal has moved by metres, and the window matches a capture of that time, in any environment.
    fn the_demo_goes_along_with_the_walk(server: &Server) {
        let folder = tempfile::tempdir().unwrap();
        let scene = ["--atlas-tile", "8", "--size", "160x120", "--samples", "2", "--validation"];
        let leadr = |flags: &[&str], file: &Path| {
            let mut leadr = Command::new(env!("CARGO_BIN_EXE_leadr"));
            // clap rejects repeated flags, so a given --size replaces the scene's flags.
            let scene = if flags.contains(&"--size") { &["--validation"][..] } else { &scene[..] };
            leadr.arg("capture").args(scene).args(flags).arg("-o").arg(file);
            if let Ok(device) = std::env::var("LEADR_DEVICE") {
                leadr.args(["--device", &device]);
            }
            let output = leadr.env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex")).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            load_color_srgb8(file).unwrap()
        };
        let capture = |time: &str, environment: &str| {
            let file = folder.path().join(format!("{time}-{environment}.png"));
            leadr(&["--time", time, "--environment", environment], &file)
        };
        let [begin, later] = ["0", "5"].map(|time| capture(time, "sky"));
        let studio = capture("5", "studio");

        let mut app = App::demo(server, &[&scene[..], &["--json"]].concat());
        app.find_window(server, "trex");
        let window = app.window();
        server.focus(window);
        let title = || server.title(window);
        // While it walks, frames are drawn without pauses, and simplified on a slow device.
        until(&app, "frames", || title().contains("fps"));
        let picture = || Rgb8Image::new(160, 120, server.picture(window)).unwrap();
        // On a busy machine a second may pass between two frames.
        let mut walking = vec![picture()];
        until(&app, "a step", || {
            walking.push(picture());
            walking.len() >= 8 && walking.windows(2).any(|pair| pair[0].texels != pair[1].texels)
        });
        let off: Vec<f64> = walking.iter().map(|picture| differs(picture, &begin)).collect();
        let (black, step) = (Rgb8Image::new(160, 120, vec![[0; 3]; 160 * 120]).unwrap(), differs(&begin, &later));
        println!("walking: {off:.2?} codes from the first moment, which is {step:.2} from five seconds later");
        assert!(off.iter().all(|off| *off < 2.0 * step) && 4.0 * step < differs(&black, &begin), "{off:?} {step}");
        server.tap(b' ');
        until(&app, "time to stop", || title().contains("(paused)"));
        // X11's arrow keys, left and right, step by half a second, and time does not become negative.
        let shown = |key: u32, times: u32| {
            (0..times).for_each(|_| server.tap(key));
            app.wait_until_idle();
            Rgb8Image::new(160, 120, server.picture(window)).unwrap()
        };
        let first = shown(0xff51, 100);
        let second = shown(0xff53, 10);
        let (same, moved) = (differs(&first, &begin).max(differs(&second, &later)), differs(&begin, &later));
        println!("window and capture differ by {same:.3} codes, the moments by {moved:.3}");
        assert!(same < 0.3 && moved > 5.0 * same, "{same} {moved}");
        // Another environment, then the first one again.
        let surrounded = |expected: &Rgb8Image, what: &str| {
            server.tap(b'e');
            let off = || differs(&Rgb8Image::new(160, 120, server.picture(window)).unwrap(), expected);
            until(&app, what, || off() < 0.3);
        };
        assert!(differs(&studio, &later) > 5.0);
        surrounded(&studio, "the studio");
        surrounded(&later, "the sky");

        // Another technique on the right: each side equals its picture alone.
        let file = folder.path().join("normal-mip.png");
        let (left, right) = (&later, &leadr(&["--technique", "normal-mip", "--time", "5"], &file));
        server.tap(b'c');
        let sides = || {
            let shown = Rgb8Image::new(160, 120, server.picture(window)).unwrap();
            // Without the names at the top and the line in the middle.
            let part = |image: &Rgb8Image, columns: std::ops::Range<usize>| {
                let rows = image.texels.chunks(160).skip(40);
                Rgb8Image {
                    width: 60,
                    height: 80,
                    texels: rows.flat_map(|row| row[columns.clone()].to_vec()).collect(),
                }
            };
            [(left, 0..60), (right, 100..160)].map(|(image, columns)| {
                let columns = columns.clone();
                differs(&part(&shown, columns.clone()), &part(image, columns))
            })
        };
        until(&app, "two sides", || sides().iter().all(|off| *off < 0.3));
        assert!(differs(left, right) > 0.5, "the techniques do not differ: {}", differs(left, right));
        // The line follows the drag.
        let line = |column: usize| {
            let shown = server.picture(window);
            shown.chunks(160).skip(100).filter(|row| row[column].iter().all(|code| *code > 200)).count()
        };
        server.drag(window, [80, 90], [40, 90]);
        until(&app, "the line to move", || line(40) > 10 && line(80) < 5);
        server.tap(b'c');
        until(&app, "one side", || differs(&Rgb8Image::new(160, 120, server.picture(window)).unwrap(), left) < 0.3);

        // The copied command makes the displayed picture.
        server.drag(window, [80, 60], [95, 52]);
        app.wait_until_idle();
        let dragged = Rgb8Image::new(160, 120, server.picture(window)).unwrap();
        server.tap(b'x');
        let command =
            || app.written(1).lines().find_map(|line| line.split_once("leadr capture ").map(|(_, c)| c.to_owned()));
        until(&app, "a command", || command().is_some());
        let file = folder.path().join("copied.png");
        let command = command().unwrap();
        let copied = leadr(&command.split(' ').collect::<Vec<_>>(), &file);
        let off = differs(&copied, &dragged);
        assert!(off < 0.3 && differs(&copied, left) > 0.5, "{command}: {off}");
        server.tap(b'q');
        let (code, out, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
        assert!(out.contains("\"command\": \"demo\""), "{out}");
    }

    /// Size, panel and sections are restored; an invalid layout file is reported and the window opens as usual.
    fn the_window_opens_as_it_was_left(server: &Server) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("leadr/window.json");
        let start = |flags: &[&str]| {
            let scene = ["--scene", "sphere", "--atlas-tile", "8", "--samples", "1", "--validation"];
            let mut app = App::demo_in(server, &[&scene, flags].concat(), folder.path());
            app.find_window(server, "sphere");
            app
        };
        let size = |app: &App| server.size(app.window());
        let app = start(&["--size", "420x240", "--panel", "off"]);
        assert_eq!(size(&app), (420, 240));
        server.focus(app.window());
        server.tap(b' ');
        server.resize(app.window(), 440, 300);
        app.wait_until_idle();
        let without = server.picture(app.window());
        server.tap(0xff09u32);
        until(&app, "the panel", || server.picture(app.window()) != without);
        server.close(app.window());
        assert_eq!(app.end().0, Some(0));
        let kept = std::fs::read_to_string(&file).unwrap();
        let kept: serde_json::Value = serde_json::from_str(&kept).unwrap();
        assert_eq!((&kept["size"], &kept["panel"]), (&serde_json::json!([440, 300]), &true.into()), "{kept}");

        // A window this narrow would start without the panel, which is almost black on the left.
        let app = start(&[]);
        let dark = |app: &App| {
            let picture = server.picture(app.window());
            let left: Vec<_> = picture.chunks(440).flat_map(|row| &row[..240]).collect();
            left.iter().filter(|texel| texel.iter().all(|code| *code < 90)).count() * 10 > left.len() * 6
        };
        assert_eq!(size(&app), (440, 300));
        until(&app, "the panel of last time", || dark(&app));
        server.close(app.window());
        assert_eq!(app.end().0, Some(0));

        std::fs::write(&file, "{\"size\": [1, 2]}\n").unwrap();
        let app = start(&["--size", "200x150"]);
        server.close(app.window());
        let (code, _, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
        assert_eq!(err.matches("window.json").count(), 1, "{err}");
        // A fresh layout ignores the file; a run with a frame count does not write it.
        std::fs::write(&file, "nothing").unwrap();
        let app = start(&["--size", "200x150", "--fresh-layout"]);
        server.close(app.window());
        let (code, _, err) = app.end();
        assert!(code == Some(0) && !err.contains("window.json"), "{err}");
        assert!(std::fs::read_to_string(&file).unwrap().contains("200"));
        std::fs::remove_file(&file).unwrap();
        let app = App::demo_in(server, &["--scene", "sphere", "--size", "64x64", "--frames", "2"], folder.path());
        assert_eq!(app.end().0, Some(0));
        assert!(!file.exists());
    }

    /// Resizes as fast as the server allows, with occasional minimising. Afterwards the window shows its scene at its size, validation is
    /// silent, and later storms take no more memory than earlier ones.
    fn a_storm_of_sizes_leaves_nothing_behind(server: &Server) {
        assert!(is_steady(&[274, 290, 295, 295, 295, 295, 295, 295, 295, 295, 296]));
        assert!(!is_steady(&[295, 295, 295, 295, 295, 295, 295, 295, 357]));
        assert!(!is_steady(&(290..400).collect::<Vec<_>>()));
        let sizes = std::env::var("LEADR_WINDOW_SIZES").map_or(40, |sizes| sizes.parse().expect("a number of sizes"));
        storms(server, sizes, true, |_| true);
        // The validation layers keep data of every past swapchain, so memory is checked without them.
        let after = storms(server, sizes / 2, false, |after| is_steady(after) || after.len() == 80);
        println!("MiB after each storm of {} sizes: {after:?}", sizes / 2);
        assert!(is_steady(&after), "{after:?} MiB");
    }

    /// Whether the last eight storms took no further memory. The peak rises now and then, when a storm happens to draw more sizes at once
    /// than any before, and at last stays; a leak grows with every storm.
    fn is_steady(after: &[u64]) -> bool {
        after.len() > 8 && after[after.len() - 1] <= after[after.len() - 9] + 2
    }

    /// Repeats a storm until there are enough; returns the resident memory after each, in MiB.
    fn storms(server: &Server, sizes: u32, validation: bool, enough: impl Fn(&[u64]) -> bool) -> Vec<u64> {
        let mut arguments = vec!["--width", "320", "--height", "240", "--samples", "1"];
        arguments.extend(validation.then_some("--validation"));
        let mut app = App::start(server, &arguments);
        app.find_window(server, "Orbit");
        let window = app.window();
        let mut after = Vec::new();
        while after.is_empty() || !enough(&after) {
            for i in 0..sizes {
                server.resize(window, 1 + i * 379 % 700, 1 + i * 251 % 500);
                if i % 10 == 7 {
                    server.minimise(window);
                    server.restore(window);
                }
                // Every third size is drawn if the machine is not busy; the others are superseded.
                if i % 3 == 0 {
                    std::thread::sleep(std::time::Duration::from_millis(60));
                }
                assert!(app.is_running(), "the program ended at size {i}");
            }
            server.resize(window, 320, 240);
            let before = server.title(window);
            until(&app, "frames after the storm", || server.title(window) != before);
            let middle = || server.picture(window)[320 * 120 + 160];
            until(&app, "the scene", || server.size(window) == (320, 240) && middle() != [0; 3]);
            after.push(app.resident());
        }
        server.close(window);
        let (code, _, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
        after
    }

    /// Another client destroys the window: the program ends with its results or with an error about the window, and never panics.
    fn a_window_that_another_program_closes_ends_the_program(server: &Server) {
        let mut app = App::start(server, &["--width", "200", "--height", "150", "--validation"]);
        app.find_window(server, "Orbit");
        server.uncover(app.window());
        let (code, out, err) = app.end();
        let reported = code == Some(0) && out.contains("\"frames\"");
        // A frame was in flight.
        let gone = code == Some(1) && err.trim().lines().count() == 1 && err.contains("window");
        assert!(reported || gone, "{code:?} {out} {err}");
    }

    /// Clicks everything in the panel, scrolls it and clicks again. Nothing may fail, and validation is silent.
    fn every_control_can_be_clicked(server: &Server) {
        let arguments =
            ["--scene", "sphere", "--atlas-tile", "8", "--size", "620x500", "--panel", "on", "--validation"];
        let folder = tempfile::tempdir().unwrap();
        let mut app = App::demo_in(server, &arguments, folder.path());
        app.find_window(server, "sphere");
        let window = app.window();
        server.focus(window);
        let before = server.picture(window);
        for round in 0..2 {
            for (x, y) in (0..26).flat_map(|row| [(24, 10 + 19 * row), (100, 14 + 19 * row), (190, 18 + 19 * row)]) {
                server.click(window, [x, y]);
                assert!(app.is_running(), "the program ended at a click on ({x}, {y}) in round {round}");
            }
            server.wheel(window, [100, 400], -30);
        }
        // Tab hides it in every state, and F1 shows the keys.
        server.tap(b'r');
        let shown = || server.picture(window);
        until(&app, "frames after the clicks", || shown() != before);
        let with_panel = shown();
        server.tap(0xff09u32);
        until(&app, "the panel to close", || shown() != with_panel);
        let without = shown();
        server.tap(0xffbeu32);
        until(&app, "the help", || shown() != without);
        println!("after the clicks: {}", server.title(window));
        server.resize(window, 480, 400);
        app.wait_until_idle();
        println!("at rest: {}", server.title(window));
        server.close(window);
        let (code, _, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
    }

    /// The sphere and a model take a measured material; an unsuitable one changes nothing.
    /// On a CPU the first picture has coarse maps; the next equals that of the copied command, with full-resolution maps.
    fn after_a_coarse_first_picture_comes_all_detail(server: &Server) {
        let folder = tempfile::tempdir().unwrap();
        let arguments =
            ["--scene", "sphere", "--size", "320x240", "--camera", "near", "--samples", "1", "--panel", "off"];
        let mut app = App::demo(server, &arguments);
        app.find_window(server, "sphere");
        let window = app.window();
        server.focus(window);
        app.wait_until_idle();
        let shown = server.picture(window);
        server.tap(b'x');
        let command = || app.written(1).lines().find_map(|line| Some(line.split_once("leadr capture ")?.1.to_owned()));
        until(&app, "a command", || command().is_some());
        let written = command().unwrap();
        let without_target = written.split(" -o ").next().unwrap();
        let made = |tile: &str| {
            let file = folder.path().join(tile).with_extension("png");
            let mut capture = Command::new(env!("CARGO_BIN_EXE_leadr"));
            capture
                .arg("capture")
                .args(without_target.split_whitespace())
                .args(["--atlas-tile", tile])
                .arg("-o")
                .arg(&file);
            let output = capture.output().unwrap();
            assert!(output.status.success(), "{written}: {}", String::from_utf8_lossy(&output.stderr));
            load_color_srgb8(&file).unwrap()
        };
        let apart = |made: &Rgb8Image| {
            let pairs = shown.iter().zip(&made.texels);
            pairs.map(|(a, b)| f64::from(a[1].abs_diff(b[1]))).sum::<f64>() / shown.len() as f64
        };
        let [coarse, fine] = ["8", "64"].map(|tile| apart(&made(tile)));
        println!("from the picture with tiles of 8: {coarse:.3} codes, of 64: {fine:.3}");
        assert!(fine < 0.1 && coarse > 10.0 * fine, "{coarse} {fine}");
        server.tap(b'q');
        let (code, _, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
    }

    fn dropped_files_are_applied(server: &Server) {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        // A Beckmann lobe of alpha .1 over a red diffuse base.
        let backscattering = |degrees: u32| {
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let lobe = (-(sine / cosine).powi(2) / 0.01).exp() / (4.0 * std::f64::consts::PI * 0.01 * cosine.powi(5));
            format!("{degrees},{},{},{}\n", lobe + 0.25, lobe + 0.01, lobe + 0.01)
        };
        let table: String = (0..80).map(backscattering).collect();
        std::fs::write(file("red.csv"), format!("theta,r,g,b\n{table}")).unwrap();
        let fitted = Command::new(env!("CARGO_BIN_EXE_leadr"))
            .arg("fit")
            .args([file("red.csv"), "-o".into(), file("red.json")])
            .output()
            .unwrap();
        assert!(fitted.status.success(), "{}", String::from_utf8_lossy(&fitted.stderr));
        std::fs::write(file("none.json"), "{}").unwrap();

        let arguments = ["--scene", "sphere", "--size", "320x240", "--samples", "1", "--panel", "off", "--validation"];
        let mut app = App::demo(server, &arguments);
        app.find_window(server, "sphere");
        let window = app.window();
        server.focus(window);
        let is_red = |[r, g, _]: &&[u8; 3]| 2 * u32::from(*r) > 3 * u32::from(*g);
        let redness = |picture: &[[u8; 3]]| picture.iter().filter(is_red).count();
        let own = server.picture(window);
        server.drop_file(window, &file("none.json"));
        until(&app, "a complaint", || app.written(1).contains("none.json"));
        server.drop_file(window, &file("red.json"));
        until(&app, "a red sphere", || redness(&server.picture(window)) > redness(&own) + 1000);
        let command = || {
            app.written(1)
                .lines()
                .filter_map(|line| line.split_once("leadr capture "))
                .next_back()
                .map(|(_, c)| c.to_owned())
        };
        server.tap(b'x');
        until(&app, "a command", || command().is_some());
        let written = command().unwrap();
        assert!(
            written.contains("--material") && written.contains("red.json") && !written.contains("none.json"),
            "{written}"
        );

        // A model keeps its own material until the measured one is dropped on it.
        let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/snail.glb");
        let sphere = server.picture(window);
        server.drop_file(window, &model);
        // The message about loading hides a part of the sphere.
        until(&app, "the model", || 3 * redness(&server.picture(window)) < redness(&sphere));
        let model = server.picture(window);
        server.drop_file(window, &file("red.json"));
        until(&app, "a red model", || redness(&server.picture(window)) > redness(&model) + 300);
        server.tap(b'x');
        until(&app, "another command", || command().is_some_and(|now| now != written));
        let written = command().unwrap();
        assert!(
            written.contains("--measured") && written.contains("*=") && !written.contains("--material"),
            "{written}"
        );
        server.tap(b'q');
        let (code, _, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
    }

    /// A saved screenshot must equal the content of the window in every sRGB code.
    fn screenshot(server: &Server, app: &App, folder: &Path, number: u32, size: (u32, u32)) -> Rgb8Image {
        let shown = server.picture(app.window());
        server.tap(b's');
        let path = folder.join(format!("shot-{number}.png"));
        until(app, "a screenshot", || path.exists());
        let saved = load_color_srgb8(&path).unwrap();
        assert_eq!((saved.width, saved.height), size);
        until(app, "a message", || server.picture(app.window()) != shown);
        until(app, "the message to go", || server.picture(app.window()) == shown);
        assert_eq!(shown.len(), saved.texels.len());
        let worst = shown.iter().zip(&saved.texels).flat_map(|(a, b)| [0, 1, 2].map(|c| a[c].abs_diff(b[c]))).max();
        // The CPU and the device may round half a code differently.
        assert!(worst <= Some(1), "the window and its screenshot differ by {worst:?} codes");
        saved
    }

    /// Mean difference of neighbouring pixels in a block of 32², in codes: large on the bumpy sphere, zero in the sky.
    fn detail(image: &Rgb8Image, left: u32, top: u32) -> f64 {
        let at = |x: u32, y: u32| i32::from(image.texels[(y * image.width + x) as usize][1]);
        let block = (0..32).flat_map(|y| (0..32).map(move |x| (left + x, top + y)));
        block.map(|(x, y)| f64::from((at(x + 1, y) - at(x, y)).abs())).sum::<f64>() / 1024.0
    }

    fn differs(a: &Rgb8Image, b: &Rgb8Image) -> f64 {
        let pairs = a.texels.iter().zip(&b.texels);
        pairs.map(|(a, b)| f64::from(a[1].abs_diff(b[1]))).sum::<f64>() / a.texels.len() as f64
    }

    fn a_user_looks_around(server: &Server) {
        let folder = tempfile::tempdir().unwrap();
        let shots = folder.path().join("shot");
        let shots = shots.to_str().unwrap();
        let arguments = ["--width", "320", "--height", "240", "--samples", "4", "--validation", "--screenshots", shots];
        let mut app = App::start(server, &arguments);
        app.find_window(server, "Orbit");
        let window = app.window();
        server.focus(window);
        let title = || server.title(window);
        until(&app, "a title with the frame rate", || title().contains("leadr") && title().contains("fps"));

        // Keys that change the technique and stop time.
        server.tap(b'2');
        until(&app, "mipmapped normals", || title().contains("normal-mip"));
        server.tap(b'1');
        until(&app, "LEADR", || title().contains("· leadr ·"));
        let before = title();
        until(&app, "time to run", || title() != before);
        assert!(app.cpu_share() > 0.1, "a running animation works");
        server.tap(b' ');
        until(&app, "time to stop", || title().contains("(paused)"));
        app.wait_until_idle();

        // Resizing the window while nothing moves.
        server.resize(window, 480, 300);
        app.wait_until_idle();
        let first = screenshot(server, &app, folder.path(), 1, (480, 300));
        let (middle, corner) = (detail(&first, 224, 134), detail(&first, 8, 8));
        assert!(middle > 4.0 * corner + 1.0, "detail {middle} in the middle, {corner} in a corner");
        if let Some(keep) = std::env::var_os("LEADR_KEEP_SCREENSHOT") {
            std::fs::copy(folder.path().join("shot-1.png"), keep).unwrap();
        }

        // A drag rotates the camera, the wheel moves it closer.
        server.drag(window, [240, 150], [330, 150]);
        app.wait_until_idle();
        let rotated = screenshot(server, &app, folder.path(), 2, (480, 300));
        assert!(differs(&first, &rotated) > 1.0, "a drag changes the picture by {}", differs(&first, &rotated));
        server.tap(b'r');
        server.tap(b' ');
        until(&app, "time to stop again", || title().contains("(paused)"));
        server.wheel(window, [100, 100], 5);
        app.wait_until_idle();
        let closer = screenshot(server, &app, folder.path(), 3, (480, 300));
        // The sphere now covers former sky.
        let (before, after) = (detail(&first, 90, 134), detail(&closer, 90, 134));
        assert!(after > before + 1.0, "detail at the rim {before}, {after} from closer");

        // Covered and minimised windows draw nothing, and draw again when restored.
        server.tap(b' ');
        until(&app, "time to run again", || !title().contains("(paused)"));
        let cover = server.cover();
        app.wait_until_idle();
        let covered = title();
        server.uncover(cover);
        until(&app, "frames after being covered", || title() != covered);
        assert!(app.cpu_share() > 0.1, "it draws again");
        server.minimise(window);
        app.wait_until_idle();
        let minimised = title();
        server.restore(window);
        until(&app, "frames after being minimised", || title() != minimised);

        // Resizing while the animation runs, down to one pixel.
        for (width, height) in [(200, 100), (1, 1), (97, 311), (320, 240)] {
            server.resize(window, width, height);
            let before = title();
            until(&app, "frames of another size", || title() != before);
        }
        server.close(window);
        let (code, out, err) = app.end();
        assert_eq!(code, Some(0), "{err}");
        assert!(out.contains("shot-3.png"), "{out}");
    }
}
