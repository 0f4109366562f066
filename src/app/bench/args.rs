//! Arguments of `leadr bench`, and what they ask for.

use std::path::PathBuf;

use clap::Args;

use crate::app::error::AppError;
use crate::app::flags::device::DeviceArgs;
use crate::app::flags::scene::{SceneArgs, scenes};
use crate::app::flags::shading::techniques;
use crate::app::flags::values::{atlas_tile, fft};
use crate::app::flags::waves::WaveArgs;
use crate::lab::bench::{BenchConfig, Quad};
use crate::render::settings::Technique;
use crate::scenes::config::SceneConfig;
use crate::scenes::registry::Scene;
use crate::scenes::view::Size;

/// Shown below the help.
pub const EXAMPLES: &str = "Examples:
  leadr bench                                  everything: minutes without a GPU
  leadr bench --paper --frames 9 --json        a full-screen quad over a LEADR map of its size, and the goals
  leadr bench --scene sphere --size 512x512
  leadr bench --scene trex --technique leadr
  leadr bench --scene ocean --frames 9         every pass of the sea, by size of transform and of picture
  leadr bench --scene ocean --soak 5000 --size 64x48 --fft 64

Times are medians over frames, measured on the device itself. Every round draws one frame of each row, and ratios are
taken within rounds: a program that runs beside it slows the rows down but hardly changes the ratios.";

/// Arguments of `leadr bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Only this scene, from its middle view and from afar [default: the paper's tables, sphere and trex]
    #[arg(long, value_name = "NAME", value_parser = scenes())]
    pub scene: Option<&'static Scene>,
    /// Only this technique in scenes [default: all]
    #[arg(long, value_name = "NAME", value_parser = techniques())]
    pub technique: Option<Technique>,
    /// Size of the pictures, pixels [default: 1024x1024 for the paper's tables, 512x512 for scenes]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Rounds: frames of every row, except rows that take over a second
    #[arg(long, value_name = "N", default_value = "15", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// The paper's tables, its Figure 11 and variants of both; with --scene or --technique they come in addition
    #[arg(long)]
    pub paper: bool,
    /// Only the rows of the paper's tables that the goals compare: takes seconds
    #[arg(long, requires = "paper")]
    pub goals: bool,
    /// Height map of the plane or the sphere (PNG or EXR)
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub height_map: Option<PathBuf>,
    /// Samples along the edge of the ocean's tiles of waves: 64, 128, 256 or 512 [default: 256]
    #[arg(long, value_name = "N", value_parser = fft, requires = "scene")]
    pub fft: Option<u32>,
    /// Instead of timing, draw this many frames of a scene with a sea, over one day, and watch the memory
    #[arg(long, value_name = "FRAMES", requires = "scene", conflicts_with = "paper", value_parser = clap::value_parser!(u32).range(1..))]
    pub soak: Option<u32>,
    /// Texels along the tile of one patch in the displacement atlas: 8, 16, 32, 64 or 128
    #[arg(long, value_name = "N", default_value = "64", value_parser = atlas_tile)]
    pub atlas_tile: u32,
    /// Edge samples of the scenes, for every technique but the reference (see leadr capture --help)
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub edge_samples: u32,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Size of the full-screen quad and its map in the paper.
const PAPER_SIZE: Size = Size { width: 1024, height: 1024 };
/// Size of the scenes' pictures.
const SCENE_SIZE: Size = Size { width: 512, height: 512 };
/// The scenes that are measured when none is named.
const SCENES: [&str; 2] = ["sphere", "trex"];

impl BenchArgs {
    /// What is measured.
    ///
    /// # Errors
    /// [`AppError::Usage`] if flags contradict each other.
    pub fn resolve(&self) -> Result<BenchConfig, AppError> {
        // The tables come alone, along with the scenes, or not at all.
        let quad = self.paper || (self.scene.is_none() && self.technique.is_none());
        let scenes: Vec<&Scene> = match self.scene {
            Some(scene) => vec![scene],
            None if self.paper && self.technique.is_none() => Vec::new(),
            None => SCENES.iter().filter_map(|name| Scene::find(name)).collect(),
        };
        Ok(BenchConfig {
            quad: quad.then(|| Quad { size: self.size.unwrap_or(PAPER_SIZE), goals_only: self.goals }),
            scenes: scenes.into_iter().map(|scene| self.scene_config(scene)).collect::<Result<_, _>>()?,
            technique: self.technique,
            rounds: self.frames,
        })
    }

    /// The picture of a scene: `leadr capture`'s defaults, changed by the bench's flags.
    fn scene_config(&self, scene: &'static Scene) -> Result<SceneConfig, AppError> {
        let scene = SceneArgs {
            scene,
            height_map: self.height_map.clone(),
            waves: WaveArgs { fft: self.fft, ..WaveArgs::default() },
            atlas_tile: self.atlas_tile,
            size: self.size.unwrap_or(SCENE_SIZE),
            samples: 1,
            edge_samples: self.edge_samples,
            ..SceneArgs::unset()?
        };
        scene.resolve()
    }
}
