//! The device memory that the maps of objects need. The need is checked before allocation, because drivers report a shortage of
//! memory late or not at all.

use super::atlas::levels::CoarseShape;
use super::classes::ObjectClasses;
use super::displacement::{Border, HeightField};
use super::horizon::MOST_TEXELS;
use super::moments::MomentFormat;
use super::object::with_same_maps;
use crate::scene::Object;
use leadr_gpu::{Gpu, MemoryRoom, Result};

/// The bytes reserved for the render targets of a frame, the environment and staging.
const RESERVE: u64 = 192 << 20;

/// The number of bytes per texel of the horizon maps.
const HORIZON: u64 = 10;

/// Adds the bytes of all coarser mips to the bytes of the finest level.
fn with_mips(bytes: u64) -> u64 {
    bytes / 3 * 4
}

/// Returns the number of bytes that the maps of an object need on the device.
pub fn map_bytes(object: &Object, format: MomentFormat) -> u64 {
    let relief = object.heights.as_ref().map_or(0, |field| {
        let texels = u64::from(field.map.width) * u64::from(field.map.height);
        let mut horizon = texels;
        while horizon > u64::from(MOST_TEXELS) {
            horizon /= 4;
        }
        let coarse = match field.border {
            Border::Tiles(layout) => {
                let texels: u64 = CoarseShape::new(layout).size().map(u64::from).iter().product();
                // Coarse levels store moments as 32-bit floats, and the images of the material as half floats.
                let material = object.material.as_ref().map_or(0, |map| {
                    let light = map.emission.is_some() || map.occlusion.is_some();
                    8 * (1 + u64::from(map.f0.is_some()) + u64::from(light) + u64::from(map.cones.is_some()))
                });
                texels * (MomentFormat::Float32.texel_bytes() - 4 + material)
            }
            Border::Wrap | Border::Clamp => 0,
        };
        with_mips(texels * format.texel_bytes()) + with_mips(horizon * HORIZON) + coarse
    });
    let material = object.material.as_ref().map_or(0, |map| {
        let bytes = 4 + 4 * u64::from(map.f0.is_some());
        with_mips(u64::from(map.width) * u64::from(map.height) * bytes)
    });
    relief + material
}

/// Returns the size in bytes of the largest image among an object's maps, either the slope moments or the colours.
fn largest_image(object: &Object, format: MomentFormat) -> u64 {
    let slopes = object.heights.as_ref().map_or(0, |field| {
        let texels = u64::from(field.map.width) * u64::from(field.map.height);
        with_mips(texels * (format.texel_bytes() / 5 * 4))
    });
    let colors = object.material.as_ref().map_or(0, |map| with_mips(u64::from(map.width) * u64::from(map.height) * 4));
    slopes.max(colors)
}

/// Returns the number of bytes that a scene of these objects needs for maps, or 0 without maps.
fn needed(objects: &[Object], format: MomentFormat) -> u64 {
    let own = objects.iter().zip(with_same_maps(objects)).filter(|(_, earlier)| earlier.is_none());
    let maps: u64 = own.map(|(object, _)| map_bytes(object, format)).sum();
    if maps == 0 { 0 } else { maps + RESERVE }
}

/// The device memory that is available for maps.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    format: MomentFormat,
    /// The memory of the device that is free.
    device: MemoryRoom,
}

impl Room {
    /// Returns the memory that is available now for maps in this format.
    pub fn on(gpu: &Gpu, format: MomentFormat) -> Self {
        Self { format, device: gpu.memory_room() }
    }

    /// Checks that the images of classes fit into memory. Each entry has the name and the classes of an object.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_classes(&self, classes: &[(&str, &ObjectClasses)]) -> Result<()> {
        let bytes = |classes: &ObjectClasses| classes.bytes().iter().sum::<u64>();
        let Some((name, _)) = classes.iter().max_by_key(|(_, classes)| bytes(classes)) else { return Ok(()) };
        let needs: u64 = classes.iter().map(|(_, classes)| bytes(classes)).sum();
        let piece = classes.iter().flat_map(|(_, classes)| classes.bytes()).max().unwrap_or(0);
        self.device.check(needs, piece, &format!("a scene with the classes of facets of {name}"), "--classes off")
    }

    /// Checks that the maps of these objects fit into memory. Only the sizes of the maps are used, so their texels may be missing.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`](leadr_gpu::GpuError::TooLarge) or [`GpuError::InOnePiece`](leadr_gpu::GpuError::InOnePiece).
    /// The error names the object with the largest maps.
    pub fn check(&self, objects: &[Object]) -> Result<()> {
        let Self { format, device } = *self;
        let piece = |format| objects.iter().map(|object| largest_image(object, format)).max().unwrap_or(0);
        let fits = |format| needed(objects, format) <= device.left && piece(format) <= device.piece;
        if fits(format) {
            return Ok(());
        }
        let largest = objects.iter().max_by_key(|object| map_bytes(object, format));
        let heights = largest.and_then(|object| object.heights.as_ref());
        let what = largest.map_or_else(String::new, |object| {
            let size = heights.map_or_else(String::new, |HeightField { map, .. }| {
                format!(" of {} x {} texels", map.width, map.height)
            });
            format!("a scene with the maps of {}{size} in {}", object.name, format.name())
        });
        let smaller = match heights.map(|field| field.border) {
            Some(Border::Tiles(_)) => "a smaller --atlas-tile",
            _ => "smaller maps",
        };
        let remedy = match format {
            MomentFormat::Float32 if fits(MomentFormat::Float16) => format!("--map-precision f16 or {smaller}"),
            _ => smaller.to_owned(),
        };
        device.check(needed(objects, format), piece(format), &what, &remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};
    use leadr_maps::HeightMap;

    #[test]
    fn atlas_memory_is_near_its_texels() {
        let layout = TileLayout::new(5920, 128);
        let (width, height) = layout.size();
        let field = HeightField { map: HeightMap { width, height, texels: Vec::new() }, border: Border::Tiles(layout) };
        let bytes =
            map_bytes(&Object::new("animal", PatchMesh::default()).with_heights(field, 1.0), MomentFormat::Float16);
        // Each tile has 128 x 128 texels of 14 bytes with mips, and a coarse block of 17 x 44 texels of 20 bytes.
        let per_texel = bytes as f64 / (f64::from(width) * f64::from(height));
        assert!((14.0 * 4.0 / 3.0..14.0 * 4.0 / 3.0 + 2.0).contains(&per_texel), "{per_texel}");
    }

    #[test]
    fn eight_thousand_texels_a_side_fit_in_16_bits() {
        let field = HeightField::repeating(HeightMap { width: 8192, height: 8192, texels: Vec::new() });
        let plane = [Object::new("plane", PatchMesh::default()).with_heights(field, 1.0)];
        let room = |format, used: u64| {
            let device = MemoryRoom { size: 2 << 30, left: (2 << 30) - used, piece: 1 << 30 };
            Room { format, device }
        };
        let check = |format, used| room(format, used).check(&plane);
        assert!(check(MomentFormat::Float16, 100 << 20).is_ok());
        let refused = check(MomentFormat::Float32, 0).unwrap_err().to_string();
        assert!(
            refused.contains("plane of 8192 x 8192 texels in f32 needs 2.") && refused.contains("of 2.00 GiB"),
            "{refused}"
        );
        assert!(refused.ends_with("use --map-precision f16 or smaller maps"), "{refused}");
        let refused = check(MomentFormat::Float16, 1 << 30).expect_err("what is in use counts").to_string();
        assert!(refused.ends_with("use smaller maps"), "{refused}");
        // The total memory is large enough, but one allocation is not.
        let device = MemoryRoom { size: 4 << 30, left: 4 << 30, piece: 1 << 30 };
        let refused = Room { format: MomentFormat::Float32, device }.check(&plane).unwrap_err().to_string();
        assert!(
            refused.contains("1.33 GiB of device memory in one allocation, but the device allows 1.00 GiB"),
            "{refused}"
        );
        assert!(refused.ends_with("use --map-precision f16 or smaller maps"), "{refused}");
        let smooth = [Object::new("smooth", PatchMesh::default())];
        assert!(room(MomentFormat::Float32, (2 << 30) - 1).check(&smooth).is_ok());
    }
}
