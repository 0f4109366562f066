//! The device's measured facets against the f64 reference: isotropic and anisotropic tables, one of them of a scanned material.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use leadr_measured::Measured;
use leadr_reflectance::extraction::fit::{FitOptions, fit};
use leadr_reflectance::extraction::lobes::fit_lobes;
use leadr_reflectance::facets::beckmann::{Beckmann, beckmann_ndf};
use leadr_reflectance::facets::fresnel::{Fresnel, FresnelTable};
use leadr_reflectance::facets::gaussian_mixture::Lobe;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::polar_table::PolarTable;
use leadr_reflectance::facets::projected_area::visible_area;
use leadr_reflectance::facets::radial_table::{RadialTable, angle_at};
use leadr_reflectance::facets::scaled::Scaled;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::facets::tabulated::Tabulated;
use leadr_reflectance::limits::MIN_AREA;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::fitted::FittedBrdf;
use leadr_reflectance::materials::fitted_table::FittedTable;
use leadr_reflectance::materials::microfacet::{Microfacet, microfacet_eval};

use super::comparator::{Arguments as _, Numbers, Tolerance, list, parity_with, v3};
use leadr_testing::shared::shared_data;

fn normal(i: usize, phi: f64) -> DVec3 {
    let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
    DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine)
}

fn radial(of: &impl SlopeDistribution) -> Tabulated {
    let rows: Vec<f64> = (0..90).map(|i| of.ndf(normal(i, 0.0))).collect();
    Tabulated::Radial(RadialTable::new(&rows).unwrap())
}

fn polar(of: &impl SlopeDistribution) -> Tabulated {
    let row = |k: usize| (0..90).map(|i| of.ndf(normal(i, TAU * k as f64 / 72.0))).collect();
    Tabulated::Polar(PolarTable::new(&(0..72).map(row).collect::<Vec<_>>()).unwrap())
}

fn material(distribution: Tabulated, masking: Masking) -> (FittedBrdf, Vec<Lobe>) {
    let lobes = fit_lobes(&distribution, 4);
    let reflectance = |i: u32| DVec3::new(0.9, 0.5, 0.04).lerp(DVec3::ONE, (f64::from(i) / 90.0).powi(4));
    let fresnel = Fresnel::Tabulated(FresnelTable::new((0..=90).map(reflectance).collect()).unwrap());
    (FittedBrdf { facets: Microfacet { distribution, masking, fresnel }, diffuse: DVec3::ZERO }, lobes)
}

fn check((brdf, lobes): &(FittedBrdf, Vec<Lobe>)) {
    let facets = &brdf.facets;
    let words = FittedTable::new(brdf, lobes, 0.3);
    parity_with::<8>(
        "materials/fitted",
        // Relative to the mean of `D` over the hemisphere.
        Tolerance { relative: 1e-3, floor: |k| [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3][k], unit: |_| 0.0 },
        Some(("Fits", words.words())),
        |r| {
            // Nothing is visible from below.
            let wo = r.direction();
            let wo = DVec3::new(wo.x, wo.y, wo.z.abs());
            // Half of the lights are near the reflected direction.
            let wn = normal((r.unit() * 60.0) as usize, r.range(0.0, TAU));
            let wi = if r.unit() < 0.5 { r.direction() } else { (2.0 * wo.dot(wn) * wn - wo).normalize() };
            let stretch = if r.unit() < 0.5 { 1.0 } else { r.log(0.3, 3.0) };
            [wo.x, wo.y, wo.z, wi.x, wi.y, wi.z, stretch, r.unit()]
        },
        |x| {
            let (wo, wi, factor) = (v3(x, 0), v3(x, 3), x[6]);
            let scaled = Scaled { inner: facets.distribution.clone(), factor };
            let of_lobes = |of: &dyn Fn(DVec3) -> f64| {
                lobes.iter().map(|lobe| lobe.share * of(factor * factor * lobe.covariance)).sum::<f64>()
            };
            let area = of_lobes(&|s| visible_area(wo, DVec2::ZERO, s));
            let density = 0.25 * of_lobes(&|s| beckmann_ndf(wi, DVec2::ZERO, s)) / area.max(MIN_AREA);
            list![
                [scaled.ndf(wi), scaled.visible_area(wo)],
                facets.fresnel.at(x[7]),
                [microfacet_eval(facets.masking, &scaled, wo, wi), area, density]
            ]
        },
    );
}

#[test]
#[ignore = "long"]
fn fitted_parity() {
    let (m, a) = (DVec2::ZERO, DVec3::new(0.09, 0.01, 0.012));
    check(&material(radial(&Ggx::isotropic(m, 0.3)), Masking::SmithCorrelated));
    check(&material(radial(&Beckmann::new(m, DVec3::new(2e-3, 2e-3, 0.0))), Masking::VGroove));
    check(&material(polar(&Ggx::new(m, a)), Masking::NormalMap));
}

#[test]
fn fitted_parity_of_a_scan() {
    let Some(folder) = shared_data("brdf/rgl_bsdf") else { return };
    let measured = Measured::load(&folder.join("cc_ibiza_sunset_rgb.bsdf")).unwrap();
    let found = fit(&measured, true, &FitOptions::default(), &mut |_| ()).unwrap();
    check(&(found.fitted, found.lobes));
}
