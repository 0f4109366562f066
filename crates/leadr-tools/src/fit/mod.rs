//! Pictures of fitted materials, as spheres under the same light and as plots of lobes.

pub mod lobe_plot;
pub mod mean_difference;
pub mod models;
pub mod reflected;
pub mod specimen;
pub mod spheres;
