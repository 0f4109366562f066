//! The types and functions that most programs need, including vectors. Import them with `use leadr_reflectance::prelude::*`.

pub use super::facets::beckmann::Beckmann;
pub use super::facets::fresnel::Fresnel;
pub use super::facets::ggx::Ggx;
pub use super::facets::slope_distribution::SlopeDistribution;
pub use super::frame::{Frame, frame_about, from_frame, to_frame};
pub use super::integrals::sh::Sh9;
pub use super::masking::shadowing::Shadowing;
pub use super::masking::variants::Masking;
pub use super::materials::brdf::{Brdf, BrdfSample};
pub use super::materials::lambert::Lambert;
pub use super::materials::microfacet::Microfacet;
pub use super::shading::{self, Surface};
pub use super::slopes::map::{SlopeMap, map_covariance, map_mean_slope, slope_map};
pub use super::slopes::moments::{SlopeMoments, moments_covariance};
pub use super::slopes::statistics::{add_roughness, clamp_covariance, covariance_from_moments, scale_height};
pub use super::{DMat2, DMat3, DVec2, DVec3, DVec4};
