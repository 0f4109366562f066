//! A command line, and the checked configuration that results from its options.

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::path::Path;

use super::config::{DEFAULT_MSAA, SceneConfig};
use super::light::EnvironmentChoice;
use super::options::{SceneOption, Sets, Under};
use super::view::ViewChoice;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::materials::diffuse_models::DiffuseModel;

/// Pairs of options that exclude each other.
pub const EXCLUSIVE: [(&str, &str); 3] = [("grid", "probes"), ("sun", "time-of-day"), ("occlusion-map", "cone-map")];

/// Pairs of an option and the option that it requires.
const NEEDS: [(&str, &str); 10] = [
    ("anisotropy-rotation", "anisotropy"),
    ("clear-coat-relief", "clear-coat"),
    ("thickness", "transmission"),
    ("attenuation", "transmission"),
    ("detail-repeat", "detail"),
    ("detail-rotation", "detail"),
    ("detail-height-scale", "detail"),
    ("detail-mask", "detail"),
    ("detail-displaces", "detail"),
    ("height-scale-span", "height-scale-map"),
];

/// The flags that need occlusion cones.
const CONE_FLAGS: [&str; 4] = ["cone-occluders", "cone-edge", "cone-axis", "cone-lobe"];

/// A list of flags with their values, in order, which can be edited and printed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommandLine {
    flags: Vec<(String, Option<OsString>)>,
}

impl CommandLine {
    /// Appends a flag with its value, if it takes one.
    pub fn add(&mut self, flag: &str, value: Option<OsString>) {
        self.flags.push((flag.to_owned(), value));
    }

    /// Sets a flag to a value. If the value is `None`, the flag is removed.
    pub fn set(&mut self, flag: &str, value: Option<impl Into<OsString>>) {
        self.remove(flag);
        self.flags.extend(value.map(|value| (flag.to_owned(), Some(value.into()))));
    }

    /// Removes a flag.
    pub fn remove(&mut self, flag: &str) {
        self.flags.retain(|(known, _)| known != flag);
    }

    /// Returns the value of a flag if it is set. The value of a flag that takes none is empty.
    pub fn value(&self, flag: &str) -> Option<&OsStr> {
        let found = self.flags.iter().rev().find(|(known, _)| known == flag);
        found.map(|(_, value)| value.as_deref().unwrap_or_default())
    }

    /// Whether the flag of an option is set.
    pub fn has(&self, option: &str) -> bool {
        self.value(&format!("--{option}")).is_some()
    }

    /// Whether an option may bring occlusion cones.
    fn may_have_cones(&self) -> bool {
        ["cone-map", "material", "cones"].iter().any(|option| self.has(option))
    }

    /// Switches the command line to another scene.
    pub fn enter(&mut self, scene: impl Into<OsString>) {
        SceneOption::all().iter().filter(|option| option.is_of_one_scene()).for_each(|o| self.remove(&o.spec.flag()));
        self.flags.insert(0, ("--scene".to_owned(), Some(scene.into())));
    }

    /// Removes options that the scene, light or technique would refuse. The window keeps them for later.
    pub fn honoured(&self) -> Self {
        let mut line = self.clone();
        let mut config = SceneConfig::default();
        for name in ["scene", "environment", "technique"] {
            if let (Some(option), Some(value)) = (SceneOption::find(name), self.value(&format!("--{name}"))) {
                // `resolve` reports these errors.
                _ = option.set(&mut config, value);
            }
        }
        let technique = config.picture.technique;
        let light = if config.environment == EnvironmentChoice::Sky { Under::Sky } else { Under::Panorama };
        let refused =
            |o: &&SceneOption| !o.applies_to(config.scene, technique) || o.under.is_some_and(|under| under != light);
        SceneOption::all().iter().filter(refused).for_each(|option| line.remove(&option.spec.flag()));
        if technique.is_reference() {
            line.remove("--msaa");
        }
        let is = |flag: &str, value: &str| line.value(flag).is_some_and(|given| given == value);
        let (separable, grooves) = (is("--shadowing", "separable"), is("--shadowing", "v-groove"));
        let on_grid = line.has("grid") || is("--rule", "grid") || grooves;
        let unused: &[(bool, &[&str])] = &[
            (grooves, &["--probes", "--rule", "--diffuse-lights", "--grid-nodes"]),
            (grooves || separable, &["--classes"]),
            (!on_grid, &["--grid-lod", "--grid-nodes"]),
            (is("--pixel-kernel", "half-vector"), &["--edge-samples"]),
        ];
        unused
            .iter()
            .filter(|(given, _)| *given)
            .for_each(|(_, flags)| flags.iter().for_each(|flag| line.remove(flag)));
        if !technique.integrates() || line.has("relief-shadows") {
            ["--clear-coat", "--clear-coat-relief", "--transmission", "--thickness", "--attenuation"]
                .into_iter()
                .for_each(|flag| line.remove(flag));
        }
        if !line.may_have_cones() {
            CONE_FLAGS.iter().for_each(|flag| line.remove(&format!("--{flag}")));
        }
        if line.has("relief-shadows") {
            ["--sky-occlusion", "--diffuse-model", "--multiscattering"].into_iter().for_each(|flag| line.remove(flag));
        }
        line
    }

    /// Resolves the options to a configuration. The camera file is not read yet.
    ///
    /// # Errors
    /// If an option is invalid, or not supported by the scene or the technique.
    pub fn resolve(&self) -> Result<SceneConfig, String> {
        let mut config = SceneConfig::default();
        for option in SceneOption::all() {
            let flag = option.spec.flag();
            for (_, value) in self.flags.iter().filter(|(known, _)| *known == flag) {
                let value = value.as_deref().unwrap_or_default();
                option.set(&mut config, value).map_err(|fault| format!("{flag}: {fault}"))?;
            }
        }
        self.check(&config)?;
        let options = &mut config.picture.options;
        // Relief shadows already include the occlusion of the sky.
        options.sky_occlusion &= self.has("sky-occlusion") || !options.relief_shadows;
        let (heights, traced) = (config.height_map.as_deref(), options.relief_shadows);
        if !self.has("shadowing") && !traced && config.material.is_normal_map_alone(heights) {
            options.shadowing = Shadowing::NormalMap;
        }
        // If there are several samples, they antialias edges, so MSAA is not needed.
        let once = config.picture.samples == 1 && options.edge_samples == 1;
        if !self.has("msaa") && once && !config.picture.technique.is_reference() {
            config.msaa = DEFAULT_MSAA;
        }
        Ok(config)
    }

    /// Refuses options that the scene, light or technique does not support, and invalid combinations of options.
    fn check(&self, config: &SceneConfig) -> Result<(), String> {
        if self.has("environment-layer") && config.environment == EnvironmentChoice::Studio {
            return Err("--environment-layer is for an EXR file; the studio has no layers".into());
        }
        let technique = config.picture.technique;
        for option in SceneOption::all() {
            let (name, flag) = (option.spec.name, option.spec.flag());
            let Some(value) = self.value(&flag) else { continue };
            if let Some(choice) = option.choice {
                config.scene.check_offers(&flag, choice)?;
            }
            match (option.under, config.environment == EnvironmentChoice::Sky) {
                (Some(Under::Sky), false) => {
                    return Err(format!("{flag} is for --environment sky; an image brings its own light"));
                }
                (Some(Under::Panorama), true) => {
                    return Err(format!(
                        "{flag} is for an image (--environment studio or FILE), not the sky; --sun moves its light"
                    ));
                }
                _ => {}
            }
            if let Sets::Shading(row) = option.sets
                && !row.applies_to(technique)
                && row.neutral.is_none_or(|neutral| value != neutral)
            {
                let names = row.techniques.names();
                return Err(format!("{flag} is for the techniques {names}, not {}", technique.name()));
            }
            if let Some((_, other)) = NEEDS.iter().find(|(needs, other)| *needs == name && !self.has(other)) {
                return Err(format!("{flag} needs --{other}"));
            }
        }
        self.check_combinations(config)
    }

    fn check_combinations(&self, config: &SceneConfig) -> Result<(), String> {
        let options = config.picture.options;
        let grooves = options.shadowing == Shadowing::VGroove;
        let is = |name: &str, value: &str| self.value(&format!("--{name}")).is_some_and(|given| given == value);
        let fault = if is("rule", "visible") && self.has("grid") {
            "--grid is for --rule grid; --rule visible takes --probes"
        } else if is("rule", "grid") && self.has("probes") {
            "--probes is for --rule visible; --rule grid takes --grid"
        } else if grooves && (self.has("probes") || is("rule", "visible")) {
            "--shadowing v-groove sums over a grid of slopes: use --grid"
        } else if grooves && is("diffuse-lights", "sh") {
            "--shadowing v-groove shadows each facet by itself: remove --diffuse-lights sh"
        } else if is("classes", "on") && (grooves || options.shadowing == Shadowing::SmithSeparable) {
            "--shadowing v-groove and separable have one Gaussian of slopes: remove --classes on"
        } else if grooves && self.has("grid-nodes") && !is("grid-nodes", "even") {
            "--shadowing v-groove sums over an even grid: remove --grid-nodes"
        } else if self.has("grid-nodes") && options.quadrature.side().is_none() && !grooves {
            "--grid-nodes is for the samples of a grid: add --grid or --rule grid"
        } else if self.has("grid-lod") && options.quadrature.side().is_none() && !grooves {
            "--grid-lod is for the nodes of a grid: add --grid or --rule grid"
        } else if config.view == ViewChoice::Model && config.model.is_none() {
            "--camera model is for models: --scene FILE.glb or FILE.gltf"
        } else if config.view == ViewChoice::Model && self.has("distance") {
            "--distance is for views of a scene; --camera model has a position"
        } else if self.has("normal-y") && !self.has("normal-map") && !self.has("material") {
            "--normal-y is for a normal map: add --normal-map or --material"
        } else if config.follow_links && config.model.is_none() && !self.has("material") && !self.has("detail") {
            "--follow-links is for a folder: add --material or --detail, or draw a model"
        } else if config.heights_as_read
            && config.model.is_none()
            && !["height-map", "material", "detail"].iter().any(|map| self.has(map))
        {
            "--heights-as-read is for height maps: add --height-map, --material or --detail, or draw a model"
        } else if config.msaa > 1 && options.edge_samples > 1 {
            "--msaa and --edge-samples both antialias edges: use one of them"
        } else if is("pixel-kernel", "half-vector") && options.edge_samples > 1 {
            "--pixel-kernel half-vector has one sample of the geometry: remove --edge-samples"
        } else if config.msaa > 1 && config.picture.technique.is_reference() {
            "--msaa is for techniques that filter; the reference takes --samples"
        } else if is("multiscattering", "on") && self.has("diffuse-model") && !is("diffuse-model", "multiscattering") {
            "--multiscattering on is --diffuse-model multiscattering: remove one of them"
        } else if !self.may_have_cones() && CONE_FLAGS.iter().any(|flag| self.has(flag)) {
            "--cone-occluders, --cone-edge, --cone-axis and --cone-lobe are for occlusion cones: add --cone-map or --material, or --cones \
             for a model"
        } else if config.material.folder.as_deref().is_some_and(Path::is_file)
            && ["anisotropy", "metal", "ior", "transmission"].iter().any(|flag| self.has(flag))
        {
            "--anisotropy, --metal, --ior and --transmission replace what the fit of --material has measured: remove one of them"
        } else if self.has("clear-coat") && !config.picture.technique.integrates() {
            "--clear-coat is for the techniques that integrate over slopes: use --technique leadr or reference"
        } else if self.has("transmission") && !config.picture.technique.integrates() {
            "--transmission is for the techniques that integrate over slopes: use --technique leadr or reference"
        } else if self.has("transmission") && self.has("metal") {
            "--transmission is for dielectrics: remove --metal"
        } else if self.has("attenuation") && config.material.thickness == 0.0 {
            "--attenuation is for a solid body: add --thickness"
        } else if !options.relief_shadows {
            return Ok(());
        } else if options.diffuse_model != DiffuseModel::Lambert {
            "--relief-shadows draws Lambertian bases only: remove --diffuse-model or --multiscattering"
        } else if matches!(options.shadowing, Shadowing::SmithSeparable | Shadowing::VGroove) {
            "--relief-shadows has Smith shadowing of the base: remove --shadowing"
        } else if is("sky-occlusion", "on") {
            "--relief-shadows already includes occlusion by large shapes: remove --sky-occlusion"
        } else if self.has("clear-coat") {
            "--relief-shadows draws no clear coat: remove one of them"
        } else if self.has("transmission") {
            "--relief-shadows draws opaque surfaces: remove --transmission"
        } else if self.has("detail") {
            "--relief-shadows needs displaced geometry, and --detail is shading only: remove one of them"
        // On the sphere, the facets come from the maps, so `--anisotropy` is allowed there.
        } else if config.scene.name == "plane"
            && config.material.anisotropy.is_some()
            && config.material.is_displaced(config.height_map.as_deref())
        {
            "--relief-shadows uses only the heights of the plane, and --anisotropy is finer: remove one of them"
        } else {
            return Ok(());
        };
        Err(fault.to_owned())
    }
}

impl fmt::Display for CommandLine {
    /// Formats the flags in shell syntax. A space precedes each flag.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.flags {
            write!(f, " {name}")?;
            let Some(value) = value.as_ref().map(|value| value.to_string_lossy()) else { continue };
            // Without `=`, a value with a leading minus sign could be parsed as a flag.
            let joint = if value.starts_with('-') { "=" } else { " " };
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_.,:/+=@%".contains(c);
            if !value.is_empty() && value.chars().all(plain) {
                write!(f, "{joint}{value}")?;
            } else {
                write!(f, "{joint}'{}'", value.replace('\'', r"'\''"))?;
            }
        }
        Ok(())
    }
}
