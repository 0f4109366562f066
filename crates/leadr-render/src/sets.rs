//! The renderer's descriptor sets, grouped by lifetime. Set 0 is pushed, and holds the inputs and outputs of a pass. A frame has
//! one set for its light, and an object has one set for its mesh and maps.

use leadr_gpu::SetLayout;
use leadr_gpu::shaders::ResourceKind::{Sampled, Storage, Uniform};

/// The light of a scene, which all surfaces share: `layout(set = 1)` in `passes/shade`.
pub static SCENE: SetLayout = SetLayout {
    number: 1,
    name: "scene",
    resources: &[
        ("lighting", Uniform),
        ("Lamps", Storage),
        ("shadow_maps", Sampled),
        ("environment_cube", Sampled),
        ("environment_lobes", Sampled),
        ("irradiance_rest", Sampled),
        ("background_cube", Sampled),
        ("Harmonics", Storage),
        ("SkyVisibility", Storage),
        ("Energies", Storage),
        ("Fits", Storage),
        ("Media", Storage),
    ],
};

/// The mesh and the maps of an object: `layout(set = 2)` in `passes/geometry` and `passes/filter`. Placeholders replace missing
/// maps. Drivers allow 32 images in a stage, so an object without an atlas has the map of its height scale in `coarse_a`, the heights
/// of a detail that displaces in `coarse_b`, and the map of its clear coat in `coarse_light` and
/// `coarse_color`. An atlas with cones, which has no horizon, has the coarse levels of its cones in `horizon_a`.
pub static OBJECT: SetLayout = SetLayout {
    number: 2,
    name: "object",
    resources: &[
        ("Patches", Storage),
        ("EdgeHeights", Storage),
        ("VertexHeights", Storage),
        ("Charts", Storage),
        ("height_map", Sampled),
        ("moments_a", Sampled),
        ("moments_b", Sampled),
        ("horizon_a", Sampled),
        ("horizon_b", Sampled),
        ("color_map", Sampled),
        ("f0_map", Sampled),
        ("class_moments", Sampled),
        ("class_colors", Sampled),
        ("class_openness", Sampled),
        ("emission_map", Sampled),
        ("occlusion_map", Sampled),
        ("opacity_map", Sampled),
        ("Atlas", Storage),
        ("coarse_a", Sampled),
        ("coarse_b", Sampled),
        ("coarse_color", Sampled),
        ("coarse_f0", Sampled),
        ("coarse_light", Sampled),
        ("coarse_class_moments", Sampled),
        ("coarse_class_colors", Sampled),
        ("Detail", Storage),
        ("detail_a", Sampled),
        ("detail_b", Sampled),
        ("detail_colors", Sampled),
        ("detail_mask", Sampled),
    ],
};
