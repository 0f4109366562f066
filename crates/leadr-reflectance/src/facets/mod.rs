//! Microfacets: slope distributions, projected areas, Fresnel terms, and sampling of visible normals.

pub mod base_roughness;
pub mod beckmann;
pub mod beckmann_sampling;
#[cfg(test)]
mod chi_square;
pub mod complex_index;
pub mod curve;
pub mod ellipse;
pub mod footprint_normals;
pub mod fresnel;
pub mod gaussian_mixture;
pub mod ggx;
pub mod ggx_sampling;
pub mod gloss;
pub mod metals;
pub mod normal_distribution;
pub mod normal_length;
pub mod normal_spread;
pub mod parametric_curve;
pub mod polar_table;
pub mod projected_area;
pub mod radial_sampling;
pub mod radial_table;
pub mod scaled;
pub mod shortened_normals;
pub mod slope_distribution;
pub mod tabulated;
