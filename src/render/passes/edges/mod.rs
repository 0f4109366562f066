//! Edge samples: outlines as smooth as of many samples, at one shaded sample per pixel.
//!
//! The geometry is drawn again with a grid of samples in every pixel, as often as it takes, each time moved by a part of the
//! grid's cell, with finer triangles where an object is small. Where such an edge sample sees the surface that the pixel's own sample
//! sees (the same object, in one plane with it), the pixel's shading is used again: it is that of the pixel's whole footprint
//! anyway. What sees another surface, across an outline, is filtered and shaded, each with the footprint of a whole pixel. So
//! the inside of a surface is shaded once, bit for bit as without edge samples.
//!
//! But maps know what lies beside a place, not what is seen of it, nor how patches bend. Where the footprint of a pixel is a
//! quarter of a patch of an atlas or more (less joins a part, from an eighth on), the edge samples that see the pixel's surface
//! are filtered, each with its part of the footprint, and their slope statistics joined in the pixel's frame
//! ([`slope_turn`](crate::reflectance::slopes::turn)) before the pixel is shaded, once.

mod join;
mod layout;
mod mark;
mod rays;

pub use join::{JoinKind, JoinLight, JoinPass};
pub use layout::{MAX_GRID, PixelArea, edge_grid, edge_tessellation};
pub use mark::EdgePass;
pub use rays::EdgeRays;
