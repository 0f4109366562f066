//! Arguments of `leadr bake`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;

use leadr_maps::Wrap;
use leadr_maps::bake::{Kind, Layout, Texels};
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
    #[arg(long, value_enum, value_name = "SCALE", default_value_t = GlossScale::Perceptual)]
    pub gloss_scale: GlossScale,
    /// Colour, filtered as linear light
    #[arg(long, value_name = "FILE")]
    pub color: Option<PathBuf>,
    /// Factor on heights; with normals, widths of the texture for a unit of height [default: 1; with normals what agrees best with them]
    #[arg(long, value_name = "X", value_parser = positive)]
    pub height_scale: Option<f32>,
    /// Which way the green of the normals goes [default: as the file's name says, or as the slopes fit together best]
    #[arg(long, value_enum, value_name = "WAY")]
    pub normal_y: Option<NormalY>,
    /// What lies beyond the edges of the heights
    #[arg(long, value_enum, value_name = "HOW", default_value_t = WrapChoice::Repeat)]
    pub wrap: WrapChoice,
    /// What is baked; of several kinds, a file for each in the folder -o
    #[arg(long, value_enum, value_name = "KIND,...", value_delimiter = ',', default_values_t = [KindChoice::Leadr])]
    pub kind: Vec<KindChoice>,
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
    #[arg(long, value_enum, value_name = "HOW", requires = "detail", default_value_t = BlendChoice::Rnm)]
    pub blend: BlendChoice,
    /// Kind gloss: which areas normals stand for
    #[arg(long, value_enum, value_name = "MODEL", default_value_t = AreaChoice::Macrosurface)]
    pub area: AreaChoice,
    /// Kind gloss: what a texel of the finest level is
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = TexelsChoice::Facets)]
    pub texels: TexelsChoice,
    /// Heights that are found of normals: 0 follows them exactly, up to 1 keeps neighbours together [default: 0.1]
    #[arg(long, value_name = "X", value_parser = share)]
    pub smoothness: Option<f32>,
    /// Resample pictures whose size is not that of the first, in place of refusing them
    #[arg(long)]
    pub resample: bool,
    /// Numbers of the file
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = Format::F32)]
    pub format: Format,
    /// Channels of the file: this program's, or those of OpenImageIO's bump slopes (.exr)
    #[arg(long, value_enum, value_name = "LAYOUT", default_value_t = LayoutChoice::Leadr)]
    pub layout: LayoutChoice,
    /// The file to write
    #[arg(long, short, value_name = "OUT.ktx2|OUT.exr|OUT.png|FOLDER")]
    pub output: PathBuf,
}

/// Which way green goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NormalY {
    /// Up (OpenGL, glTF)
    Up,
    /// Down (DirectX)
    Down,
}

impl From<NormalY> for GreenAxis {
    fn from(way: NormalY) -> Self {
        match way {
            NormalY::Up => Self::Up,
            NormalY::Down => Self::Down,
        }
    }
}

/// What lies beyond the edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WrapChoice {
    /// The map repeats
    Repeat,
    /// The edge goes on
    Clamp,
}

impl From<WrapChoice> for Wrap {
    fn from(choice: WrapChoice) -> Self {
        match choice {
            WrapChoice::Repeat => Self::Repeat,
            WrapChoice::Clamp => Self::Clamp,
        }
    }
}

/// What gloss is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GlossScale {
    /// One minus the root of α (glTF and most libraries)
    Perceptual,
    /// α² = 2 / (1 + 2^18g) (Call of Duty: WWII)
    Wwii,
    /// α² = 2 / (2 + 2^16g) (Call of Duty: Advanced Warfare)
    AdvancedWarfare,
}

impl From<GlossScale> for Gloss {
    fn from(scale: GlossScale) -> Self {
        match scale {
            GlossScale::Perceptual => Self::Perceptual,
            GlossScale::Wwii => Self::Wwii,
            GlossScale::AdvancedWarfare => Self::AdvancedWarfare,
        }
    }
}

/// How a detail is put over normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BlendChoice {
    /// Turned into the frame of the normal below (reoriented normal mapping)
    Rnm,
    /// Slopes are added (partial derivatives)
    Slopes,
    /// x and y are added, z multiplied (whiteout)
    Whiteout,
    /// x and y are added, z is that of the normal below (UDN)
    Udn,
    /// x and y are added, z follows (Call of Duty: WWII)
    Xy,
}

impl BlendChoice {
    /// What makes one normal of two, the one below first.
    pub const fn function(self) -> fn(DVec3, DVec3) -> DVec3 {
        match self {
            Self::Rnm => blend_reoriented,
            Self::Slopes => blend_partial_derivatives,
            Self::Whiteout => blend_whiteout,
            Self::Udn => blend_udn,
            Self::Xy => blend_xy,
        }
    }
}

/// Which areas normals stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AreaChoice {
    /// Texels weigh alike, as where hardware filters
    Macrosurface,
    /// Steep texels weigh more: by the area of their facets
    Microsurface,
}

impl From<AreaChoice> for NormalArea {
    fn from(choice: AreaChoice) -> Self {
        match choice {
            AreaChoice::Macrosurface => Self::Macro,
            AreaChoice::Microsurface => Self::Micro,
        }
    }
}

/// What a texel of the finest level is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TexelsChoice {
    /// A plane: the finest level stays as it was painted
    Facets,
    /// A sample of a smooth surface, whose turn within the texel is roughness
    Smooth,
}

impl From<TexelsChoice> for Texels {
    fn from(choice: TexelsChoice) -> Self {
        match choice {
            TexelsChoice::Facets => Self::Facets,
            TexelsChoice::Smooth => Self::Smooth,
        }
    }
}

/// What is baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KindChoice {
    /// Means, second moments and mixed moment of slopes in texture space, and mean height
    Leadr,
    /// The same of normals, in the tangent frame
    Lean,
    /// Mean slope and one second moment
    Clean,
    /// Mean normal, shorter where normals differ
    Toksvig,
    /// Normals; levels hold mean directions
    Normal,
    /// Normals and gloss, which takes up on each level what the normals differ (shortened normals)
    Gloss,
    /// Heights, found from the normals where there are none
    Height,
    /// The share of the surroundings that is seen past the relief
    Occlusion,
    /// The same as a cone about the mean direction that is open
    Cones,
}

impl From<KindChoice> for Kind {
    fn from(choice: KindChoice) -> Self {
        match choice {
            KindChoice::Leadr => Self::Leadr,
            KindChoice::Lean => Self::Lean,
            KindChoice::Clean => Self::Clean,
            KindChoice::Toksvig => Self::Toksvig,
            KindChoice::Normal => Self::Normal,
            KindChoice::Gloss => Self::Gloss,
            KindChoice::Height => Self::Height,
            KindChoice::Occlusion => Self::Occlusion,
            KindChoice::Cones => Self::Cones,
        }
    }
}

/// Numbers of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// 32-bit floats
    F32,
    /// 16-bit floats, scaled to fill their range
    F16,
    /// Block compression (BC5, KTX2 only): a third of the size of f16; deviations and correlation in place of second moments
    Bc,
}

/// Channels of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayoutChoice {
    /// Those of the kind
    Leadr,
    /// b0_h, b1_dhds, b2_dhdt, b3_dhds2, b4_dhdt2, b5_dh2dsdt
    Oiio,
}

impl From<LayoutChoice> for Layout {
    fn from(choice: LayoutChoice) -> Self {
        match choice {
            LayoutChoice::Leadr => Self::Leadr,
            LayoutChoice::Oiio => Self::Oiio,
        }
    }
}
