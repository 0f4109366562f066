//! The file names and formats of a capture.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

use super::frames::Timeline;
use crate::app::flags::values::Sheet;
use leadr_maps::shown::shown_path;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::extension;

/// The width of the gap between the pictures of a sheet, in pixels.
pub const GUTTER: u32 = 4;

/// Returns the size of a sheet whose pictures have the size `cell`, or an error if it exceeds the limits.
pub fn whole_size(sheet: Sheet, cell: Size) -> Result<Size, String> {
    // A side has at most 1000 pictures of 2¹⁴ pixels plus gaps, so it cannot overflow.
    let side = |count: u32, length: u32| count * length + (count - 1) * GUTTER;
    let whole = Size { width: side(sheet.columns, cell.width), height: side(sheet.rows, cell.height) };
    within_limits(whole, &format!("a --sheet of {}x{} pictures of {cell}", sheet.columns, sheet.rows))
}

/// Returns the size of a file with several pictures, or an error about `what` if it is over the limits.
pub fn within_limits(whole: Size, what: &str) -> Result<Size, String> {
    let (most_side, most_pixels) = (Size::MAX_SIDE, Size::MAX_PIXELS);
    if whole.width.max(whole.height) > most_side || u64::from(whole.width) * u64::from(whole.height) > most_pixels {
        return Err(format!(
            "{what} has {whole} pixels, over the limit of {most_side} per side or {most_pixels} in total: choose a smaller \
             --size or fewer pictures"
        ));
    }
    Ok(whole)
}

/// The file format of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum FileKind {
    /// One file per frame.
    Still(StillKind),
    /// One file for all frames.
    Moving(MovingKind),
    /// One PNG in which several techniques are compared.
    #[serde(serialize_with = "comparison")]
    Comparison,
    /// One PNG with several frames side by side.
    Sheet {
        /// The number of columns and rows.
        sheet: Sheet,
    },
}

/// Serializes the format of a comparison; an untagged unit variant would be null.
fn comparison<S: Serializer>(serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str("comparison")
}

/// The format of a still frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StillKind {
    /// A PNG file with 8-bit tonemapped sRGB.
    Png,
    /// An EXR file with linear radiance and layers as 32-bit floats.
    Exr,
}

/// The format of an animation. All formats store 8-bit tonemapped sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MovingKind {
    /// Lossless animated WebP.
    Webp,
    /// A YUV4MPEG2 video, uncompressed, for encoders.
    Y4m,
}

impl MovingKind {
    /// Returns the supported frames per second.
    pub fn rates(self) -> RangeInclusive<f64> {
        match self {
            // The lower limit keeps delays within 16 bits of milliseconds. Viewers replace delays of at most 10 ms by 100 ms, which the
            // upper limit avoids.
            Self::Webp => 0.02..=90.0,
            Self::Y4m => 0.0..=f64::INFINITY,
        }
    }
}

/// A path in which `{frame}` stands for the frame number with at least four digits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OutputPattern {
    pattern: PathBuf,
    /// The output format that the extension of the path selects.
    pub kind: FileKind,
}

/// The placeholder of the frame number in a path.
pub const FRAME: &str = "{frame}";

/// The path that means standard output.
const STDOUT: &str = "-";

impl OutputPattern {
    /// Checks that a pattern suits the timeline. `together` is the kind of a PNG that shows all pictures, if they are in one.
    pub fn new(path: &Path, timeline: &Timeline, together: Option<FileKind>) -> Result<Self, AppError> {
        let shown = shown_path(path);
        let refuse = |what: String| Err(AppError::Usage(format!("output '{shown}' {what}")));
        let kind = match extension(path).as_deref() {
            Some("png") => together.unwrap_or(FileKind::Still(StillKind::Png)),
            _ if together.is_some() => return refuse("must end in .png for --sheet or --techniques".into()),
            Some("exr") => FileKind::Still(StillKind::Exr),
            Some("webp") => FileKind::Moving(MovingKind::Webp),
            Some("y4m") => FileKind::Moving(MovingKind::Y4m),
            None if path == Path::new(STDOUT) => FileKind::Moving(MovingKind::Y4m),
            Some("gif" | "apng") => {
                return refuse(format!(
                    "is not supported: write a .webp, stills such as '{FRAME}.png', or a .y4m for an encoder such as \
                     ffmpeg"
                ));
            }
            _ => return refuse("must end in .png or .exr, or in .webp or .y4m for an animation".into()),
        };
        if let Some(odd) = path.to_str().and_then(odd_placeholder) {
            return refuse(format!("has {odd}, but only {FRAME} is a placeholder: correct it"));
        }
        if path.to_str().is_none()
            && matches!(timeline, Timeline::Sequence { .. })
            && matches!(kind, FileKind::Still(_))
        {
            return refuse("is not UTF-8, so it can have no {frame}: choose another name for many frames".into());
        }
        let numbered = path.to_str().is_some_and(|text| text.contains(FRAME));
        match (kind, timeline) {
            (FileKind::Moving(_), Timeline::Still { .. }) => refuse("is an animation: add --frames".into()),
            (FileKind::Moving(_) | FileKind::Sheet { .. } | FileKind::Comparison, _) if numbered => {
                refuse(format!("holds all frames in one file: leave {FRAME} out"))
            }
            (FileKind::Still(_), Timeline::Sequence { .. }) if !numbered => {
                refuse(format!("names one file for many frames: put {FRAME} where the number goes"))
            }
            (FileKind::Still(_), Timeline::Still { .. }) if numbered => {
                refuse(format!("has {FRAME}: add --frames, or leave {FRAME} out"))
            }
            _ => Ok(Self { pattern: path.to_owned(), kind }),
        }
    }

    /// Whether the output is a video on standard output.
    pub fn is_stdout(&self) -> bool {
        self.pattern == Path::new(STDOUT)
    }

    /// Returns the path of a frame's file.
    pub fn path(&self, frame: u32) -> PathBuf {
        // A path that is not UTF-8 cannot contain `{frame}` (see `new`).
        match self.pattern.to_str() {
            Some(text) => text.replace(FRAME, &format!("{frame:04}")).into(),
            None => self.pattern.clone(),
        }
    }
}

/// Returns the first word in braces other than [`FRAME`], which is probably a misspelt placeholder.
fn odd_placeholder(text: &str) -> Option<&str> {
    let mut words = text.match_indices('{').filter_map(|(start, _)| {
        let word = &text[start..=start + text[start..].find('}')?];
        let name = &word[1..word.len() - 1];
        (!name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphabetic())).then_some(word)
    });
    words.find(|word| *word != FRAME)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::frames::tests::sequence;

    #[test]
    fn names() {
        let walk = OutputPattern::new(Path::new("out/w-{frame}.png"), &sequence(0, 9, None), None).unwrap();
        assert_eq!((walk.path(7), walk.path(12345)), ("out/w-0007.png".into(), "out/w-12345.png".into()));
        let still = OutputPattern::new(Path::new("a.EXR"), &Timeline::Still { time: 0.0 }, None).unwrap();
        assert_eq!((still.path(0), still.kind), ("a.EXR".into(), FileKind::Still(StillKind::Exr)));
        let moving = OutputPattern::new(Path::new("walk.WEBP"), &sequence(0, 9, None), None).unwrap();
        assert_eq!((moving.path(7), moving.kind), ("walk.WEBP".into(), FileKind::Moving(MovingKind::Webp)));
        let piped = OutputPattern::new(Path::new("-"), &sequence(0, 9, None), None).unwrap();
        assert_eq!((piped.is_stdout(), piped.kind), (true, FileKind::Moving(MovingKind::Y4m)));
        assert_eq!(serde_json::to_value(moving.kind).unwrap(), "webp");
    }

    #[test]
    fn patterns_that_cannot_work_are_refused() {
        let still = Timeline::Still { time: 0.0 };
        assert!(OutputPattern::new(Path::new("a.png"), &sequence(0, 9, None), None).is_err());
        assert!(OutputPattern::new(Path::new("a-{frame}.webp"), &sequence(0, 9, None), None).is_err());
        for name in ["a-{frame}.png", "a.jpg", "a", "a.webp", "a.y4m", "-"] {
            assert!(OutputPattern::new(Path::new(name), &still, None).is_err(), "{name}");
        }
        for name in ["a-{fame}.png", "a-{Frame}-{frame}.png", "{scene}/{frame}.png"] {
            let fault = OutputPattern::new(Path::new(name), &sequence(0, 9, None), None).unwrap_err().to_string();
            assert!(fault.contains("only {frame}"), "{name}: {fault}");
        }
        for name in ["a.gif", "a.APNG"] {
            let fault = OutputPattern::new(Path::new(name), &sequence(0, 9, None), None).unwrap_err().to_string();
            assert!([".webp", "'{frame}.png'", ".y4m"].iter().all(|other| fault.contains(other)), "{fault}");
        }
        for name in ["{}-{frame}.png", "{1}/{frame}.png", "{{frame}}.png", "}{frame}{.png"] {
            assert!(OutputPattern::new(Path::new(name), &sequence(0, 9, None), None).is_ok(), "{name}");
        }
        let sheet = Some(FileKind::Sheet { sheet: Sheet { columns: 2, rows: 2 } });
        assert!(OutputPattern::new(Path::new("a.png"), &sequence(0, 9, None), sheet).is_ok());
        for name in ["a.exr", "a.webp", "-", "a-{frame}.png"] {
            assert!(OutputPattern::new(Path::new(name), &sequence(0, 9, None), sheet).is_err(), "{name}");
        }
    }
}
