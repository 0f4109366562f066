//! Roles of material pictures by their file names, in the conventions of texture libraries and engines.

use std::ops::Range;
use std::path::Path;

/// The role of a picture, or of a channel of a picture, in a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// Base colour.
    Color,
    /// Perceptual roughness.
    Roughness,
    /// Gloss, which is one minus perceptual roughness.
    Gloss,
    /// Metalness.
    Metalness,
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

impl Role {
    /// Returns the name of the role in messages.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Color => "colour",
            Self::Roughness => "roughness",
            Self::Gloss => "gloss",
            Self::Metalness => "metalness",
            Self::NormalUp => "OpenGL normals",
            Self::NormalDown => "DirectX normals",
            Self::Normal => "normals",
            Self::Height => "heights",
            Self::Occlusion => "occlusion",
            Self::Cones => "cones",
            Self::Opacity => "opacity",
            Self::Emission => "emission",
        }
    }
}

/// What the name of a picture declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// The whole picture has one role.
    Whole(Role),
    /// Each channel has its own role. The role in red covers green and blue for colour and normals.
    Packed([Option<Role>; 4]),
    /// The picture has no place in a material, for the reason.
    Aside(&'static str),
}

/// A recognised name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    pub meaning: Meaning,
    /// The number of words before the role.
    pub base: usize,
    /// The position of the list of words in the table, and of the word in the list. Earlier words are preferred.
    pub rank: [usize; 2],
}

const PREVIEW: &str = "a preview";
const SPECULAR: &str = "specular maps are not read from folders";
const NO_PLACE: &str = "the material has no place for it";

use Meaning::{Aside, Packed, Whole};
use Role::{
    Color, Cones, Emission, Gloss, Height, Metalness, Normal, NormalDown, NormalUp, Occlusion, Opacity, Roughness,
};

/// The words for each meaning, in lower case and without separators. Words of several parts are also recognised with
/// separators between the parts.
const WORDS: &[(Meaning, &str)] = &[
    (
        Whole(Color),
        "basecolor basecolour albedo color colour col diffuse diff diffusecolor diffusecolour dif alb basecol bcolor clr \
         basemap base",
    ),
    (Whole(Roughness), "roughness rough rgh perceptualroughness specularroughness"),
    (Whole(Gloss), "glossiness gloss smoothness smooth glossy gls smth reflectionglossiness reflectglossiness"),
    (Whole(Metalness), "metalness metallic metal metallness metallicness metalic mtl met"),
    (Whole(NormalUp), "normalgl norgl nrmgl normgl normalogl normalopengl nrmogl nrmopengl norogl noropengl"),
    (Whole(NormalDown), "normaldx nordx nrmdx normdx normaldirectx nrmdirectx nordirectx normald3d"),
    (
        Whole(Normal),
        "normal normals nor nrm norm nrml nml normaltangent tangentnormal normaltangentspace tangentspacenormal",
    ),
    (Whole(Height), "displacement disp displace heightmap height heights hgt dsp elevation heightfield parallax depth"),
    (Whole(Height), "bump bumpmap bmp"),
    (Whole(Occlusion), "ambientocclusion occlusion ao mixedao occ ambocc ambientocc occl"),
    (Whole(Cones), "cones"),
    (Whole(Opacity), "opacity alpha alphamask opacitymask cutout transparency opac mask"),
    (Whole(Emission), "emission emissive emissivecolor emit emis glow selfillumination selfillum illum"),
    (
        Packed([Some(Occlusion), Some(Roughness), Some(Metalness), None]),
        "orm arm aorm occlusionroughnessmetallic occlusionroughnessmetalness occlusionroughnessmetal aoroughnessmetallic \
         aoroughnessmetalness aoroughmetal aoroughmetallic ambientocclusionroughnessmetallic",
    ),
    (
        Packed([None, Some(Roughness), Some(Metalness), None]),
        "metallicroughness metalroughness metalnessroughness metalrough roughnessmetallic roughnessmetalness roughmetal",
    ),
    (Packed([Some(Roughness), Some(Metalness), Some(Occlusion), None]), "rma rmao roughnessmetallicao roughmetalao"),
    (Packed([Some(Metalness), Some(Roughness), Some(Occlusion), None]), "mra mrao metallicroughnessao metalroughao"),
    (Packed([Some(Roughness), Some(Occlusion), Some(Metalness), None]), "rom raom"),
    (
        Packed([Some(Occlusion), Some(Roughness), Some(Height), None]),
        "ordp ord orh aord occlusionroughnessdisplacement occlusionroughnessheight",
    ),
    (Packed([Some(Height), Some(Roughness), Some(Occlusion), None]), "dpra"),
    (Packed([Some(Height), Some(Roughness), None, None]), "dpr displacementroughness heightroughness"),
    (
        Packed([Some(Metalness), None, None, Some(Gloss)]),
        "metallicsmoothness metalsmoothness metalnesssmoothness metallicgloss metallicsmooth metalsmooth metallicglossiness",
    ),
    (
        Packed([None, None, None, Some(Gloss)]),
        "specularsmoothness specularglossiness speculargloss specsmoothness specgloss",
    ),
    (Packed([Some(Metalness), Some(Occlusion), None, Some(Gloss)]), "maskmap mads metallicaodetailsmoothness"),
    (
        Packed([Some(Color), None, None, Some(Opacity)]),
        "albedotransparency albedoopacity albedoalpha basecoloropacity basecoloralpha basecolortransparency coloropacity \
         coloralpha colortransparency diffusealpha diffuseopacity diffusetransparency basecolora",
    ),
    (
        Packed([Some(Color), None, None, Some(Roughness)]),
        "albedoroughness basecolorroughness colorroughness coloroughness",
    ),
    (Packed([Some(Color), None, None, Some(Gloss)]), "albedosmoothness basecolorsmoothness colorsmoothness"),
    (Packed([Some(Normal), None, None, Some(Roughness)]), "normalroughness normalrough nrmrough nrmr normalr"),
    (Packed([Some(Normal), None, None, Some(Gloss)]), "normalgloss normalsmoothness normalglossiness normalsmooth"),
    (
        Packed([Some(Normal), None, None, Some(Height)]),
        "normalheight normaldisplacement normalbump normaldisp nrmheight",
    ),
    (
        Aside(PREVIEW),
        "preview previews thumb thumbnail thumbnails render renders rendered sphere ball shaderball cube plane icon cover \
         sample swatch promo screenshot beauty turntable showcase contact",
    ),
    (
        Aside(SPECULAR),
        "specular specularity spec specularlevel speclevel specularcolor specularf0 refl reflection reflectivity reflect ior",
    ),
    (
        Aside(NO_PLACE),
        "cavity curvature curv convexity concavity thickness translucency translucent transmission transmissive sss \
         subsurface scattering scatter fuzz sheen sheencolor sheenroughness anisotropy aniso anisotropydirection clearcoat coat coatroughness \
         clearcoatroughness clearcoatnormal coatnormal position id idmap matid materialid colorid worldnormal normalworld \
         worldspacenormal wsn objectnormal normalobject objectspacenormal bentnormal bentnormals normalbent detail detailmap \
         detailmask microdetail edge edges edgewear dirt wear flow flowmap vectordisplacement displacementvector vdisp vdm \
         roughao aorough tint uv uvs wireframe lightmap",
    ),
];

/// Letters for a role at the end of a name, which count for names as in Unreal: `T_Rock_N`, or beside a picture `_N`.
const LETTERS: &[(Meaning, &str)] = &[
    (Whole(Color), "bc d c"),
    (Whole(Normal), "n nm"),
    (Whole(Roughness), "r"),
    (Whole(Height), "h dp b"),
    (Whole(Occlusion), "o"),
    (Whole(Opacity), "a"),
    (Whole(Emission), "e"),
    (Packed([Some(Metalness), None, None, Some(Gloss)]), "ms"),
    (Aside(SPECULAR), "s"),
    (Aside("`_M` can be metalness or a mask; name it Metalness"), "m"),
];

/// Words without a meaning for the role: sizes of samples, formats and colour spaces.
const SKIPPED: &str = "png jpg jpeg tif tiff exr webp tga bmp dds ktx2 ogl opengl gl dx d3d directx udim bit srgb lin linear \
    raw rgb rgba map maps texture tex image img tile tiled tiling seamless hires lowres hq lq lossless final float half hd uhd \
    noncolor utility";

fn is_in(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|known| known == word)
}

/// Whether a word gives a size, a format or a colour space, and not a number of a material.
fn is_format(word: &str) -> bool {
    let number: Option<u32> = word.strip_suffix('k').unwrap_or(word).parse().ok();
    let is_size = number.is_some_and(|n| word.ends_with('k') || n >= 128 && n.is_power_of_two());
    is_size || is_in(SKIPPED, word) || word.split_once('x').is_some_and(|(w, h)| w.parse::<u32>().is_ok() && w == h)
}

/// Returns the words before the role that name the material.
pub(super) fn base_of(words: &[String]) -> Vec<&str> {
    words.iter().map(String::as_str).filter(|word| !is_format(word)).collect()
}

/// Whether a word tells nothing about the role, such as a resolution, a version, a tile or a bit depth.
fn is_skipped(word: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let before = |end: &str| word.strip_suffix(end).is_some_and(is_number);
    let after = |start: &str| word.strip_prefix(start).is_some_and(is_number);
    is_in(SKIPPED, word)
        || is_number(word)
        || ["k", "bit", "b", "px", "bpc"].into_iter().any(before)
        || ["v", "var", "variant", "lod", "u", "bc", "ver", "version"].into_iter().any(after)
        || word.split_once('x').is_some_and(|(w, h)| is_number(w) && is_number(h))
}

/// Returns the meaning of a word, and its position in the table. A bit depth may follow, as in `DISP16`.
fn lookup(table: &[(Meaning, &str)], word: &str) -> Option<(Meaning, [usize; 2])> {
    let exact = |word: &str| {
        table.iter().enumerate().find_map(|(list, (meaning, words))| {
            words.split_ascii_whitespace().position(|known| known == word).map(|rank| (*meaning, [list, rank]))
        })
    };
    let without_depth = || ["16", "32", "8"].into_iter().find_map(|depth| word.strip_suffix(depth));
    exact(word).or_else(|| without_depth().and_then(exact))
}

/// Returns the words of a file name without its extension, in lower case.
pub(super) fn words_of(file: &Path) -> Vec<String> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    stem.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Returns the number of words before the skipped words at the end.
pub(super) fn without_skipped(words: &[String]) -> usize {
    words.iter().rposition(|word| !is_skipped(word)).map_or(0, |last| last + 1)
}

/// Returns the role at the end of a name after the first `from` words, before skipped words. With `letters`, single letters
/// count.
pub(super) fn at_end(words: &[String], from: usize, letters: bool) -> Option<Found> {
    (without_skipped(words)..=words.len()).rev().find_map(|end| phrase(words, from..end, letters))
}

/// Returns the last role in a name after the first `from` words.
pub(super) fn anywhere(words: &[String], from: usize) -> Option<Found> {
    (from..=words.len()).rev().find_map(|end| phrase(words, from..end, false))
}

/// Returns the role that the last words of a range spell. The longest phrase counts: `nor gl` before `nor`. After a word for
/// normals, the alpha of the normals has the role: `normal_roughness`.
fn phrase(words: &[String], range: Range<usize>, letters: bool) -> Option<Found> {
    let found = single(words, range.clone(), letters)?;
    let Whole(in_alpha @ (Roughness | Gloss | Height)) = found.meaning else { return Some(found) };
    let normals = single(words, range.start..found.base.max(range.start), false);
    Some(match normals {
        Some(Found { meaning: Whole(role @ (Normal | NormalUp | NormalDown)), base, .. }) => {
            Found { meaning: Packed([Some(role), None, None, Some(in_alpha)]), base, ..found }
        }
        _ => found,
    })
}

fn single(words: &[String], range: Range<usize>, letters: bool) -> Option<Found> {
    let end = range.end;
    (1..=range.len().min(4)).rev().find_map(|count| {
        let base = end - count;
        let text = words[base..end].concat();
        let by_letter = || lookup(LETTERS, &text).filter(|_| letters && count == 1 && base > 0);
        let (meaning, rank) = lookup(WORDS, &text).or_else(by_letter)?;
        // The direction of green may stand apart: `normal_2k_gl`, `gl_normal`.
        let is_near = |list: &str| words[end..].iter().chain(words[..base].last()).any(|word| is_in(list, word));
        let meaning = match meaning {
            Whole(Normal) if is_near("gl ogl opengl") => Whole(NormalUp),
            Whole(Normal) if is_near("dx d3d directx") => Whole(NormalDown),
            other => other,
        };
        Some(Found { meaning, base, rank })
    })
}

/// Returns the role at the end of a name whose last word joins several words by capitals, such as `RockNormal`.
pub(super) fn joined(file: &Path) -> Option<Found> {
    let stem = file.file_stem()?.to_string_lossy();
    let mut split = String::new();
    for c in stem.chars() {
        if c.is_ascii_uppercase() && split.chars().next_back().is_some_and(|before| before.is_ascii_lowercase()) {
            split.push(' ');
        }
        split.push(c);
    }
    let words = words_of(Path::new(&format!("{split}.png")));
    at_end(&words, 0, false).filter(|found| found.base > 0)
}

/// Whether single letters at the end of a name stand for roles, as in the names of Unreal: `T_Rock_D`.
pub(super) fn has_letters(words: &[String]) -> bool {
    words.len() > 2 && words[0] == "t"
}

/// Returns the role of a file, which is given by the last recognised word in the file name. Pictures whose channels have
/// several roles give the role in red.
pub fn role_of(file: &Path) -> Option<Role> {
    let words = words_of(file);
    let found = at_end(&words, 0, has_letters(&words)).or_else(|| joined(file)).or_else(|| anywhere(&words, 0))?;
    match found.meaning {
        Whole(role) => Some(role),
        Packed(roles) => roles[0],
        Aside(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_as_libraries_spell_them() {
        for (name, role) in [
            ("Rock003_1K-PNG_Color.png", Some(Color)),
            ("Rock003_1K-PNG_NormalGL.png", Some(NormalUp)),
            ("Rock003_1K-PNG_NormalDX.png", Some(NormalDown)),
            ("Rock003_1K-PNG_Displacement.png", Some(Height)),
            ("rock_wall_nor_gl_2k.exr", Some(NormalUp)),
            ("rock_wall_nor_dx_2k.png", Some(NormalDown)),
            ("rock_wall_diff_2k.jpg", Some(Color)),
            ("rock_wall_arm_2k.jpg", Some(Occlusion)),
            ("metal_plate_rough_1k.png", Some(Roughness)),
            ("Metal Plate Base_Color.png", Some(Color)),
            ("brushed-metal-ao.png", Some(Occlusion)),
            ("wood_Glossiness.png", Some(Gloss)),
            ("color_ramp_height.png", Some(Height)),
            ("rough_wood_spec_1k.jpg", None),
            ("smooth-stone_preview.jpg", None),
            ("wall_normal_roughness.png", Some(Normal)),
            ("wall_NormalGL+Roughness.png", Some(NormalUp)),
            ("wall_normal_4096x4096_16bit_v3.1001.tif", Some(Normal)),
            ("T_Rock_N.png", Some(Normal)),
            ("plan_n.png", None),
            ("preview.png", None),
            (".png", None),
        ] {
            assert_eq!(role_of(Path::new(name)), role, "{name}");
        }
    }
}
