//! What stands for the maps that objects lack. Shaders of such objects do not read it, so all objects share it.

use std::sync::Arc;

use super::atlas::AtlasGpu;
use super::detail::DetailImages;
use super::displacement::HeightField;
use super::horizon::HorizonMaps;
use super::material::{MaterialImages, none_weighted};
use super::moments::{LeadrMapGpu, MomentFormat};
use leadr_gpu::{Gpu, Image, Result};

/// Placeholders on a device.
pub struct Placeholders {
    /// Of a surface without relief.
    pub leadr: LeadrMapGpu,
    /// Of one whose bumps hide nothing.
    pub horizons: HorizonMaps,
    /// Of one whose maps are no atlas.
    pub atlas: AtlasGpu,
    /// Of one without a material; parts of it stand for those that a material lacks.
    pub material: MaterialImages,
    /// Of one without a finer relief.
    pub detail: Arc<DetailImages>,
    /// Of colours that follow no relief.
    pub weighted: Image,
}

impl Placeholders {
    /// Uploads them.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let HeightField { map, border } = HeightField::flat();
        let leadr = LeadrMapGpu::new(gpu, &map, border, MomentFormat::Float32)?;
        let (material, weighted) = (MaterialImages::none(gpu)?, none_weighted(gpu)?);
        let detail = Arc::new(DetailImages::none(gpu, &leadr, &material)?);
        let atlas = AtlasGpu::none(gpu, &weighted)?;
        Ok(Self { horizons: HorizonMaps::none(gpu)?, leadr, atlas, material, detail, weighted })
    }
}
