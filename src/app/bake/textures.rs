//! `leadr bake FOLDER --for ENGINE`: writes the textures of a material with filtered mip levels.

use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use super::args::{BakeArgs, ClassCount, TargetEngine};
use super::names_a_folder;
use super::sources::{NO_NORMALS, check_files, green_of};
use leadr_maps::Wrap;
use leadr_maps::bake::{Kind, Layout, Precision, Texels};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{Material, MaterialFolder, Role, role_of};
use leadr_maps::shown::{shown, shown_path};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::NormalArea;
use leadr_textures::engine::Engine;
use leadr_textures::material::filter_material;
use leadr_textures::model::FilteredTexture;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, keep_inputs};
use leadr_tools::command::output::Output;

/// Filters the textures of a folder, or of the files of flags, and prints what was written.
pub fn run(arguments: &BakeArgs, output: &Output) -> Result<(), AppError> {
    let start = Instant::now();
    refuse_map_flags(arguments, "textures of engines", &["--normal", "--normal-y", "--roughness", "--color"])?;
    if !names_a_folder(&arguments.output) {
        let what = format!(
            "'{}' must be a folder or end in /, because --for writes several textures",
            shown_path(&arguments.output)
        );
        return Err(AppError::Usage(what));
    }
    check_files(arguments)?;
    let (name, material, pictures) = material_of(arguments)?;
    let engine = engine_of(arguments);
    let source = arguments.input.as_ref().or(arguments.normal.as_ref()).or(arguments.color.as_ref());
    let fault = |fault| AppError::Failed(format!("{} {fault}", source.map_or_else(|| name.clone(), shown_path)));
    let share = output.share(Some("filtering textures"));
    let filtered =
        filter_material(&material, engine, &mut |done, all| share(done as f32 / all as f32)).map_err(fault)?;
    drop(share);
    for remark in &filtered.remarks {
        output.say(remark);
    }
    let target = |texture: &FilteredTexture| arguments.output.join(format!("{name}{}", texture.name));
    let files: Vec<PathBuf> = filtered.files.iter().map(|(texture, _)| target(texture)).collect();
    keep_inputs(files.iter().map(|path| &**path), pictures.iter().map(|path| &**path))?;
    // All files are opened first, so an unwritable folder is reported before any is replaced.
    let opened = files.iter().map(|path| begin(path)).collect::<Result<Vec<_>, _>>()?;
    for (file, (_, bytes)) in opened.into_iter().zip(&filtered.files) {
        file.write(bytes)?;
    }
    output.result(&TexturesReport {
        command: "bake",
        output: arguments.output.clone(),
        bytes: filtered.files.iter().map(|(texture, _)| texture.bytes).sum(),
        textures: filtered.files.iter().map(|(texture, _)| TextureReport::new(texture)).collect(),
        files,
        remarks: filtered.remarks,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns the beginning of the file names, the material of the folder or of the flags, and the pictures that it was read from.
fn material_of(arguments: &BakeArgs) -> Result<(String, Material, Vec<PathBuf>), AppError> {
    let flags = [&arguments.normal, &arguments.roughness, &arguments.color];
    let mut pictures: Vec<PathBuf> = flags.into_iter().flatten().cloned().collect();
    let first = arguments.input.as_ref().or(pictures.first());
    let name = first
        .and_then(|path| path.file_stem())
        .map_or_else(|| "material".into(), |name| name.to_string_lossy().into_owned());
    let mut material = Material::new(name.clone());
    let mut normals = arguments.normal.as_ref();
    match &arguments.input {
        Some(folder) if folder.is_dir() => {
            let folder = MaterialFolder::open(folder, OutsideLinks::followed(arguments.follow_links))?;
            folder.remark().iter().for_each(|remark| tracing::warn!("{remark}"));
            material = folder.load()?;
            pictures.extend(folder.pictures.into_iter().map(|picture| picture.file));
        }
        Some(file) if matches!(role_of(file), Some(Role::Normal | Role::NormalUp | Role::NormalDown)) => {
            normals = normals.or(Some(file));
            pictures.push(file.clone());
        }
        Some(file) => {
            let what = "--for takes a model, a material folder, a normal map, or --normal with --roughness and --color";
            return Err(AppError::Usage(format!("'{}' is none of these: {what}", shown_path(file))));
        }
        None => {}
    }
    if let Some(file) = &arguments.color {
        material.set_colors(file)?;
    }
    if let Some(file) = normals {
        material.set_normals(file, green_of(role_of(file)))?;
    }
    if let Some(file) = &arguments.roughness {
        material.set_roughness(file, false)?;
    }
    if let Some(way) = arguments.normal_y {
        let map = material.normal_map.as_mut().ok_or_else(|| AppError::Usage(NO_NORMALS.into()))?;
        map.green = way;
    }
    Ok((name, material, pictures))
}

/// Returns the engine of `--for`.
pub fn engine_of(arguments: &BakeArgs) -> Engine {
    match arguments.engine.unwrap_or_default() {
        TargetEngine::Gltf => Engine::Gltf,
        TargetEngine::Bevy => Engine::Bevy,
        TargetEngine::Godot => Engine::Godot,
        TargetEngine::Unity => Engine::Unity,
        TargetEngine::Unreal => Engine::Unreal,
    }
}

/// Refuses flags that say how maps of leadr are baked, except some.
pub fn refuse_map_flags(a: &BakeArgs, of: &str, except: &[&str]) -> Result<(), AppError> {
    for (flag, is_given) in [
        ("--normal", a.normal.is_some()),
        ("--roughness", a.roughness.is_some()),
        ("--gloss", a.gloss.is_some()),
        ("--gloss-scale", a.gloss_scale != Gloss::Perceptual),
        ("--color", a.color.is_some()),
        ("--height-scale", a.height_scale.is_some()),
        ("--heights-as-read", a.heights_as_read),
        ("--normal-y", a.normal_y.is_some()),
        ("--wrap", a.wrap != Wrap::Repeat),
        ("--kind", a.kind != [Kind::Leadr]),
        ("--detail", a.detail.is_some()),
        ("--area", a.area != NormalArea::Macro),
        ("--texels", a.texels != Texels::Facets),
        ("--smoothness", a.smoothness.is_some()),
        ("--occlusion-distance", a.occlusion_distance.is_some()),
        ("--classes", a.classes != ClassCount::Exactly(1)),
        ("--drop-levels", a.drop_levels > 0),
        ("--resample", a.resample),
        ("--format", a.format != Precision::F32),
        ("--layout", a.layout != Layout::Leadr),
    ] {
        if is_given && !except.contains(&flag) {
            return Err(AppError::Usage(format!("{flag} is for maps, not for {of}: leave it out")));
        }
    }
    Ok(())
}

/// The result for a material.
#[derive(Debug, Serialize)]
struct TexturesReport {
    command: &'static str,
    output: PathBuf,
    /// The files that were written.
    files: Vec<PathBuf>,
    textures: Vec<TextureReport>,
    /// What is missing or left out.
    remarks: Vec<String>,
    /// The size of all files together.
    bytes: u64,
    seconds: f64,
}

impl fmt::Display for TexturesReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.textures.iter().try_for_each(|texture| writeln!(f, "{texture}"))?;
        let (path, size) = (shown_path(&self.output), self.bytes.div_ceil(1024));
        write!(f, "wrote {} textures to {path}, {size} KiB in {:.1} s", self.files.len(), self.seconds)
    }
}

/// A texture in a result.
#[derive(Debug, Serialize)]
pub struct TextureReport {
    name: String,
    role: &'static str,
    /// The width and height of the finest level.
    size: [u32; 2],
    bytes: u64,
    /// The mean perceptual roughness of the finest and of the coarsest level; null for textures without roughness.
    roughness: Option<[f32; 2]>,
}

impl TextureReport {
    pub fn new(texture: &FilteredTexture) -> Self {
        let FilteredTexture { name, role, size, bytes, roughness } = texture;
        Self { name: shown(name), role, size: *size, bytes: *bytes, roughness: *roughness }
    }
}

impl fmt::Display for TextureReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, role, size: [width, height], bytes, roughness } = self;
        write!(f, "{role:<16}{width} x {height}, {} KiB: {name}", bytes.div_ceil(1024))?;
        match roughness {
            Some([near, far]) => write!(f, "; roughness {near:.2} near, {far:.2} at a distance"),
            None => Ok(()),
        }
    }
}
