//! All options of a scene picture, with one option per row. The shading options come from [`ShadingOptions::ALL`].

use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::LazyLock;

use self::Sets::{Flag, Path, Text};
use super::config::{NormalY, Picture, SceneConfig};
use super::deform::FACTORS;
use super::placed_light::color_of;
use super::registry::{Choice, MODEL, NamedScene, SCENES};
use super::text::{see, similar};
use super::trex::stage::SkinRelief;
use leadr_reflectance::facets::metals::{METALS, Metal};
use leadr_render::constants::MOST_MULTISAMPLES;
use leadr_render::light::panorama::MAX_ENVIRONMENT_LIGHTS;
use leadr_render::scene::{CoatRelief, MAX_LAMPS, Tiling};
use leadr_render::settings::headings::{CAMERA, GEOMETRY, LIGHT, MATERIAL, QUALITY, SCENE, SEA, SHADING};
use leadr_render::settings::numbers::{
    finite, not_negative, positive, positive_share, power_of_two, share, whole, within,
};
use leadr_render::settings::{
    Json, Named, Panel, ShadingOption, ShadingOptions, Slider, Spec, Subject, Technique, Value,
};
use leadr_render::surfaces::moments::MomentFormat;

/// An option of a scene picture.
pub struct SceneOption {
    /// The name, the syntax and the help text.
    pub spec: Spec,
    /// The setting that the option changes.
    pub sets: Sets,
    /// The choice that a scene must offer if it supports the option; `None` if every scene supports it.
    pub choice: Option<Choice>,
    /// The environment that the option requires; `None` if it works with any environment.
    pub under: Option<Under>,
    /// Whether the option may be repeated.
    pub repeats: bool,
    /// Returns the names and descriptions of the values, for options with few values.
    pub names: fn() -> Vec<(&'static str, &'static str)>,
}

/// The setting that an option changes, and the way in which its value is parsed.
pub enum Sets {
    /// A flag without a value.
    Flag(fn(&mut SceneConfig)),
    /// A setting whose value is a path.
    Path(fn(&mut SceneConfig, PathBuf)),
    /// A setting whose value is a text.
    Text(fn(&mut SceneConfig, &str) -> Result<(), String>),
    /// A setting of [`Picture`].
    Picture(Value<Picture>),
    /// A shading option.
    Shading(&'static ShadingOption),
}

/// The environment that an option requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Under {
    /// The analytic sky.
    Sky,
    /// An environment image.
    Panorama,
}

/// The roughness of a clear coat for which none is given.
const COAT_ROUGHNESS: f32 = 0.05;

/// Parses the weight and the roughness of a clear coat.
fn clear_coat(text: &str) -> Result<[f32; 2], String> {
    let (weight, roughness) =
        text.split_once(',').map_or((text, None), |(weight, roughness)| (weight, Some(roughness)));
    let weight = share(weight).map_err(|fault| format!("the weight {fault}"))?;
    let roughness =
        roughness.map_or(Ok(COAT_ROUGHNESS), positive_share).map_err(|fault| format!("the roughness {fault}"))?;
    Ok([weight, roughness])
}

/// Parses the colour of a body, and the distance in metres after which white light has this colour.
fn attenuation(text: &str) -> Result<([f32; 3], f32), String> {
    let (color, metres) = text.split_once(',').ok_or("use a colour and a distance in metres, such as 80c0a0,0.5")?;
    Ok((color_of(color)?, positive(metres).map_err(|fault| format!("the distance {fault}"))?))
}

const REMADE: Panel = Panel::Without("a change rebuilds the scene");
const FILES: Panel = Panel::Without("you drop files on the window instead");

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
    /// Restricts the option to scenes that offer this choice.
    const fn of(self, choice: Choice) -> Self { Self { choice: Some(choice), ..self } }
    const fn called(self, label: &'static str) -> Self { Self { spec: self.spec.called(label), ..self } }
    const fn under(self, under: Under) -> Self { Self { under: Some(under), ..self } }
    const fn repeats(self) -> Self { Self { repeats: true, ..self } }
    const fn values(self, names: fn() -> Vec<(&'static str, &'static str)>) -> Self { Self { names, ..self } }
}

/// All options except the shading options.
#[rustfmt::skip]
#[allow(clippy::large_const_arrays, reason = "the list takes the options by value, once")]
const OPTIONS: [SceneOption; 73] = [
    option(SCENE, "scene", "NAME|FILE.glb|FILE.gltf", "Draw this scene, or a glTF model on open ground",
        Text(enter)).common().default(SCENES[0].name).panel(Panel::Own),
    option(SCENE, "animation", "NAME|NUMBER", "Play the animation of a model with this name or number, from 1",
        Text(|c, name| {
            c.animation = Some(name.into());
            Ok(())
        })).default("the first animation").of(Choice::Model).panel(Panel::Own),
    option(SCENE, "variant", "NAME", "Draw this variant of the materials of a model. An unknown name lists the variants",
        Text(|c, name| {
            c.variant = Some(name.into());
            Ok(())
        })).of(Choice::Model),
    option(SCENE, "strict", "",
        "Refuse a model that violates glTF. Without this option, such parts are repaired or left out with a warning. A magenta \
         checkerboard replaces a colour image that is missing or damaged; the constant factor of the material replaces any \
         other image",
        Flag(|c| c.strict = true)).of(Choice::Model),
    option(SCENE, "follow-links", "",
        "Read files of a model, or of a folder of --material or --detail, through links that lead out of the folder. Use this \
         option only for folders that you trust",
        Flag(|c| c.follow_links = true)).of(Choice::Folder),
    option(SCENE, "displacement", "MATERIAL=FILE[,SCALE[,MIDDLE]]",
        "Displace a material of a model (`*`: all materials) by a height map (PNG, TIFF, EXR, KTX2 or another image format). SCALE is the height in metres \
         between the values 0 and 1 of the map [default: the scale that fits the normal map, else a typical scale]. MIDDLE is \
         the value of the map that leaves the mesh in place [default: the mean of the map]. You can repeat this option. \
         Without it, a map beside the model is used if it is named after the material or its colour image, such as \
         MATERIAL_Displacement.png",
        Text(|c, text| text.parse().map(|map| c.displacements.push(map)))).default("").key("displacements").of(Choice::Model).repeats(),
    option(SCENE, "cones", "MATERIAL=FILE",
        "Give a material of a model (`*`: all materials) this PNG of ambient occlusion cones from `leadr bake --kind cones`, which replace \
         its occlusion. The cones lie over the material like its normal map. You can repeat this option. For the plane and the \
         sphere, use `--cone-map`",
        Text(|c, text| text.parse().map(|cones| c.cones.push(cones)))).of(Choice::Model).repeats(),
    option(SCENE, "measured", "MATERIAL=FIT.json",
        "Replace a material of a model (`*`: all materials) by a measured material from `leadr fit`. The relief, occlusion \
         and cutouts of the model remain. The roughness texture of the model, divided by its mean, scales the measured \
         slopes. You can repeat this option. For the plane and the sphere, use `--material FIT.json`",
        Text(|c, text| text.parse().map(|material| c.measured.push(material)))).of(Choice::Model).repeats().panel(Panel::Own),
    option(SCENE, "bare", "", "Draw only the surface, without the ground, plinth or kerb around it",
        Flag(|c| c.bare = true)).of(Choice::Bare),
    option(SCENE, "ground", "on|off|auto",
        "Draw ground below a model: `on`, `off`, or `auto` for models without a floor of their own",
        Text(|c, text| text.parse().map(|ground| c.ground = ground))).default("auto").of(Choice::Model),
    material("height-map", "FILE",
        "Displace the surface by this height map: an image such as PNG, TIFF or EXR, or a KTX2 or EXR from `leadr bake`. The image \
         lies upright when seen from above: its top points to +y. The mean of its heights lies on the mesh",
        Path(|c, file| c.height_map = Some(file))).common(),
    material("material", "FOLDER|FIT.json",
        "Apply a downloaded material folder (NAME_Color.png, NAME_NormalGL.png, NAME_Roughness.png, NAME_Displacement.png, \
         ...), or a measured material from `leadr fit`. The images lie upright when seen from above: their tops point to +y",
        Path(|c, file| c.material.folder = Some(file))).common().panel(Panel::Own),
    material("color-map", "FILE",
        "Use the base colours of this image: an sRGB PNG, JPEG, TIFF or WebP, or a linear EXR. The image lies upright when seen from \
         above: its top points to +y",
        Path(|c, file| c.material.color_map = Some(file))),
    material("normal-map", "FILE",
        "Use this tangent-space normal map with two or three channels. The direction of its green channel is detected",
        Path(|c, file| c.material.normal_map = Some(file))),
    material("normal-y", "up|down",
        "Set the direction of the green channel of the normal map, instead of detecting the direction",
        Text(|c, text| c.material.normal_y.insert(NormalY::Up).choose(text))).values(|| NormalY::Up.names()),
    material("roughness-map", "FILE", "Use this map of perceptual roughness (the square root of alpha)",
        Path(|c, file| c.material.roughness_map = Some(file))),
    material("occlusion-map", "FILE",
        "Use this ambient occlusion map for a material without heights. For a material with heights, occlusion is computed \
         from the heights",
        Path(|c, file| c.material.occlusion_map = Some(file))),
    material("cone-map", "FILE",
        "Use this PNG of ambient occlusion cones from `leadr bake --kind cones`. For a material with heights, the cones replace the \
         occlusion that is computed from the heights. For a model, use `--cones`",
        Path(|c, file| c.material.cone_map = Some(file))),
    material("metal", "NAME", "Replace the colours and the metalness of the material by those of this metal. Without a height map or a material, the surface is smooth",
        Text(|c, name| Metal::named(name).map(|metal| c.material.metal = Some(metal.name)).ok_or("no such metal".into())))
        .values(|| METALS.iter().map(|metal| (metal.name, "")).collect()),
    option(MATERIAL, "roughness", "A",
        "Set the Beckmann roughness of displaced surfaces, above 0 and at most 1, instead of the roughness in the scene",
        Text(|c, text| positive_share(text).map(|alpha| c.roughness = Some(alpha))))
        .common().of(Choice::Roughness).panel(Panel::Own),
    material("anisotropy", "X",
        "Make the material rougher along one direction with strength X, 0 to 1. Alpha along this direction becomes alpha + (1 \
         - alpha) X^2. The direction is +x on the plane and follows the circles around the poles on the sphere",
        Text(|c, text| share(text).map(|strength| c.material.anisotropy = Some(strength)))),
    material("anisotropy-rotation", "DEGREES", "Rotate the direction of --anisotropy counter-clockwise by this angle",
        Text(|c, text| finite(text).map(|degrees| c.material.anisotropy_rotation = degrees))).default("0"),
    material("clear-coat", "WEIGHT[,ROUGHNESS]",
        "Cover the material with a clear coat of lacquer (index of refraction 1.5). WEIGHT is the covered fraction, 0 to 1. ROUGHNESS \
         is the Beckmann roughness of the coat, above 0 and at most 1 [default: 0.05]",
        Text(|c, text| clear_coat(text).map(|coat| c.material.clear_coat = Some(coat)))).default(""),
    material("clear-coat-relief", "RELIEF", "Set the relief of the clear coat",
        Text(|c, text| c.material.clear_coat_relief.choose(text)))
        .values(|| CoatRelief::Base.names()).default("base"),
    material("transmission", "WEIGHT",
        "Let this fraction of the light below the specular term pass through the surface, 0 to 1, instead of scattering it. The colour of \
         the material colours it. You see the environment, suns and lamps through the surface, but not other objects",
        Text(|c, text| share(text).map(|weight| c.material.transmission = Some(weight)))),
    material("ior", "N", "Set the refractive index of the material, 1 to 4, which also sets its reflectance",
        Text(|c, text| within(text, 1.0, 4.0).map(|ior| c.material.ior = Some(ior)))).default("1.5"),
    material("thickness", "METRES", "Set the thickness of a solid body, which bends light; 0 for a thin wall, which does not",
        Text(|c, text| not_negative(text).map(|metres| c.material.thickness = metres))).default("0"),
    material("attenuation", "RRGGBB,METRES", "Colour the body: white light has this sRGB colour after this distance above 0",
        Text(|c, text| attenuation(text).map(|body| c.material.attenuation = Some(body)))).default("no colour"),
    material("detail", "FOLDER|FILE",
        "Add a finer material, the detail, repeated over the surface: a folder as for --material, a height map, or a normal \
         map recognised by its name. Without --detail-displaces, it changes shading, not geometry",
        Path(|c, file| c.material.detail.detail = Some(file))).of(Choice::Folder),
    material("detail-repeat", "N", "Repeat the detail N times within one repeat of the material",
        Text(|c, text| positive(text).map(|times| c.material.detail.detail_repeat = times))).default("8").of(Choice::Folder),
    material("detail-rotation", "DEGREES", "Rotate the detail counter-clockwise by this angle",
        Text(|c, text| finite(text).map(|degrees| c.material.detail.detail_rotation = degrees))).default("0").of(Choice::Folder),
    material("detail-height-scale", "X", "Multiply the slopes of the detail by X",
        Text(|c, text| not_negative(text).map(|factor| c.material.detail.detail_height_scale = factor))).default("1").of(Choice::Folder),
    option(MATERIAL, "detail-displaces", "",
        "Displace the plane by the heights of the detail too. --height-scale then applies to both reliefs",
        Flag(|c| c.material.detail.detail_displaces = true)).of(Choice::Tiling),
    material("detail-mask", "FILE",
        "Show the detail only where this image is white. The image covers one repeat of the material. Without a mask, the \
         detail covers the whole surface, and its colours modulate the colours of the material",
        Path(|c, file| c.material.detail.detail_mask = Some(file))).of(Choice::Folder),
    option(MATERIAL, "heights-as-read", "",
        "Keep the steps between the codes of coarse height maps. Without this option, heights of 8, 10 or 12 bits or in whole \
         metres become the smoothest heights within half a code; edges and rough areas remain",
        Flag(|c| c.heights_as_read = true)).of(Choice::Folder),
    option(MATERIAL, "no-repeats", "",
        "Tile the maps without repetition by blending random pieces. The mean and the covariance of the slopes remain the \
         same. Use this option for ground, sand, plaster and other irregular maps",
        Flag(|c| c.tiling = Tiling::ByExample)).of(Choice::Tiling),
    material("height", "METRES", "Set the height difference in metres between black (0) and white (1) in the height map",
        Text(|c, text| not_negative(text).map(|metres| c.height = Some(metres))))
        .default("the height that fits the normals of the material; 0.12 without normals"),
    // With smaller repeats, texture coordinates on the 8 m plane would lose precision.
    material("repeat", "METRES", "Set the width of one repeat of height maps and materials, 0.01 to 1000",
        Text(|c, text| within(text, 0.01, 1000.0).map(|metres| c.repeat = Some(metres as f32))))
        .default("2 on the plane, 1.2 on the sphere"),
    sea("wind", "M/S", "Set the wind speed 10 m above the water, 1 to 40",
        Text(|c, text| within(text, 1.0, 40.0).map(|speed| c.waves.wind = speed))).default("8; 6 in the scene shore").key("waves/wind"),
    sea("wind-direction", "DEGREES", "Set the direction in which the wind blows, in degrees counter-clockwise from +x",
        Text(|c, text| within(text, -360.0, 360.0).map(|degrees| c.waves.wind_direction = degrees)))
        .default("34.4; -20 in the scene shore").key("waves/wind_direction"),
    sea("fetch", "METRES", "Set the distance over which the wind has blown, 1000 to 5000000",
        Text(|c, text| within(text, 1e3, 5e6).map(|metres| c.waves.fetch = metres))).default("120000; 40000 in the scene shore").key("waves/fetch"),
    sea("depth", "METRES", "Set the depth of the water, 1 to 11000",
        Text(|c, text| within(text, 1.0, 11e3).map(|metres| c.waves.depth = metres))).default("200").key("waves/depth"),
    sea("choppiness", "X", "Set the sideways motion of the waves, which sharpens their crests: 0 for none, 1 for real water",
        Text(|c, text| within(text, 0.0, 1.0).map(|factor| c.waves.choppiness = factor))).default("1").key("waves/choppiness"),
    sea("fft", "N", "Set the number of samples along an edge of each wave tile: 64, 128, 256 or 512",
        Text(|c, text| power_of_two(text, 64, 512).map(|samples| c.waves.fft = samples))).default("256").key("waves/fft"),
    option(GEOMETRY, "height-scale", "X", "Multiply the displacement by X; 0 makes the surface flat",
        Sets::Picture(Value::Number(|p| &mut p.height_scale, not_negative, slider([0.0, 3.0], 2, "")))).called("bump height").of(Choice::Relief),
    option(GEOMETRY, "height-scale-map", "FILE",
        "Multiply the displacement by this grey image, from 0 (black) to 1 (white), over the texture coordinates of the surface. \
         The image should change slowly compared with the relief",
        Path(|c, file| c.height_scale_map = Some(file))).of(Choice::Folder),
    option(GEOMETRY, "height-scale-span", "N", "Spread the map of --height-scale-map over N repeats of the material",
        Text(|c, text| positive(text).map(|repeats| c.height_scale_span = repeats))).default("1").of(Choice::Folder),
    option(GEOMETRY, "skin-relief", "RELIEF", "Set how the height of the T-rex's skin varies",
        Text(|c, text| c.skin_relief.choose(text)))
        .values(|| SkinRelief::Even.names()).default("even").of(Choice::Skin),
    option(GEOMETRY, "stretch", "X",
        "Stretch the objects along x by the factor X, 0.2 to 5, and flatten them along z by the same factor. Texture \
         coordinates do not change",
        Sets::Picture(Value::Number(|p| &mut p.stretch, factor, slider([*FACTORS.start(), *FACTORS.end()], 2, "")))).called("stretch").of(Choice::Stretch),
    option(GEOMETRY, "smooth-geometry", "",
        "Do not displace the geometry. The slopes of the height map still affect the shading",
        Sets::Picture(Value::Flag(|p| &mut p.displacement, false))).called("flat geometry").formerly("no-displacement").key("displacement").of(Choice::Relief),
    option(GEOMETRY, "triangle-pixels", "PIXELS", "Set the triangle size of displaced surfaces on the screen, in pixels",
        Sets::Picture(Value::Number(|p| &mut p.triangle_pixels, positive, slider([1.0, 32.0], 1, " px")))).called("triangle size").of(Choice::Objects),
    option(GEOMETRY, "atlas-tile", "N",
        "Set the number of texels along an edge of each patch tile in the displacement atlas: 8, 16, 32, 64 or 128",
        Text(|c, text| power_of_two(text, 8, 128).map(|texels| c.atlas_tile = texels))).default("64").of(Choice::AtlasTile),
    option(GEOMETRY, "map-precision", "PRECISION", "Store the slopes of the maps in GPU memory in this number format",
        Text(|c, text| {
            let formats = [MomentFormat::Float32, MomentFormat::Float16];
            let format = formats.into_iter().find(|format| format.name() == text);
            format.map(|format| c.map_precision = format).ok_or("use f32 or f16".into())
        })).default("f32").of(Choice::Objects)
        .values(|| vec![("f32", "32-bit floats"), ("f16", "16-bit floats: half the memory, less precise")]),
    option(LIGHT, "environment", "sky|studio|FILE.hdr|FILE.exr",
        "Light the scene with the analytic sky, a studio, or an equirectangular image. Cube crosses, cube strips and square light probes \
         are converted",
        Text(|c, text| text.parse().map(|choice| c.environment = choice))).common().default("sky").panel(Panel::Own),
    option(LIGHT, "environment-layer", "NAME", "Light the scene with this layer of an EXR environment",
        Text(|c, name| {
            c.environment_layer = Some(name.into());
            Ok(())
        })).default("the unnamed layer, or one named Combined, beauty or rgba, or the only layer with colour").under(Under::Panorama),
    option(LIGHT, "environment-rotation", "DEGREES",
        "Rotate the environment image by this angle, counter-clockwise when seen from above",
        Text(|c, text| finite(text).map(|degrees| c.environment_rotation = degrees))).default("0").under(Under::Panorama),
    option(LIGHT, "environment-lights", "N",
        "Convert up to N bright spots of the environment image, 0 to 4, into lights that cast shadows",
        Text(|c, text| whole(text, 0, MAX_ENVIRONMENT_LIGHTS).map(|most| c.environment_lights.count = most))).default("4").under(Under::Panorama),
    option(LIGHT, "environment-light-threshold", "X",
        "Set the minimum radiance of a bright spot in the environment image to X times the mean radiance of the image",
        Text(|c, text| positive(text).map(|factor| c.environment_lights.threshold = factor))).default("8").under(Under::Panorama),
    option(LIGHT, "sun", "AZIMUTH,ELEVATION",
        "Set the direction to the sun in degrees: AZIMUTH counter-clockwise from +x, ELEVATION above the horizon",
        Text(|c, text| text.parse().map(|sun| c.sun = Some(sun)))).common().default("-50,38, or the sun of a model").under(Under::Sky).panel(Panel::Own),
    option(LIGHT, "time-of-day", "HOURS",
        "Start the scene at this hour of the day, which sets the sun instead of --sun. The sun rises in the east (+x) at 5:30 \
         and sets at 18:30",
        Text(|c, text| within(text, 0.0, 24.0).map(|hour| c.time_of_day = Some(hour as f32)))).common().under(Under::Sky).panel(Panel::Own),
    option(LIGHT, "day-length", "SECONDS", "Move the sun through a whole day in this number of seconds",
        Text(|c, text| positive(text).map(|seconds| c.day_length = Some(seconds))))
        .default("the sun does not move").under(Under::Sky).panel(Panel::Own),
    option(LIGHT, "light", "X,Y,Z,COLOUR,POWER",
        "Add a point light at this position in metres. COLOUR is an sRGB code of six hexadecimal digits, such as ffb46b, or a \
         colour temperature, such as 2700K. POWER is in candela: at D metres, the light gives POWER / D^2 lux, and a white \
         surface under 3.14 lux is as bright as the white of the picture. You can repeat this option",
        Text(|c, text| {
            if c.point_lights.len() >= MAX_LAMPS {
                return Err(format!("more than {MAX_LAMPS} lights: leave some out"));
            }
            text.parse().map(|light| c.point_lights.push(light))
        })).common().key("point_lights").repeats(),
    option(LIGHT, "exposure", "EV",
        "Brighten a PNG or the window by this many stops, in addition to the exposure for the height of the sun. EXR files \
         store linear radiance without exposure",
        Sets::Picture(Value::Number(|p| &mut p.exposure, finite, slider([-4.0, 4.0], 1, " EV")))).called("brightness").common(),
    option(LIGHT, "auto-exposure", "",
        "Set the exposure from the environment image: level ground becomes as bright as under the analytic sky at \
         mid-morning. --exposure is added to this exposure",
        Flag(|c| c.auto_exposure = true)).under(Under::Panorama),
    option(LIGHT, "tonemap", "NAME", "Convert radiance to display values in a PNG or the window with this tone curve",
        Sets::Picture(Value::Name(|p| &mut p.tonemap))).called("tone curve"),
    option(LIGHT, "no-dither", "",
        "Round the codes of a PNG, an animation or the window to the nearest instead of dithering them by up to half a code. \
         Dithering removes bands from smooth skies",
        Sets::Picture(Value::Flag(|p| &mut p.dither, false))).key("dither").called("dithering"),
    option(CAMERA, "camera", "near|mid|far|model|model:NAME|FILE.json|X,Y,Z:X,Y,Z[:DEGREES]",
        "Set the camera to a view of the scene (near, mid or far), a camera in the file of a model (the first, or the one \
         with this name or number), a JSON file {position, target, up, fov_degrees}, or a position and a target with a \
         vertical field of view",
        Text(see)).common().default("mid").key("view").panel(Panel::Own),
    option(CAMERA, "distance", "METRES", "Move the camera along its line of sight to this distance from its target",
        Text(|c, text| positive(text).map(|metres| c.distance = Some(metres)))).common().panel(Panel::Own),
    option(SHADING, "technique", "NAME", "Filter and shade surfaces with this technique",
        Sets::Picture(Value::Name(|p| &mut p.technique))).common().panel(Panel::Own),
    option(QUALITY, "size", "WxH", "Set the size of the picture in pixels",
        Text(|c, text| text.parse().map(|size| c.size = size)))
        .common().default("1280x720").panel(Panel::Without("the window sets the size of the picture")),
    option(QUALITY, "samples", "N", "Draw N samples per pixel. The window draws one sample while anything moves",
        Sets::Picture(Value::Count(|p| &mut p.samples, [1, 65_536], slider([1.0, 64.0], 0, "")))).called("samples").common(),
    option(QUALITY, "msaa", "N",
        "Use multisampling with 1, 2, 4 or 8 geometry samples in each of the --samples, for smooth silhouettes at little \
         cost. Each surface in a pixel is shaded once per sample",
        Text(|c, text| power_of_two(text, 1, MOST_MULTISAMPLES).map(|samples| c.msaa = samples)))
        .common().default("4 with --samples 1; 4 for moving scenes in the window, unless a frame takes more than 100 ms; else 1")
        .panel(Panel::Without("the window sets the multisampling of moving scenes by its frame time")),
    option(QUALITY, "seed", "N", "Set the seed of the sample positions",
        Text(|c, text| whole(text, 0, u64::MAX).map(|seed| c.seed = seed))).default("0").panel(Panel::Without("it only changes the noise")),
];

impl SceneOption {
    /// Returns all options in the order of the help.
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

    /// Finds an option by its name.
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::all().iter().find(|option| option.spec.name == name)
    }

    /// Parses a value and stores it in a configuration. Refuses invalid text.
    pub fn set(&self, config: &mut SceneConfig, value: &OsStr) -> Result<(), String> {
        let text = || value.to_str().ok_or_else(|| "the value is not UTF-8".to_owned());
        match &self.sets {
            Flag(set) => set(config),
            Path(set) => set(config, value.into()),
            Text(set) => set(config, text()?)?,
            Sets::Picture(field) => field.read(&mut config.picture, text()?)?,
            Sets::Shading(row) => row.value.read(&mut config.picture.options, text()?)?,
        }
        Ok(())
    }

    /// Formats the value of a picture setting as text. The text is empty for a flag without a value.
    pub fn write(&self, picture: &Picture) -> Option<String> {
        match &self.sets {
            Sets::Picture(field) => field.write(*picture),
            Sets::Shading(row) => row.value.write(picture.options),
            _ => None,
        }
    }

    /// Returns the value of a picture setting as JSON.
    pub fn json(&self, picture: &Picture) -> Option<Json> {
        match &self.sets {
            Sets::Picture(field) => field.json(*picture),
            Sets::Shading(row) => row.json(picture.technique, picture.options),
            _ => None,
        }
    }

    /// Returns the names and descriptions of the values, for options with few values.
    pub fn names(&self) -> Vec<(&'static str, &'static str)> {
        match &self.sets {
            Sets::Picture(field) => field.names(Picture::default()),
            Sets::Shading(row) => row.value.names(ShadingOptions::default()),
            _ => (self.names)(),
        }
    }

    /// Whether the option takes a value.
    pub fn takes_value(&self) -> bool {
        !self.spec.value_name.is_empty()
    }

    /// Whether the option describes the surface of one scene. Such an option is dropped when the scene changes.
    pub fn is_of_one_scene(&self) -> bool {
        matches!(self.spec.heading, SCENE | MATERIAL | SEA)
    }

    /// Whether a scene and a technique support the option.
    pub fn applies_to(&self, scene: &NamedScene, technique: Technique) -> bool {
        let of_technique = if let Sets::Shading(row) = self.sets { row.applies_to(technique) } else { true };
        of_technique && self.choice.is_none_or(|choice| scene.offers(choice))
    }

    /// Returns the help text, including the default and the scenes and techniques that support the option.
    pub fn help(&self) -> String {
        let mut help = self.spec.help.to_owned();
        if let Some(choice) = self.choice.filter(|choice| !matches!(choice, Choice::Model | Choice::Folder)) {
            let (with, without): (Vec<_>, Vec<_>) = SCENES.iter().partition(|scene| scene.offers(choice));
            let few = with.len() <= without.len();
            let names = if few { with } else { without }.into_iter().map(|scene| scene.name);
            // Models are on the list if they are like the scenes on it.
            let names: Vec<_> = names.chain((MODEL.offers(choice) == few).then_some("models")).collect();
            help += &format!(" ({}{})", if few { "" } else { "not for " }, names.join(", "));
        }
        if let Sets::Shading(ShadingOption { techniques, .. }) = self.sets
            && Technique::ALL.into_iter().filter(|&technique| (techniques.has)(technique)).count() <= MOST_LISTED
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

/// The largest number of techniques that a help text lists.
const MOST_LISTED: usize = 4;

/// Parses a scale factor for widths.
fn factor(text: &str) -> Result<f32, String> {
    within(text, *FACTORS.start(), *FACTORS.end())
}

/// Selects the scene of this name, or a model, with the scene's default sea.
fn enter(config: &mut SceneConfig, name: &str) -> Result<(), String> {
    let file = PathBuf::from(name);
    let extension = file.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    if matches!(extension.as_deref(), Some("glb" | "gltf")) {
        (config.scene, config.model) = (&MODEL, Some(file));
    } else {
        let names = || SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
        let similar = || similar(name, SCENES.iter().map(|scene| scene.name));
        let unknown = || format!("no such scene{}; use {}, or a .glb or .gltf file", similar(), names());
        (config.scene, config.model) = (NamedScene::find(name).ok_or_else(unknown)?, None);
    }
    config.waves = config.scene.waves();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_names_models_and_true_defaults() {
        let help = |name: &str| SceneOption::find(name).unwrap().help();
        assert!(help("bare").ends_with("(plane, sphere, models)"), "{}", help("bare"));
        assert!(help("roughness").ends_with("(not for ocean, models)"), "{}", help("roughness"));
        assert!(help("height-scale").ends_with("(not for ocean) [default: 1]"), "{}", help("height-scale"));
        let default = help("wind-direction");
        let degrees = default.split("[default: ").nth(1).and_then(|text| text.split(';').next()).unwrap();
        let own = NamedScene::find("ocean").unwrap().waves().wind_direction;
        assert!((degrees.parse::<f64>().unwrap() - own).abs() < 0.05, "{default}: {own}");
    }
}
