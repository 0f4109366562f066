//! The environment, a cube map of radiance with all mips that is made from an equirectangular image or from the analytic sky.
//!
//! The texels are RGBA32F with alpha 1, so means and irradiance are exact up to rounding. Measured environments contain suns
//! brighter than 65504, which half floats would clamp or make infinite. Most pixels sample the [`CubeLobes`] instead of this cube.
//!
//! Directions are world directions with z up, and are used directly with a cube sampler. Faces are in Vulkan's order.

use std::sync::Arc;

use super::cube_lobes::CubeLobes;
use super::cube_mips::CubeMips;
use super::equirect;
use super::equirect::EquirectPass;
use super::irradiance_rest::IrradianceRest;
use super::panorama::{EnvironmentLight, LightExtraction, split};
use super::sky::Sky;
use super::sky_pass::SkyPass;
use leadr_gpu::vk::Format;
use leadr_gpu::{Commands, Gpu, GpuError, Image, ImageDesc, ImageView, Result, Use};
use leadr_maps::RgbImage;

/// The largest face size, in texels, of the [`CubeLobes`] for the analytic sky, which are made again whenever the sun moves. The
/// finest detail is the horizon ([`HORIZON`](super::constants::HORIZON)), which is 1.3 texels wide.
const SKY_LOBES: u32 = 128;

/// An upper bound on the radiance of the analytic sky at intensity 1 (measured: 4.3). Half floats leave room for intensities in the
/// hundreds.
const BRIGHTEST_SKY: f32 = 100.0;

/// A cube map of radiance with all mips. Between recordings, it is always in `Use::Sampled`.
pub struct Environment {
    cube: Image,
    levels: Vec<ImageView>,
    mips: CubeMips,
    lobes: CubeLobes,
    rest: IrradianceRest,
    /// The pass that draws the sky into the cube, or `None` for an image.
    sky: Option<SkyPass>,
    /// The sky that the cube currently contains.
    shown: Option<Sky>,
    lights: Vec<EnvironmentLight>,
    /// The cube including the extracted lights, for the background, with a single level, or `None` without extracted lights.
    background: Option<Image>,
}

impl Environment {
    /// The default face size in texels. A texel covers 0.35°, as in a panorama with a width of 1024 texels.
    pub const FACE_SIZE: u32 = 256;

    /// Creates an environment of the analytic sky, and fills its cube.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] unless `face_size` is a power of two. Also returns [`GpuError::Allocation`], or the error of a
    /// failed submission.
    pub fn from_sky(gpu: &Arc<Gpu>, face_size: u32, sky: &Sky) -> Result<Self> {
        let lobes = CubeLobes::new(gpu, face_size, face_size.min(SKY_LOBES), true, BRIGHTEST_SKY * sky.intensity)?;
        let mut environment = Self::new(gpu, face_size, lobes, Some(SkyPass::new(gpu)?))?;
        gpu.submit("sky", |cmd| environment.update_sky(cmd, sky))?;
        Ok(environment)
    }

    /// Creates an environment from an equirectangular panorama. The top row is +z, the centre is +x, and columns run clockwise seen
    /// from above. Texels must be finite, as the loaders of `maps` guarantee. Up to four small, bright regions become directional
    /// [`lights`](Self::lights) that cast shadows. The cube contains the remaining light.
    pub fn from_equirect(gpu: &Arc<Gpu>, face_size: u32, image: &RgbImage) -> Result<Self> {
        Self::from_panorama(gpu, face_size, image, LightExtraction::default())
    }

    /// Like `from_equirect`, with parameters for the light extraction.
    pub fn from_panorama(gpu: &Arc<Gpu>, face_size: u32, image: &RgbImage, lights: LightExtraction) -> Result<Self> {
        let pass = EquirectPass::new(gpu)?;
        let parts = split(image, lights);
        let upload = |(width, height, texels): (u32, u32, Vec<[f32; 4]>)| {
            let upload = Image::new(gpu, "equirect", ImageDesc::new(Format::R32G32B32A32_SFLOAT, width, height))?;
            upload.write(0, 0, &texels)?;
            Ok::<_, GpuError>(upload)
        };
        let rest = equirect::prepare(image, &parts.rest, face_size);
        let brightest = rest.2.iter().fold(0.0f32, |most, texel| most.max(texel[0]).max(texel[1]).max(texel[2]));
        let lobes = CubeLobes::new(gpu, face_size, face_size, false, brightest)?;
        let mut environment = Self::new(gpu, face_size, lobes, None)?;
        let rest = upload(rest)?;
        gpu.submit("equirect", |cmd| {
            environment.begin(cmd, |cmd, faces| pass.record(cmd, rest.whole(), faces));
            environment.make_mips(cmd);
        })?;
        if !parts.lights.is_empty() {
            let whole = upload(equirect::prepare(image, &[], face_size))?;
            let desc = ImageDesc::new(Format::R32G32B32A32_SFLOAT, face_size, face_size).cube().storage();
            let background = Image::new(gpu, "background", desc)?;
            let faces = background.mip_array(0)?;
            gpu.submit("background", |cmd| {
                cmd.image_barrier(&background, Use::Undefined, Use::ComputeReadWrite);
                pass.record(cmd, whole.whole(), &faces);
                cmd.transition(&background, Use::Sampled);
            })?;
            environment.background = Some(background);
        }
        environment.lights = parts.lights;
        Ok(environment)
    }

    fn new(gpu: &Arc<Gpu>, face_size: u32, lobes: CubeLobes, sky: Option<SkyPass>) -> Result<Self> {
        // The cube of a sky may change every frame, but needs fewer texels because a sky is smooth.
        let rest_size = if sky.is_some() { 8 } else { 16 };
        if !face_size.is_power_of_two() {
            let fault = format!("a face size of {face_size} texels is not a power of two: choose one that is");
            return Err(GpuError::usage("environment", fault));
        }
        let desc = ImageDesc::new(Format::R32G32B32A32_SFLOAT, face_size, face_size).cube().full_mips().storage();
        let cube = Image::new(gpu, "environment", desc)?;
        let levels = (0..desc.mips).map(|mip| cube.mip_array(mip)).collect::<Result<Vec<_>>>()?;
        let (mips, rest) = (CubeMips::new(gpu)?, IrradianceRest::new(gpu, rest_size)?);
        Ok(Self { cube, levels, mips, lobes, rest, sky, shown: None, lights: Vec::new(), background: None })
    }

    /// Records the sky pass and the mips if `sky` differs from the content of the cube, and returns whether it did. Call it every
    /// frame. The cube then counts as up to date, so the commands must be submitted. An environment made from an image stays
    /// unchanged.
    #[doc(hidden)]
    pub fn update_sky(&mut self, cmd: &mut Commands, sky: &Sky) -> bool {
        let moved = self.begin_sky(cmd, sky);
        if moved {
            self.make_mips(cmd);
        }
        moved
    }

    /// Records the first half of [`update_sky`](Self::update_sky), which is the finest level. If it returns true, record
    /// [`make_mips`](Self::make_mips) before reading the cube.
    #[doc(hidden)]
    pub fn begin_sky(&mut self, cmd: &mut Commands, sky: &Sky) -> bool {
        let Some(pass) = self.sky.as_ref().filter(|_| self.shown != Some(*sky)) else { return false };
        self.begin(cmd, |cmd, faces| pass.record(cmd, sky, faces));
        self.shown = Some(*sky);
        true
    }

    /// Marks the cube as outdated, in case recorded commands were not executed. The next [`update_sky`](Self::update_sky) then
    /// draws the sky again.
    pub(crate) fn invalidate_sky(&mut self) {
        self.shown = None;
    }

    /// Records the second half of `update_sky`, which derives the mips, the blurred levels, and the irradiance beyond order 2 from
    /// the finest level.
    #[doc(hidden)]
    pub fn make_mips(&self, cmd: &mut Commands) {
        self.mips.record(cmd, &self.levels);
        cmd.transition(&self.cube, Use::Sampled);
        self.lobes.record(cmd, &self.cube);
        self.rest.record(cmd, &self.levels);
    }

    /// Prepares the finest level for writing, and calls `record` to overwrite it.
    fn begin(&self, cmd: &mut Commands, record: impl FnOnce(&mut Commands, &ImageView)) {
        // This barrier discards the old content, but waits for its readers.
        cmd.image_barrier(&self.cube, Use::Undefined, Use::ComputeReadWrite);
        record(cmd, &self.levels[0]);
    }

    /// Returns the directional lights extracted from the image, which the cube does not contain. There are none for the analytic
    /// sky, whose sun is never in the cube.
    pub fn lights(&self) -> &[EnvironmentLight] {
        &self.lights
    }

    /// Returns the cube map for the background, which includes the extracted lights. Only its finest level may be read.
    #[doc(hidden)]
    pub fn background(&self) -> &ImageView {
        self.background.as_ref().unwrap_or(&self.cube).whole()
    }

    /// Returns the cube map, for `samplerCube`.
    #[doc(hidden)]
    pub fn cube(&self) -> &ImageView {
        self.cube.whole()
    }

    /// Returns the blurred cube map of the environment, from which a few lookups are enough
    /// ([`kernel`](leadr_reflectance::visible::kernel)).
    #[doc(hidden)]
    pub fn lobes(&self) -> &Image {
        &self.lobes.cube
    }

    /// Returns the cube map of the irradiance beyond order 2. Add it to the order-2 irradiance for the same normal.
    #[doc(hidden)]
    pub fn irradiance_rest(&self) -> &Image {
        &self.rest.cube
    }

    /// Returns the image of the cube.
    #[doc(hidden)]
    pub fn image(&self) -> &Image {
        &self.cube
    }

    /// Returns one mip level as an array of six faces.
    #[doc(hidden)]
    pub fn level(&self, mip: u32) -> &ImageView {
        &self.levels[(mip as usize).min(self.levels.len() - 1)]
    }

    /// Returns the number of mip levels, down to 1 × 1.
    #[doc(hidden)]
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Returns the face size in texels.
    #[doc(hidden)]
    pub fn face_size(&self) -> u32 {
        self.cube.desc().width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sky_is_brighter_than_stated() {
        let mut brightest = 0.0f64;
        for elevation in [-0.05f32, 0.0, 0.05, 0.2, 0.7, 1.5] {
            for turbidity in [1.0, 2.2, 10.0] {
                let sky = Sky { turbidity, ..Sky::with_sun(elevation, 0.3) };
                let (tables, sun) = (sky.tables(), sky.sun_direction.as_dvec3());
                let about = (0..400).map(|i| {
                    let (turn, reach) = (f64::from(i) * 2.4, f64::from(i) * 0.004);
                    (sun + reach * glam::DVec3::new(turn.cos(), turn.sin(), (1.3 * turn).sin())).normalize()
                });
                brightest = about.map(|d| tables.radiance(d).max_element()).fold(brightest, f64::max);
            }
        }
        println!("the brightest sky: {brightest:.1}");
        assert!(brightest > 1.0 && brightest < f64::from(BRIGHTEST_SKY), "{brightest}");
    }
}
