//! An [`Object`] on the device.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use glam::{Vec2, Vec3};

use super::atlas::AtlasGpu;
use super::classes::{ClassImages, ObjectClasses};
use super::detail::{DetailImages, DetailKind};
use super::displacement::{Border, BoundaryHeights, HeightField};
use super::fits::Fits;
use super::flat;
use super::height_scale::{DetailHeights, HeightScaleImage, HeightTerms, HeightTermsRecord, field_of, height_terms_of};
use super::horizon::{HorizonInput, HorizonMaps};
use super::material::{Bases, CutoutKind, MaterialFeatures, MaterialImages, address_mode};
use super::media::Media;
use super::moments::{LeadrMapGpu, MomentFormat, field_maps};
use super::patch_mesh::PatchMesh;
use super::placeholders::Placeholders;
use super::records::{ObjectRecordGpu, Shown};
use super::topology::Topology;
use crate::constants::{
    CHARTS, DETAIL_TRIPLANAR, FLAG_CHARTED, FLAG_DISPLACED, FLAG_FLAT, FLAG_MARK_INSIDE, FLAG_MASK, FLAG_ONE_VARIANT,
    FLAG_TINTED_EMISSION, FLAG_TRIANGLES, FLAG_TRIPLANAR,
};
use crate::scene::{CoatRelief, Detail, DetailMapping, MaterialMap, Object, Tiling, TriangleCharts};
use crate::sets::OBJECT;
use leadr_gpu::{
    AddressMode, Buffer, Descriptor, Filter, Gpu, GpuError, Image, Memory, ResourceSet, Result, Sampler, shared_struct,
};
use leadr_maps::LeadrMap;
use leadr_maps::cache::MapCache;
use leadr_maps::checksum::checksum;
use leadr_maps::material::TextureWrap;

shared_struct! {
    /// A patch in the layout of the shaders (`PatchData`).
    pub struct PatchGpu for "PatchData" {
        /// The vertices at the corners.
        pub vertices: [u32; 4],
        /// The number `edge << 1 | backwards` for each side, in the order v=0, u=1, v=1, u=0.
        pub edges: [u32; 4],
        /// The texture coordinates of corners 0 and 1, then of corners 3 and 2, and the bounds of texture samples. For a triangle
        /// with triplanar relief, the corners at rest with their normals (`RestTriangle`).
        pub mapping: [[f32; 4]; 3],
    }
}

/// Packs the position and the normal of a corner at rest. The position is in repeats. The octahedral normal has twelve bits per
/// coordinate, in a float that represents 24 bits exactly.
fn rest_corner(position: Vec3, normal: Vec3, repeat: f32) -> [f32; 4] {
    let n = normal / normal.abs().element_sum().max(1e-12);
    let folded = (1.0 - Vec2::new(n.y, n.x).abs()) * Vec2::new(1f32.copysign(n.x), 1f32.copysign(n.y));
    let octahedron = if n.z < 0.0 { folded } else { n.truncate() };
    let code = ((octahedron * 0.5 + 0.5) * 4095.0).round().clamp(Vec2::ZERO, Vec2::splat(4095.0));
    (position / repeat).extend(code.x * 4096.0 + code.y).to_array()
}

/// The number of corners of a triangle in all charts together.
const CHART_CORNERS: usize = 3 * CHARTS as usize;

shared_struct! {
    /// The texture coordinates of a triangle in the images of its material (`TriangleCharts`).
    pub struct ChartsGpu for "TriangleCharts" {
        /// The texture coordinates of the three corners in each chart, in the order of the `CHART_` constants.
        pub corners: [[f32; 2]; CHART_CORNERS],
    }
}

impl ChartsGpu {
    fn of(charts: &TriangleCharts) -> Self {
        let mut corners = [[0.0; 2]; CHART_CORNERS];
        corners.iter_mut().zip(charts.as_flattened()).for_each(|(slot, corner)| *slot = corner.to_array());
        Self { corners }
    }
}

/// The data of an object that stay the same in all frames.
pub struct GpuObject {
    /// The object of the scene, whose height texels are dropped after the upload.
    pub object: Object,
    /// The edges of the mesh.
    pub topology: Topology,
    pub(super) height_range: Vec<[f32; 2]>,
    /// The height range of the object, before scaling.
    relief: f32,
    pub(super) edge_texels: Vec<f32>,
    pub(super) edge_relief: Vec<f32>,
    terms: HeightTermsRecord,
    /// The maps, which are shared with the coarser mesh, and with objects that have [the same maps](with_same_maps).
    pub maps: Arc<ObjectMaps>,
    /// The descriptor set of the mesh and the maps.
    pub set: ResourceSet,
    /// The buffers in the set that belong to the mesh: patches, edge heights and vertex heights.
    buffers: [Buffer; 3],
    /// The inputs that the filter pass fetches for this object.
    pub kind: SurfaceKind,
    /// The inputs for frames that shade the relief by classes of facets, if there are several classes and they are known.
    by_class: OnceLock<ByClass>,
    /// The number of the measured material, counted from 1, or 0 without one.
    fit: u32,
    /// The number of the medium, counted from 1, or 0 without one.
    medium: u32,
}

/// The inputs for an object that is shaded by classes of facets.
pub struct ByClass {
    /// The inputs that the filter pass fetches.
    pub kind: SurfaceKind,
    /// The descriptor set of the mesh, the maps and the classes.
    pub set: ResourceSet,
    images: ClassImages,
}

/// The maps of an object.
pub struct ObjectMaps {
    /// The LEADR maps. Smooth objects have a placeholder with one texel.
    pub leadr: LeadrMapGpu,
    /// The horizon maps, which describe how the relief occludes itself. Smooth objects have placeholders.
    horizons: HorizonMaps,
    /// The links and the coarse levels, for filtering across the borders of tiles.
    atlas: AtlasGpu,
    material: MaterialImages,
    /// The texture coordinates of the triangles in the material, or a placeholder if they equal those of the mesh.
    charts: Buffer,
    /// The repeating detail relief. Objects without a detail have placeholders.
    detail: Arc<DetailImages>,
    /// The map of the height scale.
    height_scale: Option<HeightScaleImage>,
    sampler: Sampler,
    of_coarse_levels: Sampler,
}

/// What is needed to make the maps of objects.
#[derive(Clone, Copy)]
pub struct Upload<'a> {
    /// A cache for map data that is slow to compute.
    pub cache: Option<&'a MapCache>,
    /// The format in which the slopes are stored.
    pub format: MomentFormat,
    /// The measured materials of the scene.
    pub fits: &'a Fits,
    /// The media behind the surfaces of the scene.
    pub media: &'a Media,
    /// The placeholders for missing maps.
    pub none: &'a Placeholders,
}

/// The properties of an object that determine the inputs of its filter pass. Each kind has its own pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SurfaceKind {
    /// Whether the maps are an atlas with one tile per patch.
    pub tiled: bool,
    /// Whether the object has relief.
    pub displaced: bool,
    /// Whether the object has a material map.
    pub colored: bool,
    /// The inputs that the material has besides its colours.
    pub features: MaterialFeatures,
    /// Whether the material has its own texture coordinates.
    pub charted: bool,
    /// Whether the classes of the relief differ in colour or roughness.
    pub class_colors: bool,
    /// The number of rows of taps across the footprint in the slope and material maps. With a single row, pixels would blur into their
    /// neighbours, which is visible where two roughnesses meet.
    pub tap_rows: i32,
    /// Whether the bumps of the object can occlude the environment.
    pub horizon: bool,
    /// Whether the mesh is a plane with affine texture coordinates.
    pub flat: bool,
    /// Whether the patches are triangles.
    pub triangles: bool,
    /// Whether the relief uses triplanar mapping.
    pub triplanar: bool,
    /// Whether the maps are tiled by example.
    pub by_example: bool,
    /// Whether the surface is open ground with drifts and paths.
    pub ground: bool,
    /// Whether only front faces are drawn.
    pub front_only: bool,
    /// Whether slopes are stored as rise over run instead of per unit of texture coordinate.
    pub rise_over_run: bool,
    /// Whether all vertices have the same colour and accessibility.
    pub plain: bool,
    /// The inputs that come from a detail relief.
    pub detail: DetailKind,
    /// What scales and adds to the heights of the map, as `HEIGHT_` bits.
    pub height_terms: u32,
}

impl SurfaceKind {
    /// Returns the kind of an object that is drawn with `mesh`, which is its own mesh or its coarse mesh.
    pub fn of(object: &Object, mesh: &PatchMesh) -> Self {
        let detail = DetailKind::of(object.detail.as_ref());
        let tiles = object.heights.as_ref().is_some_and(|heights| matches!(heights.border, Border::Tiles(_)));
        let flat = !mesh.triangles && detail.mapping != DETAIL_TRIPLANAR && flat::is_flat(mesh);
        let repeats = object.heights.as_ref().is_none_or(|heights| heights.border == Border::Wrap)
            && object.slope_wrap.is_none_or(|wrap| wrap == [TextureWrap::Repeat; 2])
            && object.material.as_ref().is_none_or(|map| map.wrap == [TextureWrap::Repeat; 2]);
        let by_example =
            object.tiling != Tiling::Repeats && (flat || mesh.is_seamless()) && repeats && object.charts.is_none();
        let features = object.material.as_ref().map_or_else(MaterialFeatures::default, MaterialFeatures::of);
        Self {
            tiled: tiles,
            displaced: object.heights.is_some(),
            colored: object.material.is_some(),
            features: MaterialFeatures {
                bases: Bases {
                    classes: 1,
                    coat: object.coat.is_some(),
                    transmits: object.medium.is_some(),
                    ..features.bases
                },
                ..features
            },
            charted: object.charts.is_some(),
            class_colors: false,
            tap_rows: 1,
            horizon: object.height_scale != 0.0
                && object.material.as_ref().is_none_or(|map| map.cones.is_none())
                && object
                    .heights
                    .as_ref()
                    .is_some_and(|field| field.map.texels.iter().any(|h| *h != field.map.texels[0])),
            flat,
            triangles: mesh.triangles,
            triplanar: mesh.triplanar.is_some() && object.heights.is_some(),
            by_example,
            ground: by_example && flat && object.tiling == Tiling::Ground,
            front_only: object.front_only,
            rise_over_run: mesh.triangles && object.slopes.is_some(),
            plain: flat::is_plain(mesh),
            detail,
            height_terms: height_terms_of(object, mesh),
        }
    }
}

impl SurfaceKind {
    /// Returns the kind of the object if it is shaded by these classes.
    #[must_use]
    pub fn with_classes(self, classes: &ObjectClasses) -> Self {
        let bases = Bases { classes: classes.count(), ..self.features.bases };
        Self {
            features: MaterialFeatures { bases, ..self.features },
            class_colors: classes.colors.is_some(),
            tap_rows: if classes.has_sharp_roughness() { 3 } else { 1 },
            ..self
        }
    }

    /// Returns the kind of this surface at a factor on its heights. A relief without height has the `plain` kind, unless its classes
    /// differ in material.
    #[must_use]
    pub fn at_height(self, factor: f32, plain: Self) -> Self {
        if factor != 0.0 || self.class_colors { self } else { plain }
    }

    /// Whether the surface has several classes of facets.
    pub fn has_classes(self) -> bool {
        self.features.bases.classes > 1
    }

    /// Whether the device samples the heights by example, which includes the heights at edges.
    pub fn displaced_by_example(self) -> bool {
        self.displaced && self.by_example
    }
}

/// The data for displacing one of the meshes of an object.
struct Carrier {
    topology: Topology,
    boundary: BoundaryHeights,
    terms: HeightTermsRecord,
}

impl Carrier {
    fn of(
        mesh: &PatchMesh,
        topology: Topology,
        object: &Object,
        detail: Option<&DetailHeights>,
        kind: SurfaceKind,
    ) -> Self {
        let texels = object.height_scale_map.as_ref().map(field_of);
        let size = object
            .heights
            .as_ref()
            .map_or(Vec2::ONE, |field| Vec2::new(field.map.width as f32, field.map.height as f32));
        let terms = HeightTerms::new(mesh, texels.as_ref().zip(object.height_scale_map.as_ref()), detail, size);
        let boundary = match &object.heights {
            Some(field) if kind.by_example => BoundaryHeights::by_example(mesh, &topology, field, &terms),
            Some(field) => BoundaryHeights::bake(mesh, &topology, field, &terms),
            None => BoundaryHeights::none(),
        };
        Self { topology, boundary, terms: terms.record() }
    }
}

/// The source data of an object's maps, which are dropped after the upload.
struct MapSources {
    slopes: Option<Vec<[f32; 2]>>,
    slope_spread: Option<Vec<[f32; 3]>>,
    moments: Option<LeadrMap>,
    detail: Option<Detail>,
    material: Option<MaterialMap>,
    charts: Option<Vec<TriangleCharts>>,
}

impl MapSources {
    /// Moves the source data out of an object.
    fn take(object: &mut Object) -> Self {
        Self {
            slopes: object.slopes.take(),
            slope_spread: object.slope_spread.take(),
            moments: object.moments.take(),
            detail: object.detail.take(),
            material: object.material.take(),
            charts: object.charts.take(),
        }
    }
}

impl ObjectMaps {
    /// Uploads the maps of an object, for its finer mesh.
    fn upload(
        gpu: &Arc<Gpu>,
        object: &Object,
        sources: MapSources,
        topology: &Topology,
        kind: SurfaceKind,
        Upload { cache, format, none, .. }: Upload<'_>,
    ) -> Result<Self> {
        let (name, field) = (&object.name, object.heights.as_ref());
        let MapSources { slopes, slope_spread, moments, detail, material, charts } = sources;
        // The material of an object without relief repeats.
        let border = field.map_or(Border::Wrap, |field| field.border);
        let sum = cache.map_or(0, |_| relief_checksum(field, slopes.as_ref(), moments.as_ref()));
        let (leadr, material) = rayon::join(
            || match field {
                Some(field) => field_maps(gpu, field, slopes, slope_spread, moments, format),
                None => Ok(none.leadr.clone()),
            },
            || match material {
                Some(map) => MaterialImages::new(gpu, name, map, border, &none.material),
                None => Ok(none.material.clone()),
            },
        );
        let (leadr, material) = (leadr?, material?);
        let detail = match detail {
            Some(detail) if detail.displaces && (kind.tiled || kind.triplanar || !kind.displaced) => {
                let fault = "a detail displaces only relief over texture coordinates that do not end at each patch";
                return Err(GpuError::usage(name.clone(), fault));
            }
            Some(detail) => Arc::new(DetailImages::new(gpu, name, detail, &object.mesh, border, &none.material)?),
            None => none.detail.clone(),
        };
        let charts: Vec<ChartsGpu> = charts.unwrap_or_default().iter().map(ChartsGpu::of).collect();
        let charts = if charts.is_empty() { vec![ChartsGpu { corners: [[0.0; 2]; CHART_CORNERS] }] } else { charts };
        let atlas = match border {
            Border::Tiles(layout) => {
                let material = kind.colored.then_some(&material);
                AtlasGpu::new(gpu, name, &object.mesh, topology, layout, &leadr, material, &none.atlas)?
            }
            Border::Wrap | Border::Clamp => none.atlas.clone(),
        };
        let horizons = if kind.horizon {
            let relief = HorizonInput { mesh: &object.mesh, topology, border, height_scale: object.height_scale };
            HorizonMaps::new(gpu, name, &leadr, &relief, cache.map(|cache| (cache, sum)))?
        } else {
            none.horizons.clone()
        };
        let height_scale = match &object.height_scale_map {
            Some(_) if kind.tiled || kind.triplanar => {
                let fault = "a map of the height scale needs texture coordinates that do not end at each patch";
                return Err(GpuError::usage(name.clone(), fault));
            }
            Some(map) if kind.displaced => Some(HeightScaleImage::new(gpu, name, map)?),
            _ => None,
        };
        let mode = if border == Border::Wrap { AddressMode::Repeat } else { AddressMode::ClampToEdge };
        let modes = object.slope_wrap.map_or([mode; 2], |wrap| wrap.map(address_mode));
        Ok(Self {
            leadr,
            horizons,
            atlas,
            material,
            charts: Buffer::from_slice(gpu, &format!("{name} charts"), &charts)?,
            detail,
            height_scale,
            sampler: Sampler::with_modes(gpu, Filter::Trilinear, modes)?,
            of_coarse_levels: Sampler::new(gpu, Filter::Bilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Returns the images and the layout buffers, with their names in the shaders.
    fn bindings<'a>(&'a self, classes: &'a ClassImages) -> Vec<(&'static str, Descriptor<'a>)> {
        let Self { leadr, horizons, atlas, material, detail, sampler, of_coarse_levels, .. } = self;
        let [colors, emission, occlusion, opacity] = &material.samplers;
        let coarse = [(&atlas.light, of_coarse_levels), (&atlas.color, of_coarse_levels)];
        let [coarse_light, coarse_color] =
            material.coat.as_ref().map_or(coarse, |[first, second]| [(first, colors), (second, colors)]);
        let coarse_a = self.height_scale.as_ref();
        let coarse_a = coarse_a.map_or((&atlas.slopes, of_coarse_levels), |map| (&map.image, &map.sampler));
        let coarse_b =
            if detail.displaces { (&detail.maps.heights, &detail.sampler) } else { (&atlas.joint, of_coarse_levels) };
        let horizon_a = atlas.cones.as_ref().map_or((&horizons.leans, sampler), |cones| (cones, of_coarse_levels));
        let images: [(&str, &Image, &Sampler); 24] = [
            ("height_map", &leadr.heights, sampler),
            ("moments_a", &leadr.slopes, sampler),
            ("moments_b", &leadr.joint, sampler),
            ("horizon_a", horizon_a.0, horizon_a.1),
            ("horizon_b", &horizons.correlations, sampler),
            ("color_map", &material.color, colors),
            ("f0_map", &material.f0, colors),
            ("class_moments", &classes.moments, sampler),
            ("class_colors", &classes.colors, colors),
            ("class_openness", &classes.open, of_coarse_levels),
            ("emission_map", &material.emission, emission),
            ("occlusion_map", &material.occlusion, occlusion),
            ("opacity_map", &material.opacity, opacity),
            ("coarse_a", coarse_a.0, coarse_a.1),
            ("coarse_b", coarse_b.0, coarse_b.1),
            ("coarse_color", coarse_color.0, coarse_color.1),
            ("coarse_f0", &atlas.f0, of_coarse_levels),
            ("coarse_light", coarse_light.0, coarse_light.1),
            ("coarse_class_moments", &classes.coarse_moments, of_coarse_levels),
            ("coarse_class_colors", &classes.coarse_colors, of_coarse_levels),
            ("detail_a", &detail.maps.slopes, &detail.sampler),
            ("detail_b", &detail.maps.joint, &detail.sampler),
            ("detail_colors", &detail.material.color, &detail.sampler),
            ("detail_mask", &detail.mask, &detail.sampler),
        ];
        let images =
            images.into_iter().map(|(name, image, sampler)| (name, Descriptor::Sampled(image.whole(), sampler)));
        let layouts = [("Atlas", &atlas.links), ("Detail", &detail.layout)];
        images.chain(layouts.map(|(name, buffer)| (name, Descriptor::Storage(buffer)))).collect()
    }
}

impl GpuObject {
    /// Uploads an object. Builds its LEADR maps, unless `maps` already contains them. A coarser mesh shares the maps.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if there is a coarser mesh, but the maps depend on the finer mesh.
    pub fn upload(
        gpu: &Arc<Gpu>,
        mut object: Object,
        upload: Upload<'_>,
        maps: Option<Arc<ObjectMaps>>,
    ) -> Result<(Self, Option<Self>)> {
        let coarse_mesh = object.coarse_mesh.take();
        if coarse_mesh.is_some() && follows_its_mesh(&object) {
            let fault = "a coarser mesh cannot share maps made for the patches of the finer mesh".to_owned();
            return Err(GpuError::Usage { name: object.name, fault });
        }
        let kind = SurfaceKind::of(&object, &object.mesh);
        let coarse = coarse_mesh.map(|mesh| (SurfaceKind::of(&object, &mesh), mesh));
        let numbers = [upload.fits.number_of(&object), upload.media.number_of(&object)];
        let detail = DetailHeights::of(&object);
        let maps = match maps {
            Some(maps) => Ok(maps),
            None => Err(MapSources::take(&mut object)),
        };
        let topology = Topology::new(&object.mesh.welded_patches());
        let carry = |mesh: &PatchMesh, topology, kind| Carrier::of(mesh, topology, &object, detail.as_ref(), kind);
        let (maps, (carrier, coarse)) = rayon::join(
            || maps.or_else(|sources| ObjectMaps::upload(gpu, &object, sources, &topology, kind, upload).map(Arc::new)),
            || {
                let of_coarse = |(kind, mesh): (SurfaceKind, PatchMesh)| {
                    let carrier = carry(&mesh, Topology::new(&mesh.welded_patches()), kind);
                    (kind, carrier, mesh)
                };
                (carry(&object.mesh, topology.clone(), kind), coarse.map(of_coarse))
            },
        );
        let maps = maps?;
        // The device now has the height texels, so the CPU's copy is freed.
        object.heights.iter_mut().for_each(|field| field.map.texels = Vec::new());
        object.height_scale_map.iter_mut().for_each(|map| map.texels = Vec::new());
        let none = &upload.none.classes;
        let coarse = coarse.map(|(kind, carrier, mesh)| {
            let object = Object { mesh, ..object.clone() };
            Self::with_maps(gpu, object, numbers, kind, carrier, maps.clone(), none)
        });
        let coarse = coarse.transpose()?;
        Ok((Self::with_maps(gpu, object, numbers, kind, carrier, maps, none)?, coarse))
    }

    fn with_maps(
        gpu: &Arc<Gpu>,
        object: Object,
        [fit, medium]: [u32; 2],
        kind: SurfaceKind,
        Carrier { topology, boundary, terms }: Carrier,
        maps: Arc<ObjectMaps>,
        no_classes: &ClassImages,
    ) -> Result<Self> {
        let name = &object.name;
        let (low, high) =
            boundary.patch_range.iter().fold((0.0f32, 0.0f32), |(low, high), r| (low.min(r[0]), high.max(r[1])));
        let patches = Buffer::from_slice(gpu, &format!("{name} patches"), &patches(&object, &topology))?;
        let edges = Buffer::from_slice(gpu, &format!("{name} edge heights"), &boundary.edges)?;
        let vertices = Buffer::from_slice(gpu, &format!("{name} vertex heights"), &boundary.vertices)?;
        let buffers = [patches, edges, vertices];
        Ok(Self {
            set: set_of(gpu, &buffers, &maps, no_classes)?,
            buffers,
            by_class: OnceLock::new(),
            relief: high - low,
            height_range: boundary.patch_range,
            edge_texels: boundary.edge_texels,
            edge_relief: boundary.edge_relief,
            topology,
            terms,
            object,
            maps,
            kind,
            fit,
            medium,
        })
    }

    /// Adds the classes of the object, which has none yet. `images` are those of `classes`.
    pub fn add_classes(&self, gpu: &Arc<Gpu>, kind: SurfaceKind, images: ClassImages) -> Result<()> {
        let set = set_of(gpu, &self.buffers, &self.maps, &images)?;
        self.by_class.get_or_init(|| ByClass { kind, set, images });
        Ok(())
    }

    /// Returns the inputs for frames that shade by classes, if several classes are known.
    pub fn by_class(&self) -> Option<&ByClass> {
        self.by_class.get()
    }

    /// Creates a buffer that the CPU writes every frame, with room for `count` values (at least one) of `bytes` bytes each.
    pub(super) fn frame_buffer(&self, gpu: &Arc<Gpu>, what: &str, count: usize, bytes: usize) -> Result<Buffer> {
        let name = format!("{} {what}", self.object.name);
        Buffer::new(gpu, &name, (count.max(1) * bytes) as u64, Memory::Upload)
    }

    /// Returns the record of the object in a frame that uses these classes. Only the fields that do not depend on the pose are set.
    pub(super) fn record(&self, shown: &Shown, by_class: Option<&ByClass>) -> ObjectRecordGpu {
        let flags = [
            (FLAG_DISPLACED, self.kind.displaced),
            (FLAG_FLAT, self.kind.flat),
            (FLAG_MARK_INSIDE, shown.mark_inside),
            (FLAG_TINTED_EMISSION, self.object.tints_emission),
            (FLAG_TRIANGLES, self.kind.triangles),
            (FLAG_TRIPLANAR, self.kind.triplanar),
            (FLAG_CHARTED, self.kind.charted),
            (FLAG_ONE_VARIANT, self.object.tiling == Tiling::OneVariant),
            (FLAG_MASK, self.kind.features.cutout == Some(CutoutKind::Mask)),
        ];
        let height_scale = shown.height_scale * self.object.height_scale;
        let record = by_class.map_or_else(bytemuck::Zeroable::zeroed, |ByClass { images, .. }| ObjectRecordGpu {
            class_centers: images.centers,
            class_unit: images.unit,
            class_correlation: images.correlation,
            class_sky_depth: images.sky_depths(shown.height_scale * self.terms.typical),
            ..bytemuck::Zeroable::zeroed()
        });
        ObjectRecordGpu {
            height_scale,
            specular_f0: self.object.specular_f0,
            flags: flags.iter().filter(|(_, set)| *set).fold(0, |flags, (flag, _)| flags | flag),
            fit: self.fit,
            edge_tint: edge_tint_bits(self.object.edge_tint),
            medium: self.medium,
            coat: self.object.coat.map_or([0.0; 4], |coat| {
                [coat.weight, coat.alpha, if coat.relief == CoatRelief::Smooth { 1.0 } else { 0.0 }, 0.0]
            }),
            relief: self.relief * height_scale.abs(),
            scale_lod: self.terms.lod,
            scale_offset: self.terms.offset,
            scale_linear: self.terms.linear,
            detail_unit: self.terms.detail_unit,
            detail_lod: self.terms.detail_lod,
            ..record
        }
    }
}

/// Creates the descriptor set of an object from the buffers of its mesh, its maps and its classes.
fn set_of(gpu: &Arc<Gpu>, buffers: &[Buffer; 3], maps: &ObjectMaps, classes: &ClassImages) -> Result<ResourceSet> {
    let [patches, edges, vertices] = buffers;
    let buffers = [("Patches", patches), ("EdgeHeights", edges), ("VertexHeights", vertices), ("Charts", &maps.charts)];
    let buffers = buffers.map(|(name, buffer)| (name, Descriptor::Storage(buffer)));
    ResourceSet::new(gpu, &OBJECT, &[&buffers[..], &maps.bindings(classes)[..]].concat())
}

/// Returns, for each object, the index of the first earlier object that has the same maps.
pub fn with_same_maps(objects: &[Object]) -> Vec<Option<usize>> {
    // Comparing each object with all earlier ones would take quadratic time.
    let mut known: HashMap<_, Vec<usize>> = HashMap::new();
    let first = |(index, object): (usize, &Object)| {
        let map = object.heights.as_ref().filter(|_| is_relief_alone(object)).map(|field| &field.map)?;
        let sampled = map.texels.iter().step_by((map.texels.len() / SAMPLED).max(1)).map(|height| height.to_bits());
        let alike = known.entry((map.width, map.height, sampled.collect::<Vec<_>>())).or_default();
        let found = alike.iter().copied().find(|&earlier| have_same_maps(&objects[earlier], object));
        if found.is_none() {
            alike.push(index);
        }
        found
    };
    objects.iter().enumerate().map(first).collect()
}

/// Number of heights that are compared before all of them.
const SAMPLED: usize = 64;

/// Whether the relief of an object has no other maps.
fn is_relief_alone(object: &Object) -> bool {
    let others = [object.slopes.is_some(), object.slope_spread.is_some(), object.moments.is_some()];
    let materials = [
        object.material.is_some(),
        object.detail.is_some(),
        object.charts.is_some(),
        object.height_scale_map.is_some(),
    ];
    !others.into_iter().chain(materials).any(|there| there)
}

/// Whether two objects have the same maps. The objects must have a relief and no material, and may differ only in the height scale.
fn have_same_maps(a: &Object, b: &Object) -> bool {
    let (Some(of_a), Some(of_b)) = (&a.heights, &b.heights) else { return false };
    // Filtering crosses tiles, so the maps of an atlas depend on the mesh.
    let same_surface = |a: &PatchMesh, b: &PatchMesh| {
        a.patches == b.patches && a.positions == b.positions && a.normals == b.normals && a.texcoords == b.texcoords
    };
    is_relief_alone(a)
        && is_relief_alone(b)
        && of_a.border == of_b.border
        && a.slope_wrap == b.slope_wrap
        && a.height_scale.partial_cmp(&0.0) == b.height_scale.partial_cmp(&0.0)
        && (!matches!(of_a.border, Border::Tiles(_)) || same_surface(&a.mesh, &b.mesh))
        && !of_a.map.texels.is_empty()
        && of_a.map == of_b.map
}

/// Whether the maps of an object depend on the patches of its mesh.
fn follows_its_mesh(object: &Object) -> bool {
    let tiled = object.heights.as_ref().is_some_and(|field| matches!(field.border, Border::Tiles(_)));
    let at_rest = object.detail.as_ref().is_some_and(|detail| matches!(detail.mapping, DetailMapping::Triplanar(_)));
    tiled || at_rest || object.charts.is_some()
}

/// Returns the patches of an object in the layout of the shaders.
fn patches(object: &Object, topology: &Topology) -> Vec<PatchGpu> {
    let mesh = &object.mesh;
    let patch = |(i, (&vertices, &edges)): (usize, (&[u32; 4], &[u32; 4]))| {
        if let Some(repeat) = mesh.triplanar {
            let corner = |k: usize| {
                let vertex = vertices[k] as usize;
                rest_corner(mesh.positions[vertex], mesh.normals[vertex], repeat)
            };
            return PatchGpu { vertices, edges, mapping: [0, 1, 3].map(corner) };
        }
        let t = mesh.texcoords.get(i).copied().unwrap_or_default();
        let tile = match &object.heights {
            Some(HeightField { map, border: Border::Tiles(layout) }) => {
                let (x, y) = layout.origin(i as u32);
                let (w, h) = (map.width as f32, map.height as f32);
                let end = |k: u32| (k + layout.tile) as f32;
                [x as f32 / w, y as f32 / h, end(x) / w, end(y) / h]
            }
            _ => [-1e9, -1e9, 1e9, 1e9],
        };
        let [first_row, second_row] = [[t[0], t[1]], [t[3], t[2]]].map(|[a, b]| [a.x, a.y, b.x, b.y]);
        PatchGpu { vertices, edges, mapping: [first_row, second_row, tile] }
    };
    mesh.patches.iter().zip(&topology.patch_edges).enumerate().map(patch).collect()
}

/// Packs an edge tint, whose values are from 0 to 4, into five bits per channel.
fn edge_tint_bits(edge_tint: [f32; 3]) -> u32 {
    let code = |edge_tint: f32| (edge_tint * (31.0 / 4.0)).round().clamp(0.0, 31.0) as u32;
    code(edge_tint[0]) | code(edge_tint[1]) << 5 | code(edge_tint[2]) << 10
}

/// Returns a checksum of what the horizons of a relief depend on: the heights, and the slopes or moments if any.
fn relief_checksum(field: Option<&HeightField>, slopes: Option<&Vec<[f32; 2]>>, moments: Option<&LeadrMap>) -> u64 {
    let of_levels =
        moments.iter().flat_map(|map| &map.levels).map(|level| checksum(bytemuck::cast_slice(&level.texels)));
    let mut sums: Vec<u64> = of_levels.collect();
    sums.extend(field.map(|field| checksum(bytemuck::cast_slice(&field.map.texels))));
    sums.extend(slopes.map(|slopes| checksum(bytemuck::cast_slice(slopes))));
    // If there are only heights, the result is the checksum of the heights.
    if sums.len() == 1 { sums[0] } else { checksum(bytemuck::cast_slice(&sums)) }
}
