//! Specular occlusion by a cone, which is the fraction of an environment's specular reflection that comes from within the cone.
//!
//! [`ConeTable`] is the published method (Chan 2018, 4.7), and has the exact albedo for a cone about the normal. A cone about the normal
//! approximates a point's visibility poorly. [`cone_specular`] needs no table and supports a cone about any axis.

use crate::facets::ggx::Ggx;
use crate::integrals::directional_albedo::{AlbedoRule, directional_albedo};
use crate::limits::{at_least, unit};
use crate::masking::occlusion::{Cone, bent_cone_visibility};
use crate::masking::variants::Masking;
use crate::materials::energy::SplitAlbedo;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Returns the fraction of a GGX lobe that is within a cone. `apart` is the angle between the lobe direction and the cone axis, and `half`
/// is the half angle of the cone, both in radians. `alpha` is the facets' roughness in the plane of the lobe direction and the cone axis.
///
/// Half vectors rotate by half the angle of directions. GGX slopes are the stereographic projection of a uniformly covered sphere, and a
/// disc of slopes is a spherical cap. The cap from `tan((apart − half)/2) / α` to `tan((apart + half)/2) / α` covers the fraction `sin²` of
/// a quarter of its angle.
pub fn lobe_in_cone(alpha: f64, apart: f64, half: f64) -> f64 {
    let end = |angle: f64| {
        let (sin, cos) = (0.5 * angle).sin_cos();
        sin.atan2(at_least(alpha, 1e-4) * at_least(cos, 0.0))
    };
    let cap = 0.5 * (end(apart + half) - end(apart - half));
    cap.sin() * cap.sin()
}

/// Returns the fraction, from 0 to 1, of the specular reflection towards `wo` that comes from within the cone. The fraction is a factor for
/// a prefiltered environment. A hemispherical cone about the normal gives 1.
///
/// The fraction is [`lobe_in_cone`] about the reflection direction of a rough surface, relative to its value for the upper hemisphere. For
/// the roughest surfaces, the result is the diffuse visibility ([`bent_cone_visibility`]).
pub fn cone_specular(alpha: f64, wo: DVec3, cone: &Cone) -> f64 {
    let (c, a) = (wo.z.clamp(0.0, 1.0), alpha.clamp(1e-4, 1.0));
    let mirror = lobe_axis(a, wo);
    let share = |axis: DVec3, half: f64| {
        // Across the plane of incidence, the reflected direction moves less, by a factor of the viewer's cosine. The lobe is narrower by
        // this cosine for a cone beside the plane, and by its square root for a cone around the lobe. The factor 0.2 is empirical.
        let across = axis - mirror * mirror.dot(axis);
        let flat = mirror.truncate().length_squared();
        let outward = mirror.truncate() / at_least(flat, 1e-20).sqrt();
        let within = outward.dot(across.truncate()) * mirror.z - flat.sqrt() * across.z;
        let beside = outward.perp_dot(across.truncate()) * c;
        let (away, wide) = (across.length_squared(), 0.2 * half.sin().powi(2));
        let inside = if flat < 1e-8 { away } else { within * within + beside * beside };
        let narrow = a * ((inside + wide * c) / at_least(away + wide, 1e-12)).sqrt();
        lobe_in_cone(narrow, away.sqrt().atan2(mirror.dot(axis)), half)
    };
    let cosine = cone.cosine.clamp(0.0, 1.0);
    let half = ((1.0 - cosine) * (1.0 + cosine)).sqrt().atan2(cosine);
    let overlap = (share(cone.axis, half) / at_least(share(DVec3::Z, FRAC_PI_2), 1e-6)).clamp(0.0, 1.0);
    let t = ((a - 0.2) / 0.7).clamp(0.0, 1.0);
    overlap + (bent_cone_visibility(cone) - overlap) * (t * t * (3.0 - 2.0 * t))
}

/// Returns the dominant reflection direction of a rough surface, which is closer to the normal than the mirror direction. Viewers below the
/// horizon are clamped to it.
fn lobe_axis(alpha: f64, wo: DVec3) -> DVec3 {
    let mirror = DVec3::new(-wo.x, -wo.y, at_least(wo.z, 0.0));
    let keep = (1.0 - alpha) * ((1.0 - alpha).sqrt() + alpha);
    let axis = DVec3::Z.lerp(mirror, keep);
    axis / at_least(axis.length(), 1e-6)
}

/// Returns the texture coordinate for a lookup in a [`ConeTable`] stored as a 3D texture. The sampler must be linear and clamp (listing 5).
pub fn cone_table_texcoord(n_v: f64, gloss: f64, cosine: f64) -> DVec3 {
    let size = DVec3::from_array(CONE_TABLE.map(|n| n as f64));
    (DVec3::new(n_v, gloss, cosine).clamp(DVec3::ZERO, DVec3::ONE) * (size - DVec3::ONE) + 0.5) / size
}

/// The table of Chan 2018, figure 19: the directional albedo of specular GGX facets under light through a cone about the normal. The axes
/// are the viewer's cosine, the gloss, and the cosine of the cone, each from 0 to 1 in even steps (listing 5).
#[derive(Clone, Debug, PartialEq)]
pub struct ConeTable(Vec<[f32; 2]>);

/// The number of nodes of a [`ConeTable`] along each of its three axes.
pub const CONE_TABLE: [usize; 3] = [32, 32, 8];

impl ConeTable {
    /// Computes the table by quadrature, in a second or two. `alpha` returns the roughness of a gloss.
    pub fn new(alpha: impl Fn(f64) -> f64 + Sync) -> Self {
        let [nx, ny, nz] = CONE_TABLE;
        let rule = AlbedoRule { azimuths: 4, slopes: 4, order: 5 };
        let at = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let texel = |i: usize| {
            let (c, g, cosine) = (at(i % nx, nx).max(1e-3), at(i / nx % ny, ny), at(i / (nx * ny), nz));
            let wo = DVec3::new(((1.0 - c) * (1.0 + c)).sqrt(), 0.0, c);
            let facets = Ggx::isotropic(DVec2::ZERO, alpha(g));
            let cone = Cone { axis: DVec3::Z, cosine };
            let albedo = directional_albedo(&facets, Masking::SmithCorrelated, wo, Some(cone), rule);
            [albedo.scale() as f32, albedo.bias() as f32]
        };
        Self((0..nx * ny * nz).into_par_iter().map(texel).collect())
    }

    /// Returns the texels of a 3D texture, with x varying fastest. Each texel is the `(scale, bias)` of `F0`.
    pub fn texels(&self) -> &[[f32; 2]] {
        &self.0
    }

    /// Interpolates the table trilinearly, like a sampler. The arguments are clamped to 0..1.
    pub fn albedo(&self, n_v: f64, gloss: f64, cosine: f64) -> SplitAlbedo {
        let cell = |v: f64, n: usize| {
            let x = unit(v) * (n - 1) as f64;
            let i = (x as usize).min(n - 2);
            (i, x - i as f64)
        };
        let [nx, ny, nz] = CONE_TABLE;
        let [(i, x), (j, y), (k, z)] = [cell(n_v, nx), cell(gloss, ny), cell(cosine, nz)];
        let mut sum = [0.0; 2];
        for corner in 0..8 {
            let [a, b, c] = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight = |t: f64, upper: usize| if upper == 1 { t } else { 1.0 - t };
            let texel = self.0[i + a + nx * (j + b + ny * (k + c))];
            let w = weight(x, a) * weight(y, b) * weight(z, c);
            sum = [sum[0] + w * f64::from(texel[0]), sum[1] + w * f64::from(texel[1])];
        }
        SplitAlbedo { ideal: sum[0] + sum[1], grazing: sum[1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::masking::occlusion::{adjusted_cone_cosine, cone_cosine};
    use crate::random::Random;
    use std::f64::consts::TAU;

    /// Compares the rms errors of four methods for random bent cones and viewers: the cone about the normal, its two published adjustments,
    /// and the lobe overlap.
    #[test]
    fn overlap_against_cones_about_the_normal() {
        let rule = AlbedoRule { azimuths: 3, slopes: 4, order: 5 };
        println!("roughness, viewer: normal cone, eq. 59, listing 3, overlap");
        for (low, high) in [(0.03, 0.1), (0.1, 0.3), (0.3, 0.5), (0.5, 0.7), (0.7, 1.0)] {
            for (from, to) in [(0.5, 1.0), (0.1, 0.5)] {
                let n = 100u64;
                let errors: Vec<[f64; 4]> = (0..n)
                    .into_par_iter()
                    .map(|i| {
                        let mut r = Random::stream(7, i);
                        let (alpha, c) = (r.range(low, high), r.range(from, to));
                        let wo = DVec3::new((1.0 - c * c).sqrt(), 0.0, c);
                        let (tilt, azimuth, half) = (r.range(0.0, 1.0), r.range(0.0, TAU), r.range(0.3, 1.5));
                        let side = tilt.sin();
                        let axis = DVec3::new(side * azimuth.cos(), side * azimuth.sin(), tilt.cos());
                        let cone = Cone { axis, cosine: half.cos() };
                        let facets = Ggx::isotropic(DVec2::ZERO, alpha);
                        let albedo = |k| directional_albedo(&facets, Masking::SmithCorrelated, wo, k, rule).ideal;
                        let full = albedo(None);
                        let truth = albedo(Some(cone)) / full;
                        let about_normal = |cosine| albedo(Some(Cone { axis: DVec3::Z, cosine })) / full;
                        let cosine = cone_cosine(bent_cone_visibility(&cone));
                        let gloss = ((2.0 / (alpha * alpha) - 1.0).log2() / 18.0).clamp(0.0, 1.0);
                        let adjusted = |biased, exponent| {
                            about_normal(adjusted_cone_cosine(cosine, gloss, c, biased, exponent)) - truth
                        };
                        let plain = about_normal(cosine) - truth;
                        [plain, adjusted(false, 8), adjusted(true, 6), cone_specular(alpha, wo, &cone) - truth]
                    })
                    .collect();
                let rms = [0, 1, 2, 3].map(|k| (errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / n as f64).sqrt());
                println!("α {low}–{high}, cos {from}–{to}: {rms:.3?}");
                let bound = if high > 0.6 || from < 0.5 { 0.075 } else { 0.055 };
                assert!(rms[3] < bound, "{rms:?}");
                // The lobe overlap is the best of the four methods up to a roughness of 0.7.
                assert!(high > 0.7 || rms[..3].iter().all(|other| rms[3] < *other), "{rms:?}");
            }
        }
    }

    /// Eight cones are too few for smooth surfaces, because their lobes lie wholly inside or outside a cone.
    #[test]
    fn the_table_between_its_nodes() {
        let alpha = |gloss: f64| (2.0 / (1.0 + (18.0 * gloss).exp2())).sqrt();
        let table = ConeTable::new(alpha);
        let rule = AlbedoRule { azimuths: 4, slopes: 4, order: 5 };
        let error = |open: bool| {
            let n = 500u64;
            let errors: Vec<f64> = (0..n)
                .into_par_iter()
                .map(|i| {
                    let mut r = Random::stream(3, i);
                    let (c, gloss, cosine) = (r.range(1e-3, 1.0), r.unit(), if open { 0.0 } else { r.unit() });
                    let wo = DVec3::new((1.0 - c * c).sqrt(), 0.0, c);
                    let facets = Ggx::isotropic(DVec2::ZERO, alpha(gloss));
                    let cone = Cone { axis: DVec3::Z, cosine };
                    let exact = directional_albedo(&facets, Masking::SmithCorrelated, wo, Some(cone), rule);
                    table.albedo(c, gloss, cosine).scale() - exact.scale()
                })
                .collect();
            let worst = errors.iter().fold(0.0f64, |m, e| m.max(e.abs()));
            ((errors.iter().map(|e| e * e).sum::<f64>() / n as f64).sqrt(), worst)
        };
        let (open, cones) = (error(true), error(false));
        println!("scale between texels, rms and worst: hemispheres {open:.4?}, cones {cones:.4?}");
        assert!(open.0 < 0.005 && (0.04..0.08).contains(&cones.0), "{open:?} {cones:?}");
    }

    #[test]
    fn open_hemisphere_hides_nothing_closed_cone_everything() {
        for alpha in [0.03, 0.3, 1.0] {
            for c in [0.0f64, 1e-6, 0.3, 1.0] {
                let wo = DVec3::new(((1.0 - c) * (1.0 + c)).sqrt(), 0.0, c);
                let open = cone_specular(alpha, wo, &Cone { axis: DVec3::Z, cosine: 0.0 });
                assert!((open - 1.0).abs() < 1e-9, "{alpha} {c}: {open}");
                assert!(cone_specular(alpha, wo, &Cone { axis: DVec3::Z, cosine: 1.0 }) < 1e-9);
            }
        }
        for wo in [DVec3::ZERO, DVec3::NEG_Z, DVec3::X] {
            for axis in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::splat(1e100)] {
                for cosine in [-2.0, 0.0, 0.5, 2.0] {
                    let share = cone_specular(0.5, wo, &Cone { axis, cosine });
                    assert!((0.0..=1.0).contains(&share), "{wo} {axis} {cosine}: {share}");
                }
            }
        }
    }

    /// The spherical cap gives the exact mass of an off-centre disc under the GGX slope density.
    #[test]
    fn a_disc_of_slopes_is_a_cap() {
        use crate::quadrature::composite_gauss;
        let (alpha, centre, radius) = (0.4f64, 0.5f64, 0.3f64);
        let mut sum = 0.0;
        for (r, w) in composite_gauss(0.0, radius, 1, 20) {
            for k in 0..64 {
                let (sin, cos) = (TAU * f64::from(k) / 64.0).sin_cos();
                let s = (centre + r * cos).powi(2) + (r * sin).powi(2);
                sum += w * r * TAU / 64.0 * alpha * alpha / (std::f64::consts::PI * (alpha * alpha + s).powi(2));
            }
        }
        let (a, b) = (centre - radius, centre + radius);
        let (apart, half) = (a.atan() + b.atan(), b.atan() - a.atan());
        assert!((lobe_in_cone(alpha, apart, half) - sum).abs() < 1e-12);
    }
}
