//! Ground truth without a renderer: rays cast against displaced patches whose slopes have a prescribed mean and covariance.
//!
//! A [`Tile`] is a periodic Gaussian height field made by Fourier synthesis from a [`Spectrum`], of flat triangles. A
//! [`Patch`] stretches, shears and tilts it so that its slopes have exactly the wanted moments, and answers what a viewer sees:
//! areas, slopes, the radiance of diffuse facets and of mirrors under lights and environments, with shadows and without.
//! [`SphereTruth`] makes pictures of spheres with such relief. Light is reflected once; what is blocked is black.
//!
//! Directions are those of [`reflectance`](leadr_reflectance): in the frame of the macrosurface, away from it, slopes
//! `(−n.x/n.z, −n.y/n.z)`.
//!
//! # What limits it
//!
//! Rays need no offset and meet no gap, so nothing leaks at grazing angles beyond rounding. Errors that remain: one tile
//! is one surface (its own [`facing_area`](Patch::facing_area) strays from the closed form; use several seeds), over a
//! finite number `n` of correlation lengths slopes are Gaussian only to about `n^−1/2`, and triangles flatten
//! what is between lattice points (moments are met after that, so only the order of 1/`correlation`² of shape is
//! lost; `crates/leadr-lab/tests/lab/ray_cast.rs` measures it).

mod cast;
mod patch;
mod sphere;
mod tile;

pub(super) use patch::cosine_direction;
pub use patch::{Estimate, Facet, Patch, SeenAndLit};
pub use sphere::{SphereError, SpherePixel, SphereTruth};
pub use tile::{Spectrum, Tile};
