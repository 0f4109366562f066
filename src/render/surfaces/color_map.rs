//! Colour maps on the device: sRGB with a mip chain averaged in linear light.

use std::sync::Arc;

use ash::vk;
use rayon::prelude::*;

use super::displacement::Border;
use crate::gpu::{Gpu, Image, ImageDesc, Result};
use crate::maps::srgb::{linear_of_srgb8, srgb8_from_linear};
use crate::render::scene::ColorMap;

/// Uploads a colour map with its mips. In an atlas of tiles the mips end where a tile is one texel.
///
/// # Errors
/// Memory or a Vulkan call that failed.
pub fn upload(gpu: &Arc<Gpu>, name: &str, map: ColorMap, border: Border) -> Result<Image> {
    let ColorMap { mut width, mut height, mut texels } = map;
    let desc = ImageDesc::new(vk::Format::R8G8B8A8_SRGB, width, height).full_mips();
    let desc = match border {
        Border::Tiles(layout) => desc.mips(layout.tile.ilog2() + 1),
        _ => desc,
    };
    let image = Image::new(gpu, &format!("{name} colour"), desc)?;
    for mip in 0..desc.mips {
        if mip > 0 {
            texels = halve(&texels, width, height);
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
        }
        image.write(mip, 0, &texels)?;
    }
    Ok(image)
}

/// The next mip: means of 2 × 2 texels in linear light (an odd last row or column is dropped).
fn halve(texels: &[[u8; 4]], width: u32, height: u32) -> Vec<[u8; 4]> {
    let linear = linear_of_srgb8();
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    (0..h)
        .into_par_iter()
        .flat_map_iter(|y| {
            let linear = &linear;
            (0..w).map(move |x| {
                let at = |dx: u32, dy: u32| {
                    let (x, y) = ((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1));
                    texels[(y * width + x) as usize]
                };
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                std::array::from_fn(|channel| {
                    if channel == 3 {
                        let sum: u32 = four.iter().map(|t| u32::from(t[3])).sum();
                        ((sum + 2) / 4) as u8
                    } else {
                        let mean = four.iter().map(|t| linear[usize::from(t[channel])]).sum::<f32>() * 0.25;
                        srgb8_from_linear(mean)
                    }
                })
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mips_average_light_not_codes() {
        let half = halve(&[[0, 255, 10, 0], [255, 255, 10, 100], [0, 255, 10, 0], [255, 255, 10, 100]], 2, 2);
        assert_eq!(half, [[188, 255, 10, 50]]);
    }
}
