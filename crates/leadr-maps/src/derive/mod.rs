//! Maps made of other maps: heights of normals, what heights hide of the sky, and the cone that is left (Chan 2018, "Material Advances in
//! Call of Duty: WWII", section 4).
//!
//! Texels are square. Slopes are rise over run, along `s` and `t` (down). Heights are in widths of the texture, or become so by a factor.
//! Directions are `[x along s, y along t, z out of the surface]`.

mod heights;
mod occlusion;
mod slopes;
mod spectral;
mod sweep;

pub use heights::{Integrated, Integration, heights_of_slopes};
pub use occlusion::{About, SLICES, VisibilityMap, visibility};
pub use slopes::{Difference, SlopeFaults, Slopes, slopes_of_heights};
