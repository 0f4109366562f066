//! Ground truth without a renderer: ray casts against displaced patches with prescribed slope mean and covariance.
//!
//! A [`Tile`] is a periodic Gaussian height field of flat triangles, made by Fourier synthesis from a [`Spectrum`]. A [`Patch`] stretches,
//! shears and tilts it to match the slope moments exactly. It evaluates what a viewer sees: areas, slopes, and the radiance of diffuse and
//! specular facets under lights and environments, with and without shadows. [`SphereTruth`] renders spheres with such relief. Light is
//! reflected once; blocked light is black.
//!
//! Directions follow [`reflectance`](leadr_reflectance): in the frame of the macrosurface, away from it, with slopes `(−n.x/n.z,
//! −n.y/n.z)`.
//!
//! # Limits
//!
//! Rays need no offset and meet no gap, so nothing leaks at grazing angles beyond rounding. Remaining errors: one tile is one surface, and
//! its [`facing_area`](Patch::facing_area) deviates from the closed form (use several seeds). Over a finite number `n` of correlation
//! lengths, slopes are Gaussian only to about `n^−1/2`. Triangles flatten details between lattice points. Moments are matched after that,
//! so only shape of the order of 1/`correlation`² is lost; `crates/leadr-lab/tests/lab/ray_cast.rs` measures it.

mod cast;
mod patch;
mod sphere;
mod tile;

pub(super) use patch::cosine_direction;
pub use patch::{Estimate, Facet, Patch, SeenAndLit};
pub use sphere::{SphereError, SpherePixel, SphereTruth};
pub use tile::{Spectrum, Tile};
