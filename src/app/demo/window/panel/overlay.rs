//! Overlays on the picture: the split between two techniques, layers, messages and help.

use egui::text::{LayoutJob, TextWrapping};
use egui::{Align2, Color32, CursorIcon, FontId, Id, Mesh, Pos2, Rect, Shape, Stroke, TextureHandle, Ui, Vec2};

use crate::app::demo::window::keys;
use crate::app::demo::window::over::LayerPicture;
use crate::app::demo::window::probes::{Ball, NONE, SAYS, SIDES};
use crate::app::demo::window::viewer::{SPLIT_GRIP, Viewer};

/// The spacing of the covariance ellipses in points.
const ELLIPSES: f32 = 24.0;
/// The half-axis of an ellipse for a slope with a standard deviation of 1, in points.
const ELLIPSE: f32 = 22.0;

/// Width of the column of keys in the help, points.
const KEYS: f32 = 100.0;
/// Maximum width of the help and of other windows over the picture, points.
const WIDEST: f32 = 560.0;
/// Minimum width of the part beside the panel for text, points. In a narrower part, text also covers the panel.
const NARROWEST: f32 = 260.0;
/// Margin of text in its box, points.
const MARGIN: Vec2 = Vec2::new(6.0, 3.0);

/// Returns the part of the window for text: beside the panel of width `left` if there is room.
fn free(ui: &Ui, left: f32) -> Rect {
    let screen = ui.ctx().content_rect();
    let left = if screen.width() - left < NARROWEST { 0.0 } else { left };
    screen.with_min_x(screen.left() + left).shrink(8.0)
}

/// Draws text in a dark box of at most this size, in as many lines as it needs. Text that does not fit ends in an ellipsis.
fn label(ui: &Ui, at: Pos2, anchor: Align2, room: Vec2, text: &str) {
    let font = FontId::proportional(13.0);
    let row = ui.fonts_mut(|fonts| fonts.row_height(&font));
    let room = room - 2.0 * MARGIN;
    let max_rows = ((room.y / row) as usize).max(1);
    let wrap = TextWrapping { max_width: room.x.max(row), max_rows, ..TextWrapping::default() };
    let job = LayoutJob { wrap, ..LayoutJob::simple(text.to_owned(), font, Color32::WHITE, room.x) };
    let galley = ui.painter().layout_job(job);
    let area = anchor.anchor_size(at, galley.size() + 2.0 * MARGIN);
    ui.painter().rect_filled(area, 3.0, Color32::from_black_alpha(150));
    ui.painter().galley(area.min + MARGIN, galley, Color32::WHITE);
}

/// Draws the legend of an overlay at the bottom left.
fn legend(ui: &Ui, text: &str, left: f32) {
    let free = free(ui, left);
    label(ui, free.left_bottom(), Align2::LEFT_BOTTOM, free.size(), text);
}

/// Shows a window over the picture, beside the panel if there is room, with scrolled contents. Returns whether the window stays open.
///
/// Windows of egui keep their size from frame to frame, and are cut when the window of the program becomes smaller.
pub fn window(ui: &Ui, title: &str, left: f32, contents: impl FnOnce(&mut Ui)) -> bool {
    let free = free(ui, left);
    // The title and the frame need this space.
    let room = free.size() - Vec2::new(14.0, 44.0);
    let width = room.x.min(WIDEST);
    let corner = Pos2::new(free.center().x - 0.5 * (width + 14.0), free.top());
    let area = egui::Area::new(Id::new(title)).fixed_pos(corner).constrain(false);
    let shown = area.show(ui.ctx(), |ui| {
        egui::Frame::window(ui.style()).inner_margin(6.0).show(ui, |ui| {
            ui.set_width(width);
            let close = ui.horizontal(|ui| {
                ui.strong(title);
                let right = egui::Layout::right_to_left(egui::Align::Center);
                ui.with_layout(right, |ui| ui.small_button("close").on_hover_text("Esc").clicked()).inner
            });
            ui.separator();
            // An area has the height of its last contents, which may have been shorter.
            ui.allocate_ui(Vec2::new(width, room.y), |ui| {
                egui::ScrollArea::vertical().max_height(room.y).auto_shrink([false, true]).show(ui, contents);
            });
            close.inner
        })
    });
    !shown.inner.inner
}

/// Draws the split between two techniques and their names. The window itself handles dragging, so dragging works at any frame rate.
pub fn split(ui: &Ui, viewer: &Viewer, left: f32) {
    let screen = ui.ctx().content_rect();
    let Some(compare) = viewer.choices.compare else { return };
    let scale = ui.pixels_per_point();
    let Some(x) = viewer.split_at(screen.width() * scale).map(|pixels| screen.left() + pixels / scale) else { return };
    let hovered = ui.ctx().pointer_latest_pos().is_some_and(|at| (at.x - x).abs() <= SPLIT_GRIP && at.x > left);
    if hovered || viewer.drags_split() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let strength = if hovered || viewer.drags_split() { 2.5 } else { 1.0 };
    ui.painter().vline(x, screen.y_range(), Stroke::new(strength, Color32::WHITE));
    ui.painter().circle(Pos2::new(x, screen.center().y), 7.0, Color32::WHITE, Stroke::new(1.0, Color32::BLACK));
    let top = screen.top() + 8.0;
    let room = |width: f32| Vec2::new(width - 14.0, 0.0);
    let [before, after] = [room(x - screen.left() - left), room(screen.right() - x)];
    if before.x > 46.0 {
        label(ui, Pos2::new(x - 14.0, top), Align2::RIGHT_TOP, before, viewer.choices.picture.technique.name());
    }
    if after.x > 46.0 {
        label(ui, Pos2::new(x + 14.0, top), Align2::LEFT_TOP, after, compare.technique.name());
    }
}

/// Draws an overlay and its legend.
pub fn picture(ui: &Ui, texture: &TextureHandle, says: &str, left: f32) {
    let screen = ui.ctx().content_rect();
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    ui.painter().image(texture.id(), screen, whole, Color32::WHITE);
    legend(ui, says, left);
}

/// Draws ellipses of the slope covariance under pixels.
pub fn ellipses(ui: &Ui, covariances: &LayerPicture) {
    let (width, height) = covariances.size;
    let screen = ui.ctx().content_rect();
    let scale = Vec2::new(width as f32 / screen.width(), height as f32 / screen.height());
    let steps = |length: f32| (0..(length / ELLIPSES) as u32).map(|step| (step as f32 + 0.5) * ELLIPSES);
    for (x, y) in steps(screen.height()).flat_map(|y| steps(screen.width()).map(move |x| (x, y))) {
        let (column, row) = (((x * scale.x) as u32).min(width - 1), ((y * scale.y) as u32).min(height - 1));
        let Some(&[xx, yy, xy, _]) = covariances.values.get((row * width + column) as usize) else { continue };
        let Some([[a, b], [c, d]]) = axes(xx, yy, xy) else { continue };
        let middle = screen.min + Vec2::new(x, y);
        let points = (0..20).map(|k| {
            let (sine, cosine) = (k as f32 / 20.0 * std::f32::consts::TAU).sin_cos();
            // The y axis of slopes points up, and the y axis of the screen points down.
            middle + Vec2::new(a * cosine + c * sine, -(b * cosine + d * sine)) * ELLIPSE
        });
        ui.painter().add(Shape::closed_line(points.collect(), Stroke::new(1.2, Color32::from_rgb(255, 210, 90))));
    }
}

/// Draws the probes as shaded balls, and their legend.
pub fn balls(ui: &Ui, balls: &[Ball], left: f32) {
    let screen = ui.ctx().content_rect();
    let mut mesh = Mesh::default();
    for Ball { middle: [x, y], radius, greys } in balls {
        let middle = screen.min + Vec2::new(x * screen.width(), y * screen.height());
        let radius = (radius * screen.height()).max(1.5);
        let first = mesh.vertices.len() as u32;
        mesh.colored_vertex(middle, Color32::from_gray(greys[0]));
        for (corner, grey) in greys[1..].iter().enumerate() {
            let (sine, cosine) = (corner as f32 / SIDES as f32 * std::f32::consts::TAU).sin_cos();
            mesh.colored_vertex(middle + Vec2::new(cosine, -sine) * radius, Color32::from_gray(*grey));
            let next = (corner as u32 + 1) % SIDES as u32;
            mesh.add_triangle(first, first + 1 + corner as u32, first + 1 + next);
        }
    }
    ui.painter().add(Shape::mesh(mesh));
    let says = if balls.is_empty() { NONE } else { SAYS };
    legend(ui, says, left);
}

/// Returns the half-axes of a covariance ellipse, or `None` if the variance is 0 or not finite.
fn axes(xx: f32, yy: f32, xy: f32) -> Option<[[f32; 2]; 2]> {
    let middle = 0.5 * (xx + yy);
    let off = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    let (long, short) = ((middle + off).max(0.0).sqrt(), (middle - off).max(0.0).sqrt());
    if !(long > 1e-3 && long.is_finite()) {
        return None;
    }
    let (sine, cosine) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    Some([[long * cosine, long * sine], [-short * sine, short * cosine]])
}

/// Draws a message at the bottom of the picture.
pub fn message(ui: &Ui, text: &str, left: f32) {
    let free = free(ui, left);
    label(ui, free.center_bottom(), Align2::CENTER_BOTTOM, free.size(), text);
}

/// Shows the compiler error of a shader. Returns whether it stays open.
pub fn shader_fault(ui: &Ui, fault: &str, left: f32) -> bool {
    window(ui, "Shader error", left, |ui| {
        ui.label("The shader does not compile. The last working one is in use.");
        let text = egui::RichText::new(fault).monospace().color(Color32::from_rgb(255, 150, 130));
        ui.add(egui::Label::new(text).wrap().selectable(true));
    })
}

/// Shows the help for mouse and keys. Returns whether the help stays open.
pub fn help(ui: &Ui, left: f32) -> bool {
    window(ui, "Mouse and keys (F1)", left, |ui| {
        for (title, lines) in keys::sections() {
            ui.add_space(4.0);
            ui.strong(title);
            for (keys, text) in lines {
                ui.horizontal_top(|ui| {
                    ui.allocate_ui(Vec2::new(KEYS, 0.0), |ui| {
                        ui.set_width(KEYS);
                        ui.add(egui::Label::new(egui::RichText::new(keys).monospace()).wrap());
                    });
                    ui.add(egui::Label::new(text).wrap());
                });
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipses_follow_the_largest_variance() {
        assert_eq!(axes(0.0, 0.0, 0.0), None);
        assert_eq!(axes(f32::NAN, 0.0, 0.0), None);
        let [long, short] = axes(0.04, 0.01, 0.0).expect("an ellipse");
        assert!((long[0] - 0.2).abs() < 1e-6 && long[1].abs() < 1e-6 && (short[1] - 0.1).abs() < 1e-6);
        let [long, short] = axes(0.02, 0.02, 0.02).expect("an ellipse");
        assert!((long[0] - long[1]).abs() < 1e-6 && short[0].abs() < 1e-3);
    }
}
