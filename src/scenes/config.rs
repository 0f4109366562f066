//! What is drawn and how: a scene, its light, the view, and the settings of the picture.

use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

use super::light::{EnvironmentChoice, SunDirection};
use super::model::displacement::Displacement;
use super::ocean::waves::Waves;
use super::registry::{SCENES, Scene};
use super::view::{Size, View};
use crate::maps::MapError;
use crate::maps::material::{Material, MaterialFolder};
use crate::render::light::panorama::LightExtraction;
use crate::render::settings::{RenderSettings, Shading};
use crate::render::surfaces::moments::MomentFormat;
use crate::render::surfaces::tessellation::TessellationSettings;

/// The files that a material of the plane or sphere is read from.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MaterialFiles {
    /// A folder as it is downloaded; the other files come in place of what it has.
    #[serde(rename = "material")]
    pub folder: Option<PathBuf>,
    /// Base colour.
    pub color_map: Option<PathBuf>,
    /// Fine slopes.
    pub normal_map: Option<PathBuf>,
    /// Perceptual roughness.
    pub roughness_map: Option<PathBuf>,
}

impl MaterialFiles {
    /// Reads them, with `heights` in place of the folder's own; `None` where no file is named, whatever the heights.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong kind.
    pub fn load(&self, heights: Option<&Path>) -> Result<Option<Material>, MapError> {
        if *self == Self::default() {
            return Ok(None);
        }
        let mut material = self.load_over(Material::new("material"))?;
        if let Some(file) = heights {
            material.set_heights(file)?;
        }
        Ok(Some(material))
    }

    /// Reads them in place of what `material` has. A folder brings everything but heights that it has none of.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong kind.
    pub fn load_over(&self, mut material: Material) -> Result<Material, MapError> {
        if let Some(folder) = &self.folder {
            let folder = MaterialFolder::open(folder)?;
            folder.remarks.iter().for_each(|remark| tracing::warn!("{remark}"));
            let relief = material.relief.take();
            material = folder.load()?;
            material.relief = relief.or(material.relief);
        }
        if let Some(file) = &self.color_map {
            material.set_colors(file)?;
        }
        if let Some(file) = &self.normal_map {
            material.set_normals(file, None)?;
        }
        if let Some(file) = &self.roughness_map {
            material.set_roughness(file, false)?;
        }
        Ok(material)
    }
}

/// Samples of the geometry in each pixel of pictures of one sample, unless something else makes outlines smooth.
pub const DEFAULT_MSAA: u32 = 4;

/// A picture of a scene. Written as JSON, its fields have the names of the command's flags.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneConfig {
    /// Which scene.
    pub scene: &'static Scene,
    /// The glTF file, where the scene is one.
    pub model: Option<PathBuf>,
    /// The animation that it plays, instead of its first.
    pub animation: Option<String>,
    /// Name or number of its camera, where it is seen by one and not by the first.
    pub model_camera: Option<String>,
    /// Whether missing and damaged images of it are replaced.
    pub lenient: bool,
    /// Height maps of its materials.
    pub displacements: Vec<Displacement>,
    /// Height map of the plane or sphere.
    pub height_map: Option<PathBuf>,
    /// Files of its material.
    #[serde(flatten)]
    pub material: MaterialFiles,
    /// Whether the plane or sphere stands alone, without anything around it.
    pub bare: bool,
    /// The waves of the ocean.
    pub waves: Waves,
    /// Factor on the displacement, 0 or more.
    pub height_scale: f32,
    /// Light from all around.
    pub environment: EnvironmentChoice,
    /// What of a picture of the environment becomes lights.
    #[serde(flatten)]
    pub environment_lights: LightExtraction,
    /// Direction to the sun at the beginning.
    pub sun: SunDirection,
    /// Hour of the day at the beginning, instead of `sun`.
    pub time_of_day: Option<f32>,
    /// Seconds in which the sun goes once round the sky; `None` if it stands still.
    pub day_length: Option<f32>,
    /// How the surface is filtered and shaded.
    #[serde(flatten)]
    pub shading: Shading,
    /// Whether heights move the surface.
    pub displacement: bool,
    /// Screen pixels per triangle.
    pub triangle_pixels: f32,
    /// Where it is seen from.
    pub view: View,
    /// Distance to the camera's target, metres, instead of the view's own.
    pub distance: Option<f32>,
    /// Size of the picture.
    pub size: Size,
    /// Samples per pixel.
    pub samples: u32,
    /// Samples of the geometry in each pixel: 1, 2, 4 or 8.
    pub msaa: u32,
    /// Seed of the sample positions.
    pub seed: u64,
    /// Exposure of a PNG or a window, stops above what suits the height of the sun.
    pub exposure: f32,
    /// Texels along an atlas tile: a power of two, 8 to 128.
    pub atlas_tile: u32,
    /// How slopes of maps are kept on the device.
    #[serde(serialize_with = "name_of_format")]
    pub map_precision: MomentFormat,
    /// Beckmann roughness of the displaced surfaces instead of the scene's own.
    pub roughness: Option<f32>,
}

fn name_of_format<S: Serializer>(format: &MomentFormat, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(format.name())
}

impl Default for SceneConfig {
    /// The first scene as the command draws it without flags.
    fn default() -> Self {
        Self {
            scene: &SCENES[0],
            model: None,
            animation: None,
            model_camera: None,
            lenient: false,
            displacements: Vec::new(),
            height_map: None,
            material: MaterialFiles::default(),
            bare: false,
            waves: Waves::default(),
            height_scale: 1.0,
            environment: EnvironmentChoice::Sky,
            environment_lights: LightExtraction::default(),
            sun: SunDirection { azimuth: -50.0, elevation: 38.0 },
            time_of_day: None,
            day_length: None,
            shading: Shading::default(),
            displacement: true,
            triangle_pixels: 4.0,
            view: View::Mid,
            distance: None,
            size: Size { width: 1280, height: 720 },
            samples: 4,
            msaa: 1,
            seed: 0,
            exposure: 0.0,
            atlas_tile: 64,
            map_precision: MomentFormat::default(),
            roughness: None,
        }
    }
}

impl SceneConfig {
    /// The part that the renderer takes.
    #[must_use]
    pub fn render_settings(&self) -> RenderSettings {
        RenderSettings {
            size: (self.size.width, self.size.height),
            samples: self.samples,
            msaa: self.msaa,
            seed: self.seed,
            shading: self.shading,
            displacement: self.displacement,
            tessellation: TessellationSettings {
                pixels_per_triangle: self.triangle_pixels,
                to_texels: self.shading.technique().is_reference(),
                ..Default::default()
            },
            ..Default::default()
        }
    }
}
