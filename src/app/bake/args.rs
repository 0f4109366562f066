//! Arguments of `leadr bake`.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;

use crate::app::flags::scene::{Names, one_of};
use leadr_maps::Wrap;
use leadr_maps::bake::{Kind, Layout, Precision, Texels};
use leadr_maps::material::GreenAxis;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::NormalArea;
use leadr_reflectance::masking::classes::MOST_CLASSES;
use leadr_reflectance::slopes::normal_blending::{
    blend_partial_derivatives, blend_reoriented, blend_udn, blend_whiteout, blend_xy,
};
use leadr_render::settings::numbers::{positive, share, whole};

/// Examples and units that are printed below the help.
pub const EXAMPLES: &str = "Examples:
  leadr bake bricks.png -o bricks.ktx2                       use heights from 0 to 1, in the unit of the map
  leadr bake bricks.png --height-scale 0.05 -o bricks.ktx2   set the height of the value 1 to 5 % of the map's width
  leadr bake bricks.png --normal bricks_n.png -o bricks.ktx2 use heights for displacement and normals for slopes
  leadr bake --normal bricks_n.png --kind toksvig -o bricks.ktx2
  leadr bake Rock003 --format f16 --json -o rock.ktx2        bake a downloaded material with its roughness and colour
  leadr bake bricks.png --format bc -o bricks.ktx2           compress blocks, for leadr capture --scene plane --height-map
  leadr bake bricks.png --classes auto --format f16 -o bricks.ktx2   keep tops, walls and bottoms apart
  leadr bake bricks.png --drop-levels 2 -o bricks.ktx2       begin with level 2, for bricks at a distance: a 16th of the bytes
  leadr bake bricks.png --layout oiio -o bricks.exr          write the six channels of maketx --bumpslopes
  leadr bake --normal bricks_n.png --gloss bricks_g.png --kind gloss -o bricks.ktx2   add the spread of the normals to the gloss
  leadr bake bricks_n.png --kind height -o bricks_h.png      compute heights from normals
  leadr bake Rock003 --kind height,gloss,occlusion,cones -o rock/   write a folder of maps
  leadr bake bricks.glb -o bricks-filtered.glb               give the textures of a model mip levels with the roughness of lost normals
  leadr bake Rock003 --for unreal -o rock/                   write its textures for Unreal, with the roughness of lost normals
  leadr bake --cone-table --gloss-scale wwii -o cones.exr    write the table of specular reflectance under cones

Slopes are per unit of texture coordinate, with t pointing down. The unit of the output heights is that of the height map times
--height-scale, or the width of the texture if there is a normal map.";

/// Arguments of `leadr bake`.
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// A height map (PNG, TIFF, EXR or another image format), a normal map recognised by its name, a material folder, or a glTF model
    #[arg(value_name = "FILE|FOLDER", required_unless_present_any = ["normal", "cone_table"])]
    pub input: Option<PathBuf>,
    /// Read pictures of the folder through links that lead out of it. Use this option only for folders that you trust
    #[arg(long)]
    pub follow_links: bool,
    /// Bake the slopes of this normal map instead of the slopes of the heights
    #[arg(long, value_name = "FILE")]
    pub normal: Option<PathBuf>,
    /// Filter this map of perceptual roughness as a variance, together with the slopes
    #[arg(long, value_name = "FILE", conflicts_with = "gloss")]
    pub roughness: Option<PathBuf>,
    /// Filter this gloss map instead of a roughness map; --gloss-scale sets the scale of its values
    #[arg(long, value_name = "FILE")]
    pub gloss: Option<PathBuf>,
    /// Set the gloss scale of the --gloss map and of output maps of kind gloss
    #[arg(long, value_name = "SCALE", value_parser = one_of(GLOSS_SCALES), default_value = "perceptual")]
    pub gloss_scale: Gloss,
    /// Filter this colour map in linear light
    #[arg(long, value_name = "FILE")]
    pub color: Option<PathBuf>,
    /// Multiply heights by X; with a normal map, X is in texture widths per unit of height [default: 1; with a normal map, the best fit]
    #[arg(long, value_name = "X", value_parser = positive)]
    pub height_scale: Option<f32>,
    /// Keep the steps between the codes of a coarse height map, instead of smoothing the heights within half a code
    #[arg(long)]
    pub heights_as_read: bool,
    /// Set the direction of the green channel of normal maps [default: given by the file name, else detected from the slopes]
    #[arg(long, value_name = "WAY", value_parser = one_of(NORMAL_Y))]
    pub normal_y: Option<GreenAxis>,
    /// Set how the map continues beyond its edges
    #[arg(long, value_name = "HOW", value_parser = one_of(WRAPS), default_value = "repeat")]
    pub wrap: Wrap,
    /// Bake these kinds of map; several kinds are written to the folder -o, one file per kind
    #[arg(long, value_name = "KIND,...", value_parser = one_of(KINDS), value_delimiter = ',', default_value = "leadr")]
    pub kind: Vec<Kind>,
    /// Blend this detail normal map over the base normals (kinds normal and gloss)
    #[arg(long, value_name = "FILE")]
    pub detail: Option<PathBuf>,
    /// Use this gloss map for the detail, on the scale of --gloss-scale
    #[arg(long, value_name = "FILE", requires = "detail")]
    pub detail_gloss: Option<PathBuf>,
    /// Repeat the detail N times across the map
    #[arg(long, value_name = "N", requires = "detail", default_value_t = 1, value_parser = |text: &str| whole(text, 1_u32, 4096))]
    pub detail_repeat: u32,
    /// Set how the detail normals are blended over the base normals
    #[arg(long, value_name = "HOW", requires = "detail", value_parser = one_of(BLENDS), default_value = "rnm")]
    pub blend: Blend,
    /// Set the weights of the normals in a filter footprint (kind gloss)
    #[arg(long, value_name = "MODEL", value_parser = one_of(AREAS), default_value = "macrosurface")]
    pub area: NormalArea,
    /// Set what one texel of the finest level represents (kind gloss)
    #[arg(long, value_name = "WHAT", value_parser = one_of(TEXELS), default_value = "facets")]
    pub texels: Texels,
    /// Smooth the heights computed from normals: 0 follows the normals exactly, 1 is the smoothest [default: 0.1]
    #[arg(long, value_name = "X", value_parser = share)]
    pub smoothness: Option<f32>,
    /// Count only occluders up to X texture widths from a texel (kinds occlusion and cones) [default: all occluders]
    #[arg(long, value_name = "X", value_parser = positive)]
    pub occlusion_distance: Option<f32>,
    /// Store moments for N classes of facets, such as the tops, walls and bottoms of bricks (kind leadr); auto chooses N by the gain
    #[arg(long, value_name = "N|auto", value_parser = class_count, default_value = "1")]
    pub classes: ClassCount,
    /// Leave the N finest levels out of the file, which is then about 4^N times smaller; the other levels keep the slopes of all
    #[arg(long, value_name = "N", value_parser = |text: &str| whole(text, 0_u32, u32::MAX), default_value = "0")]
    pub drop_levels: u32,
    /// Resample images of different sizes to the size of the first image, instead of refusing them
    #[arg(long)]
    pub resample: bool,
    /// Set the number format of the file
    #[arg(long, value_name = "FORMAT", value_parser = one_of(FORMATS), default_value = "f32")]
    pub format: Precision,
    /// Set the channels of the file: the channels of leadr, or the bump slopes of OpenImageIO (.exr)
    #[arg(long, value_name = "LAYOUT", value_parser = one_of(LAYOUTS), default_value = "leadr")]
    pub layout: Layout,
    /// Write textures for an engine: of a model [default: gltf], or of a material, to a folder
    #[arg(long = "for", value_name = "ENGINE", value_parser = one_of(ENGINES))]
    pub engine: Option<TargetEngine>,
    /// Write the table of specular reflectance under occlusion cones (32 viewer's cosines x 32 glosses on --gloss-scale x 8 cones) as an .exr, without an input
    #[arg(long, conflicts_with_all = WITHOUT_CONE_TABLE)]
    pub cone_table: bool,
    /// Write the map (.ktx2, .exr or .png) or the model (.glb or .gltf) to this file, or several maps to this folder
    #[arg(long, short, value_name = "FILE|FOLDER")]
    pub output: PathBuf,
}

/// The flags that do not apply to --cone-table.
const WITHOUT_CONE_TABLE: [&str; 21] = [
    "input",
    "follow_links",
    "normal",
    "roughness",
    "gloss",
    "color",
    "height_scale",
    "heights_as_read",
    "normal_y",
    "wrap",
    "kind",
    "detail",
    "area",
    "texels",
    "smoothness",
    "occlusion_distance",
    "classes",
    "drop_levels",
    "resample",
    "layout",
    "engine",
];

/// The number of classes of facets that a map stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClassCount {
    Auto,
    Exactly(usize),
}

fn class_count(text: &str) -> Result<ClassCount, String> {
    if text == "auto" {
        return Ok(ClassCount::Auto);
    }
    let count = whole(text, 1_usize, MOST_CLASSES).map_err(|error| format!("{error}, or auto"))?;
    Ok(ClassCount::Exactly(count))
}

/// An engine that reads models or textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TargetEngine {
    #[default]
    Gltf,
    Bevy,
    Godot,
    Unity,
    Unreal,
}

const ENGINES: Names<TargetEngine> = &[
    (
        "gltf",
        TargetEngine::Gltf,
        "three.js, Babylon.js, Filament, Unity with glTFast, and others with KHR_texture_basisu",
    ),
    ("bevy", TargetEngine::Bevy, "Bevy, which reads BC7 textures but not KHR_texture_basisu"),
    (
        "godot",
        TargetEngine::Godot,
        "Godot: models as .gltf, whose colours stay as they are, because Godot darkens colours in KTX2; materials as DDS",
    ),
    ("unity", TargetEngine::Unity, "Unity: materials as DDS with the channels of its mask map; for models use gltf"),
    ("unreal", TargetEngine::Unreal, "Unreal Engine: materials as DDS with normals whose green points down; no models"),
];

const NORMAL_Y: Names<GreenAxis> =
    &[("up", GreenAxis::Up, "Up (OpenGL, glTF)"), ("down", GreenAxis::Down, "Down (DirectX)")];

const WRAPS: Names<Wrap> = &[("repeat", Wrap::Repeat, "Repeat the map"), ("clamp", Wrap::Clamp, "Extend the edge")];

const GLOSS_SCALES: Names<Gloss> = &[
    ("perceptual", Gloss::Perceptual, "1 − √α (glTF and most libraries)"),
    ("wwii", Gloss::Wwii, "α² = 2 / (1 + 2^18g) (Call of Duty: WWII)"),
    ("advanced-warfare", Gloss::AdvancedWarfare, "α² = 2 / (2 + 2^16g) (Call of Duty: Advanced Warfare)"),
];

/// A function that blends two unit normals into one. The base normal is the first argument.
pub type Blend = fn(DVec3, DVec3) -> DVec3;

const BLENDS: Names<Blend> = &[
    ("rnm", blend_reoriented, "Rotate into the frame of the base normal (reoriented normal mapping)"),
    ("slopes", blend_partial_derivatives, "Add slopes (partial derivatives)"),
    ("whiteout", blend_whiteout, "Add x and y, multiply z (whiteout)"),
    ("udn", blend_udn, "Add x and y, keep the z of the base normal (UDN)"),
    ("xy", blend_xy, "Add x and y, compute z from them (Call of Duty: WWII)"),
];

const AREAS: Names<NormalArea> = &[
    ("macrosurface", NormalArea::Macro, "Weight all texels equally, like hardware filtering"),
    ("microsurface", NormalArea::Micro, "Weight texels by the area of their facets: steep texels have larger weights"),
];

const TEXELS: Names<Texels> = &[
    ("facets", Texels::Facets, "A flat facet: the finest level does not change"),
    (
        "smooth",
        Texels::Smooth,
        "A sample of a smooth surface: the change of the normal within the texel adds roughness",
    ),
];

const KINDS: Names<Kind> = &[
    ("leadr", Kind::Leadr, "Mean slopes, second moments and mixed moment in texture space, and mean height"),
    ("lean", Kind::Lean, "The same moments, computed from normals in the tangent frame"),
    ("clean", Kind::Clean, "Mean slope and one second moment"),
    (
        "clean-conservative",
        Kind::CleanConservative,
        "Mean slope, and one variance that is never too small in any direction",
    ),
    ("toksvig", Kind::Toksvig, "Mean normal, whose length decreases with the spread of the normals"),
    ("normal", Kind::Normal, "Normals; mip levels hold mean directions"),
    ("gloss", Kind::Gloss, "Normals, and gloss that includes the spread of normals at each level (shortened normals)"),
    ("height", Kind::Height, "Heights, computed from normals if there are none"),
    ("occlusion", Kind::Occlusion, "Ambient occlusion by the relief: the share of the surroundings that is visible"),
    ("cones", Kind::Cones, "Ambient occlusion as a cone about the mean unoccluded direction"),
];

const FORMATS: Names<Precision> = &[
    ("f32", Precision::F32, "32-bit floats"),
    ("f16", Precision::F16, "16-bit floats, scaled to fill their range"),
    ("bc", Precision::Bc, BLOCKS),
];
const BLOCKS: &str =
    "BC5 blocks (KTX2, kind leadr): deviations and a correlation instead of second moments, 9/16 of the size of f16";

const LAYOUTS: Names<Layout> = &[
    ("leadr", Layout::Leadr, "The channels that leadr uses for the kind of map"),
    ("oiio", Layout::Oiio, "b0_h, b1_dhds, b2_dhdt, b3_dhds2, b4_dhdt2, b5_dh2dsdt"),
];
