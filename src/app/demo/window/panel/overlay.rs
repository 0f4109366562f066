//! Overlays on the picture: the split between two techniques, layers, messages and help.

use egui::{Align2, Color32, CursorIcon, FontId, Id, Mesh, Pos2, Rect, Shape, Stroke, TextureHandle, Ui, Vec2};

use crate::app::demo::args::keys;
use crate::app::demo::window::over::LayerPicture;
use crate::app::demo::window::probes::{Ball, NONE, SAYS, SIDES};
use crate::app::demo::window::viewer::{SPLIT_GRIP, Viewer};

/// Spacing of the covariance ellipses, points.
const ELLIPSES: f32 = 24.0;
/// Half-axis of an ellipse for a slope deviation of 1, points.
const ELLIPSE: f32 = 22.0;

/// Width of the help text, points.
const HELP: f32 = 560.0;

/// Draws text in a dark box.
fn label(ui: &Ui, at: Pos2, anchor: Align2, text: &str) {
    let galley = ui.painter().layout_no_wrap(text.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let area = anchor.anchor_size(at, galley.size()).expand2(Vec2::new(6.0, 3.0));
    ui.painter().rect_filled(area, 3.0, Color32::from_black_alpha(150));
    ui.painter().galley(area.min + Vec2::new(6.0, 3.0), galley, Color32::WHITE);
}

/// Draws the split between two techniques and their names. The window handles dragging, which therefore works at any frame rate.
pub fn split(ui: &Ui, viewer: &Viewer, left: f32) {
    let screen = ui.ctx().content_rect();
    let Some(compare) = viewer.choices.compare else { return };
    let x = screen.left() + compare.split * screen.width();
    let hovered = ui.ctx().pointer_latest_pos().is_some_and(|at| (at.x - x).abs() <= SPLIT_GRIP && at.x > left);
    if hovered || viewer.drags_split() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let strength = if hovered || viewer.drags_split() { 2.5 } else { 1.0 };
    ui.painter().vline(x, screen.y_range(), Stroke::new(strength, Color32::WHITE));
    ui.painter().circle(Pos2::new(x, screen.center().y), 7.0, Color32::WHITE, Stroke::new(1.0, Color32::BLACK));
    let top = screen.top() + 8.0;
    if x - left > 60.0 {
        label(ui, Pos2::new(x - 14.0, top), Align2::RIGHT_TOP, viewer.choices.picture.technique.name());
    }
    label(ui, Pos2::new(x + 14.0, top), Align2::LEFT_TOP, compare.technique.name());
}

/// Draws an overlay and its legend.
pub fn picture(ui: &Ui, texture: &TextureHandle, says: &str, left: f32) {
    let screen = ui.ctx().content_rect();
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    ui.painter().image(texture.id(), screen, whole, Color32::WHITE);
    label(ui, Pos2::new(screen.left() + left + 10.0, screen.bottom() - 10.0), Align2::LEFT_BOTTOM, says);
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
            // The y axis of slopes points up; that of the screen points down.
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
    label(ui, Pos2::new(screen.left() + left + 10.0, screen.bottom() - 10.0), Align2::LEFT_BOTTOM, says);
}

/// Returns the half-axes of a covariance ellipse; `None` if the variance is 0 or not finite.
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
    let screen = ui.ctx().content_rect();
    let middle = Pos2::new(0.5 * (screen.left() + left + screen.right()), screen.bottom() - 24.0);
    label(ui, middle, Align2::CENTER_BOTTOM, text);
}

/// Shows the compiler error of a shader.
pub fn shader_fault(ui: &Ui, fault: &str) {
    egui::Window::new("The shader does not compile; the last working one is in use")
        .id(Id::new("shader fault"))
        .collapsible(false)
        .anchor(Align2::CENTER_BOTTOM, Vec2::new(0.0, -40.0))
        .show(ui.ctx(), |ui| {
            let text = egui::RichText::new(fault).monospace().color(Color32::from_rgb(255, 150, 130));
            egui::ScrollArea::both().max_height(240.0).show(ui, |ui| ui.label(text));
        });
}

/// Shows the help for mouse and keys, beside the panel if there is room. Returns whether the help stays open.
pub fn help(ui: &Ui, left: f32) -> bool {
    let mut open = true;
    let screen = ui.ctx().content_rect();
    let left = if screen.width() - left < HELP { 0.0 } else { left };
    // The title, the frame and a margin need this space.
    let room = screen.size() - Vec2::new(left + 40.0, 90.0);
    egui::Window::new("Mouse and keys (F1)")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, Vec2::new(0.5 * left, 0.0))
        .show(ui.ctx(), |ui| {
            let text = egui::RichText::new(keys().trim()).monospace();
            egui::ScrollArea::both()
                .max_width(room.x)
                .max_height(room.y)
                .show(ui, |ui| ui.add(egui::Label::new(text).extend()));
        });
    open
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
