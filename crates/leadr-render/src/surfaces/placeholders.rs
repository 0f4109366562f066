//! The placeholders for missing maps. Shaders never read them, so all objects share one set.

use std::sync::Arc;

use super::atlas::AtlasGpu;
use super::classes::ClassImages;
use super::detail::DetailImages;
use super::displacement::HeightField;
use super::horizon::HorizonMaps;
use super::material::{MaterialImages, none_weighted};
use super::moments::{LeadrMapGpu, MomentFormat};
use leadr_gpu::{Gpu, Image, Result};

/// The placeholders on a device.
pub struct Placeholders {
    /// The LEADR maps for surfaces without relief.
    pub leadr: LeadrMapGpu,
    /// The horizon maps for surfaces without horizons.
    pub horizons: HorizonMaps,
    /// The links and the coarse levels for maps that are not an atlas.
    pub atlas: AtlasGpu,
    /// The images for objects or materials that lack them.
    pub material: MaterialImages,
    /// The detail images for surfaces without a detail.
    pub detail: Arc<DetailImages>,
    /// The weighted colours for surfaces whose colours do not follow the relief.
    pub weighted: Image,
    /// The images for relief with one class.
    pub classes: ClassImages,
}

impl Placeholders {
    /// Uploads the placeholders.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let HeightField { map, border } = HeightField::flat();
        let leadr = LeadrMapGpu::new(gpu, &map, border, MomentFormat::Float32)?;
        let (material, weighted) = (MaterialImages::none(gpu)?, none_weighted(gpu)?);
        let detail = Arc::new(DetailImages::none(gpu, &leadr, &material)?);
        let atlas = AtlasGpu::none(gpu, &weighted)?;
        Ok(Self {
            horizons: HorizonMaps::none(gpu)?,
            leadr,
            atlas,
            material,
            detail,
            weighted,
            classes: ClassImages::none(gpu)?,
        })
    }
}
