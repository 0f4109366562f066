//! The state that the sections of a run share: the device, settings, pictures, and cases for the last section.

use std::cell::{Cell, OnceCell};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::case::Case;
use super::verdict::{Shot, Verdict};
use leadr_gpu::Gpu;
use leadr_maps::save::encode_png_srgb8;
use leadr_maps::tonemap::{Tonemap, display_image};
use leadr_maps::{MapFault, Rgb8Image, RgbImage};
use leadr_render::frame::Renderer;
use leadr_render::sampling::independent_seed;
use leadr_render::scene::FrameState;
use leadr_render::settings::RenderSettings;
use leadr_tools::command::bars::Bar;
use leadr_tools::command::output::Output;
use leadr_tools::error::LabError;
use leadr_tools::html::Figure;

/// The folder of the pictures, next to the page.
pub const PICTURES: &str = "pictures";

/// The state that the sections of a run share.
pub struct Studio<'a> {
    /// The device that renders the pictures.
    pub gpu: Arc<Gpu>,
    /// Whether to render small pictures with few samples.
    pub quick: bool,
    /// The output that receives progress.
    pub progress: &'a Output,
    /// The pictures that were compared with the truth so far.
    pub cases: Vec<Case>,
    pictures: BTreeMap<String, Vec<u8>>,
    /// The progress bar of the current section, once the section renders or reports steps.
    bar: OnceCell<Bar>,
    /// The number of pictures that were rendered for the current section.
    rendered: Cell<u32>,
}

impl<'a> Studio<'a> {
    /// Creates an empty studio.
    pub fn new(gpu: Arc<Gpu>, quick: bool, progress: &'a Output) -> Self {
        Self {
            gpu,
            quick,
            progress,
            cases: Vec::new(),
            pictures: BTreeMap::new(),
            bar: OnceCell::new(),
            rendered: Cell::new(0),
        }
    }

    fn bar(&self) -> &Bar {
        self.bar.get_or_init(|| self.progress.bar(0, "rendering the report"))
    }

    /// Sets the number of steps of a section. Without this call, progress counts pictures.
    pub fn steps(&self, steps: usize) {
        self.bar().restart(steps);
    }

    /// Completes one step of the section's progress.
    pub fn step(&self) {
        self.bar().step();
    }

    /// Ends the progress of a section.
    pub fn end_section(&mut self) {
        self.bar = OnceCell::new();
        self.rendered.set(0);
    }

    /// Returns `quick` in a quick run, otherwise `full`.
    pub fn pick<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Renders a picture.
    ///
    /// # Errors
    /// Fails if the device fails, or if a pixel is not finite. The error gives the position of the pixel.
    pub fn shoot(
        &self,
        renderer: &mut Renderer,
        state: &FrameState,
        settings: &RenderSettings,
    ) -> Result<Shot, LabError> {
        self.shoot_range(renderer, state, settings, 0..settings.samples.max(1))
    }

    /// Renders a range of a picture's samples and returns their mean.
    ///
    /// # Errors
    /// Returns the errors of [`shoot`](Self::shoot).
    pub fn shoot_range(
        &self,
        renderer: &mut Renderer,
        state: &FrameState,
        settings: &RenderSettings,
        range: Range<u32>,
    ) -> Result<Shot, LabError> {
        let samples = range.len() as u32;
        self.rendered.set(self.rendered.get() + 1);
        self.bar().message(&format!("picture {}", self.rendered.get()));
        let output = renderer.render_range(state, settings, range)?;
        let (width, height) = output.size;
        let texels = output.color.iter().map(|c| [c[0], c[1], c[2]]).collect();
        let image = RgbImage::new(width, height, texels).map_err(fault)?;
        image.check_finite().map_err(fault)?;
        Ok(Shot {
            image,
            coverage: output.color.iter().map(|c| c[3]).collect(),
            milliseconds: output.times.iter().map(|t| t.milliseconds).sum(),
            samples,
            noise: 0.0,
        })
    }

    /// Renders a truth in two halves with different seeds. The difference of the halves estimates the noise of their mean.
    ///
    /// # Errors
    /// Returns the errors of [`shoot`](Self::shoot).
    pub fn shoot_truth(
        &self,
        renderer: &mut Renderer,
        state: &FrameState,
        settings: &RenderSettings,
    ) -> Result<Shot, LabError> {
        let samples = settings.samples.div_ceil(2);
        let half = |seed: u64| RenderSettings { samples, seed, ..*settings };
        let first = self.shoot(renderer, state, &half(settings.seed))?;
        let second = self.shoot(renderer, state, &half(independent_seed(samples, settings.seed)))?;
        Shot::mean_of(&first, &second).map_err(fault)
    }

    /// Stores a picture under `name` (letters, digits and dashes). The picture is scaled by `exposure` and displayed with
    /// the filmic curve.
    ///
    /// # Errors
    /// Fails if the picture cannot be encoded.
    pub fn picture(
        &mut self,
        name: &str,
        image: &RgbImage,
        exposure: f32,
        alt: &str,
        caption: Vec<String>,
    ) -> Result<Figure, LabError> {
        self.codes(name, &display_image(image, exposure, Tonemap::Filmic), alt, caption)
    }

    /// Stores the picture of a verdict's FLIP errors. Black means 0, and pale yellow means 1.
    ///
    /// # Errors
    /// Fails if the picture cannot be encoded.
    pub fn error_picture(
        &mut self,
        name: &str,
        verdict: &Verdict,
        alt: &str,
        caption: Vec<String>,
    ) -> Result<Figure, LabError> {
        self.codes(name, &verdict.error_image, alt, caption)
    }

    /// Stores a picture of sRGB codes.
    ///
    /// # Errors
    /// Fails if the picture cannot be encoded.
    pub fn codes(
        &mut self,
        name: &str,
        codes: &Rgb8Image,
        alt: &str,
        caption: Vec<String>,
    ) -> Result<Figure, LabError> {
        let file = format!("{PICTURES}/{name}.png");
        let bytes = encode_png_srgb8(codes).map_err(fault)?;
        if self.pictures.insert(file.clone(), bytes).is_some() {
            return Err(LabError(format!("two pictures of the report are called {file}")));
        }
        Ok(Figure { file, alt: alt.to_owned(), caption, width: codes.width, height: codes.height, scale: 1 })
    }

    /// Takes the pictures since the last call, as PNG bytes with paths relative to the page.
    pub fn take_pictures(&mut self) -> BTreeMap<String, Vec<u8>> {
        std::mem::take(&mut self.pictures)
    }
}

/// Converts a fault of a picture that has no file.
pub fn fault(fault: MapFault) -> LabError {
    LabError(fault.to_string())
}
