//! Edge samples: silhouettes as smooth as with many samples per pixel, while most pixels are shaded once.
//!
//! The geometry is drawn again, with a grid of samples in every pixel, and with finer triangles where an object is small.
//! Several such images, each moved by a part of a grid cell, make up the requested number of samples. An edge sample that
//! sees the same surface as the pixel's own sample (the same object, in one plane with it) takes the pixel's shading, which
//! covers the pixel's whole footprint anyway. An edge sample that sees another surface, across a silhouette, is filtered
//! and shaded by itself, with the footprint of a whole pixel. The inside of a surface is thus shaded once, as without
//! edge samples but for the rounding of the G-buffer.
//!
//! The maps describe the surface around a point, but not which part of it is visible, nor how patches bend. Where a pixel's
//! footprint covers a quarter of an atlas patch or more, the edge samples that see the pixel's surface are therefore
//! filtered too, each with its part of the footprint, and their slope statistics are joined in the pixel's frame
//! ([`slope_turn`](leadr_reflectance::slopes::turn)) before the pixel is shaded. The transition begins at footprints of an
//! eighth of a patch.

mod join;
mod layout;
mod mark;
mod rays;

pub use join::{JoinKind, JoinPass};
pub use layout::{MAX_GRID, edge_grid, edge_tessellation};
pub use mark::EdgePass;
pub use rays::EdgeRays;
