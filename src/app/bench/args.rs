//! Arguments of `leadr bench`, and what they ask for.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::app::flags::scene::{SceneArgs, choice, value_of};
use leadr_render::settings::Technique;
use leadr_render::settings::numbers::{positive, whole};
use leadr_scenes::config::SceneConfig;
use leadr_scenes::given::CommandLine;
use leadr_scenes::registry::{self, Choice};
use leadr_scenes::view::Size;
use leadr_tools::bench::{BenchConfig, Quad, Table};
use leadr_tools::command::device::DeviceArgs;
use leadr_tools::command::error::AppError;

/// Shown below the help.
pub const EXAMPLES: &str = "Examples:
  leadr bench                                  everything: minutes without a GPU
  leadr bench --paper --frames 9 --json        a full-screen quad over a LEADR map of its size, and the goals
  leadr bench --forward --size 512x512         the renderer against a plain forward pass
  leadr bench --scene trex                     a frame of its near, mid and far views at three sizes
  leadr bench --scene trex --tables resolution,triangles,maps
  leadr bench --scene sphere --tables techniques,distance --size 256x256
  leadr bench --scene trex --json > old.json   later: leadr bench --scene trex --against old.json
  leadr bench --measured new.json --against old.json
  leadr bench --scene ocean --frames 9         every pass of the sea, by size of transform and of picture
  leadr bench --scene ocean --soak 5000 --size 64x48 --fft 64

Times are medians over frames, measured on the device itself. Every round draws one frame of each row, and ratios are
taken within rounds: a program that runs beside it slows the rows down but hardly changes the ratios.";

/// Arguments of `leadr bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Measure only this scene or glTF model [default: the paper's tables, sphere and trex]
    #[arg(long, help_heading = MEASURED, value_name = "NAME|FILE.glb|FILE.gltf", value_parser = value_of("scene"))]
    pub scene: Option<OsString>,
    /// Measure only this technique in scenes [default: all in techniques, LEADR in the other tables]
    #[arg(long, help_heading = MEASURED, value_name = "NAME", value_parser = choice(Technique::Leadr))]
    pub technique: Option<Technique>,
    /// Measure these tables of scenes, separated by commas [default: views, and waves of the open sea; without --scene techniques, distance]
    #[arg(long, help_heading = MEASURED, value_name = "NAMES", value_enum, value_delimiter = ',')]
    pub tables: Vec<Table>,
    /// Set the size of the pictures in pixels [default: 1024x1024 for the paper's tables; for views 128x128, 480x270 and 1024x1024; else
    /// 512x512]
    #[arg(long, help_heading = MEASURED, value_name = "WxH")]
    pub size: Option<Size>,
    /// Draw N frames of every row, except of rows that take over a second
    #[arg(long, help_heading = MEASURED, value_name = "N", default_value = "15", value_parser = |text: &str| whole(text, 1_u32, 10_000))]
    pub frames: u32,
    /// Measure the paper's tables, its Figure 11 and variants of both, in addition to --scene or --technique
    #[arg(long, help_heading = MEASURED)]
    pub paper: bool,
    /// Measure the renderer against a plain forward pass of the paper's shaders over the same quad, and the goals, in addition to
    /// anything else
    #[arg(long, help_heading = MEASURED)]
    pub forward: bool,
    /// Measure only the rows of the paper's tables that the goals compare: takes seconds
    #[arg(long, help_heading = MEASURED, hide_short_help = true, requires = "paper")]
    pub goals: bool,
    /// Use this height map of the plane or the sphere, PNG or EXR
    #[arg(long, help_heading = SCENES_OF, value_name = "FILE", requires = "scene")]
    pub height_map: Option<OsString>,
    /// Set the samples along the edge of a tile of waves: 64, 128, 256 or 512 [default: 256]
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "N", value_parser = value_of("fft"), requires = "scene")]
    pub fft: Option<OsString>,
    /// Instead of timing, draw this many frames of a scene, near and far over one day, and watch the memory
    #[arg(long, help_heading = MEASURED, hide_short_help = true, value_name = "FRAMES", requires = "scene", conflicts_with_all = ["paper", "forward", "tables"], value_parser = |text: &str| whole(text, 1, u32::MAX))]
    pub soak: Option<u32>,
    /// Compare with an earlier run, row by row: what leadr bench --json printed then. Ratios below 1 are faster now
    #[arg(long, help_heading = AGAINST, value_name = "OLD.json", conflicts_with = "soak")]
    pub against: Option<PathBuf>,
    /// With --against: compare this run instead of measuring
    #[arg(long, help_heading = AGAINST, hide_short_help = true, value_name = "NEW.json", requires = "against",
        conflicts_with_all = ["scene", "technique", "tables", "size", "frames", "paper", "forward", "atlas_tile", "map_precision", "edge_samples", "msaa", "device",
            "validation"])]
    pub measured: Option<PathBuf>,
    /// With --against: compare runs on different devices
    #[arg(long, help_heading = AGAINST, hide_short_help = true, requires = "against")]
    pub any_device: bool,
    /// With --against: exit with 1 if the geometric mean of the ratios of least total times is above this
    #[arg(long, help_heading = AGAINST, hide_short_help = true, value_name = "X", requires = "against", value_parser = positive)]
    pub max_ratio: Option<f32>,
    /// Set the texels along the tile of one patch in the displacement atlas: 8, 16, 32, 64 or 128 [default: 64]
    #[arg(long, help_heading = SCENES_OF, value_name = "N", value_parser = value_of("atlas-tile"))]
    pub atlas_tile: Option<OsString>,
    /// Store the slopes of maps on the device in this format [default: f32]
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "PRECISION", value_parser = value_of("map-precision"))]
    pub map_precision: Option<OsString>,
    /// Sample the geometry of scenes so many times per pixel (see leadr capture --help)
    #[arg(long, help_heading = SCENES_OF, value_name = "N", default_value = "1", value_parser = value_of("msaa"))]
    pub msaa: OsString,
    /// Use edge samples in scenes, for every technique but the reference (see leadr capture --help)
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "N", default_value = "1", value_parser = value_of("edge-samples"))]
    pub edge_samples: OsString,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

const MEASURED: &str = "What is measured";
const AGAINST: &str = "Comparison with an earlier run";
const SCENES_OF: &str = "Scenes";

/// Size of the full-screen quad and its map in the paper.
const PAPER_SIZE: Size = Size { width: 1024, height: 1024 };
/// Sizes of the pictures of a scene's views.
const VIEW_SIZES: [Size; 3] =
    [Size { width: 128, height: 128 }, Size { width: 480, height: 270 }, Size { width: 1024, height: 1024 }];
/// Size of the scenes' other pictures.
const SCENE_SIZE: Size = Size { width: 512, height: 512 };
/// The scenes that are measured when none is named.
const SCENES: [&str; 2] = ["sphere", "trex"];

impl BenchArgs {
    /// What is measured.
    pub fn resolve(&self) -> Result<BenchConfig, AppError> {
        // The tables come alone, along with the scenes, or not at all.
        let about_scenes = self.technique.is_some() || !self.tables.is_empty();
        let everything = !self.paper && !self.forward && self.scene.is_none() && !about_scenes;
        let quad = self.paper || everything;
        let size = self.size.unwrap_or(PAPER_SIZE);
        let scenes: Vec<OsString> = match &self.scene {
            Some(scene) => vec![scene.clone()],
            None if (self.paper || self.forward) && !about_scenes => Vec::new(),
            None => SCENES.map(OsString::from).to_vec(),
        };
        let scenes: Vec<SceneConfig> = scenes.iter().map(|scene| self.scene_config(scene)).collect::<Result<_, _>>()?;
        let tables = self.tables_of_scenes();
        for scene in scenes.iter().map(|config| config.scene) {
            if let Some(table) = tables.iter().find(|table| !table.is_of(scene) && self.tables.contains(table)) {
                let mut with: Vec<&str> =
                    registry::SCENES.iter().filter(|scene| table.is_of(scene)).map(|scene| scene.name).collect();
                with.sort_unstable();
                let (table, with) = (table.name(), with.join(", "));
                return Err(AppError::Usage(format!("--tables {table} is for the scenes {with}, not {}", scene.name)));
            }
        }
        let untiled = scenes.iter().find(|config| !config.scene.offers(Choice::AtlasTile));
        if let (Some(config), Some(_)) = (untiled, &self.height_map)
            && tables.contains(&Table::Maps)
        {
            let name = config.scene.name;
            let fault = format!("--tables maps makes the height maps of {name} itself: leave --height-map out");
            return Err(AppError::Usage(fault));
        }
        Ok(BenchConfig {
            quad: quad.then_some(Quad { size, goals_only: self.goals }),
            forward: (self.forward || everything).then_some(size),
            scenes,
            tables,
            view_sizes: self.size.map_or(VIEW_SIZES.into(), |size| vec![size]),
            technique: self.technique,
            rounds: self.frames,
        })
    }

    /// The tables that are asked for, in the order in which they are measured.
    fn tables_of_scenes(&self) -> Vec<Table> {
        let wanted: &[Table] = match (self.tables.as_slice(), &self.scene) {
            ([], Some(_)) => &[Table::Views, Table::Waves],
            ([], None) => &[Table::Techniques, Table::Distance],
            (named, _) => named,
        };
        Table::value_variants().iter().copied().filter(|table| wanted.contains(table)).collect()
    }

    /// The picture of a scene: `leadr capture`'s defaults, changed by the bench's flags.
    fn scene_config(&self, scene: &OsStr) -> Result<SceneConfig, AppError> {
        let mut given = CommandLine::default();
        given.set("--scene", Some(scene));
        given.set("--size", Some(self.size.unwrap_or(SCENE_SIZE).to_string()));
        given.set("--samples", Some("1"));
        given.set("--edge-samples", Some(&self.edge_samples));
        if self.edge_samples == "1" {
            given.set("--msaa", Some(&self.msaa));
        }
        given.set("--height-map", self.height_map.as_ref());
        given.set("--fft", self.fft.as_ref());
        given.set("--atlas-tile", self.atlas_tile.as_ref());
        given.set("--map-precision", self.map_precision.as_ref());
        let mut config = SceneArgs { given }.resolve()?;
        // What surrounds a surface would be timed with it.
        config.bare = config.scene.offers(Choice::Bare);
        Ok(config)
    }
}
