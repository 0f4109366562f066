//! The flags of commands that draw a scene. The flags are generated from the option table of `leadr-scenes`.

use std::ffi::OsString;

use clap::builder::{OsStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::given;
use leadr_render::settings::Named;
use leadr_scenes::camera_file;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::file_kind::FileKind;
use leadr_scenes::given::{CommandLine, EXCLUSIVE};
use leadr_scenes::options::SceneOption;
use leadr_scenes::registry::SCENES;
use leadr_scenes::view::ViewChoice;
use leadr_tools::command::error::AppError;

/// The scene and picture options set by the user.
#[derive(Clone, Debug, Default)]
pub struct SceneArgs {
    /// The options as text.
    pub given: CommandLine,
}

impl Args for SceneArgs {
    fn augment_args(command: Command) -> Command {
        command.args(SceneOption::all().iter().map(arg))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SceneArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self { given: given::<Self>(matches) })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.given = given::<Self>(matches);
        Ok(())
    }
}

impl SceneArgs {
    /// Checks that the flags are consistent, and reads the camera file if there is one.
    pub fn resolve(&self) -> Result<SceneConfig, AppError> {
        let mut config = self.given.resolve().map_err(AppError::Usage)?;
        if let Some(file) = config.camera_file.take() {
            FileKind::check("--camera", &file, &[FileKind::Camera])?;
            config.view = ViewChoice::Pose(camera_file::read(&file).map_err(AppError::Failed)?);
        }
        Ok(config)
    }
}

/// Returns the clap argument of an option.
fn arg(option: &'static SceneOption) -> Arg {
    let spec = &option.spec;
    let arg = Arg::new(spec.name).long(spec.name).help(option.help()).help_heading(spec.heading);
    let arg = arg.aliases(spec.old_name).hide_short_help(!spec.is_common);
    let other = |&(a, b): &(&'static str, &'static str)| match spec.name {
        name if name == a => Some(b),
        name if name == b => Some(a),
        _ => None,
    };
    let arg = arg.conflicts_with_all(EXCLUSIVE.iter().filter_map(other));
    let arg = if spec.name == "scene" { arg.long_help(scene_help(option)) } else { arg };
    if !option.takes_value() {
        return arg.action(ArgAction::SetTrue);
    }
    let arg = arg.value_name(spec.value_name).value_parser(value(option)).allow_negative_numbers(true);
    // clap recognises only single negative numbers. The values of these options are lists of numbers.
    let arg = arg.allow_hyphen_values(matches!(spec.name, "sun" | "camera" | "light"));
    arg.action(if option.repeats { ArgAction::Append } else { ArgAction::Set })
}

/// Returns the value parser of an option.
fn value(option: &'static SceneOption) -> ValueParser {
    let names = option.names();
    if !names.is_empty() {
        return PossibleValuesParser::new(names.into_iter().map(possible)).into();
    }
    let check = |text: OsString| option.set(&mut SceneConfig::default(), &text).map(|()| text);
    OsStringValueParser::new().try_map(check).into()
}

/// Returns the value parser of the option with this name, for a flag of another command.
pub fn value_of(name: &str) -> ValueParser {
    SceneOption::find(name).map(value).expect("an option of this name")
}

fn possible((name, help): (&'static str, &'static str)) -> PossibleValue {
    let value = PossibleValue::new(name);
    if help.is_empty() { value } else { value.help(help) }
}

/// Returns the value parser of a choice between names, with one line of help per name. `some` can be any value of the type.
pub fn choice<T: Named + Copy + Send + Sync + 'static>(some: T) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(some.names().into_iter().map(possible)).try_map(move |text| {
        let mut value = some;
        value.choose(&text).map(|()| value)
    })
}

/// The names of values, with their meanings and their lines of help.
pub type Names<T> = &'static [(&'static str, T, &'static str)];

/// Returns the value parser of a flag with these named values.
pub fn one_of<T: Copy + Send + Sync + 'static>(names: Names<T>) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names.iter().map(|(name, _, help)| possible((name, help)))).try_map(move |text| {
        names.iter().find(|(name, ..)| *name == text).map(|(_, value, _)| *value).ok_or("no such value")
    })
}

fn scene_help(option: &SceneOption) -> String {
    let names: Vec<_> = SCENES.iter().map(|scene| format!("- {}: {}", scene.name, scene.help)).collect();
    format!("{}\n\nScenes:\n{}", option.help(), names.join("\n"))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use clap::Parser;
    use leadr_reflectance::integrals::slope_nodes::NodePlacement;
    use leadr_reflectance::masking::occlusion::ConeEdge;
    use leadr_reflectance::masking::shadowing::Shadowing;
    use leadr_reflectance::materials::diffuse_models::DiffuseModel;
    use leadr_render::settings::{GridLod, Probes, Quadrature, ShadingOptions, Technique, Terms};
    use leadr_scenes::config::Picture;
    use leadr_scenes::options::Sets;
    use leadr_scenes::registry::{MODEL, NamedScene};
    use serde_json::Value;
    use std::ffi::OsStr;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        scene: SceneArgs,
    }

    fn resolve(line: &str) -> Result<SceneConfig, String> {
        let words = ["leadr"].into_iter().chain(line.split_whitespace());
        Flags::try_parse_from(words).map_err(|e| e.to_string())?.scene.resolve().map_err(|e| e.to_string())
    }

    /// Returns the value of an option in a configuration as JSON.
    fn json(option: &SceneOption, config: &SceneConfig) -> Option<Value> {
        serde_json::to_value(config).unwrap().pointer(&format!("/{}", option.spec.json_key())).cloned()
    }

    /// Returns a value of an option that changes the JSON of a configuration.
    pub fn other_value(option: &SceneOption, config: &SceneConfig) -> String {
        let values = [
            "",
            "on",
            "off",
            "0.5",
            "2",
            "9",
            "16",
            "20",
            "128",
            "2000",
            "diffuse-lights",
            "grid",
            "far",
            "10,10",
            "studio",
            "1,2,3,ff8000,1",
            "ff8000,1",
        ];
        let names = option.names().into_iter().map(|(name, _)| name);
        let texts = names.chain(values).chain(["64x48", "skin=a.png", "ocean", "a"]);
        let mut config = config.clone();
        if let Sets::Shading(row) = option.sets
            && !row.applies_to(config.picture.technique)
            && let Some(technique) = Technique::ALL.into_iter().find(|technique| row.applies_to(*technique))
        {
            config.picture.technique = technique;
        }
        let is_other = |text: &&str| {
            let mut changed = config.clone();
            option.set(&mut changed, OsStr::new(text)).is_ok() && json(option, &changed) != json(option, &config)
        };
        let found = texts.into_iter().find(is_other);
        found.unwrap_or_else(|| panic!("no value of --{} changes the JSON", option.spec.name)).to_owned()
    }

    #[test]
    fn without_flags_the_configuration_is_the_default_one() {
        assert_eq!(resolve("").unwrap(), SceneConfig::default());
    }

    #[test]
    fn every_option_is_in_the_json_and_honoured_or_refused() {
        let names: Vec<&str> = SCENES.iter().map(|scene| scene.name).chain(["model.glb"]).collect();
        for option in SceneOption::all() {
            let value = other_value(option, &SceneConfig::default());
            for name in names.iter().filter(|_| option.choice.is_some()) {
                let mut given = CommandLine::default();
                given.set("--scene", Some(*name));
                given.set(&option.spec.flag(), Some(&*value));
                match option.spec.name {
                    "anisotropy-rotation" => given.set("--anisotropy", Some("0.5")),
                    "clear-coat-relief" => given.set("--clear-coat", Some("1")),
                    "thickness" => given.set("--transmission", Some("1")),
                    "attenuation" => {
                        given.set("--transmission", Some("1"));
                        given.set("--thickness", Some("1"));
                    }
                    "detail-repeat"
                    | "detail-rotation"
                    | "detail-height-scale"
                    | "detail-displaces"
                    | "detail-mask" => given.set("--detail", Some("a")),
                    "height-scale-span" => given.set("--height-scale-map", Some("a")),
                    "normal-y" => given.set("--normal-map", Some("a")),
                    "follow-links" | "heights-as-read" if *name != "model.glb" => given.set("--material", Some("a")),
                    "relief-shadows" => given.set("--technique", Some("reference")),
                    _ => {}
                }
                let scene = NamedScene::find(name).unwrap_or(&MODEL);
                match given.resolve() {
                    Ok(config) => {
                        assert!(
                            option.choice.is_some_and(|choice| scene.offers(choice)),
                            "{name} ignores --{}",
                            option.spec.name
                        );
                        let picture = Picture { technique: config.picture.technique, ..Picture::default() };
                        let own = SceneConfig { waves: scene.waves(), picture, ..SceneConfig::default() };
                        assert_ne!(json(option, &config), json(option, &own), "{name} --{}", option.spec.name);
                    }
                    Err(message) => {
                        assert!(option.choice.is_some_and(|choice| !scene.offers(choice)), "{name}: {message}");
                        let known = message.contains("is for the scenes") || message.contains("is for models");
                        assert!(known && message.starts_with("--"), "{name} --{}: {message}", option.spec.name);
                    }
                }
            }
        }
    }

    #[test]
    fn techniques_refuse_missing_features() {
        for option in SceneOption::all() {
            let Sets::Shading(row) = option.sets else { continue };
            let value = other_value(option, &SceneConfig::default());
            for technique in Technique::ALL {
                let mut given = CommandLine::default();
                given.set("--technique", Some(technique.name()));
                given.set(&option.spec.flag(), Some(&*value));
                if option.spec.name.starts_with("grid-") && technique.integrates() {
                    given.set("--grid", Some("5"));
                }
                if option.spec.name.starts_with("cone-") {
                    given.set("--scene", Some("plane"));
                    given.set("--cone-map", Some("a"));
                }
                match given.resolve() {
                    Ok(_) => {
                        assert!(row.applies_to(technique) || row.neutral == Some(&*value), "{technique:?} {value}")
                    }
                    Err(message) => {
                        assert!(
                            !row.applies_to(technique) && message.starts_with(&option.spec.flag()),
                            "{technique:?}: {message}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_guide_lists_every_option() {
        let mut guide = "# Options of a picture\n\n`leadr capture` and `leadr demo` have these options. Written from the program; see ARCHITECTURE.md.\n".to_owned();
        let mut headings = Vec::new();
        for heading in SceneOption::all().iter().map(|option| option.spec.heading) {
            if !headings.contains(&heading) {
                headings.push(heading);
            }
        }
        for heading in headings {
            guide += &format!("\n## {}\n\n| option | does |\n|---|---|\n", heading);
            for option in SceneOption::all().iter().filter(|option| option.spec.heading == heading) {
                let value = format!("{} {}", option.spec.flag(), option.spec.value_name);
                guide += &format!("| `{}` | {} |\n", value.trim().replace('|', "\\|"), option.help());
            }
        }
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide/options.md");
        if std::env::var_os("LEADR_WRITE_GUIDE").is_some() {
            std::fs::write(file, &guide).unwrap();
        }
        assert_eq!(std::fs::read_to_string(file).unwrap(), guide, "LEADR_WRITE_GUIDE=1 writes it again");
    }

    #[test]
    fn flags_become_settings() {
        let options = |line: &str| resolve(line).unwrap().picture.options;
        assert_eq!(options("--sky-occlusion off"), ShadingOptions::default());
        assert_eq!(options("--rule grid").quadrature, Quadrature::Grid(5));
        assert_eq!(options("--rule grid --grid 7").quadrature, Quadrature::Grid(7));
        assert_eq!(options("--probes 9").quadrature, Quadrature::VisibleSlopes(Probes::Nine));
        let model = |line: &str| options(line).diffuse_model;
        assert_eq!(model(""), DiffuseModel::Lambert);
        assert_eq!(model("--technique gloss --multiscattering on"), DiffuseModel::Multiscattering);
        assert_eq!(model("--diffuse-model disney --multiscattering off"), DiffuseModel::Disney);
        assert!(resolve("--diffuse-model disney --multiscattering on").unwrap_err().contains("remove one of them"));
        assert!(options("").sky_occlusion && !options("--technique reference --relief-shadows").sky_occlusion);
        assert_eq!(options("--masking normal-map"), options("--shadowing normal-map"));
        assert_eq!(options("--grid 5 --grid-lod banding-5").grid_lod, GridLod::Banding5);
        assert_eq!(options("--rule grid --grid-nodes pruned").grid_nodes, NodePlacement::Pruned);
        assert_eq!(options("--masking separable").shadowing, Shadowing::SmithSeparable);
        let grooves = resolve("--shadowing v-groove --grid-lod derivation").unwrap().picture.shading();
        assert_eq!(grooves.quadrature(), Some(Quadrature::PAPER));
        assert!(!resolve("--no-displacement").unwrap().picture.displacement);
        let terms = options("--terms specular-lights,diffuse-environment").terms;
        assert_eq!(terms, Terms::SPECULAR_LIGHTS | Terms::DIFFUSE_ENVIRONMENT);
        assert_eq!(
            resolve("--technique constant --terms all --edge-samples 1").unwrap().picture.technique,
            Technique::Constant
        );
        let [ocean, shore] =
            ["ocean", "shore"].map(|name| resolve(&format!("--scene {name} --wind 12")).unwrap().waves);
        assert_eq!((ocean.wind, ocean.fetch, shore.wind, shore.fetch), (12.0, 120e3, 12.0, 40e3));
        let plane = resolve("--scene plane --height 0.05 --repeat 0.6").unwrap();
        assert_eq!((plane.height, plane.repeat), (Some(0.05), Some(0.6)));
        let studio = resolve("--environment studio --environment-rotation -45 --auto-exposure").unwrap();
        assert_eq!((studio.environment_rotation, studio.auto_exposure), (-45.0, true));
        assert_eq!(resolve("--light -1,0,2,ff8000,3 --light 0,0,1,2700K,1").unwrap().point_lights.len(), 2);
        let cones = resolve("--scene fox.glb --cones a=b.png --cones *=c.png --cone-edge hard").unwrap();
        assert_eq!((cones.cones.len(), cones.picture.options.cone_edge), (2, ConeEdge::Hard));
        assert_eq!(
            resolve("--scene fox.glb --displacement a=b.png --displacement c=d.png").unwrap().displacements.len(),
            2
        );
    }

    #[test]
    fn contradictions_and_unknown_names_are_refused() {
        for (line, word) in [
            ("--rule visible --grid 5", "--probes"),
            ("--rule grid --probes 5", "--grid"),
            ("--grid 5 --probes 5", "--grid"),
            ("--probes 4", "16"),
            ("--grid-lod derivation", "add --grid"),
            ("--grid 5 --grid-lod fine", "matched"),
            ("--grid-nodes pruned", "add --grid"),
            ("--grid 5 --grid-nodes fewer", "centred-normals"),
            ("--shadowing v-groove --grid-nodes pruned", "remove --grid-nodes"),
            ("--shadowing v-groove --probes 9", "use --grid"),
            ("--shadowing v-groove --diffuse-lights sh", "remove --diffuse-lights"),
            ("--shadowing separable --classes on", "remove --classes"),
            ("--technique reference --relief-shadows --shadowing v-groove", "remove --shadowing"),
            ("--grid 129", "128"),
            ("--technique phong", "blinn-phong"),
            ("--terms specular", "specular-lights"),
            ("--pixel-kernel maybe", "half-vector"),
            ("--pixel-kernel half-vector --edge-samples 16", "remove --edge-samples"),
            ("--displacement skin=scales.png", "is for models"),
            ("--scene sphere --cones skin=skin_Cones.png", "is for models"),
            ("--scene fox.glb --cones skin_Cones.png", "MATERIAL=FILE"),
            ("--scene fox.glb --cone-map skin_Cones.png", "is for the scenes plane, sphere"),
            ("--scene fox.glb --cone-edge hard", "--cones for a model"),
            ("--scene trex --height 0.05", "is for the scenes plane, sphere"),
            ("--scene plane --height=-1", "negative"),
            ("--scene plane --repeat 0", "0.01"),
            ("--light 1,2,3", "X,Y,Z,COLOUR,POWER"),
            ("--light 1,2,3,red,1", "no such colour: 'red'"),
            ("--light 1,nan,3,ffffff,1", "'nan' is not a finite number"),
            ("--light 1,2,3,ffffff,inf", "POWER"),
            ("--environment-rotation 10", "--sun"),
            ("--environment studio --sun 10,10", "--sun is for --environment sky"),
        ] {
            let message = resolve(line).expect_err(line);
            assert!(message.contains(word), "{line}: {message}");
        }
    }
}
