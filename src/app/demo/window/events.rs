//! Events of the window: keys, mouse, dropped files, and the times of the next frames.

use std::path::PathBuf;
use std::time::Instant;

use glam::Vec3;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, NamedKey};
use winit::window::Fullscreen;

use super::loading::Change;
use super::show::SceneChange;
use super::surroundings::Surroundings;
use super::viewer::{Action, Drag, SPLIT_GRIP};
use super::{ASK_INTERVAL, Session, keys};
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::extension;

impl Session<'_> {
    pub(super) fn handle(&mut self, events: &ActiveEventLoop, event: WindowEvent) -> Result<(), AppError> {
        let tab = matches!(&event, WindowEvent::KeyboardInput { event, .. } if event.logical_key == Key::Named(NamedKey::Tab));
        let (consumed, redraw) = if tab { (false, false) } else { self.panel.event(&self.window, &event) };
        if redraw {
            self.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::RedrawRequested => return self.draw(events),
            WindowEvent::Occluded(occluded) => {
                self.occluded = occluded;
                self.hidden = occluded;
                self.window.request_redraw();
            }
            WindowEvent::Resized(size) => {
                self.size = size;
                self.hidden = false;
                self.window.request_redraw();
            }
            WindowEvent::Focused(true) => {
                self.hidden = false;
                self.window.request_redraw();
            }
            WindowEvent::Focused(false) => self.viewer.held = Vec3::ZERO,
            // Escape closes the dialog although its text field has the focus.
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. }
                if !consumed || self.panel.has_dialog() && event.logical_key == Key::Named(NamedKey::Escape) =>
            {
                self.key(events, &event);
            }
            WindowEvent::DroppedFile(path) => self.open(path),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::MouseInput { state, button, .. } => {
                let grip = SPLIT_GRIP * self.window.scale_factor() as f32;
                let width = self.size.width as f32;
                let at_split = self.viewer.pointer.is_some_and(|[x, _]| self.viewer.is_at_split(x, width, grip));
                let drag = match button {
                    MouseButton::Left if at_split => Some(Drag::Split),
                    MouseButton::Left if self.modifiers.shift_key() => Some(Drag::Pan),
                    MouseButton::Left if self.viewer.fly => Some(Drag::Look),
                    MouseButton::Left => Some(Drag::Rotate),
                    MouseButton::Right => Some(Drag::Pan),
                    _ => return Ok(()),
                };
                self.viewer.drag = drag.filter(|_| state == ElementState::Pressed && !consumed);
            }
            WindowEvent::CursorMoved { position, .. } => {
                let size = [self.size.width as f32, self.size.height as f32];
                self.viewer.move_pointer([position.x as f32, position.y as f32], size);
                if std::mem::take(&mut self.viewer.redraw) {
                    self.window.request_redraw();
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !consumed => self.viewer.wheel(match delta {
                MouseScrollDelta::LineDelta(_, lines) => lines,
                MouseScrollDelta::PixelDelta(position) => position.y as f32 / 40.0,
            }),
            _ => return Ok(()),
        }
        Ok(())
    }

    fn key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) {
        let pressed = event.state == ElementState::Pressed;
        if self.viewer.fly
            && !self.modifiers.control_key()
            && let Some(way) = keys::flies(event.physical_key)
        {
            if !event.repeat {
                let held = self.viewer.held + if pressed { way } else { -way };
                self.viewer.held = held.clamp(Vec3::NEG_ONE, Vec3::ONE);
            }
            // Time before the key press must not move the camera.
            if !self.viewer.is_moving() {
                self.clock.pause();
            }
            return;
        }
        if !pressed {
            return;
        }
        let Some(action) = keys::action(&event.logical_key) else { return };
        // Key repeat applies to steps, but not to toggles.
        if event.repeat && !matches!(action, Action::Scrub(_) | Action::Frame(_) | Action::Sun(_)) {
            return;
        }
        self.act(events, action);
    }

    pub(super) fn act(&mut self, events: &ActiveEventLoop, action: Action) {
        match action {
            Action::Close if self.panel.close_topmost() || self.panel.dismiss() => {}
            Action::Quit if self.panel.close_topmost() => {}
            Action::Close | Action::Quit => events.exit(),
            Action::Screenshot => self.request_screenshot(),
            Action::Environment => self.loading.request(Change::Environment(self.surroundings.next())),
            Action::CopyCommand => self.copy_command(),
            Action::Open => self.panel.toggle_dialog(),
            Action::Panel => self.panel.open = !self.panel.open,
            Action::Help => self.panel.toggle_help(),
            Action::FullScreen => {
                let whole = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(whole);
            }
            _ => self.viewer.act(action),
        }
        self.window.request_redraw();
    }

    /// Opens a scene by name, or a file or folder. Errors are shown, and the current scene stays.
    pub(super) fn open(&mut self, path: PathBuf) {
        let is_scene = self.program.scenes().iter().any(|name| *path == **name);
        let material = |path: PathBuf| Ok(Change::Scene(SceneChange::Material(Some(path))));
        let change = match extension(&path).as_deref() {
            _ if is_scene => Ok(Change::Scene(SceneChange::Open(path))),
            _ if !path.exists() => Err(AppError::io("open", &path, "there is no such file; check the path")),
            Some("glb" | "gltf") => Ok(Change::Scene(SceneChange::Open(path))),
            Some("json") => material(path),
            _ if path.is_dir() => material(path),
            _ => Surroundings::dropped(path).map(Change::Environment),
        };
        match change {
            Ok(change) => self.loading.request(change),
            Err(error) => self.complain(&error),
        }
    }

    /// Requests a change of the scene.
    pub(super) fn change(&mut self, change: SceneChange) {
        self.loading.request(Change::Scene(change));
    }

    /// Requests a frame if the panel or a comparison needs one without an event.
    pub(super) fn wake(&self) {
        let wakes = self.panel.wakes.is_some_and(|wakes| wakes <= Instant::now());
        if self.difference.is_running() || wakes {
            self.window.request_redraw();
        }
    }

    /// Requests a frame if one is needed, and sets the time of the next wake-up.
    pub(super) fn wait(&mut self, events: &ActiveEventLoop) -> Result<(), AppError> {
        self.load()?;
        self.reload()?;
        if self.hidden {
            events.set_control_flow(ControlFlow::Wait);
            return Ok(());
        }
        let PhysicalSize { width, height } = self.size;
        let sides = self.viewer.choices.sides(&self.settings);
        // The loop sleeps when nothing moves and the picture is complete, unless a number of frames was requested.
        if self.options.frames.is_some()
            || self.viewer.is_moving()
            || !self.painter.is_complete([width, height], &sides)
        {
            self.window.request_redraw();
        }
        let polls = self.difference.is_running() || self.shaders.is_some() || self.loading.is_busy();
        let poll_at = polls.then(|| Instant::now() + ASK_INTERVAL);
        let wakes = [self.panel.wakes, poll_at].into_iter().flatten().min();
        events.set_control_flow(wakes.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        Ok(())
    }
}
