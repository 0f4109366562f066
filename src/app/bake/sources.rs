//! Selects the files to bake from flags, names and folders, and reads these files.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::args::BakeArgs;
use leadr_maps::bake::{DetailNormals, Inputs, Roughness};
use leadr_maps::derive::quantisation::{Quantisation, restore};
use leadr_maps::derive::{SlopeFaults, Slopes};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{
    GreenAxis, Material, MaterialFolder, MaterialPicture, NormalMap, Role, RoughnessMeaning, role_of,
};
use leadr_maps::shown::shown_path;
use leadr_maps::{load_color_raster, load_height_channel, load_height_map, load_raster};
use leadr_scenes::file_kind::{FileKind, IMAGE};
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;

/// The files to bake.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Sources {
    height: Option<PathBuf>,
    normal: Option<PathBuf>,
    roughness: Option<PathBuf>,
    color: Option<PathBuf>,
    detail: Option<PathBuf>,
    detail_gloss: Option<PathBuf>,
    #[serde(skip)]
    green: Option<GreenAxis>,
    /// The channel of the heights, if other channels have other roles.
    #[serde(skip)]
    height_channel: Option<usize>,
    #[serde(skip)]
    channel: usize,
    #[serde(skip)]
    meaning: RoughnessMeaning,
    /// Remarks about files that are not used, as one sentence each.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

/// The fault of `--normal-y` without normals.
pub(super) const NO_NORMALS: &str = "--normal-y needs a normal map: add --normal, or leave --normal-y out";

/// Returns the direction of the green channel that the name of a normal map suggests.
pub(super) fn green_of(role: Option<Role>) -> Option<GreenAxis> {
    match role {
        Some(Role::NormalUp) => Some(GreenAxis::Up),
        Some(Role::NormalDown) => Some(GreenAxis::Down),
        _ => None,
    }
}

/// Describes the invalid normals of a map, if there are any.
fn sentence(faults: &SlopeFaults) -> Option<String> {
    let SlopeFaults { broken, below_horizon, steep, not_unit } = *faults;
    let message = [
        (broken, "have no length and are replaced by (0, 0, 1)"),
        (below_horizon, "point into the surface and are replaced by slopes of 8"),
        (steep, "have slopes above 8 and are clamped to 8"),
        (not_unit, "differ from unit length by over 5 % and are normalised"),
    ];
    let message: Vec<String> =
        message.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} normals {what}")).collect();
    (!message.is_empty()).then(|| message.join("; "))
}

/// Checks that the file of each flag is of a kind that the flag takes.
pub(super) fn check_files(arguments: &BakeArgs) -> Result<(), AppError> {
    use FileKind::{Exr, Folder, Picture};
    let inputs: [(&str, &Option<PathBuf>, &[FileKind]); 7] = [
        ("leadr bake", &arguments.input, &[Folder, Picture, Exr]),
        ("--normal", &arguments.normal, IMAGE),
        ("--roughness", &arguments.roughness, IMAGE),
        ("--gloss", &arguments.gloss, IMAGE),
        ("--color", &arguments.color, IMAGE),
        ("--detail", &arguments.detail, IMAGE),
        ("--detail-gloss", &arguments.detail_gloss, IMAGE),
    ];
    for (flag, file, kinds) in inputs {
        file.iter().try_for_each(|file| FileKind::check(flag, file, kinds))?;
    }
    if arguments.follow_links && !arguments.input.as_ref().is_some_and(|input| input.is_dir()) {
        return Err(AppError::Usage("--follow-links is for a folder: give a material folder".into()));
    }
    Ok(())
}

impl Sources {
    /// Selects the files. With `slopes_only`, channels for roughness and colour are left out.
    pub fn find(arguments: &BakeArgs, slopes_only: bool) -> Result<Self, AppError> {
        check_files(arguments)?;
        let mut found = Self::default();
        if let Some(input) = &arguments.input {
            if input.is_dir() {
                found.look_into(input, arguments, slopes_only)?;
            } else {
                found.take_file(input, arguments.normal.is_some());
            }
        }
        if let Some(file) = &arguments.normal {
            (found.normal, found.green) = (Some(file.clone()), green_of(role_of(file)));
        }
        let roughness = arguments.roughness.as_ref().map(|file| (file, RoughnessMeaning::Perceptual));
        let gloss = arguments.gloss.as_ref().map(|file| (file, RoughnessMeaning::Gloss(arguments.gloss_scale)));
        if let Some((file, meaning)) = roughness.or(gloss) {
            (found.roughness, found.channel, found.meaning) = (Some(file.clone()), 0, meaning);
        }
        if let Some(file) = &arguments.color {
            found.color = Some(file.clone());
        }
        (found.detail, found.detail_gloss) = (arguments.detail.clone(), arguments.detail_gloss.clone());
        if let Some(way) = arguments.normal_y {
            if found.normal.is_none() {
                return Err(AppError::Usage(NO_NORMALS.into()));
            }
            found.green = Some(way);
        }
        if arguments.height_scale.is_some() && found.height.is_none() {
            return Err(AppError::Usage(
                "--height-scale needs heights: add a height map, or leave --height-scale out".into(),
            ));
        }
        if arguments.heights_as_read && found.height.is_none() {
            return Err(AppError::Usage(
                "--heights-as-read needs heights: add a height map, or leave --heights-as-read out".into(),
            ));
        }
        Ok(found)
    }

    fn take_file(&mut self, file: &Path, is_heights: bool) {
        let role = role_of(file);
        let normals = matches!(role, Some(Role::Normal | Role::NormalUp | Role::NormalDown));
        if normals && !is_heights {
            (self.normal, self.green) = (Some(file.to_path_buf()), green_of(role));
        } else {
            self.height = Some(file.to_path_buf());
        }
    }

    fn look_into(&mut self, folder: &Path, arguments: &BakeArgs, slopes_only: bool) -> Result<(), AppError> {
        let mut material = MaterialFolder::open(folder, OutsideLinks::followed(arguments.follow_links))?;
        for MaterialPicture { role, channel, file } in std::mem::take(&mut material.pictures) {
            let beside = matches!(role, Role::Color | Role::Roughness | Role::Gloss);
            if beside && slopes_only {
                material.leave_aside(file, "the layout has no channel for it");
                continue;
            }
            match role {
                Role::Height => (self.height, self.height_channel) = (Some(file), channel),
                Role::Normal | Role::NormalUp | Role::NormalDown => {
                    (self.normal, self.green) = (Some(file), green_of(Some(role)));
                }
                Role::Color => self.color = Some(file),
                Role::Roughness => (self.roughness, self.channel) = (Some(file), channel.unwrap_or(0)),
                Role::Gloss => {
                    (self.roughness, self.channel) = (Some(file), channel.unwrap_or(0));
                    self.meaning = RoughnessMeaning::Gloss(arguments.gloss_scale);
                }
                Role::Metalness | Role::Occlusion | Role::Cones | Role::Opacity | Role::Emission => {
                    material.leave_aside(file, "it does not affect slopes");
                }
            }
        }
        let used: Vec<PathBuf> = self.files().map(Path::to_path_buf).collect();
        material.aside.retain(|(file, _)| !used.contains(file));
        self.remarks.extend(material.remark());
        if self.height.is_none() && self.normal.is_none() {
            let what = format!("'{}' holds neither a height map nor a normal map", shown_path(folder));
            return Err(AppError::Failed(format!(
                "{what}: add one named like NAME_Displacement.png or NAME_NormalGL.png"
            )));
        }
        Ok(())
    }

    /// Returns all files to read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let Self { height, normal, roughness, color, detail, detail_gloss, .. } = self;
        [height, normal, roughness, color, detail, detail_gloss].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Returns the file that sets the size of all others: heights, else normals.
    pub fn main(&self) -> &Path {
        self.height.as_deref().or(self.normal.as_deref()).unwrap_or(Path::new(""))
    }

    /// Reads the files, restores coarse heights, and prints remarks about invalid normals.
    pub fn load(&self, arguments: &BakeArgs, output: &Output) -> Result<(Inputs, Option<Quantisation>), AppError> {
        let normals_of = |file: &Path, green| -> Result<NormalMap, AppError> {
            let mut material = Material::new("normals");
            material.set_normals(file, green)?;
            let normals = material.normal_map.expect("just read");
            let faults = Slopes::of_normal_map(&normals).map_err(|fault| fault.in_file(file))?.faults;
            if let Some(faults) = sentence(&faults) {
                output.say(&format!("{}: {faults}", shown_path(file)));
            }
            Ok(normals)
        };
        let roughness_of = |file: &Path, channel, meaning| -> Result<Roughness, AppError> {
            Ok(Roughness { raster: load_raster(file)?, channel, meaning })
        };
        let mut heights = (self.height.as_deref())
            .map(|file| match self.height_channel {
                Some(channel) => load_height_channel(file, channel),
                None => load_height_map(file),
            })
            .transpose()?;
        let coarse = heights.as_mut().filter(|_| !arguments.heights_as_read);
        let quantisation = coarse.and_then(|map| restore(map, arguments.wrap));
        let mut inputs = Inputs {
            heights,
            normals: self.normal.as_deref().map(|file| normals_of(file, self.green)).transpose()?,
            roughness: (self.roughness.as_deref().map(|file| roughness_of(file, self.channel, self.meaning)))
                .transpose()?,
            color: self.color.as_deref().map(load_color_raster).transpose()?,
            height_scale: arguments.height_scale,
            wrap: arguments.wrap,
            smoothness: arguments.smoothness.map(f64::from),
            occlusion_distance: arguments.occlusion_distance,
            gloss: arguments.gloss_scale,
            area: arguments.area,
            texels: arguments.texels,
            ..Inputs::default()
        };
        if let Some(file) = &self.detail {
            let meaning = RoughnessMeaning::Gloss(arguments.gloss_scale);
            inputs.detail = Some(DetailNormals {
                normals: normals_of(file, green_of(role_of(file)))?,
                roughness: self.detail_gloss.as_deref().map(|file| roughness_of(file, 0, meaning)).transpose()?,
                repeat: arguments.detail_repeat,
                blend: arguments.blend,
            });
        }
        if arguments.resample {
            inputs.resample().into_iter().for_each(|remark| output.say(&remark));
        }
        Ok((inputs, quantisation))
    }
}
