//! Edge samples, which make silhouettes as smooth as many samples per pixel, while most pixels are shaded once.
//!
//! The geometry is drawn again with a grid of samples in every pixel, and with finer triangles on small objects. Several images,
//! each shifted by a fraction of a grid cell, provide the requested number of samples. An edge sample on the pixel's own surface
//! (the same object, in the same plane) takes the pixel's shading, which covers the whole footprint anyway. An edge sample across a
//! silhouette is filtered and shaded separately, with the footprint of a whole pixel. The inside of a surface is shaded once; only
//! the rounding of the G-buffer differs from a frame without edge samples.
//!
//! The maps describe the surface around a point, but neither its visible area nor the curvature of patches. If a pixel's footprint
//! covers a quarter of an atlas patch or more, the edge samples on the pixel's surface are filtered too, each over its own fraction
//! of the footprint. The slope statistics of these samples are joined in the pixel's frame
//! ([`slopes::rotation`](leadr_reflectance::slopes::rotation)) before shading. The transition begins at footprints of an eighth of
//! a patch.

mod join;
mod layout;
mod mark;
mod rays;

pub use join::{JoinKind, JoinPass};
pub use layout::{MAX_GRID, edge_grid, edge_tessellation};
pub use mark::EdgePass;
pub use rays::EdgeRays;
