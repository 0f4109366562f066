//! A raw-Vulkan renderer for displaced surfaces whose appearance does not change with distance (LEADR mapping).
//!
//! A minified displacement map loses its bumps, and therefore loses the light that the bumps scatter. LEADR mapping (Dupuy et al. 2013)
//! stores the first two moments of slopes with each displacement texel. Moments filter linearly, so mip mapping turns vanished bumps into
//! roughness. The mean slope and slope covariance under a pixel are the parameters of an anisotropic, off-centre Beckmann BRDF with a
//! view-dependent projected area.
//!
//! # Crates
//!
//! Each part is a separate crate, and this crate re-exports all of them. A program that needs a single part can depend on the crate of this
//! part alone.
//!
//! | module | crate | contents |
//! |---|---|---|
//! | [`reflectance`] | `leadr-reflectance` | the mathematics: slopes, microfacets, masking, materials, integrals |
//! | [`maps`] | `leadr-maps` | textures on the CPU: load, derive, filter, save |
//! | [`measured`] | `leadr-measured` | files of measured reflectance and of fits |
//! | [`models`] | `leadr-models` | glTF files |
//! | [`gpu`] | `leadr-gpu` | a thin layer over Vulkan |
//! | [`render`] | `leadr-render` | the renderer: a `Renderer` draws a `FrameState` of `Object`s under an `Environment` |
//! | [`scenes`] | `leadr-scenes` | ready-made scenes: a `Stage` each |
//! | – | `leadr-textures` | filtered textures of models for other engines |
//! | `command` | this one, feature `cli` | the `leadr` command; feature `window` (default) adds its window |
//!
//! `examples/00_first_picture.rs` renders a picture. `ARCHITECTURE.md` describes the inside of the crates.
//!
//! # Moments under minification
//!
//! When a map of corrugated iron covers less than one pixel, its height and mean slope average to 0, but its roughness remains:
//!
//! ```
//! use std::f32::consts::TAU;
//! use leadr_maps::{HeightMap, LeadrMap, Wrap};
//!
//! // Eight waves across a map of 256 texels, amplitude 0.01 in units of the map's side.
//! let wave = |i: u32| 0.01 * (TAU * 8.0 * (i % 256) as f32 / 256.0).sin();
//! let iron = HeightMap::new(256, 256, (0..256 * 256).map(wave).collect())?;
//! let leadr = LeadrMap::new(&iron, Wrap::Repeat);
//!
//! // The last mip level is one texel. The slopes of a sine have the variance (2π · 8 · 0.01)² / 2 across the waves
//! // and none along them.
//! let far = leadr.mean();
//! let [across, along, covariance] = far.slope_covariance();
//! assert!(far.height.abs() < 1e-6 && far.mean_slope[0].abs() < 1e-6);
//! assert!((across / 0.1263 - 1.0).abs() < 0.02);
//! assert!(along.abs() < 1e-6 && covariance.abs() < 1e-6);
//! # Ok::<(), leadr_maps::MapFault>(())
//! ```
//!
//! Lengths are in metres, and z is up. Radiance is linear Rec. 709. `wi` points to the light and `wo` to the viewer, `wh` is the half
//! vector of both, and `wn` is a micronormal. Vectors are in the macro tangent frame unless their name begins with `world_`.

// The panel painter calls Vulkan. No other module allows unsafe code.
#![deny(unsafe_code)]

pub use glam;
pub use {
    leadr_gpu as gpu, leadr_maps as maps, leadr_measured as measured, leadr_models as models,
    leadr_reflectance as reflectance, leadr_render as render, leadr_scenes as scenes,
};

pub use leadr_render::open_gpu;

#[cfg(feature = "cli")]
mod app;

pub use self::{
    gpu::{Gpu, GpuError, GpuOptions},
    maps::{save::save_png, tonemap::Tonemap},
    reflectance::masking::shadowing::Shadowing,
    render::{
        camera::Camera,
        frame::{FrameOutput, Layer, PassTime, PausedFrame, PreparedFrame, Renderer},
        light::{
            environment::Environment,
            panorama::{EnvironmentLight, LightExtraction},
            sky::Sky,
        },
        passes::accumulate::Accumulation,
        scene::{FrameState, MAX_LAMPS, MaterialMap, Object, PointLight, Pose, Scene, Sun},
        settings::{DiffuseLights, Probes, Quadrature, RenderSettings, Shading, ShadingOptions, Technique, Terms},
        surfaces::{
            displacement::{Border, HeightField},
            ocean::Ocean,
            patch_mesh::{PatchMesh, SkinWeights},
            tessellation::TessellationSettings,
        },
    },
    scenes::{
        error::SceneError,
        ocean::waves::Waves,
        registry::{Choice, NamedScene, SCENES, SceneOptions},
        stage::{Lights, Stage, Views},
    },
};

/// The `leadr` command, for programs that embed it.
#[cfg(feature = "cli")]
pub mod command {
    pub use crate::app::run;
}

/// The window of `leadr demo`, for programs that show their own scenes.
#[cfg(feature = "window")]
pub mod window {
    pub use crate::app::demo::orbit::Orbit;
    pub use crate::app::demo::window::show::{Animations, OneScene, Show};
    pub use crate::app::demo::window::surroundings::Surroundings;
    pub use crate::app::demo::window::{Display, WindowOptions, run};
}
