//! The GLSL library on the device against the f64 reference, at 100,000 arguments per function, including grazing and
//! degenerate ones. Prints the worst errors, and the driver's name on failure.
//!
//! Rounded arguments limit the accuracy of a 32-bit evaluation, so the tolerance has two parts: a measured relative error, and
//! a multiple of how much the reference changes when each argument changes by about one ulp.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use super::extremes::finite;
use glam::{DMat3, DVec2, DVec3};
use leadr_reflectance::facets::base_roughness::add_facet_roughness;
use leadr_reflectance::facets::beckmann::{beckmann_ndf, beckmann_p22};
use leadr_reflectance::facets::complex_index::{average_deviation, complex_index, fresnel_exact};
use leadr_reflectance::facets::fresnel::{fresnel_dielectric, fresnel_edge_tint, fresnel_schlick};
use leadr_reflectance::facets::normal_distribution::{
    clamped_lean, normal_cdf, normal_pdf, normal_ramp, normal_tail_mean,
};
use leadr_reflectance::facets::projected_area::{
    artificial_micronormal, face_viewer, meso_area, slope_spread, tilt_to_edge, visible_area,
};
use leadr_reflectance::frame::{frame_about, octahedral_decode, octahedral_encode, to_frame};
use leadr_reflectance::integrals::diffuse::{
    groove_diffuse_light, groove_normal_moments, leadr_diffuse_environment, leadr_diffuse_light,
    leadr_diffuse_light_sh, visible_normal_moments,
};
use leadr_reflectance::integrals::sh::{
    sh_add_light, sh_basis, sh_irradiance, sh_irradiance_light, sh_irradiance_rest, sh_rest_damping,
};
use leadr_reflectance::integrals::slope_nodes::{NodePlacement, node_diffuse_light, node_normal_moments, slope_nodes};
use leadr_reflectance::integrals::specular;
use leadr_reflectance::integrals::specular::{
    env_lod, environment_sample, leadr_specular_directional, leadr_specular_light,
};
use leadr_reflectance::limits;
use leadr_reflectance::masking::correlated::direction_area;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::masking::smith::{
    masking, masking_shadowing, shadowing_given_masking, smith_lambda, smith_lambda_fit,
};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{
    facet_area, grid_lambda, grid_node, grid_spacing, normal_of_slope, slope_cholesky, slope_sample,
};
use leadr_reflectance::slopes::map::{map_covariance, map_mean_slope, slope_map};
use leadr_reflectance::slopes::rotation::{SlopePart, join_slopes, rotate_slopes};
use leadr_reflectance::slopes::statistics::{
    add_macro_curvature, add_roughness, clamp_covariance, covariance_from_moments, scale_height,
};
use leadr_testing::gpu::test_gpu;

#[test]
fn normal_distribution_parity() {
    parity::<1>(
        "facets/normal_distribution",
        Tolerance { relative: 1e-5, floor: |_| 1e-36, unit: |_| 0.0 },
        |r| [r.range(-14.0, 14.0)],
        |x| {
            // The device clamps its argument to 13, where the density is 1e-37.
            let t = x[0].clamp(-13.0, 13.0);
            list![[
                normal_pdf(t),
                normal_tail_mean(t),
                normal_cdf(t),
                clamped_lean(x[0]),
                x[0].max(0.0) / normal_ramp(x[0]).ramp
            ]]
        },
    );
}

#[test]
fn projected_area_parity() {
    parity::<8>(
        "facets/projected_area",
        // An artificial micronormal is the difference of vectors that may be a hundred times as long.
        Tolerance {
            relative: 5e-6,
            floor: |k| [1e-6, 1.0, 10.0][usize::from(k > 2) + usize::from(k > 6)],
            unit: |_| 0.0,
        },
        |r| join(&[&r.direction().to_array(), &r.mean_slope().to_array(), &r.covariance().to_array()]),
        |x| {
            let (wo, m, s) = (v3(x, 0), v2(x, 3), v3(x, 5));
            let areas = [meso_area(wo, m), slope_spread(wo, s), visible_area(wo, m, s)];
            list![
                areas,
                face_viewer(wo, m, s, 1.8),
                tilt_to_edge(wo, m),
                artificial_micronormal(wo, normal_of_slope(m))
            ]
        },
    );
}

#[test]
fn base_roughness_parity() {
    parity::<9>(
        "facets/base_roughness",
        Tolerance { relative: 5e-6, floor: |_| 1e-6, unit: |_| 0.0 },
        |r| {
            let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
            join(&[&wo.to_array(), &m.to_array(), &s.to_array(), &[r.unit()]])
        },
        |x| list![add_facet_roughness(v3(x, 5), x[8], v3(x, 0), v2(x, 3))],
    );
}

#[test]
fn masking_parity() {
    parity::<11>(
        "masking/smith",
        Tolerance { relative: 5e-6, floor: |_| 1e-6, unit: |_| 0.0 },
        |r| {
            let (wo, wi) = (r.direction(), r.direction());
            join(&[&wo.to_array(), &wi.to_array(), &r.mean_slope().to_array(), &r.covariance().to_array()])
        },
        |x| {
            let (wo, wi, m, s) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8));
            list![[
                masking(wo, m, s),
                smith_lambda(wo, m, s),
                masking_shadowing(wo, wi, m, s, true),
                shadowing_given_masking(wo, wi, m, s, true),
                smith_lambda_fit(s.x.clamp(0.001, 1.3)),
            ]]
        },
    );
}

#[test]
fn slope_statistics_parity() {
    parity::<11>(
        "slopes/statistics",
        Tolerance { relative: 5e-6, floor: |_| 1e-6, unit: |_| 0.0 },
        |r| {
            let (m, s) = (r.mean_slope(), r.covariance());
            let second = [s.x + m.x * m.x, s.y + m.y * m.y, s.z + m.x * m.y];
            let d = r.log(1e-3, 1e3);
            let step = [r.range(-d, d), r.range(-d, d), r.range(-d, d), r.range(-d, d)];
            join(&[&m.to_array(), &second, &[r.range(-2.0, 2.0), r.unit()], &step])
        },
        |x| {
            let (first, second) = (v2(x, 0), v3(x, 2));
            let s = covariance_from_moments(first, second);
            let curved = add_macro_curvature(DVec3::new(0.01, 0.02, 0.0), v2(x, 7), v2(x, 9));
            list![s, scale_height(second, x[5]), add_roughness(second, x[6]), curved]
        },
    );
}

#[test]
fn slope_map_parity() {
    parity::<14>(
        "slopes/map",
        Tolerance { relative: 1e-5, floor: |_| 1e-2, unit: |_| 1.0 },
        |r| {
            let (mut ts, mut tt) = (r.direction() * r.log(0.1, 10.0), r.direction() * r.log(0.1, 10.0));
            match (r.unit() * 12.0) as u32 {
                0 => tt = ts,
                1 => ts = DVec3::ZERO,
                2 => (ts, tt) = (DVec3::ZERO, DVec3::ZERO),
                _ => {}
            }
            let z = r.direction();
            let rest = [r.range(-2.0, 2.0), r.range(-2.0, 2.0)];
            join(&[&ts.to_array(), &tt.to_array(), &z.to_array(), &rest, &r.covariance().to_array()])
        },
        |x| {
            let z = v3(x, 6);
            let x_axis = (if z.x.abs() < 0.5 { DVec3::X } else { DVec3::Y }).cross(z).normalize();
            let map = slope_map(v3(x, 0), v3(x, 3), x_axis, z.cross(x_axis), z);
            let linear = map.linear.to_cols_array();
            list![linear, map.offset, map_mean_slope(&map, v2(x, 9)), map_covariance(&map, v3(x, 11))]
        },
    );
}

#[test]
fn slope_rotation_parity() {
    parity::<17>(
        "slopes/rotation",
        Tolerance { relative: 1e-5, floor: |_| 1e-2, unit: |_| 1.0 },
        |r| {
            let to = r.direction();
            let from =
                if r.unit() < 0.1 { r.direction() } else { (to + r.direction() * r.range(0.0, 0.6)).normalize() };
            let slope = |r: &mut Random| [r.range(-2.0, 2.0), r.range(-2.0, 2.0)];
            let (mean, covariance, other) = (slope(r), r.covariance().to_array(), slope(r));
            let area = if r.unit() < 0.1 { 0.0 } else { r.log(0.01, 100.0) };
            join(&[&from.to_array(), &to.to_array(), &mean, &covariance, &other, &r.covariance().to_array(), &[area]])
        },
        |x| {
            let (from, to) = (frame_about(v3(x, 0)), frame_about(v3(x, 3)));
            let rotation = DMat3::from_cols(to_frame(&to, from.x), to_frame(&to, from.y), to_frame(&to, from.z));
            let part = rotate_slopes(rotation, v2(x, 6), v3(x, 8));
            let whole = join_slopes(SlopePart { mean: v2(x, 11), covariance: v3(x, 13), area: x[16] }, part);
            list![part.mean, part.covariance, [part.area], whole.mean, whole.covariance, [whole.area]]
        },
    );
}

#[test]
fn frame_parity() {
    parity::<6>(
        "frame",
        Tolerance { relative: 5e-6, floor: |_| 0.1, unit: |_| 0.0 },
        |r| join(&[&r.direction().to_array(), &r.direction().to_array()]),
        |x| {
            let (z, d) = (v3(x, 0), v3(x, 3));
            let f = frame_about(z);
            list![f.x, f.y, to_frame(&f, d), octahedral_encode(d), octahedral_decode(DVec2::new(d.x, d.y))]
        },
    );
}

#[test]
fn beckmann_parity() {
    parity::<8>(
        "facets/beckmann",
        Tolerance { relative: 2e-5, floor: |_| 1e-12, unit: |_| 0.0 },
        |r| {
            let (m, s) = (r.mean_slope(), r.covariance());
            // Half of the half vectors within the lobe.
            let wh = if r.unit() < 0.5 {
                r.direction()
            } else {
                normal_of_slope(slope_sample(DVec2::new(r.range(-3.0, 3.0), r.range(-3.0, 3.0)), m, s))
            };
            join(&[&wh.to_array(), &m.to_array(), &s.to_array()])
        },
        |x| {
            let (wh, m, s) = (v3(x, 0), v2(x, 3), v3(x, 5));
            list![[beckmann_p22(DVec2::new(wh.x, wh.y), m, s), beckmann_ndf(wh, m, s)]]
        },
    );
}

#[test]
fn fresnel_parity() {
    parity::<5>(
        "facets/fresnel",
        // The F82 tint cancels Schlick's form. The index of bright metals depends on small differences.
        Tolerance {
            relative: 3e-6,
            floor: |k| [1e-3, 0.1, 10.0][usize::from(k > 3) + usize::from(k > 6)],
            unit: |_| 0.0,
        },
        |r| [r.unit(), r.unit(), r.unit(), r.range(-0.1, 1.1), r.range(0.4, 3.0)],
        |x| {
            let (f0, edge_tint) = (v3(x, 0), DVec3::new(4.0, 1.0, 0.0));
            let index = complex_index(f0, edge_tint);
            list![
                fresnel_schlick(f0, x[3]),
                [fresnel_dielectric(x[3], x[4])],
                fresnel_edge_tint(f0, edge_tint, x[3]),
                fresnel_exact(f0, &index, x[3]),
                average_deviation(f0, &index)
            ]
        },
    );
}

#[test]
fn slope_grid_parity() {
    parity::<12>(
        "slopes/grid",
        Tolerance { relative: 5e-6, floor: |_| 1e-4, unit: |_| 0.0 },
        |r| {
            let n = r.pick([1.0, 2.0, 3.0, 5.0, 8.0, 32.0, 128.0]);
            let (j, k) = ((r.unit() * n).floor(), (r.unit() * n).floor());
            let rest = [n, j, k, r.range(0.5, 3.0)];
            join(&[&r.direction().to_array(), &r.mean_slope().to_array(), &r.covariance().to_array(), &rest])
        },
        |x| {
            let (wo, m, s, lambda) = (v3(x, 0), v2(x, 3), v3(x, 5), x[11]);
            // Rounded, because the comparison shifts arguments slightly.
            let [n, j, k] = [x[8], x[9], x[10]].map(|v| v.round() as u32);
            let node = grid_node(j, k, n, lambda);
            let slope = slope_sample(DVec2::new(node.x, node.y), m, s);
            let ends = [grid_lambda(n), grid_spacing(n, lambda)];
            list![ends, node, slope, normal_of_slope(slope), [facet_area(wo, slope)]]
        },
    );
}

#[test]
fn specular_parity() {
    parity::<13>(
        "integrals/specular",
        Tolerance { relative: 3e-5, floor: |k| if k < 9 { 1e-5 } else { 0.1 }, unit: |_| 0.0 },
        |r| {
            let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
            // Half of the lights are near the reflected direction of a facet in the lobe.
            let p = [r.range(-2.0, 2.0), r.range(-2.0, 2.0)];
            let wi = if r.unit() < 0.5 { r.direction() } else { environment_sample(wo, DVec2::from_array(p), m, s).wi };
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array(), &p])
        },
        |x| {
            let (wo, wi, m, s) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8));
            let f0 = DVec3::new(0.04, 0.5, 1.0);
            let shadowed = leadr_specular_directional(wo, wi, m, s, f0, true);
            let masked = leadr_specular_directional(wo, wi, m, s, f0, false);
            let e = environment_sample(wo, v2(x, 11), m, s);
            let lod = env_lod(wo, e.wn, s, 0.9, 256.0, specular::LOD_MATCHED);
            let cholesky = slope_cholesky(s);
            let (o, i) = (direction_area(wo, m, cholesky), direction_area(wi, m, cholesky));
            let correlated = leadr_specular_light(Shadowing::Correlated, &o, &i, wo, wi, m, s, f0);
            list![shadowed, masked, correlated, e.wi, e.wn, [e.area, lod]]
        },
    );
}

#[test]
fn sh_parity() {
    parity::<12>(
        "integrals/sh",
        Tolerance { relative: 5e-6, floor: |_| 0.1, unit: |_| 0.0 },
        |r| {
            let d = r.direction();
            let mut x = [0.0; 12];
            x[..3].copy_from_slice(&d.to_array());
            x[3..].fill_with(|| r.range(-1.0, 1.0));
            x
        },
        |x| {
            let d = v3(x, 0);
            let mut c = std::array::from_fn(|i| x[3 + i] * DVec3::new(1.0, 2.0, -0.5));
            let before = sh_irradiance(&c, d);
            sh_add_light(&mut c, DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
            list![
                sh_basis(d),
                before,
                sh_irradiance(&c, d),
                [sh_irradiance_light(d.x), sh_irradiance_rest(d.x), sh_rest_damping(0.9 * d)]
            ]
        },
    );
}

#[test]
fn diffuse_parity() {
    parity::<12>(
        "integrals/diffuse",
        Tolerance { relative: 8e-5, floor: |k| if k < 16 { 1e-2 } else { 0.1 }, unit: |_| 0.0 },
        |r| {
            let (wo, wi) = (r.direction(), r.direction());
            let n = r.pick([1.0, 3.0, 5.0]);
            join(&[&wo.to_array(), &wi.to_array(), &r.mean_slope().to_array(), &r.covariance().to_array(), &[n]])
        },
        |x| {
            let (wo, wi, m, s, n) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8), x[11].round() as u32);
            let lambda = grid_lambda(n);
            let m = face_viewer(wo, m, s, lambda);
            let v = visible_normal_moments(wo, m, s, n, lambda);
            let mut c = [DVec3::ZERO; 9];
            c[0] = DVec3::new(2.0, 1.5, 1.0);
            sh_add_light(&mut c, DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
            sh_add_light(&mut c, DVec3::new(0.0, -0.8, -0.6), DVec3::new(0.3, 0.2, 0.1));
            let environment = leadr_diffuse_environment(&v, &frame_about(wi), &c, DVec3::new(0.1, -0.2, 0.3));
            let lights = [
                leadr_diffuse_light_sh(&v, wo, wi, m, s, true),
                leadr_diffuse_light_sh(&v, wo, wi, m, s, false),
                leadr_diffuse_light(wo, wi, m, s, true, n, lambda),
                leadr_diffuse_light(wo, wi, m, s, false, n, lambda),
            ];
            // Seen edge-on, the visible parts of grooves have relative rounding errors.
            let edge = meso_area(wo, m).clamp(0.0, 1.0);
            let grooves = edge * groove_normal_moments(wo, m, s, n, lambda).mean;
            let groove_light = edge * groove_diffuse_light(wo, wi, m, s, n, lambda);
            list![v.mean, v.diag, v.off, environment, lights, grooves, [groove_light]]
        },
    );
}

#[test]
fn slope_nodes_parity() {
    const N: u32 = 5;
    parity::<12>(
        "integrals/slope_nodes",
        Tolerance { relative: 1e-3, floor: |_| 1.0, unit: |_| 0.0 },
        |r| {
            let (wo, wi) = (r.direction(), r.direction());
            let wo = DVec3::new(wo.x, wo.y, wo.z.abs().max(0.05)).normalize();
            let m = 0.2 * r.mean_slope().clamp(DVec2::NEG_ONE, DVec2::ONE);
            // Shaders read u = 0 of the thesis's placement (3) as another number.
            let placement = [r.pick([0.0, 1.0, 2.0, 4.0])];
            join(&[&wo.to_array(), &m.to_array(), &r.covariance().to_array(), &placement, &wi.to_array()])
        },
        |x| {
            let (wo, m, s, wi) = (v3(x, 0), v2(x, 3), clamp_covariance(v3(x, 5)), v3(x, 9));
            let placement = NodePlacement::ALL[x[8].round() as usize];
            let nodes = slope_nodes(placement, wo, m, s, N);
            let node = nodes.node(wo, nodes.row(3), 1);
            let spread = DVec2::new(s.x.sqrt(), s.y.sqrt()).max(DVec2::splat(1e-4));
            let slope = (node.slope - m) / spread;
            let moments = node_normal_moments(placement, wo, m, s, N);
            let light = node_diffuse_light(placement, wo, wi, m, s, true, N);
            let last = nodes.artificial(wo);
            let normal = if last.weight > 0.0 { normal_of_slope(last.slope) } else { DVec3::ZERO };
            list![
                slope.to_array(),
                [node.weight, node.cell.log2()],
                moments.mean,
                [light],
                [last.weight.max(1e-9).log2()],
                normal
            ]
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = &mut Random(7);
    finite::<11, 0>(&gpu, r, "masking/smith", 5, 2, |_| []);
    finite::<8, 0>(&gpu, r, "facets/projected_area", 7, 1, |_| []);
    finite::<8, 0>(&gpu, r, "facets/beckmann", 2, 1, |_| []);
    finite::<13, 2>(&gpu, r, "integrals/specular", 17, 2, |_| [1.0; 2]);
    finite::<12, 1>(&gpu, r, "integrals/diffuse", 16, 2, |_| [1.0]);
}

#[test]
fn constants_are_the_same() {
    parity::<1>(
        "constants",
        Tolerance { relative: 2e-6, floor: |_| 1e-12, unit: |_| 0.0 },
        |r| [r.pick([1.0, 2.0])],
        |x| {
            let constants = [
                std::f64::consts::PI,
                limits::MIN_VARIANCE,
                limits::MAX_CORRELATION,
                limits::MAX_SLOPE,
                limits::MAX_GRADIENT_VARIANCE,
                limits::MIN_AREA,
                limits::MIN_NORMAL_Z,
                specular::LOD_MATCHED,
                specular::LOD_SUPPLEMENT,
                specular::LOD_SUPPLEMENT_5,
                specular::LOD_SUPPLEMENT_32,
                specular::LOD_ALGORITHM_1,
            ];
            list![constants.map(|c| c * x[0])]
        },
    );
}
