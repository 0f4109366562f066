//! The configuration of a picture: scene, light, view and render settings.

use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

use super::fitted::material_of;
use super::light::{EnvironmentChoice, SunDirection};
use super::model::Ground;
use super::model::cones::MaterialCones;
use super::model::displacement::Displacement;
use super::model::measured::MeasuredMaterial;
use super::ocean::waves::Waves;
use super::options::SceneOption;
use super::placed_light::PlacedLight;
use super::registry::{NamedScene, SCENES};
use super::trex::stage::SkinRelief;
use super::view::{Size, ViewChoice};
use leadr_maps::Rgb8Image;
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{
    Anisotropy, ClearCoat, Encoding, GreenAxis, Input, Material, MaterialDetail, MaterialFolder, Role,
    RoughnessMeaning, Texture, Transmission, agreement, f0_of_ior, role_of,
};
use leadr_maps::shown::shown_path;
use leadr_maps::tonemap::{Tonemap, display_srgb8, dithered_srgb8};
use leadr_maps::{MapError, MapFault, Wrap, load_raster};
use leadr_measured::fit_file::FitFile;
use leadr_reflectance::facets::metals::Metal;
use leadr_render::light::panorama::LightExtraction;
use leadr_render::named_enum;
use leadr_render::scene::{CoatRelief, Tiling};
use leadr_render::settings::{RenderSettings, Shading, ShadingOptions, Technique};
use leadr_render::surfaces::moments::MomentFormat;
use leadr_render::surfaces::tessellation::TessellationSettings;

/// The input files for the material of the plane or sphere.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MaterialFiles {
    /// The folder of a downloaded material. The individual files below override the files of the folder.
    #[serde(rename = "material")]
    pub folder: Option<PathBuf>,
    /// The base colour map.
    pub color_map: Option<PathBuf>,
    /// The normal map.
    pub normal_map: Option<PathBuf>,
    /// The perceptual roughness map.
    pub roughness_map: Option<PathBuf>,
    /// The ambient occlusion map.
    pub occlusion_map: Option<PathBuf>,
    /// The map of ambient occlusion cones.
    pub cone_map: Option<PathBuf>,
    /// The direction of the normal map's green channel; with `None`, it is detected from the file name or the slopes.
    pub normal_y: Option<NormalY>,
    /// The metal that replaces the material's colours and metalness.
    pub metal: Option<&'static str>,
    /// The anisotropy strength, 0 to 1.
    pub anisotropy: Option<f32>,
    /// The counter-clockwise rotation of the anisotropy direction in degrees.
    pub anisotropy_rotation: f32,
    /// The weight of the clear coat, 0 to 1, and its Beckmann roughness.
    pub clear_coat: Option<[f32; 2]>,
    /// The relief of the clear coat.
    pub clear_coat_relief: CoatRelief,
    /// The fraction of light that passes through the surface, 0 to 1.
    pub transmission: Option<f32>,
    /// The refractive index, 1 to 4.
    pub ior: Option<f32>,
    /// The thickness of the body in metres, or 0 for a thin wall.
    pub thickness: f32,
    /// The colour of the body, and the distance in metres after which white light has this colour.
    pub attenuation: Option<([f32; 3], f32)>,
    /// The detail, which repeats more often than the base material.
    #[serde(flatten)]
    pub detail: DetailFiles,
}

/// The refractive index of a material for which none is given, as in glTF.
pub const DEFAULT_IOR: f32 = 1.5;

named_enum! {
    /// The direction of a normal map's green channel.
    pub enum NormalY {
        /// The green channel points up, as in OpenGL and glTF.
        Up = "up", "Up, as in OpenGL and glTF";
        /// The green channel points down, as in DirectX.
        Down = "down", "Down, as in DirectX";
    }
}

impl From<NormalY> for GreenAxis {
    fn from(way: NormalY) -> Self {
        match way {
            NormalY::Up => Self::Up,
            NormalY::Down => Self::Down,
        }
    }
}

/// The files of a detail over the material of the plane or sphere, or over every material of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DetailFiles {
    /// A material folder, a height map or a normal map of the detail.
    pub detail: Option<PathBuf>,
    /// The number of repeats of the detail per repeat of the material.
    pub detail_repeat: f32,
    /// The counter-clockwise rotation of the detail in degrees.
    pub detail_rotation: f32,
    /// The factor on the slopes of the detail.
    pub detail_height_scale: f32,
    /// Whether the heights of the detail displace the surface.
    pub detail_displaces: bool,
    /// The mask of the area that shows the detail.
    pub detail_mask: Option<PathBuf>,
}

impl Default for DetailFiles {
    fn default() -> Self {
        Self {
            detail: None,
            detail_repeat: 8.0,
            detail_rotation: 0.0,
            detail_height_scale: 1.0,
            detail_displaces: false,
            detail_mask: None,
        }
    }
}

impl DetailFiles {
    /// Loads the files; `None` without a detail.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong type.
    pub fn load(&self, links: OutsideLinks) -> Result<Option<MaterialDetail>, MapError> {
        let Some(path) = &self.detail else { return Ok(None) };
        let (material, colored) = if path.is_dir() {
            let folder = MaterialFolder::open(path, links)?;
            folder.remark().iter().for_each(|remark| tracing::warn!("{remark}"));
            let colored = [Role::Color, Role::Roughness, Role::Gloss];
            let colored = colored.iter().any(|&role| folder.picture(role).is_some());
            if folder.picture(Role::Metalness).is_some() {
                tracing::warn!("{}: the metalness of a detail is not used", shown_path(path));
            }
            let mut material = folder.load()?;
            material.metalness = Input::constant(0.0);
            (material, colored)
        } else {
            let mut material = Material::new("detail");
            match role_of(path) {
                Some(Role::NormalUp) => material.set_normals(path, Some(GreenAxis::Up))?,
                Some(Role::NormalDown) => material.set_normals(path, Some(GreenAxis::Down))?,
                Some(Role::Normal) => material.set_normals(path, None)?,
                _ => material.set_heights(path)?,
            }
            (material, false)
        };
        if self.detail_displaces && material.relief.is_none() {
            let remedy = "give --detail heights, or remove --detail-displaces";
            return Err(
                MapFault::unsupported("the detail has no heights to displace the surface", remedy).in_file(path)
            );
        }
        let mask = match &self.detail_mask {
            Some(file) => Some(Texture::new(load_raster(file)?, shown_path(file), Encoding::Linear)),
            None => None,
        };
        Ok(Some(MaterialDetail {
            material,
            colored,
            repeat: self.detail_repeat,
            rotation: self.detail_rotation,
            height_scale: self.detail_height_scale,
            displaces: self.detail_displaces,
            mask,
        }))
    }
}

impl MaterialFiles {
    /// Loads the material, with `heights` in place of the folder's own; `None` if no material file is set, even with `heights`. `links`
    /// applies to files in folders.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong type.
    pub fn load(&self, heights: Option<&Path>, links: OutsideLinks) -> Result<Option<Material>, MapError> {
        if *self == Self::default() {
            return Ok(None);
        }
        let mut material = self.load_over(Material::new("material"), links)?;
        if let Some(file) = heights {
            material.set_heights(file)?;
        }
        Ok(Some(material))
    }

    /// Loads the files over `material`. A folder replaces every property. If the folder has no heights, the existing heights are kept.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong type.
    pub fn load_over(&self, mut material: Material, links: OutsideLinks) -> Result<Material, MapError> {
        if let Some(file) = self.folder.as_ref().filter(|path| path.is_file()) {
            let (relief, slope_moments) = (material.relief.take(), material.slope_moments.take());
            let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            material = material_of(&FitFile::load(file)?, &name);
            (material.relief, material.slope_moments) = (relief, slope_moments);
        } else if let Some(folder) = &self.folder {
            let folder = MaterialFolder::open(folder, links)?;
            folder.remark().iter().for_each(|remark| tracing::warn!("{remark}"));
            let (relief, slope_moments) = (material.relief.take(), material.slope_moments.take());
            material = folder.load()?;
            material.relief = relief.or(material.relief);
            material.slope_moments = slope_moments;
        }
        if let Some(file) = &self.color_map {
            material.set_colors(file)?;
        }
        if let Some(file) = &self.normal_map {
            material.set_normals(file, None)?;
        }
        match (&mut material.normal_map, self.normal_y) {
            (Some(map), Some(way)) => map.green = way.into(),
            (None, Some(_)) => {
                let fault = MapFault::Unsupported {
                    what: "it has no normal map for --normal-y to apply to".into(),
                    remedy: "remove --normal-y".into(),
                };
                return Err(fault.in_file(self.folder.as_deref().unwrap_or(Path::new("material"))));
            }
            (_, None) => {}
        }
        if let Some(file) = &self.roughness_map {
            material.set_roughness(file, false)?;
        }
        if let Some(file) = &self.occlusion_map {
            material.set_occlusion(file)?;
        }
        if let Some(file) = &self.cone_map {
            material.set_cones(file)?;
        }
        if let Some(metal) = self.metal.and_then(Metal::named) {
            material.base_color = Input::constant(metal.f0().as_vec3().to_array());
            material.metalness = Input::constant(1.0);
            material.edge_tint = metal.edge_tint().as_vec3().to_array();
        }
        if let Some(strength) = self.anisotropy {
            let rotation = self.anisotropy_rotation.to_radians();
            material.anisotropy = Some(Anisotropy { strength: Input::constant(strength), rotation, direction: None });
        }
        if let Some([weight, alpha]) = self.clear_coat {
            material.coat = Some(ClearCoat {
                weight: Input::constant(weight),
                roughness: Input::constant(alpha),
                roughness_meaning: RoughnessMeaning::Alpha,
                follows_relief: self.clear_coat_relief == CoatRelief::Base,
                normal_map: None,
            });
        }
        if let Some(ior) = self.ior {
            material.f0 = Input::constant([f0_of_ior(ior); 3]);
        }
        if let Some(weight) = self.transmission {
            if self.folder.is_none() && material.base_color.texture.is_none() {
                // Glass without a material is colourless.
                material.base_color = Input::constant([1.0; 3]);
            }
            let (attenuation_color, attenuation_distance) = self.attenuation.unwrap_or(([1.0; 3], f32::INFINITY));
            let (ior, thickness) = (self.ior.unwrap_or(DEFAULT_IOR), self.thickness);
            material.transmission =
                Some(Transmission { weight, ior, thickness, attenuation_color, attenuation_distance });
        }
        material.detail = self.detail.load(links)?.map(Box::new);
        Ok(material)
    }

    /// Opens the folder. Returns `None` if it cannot be read.
    fn opened(&self) -> Option<MaterialFolder> {
        let folder = self.folder.as_ref().filter(|path| !path.is_file())?;
        // Only names matter here. Loading checks the links.
        MaterialFolder::open(folder, OutsideLinks::Followed).ok()
    }

    /// Whether the material has a relief, from `heights` or from its folder.
    pub fn is_displaced(&self, heights: Option<&Path>) -> bool {
        heights.is_some() || self.opened().is_some_and(|folder| folder.picture(Role::Height).is_some())
    }

    /// Whether the material has a normal map, but neither heights nor a detail.
    pub fn is_normal_map_alone(&self, heights: Option<&Path>) -> bool {
        let folder = self.opened();
        let has = |role| folder.as_ref().is_some_and(|folder| folder.picture(role).is_some());
        let normals = [Role::Normal, Role::NormalUp, Role::NormalDown].into_iter().any(has);
        (normals || self.normal_map.is_some())
            && !has(Role::Height)
            && heights.is_none()
            && self.detail.detail.is_none()
    }
}

/// Logs how well the heights and normals of a material agree.
pub(super) fn log_slope_agreement(material: &Material) {
    let (Some(relief), Some(normals)) = (&material.relief, &material.normal_map) else { return };
    match agreement(&relief.map, normals, Wrap::Repeat) {
        Some(found) if found.is_of_one_surface() => tracing::info!("heights and normals agree: {found}"),
        Some(found) => tracing::warn!("heights and normals disagree: {found}; try --normal-y, or use only one of them"),
        None => tracing::warn!("heights or normals are flat: the height of the relief cannot be derived"),
    }
}

/// The default number of MSAA samples, for pictures with one sample per pixel and without other edge antialiasing.
pub const DEFAULT_MSAA: u32 = 4;

/// The settings that can change without a rebuild of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// The filtering and shading technique.
    pub technique: Technique,
    /// Shading options. If the technique does not support an option, the option is kept for other techniques.
    pub options: ShadingOptions,
    /// Whether heights displace the surface.
    pub displacement: bool,
    /// The factor on the displacement, 0 or more.
    pub height_scale: f32,
    /// The factor by which all objects are stretched along x and compressed along z; above 0.
    pub stretch: f32,
    /// The number of screen pixels per triangle.
    pub triangle_pixels: f32,
    /// The number of samples per pixel.
    pub samples: u32,
    /// The exposure of a PNG file or a window, in stops above the exposure for the sun's elevation.
    pub exposure: f32,
    /// The tone mapping curve.
    pub tonemap: Tonemap,
    /// Whether 8-bit codes are dithered, so that skies show no bands.
    pub dither: bool,
}

impl Default for Picture {
    /// Returns the default values of the command.
    fn default() -> Self {
        Self {
            technique: Technique::Leadr,
            options: ShadingOptions { sky_occlusion: true, ..ShadingOptions::default() },
            displacement: true,
            height_scale: 1.0,
            stretch: 1.0,
            triangle_pixels: 4.0,
            samples: 4,
            exposure: 0.0,
            tonemap: Tonemap::SHOWN,
            dither: true,
        }
    }
}

impl Picture {
    /// Returns the technique with the options that it supports.
    pub fn shading(&self) -> Shading {
        self.technique.with(self.options)
    }

    /// Returns the sRGB codes of rows of linear radiance, each `width` texels long, with the tone curve and dithering of this
    /// picture. `exposure` is a factor.
    pub fn codes(&self, width: u32, radiance: &[[f32; 3]], exposure: f32) -> Rgb8Image {
        let code = |(i, &color): (usize, &[f32; 3])| match self.dither {
            true => dithered_srgb8(color, exposure, self.tonemap, [i as u32 % width, i as u32 / width]),
            false => display_srgb8(color, exposure, self.tonemap),
        };
        let texels = radiance.iter().enumerate().map(code).collect();
        Rgb8Image { width, height: radiance.len() as u32 / width.max(1), texels }
    }

    /// Extracts the picture settings from `settings`.
    pub fn of(settings: &RenderSettings) -> Self {
        Self {
            technique: settings.shading.technique(),
            options: settings.shading.options(),
            displacement: settings.displacement,
            triangle_pixels: settings.tessellation.pixels_per_triangle,
            samples: settings.samples,
            ..Self::default()
        }
    }

    /// Returns `base` with its picture settings replaced by these.
    pub fn settings(&self, base: &RenderSettings) -> RenderSettings {
        let tessellation = TessellationSettings { pixels_per_triangle: self.triangle_pixels, ..base.tessellation };
        let (samples, displacement) = (self.samples, self.displacement);
        RenderSettings { samples, displacement, tessellation, ..*base }.shaded_by(self.shading())
    }
}

impl Serialize for Picture {
    /// Serialises the settings with the flag names as JSON keys.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let json = |option: &SceneOption| Some((option.spec.json_key(), option.json(self)?));
        serializer.collect_map(SceneOption::all().iter().filter_map(json))
    }
}

/// The configuration of one picture. The JSON fields of the configuration have the names of the command's flags.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneConfig {
    /// The selected scene.
    pub scene: &'static NamedScene,
    /// The glTF file, for model scenes only.
    pub model: Option<PathBuf>,
    /// The name of the animation to play; `None` plays the first animation.
    pub animation: Option<String>,
    /// The name or number of the camera in the file; `None` uses the first camera.
    pub model_camera: Option<String>,
    /// Whether the model is refused if it violates glTF.
    pub strict: bool,
    /// The name of the variant of the model's materials.
    pub variant: Option<String>,
    /// Whether files of a model or a material may lie behind links out of its folder.
    pub follow_links: bool,
    /// Whether heights keep the codes of coarse height maps.
    pub heights_as_read: bool,
    /// The map that multiplies the height scale.
    pub height_scale_map: Option<PathBuf>,
    /// The number of repeats of the material that the map of the height scale covers.
    pub height_scale_span: f32,
    /// Height maps for the model's materials.
    pub displacements: Vec<Displacement>,
    /// The maps of occlusion cones for the model's materials.
    pub cones: Vec<MaterialCones>,
    /// The measured materials that replace materials of the model.
    pub measured: Vec<MeasuredMaterial>,
    /// The height map of the plane or sphere.
    pub height_map: Option<PathBuf>,
    /// The files of the plane's or sphere's material.
    #[serde(flatten)]
    pub material: MaterialFiles,
    /// How the maps are tiled on the plane.
    #[serde(rename = "no_repeats", serialize_with = "without_repeats")]
    pub tiling: Tiling,
    /// Whether the plane or sphere is drawn without ground and plinth.
    pub bare: bool,
    /// Whether ground is drawn below a model.
    pub ground: Ground,
    /// The waves of the ocean.
    pub waves: Waves,
    /// The height difference between map values 0 and 1 on the plane or sphere, in metres, 0 or more; `None` uses the files' scale or the
    /// default.
    pub height: Option<f32>,
    /// The width of one repeat of the maps, in metres, above 0; `None` uses the scene's default.
    pub repeat: Option<f32>,
    /// The environment light.
    pub environment: EnvironmentChoice,
    /// The name of the layer of an EXR environment; `None` chooses the layer of the finished picture.
    pub environment_layer: Option<String>,
    /// The counter-clockwise rotation of an environment image when seen from above, in degrees.
    pub environment_rotation: f32,
    /// How lights are extracted from an environment image.
    #[serde(flatten)]
    pub environment_lights: LightExtraction,
    /// The direction to the sun at time 0; `None` uses the sun of the model, or [`DEFAULT_SUN`](super::light::DEFAULT_SUN).
    pub sun: Option<SunDirection>,
    /// The hour of the day at time 0; overrides `sun`.
    pub time_of_day: Option<f32>,
    /// The duration of an orbit of the sun, in seconds; `None` if the sun stands still.
    pub day_length: Option<f32>,
    /// Point lights in addition to the lights of the scene.
    pub point_lights: Vec<PlacedLight>,
    /// The settings that can change without a rebuild of the scene.
    #[serde(flatten)]
    pub picture: Picture,
    /// The camera view.
    pub view: ViewChoice,
    /// The path of a camera file that is not yet read.
    #[serde(skip)]
    pub camera_file: Option<PathBuf>,
    /// The distance to the camera's target in metres; `None` keeps the view's distance.
    pub distance: Option<f32>,
    /// The size of the picture in pixels.
    pub size: Size,
    /// The number of MSAA samples per pixel: 1, 2, 4 or 8.
    pub msaa: u32,
    /// The seed for the sample positions.
    pub seed: u64,
    /// Whether the exposure follows the irradiance of the environment image on level ground; if not, the exposure is 1.
    pub auto_exposure: bool,
    /// The edge length of an atlas tile in texels: a power of two, 8 to 128.
    pub atlas_tile: u32,
    /// How the height of the T-rex's skin varies.
    pub skin_relief: SkinRelief,
    /// The storage format of slope moments on the device.
    #[serde(serialize_with = "name_of_format")]
    pub map_precision: MomentFormat,
    /// Beckmann roughness of the displaced surfaces; `None` keeps the roughness of the scene.
    pub roughness: Option<f32>,
}

fn without_repeats<S: Serializer>(tiling: &Tiling, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bool(*tiling != Tiling::Repeats)
}

fn name_of_format<S: Serializer>(format: &MomentFormat, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(format.name())
}

impl Default for SceneConfig {
    /// Returns the first scene with the default values of the command.
    fn default() -> Self {
        Self {
            scene: &SCENES[0],
            model: None,
            animation: None,
            model_camera: None,
            strict: false,
            variant: None,
            follow_links: false,
            heights_as_read: false,
            height_scale_map: None,
            height_scale_span: 1.0,
            displacements: Vec::new(),
            cones: Vec::new(),
            measured: Vec::new(),
            height_map: None,
            material: MaterialFiles::default(),
            tiling: Tiling::default(),
            bare: false,
            ground: Ground::Auto,
            waves: Waves::default(),
            height: None,
            repeat: None,
            environment: EnvironmentChoice::Sky,
            environment_layer: None,
            environment_rotation: 0.0,
            environment_lights: LightExtraction::default(),
            sun: None,
            time_of_day: None,
            day_length: None,
            point_lights: Vec::new(),
            picture: Picture::default(),
            view: ViewChoice::Mid,
            camera_file: None,
            distance: None,
            size: Size { width: 1280, height: 720 },
            msaa: 1,
            seed: 0,
            auto_exposure: false,
            atlas_tile: 64,
            skin_relief: SkinRelief::Even,
            map_precision: MomentFormat::default(),
            roughness: None,
        }
    }
}

impl SceneConfig {
    /// Returns the render settings of this configuration.
    pub fn render_settings(&self) -> RenderSettings {
        let base = RenderSettings {
            size: (self.size.width, self.size.height),
            msaa: self.msaa,
            seed: self.seed,
            ..Default::default()
        };
        self.picture.settings(&base)
    }
}
