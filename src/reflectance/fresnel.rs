//! Fresnel reflectance.

use glam::DVec3;

/// Schlick's approximation. `f0`: reflectance at normal incidence, linear RGB; `cosine`: `wi·wh`, clamped to 0..1.
#[must_use]
pub fn fresnel_schlick(f0: DVec3, cosine: f64) -> DVec3 {
    let k = (1.0 - cosine).clamp(0.0, 1.0);
    f0 + (DVec3::ONE - f0) * k.powi(5)
}

/// Unpolarised reflectance of a smooth dielectric (Walter et al. 2007, eq. 22). `eta`: refractive index on the far side
/// over the near side, > 0; 1 at total reflection.
#[must_use]
pub fn fresnel_dielectric(cosine: f64, eta: f64) -> f64 {
    let c = cosine.abs().min(1.0);
    let g2 = eta * eta - 1.0 + c * c;
    if g2 <= 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    let s = (g - c) / (g + c).max(1e-12);
    let p = (c * (g + c) - 1.0) / (c * (g - c) + 1.0).max(1e-12);
    (0.5 * s * s * (1.0 + p * p)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dielectric_agrees_with_the_amplitude_formulas() {
        for eta in [1.0 / 1.5, 1.33, 1.5, 2.4] {
            for i in 0..=90 {
                let ti = f64::from(i).to_radians();
                let sin = ti.sin() / eta;
                let truth = if sin >= 1.0 {
                    1.0
                } else {
                    let (ci, ct) = (ti.cos(), (1.0 - sin * sin).sqrt());
                    let rs = (ci - eta * ct) / (ci + eta * ct);
                    let rp = (eta * ci - ct) / (eta * ci + ct);
                    0.5 * (rs * rs + rp * rp)
                };
                assert!((fresnel_dielectric(ti.cos(), eta) - truth).abs() < 1e-12, "{eta} {i}");
            }
        }
        assert!((fresnel_dielectric(1.0, 1.5) - 0.04).abs() < 1e-15);
    }

    #[test]
    fn schlick_ends() {
        let f0 = DVec3::new(0.04, 0.5, 1.0);
        assert_eq!(fresnel_schlick(f0, 1.0), f0);
        assert!((fresnel_schlick(f0, -0.5) - DVec3::ONE).length() < 1e-15);
    }
}
