//! Filters an atlas with one tile per patch, without seams.
//!
//! The mips of a tile cover only its own patch, so filtered values would jump at the borders of patches and in pixels that cover
//! several patches. Two mechanisms extend the filter over the whole surface:
//!
//! * [Links](frames) give the patch across each side of a patch, and the conversion of its gradients. Texture samples can therefore
//!   cross tiles.
//! * [Coarse levels](levels) continue the mips, from an eighth of a patch to many patches. All adjacent patches share the samples
//!   on their borders and corners.
//!
//! `shaders-glsl/passes/filter/atlas.glsl` reads the links and the coarse levels.

pub mod frames;
pub mod levels;
pub mod tiles;
pub mod turns;

use std::sync::Arc;

use half::f16;
use rayon::prelude::*;

use self::frames::{AtlasFrames, ConeTexel, gradient_transform};
use self::levels::{CoarseShape, Star, coarse_levels};
use self::turns::quarter_turns;
use super::material::{Codes, HALF_FORMAT, MaterialImages};
use super::moments::LeadrMapGpu;
use super::patch_mesh::{PatchMesh, TileLayout};
use super::topology::Topology;
use super::{floats, placeholder};
use crate::constants::{NO_NEIGHBOR, SOURCE_LEVEL};
use leadr_gpu::vk::Format;
use leadr_gpu::{Buffer, Gpu, GpuError, Image, ImageDesc, Result, shared_struct};

shared_struct! {
    /// The header of the buffer with the links.
    pub struct AtlasHeadGpu for "Atlas" {
        /// The value of [`TileLayout::tile`].
        tile_size: u32,
        tile_gutter: u32,
        tile_columns: u32,
        /// The value of [`CoarseShape::finest`].
        finest_coarse: u32,
    }
}

shared_struct! {
    /// The neighbours across the sides of a patch, in the order of [`Topology::patch_edges`].
    pub struct PatchLinkGpu for "PatchLink" {
        /// `patch << 2 | side` of the neighbour across each side, or [`NO_NEIGHBOR`].
        neighbors: [u32; 4],
        /// The [quarter turns](turns) of the patch, then zeros.
        turns: [u32; 4],
        /// The columns of the matrix that converts the neighbour's gradients to the patch's coordinates, at the first and second
        /// corner of each side.
        gradient_transforms: [[[f32; 4]; 2]; 4],
    }
}

/// The links and the coarse levels on the device. Objects without an atlas have placeholders.
#[derive(Clone)]
pub struct AtlasGpu {
    /// A buffer with an `AtlasHeadGpu`, followed by a `PatchLinkGpu` for every patch.
    pub links: Buffer,
    /// The coarse levels of the moments in [`LeadrMapGpu::slopes`].
    pub slopes: Image,
    /// The coarse levels of the moments in [`LeadrMapGpu::joint`].
    pub joint: Image,
    /// The coarse levels of the linear colours, with the square root of the roughness in alpha.
    pub color: Image,
    /// The coarse levels of the linear reflectance at normal incidence.
    pub f0: Image,
    /// The coarse levels of the emission, with the accessibility in alpha.
    pub light: Image,
    /// The coarse levels of the cones of ambient visibility, if the material has cones.
    pub cones: Option<Image>,
}

impl AtlasGpu {
    /// Creates placeholders for an object whose maps are not an atlas. Shaders never read them.
    pub fn none(gpu: &Arc<Gpu>) -> Result<Self> {
        let image = |what: &str, format| placeholder(gpu, &format!("no coarse {what}"), format);
        Ok(Self {
            links: Buffer::from_slice(gpu, "no links", &[0u32; 44])?,
            slopes: image("slopes", Format::R32G32B32A32_SFLOAT)?,
            joint: image("joint", Format::R32_SFLOAT)?,
            color: image("colour", HALF_FORMAT)?,
            f0: image("reflectance", HALF_FORMAT)?,
            light: image("light", HALF_FORMAT)?,
            cones: None,
        })
    }

    /// Builds the links and the coarse levels of `mesh`. The patches have the tiles of `layout`, in `maps` and in the material. The
    /// maps and the material must have equal sizes. `none` holds the placeholders for missing levels.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the material and the maps differ in size.
    pub fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        mesh: &PatchMesh,
        topology: &Topology,
        layout: TileLayout,
        maps: &LeadrMapGpu,
        material: Option<&MaterialImages>,
        none: &Self,
    ) -> Result<Self> {
        let size = maps.slopes.mip_extent(0);
        if let Some(material) = material.filter(|material| material.color.mip_extent(0) != size) {
            let ([w, h], [width, height]) = (material.color.mip_extent(0), size);
            let fault = format!("colours of {w}x{h} texels do not match heights of {width}x{height}");
            return Err(GpuError::usage(format!("atlas of {name}"), fault));
        }
        let frames = AtlasFrames::new(mesh, layout);
        let star = Star::new(mesh, topology.neighbors());
        let shape = CoarseShape::new(layout);

        let (slopes, joint) = (maps.read_slopes(SOURCE_LEVEL)?, maps.read_joint(SOURCE_LEVEL)?);
        let moments: Vec<[f32; 5]> = slopes.iter().zip(&joint).map(|(a, &b)| [a[0], a[1], a[2], a[3], b]).collect();
        let moments = coarse_levels(&star, &frames, shape, &moments);
        let [width, height] = shape.size();
        let image = |what: &str, format| {
            Image::new(gpu, &format!("{name} coarse {what}"), ImageDesc::new(format, width, height))
        };
        let mut atlas = none.clone();
        atlas.slopes = image("slopes", Format::R32G32B32A32_SFLOAT)?;
        atlas.slopes.write(0, 0, &moments.iter().map(|m| [m[0], m[1], m[2], m[3]]).collect::<Vec<_>>())?;
        atlas.joint = image("joint", Format::R32_SFLOAT)?;
        atlas.joint.write(0, 0, &moments.iter().map(|m| m[4]).collect::<Vec<_>>())?;

        let in_halves = |what: &str, texels: &mut dyn Iterator<Item = [f32; 4]>| {
            let halves: Vec<_> = texels.map(|texel| texel.map(f16::from_f32)).collect();
            let image = image(what, HALF_FORMAT)?;
            image.write(0, 0, &halves)?;
            Ok::<_, GpuError>(image)
        };
        let coarse = |what: &str, texels: Vec<[f32; 4]>, stored: fn([f32; 4]) -> [f32; 4]| {
            in_halves(what, &mut coarse_levels(&star, &frames, shape, &texels).into_iter().map(stored))
        };
        if let Some(images) = material {
            let codes = Codes::new();
            let decoded = |image: &Image| {
                let texels: Vec<[u8; 4]> = image.read(SOURCE_LEVEL, 0)?;
                Ok::<Vec<[f32; 4]>, GpuError>(texels.into_iter().map(|texel| codes.linear(texel)).collect())
            };
            // The shader expects the square root of the roughness in tile mips and in coarse levels.
            let root = |[r, g, b, variance]: [f32; 4]| [r, g, b, variance.sqrt().sqrt()];
            atlas.color = coarse("colour", decoded(&images.color)?, root)?;
            if images.features.f0 {
                atlas.f0 = coarse("reflectance", decoded(&images.f0)?, |texel| texel)?;
            }
            let has_cones = images.features.bases.cones;
            if images.features.emission || images.features.occlusion && !has_cones {
                atlas.light = coarse("light", light_texels(images)?, |texel| texel)?;
            }
            if has_cones {
                let codes: Vec<[i8; 4]> = images.occlusion.read(SOURCE_LEVEL, 0)?;
                let texels: Vec<ConeTexel> =
                    codes.into_iter().map(|texel| ConeTexel(texel.map(|code| f32::from(code) / 127.0))).collect();
                let levels = coarse_levels(&star, &frames, shape, &texels);
                atlas.cones = Some(in_halves("cones", &mut levels.into_iter().map(|texel| texel.0))?);
            }
        }

        let turns = quarter_turns(&star.neighbors);
        let links: Vec<PatchLinkGpu> = (0..mesh.patches.len())
            .into_par_iter()
            .map(|patch| {
                let mut link = PatchLinkGpu {
                    neighbors: [NO_NEIGHBOR; 4],
                    turns: [turns[patch], 0, 0, 0],
                    gradient_transforms: [[[1.0, 0.0, 0.0, 1.0]; 2]; 4],
                };
                for (side, neighbor) in star.neighbors[patch].iter().enumerate() {
                    let &Some((other, beside)) = neighbor else { continue };
                    link.neighbors[side] = other << 2 | u32::from(beside);
                    // The neighbour runs along the edge in the opposite direction.
                    for end in 0..2 {
                        let here = frames.corner(patch, (side + end) & 3);
                        let there = frames.corner(other as usize, (usize::from(beside) + 1 - end) & 3);
                        link.gradient_transforms[side][end] = gradient_transform(&there, &here);
                    }
                }
                link
            })
            .collect();
        let head = AtlasHeadGpu {
            tile_size: layout.tile,
            tile_gutter: layout.gutter,
            tile_columns: layout.columns,
            finest_coarse: shape.finest,
        };
        let mut bytes = bytemuck::bytes_of(&head).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(&links));
        atlas.links = Buffer::from_slice(gpu, &format!("{name} links"), &bytes)?;
        Ok(atlas)
    }
}

/// Reads the emission and the accessibility at the mip from which the coarse levels are computed.
fn light_texels(images: &MaterialImages) -> Result<Vec<[f32; 4]>> {
    let count = images.color.mip_extent(SOURCE_LEVEL).iter().product::<u32>() as usize;
    let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; count];
    if images.features.emission {
        for (texel, [r, g, b, _]) in texels.iter_mut().zip(floats(&images.emission, SOURCE_LEVEL)?) {
            *texel = [r, g, b, 1.0];
        }
    }
    if images.features.occlusion && !images.features.bases.cones {
        let shares: Vec<u8> = images.occlusion.read(SOURCE_LEVEL, 0)?;
        texels.iter_mut().zip(shares).for_each(|(texel, share)| texel[3] = f32::from(share) / 255.0);
    }
    Ok(texels)
}
