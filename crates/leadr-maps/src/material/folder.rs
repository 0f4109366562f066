//! Folders of material pictures, as downloaded. File names determine the role of each picture.

use std::path::{Path, PathBuf};

use super::normals::green_axis;
use super::{Encoding, GreenAxis, Input, Material, NormalMap, Opacity, Relief, RoughnessMeaning, Samples, Texture};
use crate::folders::{OutsideLinks, matching};
use crate::limits::ImageBudget;
use crate::load::{load_height_map, load_raster};
use crate::shown::shown_path;
use crate::{ImageHeader, MapError, MapFault};
use leadr_reflectance::facets::gloss::Gloss;

/// The role of a picture in a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Base colour.
    Color,
    /// Perceptual roughness.
    Roughness,
    /// Gloss, which is one minus perceptual roughness.
    Gloss,
    /// Metalness.
    Metalness,
    /// Occlusion in the red channel, roughness in green, and metalness in blue.
    Packed,
    /// Normals whose green channel points up (OpenGL).
    NormalUp,
    /// Normals whose green channel points down (DirectX).
    NormalDown,
    /// Normals whose green direction is unknown.
    Normal,
    /// Heights.
    Height,
    /// Ambient occlusion.
    Occlusion,
    /// Visibility cones.
    Cones,
    /// Alpha mask.
    Opacity,
    /// Emitted radiance.
    Emission,
}

/// The words in file names that indicate each role, in lower case and without separators.
const WORDS: &[(Role, &[&str])] = &[
    (Role::Color, &["color", "colour", "col", "albedo", "basecolor", "basecolour", "diffuse", "diff", "basemap"]),
    (Role::Roughness, &["roughness", "rough", "rgh"]),
    (Role::Gloss, &["gloss", "glossiness", "smoothness", "smooth"]),
    (Role::Metalness, &["metalness", "metallic", "metal", "metallness"]),
    (Role::Packed, &["arm", "orm", "aorm", "occlusionroughnessmetallic"]),
    (Role::NormalUp, &["normalgl", "norgl", "nrmgl", "normalopengl", "normgl"]),
    (Role::NormalDown, &["normaldx", "nordx", "nrmdx", "normaldirectx", "normdx"]),
    (Role::Normal, &["normal", "normals", "nor", "nrm", "norm", "normalmap"]),
    (Role::Height, &["displacement", "disp", "height", "heightmap", "bump"]),
    (Role::Occlusion, &["ambientocclusion", "occlusion", "ao", "occ"]),
    (Role::Cones, &["cones"]),
    (Role::Opacity, &["opacity", "alpha", "mask"]),
    (Role::Emission, &["emission", "emissive", "emit"]),
];

const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "exr"];

/// Maximum number of remarks about pictures without a role.
const MOST_REMARKS: usize = 20;

/// Returns the role of a file, which is given by the last recognised word in the file name.
pub fn role_of(file: &Path) -> Option<Role> {
    let stem = file.file_stem()?.to_string_lossy().to_ascii_lowercase();
    let words: Vec<&str> = stem.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let found = |word: &str| WORDS.iter().find(|(_, words)| words.contains(&word)).map(|(role, _)| *role);
    (0..words.len()).rev().find_map(|last| {
        // Word pairs come first: "nor_gl" before "nor".
        let pair = (last > 0).then(|| [words[last - 1], words[last]].concat());
        pair.and_then(|pair| found(&pair)).or_else(|| found(words[last]))
    })
}

/// A material folder, with one picture for each role.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialFolder {
    /// The name of the folder.
    pub name: String,
    /// The pictures in the order of roles, at most one for each role.
    pub pictures: Vec<(Role, PathBuf)>,
    /// One message for each ignored file.
    pub remarks: Vec<String>,
}

impl MaterialFolder {
    /// Reads the file names of a folder. Pictures behind links are treated by `links`.
    ///
    /// # Errors
    /// Fails if the folder is missing or unreadable, two pictures have the same role, no picture has a role, or a picture is
    /// behind a link out of the folder.
    pub fn open(folder: impl AsRef<Path>, links: OutsideLinks) -> Result<Self, MapError> {
        let folder = folder.as_ref();
        Self::find(folder, links).map_err(|fault| fault.in_file(folder))
    }

    fn find(folder: &Path, links: OutsideLinks) -> Result<Self, MapFault> {
        let is_picture = |file: &Path| {
            let extension = file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
            extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
        };
        let mut unnamed = Vec::new();
        let files = matching(folder, |file| {
            let named = role_of(file).is_some();
            if is_picture(file) && !named {
                unnamed.push(file.to_path_buf());
            }
            is_picture(file) && named
        })?;
        unnamed.sort();
        let unused =
            |file: &PathBuf| format!("{} is not used: its name matches no role of a material", shown_path(file));
        let mut remarks: Vec<String> = unnamed.iter().take(MOST_REMARKS).map(unused).collect();
        if let Some(more) = unnamed.len().checked_sub(MOST_REMARKS + 1) {
            remarks
                .push(format!("{} further pictures are not used: each name matches no role of a material", more + 1));
        }
        let mut pictures: Vec<(Role, PathBuf)> = Vec::new();
        for file in files {
            let Some(role) = role_of(&file) else { continue };
            if let Some((_, other)) = pictures.iter().find(|(taken, _)| *taken == role) {
                let what = format!("{} and {} are both {role:?}", name_of(other), name_of(&file));
                return Err(MapFault::unsupported(what, "keep one of them in the folder"));
            }
            pictures.push((role, file));
        }
        pictures.sort_by_key(|(role, _)| *role);
        let mut this = Self { name: name_of(folder), pictures, remarks };
        this.leave_aside();
        if this.pictures.is_empty() {
            let remedy = "name them NAME_Color.png, NAME_NormalGL.png, NAME_Roughness.png, NAME_Displacement.png";
            return Err(MapFault::unsupported("no picture in it has the name of a material role", remedy));
        }
        for (_, file) in &this.pictures {
            links.check(folder, Path::new(file.file_name().unwrap_or_default()))?;
        }
        Ok(this)
    }

    /// If several pictures contain the same information, keeps only the most specific one.
    fn leave_aside(&mut self) {
        use Role::{Gloss, Metalness, Normal, NormalDown, NormalUp, Packed, Roughness};
        for (kept, other) in [
            (NormalUp, NormalDown),
            (NormalUp, Normal),
            (NormalDown, Normal),
            (Roughness, Gloss),
            (Packed, Roughness),
            (Packed, Gloss),
            (Packed, Metalness),
        ] {
            if self.picture(kept).is_some()
                && let Some(at) = self.pictures.iter().position(|(role, _)| *role == other)
            {
                let (_, file) = self.pictures.remove(at);
                self.remarks.push(format!("{} is not used: {kept:?} replaces it", shown_path(file)));
            }
        }
        // Occlusion is also computed from the heights, and must not be applied twice.
        if let (Some(file), Some(_)) = (self.picture(Role::Occlusion), self.picture(Role::Height)) {
            self.remarks.push(format!("{} is not used: occlusion is computed from the heights", shown_path(file)));
        }
    }

    /// Returns the picture with a role.
    pub fn picture(&self, role: Role) -> Option<&Path> {
        self.pictures.iter().find(|(other, _)| *other == role).map(|(_, file)| file.as_path())
    }

    /// Reads the pictures.
    ///
    /// # Errors
    /// Fails if a picture is damaged, too large or of the wrong kind, or if all pictures together are too large.
    pub fn load(&self) -> Result<Material, MapError> {
        let budget = ImageBudget::default();
        for (_, file) in &self.pictures {
            // Loading reports damaged files.
            if let Ok((header, _)) = ImageHeader::of_file(file) {
                budget.take(header.decoded_bytes()).map_err(|fault| fault.in_file(file))?;
            }
        }
        let mut material = Material::new(&self.name);
        for (role, file) in &self.pictures {
            match role {
                Role::Color => material.set_colors(file)?,
                Role::Roughness | Role::Gloss => material.set_roughness(file, *role == Role::Gloss)?,
                Role::Metalness => material.metalness = numbers(file)?,
                Role::Packed => {
                    let packed = texture(file, Encoding::Linear)?;
                    material.roughness = Input::texture(packed.clone(), 1);
                    material.metalness = Input::texture(packed.clone(), 2);
                    if self.picture(Role::Height).is_none() && self.picture(Role::Occlusion).is_none() {
                        material.occlusion = Input::texture(packed, 0);
                    }
                }
                Role::NormalUp => material.set_normals(file, Some(GreenAxis::Up))?,
                Role::NormalDown => material.set_normals(file, Some(GreenAxis::Down))?,
                Role::Normal => material.set_normals(file, None)?,
                Role::Height => material.set_heights(file)?,
                Role::Occlusion if self.picture(Role::Height).is_some() => {}
                Role::Occlusion => material.set_occlusion(file)?,
                Role::Cones => material.set_cones(file)?,
                Role::Opacity => material.opacity = Opacity::Mask { mask: numbers(file)?, cutoff: 0.5 },
                Role::Emission => material.emission = Input::colors(texture(file, Encoding::Srgb)?),
            }
        }
        Ok(material)
    }
}

impl Material {
    /// Reads the base colour.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large or of the wrong kind.
    pub fn set_colors(&mut self, file: &Path) -> Result<(), MapError> {
        self.base_color = Input::colors(texture(file, Encoding::Srgb)?);
        Ok(())
    }

    /// Reads the roughness from a picture of perceptual roughness, or of gloss if `gloss` is set.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large or of the wrong kind.
    pub fn set_roughness(&mut self, file: &Path, gloss: bool) -> Result<(), MapError> {
        self.roughness = numbers(file)?;
        self.roughness_meaning =
            if gloss { RoughnessMeaning::Gloss(Gloss::Perceptual) } else { RoughnessMeaning::Perceptual };
        Ok(())
    }

    /// Reads a normal map. `green` is the direction of its green channel; `None` detects the direction.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large or has one channel.
    pub fn set_normals(&mut self, file: &Path, green: Option<GreenAxis>) -> Result<(), MapError> {
        let texture = texture(file, Encoding::Linear)?;
        if texture.raster.channels() == 1 {
            let what = "it is grey; normals need two or three channels";
            return Err(MapFault::unsupported(what, "if it holds heights, give it as a height map").in_file(file));
        }
        let green = green.unwrap_or_else(|| green_axis(&texture.raster));
        self.normal_map = Some(NormalMap { texture, green, scale: 1.0 });
        Ok(())
    }

    /// Reads the ambient occlusion, which is the visible fraction of the hemisphere.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large or of the wrong kind.
    pub fn set_occlusion(&mut self, file: &Path) -> Result<(), MapError> {
        self.occlusion = numbers(file)?;
        Ok(())
    }

    /// Reads visibility cones from a picture that `leadr bake --kind cones` wrote.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large, or does not have four channels.
    pub fn set_cones(&mut self, file: &Path) -> Result<(), MapError> {
        let texture = texture(file, Encoding::Linear)?;
        if texture.raster.channels() != 4 {
            let what = "cones need four channels: a direction and the visible share of the surroundings";
            let remedy = "make them with leadr bake --kind cones -o NAME_Cones.png";
            return Err(MapFault::unsupported(what, remedy).in_file(file));
        }
        self.cones = Some(texture);
        Ok(())
    }

    /// Reads heights whose unit is unknown.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large or of the wrong kind.
    pub fn set_heights(&mut self, file: &Path) -> Result<(), MapError> {
        let map = load_height_map(file)?;
        let middle = map.mean();
        self.relief = Some(Relief { map, scale: None, in_widths: false, middle });
        Ok(())
    }
}

fn numbers(file: &Path) -> Result<Input<f32>, MapError> {
    Ok(Input::texture(texture(file, Encoding::Linear)?, 0))
}

fn texture(file: &Path, encoding: Encoding) -> Result<Texture, MapError> {
    let raster = load_raster(file)?;
    // Floats are always linear.
    let encoding = if matches!(raster.samples(), Samples::F32(_)) { Encoding::Linear } else { encoding };
    Ok(Texture::new(raster, shown_path(file), encoding))
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| shown_path(path), shown_path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_as_libraries_spell_them() {
        for (name, role) in [
            ("Rock003_1K-PNG_Color.png", Some(Role::Color)),
            ("Rock003_1K-PNG_NormalGL.png", Some(Role::NormalUp)),
            ("Rock003_1K-PNG_NormalDX.png", Some(Role::NormalDown)),
            ("Rock003_1K-PNG_Displacement.png", Some(Role::Height)),
            ("rock_wall_nor_gl_2k.exr", Some(Role::NormalUp)),
            ("rock_wall_nor_dx_2k.png", Some(Role::NormalDown)),
            ("rock_wall_diff_2k.jpg", Some(Role::Color)),
            ("rock_wall_arm_2k.jpg", Some(Role::Packed)),
            ("metal_plate_rough_1k.png", Some(Role::Roughness)),
            ("Metal Plate Base_Color.png", Some(Role::Color)),
            ("brushed-metal-ao.png", Some(Role::Occlusion)),
            ("wood_Glossiness.png", Some(Role::Gloss)),
            ("color_ramp_height.png", Some(Role::Height)),
            ("preview.png", None),
            (".png", None),
        ] {
            assert_eq!(role_of(Path::new(name)), role, "{name}");
        }
    }

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|file| std::fs::write(folder.path().join(file), b"").unwrap());
        folder
    }

    #[test]
    fn each_role_takes_one_image() {
        let both = folder(&["a_NormalGL.png", "a_NormalDX.png", "a_Roughness.png", "a_preview.png", "notes.txt"]);
        let found = MaterialFolder::open(both.path(), OutsideLinks::Refused).unwrap();
        assert_eq!(found.pictures.iter().map(|p| p.0).collect::<Vec<_>>(), [Role::Roughness, Role::NormalUp]);
        assert_eq!(found.remarks.len(), 2, "{:?}", found.remarks);
        let twice = folder(&["a_Color.png", "b_Albedo.png"]);
        let error = MaterialFolder::open(twice.path(), OutsideLinks::Refused).unwrap_err().to_string();
        assert!(error.contains("a_Color.png and b_Albedo.png are both Color"), "{error}");
        let none = folder(&["readme.txt", "1.png"]);
        assert!(
            MaterialFolder::open(none.path(), OutsideLinks::Refused)
                .unwrap_err()
                .to_string()
                .contains("NAME_Color.png")
        );
        assert!(MaterialFolder::open(none.path().join("nowhere"), OutsideLinks::Refused).is_err());
    }

    #[test]
    fn non_images_are_reported() {
        let empty = folder(&["a_Color.png"]);
        let error = MaterialFolder::open(empty.path(), OutsideLinks::Refused).unwrap().load().unwrap_err().to_string();
        assert!(error.contains("a_Color.png: is not an image"), "{error}");
    }

    #[test]
    fn a_folder_becomes_a_material() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str, image: image::DynamicImage| image.save(folder.path().join(name)).unwrap();
        save("x_Color.png", image::RgbImage::from_pixel(4, 2, image::Rgb([255, 0, 0])).into());
        save("x_Roughness.jpg", image::GrayImage::from_pixel(8, 8, image::Luma([128])).into());
        save("x_Displacement.png", image::ImageBuffer::from_fn(2, 1, |x, _| image::Luma([x as u16 * 65535])).into());
        save("x_nrm.png", image::RgbImage::from_pixel(2, 2, image::Rgb([128, 128, 255])).into());
        let material = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap().load().unwrap();
        let color = material.base_color.texture.unwrap();
        assert_eq!((color.raster.width(), color.encoding), (4, Encoding::Srgb));
        let relief = material.relief.unwrap();
        assert_eq!((relief.map.texels, relief.middle, relief.scale), (vec![0.0, 1.0], 0.5, None));
        assert!((material.roughness.texture.unwrap().raster.value(3, 3, 0) - 0.5).abs() < 0.01);
        assert!(material.normal_map.is_some());
    }

    #[test]
    fn unnamed_files_hide_no_picture() {
        let crowded = tempfile::tempdir().unwrap();
        let add = |name: String| std::fs::write(crowded.path().join(name), b"").unwrap();
        (0..crate::folders::MAX_MATCHES + 5).for_each(|i| add(format!("{i:05}.png")));
        add("z_Color.png".to_owned());
        let found = MaterialFolder::open(crowded.path(), OutsideLinks::Refused).unwrap();
        assert_eq!((found.pictures.len(), found.remarks.len()), (1, MOST_REMARKS + 1));
        assert_eq!(
            found.remarks[MOST_REMARKS],
            "9985 further pictures are not used: each name matches no role of a material"
        );
    }

    #[cfg(unix)]
    #[test]
    fn pictures_behind_links_out_of_the_folder_are_refused() {
        let (folder, other) = (folder(&["a_Roughness.png"]), folder(&["secret.png"]));
        std::os::unix::fs::symlink(other.path().join("secret.png"), folder.path().join("a_Color.png")).unwrap();
        let error = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap_err().to_string();
        assert!(error.contains("the link \"a_Color.png\" leads out") && error.contains("--follow-links"), "{error}");
        assert_eq!(MaterialFolder::open(folder.path(), OutsideLinks::Followed).unwrap().pictures.len(), 2);
    }
}
