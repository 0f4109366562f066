//! The cost section: frame rate, samples, triangles and pass times.

use std::collections::VecDeque;

use egui::{Color32, Pos2, Rect, Sense, Ui, Vec2};

use super::controls::{Sections, section};
use super::facts::{Facts, HISTORY};

/// Height of the frame time graph, points.
const GRAPH: f32 = 36.0;
/// Minimum time of a listed pass, milliseconds.
const LEAST: f64 = 0.05;

/// Shows frames per second, a graph of recent frames, and the milliseconds of each pass.
pub fn show(ui: &mut Ui, facts: &Facts<'_>, milliseconds: &VecDeque<f32>, sections: &mut Sections) {
    section(ui, "Cost", true, sections, |ui| {
        let rate = facts.fps.map(|fps| format!("{fps:.1} frames per second, ")).unwrap_or_default();
        ui.label(format!("{rate}{} x {}", facts.pixels.0, facts.pixels.1));
        ui.label(format!("sample {} of {}", facts.samples.0, facts.samples.1));
        ui.label(format!("{} patches", grouped(facts.triangles.1.into())));
        ui.label(format!("up to {} triangles", grouped(facts.triangles.0)));
        graph(ui, milliseconds);
        let whole: f64 = facts.passes.iter().map(|(_, time)| time).sum();
        egui::Grid::new("passes").num_columns(2).spacing([12.0, 1.0]).show(ui, |ui| {
            for (pass, time) in facts.passes.iter().filter(|(_, time)| *time >= LEAST) {
                ui.small(pass);
                ui.small(format!("{time:.2} ms"));
                ui.end_row();
            }
            ui.small("all passes");
            ui.small(format!("{:.2} ms", whole.max(0.0)));
            ui.end_row();
        });
        ui.weak(facts.device);
    });
}

/// Draws the times of recent frames as bars, scaled to the longest time.
fn graph(ui: &mut Ui, milliseconds: &VecDeque<f32>) {
    let size = Vec2::new(ui.available_width(), GRAPH);
    let (area, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(90));
    let Some(most) = milliseconds.iter().copied().max_by(f32::total_cmp).filter(|most| *most > 0.0) else { return };
    let step = area.width() / HISTORY as f32;
    for (index, time) in milliseconds.iter().enumerate() {
        let left = area.left() + step * index as f32;
        let top = area.bottom() - (GRAPH - 10.0) * time / most;
        let bar = Rect::from_min_max(Pos2::new(left, top), Pos2::new(left + 0.8 * step, area.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(120, 180, 110));
    }
    let font = egui::FontId::proportional(9.0);
    let text = format!("{most:.0} ms");
    painter.text(area.left_top() + Vec2::new(3.0, 1.0), egui::Align2::LEFT_TOP, text, font, Color32::LIGHT_GRAY);
}

/// Formats 1234567 as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_set_apart() {
        assert_eq!([0, 999, 1000, 1_234_567].map(super::grouped), ["0", "999", "1,000", "1,234,567"]);
    }
}
