//! The images of the classes of an object.

use std::sync::Arc;

use glam::DVec2;
use half::f16;
use leadr_gpu::{Gpu, Image, ImageDesc, Result, vk};
use leadr_maps::derive::{LocalLevel, OPENNESS_SIDE};
use leadr_maps::{ClassLevel, ClassMap};
use leadr_reflectance::masking::classes::{Class, Correlation, LOCAL_COMPONENTS, MOST_CLASSES};

use super::ObjectClasses;
use crate::constants::SOURCE_LEVEL;
use crate::surfaces::atlas::frames::AtlasFrames;
use crate::surfaces::atlas::levels::{CoarseShape, Star, coarse_levels};
use crate::surfaces::atlas::turns::quarter_turns;
use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};
use crate::surfaces::topology::Topology;

/// The format of the moments and of the weighted colours.
const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// The number of factors of the height scale for which depths towards the sky are stored.
const FACTORS: usize = 11;
/// The factors of the height scale, each twice the one before.
const FACTOR_RANGE: [f64; FACTORS] = [0.015625, 0.03125, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// The images of the classes. Clones share the images.
#[derive(Clone)]
pub struct ClassImages {
    /// The moments of each class that shaders read, and the local openness, which atlases do not have, packed in layers of four.
    pub moments: Image,
    /// The weighted colours of each class, and the weights.
    pub colors: Image,
    /// The coarse levels of the moments and of the weighted colours of an atlas.
    pub coarse_moments: Image,
    /// See `coarse_moments`.
    pub coarse_colors: Image,
    /// The [openness](leadr_maps::derive::Openness) of each class, and the components of the local openness.
    pub open: Image,
    /// The centres of the classes.
    pub centers: [[f32; 4]; MOST_CLASSES],
    /// The units of the moments about the centres, and the slope variance of the map in these units, summed over both axes.
    pub unit: [f32; 4],
    /// The [correlation](leadr_maps::derive::Openness::correlation) of the openness of each class.
    pub correlation: [[f32; 4]; MOST_CLASSES],
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
        let open = image("no class openness")?;
        let (moments, colors) = (image("no class moments")?, image("no class colours")?);
        let (coarse_moments, coarse_colors) = (moments.clone(), colors.clone());
        let (centers, sky_depths) = ([[0.0; 4]; MOST_CLASSES], [[0.0; MOST_CLASSES]; FACTORS]);
        let (unit, correlation) = ([1.0; 4], [Correlation::SMITH; MOST_CLASSES].map(correlation_record));
        Ok(Self { moments, colors, coarse_moments, coarse_colors, open, centers, unit, correlation, sky_depths })
    }

    /// Uploads the classes of an object. `atlas` describes the tiles of its maps, if they are an atlas.
    pub fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        classes: ObjectClasses,
        atlas: Option<ClassAtlas<'_>>,
        none: &Self,
    ) -> Result<Self> {
        let [coarse_moments, coarse_colors] = match &atlas {
            Some(atlas) => atlas.coarse_levels(gpu, name, &classes, none)?,
            None => [none.coarse_moments.clone(), none.coarse_colors.clone()],
        };
        let (is_smooth, is_atlas) = (classes.map.levels.is_empty(), atlas.is_some());
        let sky_depths =
            if is_smooth { none.sky_depths } else { FACTOR_RANGE.map(|factor| classes.sky_depths(factor)) };
        let ObjectClasses { map, open, colors, local, .. } = classes;
        let colors = match colors {
            Some(colors) => uploaded(gpu, &format!("{name} class colours"), colors.levels)?,
            None => none.colors.clone(),
        };
        if is_smooth {
            return Ok(Self { colors, ..none.clone() });
        }
        let [s, t, h] = map.units;
        let unit = [s, t, h, variance_in_units(&map)];
        let mut levels = local.levels.into_iter();
        let packed = |level| packed(level, (!is_atlas).then(|| levels.next().unwrap_or_default()));
        let moments = uploaded(gpu, &format!("{name} class moments"), map.levels.into_iter().map(packed).collect())?;
        let mut centers = [[0.0; 4]; MOST_CLASSES];
        centers.iter_mut().zip(&map.centers).for_each(|(to, [s, t, h])| *to = [*s, *t, *h, 0.0]);
        let side = OPENNESS_SIDE as u32;
        let table = Image::new(gpu, &format!("{name} class openness"), ImageDesc::new(FORMAT, side, side).layers(2))?;
        table.write(0, 0, &open.texels)?;
        let mut components = local.components;
        components.resize(open.texels.len(), [f16::ZERO; LOCAL_COMPONENTS]);
        table.write(0, 1, &components)?;
        let correlation = open.correlation.map(correlation_record);
        Ok(Self { moments, colors, coarse_moments, coarse_colors, open: table, centers, unit, correlation, sky_depths })
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

/// The tiles of an object whose maps are an atlas.
pub struct ClassAtlas<'a> {
    /// The mesh of the patches.
    pub mesh: &'a PatchMesh,
    /// The edges of the mesh.
    pub topology: &'a Topology,
    /// The layout of the tiles.
    pub layout: TileLayout,
}

impl ClassAtlas<'_> {
    /// Creates the images with the coarse levels of the moments and of the colours.
    fn coarse_levels(
        &self,
        gpu: &Arc<Gpu>,
        name: &str,
        classes: &ObjectClasses,
        none: &ClassImages,
    ) -> Result<[Image; 2]> {
        let Self { mesh, topology, layout } = *self;
        let star = Star::new(mesh, topology.neighbors());
        let frames = AtlasFrames::new(mesh, layout).aligned(&quarter_turns(&star.neighbors));
        let shape = CoarseShape::new(layout);
        let [width, height] = shape.size();
        let image = |what: &str, layers: usize| {
            let desc = ImageDesc::new(FORMAT, width, height).layers(layers as u32);
            Image::new(gpu, &format!("{name} coarse class {what}"), desc)
        };
        let halves =
            |texels: Vec<[f32; 4]>| texels.into_iter().map(|texel| texel.map(f16::from_f32)).collect::<Vec<_>>();
        let floats = |texel: &[f16; 4]| texel.map(f16::to_f32);
        // The levels may start at a coarser level than the atlas.
        let source = |levels: &'_ [ClassLevel]| {
            let skipped = (layout.size().0 / levels[0].width).ilog2();
            SOURCE_LEVEL.saturating_sub(skipped) as usize
        };
        let ClassLevel { layers, .. } = &classes.map.levels[source(&classes.map.levels)];
        let mut coarse = Vec::new();
        for layers in layers.chunks_exact(2) {
            let texel = |(first, second): (&[f16; 4], &[f16; 4])| {
                let mut texel = [0.0; 8];
                texel[..4].copy_from_slice(&floats(first));
                texel[4..].copy_from_slice(&floats(second));
                texel
            };
            let texels: Vec<[f32; 8]> = layers[0].iter().zip(&layers[1]).map(texel).collect();
            let levels = coarse_levels(&star, &frames, shape, &texels);
            for half in [0, 4] {
                let part = |texel: &[f32; 8]| std::array::from_fn(|i| texel[half + i]);
                coarse.push(halves(levels.iter().map(part).collect()));
            }
        }
        let coarse = packed(ClassLevel { width, height, layers: coarse }, None);
        let moments = image("moments", coarse.layers.len())?;
        for (number, layer) in (0..).zip(&coarse.layers) {
            moments.write(0, number, layer)?;
        }
        let Some(colors) = &classes.colors else { return Ok([moments, none.coarse_colors.clone()]) };
        let ClassLevel { layers, .. } = &colors.levels[source(&colors.levels)];
        let image = image("colours", layers.len())?;
        for (number, layer) in (0..).zip(layers) {
            let texels: Vec<[f32; 4]> = layer.iter().map(floats).collect();
            image.write(0, number, &halves(coarse_levels(&star, &frames, shape, &texels)))?;
        }
        Ok([moments, image])
    }
}

/// The moments of a class that shaders read, by layer and component of a [`ClassLevel`]. They are those of the slopes.
const SHADED: [[usize; 2]; 6] = [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]];

/// Returns the number of layers that hold the shaded moments of this many classes, and the local openness if it `is_local`.
pub const fn packed_layers(classes: usize, is_local: bool) -> usize {
    (SHADED.len() * classes).div_ceil(4) + if is_local { 1 } else { 0 }
}

/// Packs the shaded moments of all classes in layers of four, and then the local openness. An empty level has no deviations.
fn packed(level: ClassLevel, local: Option<LocalLevel>) -> ClassLevel {
    let ClassLevel { width, height, layers } = level;
    let classes = layers.len() / 2;
    let of_classes = packed_layers(classes, false);
    let value = |at: usize, texel: usize| {
        let (class, moment) = (at / SHADED.len(), at % SHADED.len());
        if class < classes {
            let [layer, component] = SHADED[moment];
            layers[2 * class + layer][texel][component]
        } else {
            let texel = local.as_ref().and_then(|level| level.get(texel));
            texel.zip(at.checked_sub(4 * of_classes)).map_or(f16::ZERO, |(texel, at)| texel[at])
        }
    };
    let texels = width as usize * height as usize;
    let layer = |n: usize| (0..texels).map(|texel| std::array::from_fn(|i| value(4 * n + i, texel))).collect();
    ClassLevel { width, height, layers: (0..packed_layers(classes, local.is_some())).map(layer).collect() }
}

/// Uploads levels. Each layer is freed after its upload.
fn uploaded(gpu: &Arc<Gpu>, name: &str, levels: Vec<ClassLevel>) -> Result<Image> {
    let ClassLevel { width, height, layers } = &levels[0];
    let image = Image::new(gpu, name, ImageDesc::new(FORMAT, *width, *height).full_mips().layers(layers.len() as u32))?;
    for (mip, level) in (0..).zip(levels) {
        for (number, layer) in (0..).zip(level.layers) {
            image.write(mip, number, &layer)?;
        }
    }
    Ok(image)
}

fn correlation_record(Correlation { width, across, opposite }: Correlation) -> [f32; 4] {
    [width, across, opposite, 0.0].map(|c| c as f32)
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
