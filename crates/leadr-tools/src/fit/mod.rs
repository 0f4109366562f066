//! Pictures of fitted materials: spheres under the same light, and cuts through lobes.

pub mod lobe_plot;
pub mod specimen;
pub mod spheres;
