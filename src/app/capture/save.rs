//! Writes frames to files, and checks whether a file is a complete frame.

use std::path::Path;

use exr::prelude as ex;

use super::frame_source::Frame;
use super::pattern::StillKind;
use leadr_maps::limits::read_file;
use leadr_maps::new_file::write_atomic;
use leadr_maps::origin::Origin;
use leadr_maps::save::{encode_exr_of, encode_png_srgb8};
use leadr_maps::{Rgb8Image, decode_color_srgb8};
use leadr_scenes::config::Picture;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;

/// The largest number of channels in a frame. An EXR file with more channels is from another program.
const MAX_CHANNELS: usize = 32;

/// Writes `frame` to `path` atomically, and creates missing folders. A PNG file stores sRGB with the exposure and tone curve of `picture`.
/// An EXR file stores linear radiance and layers. Both kinds of file store `origin`.
///
/// # Errors
/// If the frame cannot be encoded or the file cannot be written, `path` is unchanged in this case.
pub fn save(path: &Path, kind: StillKind, frame: &Frame, picture: &Picture, origin: &Origin) -> Result<(), AppError> {
    let encoded = match kind {
        StillKind::Png => encode_png_srgb8(&display(frame, picture)).map(|png| origin.in_png(png)),
        StillKind::Exr => {
            let color: [Vec<f32>; 4] = std::array::from_fn(|i| frame.color.iter().map(|c| c[i]).collect());
            let mut channels: Vec<(&str, &[f32])> =
                ["R", "G", "B", "A"].into_iter().zip(color.iter().map(Vec::as_slice)).collect();
            for (layer, planes) in &frame.layers {
                channels.extend(layer.channels().iter().copied().zip(planes.iter().map(Vec::as_slice)));
            }
            encode_exr_of(origin, frame.width, frame.height, &channels)
        }
    };
    Ok(write_atomic(path, &encoded.map_err(|fault| fault.in_file(path))?)?)
}

/// Returns the factor from radiance to the input of the tone curve.
pub fn display_factor(frame: &Frame, picture: &Picture) -> f32 {
    frame.exposure * picture.exposure.exp2()
}

/// Converts a frame to tonemapped sRGB.
pub fn display(frame: &Frame, picture: &Picture) -> Rgb8Image {
    let colors: Vec<[f32; 3]> = frame.color.iter().map(|c| [c[0], c[1], c[2]]).collect();
    picture.codes(frame.width, &colors, display_factor(frame, picture))
}

/// Returns the stored origin if `path` is a complete picture of this format and size. The file is decoded to its end to check this.
pub fn origin_if_whole(path: &Path, kind: StillKind, size: Size) -> Option<Option<Origin>> {
    match kind {
        StillKind::Png => {
            let bytes = read_file(path).ok()?;
            let image = decode_color_srgb8(&bytes).ok()?;
            ((image.width, image.height) == (size.width, size.height)).then(|| Origin::of_png(&bytes))
        }
        StillKind::Exr => exr_is_complete(path, size).map(|()| Origin::of_exr(path)),
    }
}

fn exr_is_complete(path: &Path, size: Size) -> Option<()> {
    use ex::{ReadChannels, ReadLayers};
    // If the path is a pipe, opening it would block until a writer opens it.
    path.is_file().then_some(())?;
    // The decoder allocates memory for the pixels, so the header is checked first.
    let meta = exr::meta::MetaData::read_from_file(path, false).ok()?;
    let [header] = meta.headers.as_slice() else { return None };
    let fits = header.layer_size == ex::Vec2(size.width as usize, size.height as usize);
    (fits && header.channels.list.len() <= MAX_CHANNELS).then_some(())?;
    let image = ex::read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    image.from_file(path).is_ok().then_some(())
}
