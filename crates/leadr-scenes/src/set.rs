//! Loads and uploads the scene of a configuration, with its objects, light and view.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::coarse_heights::{restore_map, restore_material, restore_materials};
use super::config::{MaterialFiles, Picture, SceneConfig, log_slope_agreement};
use super::daylight;
use super::deform;
use super::detail::factor_map;
use super::error::SceneError;
use super::file_kind::{FileKind, IMAGE};
use super::light::{DEFAULT_SUN, EnvironmentChoice};
use super::model::cones::give_cones;
use super::model::displacement::displace;
use super::model::measured::measure;
use super::model::{Ground, ModelChoice};
use super::registry::{Choice, SceneOptions};
use super::stage::{BakedRelief, Lights, Views};
use super::view::{Size, ViewChoice};
use glam::{Affine2, Vec2};
use leadr_gpu::{Gpu, GpuError};
use leadr_maps::baked::{BakedMap, HeightUnit};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{Input, Material, RoughnessMeaning};
use leadr_maps::shown::shown_path;
use leadr_maps::{HeightMap, MapError, MapFault, RgbImage, load_raster};
use leadr_models::{LoadOptions, Model};
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::light::exposure;
use leadr_render::light::panorama::LightExtraction;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{FactorMap, FrameState, Tiling};
use leadr_render::settings::{RenderSettings, ShadingOptions};
use leadr_render::surfaces::budget::Room;
use leadr_render::surfaces::classes::StoredClasses;

/// The input files of a scene. They are loaded and checked.
#[derive(Debug)]
pub struct Inputs {
    /// The heights of the plane or sphere.
    pub height_map: Option<HeightMap>,
    /// The slope moments and the height unit of a baked file.
    pub baked: Option<BakedRelief>,
    /// The material of the plane or sphere, including its heights.
    pub material: Option<Material>,
    /// The map of the height scale.
    pub height_scale_map: Option<FactorMap>,
    /// The model, for model scenes.
    pub model: Option<ModelChoice>,
    /// The equirectangular radiance of the environment; `None` for the analytic sky.
    pub environment: Option<RgbImage>,
}

impl Inputs {
    /// Loads the files of `config`.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of the wrong type.
    pub fn load(config: &SceneConfig) -> Result<Self, SceneError> {
        check_kinds(config)?;
        let (mut height_map, mut baked, mut material) = (None, None, None);
        let links = OutsideLinks::followed(config.follow_links);
        match &config.height_map {
            Some(file) if leadr_maps::baked::is_baked(file)? => {
                let map = BakedMap::load(file)?;
                map.check_drawable().map_err(|fault| fault.in_file(file))?;
                let fault = |fault: MapFault| fault.in_file(file);
                if map.is_material() || config.material != MaterialFiles::default() {
                    material = Some(config.material.load_over(Material::of_baked(&map).map_err(fault)?, links)?);
                } else {
                    height_map = Some(map.height_map().map_err(fault)?);
                    let in_widths = map.heights == HeightUnit::Width;
                    let is_reduced = map.dropped_levels > 0;
                    let classes = map.class_map().zip(map.openness.clone());
                    let classes = classes.map(|(map, open)| StoredClasses { map, open });
                    baked = map.into_moments().map(|moments| BakedRelief { moments, classes, in_widths, is_reduced });
                }
            }
            heights => {
                if config.model.is_none() {
                    material = config.material.load(heights.as_deref(), links)?;
                }
                if material.is_none() {
                    height_map = heights.as_ref().map(leadr_maps::load_height_map).transpose()?;
                }
            }
        }
        if !config.heights_as_read {
            let file = config.height_map.as_ref().or(config.material.folder.as_ref());
            let name = file.map_or_else(|| "the material".to_owned(), shown_path);
            // The slopes of a baked file are not those of its heights.
            height_map.iter_mut().filter(|_| baked.is_none()).for_each(|map| restore_map(map, &name));
            material.iter_mut().for_each(|material| restore_material(material, &name));
        }
        material.iter().for_each(log_slope_agreement);
        let color = material.as_ref().and_then(|material| material.base_color.texture.as_ref());
        let heights = height_map.as_ref().or(material.as_ref().and_then(|m| Some(&m.relief.as_ref()?.map)));
        let has_seam = heights.is_some_and(HeightMap::has_seam) || color.is_some_and(|color| color.raster.has_seam());
        if config.tiling == Tiling::Repeats && has_seam {
            let remedy = if config.scene.offers(Choice::Tiling) { ", or add --no-repeats" } else { "" };
            tracing::warn!("the edges of the maps do not match, so repeats show seams; use maps that tile{remedy}");
        }
        if let (Some(material), Some(alpha)) = (&mut material, config.roughness) {
            // The anisotropy is added to this roughness.
            material.roughness = Input::constant(alpha);
            material.roughness_meaning = RoughnessMeaning::Alpha;
        }
        if let Some(metres) = config.height {
            set_height(metres, config, material.as_mut(), baked.as_ref())?;
        }
        let model = match &config.model {
            Some(file) => {
                let options = LoadOptions { strict: config.strict, variant: config.variant.clone(), links };
                let mut model = Model::load(file, options)?;
                let named = |fault: SceneError| fault.of_file(file);
                displace(&mut model, file, &config.displacements, links).map_err(named)?;
                give_cones(&mut model, &config.cones).map_err(named)?;
                if let Some(mut detail) = config.material.detail.load(links)? {
                    if !config.heights_as_read {
                        restore_material(&mut detail.material, "the detail");
                    }
                    model.materials.iter_mut().for_each(|material| material.detail = Some(Box::new(detail.clone())));
                }
                if !config.heights_as_read {
                    let name = model.name.clone();
                    restore_materials(&mut model.materials, &name);
                }
                measure(&mut model, &config.measured).map_err(named)?;
                let ground = if config.bare { Ground::Off } else { config.ground };
                let choice = ModelChoice::new(model, config.animation.as_deref()).map_err(named)?.on(ground);
                let seen = config.view == ViewChoice::Model;
                Some(if seen { choice.seen_by(config.model_camera.as_deref()).map_err(named)? } else { choice })
            }
            None => None,
        };
        let of_model = model.iter().flat_map(|choice| &choice.model.materials);
        if chooses_cones(&config.picture.options) && !material.iter().chain(of_model).any(|one| one.cones.is_some()) {
            tracing::warn!(
                "no material has occlusion cones, so --cone-occluders, --cone-edge, --cone-axis and --cone-lobe have no effect; add \
                 NAME_Cones.png to the folder, --cone-map, or --cones for a model"
            );
        }
        Ok(Self {
            height_map,
            baked,
            material,
            height_scale_map: config
                .height_scale_map
                .as_deref()
                .map(|file| factors(file, config.height_scale_span))
                .transpose()?,
            model,
            environment: config.environment.load(config.environment_rotation, config.environment_layer.as_deref())?,
        })
    }
}

/// Whether a setting of occlusion cones differs from the default.
fn chooses_cones(options: &ShadingOptions) -> bool {
    let choices = |of: &ShadingOptions| (of.cone_occluders, of.cone_edge, of.cone_axis, of.cone_lobe);
    choices(options) != choices(&ShadingOptions::default())
}

/// Checks that the file of each option is of a kind that the option takes, before a reader calls it damaged.
fn check_kinds(config: &SceneConfig) -> Result<(), MapError> {
    use FileKind::{Baked, Exr, Fit, Folder, Hdr, Model, Picture};
    let material = &config.material;
    let environment = match &config.environment {
        EnvironmentChoice::File(file) => Some(file),
        _ => None,
    };
    let options: [(&str, Option<&PathBuf>, &[FileKind]); 12] = [
        ("--height-map", config.height_map.as_ref(), &[Picture, Exr, Baked]),
        ("--material", material.folder.as_ref(), &[Folder, Fit]),
        ("--color-map", material.color_map.as_ref(), IMAGE),
        ("--normal-map", material.normal_map.as_ref(), IMAGE),
        ("--roughness-map", material.roughness_map.as_ref(), IMAGE),
        ("--occlusion-map", material.occlusion_map.as_ref(), IMAGE),
        ("--cone-map", material.cone_map.as_ref(), IMAGE),
        ("--detail", material.detail.detail.as_ref(), &[Folder, Picture, Exr]),
        ("--height-scale-map", config.height_scale_map.as_ref(), IMAGE),
        ("--detail-mask", material.detail.detail_mask.as_ref(), IMAGE),
        ("--environment", environment, &[Hdr, Exr]),
        ("--scene", config.model.as_ref(), &[Model]),
    ];
    let displacements =
        config.displacements.iter().map(|displacement| ("--displacement", &displacement.named.file, IMAGE));
    let measured = config.measured.iter().map(|measured| ("--measured", &measured.0.file, [Fit].as_slice()));
    let cones = config.cones.iter().map(|cones| ("--cones", &cones.0.file, IMAGE));
    let single = options.into_iter().filter_map(|(flag, file, kinds)| Some((flag, file?, kinds)));
    let named = displacements.chain(measured).chain(cones);
    single.chain(named).try_for_each(|(flag, file, kinds)| FileKind::check(flag, file, kinds))
}

/// Loads a map of factors that spans this number of repeats of the material.
fn factors(file: &Path, span: f32) -> Result<FactorMap, MapError> {
    let map = factor_map(&load_raster(file)?);
    Ok(FactorMap { transform: Affine2::from_scale(Vec2::splat(1.0 / span)), ..map })
}

/// Progress of setting up a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetUp {
    /// The step of this name starts.
    Begins(&'static str),
    /// The completed fraction of the step, from 0 to 1.
    Share(f32),
}

/// A callback that receives the progress while a scene is set up, from any thread.
pub type Watch<'a> = &'a (dyn Fn(SetUp) + Sync);

/// Sets the height of a material's relief in metres. Refuses materials without heights, and heights in widths of the map.
fn set_height(
    metres: f32,
    config: &SceneConfig,
    material: Option<&mut Material>,
    baked: Option<&BakedRelief>,
) -> Result<(), SceneError> {
    let refuse = |what: &str, remedy: &str| {
        let file = config.height_map.as_ref().or(config.material.folder.as_ref());
        let fault = MapFault::Unsupported { what: what.to_owned(), remedy: remedy.to_owned() };
        Err(fault.in_file(file.map_or(Path::new("--height"), PathBuf::as_path)).into())
    };
    let mut relief = None;
    if let Some(material) = material {
        let Some(found) = &mut material.relief else {
            return refuse("the material has no heights", "give --height-map FILE, or leave --height out");
        };
        relief = Some(found);
    }
    if relief.as_ref().map_or(baked.is_some_and(|baked| baked.in_widths), |relief| relief.in_widths) {
        let remedy = "say how wide it is by --repeat METRES, or multiply its heights by --height-scale X";
        return refuse("its heights are in widths of the map, so --height does not apply", remedy);
    }
    if let Some(relief) = relief {
        relief.scale = Some(metres);
    }
    Ok(())
}

/// The state of a scene as a function of time in seconds.
pub type Animation = Box<dyn Fn(f64) -> FrameState + Send>;

/// A scene on the device.
pub struct Set {
    /// The renderer that holds the uploaded objects.
    pub renderer: Renderer,
    /// Returns the scene at any time, seen by `camera`. The camera follows moving objects.
    pub animation: Animation,
    /// The initial camera, relative to the followed object.
    pub camera: Camera,
    /// The standard views of the scene, relative to the followed object.
    pub views: Views,
    /// The resolution of the largest height map, in texels across and down, if there is one.
    pub map_size: Option<(u32, u32)>,
    /// The factory for other environments of the scene.
    pub surroundings: SkyOrPicture,
}

/// A factory for environments. An environment is the sky over a scene, or an image whose brightest spots become lights.
#[derive(Clone, Debug)]
pub struct SkyOrPicture {
    /// The sky over the scene.
    pub sky: Sky,
    /// The settings for the extraction of lights.
    pub lights: LightExtraction,
    /// The counter-clockwise rotation of images when seen from above, in degrees.
    pub rotation: f32,
    /// Whether the exposure of images follows their irradiance on level ground.
    pub auto_exposure: bool,
}

impl SkyOrPicture {
    /// Creates a factory with this sky. Images have neither exposure nor rotation.
    pub fn under(sky: Sky) -> Self {
        Self { sky, lights: LightExtraction::default(), rotation: 0.0, auto_exposure: false }
    }

    /// Returns the exposure factor for lighting by `picture`.
    pub fn metered(&self, picture: Option<&RgbImage>) -> f32 {
        picture.filter(|_| self.auto_exposure).map_or(1.0, exposure::metered)
    }

    /// Builds the environment of an equirectangular `picture`; with `None`, the sky is used.
    pub fn make(&self, gpu: &Arc<Gpu>, picture: Option<&RgbImage>) -> Result<Environment, GpuError> {
        match picture {
            Some(picture) => Environment::from_panorama(gpu, Environment::FACE_SIZE, picture, self.lights),
            None => Environment::from_sky(gpu, Environment::FACE_SIZE, &self.sky),
        }
    }
}

/// Uploads the scene of `config` and reports progress to `watch`. `first` has the settings of the first frames. The pipelines of these
/// frames are compiled during the upload.
///
/// # Errors
/// If the scene cannot be built or the device fails.
pub fn set(
    config: &SceneConfig,
    inputs: Inputs,
    gpu: &Arc<Gpu>,
    first: Option<&RenderSettings>,
    watch: Watch<'_>,
) -> Result<Set, SceneError> {
    let options = SceneOptions {
        height_map: inputs.height_map,
        baked: inputs.baked,
        material: inputs.material,
        height_scale_map: inputs.height_scale_map,
        model: inputs.model,
        height: config.height,
        repeat: config.repeat,
        tiling: config.tiling,
        bare: config.bare,
        atlas_tile: config.atlas_tile,
        skin_relief: config.skin_relief,
        waves: Some(config.waves),
        room: Some(Room::on(gpu, config.map_precision)),
    };
    let named = |fault: SceneError| match &config.model {
        Some(file) => fault.of_file(file),
        None => fault,
    };
    watch(SetUp::Begins(config.scene.making.map_or("making the scene", |label| label(config.atlas_tile))));
    let mut stage = config.scene.stage(options, &|share| watch(SetUp::Share(share))).map_err(named)?;
    if let Some(roughness) = config.roughness {
        stage.set_roughness(roughness);
    }
    if config.sun.is_some() || config.time_of_day.is_some() || config.day_length.is_some() {
        stage.leave_out_own_sun();
    }
    let start = match config.time_of_day {
        Some(hour) => daylight::at_hour(f64::from(hour)),
        None => stage.sun_of_sky().unwrap_or(config.sun.unwrap_or(DEFAULT_SUN).vector()),
    };
    let sky = Sky { sun_direction: start, ground_albedo: stage.below_horizon, ..Sky::default() };
    let surroundings = SkyOrPicture {
        sky,
        lights: config.environment_lights,
        rotation: config.environment_rotation,
        auto_exposure: config.auto_exposure,
    };
    let metered = surroundings.metered(inputs.environment.as_ref());
    watch(SetUp::Begins("filtering the environment light"));
    let environment = surroundings.make(gpu, inputs.environment.as_ref())?;
    // The suns of an environment image replace the sun of the sky.
    let sky = inputs.environment.is_none().then_some(sky);
    let views = stage.views;
    let own = stage.own_camera.take();
    let camera = own.as_ref().map_or_else(|| camera(config, views), |own| own(0.0));
    let sizes = stage
        .objects
        .iter()
        .filter_map(|object| object.heights.as_ref())
        .map(|field| (field.map.width, field.map.height));
    let map_size = sizes.max_by_key(|&(width, height)| u64::from(width) * u64::from(height));
    let lights = Lights { sky, metered, placed: config.point_lights.clone(), ..Default::default() };
    let mut scene = leadr_render::scene::Scene { map_precision: config.map_precision, ..stage.take_scene() };
    let follows_relief = config.picture.shading().options().relief_color;
    scene.objects.iter_mut().for_each(|object| object.follows_relief = follows_relief);
    let Picture { height_scale, stretch, .. } = config.picture;
    let hours_per_second = config.day_length.map_or(0.0, |seconds| 24.0 / f64::from(seconds));
    let animation: Animation = Box::new(move |time| {
        let mut state = stage.state(time, &camera, &lights);
        if let Some(own) = &own {
            state.camera = own(time);
        }
        state.height_scale *= height_scale;
        deform::stretch(&mut state, stretch);
        daylight::pass(&mut state, time * hours_per_second);
        state
    });
    watch(SetUp::Begins("uploading maps and compiling shaders"));
    let renderer = match first {
        Some(first) => Renderer::for_frames_like(gpu, scene, environment, &animation(0.0), first)?,
        None => Renderer::new(gpu, scene, environment)?,
    };
    Ok(Set { renderer, animation, camera, views, map_size, surroundings })
}

impl Set {
    /// Returns the scene at `time` seconds, seen from another view, for a picture of this size.
    pub fn state_from(&self, time: f64, view: ViewChoice, size: Size) -> FrameState {
        let state = (self.animation)(time);
        // The animation's camera moves with the object that it follows.
        let moved = state.camera.position - self.camera.position;
        let camera = camera_of(view, self.views, size);
        let camera = Camera { position: camera.position + moved, target: camera.target + moved, ..camera };
        FrameState { camera, ..state }
    }
}

/// Moves the camera back for pictures narrower than 4:3, so that they show the full width of the middle view.
fn fitted(camera: Camera, size: Size) -> Camera {
    let narrower = (4.0 / 3.0) * size.height as f32 / size.width as f32;
    camera.at_distance(camera.position.distance(camera.target) * narrower.clamp(1.0, 4.0))
}

fn camera(config: &SceneConfig, views: Views) -> Camera {
    let camera = camera_of(config.view, views, config.size);
    config.distance.map_or(camera, |metres| camera.at_distance(metres))
}

fn camera_of(view: ViewChoice, views: Views, size: Size) -> Camera {
    match view {
        ViewChoice::Near => views.near,
        ViewChoice::Mid | ViewChoice::Model => fitted(views.mid, size),
        ViewChoice::Far => views.far,
        ViewChoice::Pose(pose) => pose.camera(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::save::save_png_grey16;

    #[test]
    fn a_file_given_with_the_wrong_flag_is_named_with_the_right_one() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let file = folder.path().join(name);
            std::fs::write(&file, bytes).unwrap();
            file
        };
        let (picture, model) = (write("a.json", b"\x89PNG\r\n"), write("b.exr", b"glTF\x02"));
        let (fit, light) = (write("c.png", b"{\"format\": \"leadr fit\"}"), write("d.png", b"#?RADIANCE\n"));
        let flagged = |flag: &str, file: &Path| {
            let mut line = crate::given::CommandLine::default();
            line.set("--scene", Some("plane"));
            line.set(flag, Some(file));
            Inputs::load(&line.resolve().unwrap()).unwrap_err().to_string()
        };
        for (flag, file, kind, remedy) in [
            ("--material", &picture, "a picture such as PNG or JPEG", "--color-map"),
            ("--material", &model, "a glTF model", "--scene"),
            ("--height-map", &fit, "a fit", "--material"),
            ("--height-map", &folder.path().to_path_buf(), "a folder", "--material"),
            ("--color-map", &light, "a Radiance HDR", "--environment"),
            ("--normal-map", &model, "a glTF model", "--scene"),
            ("--roughness-map", &fit, "a fit", "--measured"),
            ("--occlusion-map", &folder.path().to_path_buf(), "a folder", "--material"),
            ("--cone-map", &model, "a glTF model", "--scene"),
            ("--detail", &fit, "a fit", "--material"),
            ("--environment", &model, "a glTF model", "--scene"),
        ] {
            let fault = flagged(flag, file);
            let names = [flag, kind, remedy].iter().all(|word| fault.contains(word));
            assert!(names && fault.starts_with(&file.display().to_string()), "{flag}: {fault}");
        }
    }

    #[test]
    fn metres_apply_only_to_heights_without_a_unit() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let bumps = HeightMap::new(4, 4, (0..16).map(|i| i as f32 / 15.0).collect()).unwrap();
        save_png_grey16(file("x_Displacement.png"), &bumps, 0.0, 1.0).unwrap();
        let scale = |config: &SceneConfig| {
            let inputs = Inputs::load(config).map_err(|error| error.to_string())?;
            Ok::<_, String>(inputs.material.and_then(|material| material.relief?.scale))
        };
        let of_folder = SceneConfig {
            height: Some(0.03),
            material: MaterialFiles { folder: Some(folder.path().to_path_buf()), ..MaterialFiles::default() },
            ..SceneConfig::default()
        };
        assert_eq!(scale(&of_folder), Ok(Some(0.03)));
        // Heights without a material are passed directly to the scene.
        let alone = SceneConfig {
            height_map: Some(file("x_Displacement.png")),
            material: MaterialFiles::default(),
            ..of_folder.clone()
        };
        assert_eq!(scale(&alone), Ok(None));
        let metal = MaterialFiles { metal: Some("gold"), ..MaterialFiles::default() };
        let flat = SceneConfig { material: metal, ..of_folder };
        assert!(scale(&flat).unwrap_err().contains("no heights"));
    }
}
