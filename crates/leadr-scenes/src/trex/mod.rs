//! The walking Tyrannosaurus. The shape of the animal is a distance field, and the skin is a function of the rest position. Shape and skin
//! are baked into a patch mesh with one displacement tile per patch.

mod atlas;
mod attach;
mod baked;
#[cfg(test)]
mod baked_tests;
mod cage;
mod dual;
mod gait;
mod noise;
mod parts;
mod primitive;
mod props;
mod relax;
mod sdf;
mod skeleton;
mod skin;
pub mod stage;
pub mod walk;
mod weights;

use crate::error::SceneError;
use crate::registry::Progress;
use crate::sphere::layout_tiles;
use baked::Baked;
use leadr_maps::cache::MapCache;
use leadr_maps::checksum::checksum;
use leadr_render::surfaces::patch_mesh::{PatchMesh, TileLayout};
use sdf::TrexSdf;
use skin::Skin;

/// The source text of the generator. Any change of this text changes the cache key.
const SOURCES: [&str; 15] = [
    include_str!("atlas.rs"),
    include_str!("baked.rs"),
    include_str!("cage.rs"),
    include_str!("dual.rs"),
    include_str!("mod.rs"),
    include_str!("noise.rs"),
    include_str!("parts.rs"),
    include_str!("primitive.rs"),
    include_str!("relax.rs"),
    include_str!("sdf.rs"),
    include_str!("skin.rs"),
    include_str!("weights.rs"),
    include_str!("../sphere.rs"),
    leadr_maps::noise::SOURCE,
    leadr_render::surfaces::patch::SOURCE,
];

/// The animal in its bind pose, ready for the renderer.
pub struct Trex {
    /// The body mesh, displaced by the atlas, with texture coordinates and skin weights.
    pub body: PatchMesh,
    /// The layout of the atlas, with one tile per patch of the body.
    pub layout: TileLayout,
    /// The displacement along the patch normal in metres, in rows.
    pub heights: Vec<f32>,
    /// The sRGB-encoded albedo (rgb) and the linear Beckmann `α` (a), in rows.
    pub colors: Vec<[u8; 4]>,
    /// Teeth, claws, eyes, tongue and fingers. The props are not displaced, have a colour per vertex, and are each attached rigidly to one
    /// joint.
    pub props: PatchMesh,
    /// The props with fewer patches, for distances at which the patches of `props` are smaller than pixels.
    pub coarse_props: PatchMesh,
}

/// Hashes the generator's source and the tile size.
fn key(tile: u32) -> u64 {
    let sums: Vec<u64> = SOURCES.iter().map(|s| checksum(s.as_bytes())).chain([u64::from(tile)]).collect();
    checksum(bytemuck::cast_slice(&sums))
}

/// Returns the name of the entry in the cache.
fn kind(tile: u32) -> String {
    format!("trex-{tile}")
}

fn generate(tile: u32, progress: Progress<'_>) -> Baked {
    let (sdf, skin) = (TrexSdf::new(), Skin::new());
    let mut body = cage::build(&sdf);
    let layout = layout_tiles(&mut body, tile);
    // The vertices have the mean colour of the skin, for drawing without the atlas.
    body.colors = body
        .positions
        .iter()
        .map(|&p| skin.shade(p, &skin::SkinPoint { height: 0.001, top: 0.7, fold: 0.0 }, 0.0))
        .collect();
    let (heights, colors) = atlas::bake(&sdf, &skin, &body, &layout, progress);
    Baked { body, layout, heights, colors }
}

impl Trex {
    /// Loads the animal with tiles of `tile` texels from the cache, or bakes and caches it. Tiles of 64 texels give full detail, and tiles
    /// of 16 a preview. `progress` receives the completed fraction, in `[0, 1]`, from any thread.
    ///
    /// A damaged, unreadable or unwritable cache only causes a warning.
    ///
    /// # Errors
    /// [`SceneError::Tile`] if the tile size is invalid.
    pub fn load(tile: u32, progress: Progress<'_>) -> Result<Self, SceneError> {
        Self::load_from(MapCache::of_user().as_ref(), tile, progress)
    }

    /// Whether the user's cache contains an animal with tiles of this size.
    pub fn is_kept(tile: u32) -> bool {
        MapCache::of_user().is_some_and(|cache| cache.holds(&kind(tile), key(tile)))
    }

    /// Like [`Self::load`], but with an optional cache.
    pub fn load_from(cache: Option<&MapCache>, tile: u32, progress: Progress<'_>) -> Result<Self, SceneError> {
        if !(tile.is_power_of_two() && (8..=128).contains(&tile)) {
            return Err(SceneError::Tile(tile));
        }
        let Some(cache) = cache else { return Ok(Self::assemble(generate(tile, progress))) };
        let read = |content: &[u8]| Baked::from_bytes(content, tile).inspect(|_| progress(1.0));
        let make = || {
            let baked = generate(tile, progress);
            let content = baked.to_bytes();
            debug_assert!(Baked::from_bytes(&content, tile).is_ok());
            Ok((baked, content))
        };
        cache.load_or_make(&kind(tile), key(tile), baked::most_bytes(tile), read, make).map(Self::assemble)
    }

    fn assemble(Baked { body, layout, heights, colors }: Baked) -> Self {
        let [props, coarse_props] = [props::Detail::Fine, props::Detail::Coarse].map(|detail| {
            let mut props = props::build(&Skin::new(), detail);
            attach::attach(&mut props, &body);
            props
        });
        Self { body, layout, heights, colors, props, coarse_props }
    }
}
