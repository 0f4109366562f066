//! The equivalent roughness of any slope distribution (thesis 4.2).

use glam::{DVec2, DVec3};

use crate::facets::tabulated::Tabulated;

/// Returns the roughness matrix (`α²` terms) of Gaussian slopes with the same second moments, `α² = 2 E[x²]`. The matrix is exact for
/// Beckmann slopes.
///
/// For slopes of infinite variance, such as GGX, the second moments cover the tabulated slopes only. Prefer [`ggx_roughness`] for GGX.
pub fn beckmann_roughness(slopes: &Tabulated) -> DVec3 {
    2.0 * DVec3::new(slopes.mean_of(|s| s.x * s.x), slopes.mean_of(|s| s.y * s.y), slopes.mean_of(|s| s.x * s.y))
}

/// Returns the roughness matrix of GGX slopes with the same mean absolute slopes. The matrix is exact for GGX slopes.
///
/// Along every direction, GGX slopes have a Student distribution whose width equals the mean absolute value: `α_x = E|x|`, `α_y = E|y|`.
/// The mean absolute slopes along the two diagonals give the correlation, `2 ρ α_x α_y = E|x + y|²/2 − E|x − y|²/2`, where `E|…|²` is the
/// square of a mean.
pub fn ggx_roughness(slopes: &Tabulated) -> DVec3 {
    let size = |along: DVec2| slopes.mean_of(|s| s.dot(along).abs());
    let square = |along: DVec2| size(along).powi(2);
    let diagonal = DVec2::splat(0.5f64.sqrt());
    let mixed = 0.5 * (square(diagonal) - square(DVec2::new(diagonal.x, -diagonal.y)));
    DVec3::new(square(DVec2::X), square(DVec2::Y), mixed)
}
