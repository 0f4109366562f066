//! The images through which the passes exchange data.

mod begin;
mod gbuffer;
mod multisample;
mod radiance;
mod sample;
mod tiles;
mod visible_surface;

pub use begin::Begin;
pub use gbuffer::{FilteredPixel, GBuffer};
pub use multisample::MultisampleTargets;
pub use radiance::{JoinedEdges, RADIANCE_FORMAT};
pub use sample::SampleTargets;
pub use tiles::Tiles;
pub use visible_surface::{GeometryTargets, OBJECT_FORMAT, VisibleSurface};
