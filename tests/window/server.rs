//! A private X server, simulated keyboard and mouse, and the program under test.

use std::cell::Cell;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    self, AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, CreateWindowAux, EventMask,
    ImageFormat, InputFocus, PropMode, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Time limit of an action, sufficient on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);

/// Sleeps until a condition holds.
pub fn until(app: &App, what: &str, mut happened: impl FnMut() -> bool) {
    let start = Instant::now();
    while !happened() {
        assert!(app.is_running(), "the program ended before {what}");
        assert!(start.elapsed() < PATIENCE, "waited {PATIENCE:?} for {what}");
        std::thread::sleep(Duration::from_millis(40));
    }
}

/// An Xvfb on a free display, ended when dropped.
pub struct Server {
    process: Child,
    display: String,
    connection: RustConnection,
    root: Window,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Server {
    pub fn start() -> Result<Self, String> {
        let mut process = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| format!("Xvfb cannot be started ({e}): install xvfb"))?;
        let mut number = String::new();
        let read = process.stdout.as_mut().map(|out| BufReader::new(out).read_line(&mut number));
        let display = format!(":{}", number.trim());
        let connected = match read {
            Some(Ok(length)) if length > 0 => RustConnection::connect(Some(&display)).map_err(|e| e.to_string()),
            _ => Err("it names no display".to_owned()),
        };
        match connected {
            Ok((connection, screen)) => {
                let root = connection.setup().roots[screen].root;
                Ok(Self { process, display, connection, root })
            }
            Err(reason) => {
                let _ = process.kill();
                let _ = process.wait();
                Err(format!("Xvfb does not work: {reason}"))
            }
        }
    }

    fn atom(&self, name: &str) -> xproto::Atom {
        self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    pub fn title(&self, window: Window) -> String {
        let (name, utf8) = (self.atom("_NET_WM_NAME"), self.atom("UTF8_STRING"));
        let property = self.connection.get_property(false, window, name, utf8, 0, 1024).unwrap().reply();
        property.map(|p| String::from_utf8_lossy(&p.value).into_owned()).unwrap_or_default()
    }

    pub fn focus(&self, window: Window) {
        self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap().check().unwrap();
        self.point(window, [5, 5]);
    }

    /// Presses and releases an unshifted key: that of a character, or another X11 keysym.
    pub fn tap(&self, symbol: impl Into<u32>) {
        let symbol = symbol.into();
        let setup = self.connection.setup();
        let (first, count) = (setup.min_keycode, setup.max_keycode - setup.min_keycode + 1);
        let mapping = self.connection.get_keyboard_mapping(first, count).unwrap().reply().unwrap();
        let columns = usize::from(mapping.keysyms_per_keycode);
        let row = mapping.keysyms.chunks(columns).position(|row| row[0] == symbol).expect("a key");
        for event in [xproto::KEY_PRESS_EVENT, xproto::KEY_RELEASE_EVENT] {
            self.fake(event, first + row as u8, [0, 0]);
        }
    }

    fn fake(&self, event: u8, detail: u8, [x, y]: [i16; 2]) {
        self.connection.xtest_fake_input(event, detail, 0, self.root, x, y, 0).unwrap().check().unwrap();
    }

    fn point(&self, window: Window, at: [i16; 2]) {
        let origin = self.connection.translate_coordinates(window, self.root, 0, 0).unwrap().reply().unwrap();
        self.fake(xproto::MOTION_NOTIFY_EVENT, 0, [origin.dst_x + at[0], origin.dst_y + at[1]]);
        // The program receives a pointer jump as one motion event; it must arrive before the next event.
        std::thread::sleep(Duration::from_millis(200));
    }

    pub fn drag(&self, window: Window, from: [i16; 2], to: [i16; 2]) {
        self.point(window, from);
        self.fake(xproto::BUTTON_PRESS_EVENT, 1, [0, 0]);
        self.point(window, to);
        self.fake(xproto::BUTTON_RELEASE_EVENT, 1, [0, 0]);
    }

    pub fn click(&self, window: Window, at: [i16; 2]) {
        self.point(window, at);
        self.fake(xproto::BUTTON_PRESS_EVENT, 1, [0, 0]);
        self.fake(xproto::BUTTON_RELEASE_EVENT, 1, [0, 0]);
    }

    /// Turns the wheel at a point of the window, forward or back.
    pub fn wheel(&self, window: Window, at: [i16; 2], notches: i32) {
        self.point(window, at);
        for _ in 0..notches.abs() {
            let button = if notches > 0 { 4 } else { 5 };
            self.fake(xproto::BUTTON_PRESS_EVENT, button, [0, 0]);
            self.fake(xproto::BUTTON_RELEASE_EVENT, button, [0, 0]);
        }
    }

    pub fn resize(&self, window: Window, width: u32, height: u32) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).unwrap().check().unwrap();
    }

    pub fn size(&self, window: Window) -> (u16, u16) {
        let size = self.connection.get_geometry(window).unwrap().reply().unwrap();
        (size.width, size.height)
    }

    /// The content of the window, in sRGB codes.
    pub fn picture(&self, window: Window) -> Vec<[u8; 3]> {
        let size = self.connection.get_geometry(window).unwrap().reply().unwrap();
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, size.width, size.height, !0);
        let image = image.unwrap().reply().unwrap();
        assert_eq!(image.data.len(), usize::from(size.width) * usize::from(size.height) * 4);
        image.data.chunks(4).map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect()
    }

    /// Covers the whole screen with a black window.
    pub fn cover(&self) -> Window {
        let cover = self.connection.generate_id().unwrap();
        let look = CreateWindowAux::new().override_redirect(1).background_pixel(0);
        let class = WindowClass::INPUT_OUTPUT;
        let made = self.connection.create_window(0, cover, self.root, 0, 0, 800, 600, 0, class, 0, &look);
        made.unwrap().check().unwrap();
        self.connection.map_window(cover).unwrap().check().unwrap();
        cover
    }

    pub fn uncover(&self, cover: Window) {
        self.connection.destroy_window(cover).unwrap().check().unwrap();
    }

    /// Minimises the window as a window manager does.
    pub fn minimise(&self, window: Window) {
        let (state, hidden) = (self.atom("_NET_WM_STATE"), self.atom("_NET_WM_STATE_HIDDEN"));
        let set = self.connection.change_property32(PropMode::REPLACE, window, state, AtomEnum::ATOM, &[hidden]);
        set.unwrap().check().unwrap();
        self.connection.unmap_window(window).unwrap().check().unwrap();
    }

    pub fn restore(&self, window: Window) {
        let state = self.atom("_NET_WM_STATE");
        self.connection.delete_property(window, state).unwrap().check().unwrap();
        self.connection.map_window(window).unwrap().check().unwrap();
    }

    /// Closes the window as a window manager's close button does.
    pub fn close(&self, window: Window) {
        let (protocols, delete) = (self.atom("WM_PROTOCOLS"), self.atom("WM_DELETE_WINDOW"));
        let event = ClientMessageEvent::new(32, window, protocols, [delete, x11rb::CURRENT_TIME, 0, 0, 0]);
        self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap().check().unwrap();
    }

    /// Drops a file on the window, as file managers do (XDND version 5).
    pub fn drop_file(&self, window: Window, file: &Path) {
        let connection = &self.connection;
        let source = connection.generate_id().unwrap();
        let (class, look) = (WindowClass::INPUT_OUTPUT, CreateWindowAux::new());
        connection.create_window(0, source, self.root, 0, 0, 1, 1, 0, class, 0, &look).unwrap().check().unwrap();
        let (selection, uris) = (self.atom("XdndSelection"), self.atom("text/uri-list"));
        connection.set_selection_owner(source, selection, x11rb::CURRENT_TIME).unwrap().check().unwrap();
        let say = |name: &str, data: [u32; 4]| {
            let [a, b, c, d] = data;
            let event = ClientMessageEvent::new(32, window, self.atom(name), [source, a, b, c, d]);
            connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap().check().unwrap();
        };
        say("XdndEnter", [5 << 24, uris, 0, 0]);
        say("XdndPosition", [0, 0, x11rb::CURRENT_TIME, self.atom("XdndActionCopy")]);
        // The window requests the file name.
        let start = Instant::now();
        let requested = loop {
            match connection.poll_for_event().unwrap() {
                Some(Event::SelectionRequest(requested)) => break requested,
                _ => std::thread::sleep(Duration::from_millis(10)),
            }
            assert!(start.elapsed() < PATIENCE, "the window does not ask for what is dropped");
        };
        let text = format!("file://{}\r\n", file.display());
        let changed = connection.change_property8(
            PropMode::REPLACE,
            requested.requestor,
            requested.property,
            uris,
            text.as_bytes(),
        );
        changed.unwrap().check().unwrap();
        let answer = SelectionNotifyEvent {
            response_type: xproto::SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time: requested.time,
            requestor: requested.requestor,
            selection: requested.selection,
            target: requested.target,
            property: requested.property,
        };
        connection.send_event(false, requested.requestor, EventMask::NO_EVENT, answer).unwrap().check().unwrap();
        std::thread::sleep(Duration::from_millis(200));
        say("XdndDrop", [0, x11rb::CURRENT_TIME, 0, 0]);
    }

    /// The top-level window whose title contains this text.
    fn find(&self, title: &str) -> Option<Window> {
        let windows = self.connection.query_tree(self.root).unwrap().reply().unwrap().children;
        windows.into_iter().find(|&window| self.title(window).starts_with(title))
    }
}

/// The program under test, ended when dropped.
pub struct App {
    process: Cell<Option<Child>>,
    id: u32,
    window: Window,
    /// Written to files, because pipes can fill up and block.
    written: [File; 2],
}

impl Drop for App {
    fn drop(&mut self) {
        if let Some(mut process) = self.process.take() {
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

impl App {
    pub fn command(arguments: &[&str]) -> Command {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(arguments).env("LEADR_WINDOW_CHILD", "1");
        // With one arena the C library reuses memory freed by any thread, so resident memory grows only by leaks.
        command.env("MALLOC_ARENA_MAX", "1");
        command
    }

    /// Starts `leadr demo` with the T-rex from the cache shared by all tests.
    pub fn demo(server: &Server, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
        command
            .arg("demo")
            .args(arguments)
            // Tests ignore the user's saved layout.
            .arg("--fresh-layout")
            .env("XDG_CONFIG_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/config"))
            .env("LEADR_LOG", "info")
            .env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
        Self::spawn(server, command)
    }

    /// The same in a folder for output files.
    pub fn demo_in(server: &Server, arguments: &[&str], folder: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
        command.arg("demo").args(arguments).current_dir(folder).env("XDG_CONFIG_HOME", folder);
        command.env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
        Self::spawn(server, command)
    }

    pub fn start(server: &Server, arguments: &[&str]) -> Self {
        Self::spawn(server, Self::command(arguments))
    }

    /// The same with a variable in its environment.
    pub fn start_with(server: &Server, arguments: &[&str], (variable, value): (&str, &str)) -> Self {
        let mut command = Self::command(arguments);
        command.env(variable, value);
        Self::spawn(server, command)
    }

    fn spawn(server: &Server, mut command: Command) -> Self {
        command.env_remove("WAYLAND_DISPLAY");
        if let Ok(device) = std::env::var("LEADR_DEVICE") {
            command.args(["--device", &device]);
        }
        let written = [tempfile::tempfile().unwrap(), tempfile::tempfile().unwrap()];
        let [out, err] = [0, 1].map(|i| Stdio::from(written[i].try_clone().unwrap()));
        command.env("DISPLAY", &server.display).stdout(out).stderr(err);
        let process = command.spawn().unwrap();
        let id = process.id();
        Self { process: Cell::new(Some(process)), id, window: 0, written }
    }

    pub fn find_window(&mut self, server: &Server, title: &str) {
        // The title has the technique from the first frame on.
        let start = format!("{title} ·");
        until(self, "a window", || server.find(&start).is_some());
        self.window = server.find(&start).unwrap();
    }

    pub fn window(&self) -> Window {
        self.window
    }

    pub fn is_running(&self) -> bool {
        let mut process = self.process.take();
        let running = process.as_mut().is_some_and(|p| matches!(p.try_wait(), Ok(None)));
        self.process.set(process);
        if !running {
            eprintln!("{}", self.written(1));
        }
        running
    }

    /// CPU use of the program over half a second, in cores.
    pub fn cpu_share(&self) -> f64 {
        let seconds = || {
            let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.id)).unwrap();
            // Fields 14 and 15, in ticks; the second field is in brackets and may hold spaces.
            let fields: Vec<&str> = stat[stat.rfind(')').unwrap() + 2..].split(' ').collect();
            let ticks: f64 = fields[11..13].iter().map(|ticks| ticks.parse::<f64>().unwrap()).sum();
            ticks / 100.0
        };
        let (start, before) = (Instant::now(), seconds());
        std::thread::sleep(Duration::from_millis(500));
        (seconds() - before) / start.elapsed().as_secs_f64()
    }

    /// Memory of the program, MiB.
    pub fn resident(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.id)).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        line.split_whitespace().next().unwrap().parse::<u64>().unwrap() / 1024
    }

    /// Waits until the program is idle: it draws nothing and uses no CPU time.
    pub fn wait_until_idle(&self) {
        let mut still = 0;
        until(self, "the program to rest", || {
            still = if self.cpu_share() < 0.03 { still + 1 } else { 0 };
            still == 2
        });
    }

    /// Waits until the program ends; returns exit code, stdout and stderr.
    pub fn end(self) -> (Option<i32>, String, String) {
        let mut process = self.process.take().expect("running");
        let start = Instant::now();
        while process.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < PATIENCE, "the program does not end");
            std::thread::sleep(Duration::from_millis(40));
        }
        let code = process.wait().unwrap().code();
        (code, self.written(0), self.written(1))
    }

    /// All output to stdout (0) or stderr (1) so far.
    pub fn written(&self, stream: usize) -> String {
        let mut file = &self.written[stream];
        let mut bytes = Vec::new();
        file.rewind().unwrap();
        file.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}
