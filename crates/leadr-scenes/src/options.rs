//! Every option of a picture of a scene, each in one row. Options of the shading are rows of [`ShadingOptions::ALL`].

use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::LazyLock;

use self::Sets::{Flag, Path, Text};
use super::config::{NormalY, Picture, SceneConfig};
use super::deform::FACTORS;
use super::registry::{Choice, MODEL, NamedScene, SCENES};
use super::text::see;
use leadr_reflectance::facets::metals::{METALS, Metal};
use leadr_render::constants::MOST_MULTISAMPLES;
use leadr_render::light::panorama::MAX_ENVIRONMENT_LIGHTS;
use leadr_render::scene::Tiling;
use leadr_render::settings::headings::{CAMERA, GEOMETRY, LIGHT, MATERIAL, QUALITY, SCENE, SEA, SHADING};
use leadr_render::settings::numbers::{finite, not_negative, positive, power_of_two, share, whole, within};
use leadr_render::settings::{
    Json, Named, Panel, ShadingOption, ShadingOptions, Slider, Spec, Subject, Technique, Value,
};
use leadr_render::surfaces::moments::MomentFormat;

/// An option of a picture of a scene.
pub struct SceneOption {
    /// What is said about it.
    pub spec: Spec,
    /// What it changes.
    pub sets: Sets,
    /// The choice that a scene must offer to honour it; `None` if every scene does.
    pub choice: Option<Choice>,
    /// The surroundings that it is about; `None` for all.
    pub under: Option<Under>,
    /// Whether it may be given several times.
    pub repeats: bool,
    /// Names of its values and what they are, if they are few.
    pub names: fn() -> Vec<(&'static str, &'static str)>,
}

/// What an option changes, and how its value is read.
pub enum Sets {
    /// A configuration, by being given.
    Flag(fn(&mut SceneConfig)),
    /// A configuration, by a path.
    Path(fn(&mut SceneConfig, PathBuf)),
    /// A configuration, by a text.
    Text(fn(&mut SceneConfig, &str) -> Result<(), String>),
    /// How a scene is drawn.
    Picture(Value<Picture>),
    /// How it is shaded.
    Shading(&'static ShadingOption),
}

/// Surroundings that some options are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Under {
    /// The analytic sky.
    Sky,
    /// A picture.
    Panorama,
}

const REMADE: Panel = Panel::Without("it would make the scene again");
const FILES: Panel = Panel::Without("files are dropped on the window");

const fn option(
    heading: &'static str,
    name: &'static str,
    value_name: &'static str,
    help: &'static str,
    sets: Sets,
) -> SceneOption {
    let panel = if matches!(sets, Path(_)) { FILES } else { REMADE };
    let spec = Spec::new(heading, name, value_name, help).panel(panel);
    SceneOption { spec, sets, choice: None, under: None, repeats: false, names: Vec::new }
}

const fn material(name: &'static str, value_name: &'static str, help: &'static str, sets: Sets) -> SceneOption {
    option(MATERIAL, name, value_name, help, sets).of(Choice::HeightMap)
}

const fn sea(name: &'static str, value_name: &'static str, help: &'static str, sets: Sets) -> SceneOption {
    option(SEA, name, value_name, help, sets).of(Choice::Waves)
}

const fn slider(ends: [f32; 2], decimals: usize, unit: &'static str) -> Slider {
    Slider { ends, decimals, unit }
}

#[rustfmt::skip]
impl SceneOption {
    const fn common(self) -> Self { Self { spec: self.spec.common(), ..self } }
    const fn default(self, words: &'static str) -> Self { Self { spec: self.spec.default(words), ..self } }
    const fn formerly(self, name: &'static str) -> Self { Self { spec: self.spec.formerly(name), ..self } }
    const fn key(self, key: &'static str) -> Self { Self { spec: self.spec.key(key), ..self } }
    const fn panel(self, panel: Panel) -> Self { Self { spec: self.spec.panel(panel), ..self } }
    /// For scenes that offer a choice.
    const fn of(self, choice: Choice) -> Self { Self { choice: Some(choice), ..self } }
    const fn under(self, under: Under) -> Self { Self { under: Some(under), ..self } }
    const fn repeats(self) -> Self { Self { repeats: true, ..self } }
    const fn values(self, names: fn() -> Vec<(&'static str, &'static str)>) -> Self { Self { names, ..self } }
}

/// The options that are not of the shading.
#[rustfmt::skip]
const OPTIONS: [SceneOption; 55] = [
    option(SCENE, "scene", "NAME|FILE.glb|FILE.gltf", "Draw this scene, or a glTF model on open ground",
        Text(enter)).common().default(SCENES[0].name).panel(Panel::Own),
    option(SCENE, "animation", "NAME", "Play this animation of a model",
        Text(|c, name| {
            c.animation = Some(name.into());
            Ok(())
        })).default("its first").of(Choice::Model),
    option(SCENE, "lenient", "",
        "Replace missing and damaged images of a model instead of refusing it: colours by a magenta check, numbers by their factor",
        Flag(|c| c.lenient = true)).of(Choice::Model),
    option(SCENE, "displacement", "MATERIAL=FILE[,SCALE[,MIDDLE]]",
        "Displace a material of a model (`*`: all of them) by heights, PNG or EXR. SCALE is the metres from the map's 0 to its 1 \
         [default: what fits its normal map or looks usual], MIDDLE the height that lies on the mesh [default: the mean]. May be given \
         several times. Maps beside the model that are named MATERIAL_Displacement.png or like its image are found",
        Text(|c, text| text.parse().map(|map| c.displacements.push(map)))).default("").key("displacements").of(Choice::Model).repeats(),
    option(SCENE, "measured", "MATERIAL=FIT.json",
        "Replace a material of a model (`*`: all of them) by a measured one from `leadr fit`. Relief, occlusion and cutouts stay the \
         model's; a roughness texture scales the measured slopes about its own mean. May be given several times. The plane and the \
         sphere take `--material FIT.json`",
        Text(|c, text| text.parse().map(|material| c.measured.push(material)))).of(Choice::Model).repeats().panel(Panel::Own),
    option(SCENE, "bare", "", "Draw only the surface: no pavement, plinth or kerb around it",
        Flag(|c| c.bare = true)).of(Choice::Bare),
    material("height-map", "FILE",
        "Displace by this height map: PNG or EXR, or KTX2 or EXR from `leadr bake`. Its first row lies at y = 0, rows run along +y",
        Path(|c, file| c.height_map = Some(file))).common(),
    material("material", "FOLDER|FIT.json",
        "Apply a material as downloaded (NAME_Color.png, NAME_NormalGL.png, NAME_Roughness.png, NAME_Displacement.png, ...), or a \
         measured one from `leadr fit`. Seen from above, it lies upright with +y on top",
        Path(|c, file| c.material.folder = Some(file))).common().panel(Panel::Own),
    material("color-map", "FILE", "Use these base colours: PNG or JPEG in sRGB, or linear EXR. With --height-map, both lie upright",
        Path(|c, file| c.material.color_map = Some(file))),
    material("normal-map", "FILE", "Use these tangent-space normals, two or three channels. Whether green points up or down is detected",
        Path(|c, file| c.material.normal_map = Some(file))),
    material("normal-y", "up|down", "Set which way the green channel of the normal map points, instead of detecting it",
        Text(|c, text| c.material.normal_y.insert(NormalY::Up).choose(text))).values(|| NormalY::Up.names()),
    material("roughness-map", "FILE", "Use this perceptual roughness, the square root of alpha",
        Path(|c, file| c.material.roughness_map = Some(file))),
    material("occlusion-map", "FILE", "Use this ambient occlusion, for materials without heights. Heights give their own",
        Path(|c, file| c.material.occlusion_map = Some(file))),
    material("cone-map", "FILE",
        "Use these cones of ambient occlusion, PNG, from `leadr bake --kind cones`. The sphere uses only how open they are",
        Path(|c, file| c.material.cone_map = Some(file))),
    material("metal", "NAME", "Use this metal instead of the material's own colours and metalness",
        Text(|c, name| Metal::named(name).map(|metal| c.material.metal = Some(metal.name)).ok_or("no such metal".into())))
        .values(|| METALS.iter().map(|metal| (metal.name, "")).collect()),
    option(MATERIAL, "roughness", "A", "Set the Beckmann roughness of displaced surfaces, above 0, up to 1, instead of the scene's own",
        Text(|c, text| positive(text).and_then(|_| within(text, 0.0, 1.0)).map(|alpha| c.roughness = Some(alpha as f32))))
        .common().of(Choice::Roughness).panel(Panel::Own),
    material("anisotropy", "X",
        "Make the material rougher along one direction, 0 to 1: mix alpha along it towards 1 by the square of X. The direction is +x on \
         the plane and runs around the poles of the sphere",
        Text(|c, text| share(text).map(|strength| c.material.anisotropy = Some(strength)))),
    material("anisotropy-rotation", "DEGREES", "Rotate the direction of --anisotropy counter-clockwise",
        Text(|c, text| finite(text).map(|degrees| c.material.anisotropy_rotation = degrees))).default("0"),
    material("detail", "FOLDER|FILE",
        "Repeat a finer material over the surface: a folder as for --material, an image of heights, or an image of normals whose name \
         says so. It changes shading, not geometry",
        Path(|c, file| c.material.detail.detail = Some(file))),
    material("detail-repeat", "N", "Repeat the detail N times within one repeat of the material",
        Text(|c, text| positive(text).map(|times| c.material.detail.detail_repeat = times))).default("8"),
    material("detail-rotation", "DEGREES", "Rotate the detail counter-clockwise",
        Text(|c, text| finite(text).map(|degrees| c.material.detail.detail_rotation = degrees))).default("0"),
    material("detail-height-scale", "X", "Multiply the slopes of the detail by X",
        Text(|c, text| not_negative(text).map(|factor| c.material.detail.detail_height_scale = factor))).default("1"),
    material("detail-mask", "FILE",
        "Show the detail where this image is white, over one repeat of the material. Without a mask it is everywhere, and its colours \
         vary those of the material",
        Path(|c, file| c.material.detail.detail_mask = Some(file))),
    option(MATERIAL, "no-repeats", "",
        "Tile the maps by example: blended pieces that never repeat, with the same mean and covariance of slopes. For ground, sand, \
         plaster and other maps without order",
        Flag(|c| c.tiling = Tiling::ByExample)).of(Choice::Tiling),
    material("height", "METRES", "Set the metres from the 0 of the heights (black) to their 1 (white)",
        Text(|c, text| not_negative(text).map(|metres| c.height = Some(metres))))
        .default("what fits the material's normals; 0.12 for heights alone"),
    // Coordinates of smaller repeats have too few bits on a plane of 8 m.
    material("repeat", "METRES", "Set the width of one repeat of height maps and materials, 0.01 to 1000",
        Text(|c, text| within(text, 0.01, 1000.0).map(|metres| c.repeat = Some(metres as f32))))
        .default("2 on the plane, 1.2 on the sphere"),
    sea("wind", "M/S", "Set the wind speed 10 m above the water, 1 to 40",
        Text(|c, text| within(text, 1.0, 40.0).map(|speed| c.waves.wind = speed))).default("8; 6 off the shore").key("waves/wind"),
    sea("wind-direction", "DEGREES", "Set where the wind blows to, counter-clockwise from +x",
        Text(|c, text| within(text, -360.0, 360.0).map(|degrees| c.waves.wind_direction = degrees)))
        .default("34; -20 off the shore").key("waves/wind_direction"),
    sea("fetch", "METRES", "Set the distance over which the wind has blown, 1000 to 5000000",
        Text(|c, text| within(text, 1e3, 5e6).map(|metres| c.waves.fetch = metres))).default("120000; 40000 off the shore").key("waves/fetch"),
    sea("depth", "METRES", "Set the depth of the water, 1 to 11000",
        Text(|c, text| within(text, 1.0, 11e3).map(|metres| c.waves.depth = metres))).default("200").key("waves/depth"),
    sea("choppiness", "X", "Set how far waves move sideways, which sharpens their crests: 0 not at all, 1 like real water",
        Text(|c, text| within(text, 0.0, 1.0).map(|factor| c.waves.choppiness = factor))).default("1").key("waves/choppiness"),
    sea("fft", "N", "Set the samples along the edge of a tile of waves: 64, 128, 256 or 512",
        Text(|c, text| power_of_two(text, 64, 512).map(|samples| c.waves.fft = samples))).default("256").key("waves/fft"),
    option(GEOMETRY, "height-scale", "X", "Multiply the displacement by X; 0 is flat",
        Sets::Picture(Value::Number(|p| &mut p.height_scale, not_negative, slider([0.0, 3.0], 2, "")))).of(Choice::Relief),
    option(GEOMETRY, "stretch", "X",
        "Stretch everything along x by X, 0.2 to 5, and flatten it along z by as much. Texture coordinates stay",
        Sets::Picture(Value::Number(|p| &mut p.stretch, factor, slider([*FACTORS.start(), *FACTORS.end()], 2, "")))).of(Choice::Stretch),
    option(GEOMETRY, "smooth-geometry", "", "Do not displace the geometry; the slopes of the height map still shade it",
        Sets::Picture(Value::Flag(|p| &mut p.displacement, false))).formerly("no-displacement").key("displacement").of(Choice::Relief),
    option(GEOMETRY, "triangle-pixels", "PIXELS", "Set the size of the triangles of displaced surfaces on the screen",
        Sets::Picture(Value::Number(|p| &mut p.triangle_pixels, positive, slider([1.0, 32.0], 1, " px")))).of(Choice::Objects),
    option(GEOMETRY, "atlas-tile", "N", "Set the texels along the tile of one patch in the displacement atlas: 8, 16, 32, 64 or 128",
        Text(|c, text| power_of_two(text, 8, 128).map(|texels| c.atlas_tile = texels))).default("64").of(Choice::AtlasTile),
    option(GEOMETRY, "map-precision", "PRECISION", "Store the slopes of maps on the device in this format",
        Text(|c, text| {
            let formats = [MomentFormat::Float32, MomentFormat::Float16];
            let format = formats.into_iter().find(|format| format.name() == text);
            format.map(|format| c.map_precision = format).ok_or("use f32 or f16".into())
        })).default("f32").of(Choice::Objects)
        .values(|| vec![("f32", "32-bit floats"), ("f16", "16-bit floats: half the memory, with a measured error")]),
    option(LIGHT, "environment", "sky|studio|FILE.hdr|FILE.exr",
        "Light the scene by the analytic sky, a studio, or an equirectangular image",
        Text(|c, text| text.parse().map(|choice| c.environment = choice))).common().default("sky").panel(Panel::Own),
    option(LIGHT, "environment-rotation", "DEGREES", "Rotate the environment image counter-clockwise, seen from above",
        Text(|c, text| finite(text).map(|degrees| c.environment_rotation = degrees))).default("0").under(Under::Panorama),
    option(LIGHT, "environment-lights", "N", "Turn up to N bright spots of the environment image into lights that cast shadows, 0 to 4",
        Text(|c, text| whole(text, 0, MAX_ENVIRONMENT_LIGHTS).map(|most| c.environment_lights.count = most))).default("4").under(Under::Panorama),
    option(LIGHT, "environment-light-threshold", "X", "Count a spot of the environment image as bright from X times its mean radiance",
        Text(|c, text| positive(text).map(|factor| c.environment_lights.threshold = factor))).default("8").under(Under::Panorama),
    option(LIGHT, "sun", "AZIMUTH,ELEVATION", "Set the direction to the sun in degrees: counter-clockwise from +x, and above the horizon",
        Text(|c, text| text.parse().map(|sun| c.sun = sun))).common().default("-50,38").under(Under::Sky).panel(Panel::Own),
    option(LIGHT, "time-of-day", "HOURS",
        "Set the hour at which the scene begins, instead of --sun. The sun rises in the east (+x) at 5:30 and sets at 18:30",
        Text(|c, text| within(text, 0.0, 24.0).map(|hour| c.time_of_day = Some(hour as f32)))).common().under(Under::Sky).panel(Panel::Own),
    option(LIGHT, "day-length", "SECONDS", "Move the sun once around the sky in this time",
        Text(|c, text| positive(text).map(|seconds| c.day_length = Some(seconds))))
        .default("it stands still").under(Under::Sky).panel(Panel::Own),
    option(LIGHT, "exposure", "EV",
        "Brighten a PNG or a window by this many stops beyond what suits the height of the sun. An EXR keeps linear radiance",
        Sets::Picture(Value::Number(|p| &mut p.exposure, finite, slider([-4.0, 4.0], 1, " EV")))).common(),
    option(LIGHT, "auto-exposure", "",
        "Expose for the environment image: level ground in its light is as bright as under the sky at mid-morning. --exposure adds \
         stops",
        Flag(|c| c.auto_exposure = true)).under(Under::Panorama),
    option(LIGHT, "tonemap", "NAME", "Map the light of a PNG or a window to a screen by this curve",
        Sets::Picture(Value::Name(|p| &mut p.tonemap))),
    option(CAMERA, "camera", "near|mid|far|model|model:NAME|FILE.json|X,Y,Z:X,Y,Z[:DEGREES]",
        "Look from a view of the scene, from a camera of a model's file (the first, or by name or number), from a JSON file {position, \
         target, up, fov_degrees}, or from a position to a target with a vertical field of view",
        Text(see)).common().default("mid").key("view").panel(Panel::Own),
    option(CAMERA, "distance", "METRES", "Move the camera along its line of sight to this distance from its target",
        Text(|c, text| positive(text).map(|metres| c.distance = Some(metres)))).common().panel(Panel::Own),
    option(SHADING, "technique", "NAME", "Filter and shade surfaces by this technique",
        Sets::Picture(Value::Name(|p| &mut p.technique))).common().panel(Panel::Own),
    option(QUALITY, "size", "WxH", "Set the size of the picture in pixels",
        Text(|c, text| text.parse().map(|size| c.size = size)))
        .common().default("1280x720").panel(Panel::Without("the window has a size")),
    option(QUALITY, "samples", "N", "Draw N samples per pixel; a window does once nothing moves",
        Sets::Picture(Value::Count(|p| &mut p.samples, [1, 65_536], slider([1.0, 64.0], 0, "")))).common(),
    option(QUALITY, "msaa", "N",
        "Sample the geometry 1, 2, 4 or 8 times in each sample, for smooth silhouettes at little cost; each surface in a pixel is \
         shaded once",
        Text(|c, text| power_of_two(text, 1, MOST_MULTISAMPLES).map(|samples| c.msaa = samples)))
        .common().default("4 with --samples 1, and in a window for what moves unless a frame then takes longer than 100 ms; else 1")
        .panel(Panel::Without("the window multisamples what moves as far as its pace allows")),
    option(QUALITY, "seed", "N", "Set the seed of the sample positions",
        Text(|c, text| whole(text, 0, u64::MAX).map(|seed| c.seed = seed))).default("0").panel(Panel::Without("it only moves noise")),
];

impl SceneOption {
    /// Every option, in the order of the help.
    pub fn all() -> &'static [Self] {
        static ALL: LazyLock<Vec<SceneOption>> = LazyLock::new(|| {
            let shading = ShadingOptions::ALL.iter().map(|row| SceneOption {
                spec: row.spec,
                choice: match row.subject {
                    Subject::Anything => None,
                    Subject::Objects => Some(Choice::Objects),
                    Subject::Relief => Some(Choice::Relief),
                },
                ..option(SHADING, "", "", "", Sets::Shading(row))
            });
            OPTIONS.into_iter().chain(shading).collect()
        });
        &ALL
    }

    /// The option of this name.
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::all().iter().find(|option| option.spec.name == name)
    }

    /// Changes a configuration to what is written; refuses what is not understood.
    pub fn set(&self, config: &mut SceneConfig, value: &OsStr) -> Result<(), String> {
        let text = || value.to_str().ok_or_else(|| "this is not UTF-8".to_owned());
        match &self.sets {
            Flag(set) => set(config),
            Path(set) => set(config, value.into()),
            Text(set) => set(config, text()?)?,
            Sets::Picture(place) => place.read(&mut config.picture, text()?)?,
            Sets::Shading(row) => row.value.read(&mut config.picture.options, text()?)?,
        }
        Ok(())
    }

    /// How it is written for a picture, as far as it is about how a scene is drawn; empty for a flag without a value.
    pub fn write(&self, picture: &Picture) -> Option<String> {
        match &self.sets {
            Sets::Picture(place) => place.write(*picture),
            Sets::Shading(row) => row.value.write(picture.options),
            _ => None,
        }
    }

    /// Its value in JSON, as far as it is about how a scene is drawn.
    pub fn json(&self, picture: &Picture) -> Option<Json> {
        match &self.sets {
            Sets::Picture(place) => place.json(*picture),
            Sets::Shading(row) => row.json(picture.technique, picture.options),
            _ => None,
        }
    }

    /// Names of its values and what they are, if they are few.
    pub fn names(&self) -> Vec<(&'static str, &'static str)> {
        match &self.sets {
            Sets::Picture(place) => place.names(Picture::default()),
            Sets::Shading(row) => row.value.names(ShadingOptions::default()),
            _ => (self.names)(),
        }
    }

    /// Whether it takes a value.
    pub fn takes_value(&self) -> bool {
        !self.spec.value_name.is_empty()
    }

    /// Whether it is about the surface of one scene, which another does not take over.
    pub fn is_of_one_scene(&self) -> bool {
        matches!(self.spec.heading, SCENE | MATERIAL | SEA)
    }

    /// Whether a scene and a technique have it.
    pub fn applies_to(&self, scene: &NamedScene, technique: Technique) -> bool {
        let of_technique = if let Sets::Shading(row) = self.sets { row.applies_to(technique) } else { true };
        of_technique && self.choice.is_none_or(|choice| scene.offers(choice))
    }

    /// What it does, with the scenes and techniques that honour it and its default.
    pub fn help(&self) -> String {
        let mut help = self.spec.help.to_owned();
        if let Some(choice) = self.choice.filter(|choice| *choice != Choice::Model) {
            let (with, without): (Vec<_>, Vec<_>) = SCENES.iter().partition(|scene| scene.offers(choice));
            let few = with.len() <= without.len();
            let names: Vec<_> = if few { with } else { without }.iter().map(|scene| scene.name).collect();
            help += &format!(" ({}{})", if few { "" } else { "not for " }, names.join(", "));
        }
        if let Sets::Shading(ShadingOption { techniques, .. }) = self.sets
            && Technique::ALL.into_iter().filter(|&technique| (techniques.has)(technique)).count()
                < Technique::ALL.len() / 2
        {
            help += &format!(" ({})", techniques.names());
        }
        let own = || self.write(&Picture::default()).filter(|text| !text.is_empty());
        match self.spec.default.map(str::to_owned).or_else(own) {
            Some(default) if !default.is_empty() => format!("{help} [default: {default}]"),
            _ => help,
        }
    }
}

/// A factor on widths.
fn factor(text: &str) -> Result<f32, String> {
    within(text, *FACTORS.start(), *FACTORS.end())
}

/// Draws the scene of this name, or a model, with its own sea.
fn enter(config: &mut SceneConfig, name: &str) -> Result<(), String> {
    let file = PathBuf::from(name);
    let extension = file.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    if matches!(extension.as_deref(), Some("glb" | "gltf")) {
        (config.scene, config.model) = (&MODEL, Some(file));
    } else {
        let names = || SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
        let unknown = || format!("no such scene; there are {}, and files that end in .glb or .gltf", names());
        (config.scene, config.model) = (NamedScene::find(name).ok_or_else(unknown)?, None);
    }
    config.waves = config.scene.waves();
    Ok(())
}
