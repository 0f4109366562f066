//! Arguments of `leadr bake`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::app::flags::values::positive;
use crate::maps::Wrap;
use crate::maps::bake::{Kind, Layout};
use crate::maps::material::GreenAxis;

/// Shown below the help.
pub const EXAMPLES: &str = "Examples:
  leadr bake bricks.png -o bricks.ktx2                       heights of 0 to 1, in their own unit
  leadr bake bricks.png --height-scale 0.05 -o bricks.ktx2   1 in the map is a twentieth of its width
  leadr bake bricks.png --normal bricks_n.png -o bricks.ktx2 heights displace, normals keep the fine slopes
  leadr bake --normal bricks_n.png --kind toksvig -o bricks.ktx2
  leadr bake Rock003 --format f16 --json -o rock.ktx2        a material as downloaded, with roughness and colour
  leadr bake bricks.png --format bc -o bricks.ktx2           block-compressed; leadr capture --scene plane --height-map draws it
  leadr bake bricks.png --layout oiio -o bricks.exr          six channels, as maketx --bumpslopes writes them

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
    /// One minus a perceptual roughness
    #[arg(long, value_name = "FILE")]
    pub gloss: Option<PathBuf>,
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
    /// How slopes are kept
    #[arg(long, value_enum, value_name = "KIND", default_value_t = KindChoice::Leadr)]
    pub kind: KindChoice,
    /// Numbers of the file
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = Format::F32)]
    pub format: Format,
    /// Channels of the file: this program's, or those of OpenImageIO's bump slopes (.exr)
    #[arg(long, value_enum, value_name = "LAYOUT", default_value_t = LayoutChoice::Leadr)]
    pub layout: LayoutChoice,
    /// The file to write
    #[arg(long, short, value_name = "OUT.ktx2|OUT.exr")]
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

/// How slopes are kept.
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
}

impl From<KindChoice> for Kind {
    fn from(choice: KindChoice) -> Self {
        match choice {
            KindChoice::Leadr => Self::Leadr,
            KindChoice::Lean => Self::Lean,
            KindChoice::Clean => Self::Clean,
            KindChoice::Toksvig => Self::Toksvig,
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
