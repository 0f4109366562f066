//! The state that the user changes: camera, time and picture settings. The state does not depend on the window or the device.

use glam::{Vec2, Vec3};

use super::choices::{Choices, Compare};
use crate::app::demo::orbit::Orbit;
use leadr_render::camera::Camera;
use leadr_render::settings::{Probes, Quadrature, Technique};
use leadr_scenes::config::Picture;
use leadr_scenes::light::SunDirection;
use leadr_scenes::stage::Sweep;

/// The largest step of the animation in seconds. On a slow device, the animation slows down instead of jumping.
const LONGEST_STEP: f64 = 0.1;
/// The time step of the arrow keys in seconds.
const SCRUB: f64 = 0.5;
/// The time step of `,` and `.` in seconds.
const FRAME: f64 = 1.0 / 30.0;

/// The duration of a sweep in each direction in seconds.
const SWEEP_SECONDS: f64 = 8.0;
/// The number of steps of a sweep, which is larger than the number of frames.
const SWEEP_STEPS: u32 = 1 << 16;
/// The speed of a flying camera per second, in multiples of its distance from the target.
const FLY_PACE: f32 = 0.6;

/// The distance in points from the split line within which the line can be dragged.
pub const SPLIT_GRIP: f32 = 8.0;

/// The step of the sun for `[` and `]` in hours.
const SUN_STEP: f64 = 0.5;
/// The speeds of the sun in hours per second. The key selects them in this order.
const SUN_PACES: [f64; 3] = [0.0, 24.0 / 120.0, 24.0 / 20.0];

/// An action of a key or button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Pause or resume time.
    Pause,
    /// Move time by this many half seconds.
    Scrub(i8),
    /// Pause and move time by this many thirtieths of a second.
    Frame(i8),
    /// Move the sun by this many half hours.
    Sun(i8),
    /// Select the next speed of the sun. This speed is added to the sun's motion in the scene.
    SunPace,
    /// Reset view, time and sun, and resume time.
    Reset,
    /// Select a technique.
    Technique(Technique),
    /// Switch between the paper's grid and the visible-slope rules.
    Rule,
    /// Select the next shadowing model.
    Shadowing,
    /// Show or hide the right side with another technique.
    Compare,
    /// Start or stop a camera sweep to the far view and back.
    Sweep,
    /// Switch between orbit and fly mode.
    Fly,
    /// Select the next environment.
    Environment,
    /// Save a screenshot.
    Screenshot,
    /// Copy the command that draws this picture.
    CopyCommand,
    /// Show or hide the panel.
    Panel,
    /// Show or hide the help.
    Help,
    /// Switch between full screen and window.
    FullScreen,
    /// Show or hide the dialog that opens files.
    Open,
    /// Close the topmost overlay; quit if there is none.
    Close,
    /// Quit, or close the topmost overlay that covers the picture.
    Quit,
}

/// The effect of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drag {
    /// Orbits the camera around its target.
    Rotate,
    /// Moves the camera and the target sideways.
    Pan,
    /// Rotates a flying camera.
    Look,
    /// Moves the line between two techniques.
    Split,
}

/// The state that keys and mouse change.
#[derive(Clone, Debug)]
pub struct Viewer {
    /// The orbit camera of the user.
    pub orbit: Orbit,
    /// The animation time in seconds, which is never negative.
    pub time: f64,
    /// Whether time is paused.
    pub paused: bool,
    /// The time offset of the sun in hours.
    pub sun_hours: f64,
    sun_pace: usize,
    /// The picture settings of the user.
    pub choices: Choices,
    /// Whether the camera is in fly mode, in which dragging rotates the camera about its own position, and keys move the camera.
    pub fly: bool,
    /// The direction of the held keys in fly mode, as right, forward and up. The components are -1, 0 or 1.
    pub held: Vec3,
    /// Whether the scene is animated.
    pub scene_moves: bool,
    /// The scene's sweep, if it has one.
    pub sweep: Option<Sweep>,
    /// The seconds since a sweep started, and the orbit at the end of the sweep.
    sweeping: Option<(f64, Orbit)>,
    other_rule: Quadrature,
    other_compare: Compare,
    start: (Orbit, f64),
    /// The drag that is in progress, if there is one.
    pub drag: Option<Drag>,
    /// The position of the pointer in pixels.
    pub pointer: Option<[f32; 2]>,
    /// Width of the panel, which covers the left part of the picture, pixels.
    covered: f32,
    changed: bool,
    /// Whether an overlay needs a redraw.
    pub redraw: bool,
}

impl Viewer {
    /// Creates a viewer whose time is running. `sweep` has the camera distances of the scene's sweep.
    pub fn new(orbit: Orbit, time: f64, choices: Choices, sweep: Option<Sweep>) -> Self {
        let (start, drag, pointer) = ((orbit, time), None, None);
        let other_rule = match choices.picture.options.quadrature {
            Quadrature::Grid(_) => Quadrature::VisibleSlopes(Probes::Sixteen),
            Quadrature::VisibleSlopes(_) => Quadrature::Grid(5),
        };
        Self {
            orbit,
            time,
            paused: false,
            sun_hours: 0.0,
            sun_pace: 0,
            choices,
            fly: false,
            held: Vec3::ZERO,
            scene_moves: true,
            sweep,
            sweeping: None,
            other_rule,
            other_compare: Compare::default(),
            start,
            drag,
            pointer,
            covered: 0.0,
            changed: true,
            redraw: false,
        }
    }

    /// Starts another scene and keeps the picture settings.
    pub fn enter(&mut self, orbit: Orbit, sweep: Option<Sweep>, scene_moves: bool) {
        let (choices, other_rule, other_compare) = (self.choices.clone(), self.other_rule, self.other_compare);
        let picture = Picture { height_scale: 1.0, stretch: 1.0, ..choices.picture };
        let choices = Choices { picture, sun: None, ..choices };
        let covered = self.covered;
        *self = Self { other_rule, other_compare, scene_moves, covered, ..Self::new(orbit, 0.0, choices, sweep) };
    }

    /// Plays the animation from its start.
    pub fn play(&mut self) {
        (self.time, self.paused, self.changed) = (0.0, false, true);
    }

    /// Returns the progress of a running sweep, 0 to 1.
    pub fn sweep_progress(&self) -> Option<f32> {
        self.sweeping.map(|(seconds, _)| (seconds / (2.0 * SWEEP_SECONDS)) as f32)
    }

    /// Advances time by `seconds`, unless time is paused. Sun, sweep and fly mode always advance.
    pub fn advance(&mut self, seconds: f64) {
        if !self.paused {
            self.time += seconds.clamp(0.0, LONGEST_STEP);
            self.changed |= self.scene_moves;
        }
        if self.sun_pace > 0 {
            self.sun_hours += SUN_PACES[self.sun_pace] * seconds.clamp(0.0, LONGEST_STEP);
            self.changed = true;
        }
        if let (Some((ran, back)), Some(sweep)) = (self.sweeping, self.sweep) {
            let ran = ran + seconds.max(0.0);
            // The position of the sweep rises to 1 and falls back to 0.
            let share = (ran / SWEEP_SECONDS).min(2.0);
            let share = if share > 1.0 { 2.0 - share } else { share };
            self.orbit.set_distance(sweep.distance((share * f64::from(SWEEP_STEPS - 1)) as u32, SWEEP_STEPS));
            self.sweeping = Some((ran, back)).filter(|_| ran < 2.0 * SWEEP_SECONDS);
            if self.sweeping.is_none() {
                self.orbit = back;
            }
            self.changed = true;
        }
        if self.fly && self.held != Vec3::ZERO {
            let metres = FLY_PACE * self.orbit.distance() * seconds.clamp(0.0, LONGEST_STEP) as f32;
            self.orbit.fly(self.held * metres);
            self.changed = true;
        }
    }

    /// Performs an action. Actions on the window, the environment or files are ignored, because the window handles them.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Pause => self.paused = !self.paused,
            Action::Scrub(steps) => self.time = (self.time + SCRUB * f64::from(steps)).max(0.0),
            Action::Frame(steps) => {
                self.paused = true;
                self.time = (self.time + FRAME * f64::from(steps)).max(0.0);
            }
            Action::Sun(steps) => self.sun_hours += SUN_STEP * f64::from(steps),
            Action::SunPace => self.sun_pace = (self.sun_pace + 1) % SUN_PACES.len(),
            Action::Reset => {
                (self.sweeping, self.fly) = (None, false);
                (self.orbit, self.time) = self.start;
                (self.sun_hours, self.sun_pace) = (0.0, 0);
                self.paused = false;
            }
            Action::Technique(technique) => self.choices.picture.technique = technique,
            Action::Rule => std::mem::swap(&mut self.choices.picture.options.quadrature, &mut self.other_rule),
            Action::Shadowing => self.choices.picture.options.shadowing = self.choices.picture.options.shadowing.next(),
            Action::Compare => match self.choices.compare.take() {
                Some(compare) => self.other_compare = compare,
                None => self.choices.compare = Some(self.other_compare),
            },
            Action::Sweep => {
                self.sweeping = match (self.sweeping, self.sweep) {
                    (Some((_, back)), _) => {
                        self.orbit = back;
                        None
                    }
                    (None, Some(_)) => Some((0.0, self.orbit)),
                    (None, None) => None,
                };
            }
            Action::Fly => {
                self.fly = !self.fly;
                self.held = Vec3::ZERO;
            }
            Action::Environment
            | Action::Screenshot
            | Action::CopyCommand
            | Action::Panel
            | Action::Help
            | Action::FullScreen
            | Action::Open
            | Action::Close
            | Action::Quit => return,
        }
        self.changed = true;
    }

    /// Returns the user's camera, moved with the target of the scene's camera `own` since the start, so that both follow one object. The
    /// image is moved to the part of a window of this width in pixels that the panel leaves free.
    pub fn camera(&self, own: &Camera, width: f32) -> Camera {
        let gone = own.target - self.start.0.target();
        let camera = self.orbit.pose().camera();
        let shift = Vec2::new(2.0 * self.shift() / width, 0.0);
        Camera { position: camera.position + gone, target: camera.target + gone, shift, ..camera }
    }

    /// Sets the width of the panel, which covers the left part of the picture, in pixels.
    pub fn cover(&mut self, pixels: f32) {
        self.changed |= pixels != self.covered;
        self.covered = pixels;
    }

    /// Returns the offset of the picture to the right, to the middle of the part that the panel leaves free, in whole pixels.
    pub fn shift(&self) -> f32 {
        (0.5 * self.covered).round()
    }

    /// Returns the position of the split between two techniques in a window of this width, in pixels.
    pub fn split_at(&self, width: f32) -> Option<f32> {
        self.choices.compare.map(|compare| compare.split * width + self.shift())
    }

    /// Whether `x` is within `grip` of the split between two techniques. All values are in pixels.
    pub fn is_at_split(&self, x: f32, width: f32, grip: f32) -> bool {
        self.split_at(width).is_some_and(|split| (split - x).abs() <= grip)
    }

    /// Whether the split between two techniques is being dragged.
    pub fn drags_split(&self) -> bool {
        self.drag == Some(Drag::Split)
    }

    /// Moves the pointer to this position in pixels, with x to the right and y down, in a window of this size. Continues the current drag.
    pub fn move_pointer(&mut self, to: [f32; 2], [width, height]: [f32; 2]) {
        let (shift, covered) = (self.shift(), self.covered.min(width));
        if let (Some(from), Some(drag)) = (self.pointer, self.drag) {
            let (right, down) = (to[0] - from[0], to[1] - from[1]);
            match drag {
                Drag::Rotate => self.orbit.rotate(right, down),
                Drag::Pan => self.orbit.pan(right, down, height),
                Drag::Look => self.orbit.look(right, down),
                Drag::Split => {
                    if let Some(compare) = &mut self.choices.compare {
                        compare.split = ((to[0].clamp(covered, width) - shift) / width).clamp(0.0, 1.0);
                    }
                    self.redraw = true;
                }
            }
            self.changed |= drag != Drag::Split;
        }
        self.pointer = Some(to);
    }

    /// Zooms by wheel notches. Positive notches move closer.
    pub fn wheel(&mut self, notches: f32) {
        self.orbit.zoom(notches.clamp(-50.0, 50.0));
        self.changed = true;
    }

    /// Sets the direction of the sun. A moving sun continues from this direction.
    pub fn put_sun(&mut self, sun: SunDirection) {
        self.choices.sun = Some(sun);
        self.sun_hours = 0.0;
        self.changed = true;
    }

    /// Marks the picture as changed.
    pub fn invalidate(&mut self) {
        self.changed = true;
    }

    /// Whether something has changed since the last call.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Whether the picture changes, after an action or during an animation.
    pub fn is_moving(&self) -> bool {
        let flies = self.fly && self.held != Vec3::ZERO;
        let runs = !self.paused && self.scene_moves;
        self.changed || runs || self.sun_pace > 0 || self.sweeping.is_some() || flies
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::masking::shadowing::Shadowing;
    use leadr_render::settings::RenderSettings;
    use leadr_scenes::view::CameraPose;

    fn viewer() -> Viewer {
        let pose =
            CameraPose { position: [6.0, -8.0, 5.0], target: [0.0, 0.0, 2.0], up: [0.0, 0.0, 1.0], fov_degrees: 40.0 };
        let choices = Choices::new(Picture::of(&RenderSettings::default()));
        Viewer::new(Orbit::new(&pose), 1.0, choices, Some(Sweep { near: 2.0, far: 50.0 }))
    }

    #[test]
    fn clock_jumps_keep_camera_time_and_sun_valid() {
        for jump in [-5.0 * 3600.0, 5.0 * 3600.0, 1e12] {
            let mut viewer = viewer();
            let orbit = viewer.orbit;
            viewer.act(Action::SunPace);
            viewer.act(Action::Sweep);
            viewer.advance(jump);
            viewer.advance(2.0 * SWEEP_SECONDS);
            assert!(viewer.orbit == orbit && viewer.sweep_progress().is_none(), "{jump}: {:?}", viewer.orbit);
            let at = |viewer: &Viewer| viewer.orbit.pose().camera().position;
            let before = at(&viewer);
            viewer.act(Action::Fly);
            viewer.held = Vec3::Y;
            viewer.advance(jump);
            let moved = at(&viewer).distance(before);
            assert!(moved <= 1.0, "{jump}: {moved} m");
            assert!((1.0..=1.31).contains(&viewer.time), "{jump}: {} s", viewer.time);
            assert!((0.0..=0.31 * SUN_PACES[1]).contains(&viewer.sun_hours), "{jump}: {} h", viewer.sun_hours);
        }
    }

    #[test]
    fn time_runs_unless_it_is_paused_and_never_jumps() {
        let mut viewer = viewer();
        viewer.advance(0.05);
        assert!((viewer.time - 1.05).abs() < 1e-9);
        viewer.advance(60.0);
        assert!((viewer.time - 1.15).abs() < 1e-9);
        viewer.act(Action::Pause);
        assert!(viewer.take_changed());
        viewer.advance(0.05);
        assert!((viewer.time - 1.15).abs() < 1e-9 && !viewer.take_changed() && !viewer.is_moving());
        viewer.act(Action::Frame(1));
        assert!((viewer.time - 1.15 - FRAME).abs() < 1e-9 && viewer.paused && viewer.is_moving());
        for _ in 0..9 {
            viewer.act(Action::Scrub(-1));
        }
        assert_eq!(viewer.time, 0.0);
    }

    #[test]
    fn time_does_not_change_static_scenes() {
        let mut viewer = viewer();
        viewer.scene_moves = false;
        viewer.take_changed();
        viewer.advance(0.05);
        assert!(!viewer.is_moving() && viewer.time > 1.0);
        viewer.act(Action::Scrub(1));
        assert!(viewer.is_moving());
    }

    #[test]
    fn the_sun_moves_while_the_scene_stands() {
        let mut viewer = viewer();
        viewer.act(Action::Pause);
        viewer.take_changed();
        viewer.advance(0.1);
        assert!(viewer.sun_hours == 0.0 && !viewer.is_moving());
        viewer.act(Action::Sun(-1));
        assert!(viewer.sun_hours == -0.5 && viewer.take_changed());
        viewer.act(Action::SunPace);
        viewer.act(Action::SunPace);
        viewer.advance(0.05);
        assert!((viewer.sun_hours + 0.5 - 0.06).abs() < 1e-9 && viewer.time == 1.0 && viewer.is_moving());
        viewer.act(Action::SunPace);
        viewer.act(Action::Reset);
        assert_eq!(viewer.sun_hours, 0.0);
    }

    #[test]
    fn the_shading_switches_and_comes_back() {
        let mut viewer = viewer();
        let start = viewer.choices.picture.shading();
        viewer.act(Action::Rule);
        assert_ne!(viewer.choices.picture.shading(), start);
        viewer.act(Action::Rule);
        let seen: Vec<Shadowing> = (0..3)
            .map(|_| {
                viewer.act(Action::Shadowing);
                viewer.choices.picture.shading().options().shadowing
            })
            .collect();
        assert!(Shadowing::MAIN.iter().all(|v| seen.contains(v)) && viewer.choices.picture.shading() == start);
    }

    #[test]
    fn options_outlast_a_technique_without_them() {
        let mut viewer = viewer();
        viewer.act(Action::Rule);
        let start = viewer.choices.picture.shading();
        viewer.act(Action::Technique(Technique::Lean));
        assert_eq!(viewer.choices.picture.shading(), Technique::Lean.into());
        viewer.act(Action::Technique(Technique::Leadr));
        assert_eq!(viewer.choices.picture.shading(), start);
    }

    #[test]
    fn dragging_turns_pans_and_stops() {
        let mut viewer = viewer();
        viewer.take_changed();
        let start = viewer.orbit;
        viewer.move_pointer([10.0, 10.0], [200.0, 100.0]);
        assert!(viewer.orbit == start && !viewer.take_changed());
        viewer.drag = Some(Drag::Rotate);
        viewer.move_pointer([30.0, 15.0], [200.0, 100.0]);
        assert!(viewer.orbit != start && viewer.take_changed());
        assert_eq!(viewer.orbit.pose().target, start.pose().target);
        viewer.drag = Some(Drag::Pan);
        viewer.move_pointer([40.0, 15.0], [200.0, 100.0]);
        assert_ne!(viewer.orbit.pose().target, start.pose().target);
        viewer.drag = None;
        let panned = viewer.orbit;
        viewer.move_pointer([90.0, 90.0], [200.0, 100.0]);
        assert_eq!(viewer.orbit, panned);
        viewer.act(Action::Reset);
        assert_eq!((viewer.orbit, viewer.time), (start, 1.0));
    }

    #[test]
    fn camera_follows_the_scene_anchor() {
        let mut viewer = viewer();
        let start = viewer.orbit.pose().camera();
        let gone = Vec3::new(7.0, 1.0, 0.0);
        let own = Camera { position: start.position + gone, target: start.target + gone, ..start };
        let camera = viewer.camera(&own, 200.0);
        assert!(camera.position.distance(own.position) < 1e-4 && camera.target == own.target);
        // An orbit keeps the distance to the followed target. A pan keeps its offset.
        viewer.orbit.rotate(100.0, 0.0);
        let turned = viewer.camera(&own, 200.0);
        assert!(turned.target == own.target && turned.position.distance(own.position) > 1.0);
        viewer.orbit.pan(50.0, 0.0, 100.0);
        let aside = viewer.camera(&own, 200.0).target - own.target;
        assert!(aside.distance(viewer.orbit.target() - start.target) < 1e-4 && aside.length() > 0.1);
    }

    #[test]
    fn subject_and_split_move_to_the_middle_of_the_free_part() {
        let mut viewer = viewer();
        let own = viewer.orbit.pose().camera();
        let without = viewer.camera(&own, 200.0);
        viewer.take_changed();
        viewer.cover(50.0);
        assert!(viewer.take_changed());
        viewer.cover(50.0);
        assert!(!viewer.take_changed());
        let camera = viewer.camera(&own, 200.0);
        let target = camera.clip_from_world((200, 100), Vec2::ZERO).project_point3(camera.target);
        assert!((100.0 + 100.0 * target.x - 125.0).abs() < 1e-3, "{target}");
        assert_eq!(Camera { shift: Vec2::ZERO, ..camera }, without);
        // The split stays on the subject, in the free part of the window.
        viewer.act(Action::Compare);
        assert_eq!(viewer.split_at(200.0), Some(125.0));
        viewer.drag = Some(Drag::Split);
        for (to, at) in [(20.0, 50.0), (60.0, 60.0), (300.0, 200.0)] {
            viewer.move_pointer([100.0, 10.0], [200.0, 100.0]);
            viewer.move_pointer([to, 10.0], [200.0, 100.0]);
            assert_eq!(viewer.split_at(200.0), Some(at));
        }
        viewer.enter(viewer.orbit, None, false);
        assert_eq!(viewer.shift(), 25.0);
    }

    #[test]
    fn a_sweep_goes_out_and_comes_back() {
        let mut viewer = viewer();
        let start = viewer.orbit;
        viewer.act(Action::Pause);
        viewer.act(Action::Sweep);
        viewer.advance(SWEEP_SECONDS);
        assert!((viewer.orbit.distance() - 50.0).abs() < 0.1 && viewer.is_moving());
        viewer.advance(0.5 * SWEEP_SECONDS);
        assert!((viewer.orbit.distance() - 10.0).abs() < 0.1);
        viewer.advance(SWEEP_SECONDS);
        assert!(viewer.orbit == start && viewer.sweep_progress().is_none());
        // The same action stops the sweep.
        viewer.act(Action::Sweep);
        viewer.advance(1.0);
        viewer.act(Action::Sweep);
        assert_eq!(viewer.orbit, start);
    }

    #[test]
    fn fly_camera_rotates_in_place_and_moves_forward() {
        let mut viewer = viewer();
        viewer.act(Action::Fly);
        let eye = Vec3::from_array(viewer.orbit.pose().position);
        viewer.move_pointer([0.0, 0.0], [200.0, 100.0]);
        viewer.drag = Some(Drag::Look);
        viewer.move_pointer([40.0, 10.0], [200.0, 100.0]);
        let turned = viewer.orbit.pose();
        assert!(Vec3::from_array(turned.position).distance(eye) < 1e-4);
        viewer.held = Vec3::Y;
        viewer.advance(0.1);
        let gone = viewer.orbit.pose();
        let way = Vec3::from_array(gone.position) - eye;
        let ahead = Vec3::from_array(turned.target) - eye;
        assert!(way.normalize().dot(ahead.normalize()) > 0.999 && way.length() > 0.1);
        assert!(viewer.is_moving());
    }

    #[test]
    fn the_line_between_techniques_follows_the_pointer_and_no_picture_is_drawn_for_it() {
        let mut viewer = viewer();
        viewer.act(Action::Compare);
        viewer.take_changed();
        assert!(viewer.is_at_split(104.0, 200.0, 8.0) && !viewer.is_at_split(120.0, 200.0, 8.0));
        let orbit = viewer.orbit;
        viewer.move_pointer([100.0, 10.0], [200.0, 100.0]);
        viewer.drag = Some(Drag::Split);
        viewer.move_pointer([50.0, 30.0], [200.0, 100.0]);
        viewer.drag = None;
        viewer.move_pointer([90.0, 30.0], [200.0, 100.0]);
        assert_eq!(viewer.choices.compare.expect("one").split, 0.25);
        assert!(viewer.orbit == orbit && !viewer.take_changed() && viewer.redraw);
    }

    #[test]
    fn other_technique_is_restored() {
        let mut viewer = viewer();
        viewer.act(Action::Compare);
        viewer.choices.compare.as_mut().expect("one").technique = Technique::Lean;
        viewer.act(Action::Compare);
        assert_eq!(viewer.choices.compare, None);
        viewer.act(Action::Compare);
        assert_eq!(viewer.choices.compare.expect("one").technique, Technique::Lean);
    }

    #[test]
    fn the_wheel_never_reaches_the_target() {
        let mut viewer = viewer();
        for _ in 0..1000 {
            viewer.wheel(f32::MAX);
        }
        let pose = viewer.orbit.pose();
        let distance = Vec3::from_array(pose.position).distance(Vec3::from_array(pose.target));
        assert!((0.1..1.0).contains(&distance), "{distance}");
    }
}
