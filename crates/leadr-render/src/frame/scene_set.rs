//! The descriptor set of a frame's light, which all passes that shade share.

use std::sync::Arc;

use crate::light::environment::Environment;
use crate::light::irradiance::IrradiancePass;
use crate::light::sky_visibility::SkyVisibilityGpu;
use crate::sets::SCENE;
use crate::surfaces::fits::Fits;
use crate::surfaces::media::Media;
use leadr_gpu::{AddressMode, Buffer, Descriptor, Filter, Gpu, ImageView, Memory, ResourceSet, Result, Sampler};
use leadr_reflectance::materials::energy::EnergyTable;

/// The tables of a scene that stay the same in all frames.
pub struct SceneTables {
    energies: Buffer,
    fits: Buffer,
    media: Buffer,
    /// A placeholder that is bound while sky occlusion is off.
    no_sky: Buffer,
    nearest: Sampler,
    trilinear: Sampler,
}

/// The parts of a frame's light that neither the scene's tables nor the environment contain.
pub struct FrameLight<'a> {
    /// The buffer of the [`LightingGpu`](crate::passes::shade::LightingGpu) block.
    pub lighting: &'a Buffer,
    /// The buffer of the frame's [lamps](crate::passes::lamps).
    pub lamps: &'a Buffer,
    /// The shadow maps, with one layer per light.
    pub shadow_maps: &'a ImageView,
    /// The sky visibility, if the frame is shaded with it.
    pub sky: Option<&'a Buffer>,
}

impl SceneTables {
    /// Uploads the tables for a scene with these measured materials and media.
    pub fn new(gpu: &Arc<Gpu>, fits: &Fits, media: &Media) -> Result<Self> {
        let energies = [EnergyTable::ggx(), EnergyTable::beckmann()].map(|table| table.texels().concat()).concat();
        let (fits, media) = (fits.words(), media.words());
        Ok(Self {
            energies: Buffer::from_slice(gpu, "energies of facets", &energies)?,
            fits: Buffer::from_slice(gpu, "measured materials", if fits.is_empty() { &[0.0] } else { &fits[..] })?,
            media: Buffer::from_slice(gpu, "media", if media.is_empty() { &[[0.0; 4]] } else { &media[..] })?,
            no_sky: Buffer::new(gpu, "no sky visibility", size_of::<SkyVisibilityGpu>() as u64, Memory::Upload)?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
            trilinear: Sampler::new(gpu, Filter::Trilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Creates the descriptor set of a frame.
    pub fn set(
        &self,
        gpu: &Arc<Gpu>,
        environment: &Environment,
        irradiance: &IrradiancePass,
        light: &FrameLight<'_>,
    ) -> Result<ResourceSet> {
        let of_environment = |view| Descriptor::Sampled(view, &self.trilinear);
        ResourceSet::new(
            gpu,
            &SCENE,
            &[
                ("lighting", Descriptor::Uniform(light.lighting)),
                ("Lamps", Descriptor::Storage(light.lamps)),
                ("shadow_maps", Descriptor::Sampled(light.shadow_maps, &self.nearest)),
                ("environment_cube", of_environment(environment.cube())),
                ("environment_lobes", of_environment(environment.lobes().whole())),
                ("irradiance_rest", of_environment(environment.irradiance_rest().whole())),
                ("background_cube", of_environment(environment.background())),
                ("Harmonics", Descriptor::Storage(irradiance.coefficients())),
                ("SkyVisibility", Descriptor::Storage(light.sky.unwrap_or(&self.no_sky))),
                ("Energies", Descriptor::Storage(&self.energies)),
                ("Fits", Descriptor::Storage(&self.fits)),
                ("Media", Descriptor::Storage(&self.media)),
            ],
        )
    }
}
