//! The device's slope moments, packings, geometric antialiasing and GGX filtering against the f64 reference.
//! `parity/comparator.rs` describes the comparison.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use glam::{DMat2, DVec2, DVec3, DVec4};
use leadr_reflectance::integrals::ggx_filtering::{
    base_share, displaced_ggx, displaced_ggx_masking_shadowing, displaced_ggx_ndf, displaced_ggx_p22,
    displaced_ggx_visible_area, filter_ggx,
};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::geometric_antialiasing::{
    axis_aligned_kernel, clamp_determinant, filter_covariance, filter_roughness, ggx_ndf_clamped, half_vector_kernel,
    isotropic_kernel, kernel_over, tilt_kernel,
};
use leadr_reflectance::slopes::moments::{
    SlopeMoments, add_moments, map_moments, mask_moments, mix_moments, moments_covariance, moments_of_corner,
    moments_of_distribution, moments_of_normal, moments_of_slope, roughen_moments, scale_moments, shear_moments,
    slope_of_heights,
};
use leadr_reflectance::slopes::packing::{
    clean_conservative_covariance, clean_covariance, lean_error, pack_clean, pack_clean_conservative, pack_clean_major,
    pack_leadr, pack_lean, principal_variances, unpack_leadr, unpack_lean,
};
use leadr_reflectance::slopes::statistics::{add_macro_curvature, clamp_covariance};

impl Numbers for SlopeMoments {
    fn numbers(self) -> Vec<f64> {
        list![self.first, self.second]
    }
}

/// A number of either sign, sometimes zero.
fn number(r: &mut Random) -> f64 {
    if r.unit() < 0.05 { 0.0 } else { r.range(-2.0, 2.0) }
}

#[test]
fn slope_moments_parity() {
    parity::<17>(
        "slopes/moments",
        Tolerance { relative: 2e-6, floor: |_| 1.0, unit: |_| 0.0 },
        |r| {
            // Up to 1.6: with steeper means, rounding of the squares destroys the covariance.
            let (m, s, n) = (r.mean_slope() * 0.2, r.covariance(), r.direction() * r.log(0.01, 100.0));
            let rest: [f64; 9] = std::array::from_fn(|i| if i == 7 { r.unit() } else { number(r) });
            join(&[&m.to_array(), &s.to_array(), &n.to_array(), &rest])
        },
        |x| {
            let (m, s, n, shear, column) = (v2(x, 0), v3(x, 2), v3(x, 5), v2(x, 8), v2(x, 10));
            let (linear, eta, t, alpha) = (DMat2::from_cols(column, v2(x, 12)), x[14], x[15], x[16]);
            let (a, b) = (moments_of_distribution(m, s), moments_of_normal(n));
            let flat = SlopeMoments { first: 0.1 * n.truncate(), second: s + 0.02 };
            list![
                a,
                b,
                add_moments(a, b),
                scale_moments(a, eta),
                shear_moments(a, shear),
                map_moments(linear, a),
                mix_moments(a, b, t),
                roughen_moments(a, alpha),
                slope_of_heights(DVec4::new(m.x, m.y, shear.x, shear.y), column.abs() + 0.1),
                moments_covariance(flat),
                moments_of_slope(shear).second.truncate(),
                moments_of_corner(
                    DVec4::new(m.x, m.y, shear.x, shear.y),
                    DVec2::new(-0.2, 0.1) + DVec2::new(-1.0, 1.0) * column * column
                ),
                mask_moments(b, column),
            ]
        },
    );
}

#[test]
fn slope_packing_parity() {
    parity::<8>(
        "slopes/packing",
        // Unpacking LEAN subtracts the bias, so errors are absolute, in units of the limit.
        Tolerance { relative: 2e-6, floor: |k| if (19..24).contains(&k) { 4.0 } else { 0.1 }, unit: |_| 0.0 },
        |r| {
            let (m, s) = (r.mean_slope() * 0.2, r.covariance());
            let a = moments_of_distribution(m, s);
            let rest = [number(r), r.log(0.5, 2.0), r.pick([255.0, 1023.0, 65535.0])];
            join(&[&a.first.to_array(), &a.second.to_array(), &rest])
        },
        |x| {
            let (first, second, height, limit, levels) = (v2(x, 0), v3(x, 2), x[5], x[6], x[7]);
            let a = SlopeMoments { first, second };
            let (p, q) = pack_leadr(a, height);
            let (b, h) = unpack_leadr(p, q);
            let lean = pack_lean(a, limit);
            let third = first.extend(second.x);
            list![
                principal_variances(second),
                p,
                q,
                b,
                [h],
                lean,
                unpack_lean(lean, limit),
                [lean_error(limit, levels), pack_clean(a).z, pack_clean_major(a).z, pack_clean_conservative(a).z],
                clean_covariance(third).truncate(),
                clean_conservative_covariance(third).truncate(),
            ]
        },
    );
}

#[test]
fn geometric_antialiasing_parity() {
    parity::<17>(
        "slopes/geometric_antialiasing",
        // 6 to 8: determinants of thin kernels, which are less accurate in 32 bits.
        Tolerance { relative: 2e-5, floor: |k| [1e-2, 1e-2, 2.0, 1e-3][(k / 3).min(3)], unit: |_| 0.0 },
        |r| {
            let wh = r.direction();
            let d = |r: &mut Random| DVec3::new(number(r), number(r), number(r)) * r.log(1e-4, 1.0);
            let (dx, dy) = (d(r), d(r));
            let (u, v) = (DVec2::new(number(r), number(r)), DVec2::new(number(r), number(r)));
            let kernel = add_macro_curvature(DVec3::ZERO, u * r.log(1e-3, 1.0), v * r.log(1e-3, 1.0));
            let (m, s) = (r.mean_slope(), clamp_covariance(r.covariance()));
            join(&[&wh.to_array(), &dx.to_array(), &dy.to_array(), &m.to_array(), &s.to_array(), &kernel.to_array()])
        },
        |x| {
            let (wh, m, s, kernel) = (v3(x, 0), v2(x, 9), v3(x, 11), v3(x, 14));
            list![
                half_vector_kernel(wh, v3(x, 3), v3(x, 6)),
                tilt_kernel(kernel, m),
                kernel_over(kernel, s),
                axis_aligned_kernel(kernel).truncate(),
                isotropic_kernel(kernel).truncate(),
                filter_covariance(s, kernel),
                filter_roughness(s, kernel),
                [
                    clamp_determinant(s, 1e-2).z,
                    ggx_ndf_clamped(wh, m, s, 1e-4),
                    ggx_ndf_clamped(wh, m, filter_roughness(s, kernel), 1e-4),
                ],
            ]
        },
    );
}

#[test]
fn ggx_filtering_parity() {
    parity::<14>(
        "integrals/ggx_filtering",
        Tolerance { relative: 3e-5, floor: |k| if k < 8 { 1e-3 } else { 1e-6 }, unit: |_| 0.0 },
        |r| {
            let (wo, wi, m) = (r.direction(), r.direction(), r.mean_slope());
            let (a, s) = (clamp_covariance(r.covariance()), clamp_covariance(r.covariance()));
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &a.to_array(), &s.to_array()])
        },
        |x| {
            let (wo, wi, m, a, s) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8), v3(x, 11));
            let d = displaced_ggx(a, s);
            list![
                filter_ggx(a, s),
                [base_share(a, s), d.weight],
                d.roughness,
                [
                    displaced_ggx_p22(wi.truncate(), m, &d),
                    displaced_ggx_ndf(wi, m, &d),
                    displaced_ggx_visible_area(wo, m, &d),
                    displaced_ggx_masking_shadowing(wo, wi, m, &d, true),
                    displaced_ggx_masking_shadowing(wo, wi, m, &d, false),
                ],
            ]
        },
    );
}
