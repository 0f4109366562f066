//! Flags about the material of the plane and the sphere, beside its files.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::values::{not_negative, positive, share};
use leadr_reflectance::facets::metals::{METALS, Metal};
use leadr_scenes::config::{DetailFiles, MaterialFiles, NormalY};
use leadr_scenes::view::finite;

/// What is chosen about a material.
#[derive(Clone, Debug, Default, Args)]
pub struct DressArgs {
    /// Which way the green of the normal map goes, instead of what its name says or its slopes tell (plane, sphere)
    #[arg(long, value_name = "up|down")]
    pub normal_y: Option<Way>,
    /// A metal instead of the material's own colours and metalness (plane, sphere)
    #[arg(long, value_name = "NAME", value_parser = metals())]
    pub metal: Option<&'static str>,
    /// How much rougher the material is along one direction, 0 to 1: alpha along it is mixed towards 1 by the square. The
    /// direction is +x on the plane and goes around the poles of the sphere (plane, sphere)
    #[arg(long, value_name = "X", value_parser = share)]
    pub anisotropy: Option<f32>,
    /// From which that direction is turned counter-clockwise [default: 0]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = finite)]
    pub anisotropy_rotation: Option<f32>,
    /// A finer material that repeats over the surface: a folder as for --material, or a picture of heights, or one of normals whose
    /// name says so (plane, sphere). It shades and does not displace
    #[arg(long, value_name = "FOLDER|FILE")]
    pub detail: Option<PathBuf>,
    /// Times that it repeats within one repeat of the material [default: 8]
    #[arg(long, value_name = "N", value_parser = positive)]
    pub detail_repeat: Option<f32>,
    /// By which it is turned counter-clockwise [default: 0]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = finite)]
    pub detail_rotation: Option<f32>,
    /// Factor on its slopes [default: 1]
    #[arg(long, value_name = "X", value_parser = not_negative)]
    pub detail_height_scale: Option<f32>,
    /// Where it covers the material, white, over one repeat of the material; without a mask it is everywhere, and its colours vary
    /// those of the material
    #[arg(long, value_name = "FILE")]
    pub detail_mask: Option<PathBuf>,
}

/// Which way green goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Way {
    /// Up, as in OpenGL and glTF
    Up,
    /// Down, as in DirectX
    Down,
}

fn metals() -> impl TypedValueParser<Value = &'static str> {
    PossibleValuesParser::new(METALS.iter().map(|metal| PossibleValue::new(metal.name)))
        .try_map(|name| Metal::named(&name).map(|metal| metal.name).ok_or("no such metal"))
}

impl DressArgs {
    /// Its flags, and whether each is given.
    pub fn flags(&self) -> [(&'static str, bool); 9] {
        [
            ("--normal-y", self.normal_y.is_some()),
            ("--metal", self.metal.is_some()),
            ("--anisotropy", self.anisotropy.is_some()),
            ("--anisotropy-rotation", self.anisotropy_rotation.is_some()),
            ("--detail", self.detail.is_some()),
            ("--detail-repeat", self.detail_repeat.is_some()),
            ("--detail-rotation", self.detail_rotation.is_some()),
            ("--detail-height-scale", self.detail_height_scale.is_some()),
            ("--detail-mask", self.detail_mask.is_some()),
        ]
    }

    /// Refuses combinations that make no sense. `normals`: whether files that can hold normals are named.
    pub fn check(&self, normals: bool, relief_shadows: bool) -> Result<(), String> {
        if self.normal_y.is_some() && !normals {
            return Err("--normal-y is for a normal map: give --normal-map or --material".into());
        }
        if self.anisotropy_rotation.is_some() && self.anisotropy.is_none() {
            return Err("--anisotropy-rotation turns the direction of --anisotropy, which is not given".into());
        }
        let details = [
            ("--detail-repeat", self.detail_repeat.is_some()),
            ("--detail-rotation", self.detail_rotation.is_some()),
            ("--detail-height-scale", self.detail_height_scale.is_some()),
            ("--detail-mask", self.detail_mask.is_some()),
        ];
        if let Some((flag, _)) = details.iter().find(|(_, given)| *given)
            && self.detail.is_none()
        {
            return Err(format!("{flag} is about --detail, which is not given"));
        }
        if self.detail.is_some() && relief_shadows {
            return Err(
                "--relief-shadows knows only what displaces, and a --detail shades: leave one of them out".into()
            );
        }
        Ok(())
    }

    /// `files` with what is chosen here.
    pub fn files(&self, files: MaterialFiles) -> MaterialFiles {
        let default = DetailFiles::default();
        MaterialFiles {
            normal_y: self.normal_y.map(|way| match way {
                Way::Up => NormalY::Up,
                Way::Down => NormalY::Down,
            }),
            metal: self.metal,
            anisotropy: self.anisotropy,
            anisotropy_rotation: self.anisotropy_rotation.unwrap_or(0.0),
            detail: DetailFiles {
                detail: self.detail.clone(),
                detail_repeat: self.detail_repeat.unwrap_or(default.detail_repeat),
                detail_rotation: self.detail_rotation.unwrap_or(default.detail_rotation),
                detail_height_scale: self.detail_height_scale.unwrap_or(default.detail_height_scale),
                detail_mask: self.detail_mask.clone(),
            },
            ..files
        }
    }
}
