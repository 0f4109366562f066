//! The classes of facets of an object's relief, such as the tops, walls and bottoms of bricks
//! ([`classes`]).
//!
//! One class is one Gaussian of slopes. A relief with more classes has two image layers per class with slope and height moments, and
//! one layer per class with colours if the classes differ in material. A smooth surface has only the classes of its material.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use half::f16;
use leadr_gpu::{Gpu, Image, ImageDesc, Result, vk};
use leadr_maps::derive::{ClassMaterial, Classes, Facets, OPENNESS_SIDE, Openness, classes};
use leadr_maps::{ClassColors, ClassLevel, ClassMap, MomentLevel, Moments, Wrap};
use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};

use super::displacement::Border;
use super::material::Codes;
use super::patch_mesh::PatchMesh;
use crate::scene::{MaterialMap, Object};

/// The format of the moments and of the weighted colours.
const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// The number of patches from which the size of a map repeat is measured.
const MEASURED: usize = 64;
/// The maximum side of an image of class colours, in texels. For larger colour maps, the image starts at a coarser level.
const MOST_TEXELS: u32 = 2048;
/// The ratio of the `α²` of two classes from which pixels at their border look blurred if a single row of taps filters them.
const APART: f64 = 2.0;

/// The classes of an object's relief and of the material on it.
#[derive(Clone, Debug)]
pub struct ObjectClasses {
    /// The moments of each class. Smooth surfaces have no levels.
    pub map: ClassMap,
    /// How much of each class other facets hide. Smooth surfaces have no texels.
    pub open: Openness,
    /// The factors that convert slopes per texture coordinate to rise over run.
    pub slope_scale: DVec2,
    /// The colours and the roughness of each class, if they differ.
    pub colors: Option<ClassColors>,
}

impl ObjectClasses {
    /// Finds the classes of an object, which must still hold its maps. Returns `None` if one class describes the surface, or if the
    /// maps are an atlas or projected along the axes.
    pub fn of(object: &Object) -> Option<Self> {
        let codes = Codes::new();
        let texel = object.material.as_ref().map(|map| {
            move |i: usize| {
                let [r, g, b, square] = codes.linear(map.colors[i]);
                [r, g, b, square.sqrt()]
            }
        });
        let material = object.material.as_ref().zip(texel.as_ref()).filter(|(map, _)| has_classes(object, map));
        let material = material.map(|(map, texel)| {
            let size = [map.width, map.height];
            (map, ClassMaterial { size, texel, follows_relief: object.follows_relief })
        });
        let colors = |facets, found: &Classes| {
            let (map, material) = material.as_ref()?;
            ClassColors::new(facets, found, material, skipped_levels(map))
        };
        let material = material.as_ref().map(|(_, material)| material);
        if object.mesh.triplanar.is_some() {
            return None;
        }
        let field = object.heights.as_ref();
        let relief = field.filter(|field| object.height_scale != 0.0 && !is_constant(&field.map.texels));
        if relief.is_none() {
            // Without relief, only the material has classes.
            let flat = classes(Facets::Flat, [1.0; 2], Some(material?));
            if flat.count() == 1 {
                return None;
            }
            if field.is_none() {
                let colors = colors(Facets::Flat, &flat)?;
                let map = ClassMap { centers: vec![[0.0; 3]; flat.count()], units: [1.0; 3], levels: Vec::new() };
                let open = Openness { correlation: [1.0; MOST_CLASSES], texels: Vec::new() };
                return Some(Self { map, open, slope_scale: DVec2::ONE, colors: Some(colors) });
            }
        }
        let field = field?;
        let wrap = match field.border {
            Border::Wrap => Wrap::Repeat,
            Border::Clamp => Wrap::Clamp,
            Border::Tiles(_) => return None,
        };
        let rise_over_run = object.mesh.triangles && object.slopes.is_some();
        let repeat = if rise_over_run { DVec2::ONE } else { metres_per_repeat(&object.mesh)? };
        let level = first_level(object, wrap);
        let facets = match &level {
            Some(level) => Facets::OfTexels(level),
            None => Facets::OfHeights(&field.map, wrap),
        };
        let scale = f64::from(object.height_scale) / repeat;
        let found = classes(facets, scale.to_array(), material);
        (found.count() > 1).then(|| {
            let map = ClassMap::new(facets, &found, material);
            let open = Openness::new(facets, wrap, &found, material, map.units, object.height_scale < 0.0);
            Self { map, open, slope_scale: scale, colors: colors(facets, &found) }
        })
    }

    /// Multiplies all heights by a factor.
    pub fn scale(&mut self, factor: f32) {
        self.map.centers.as_flattened_mut().iter_mut().for_each(|center| *center *= factor);
        self.map.units.iter_mut().for_each(|unit| *unit *= factor);
    }

    /// Returns the optical depths of the classes towards the sky, if a factor multiplies the height scale.
    fn sky_depths(&self, factor: f64) -> [f32; MOST_CLASSES] {
        let scale = factor * self.slope_scale;
        let physical = |class: Class| Class {
            mean: scale * class.mean,
            covariance: class.covariance * DVec3::new(scale.x * scale.x, scale.y * scale.y, scale.x * scale.y),
            ..class
        };
        let classes: Vec<Class> = self.map.mean().into_iter().map(physical).collect();
        let units = DVec2::new(f64::from(self.map.units[0]), f64::from(self.map.units[1]));
        self.open.sky_depths(&classes, (scale * units).abs()).map(|depth| depth as f32)
    }

    /// Returns the number of classes.
    pub fn count(&self) -> u32 {
        self.map.centers.len() as u32
    }

    /// Whether the roughness changes sharply between classes.
    pub fn has_sharp_roughness(&self) -> bool {
        let Some(colors) = &self.colors else { return false };
        let squares = colors.of_texel(colors.levels.len() - 1, 0).into_iter().filter(|(share, _)| *share > 0.0);
        let (least, most) =
            squares.fold((f64::INFINITY, 0.0f64), |(least, most), (_, value)| (least.min(value.w), most.max(value.w)));
        most > APART * least
    }

    /// Returns the number of bytes of the images.
    pub fn bytes(&self) -> u64 {
        let levels = self.map.levels.iter().chain(self.colors.iter().flat_map(|colors| &colors.levels));
        levels.map(|level| 8 * u64::from(level.width) * u64::from(level.height) * level.layers.len() as u64).sum()
    }
}

/// Whether classes can depend on the material of an object.
fn has_classes(object: &Object, map: &MaterialMap) -> bool {
    // With charts, the colours have different texture coordinates from the heights. A measured material has its own facet distribution.
    let lies_on_relief = object.charts.is_none() || object.heights.is_none();
    lies_on_relief
        && map.fit.is_none()
        && !map.colors.is_empty()
        && map.colors.len() == map.width as usize * map.height as usize
}

/// Returns how many of the finest colour levels have no class colours.
fn skipped_levels(map: &MaterialMap) -> usize {
    let mut skipped = 0;
    while map.width.max(map.height) >> skipped > MOST_TEXELS {
        skipped += 1;
    }
    skipped
}

fn is_constant(heights: &[f32]) -> bool {
    heights.iter().all(|height| *height == heights[0])
}

/// The largest difference between the mean slopes of texels with the same heights, relative to the slopes, as for block compression.
const ALIKE: f64 = 0.05;

/// Whether two levels have the same mean slopes up to the precision of files.
fn agrees(a: &MomentLevel, b: &MomentLevel) -> bool {
    let (mut difference, mut square) = (0.0, 0.0);
    for (a, b) in a.texels.iter().zip(&b.texels) {
        for axis in 0..2 {
            difference += f64::from(a.mean_slope[axis] - b.mean_slope[axis]).powi(2);
            square += f64::from(b.second[axis]);
        }
    }
    a.texels.len() == b.texels.len() && difference <= ALIKE * ALIKE * square
}

/// Returns the finest moments of an object's slopes, or `None` if they are those of its heights.
fn first_level(object: &Object, wrap: Wrap) -> Option<MomentLevel> {
    let map = &object.heights.as_ref()?.map;
    if let Some(moments) = &object.moments {
        // A file gives the classes of the heights from which it was baked.
        let level = moments.levels.first()?;
        return (!agrees(level, &MomentLevel::of_heights(map, wrap))).then(|| level.clone());
    }
    let slopes = object.slopes.as_ref()?;
    let moments = |(i, &[x, y]): (usize, &[f32; 2])| {
        let [ss, tt, st] = object.slope_spread.as_ref().map_or([0.0; 3], |spread| spread[i]);
        let second = [x * x + ss, y * y + tt];
        Moments { mean_slope: [x, y], second, cross: x * y + st, height: map.texels[i] }
    };
    let texels = slopes.iter().enumerate().map(moments).collect();
    Some(MomentLevel { width: map.width, height: map.height, texels })
}

/// Returns the size of a map repeat in metres along both texture coordinates, as the root mean square over patches.
fn metres_per_repeat(mesh: &PatchMesh) -> Option<DVec2> {
    let step = mesh.patches.len().div_ceil(MEASURED).max(1);
    let (mut squares, mut count) = (DVec2::ZERO, 0.0);
    for (patch, texcoords) in mesh.patches.iter().zip(&mesh.texcoords).step_by(step) {
        let [a, b, d] = [patch[0], patch[1], patch[3]].map(|vertex| mesh.positions[vertex as usize]);
        let ([u, v], [p, q]) = ([texcoords[1] - texcoords[0], texcoords[3] - texcoords[0]], [b - a, d - a]);
        let area = u.perp_dot(v);
        let along_s: Vec3 = (p * v.y - q * u.y) / area;
        let along_t: Vec3 = (q * u.x - p * v.x) / area;
        if along_s.is_finite() && along_t.is_finite() {
            squares += DVec2::new(f64::from(along_s.length_squared()), f64::from(along_t.length_squared()));
            count += 1.0;
        }
    }
    let sizes = DVec2::new((squares.x / count).sqrt(), (squares.y / count).sqrt());
    (sizes.is_finite() && sizes.min_element() > 0.0).then_some(sizes)
}

/// The number of factors of the height scale for which depths towards the sky are stored.
const FACTORS: usize = 11;
/// The factors of the height scale, each twice the one before.
const FACTOR_RANGE: [f64; FACTORS] = [0.015625, 0.03125, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// The images of the classes. Clones share the images.
#[derive(Clone)]
pub struct ClassImages {
    /// Two layers per class ([`leadr_maps::ClassLevel`]).
    pub moments: Image,
    /// The weighted colours of each class, and the weights.
    pub colors: Image,
    /// The [openness](Openness) of each class.
    pub open: Image,
    /// The centres of the classes.
    pub centers: [[f32; 4]; MOST_CLASSES],
    /// The units of the moments about the centres, and the slope variance of the map in these units, summed over both axes.
    pub unit: [f32; 4],
    /// The [correlation](Openness::correlation) of the openness of each class.
    pub correlation: [f32; MOST_CLASSES],
    /// The optical depth of each class towards the sky, at each of [`FACTORS`] of the height scale.
    sky_depths: [[f32; MOST_CLASSES]; FACTORS],
}

impl ClassImages {
    /// Creates placeholders. Shaders never read them.
    pub fn none(gpu: &Arc<Gpu>) -> Result<Self> {
        let image = |name| {
            let image = Image::new(gpu, name, ImageDesc::new(FORMAT, 1, 1).layers(2))?;
            (0..2).try_for_each(|layer| image.write(0, layer, &[[f16::ZERO; 4]])).map(|()| image)
        };
        let open = Image::new(gpu, "no class openness", ImageDesc::new(FORMAT, 1, 1))?;
        open.write(0, 0, &[[f16::ONE; 4]])?;
        let (moments, colors) = (image("no class moments")?, image("no class colours")?);
        let (centers, sky_depths) = ([[0.0; 4]; MOST_CLASSES], [[0.0; MOST_CLASSES]; FACTORS]);
        Ok(Self { moments, colors, open, centers, unit: [1.0; 4], correlation: [1.0; MOST_CLASSES], sky_depths })
    }

    /// Uploads the classes of an object.
    pub fn new(gpu: &Arc<Gpu>, name: &str, classes: &ObjectClasses, none: &Self) -> Result<Self> {
        let ObjectClasses { map, open, colors, .. } = classes;
        let colors = match colors {
            Some(colors) => uploaded(gpu, &format!("{name} class colours"), &colors.levels)?,
            None => none.colors.clone(),
        };
        if map.levels.is_empty() {
            return Ok(Self { colors, ..none.clone() });
        }
        let moments = uploaded(gpu, &format!("{name} class moments"), &map.levels)?;
        let mut centers = [[0.0; 4]; MOST_CLASSES];
        centers.iter_mut().zip(&map.centers).for_each(|(to, [s, t, h])| *to = [*s, *t, *h, 0.0]);
        let side = OPENNESS_SIDE as u32;
        let table = Image::new(gpu, &format!("{name} class openness"), ImageDesc::new(FORMAT, side, side))?;
        table.write(0, 0, &open.texels)?;
        let [s, t, h] = map.units;
        let unit = [s, t, h, variance_in_units(map)];
        let (correlation, sky_depths) =
            (open.correlation.map(|c| c as f32), FACTOR_RANGE.map(|factor| classes.sky_depths(factor)));
        Ok(Self { moments, colors, open: table, centers, unit, correlation, sky_depths })
    }

    /// Returns the optical depth of each class towards the sky, if a factor multiplies the height scale.
    pub fn sky_depths(&self, factor: f32) -> [f32; MOST_CLASSES] {
        let at = (factor.abs().log2() - FACTOR_RANGE[0].log2() as f32).clamp(0.0, (FACTORS - 1) as f32);
        let first = (at as usize).min(FACTORS - 2);
        let part = at - first as f32;
        std::array::from_fn(|k| {
            let [low, high] = [first, first + 1].map(|i| self.sky_depths[i][k]);
            low + part * (high - low)
        })
    }
}

fn uploaded(gpu: &Arc<Gpu>, name: &str, levels: &[ClassLevel]) -> Result<Image> {
    let ClassLevel { width, height, layers } = &levels[0];
    let image = Image::new(gpu, name, ImageDesc::new(FORMAT, *width, *height).full_mips().layers(layers.len() as u32))?;
    for (mip, level) in (0..).zip(levels) {
        for (number, layer) in (0..).zip(&level.layers) {
            image.write(mip, number, layer)?;
        }
    }
    Ok(image)
}

/// Returns the slope variance of a whole map in the units of its classes, summed over both axes.
fn variance_in_units(map: &ClassMap) -> f32 {
    let unit = DVec2::new(f64::from(map.units[0]), f64::from(map.units[1]));
    let classes = map.mean();
    let mean: DVec2 = classes.iter().map(|class| class.share * class.mean).sum();
    let variance = |class: &Class| {
        let off = class.mean - mean;
        class.share * (class.covariance.truncate() + off * off)
    };
    let variance: DVec2 = classes.iter().map(variance).sum();
    (variance / (unit * unit)).element_sum() as f32
}
