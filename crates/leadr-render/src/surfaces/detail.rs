//! A repeating detail relief on the device, with its LEADR maps, colours, mask and mapping.
//! `shaders-glsl/passes/filter/detail.glsl` filters it.

use std::sync::Arc;

use glam::Affine2;

use super::displacement::Border;
use super::material::{Codes, HALF_FORMAT, MaterialImages, halve, halves, write_mips};
use super::moments::{LeadrMapGpu, MomentFormat, field_maps};
use super::patch_mesh::PatchMesh;
use crate::constants::{
    DETAIL_BY_TEXCOORD, DETAIL_COLORLESS, DETAIL_COVERS, DETAIL_NONE, DETAIL_TRIPLANAR, DETAIL_VARIES,
};
use crate::scene::{Detail, DetailColors, DetailMapping, FactorMap, MaterialMap};
use leadr_gpu::{AddressMode, Buffer, Filter, Gpu, GpuError, Image, ImageDesc, Result, Sampler, shared_struct};

shared_struct! {
    /// The mapping of a detail onto its surface. For triplanar mapping, it is followed in the buffer by one `RestVertexGpu` per
    /// vertex.
    pub struct DetailHeadGpu for "Detail" {
        /// The columns of the matrix from the texture coordinates of the surface to those of the detail.
        detail_linear: [f32; 4],
        /// The columns of the matrix from the texture coordinates of the surface to those of the mask.
        mask_linear: [f32; 4],
        detail_offsets: [f32; 4],
        /// The factor for the colours in rgb, and the reflectance at normal incidence in alpha.
        detail_color: [f32; 4],
    }
}

shared_struct! {
    /// A vertex at rest, with its position in units of the detail's triplanar coordinates.
    pub struct RestVertexGpu for "RestVertex" {
        position: [f32; 4],
        normal: [f32; 4],
    }
}

/// The inputs that the filter pass reads from a detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DetailKind {
    /// The `DETAIL_` constant of the mapping, or the constant for no detail.
    pub mapping: u32,
    /// The `DETAIL_` constant that says how the colours of the detail are used.
    pub colors: u32,
    /// Whether the detail has a mask.
    pub masked: bool,
}

impl DetailKind {
    /// Whether the object has a detail.
    pub const fn is_some(self) -> bool {
        self.mapping != DETAIL_NONE
    }

    /// Returns the kind of a detail.
    pub fn of(detail: Option<&Detail>) -> Self {
        let Some(detail) = detail else {
            return Self { mapping: DETAIL_NONE, colors: DETAIL_COLORLESS, masked: false };
        };
        Self {
            mapping: match detail.mapping {
                DetailMapping::Texcoords => DETAIL_BY_TEXCOORD,
                DetailMapping::Triplanar(_) => DETAIL_TRIPLANAR,
            },
            colors: match detail.material {
                None => DETAIL_COLORLESS,
                Some((_, DetailColors::Vary)) => DETAIL_VARIES,
                Some((_, DetailColors::Cover(_))) => DETAIL_COVERS,
            },
            masked: detail.mask.is_some(),
        }
    }
}

/// A detail on the device. Objects without a detail have placeholders, which shaders never read.
pub struct DetailImages {
    /// A buffer with a `DetailHeadGpu`, followed by one `RestVertexGpu` per vertex for triplanar mapping.
    pub layout: Buffer,
    /// The slope moments of the detail.
    pub maps: LeadrMapGpu,
    /// The colours and the roughness of the detail.
    pub material: MaterialImages,
    /// The mask `m` and its square `m²`, as half floats.
    pub mask: Image,
    /// The sampler for all maps of the detail.
    pub sampler: Sampler,
    /// Whether the heights displace the surface.
    pub displaces: bool,
}

impl DetailImages {
    /// Creates a placeholder detail from placeholder maps.
    pub fn none(gpu: &Arc<Gpu>, leadr: &LeadrMapGpu, material: &MaterialImages) -> Result<Self> {
        Ok(Self {
            layout: Buffer::from_slice(gpu, "no detail", &[0u8; size_of::<DetailHeadGpu>()])?,
            maps: leadr.clone(),
            material: material.clone(),
            mask: mask_image(gpu, "no detail", None)?,
            displaces: false,
            sampler: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?,
        })
    }

    /// Uploads the detail of a surface with this mesh and border rule. `none` holds placeholders for images that the material
    /// lacks.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the detail uses the texture coordinates of an atlas, or if a map has the wrong number of
    /// texels.
    pub fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        detail: Detail,
        mesh: &PatchMesh,
        border: Border,
        none: &MaterialImages,
    ) -> Result<Self> {
        let name = format!("{name} detail");
        let Detail { heights, slopes, material, mapping, transform, mask, displaces } = detail;
        if mapping == DetailMapping::Texcoords && matches!(border, Border::Tiles(_)) {
            let fault = "texture coordinates of an atlas end at each tile: use triplanar mapping for the detail";
            return Err(GpuError::usage(name, fault));
        }
        let detail_color = match &material {
            None => [1.0, 1.0, 1.0, 0.04],
            Some((map, DetailColors::Vary)) => per_mean(map),
            Some((_, DetailColors::Cover(f0))) => [1.0, 1.0, 1.0, *f0],
        };
        let onto_mask = mask.as_ref().map_or(Affine2::IDENTITY, |mask| mask.transform);
        let [d, m] = [transform.translation, onto_mask.translation];
        let head = DetailHeadGpu {
            detail_linear: transform.matrix2.to_cols_array(),
            mask_linear: onto_mask.matrix2.to_cols_array(),
            detail_offsets: [d.x, d.y, m.x, m.y],
            detail_color,
        };
        let rest = match mapping {
            DetailMapping::Texcoords => Vec::new(),
            DetailMapping::Triplanar(metres) => rest_vertices(mesh, metres),
        };
        let layout = [bytemuck::bytes_of(&head), bytemuck::cast_slice(&rest)].concat();
        Ok(Self {
            layout: Buffer::from_slice(gpu, &name, &layout)?,
            material: match material {
                Some((map, _)) => MaterialImages::new(gpu, &name, map, Border::Wrap, none)?,
                None => none.clone(),
            },
            maps: field_maps(gpu, &heights, slopes, None, None, MomentFormat::Float32)?,
            mask: mask_image(gpu, &name, mask)?,
            displaces,
            sampler: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?,
        })
    }
}

fn rest_vertices(mesh: &PatchMesh, metres: f32) -> Vec<RestVertexGpu> {
    let vertex = |(position, normal): (&glam::Vec3, &glam::Vec3)| RestVertexGpu {
        position: (*position / metres).extend(0.0).to_array(),
        normal: normal.extend(0.0).to_array(),
    };
    mesh.positions.iter().zip(&mesh.normals).map(vertex).collect()
}

/// Returns the factor that normalises the mean colour of a map to 1. The factor is at most 100.
fn per_mean(map: &MaterialMap) -> [f32; 4] {
    let codes = Codes::new();
    let sum = map.colors.iter().fold([0.0f64; 3], |sum, &texel| {
        let [r, g, b, _] = codes.linear(texel).map(f64::from);
        [sum[0] + r, sum[1] + g, sum[2] + b]
    });
    let [r, g, b] = sum.map(|channel| (map.colors.len() as f64 / channel.max(1e-9)).min(100.0) as f32);
    [r, g, b, 0.04]
}

fn mask_image(gpu: &Arc<Gpu>, name: &str, mask: Option<FactorMap>) -> Result<Image> {
    let none = FactorMap { width: 1, height: 1, texels: vec![1.0], transform: Affine2::IDENTITY };
    let FactorMap { width, height, texels, .. } = mask.unwrap_or(none);
    if u64::from(width) * u64::from(height) != texels.len() as u64 {
        let fault = format!("{} mask texels do not match {width}x{height}", texels.len());
        return Err(GpuError::usage(name, fault));
    }
    let desc = ImageDesc::new(HALF_FORMAT, width, height).full_mips();
    let image = Image::new(gpu, &format!("{name} mask"), desc)?;
    let squares = texels.iter().map(|&m| [m, m * m, 0.0, 0.0]).collect();
    write_mips(&image, [width, height], squares, halves, halve)?;
    Ok(image)
}
