//! A contact sheet, which is a single PNG with rows of frames.

use std::path::Path;

use super::Sink;
use super::comparison::TechniqueErrors;
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::pattern::{GUTTER, whole_size};
use crate::app::capture::save::display;
use crate::app::flags::values::Sheet;
use leadr_maps::Rgb8Image;
use leadr_maps::new_file::NewFile;
use leadr_maps::origin::Origin;
use leadr_maps::save::encode_png_srgb8;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::begin;

/// Gutter colour in sRGB, dark but lighter than night scenes.
pub const GUTTER_COLOR: [u8; 3] = [32; 3];

/// Collects the pictures of a sheet and writes it at the end.
pub struct ContactSheet<'a> {
    config: &'a CaptureConfig,
    sheet: Sheet,
    file: NewFile,
    whole: Rgb8Image,
    count: u32,
}

impl<'a> ContactSheet<'a> {
    pub fn begin(config: &'a CaptureConfig, sheet: Sheet) -> Result<Self, AppError> {
        let Size { width, height } = whole_size(sheet, config.scene.size).map_err(AppError::Usage)?;
        let file = begin(&config.output.path(0))?;
        let whole = Rgb8Image { width, height, texels: vec![GUTTER_COLOR; width as usize * height as usize] };
        Ok(Self { config, sheet, file, whole, count: 0 })
    }
}

impl Sink for ContactSheet<'_> {
    fn put(&mut self, _file: &Path, frame: &Frame, _: &Origin) -> Result<(), AppError> {
        let (column, row) = (self.count % self.sheet.columns, self.count / self.sheet.columns);
        self.count += 1;
        let cell = self.config.scene.size;
        let corner = [column * (cell.width + GUTTER), row * (cell.height + GUTTER)];
        place(&mut self.whole, corner, &display(frame, &self.config.scene.picture));
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Vec<TechniqueErrors>, AppError> {
        let bytes = encode_png_srgb8(&self.whole).map_err(|fault| fault.in_file(self.file.target()))?;
        self.file.write(&bytes)?;
        Ok(Vec::new())
    }
}

/// Copies a picture into a larger one, with its top left corner at `corner`.
pub fn place(whole: &mut Rgb8Image, corner: [u32; 2], picture: &Rgb8Image) {
    let [x, y] = corner.map(|side| side as usize);
    let width = picture.width as usize;
    let rows = whole.texels.chunks_mut(whole.width as usize).skip(y);
    for (to, from) in rows.zip(picture.texels.chunks(width)) {
        to[x..x + width].copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::tests::{Double, configure, files, run};
    use leadr_maps::load_color_srgb8;

    #[test]
    fn pictures_stand_in_their_cells() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.png", &["--frames", "3..15", "--sheet", "3x2"]);
        let report = run(&config, &mut Double::new(&config)).unwrap();
        let numbers: Vec<_> = (0..6).map(|i| report["frames"][i]["frame"].as_u64().unwrap()).collect();
        assert_eq!(numbers, [3, 5, 7, 9, 11, 13]);
        assert_eq!(report["settings"]["output"]["kind"]["sheet"]["columns"], 3);
        assert_eq!(files(folder.path()), ["a.png"]);
        let sheet = load_color_srgb8(config.output.path(0)).unwrap();
        assert_eq!((sheet.width, sheet.height), (3 * 5 + 2 * 4, 2 * 3 + 4));
        let texel = |x: u32, y: u32| sheet.texels[(y * sheet.width + x) as usize];
        let mut covered = 0;
        for (index, moment) in config.moments().into_iter().enumerate() {
            let picture = display(&Double::new(&config).render(moment, &mut |_| ()).unwrap(), &config.scene.picture);
            let (left, top) = (9 * (index as u32 % 3), 7 * (index as u32 / 3));
            for (i, &expected) in picture.texels.iter().enumerate() {
                assert_eq!(texel(left + i as u32 % 5, top + i as u32 / 5), expected, "picture {index}");
                covered += 1;
            }
        }
        let gutters = sheet.texels.iter().filter(|&&texel| texel == GUTTER_COLOR).count();
        assert_eq!(covered + gutters, sheet.texels.len());
    }

    #[test]
    fn failed_sheet_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.png", &["--frames", "0..4", "--sheet", "2x2"]);
        run(&config, &mut Double { fail_at: Some(2), ..Double::new(&config) }).unwrap_err();
        assert!(files(folder.path()).is_empty());
    }

    #[test]
    fn sheets_that_are_too_large_are_refused() {
        let sheet = Sheet { columns: 1000, rows: 1000 };
        let largest = Size { width: Size::MAX_SIDE, height: 4096 };
        let fault = whole_size(sheet, largest).unwrap_err();
        assert!(fault.contains("--size"), "{fault}");
        let small = whole_size(Sheet { columns: 4, rows: 3 }, Size { width: 320, height: 180 });
        assert_eq!(small, Ok(Size { width: 1292, height: 548 }));
    }
}
