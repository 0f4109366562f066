//! Computes the albedo of rough gold by importance sampling, and compares it with quadrature. The example needs no GPU.
//!
//! Cosine sampling is shown for comparison. Cosine sampling converges more slowly, and to a smaller value: facets of a rough surface also
//! reflect light from below the macrosurface's horizon, where cosine sampling has no samples.
//!
//! ```sh
//! cargo run --example 05_sample_a_brdf
//! ```

use leadr::reflectance::facets::beckmann::Beckmann;
use leadr::reflectance::facets::fresnel::Fresnel;
use leadr::reflectance::facets::ggx::Ggx;
use leadr::reflectance::frame::{frame_about, from_frame};
use leadr::reflectance::masking::variants::Masking;
use leadr::reflectance::materials::brdf::Brdf;
use leadr::reflectance::materials::microfacet::Microfacet;
use leadr::reflectance::quadrature::composite_gauss;

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

fn main() {
    // The complex refractive index of gold at 630, 532 and 465 nm.
    let gold = Fresnel::Conductor { eta: DVec3::new(0.18, 0.54, 1.35), k: DVec3::new(3.42, 2.24, 1.87) };
    let mean = DVec2::new(0.3, -0.1);
    let roughness = DVec3::new(0.16, 0.04, 0.03);
    let masking = Masking::SmithCorrelated;
    let materials: [(&str, Box<dyn Brdf>); 2] = [
        (
            "Beckmann",
            Box::new(Microfacet { distribution: Beckmann::new(mean, roughness), masking, fresnel: gold.clone() }),
        ),
        ("GGX", Box::new(Microfacet { distribution: Ggx::new(mean, 2.0 * roughness), masking, fresnel: gold })),
    ];
    let wo = DVec3::new(-0.6, 0.3, 0.5).normalize();
    for (name, brdf) in materials {
        let exact = quadrature(brdf.as_ref(), wo);
        println!("{name}: albedo by quadrature {exact:.5}");
        println!("   samples   by importance sampling          error      by the cosine (red)  error");
        for power in [2, 6, 10, 14, 18] {
            let n = 1u32 << power;
            let (mut visible, mut cosine) = (DVec3::ZERO, DVec3::ZERO);
            for i in 0..n {
                let u = low_discrepancy(i);
                visible += brdf.sample(wo, u).map_or(DVec3::ZERO, |s| s.throughput);
                let wi = leadr::reflectance::materials::brdf::cosine_sample(u);
                cosine += brdf.eval_cos(wo, wi) * (PI / wi.z.max(1e-9));
            }
            let (visible, cosine) = (visible / f64::from(n), cosine / f64::from(n));
            println!(
                "{n:>10}   {visible:.5}   {:.1e}    {:.5}              {:.1e}",
                (visible - exact).length(),
                cosine.x,
                (cosine - exact).length()
            );
        }
    }
}

/// Returns a point of the additive recurrence on the plastic number, which is a two-dimensional low-discrepancy sequence of any length.
fn low_discrepancy(i: u32) -> DVec2 {
    (DVec2::splat(0.5) + f64::from(i) * DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_3)).fract()
}

/// Returns `∫ f_r cos θ_i dwi` over the sphere, in polar coordinates about the viewer by half the angle.
fn quadrature(brdf: &dyn Brdf, wo: DVec3) -> DVec3 {
    let frame = frame_about(wo);
    let mut sum = DVec3::ZERO;
    for (half, w) in composite_gauss(0.0, 0.5 * PI, 60, 8) {
        let (sin, cos) = (2.0 * half).sin_cos();
        for (phi, v) in composite_gauss(0.0, TAU, 60, 8) {
            let wi = from_frame(&frame, DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
            sum += w * v * 2.0 * sin * brdf.eval_cos(wo, wi);
        }
    }
    sum
}
