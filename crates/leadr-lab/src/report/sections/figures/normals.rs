//! Draws Figures 1 to 3 of the supplement: from normals to slopes, from slope density to Beckmann's normal density, and from normals to
//! reflected directions.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3Swizzles as _};

use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_reflectance::facets::beckmann::{Beckmann, beckmann_p22};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::quadrature::composite_gauss;
use leadr_tools::error::LabError;
use leadr_tools::html::{Plot, Scale, number};

const AZIMUTH: f64 = 0.7;
/// The Beckmann roughness of the second figure.
const ALPHA: f64 = 0.5;

fn slope_of(n: DVec3) -> DVec2 {
    -n.xy() / n.z
}

/// The step of finite differences, in radians.
const STEP: f64 = 1e-5;

/// Returns the normal at `theta`, and the tangents along its meridian and its parallel.
fn frame(theta: f64) -> (DVec3, [DVec3; 2]) {
    let ((st, ct), (sp, cp)) = (theta.sin_cos(), AZIMUTH.sin_cos());
    (DVec3::new(st * cp, st * sp, ct), [DVec3::new(ct * cp, ct * sp, -st), DVec3::new(-sp, cp, 0.0)])
}

/// Computes the slope area per solid angle of normals at `theta`, by finite differences.
fn jacobian(theta: f64) -> f64 {
    let (n, tangents) = frame(theta);
    let [polar, around] = tangents.map(|along| {
        let at = |step: f64| slope_of((n + along * step).normalize());
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    });
    polar.perp_dot(around).abs()
}

/// Computes the solid angle of reflected directions per solid angle of normals at `theta` from the viewer, by finite differences.
fn reflection_jacobian(theta: f64) -> f64 {
    let (n, tangents) = frame(theta);
    let reflected = |n: DVec3| 2.0 * n.dot(DVec3::Z) * n - DVec3::Z;
    let [polar, around] = tangents.map(|along| {
        let at = |step: f64| reflected((n + along * step).normalize());
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    });
    polar.cross(around).length()
}

/// Evaluates `exp(−tan²θ / α²) / (π α² cos⁴θ)`, the usual form of Beckmann's distribution.
fn closed_form(theta: f64) -> f64 {
    let square = ALPHA * ALPHA;
    (-theta.tan().powi(2) / square).exp() / (PI * square * theta.cos().powi(4))
}

pub fn draw(_: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Supplement Figure 1",
        "Area of slopes per solid angle of normals: by finite differences of the slope over the sphere, and the closed form 1 / cos³θ.",
    );
    let angles = || (0..=85).map(|degrees| (f64::from(degrees), f64::from(degrees).to_radians()));
    let mut plot =
        Plot::new("Jacobian of the normal-to-slope map", ("θ, degrees", Scale::Linear), ("Jacobian", Scale::Log));
    plot.line("by differences", angles().map(|(degrees, theta)| (degrees, jacobian(theta))).collect());
    plot.guide("1 / cos³θ", angles().map(|(degrees, theta)| (degrees, theta.cos().powi(-3))).collect());
    page.html.plot(&plot);
    let worst = angles().map(|(_, theta)| (jacobian(theta) * theta.cos().powi(3) - 1.0).abs()).fold(0.0, f64::max);
    page.check("largest relative difference up to 85°", worst);
    page.find(&format!("the Jacobian by differences is 1 / cos³θ to {} up to 85°.", number(worst)));

    page.begin(
        "Supplement Figure 2",
        "Beckmann's density of normals for α = .5: the Gaussian density of slopes divided by cos⁴θ, and Beckmann's own form. The lower line is the density of slopes alone.",
    );
    let facets = Beckmann::isotropic(DVec2::ZERO, ALPHA);
    let s = facets.covariance();
    let normal = |theta: f64| DVec3::new(theta.sin() * AZIMUTH.cos(), theta.sin() * AZIMUTH.sin(), theta.cos());
    let slopes = |theta: f64| beckmann_p22(slope_of(normal(theta)), DVec2::ZERO, s);
    let of_slopes = |theta: f64| slopes(theta) / theta.cos().powi(4);
    let mut plot =
        Plot::new("Beckmann's D of Gaussian slopes", ("θ, degrees", Scale::Linear), ("density", Scale::Linear));
    let line = |of: &dyn Fn(f64) -> f64| angles().map(|(degrees, theta)| (degrees, of(theta))).collect();
    plot.line("P22 / cos⁴θ", line(&of_slopes));
    plot.line("P22", line(&slopes));
    plot.guide("exp(−tan²θ / α²) / (π α² cos⁴θ)", line(&closed_form));
    page.html.plot(&plot);
    let peak = angles().map(|(_, theta)| closed_form(theta)).fold(0.0, f64::max);
    let worst = |of: &dyn Fn(f64) -> f64| {
        angles().map(|(_, theta)| (of(theta) - closed_form(theta)).abs() / peak).fold(0.0, f64::max)
    };
    let (by_slopes, by_library) = (worst(&of_slopes), worst(&|theta| facets.ndf(normal(theta))));
    let whole = composite_gauss(0.0, 0.5 * PI, 64, 8);
    let area: f64 =
        whole.iter().map(|&(theta, w)| w * TAU * theta.sin() * theta.cos() * facets.ndf(normal(theta))).sum();
    page.check("largest difference relative to the peak", by_slopes.max(by_library));
    page.check("projected area of the facets", area);
    page.find(&format!(
        "both forms differ by at most {} of the peak, the library's D by {}; its facets project to an area of 1 {} {}.",
        number(by_slopes),
        number(by_library),
        if area < 1.0 { "−" } else { "+" },
        number((area - 1.0).abs())
    ));

    page.begin(
        "Supplement Figure 3",
        "Solid angle of reflected directions per solid angle of normals, by the angle θ from the viewer to the normal: by finite \
        differences of the reflection, and the closed form 4 |cos θ| (eq. 3).",
    );
    let mut plot = Plot::new(
        "Jacobian of the reflection",
        ("θ between normal and viewer, degrees", Scale::Linear),
        ("Jacobian", Scale::Linear),
    );
    plot.line("by differences", line(&reflection_jacobian));
    plot.guide("4 |cos θ|", line(&|theta| 4.0 * theta.cos()));
    page.html.plot(&plot);
    let worst = angles().map(|(_, theta)| (reflection_jacobian(theta) / (4.0 * theta.cos()) - 1.0).abs());
    let worst = worst.fold(0.0, f64::max);
    page.check("largest relative difference up to 85°", worst);
    page.find(&format!("the Jacobian by differences is 4 |cos θ| to {} up to 85°.", number(worst)));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_see_the_jacobian() {
        assert!((jacobian(1.0) * 1f64.cos().powi(3) - 1.0).abs() < 1e-7);
        assert!((jacobian(0.0) - 1.0).abs() < 1e-7);
    }

    /// Normals on the other side of the viewer reflect too, hence the absolute value.
    #[test]
    fn differences_see_the_jacobian_of_the_reflection() {
        for theta in [0.0, 0.3, 1.0, 1.5, 2.0, 3.0f64] {
            let expected = 4.0 * theta.cos().abs();
            assert!((reflection_jacobian(theta) - expected).abs() < 1e-7, "{theta}: {}", reflection_jacobian(theta));
        }
    }
}
