//! Measures the accuracy and time of power iteration for known facets (thesis Table 4.I and Figure 4.5), here and as printed in the thesis.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::hint::black_box;
use std::time::Instant;

use glam::{DVec2, DVec3};
use serde::Serialize;

use leadr_reflectance::extraction::fresnel::thesis_fresnel;
use leadr_reflectance::extraction::power_iteration::{Backscattering, extract_polar, extract_radial};
use leadr_reflectance::extraction::samples::direction;
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::fresnel::Fresnel;
use leadr_reflectance::facets::radial_sampling::{PolarSampler, RadialSampler};
use leadr_reflectance::facets::radial_table::{angle_at, u_of_angle};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::facets::tabulated::Tabulated;
use leadr_reflectance::materials::microfacet::Microfacet;

/// Values below this fraction of the backscattering peak are ignored.
const DARK: f64 = 1e-3;
/// The number of angles at which fits are compared.
const ANGLES: u32 = 2000;

/// The settings and results of one extraction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Extraction {
    /// The number of angles at which the material is evaluated.
    pub angles: usize,
    /// The number of azimuths at which the material is evaluated.
    pub azimuths: usize,
    /// The duration of the extraction in seconds: the slopes, the visible areas, the quantile functions, and the Fresnel term of the thesis.
    pub seconds: f64,
    /// The largest relative error of the backscattering, over angles where the backscattering is at least a thousandth of
    /// its peak.
    pub error: f64,
}

/// Computes the backscattering `f_r(o, o)` of ideal specular facets with Smith's masking (thesis eq. 4.3).
fn backscattering(slopes: &impl SlopeDistribution, o: DVec3) -> f64 {
    slopes.ndf(o) / (4.0 * o.z * slopes.visible_area(o))
}

fn worst(of: &impl SlopeDistribution, found: &impl SlopeDistribution, azimuths: u32) -> f64 {
    let peak = backscattering(of, DVec3::Z);
    let all = (0..ANGLES).flat_map(|i| (0..azimuths).map(move |k| (i, k)));
    let error = |(i, k)| {
        let o = direction(angle_at(f64::from(i) / f64::from(ANGLES)), TAU * f64::from(k) / f64::from(azimuths));
        let expected = backscattering(of, o);
        if expected > DARK * peak { (backscattering(found, o) / expected - 1.0).abs() } else { 0.0 }
    };
    all.map(error).fold(0.0, f64::max)
}

fn beckmann(x: f64, y: f64) -> Beckmann {
    Beckmann::new(DVec2::ZERO, 0.5 * DVec3::new(x * x, y * y, 0.0))
}

/// Recovers isotropic Beckmann slopes of roughness `alpha` from `angles` angles. Returns `None` if the extraction fails.
pub fn round(alpha: f64, angles: usize) -> Option<Extraction> {
    let slopes = beckmann(alpha, alpha);
    let at = |i: usize| backscattering(&slopes, direction(angle_at(i as f64 / angles as f64), 0.0));
    let samples: Vec<f64> = (0..angles).map(at).collect();
    let start = Instant::now();
    let found = Tabulated::Radial(extract_radial(&samples, Backscattering::Smith)?.slopes);
    complete(slopes, &found, angles);
    let seconds = start.elapsed().as_secs_f64();
    Some(Extraction { angles, azimuths: 1, seconds, error: worst(&slopes, &found, 1) })
}

/// Computes the tables that complete extracted slopes: the quantile functions and the Fresnel term of ideal specular facets.
fn complete(slopes: Beckmann, found: &Tabulated, angles: usize) {
    match found {
        Tabulated::Radial(table) => _ = black_box(RadialSampler::new(table)),
        Tabulated::Polar(table) => _ = black_box(PolarSampler::new(table)),
    }
    let masking = Backscattering::Smith.masking();
    let material = Microfacet { distribution: slopes, masking, fresnel: Fresnel::Ideal };
    black_box(thesis_fresnel(&material, found, masking, angles));
}

/// Recovers anisotropic Beckmann slopes of two roughnesses from `angles` angles and `azimuths` azimuths.
pub fn anisotropic(alpha: DVec2, angles: usize, azimuths: usize) -> Option<Extraction> {
    let slopes = beckmann(alpha.x, alpha.y);
    let at = |i: usize, k: usize| {
        backscattering(&slopes, direction(angle_at(i as f64 / angles as f64), TAU * k as f64 / azimuths as f64))
    };
    let rows: Vec<Vec<f64>> = (0..azimuths).map(|k| (0..angles).map(|i| at(i, k)).collect()).collect();
    let start = Instant::now();
    let found = Tabulated::Polar(extract_polar(&rows, Backscattering::Smith)?.slopes);
    complete(slopes, &found, angles);
    let seconds = start.elapsed().as_secs_f64();
    Some(Extraction { angles, azimuths, seconds, error: worst(&slopes, &found, 17) })
}

/// The slope densities that the thesis' listings extract, at the nodes `θ = (i/n)² π/2` and at 90°.
pub struct PrintedSlopes(Vec<f64>);

/// Extracts slopes from the backscatter `f_r(o, o)` at `n` angles with the thesis' Listing 4.1 as printed: rectangles and four
/// multiplications. Listing 4.6 normalises them.
pub fn extract_listing_4_1(backscatter: impl Fn(f64) -> f64, n: usize) -> PrintedSlopes {
    let theta = |i: usize| angle_at(i as f64 / n as f64);
    let width = FRAC_PI_2.sqrt() / n as f64;
    let kernel: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let row = width * theta(i).cos().powi(6) * 8.0 * backscatter(theta(i));
            let at = |j: usize| {
                let product = theta(i).tan() * theta(j).tan();
                let ring: f64 = (0..360).map(|k| (product * f64::from(k).to_radians().cos()).max(1.0)).sum();
                theta(j).sqrt() * row * ring.to_radians() * theta(j).tan() / theta(j).cos().powi(2)
            };
            (0..n).map(at).collect()
        })
        .collect();
    let multiply = |p: Vec<f64>, _| kernel.iter().map(|row| row.iter().zip(&p).map(|(k, p)| k * p).sum()).collect();
    let mut found = PrintedSlopes((0..4).fold(vec![1.0; n], multiply));
    found.0.push(0.0);
    let all = TAU * found.sum(|_| 1.0);
    found.0.iter_mut().for_each(|p| *p /= all);
    found
}

impl PrintedSlopes {
    /// Returns the slope density, linear between the nodes.
    fn density(&self, theta: f64) -> f64 {
        let position = u_of_angle(theta) * (self.0.len() - 1) as f64;
        let i = (position as usize).min(self.0.len() - 2);
        self.0[i] + (position - i as f64) * (self.0[i + 1] - self.0[i])
    }

    /// Integrates `of(r) P(r) r dr` over the radius of the slopes with the 128 rectangles of Listings 4.4 to 4.6.
    fn sum(&self, of: impl Fn(f64) -> f64) -> f64 {
        let at = |i: u32| {
            let u = f64::from(i) / 128.0;
            let (r, cosine) = (angle_at(u).tan(), angle_at(u).cos());
            PI / 128.0 * u * r * of(r) * self.density(angle_at(u)) / (cosine * cosine)
        };
        (0..128).map(at).sum()
    }

    /// Returns the Beckmann roughness of Listing 4.4.
    pub fn beckmann_alpha(&self) -> f64 {
        (TAU * self.sum(|r| r * r)).sqrt()
    }

    /// Returns the GGX roughness of Listing 4.5.
    pub fn ggx_alpha(&self) -> f64 {
        4.0 * self.sum(|r| r)
    }

    /// Returns Smith's masking term of Listing 4.7.
    fn masking(&self, theta: f64) -> f64 {
        let ring = |j: u32| {
            let u = f64::from(j) / 90.0;
            let (sine, cosine) = angle_at(u).sin_cos();
            let seen =
                |k: u32| (theta.sin() * sine * f64::from(2 * k).to_radians().cos() + theta.cos() * cosine).max(0.0);
            let seen: f64 = (0..180).map(seen).sum();
            u * sine * seen * self.density(angle_at(u)) / cosine.powi(4)
        };
        let area = (0..90).map(ring).sum::<f64>() * (PI / 90.0) * (TAU / 180.0);
        (theta.cos() / area).min(1.0)
    }
}

/// Recovers isotropic Beckmann slopes of roughness `alpha` from `n` angles with the thesis' listings. Returns the [`Extraction::error`].
pub fn printed(alpha: f64, n: usize) -> f64 {
    let slopes = beckmann(alpha, alpha);
    let expected = |theta: f64| backscattering(&slopes, direction(theta, 0.0));
    let found = extract_listing_4_1(expected, n);
    let error = |i: u32| {
        let theta = angle_at(f64::from(i) / f64::from(ANGLES));
        if expected(theta) <= DARK * expected(0.0) {
            return 0.0;
        }
        let value = found.density(theta) * found.masking(theta) / (4.0 * theta.cos().powi(6));
        (value / expected(theta) - 1.0).abs()
    };
    (0..ANGLES).map(error).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_measured::Measured;
    use leadr_reflectance::color::luminance;
    use leadr_reflectance::facets::ggx::Ggx;
    use leadr_reflectance::materials::brdf::Brdf as _;
    use std::path::PathBuf;

    #[test]
    fn more_angles_are_nearer() {
        let few = round(0.05, 24).unwrap();
        let many = round(0.05, 96).unwrap();
        assert!(many.error < 0.1 * few.error && few.error < 0.1, "{few:?} {many:?}");
        let anisotropic = anisotropic(DVec2::new(0.1, 0.3), 48, 48).unwrap();
        assert!(anisotropic.error < 0.01, "{anisotropic:?}");
    }

    /// Prints the tables of `docs/measurements/fitting.md`, with the thesis' Table 4.I beside them.
    #[test]
    fn listings_are_less_accurate() {
        for angles in [32, 90, 180, 360] {
            for alpha in [0.01, 0.02, 0.05, 0.15, 0.5] {
                let (here, printed) = (round(alpha, angles).unwrap(), printed(alpha, angles));
                println!(
                    "{angles} angles, α {alpha}: {:.1e} in {:.3} s, as printed {printed:.1e}",
                    here.error, here.seconds
                );
                assert!(angles == 32 || here.error < 0.1 * printed, "{angles} {alpha}: {here:?} {printed}");
            }
        }
        for n in [32, 64, 90] {
            let found = anisotropic(DVec2::new(0.1, 0.3), n, n).unwrap();
            println!("{n} x {n}, α .1 and .3: {:.1e} in {:.2} s", found.error, found.seconds);
        }
        let of = |slopes: &dyn SlopeDistribution| {
            let at = |theta: f64| {
                let o = direction(theta, 0.0);
                slopes.ndf(o) / (4.0 * o.z * slopes.visible_area(o))
            };
            extract_listing_4_1(at, 90)
        };
        let errors = [
            of(&beckmann(0.05, 0.05)).beckmann_alpha() / 0.05 - 1.0,
            of(&Ggx::isotropic(DVec2::ZERO, 0.5)).ggx_alpha() / 0.5 - 1.0,
        ];
        println!("roughness as printed, 90 angles, Beckmann .05 and GGX .5: {errors:?}");
        assert!(errors.iter().all(|error| error.abs() < 0.1), "{errors:?}");
    }

    #[test]
    #[ignore = "prints the roughness of measured materials as printed; LEADR_SHARED names their folder"]
    fn listings_of_measured_materials() {
        let folder =
            PathBuf::from(std::env::var_os("LEADR_SHARED").expect("LEADR_SHARED names the folder of the files"));
        for name in ["cc_ibiza_sunset", "paper_white"] {
            let file = folder.join(format!("data/brdf/rgl_bsdf/{name}_rgb.bsdf"));
            let measured = Measured::load(&file).unwrap();
            let back = |theta: f64| luminance(measured.eval(direction(theta, 0.0), direction(theta, 0.0)));
            let printed = extract_listing_4_1(back, 90);
            println!("{name}: Beckmann {:.4}, GGX {:.4}", printed.beckmann_alpha(), printed.ggx_alpha());
        }
    }
}
