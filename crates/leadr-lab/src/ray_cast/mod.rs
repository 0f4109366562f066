//! Computes ground truth without a renderer. Rays are cast against displaced patches whose slopes have a prescribed mean and
//! covariance.
//!
//! A [`Tile`] is a periodic Gaussian height field of flat triangles, made by Fourier synthesis from a [`Spectrum`]. A
//! [`Patch`] stretches, shears and tilts a tile to match the slope moments exactly. A patch evaluates what a viewer sees:
//! areas, slopes, and the radiance of diffuse and specular facets under lights and environments, with and without shadows.
//! [`SphereTruth`] renders spheres with patches of relief. Blocked light is black, except in [`Patch::traced_light`], which follows further
//! bounces.
//!
//! Directions follow [`reflectance`](leadr_reflectance): they point away from the macrosurface, in its frame, with slopes `(−n.x/n.z,
//! −n.y/n.z)`.
//!
//! # Limits
//!
//! Rays need no offset and find no gaps, so nothing leaks at grazing angles beyond rounding. Three errors remain. First, one
//! tile is one surface, and its [`facing_area`](Patch::facing_area) deviates from the closed form (use several seeds).
//! Second, over a finite number `n` of correlation lengths, slopes are Gaussian only to about `n^−1/2`. Third, triangles
//! flatten details between lattice points. Moments are matched after the flattening, which therefore changes only the shape,
//! by the order of 1/`correlation`². `crates/leadr-lab/tests/lab/ray_cast.rs` measures the change.

mod cast;
mod patch;
mod sphere;
mod tile;

pub(super) use patch::cosine_direction;
pub use patch::{Estimate, Facet, Patch, SeenAndLit};
pub use sphere::{SphereError, SpherePixel, SphereTruth};
pub use tile::{Spectrum, Tile};
