//! The cost section: frame rate, samples, triangles and pass times.

use std::collections::VecDeque;

use egui::{Color32, Pos2, Rect, Sense, Ui, Vec2};

use super::controls::{Sections, section};
use super::facts::{Facts, HISTORY};

/// The height of the frame time graph in points.
const GRAPH: f32 = 36.0;
/// The shortest time of a pass that is listed, in milliseconds.
const LEAST: f64 = 0.05;

/// Shows the frames per second, a graph of recent frames, and the milliseconds of each pass.
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

/// Share of the frames that the graph shows at full length. Longer frames, such as those that create pipelines, are clipped.
const SHARE: f64 = 0.95;

/// Returns the time at the top of the graph, and the longest time if it is clipped, in milliseconds; `None` without frames.
fn scale(milliseconds: &VecDeque<f32>) -> Option<(f32, Option<f32>)> {
    let mut sorted: Vec<f32> = milliseconds.iter().copied().collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let longest = *sorted.last()?;
    let most = sorted[(SHARE * (sorted.len() - 1) as f64) as usize];
    (most > 0.0).then_some((most, (longest > CLIPPED * most).then_some(longest)))
}

/// Ratio to the time at the top of the graph above which a bar is marked as clipped.
const CLIPPED: f32 = 1.35;

/// Draws the times of recent frames as bars. A bar that is clipped at the top edge is red.
fn graph(ui: &mut Ui, milliseconds: &VecDeque<f32>) {
    let size = Vec2::new(ui.available_width(), GRAPH);
    let (area, response) = ui.allocate_exact_size(size, Sense::hover());
    response.on_hover_text(format!("Times of the last {HISTORY} frames; a red bar is longer than the graph"));
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(90));
    let Some((most, longest)) = scale(milliseconds) else { return };
    let step = area.width() / HISTORY as f32;
    for (index, time) in milliseconds.iter().enumerate() {
        let left = area.left() + step * index as f32;
        let clipped = *time > CLIPPED * most;
        let height = if clipped { GRAPH } else { (GRAPH - 10.0) * time / most };
        let bar =
            Rect::from_min_max(Pos2::new(left, area.bottom() - height), Pos2::new(left + 0.8 * step, area.bottom()));
        let color = if clipped { Color32::from_rgb(220, 90, 80) } else { Color32::from_rgb(120, 180, 110) };
        painter.rect_filled(bar, 0.0, color);
    }
    let font = egui::FontId::proportional(9.0);
    let text = match longest {
        Some(longest) => format!("{most:.0} ms; longest {longest:.0} ms"),
        None => format!("{most:.0} ms"),
    };
    painter.text(area.left_top() + Vec2::new(3.0, 1.0), egui::Align2::LEFT_TOP, text, font, Color32::LIGHT_GRAY);
}

/// Formats a number with commas between groups of digits, such as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_frame_does_not_flatten_the_graph() {
        let times = |times: &[f32]| scale(&times.iter().copied().collect());
        assert_eq!(times(&[]), None);
        assert_eq!(times(&[0.0]), None);
        assert_eq!(times(&[20.0]), Some((20.0, None)));
        // The first frame creates pipelines.
        for frames in 2..=HISTORY {
            let mut all = vec![20.0; frames];
            all[0] = 900.0;
            assert_eq!(times(&all), Some((20.0, Some(900.0))), "{frames} frames");
        }
        // Even frames use the full height.
        let even: Vec<f32> = (0..HISTORY).map(|i| 20.0 + (i % 5) as f32).collect();
        assert_eq!(times(&even), Some((24.0, None)));
    }

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }
}
