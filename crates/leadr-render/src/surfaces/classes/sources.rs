//! The maps of an object that determine its classes.

use std::borrow::Cow;

use glam::{DVec2, Vec3};
use leadr_maps::checksum::checksum;
use leadr_maps::derive::{ClassMaterial, Facets, LocalOpenness, Openness, classes, classes_of_windows};
use leadr_maps::{CLASS_SOURCES, ClassColors, ClassMap, HeightMap, MomentLevel, Moments, Wrap};

use super::tiles::{AtlasRelief, AtlasSurface};
use super::{ObjectClasses, StoredClasses, smooth};
use crate::scene::{MaterialMap, Object};
use crate::surfaces::displacement::Border;
use crate::surfaces::material::Codes;
use crate::surfaces::patch_mesh::PatchMesh;

/// The number of patches from which the size of a map repeat is measured.
const MEASURED: usize = 64;
/// The maximum side of an image of class colours, in texels. For larger colour maps, the image starts at a coarser level.
const MOST_TEXELS: u32 = 2048;
/// The largest difference between the mean slopes of texels with the same heights, relative to the slopes, as for block compression.
const ALIKE: f64 = 0.05;

/// The maps of an object in which its classes are found.
pub struct ClassSources<'a> {
    relief: Option<Relief<'a>>,
    /// Whether the heights vary. Otherwise, only the material separates classes.
    has_relief: bool,
    material: Option<Material<'a>>,
    /// The factors that convert slopes per texture coordinate to rise over run.
    scale: DVec2,
    /// A factor on the heights for which the classes are chosen.
    steepness: f64,
    upside_down: bool,
    stored: Option<StoredClasses>,
}

struct Relief<'a> {
    heights: Cow<'a, HeightMap>,
    wrap: Wrap,
    /// The surface, if the maps are an atlas.
    atlas: Option<AtlasSurface<'a>>,
    slopes: Option<Cow<'a, [[f32; 2]]>>,
    spread: Option<Cow<'a, [[f32; 3]]>>,
    /// The finest moments of a baked file.
    moments: Option<Cow<'a, MomentLevel>>,
}

struct Material<'a> {
    size: [u32; 2],
    colors: Cow<'a, [[u8; 4]]>,
    follows_relief: bool,
}

impl<'a> ClassSources<'a> {
    /// Returns the sources of an object that still holds its maps. `stored` are the classes of its file, and
    /// `height_scale` is a factor on its heights. Returns `None` if one class
    /// describes the surface, or if the maps are a large atlas.
    pub fn of(object: &'a Object, stored: Option<StoredClasses>, height_scale: f32) -> Option<Self> {
        if object.single_class && !object.follows_relief {
            return None;
        }
        let field = object.heights.as_ref();
        let has_relief = field.is_some_and(|field| object.height_scale != 0.0 && !is_constant(&field.map.texels));
        let material = object.material.as_ref().filter(|map| has_classes(object, map)).map(|map| Material {
            size: [map.width, map.height],
            colors: Cow::Borrowed(&map.colors),
            follows_relief: object.follows_relief && has_relief,
        });
        if !has_relief && !material.as_ref().is_some_and(Material::has_roughnesses) {
            return None;
        }
        let relief = field.map(|field| {
            let (wrap, atlas) = match field.border {
                Border::Wrap => (Wrap::Repeat, None),
                Border::Clamp => (Wrap::Clamp, None),
                Border::Tiles(layout) => (Wrap::Clamp, Some(AtlasSurface::new(&object.mesh, layout)?)),
            };
            Some(Relief {
                heights: Cow::Borrowed(&field.map),
                wrap,
                atlas,
                slopes: object.slopes.as_deref().map(Cow::Borrowed),
                spread: object.slope_spread.as_deref().map(Cow::Borrowed),
                moments: object.moments.as_ref().and_then(|moments| moments.levels.first()).map(Cow::Borrowed),
            })
        });
        let relief = match relief {
            Some(relief) => Some(relief?),
            None => None,
        };
        let is_atlas = relief.as_ref().is_some_and(|relief| relief.atlas.is_some());
        let rise_over_run = is_atlas || object.mesh.triangles && object.slopes.is_some();
        let stored = stored.filter(|_| !is_atlas);
        let repeat = if relief.is_none() || rise_over_run { DVec2::ONE } else { metres_per_repeat(&object.mesh)? };
        let scale = f64::from(object.height_scale) / repeat;
        // A flat surface may be raised later.
        let steepness = if height_scale == 0.0 { 1.0 } else { f64::from(height_scale.abs()) };
        Some(Self { relief, has_relief, material, scale, steepness, upside_down: object.height_scale < 0.0, stored })
    }

    /// Copies the maps.
    pub fn into_owned(self) -> ClassSources<'static> {
        let Self { relief, has_relief, material, scale, steepness, upside_down, stored } = self;
        let relief = relief.map(|Relief { heights, wrap, atlas, slopes, spread, moments }| Relief {
            heights: Cow::Owned(heights.into_owned()),
            wrap,
            atlas: atlas.map(AtlasSurface::into_owned),
            slopes: slopes.map(|slopes| Cow::Owned(slopes.into_owned())),
            spread: spread.map(|spread| Cow::Owned(spread.into_owned())),
            moments: moments.map(|moments| Cow::Owned(moments.into_owned())),
        });
        let material = material.map(|Material { size, colors, follows_relief }| Material {
            size,
            colors: Cow::Owned(colors.into_owned()),
            follows_relief,
        });
        ClassSources { relief, has_relief, material, scale, steepness, upside_down, stored }
    }

    /// Removes the classes of the file, if they are those of the surface: the relief is not inverted, and the material does not separate
    /// classes.
    pub(super) fn take_stored(&mut self) -> Option<StoredClasses> {
        let separates = |material: &Material<'_>| material.follows_relief || material.has_roughnesses();
        let applies = !self.upside_down && !self.material.as_ref().is_some_and(separates);
        self.stored.take().filter(|_| applies)
    }

    /// Returns the classes of a file as those of the surface.
    pub(super) fn with_stored(&self, StoredClasses { map, open }: StoredClasses) -> ObjectClasses {
        let colors = self.with_material(|material| ClassColors::of_map(&map, material?, self.skipped()));
        let facets = self.relief.as_ref().map(|relief| Facets::OfHeights(&relief.heights, relief.wrap));
        let local = facets.map(|facets| open.local(facets, &map, self.upside_down)).unwrap_or_default();
        ObjectClasses { map, open, slope_scale: self.scale, local, colors }
    }

    /// Finds the classes. Returns `None` for a single class.
    pub(super) fn find(&self) -> Option<ObjectClasses> {
        if let Some((relief, atlas)) = self.relief.as_ref().and_then(|relief| Some((relief, relief.atlas.as_ref()?))) {
            return self.find_in_atlas(relief, atlas);
        }
        let level = self.relief.as_ref().and_then(Relief::level);
        let facets = match (&self.relief, &level) {
            (Some(relief), Some(level)) => Facets::OfTexels(level, relief.wrap),
            (Some(relief), None) => Facets::OfHeights(&relief.heights, relief.wrap),
            (None, _) => Facets::Flat,
        };
        self.with_material(|material| {
            let searched = if self.has_relief { facets } else { Facets::Flat };
            let found = classes(searched, (self.steepness * self.scale).to_array(), material);
            if found.count() == 1 {
                return None;
            }
            let colors = material.and_then(|material| ClassColors::new(facets, &found, material, self.skipped()));
            if self.relief.is_none() {
                let (map, open) = smooth(found.count());
                return colors.map(|colors| ObjectClasses {
                    map,
                    open,
                    slope_scale: self.scale,
                    local: LocalOpenness::default(),
                    colors: Some(colors),
                });
            }
            let map = ClassMap::new(facets, &found, material);
            let open = Openness::new(facets, &found, material, map.units, self.upside_down);
            let local = open.local(facets, &map, self.upside_down);
            Some(ObjectClasses { map, open, slope_scale: self.scale, local, colors })
        })
    }

    fn find_in_atlas(&self, relief: &Relief<'_>, atlas: &AtlasSurface<'_>) -> Option<ObjectClasses> {
        let level = relief.level().unwrap_or_else(|| MomentLevel::of_heights(&relief.heights, relief.wrap));
        let AtlasRelief { level, windows } = atlas.relief(&relief.heights, level);
        self.with_material(|material| {
            let found = classes_of_windows(&windows, (self.steepness * self.scale).to_array(), material);
            if found.count() == 1 {
                return None;
            }
            let facets = Facets::OfTexels(&level, relief.wrap);
            let colors = material.and_then(|material| ClassColors::new(facets, &found, material, self.skipped()));
            let map = ClassMap::of_tiles(facets, &found, material, atlas.skipped());
            let open = Openness::of_windows(&windows, &found, material, map.units, self.upside_down);
            Some(ObjectClasses { map, open, slope_scale: self.scale, local: LocalOpenness::default(), colors })
        })
    }

    fn with_material<T>(&self, f: impl FnOnce(Option<&ClassMaterial<'_>>) -> T) -> T {
        let Some(Material { size, colors, follows_relief }) = &self.material else { return f(None) };
        let codes = Codes::new();
        let texel = |i: usize| {
            let [r, g, b, square] = codes.linear(colors[i]);
            [r, g, b, square.sqrt()]
        };
        f(Some(&ClassMaterial { size: *size, texel: &texel, follows_relief: *follows_relief }))
    }

    /// Returns the factors that convert slopes per texture coordinate to rise over run.
    pub(super) const fn scale(&self) -> DVec2 {
        self.scale
    }

    /// Returns the size of the finest level of the classes of the relief, if any.
    pub(super) fn relief_size(&self) -> Option<[u32; 2]> {
        self.relief.as_ref().map(|relief| {
            let skipped = relief.atlas.as_ref().map_or(0, AtlasSurface::skipped);
            [relief.heights.width, relief.heights.height].map(|side| side >> skipped)
        })
    }

    /// Returns the size of the colours, if any.
    pub(super) fn color_size(&self) -> Option<[u32; 2]> {
        self.material.as_ref().map(|material| material.size)
    }

    /// Returns how many of the finest colour levels have no class colours.
    pub(super) fn skipped(&self) -> usize {
        let side = self.material.as_ref().map_or(1, |material| material.size[0].max(material.size[1]));
        (0..).find(|skipped| side >> skipped <= MOST_TEXELS).unwrap_or(0)
    }

    /// Returns the cache key of the classes.
    pub(super) fn key(&self) -> u64 {
        fn sum<T: bytemuck::NoUninit>(values: &[T]) -> u64 {
            checksum(bytemuck::cast_slice(values))
        }
        let [x, y] = self.scale.to_array().map(f64::to_bits);
        let mut words = vec![x, y, self.steepness.to_bits(), u64::from(self.upside_down)];
        if let Some(Relief { heights, wrap, atlas, slopes, spread, moments }) = &self.relief {
            words.extend(atlas.iter().flat_map(AtlasSurface::key));
            let [width, height] = [heights.width, heights.height].map(u64::from);
            words.extend([1, width, height, u64::from(*wrap == Wrap::Clamp), sum(&heights.texels)]);
            words.push(slopes.as_ref().map_or(0, |slopes| sum(slopes)));
            words.push(spread.as_ref().map_or(0, |spread| sum(spread)));
            words.push(moments.as_ref().map_or(0, |moments| sum(&moments.texels)));
        }
        if let Some(Material { size: [width, height], colors, follows_relief }) = &self.material {
            words.extend([2, (*width).into(), (*height).into(), u64::from(*follows_relief), sum(colors)]);
        }
        let own = [include_str!("mod.rs"), include_str!("sources.rs"), include_str!("tiles.rs")];
        words.extend(CLASS_SOURCES.iter().chain(&own).map(|text| checksum(text.as_bytes())));
        sum(&words)
    }
}

impl Material<'_> {
    fn has_roughnesses(&self) -> bool {
        self.colors.iter().any(|color| color[3] != self.colors[0][3])
    }
}

impl Relief<'_> {
    /// Returns the moments of the slopes, or `None` if they are those of the heights.
    fn level(&self) -> Option<MomentLevel> {
        let map = &self.heights;
        if let Some(level) = &self.moments {
            return (!agrees(level, &MomentLevel::of_heights(map, self.wrap))).then(|| level.clone().into_owned());
        }
        let slopes = self.slopes.as_ref()?;
        let moments = |(i, &[x, y]): (usize, &[f32; 2])| {
            let [ss, tt, st] = self.spread.as_ref().map_or([0.0; 3], |spread| spread[i]);
            let second = [x * x + ss, y * y + tt];
            Moments { mean_slope: [x, y], second, cross: x * y + st, height: map.texels[i] }
        };
        let texels = slopes.iter().enumerate().map(moments).collect();
        Some(MomentLevel { width: map.width, height: map.height, texels })
    }
}

/// Whether classes can depend on the material of an object.
fn has_classes(object: &Object, map: &MaterialMap) -> bool {
    // With charts, or under projected relief, the colours have different texture coordinates from the heights. A measured material has its
    // own facet distribution.
    let lies_on_relief = object.charts.is_none() && object.mesh.triplanar.is_none() || object.heights.is_none();
    lies_on_relief
        && map.fit.is_none()
        && !map.colors.is_empty()
        && map.colors.len() == map.width as usize * map.height as usize
}

fn is_constant(heights: &[f32]) -> bool {
    heights.iter().all(|height| *height == heights[0])
}

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

/// Returns the size of a map repeat in metres along both texture coordinates, as the root mean square over patches.
fn metres_per_repeat(mesh: &PatchMesh) -> Option<DVec2> {
    if let Some(repeat) = mesh.triplanar {
        return Some(DVec2::splat(repeat.into()));
    }
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
