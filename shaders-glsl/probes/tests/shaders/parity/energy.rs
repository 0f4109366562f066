//! Energy of specular facets, diffuse facets with light between them, and cones of visibility, on the device against the
//! reference.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, parity_with, v3};
use glam::DVec3;
use leadr_reflectance::masking::occlusion::{
    Cone, ConeEdge, ConeLobe, Hidden, adjusted_cone_cosine, adjusted_visibility, bent_cone, bent_cone_cosine,
    bent_cone_visibility, cone_cosine, cone_light, cone_light_by_edge, cone_light_smooth, cone_visibility,
    interreflected_visibility,
};
use leadr_reflectance::materials::diffuse_models::{DiffuseModel, diffuse_model_albedo, diffuse_value};
use leadr_reflectance::materials::energy::{
    EnergyTable, average_fresnel, compensation_color, compensation_lobe, compensation_scale, entered, specular_albedo,
};
use leadr_reflectance::materials::multiscattering::{
    BOUNCES, BOUNCES_LOSSY, FacetBounces, chan_diffuse, facet_albedo, facet_diffuse, grazing_albedo,
    multiscattering_albedo, multiscattering_diffuse,
};
use leadr_reflectance::random::Random;
use leadr_reflectance::visible::cone_specular::{cone_specular, cone_table_texcoord, lobe_in_cone};

/// 0 to 1, occasionally one of the ends.
fn share(r: &mut Random) -> f64 {
    match (r.unit() * 12.0) as u32 {
        0 => 0.0,
        1 => 1.0,
        2 => r.log(1e-6, 1e-2),
        _ => r.unit(),
    }
}

fn shares(r: &mut Random) -> [f64; 3] {
    [share(r), share(r), share(r)]
}

#[test]
fn occlusion_parity() {
    parity::<12>(
        "masking/occlusion",
        // The visibility of a cone clipped by the horizon is a small difference.
        Tolerance { relative: 1e-5, floor: |k| if k == 17 { 0.2 } else { 1e-2 }, unit: |_| 1.0 },
        |r| {
            let (axis, wi) = (r.direction(), r.direction());
            // Not on the edge of the cone, where rounding decides.
            let mut cosine = share(r);
            if (axis.dot(wi) - cosine).abs() < 1e-5 {
                cosine = 0.5 * cosine + 0.001;
            }
            join(&[&[share(r)], &shares(r), &axis.to_array(), &[cosine], &wi.to_array(), &[share(r)]])
        },
        |x| {
            let (visibility, albedo, wi) = (x[0], v3(x, 1), v3(x, 8));
            let cone = Cone { axis: v3(x, 4), cosine: x[7] };
            let adjusted = Hidden::ALL.map(|h| adjusted_visibility(h, visibility, albedo).to_array()).concat();
            let rest = [
                cone_cosine(visibility),
                cone_visibility(cone.cosine),
                bent_cone_visibility(&cone),
                bent_cone(visibility, cone.axis).cosine,
                bent_cone_cosine(visibility, cone.axis),
                cone_light(&cone, wi),
                cone_light_smooth(&cone, wi),
                adjusted_cone_cosine(cone.cosine, x[11], wi.z, false, 8),
                adjusted_cone_cosine(cone.cosine, x[11], wi.z, true, 6),
                interreflected_visibility(visibility, albedo).x,
            ];
            let found = Cone::of_vector(0.5 * visibility * cone.axis);
            let edges = ConeEdge::ALL.map(|edge| cone_light_by_edge(edge, &cone, wi));
            let lobes = ConeLobe::ALL.map(|lobe| {
                let cone = lobe.of(cone, visibility, x[11], wi.z);
                [&cone.axis.to_array()[..], &[cone.cosine]].concat()
            });
            let found = [&found.axis.to_array()[..], &[found.cosine]].concat();
            [adjusted, rest.to_vec(), found, edges.to_vec(), lobes.concat()].concat()
        },
    );
}

#[test]
fn energy_parity() {
    for table in [EnergyTable::ggx(), EnergyTable::beckmann()] {
        let words: Vec<f32> = table.texels().concat();
        parity_with::<6>(
            "materials/energy",
            Tolerance { relative: 1e-5, floor: |k| if k == 13 { 0.1 } else { 1e-2 }, unit: |_| 0.0 },
            Some(("Energy", &words)),
            // The energy loss is below a float's precision where it is subtracted from 1.
            |r| join(&[&[r.range(0.02, 1.0)], &[share(r), share(r)], &shares(r)]),
            |x| {
                let (alpha, f0) = (x[0], v3(x, 3));
                let (o, i, average) = (table.albedo(alpha, x[1]), table.albedo(alpha, x[2]), table.average(alpha));
                list![
                    [o.ideal, o.grazing, average.ideal, average.grazing],
                    o.of(f0),
                    average_fresnel(f0),
                    compensation_color(f0, average.ideal),
                    [compensation_lobe(o.ideal, i.ideal, average.ideal)],
                    compensation_scale(f0, o.ideal),
                    specular_albedo(f0, o, average.ideal),
                    entered(f0, o, average.ideal)
                ]
            },
        );
    }
}

#[test]
fn multiscattering_parity() {
    let table = EnergyTable::ggx();
    parity::<22>(
        "materials/multiscattering",
        Tolerance { relative: 2e-5, floor: |_| 1e-2, unit: |_| 0.0 },
        |r| {
            let (wo, wi, alpha) = (r.direction(), r.direction(), share(r));
            // The light that passes the coat of dielectrics.
            let (f0, average) = (0.2 * DVec3::from_array(shares(r)), table.average(alpha));
            let [o, i] = [wo, wi].map(|w| entered(f0, table.albedo(alpha, w.z), average.ideal).to_array());
            let mean = entered(f0, average, average.ideal).to_array();
            join(&[&wo.to_array(), &wi.to_array(), &[alpha], &f0.to_array(), &shares(r), &o, &i, &mean])
        },
        |x| {
            let (wo, wi, alpha, f0, albedo) = (v3(x, 0), v3(x, 3), x[6], v3(x, 7), v3(x, 10));
            let (o, i, average) = (v3(x, 13), v3(x, 16), v3(x, 19));
            let (b, lossy) = (BOUNCES.at(alpha), BOUNCES_LOSSY.at(alpha));
            let words = |b: FacetBounces| [b.grazing, b.again, b.lean, b.lost];
            list![
                multiscattering_diffuse(wo, wi, b, f0, albedo, o, i, average),
                multiscattering_diffuse(wo, wi, lossy, f0, albedo, o, i, average),
                multiscattering_albedo(b, albedo, o),
                facet_albedo(b, albedo),
                [facet_diffuse(f0.x, wo.z, wi.z), chan_diffuse(wi.z, wo.z, o.x, i.x, alpha), grazing_albedo(wo.z)],
                words(b),
                words(lossy)
            ]
        },
    );
}

#[test]
fn diffuse_models_parity() {
    parity::<10>(
        "materials/diffuse_models",
        Tolerance { relative: 2e-5, floor: |_| 0.1, unit: |_| 0.0 },
        |r| {
            let [wo, wi] = [r.direction(), r.direction()].map(|w| w.with_z(w.z.abs().max(0.02)).normalize().to_array());
            // The gloss of the smoothest surfaces is the logarithm of a difference.
            join(&[&wo, &wi, &[r.range(0.01, 1.0)], &shares(r)])
        },
        |x| {
            let (wo, wi, alpha, albedo) = (v3(x, 0), v3(x, 3), x[6], v3(x, 7));
            let both = |model| {
                let value = diffuse_value(model, wo, wi, alpha, albedo);
                [value, diffuse_model_albedo(model, wo.z, alpha, albedo)].map(|v| v.to_array()).concat()
            };
            DiffuseModel::ALL.map(both).concat()
        },
    );
}

#[test]
fn cone_specular_parity() {
    parity::<8>(
        "visible/cone_specular",
        Tolerance { relative: 2e-5, floor: |_| 0.5, unit: |_| 1.0 },
        |r| {
            let alpha = r.range(0.02, 1.0);
            join(&[&[alpha], &r.direction().to_array(), &r.direction().to_array(), &[share(r)]])
        },
        |x| {
            let (alpha, wo, cone) = (x[0], v3(x, 1), Cone { axis: v3(x, 4), cosine: x[7] });
            let lobe = lobe_in_cone(alpha, 3.0 * wo.z, 1.5 * cone.cosine);
            list![[cone_specular(alpha, wo, &cone), lobe], cone_table_texcoord(wo.z, alpha, cone.cosine)]
        },
    );
}
