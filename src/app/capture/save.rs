//! A frame as a file, and whether a file is a whole frame.

use std::path::Path;

use exr::prelude as ex;

use super::frame_source::Frame;
use super::pattern::StillKind;
use crate::app::error::AppError;
use crate::app::files::make_folder_of;
use crate::maps::tonemap::{Tonemap, display_srgb8};
use crate::maps::{self, Rgb8Image};
use crate::scenes::config::SceneConfig;
use crate::scenes::view::Size;

/// No frame has more channels than this: an EXR with more is from another program.
const MAX_CHANNELS: usize = 32;

/// How radiance becomes what a screen shows.
#[derive(Clone, Copy, Debug)]
pub struct Tone {
    /// Stops on top of the frame's own exposure.
    pub exposure: f32,
    /// The curve.
    pub tonemap: Tonemap,
}

impl Tone {
    /// What a configuration asks for.
    #[must_use]
    pub fn of(config: &SceneConfig) -> Self {
        Self { exposure: config.exposure, tonemap: config.tonemap }
    }
}

/// Writes `frame` to `path`, whole or not at all, and makes the folders above it: a PNG gets tonemapped sRGB, an EXR linear radiance
/// and layers. `tone` is that of a PNG.
///
/// # Errors
/// If the frame cannot be encoded or the file not written; `path` then stays as it was.
pub fn save(path: &Path, kind: StillKind, frame: &Frame, tone: Tone) -> Result<(), AppError> {
    make_folder_of(path)?;
    match kind {
        StillKind::Png => maps::save::save_png_srgb8(path, &display(frame, tone))?,
        StillKind::Exr => {
            let color: [Vec<f32>; 4] = std::array::from_fn(|i| frame.color.iter().map(|c| c[i]).collect());
            let mut channels: Vec<(&str, &[f32])> =
                ["R", "G", "B", "A"].into_iter().zip(color.iter().map(Vec::as_slice)).collect();
            for (layer, planes) in &frame.layers {
                channels.extend(layer.channels().iter().copied().zip(planes.iter().map(Vec::as_slice)));
            }
            maps::save::save_exr(path, frame.width, frame.height, &channels)?;
        }
    }
    Ok(())
}

/// A frame as it is shown: tonemapped sRGB.
#[must_use]
pub fn display(frame: &Frame, tone: Tone) -> Rgb8Image {
    let factor = frame.exposure * tone.exposure.exp2();
    let texels = frame.color.iter().map(|c| display_srgb8([c[0], c[1], c[2]], factor, tone.tonemap)).collect();
    Rgb8Image { width: frame.width, height: frame.height, texels }
}

/// Whether `path` is a whole picture of this kind and size: it decodes to its end.
#[must_use]
pub fn is_complete(path: &Path, kind: StillKind, size: Size) -> bool {
    match kind {
        StillKind::Png => {
            maps::load_color_srgb8(path).is_ok_and(|image| (image.width, image.height) == (size.width, size.height))
        }
        StillKind::Exr => exr_is_complete(path, size).is_some(),
    }
}

fn exr_is_complete(path: &Path, size: Size) -> Option<()> {
    use ex::{ReadChannels, ReadLayers};
    // The header is checked before the decoder allocates memory for the pixels.
    let meta = exr::meta::MetaData::read_from_file(path, false).ok()?;
    let [header] = meta.headers.as_slice() else { return None };
    let fits = header.layer_size == ex::Vec2(size.width as usize, size.height as usize);
    (fits && header.channels.list.len() <= MAX_CHANNELS).then_some(())?;
    let image = ex::read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    image.from_file(path).is_ok().then_some(())
}
