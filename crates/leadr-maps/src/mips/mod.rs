//! Mip levels of textures with 8 bits per channel, for engines that know nothing of slope statistics.
//!
//! Engines read a normal map and a roughness map separately, and shade with both values as if the surface under a pixel were flat. The
//! levels here keep what such an engine can show: normals are mean directions of length 1, and the roughness contains the spread of the
//! normals that the mean has lost. Colours are means in linear light.
//!
//! The mean normal of a footprint has the length `L_r · L_n`: `L_r` is the mean length that the roughness of the texels gives (Chan 2018,
//! eq. 18), and `L_n` is the length of the mean of the unit normals. The roughness of a level is that of the product (eq. 34).

mod color;
mod normals;
mod roughness;

pub use color::{Alpha, color_mips, data_mips};
pub use normals::NormalMips;
pub use roughness::{RoughnessSource, roughness_mips};

use crate::pyramid::{Pyramid, Row, level_sizes};

/// Rows that are filtered together.
const BAND: u32 = 64;

/// All mip levels of a texture, with 8-bit RGBA texels. The first level is the finest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mips {
    /// The texels of each level.
    pub levels: Vec<MipLevel>,
    /// Whether the colour channels are sRGB codes. Alpha is always linear.
    pub srgb: bool,
}

/// One mip level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MipLevel {
    /// The width and height in texels.
    pub size: [u32; 2],
    /// The RGBA texels, row by row from the top.
    pub texels: Vec<[u8; 4]>,
}

impl Mips {
    /// Whether a texel of the finest level has an alpha below 1.
    pub fn has_alpha(&self) -> bool {
        self.levels[0].texels.iter().any(|texel| texel[3] < u8::MAX)
    }
}

/// Averages an image down to one texel. `row` returns the values of a row of the finest level. The result has all levels but the finest.
fn filtered<const N: usize>(size: [u32; 2], row: impl Fn(u32) -> Row + Sync) -> Vec<Vec<[f32; N]>> {
    use rayon::prelude::*;
    let count = level_sizes(size).len();
    let mut levels = vec![Vec::new(); count];
    let mut pyramid = Pyramid::new(size, N);
    for first in (0..size[1]).step_by(BAND as usize) {
        let rows = (first..size[1].min(first + BAND)).into_par_iter().map(&row).collect();
        let pushed = pyramid.push(rows, &mut |level, _, rows| {
            if level > 0 {
                levels[level].extend(rows.iter().flat_map(|row| row.as_chunks::<N>().0));
            }
            Ok(())
        });
        pushed.expect("the callback never fails");
    }
    levels.remove(0);
    levels
}

/// Returns the code of a value from 0 to 1.
fn unorm8(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}
