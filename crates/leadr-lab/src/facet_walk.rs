//! Simulates multiple bounces between facets by a random walk on a Smith microsurface (Heitz, Hanika, d'Eon and Dachsbacher
//! 2016). The walk is the reference for [`materials::energy`](leadr_reflectance::materials::energy) and
//! [`materials::multiscattering`](leadr_reflectance::materials::multiscattering).
//!
//! A Smith surface is a volume of facets with independent heights and normals. The probability that a ray in direction `w`
//! from height `h` hits no facet is `C(h)^Λ(w)`. `C` is the distribution function of heights, and `Λ(w)` is negative for
//! downward directions. The result does not depend on the height distribution, so heights are measured by the value of `C`.
//! The normal of a hit facet is visible from the ray's origin. Facets are specular, or diffuse under a specular coat. Every
//! bounce adds its contribution to each direction of a list, so one walk serves all directions.
//!
//! The walk is meant for isotropic distributions with mean slope 0, but accepts any distribution that can sample visible
//! normals.

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::fresnel::schlick_weight;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::frame::{frame_about, from_frame};
use leadr_reflectance::materials::brdf::cosine_sample;
use leadr_reflectance::materials::microfacet::half_vector;
use leadr_reflectance::materials::multiscattering::FACET_DIFFUSE;
use leadr_reflectance::random::Random;
use std::f64::consts::FRAC_1_PI;

/// The material of the facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facets {
    /// Specular facets with Schlick's Fresnel term. The value is the reflectance at normal incidence, and 1 is an ideal
    /// reflector.
    Specular(f64),
    /// White Lambertian facets.
    Lambert,
    /// Diffuse facets under a coat with this reflectance
    /// ([`facet_diffuse`](leadr_reflectance::materials::multiscattering::facet_diffuse)). Light that the coat reflects is
    /// lost (Chan 2018, 5.4).
    Diffuse(f64),
    /// Diffuse facets under a coat with this reflectance, where no light is lost. Purely specular paths are not counted,
    /// because they belong to the specular lobe.
    Coated(f64),
}

/// The number of bounces that are stored separately. Later bounces are added to the last entry.
pub const ORDERS: usize = 12;

/// The mean of walks from one direction, by the number of diffuse bounces, or of all bounces for specular facets. Entry `k`
/// is for `k + 1` bounces. If facets are not white, multiply entry `k` by the facet albedo to the power `k + 1`.
#[derive(Clone, Debug, PartialEq)]
pub struct Walks {
    /// The value of `f_r cos θ_o` towards each requested direction.
    pub towards: Vec<[f64; ORDERS]>,
    /// The directional albedo, which is the fraction of light that leaves in any direction.
    pub albedo: [f64; ORDERS],
}

/// A ray among the facets, with its direction and its height. The height is a value of the distribution function.
struct Ray {
    towards: DVec3,
    height: f64,
}

/// Computes `Λ` for any direction: `A(w) / w.z − 1` upwards, and `−A(−w) / |w.z|` downwards.
fn lambda(distribution: &impl SlopeDistribution, w: DVec3) -> f64 {
    let z = w.z.abs().max(1e-9);
    if w.z >= 0.0 { distribution.visible_area(w) / z - 1.0 } else { -distribution.visible_area(-w) / z }
}

/// Samples the height of the next hit on a ray. Returns `None` if the ray leaves the surface.
fn next_height(distribution: &impl SlopeDistribution, ray: &Ray, u: f64) -> Option<f64> {
    let lambda = lambda(distribution, ray.towards);
    // The probability of reaching height c without a hit is (height / c)^Λ.
    if lambda.abs() < 1e-9 {
        return None;
    }
    let free = if lambda > 0.0 { ray.height.powf(lambda) } else { 0.0 };
    let rest = 1.0 - u;
    (rest > free).then(|| (ray.height / rest.powf(1.0 / lambda)).clamp(1e-300, 1.0))
}

/// Samples a diffuse direction about the normal. The density is `∝ cos (1 − (1 − cos)⁵)` under a coat.
fn diffuse_direction(facets: Facets, normal: DVec3, random: &mut Random) -> DVec3 {
    loop {
        let local = cosine_sample(DVec2::new(random.unit(), random.unit()));
        if facets == Facets::Lambert || random.unit() >= schlick_weight(local.z) {
            return from_frame(&frame_about(normal), local);
        }
    }
}

/// Returns the mean of `count` walks of light from `wi` on facets of a `distribution`. `seed` selects the random stream.
/// `outwards` lists the directions of the requested BRDF values. Specular facets ([`Facets::Specular`]) use the density of
/// normals, so smoother surfaces have more noise.
pub fn facet_walks(
    distribution: &impl SlopeDistribution,
    facets: Facets,
    wi: DVec3,
    outwards: &[DVec3],
    count: u64,
    seed: u64,
) -> Walks {
    let mut sum = Walks { towards: vec![[0.0; ORDERS]; outwards.len()], albedo: [0.0; ORDERS] };
    let lambdas: Vec<f64> = outwards.iter().map(|w| lambda(distribution, *w)).collect();
    let mut random = Random::stream(seed, count);
    for _ in 0..count {
        walk(distribution, facets, wi, outwards, &lambdas, &mut random, &mut sum);
    }
    let scale = 1.0 / count.max(1) as f64;
    for orders in sum.towards.iter_mut().chain([&mut sum.albedo]) {
        orders.iter_mut().for_each(|x| *x *= scale);
    }
    sum
}

fn walk(
    distribution: &impl SlopeDistribution,
    facets: Facets,
    wi: DVec3,
    outwards: &[DVec3],
    lambdas: &[f64],
    random: &mut Random,
    sum: &mut Walks,
) {
    let mut ray = Ray { towards: -wi, height: 1.0 };
    let (mut weight, mut order) = (1.0, 0usize);
    for _ in 0..10_000 {
        let Some(height) = next_height(distribution, &ray, random.unit()) else {
            if order > 0 {
                sum.albedo[(order - 1).min(ORDERS - 1)] += weight;
            }
            return;
        };
        ray.height = height;
        let back = -ray.towards;
        let wn = visible_normal(distribution, back, random);
        let cosine = back.dot(wn).clamp(0.0, 1.0);
        let grazing = schlick_weight(cosine);
        let (diffuse, f0) = match facets {
            Facets::Specular(f0) => (false, f0),
            Facets::Lambert => (true, 0.0),
            Facets::Diffuse(f0) => (true, f0),
            // The coat transmits some light, which continues, and reflects the rest.
            Facets::Coated(f0) => (random.unit() >= f0 + (1.0 - f0) * grazing, f0),
        };
        if diffuse {
            if let Facets::Diffuse(f0) = facets {
                weight *= (1.0 - f0) * (1.0 - grazing);
            }
            order += 1;
            let slot = (order - 1).min(ORDERS - 1);
            for ((wo, lambda), towards) in outwards.iter().zip(lambdas).zip(&mut sum.towards) {
                let out = wo.dot(wn);
                if out > 0.0 {
                    let lobe = match facets {
                        Facets::Lambert => FRAC_1_PI * out,
                        _ => FACET_DIFFUSE * out * (1.0 - schlick_weight(out)),
                    };
                    towards[slot] += weight * lobe * height.powf(*lambda);
                }
            }
            ray.towards = diffuse_direction(facets, wn, random);
        } else {
            let f = f0 + (1.0 - f0) * grazing;
            if let Facets::Specular(_) = facets {
                weight *= f;
                order += 1;
            }
            let slot = order.saturating_sub(1).min(ORDERS - 1);
            if order > 0 {
                for ((wo, lambda), towards) in outwards.iter().zip(lambdas).zip(&mut sum.towards) {
                    let wh = half_vector(*wo, back);
                    if wh.z > 0.0 {
                        let density = 0.25 * distribution.ndf(wh) / distribution.visible_area(back).max(1e-30);
                        let change = match facets {
                            Facets::Specular(_) => (f0 + (1.0 - f0) * schlick_weight(back.dot(wh))) / f.max(1e-30),
                            _ => 1.0,
                        };
                        towards[slot] += weight * density * change * height.powf(*lambda);
                    }
                }
            }
            ray.towards = (2.0 * cosine * wn - back).normalize();
        }
        if weight <= 0.0 {
            return;
        }
    }
}

/// Samples a normal that is visible from a direction. The direction may point below the surface.
fn visible_normal(distribution: &impl SlopeDistribution, back: DVec3, random: &mut Random) -> DVec3 {
    distribution.sample_visible(back, DVec2::new(random.unit(), random.unit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::facets::beckmann::Beckmann;
    use leadr_reflectance::facets::ggx::Ggx;
    use leadr_reflectance::integrals::directional_albedo::{AlbedoRule, directional_albedo};
    use leadr_reflectance::masking::variants::Masking;
    use leadr_reflectance::materials::energy::{EnergyTable, compensation_color};
    use leadr_reflectance::materials::microfacet::microfacet_eval;

    fn direction(c: f64, phi: f64) -> DVec3 {
        let s = ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), c)
    }

    const COUNT: u64 = 20_000;

    /// Five standard errors of a mean, for values between 0 and 1.
    const NOISE: f64 = 5.0 * 0.5 / 141.0;

    fn single_bounce(distribution: &impl SlopeDistribution, wi: DVec3, outwards: &[DVec3]) {
        let walks = facet_walks(distribution, Facets::Specular(1.0), wi, outwards, COUNT, 5);
        let rule = AlbedoRule { azimuths: 5, slopes: 5, order: 7 };
        let e = directional_albedo(distribution, Masking::SmithCorrelated, wi, None, rule).ideal;
        assert!((walks.albedo[0] - e).abs() < NOISE, "{} {e}", walks.albedo[0]);
        assert!((walks.albedo.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        for (wo, got) in outwards.iter().zip(&walks.towards) {
            let want = microfacet_eval(Masking::SmithCorrelated, distribution, wi, *wo);
            assert!((got[0] - want).abs() < 0.03 * want.max(0.1), "{} {want} at {wo}", got[0]);
        }
    }

    /// The first bounce must match the microfacet BRDF with height-correlated masking, and energy must be conserved.
    #[test]
    fn the_first_bounce_is_the_microfacet_brdf() {
        let outwards = [direction(0.9, 0.3), direction(0.5, 2.8), direction(0.1, 3.1)];
        single_bounce(&Ggx::isotropic(DVec2::ZERO, 0.6), direction(0.4, 0.0), &outwards);
        single_bounce(&Beckmann::isotropic(DVec2::ZERO, 0.8), direction(0.7, 0.0), &outwards);
    }

    /// Specular plus diffuse reflection must conserve energy. Directional values must agree with totals, and walks must be
    /// reciprocal.
    #[test]
    fn coated_facets_return_all_light() {
        let d = Ggx::isotropic(DVec2::ZERO, 0.7);
        for c in [0.1, 0.8] {
            let of = |facets| facet_walks(&d, facets, direction(c, 0.0), &[], COUNT, 1).albedo.iter().sum::<f64>();
            let (coated, specular, lossy) =
                (of(Facets::Coated(0.04)), of(Facets::Specular(0.04)), of(Facets::Diffuse(0.04)));
            assert!((coated + specular - 1.0).abs() < NOISE && lossy < coated, "{coated} {specular} {lossy}");
            assert!((of(Facets::Lambert) - 1.0).abs() < 1e-9);
        }
        let brdf = |i: DVec3, o: DVec3| {
            facet_walks(&d, Facets::Coated(0.04), i, &[o], 4 * COUNT, 9).towards[0].iter().sum::<f64>() / o.z
        };
        let (i, o) = (direction(0.8, 0.0), direction(0.3, 2.0));
        assert!((brdf(i, o) / brdf(o, i) - 1.0).abs() < 0.03, "{} {}", brdf(i, o), brdf(o, i));
    }

    /// Compares the compensation's colours with walks that apply the Fresnel term at each bounce.
    #[test]
    fn compensation_is_near_the_walk() {
        let table = EnergyTable::ggx();
        let mut worst = 0.0f64;
        for (alpha, c) in [(0.3, 0.2), (0.6, 0.9), (1.0, 0.5)] {
            let d = Ggx::isotropic(DVec2::ZERO, alpha);
            for f0 in [0.04, 0.5, 0.9] {
                let walk: f64 =
                    facet_walks(&d, Facets::Specular(f0), direction(c, 0.0), &[], COUNT, 3).albedo[1..].iter().sum();
                let lost = 1.0 - table.albedo(alpha, c).ideal;
                let got = lost * compensation_color(DVec3::splat(f0), table.average(alpha).ideal).x;
                worst = worst.max((got - walk).abs());
            }
        }
        println!("further bounces of mirrors: worst difference {worst:.3}");
        assert!(worst < 0.04, "{worst}");
    }

    #[test]
    fn strange_directions_end() {
        for alpha in [1e-9, 1.0] {
            let d = Ggx::isotropic(DVec2::ZERO, alpha);
            for wi in [DVec3::Z, DVec3::X, DVec3::NEG_Z, direction(1e-12, 0.0)] {
                let walks = facet_walks(&d, Facets::Coated(0.04), wi, &[DVec3::X, DVec3::Z], 100, 1);
                assert!(walks.albedo.iter().chain(walks.towards.iter().flatten()).all(|x| x.is_finite()));
            }
        }
    }
}
