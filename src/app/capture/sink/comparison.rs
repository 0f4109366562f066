//! A contact sheet of techniques in one PNG: a column per technique and a row per frame, with labels and images of the FLIP error.

use std::path::Path;

use serde::Serialize;

use super::Sink;
use super::labels::{CHARACTER, LINE, write_lines};
use super::sheet::{GUTTER_COLOR, place};
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::frames::Moment;
use crate::app::capture::pattern::{GUTTER, within_limits};
use crate::app::capture::save::{display, display_factor};
use leadr_maps::new_file::NewFile;
use leadr_maps::origin::Origin;
use leadr_maps::save::encode_png_srgb8;
use leadr_maps::{Rgb8Image, RgbImage};
use leadr_render::settings::Technique;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::begin;
use leadr_tools::metrics::compare::{Comparison, compare};

/// Lines of text above each picture: technique, FLIP, relative RMSE, device time.
const LINES: u32 = 4;

/// The space around text, pixels, before magnification.
const PADDING: u32 = 4;

/// The measured difference of a technique from the one that it is compared with, in one frame.
#[derive(Clone, Debug, Serialize)]
pub struct TechniqueErrors {
    frame: u32,
    technique: &'static str,
    against: &'static str,
    flip: f64,
    /// Null (infinite) if only the other picture is black.
    rrmse: f64,
    max_abs: f64,
}

/// Collects the pictures of a row, measures them, and writes the sheet at the end.
pub struct ComparisonSheet<'a> {
    config: &'a CaptureConfig,
    file: NewFile,
    whole: Rgb8Image,
    row: Vec<Frame>,
    moments: Vec<Moment>,
    errors: Vec<TechniqueErrors>,
}

/// Returns the magnification of the labels for pictures of this width.
fn label_scale(cell: Size) -> u32 {
    (cell.width / (60 * CHARACTER)).max(1)
}

/// Returns the height of the labels above a picture.
fn label_height(cell: Size) -> u32 {
    (LINES * LINE + 2 * PADDING) * label_scale(cell)
}

/// Returns the height of a row: labels, picture, gutter, error image.
fn row_height(cell: Size) -> u32 {
    label_height(cell) + 2 * cell.height + GUTTER
}

/// Returns the size of the sheet, or an error if it is over the limits.
pub fn sheet_size(techniques: usize, frames: usize, cell: Size) -> Result<Size, String> {
    let side = |count: usize, length: u32| (count as u32).saturating_mul(length + GUTTER) - GUTTER;
    let whole = Size { width: side(techniques, cell.width), height: side(frames, row_height(cell)) };
    within_limits(whole, &format!("a sheet of {techniques} --techniques in {frames} frames of {cell}"))
}

/// Returns the number of the technique that the others are compared with: the reference, or else the first.
fn baseline(techniques: &[Technique]) -> usize {
    techniques.iter().position(|technique| technique.is_reference()).unwrap_or(0)
}

/// Returns the sum of the device times of all passes, milliseconds.
fn device_time(frame: &Frame) -> f64 {
    frame.passes.iter().map(|pass| pass.ms).sum()
}

/// Formats the time of a single run with three significant digits, in milliseconds or, from one second, in seconds.
fn one_run(ms: f64) -> String {
    // The exponential format rounds to significant digits.
    let ms = format!("{ms:.2e}").parse().unwrap_or(ms);
    let (value, unit) = if ms < 1000.0 { (ms, "ms") } else { (ms / 1000.0, "s") };
    let digits = [100.0, 10.0, 1.0].into_iter().filter(|power| value < *power).count();
    format!("{value:.digits$} {unit}, one run")
}

/// Returns where a row stands in the sequence; empty for a still.
fn place_in_sequence(config: &CaptureConfig, moment: Moment) -> String {
    match (moment.distance, config.timeline.moments().len()) {
        (_, 1) => String::new(),
        (Some(metres), _) => format!(", {metres:.1} m"),
        _ => format!(", frame {}", moment.frame),
    }
}

impl<'a> ComparisonSheet<'a> {
    pub fn begin(config: &'a CaptureConfig) -> Result<Self, AppError> {
        let moments = config.moments();
        let techniques = config.techniques.len();
        let size = sheet_size(techniques, moments.len() / techniques, config.scene.size);
        let Size { width, height } = size.map_err(AppError::Usage)?;
        let whole = Rgb8Image { width, height, texels: vec![GUTTER_COLOR; width as usize * height as usize] };
        let file = begin(&config.output.path(0))?;
        Ok(Self { config, file, whole, row: Vec::new(), moments, errors: Vec::new() })
    }

    /// Measures the collected pictures and draws them into the next row of the sheet.
    fn draw_row(&mut self) -> Result<(), AppError> {
        let (cell, picture, techniques) = (self.config.scene.size, &self.config.scene.picture, &self.config.techniques);
        let done = self.errors.len() / (techniques.len() - 1);
        let moment = self.moments[done * techniques.len()];
        let top = done as u32 * (row_height(cell) + GUTTER);
        let scale = label_scale(cell);
        let under = top + label_height(cell);
        let padding = PADDING * scale;
        let width = cell.width.saturating_sub(2 * padding);
        let base = baseline(techniques);
        let factor = display_factor(&self.row[base], picture);
        let linear = |frame: &Frame| {
            let texels = frame.color.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            RgbImage { width: frame.width, height: frame.height, texels }
        };
        let truth = linear(&self.row[base]);
        for (column, (frame, technique)) in self.row.iter().zip(techniques).enumerate() {
            let left = column as u32 * (cell.width + GUTTER);
            let mut lines = vec![format!("{}{}", technique.name(), place_in_sequence(self.config, moment))];
            place(&mut self.whole, [left, under], &display(frame, picture));
            let below = [left, under + cell.height + GUTTER];
            if column == base {
                lines.extend(["others are".to_owned(), "against this".to_owned()]);
                let legend = ["FLIP error:", "black 0", "yellow 1"].map(str::to_owned);
                let fitting = (cell.height.saturating_sub(2 * padding) / (LINE * scale)).min(3) as usize;
                write_lines(&mut self.whole, below.map(|side| side + padding), width, scale, &legend[..fitting]);
            } else {
                let found: Comparison = compare(&truth, &linear(frame), factor, picture.tonemap)
                    .map_err(|fault| fault.in_file(self.file.target()))?;
                lines.extend([format!("FLIP {:.4}", found.flip), format!("rRMSE {:.4}", found.rrmse)]);
                place(&mut self.whole, below, &found.error_image());
                self.errors.push(TechniqueErrors {
                    frame: moment.frame,
                    technique: technique.name(),
                    against: techniques[base].name(),
                    flip: found.flip,
                    rrmse: found.rrmse,
                    max_abs: found.max_abs,
                });
            }
            lines.push(one_run(device_time(frame)));
            write_lines(&mut self.whole, [left + padding, top + padding], width, scale, &lines);
        }
        self.row.clear();
        Ok(())
    }
}

impl Sink for ComparisonSheet<'_> {
    fn put(&mut self, _file: &Path, frame: &Frame, _: &Origin) -> Result<(), AppError> {
        self.row.push(frame.clone());
        if self.row.len() == self.config.techniques.len() { self.draw_row() } else { Ok(()) }
    }

    fn finish(self: Box<Self>) -> Result<Vec<TechniqueErrors>, AppError> {
        let bytes = encode_png_srgb8(&self.whole).map_err(|fault| fault.in_file(self.file.target()))?;
        self.file.write(&bytes)?;
        Ok(self.errors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::args::tests::resolve;
    use crate::app::capture::tests::{Double, files, run};
    use leadr_maps::load_color_srgb8;

    #[test]
    fn techniques_stand_side_by_side_with_their_errors() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.png");
        let flags = ["--size", "24x30", "--techniques", "lean,reference,constant", "--frames", "0..2", "-o"];
        let config = resolve(&[&flags[..], &[file.to_str().unwrap()]].concat()).unwrap();
        let report = run(&config, &mut Double::new(&config)).unwrap();
        assert_eq!(files(folder.path()), ["a.png"]);
        assert_eq!(report["settings"]["techniques"], serde_json::json!(["lean", "reference", "constant"]));
        let drawn: Vec<_> = (0..6).map(|i| report["frames"][i]["technique"].as_str().unwrap()).collect();
        assert_eq!(drawn, ["lean", "reference", "constant", "lean", "reference", "constant"]);
        let errors = report["errors"].as_array().unwrap();
        assert_eq!(
            (errors.len(), &errors[0]["technique"], &errors[0]["against"]),
            (4, &"lean".into(), &"reference".into())
        );
        // The double draws each technique brighter than the one before.
        assert!(errors.iter().all(|error| error["flip"].as_f64().unwrap() > 0.0), "{errors:?}");
        let sheet = load_color_srgb8(config.output.path(0)).unwrap();
        let label = LINES * LINE + 2 * PADDING;
        assert_eq!([sheet.width, sheet.height], [3 * 24 + 2 * 4, 2 * (label + 64) + 4]);
        let texel = |x: u32, y: u32| sheet.texels[(y * sheet.width + x) as usize];
        for (index, moment) in config.moments().into_iter().enumerate() {
            let frame = Double::new(&config).render(moment, &mut |_| ()).unwrap();
            let (left, top) = (28 * (index as u32 % 3), (label + 68) * (index as u32 / 3));
            let words = (0..label * 24).any(|i| texel(left + i % 24, top + i / 24) != GUTTER_COLOR);
            assert!(words, "picture {index} has a label");
            let margin = |i: u32| i % 24 < PADDING || i % 24 >= 24 - PADDING || i / 24 < PADDING;
            let edge = (0..label * 24).filter(|&i| margin(i)).map(|i| texel(left + i % 24, top + i / 24));
            assert!(
                edge.into_iter().all(|texel| texel == GUTTER_COLOR),
                "the label of picture {index} touches the edge"
            );
            for (i, &expected) in (0..).zip(&display(&frame, &config.scene.picture).texels) {
                assert_eq!(texel(left + i % 24, top + label + i / 24), expected, "picture {index}");
            }
            let below = texel(left, top + label + 33);
            assert!(index % 3 == 1 || below == GUTTER_COLOR, "the gutter is between picture and error");
        }
    }

    #[test]
    fn times_have_three_digits() {
        let texts = [0.1234, 1.5, 9.996, 45.678, 234.4, 1851.0, 240_929.0].map(one_run);
        let expected = ["0.123 ms", "1.50 ms", "10.0 ms", "45.7 ms", "234 ms", "1.85 s", "241 s"];
        assert_eq!(texts, expected.map(|time| format!("{time}, one run")));
    }

    #[test]
    fn a_lone_or_repeated_technique_is_refused() {
        let size = sheet_size(3, 1000, Size { width: 1920, height: 1080 });
        assert!(size.unwrap_err().contains("--techniques"));
        for list in ["leadr", "leadr,lean,leadr"] {
            let fault = resolve(&["--techniques", list]).unwrap_err().to_string();
            assert!(fault.contains("two or more different"), "{fault}");
        }
        for flags in [["--technique", "lean"], ["--beside", "lean"], ["-o", "a.exr"], ["-o", "a-{frame}.png"]] {
            let fault = resolve(&[&["--techniques", "leadr,lean"], &flags[..]].concat()).expect_err(flags[1]);
            assert_eq!(fault.exit_code(), 2);
        }
    }
}
