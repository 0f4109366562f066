//! The equivalent roughness of any slope distribution (thesis 4.2).

use glam::{DVec2, DVec3};

use crate::facets::tabulated::Tabulated;
use crate::slopes::statistics::outer_square;

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

/// Returns the roughness matrix of GGX slopes as printed in the thesis (4.2). The matrix is exact for GGX slopes.
///
/// The scales are those of [`ggx_roughness`]. The correlation follows from the directions of the slopes alone, with
/// `β₁ = E[xy/(x² + y²)]` and `β₂ = E[y²/(x² + y²)]`: `ρ = (α_y/α_x) β₁/(β₁² + β₂²)`.
pub fn thesis_ggx_roughness(slopes: &Tabulated) -> DVec3 {
    let square = |along: DVec2| slopes.mean_of(|s| s.dot(along).abs()).powi(2);
    let share =
        |of: fn(DVec3) -> f64| slopes.mean_of(|s| of(outer_square(s)) / s.length_squared().max(f64::MIN_POSITIVE));
    let (across, along_y) = (share(|s| s.z), share(|s| s.y));
    let y = square(DVec2::Y);
    DVec3::new(square(DVec2::X), y, y * across / (across * across + along_y * along_y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::ellipse::{Bivariate, roughness_from_bivariate};
    use crate::facets::ggx::Ggx;
    use crate::facets::radial_table::angle_at;
    use crate::facets::slope_distribution::SlopeDistribution as _;
    use std::f64::consts::TAU;

    #[test]
    fn both_forms_are_exact_for_ggx() {
        for (alpha, rho) in [(DVec2::new(0.2, 0.5), 0.6), (DVec2::new(0.4, 0.2), -0.5), (DVec2::splat(0.3), 0.0)] {
            let expected = roughness_from_bivariate(&Bivariate::new(alpha, rho));
            let ggx = Ggx::new(DVec2::ZERO, expected);
            let at = |k: usize, i: usize| {
                let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
                ggx.ndf((sine * DVec2::from_angle(TAU * k as f64 / 90.0)).extend(cosine))
            };
            let rows: Vec<Vec<f64>> = (0..90).map(|k| (0..90).map(|i| at(k, i)).collect()).collect();
            let slopes = Tabulated::from_rows(&rows).unwrap();
            for found in [ggx_roughness(&slopes), thesis_ggx_roughness(&slopes)] {
                let error = (found - expected).length() / expected.length();
                println!("{alpha} {rho}: {error:.1e}");
                assert!(error < 1e-3, "{alpha} {rho}: {found} {expected}");
            }
        }
    }
}
