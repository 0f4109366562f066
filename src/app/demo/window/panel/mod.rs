//! The panel over the picture, which has the controls, the costs, and the split between two techniques.
//!
//! The panel changes the [`Viewer`] directly, and returns all other changes as [`Request`]s to the window.

mod controls;
mod costs;
mod dialog;
mod facts;
mod overlay;
pub mod paint;

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use egui::{Color32, ColorImage, Context, Pos2, RawInput, Rect, TextureHandle, TextureOptions, Vec2, ViewportId};
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::keyboard::{Key, NamedKey};
use winit::window::Window;

use self::controls::Sections;
use self::dialog::FileDialog;
use self::facts::HISTORY;
pub use self::facts::{Facts, Request};
use self::paint::Painted;
use super::layout::Layout;
use super::over::LayerPicture;
use super::probes::Ball;
use super::viewer::Viewer;
use leadr_maps::Rgb8Image;
use leadr_maps::shown::shown_line;

/// The width of the panel in points.
const WIDTH: f32 = 252.0;
/// The smallest width of a window that starts with the panel, in points.
const ROOM: f32 = 560.0;
/// The duration of a message on the screen.
const MESSAGE: Duration = Duration::from_secs(6);

/// The panel of a window.
pub struct Panel {
    context: Context,
    input: egui_winit::State,
    began: Instant,
    /// Whether the panel is shown.
    pub open: bool,
    /// Whether the help is shown.
    help: bool,
    sections: Sections,
    /// The dialog that opens files, while it is shown.
    dialog: Option<FileDialog>,
    /// Compiler error of a changed shader.
    pub shader_fault: Option<String>,
    message: Option<(String, Instant)>,
    /// Description of running work, shown until it ends.
    pub working: Option<String>,
    milliseconds: VecDeque<f32>,
    /// An overlay on the picture and its legend.
    over: Option<(TextureHandle, String)>,
    /// The slope covariances under pixels for the ellipses.
    pub ellipses: Option<LayerPicture>,
    /// The probes of the volume of sky occlusion.
    pub balls: Option<Vec<Ball>>,
    /// The time of the next redraw that happens without an event.
    pub wakes: Option<Instant>,
    /// The position of the pointer in points.
    pointer: Option<Pos2>,
}

impl Panel {
    /// Creates a panel for `window` with a stored layout.
    pub fn new(window: &Window, layout: &Layout) -> Self {
        let context = Context::default();
        set_style(&context);
        let scale = window.scale_factor();
        let input =
            egui_winit::State::new(context.clone(), ViewportId::ROOT, window, Some(scale as f32), None, Some(8192));
        let room = || window.inner_size().to_logical::<f32>(scale).width >= ROOM;
        let open = layout.panel.unwrap_or_else(room);
        Self {
            context,
            input,
            began: Instant::now(),
            open,
            help: false,
            sections: layout.sections.clone(),
            dialog: None,
            shader_fault: None,
            message: None,
            working: None,
            milliseconds: VecDeque::new(),
            over: None,
            ellipses: None,
            balls: None,
            wakes: None,
            pointer: None,
        }
    }

    /// Returns the current layout without the size of the window.
    pub fn layout(&self) -> Layout {
        Layout { size: None, panel: Some(self.open), sections: self.sections.clone() }
    }

    /// Returns the number of pixels per point.
    pub fn scale(&self) -> f64 {
        f64::from(self.context.pixels_per_point())
    }

    /// Handles an event. Returns whether the panel consumed it, and whether the panel must be redrawn.
    pub fn event(&mut self, window: &Window, event: &WindowEvent) -> (bool, bool) {
        // If this event were handled, a redraw would request another redraw.
        if matches!(event, WindowEvent::RedrawRequested) {
            return (false, false);
        }
        if let WindowEvent::CursorMoved { position, .. } = event {
            let scale = self.context.pixels_per_point();
            self.pointer = Some(egui::pos2(position.x as f32 / scale, position.y as f32 / scale));
        }
        let response = self.input.on_window_event(window, event);
        let consumed = match event {
            WindowEvent::KeyboardInput { event, .. } => self.context.text_edit_focused() && edits(&event.logical_key),
            WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. } => self.is_under_pointer(),
            _ => response.consumed,
        };
        (consumed, response.repaint)
    }

    /// Whether the pointer is over the panel or drags a widget. egui answers this for the pointer position at the last layout, which may be
    /// outdated.
    fn is_under_pointer(&self) -> bool {
        let over = |at: Pos2| {
            let layer = self.context.layer_id_at(at);
            (self.open && at.x < WIDTH) || layer.is_some_and(|layer| layer.order != egui::Order::Background)
        };
        self.pointer.is_some_and(over) || self.context.egui_is_using_pointer()
    }

    /// Shows a message for a few seconds.
    pub fn say(&mut self, message: impl Into<String>) {
        self.message = Some((shown_line(&message.into()), Instant::now()));
    }

    /// Returns the width of the panel in a window of this width, in pixels; 0 if it is hidden.
    pub fn covers(&self, width: u32) -> f32 {
        if self.open { (WIDTH * self.context.pixels_per_point()).min(width as f32) } else { 0.0 }
    }

    /// Shows or hides the dialog that opens files, which takes the place of the help.
    pub fn toggle_dialog(&mut self) {
        self.dialog = if self.dialog.is_none() { Some(FileDialog::default()) } else { None };
        self.help = false;
    }

    /// Shows or hides the help, which takes the place of the dialog.
    pub fn toggle_help(&mut self) {
        self.help = !self.help;
        self.dialog = None;
    }

    /// Whether the dialog that opens files is shown, which has a text field.
    pub fn has_dialog(&self) -> bool {
        self.dialog.is_some()
    }

    /// Closes the topmost overlay that covers the picture: an open list, the dialog, the help or the error of a shader. Returns whether
    /// there was one.
    pub fn close_topmost(&mut self) -> bool {
        if egui::Popup::is_any_open(&self.context) {
            egui::Popup::close_all(&self.context);
            return true;
        }
        self.dialog.take().is_some() || std::mem::take(&mut self.help) || self.shader_fault.take().is_some()
    }

    /// Removes the message. Returns whether there was one.
    pub fn dismiss(&mut self) -> bool {
        self.message.take().is_some()
    }

    /// Records the time of a frame for the graph.
    pub fn frame_took(&mut self, milliseconds: f32) {
        self.milliseconds.push_back(milliseconds);
        if self.milliseconds.len() > HISTORY {
            self.milliseconds.pop_front();
        }
    }

    /// Copies text to the clipboard with the next frame.
    pub fn copy(&self, text: String) {
        self.context.copy_text(text);
    }

    /// Shows an overlay on the picture with its legend. `None` removes the overlay.
    pub fn lay_over(&mut self, picture: Option<(Rgb8Image, String)>) {
        self.over = picture.map(|(picture, says)| {
            let pixels = picture.texels.iter().map(|&[r, g, b]| Color32::from_rgb(r, g, b)).collect();
            let image = ColorImage::new([picture.width as usize, picture.height as usize], pixels);
            (self.context.load_texture("over the picture", image, TextureOptions::NEAREST), says)
        });
    }

    /// Takes the input since the last frame. `State::take_egui_input` is not used, because it queries the window size, which panics if
    /// another program has closed the window.
    fn take_input(&mut self, window: &Window, size: PhysicalSize<u32>) -> RawInput {
        let scale = self.context.zoom_factor() * window.scale_factor() as f32;
        let points = Vec2::new(size.width as f32, size.height as f32) / scale;
        let input = self.input.egui_input_mut();
        input.time = Some(self.began.elapsed().as_secs_f64());
        input.screen_rect = Some(Rect::from_min_size(Pos2::ZERO, points));
        input.viewport_id = ViewportId::ROOT;
        let viewport = input.viewports.entry(ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(window.scale_factor() as f32);
        input.take()
    }

    /// Lays out the panel, and applies the changes of the user to `viewer`. Returns all other requests. `size` is the window size in pixels
    /// from the last event.
    pub fn run(
        &mut self,
        window: &Window,
        size: PhysicalSize<u32>,
        viewer: &mut Viewer,
        facts: &Facts<'_>,
    ) -> (Painted, Vec<Request>) {
        let input = self.take_input(window, size);
        let mut requests = Vec::new();
        let context = self.context.clone();
        if self.message.as_ref().is_some_and(|(_, since)| since.elapsed() > MESSAGE) {
            self.message = None;
        }
        let before = (viewer.choices.clone(), viewer.time, viewer.fly);
        let output = context.run_ui(input, |ui| {
            requests.clear();
            let left = if self.open { WIDTH } else { 0.0 };
            if let Some((texture, says)) = &self.over {
                overlay::picture(ui, texture, says, left);
            }
            if let Some(covariances) = &self.ellipses {
                overlay::ellipses(ui, covariances);
            }
            if let Some(balls) = &self.balls {
                overlay::balls(ui, balls, left);
            }
            overlay::split(ui, viewer, left);
            if self.open {
                egui::Panel::left("choices").exact_size(WIDTH).resizable(false).show(ui, |ui| {
                    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                        controls::show(ui, viewer, facts, &mut self.sections, &mut requests);
                        costs::show(ui, facts, &self.milliseconds, &mut self.sections);
                        controls::buttons(ui, &mut requests);
                    });
                });
            }
            let messages = self.working.iter().chain(self.message.iter().map(|(message, _)| message));
            let messages: Vec<&str> = messages.map(String::as_str).collect();
            if !messages.is_empty() {
                overlay::message(ui, &messages.join("\n"), left);
            }
            // The topmost overlay is drawn last, and closed first.
            if self.shader_fault.as_ref().is_some_and(|fault| !overlay::shader_fault(ui, fault, left)) {
                self.shader_fault = None;
            }
            if self.help {
                self.help = overlay::help(ui, left);
            }
            if self.dialog.as_mut().is_some_and(|dialog| !dialog.show(ui, left, &mut requests)) {
                self.dialog = None;
            }
        });
        let (choices, time, fly) = before;
        if !choices.draws_like(&viewer.choices) || time != viewer.time || fly != viewer.fly {
            viewer.invalidate();
        }
        let wait = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |root| root.repaint_delay);
        let message = self.message.as_ref().map(|(_, since)| *since + MESSAGE);
        self.wakes = [Instant::now().checked_add(wait), message].into_iter().flatten().min();
        self.input.handle_platform_output(window, output.platform_output);
        let primitives = context.tessellate(output.shapes, output.pixels_per_point);
        let painted =
            Painted { primitives, textures: output.textures_delta, pixels_per_point: output.pixels_per_point };
        (painted, requests)
    }
}

/// Whether a key edits text in a field that has the focus.
fn edits(key: &Key) -> bool {
    !matches!(key, Key::Named(NamedKey::F1 | NamedKey::F11 | NamedKey::F12 | NamedKey::Tab))
}

/// Sets a dark, slightly transparent style. Labels cannot be selected, because a selectable label has no tooltip of its control.
fn set_style(context: &Context) {
    let mut visuals = egui::Visuals::dark();
    visuals.panel_fill = Color32::from_rgba_unmultiplied(20, 22, 26, 225);
    visuals.window_fill = Color32::from_rgba_unmultiplied(20, 22, 26, 240);
    // A shadow would hide more of the picture than the window.
    visuals.window_shadow = egui::Shadow::NONE;
    context.set_visuals(visuals);
    context.all_styles_mut(|style| style.interaction.selectable_labels = false);
}
