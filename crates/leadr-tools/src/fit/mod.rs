//! Pictures of fitted materials: spheres in one light, and cuts through lobes.

pub mod lobe_plot;
pub mod specimen;
pub mod spheres;
