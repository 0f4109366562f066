//! Placeholders for missing maps. Shaders never read them, so all objects share one set.

use std::sync::Arc;

use super::atlas::AtlasGpu;
use super::detail::DetailImages;
use super::displacement::HeightField;
use super::horizon::HorizonMaps;
use super::material::{MaterialImages, none_weighted};
use super::moments::{LeadrMapGpu, MomentFormat};
use leadr_gpu::{Gpu, Image, Result};

/// The placeholders on a device.
pub struct Placeholders {
    /// LEADR maps for surfaces without relief.
    pub leadr: LeadrMapGpu,
    /// Horizon maps for surfaces without horizons.
    pub horizons: HorizonMaps,
    /// Links and coarse levels for maps that are not an atlas.
    pub atlas: AtlasGpu,
    /// Images for missing materials or material images.
    pub material: MaterialImages,
    /// Detail images for surfaces without a detail.
    pub detail: Arc<DetailImages>,
    /// Weighted colours for colours that do not follow the relief.
    pub weighted: Image,
}

impl Placeholders {
    /// Uploads the placeholders.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let HeightField { map, border } = HeightField::flat();
        let leadr = LeadrMapGpu::new(gpu, &map, border, MomentFormat::Float32)?;
        let (material, weighted) = (MaterialImages::none(gpu)?, none_weighted(gpu)?);
        let detail = Arc::new(DetailImages::none(gpu, &leadr, &material)?);
        let atlas = AtlasGpu::none(gpu, &weighted)?;
        Ok(Self { horizons: HorizonMaps::none(gpu)?, leadr, atlas, material, detail, weighted })
    }
}
