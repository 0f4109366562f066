//! What is drawn and how: a scene, its light, the view, and the settings of the picture.

use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

use super::fitted::material_of;
use super::light::{EnvironmentChoice, SunDirection};
use super::model::displacement::Displacement;
use super::model::measured::MeasuredMaterial;
use super::ocean::waves::Waves;
use super::options::SceneOption;
use super::registry::{NamedScene, SCENES};
use super::view::{Size, ViewChoice};
use leadr_maps::material::{
    Anisotropy, Encoding, GreenAxis, Input, Material, MaterialDetail, MaterialFolder, Role, Texture, agreement, role_of,
};
use leadr_maps::tonemap::Tonemap;
use leadr_maps::{MapError, MapFault, Wrap, load_raster};
use leadr_measured::fit_file::FitFile;
use leadr_reflectance::facets::metals::Metal;
use leadr_render::light::panorama::LightExtraction;
use leadr_render::named_enum;
use leadr_render::scene::Tiling;
use leadr_render::settings::{RenderSettings, Shading, ShadingOptions, Technique};
use leadr_render::surfaces::moments::MomentFormat;
use leadr_render::surfaces::tessellation::TessellationSettings;

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
    /// The share of the surroundings that is seen.
    pub occlusion_map: Option<PathBuf>,
    /// The cone in which they are seen.
    pub cone_map: Option<PathBuf>,
    /// Which way the green of the normal map goes, instead of what its name or its slopes tell.
    pub normal_y: Option<NormalY>,
    /// What it is made of instead of its colours and its metalness.
    pub metal: Option<&'static str>,
    /// How much rougher it is along one direction, 0 to 1.
    pub anisotropy: Option<f32>,
    /// From which that direction is turned counter-clockwise, degrees.
    pub anisotropy_rotation: f32,
    /// What lies over it and repeats more often.
    #[serde(flatten)]
    pub detail: DetailFiles,
}

named_enum! {
    /// Which way the green channel of a normal map goes.
    pub enum NormalY {
        /// Up, as in OpenGL and glTF.
        Up = "up", "Up, as in OpenGL and glTF";
        /// Down, as in DirectX.
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

/// A detail over a material of the plane or sphere.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DetailFiles {
    /// A folder of a material, or a picture of heights or normals.
    pub detail: Option<PathBuf>,
    /// Times that it repeats within one repeat of the material.
    pub detail_repeat: f32,
    /// By which it is turned counter-clockwise, degrees.
    pub detail_rotation: f32,
    /// Factor on its slopes.
    pub detail_height_scale: f32,
    /// Where it covers the material.
    pub detail_mask: Option<PathBuf>,
}

impl Default for DetailFiles {
    fn default() -> Self {
        Self { detail: None, detail_repeat: 8.0, detail_rotation: 0.0, detail_height_scale: 1.0, detail_mask: None }
    }
}

impl DetailFiles {
    fn load(&self) -> Result<Option<MaterialDetail>, MapError> {
        let Some(path) = &self.detail else { return Ok(None) };
        let (material, colored) = if path.is_dir() {
            let folder = MaterialFolder::open(path)?;
            folder.remarks.iter().for_each(|remark| tracing::warn!("{remark}"));
            let colored = [Role::Color, Role::Roughness, Role::Gloss, Role::Packed];
            let colored = colored.iter().any(|&role| folder.picture(role).is_some());
            if folder.picture(Role::Metalness).is_some() {
                tracing::warn!("{}: the metalness of a detail is not used", path.display());
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
        let mask = match &self.detail_mask {
            Some(file) => Some(Texture::new(load_raster(file)?, file.display().to_string(), Encoding::Linear)),
            None => None,
        };
        Ok(Some(MaterialDetail {
            material,
            colored,
            repeat: self.detail_repeat,
            rotation: self.detail_rotation,
            height_scale: self.detail_height_scale,
            mask,
        }))
    }
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
        say_whether_slopes_agree(&material);
        Ok(Some(material))
    }

    /// Reads them in place of what `material` has. A folder brings everything but heights that it has none of.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong kind.
    pub fn load_over(&self, mut material: Material) -> Result<Material, MapError> {
        if let Some(file) = self.folder.as_ref().filter(|path| path.is_file()) {
            let relief = material.relief.take();
            let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            material = material_of(&FitFile::load(file)?, &name);
            material.relief = relief;
        } else if let Some(folder) = &self.folder {
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
        match (&mut material.normal_map, self.normal_y) {
            (Some(map), Some(way)) => map.green = way.into(),
            (None, Some(_)) => {
                let fault = MapFault::Unsupported {
                    what: "it has no normal map whose green --normal-y could turn".into(),
                    remedy: "leave that flag out".into(),
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
            material.conductor_dip = metal.dip().as_vec3().to_array();
        }
        if let Some(strength) = self.anisotropy {
            let rotation = self.anisotropy_rotation.to_radians();
            material.anisotropy = Some(Anisotropy { strength: Input::constant(strength), rotation, direction: None });
        }
        material.detail = self.detail.load()?.map(Box::new);
        Ok(material)
    }

    /// Its folder, where it names one that can be read.
    fn opened(&self) -> Option<MaterialFolder> {
        let folder = self.folder.as_ref().filter(|path| !path.is_file())?;
        MaterialFolder::open(folder).ok()
    }

    /// Whether it has a relief: `heights`, or the folder's own.
    pub fn is_displaced(&self, heights: Option<&Path>) -> bool {
        heights.is_some() || self.opened().is_some_and(|folder| folder.picture(Role::Height).is_some())
    }

    /// Whether it is a normal map on smooth geometry: normals, and neither `heights` nor a relief of its own or of a detail.
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

/// Correlation of the slopes of heights and normals below which they hardly are of the same surface.
const SAME_SURFACE: f64 = 0.5;

/// Says how heights and normals of one material fit together.
fn say_whether_slopes_agree(material: &Material) {
    let (Some(relief), Some(normals)) = (&material.relief, &material.normal_map) else { return };
    match agreement(&relief.map, normals, Wrap::Repeat) {
        Some(found) if found.correlation >= SAME_SURFACE => tracing::info!("heights and normals agree: {found}"),
        Some(found) => tracing::warn!(
            "heights and normals disagree: {found}; heights displace and normals shade, so try --normal-y, or leave one of them out"
        ),
        None => tracing::warn!("heights or normals are flat: nothing tells how high the relief is"),
    }
}

/// Samples of the geometry in each pixel of pictures of one sample, unless something else makes outlines smooth.
pub const DEFAULT_MSAA: u32 = 4;

/// How a scene is drawn, as far as that can change without making the scene again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// How surfaces are filtered and shaded.
    pub technique: Technique,
    /// Its options. Those that the technique lacks are kept for another that has them.
    pub options: ShadingOptions,
    /// Whether heights move the surface.
    pub displacement: bool,
    /// Factor on the displacement, 0 or more.
    pub height_scale: f32,
    /// Factor by which everything is wider along x and lower along z, above 0.
    pub stretch: f32,
    /// Screen pixels per triangle.
    pub triangle_pixels: f32,
    /// Samples per pixel.
    pub samples: u32,
    /// Exposure of a PNG or a window, stops above what suits the height of the sun.
    pub exposure: f32,
    /// How its light becomes that of a screen.
    pub tonemap: Tonemap,
}

impl Default for Picture {
    /// As the command draws without flags.
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
        }
    }
}

impl Picture {
    /// The technique with those of the options that it has.
    pub fn shading(&self) -> Shading {
        self.technique.with(self.options)
    }

    /// How `settings` draw.
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

    /// `base` drawn so.
    pub fn settings(&self, base: &RenderSettings) -> RenderSettings {
        let tessellation = TessellationSettings { pixels_per_triangle: self.triangle_pixels, ..base.tessellation };
        let (samples, displacement) = (self.samples, self.displacement);
        RenderSettings { samples, displacement, tessellation, ..*base }.shaded_by(self.shading())
    }
}

impl Serialize for Picture {
    /// Under the names of the flags.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let json = |option: &SceneOption| Some((option.spec.json_key(), option.json(self)?));
        serializer.collect_map(SceneOption::all().iter().filter_map(json))
    }
}

/// A picture of a scene. Written as JSON, its fields have the names of the command's flags.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneConfig {
    /// Which scene.
    pub scene: &'static NamedScene,
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
    /// Which of its materials are measured ones.
    pub measured: Vec<MeasuredMaterial>,
    /// Height map of the plane or sphere.
    pub height_map: Option<PathBuf>,
    /// Files of its material.
    #[serde(flatten)]
    pub material: MaterialFiles,
    /// How its maps cover the plane.
    #[serde(rename = "no_repeats", serialize_with = "without_repeats")]
    pub tiling: Tiling,
    /// Whether the plane or sphere stands alone, without anything around it.
    pub bare: bool,
    /// The waves of the ocean.
    pub waves: Waves,
    /// Metres from the 0 of the plane's or sphere's heights to their 1, 0 or more; `None` for what files tell, or what is usual.
    pub height: Option<f32>,
    /// Metres after which its maps repeat, above 0; `None` for the scene's own.
    pub repeat: Option<f32>,
    /// Light from all around.
    pub environment: EnvironmentChoice,
    /// By which a picture of it is turned counter-clockwise seen from above, degrees.
    pub environment_rotation: f32,
    /// What of a picture of the environment becomes lights.
    #[serde(flatten)]
    pub environment_lights: LightExtraction,
    /// Direction to the sun at the beginning.
    pub sun: SunDirection,
    /// Hour of the day at the beginning, instead of `sun`.
    pub time_of_day: Option<f32>,
    /// Seconds in which the sun goes once round the sky; `None` if it stands still.
    pub day_length: Option<f32>,
    /// How it is drawn.
    #[serde(flatten)]
    pub picture: Picture,
    /// Where it is seen from.
    pub view: ViewChoice,
    /// A file with the pose that it is seen from; not yet read.
    #[serde(skip)]
    pub camera_file: Option<PathBuf>,
    /// Distance to the camera's target, metres, instead of the view's own.
    pub distance: Option<f32>,
    /// Size of the picture.
    pub size: Size,
    /// Samples of the geometry in each pixel: 1, 2, 4 or 8.
    pub msaa: u32,
    /// Seed of the sample positions.
    pub seed: u64,
    /// Whether a picture of the environment is exposed for what it shines on level ground, instead of at 1.
    pub auto_exposure: bool,
    /// Texels along an atlas tile: a power of two, 8 to 128.
    pub atlas_tile: u32,
    /// How slopes of maps are kept on the device.
    #[serde(serialize_with = "name_of_format")]
    pub map_precision: MomentFormat,
    /// Beckmann roughness of the displaced surfaces instead of the scene's own.
    pub roughness: Option<f32>,
}

fn without_repeats<S: Serializer>(tiling: &Tiling, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bool(*tiling != Tiling::Repeats)
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
            measured: Vec::new(),
            height_map: None,
            material: MaterialFiles::default(),
            tiling: Tiling::default(),
            bare: false,
            waves: Waves::default(),
            height: None,
            repeat: None,
            environment: EnvironmentChoice::Sky,
            environment_rotation: 0.0,
            environment_lights: LightExtraction::default(),
            sun: SunDirection { azimuth: -50.0, elevation: 38.0 },
            time_of_day: None,
            day_length: None,
            picture: Picture::default(),
            view: ViewChoice::Mid,
            camera_file: None,
            distance: None,
            size: Size { width: 1280, height: 720 },
            msaa: 1,
            seed: 0,
            auto_exposure: false,
            atlas_tile: 64,
            map_precision: MomentFormat::default(),
            roughness: None,
        }
    }
}

impl SceneConfig {
    /// The part that the renderer takes.
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
