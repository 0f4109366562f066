//! Functions for the Fresnel reflectance of facets (thesis Table 2.I, plus conductors). Their argument is the cosine of the difference
//! angle, `cos θ_d = wo·wh = wi·wh`.

use crate::limits::unit;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// Returns Schlick's approximation of the reflectance. `f0` is the reflectance at normal incidence, in linear RGB. The `cosine` of the
/// angle between `wi` and `wh` is clamped to 0..1.
pub fn fresnel_schlick(f0: DVec3, cosine: f64) -> DVec3 {
    f0 + (grazing_reflectance(f0) - f0) * schlick_weight(cosine)
}

/// Returns the weight of the grazing reflectance in Schlick's approximation, `(1 − cos)⁵`.
pub fn schlick_weight(cosine: f64) -> f64 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Returns the reflectance at grazing incidence, which is 1 for every real surface. No real material has an `f0` below 2 %, so a smaller
/// `f0` means that only a fraction of the surface reflects (Lagarde & de Rousiers 2014). An `f0` of 0 disables specular reflection and
/// leaves diffuse facets.
pub fn grazing_reflectance(f0: DVec3) -> DVec3 {
    DVec3::splat((50.0 * f0.max_element()).min(1.0))
}

/// Returns Schlick's approximation with the F82 edge tint. The reflectance of most metals falls before it rises towards grazing incidence:
/// `F = schlick − edge_tint · cos (1 − cos)⁶` (Lazányi and Szirmay-Kalos 2005, with the exponent of Hoffman 2019). `edge_tint` is a
/// [`Metal::edge_tint`](super::metals::Metal::edge_tint), and 0 gives Schlick's approximation.
pub fn fresnel_edge_tint(f0: DVec3, edge_tint: DVec3, cosine: f64) -> DVec3 {
    fresnel_schlick(f0, cosine) - edge_tint * edge_tint_weight(cosine)
}

/// Returns the weight of a conductor's edge tint, `cos (1 − cos)⁶`. The weight is at most 0.057, at a cosine of 1/7.
pub fn edge_tint_weight(cosine: f64) -> f64 {
    let c = cosine.clamp(0.0, 1.0);
    c * (1.0 - c).powi(6)
}

/// Returns the unpolarised reflectance of a smooth dielectric (Walter et al. 2007, eq. 22). `eta`, above 0, is the refractive index on the
/// transmitted side divided by the index on the incident side. The result is 1 at total internal reflection.
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

/// The upper limit for both components of a refractive index. At this limit [`fresnel_conductor`] reflects nearly all light.
const MAX_INDEX: f64 = 1e4;

/// Returns the unpolarised reflectance of a smooth conductor in vacuum. `eta` and `k` are the real part and the extinction coefficient of
/// the complex index `η + i k` for each colour channel. Both are clamped to 0..1e4. `k = 0` gives a dielectric.
///
/// With `a + i b = √((η + i k)² − sin²θ)`, `c = cos θ` and `s = sin θ`, the amplitude formulas become quotients of sums of squares:
/// `R_s = ((a − c)² + b²) / ((a + c)² + b²)` and `R_p = R_s ((a c − s²)² + (b c)²) / ((a c + s²)² + (b c)²)`. No term suffers from
/// cancellation, and `0/0` is replaced by its limit, 1.
pub fn fresnel_conductor(cosine: f64, eta: DVec3, k: DVec3) -> DVec3 {
    let c = cosine.abs().min(1.0);
    let s2 = (1.0 - c) * (1.0 + c);
    let channel = |eta: f64, k: f64| {
        let (eta, k) = (eta.clamp(0.0, MAX_INDEX), k.clamp(0.0, MAX_INDEX));
        let (re, im) = ((eta - k) * (eta + k) - s2, eta * k);
        // To avoid cancellation, compute the larger component of the root first, and the smaller one from the product of the two.
        let larger = (0.5 * ((re * re + 4.0 * im * im).sqrt() + re.abs())).sqrt();
        let smaller = im / larger.max(1e-15);
        let (a, b) = if re >= 0.0 { (larger, smaller) } else { (smaller, larger) };
        let ratio =
            |difference: f64, sum: f64, b: f64| (difference * difference + b * b + 1e-30) / (sum * sum + b * b + 1e-30);
        let s_polarised = ratio(a - c, a + c, b);
        (0.5 * s_polarised * (1.0 + ratio(a * c - s2, a * c + s2, b * c))).min(1.0)
    };
    DVec3::new(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
}

/// The largest value of a residual.
pub const MAX_RESIDUAL: f64 = 1e6;

/// A table of the Fresnel reflectance at equal steps of the difference angle from 0° to 90°, with linear interpolation. Section 4.2 of the
/// thesis extracts this table from a measured material. A table can also be a residual, whose values exceed 1.
#[derive(Clone, Debug, PartialEq)]
pub struct FresnelTable(Vec<DVec3>);

impl FresnelTable {
    /// Creates the table from linear RGB `values`. The first value is at 0° (normal incidence) and the last at 90°.
    ///
    /// # Errors
    /// If there are fewer than two entries, or an entry is not finite or is outside 0..1. The message names the entry.
    pub fn new(values: Vec<DVec3>) -> Result<Self, String> {
        Self::within(values, 1.0)
    }

    /// Creates a table of residuals (thesis 4.2), which replace the Fresnel term of a material that facets do not describe. The values are
    /// from 0 to [`MAX_RESIDUAL`], so the material can reflect more light than it receives.
    ///
    /// # Errors
    /// As for [`Self::new`], with the larger limit.
    pub fn residual(values: Vec<DVec3>) -> Result<Self, String> {
        Self::within(values, MAX_RESIDUAL)
    }

    fn within(values: Vec<DVec3>, most: f64) -> Result<Self, String> {
        if values.len() < 2 {
            return Err(format!("the Fresnel table has {} entries; give at least 2, for 0° and 90°", values.len()));
        }
        let bad = |v: &DVec3| !v.to_array().iter().all(|c| (0.0..=most).contains(c));
        match values.iter().position(bad) {
            Some(index) => {
                let value = values[index];
                Err(format!(
                    "entry {index} of the Fresnel table is {value}; its values are finite and within 0..{most}"
                ))
            }
            None => Ok(Self(values)),
        }
    }

    /// Whether a value exceeds 1, which no reflectance does.
    pub fn is_residual(&self) -> bool {
        self.0.iter().any(|value| value.max_element() > 1.0)
    }

    /// Returns the reflectance at the cosine of a difference angle. The cosine is clamped to 0..1.
    pub fn at(&self, cosine: f64) -> DVec3 {
        let last = self.0.len() - 1;
        // A NaN cosine is treated as grazing incidence.
        let at = unit(cosine).acos() / FRAC_PI_2 * last as f64;
        let low = (at as usize).min(last - 1);
        self.0[low].lerp(self.0[low + 1], (at - low as f64).clamp(0.0, 1.0))
    }
}

/// The Fresnel term of a microfacet BRDF (thesis eq. 2.2 and Table 2.I).
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Fresnel {
    /// Ideal reflectors with `F = 1`, as in the white furnace (thesis eq. 2.3).
    #[default]
    Ideal,
    /// Schlick's approximation, [`fresnel_schlick`], with this linear RGB reflectance at normal incidence, from 0 to 1.
    Schlick(DVec3),
    /// A dielectric, [`fresnel_dielectric`], with this positive ratio of the interior to the exterior refractive index.
    Dielectric(f64),
    /// A conductor in vacuum, [`fresnel_conductor`].
    Conductor {
        /// The real part of the refractive index for each colour channel, at least 0.
        eta: DVec3,
        /// The extinction coefficient for each colour channel, at least 0.
        k: DVec3,
    },
    /// A table, which [`FresnelTable::at`] evaluates.
    Tabulated(FresnelTable),
}

impl Fresnel {
    /// Returns the reflectance at `cosine = wo·wh`, in linear RGB from 0 to 1. Only a residual table exceeds 1.
    pub fn at(&self, cosine: f64) -> DVec3 {
        match self {
            Self::Ideal => DVec3::ONE,
            Self::Schlick(f0) => fresnel_schlick(*f0, cosine),
            Self::Dielectric(eta) => DVec3::splat(fresnel_dielectric(cosine, *eta)),
            Self::Conductor { eta, k } => fresnel_conductor(cosine, *eta, *k),
            Self::Tabulated(table) => table.at(cosine),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3Swizzles as _;

    /// Complex arithmetic for the Fresnel amplitude formulas.
    mod complex {
        pub type C = (f64, f64);
        pub fn mul(a: C, b: C) -> C {
            (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
        }
        pub fn add(a: C, b: C) -> C {
            (a.0 + b.0, a.1 + b.1)
        }
        pub fn sub(a: C, b: C) -> C {
            (a.0 - b.0, a.1 - b.1)
        }
        pub fn norm2(a: C) -> f64 {
            a.0 * a.0 + a.1 * a.1
        }
        pub fn sqrt(a: C) -> C {
            let r = norm2(a).sqrt().sqrt();
            let half = 0.5 * a.1.atan2(a.0);
            (r * half.cos(), r * half.sin())
        }
    }

    #[test]
    fn conductor_agrees_with_complex_amplitudes() {
        use complex::{add, mul, norm2, sqrt, sub};
        let mut worst = 0.0f64;
        // The media resemble gold, silver and iron, a nearly dielectric conductor, a dielectric, and optically thinner media.
        for (eta, k) in [(0.14, 4.0), (0.05, 3.1), (2.9, 3.1), (1.5, 1e-9), (1.5, 0.0), (0.6, 0.0), (0.6, 1e-6)] {
            for i in 0..=900 {
                let t = (0.1 * f64::from(i)).to_radians();
                let (s, c) = t.sin_cos();
                let n2 = mul((eta, k), (eta, k));
                let root = sqrt(sub(n2, (s * s, 0.0)));
                let rs = norm2(sub((c, 0.0), root)) / norm2(add((c, 0.0), root));
                let n2c = mul(n2, (c, 0.0));
                let rp = norm2(sub(n2c, root)) / norm2(add(n2c, root));
                let f = fresnel_conductor(c, DVec3::splat(eta), DVec3::splat(k)).x;
                worst = worst.max((f - 0.5 * (rs + rp)).abs());
            }
        }
        println!("conductor against complex amplitudes: worst error {worst:.1e}");
        assert!(worst < 1e-11);
    }

    #[test]
    fn conductor_without_extinction_is_a_dielectric() {
        for eta in [0.5, 1.33, 2.4] {
            for i in 0..=1000 {
                let c = f64::from(i) / 1000.0;
                let f = fresnel_conductor(c, DVec3::splat(eta), DVec3::ZERO).x;
                assert!((f - fresnel_dielectric(c, eta)).abs() < 1e-12, "{eta} {c}");
            }
        }
    }

    #[test]
    fn every_term_is_a_reflectance_for_every_input() {
        let table = FresnelTable::new(vec![DVec3::splat(0.2), DVec3::ONE]).unwrap();
        let odd = DVec3::new(0.0, -3.0, 1e300);
        let mut terms = vec![Fresnel::Ideal, Fresnel::Schlick(DVec3::new(0.0, 0.5, 1.0)), Fresnel::Tabulated(table)];
        terms.extend([1e-3, 1.0, 1.5, 1e3].map(Fresnel::Dielectric));
        for eta in [DVec3::ZERO, DVec3::ONE, odd] {
            terms.extend([DVec3::ZERO, DVec3::splat(1e-30), odd.zxy()].map(|k| Fresnel::Conductor { eta, k }));
        }
        for term in terms {
            for cosine in [-1.0, -1e-300, 0.0, 1e-30, 0.3, 1.0, 1.0 + 1e-12, 2.0] {
                let f = term.at(cosine);
                assert!(f.min_element() >= 0.0 && f.max_element() <= 1.0, "{term:?} at {cosine}: {f}");
            }
        }
    }

    #[test]
    fn a_table_returns_its_entries_and_refuses_bad_ones() {
        let values: Vec<DVec3> = (0..=90).map(|i| DVec3::new(f64::from(i) / 90.0, 0.5, 1.0)).collect();
        let table = FresnelTable::new(values).unwrap();
        for i in 0..=180 {
            let want = f64::from(i) / 180.0;
            assert!((table.at((0.5 * f64::from(i)).to_radians().cos()).x - want).abs() < 1e-12);
        }
        assert_eq!(table.at(f64::NAN).x, 1.0);
        assert!(FresnelTable::new(vec![DVec3::ONE]).unwrap_err().contains("has 1 entries"));
        for bad in [f64::NAN, -0.1, 1.1, f64::INFINITY] {
            let values = vec![DVec3::ONE, DVec3::new(0.5, bad, 0.5)];
            assert!(FresnelTable::new(values).unwrap_err().contains("entry 1 "), "{bad} accepted as a reflectance");
        }
        let residual = vec![DVec3::ONE, DVec3::new(0.5, 1.5, MAX_RESIDUAL)];
        let residual = FresnelTable::residual(residual).unwrap();
        assert!(residual.is_residual() && !table.is_residual());
        assert_eq!(residual.at(0.0), DVec3::new(0.5, 1.5, MAX_RESIDUAL));
        assert!(FresnelTable::residual(vec![DVec3::ONE, DVec3::splat(2.0 * MAX_RESIDUAL)]).is_err());
    }

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
        for cosine in [0.0, 0.1, 1.0] {
            assert_eq!(fresnel_schlick(DVec3::ZERO, cosine), DVec3::ZERO, "no surface, no reflection");
            assert_eq!(fresnel_schlick(DVec3::ONE, cosine), DVec3::ONE, "a perfect mirror");
        }
    }
}
