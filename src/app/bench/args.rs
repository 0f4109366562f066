//! The arguments of `leadr bench`, and the configuration that results from them.

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

/// Examples that are printed after the help text.
pub const EXAMPLES: &str = "Examples:
  leadr bench                                  measure everything; takes minutes without a GPU
  leadr bench --paper --frames 9 --json        measure the paper's tables and check the goals
  leadr bench --forward --size 512x512         compare the renderer with a plain forward pass
  leadr bench --scene trex                     time the near, mid and far views at three sizes
  leadr bench --scene trex --tables resolution,triangles,maps
  leadr bench --scene sphere --tables techniques,distance --size 256x256
  leadr bench --scene trex --csv trex.csv      also write a table for a spreadsheet or a notebook
  leadr bench --scene trex --json > old.json   later: leadr bench --scene trex --against old.json
  leadr bench --measured new.json --against old.json
  leadr bench --scene ocean --frames 9         time every pass of the sea at several FFT and picture sizes
  leadr bench --scene ocean --soak 5000 --size 64x48 --fft 64

Times are medians over frames, measured on the GPU. Each round draws one frame of every row, and each ratio compares
two rows of the same round. Other programs on the machine therefore slow down all rows but hardly change the ratios.";

/// Arguments of `leadr bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Measure only this scene or glTF model [default: the tables of the paper, and the scenes sphere and trex]
    #[arg(long, help_heading = MEASURED, value_name = "NAME|FILE.glb|FILE.gltf", value_parser = value_of("scene"))]
    pub scene: Option<OsString>,
    /// Measure only this technique in scenes [default: all techniques in the table techniques, LEADR in the other tables]
    #[arg(long, help_heading = MEASURED, value_name = "NAME", value_parser = choice(Technique::Leadr))]
    pub technique: Option<Technique>,
    /// Measure these tables of the scenes [default: with --scene, views and, for the ocean, waves; without --scene, techniques and distance]
    #[arg(long, help_heading = MEASURED, value_name = "NAMES", value_enum, value_delimiter = ',')]
    pub tables: Vec<Table>,
    /// Set the size of the pictures in pixels [default: 1024x1024 for --paper and --forward; 128x128, 480x270 and 1024x1024 for views;
    /// else 512x512]
    #[arg(long, help_heading = MEASURED, value_name = "WxH")]
    pub size: Option<Size>,
    /// Draw N frames of every row, or fewer if a frame takes over a second
    #[arg(long, help_heading = MEASURED, value_name = "N", default_value = "15", value_parser = |text: &str| whole(text, 1_u32, 10_000))]
    pub frames: u32,
    /// Measure the tables and Figure 11 of the paper, and variants, in addition to --scene or --technique
    #[arg(long, help_heading = MEASURED)]
    pub paper: bool,
    /// Compare the renderer with a plain forward pass that runs the paper's shaders on the same quad, in addition to other tables
    #[arg(long, help_heading = MEASURED)]
    pub forward: bool,
    /// Measure only the rows of the paper's tables that the performance goals compare; takes seconds
    #[arg(long, help_heading = MEASURED, hide_short_help = true, requires = "paper")]
    pub goals: bool,
    /// Use this height map for the plane or the sphere: an image such as PNG, TIFF or EXR, or a KTX2 or EXR from `leadr bake`
    #[arg(long, help_heading = SCENES_OF, value_name = "FILE", requires = "scene")]
    pub height_map: Option<OsString>,
    /// Add a point light to the scene (see leadr capture --help). You can repeat this option
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "X,Y,Z,COLOUR,POWER", value_parser = value_of("light"), allow_hyphen_values = true, requires = "scene")]
    pub light: Vec<OsString>,
    /// Set the number of samples along an edge of each wave tile: 64, 128, 256 or 512 [default: 256]
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "N", value_parser = value_of("fft"), requires = "scene")]
    pub fft: Option<OsString>,
    /// Draw FRAMES frames of a scene without timing, and fail if the memory in buffers and images grows
    ///
    /// The sun moves through one day, and the camera moves near and far. Each frame uses the next technique, unless --technique
    /// selects one. The resident memory and the number and size of buffers and images are measured ten times. Growth is measured
    /// from the second measurement.
    #[arg(long, help_heading = MEASURED, hide_short_help = true, value_name = "FRAMES", requires = "scene", conflicts_with_all = ["paper", "forward", "tables"], value_parser = |text: &str| whole(text, 1, u32::MAX))]
    pub soak: Option<u32>,
    /// Compare each row with an earlier run, the output of leadr bench --json; a ratio below 1 means that this run is faster
    #[arg(long, help_heading = AGAINST, value_name = "OLD.json", conflicts_with = "soak")]
    pub against: Option<PathBuf>,
    /// Compare the run in this file with the run in --against, instead of measuring
    #[arg(long, help_heading = AGAINST, hide_short_help = true, value_name = "NEW.json", requires = "against",
        conflicts_with_all = ["scene", "technique", "tables", "size", "frames", "paper", "forward", "atlas_tile", "map_precision", "edge_samples", "msaa", "lod_bias", "device",
            "validation"])]
    pub measured: Option<PathBuf>,
    /// Also write the rows to this CSV file: a header with units, and one line per table, row and pass
    #[arg(long, help_heading = MEASURED, hide_short_help = true, value_name = "FILE.csv", conflicts_with_all = ["soak", "measured"])]
    pub csv: Option<PathBuf>,
    /// Allow --against to compare runs on different devices
    #[arg(long, help_heading = AGAINST, hide_short_help = true, requires = "against")]
    pub any_device: bool,
    /// Exit with code 1 if the ratio of the minimum total times in --against exceeds X (geometric mean over the rows)
    #[arg(long, help_heading = AGAINST, hide_short_help = true, value_name = "X", requires = "against", value_parser = positive)]
    pub max_ratio: Option<f32>,
    /// Set the number of texels along an edge of each patch tile in the displacement atlas: 8, 16, 32, 64 or 128 [default: 64]
    #[arg(long, help_heading = SCENES_OF, value_name = "N", value_parser = value_of("atlas-tile"))]
    pub atlas_tile: Option<OsString>,
    /// Store the slopes of the maps in GPU memory in this number format [default: f32]
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "PRECISION", value_parser = value_of("map-precision"))]
    pub map_precision: Option<OsString>,
    /// Draw scenes with N geometry samples per pixel (see leadr capture --help)
    #[arg(long, help_heading = SCENES_OF, value_name = "N", default_value = "1", value_parser = value_of("msaa"))]
    pub msaa: OsString,
    /// Draw scenes with N edge samples, except with the technique reference (see leadr capture --help)
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "N", default_value = "1", value_parser = value_of("edge-samples"))]
    pub edge_samples: OsString,
    /// Read the maps X levels coarser than pixels require, except with the technique reference (see leadr capture --help)
    #[arg(long, help_heading = SCENES_OF, hide_short_help = true, value_name = "X", value_parser = value_of("lod-bias"), allow_hyphen_values = true)]
    pub lod_bias: Option<OsString>,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

const MEASURED: &str = "Measurements";
const AGAINST: &str = "Comparison with an earlier run";
const SCENES_OF: &str = "Scenes";

/// The size of the full-screen quad and of its map in the paper.
const PAPER_SIZE: Size = Size { width: 1024, height: 1024 };
/// The sizes of the pictures for the table of views.
const VIEW_SIZES: [Size; 3] =
    [Size { width: 128, height: 128 }, Size { width: 480, height: 270 }, Size { width: 1024, height: 1024 }];
/// The size of the pictures for all other tables of scenes.
const SCENE_SIZE: Size = Size { width: 512, height: 512 };
/// The scenes of the bench by default.
const SCENES: [&str; 2] = ["sphere", "trex"];

impl BenchArgs {
    /// Checks the arguments and returns the measurements that they select.
    pub fn resolve(&self) -> Result<BenchConfig, AppError> {
        // The tables of the paper can be measured alone, with the tables of scenes, or not at all.
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
            let fault = format!("--tables maps generates the height maps of {name}: leave --height-map out");
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

    /// Returns the selected tables, in the order of measurement.
    fn tables_of_scenes(&self) -> Vec<Table> {
        let wanted: &[Table] = match (self.tables.as_slice(), &self.scene) {
            ([], Some(_)) => &[Table::Views, Table::Waves],
            ([], None) => &[Table::Techniques, Table::Distance],
            (named, _) => named,
        };
        Table::value_variants().iter().copied().filter(|table| wanted.contains(table)).collect()
    }

    /// Returns the configuration of a scene: the defaults of `leadr capture`, changed by the flags of the bench.
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
        self.light.iter().for_each(|light| given.add("--light", Some(light.clone())));
        given.set("--fft", self.fft.as_ref());
        given.set("--atlas-tile", self.atlas_tile.as_ref());
        given.set("--map-precision", self.map_precision.as_ref());
        given.set("--lod-bias", self.lod_bias.as_ref());
        let mut config = SceneArgs { given }.resolve()?;
        // The surroundings of a surface would add to the measured time.
        config.bare = config.model.is_none() && config.scene.offers(Choice::Bare);
        Ok(config)
    }
}
