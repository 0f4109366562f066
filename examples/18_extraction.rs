//! How exactly known facets are found again by power iteration, and how long that takes (thesis Table 4.I and Figure 4.5).
//!
//! `cargo run --release --example 18_extraction`

use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use leadr::reflectance::extraction::power_iteration::{Backscattering, extract_polar, extract_radial};
use leadr::reflectance::facets::beckmann::Beckmann;
use leadr::reflectance::facets::radial_table::angle_at;
use leadr::reflectance::facets::slope_distribution::SlopeDistribution;
use leadr::reflectance::{DVec2, DVec3};

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// `f_r(o, o)` of ideal mirrors with Smith's masking (thesis eq. 4.3).
fn backscattering(slopes: &impl SlopeDistribution, o: DVec3) -> f64 {
    slopes.ndf(o) / (4.0 * o.z * slopes.visible_area(o))
}

fn beckmann(x: f64, y: f64) -> Beckmann {
    Beckmann::new(DVec2::ZERO, 0.5 * DVec3::new(x * x, y * y, 0.0))
}

/// Largest error of the backscattering where it is at least a thousandth of its peak, relative.
fn worst(of: &impl SlopeDistribution, found: &impl SlopeDistribution, azimuths: u32) -> f64 {
    let peak = backscattering(of, DVec3::Z);
    let mut worst = 0.0f64;
    for i in 0..2000 {
        for k in 0..azimuths {
            let o = direction(angle_at(f64::from(i) / 2000.0), TAU * f64::from(k) / f64::from(azimuths));
            let expected = backscattering(of, o);
            if expected > 1e-3 * peak {
                worst = worst.max((backscattering(found, o) / expected - 1.0).abs());
            }
        }
    }
    worst
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("isotropic: samples, seconds, largest relative error of the backscattering by α");
    let alphas = [0.01, 0.02, 0.05, 0.15, 0.5];
    println!("{:>8} {:>8}  {}", "samples", "seconds", alphas.map(|a| format!("{a:>8}")).join(" "));
    for n in [32usize, 90, 180, 360] {
        let (mut errors, mut seconds) = (Vec::new(), f64::INFINITY);
        for alpha in alphas {
            let slopes = beckmann(alpha, alpha);
            let samples: Vec<f64> =
                (0..n).map(|i| backscattering(&slopes, direction(angle_at(i as f64 / n as f64), 0.0))).collect();
            let start = Instant::now();
            let found = extract_radial(&samples, Backscattering::Smith).ok_or("nothing is scattered back")?;
            seconds = seconds.min(start.elapsed().as_secs_f64());
            errors.push(format!("{:8.1e}", worst(&slopes, &found.slopes, 1)));
        }
        println!("{n:>8} {seconds:>8.3}  {}", errors.join(" "));
    }
    println!("anisotropic, α .1 and .3: angles, azimuths, seconds, largest relative error of the backscattering");
    for (n, m) in [(32usize, 32usize), (64, 64), (90, 90)] {
        let slopes = beckmann(0.1, 0.3);
        let at = |i: usize, k: usize| {
            backscattering(&slopes, direction(angle_at(i as f64 / n as f64), TAU * k as f64 / m as f64))
        };
        let rows: Vec<Vec<f64>> = (0..m).map(|k| (0..n).map(|i| at(i, k)).collect()).collect();
        let start = Instant::now();
        let found = extract_polar(&rows, Backscattering::Smith).ok_or("nothing is scattered back")?;
        let seconds = start.elapsed().as_secs_f64();
        println!("{n:>8} {m:>8} {seconds:>8.2} {:>8.1e}", worst(&slopes, &found.slopes, 17));
    }
    Ok(())
}
