//! Fits of measured materials, seen: spheres in one light, and cuts through their lobes.

pub mod lobe_plot;
pub mod specimen;
pub mod spheres;
