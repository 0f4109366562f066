//! Edge samples, which make silhouettes as smooth as many samples per pixel would, although most pixels are shaded only once.
//!
//! The geometry is drawn again with a grid of samples in every pixel, and with finer triangles on small objects. Several images
//! provide the requested number of samples, and each image is shifted by a fraction of a grid cell. An edge sample on the pixel's
//! own surface (the same object, in the same plane) takes the pixel's shading, which covers the whole footprint anyway. An edge
//! sample across a silhouette is filtered and shaded separately, with the footprint of a whole pixel. The inside of a surface is
//! shaded once. Compared with a frame without edge samples, it differs only by the rounding of the G-buffer.
//!
//! The maps describe the surface around a point, but not its visible area or the curvature of patches. If the footprint of a pixel
//! covers a quarter of an atlas patch or more, the edge samples on the pixel's surface are filtered too, each over its own fraction
//! of the footprint. The slope statistics of these samples are joined in the frame of the pixel
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
