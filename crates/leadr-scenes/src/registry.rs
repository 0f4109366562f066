//! The table of scenes. Each row declares a name, a help line, choices and a constructor.
//!
//! The command line, its help, the reports and the bench use this table. A new scene needs a source file and a row here.

use std::fmt;

use serde::{Serialize, Serializer};

use Choice::{AtlasTile, Bare, Objects, Relief, Roughness, Stretch};

use super::deform::{self, Deformation};
use super::error::SceneError;
use super::height_scale::{upright, vary_height};
use super::model::{self, ModelChoice};
use super::ocean::sea;
use super::ocean::waves::Waves;
use super::shore::{self, shore_stage};
use super::stage::{BakedRelief, ReliefOptions, Stage, plane_stage, sphere_stage};
use super::trex::Trex;
use super::trex::stage::{SkinRelief, trex_stage, unbaked_body, vary_skin};
use super::{dressed, pillow, setting, snake, spheres};
use leadr_gpu::machine_memory;
use leadr_maps::HeightMap;
use leadr_maps::material::Material;
use leadr_render::scene::{FactorMap, Object, Tiling};
use leadr_render::surfaces::budget::Room;

/// A property of a scene that the user can choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// A height map or a material that replaces the generated ones.
    HeightMap,
    /// The roughness of the displaced surfaces.
    Roughness,
    /// The tile size of the displacement atlas.
    AtlasTile,
    /// Whether a relief displaces the surfaces, and its height.
    Relief,
    /// The triangulation, maps and shading of objects. Waves do not support curvature under a pixel, relief shadows and occlusion.
    Objects,
    /// The stretch of the objects.
    Stretch,
    /// Whether maps repeat.
    Tiling,
    /// Whether the setting around the surface is drawn.
    Bare,
    /// The waves of the sea.
    Waves,
    /// The materials, animations and cameras of a model file.
    Model,
    /// The folder of a model or a material.
    Folder,
    /// The relief of the T-rex's skin.
    Skin,
}

impl Choice {
    /// Returns the reason why a scene does not offer this choice, in a form that completes a sentence about the scene.
    fn lacking(self) -> &'static str {
        match self {
            Self::HeightMap => "has its own surfaces",
            Self::Roughness => "has its own roughness",
            Self::AtlasTile => "has no displacement atlas",
            Self::Relief => "has no height relief",
            Self::Objects => "has no objects, only waves",
            Self::Stretch => "is a sea and cannot be stretched",
            Self::Tiling => "has its own maps",
            Self::Bare => "cannot be drawn without its surroundings",
            Self::Waves => "has no sea",
            Self::Model => "is not a model",
            Self::Folder => "reads no folder and no height map",
            Self::Skin => "has no T-rex",
        }
    }
}

/// The inputs of the scene constructors.
#[derive(Clone, Debug)]
pub struct SceneOptions {
    /// One repeat of the heights, for scenes with [`Choice::HeightMap`]; with `None`, heights are generated.
    pub height_map: Option<HeightMap>,
    /// The slope moments and the height unit of a baked file.
    pub baked: Option<BakedRelief>,
    /// A complete material that replaces `height_map`.
    pub material: Option<Material>,
    /// Factors for the height scale over the images of the material, for scenes with [`Choice::Folder`].
    pub height_scale_map: Option<FactorMap>,
    /// The model of a model scene.
    pub model: Option<ModelChoice>,
    /// The height difference between map values 0 and 1, in metres; `None` uses the file's scale or the default. Materials have a height of
    /// their own.
    pub height: Option<f32>,
    /// The width of one repeat of heights and materials in metres; `None` uses the scene's default.
    pub repeat: Option<f32>,
    /// How maps are tiled, for scenes with [`Choice::Tiling`].
    pub tiling: Tiling,
    /// Whether scenes with [`Choice::Bare`] leave out the setting around the surface.
    pub bare: bool,
    /// The number of texels along an atlas tile, for scenes with [`Choice::AtlasTile`]: a power of two, 8 to 128.
    pub atlas_tile: u32,
    /// How the height of the skin varies, for scenes with [`Choice::Skin`].
    pub skin_relief: SkinRelief,
    /// The sea of scenes with [`Choice::Waves`]; `None` uses the scene's default.
    pub waves: Option<Waves>,
    /// The memory limit for the maps. The limit is checked before slow bakes.
    pub room: Option<Room>,
}

/// The memory in bytes per texel that the bake of the T-rex's atlas needs. Tiles of 128 texels need 4.5 GB in total.
const TREX_BAKING: u64 = 46;

impl SceneOptions {
    /// Refuses an object whose maps exceed the memory of the device, or whose construction exceeds the memory of the machine. `making` is
    /// the memory for the construction in bytes per height texel. Only the sizes of the maps are used.
    fn room_for(&self, object: Object, making: u64, remedy: &'static str) -> Result<(), SceneError> {
        let Some(room) = self.room else { return Ok(()) };
        let texels =
            object.heights.as_ref().map_or(0, |field| u64::from(field.map.width) * u64::from(field.map.height));
        let what = format!("the maps of {}", object.name);
        room.check(&[object])?;
        let needs = texels * making;
        match machine_memory() {
            Some(left) if left < needs => Err(SceneError::Memory { what, needs, left, remedy }),
            _ => Ok(()),
        }
    }

    /// Refuses a T-rex that needs too much memory.
    fn room_for_trex(&self) -> Result<(), SceneError> {
        self.room_for(unbaked_body(self.atlas_tile), TREX_BAKING, "a smaller --atlas-tile")
    }
}

impl Default for SceneOptions {
    /// Returns options with generated heights, fine tiles and the default sea.
    fn default() -> Self {
        Self {
            height_map: None,
            baked: None,
            material: None,
            height_scale_map: None,
            model: None,
            height: None,
            repeat: None,
            tiling: Tiling::Repeats,
            bare: false,
            atlas_tile: 64,
            skin_relief: SkinRelief::Even,
            waves: None,
            room: None,
        }
    }
}

/// A callback that receives the completed fraction of a scene, from 0 to 1, from any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) + Sync);

/// A scene that is declared by one row of [`SCENES`].
pub struct NamedScene {
    /// The name of the scene on the command line and in reports.
    pub name: &'static str,
    /// The description of the scene for the command's help.
    pub help: &'static str,
    /// The properties of the scene that the user can choose.
    pub choices: &'static [Choice],
    /// The default sea of the scene, if it has one.
    pub sea: Option<fn() -> Waves>,
    /// Returns the label of the slow construction step with atlas tiles of this size, which is shown with its progress.
    pub making: Option<fn(u32) -> &'static str>,
    make: fn(SceneOptions, Progress<'_>) -> Result<Stage, SceneError>,
}

const fn scene(
    name: &'static str,
    help: &'static str,
    choices: &'static [Choice],
    make: fn(SceneOptions, Progress<'_>) -> Result<Stage, SceneError>,
) -> NamedScene {
    NamedScene { name, help, choices, sea: None, making: None, make }
}

/// All scenes in the order of the help. The first scene is the default.
pub static SCENES: [NamedScene; 11] = [
    NamedScene {
        making: Some(making_the_trex),
        ..scene("trex", "A displaced T-rex walks over dry ground", &WITH_SKIN, |options, progress| {
            options.room_for_trex()?;
            let mut stage = trex_stage(options.atlas_tile, progress)?;
            vary_skin(&mut stage.objects, options.skin_relief);
            Ok(stage)
        })
    },
    scene(
        "plane",
        "A square plane with a height map, in a kerb",
        &[Choice::HeightMap, Choice::Folder, Relief, Objects, Stretch, Roughness, Choice::Tiling, Bare],
        |mut options, _| {
            let (bare, tiling) = (options.bare, options.tiling);
            let mut stage = match &options.material {
                Some(material) => {
                    // The memory is checked before the material is resampled to the finest texels.
                    options.room_for(dressed::placeholder_plane(material), dressed::DRESSING, "smaller maps")?;
                    dressed::plane_stage(material, options.repeat)
                }
                None => plane_stage(relief(&mut options)),
            };
            stage.objects.iter_mut().for_each(|plane| plane.tiling = tiling);
            if let Some(map) = options.height_scale_map {
                vary_height(&mut stage.objects, upright(map))?;
            }
            Ok(if bare { stage } else { setting::around_plane(stage) })
        },
    ),
    scene(
        "sphere",
        "A sphere with a height map, on a plinth",
        &[Choice::HeightMap, Choice::Folder, AtlasTile, Relief, Objects, Stretch, Roughness, Bare],
        |mut options, _| {
            let bare = options.bare;
            let stage = match &options.material {
                Some(material) => {
                    let scale = options.height_scale_map.as_ref();
                    dressed::scaled_sphere_stage(material, options.repeat, options.atlas_tile, scale)
                }
                None => sphere_stage(relief(&mut options)),
            };
            Ok(if bare { stage } else { setting::around_sphere(stage) })
        },
    ),
    scene("spheres", "Sixteen spheres of known roughness", &SHAPES, |_, _| Ok(spheres::grid::stage())),
    scene("stretch", "A quad, a sphere and a cylinder that are stretched and squeezed", &SHAPES, |_, _| {
        Ok(setting::on_ground(deform::stage(Deformation::Stretch), deform::FLOOR))
    }),
    scene("shear", "A quad, a sphere and a cylinder that are sheared", &SHAPES, |_, _| {
        Ok(setting::on_ground(deform::stage(Deformation::Shear), deform::FLOOR))
    }),
    scene("height-scale", "A quad, a sphere and a cylinder whose bumps sink until they are smooth", &SHAPES, |_, _| {
        Ok(setting::on_ground(deform::stage(Deformation::HeightScale), deform::FLOOR))
    }),
    scene("pillow", "A quilted cushion", &IN_TILES, |options, _| Ok(pillow::stage(options.atlas_tile))),
    scene("snake", "A coiled snake among four lamps", &IN_TILES, |options, _| Ok(snake::stage(options.atlas_tile))),
    NamedScene {
        sea: Some(Waves::default),
        ..scene("ocean", "The open sea under a wind of 8 m/s", &[Choice::Waves], |options, _| {
            Ok(sea::stage(options.waves.unwrap_or_default().ocean()))
        })
    },
    NamedScene {
        sea: Some(shore::waves),
        making: Some(making_the_trex),
        ..scene(
            "shore",
            "The T-rex on a beach with the sea behind it",
            &[AtlasTile, Relief, Objects, Roughness, Choice::Waves, Choice::Skin],
            |options, progress| {
                options.room_for_trex()?;
                let waves = options.waves.unwrap_or_else(shore::waves);
                let mut stage = shore_stage(options.atlas_tile, &waves, progress)?;
                vary_skin(&mut stage.objects, options.skin_relief);
                Ok(stage)
            },
        )
    },
];

/// The choices of scenes with displaced objects. The longer list also includes atlas tiles.
const SHAPES: [Choice; 4] = [Relief, Objects, Stretch, Roughness];
const IN_TILES: [Choice; 5] = [AtlasTile, Relief, Objects, Stretch, Roughness];
const WITH_SKIN: [Choice; 6] = [AtlasTile, Relief, Objects, Stretch, Roughness, Choice::Skin];

/// The scene of a glTF file.
pub static MODEL: NamedScene = scene(
    "model",
    "A glTF model on open ground",
    &[Choice::Model, Choice::Folder, Relief, Objects, Stretch, Bare],
    |options, _| match options.model {
        Some(choice) => {
            let mut stage = model::stage(choice)?;
            if let Some(map) = options.height_scale_map {
                vary_height(&mut stage.objects, map)?;
            }
            Ok(stage)
        }
        None => Err(SceneError::Model("no model file is given; use --scene FILE.glb".into())),
    },
);

const FIRST_TILE: u32 = 8;

fn making_the_trex(tile: u32) -> &'static str {
    if Trex::is_kept(tile) { "reading the T-rex" } else { "making the T-rex (once; then it is cached)" }
}

fn relief(options: &mut SceneOptions) -> ReliefOptions {
    let (map, baked, scale) = (options.height_map.take(), options.baked.take(), options.height_scale_map.clone());
    let SceneOptions { height, repeat, atlas_tile: tile, .. } = *options;
    ReliefOptions { map, baked, height, repeat, tile, scale, ..ReliefOptions::default() }
}

impl NamedScene {
    /// Finds a scene by name, in upper or lower case.
    pub fn find(name: &str) -> Option<&'static Self> {
        SCENES.iter().find(|scene| scene.name.eq_ignore_ascii_case(name))
    }

    /// Whether the scene offers this choice.
    pub fn offers(&self, choice: Choice) -> bool {
        self.choices.contains(&choice)
    }

    /// Refuses a `flag` if the scene does not offer its choice.
    ///
    /// # Errors
    /// Returns a sentence that names the scenes that offer the choice.
    pub fn check_offers(&self, flag: &str, choice: Choice) -> Result<(), String> {
        if self.offers(choice) {
            return Ok(());
        }
        if choice == Choice::Model {
            return Err(format!("{flag} is for models: --scene FILE.glb or FILE.gltf"));
        }
        let names = choice.scenes().collect::<Vec<_>>().join(", ");
        let models = if MODEL.offers(choice) { " and for models" } else { "" };
        Err(format!("{flag} is for the scenes {names}{models}; {} {}", self.name, choice.lacking()))
    }

    /// Returns the default sea. For scenes without a default sea, returns the open sea.
    pub fn waves(&self) -> Waves {
        self.sea.map_or_else(Waves::default, |waves| waves())
    }

    /// Returns the tile size of a quick first picture, before tiles of `tile` texels are ready. The finer relief becomes roughness, so
    /// small bumps look the same. Returns `None` if the scene has no atlas, or if the finer atlas is not cached.
    pub fn first_tile(&self, tile: u32) -> Option<u32> {
        let at_hand = self.making.is_none() || Trex::is_kept(tile);
        (self.offers(AtlasTile) && tile > FIRST_TILE && at_hand).then_some(FIRST_TILE)
    }

    /// Builds the scene's stage.
    ///
    /// # Errors
    /// If options are invalid or memory is too small.
    pub fn stage(&self, options: SceneOptions, progress: Progress<'_>) -> Result<Stage, SceneError> {
        (self.make)(options, progress)
    }
}

impl Choice {
    /// Lists the scenes that offer this choice, in the order of [`SCENES`].
    pub fn scenes(self) -> impl Iterator<Item = &'static str> {
        SCENES.iter().filter(move |scene| scene.offers(self)).map(|scene| scene.name)
    }
}

impl PartialEq for NamedScene {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for NamedScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Serialize for NamedScene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_pictures_have_coarser_atlases() {
        let first = |name: &str, tile: u32| NamedScene::find(name).unwrap().first_tile(tile);
        assert_eq!(first("sphere", 64), Some(FIRST_TILE));
        // These scenes have no atlas, or no coarser atlas.
        assert_eq!([first("plane", 64), first("sphere", FIRST_TILE)], [None, None]);
        // An atlas that is not cached is baked before the first picture. No cache has tiles of this size.
        assert_eq!(first("trex", 1024), None);
        assert_eq!(making_the_trex(1024), "making the T-rex (once; then it is cached)");
    }

    #[test]
    fn names_are_unique_and_found() {
        for scene in &SCENES {
            assert_eq!(NamedScene::find(scene.name), Some(scene));
            assert_eq!(NamedScene::find(&scene.name.to_uppercase()), Some(scene));
            assert_eq!(SCENES.iter().filter(|s| s.name == scene.name).count(), 1);
        }
        assert_eq!(NamedScene::find("cube"), None);
    }

    #[test]
    fn scenes_offer_options_of_their_surfaces() {
        // The T-rex scenes are skipped because their bake takes minutes.
        for scene in SCENES.iter().filter(|scene| scene.making.is_none()) {
            let waves = scene.sea.map(|waves| Waves { fft: 64, ..waves() });
            let options = SceneOptions { atlas_tile: 8, waves, ..Default::default() };
            let mut stage = scene.stage(options, &|_| ()).unwrap();
            let displaced = stage.objects.iter().any(|object| object.heights.is_some());
            for choice in [Roughness, Relief] {
                assert_eq!(scene.offers(choice), displaced, "{scene:?} {choice:?}");
            }
            assert_eq!(scene.offers(Objects), !stage.objects.is_empty(), "{scene:?}");
            assert_eq!(scene.offers(Stretch), stage.ocean.is_none(), "{scene:?}");
            assert_eq!(scene.sea.is_some(), stage.ocean.is_some(), "{scene:?}");
            assert_eq!(scene.offers(Choice::Waves), stage.ocean.is_some(), "{scene:?}");
            stage.set_roughness(0.5);
            for object in stage.objects.iter().filter(|object| object.heights.is_some()) {
                let meshes = std::iter::once(&object.mesh).chain(&object.coarse_mesh);
                let mut colors = meshes.flat_map(|mesh| &mesh.colors);
                assert!(colors.all(|color| color[3] == 0.5), "{scene:?}: {}", object.name);
                let map = object.material.iter().flat_map(|map| &map.colors);
                assert!(map.into_iter().all(|texel| texel[3] == 255), "{scene:?}: {}", object.name);
            }
        }
    }
}
