//! The classes of facets of an object's relief, such as the tops, walls and bottoms of bricks
//! ([`classes`](leadr_maps::derive::classes)).
//!
//! One class is one Gaussian of slopes. A relief with more classes has an image with six slope moments per class, and one layer per
//! class with colours if the classes differ in material. A smooth surface has only the classes of its material.

mod images;
mod sources;
mod tiles;

use std::convert::Infallible;

use glam::{DVec2, DVec3};
use half::f16;
use leadr_maps::cache::{MapCache, expect_all, expect_end, put, take};
use leadr_maps::derive::{LocalLevel, LocalOpenness, OPENNESS_SIDE, Openness};
use leadr_maps::{ClassColors, ClassLevel, ClassMap};
use leadr_reflectance::masking::classes::{Class, Correlation, LOCAL_COMPONENTS, MOST_CLASSES};
use rayon::prelude::*;

use crate::scene::Object;

pub use images::{ClassAtlas, ClassImages};
pub use sources::ClassSources;

/// The ratio of the `α²` of two classes from which pixels at their border look blurred if a single row of taps filters them.
const APART: f64 = 2.0;

/// The classes of a relief, as a baked file stores them.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredClasses {
    /// The moments of each class.
    pub map: ClassMap,
    /// How much of each class other facets hide, for heights that are not inverted.
    pub open: Openness,
}

impl StoredClasses {
    /// Multiplies all heights by a factor.
    pub fn scale(&mut self, factor: f32) {
        self.map.centers.as_flattened_mut().iter_mut().for_each(|center| *center *= factor);
        self.map.units.iter_mut().for_each(|unit| *unit *= factor);
    }

    /// Subtracts `height` from all heights.
    pub fn lower(&mut self, height: f32) {
        self.map.centers.iter_mut().for_each(|[_, _, center]| *center -= height);
    }

    /// Reverses the order of the rows, and with it the direction of `t`.
    #[must_use]
    pub fn with_reversed_rows(mut self) -> Self {
        self.map.centers.iter_mut().for_each(|[_, t, _]| *t = -*t);
        for ClassLevel { width, layers, .. } in &mut self.map.levels {
            for layer in layers {
                *layer = layer.chunks_exact(*width as usize).rev().flatten().copied().collect();
                // The third value is the first or mixed moment of the slopes along t.
                layer.iter_mut().for_each(|[_, _, value, _]| *value = -*value);
            }
        }
        self.open.texels = self.open.texels.chunks_exact(OPENNESS_SIDE).rev().flatten().copied().collect();
        self
    }
}

/// The classes of an object's relief and of the material on it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectClasses {
    /// The moments of each class. Smooth surfaces have no levels.
    pub map: ClassMap,
    /// How much of each class other facets hide. Smooth surfaces have no texels.
    pub open: Openness,
    /// The factors that convert slopes per texture coordinate to rise over run.
    pub slope_scale: DVec2,
    /// The local openness, with the levels of `map`. Smooth surfaces and atlases have no levels.
    pub local: LocalOpenness,
    /// The colours and the roughness of each class, if they differ.
    pub colors: Option<ClassColors>,
}

/// The classes of the objects of a scene, in scene order. `None` means a single class.
pub type FoundClasses = Vec<Option<ObjectClasses>>;

/// The classes of the objects of a scene, or the maps in which they are found.
pub enum SceneClasses {
    /// The maps, for frames that may need the classes later.
    Unfound(Vec<Option<ClassSources<'static>>>),
    /// The classes.
    Found(FoundClasses),
}

impl SceneClasses {
    /// Finds the classes if they are `wanted`. The objects must still hold their maps. `height_scale` is a factor for the heights of every
    /// object. Classes hold for all heights, but suit these best.
    pub fn of(objects: &mut [Object], cache: Option<&MapCache>, height_scale: f32, wanted: bool) -> Self {
        let stored: Vec<_> = objects.iter_mut().map(|object| object.classes.take()).collect();
        let sources =
            objects.par_iter().zip(stored).map(|(object, stored)| ClassSources::of(object, stored, height_scale));
        if wanted {
            Self::Found(sources.map(|sources| ObjectClasses::of(sources?, cache)).collect())
        } else {
            Self::Unfound(sources.map(|sources| sources.map(ClassSources::into_owned)).collect())
        }
    }

    /// Finds the classes in these maps.
    pub fn find(sources: Vec<Option<ClassSources<'_>>>, cache: Option<&MapCache>) -> FoundClasses {
        sources.into_par_iter().map(|sources| ObjectClasses::of(sources?, cache)).collect()
    }
}

/// The bytes per texel of the cached classes at most: eight layers and their mask, and the local openness.
const MOST_TEXEL_BYTES: u64 = 8 * 2 * MOST_CLASSES as u64 + 1 + 2 * LOCAL_COMPONENTS as u64;

impl ObjectClasses {
    fn of(mut sources: ClassSources<'_>, cache: Option<&MapCache>) -> Option<Self> {
        if let Some(stored) = sources.take_stored() {
            return Some(sources.with_stored(stored));
        }
        let Some(cache) = cache else { return sources.find() };
        let texels = [sources.relief_size(), sources.color_size()].into_iter().flatten();
        // All levels together have less than twice the texels of the first.
        let texels: u64 = texels.map(|size| 2 * size.map(u64::from).iter().product::<u64>()).sum();
        let read = |content: &[u8]| Self::read(content, &sources);
        let make = || {
            let found = sources.find();
            let content = Self::content(found.as_ref());
            Ok::<_, Infallible>((found, content))
        };
        let Ok(found) = cache.load_or_make("classes", sources.key(), MOST_TEXEL_BYTES * texels + (1 << 16), read, make);
        found
    }

    /// Returns the content of a cache file with these classes.
    fn content(found: Option<&Self>) -> Vec<u8> {
        let mut content = Vec::new();
        let Some(Self { map, open, colors, local, .. }) = found else { return content };
        put(&mut content, &[map.count() as u32, u32::from(colors.is_some()), u32::from(!local.levels.is_empty())]);
        if !map.levels.is_empty() {
            map.put(&mut content);
            open.put(&mut content);
        }
        let bits = |texel: &[f16; LOCAL_COMPONENTS]| texel.map(f16::to_bits);
        let tables = local.levels.iter().chain((!local.levels.is_empty()).then_some(&local.components));
        tables.for_each(|table| put(&mut content, &table.iter().map(bits).collect::<Vec<_>>()));
        colors.iter().for_each(|colors| colors.put(&mut content));
        content
    }

    /// Reads the content of a cache file.
    fn read(mut content: &[u8], sources: &ClassSources<'_>) -> Result<Option<Self>, &'static str> {
        if content.is_empty() {
            return Ok(None);
        }
        let [count, has_colors, has_local] = take::<u32>(&mut content, 3)?[..] else {
            return Err("it is too short");
        };
        expect_all(&[count], |count| (2..=MOST_CLASSES as u32).contains(count))?;
        let (count, colored) = (count as usize, has_colors == 1);
        let (map, open) = match sources.relief_size() {
            Some(size) => (ClassMap::take(&mut content, size, count)?, Openness::take(&mut content)?),
            None => smooth(count),
        };
        let mut table = |texels: usize| {
            let texels = take::<[u16; LOCAL_COMPONENTS]>(&mut content, texels)?;
            let texels: LocalLevel = texels.into_iter().map(|texel| texel.map(f16::from_bits)).collect();
            expect_all(&texels, |texel| texel.iter().all(|v| v.is_finite()))?;
            Ok(texels)
        };
        let mut level = |level: &ClassLevel| table(level.width as usize * level.height as usize);
        let local = if has_local == 1 {
            let levels = map.levels.iter().map(&mut level).collect::<Result<_, &'static str>>()?;
            LocalOpenness { levels, components: table(OPENNESS_SIDE * OPENNESS_SIDE)? }
        } else {
            LocalOpenness::default()
        };
        let colors = match sources.color_size() {
            Some(size) if colored => Some(ClassColors::take(&mut content, size, sources.skipped(), count)?),
            _ => None,
        };
        expect_end(content)?;
        Ok(Some(Self { map, open, slope_scale: sources.scale(), local, colors }))
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

    /// Returns the number of bytes of each image.
    pub fn bytes(&self) -> [u64; 2] {
        let bytes =
            |level: &ClassLevel, layers: usize| 8 * u64::from(level.width) * u64::from(level.height) * layers as u64;
        let colors = self.colors.iter().flat_map(|colors| &colors.levels);
        let layers = images::packed_layers(self.map.count(), !self.local.levels.is_empty());
        [
            self.map.levels.iter().map(|level| bytes(level, layers)).sum(),
            colors.map(|level| bytes(level, level.layers.len())).sum(),
        ]
    }
}

/// Returns the map and the openness of a smooth surface.
fn smooth(count: usize) -> (ClassMap, Openness) {
    let map = ClassMap { centers: vec![[0.0; 3]; count], units: [1.0; 3], levels: Vec::new() };
    (map, Openness { correlation: [Correlation::SMITH; MOST_CLASSES], texels: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MaterialMap;
    use crate::surfaces::displacement::{Border, HeightField};
    use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};
    use glam::{Vec2, Vec3};
    use leadr_maps::HeightMap;

    /// One patch of one metre with blocks on it.
    fn blocks() -> Object {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let mesh = PatchMesh {
            positions: corners.map(|at| at.extend(0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            texcoords: vec![corners],
            patches: vec![[0, 1, 2, 3]],
            ..PatchMesh::default()
        };
        let height =
            |i: u32| f32::from(u8::from((i / 8 + i / 256).is_multiple_of(2))) + 0.01 * ((i * 7919) % 13) as f32;
        let map = HeightMap { width: 32, height: 32, texels: (0..1024).map(height).collect() };
        Object::new("blocks", mesh).with_heights(HeightField::repeating(map), 0.05)
    }

    /// The blocks in an atlas with one patch.
    fn tiled_blocks() -> Object {
        let layout = TileLayout::new(1, 32);
        let (width, height) = layout.size();
        let Object { mesh, heights, height_scale, .. } = blocks();
        let blocks = heights.map(|field| field.map.texels).unwrap_or_default();
        let texels = (0..width * height).map(|i| blocks[(i / width * 32 + i % width % 32) as usize]).collect();
        let heights = HeightField { map: HeightMap { width, height, texels }, border: Border::Tiles(layout) };
        Object::new("tiles", PatchMesh { texcoords: vec![layout.texcoords(0)], ..mesh })
            .with_heights(heights, height_scale)
    }

    #[test]
    fn an_atlas_has_the_classes_of_its_relief() {
        let [plain, tiled] = [blocks(), tiled_blocks()].map(|object| found(&object, None, None).unwrap());
        assert_eq!(tiled.map.levels[0].width, 128);
        let rise = |classes: &ObjectClasses| {
            let square = |class: Class| class.share * (class.covariance.truncate() + class.mean * class.mean);
            classes.map.mean().into_iter().map(square).sum::<DVec2>() * classes.slope_scale * classes.slope_scale
        };
        // The patch has 28 texels per metre, and the plain map has 32. One of its four steps is at the border, which the patch lacks.
        let ratio = rise(&tiled) / rise(&plain) * (32.0f64 / 28.0).powi(2);
        assert!(ratio.cmpgt(DVec2::splat(0.7)).all() && ratio.cmplt(DVec2::splat(1.05)).all(), "{ratio}");
        assert!(tiled.map.centers.iter().all(|[s, t, _]| [*s, *t] == [0.0; 2]));
    }

    fn rough(object: Object, alpha: impl Fn(usize) -> u8) -> Object {
        let colors = (0..1024).map(|i| [200, 100, 50, alpha(i)]).collect();
        object.with_material(MaterialMap::new(32, 32, colors))
    }

    fn found(object: &Object, stored: Option<StoredClasses>, cache: Option<&MapCache>) -> Option<ObjectClasses> {
        ObjectClasses::of(ClassSources::of(object, stored, 1.0)?, cache)
    }

    #[test]
    fn classes_are_stored_in_the_cache() {
        let folder = tempfile::tempdir().unwrap();
        let cache = MapCache::in_folder(folder.path());
        let files = || {
            let entries = std::fs::read_dir(folder.path()).map(Iterator::flatten).into_iter().flatten();
            entries.map(|entry| entry.path()).collect::<Vec<_>>()
        };
        let two_roughnesses = |i: usize| if i.is_multiple_of(3) { 40 } else { 200 };
        let flat = |mut object: Object| {
            object.heights = None;
            object
        };
        let even = |mut object: Object| {
            object.heights.iter_mut().for_each(|field| field.map.texels.fill(0.25));
            object
        };
        let objects = [
            blocks(),
            rough(blocks(), |_| 200),
            rough(blocks(), two_roughnesses),
            flat(rough(blocks(), two_roughnesses)),
            even(rough(blocks(), two_roughnesses)),
            tiled_blocks(),
        ];
        for (i, object) in objects.iter().enumerate() {
            let exact = found(object, None, None);
            assert_eq!(exact.as_ref().is_some_and(|classes| classes.colors.is_some()), (2..5).contains(&i), "{i}");
            assert!(found(object, None, Some(&cache)) == exact && files().len() == i + 1, "{i}");
            assert!(found(object, None, Some(&cache)) == exact && files().len() == i + 1, "{i}");
        }
        // Other inputs have their own entries.
        let steeper = Object { height_scale: 0.2, ..blocks() };
        let inverted = Object { height_scale: -0.05, ..blocks() };
        for (i, object) in [steeper, inverted].iter().enumerate() {
            found(object, None, Some(&cache));
            assert_eq!(files().len(), objects.len() + i + 1);
        }
    }

    #[test]
    fn one_class_and_damaged_entries_are_cached_again() {
        let folder = tempfile::tempdir().unwrap();
        let cache = MapCache::in_folder(folder.path());
        let mut smooth = blocks();
        let wave = |i: usize| (i as f32 * std::f32::consts::TAU / 32.0).sin();
        smooth
            .heights
            .iter_mut()
            .flat_map(|field| field.map.texels.iter_mut().enumerate())
            .for_each(|(i, h)| *h = wave(i));
        smooth.height_scale = 1e-3;
        assert_eq!(found(&smooth, None, Some(&cache)), None);
        let entry = || std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
        assert_eq!(std::fs::metadata(entry()).unwrap().len(), 24, "only a header");
        std::fs::remove_file(entry()).unwrap();

        let exact = found(&blocks(), None, Some(&cache));
        let file = entry();
        let good = std::fs::read(&file).unwrap();
        for damaged in [good[..good.len() / 2].to_vec(), [&good[..30], &[0xff; 9], &good[39..]].concat()] {
            std::fs::write(&file, damaged).unwrap();
            assert!(found(&blocks(), None, Some(&cache)) == exact);
            assert_eq!(std::fs::read(&file).unwrap(), good, "the entry is replaced");
        }
        // A file with a good checksum and another number of classes is too short or too long.
        let sources = ClassSources::of(&blocks(), None, 1.0).map(ClassSources::into_owned);
        let content = ObjectClasses::content(exact.as_ref());
        for count in [0_u32, 1, 5, 2 + u32::from(content[0] == 2)] {
            let planted = [&count.to_le_bytes()[..], &content[4..]].concat();
            assert!(ObjectClasses::read(&planted, sources.as_ref().unwrap()).is_err(), "{count}");
        }
    }

    #[test]
    fn classes_of_a_file_are_used_where_they_apply() {
        let exact = found(&blocks(), None, None).unwrap();
        // The file describes its classes in another way than the search.
        let mut stored = StoredClasses { map: exact.map.clone(), open: exact.open.clone() };
        stored.open.correlation[0].across = 0.25;
        let of_file = |object: &Object| {
            found(object, Some(stored.clone()), None).is_some_and(|classes| classes.open == stored.open)
        };
        assert!(of_file(&blocks()) && of_file(&rough(blocks(), |_| 200)));
        assert!(!of_file(&Object { height_scale: -0.05, ..blocks() }), "the openness of inverted relief differs");
        assert!(
            !of_file(&rough(blocks(), |i| if i.is_multiple_of(3) { 40 } else { 200 })),
            "the material separates classes"
        );
        assert!(!of_file(&rough(blocks(), |_| 200).with_relief_color()));
        assert_eq!(stored.clone().with_reversed_rows().with_reversed_rows(), stored);
    }

    #[test]
    fn reversed_rows_have_the_classes_of_the_reversed_relief() {
        let sorted = |classes: ObjectClasses| {
            let mut means: Vec<Class> = classes.map.mean();
            means.sort_by(|a, b| a.share.total_cmp(&b.share).then(a.mean.y.total_cmp(&b.mean.y)));
            means
        };
        // Ramps along t, which rise slowly and fall fast.
        let mut object = blocks();
        let texels = object.heights.iter_mut().flat_map(|field| field.map.texels.iter_mut().enumerate());
        texels.for_each(|(i, h)| *h = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.4][i / 32 % 10]);
        let upright = found(&object, None, None).unwrap();
        let stored = StoredClasses { map: upright.map.clone(), open: upright.open.clone() };
        object.heights.iter_mut().for_each(|field| {
            field.map.texels = field.map.texels.chunks_exact(32).rev().flatten().copied().collect();
        });
        let reversed = found(&object, None, None).unwrap();
        let of_file = found(&object, Some(stored.with_reversed_rows()), None).unwrap();
        for (a, b) in sorted(of_file.clone()).iter().zip(sorted(reversed.clone())) {
            assert!((a.share - b.share).abs() < 0.02 && (a.mean - b.mean).length() < 0.05 * b.mean.length().max(1.0));
        }
        let open = |classes: &ObjectClasses, y: f64| {
            let units = DVec2::new(f64::from(classes.map.units[0]), f64::from(classes.map.units[1])) * 0.05;
            let open = classes.open.towards(DVec3::new(0.0, y, 1.0).normalize(), units);
            classes.map.mean().iter().zip(open).map(|(class, open)| class.share * open).sum::<f64>()
        };
        for y in [-4.0, 4.0] {
            let [a, b] = [&of_file, &reversed].map(|classes| open(classes, y));
            assert!((a - b).abs() < 0.02, "{y}: {a} {b}");
        }
    }
}
