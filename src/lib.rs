//! A raw-Vulkan renderer in which displaced surfaces keep their look at every distance (LEADR mapping).
//!
//! A displacement map that is minified loses its bumps, and with them the way it scattered light. LEADR mapping
//! (Dupuy et al. 2013) stores, beside each displacement texel, the first two moments of its slopes. They filter
//! linearly, so mip mapping turns vanished bumps into roughness: mean slope and slope covariance
//! at a pixel's scale feed an anisotropic, off-centre Beckmann microfacet BRDF with a view-dependent projected area.
//!
//! # What is here
//!
//! | feature | gives |
//! |---|---|
//! | none | [`reflectance`]: the mathematics; [`maps`]: textures on the CPU; [`measured`]: measured materials; [`models`]: glTF files. No Vulkan, no shader compiler |
//! | `gpu` | the renderer below: a `Renderer` draws a `FrameState` of `Object`s under an `Environment`; `Stage`s are ready-made scenes |
//! | `cli` | the laboratory and the `leadr` command (`command::run`) |
//! | `window` (default) | its window |
//!
//! Each feature contains the ones above it. `examples/00_first_picture.rs` renders a picture; `ARCHITECTURE.md` tells how the
//! crate is built inside.
//!
//! # What a map keeps
//!
//! Seen from far away, corrugated iron has no height and no mean slope left, but all of its roughness:
//!
//! ```
//! use std::f32::consts::TAU;
//! use leadr::maps::{HeightMap, LeadrMap, Wrap};
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
//! # Ok::<(), leadr::maps::MapFault>(())
//! ```
//!
//! Conventions everywhere: metres, z up; linear Rec. 709 radiance; `wi` to the light, `wo` to the viewer, `wh` their
//! half vector, `wn` a micronormal, in the macro tangent frame unless the name says `world_`.

// Vulkan is the only reason for unsafe code: floor 2 and what draws the panel.
#![deny(unsafe_code)]
#![cfg_attr(
    not(feature = "internals"),
    allow(dead_code, unused_imports, reason = "tests and examples use what the crate itself does not")
)]

pub mod maps;
pub mod measured;
pub mod models;
pub mod reflectance;

// The floors below are for this crate alone; its tests and examples see them through the feature `internals`.
#[cfg(all(feature = "cli", feature = "internals"))]
#[doc(hidden)]
pub mod app;
#[cfg(all(feature = "cli", not(feature = "internals")))]
mod app;
#[cfg(all(feature = "gpu", feature = "internals"))]
#[doc(hidden)]
pub mod gpu;
#[cfg(all(feature = "gpu", not(feature = "internals")))]
mod gpu;
#[cfg(all(feature = "cli", feature = "internals"))]
#[doc(hidden)]
pub mod lab;
#[cfg(all(feature = "cli", not(feature = "internals")))]
mod lab;
#[cfg(all(feature = "gpu", feature = "internals"))]
#[doc(hidden)]
pub mod render;
#[cfg(all(feature = "gpu", not(feature = "internals")))]
mod render;
#[cfg(all(feature = "gpu", feature = "internals"))]
#[doc(hidden)]
pub mod scenes;
#[cfg(all(feature = "gpu", not(feature = "internals")))]
mod scenes;

/// Vectors and matrices of the renderer.
#[cfg(feature = "gpu")]
pub use glam;

#[cfg(feature = "gpu")]
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
        scene::{FrameState, MAX_POINT_LIGHTS, MaterialMap, Object, PointLight, Pose, Scene, Sun},
        settings::{
            DiffuseLights, Integral, Probes, Quadrature, RenderSettings, Shading, ShadingOptions, Technique, Terms,
        },
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
        registry::{Choice, SCENES, Scene as NamedScene, SceneOptions},
        stage::{Lights, Stage, Views},
    },
};

/// The `leadr` command, for programs that contain it.
#[cfg(feature = "cli")]
pub mod command {
    pub use crate::app::run;
}
