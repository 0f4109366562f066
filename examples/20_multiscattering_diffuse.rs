//! Measures multiple scattering between facets (Chan 2018, section 5) by random walks on rough surfaces. Prints the errors of the published
//! fits and of `reflectance::materials::multiscattering`, and a refit. With `energy`, the example writes
//! `crates/leadr-reflectance/src/materials/energy.bin` to standard output. With `walks`, it prints tables of the albedo and of the specular
//! term. With `export`, it writes the walks at one gloss (0 to 1) as a MERL `.binary` or a `.pfm` slice, as in the paper's section 5.5.
//!
//! `cargo run --release --example 20_multiscattering_diffuse [energy | walks | export GLOSS FILE [WALKS] | WALKS]`

use std::f64::consts::{FRAC_1_PI, PI};
use std::io::Write;
use std::path::Path;

use glam::{DVec2, DVec3};
use leadr::measured::export::Export;
use leadr::reflectance::facets::beckmann::Beckmann;
use leadr::reflectance::facets::ggx::Ggx;
use leadr::reflectance::facets::gloss::Gloss;
use leadr::reflectance::masking::variants::Masking;
use leadr::reflectance::materials::brdf::Brdf;
use leadr::reflectance::materials::energy::{EnergyTable, compensation_color, compensation_lobe, compensation_scale};
use leadr::reflectance::materials::microfacet::{half_vector, microfacet_eval_ggx};
use leadr::reflectance::materials::multiscattering::{BOUNCES, BOUNCES_LOSSY, chan_diffuse, chan_rational_rough};
use leadr::reflectance::quadrature::composite_gauss;
use leadr::reflectance::visible::diffuse::leadr_diffuse_light_visible;
use leadr_lab::energy_table::energy_nodes;
use leadr_lab::facet_walk::{Facets, facet_walks};
use leadr_lab::multiscattering_study::{Simulation, fit_bounces, fitted};

/// The gloss levels in the figures of the paper.
const GLOSS: [f64; 5] = [0.0, 60.0, 120.0, 180.0, 240.0];

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let s = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    DVec3::new(s * azimuth.cos(), s * azimuth.sin(), cosine)
}

/// Returns `∫ f c dω`.
fn albedo(brdf: impl Fn(DVec3) -> f64) -> f64 {
    let azimuths = composite_gauss(0.0, PI, 4, 12);
    let ring = |c: f64| azimuths.iter().map(|(phi, w)| 2.0 * w * brdf(direction(c, *phi))).sum::<f64>();
    composite_gauss(0.0, 1.0, 6, 12).into_iter().map(|(u, w)| w * 2.0 * u * u * u * ring(u * u)).sum()
}

fn chan(wo: DVec3, wi: DVec3, gloss: f64) -> f64 {
    let h = half_vector(wo, wi);
    chan_diffuse(wi.z, wo.z, h.z, wi.dot(h), gloss)
}

fn write_energy() {
    let ggx = energy_nodes(|a| Ggx::isotropic(DVec2::ZERO, a));
    let beckmann = energy_nodes(|a| Beckmann::isotropic(DVec2::ZERO, a));
    let bytes: Vec<u8> = [ggx, beckmann].concat().into_iter().flatten().flat_map(|node| node.to_le_bytes()).collect();
    std::io::stdout().write_all(&bytes).expect("stdout takes the table");
}

/// The BRDF of walks that lose the light which the coat reflects, as in the paper.
struct Walked {
    facets: Ggx,
    count: u64,
}

impl Brdf for Walked {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        let walks = facet_walks(&self.facets, Facets::Diffuse(0.04), wo, &[wi], self.count, 1);
        DVec3::splat(walks.towards[0].iter().sum())
    }
}

fn export(arguments: &[String]) {
    let [gloss, file, rest @ ..] = arguments else { panic!("give GLOSS, FILE and perhaps WALKS") };
    let gloss = gloss.parse().expect("GLOSS is a number from 0 to 1");
    let count = rest.first().map_or(200, |count| count.parse().expect("WALKS is a whole number"));
    let format = Export::of(Path::new(file)).unwrap_or_else(|| panic!("end {file} in .binary or .pfm"));
    let walked = Walked { facets: Ggx::isotropic(DVec2::ZERO, Gloss::Wwii.alpha(gloss)), count };
    let bytes = format.bytes_of_any(&walked).expect("a .binary or .pfm file");
    std::fs::write(file, bytes).expect("the file is written");
}

/// Prints directional albedos, and the contribution of further specular bounces.
fn print_walks() {
    let cosines = [0.05, 0.2, 0.5, 0.8, 1.0];
    println!("directional albedo at cosines {cosines:?}");
    for gloss in GLOSS {
        let row = cosines.map(|c| albedo(|wi| chan(direction(c, 0.0), wi, gloss / 255.0) * FRAC_1_PI));
        println!("listing 1, gloss {gloss}: {row:.3?}, at cosine .001 {:.3}", {
            let wo = direction(1e-3, 0.0);
            albedo(|wi| chan(wo, wi, gloss / 255.0) * FRAC_1_PI)
        });
    }
    let rational = |c: f64| {
        let wo = direction(c, 0.0);
        albedo(|wi| {
            let h = half_vector(wo, wi);
            chan_rational_rough(h.z, wi.dot(h))
        })
    };
    println!("eq. 63: {:.3?}, at cosine .001 {:.3}", cosines.map(rational), rational(1e-3));
    for alpha in [0.1, 0.3, 0.6, 1.0] {
        let walk = |facets| {
            let of = |c: f64| {
                let walks =
                    facet_walks(&Beckmann::isotropic(DVec2::ZERO, alpha), facets, direction(c, 0.0), &[], 100_000, 3);
                (walks.albedo[0], walks.albedo.iter().sum::<f64>())
            };
            cosines.map(of)
        };
        let s = DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0);
        let leadr = cosines.map(|c| {
            let wo = direction(c, 0.0);
            albedo(|wi| leadr_diffuse_light_visible(wo, wi, DVec2::ZERO, s, true, 3) / wi.z)
        });
        let lambert = walk(Facets::Lambert);
        println!(
            "Beckmann α {alpha}, Lambertian facets: LEADR {leadr:.3?}, walk, one bounce {:.3?}, all {:.3?}",
            lambert.map(|w| w.0),
            lambert.map(|w| w.1)
        );
        println!(
            "    under a coat of .04, all bounces: lossy {:.3?}, nothing lost {:.3?}",
            walk(Facets::Diffuse(0.04)).map(|w| w.1),
            walk(Facets::Coated(0.04)).map(|w| w.1)
        );
    }
    println!(
        "specular, GGX: albedo of further bounces, walk | lobe | scale, by cosine; rms of π f_r of all of them: lobe, scale, none"
    );
    let table = EnergyTable::ggx();
    for (alpha, f0) in [0.1, 0.3, 0.6, 1.0].into_iter().flat_map(|a| [1.0, 0.5, 0.04].map(|f| (a, f))) {
        let facets = Ggx::isotropic(DVec2::ZERO, alpha);
        let (average, f) = (table.average(alpha).ideal, DVec3::splat(f0));
        let further = |c: f64| {
            let walks = facet_walks(&facets, Facets::Specular(f0), direction(c, 0.0), &[], 100_000, 3);
            let (a, first) = (table.albedo(alpha, c), walks.albedo[0]);
            let lobe = (1.0 - a.ideal) * compensation_color(f, average).x;
            (walks.albedo[1..].iter().sum::<f64>(), lobe, first * (compensation_scale(f, a.ideal).x - 1.0))
        };
        let rows = cosines.map(further);
        // The directions are cosine-distributed over both hemispheres.
        let nodes = composite_gauss(0.0, 1.0, 1, 8);
        let azimuths = composite_gauss(0.0, PI, 1, 7);
        let mut errors = [0.0; 3];
        for (ci, wi) in &nodes {
            let outwards: Vec<DVec3> =
                nodes.iter().flat_map(|(c, _)| azimuths.iter().map(|(p, _)| direction(*c, *p))).collect();
            let i = direction(*ci, 0.0);
            let walks = facet_walks(&facets, Facets::Specular(f0), i, &outwards, 40_000, 5);
            for (k, (o, towards)) in outwards.iter().zip(&walks.towards).enumerate() {
                let w = wi * nodes[k / azimuths.len()].1 * azimuths[k % azimuths.len()].1 * 4.0 * ci * o.z / PI;
                let truth = towards[1..].iter().sum::<f64>() / o.z;
                let [eo, ei] = [o.z, *ci].map(|c| table.albedo(alpha, c).ideal);
                let lobe = compensation_lobe(eo, ei, average) * compensation_color(f, average).x;
                let fresnel = f0 + (1.0 - f0) * (1.0 - o.dot(half_vector(*o, i))).max(0.0).powi(5);
                let a = DVec3::new(alpha * alpha, alpha * alpha, 0.0);
                let one = fresnel * microfacet_eval_ggx(Masking::SmithCorrelated, *o, i, DVec2::ZERO, a) / ci;
                let scale = one * (compensation_scale(f, eo).x - 1.0);
                for (sum, model) in errors.iter_mut().zip([lobe, scale, 0.0]) {
                    *sum += w * (PI * (model - truth)).powi(2);
                }
            }
        }
        let [a, b, c] = [rows.map(|r| r.0), rows.map(|r| r.1), rows.map(|r| r.2)];
        println!("α {alpha}, F0 {f0}: {a:.3?} | {b:.3?} | {c:.3?}; {:.3?}", errors.map(f64::sqrt));
    }
}

fn main() {
    let argument = std::env::args().nth(1).unwrap_or_default();
    match argument.as_str() {
        "energy" => return write_energy(),
        "walks" => return print_walks(),
        "export" => return export(&std::env::args().skip(2).collect::<Vec<_>>()),
        _ => {}
    }
    let count = argument.parse().unwrap_or(20_000);
    let table = EnergyTable::ggx();
    let roughness = [0.03, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0];
    for (name, facets, in_use) in
        [("nothing lost", Facets::Coated(0.04), BOUNCES), ("lossy, as published", Facets::Diffuse(0.04), BOUNCES_LOSSY)]
    {
        let walks: Vec<Simulation> = roughness.iter().map(|&a| Simulation::new(a, 0.04, facets, count, 1)).collect();
        let again = fit_bounces(&walks, &table, &in_use, 80);
        println!("{name}: in use {in_use:?}\n    fitted {again:.5?}");
        println!("rms of π f_r / albedo: roughness, for facets of albedo .2, .5, .8, 1, in use; fitted, 1; Lambert, 1");
        for walk in &walks {
            let error = |fit, rho| walk.error(rho, |o, i| fitted(fit, &table, walk.alpha, walk.f0, rho, o, i)) / rho;
            let used = [0.2, 0.5, 0.8, 1.0].map(|rho| error(&in_use, rho));
            let lambert = walk.error(1.0, |_, _| 1.0);
            println!("    {:.2}: {used:.4?}; {:.4}; {lambert:.4}", walk.alpha, error(&again, 1.0));
        }
        println!("gloss, of 255: listing 1, eq. 63, in use, Lambert; other walks of the same surface");
        for gloss in GLOSS {
            let (g, alpha) = (gloss / 255.0, Gloss::Wwii.alpha(gloss / 255.0));
            let [walk, other] = [101, 202].map(|seed| Simulation::new(alpha, 0.04, facets, count, seed));
            let rational = |o: DVec3, i: DVec3| PI * chan_rational_rough(half_vector(o, i).z, i.dot(half_vector(o, i)));
            let errors = [
                walk.error(1.0, |o, i| chan(o, i, g)),
                walk.error(1.0, rational),
                walk.error(1.0, |o, i| fitted(&in_use, &table, alpha, 0.04, 1.0, o, i)),
                walk.error(1.0, |_, _| 1.0),
            ];
            let noise: f64 = walk
                .direction_pairs(1.0)
                .zip(other.direction_pairs(1.0))
                .map(|((p, a), (_, b))| p.weight * (a - b).powi(2))
                .sum();
            println!("    {gloss}: {errors:.4?}; {:.4}", noise.sqrt());
        }
    }
}
