//! Screenshots: the whole picture of the window, without the panel and its offset.

use std::path::PathBuf;

use super::Session;
use leadr_maps::Rgb8Image;
use leadr_maps::save::save_png_srgb8;
use leadr_maps::shown::shown_path;
use leadr_tools::command::error::AppError;

impl Session<'_> {
    /// Requests a screenshot. A picture beside the panel is drawn again without its offset, which a message announces first.
    pub(super) fn request_screenshot(&mut self) {
        self.screenshot_in = Some(if self.viewer.shift() == 0.0 { 0 } else { 2 });
        self.save_screenshot();
    }

    /// Saves a requested screenshot when its message is on the screen.
    pub(super) fn save_screenshot(&mut self) {
        match self.screenshot_in {
            None => return,
            Some(0) => self.screenshot_in = None,
            Some(frames) => {
                self.screenshot_in = Some(frames - 1);
                return self.window.request_redraw();
            }
        }
        // An error such as a full disk must not close the window.
        if let Err(error) = self.screenshot() {
            self.complain(&error);
            self.lost.get_or_insert(error);
        }
    }

    fn screenshot(&mut self) -> Result<(), AppError> {
        let pictures = if self.viewer.shift() == 0.0 {
            self.painter.pictures()?
        } else {
            self.viewer.invalidate();
            self.painter.centred_pictures()?
        };
        let pictures: Vec<Rgb8Image> = pictures
            .iter()
            .map(|picture| self.viewer.choices.picture.codes(picture.width, &picture.texels, self.exposure))
            .collect();
        let split = self.viewer.choices.compare.map_or(1.0, |compare| compare.split);
        let Some(picture) = side_by_side(pictures, split) else { return Ok(()) };
        let stem = self.options.screenshots.as_os_str();
        let path = |number: u32| {
            let mut name = stem.to_owned();
            name.push(format!("-{number}.png"));
            PathBuf::from(name)
        };
        let path = (1..).map(path).find(|path| !path.exists()).unwrap_or_default();
        save_png_srgb8(&path, &picture)?;
        tracing::info!("saved {}", shown_path(&path));
        self.panel.say(format!("saved {}", shown_path(&path)));
        self.report.screenshots.push(path);
        Ok(())
    }
}

/// Combines the left side of the first picture with the right side of the second, if there is one.
fn side_by_side(pictures: Vec<Rgb8Image>, split: f32) -> Option<Rgb8Image> {
    let mut pictures = pictures.into_iter();
    let (mut left, right) = (pictures.next()?, pictures.next());
    if let Some(right) = right.filter(|right| (right.width, right.height) == (left.width, left.height)) {
        let width = left.width as usize;
        for (index, texel) in left.texels.iter_mut().enumerate() {
            if (index % width) as f32 + 0.5 >= split * width as f32 {
                *texel = right.texels[index];
            }
        }
    }
    Some(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_screenshot_shows_both_sides() {
        let picture = |code: u8| Rgb8Image { width: 4, height: 1, texels: vec![[code; 3]; 4] };
        let codes = |pictures, split| side_by_side(pictures, split).map(|p| p.texels.iter().map(|t| t[0]).collect());
        assert_eq!(codes(vec![picture(1), picture(2)], 0.25), Some(vec![1, 2, 2, 2]));
        assert_eq!(codes(vec![picture(1)], 0.25), Some(vec![1; 4]));
        assert_eq!(codes(Vec::new(), 0.5), None);
    }
}
