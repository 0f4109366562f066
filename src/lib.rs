//! A raw-Vulkan renderer in which displaced surfaces keep their look at every distance (LEADR mapping).
//!
//! A displacement map that is minified loses its bumps, and with them the way it scattered light. LEADR mapping
//! (Dupuy et al. 2013) stores, beside each displacement texel, the first two moments of its slopes. They filter
//! linearly, so hardware mip mapping turns vanished bumps into roughness: mean slope and slope covariance at the scale of a pixel
//! feed an anisotropic, off-centre Beckmann microfacet BRDF with a view-dependent projected area.
//!
//! # The floors
//!
//! Modules only use the floors below them; `tests/layers.rs` fails on an upward arrow.
//!
//! | floor | module | holds |
//! |---|---|---|
//! | 1 | [`reflectance`] | pure mathematics: slope statistics, microfacet terms, BRDFs, quadrature. No files, no GPU |
//! | 2 | [`maps`] | textures on the CPU: load, validate, derive, mip, compare, save |
//! | 2 | [`gpu`] | Vulkan, and nothing else. Knows no BRDF |
//! | 3 | [`render`] | the passes, and the frame that orders them |
//! | 4 | [`scenes`] | pure functions of time that produce what the renderer draws |
//! | 5 | [`app`] | the `leadr` command |
//!
//! Conventions everywhere: metres, z up; linear Rec. 709 radiance; `wi` to the light, `wo` to the viewer, `wh` their
//! half vector, `wn` a micronormal, in the macro tangent frame unless the name says `world_`.

pub mod app;
pub mod gpu;
pub mod maps;
pub mod reflectance;
pub mod render;
pub mod scenes;
