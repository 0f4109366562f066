//! Extracts the Fresnel term of a material whose slope distribution has been fitted (thesis algorithm 2).

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::samples::pair;
use crate::facets::fresnel::FresnelTable;
use crate::facets::radial_table::angle_at;
use crate::facets::tabulated::Tabulated;
use crate::masking::variants::Masking;
use crate::materials::brdf::Brdf;
use crate::materials::microfacet::microfacet_eval;

/// The lowest reflectance of ideal facets that may divide a measured reflectance. Ratios to smaller values are unreliable.
const LEAST: f64 = 1e-4;

/// Returns the reflectance of the material divided by the reflectance of ideal specular facets with these slopes, averaged over the half
/// vectors. The table has `count` difference angles from 0 to 90°, and its values are clamped to 0..1.
pub fn mean_ratio_fresnel(brdf: &dyn Brdf, slopes: &Tabulated, masking: Masking, count: usize) -> FresnelTable {
    let count = count.max(2);
    let azimuths = if matches!(slopes, Tabulated::Radial(_)) { 1 } else { 8 };
    let mut values = Vec::with_capacity(count);
    for d in 0..count - 1 {
        let theta_d = d as f64 / (count - 1) as f64 * FRAC_PI_2;
        let (mut sum, mut number) = (DVec3::ZERO, 0.0);
        for h in 0..count {
            for k in 0..azimuths {
                let phi_h = FRAC_PI_2 * 4.0 * f64::from(k) / f64::from(azimuths);
                // Both directions have the same height, so most pairs stay above the horizon.
                let (wo, wi, _) = pair(angle_at(h as f64 / count as f64), phi_h, theta_d, FRAC_PI_2);
                if wo.z <= 0.0 || wi.z <= 0.0 {
                    continue;
                }
                let ideal = microfacet_eval(masking, slopes, wo, wi) / wi.z;
                if ideal > LEAST {
                    sum += brdf.eval(wo, wi) / ideal;
                    number += 1.0;
                }
            }
        }
        values.push(if number > 0.0 { (sum / number).clamp(DVec3::ZERO, DVec3::ONE) } else { DVec3::ONE });
    }
    values.push(values[count - 2]);
    FresnelTable::new(values).expect("reflectances within 0..1")
}
