//! The one reader of EXR files that are not baked maps: pictures, environments, heights and maps of materials.

use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, EnvironmentMap, IntegerBounds, Text};
use exr::meta::header::Header;

use super::MapFault;
use super::exr_layers::{Selected, Wanted, select};
use super::exr_read::{Opened, Planes};
use super::gamut::{ACES, Conversion, Gamut};
use super::guard::guarded;

/// The selected layer of a file, over the display window.
pub(crate) struct ExrPicture {
    pub width: u32,
    pub height: u32,
    /// One plane of grey, or three of linear Rec.709. The primaries of `Wanted::Numbers` and heights are not converted.
    pub colors: Vec<Vec<f32>>,
    /// The opacity. The colours are multiplied by it.
    pub alpha: Option<Vec<f32>>,
    /// The top left corner of the display window.
    pub origin: [i32; 2],
    /// The width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The name of the layer, or an empty text for the unnamed layer.
    pub layer: String,
    /// The view of a stereo picture, such as `left`.
    pub view: Option<String>,
    /// Whether the file declares the faces of a cube, or a panorama.
    pub is_cube: Option<bool>,
    /// Whether the data window leaves a part of the display window empty.
    pub is_cropped: bool,
    /// The value that the file declares to be missing.
    pub missing: Option<f32>,
}

impl ExrPicture {
    /// Returns the colour of a texel. Grey fills all channels.
    pub fn color(&self, index: usize) -> [f32; 3] {
        [0, 1, 2].map(|channel| self.colors[channel.min(self.colors.len() - 1)][index])
    }
}

/// Reads the layer that `wanted` selects, and adds remarks on what was chosen or left aside. Texels of the display window that
/// the file does not store are black and transparent, or NaN in heights.
pub(crate) fn read(bytes: &[u8], wanted: Wanted<'_>, remarks: &mut Vec<String>) -> Result<ExrPicture, MapFault> {
    // Damaged blocks cause arithmetic overflow in the crate, for example with B44 compression.
    guarded("EXR", || {
        let file = Opened::new(bytes)?;
        let Selected { part, layer, view, colors, alpha, remark } = select(&file.meta, wanted)?;
        let header = &file.meta.headers[part];
        let outside = if matches!(wanted, Wanted::Heights) { f32::NAN } else { 0.0 };
        let picked: Vec<usize> = colors.iter().copied().chain(alpha).collect();
        let Planes { width, height, mut planes } = file.framed(part, &picked, outside)?;
        let alpha = alpha.and_then(|_| planes.pop());
        remarks.extend(remark);
        let empty = empty_share(header);
        if empty > 0.0 && outside == 0.0 {
            let percent = 100.0 * empty;
            remarks
                .push(format!("its data window leaves {percent:.1} % of its display window empty, which is read as 0"));
        }
        if matches!(wanted, Wanted::Colors(_)) && planes.len() == 3 {
            match conversion(header) {
                Ok(None) => {}
                Ok(Some(conversion)) => convert(&mut planes, &conversion),
                Err(()) => remarks.push("its chromaticities span no gamut; its colours are read as Rec.709".to_owned()),
            }
        }
        let (shared, own) = (&header.shared_attributes, &header.own_attributes);
        Ok(ExrPicture {
            width,
            height,
            colors: planes,
            alpha,
            origin: [shared.display_window.position.x(), shared.display_window.position.y()],
            pixel_aspect: shared.pixel_aspect,
            layer,
            view,
            is_cube: own.environment_map.map(|map| map == EnvironmentMap::Cube),
            is_cropped: empty > 0.0,
            missing: missing_value(header),
        })
    })
}

/// Returns the share of the display window that lies outside the data window.
fn empty_share(header: &Header) -> f64 {
    let ends = |window: IntegerBounds| {
        let (start, size) = (window.position, window.size);
        [(start.x(), size.width()), (start.y(), size.height())].map(|(start, size)| (i64::from(start), size as i64))
    };
    let (data, display) = (ends(header.data_window()), ends(header.shared_attributes.display_window));
    let covered = data.iter().zip(display).map(|((start, size), (other_start, other_size))| {
        let covered = (start + size).min(other_start + other_size) - (*start).max(other_start);
        covered.max(0) as f64 / other_size as f64
    });
    1.0 - covered.product::<f64>()
}

/// Returns the conversion from the primaries of a file to Rec.709. `Err` stands for chromaticities that span no gamut.
fn conversion(header: &Header) -> Result<Option<Conversion>, ()> {
    let of = |at: Vec2<f32>| [f64::from(at.x()), f64::from(at.y())];
    let (shared, own) = (&header.shared_attributes, &header.own_attributes);
    if let Some(given) = &shared.chromaticities {
        return Gamut([given.red, given.green, given.blue, given.white].map(of)).conversion();
    }
    // Other ways to name the primaries: the flag of ACES containers, and names of colour spaces.
    let named = |(name, value): (&Text, &AttributeValue)| match value {
        AttributeValue::I32(1) if name.eq("acesImageContainerFlag") => Some(ACES),
        AttributeValue::Text(space) => {
            let name = name.to_string().to_ascii_lowercase();
            let is_space = name.ends_with("colorspace") || name.ends_with("colorinteropid");
            is_space.then(|| Gamut::named(&space.to_string())).flatten()
        }
        _ => None,
    };
    let gamut = shared.other.iter().chain(&own.other).find_map(named);
    gamut.map_or(Ok(None), |gamut| gamut.conversion())
}

fn convert(planes: &mut [Vec<f32>], conversion: &Conversion) {
    let [red, green, blue] = planes else { return };
    for ((red, green), blue) in red.iter_mut().zip(green).zip(blue) {
        [*red, *green, *blue] = conversion.apply([*red, *green, *blue]);
    }
}

/// Returns the value of an attribute such as `GDAL_NODATA`.
fn missing_value(header: &Header) -> Option<f32> {
    let attributes = header.shared_attributes.other.iter().chain(&header.own_attributes.other);
    let named = |name: &Text| {
        let name: String = name.to_string().to_ascii_lowercase().chars().filter(char::is_ascii_alphabetic).collect();
        name.ends_with("nodata") || name.ends_with("nodatavalue")
    };
    attributes.filter(|(name, _)| named(name)).find_map(|(_, value)| match value {
        AttributeValue::F32(value) => Some(*value),
        AttributeValue::F64(value) => Some(*value as f32),
        AttributeValue::I32(value) => Some(*value as f32),
        AttributeValue::Text(text) => text.to_string().trim().parse().ok(),
        _ => None,
    })
}
