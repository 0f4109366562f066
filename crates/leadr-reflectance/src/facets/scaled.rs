//! A slope distribution whose slopes are all multiplied by one factor. The result describes a rougher or smoother surface of the same
//! shape, for instance a measured material with a roughness texture (thesis Figure 4.6).

use glam::{DVec2, DVec3};

use super::slope_distribution::SlopeDistribution;

/// A slope distribution with all slopes scaled by a positive factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaled<D> {
    /// The unscaled distribution.
    pub inner: D,
    /// The positive factor that multiplies the slopes.
    pub factor: f64,
}

impl<D> Scaled<D> {
    /// Returns the direction `w'`, which is not a unit vector, from which the unscaled surface has the same visible area as the scaled
    /// surface has from `w`. For a slope `s = factor · s'`, `max(0, w·(−s, 1))` equals `max(0, w'·(−s', 1))`.
    fn seen_from(&self, w: DVec3) -> DVec3 {
        DVec3::new(self.factor * w.x, self.factor * w.y, w.z)
    }
}

impl<D: SlopeDistribution> SlopeDistribution for Scaled<D> {
    fn p22(&self, slope: DVec2) -> f64 {
        self.inner.p22(slope / self.factor) / (self.factor * self.factor)
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        let n = DVec3::new(wn.x / self.factor, wn.y / self.factor, wn.z);
        let square = n.length_squared();
        self.inner.ndf(n / square.sqrt()) / (self.factor * square).powi(2)
    }

    fn mean_slope(&self) -> DVec2 {
        self.factor * self.inner.mean_slope()
    }

    fn shape(&self) -> DVec3 {
        self.factor * self.factor * self.inner.shape()
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        let seen = self.seen_from(w);
        let length = seen.length();
        length * self.inner.visible_area(seen / length)
    }

    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        let n = self.inner.sample_visible(self.seen_from(wo).normalize(), u);
        DVec3::new(self.factor * n.x, self.factor * n.y, n.z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::Beckmann;
    use crate::facets::ggx::Ggx;

    /// A scaled Gaussian lobe is again Gaussian, and a scaled GGX lobe is again GGX.
    #[test]
    fn a_scaled_lobe_is_a_lobe() {
        fn check(of: impl SlopeDistribution, same: &impl SlopeDistribution) {
            let scaled = Scaled { inner: of, factor: 1.7 };
            for (x, y, z) in [(0.1, 0.2, 0.9), (-0.7, 0.3, 0.2), (0.0, 0.0, 1.0), (0.6, -0.7, 0.02)] {
                let w = DVec3::new(x, y, z).normalize();
                let slope = DVec2::new(x, y);
                for (found, expected) in [
                    (scaled.ndf(w), same.ndf(w)),
                    (scaled.p22(slope), same.p22(slope)),
                    (scaled.visible_area(w), same.visible_area(w)),
                ] {
                    assert!((found - expected).abs() < 1e-9 * expected.max(1e-3), "{w}: {found} {expected}");
                }
                let u = DVec2::new(0.3, 0.8);
                assert!((scaled.sample_visible(w, u) - same.sample_visible(w, u)).length() < 1e-6, "{w}");
            }
            assert!((scaled.shape() - same.shape()).length() < 1e-12);
            assert!((scaled.mean_slope() - same.mean_slope()).length() < 1e-12);
        }
        let (m, s) = (DVec2::new(0.1, -0.2), DVec3::new(0.05, 0.2, 0.03));
        check(Beckmann::new(m, s), &Beckmann::new(1.7 * m, 1.7 * 1.7 * s));
        check(Ggx::new(m, s), &Ggx::new(1.7 * m, 1.7 * 1.7 * s));
    }
}
