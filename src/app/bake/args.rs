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
use leadr_reflectance::slopes::normal_blending::{
    blend_partial_derivatives, blend_reoriented, blend_udn, blend_whiteout, blend_xy,
};
use leadr_render::settings::numbers::{positive, share, whole};

/// Shown below the help.
pub const EXAMPLES: &str = "Examples:
  leadr bake bricks.png -o bricks.ktx2                       heights of 0 to 1, in their own unit
  leadr bake bricks.png --height-scale 0.05 -o bricks.ktx2   1 in the map is a twentieth of its width
  leadr bake bricks.png --normal bricks_n.png -o bricks.ktx2 heights displace, normals keep the fine slopes
  leadr bake --normal bricks_n.png --kind toksvig -o bricks.ktx2
  leadr bake Rock003 --format f16 --json -o rock.ktx2        a material as downloaded, with roughness and colour
  leadr bake bricks.png --format bc -o bricks.ktx2           block-compressed; leadr capture --scene plane --height-map draws it
  leadr bake bricks.png --layout oiio -o bricks.exr          six channels, as maketx --bumpslopes writes them
  leadr bake --normal bricks_n.png --gloss bricks_g.png --kind gloss -o bricks.ktx2   normals and gloss that agree at every level
  leadr bake bricks_n.png --kind height -o bricks_h.png      heights of normals
  leadr bake Rock003 --kind height,gloss,occlusion,cones -o rock/   a folder of maps

Slopes are per unit of texture coordinate, t down; heights are in the map's unit times --height-scale, and with a normal map in
widths of the texture.";

/// Arguments of `leadr bake`.
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// A height map (PNG, JPEG or EXR), a normal map whose name says so, or the folder of a material
    #[arg(value_name = "FILE|FOLDER", required_unless_present = "normal")]
    pub input: Option<PathBuf>,
    /// Normals, whose slopes are baked in place of those of the heights
    #[arg(long, value_name = "FILE")]
    pub normal: Option<PathBuf>,
    /// Perceptual roughness, filtered beside the slopes as a variance
    #[arg(long, value_name = "FILE", conflicts_with = "gloss")]
    pub roughness: Option<PathBuf>,
    /// Gloss, on the scale of --gloss-scale
    #[arg(long, value_name = "FILE")]
    pub gloss: Option<PathBuf>,
    /// What gloss is, in --gloss and in maps of kind gloss
    #[arg(long, value_name = "SCALE", value_parser = one_of(GLOSS_SCALES), default_value = "perceptual")]
    pub gloss_scale: Gloss,
    /// Colour, filtered as linear light
    #[arg(long, value_name = "FILE")]
    pub color: Option<PathBuf>,
    /// Factor on heights; with normals, widths of the texture for a unit of height [default: 1; with normals what agrees best with them]
    #[arg(long, value_name = "X", value_parser = positive)]
    pub height_scale: Option<f32>,
    /// Which way the green of the normals goes [default: as the file's name says, or as the slopes fit together best]
    #[arg(long, value_name = "WAY", value_parser = one_of(NORMAL_Y))]
    pub normal_y: Option<GreenAxis>,
    /// What lies beyond the edges of the heights
    #[arg(long, value_name = "HOW", value_parser = one_of(WRAPS), default_value = "repeat")]
    pub wrap: Wrap,
    /// What is baked; of several kinds, a file for each in the folder -o
    #[arg(long, value_name = "KIND,...", value_parser = one_of(KINDS), value_delimiter = ',', default_value = "leadr")]
    pub kind: Vec<Kind>,
    /// Kinds normal and gloss: normals that lie over the others
    #[arg(long, value_name = "FILE")]
    pub detail: Option<PathBuf>,
    /// Gloss of the detail, on the scale of --gloss-scale
    #[arg(long, value_name = "FILE", requires = "detail")]
    pub detail_gloss: Option<PathBuf>,
    /// Times that the detail repeats within the map
    #[arg(long, value_name = "N", requires = "detail", default_value_t = 1, value_parser = |text: &str| whole(text, 1_u32, 4096))]
    pub detail_repeat: u32,
    /// How the detail's normals are put over the others
    #[arg(long, value_name = "HOW", requires = "detail", value_parser = one_of(BLENDS), default_value = "rnm")]
    pub blend: Blend,
    /// Kind gloss: which areas normals stand for
    #[arg(long, value_name = "MODEL", value_parser = one_of(AREAS), default_value = "macrosurface")]
    pub area: NormalArea,
    /// Kind gloss: what a texel of the finest level is
    #[arg(long, value_name = "WHAT", value_parser = one_of(TEXELS), default_value = "facets")]
    pub texels: Texels,
    /// Heights that are found of normals: 0 follows them exactly, up to 1 keeps neighbours together [default: 0.1]
    #[arg(long, value_name = "X", value_parser = share)]
    pub smoothness: Option<f32>,
    /// Resample pictures whose size is not that of the first, in place of refusing them
    #[arg(long)]
    pub resample: bool,
    /// Numbers of the file
    #[arg(long, value_name = "FORMAT", value_parser = one_of(FORMATS), default_value = "f32")]
    pub format: Precision,
    /// Channels of the file: this program's, or those of OpenImageIO's bump slopes (.exr)
    #[arg(long, value_name = "LAYOUT", value_parser = one_of(LAYOUTS), default_value = "leadr")]
    pub layout: Layout,
    /// The file to write
    #[arg(long, short, value_name = "OUT.ktx2|OUT.exr|OUT.png|FOLDER")]
    pub output: PathBuf,
}

const NORMAL_Y: Names<GreenAxis> =
    &[("up", GreenAxis::Up, "Up (OpenGL, glTF)"), ("down", GreenAxis::Down, "Down (DirectX)")];

const WRAPS: Names<Wrap> = &[("repeat", Wrap::Repeat, "The map repeats"), ("clamp", Wrap::Clamp, "The edge goes on")];

const GLOSS_SCALES: Names<Gloss> = &[
    ("perceptual", Gloss::Perceptual, "One minus the root of α (glTF and most libraries)"),
    ("wwii", Gloss::Wwii, "α² = 2 / (1 + 2^18g) (Call of Duty: WWII)"),
    ("advanced-warfare", Gloss::AdvancedWarfare, "α² = 2 / (2 + 2^16g) (Call of Duty: Advanced Warfare)"),
];

/// Makes one normal of two, the one below first.
pub type Blend = fn(DVec3, DVec3) -> DVec3;

const BLENDS: Names<Blend> = &[
    ("rnm", blend_reoriented, "Turned into the frame of the normal below (reoriented normal mapping)"),
    ("slopes", blend_partial_derivatives, "Slopes are added (partial derivatives)"),
    ("whiteout", blend_whiteout, "x and y are added, z multiplied (whiteout)"),
    ("udn", blend_udn, "x and y are added, z is that of the normal below (UDN)"),
    ("xy", blend_xy, "x and y are added, z follows (Call of Duty: WWII)"),
];

const AREAS: Names<NormalArea> = &[
    ("macrosurface", NormalArea::Macro, "Texels weigh alike, as where hardware filters"),
    ("microsurface", NormalArea::Micro, "Steep texels weigh more: by the area of their facets"),
];

const TEXELS: Names<Texels> = &[
    ("facets", Texels::Facets, "A plane: the finest level stays as it was painted"),
    ("smooth", Texels::Smooth, "A sample of a smooth surface, whose turn within the texel is roughness"),
];

const KINDS: Names<Kind> = &[
    ("leadr", Kind::Leadr, "Means, second moments and mixed moment of slopes in texture space, and mean height"),
    ("lean", Kind::Lean, "The same of normals, in the tangent frame"),
    ("clean", Kind::Clean, "Mean slope and one second moment"),
    ("toksvig", Kind::Toksvig, "Mean normal, shorter where normals differ"),
    ("normal", Kind::Normal, "Normals; levels hold mean directions"),
    (
        "gloss",
        Kind::Gloss,
        "Normals and gloss, which takes up on each level what the normals differ (shortened normals)",
    ),
    ("height", Kind::Height, "Heights, found from the normals where there are none"),
    ("occlusion", Kind::Occlusion, "The share of the surroundings that is seen past the relief"),
    ("cones", Kind::Cones, "The same as a cone about the mean direction that is open"),
];

const FORMATS: Names<Precision> = &[
    ("f32", Precision::F32, "32-bit floats"),
    ("f16", Precision::F16, "16-bit floats, scaled to fill their range"),
    ("bc", Precision::Bc, BLOCKS),
];
const BLOCKS: &str = "Block compression (BC5, KTX2 only): a third of the size of f16; deviations and correlation in place of second moments";

const LAYOUTS: Names<Layout> = &[
    ("leadr", Layout::Leadr, "Those of the kind"),
    ("oiio", Layout::Oiio, "b0_h, b1_dhds, b2_dhdt, b3_dhds2, b4_dhdt2, b5_dh2dsdt"),
];
