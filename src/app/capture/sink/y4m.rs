//! Writes uncompressed YUV4MPEG2 video for any encoder, with 8 bits, no subsampling (C444), and BT.709 in limited range.
//!
//! Decoders assume limited range, whether or not they support the extension `XCOLORRANGE`. The format cannot declare its colour matrix, but
//! BT.709 has the primaries of sRGB.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::Sink;
use super::comparison::TechniqueErrors;
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::save::display;
use crate::app::flags::values::Rate;
use leadr_maps::new_file::{NewFile, undivided};
use leadr_maps::origin::Origin;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::begin;

/// Writes frames to a file or to stdout.
pub struct Y4m<'a> {
    config: &'a CaptureConfig,
    /// The output file; `None` for standard output.
    file: Option<NewFile>,
    planes: Vec<u8>,
}

fn header(size: Size, rate: Rate) -> String {
    let (width, height) = (size.width, size.height);
    let (numerator, denominator) = (rate.numerator(), rate.denominator());
    format!("YUV4MPEG2 W{width} H{height} F{numerator}:{denominator} Ip A1:1 C444 XCOLORRANGE=LIMITED\n")
}

/// Converts sRGB codes to Y′CbCr.
fn limited_709(rgb: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = rgb.map(|code| f32::from(code) / 255.0);
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let (cb, cr) = ((b - y) / 1.8556, (r - y) / 1.5748);
    [16.0 + 219.0 * y, 128.0 + 224.0 * cb, 128.0 + 224.0 * cr].map(|code| code.round() as u8)
}

impl<'a> Y4m<'a> {
    pub fn begin(config: &'a CaptureConfig) -> Result<Self, AppError> {
        let file = if config.output.is_stdout() { None } else { Some(begin(&config.output.path(0))?) };
        let y4m = Self { config, file, planes: Vec::new() };
        y4m.write(header(config.scene.size, config.rate).as_bytes())?;
        Ok(y4m)
    }

    fn write(&self, bytes: &[u8]) -> Result<(), AppError> {
        if let Some(new) = &self.file {
            return (&new.file).write_all(bytes).map_err(|fault| AppError::io("write", new.target(), fault));
        }
        let mut stdout = io::stdout();
        undivided(|| stdout.write_all(bytes).and_then(|()| stdout.flush())).map_err(|fault| match fault.kind() {
            ErrorKind::BrokenPipe => {
                AppError::Failed("the program that reads standard output closed it before the last frame".to_owned())
            }
            _ => AppError::Failed(format!("cannot write to standard output: {fault}")),
        })
    }
}

impl Sink for Y4m<'_> {
    fn put(&mut self, _file: &Path, frame: &Frame, _: &Origin) -> Result<(), AppError> {
        const FRAME: &[u8] = b"FRAME\n";
        let picture = display(frame, &self.config.scene.picture);
        let pixels = picture.texels.len();
        self.planes.clear();
        self.planes.extend_from_slice(FRAME);
        self.planes.resize(FRAME.len() + 3 * pixels, 0);
        for (index, &rgb) in picture.texels.iter().enumerate() {
            for (plane, code) in limited_709(rgb).into_iter().enumerate() {
                self.planes[FRAME.len() + plane * pixels + index] = code;
            }
        }
        self.write(&self.planes)
    }

    fn finish(self: Box<Self>) -> Result<Vec<TechniqueErrors>, AppError> {
        self.file.map_or(Ok(()), NewFile::finish)?;
        Ok(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::tests::{Double, configure, files, run};

    #[test]
    fn known_colours() {
        assert_eq!(limited_709([0; 3]), [16, 128, 128]);
        assert_eq!(limited_709([255; 3]), [235, 128, 128]);
        // The primaries at full intensity are from ITU-R BT.709-6, table 3.
        assert_eq!(limited_709([255, 0, 0]), [63, 102, 240]);
        assert_eq!(limited_709([0, 255, 0]), [173, 42, 26]);
        assert_eq!(limited_709([0, 0, 255]), [32, 240, 118]);
    }

    /// The inverse of [`limited_709`].
    fn rgb([y, cb, cr]: [u8; 3]) -> [f32; 3] {
        let (y, cb, cr) =
            ((f32::from(y) - 16.0) / 219.0, (f32::from(cb) - 128.0) / 224.0, (f32::from(cr) - 128.0) / 224.0);
        let (r, b) = (y + 1.5748 * cr, y + 1.8556 * cb);
        [r, (y - 0.2126 * r - 0.0722 * b) / 0.7152, b].map(|v| 255.0 * v)
    }

    #[test]
    fn video_has_header_and_complete_frames() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.y4m", &["--frames", "2..6", "--fps", "30000/1001"]);
        run(&config, &mut Double::new(&config)).unwrap();
        assert_eq!(files(folder.path()), ["a.y4m"]);
        let bytes = std::fs::read(config.output.path(0)).unwrap();
        let header = b"YUV4MPEG2 W5 H3 F30000:1001 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
        let frames = bytes.strip_prefix(header).unwrap();
        assert_eq!(frames.len(), 4 * (6 + 45));
        let mut double = Double::new(&config);
        for (frame, moment) in frames.chunks(6 + 45).zip(config.timeline.moments()) {
            let planes = frame.strip_prefix(b"FRAME\n").unwrap();
            let picture = display(&double.render(moment, &mut |_| ()).unwrap(), &config.scene.picture);
            for (index, texel) in picture.texels.iter().enumerate() {
                let seen = rgb([planes[index], planes[15 + index], planes[30 + index]]);
                // Luma and chroma each have a rounding error of at most half a code.
                let off = (0..3).map(|c| (seen[c] - f32::from(texel[c])).abs()).fold(0.0, f32::max);
                assert!(off < 2.0, "{texel:?} {seen:?}");
            }
        }
    }

    #[test]
    fn failed_video_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.y4m", &["--frames", "0..5"]);
        run(&config, &mut Double { fail_at: Some(3), ..Double::new(&config) }).unwrap_err();
        assert!(files(folder.path()).is_empty());
    }
}
