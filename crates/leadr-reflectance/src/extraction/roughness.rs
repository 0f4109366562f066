//! One roughness for any distribution of slopes (thesis 4.2).

use glam::{DVec2, DVec3};

use crate::facets::tabulated::Tabulated;

/// The roughness matrix (`α²` terms) of the Gaussian slopes of the same second moments, `α² = 2 E[x²]`; exact for Beckmann slopes.
///
/// Slopes whose variance is infinite, as those of GGX, have that of the slopes that the table reaches: prefer [`ggx_roughness`] for them.
pub fn beckmann_roughness(slopes: &Tabulated) -> DVec3 {
    2.0 * DVec3::new(slopes.mean_of(|s| s.x * s.x), slopes.mean_of(|s| s.y * s.y), slopes.mean_of(|s| s.x * s.y))
}

/// The roughness matrix of the GGX slopes of the same mean sizes; exact for GGX slopes.
///
/// Along every direction GGX's slopes are a Student distribution of the width that the matrix has there, whose mean size is that width: `α_x = E|x|`,
/// `α_y = E|y|`. So the mean sizes along both diagonals tell the correlation: `2 ρ α_x α_y = E|x + y|²/2 − E|x − y|²/2`, squares of the means.
pub fn ggx_roughness(slopes: &Tabulated) -> DVec3 {
    let size = |along: DVec2| slopes.mean_of(|s| s.dot(along).abs());
    let square = |along: DVec2| size(along).powi(2);
    let diagonal = DVec2::splat(0.5f64.sqrt());
    let mixed = 0.5 * (square(diagonal) - square(DVec2::new(diagonal.x, -diagonal.y)));
    DVec3::new(square(DVec2::X), square(DVec2::Y), mixed)
}
