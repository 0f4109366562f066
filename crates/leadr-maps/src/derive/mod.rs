//! Maps derived from other maps: heights from normals, heights between coarse codes, ambient visibility, and visibility cones (Chan 2018, "Material Advances
//! in Call of Duty: WWII", section 4).
//!
//! Texels are square. Slopes are rise over run, along `s` and along `t`, which points down. Heights are in texture widths,
//! or are converted by a factor. Directions are `[x along s, y along t, z out of the surface]`.

mod classes;
mod heights;
mod local_openness;
mod occlusion;
mod openness;
pub mod quantisation;
mod reach;
mod sky_depths;
mod slopes;
mod spectral;
mod sweep;
mod usual;

pub(crate) use classes::{CORNERS, Cell, Facet, FacetsAt, MaterialAt};
pub use classes::{ClassMaterial, Classes, Facets, classes, classes_of_count, classes_of_windows};
pub use heights::{Integrated, Integration, heights_of_slopes};
pub use local_openness::{LocalLevel, LocalOpenness};
pub use occlusion::{About, Occlusion, SLICES, VisibilityMap, visibility};
pub use openness::{OPENNESS_SIDE, Openness, OpennessWindow, WindowFacet};
pub use slopes::{Difference, SlopeFaults, Slopes, slopes_of_heights};
pub use usual::{USUAL_HEIGHT, USUAL_SLOPE, usual_scale, usual_scale_of_slope};
