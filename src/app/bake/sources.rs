//! Which files are baked, from flags, names and folders; and reading them.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::args::BakeArgs;
use leadr_maps::bake::{DetailNormals, Inputs, Roughness};
use leadr_maps::derive::{SlopeFaults, Slopes};
use leadr_maps::material::{GreenAxis, Material, MaterialFolder, NormalMap, Role, RoughnessMeaning, role_of};
use leadr_maps::{load_height_map, load_raster};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;

/// The files that are baked.
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
    #[serde(skip)]
    channel: usize,
    #[serde(skip)]
    meaning: RoughnessMeaning,
    /// What was left aside, in a sentence each.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

/// What the name of a normal map says of its green.
fn green_of(role: Option<Role>) -> Option<GreenAxis> {
    match role {
        Some(Role::NormalUp) => Some(GreenAxis::Up),
        Some(Role::NormalDown) => Some(GreenAxis::Down),
        _ => None,
    }
}

/// What is wrong with the normals of a map, if anything is.
fn sentence(faults: &SlopeFaults) -> Option<String> {
    let SlopeFaults { broken, below_horizon, steep, not_unit } = *faults;
    let said = [
        (broken, "have no length and count as upright"),
        (below_horizon, "point into the surface and count as the steepest that are kept"),
        (steep, "are steeper than slopes of 8 and are cut there"),
        (not_unit, "are longer or shorter than 1 by a twentieth and more: their direction counts"),
    ];
    let said: Vec<String> =
        said.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} normals {what}")).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

impl Sources {
    /// Settles the files. `slopes_only`: the result has no place for roughness and colour.
    pub fn find(arguments: &BakeArgs, slopes_only: bool) -> Result<Self, AppError> {
        let mut found = Self::default();
        if let Some(input) = &arguments.input {
            if input.is_dir() {
                found.look_into(input, arguments.gloss_scale, slopes_only)?;
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
                return Err(AppError::Usage("--normal-y is for a normal map, and there is none".into()));
            }
            found.green = Some(way);
        }
        if arguments.height_scale.is_some() && found.height.is_none() {
            return Err(AppError::Usage("--height-scale is for heights, and there are none".into()));
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

    fn look_into(&mut self, folder: &Path, scale: Gloss, slopes_only: bool) -> Result<(), AppError> {
        let material = MaterialFolder::open(folder)?;
        self.remarks = material.remarks.iter().filter(|remark| remark.contains("tells no part")).cloned().collect();
        for (role, file) in material.pictures {
            let beside = matches!(role, Role::Color | Role::Roughness | Role::Gloss | Role::Packed);
            if beside && slopes_only {
                self.remarks.push(format!("{} is not baked: the layout has no place for it", file.display()));
                continue;
            }
            match role {
                Role::Height => self.height = Some(file),
                Role::Normal | Role::NormalUp | Role::NormalDown => {
                    (self.normal, self.green) = (Some(file), green_of(Some(role)));
                }
                Role::Color => self.color = Some(file),
                Role::Roughness => self.roughness = Some(file),
                Role::Gloss => {
                    (self.roughness, self.meaning) = (Some(file), RoughnessMeaning::Gloss(scale));
                }
                Role::Packed => (self.roughness, self.channel) = (Some(file), 1),
                Role::Metalness | Role::Occlusion | Role::Cones | Role::Opacity | Role::Emission => {
                    self.remarks.push(format!("{} is not baked: it has no part in slopes", file.display()));
                }
            }
        }
        if self.height.is_none() && self.normal.is_none() {
            let what = format!("'{}' holds neither a height map nor a normal map", folder.display());
            return Err(AppError::Failed(format!("{what}; name one like NAME_Displacement.png or NAME_NormalGL.png")));
        }
        Ok(())
    }

    /// The file that others must fit.
    pub fn main(&self) -> &Path {
        self.height.as_deref().or(self.normal.as_deref()).unwrap_or(Path::new(""))
    }

    /// Reads the files, and says what is wrong with their normals.
    pub fn load(&self, arguments: &BakeArgs, output: &Output) -> Result<Inputs, AppError> {
        let normals_of = |file: &Path, green| -> Result<NormalMap, AppError> {
            let mut material = Material::new("normals");
            material.set_normals(file, green)?;
            let normals = material.normal_map.expect("just read");
            let faults = Slopes::of_normal_map(&normals).map_err(|fault| fault.in_file(file))?.faults;
            if let Some(faults) = sentence(&faults) {
                output.say(&format!("{}: {faults}", file.display()));
            }
            Ok(normals)
        };
        let roughness_of = |file: &Path, channel, meaning| -> Result<Roughness, AppError> {
            Ok(Roughness { raster: load_raster(file)?, channel, meaning })
        };
        let mut inputs = Inputs {
            heights: self.height.as_deref().map(load_height_map).transpose()?,
            normals: self.normal.as_deref().map(|file| normals_of(file, self.green)).transpose()?,
            roughness: (self.roughness.as_deref().map(|file| roughness_of(file, self.channel, self.meaning)))
                .transpose()?,
            color: self.color.as_deref().map(load_raster).transpose()?,
            height_scale: arguments.height_scale,
            wrap: arguments.wrap,
            smoothness: arguments.smoothness.map(f64::from),
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
        Ok(inputs)
    }
}
