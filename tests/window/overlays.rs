//! What lies over the picture: panel, help, messages and the dialog; and scenes that load while the picture moves on.

use std::path::{Path, PathBuf};

use super::server::{App, Server, until};

const TAB: u32 = 0xff09;
const ESCAPE: u32 = 0xff1b;
const F1: u32 = 0xffbe;

/// A picture of the window.
struct Picture {
    width: usize,
    texels: Vec<[u8; 3]>,
}

impl Picture {
    fn of(server: &Server, app: &App) -> Self {
        let (width, _) = server.size(app.window());
        Self { width: width.into(), texels: server.picture(app.window()) }
    }

    fn height(&self) -> usize {
        self.texels.len() / self.width
    }

    /// The bounds of all pixels that differ visibly: left, top, right, bottom; `None` if there are none.
    fn changed(&self, other: &Self) -> Option<[usize; 4]> {
        let pairs = self.texels.iter().zip(&other.texels).enumerate();
        let apart = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 8);
        let at = pairs.filter(|(_, pair)| apart(*pair)).map(|(i, _)| (i % self.width, i / self.width));
        at.fold(None, |bounds, (x, y)| {
            let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
            Some([left.min(x), top.min(y), right.max(x), bottom.max(y)])
        })
    }

    /// Mean difference from another picture that is `shift` pixels to the left, in codes, from column `left` on.
    fn apart(&self, other: &Self, left: usize, shift: usize) -> f64 {
        let rows = self.texels.chunks(self.width).zip(other.texels.chunks(self.width));
        let off = |(a, b): (&[[u8; 3]], &[[u8; 3]])| {
            (left..self.width).map(|x| f64::from(a[x][1].abs_diff(b[x - shift][1]))).sum::<f64>()
        };
        rows.map(off).sum::<f64>() / ((self.width - left) * self.height()) as f64
    }
}

/// A still sphere without a panel, after its first complete picture.
fn sphere(server: &Server, size: &str, folder: &Path) -> App {
    let arguments = ["--scene", "sphere", "--atlas-tile", "8", "--samples", "1", "--panel", "off", "--size", size];
    let mut app = App::demo_in(server, &[&arguments[..], &["--fresh-layout", "--validation"]].concat(), folder);
    app.find_window(server, "sphere");
    server.focus(app.window());
    app.wait_until_idle();
    app
}

/// Presses a key and waits until the picture differs from `before`.
fn press(server: &Server, app: &App, key: u32, before: &Picture, what: &str) -> Picture {
    server.tap(key);
    until(app, what, || Picture::of(server, app).changed(before).is_some());
    app.wait_until_idle();
    Picture::of(server, app)
}

fn until_equal(server: &Server, app: &App, expected: &Picture, what: &str) {
    until(app, what, || Picture::of(server, app).changed(expected).is_none());
}

fn inside([left, top, right, bottom]: [usize; 4], picture: &Picture) -> bool {
    left >= 4 && top >= 4 && right + 4 < picture.width && bottom + 4 < picture.height()
}

/// At every size, help and messages fit into the window, and Esc closes what is open before it quits.
pub fn overlays_fit_and_escape_closes_them(server: &Server) {
    let folder = tempfile::tempdir().unwrap();
    let app = sphere(server, "320x240", folder.path());
    assert!(server.title(app.window()).starts_with("sphere · leadr"), "{}", server.title(app.window()));
    assert!(!server.title(app.window()).contains("ms"), "{}", server.title(app.window()));
    for (width, height) in [(320, 240), (640, 300), (800, 600), (320, 240)] {
        server.resize(app.window(), width, height);
        until(&app, "the new size", || server.size(app.window()) == (width as u16, height as u16));
        app.wait_until_idle();
        let without = Picture::of(server, &app);
        press(server, &app, F1, &without, "the help");
        // It opens at the line where it was closed.
        let middle = [(width / 2) as i16, (height / 2) as i16];
        server.wheel(app.window(), middle, 60);
        app.wait_until_idle();
        let help = Picture::of(server, &app);
        let bounds = without.changed(&help).unwrap();
        assert!(inside(bounds, &without), "help in {width} x {height}: {bounds:?}");
        let [left, top, right, bottom] = bounds;
        let (wide, high) = (right - left, bottom - top);
        assert!(wide + 40 > without.width.min(560) && high + 40 > without.height().min(500), "{bounds:?}");
        // It scrolls to its end and no further.
        server.wheel(app.window(), middle, -40);
        until(&app, "the end of the help", || Picture::of(server, &app).changed(&help).is_some());
        app.wait_until_idle();
        let end = Picture::of(server, &app);
        server.wheel(app.window(), middle, -10);
        app.wait_until_idle();
        assert_eq!(Picture::of(server, &app).changed(&end), None, "beyond the end");
        server.tap(ESCAPE);
        until_equal(server, &app, &without, "the help to close");

        server.tap(b'x');
        let mut bounds = None;
        until(&app, "a message", || {
            bounds = Picture::of(server, &app).changed(&without);
            bounds.is_some()
        });
        let bounds = bounds.unwrap();
        assert!(inside(bounds, &without), "message in {width} x {height}: {bounds:?}");
        assert!(width > 320 || bounds[3] - bounds[1] > 60, "the command takes several lines: {bounds:?}");
        server.tap(ESCAPE);
        until_equal(server, &app, &without, "the message to close");
    }
    let without = Picture::of(server, &app);
    // A list in the panel, and the dialog. The pointer rests beside the panel, where it highlights no control.
    server.wheel(app.window(), [300, 230], 0);
    let panel = press(server, &app, TAB, &without, "the panel");
    server.click(app.window(), [150, 17]);
    until(&app, "a list", || Picture::of(server, &app).changed(&panel).is_some_and(|bounds| bounds[3] > 60));
    app.wait_until_idle();
    server.tap(ESCAPE);
    server.wheel(app.window(), [300, 230], 0);
    until(&app, "the list to close", || Picture::of(server, &app).changed(&panel).is_none_or(|bounds| bounds[3] < 60));
    server.tap(TAB);
    until_equal(server, &app, &without, "the panel to close");
    server.tap(b'l');
    until(&app, "the dialog", || Picture::of(server, &app).changed(&without).is_some());
    server.tap(ESCAPE);
    until_equal(server, &app, &without, "the dialog to close");
    server.tap(ESCAPE);
    let (code, _, err) = app.end();
    assert_eq!(code, Some(0), "{err}");
}

/// The panel moves the picture to the middle of the free part and changes nothing else. Screenshots show the whole picture.
pub fn the_panel_moves_the_picture(server: &Server) {
    let folder = tempfile::tempdir().unwrap();
    let app = sphere(server, "620x200", folder.path());
    let without = Picture::of(server, &app);
    let with = press(server, &app, TAB, &without, "the panel");
    let (moved, unmoved) = (with.apart(&without, 254, 126), with.apart(&without, 254, 0));
    println!(
        "beside the panel, the picture differs by {moved:.3} codes from the moved one, {unmoved:.2} from the other"
    );
    assert!(moved < 0.3 && unmoved > 10.0 * moved + 1.0, "{moved} {unmoved}");
    server.tap(b's');
    let path = folder.path().join("out/screenshot-1.png");
    until(&app, "a screenshot", || path.exists());
    app.wait_until_idle();
    let saved = leadr::maps::load_color_srgb8(&path).unwrap();
    let saved = Picture { width: saved.width as usize, texels: saved.texels };
    let off = saved.apart(&without, 0, 0);
    assert!(off < 0.3, "the screenshot differs by {off} codes");
    server.tap(ESCAPE);
    server.tap(b'q');
    assert_eq!(app.end().0, Some(0));
}

/// A run of N frames draws N frames although nothing moves.
pub fn a_limited_run_of_a_still_scene_ends(server: &Server) {
    let arguments = ["--scene", "sphere", "--atlas-tile", "8", "--size", "64x48", "--samples", "1", "--frames", "30"];
    let app = App::demo(server, &[&arguments[..], &["--json"]].concat());
    let (code, out, err) = app.end();
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("\"frames\": 30"), "{out}");
}

/// A model with a second animation.
fn two_animations(folder: &Path) -> PathBuf {
    let model = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/snail.glb")).unwrap();
    let length = u32::from_le_bytes(model[12..16].try_into().unwrap()) as usize;
    let (json, rest) = (&model[20..20 + length], &model[20 + length..]);
    let mut json: serde_json::Value = serde_json::from_slice(json).unwrap();
    let animations = json["animations"].as_array_mut().unwrap();
    let mut second = animations[0].clone();
    second["name"] = "Turn".into();
    animations.push(second);
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |number: usize| (number as u32).to_le_bytes();
    let whole = word(20 + json.len() + rest.len());
    let path = folder.join("turning.glb");
    let parts = [&model[..8], &whole, &word(json.len()), &model[16..20], &json, rest];
    std::fs::write(&path, parts.concat()).unwrap();
    path
}

/// Models are opened and their animations chosen. Damaged files leave the scene as it is, and are named with their fault.
pub fn files_are_opened_and_animations_chosen(server: &Server) {
    let folder = tempfile::tempdir().unwrap();
    let model = two_animations(folder.path());
    for bad in ["bad.glb", "bad.hdr", "bad.json", "notes.txt"] {
        std::fs::write(folder.path().join(bad), "nothing").unwrap();
    }
    let arguments = ["--scene", "sphere", "--atlas-tile", "8", "--samples", "1", "--size", "700x300", "--panel", "on"];
    let mut app = App::demo(server, &arguments);
    app.find_window(server, "sphere");
    let window = app.window();
    server.focus(window);
    app.wait_until_idle();
    let before = Picture::of(server, &app);
    for bad in ["bad.glb", "bad.hdr", "bad.json", "notes.txt"] {
        server.drop_file(window, &folder.path().join(bad));
        until(&app, bad, || app.written(1).lines().any(|line| line.contains("ERROR") && line.contains(bad)));
    }
    // Only the message was drawn over the old scene.
    until_equal(server, &app, &before, "the old scene");
    assert!(server.title(window).starts_with("sphere ·"));
    // `e` announces the environment that it loads.
    server.tap(b'e');
    until(&app, "an announcement", || app.written(1).contains("loading the studio ..."));
    until(&app, "the studio", || Picture::of(server, &app).apart(&before, 260, 0) > 5.0);

    server.drop_file(window, &model);
    until(&app, "the model", || server.title(window).starts_with("turning.glb ·"));
    let command = || {
        let log = app.written(1);
        log.lines().filter_map(|line| line.split_once("leadr capture ")).next_back().map(|(_, c)| c.to_owned())
    };
    // The second line of the panel is the list of animations, and its second entry is the second animation.
    server.click(window, [150, 38]);
    std::thread::sleep(std::time::Duration::from_secs(2));
    server.click(window, [120, 83]);
    until(&app, "another animation", || app.written(1).contains("loading the scene with another animation ..."));
    until(&app, "a command with the animation", || {
        server.tap(b'x');
        std::thread::sleep(std::time::Duration::from_secs(1));
        command().is_some_and(|command| command.contains("--animation Turn"))
    });
    server.close(window);
    let (code, _, err) = app.end();
    assert_eq!(code, Some(0), "{err}");
}

/// Without its display or its device, the program ends with a sentence.
pub fn a_lost_display_or_device_is_a_sentence(_: &Server) {
    for still in [true, false] {
        let own = Server::start().unwrap();
        let mut app = App::start(&own, &["--width", "96", "--height", "64", "--samples", "1"]);
        app.find_window(&own, "Orbit");
        if still {
            own.focus(app.window());
            own.tap(b' ');
            app.wait_until_idle();
        }
        drop(own);
        let (code, _, err) = app.end();
        assert_eq!(code, Some(1), "{err}");
        // Xlib ends the process with its own sentence if it notices first.
        let said = ["the connection to the display was lost", "surface was lost", "X connection to"];
        assert!(err.trim().lines().count() == 1 && said.iter().any(|text| err.contains(text)), "{err}");
    }
    let own = Server::start().unwrap();
    let app =
        App::start_with(&own, &["--width", "96", "--height", "64", "--frames", "40"], ("LEADR_FAIL", "submission:60"));
    let (code, _, err) = app.end();
    assert_eq!(code, Some(1), "{err}");
    assert!(err.trim().lines().count() == 1 && err.contains("the device was lost"), "{err}");
}
