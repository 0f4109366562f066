//! Flags of every command that draws a scene, and the configuration they ask for.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, ValueEnum};

use super::dress::DressArgs;
use super::shading::{ShadingArgs, choice};
use super::values::{
    CameraChoice, atlas_tile, environment_lights, hour, msaa, not_negative, positive, repeat, roughness, stretch, whole,
};
use super::waves::WaveArgs;
use leadr_maps::tonemap::Tonemap;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::light::panorama::LightExtraction;
use leadr_render::scene::Tiling;
use leadr_render::settings::ShadingOptions;
use leadr_render::surfaces::moments::MomentFormat;
use leadr_scenes::camera_file;
use leadr_scenes::config::{DEFAULT_MSAA, MaterialFiles, SceneConfig};
use leadr_scenes::light::{EnvironmentChoice, SunDirection};
use leadr_scenes::model::displacement::Displacement;
use leadr_scenes::model::measured::MeasuredMaterial;
use leadr_scenes::registry::{Choice, MODEL, SCENES, Scene};
use leadr_scenes::view::finite;
use leadr_scenes::view::{Size, View};
use leadr_tools::command::error::AppError;

/// Flags of every command that draws a scene.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// Scene to draw, or a glTF model
    #[arg(long, value_name = "NAME|FILE.glb|FILE.gltf", value_parser = scene_choice, default_value = SCENES[0].name, long_help = scene_help())]
    pub scene: SceneChoice,
    /// Animation of a model to play [default: its first]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Replace missing and damaged images of a model (colours by a magenta check, numbers by their factor) instead of refusing it
    #[arg(long)]
    pub lenient: bool,
    /// Heights, PNG or EXR, that displace a material of a model (`*`: all of them), and if need be the metres from the map's 0 to
    /// its 1 [default: what fits its normal map or looks usual] and the height that lies on the mesh [default: the mean]; may be
    /// given several times. Maps beside the model that are named MATERIAL_Displacement.png or like its image are found
    #[arg(long, value_name = "MATERIAL=FILE[,SCALE[,MIDDLE]]")]
    pub displacement: Vec<Displacement>,
    /// A measured material, as leadr fit keeps it, instead of a material of a model (`*`: all of them); may be given several times.
    /// Relief, occlusion and holes stay the model's; a texture of roughness scales the measured slopes about its own mean
    #[arg(long, value_name = "MATERIAL=FIT.json")]
    pub measured: Vec<MeasuredMaterial>,
    /// Height map of the plane or the sphere
    #[arg(long, value_name = "FILE", help = for_scenes("Height map, PNG or EXR, or what leadr bake made of one (KTX2, EXR); its first row lies at y = 0, rows run along +y", Choice::HeightMap))]
    pub height_map: Option<PathBuf>,
    /// A material
    #[arg(long, value_name = "FOLDER|FIT.json", help = for_scenes("A material as downloaded: NAME_Color.png, NAME_NormalGL.png, NAME_Roughness.png, NAME_Displacement.png, ...; or a measured one, as leadr fit keeps it. It lies upright, as seen from above with +y on top", Choice::HeightMap))]
    pub material: Option<PathBuf>,
    /// Base colours
    #[arg(long, value_name = "FILE", help = for_scenes("Base colours, PNG or JPEG in sRGB, or linear EXR; with --height-map, both lie upright", Choice::HeightMap))]
    pub color_map: Option<PathBuf>,
    /// Normals
    #[arg(long, value_name = "FILE", help = for_scenes("Normals in the tangent frame, two or three channels; whether green goes up or down is found", Choice::HeightMap))]
    pub normal_map: Option<PathBuf>,
    /// Roughness
    #[arg(long, value_name = "FILE", help = for_scenes("Perceptual roughness, the root of alpha", Choice::HeightMap))]
    pub roughness_map: Option<PathBuf>,
    /// Occlusion
    #[arg(long, value_name = "FILE", conflicts_with = "cone_map", help = for_scenes("The share of the surroundings that each place sees, for materials without heights, whose relief tells that itself", Choice::HeightMap))]
    pub occlusion_map: Option<PathBuf>,
    /// Cones
    #[arg(long, value_name = "FILE", help = for_scenes("The cone in which each place sees its surroundings, as leadr bake --kind cones writes it into a PNG; on the sphere its share alone", Choice::HeightMap))]
    pub cone_map: Option<PathBuf>,
    /// Flags of the material.
    #[command(flatten)]
    pub dress: DressArgs,
    /// The waves of the ocean.
    #[command(flatten)]
    pub waves: WaveArgs,
    /// Without repeats
    #[arg(long, help = for_scenes("Show the maps by example instead of side by side: blended pieces that never repeat, with the same mean and covariance of slopes; for ground, sand, plaster and whatever else has no order", Choice::Tiling))]
    pub no_repeats: bool,
    /// Height of the relief
    #[arg(long, value_name = "METRES", value_parser = not_negative, help = for_scenes("Metres from the 0 of the heights (black) to their 1 (white) [default: what fits the material's normals; 0.12 for heights alone]", Choice::HeightMap))]
    pub height: Option<f32>,
    /// Width of the maps
    #[arg(long, value_name = "METRES", value_parser = repeat, help = for_scenes("Metres after which height maps and materials repeat, 0.01 to 1000 [default: 2 on the plane, 1.2 on the sphere]", Choice::HeightMap))]
    pub repeat: Option<f32>,
    /// Factor on the displacement
    #[arg(long, value_name = "X", value_parser = not_negative, help = but_not_for("Factor on the displacement, whatever its metres; 0 is flat [default: 1]", Choice::Relief))]
    pub height_scale: Option<f32>,
    /// Factor on widths
    #[arg(long, value_name = "X", value_parser = stretch, help = but_not_for("Stretch everything along x by this factor, 0.2 to 5, and flatten it along z by as much; the maps stay as they are [default: 1]", Choice::Stretch))]
    pub stretch: Option<f32>,
    /// Light from all around: the analytic sky, a studio, or an equirectangular picture
    #[arg(long, value_name = "sky|studio|FILE.hdr|FILE.exr", default_value = "sky")]
    pub environment: EnvironmentChoice,
    /// By which a picture of an environment is turned counter-clockwise, seen from above [default: 0]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = finite)]
    pub environment_rotation: Option<f32>,
    /// Most lights, 0 to 4, that are taken out of a picture of an environment to throw shadows; at 0 all light stays in the
    /// picture [default: 4]
    #[arg(long, value_name = "N", value_parser = environment_lights)]
    pub environment_lights: Option<u32>,
    /// Radiance from which on a place of that picture can belong to a light, in multiples of the picture's mean [default: 8]
    #[arg(long, value_name = "X", value_parser = positive)]
    pub environment_light_threshold: Option<f32>,
    /// Direction to the sun under --environment sky, degrees: counter-clockwise from +x, and above the horizon [default: -50,38]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", allow_hyphen_values = true)]
    pub sun: Option<SunDirection>,
    /// Hour at which the scene begins, instead of --sun: the sun rises in the east (+x) at 5:30 and sets at 18:30
    #[arg(long, value_name = "HOURS", conflicts_with = "sun", value_parser = hour)]
    pub time_of_day: Option<f32>,
    /// Seconds in which the sun goes once round the sky [default: it stands still]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub day_length: Option<f32>,
    /// How it is shaded.
    #[command(flatten)]
    pub shading: ShadingArgs,
    /// Keep the geometry smooth
    #[arg(long, help = but_not_for("Keep the geometry smooth; the slopes of the height map still shade it", Choice::Relief))]
    pub no_displacement: bool,
    /// With --technique reference: bumps shadow each other, from every light and the environment; slow, needs many samples
    #[arg(long)]
    pub relief_shadows: bool,
    /// Screen pixels per triangle
    #[arg(long, value_name = "PIXELS", value_parser = positive, help = but_not_for("Screen pixels per triangle of the displaced surface [default: 4]", Choice::Objects))]
    pub triangle_pixels: Option<f32>,
    /// A view of the scene, a camera of a model's file (the first, or by name or number), a JSON file {position, target, up,
    /// fov_degrees}, or position, target and vertical field of view in numbers
    #[arg(
        long,
        value_name = "near|mid|far|model|model:NAME|FILE.json|X,Y,Z:X,Y,Z[:DEGREES]",
        default_value = "mid",
        allow_hyphen_values = true
    )]
    pub camera: CameraChoice,
    /// Move the camera along its line of sight to this distance from its target, metres
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub distance: Option<f32>,
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: Size,
    /// Samples per pixel (in a window: once nothing moves)
    #[arg(long, value_name = "N", default_value = "4", value_parser = |text: &str| whole(text, 1_u32, 65_536))]
    pub samples: u32,
    /// Samples of the geometry in each sample, for smooth outlines at little cost: 1, 2, 4 or 8; each surface in a pixel is shaded once
    /// [default: 4 with --samples 1, and in a window for what moves unless that takes longer than 100 ms a frame; else 1]
    #[arg(long, value_name = "N", value_parser = msaa)]
    pub msaa: Option<u32>,
    /// Look at the geometry N times per sample, for smooth silhouettes; each surface in a pixel is still shaded once.
    /// Fastest: 16, 64, 256
    #[arg(long, value_name = "N", default_value = "1", value_parser = |text: &str| whole(text, 1_u32, 256))]
    pub edge_samples: u32,
    /// Seed of the sample positions
    #[arg(long, value_name = "N", default_value = "0", value_parser = |text: &str| whole(text, 0, u64::MAX))]
    pub seed: u64,
    /// Exposure of a PNG or a window, stops above what suits the height of the sun (an EXR keeps linear radiance)
    #[arg(long, value_name = "EV", default_value = "0", allow_negative_numbers = true, value_parser = finite)]
    pub exposure: f32,
    /// Expose for a picture of an environment, whose unit nobody tells: level ground in its light is as bright as under the sky at
    /// mid-morning. --exposure adds stops
    #[arg(long)]
    pub auto_exposure: bool,
    /// How the light of a PNG or a window becomes that of a screen [default: agx]
    #[arg(long, value_name = "NAME", value_parser = choice(&Tonemap::ALL, Tonemap::name, Tonemap::help))]
    pub tonemap: Option<Tonemap>,
    /// Only the surface, with nothing around it
    #[arg(long, help = for_scenes("Only the surface, as it is measured: no pavement, plinth or kerb around it", Choice::Bare))]
    pub bare: bool,
    /// Texels along the tile of one patch in the displacement atlas
    #[arg(long, value_name = "N", value_parser = atlas_tile,
        help = for_scenes("Texels along the tile of one patch in the displacement atlas: 8, 16, 32, 64 or 128 [default: 64]", Choice::AtlasTile))]
    pub atlas_tile: Option<u32>,
    /// Numbers in which the slopes of maps are kept on the device
    #[arg(long, value_name = "PRECISION", value_enum,
        help = but_not_for("Numbers in which the slopes of maps are kept on the device [default: f32]", Choice::Objects))]
    pub map_precision: Option<MapPrecision>,
    /// Beckmann roughness of the displaced surfaces instead of the scene's own
    #[arg(long, value_name = "A", value_parser = roughness,
        help = for_scenes("Beckmann roughness of displaced surfaces, above 0, up to 1, instead of the scene's own", Choice::Roughness))]
    pub roughness: Option<f32>,
}

/// Numbers in which the slopes of maps are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MapPrecision {
    /// 32-bit floats
    F32,
    /// 16-bit floats: half the memory, with a measured error
    F16,
}

impl From<MapPrecision> for MomentFormat {
    fn from(precision: MapPrecision) -> Self {
        match precision {
            MapPrecision::F32 => Self::Float32,
            MapPrecision::F16 => Self::Float16,
        }
    }
}

/// A line of help with the scenes it is about.
fn for_scenes(help: &str, choice: Choice) -> String {
    format!("{help} ({})", choice.scenes().collect::<Vec<_>>().join(", "))
}

/// A line of help with the scenes that it is not about.
fn but_not_for(help: &str, choice: Choice) -> String {
    let others: Vec<_> = SCENES.iter().filter(|scene| !scene.offers(choice)).map(|scene| scene.name).collect();
    format!("{help} (not for {})", others.join(", "))
}

/// What `--scene` names.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneChoice {
    /// The scene.
    pub scene: &'static Scene,
    /// The file, where it is a model.
    pub model: Option<PathBuf>,
}

fn scene_help() -> String {
    let names: Vec<_> = SCENES.iter().map(|scene| format!("- {}: {}", scene.name, scene.help)).collect();
    format!("Scene to draw, or a glTF model on open ground\n\nScenes:\n{}", names.join("\n"))
}

/// A scene by its name, or a model by its file.
///
/// # Errors
/// A sentence that lists what there is.
pub fn scene_choice(name: &str) -> Result<SceneChoice, String> {
    let file = Path::new(name);
    let extension = file.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    if matches!(extension.as_deref(), Some("glb" | "gltf")) {
        return Ok(SceneChoice { scene: &MODEL, model: Some(file.to_path_buf()) });
    }
    let names = || SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
    let unknown = || format!("no such scene; there are {}, and files that end in .glb or .gltf", names());
    Scene::find(name).map(|scene| SceneChoice { scene, model: None }).ok_or_else(unknown)
}

impl SceneArgs {
    /// The flags when none is given.
    ///
    /// # Errors
    /// None that a user can cause.
    pub fn unset() -> Result<Self, AppError> {
        #[derive(Parser)]
        struct Flags {
            #[command(flatten)]
            scene: SceneArgs,
        }
        let flags = Flags::try_parse_from(["leadr"]).map_err(|e| AppError::Failed(e.to_string()))?;
        Ok(flags.scene)
    }

    /// Checks the flags against each other and reads the camera file, if one is named.
    ///
    /// # Errors
    /// [`AppError::Usage`] if flags contradict each other, [`AppError::Failed`] if a file is wrong.
    pub fn resolve(&self) -> Result<SceneConfig, AppError> {
        let a = self.clone();
        let waves = a.waves.of(a.scene.scene);
        let shading = a.shading.resolve(a.edge_samples, a.relief_shadows)?;
        a.check().map_err(AppError::Usage)?;
        let material = a.dress.files(MaterialFiles {
            folder: a.material.clone(),
            color_map: a.color_map.clone(),
            normal_map: a.normal_map.clone(),
            roughness_map: a.roughness_map.clone(),
            occlusion_map: a.occlusion_map.clone(),
            cone_map: a.cone_map.clone(),
            ..MaterialFiles::default()
        });
        // Of the sphere the maps tell the facets.
        let drawn_facets = a.relief_shadows && a.scene.scene.name == "plane";
        if drawn_facets && material.anisotropy.is_some() && material.is_displaced(a.height_map.as_deref()) {
            return Err(AppError::Usage(
                "--relief-shadows sees the plane's heights themselves, and --anisotropy is finer than they are: leave one of them out"
                    .into(),
            ));
        }
        let mapped = a.shading.masking.is_none() && material.is_normal_map_alone(a.height_map.as_deref());
        let shading = if mapped && !a.relief_shadows {
            shading.adjusted(|options| ShadingOptions { shadowing: Shadowing::NormalMap, ..options })
        } else {
            shading
        };
        // Something else makes outlines smooth otherwise.
        let once = a.samples == 1 && a.edge_samples == 1 && !a.shading.technique.is_reference();
        let lights = LightExtraction::default();
        let view = match &a.camera {
            CameraChoice::Near => View::Near,
            CameraChoice::Mid => View::Mid,
            CameraChoice::Far => View::Far,
            CameraChoice::Model(_) => View::Model,
            CameraChoice::Pose(pose) => View::Pose(*pose),
            CameraChoice::File(file) => View::Pose(camera_file::read(file).map_err(AppError::Failed)?),
        };
        let default = SceneConfig::default();
        Ok(SceneConfig {
            scene: a.scene.scene,
            model: a.scene.model,
            animation: a.animation,
            model_camera: if let CameraChoice::Model(name) = a.camera { name } else { None },
            lenient: a.lenient,
            displacements: a.displacement,
            measured: a.measured,
            height_map: a.height_map,
            material,
            tiling: if a.no_repeats { Tiling::ByExample } else { Tiling::Repeats },
            bare: a.bare,
            waves,
            height: a.height,
            repeat: a.repeat,
            height_scale: a.height_scale.unwrap_or(default.height_scale),
            stretch: a.stretch.unwrap_or(default.stretch),
            environment: a.environment,
            environment_rotation: a.environment_rotation.unwrap_or(0.0),
            environment_lights: LightExtraction {
                count: a.environment_lights.unwrap_or(lights.count),
                threshold: a.environment_light_threshold.unwrap_or(lights.threshold),
            },
            sun: a.sun.unwrap_or(default.sun),
            time_of_day: a.time_of_day,
            day_length: a.day_length,
            shading,
            displacement: !a.no_displacement,
            triangle_pixels: a.triangle_pixels.unwrap_or(default.triangle_pixels),
            view,
            distance: a.distance,
            size: a.size,
            samples: a.samples,
            msaa: a.msaa.unwrap_or(if once { DEFAULT_MSAA } else { 1 }),
            seed: a.seed,
            exposure: a.exposure,
            auto_exposure: a.auto_exposure,
            tonemap: a.tonemap.unwrap_or(Tonemap::SHOWN),
            atlas_tile: a.atlas_tile.unwrap_or(default.atlas_tile),
            map_precision: a.map_precision.map_or(default.map_precision, MomentFormat::from),
            roughness: a.roughness,
        })
    }

    /// The flags that not every scene honours: whether each is given, and the choice that it makes.
    pub fn choices(&self) -> Vec<(&'static str, bool, Choice)> {
        let flags = [
            ("--height-map", self.height_map.is_some(), Choice::HeightMap),
            ("--height", self.height.is_some(), Choice::HeightMap),
            ("--repeat", self.repeat.is_some(), Choice::HeightMap),
            ("--material", self.material.is_some(), Choice::HeightMap),
            ("--color-map", self.color_map.is_some(), Choice::HeightMap),
            ("--normal-map", self.normal_map.is_some(), Choice::HeightMap),
            ("--roughness-map", self.roughness_map.is_some(), Choice::HeightMap),
            ("--occlusion-map", self.occlusion_map.is_some(), Choice::HeightMap),
            ("--cone-map", self.cone_map.is_some(), Choice::HeightMap),
            ("--no-repeats", self.no_repeats, Choice::Tiling),
            ("--height-scale", self.height_scale.is_some(), Choice::Relief),
            ("--no-displacement", self.no_displacement, Choice::Relief),
            ("--stretch", self.stretch.is_some(), Choice::Stretch),
            ("--relief-shadows", self.relief_shadows, Choice::Relief),
            ("--relief-occlusion", self.shading.relief_occlusion.is_some(), Choice::Relief),
            ("--relief-color", self.shading.relief_color.is_some(), Choice::Relief),
            ("--triangle-pixels", self.triangle_pixels.is_some(), Choice::Objects),
            ("--map-precision", self.map_precision.is_some(), Choice::Objects),
            ("--pixel-kernel", self.shading.pixel_kernel.is_some(), Choice::Objects),
            ("--sky-occlusion", self.shading.sky_occlusion.is_some(), Choice::Objects),
            ("--bare", self.bare, Choice::Bare),
            ("--atlas-tile", self.atlas_tile.is_some(), Choice::AtlasTile),
            ("--roughness", self.roughness.is_some(), Choice::Roughness),
        ];
        let dress = self.dress.flags().map(|(flag, given)| (flag, given, Choice::HeightMap));
        let waves = self.waves.flags().map(|(flag, given)| (flag, given, Choice::Waves));
        flags.into_iter().chain(dress).chain(waves).collect()
    }

    /// Refuses combinations that make no sense.
    fn check(&self) -> Result<(), String> {
        let scene = self.scene.scene;
        if self.animation.is_some() && self.scene.model.is_none() {
            return Err("--animation is for models: --scene FILE.glb or FILE.gltf".into());
        }
        if self.lenient && self.scene.model.is_none() {
            return Err("--lenient is for models: --scene FILE.glb or FILE.gltf".into());
        }
        if !self.displacement.is_empty() && self.scene.model.is_none() {
            return Err("--displacement is for models: --scene FILE.glb or FILE.gltf".into());
        }
        if !self.measured.is_empty() && self.scene.model.is_none() {
            return Err("--measured is for models; for the plane and the sphere write --material FIT.json".into());
        }
        if matches!(self.camera, CameraChoice::Model(_)) {
            if self.scene.model.is_none() {
                return Err("--camera model is for models: --scene FILE.glb or FILE.gltf".into());
            }
            if self.distance.is_some() {
                return Err("--distance is for views of a scene; --camera model is where its file has it".into());
            }
        }
        for (flag, _, choice) in self.choices().into_iter().filter(|flag| flag.1) {
            scene.check_offers(flag, choice)?;
        }
        let normals = self.normal_map.is_some() || self.material.is_some();
        self.dress.check(normals, self.relief_shadows)?;
        if self.sun.is_some() && self.environment != EnvironmentChoice::Sky {
            return Err("--sun is for --environment sky; a picture has its own light".into());
        }
        if self.time_of_day.or(self.day_length).is_some() && self.environment != EnvironmentChoice::Sky {
            return Err("--time-of-day and --day-length are for --environment sky; a picture has its own light".into());
        }
        if self.msaa.is_some_and(|msaa| msaa > 1) {
            if self.edge_samples > 1 {
                return Err("--msaa and --edge-samples do the same: use one of them".into());
            }
            if self.shading.technique.is_reference() {
                let name = self.shading.technique.name();
                return Err(format!("--msaa is for techniques that filter; --technique {name} takes --samples"));
            }
        }
        let about_pictures = [
            (
                "--environment-rotation turns",
                self.environment_rotation.is_some(),
                "--sun and --time-of-day turn the sky's light",
            ),
            ("--auto-exposure exposes for", self.auto_exposure, "the sky is exposed for the height of its sun anyway"),
        ];
        if let Some((flag, _, instead)) = about_pictures.iter().find(|(_, given, _)| *given)
            && self.environment == EnvironmentChoice::Sky
        {
            return Err(format!("{flag} a picture (--environment studio or FILE); {instead}"));
        }
        let about_lights = self.environment_lights.is_some() || self.environment_light_threshold.is_some();
        if about_lights && self.environment == EnvironmentChoice::Sky {
            return Err(
                "--environment-lights and --environment-light-threshold are for pictures; the sky's sun is a light anyway"
                    .into(),
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Command;

    #[test]
    fn without_flags_the_configuration_is_the_default_one() {
        assert_eq!(SceneArgs::unset().unwrap().resolve().unwrap(), SceneConfig::default());
    }

    #[test]
    fn displacement_is_for_models() {
        let displacement = vec!["skin=scales.png".parse().unwrap()];
        let flags = SceneArgs { displacement, ..SceneArgs::unset().unwrap() };
        let said = flags.resolve().unwrap_err().to_string();
        assert!(said.contains("--displacement is for models"), "{said}");
        let scene = scene_choice("fox.glb").unwrap();
        assert_eq!(SceneArgs { scene, ..flags }.resolve().unwrap().displacements.len(), 1);
    }

    #[test]
    fn every_flag_is_honoured_or_refused_by_the_scenes_own_table() {
        let value = |flag: &str| match flag {
            "--height-map" | "--color-map" | "--normal-map" | "--roughness-map" | "--occlusion-map" | "--cone-map" => {
                vec!["a.png"]
            }
            "--detail-mask" => vec!["a.png", "--detail", "b.png"],
            "--detail-repeat" | "--detail-rotation" | "--detail-height-scale" => vec!["2", "--detail", "b.png"],
            "--material" | "--detail" => vec!["a"],
            "--normal-y" => vec!["up", "--normal-map", "a.png"],
            "--metal" => vec!["gold"],
            "--anisotropy-rotation" => vec!["10", "--anisotropy", "0.5"],
            "--no-repeats" | "--no-displacement" | "--bare" => vec![],
            "--relief-shadows" => vec!["--technique", "reference"],
            "--relief-occlusion" | "--relief-color" | "--pixel-kernel" | "--sky-occlusion" => vec!["off"],
            "--map-precision" => vec!["f16"],
            "--atlas-tile" => vec!["64"],
            "--fft" => vec!["128"],
            "--fetch" => vec!["2000"],
            "--height" | "--repeat" | "--height-scale" | "--stretch" | "--triangle-pixels" | "--roughness"
            | "--anisotropy" | "--choppiness" => vec!["0.5"],
            "--wind" | "--wind-direction" | "--depth" => vec!["20"],
            other => panic!("{other} is about a choice, and this test knows no value of it"),
        };
        #[derive(Parser)]
        struct Flags {
            #[command(flatten)]
            scene: SceneArgs,
        }
        let names: Vec<&str> = SCENES.iter().map(|scene| scene.name).chain(["model.glb"]).collect();
        for (flag, _, choice) in SceneArgs::unset().unwrap().choices() {
            for name in &names {
                let line = [&["leadr", "--scene", name, flag][..], &value(flag)].concat();
                let args = Flags::try_parse_from(&line).unwrap_or_else(|fault| panic!("{line:?}: {fault}")).scene;
                let scene = args.scene.scene;
                match args.resolve() {
                    Ok(_) => assert!(scene.offers(choice), "{line:?} is ignored"),
                    Err(fault) => {
                        let said = fault.to_string();
                        assert!(!scene.offers(choice), "{line:?}: {said}");
                        assert!(said.starts_with(flag) || said.starts_with("--"), "{line:?}: {said}");
                        assert!(said.contains(scene.name) && said.contains("is for the scenes"), "{line:?}: {said}");
                    }
                }
            }
        }
        // What is a flag of the scene's surfaces stands in the table, or is for pictures, light, views and models of every scene.
        let of_every_scene = [
            "scene",
            "animation",
            "lenient",
            "displacement",
            "measured",
            "environment",
            "environment-lights",
            "environment-light-threshold",
            "environment-rotation",
            "auto-exposure",
            "sun",
            "time-of-day",
            "day-length",
            "technique",
            "rule",
            "grid",
            "probes",
            "masking",
            "terms",
            "diffuse-lights",
            "base-frame",
            "multiscattering",
            "camera",
            "distance",
            "size",
            "samples",
            "msaa",
            "edge-samples",
            "seed",
            "exposure",
            "tonemap",
        ];
        let table: Vec<_> = SceneArgs::unset().unwrap().choices().into_iter().map(|(flag, ..)| flag).collect();
        for argument in SceneArgs::augment_args(Command::new("scene")).get_arguments() {
            let long = argument.get_long().unwrap_or_default();
            let known = of_every_scene.contains(&long) || table.contains(&format!("--{long}").as_str());
            assert!(known, "does every scene honour --{long}? If not, it belongs into SceneArgs::choices");
        }
    }

    #[test]
    fn metres_are_for_surfaces_with_maps_and_turns_for_pictures() {
        #[derive(Parser)]
        struct Flags {
            #[command(flatten)]
            scene: SceneArgs,
        }
        let resolve = |line: &str| {
            let flags =
                Flags::try_parse_from(["leadr"].into_iter().chain(line.split(' '))).map_err(|e| e.to_string())?;
            flags.scene.resolve().map_err(|e| e.to_string())
        };
        let plane = resolve("--scene plane --height 0.05 --repeat 0.6").unwrap();
        assert_eq!((plane.height, plane.repeat), (Some(0.05), Some(0.6)));
        let studio = resolve("--environment studio --environment-rotation -45 --auto-exposure").unwrap();
        assert_eq!((studio.environment_rotation, studio.auto_exposure), (-45.0, true));
        for (line, word) in [
            ("--scene trex --height 0.05", "is for the scenes plane, sphere"),
            ("--scene ocean --repeat 3", "plane, sphere"),
            ("--scene plane --height=-1", "negative"),
            ("--scene plane --repeat 0", "0.01"),
            ("--environment-rotation 10", "--sun"),
            ("--auto-exposure", "anyway"),
        ] {
            let said = resolve(line).unwrap_err();
            assert!(said.contains(word), "{line}: {said}");
        }
    }

    #[test]
    fn a_picture_has_its_own_sun() {
        let sun = Some(SunDirection { azimuth: 10.0, elevation: 10.0 });
        let flags = SceneArgs { sun, ..SceneArgs::unset().unwrap() };
        assert_eq!(Some(flags.resolve().unwrap().sun), sun);
        let said = SceneArgs { environment: EnvironmentChoice::Studio, ..flags }.resolve().unwrap_err().to_string();
        assert!(said.contains("--sun is for --environment sky"), "{said}");
    }

    #[test]
    fn roughness_is_taken_by_every_scene_that_offers_it_and_refused_by_the_sea() {
        for scene in &SCENES {
            let flags = SceneArgs {
                scene: SceneChoice { scene, model: None },
                roughness: Some(0.3),
                ..SceneArgs::unset().unwrap()
            };
            match flags.resolve() {
                Ok(config) => assert!(config.roughness == Some(0.3) && scene.offers(Choice::Roughness), "{scene:?}"),
                Err(error) => {
                    let said = error.to_string();
                    assert!(scene.name == "ocean" && said.contains("--roughness") && said.contains("shore"), "{said}");
                }
            }
        }
    }
}
