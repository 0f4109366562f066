//! A Gaussian distribution of slopes, until the library has its own.
#![allow(dead_code)]
use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};
use leadr::reflectance::beckmann::beckmann_p22;
use leadr::reflectance::normal_distribution::{normal_cdf, normal_pdf};
use leadr::reflectance::projected_area::{meso_area, slope_spread, visible_area};
use leadr::reflectance::slope_distribution::SlopeDistribution;
use leadr::reflectance::slope_grid::{normal_of_slope, slope_cholesky};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    pub mean: DVec2,
    pub covariance: DVec3,
}

fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

impl SlopeDistribution for Beckmann {
    fn p22(&self, slope: DVec2) -> f64 {
        beckmann_p22(slope, self.mean, self.covariance)
    }
    fn mean_slope(&self) -> DVec2 {
        self.mean
    }
    fn visible_area(&self, w: DVec3) -> f64 {
        visible_area(w, self.mean, self.covariance)
    }
    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        let c = slope_cholesky(self.covariance);
        let cholesky = DMat2::from_cols(DVec2::new(c.x, c.y), DVec2::new(0.0, c.z));
        let e = (cholesky.transpose() * wo.xy()).try_normalize().unwrap_or(DVec2::X);
        let factor = cholesky * DMat2::from_cols(e, DVec2::new(-e.y, e.x));
        let (a, b) = (meso_area(wo, self.mean), slope_spread(wo, self.covariance));
        let top = if b > 0.0 { (a / b).clamp(-20.0, 20.0) } else { 20.0 };
        let cdf = |t: f64| a * normal_cdf(t) + b * normal_pdf(t);
        let x = bisect(-20.0, top, |t| cdf(t) - u.x * cdf(top));
        let y = bisect(-20.0, 20.0, |t| normal_cdf(t) - u.y);
        normal_of_slope(self.mean + factor * DVec2::new(x, y))
    }
}
