//! The light that materials reflect at a point of a surface. All materials use equal sample directions and thus have equal noise.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use leadr_reflectance::frame::{Frame, from_frame, to_frame};
use leadr_reflectance::materials::brdf::{Brdf, cosine_sample};

/// A von Mises–Fisher lobe, the form of lamps and of glows.
#[derive(Clone, Copy, Debug)]
pub struct LightLobe {
    /// The unit direction towards the middle of the lobe.
    pub toward: DVec3,
    /// The concentration of the lobe, above 0.
    pub sharpness: f64,
}

impl LightLobe {
    /// Returns the value for a unit direction, which is 1 in the middle.
    pub fn value(&self, w: DVec3) -> f64 {
        (self.sharpness * (w.dot(self.toward) - 1.0)).exp()
    }

    fn pdf(&self, w: DVec3) -> f64 {
        let norm = self.sharpness / (TAU * -(-2.0 * self.sharpness).exp_m1());
        norm * self.value(w)
    }

    fn sample(&self, u: DVec2) -> DVec3 {
        let z = 1.0 + (u.x + (1.0 - u.x) * (-2.0 * self.sharpness).exp()).ln() / self.sharpness;
        let (x, y) = self.toward.any_orthonormal_pair();
        let (sine, cosine) = (TAU * u.y).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        x * (r * cosine) + y * (r * sine) + self.toward * z
    }
}

/// The light around a point, and the number of directions from which it is sampled.
pub struct Surroundings<'a> {
    /// Returns the radiance in linear RGB from a unit world direction.
    pub radiance: &'a (dyn Fn(DVec3) -> DVec3 + Sync),
    /// The lobes of the bright parts, from which directions are drawn. The list may be empty.
    pub lobes: &'a [LightLobe],
    /// The number of sample directions per point, for each sampling strategy.
    pub directions: u32,
}

/// Returns the radiance in linear RGB that each material reflects towards the eye. `frame` is the tangent frame of the point, and
/// `towards_eye` a unit world direction. The directions are drawn from the cosine, from `guide` and from the lobes of the light. `shift`
/// in `[0, 1)²` moves the sequence of samples.
pub fn reflected(
    materials: &[&(dyn Brdf + Sync)],
    guide: &(dyn Brdf + Sync),
    around: &Surroundings<'_>,
    frame: &Frame,
    towards_eye: DVec3,
    shift: DVec2,
) -> Vec<DVec3> {
    let Surroundings { radiance, lobes, directions } = *around;
    let wo = to_frame(frame, towards_eye);
    let mut sums = vec![DVec3::ZERO; materials.len()];
    let mut add = |wi: DVec3| {
        if wi.z <= 1e-6 {
            return;
        }
        let w = from_frame(frame, wi);
        let of_lobes = lobes.iter().map(|lobe| lobe.pdf(w)).sum::<f64>() / lobes.len().max(1) as f64;
        // The balance heuristic combines the strategies.
        let pdf = wi.z / PI + guide.pdf(wo, wi) + of_lobes;
        let incident = radiance(w) / (pdf * f64::from(directions));
        for (sum, material) in sums.iter_mut().zip(materials) {
            *sum += material.eval_cos(wo, wi) * incident;
        }
    };
    // The samples form Roberts' low-discrepancy sequence.
    for k in 0..directions {
        let u = (DVec2::new(0.754_877_666_25, 0.569_840_290_99) * (f64::from(k) + 0.5) + shift).fract();
        add(cosine_sample(u));
        if let Some(sample) = guide.sample(wo, u) {
            add(sample.wi);
        }
        if !lobes.is_empty() {
            add(to_frame(frame, lobes[k as usize % lobes.len()].sample(u)));
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::facets::fresnel::Fresnel;
    use leadr_reflectance::facets::ggx::Ggx;
    use leadr_reflectance::frame::frame_about;
    use leadr_reflectance::masking::variants::Masking;
    use leadr_reflectance::materials::lambert::Lambert;
    use leadr_reflectance::materials::microfacet::Microfacet;

    #[test]
    fn materials_have_equal_noise_with_and_without_lobes() {
        let frame = frame_about(DVec3::new(0.3, -0.5, 0.6).normalize());
        let eye = from_frame(&frame, DVec3::new(0.4, 0.2, 0.8).normalize());
        let lobe = LightLobe { toward: DVec3::new(0.2, -0.9, 0.4).normalize(), sharpness: 50.0 };
        let guide = Microfacet {
            distribution: Ggx::isotropic(DVec2::ZERO, 0.2),
            masking: Masking::SmithCorrelated,
            fresnel: Fresnel::Schlick(DVec3::splat(0.5)),
        };
        let [white, grey] = [1.0, 0.5].map(|albedo| Lambert { albedo: DVec3::splat(albedo) });
        let bright = |w: DVec3| DVec3::splat(0.5 + 0.2 * w.z) + DVec3::splat(20.0) * lobe.value(w);
        // A diffuse surface reflects the cosine-weighted mean of the light over its hemisphere.
        let n = 400;
        let mean = |radiance: &dyn Fn(DVec3) -> DVec3| {
            let u = |i: i32| DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
            (0..n * n).map(|i| radiance(from_frame(&frame, cosine_sample(u(i))))).sum::<DVec3>() / f64::from(n * n)
        };
        let even = |w: DVec3| DVec3::splat(0.5 + 0.2 * w.z);
        for (radiance, lobes) in [(&bright as &(dyn Fn(DVec3) -> DVec3 + Sync), &[lobe][..]), (&even, &[])] {
            let around = Surroundings { radiance, lobes, directions: 48 };
            let found = reflected(&[&white, &grey], &guide, &around, &frame, eye, DVec2::new(0.3, 0.7));
            let wanted = mean(radiance);
            assert!((found[0] - wanted).length() < 0.02 * wanted.length(), "{} {wanted}", found[0]);
            assert!((found[0] - 2.0 * found[1]).length() < 1e-12);
        }
    }
}
