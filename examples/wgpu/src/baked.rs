//! Reads files of `leadr bake` with the `ktx2` crate and the keys that are listed in `crates/leadr-maps/README.md#baked-files`.

use std::path::Path;

/// A LEADR map with roughness and colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// The width and height of level 0 in texels.
    pub size: [u32; 2],
    /// The number of four-channel layers.
    pub layers: u32,
    /// The index of the colour layer.
    pub color_layer: u32,
    /// Whether numbers have 16 bits instead of 32 bits.
    pub half: bool,
    /// The factors on the channels of the first two layers and of the colour layer.
    pub scale: [[f32; 4]; 3],
    /// The bytes of each level, from the largest level on, layer by layer.
    pub levels: Vec<Vec<u8>>,
}

/// The required channels, in the order of their slots.
const CHANNELS: [&str; 8] = ["x", "y", "xx", "yy", "xy", "height", "alpha2", "alpha4"];

impl Baked {
    /// Reads a file.
    ///
    /// # Errors
    /// Returns a message that includes the name of the file.
    pub fn load(path: &Path) -> Result<Self, String> {
        let named = |error: String| format!("{}: {error}", path.display());
        let bytes = std::fs::read(path).map_err(|error| named(error.to_string()))?;
        Self::decode(&bytes).map_err(named)
    }

    /// Reads a file from memory.
    ///
    /// # Errors
    /// Returns a message with the reason.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let reader = ktx2::Reader::new(bytes).map_err(|error| format!("not a KTX2 file: {error:?}"))?;
        let header = reader.header();
        let half = match header.format {
            Some(ktx2::Format::R32G32B32A32_SFLOAT) => false,
            Some(ktx2::Format::R16G16B16A16_SFLOAT) => true,
            other => return Err(format!("texels are {other:?}; bake with --format f32 or f16")),
        };
        let key = |name: &str| -> Result<Vec<&str>, String> {
            let found = reader.key_value_data().find(|(key, _)| *key == name);
            let value = found.and_then(|(_, value)| std::str::from_utf8(value.strip_suffix(&[0])?).ok());
            Ok(value
                .ok_or_else(|| format!("the key {name} is missing; give a file of leadr bake"))?
                .split(' ')
                .collect())
        };
        let channels = key("leadr.channels")?;
        let red = channels.iter().position(|name| *name == "red").filter(|at| at % 4 == 0);
        let red = red.filter(|_| channels.starts_with(&CHANNELS) && channels.len() == 4 * header.layer_count as usize);
        let red =
            red.ok_or("slopes, roughness and colour are needed; bake a material folder with roughness and colour")?;
        let factors: Option<Vec<f32>> = key("leadr.factors")?.into_iter().map(|text| text.parse().ok()).collect();
        let factors = factors
            .filter(|f| f.len() == channels.len())
            .ok_or("the key leadr.factors is invalid; bake the file again")?;
        let scale = [0, 4, red].map(|first| std::array::from_fn(|i| 1.0 / factors[first + i]));
        let levels: Vec<Vec<u8>> = reader.levels().map(|level| level.data.to_vec()).collect();
        let texel = if half { 8 } else { 16 };
        let size = [header.pixel_width, header.pixel_height];
        for (i, level) in levels.iter().enumerate() {
            let texels = size.map(|side| (side >> i).max(1) as usize).iter().product::<usize>();
            if level.len() != texels * texel * header.layer_count as usize {
                return Err(format!(
                    "level {i} has {} bytes, which does not match its size; bake the file again",
                    level.len()
                ));
            }
        }
        Ok(Self { size, layers: header.layer_count, color_layer: red as u32 / 4, half, scale, levels })
    }
}
