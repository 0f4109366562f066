//! The engines for which textures are written.

use leadr_maps::material::GreenAxis;
use leadr_maps::mips::Mips;

use crate::blocks::{BlockFormat, compress};
use crate::dds_file::dds;
use crate::ktx2_file::ktx2;

/// An engine that reads models or textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Any engine with `KHR_texture_basisu`, such as three.js, Babylon.js, Filament, and Unity with glTFast and KTX for Unity.
    #[default]
    Gltf,
    /// Bevy, which reads KTX2 images with BC7 blocks in place of PNG images, but no `KHR_texture_basisu`.
    Bevy,
    /// Godot, which darkens colours in KTX2 (godot#99589): in models they stay as they are, and textures are DDS files. Write a `.gltf`:
    /// Godot extracts the images of a `.glb` and makes their mip levels anew.
    Godot,
    /// Unity's render pipelines, for textures of a material. Models are for glTFast ([`Engine::Gltf`]).
    Unity,
    /// Unreal Engine, for textures of a material. Its importer does not read KTX2 in models.
    Unreal,
}

/// The channels of the texture with roughness, occlusion and metalness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Packing {
    /// The end of the file name.
    pub(crate) name: &'static str,
    pub(crate) roughness: usize,
    pub(crate) occlusion: usize,
    pub(crate) metalness: usize,
    /// Whether the channel holds 1 − roughness.
    pub(crate) smoothness: bool,
}

impl Engine {
    /// Returns the block format of textures in KTX2 files.
    pub(crate) fn blocks(self) -> BlockFormat {
        match self {
            Self::Bevy => BlockFormat::Bc7,
            _ => BlockFormat::Uastc,
        }
    }

    /// Whether the files of a material's textures are KTX2 with blocks, and not DDS.
    pub(crate) fn has_blocks(self) -> bool {
        matches!(self, Self::Gltf | Self::Bevy)
    }

    /// Returns the suffix of the files of a material's textures.
    pub(crate) fn suffix(self) -> &'static str {
        if self.has_blocks() { "ktx2" } else { "dds" }
    }

    /// Returns the bytes of a file with this suffix.
    pub(crate) fn file(self, mips: &Mips) -> Vec<u8> {
        if self.has_blocks() { ktx2(&compress(mips, self.blocks())) } else { dds(mips) }
    }

    /// Returns the direction of the green channel of normals.
    pub(crate) fn green(self) -> GreenAxis {
        match self {
            Self::Unreal => GreenAxis::Down,
            _ => GreenAxis::Up,
        }
    }

    pub(crate) fn packing(self) -> Packing {
        match self {
            Self::Unity => Packing { name: "Mask", metalness: 0, occlusion: 1, roughness: 3, smoothness: true },
            _ => Packing { name: "ORM", occlusion: 0, roughness: 1, metalness: 2, smoothness: false },
        }
    }
}
