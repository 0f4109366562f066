//! The images that passes hand to each other.

mod gbuffer;
mod radiance;
mod tiles;
mod visible_surface;

pub use gbuffer::{FilteredPixel, GBuffer};
pub use radiance::{JoinedEdges, RADIANCE_FORMAT};
pub use tiles::Tiles;
pub use visible_surface::VisibleSurface;
