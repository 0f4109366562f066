//! Folders of material pictures, as downloaded. File names determine the role of each picture.

use std::cmp::Reverse;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::names::{self, Found, Meaning, Role};
use super::normals::{green_axis, packed_axes};
use super::{Encoding, GreenAxis, Input, Material, NormalMap, Opacity, Relief, RoughnessMeaning, Samples, Texture};
use crate::baked::is_baked;
use crate::folders::{OutsideLinks, matching};
use crate::limits::ImageBudget;
use crate::load::{load_color_raster, load_height_channel, load_height_map, load_raster};
use crate::shown::shown_path;
use crate::{HeightMap, ImageHeader, MapError, MapFault};
use leadr_reflectance::facets::gloss::Gloss;

const EXTENSIONS: &str = "png jpg jpeg exr tif tiff webp tga bmp pbm pgm ppm pnm ktx2 dds";
/// Extensions of pictures that are named, because they cannot be read.
const FOREIGN: &str = "psd psb jxl avif heic gif jp2 hdr pfm ktx basis svg xcf kra";

/// Maximum number of pictures that a remark names.
const MOST_NAMED: usize = 8;
/// Maximum number of pictures without a role that are counted.
const MOST_UNNAMED: usize = 20_000;

const NO_ROLE: &str = "its name matches no role of a material";

/// A picture of a material.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MaterialPicture {
    /// The role of the picture or of its channel.
    pub role: Role,
    /// The channel with the role, from 0 to 3, if other channels have other roles. For colour and normals, the first of three
    /// channels.
    pub channel: Option<usize>,
    /// The path of the picture.
    pub file: PathBuf,
}

/// A material folder, with one picture for each role.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialFolder {
    /// The name of the folder.
    pub name: String,
    /// The pictures in the order of roles, at most one for each role.
    pub pictures: Vec<MaterialPicture>,
    /// The pictures that are not used, each with the reason.
    pub aside: Vec<(PathBuf, String)>,
}

/// A recognised name in a folder.
struct Named {
    found: Found,
    /// The words before the role.
    base: String,
    /// The number of pictures with the same words before the role.
    siblings: usize,
}

/// A picture that may have a role.
struct Candidate {
    picture: MaterialPicture,
    /// Whether the file may be opened.
    is_inside: bool,
    /// The number of pictures with the same words before the role.
    siblings: usize,
    /// The words before the role.
    base: String,
    /// The position of the word for the role in the table, where earlier words are preferred.
    rank: [usize; 2],
}

impl MaterialFolder {
    /// Reads the file names of a folder. Pictures behind links are treated by `links`. If several pictures have one role, the
    /// picture with more bits per sample is used, then a lossless one, then the larger one.
    ///
    /// # Errors
    /// Fails if the folder is missing or unreadable, pictures of two materials have the same role, no picture has a role, or a
    /// picture is behind a link out of the folder.
    pub fn open(folder: impl AsRef<Path>, links: OutsideLinks) -> Result<Self, MapError> {
        let folder = folder.as_ref();
        Self::find(folder, links).map_err(|fault| fault.in_file(folder))
    }

    fn find(folder: &Path, links: OutsideLinks) -> Result<Self, MapFault> {
        let mut aside: Vec<(PathBuf, String)> = Vec::new();
        let mut unnamed = Vec::new();
        let files = matching(folder, |file| {
            let has = |list| has_extension(file, list);
            if has(FOREIGN) && aside.len() < MOST_UNNAMED {
                aside.push((file.to_path_buf(), "its format is not supported".to_owned()));
            }
            let words = names::words_of(file);
            let is_named = names::at_end(&words, 0, true).or_else(|| names::joined(file)).is_some()
                || names::anywhere(&words, 0).is_some();
            if has(EXTENSIONS) && !is_named && unnamed.len() < MOST_UNNAMED {
                unnamed.push(file.to_path_buf());
            }
            has(EXTENSIONS) && is_named
        })?;
        aside.sort();
        let mut candidates = Vec::new();
        let check = |file: &Path| links.check(folder, Path::new(file.file_name().unwrap_or_default()));
        for (file, named) in roles(files) {
            // A file behind a link out of the folder is not opened.
            let is_inside = check(&file).is_ok();
            if is_inside && has_extension(&file, "ktx2 exr") && is_baked(&file).unwrap_or(false) {
                aside.push((file, "a map of leadr bake".to_owned()));
                continue;
            }
            let Some(Named { found: Found { meaning, rank, .. }, base, siblings }) = named else {
                unnamed.push(file);
                continue;
            };
            let candidate = |role, channel, file| {
                let picture = MaterialPicture { role, channel, file };
                Candidate { picture, is_inside, siblings, base: base.clone(), rank }
            };
            match meaning {
                Meaning::Aside(why) => aside.push((file, why.to_owned())),
                Meaning::Whole(role) => candidates.push(candidate(role, None, file)),
                Meaning::Packed(mut packed) => {
                    let header = is_inside.then(|| ImageHeader::of_file(&file).ok()).flatten();
                    let channels = header.map_or(4, |(header, _)| header.channels);
                    if channels < 3 && matches!(packed[0], Some(Role::Normal | Role::NormalUp | Role::NormalDown)) {
                        // A grey picture of a material that is named like a normal map.
                        packed = [packed[3], None, None, None];
                    }
                    let roles = packed.into_iter().enumerate().filter(|&(channel, _)| has_channel(channels, channel));
                    let roles = roles.filter_map(|(channel, role)| Some((channel, role?)));
                    candidates.extend(roles.map(|(channel, role)| candidate(role, Some(channel), file.clone())));
                }
            }
        }
        unnamed.sort();
        let mut this = Self { name: name_of(folder), pictures: Vec::new(), aside };
        this.choose(candidates)?;
        this.aside.extend(unnamed.into_iter().map(|file| (file, NO_ROLE.to_owned())));
        if this.pictures.is_empty() {
            let remedy = "name them NAME_Color.png, NAME_NormalGL.png, NAME_Roughness.png, NAME_Displacement.png";
            return Err(MapFault::unsupported("no picture in it has the name of a material role", remedy));
        }
        this.pictures.iter().try_for_each(|picture| check(&picture.file))?;
        Ok(this)
    }

    /// Chooses one picture for each role. If several pictures contain the same information, keeps only the most specific one.
    fn choose(&mut self, candidates: Vec<Candidate>) -> Result<(), MapFault> {
        let files: Vec<PathBuf> = candidates.iter().map(|candidate| candidate.picture.file.clone()).collect();
        let mut of_role: BTreeMap<Role, Vec<Candidate>> = BTreeMap::new();
        for candidate in candidates {
            of_role.entry(candidate.picture.role).or_default().push(candidate);
        }
        let mut reasons: HashMap<PathBuf, String> = HashMap::new();
        for (role, mut all) in of_role {
            if all.len() > 1 {
                let key = |c: &Candidate| {
                    let quality = c.is_inside.then(|| quality(&c.picture.file));
                    let (bytes, lossless, texels) = quality.unwrap_or_default();
                    let first = Reverse((c.siblings, c.picture.channel.is_none(), bytes));
                    (first, c.rank[0], Reverse((lossless, texels)), c.rank[1], c.picture.clone())
                };
                all.sort_by_cached_key(key);
                let [first, second, ..] = &all[..] else { unreachable!("more than one") };
                let is_other = !first.base.starts_with(&second.base) && !second.base.starts_with(&first.base);
                if is_other && first.siblings == second.siblings {
                    let [a, b] = [first, second].map(|candidate| name_of(&candidate.picture.file));
                    let what = format!("{a} and {b} are both {}, of two materials", role.name());
                    return Err(MapFault::unsupported(what, "keep the pictures of one material in the folder"));
                }
            }
            let mut all = all.into_iter().map(|candidate| candidate.picture);
            let Some(kept) = all.next() else { continue };
            for other in all {
                reasons.insert(other.file, format!("{} is used for {}", name_of(&kept.file), role.name()));
            }
            self.pictures.push(kept);
        }
        self.pictures.sort();
        use Role::{Gloss, Height, Normal, NormalDown, NormalUp, Occlusion, Roughness};
        for (kept, other) in [
            (NormalUp, NormalDown),
            (NormalUp, Normal),
            (NormalDown, Normal),
            (Roughness, Gloss),
            // Occlusion is computed from the heights, and must not be applied twice.
            (Height, Occlusion),
        ] {
            let Some(kept) = self.picture(kept).map(name_of) else { continue };
            if let Some(at) = self.pictures.iter().position(|picture| picture.role == other) {
                let why = match other {
                    Occlusion => "occlusion is computed from the heights".to_owned(),
                    _ => format!("{kept} is used instead"),
                };
                reasons.insert(self.pictures.remove(at).file, why);
            }
        }
        for file in files {
            if !self.pictures.iter().any(|picture| picture.file == file)
                && let Some(why) = reasons.remove(&file)
            {
                self.aside.push((file, why));
            }
        }
        Ok(())
    }

    /// Returns the picture with a role.
    pub fn picture(&self, role: Role) -> Option<&Path> {
        self.pictures.iter().find(|picture| picture.role == role).map(|picture| picture.file.as_path())
    }

    /// Notes that a picture is not used, for a reason. A file is noted once.
    pub fn leave_aside(&mut self, file: PathBuf, why: &str) {
        if !self.aside.iter().any(|(other, _)| *other == file) {
            self.aside.push((file, why.to_owned()));
        }
    }

    /// Returns one line about the pictures that are not used, if there are any.
    pub fn remark(&self) -> Option<String> {
        let named: Vec<String> =
            self.aside.iter().take(MOST_NAMED).map(|(file, why)| format!("{} ({why})", name_of(file))).collect();
        let more = self.aside.len() - named.len();
        let more = if more > 0 { format!(", and {more} more pictures") } else { String::new() };
        (!named.is_empty()).then(|| format!("{}: not used: {}{more}", self.name, named.join(", ")))
    }

    /// Reads the pictures.
    ///
    /// # Errors
    /// Fails if a picture is damaged, too large or of the wrong kind, or if all pictures together are too large.
    pub fn load(&self) -> Result<Material, MapError> {
        let budget = ImageBudget::default();
        let mut packed: HashMap<&Path, Option<Texture>> = HashMap::new();
        for MaterialPicture { file, channel, .. } in &self.pictures {
            if packed.contains_key(file.as_path()) {
                continue;
            }
            // Loading reports damaged files.
            if let Ok((header, _)) = ImageHeader::of_file(file) {
                budget.take(header.decoded_bytes()).map_err(|fault| fault.in_file(file))?;
            }
            if channel.is_some() {
                packed.insert(file, None);
            }
        }
        let mut material = Material::new(&self.name);
        for MaterialPicture { role, channel, file } in &self.pictures {
            // Pictures of several roles are read once.
            let shared = match packed.get_mut(file.as_path()) {
                Some(slot) if !matches!(role, Role::Height) => {
                    if slot.is_none() {
                        *slot = Some(texture(file, Encoding::Linear)?);
                    }
                    slot.clone()
                }
                _ => None,
            };
            let numbers = || match &shared {
                Some(texture) => Ok(Input::texture(texture.clone(), channel.unwrap_or(0))),
                None => numbers(file),
            };
            match role {
                Role::Color => material.set_colors(file)?,
                Role::Roughness | Role::Gloss => material.set_roughness_input(numbers()?, *role == Role::Gloss),
                Role::Metalness => material.metalness = numbers()?,
                Role::NormalUp => material.set_normals(file, Some(GreenAxis::Up))?,
                Role::NormalDown => material.set_normals(file, Some(GreenAxis::Down))?,
                Role::Normal => material.set_normals(file, None)?,
                Role::Height => match channel {
                    Some(channel) => material.set_relief(load_height_channel(file, *channel)?),
                    None => material.set_heights(file)?,
                },
                Role::Occlusion => material.occlusion = numbers()?,
                Role::Cones => material.set_cones(file)?,
                Role::Opacity => {
                    let mask = numbers()?;
                    // Exporters write an alpha channel of ones for opaque materials.
                    if channel.is_none() || !is_one(&mask) {
                        material.opacity = Opacity::Mask { mask, cutoff: 0.5 };
                    }
                }
                Role::Emission => material.emission = Input::colors(texture(file, Encoding::Srgb)?),
            }
        }
        Ok(material)
    }
}

fn is_one(mask: &Input<f32>) -> bool {
    let Some(texture) = &mask.texture else { return true };
    let [width, height] = texture.raster.size();
    (0..height).all(|y| (0..width).all(|x| texture.raster.value(x, y, mask.channel) == 1.0))
}

fn has_extension(file: &Path, list: &str) -> bool {
    let extension = file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    extension.is_some_and(|extension| list.split_ascii_whitespace().any(|known| known == extension))
}

/// Whether a picture of `channels` channels has the channel: red, green, blue or alpha.
fn has_channel(channels: usize, channel: usize) -> bool {
    match channel {
        0 => true,
        3 => channels.is_multiple_of(2),
        _ => channels >= 3,
    }
}

/// The quality of a picture: bytes per sample, whether it is lossless, and the number of texels.
fn quality(file: &Path) -> (u64, bool, u64) {
    let Ok((header, _)) = ImageHeader::of_file(file) else { return (0, false, 0) };
    (header.sample_bytes, !has_extension(file, "jpg jpeg webp"), header.texels())
}

/// Finds the role of each file in a folder, the words before the role, and the number of files with these words. A name
/// without words after those that all files share has no role: it is a preview.
fn roles(files: Vec<PathBuf>) -> Vec<(PathBuf, Option<Named>)> {
    let words: Vec<Vec<String>> = files.iter().map(|file| names::words_of(file)).collect();
    let is_letter_n = |words: &Vec<String>| {
        names::has_letters(words) || words.len() > 1 && words[names::without_skipped(words).max(1) - 1] == "n"
    };
    let letters = words.iter().any(is_letter_n);
    let found: Vec<Option<Found>> = words.iter().map(|words| names::at_end(words, 0, letters)).collect();
    // The number of files by the words before their role.
    let mut bases: HashMap<Vec<&str>, usize> = HashMap::new();
    for (words, found) in words.iter().zip(&found) {
        if let Some(found) = found {
            *bases.entry(names::base_of(&words[..found.base])).or_default() += 1;
        }
    }
    // The number of files whose base begins with the words.
    let mut starts: HashMap<Vec<&str>, usize> = HashMap::new();
    for (base, count) in &bases {
        (1..=base.len()).for_each(|end| *starts.entry(base[..end].to_vec()).or_default() += count);
    }
    let mut sorted: Vec<&Vec<String>> = words.iter().collect();
    sorted.sort();
    let shared = |words: &Vec<String>| {
        let common = |other: &&Vec<String>| words.iter().zip(*other).take_while(|(a, b)| a == b).count();
        let at = sorted.partition_point(|other| *other < words);
        let beside = [at.checked_sub(1), (at + 1 < sorted.len()).then_some(at + 1)];
        beside.into_iter().flatten().map(|i| common(&sorted[i])).max().unwrap_or(0)
    };
    let role = |i: usize| -> Option<Named> {
        let all = &words[i];
        let bare = names::base_of(&all[..names::without_skipped(all)]);
        let as_base = starts.get(&bare).copied().unwrap_or(0);
        let found = match found[i] {
            Some(found) if as_base > bases[&names::base_of(&all[..found.base])] - 1 => return None,
            Some(found) => {
                // A word of the material does not belong to the role: `worn-metal_roughness` beside `worn-metal_color`.
                let count = |end: usize| bases.get(&names::base_of(&all[..end])).copied().unwrap_or(0);
                let longer = (found.base + 1..all.len()).rev().find(|&end| count(end) >= count(found.base));
                longer.and_then(|end| names::at_end(all, end, letters)).unwrap_or(found)
            }
            None if as_base > 0 => return None,
            None => names::joined(&files[i]).or_else(|| names::anywhere(all, shared(all)))?,
        };
        let base = names::base_of(all.get(..found.base).unwrap_or(all));
        let siblings = bases.get(&base).copied().unwrap_or(1);
        Some(Named { found, base: base.join(" "), siblings })
    };
    let roles: Vec<_> = (0..files.len()).map(role).collect();
    files.into_iter().zip(roles).collect()
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
        self.set_roughness_input(numbers(file)?, gloss);
        Ok(())
    }

    fn set_roughness_input(&mut self, roughness: Input<f32>, gloss: bool) {
        self.roughness = roughness;
        self.roughness_meaning =
            if gloss { RoughnessMeaning::Gloss(Gloss::Perceptual) } else { RoughnessMeaning::Perceptual };
    }

    /// Reads a normal map. `green` is the direction of its green channel; `None` detects the direction.
    ///
    /// # Errors
    /// Fails if the picture is damaged, too large or has one channel.
    pub fn set_normals(&mut self, file: &Path, green: Option<GreenAxis>) -> Result<(), MapError> {
        let mut texture = texture(file, Encoding::Linear)?;
        if let Some(axes) = packed_axes(&texture.raster) {
            texture.raster = Arc::new(texture.raster.selected(&axes));
        }
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
        self.set_relief(load_height_map(file)?);
        Ok(())
    }

    fn set_relief(&mut self, map: HeightMap) {
        let middle = map.mean();
        self.relief = Some(Relief { map, scale: None, in_widths: false, middle });
    }
}

fn numbers(file: &Path) -> Result<Input<f32>, MapError> {
    Ok(Input::texture(texture(file, Encoding::Linear)?, 0))
}

fn texture(file: &Path, encoding: Encoding) -> Result<Texture, MapError> {
    let raster = if encoding == Encoding::Srgb { load_color_raster(file) } else { load_raster(file) }?;
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

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|file| std::fs::write(folder.path().join(file), b"").unwrap());
        folder
    }

    fn open(files: &[&str]) -> Result<MaterialFolder, MapError> {
        MaterialFolder::open(folder(files).path(), OutsideLinks::Refused)
    }

    /// Returns the roles of a folder: `ROLE=FILE`, or `ROLE=FILE:CHANNEL`.
    fn found(folder: &MaterialFolder) -> Vec<String> {
        let one = |MaterialPicture { role, channel, file }: &MaterialPicture| {
            format!("{role:?}={}{}", name_of(file), channel.map_or(String::new(), |c| format!(":{c}")))
        };
        folder.pictures.iter().map(one).collect()
    }

    #[test]
    fn folders_of_the_libraries_and_engines() {
        type Names = &'static [&'static str];
        // The files of a folder, the roles that are found, and the files that are left aside.
        let cases: &[(&str, Names, Names, Names)] = &[
            (
                "ambientCG",
                &[
                    "Metal055A.png",
                    "Metal055A_1K-JPG_Color.jpg",
                    "Metal055A_1K-JPG_Displacement.jpg",
                    "Metal055A_1K-JPG_Metalness.jpg",
                    "Metal055A_1K-JPG_NormalDX.jpg",
                    "Metal055A_1K-JPG_NormalGL.jpg",
                    "Metal055A_1K-JPG_Roughness.jpg",
                ],
                &[
                    "Color=Metal055A_1K-JPG_Color.jpg",
                    "Roughness=Metal055A_1K-JPG_Roughness.jpg",
                    "Metalness=Metal055A_1K-JPG_Metalness.jpg",
                    "NormalUp=Metal055A_1K-JPG_NormalGL.jpg",
                    "Height=Metal055A_1K-JPG_Displacement.jpg",
                ],
                &["Metal055A.png", "Metal055A_1K-JPG_NormalDX.jpg"],
            ),
            (
                "Poly Haven",
                &[
                    "rough_wood_arm_1k.jpg",
                    "rough_wood_diff_1k.jpg",
                    "rough_wood_disp_1k.png",
                    "rough_wood_nor_gl_1k.exr",
                    "rough_wood_spec_1k.jpg",
                    "rough_wood_weird_1k.jpg",
                ],
                &[
                    "Color=rough_wood_diff_1k.jpg",
                    "Roughness=rough_wood_arm_1k.jpg:1",
                    "Metalness=rough_wood_arm_1k.jpg:2",
                    "NormalUp=rough_wood_nor_gl_1k.exr",
                    "Height=rough_wood_disp_1k.png",
                ],
                &["rough_wood_spec_1k.jpg", "rough_wood_weird_1k.jpg"],
            ),
            (
                "Megascans",
                &[
                    "vjhkdb_2K_AO.jpg",
                    "vjhkdb_2K_Albedo.jpg",
                    "vjhkdb_2K_Bump.jpg",
                    "vjhkdb_2K_Cavity.jpg",
                    "vjhkdb_2K_Displacement.exr",
                    "vjhkdb_2K_Gloss.jpg",
                    "vjhkdb_2K_Normal_LOD0.jpg",
                    "vjhkdb_2K_Roughness.jpg",
                    "vjhkdb_2K_Specular.jpg",
                    "vjhkdb_Preview.png",
                ],
                &[
                    "Color=vjhkdb_2K_Albedo.jpg",
                    "Roughness=vjhkdb_2K_Roughness.jpg",
                    "Normal=vjhkdb_2K_Normal_LOD0.jpg",
                    "Height=vjhkdb_2K_Displacement.exr",
                ],
                &[
                    "vjhkdb_2K_AO.jpg",
                    "vjhkdb_2K_Bump.jpg",
                    "vjhkdb_2K_Cavity.jpg",
                    "vjhkdb_2K_Gloss.jpg",
                    "vjhkdb_2K_Specular.jpg",
                    "vjhkdb_Preview.png",
                ],
            ),
            (
                "Poliigon",
                &[
                    "GroundDirt014_COL_VAR1_3K.jpg",
                    "GroundDirt014_COL_VAR2_3K.jpg",
                    "GroundDirt014_DISP16_3K.tif",
                    "GroundDirt014_GLOSS_3K.jpg",
                    "GroundDirt014_NRM_3K.png",
                    "GroundDirt014_REFL_3K.jpg",
                ],
                &[
                    "Color=GroundDirt014_COL_VAR1_3K.jpg",
                    "Gloss=GroundDirt014_GLOSS_3K.jpg",
                    "Normal=GroundDirt014_NRM_3K.png",
                    "Height=GroundDirt014_DISP16_3K.tif",
                ],
                &["GroundDirt014_COL_VAR2_3K.jpg", "GroundDirt014_REFL_3K.jpg"],
            ),
            (
                "FreePBR",
                &[
                    "worn-metal_albedo.png",
                    "worn-metal_ao.png",
                    "worn-metal_metallic.png",
                    "worn-metal_normal-dx.png",
                    "worn-metal_preview.jpg",
                    "worn-metal_roughness.png",
                ],
                &[
                    "Color=worn-metal_albedo.png",
                    "Roughness=worn-metal_roughness.png",
                    "Metalness=worn-metal_metallic.png",
                    "NormalDown=worn-metal_normal-dx.png",
                    "Occlusion=worn-metal_ao.png",
                ],
                &["worn-metal_preview.jpg"],
            ),
            (
                "textures.com",
                &["TexturesCom_Wall_1K_albedo.tif", "TexturesCom_Wall_1K_height.tif", "TexturesCom_Wall_1K_normal.tif"],
                &[
                    "Color=TexturesCom_Wall_1K_albedo.tif",
                    "Normal=TexturesCom_Wall_1K_normal.tif",
                    "Height=TexturesCom_Wall_1K_height.tif",
                ],
                &[],
            ),
            (
                "Substance",
                &[
                    "mat_Base_Color.png",
                    "mat_Emissive.png",
                    "mat_Height.png",
                    "mat_Metallic.png",
                    "mat_Mixed_AO.png",
                    "mat_Normal.png",
                    "mat_Normal_OpenGL.png",
                    "mat_Roughness.png",
                ],
                &[
                    "Color=mat_Base_Color.png",
                    "Roughness=mat_Roughness.png",
                    "Metalness=mat_Metallic.png",
                    "NormalUp=mat_Normal_OpenGL.png",
                    "Height=mat_Height.png",
                    "Emission=mat_Emissive.png",
                ],
                &["mat_Mixed_AO.png", "mat_Normal.png"],
            ),
            (
                "Unity URP",
                &["mat_AlbedoTransparency.png", "mat_MetallicSmoothness.png", "mat_Normal.png"],
                &[
                    "Color=mat_AlbedoTransparency.png:0",
                    "Gloss=mat_MetallicSmoothness.png:3",
                    "Metalness=mat_MetallicSmoothness.png:0",
                    "Normal=mat_Normal.png",
                    "Opacity=mat_AlbedoTransparency.png:3",
                ],
                &[],
            ),
            (
                "Unity HDRP",
                &["mat_BaseMap.png", "mat_MaskMap.png", "mat_Normal.png"],
                &[
                    "Color=mat_BaseMap.png",
                    "Gloss=mat_MaskMap.png:3",
                    "Metalness=mat_MaskMap.png:0",
                    "Normal=mat_Normal.png",
                    "Occlusion=mat_MaskMap.png:1",
                ],
                &[],
            ),
            (
                "Unreal",
                &["T_Rock_BC.png", "T_Rock_N.png", "T_Rock_ORM.png", "T_Rock_S.png"],
                &[
                    "Color=T_Rock_BC.png",
                    "Roughness=T_Rock_ORM.png:1",
                    "Metalness=T_Rock_ORM.png:2",
                    "Normal=T_Rock_N.png",
                    "Occlusion=T_Rock_ORM.png:0",
                ],
                &["T_Rock_S.png"],
            ),
            (
                "Unreal's Megascans",
                &["T_Cliff_2K_D.png", "T_Cliff_2K_N.png", "T_Cliff_2K_ORDp.png"],
                &[
                    "Color=T_Cliff_2K_D.png",
                    "Roughness=T_Cliff_2K_ORDp.png:1",
                    "Normal=T_Cliff_2K_N.png",
                    "Height=T_Cliff_2K_ORDp.png:2",
                ],
                &[],
            ),
            (
                "glTF",
                &["mat_baseColor.png", "mat_normal.png", "mat_occlusionRoughnessMetallic.png"],
                &[
                    "Color=mat_baseColor.png",
                    "Roughness=mat_occlusionRoughnessMetallic.png:1",
                    "Metalness=mat_occlusionRoughnessMetallic.png:2",
                    "Normal=mat_normal.png",
                    "Occlusion=mat_occlusionRoughnessMetallic.png:0",
                ],
                &[],
            ),
            (
                "upper case and AO_R_M",
                &["MAT_AO_R_M.PNG", "MAT_COLOR.PNG", "MAT_DISP.PNG", "MAT_NRM.PNG", "MAT_OCC.PNG", "MAT_SPEC.PNG"],
                &[
                    "Color=MAT_COLOR.PNG",
                    "Roughness=MAT_AO_R_M.PNG:1",
                    "Metalness=MAT_AO_R_M.PNG:2",
                    "Normal=MAT_NRM.PNG",
                    "Height=MAT_DISP.PNG",
                ],
                &["MAT_OCC.PNG", "MAT_SPEC.PNG"],
            ),
            (
                "roughness in the alpha of normals",
                &["wall_color.png", "wall_normal_roughness.png", "wall_vector_displacement.exr", "wall_thumb.webp"],
                &[
                    "Color=wall_color.png",
                    "Roughness=wall_normal_roughness.png:3",
                    "Normal=wall_normal_roughness.png:0",
                ],
                &["wall_thumb.webp", "wall_vector_displacement.exr"],
            ),
            (
                "names without separators",
                &["RockDiffuse.png", "RockNormalGL.png", "RockHeight.psd", "Rock Bump 8bit.png", "Rock.png"],
                &["Color=RockDiffuse.png", "NormalUp=RockNormalGL.png", "Height=Rock Bump 8bit.png"],
                &["Rock.png", "RockHeight.psd"],
            ),
            (
                "a material named like a map",
                &["brick_normal.png", "brick_normal_ao.png", "brick_albedo_2k_srgb_v2.png", "brick_nor_8k_gl.png"],
                &["Color=brick_albedo_2k_srgb_v2.png", "NormalUp=brick_nor_8k_gl.png", "Occlusion=brick_normal_ao.png"],
                &["brick_normal.png"],
            ),
        ];
        for (name, files, roles, aside) in cases {
            let folder = open(files).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(found(&folder), *roles, "{name}");
            let mut left: Vec<String> = folder.aside.iter().map(|(file, _)| name_of(file)).collect();
            left.sort();
            assert_eq!(left, *aside, "{name}");
            let remark = folder.remark().unwrap_or_default();
            assert!(aside.iter().all(|file| remark.contains(file)) && !remark.contains('\n'), "{name}: {remark}");
        }
    }

    #[test]
    fn the_best_picture_of_a_role_is_used() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str, image: image::DynamicImage| image.save(folder.path().join(name)).unwrap();
        let (grey, fine) = (image::GrayImage::new(4, 4), image::ImageBuffer::from_pixel(2, 2, image::Luma([9u16])));
        save("a_Bump.png", grey.clone().into());
        save("a_Displacement.jpg", grey.clone().into());
        let height = || {
            let folder = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap();
            (name_of(folder.picture(Role::Height).unwrap()), folder.remark().unwrap())
        };
        let (kept, remark) = height();
        assert_eq!(kept, "a_Displacement.jpg");
        assert!(remark.contains("not used: a_Bump.png (a_Displacement.jpg is used for heights)"), "{remark}");
        save("a_height_4k.png", grey.into());
        assert_eq!(height().0, "a_height_4k.png");
        save("a_Displacement16.png", fine.into());
        assert_eq!(height().0, "a_Displacement16.png");
    }

    #[test]
    fn baked_maps_in_the_folder_are_left_aside() {
        use crate::bake::{Inputs, Kind, Ktx2File, Layout, Plan, Precision, bake};
        let folder = tempfile::tempdir().unwrap();
        let heights = Some(HeightMap::new(2, 2, vec![0.0, 0.5, 1.0, 0.2]).unwrap());
        let inputs = Inputs { heights, ..Inputs::default() };
        let plan = Plan::new(&inputs, Kind::Height, Layout::Leadr, Precision::F32).unwrap();
        let mut file = std::fs::File::create(folder.path().join("a_height.ktx2")).unwrap();
        let mut target = Ktx2File::new(&mut file, &plan).unwrap();
        let report = bake(&inputs, &plan, &mut target, &|_| ()).unwrap();
        target.finish(&report).unwrap();
        image::GrayImage::new(2, 2).save(folder.path().join("a_height.png")).unwrap();
        let found = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap();
        assert_eq!(name_of(found.picture(Role::Height).unwrap()), "a_height.png");
        assert!(found.remark().unwrap().contains("a_height.ktx2 (a map of leadr bake)"), "{:?}", found.remark());
    }

    #[test]
    fn two_materials_in_a_folder_are_refused() {
        let error = open(&["a_Color.png", "b_Albedo.png"]).unwrap_err().to_string();
        assert!(error.contains("b_Albedo.png and a_Color.png are both colour, of two materials"), "{error}");
        let most = open(&["a_Color.png", "a_Roughness.png", "b_Albedo.png"]).unwrap();
        assert_eq!(found(&most), ["Color=a_Color.png", "Roughness=a_Roughness.png"]);
        let none = open(&["readme.txt", "1.png"]).unwrap_err().to_string();
        assert!(none.contains("NAME_Color.png"), "{none}");
        let missing = folder(&[]).path().join("nowhere");
        assert!(MaterialFolder::open(missing, OutsideLinks::Refused).is_err());
    }

    #[test]
    fn channels_of_packed_pictures_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str, image: image::DynamicImage| image.save(folder.path().join(name)).unwrap();
        save("m_MetallicSmoothness.png", image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 0, 0, 51])).into());
        save("m_AlbedoTransparency.png", image::RgbaImage::from_pixel(2, 2, image::Rgba([9, 9, 9, 255])).into());
        save("m_ORDp.png", image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([0, 0, x as u8 * 51])).into());
        let material = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap().load().unwrap();
        let value = |input: &Input<f32>| input.texture.as_ref().unwrap().raster.value(0, 0, input.channel);
        assert_eq!((value(&material.metalness), value(&material.roughness)), (1.0, 0.0));
        assert_eq!((material.opacity, material.roughness_meaning), (Opacity::Opaque, RoughnessMeaning::Perceptual));
        assert_eq!(material.relief.unwrap().map.texels, [0.0, 0.2]);
        std::fs::remove_file(folder.path().join("m_ORDp.png")).unwrap();
        let material = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap().load().unwrap();
        assert_eq!(material.roughness_meaning, RoughnessMeaning::Gloss(Gloss::Perceptual));
        assert!((value(&material.roughness) - 0.2).abs() < 1e-6);
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
        assert_eq!((found.pictures.len(), found.aside.len()), (1, crate::folders::MAX_MATCHES + 5));
        assert!(found.remark().unwrap().ends_with(", and 9997 more pictures"), "{:?}", found.remark());
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
