//! The placeholders for missing maps. Shaders never read them, so all objects share one set.

use std::sync::Arc;

use super::atlas::AtlasGpu;
use super::classes::ClassImages;
use super::detail::DetailImages;
use super::displacement::HeightField;
use super::horizon::HorizonMaps;
use super::material::MaterialImages;
use super::moments::{LeadrMapGpu, MomentFormat};
use leadr_gpu::{Gpu, Result};

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
    /// The images for relief with one class.
    pub classes: ClassImages,
}

impl Placeholders {
    /// Uploads the placeholders.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let HeightField { map, border } = HeightField::flat();
        let leadr = LeadrMapGpu::new(gpu, &map, border, MomentFormat::Float32)?;
        let material = MaterialImages::none(gpu)?;
        let detail = Arc::new(DetailImages::none(gpu, &leadr, &material)?);
        Ok(Self {
            horizons: HorizonMaps::none(gpu)?,
            leadr,
            atlas: AtlasGpu::none(gpu)?,
            material,
            detail,
            classes: ClassImages::none(gpu)?,
        })
    }
}
