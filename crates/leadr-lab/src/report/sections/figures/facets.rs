//! Draws thesis Figures 2.2 to 2.6: the terms of a microfacet BRDF.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_maps::RgbImage;
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ellipse::Ellipse;
use leadr_reflectance::facets::fresnel::Fresnel;
use leadr_reflectance::facets::metals::Metal;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_tools::error::LabError;
use leadr_tools::fit::spheres::{contact_sheet, sphere_error, spheres};
use leadr_tools::html::{Cell, Figure, Table, number};

type Facets = Microfacet<Beckmann>;

fn metal(name: &str) -> Fresnel {
    // The names are the library's names of metals.
    Metal::named(name).map_or(Fresnel::Ideal, |metal| Fresnel::Conductor { eta: metal.eta, k: metal.k })
}

fn round(alpha: f64, masking: Masking, fresnel: Fresnel) -> Facets {
    Microfacet { distribution: Beckmann::isotropic(DVec2::ZERO, alpha), masking, fresnel }
}

fn anisotropic_gold(radii: DVec2, degrees: f64) -> Facets {
    let distribution = Beckmann::from_ellipse(DVec2::ZERO, &Ellipse { radii, angle: degrees.to_radians() });
    Microfacet { distribution, masking: Masking::default(), fresnel: metal("gold") }
}

fn viewer(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

/// Computes the fraction of uniform light from all directions that is reflected to the viewer. Without shadowing, light from
/// below also reaches facets.
fn reflected(material: &Facets, wo: DVec3, n: u32) -> DVec3 {
    let row = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let r = (1.0 - z * z).sqrt();
        let at = |k: u32| {
            let (sin, cos) = (TAU * (f64::from(k) + 0.5) / f64::from(n)).sin_cos();
            material.eval_cos(wo, DVec3::new(r * cos, r * sin, z))
        };
        (0..n).map(at).sum::<DVec3>()
    };
    (0..n).into_par_iter().map(row).sum::<DVec3>() * (4.0 * PI / f64::from(n * n))
}

/// Renders a sphere with sample directions for the sphere's facets.
fn sphere(studio: &Studio, facets: &Facets) -> RgbImage {
    spheres(&[facets], facets, studio.pick(40, 128)).remove(0)
}

/// Renders a row of spheres with the exposure of the first sphere. Also returns the spheres.
fn row(studio: &mut Studio, file: &str, materials: &[(&str, Facets)]) -> Result<(Figure, Vec<RgbImage>), LabError> {
    let images: Vec<RgbImage> = materials.iter().map(|(_, facets)| sphere(studio, facets)).collect();
    let names: Vec<&str> = materials.iter().map(|(name, _)| *name).collect();
    let caption = vec![names.join(" · ")];
    let figure = studio.picture(&format!("figures-{file}"), &contact_sheet(&images), 1.0, file, caption)?;
    Ok((figure, images))
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    fresnel(studio, page)?;
    attenuation(studio, page)?;
    isotropic(studio, page)?;
    anisotropic(studio, page)?;
    orientation(studio, page)
}

/// Draws Figure 2.2.
fn fresnel(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Thesis Figure 2.2",
        "Fresnel terms on Beckmann facets of α = .2: metals beside an ideal mirror, then dielectrics beside Schlick's form of the same \
        reflectance at normal incidence. Each row has one exposure. Viewed from above in uniform light, the facets reflect as much as an \
        ideal mirror's, times F at normal incidence.",
    );
    let with = |fresnel: Fresnel| round(0.2, Masking::default(), fresnel);
    let f0 = |eta: f64| DVec3::splat(((eta - 1.0) / (eta + 1.0)).powi(2));
    let rows = [
        (
            "metals",
            vec![
                ("F = 1", with(Fresnel::Ideal)),
                ("silver", with(metal("silver"))),
                ("gold", with(metal("gold"))),
                ("copper", with(metal("copper"))),
                ("iron", with(metal("iron"))),
            ],
        ),
        (
            "dielectrics",
            vec![
                ("glass, η = 1.5", with(Fresnel::Dielectric(1.5))),
                ("Schlick, F0 = .04", with(Fresnel::Schlick(f0(1.5)))),
                ("diamond, η = 2.42", with(Fresnel::Dielectric(2.42))),
                ("Schlick, F0 = .172", with(Fresnel::Schlick(f0(2.42)))),
            ],
        ),
    ];
    let n = studio.pick(200, 800);
    let ideal = reflected(&with(Fresnel::Ideal), DVec3::Z, n);
    let mut table = Table::new(
        "Reflected fraction of uniform light, seen from above, relative to F = 1: red, green, blue",
        ["", "F at normal incidence", "facets"],
    );
    let mut worst = 0.0f64;
    for (file, materials) in &rows {
        let (figure, _) = row(studio, file, materials)?;
        page.html.figures(&[figure]);
        for (name, material) in materials {
            let (found, normal) = (reflected(material, DVec3::Z, n) / ideal, material.fresnel.at(1.0));
            worst = worst.max((found - normal).abs().max_element());
            let text = |v: DVec3| Cell::from(v.to_array().map(number).join(", "));
            table.row([Cell::from(*name), text(normal), text(found)]);
        }
    }
    page.html.table(&table);
    page.check("largest difference from F at normal incidence", worst);
    page.find(&format!(
        "from above, facets of α = .2 reflect F at normal incidence to {}, for every term.",
        number(worst)
    ));
    Ok(())
}

/// Draws Figure 2.3.
fn attenuation(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    const ANGLE: f64 = 60.0;
    page.begin(
        "Thesis Figure 2.3",
        "Masking and shadowing on ideal mirrors of α = .9. In uniform light, visible facets without shadowing reflect everything: 1 for \
        Smith's and the V-grooves' masking alone. Shadowing removes light that further bounces would return; a normal map loses facets \
        that face away.",
    );
    let with = |masking: Masking| round(0.9, masking, Fresnel::Ideal);
    let materials = [
        ("Smith, correlated", Masking::SmithCorrelated),
        ("Smith, separable", Masking::SmithSeparable),
        ("Smith, correlated in direction", Masking::SmithDirectionCorrelated),
        ("V-grooves", Masking::VGroove),
        ("normal map", Masking::NormalMap),
    ]
    .map(|(name, masking)| (name, with(masking)));
    let (figure, _) = row(studio, "masking", &materials)?;
    page.html.figures(&[figure]);
    let n = studio.pick(200, 800);
    let mut table =
        Table::new(format!("Reflected fraction of uniform light at {ANGLE}°"), ["", "masking alone", "with shadows"]);
    let mut worst = 0.0f64;
    let mut listed = Vec::new();
    for (name, material) in &materials {
        let masking = material.masking.unshadowed();
        let [open, shadowed] =
            [with(masking), material.clone()].map(|material| reflected(&material, viewer(ANGLE), n).x);
        table.row([Cell::from(*name), Cell::from(open), Cell::from(shadowed)]);
        page.check(format!("reflected at {ANGLE}°, {name}"), shadowed);
        if masking != Masking::NormalMap {
            worst = worst.max((open - 1.0).abs());
        }
        listed.push(format!("{name} {}", number(shadowed)));
    }
    page.html.table(&table);
    page.check("largest difference of masking alone from 1", worst);
    page.find(&format!(
        "masking alone reflects 1 to {}; with shadows, at {ANGLE}°: {}.",
        number(worst),
        listed.join(", ")
    ));
    Ok(())
}

/// Computes by how much the reflection of uniform light at 45° deviates from 1. The row's facets are taken as ideal specular
/// facets without shadowing.
fn lost(materials: &[(&str, Facets)], n: u32) -> f64 {
    let lost = |(_, facets): &(&str, Facets)| {
        let open = Microfacet { masking: Masking::SmithUnshadowed, fresnel: Fresnel::Ideal, ..facets.clone() };
        (reflected(&open, viewer(45.0), n).x - 1.0).abs()
    };
    materials.iter().map(lost).fold(0.0, f64::max)
}

/// Draws Figure 2.4.
fn isotropic(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin("Thesis Figure 2.4", "Gold of Beckmann roughness α from .05 to .8. In uniform light, ideal mirrors with masking alone reflect 1 for every α.");
    let names = ["α = .05", "α = .1", "α = .2", "α = .4", "α = .8"];
    let alphas = [0.05, 0.1, 0.2, 0.4, 0.8];
    let with = |alpha: f64| round(alpha, Masking::default(), metal("gold"));
    let materials: Vec<(&str, Facets)> = names.into_iter().zip(alphas.map(with)).collect();
    let (figure, _) = row(studio, "isotropic", &materials)?;
    page.html.figures(&[figure]);
    let worst = lost(&materials, studio.pick(400, 1200));
    page.check("largest difference from 1 in even light", worst);
    page.find(&format!("facets of every α reflect uniform light to {}.", number(worst)));
    Ok(())
}

/// Draws Figure 2.5.
fn anisotropic(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Thesis Figure 2.5",
        "Anisotropic gold: αx along the circles of latitude, αy along the meridians. Highlights stretch where slopes vary most. In uniform light, ideal mirrors with masking alone reflect 1.",
    );
    let materials = [
        ("αx = .4, αy = .1", anisotropic_gold(DVec2::new(0.4, 0.1), 0.0)),
        ("αx = .2, αy = .1", anisotropic_gold(DVec2::new(0.2, 0.1), 0.0)),
        ("αx = αy = .1", anisotropic_gold(DVec2::new(0.1, 0.1), 0.0)),
        ("αx = .1, αy = .2", anisotropic_gold(DVec2::new(0.1, 0.2), 0.0)),
        ("αx = .1, αy = .4", anisotropic_gold(DVec2::new(0.1, 0.4), 0.0)),
    ];
    let (figure, images) = row(studio, "anisotropic", &materials)?;
    page.html.figures(&[figure]);
    let plain = sphere(studio, &round(0.1, Masking::default(), metal("gold")));
    let same = sphere_error(&plain, &images[2]).rrmse;
    let worst = lost(&materials, studio.pick(200, 800));
    page.check("rRMSE of equal scales against isotropic facets", same);
    page.check("largest difference from 1 in even light", worst);
    page.find(&format!(
        "equal scales match isotropic facets to an rRMSE of {}; all reflect uniform light to {}.",
        number(same),
        number(worst)
    ));
    Ok(())
}

/// Draws Figure 2.6.
fn orientation(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    const RADII: DVec2 = DVec2::new(0.4, 0.1);
    page.begin(
        "Thesis Figure 2.6",
        "Anisotropic gold of α .4 and .1 with a rotated first axis. Half a turn changes nothing, and a quarter exchanges the two α.",
    );
    let materials = [("0°", 0.0), ("45°", 45.0), ("90°", 90.0), ("135°", 135.0), ("180°", 180.0)]
        .map(|(name, degrees)| (name, anisotropic_gold(RADII, degrees)));
    let (figure, images) = row(studio, "orientation", &materials)?;
    page.html.figures(&[figure]);
    let exchanged = sphere(studio, &anisotropic_gold(DVec2::new(RADII.y, RADII.x), 0.0));
    let half = sphere_error(&images[0], &images[4]).rrmse;
    let quarter = sphere_error(&exchanged, &images[2]).rrmse;
    let eighth = sphere_error(&images[0], &images[1]).rrmse;
    page.check("rRMSE of half a turn", half);
    page.check("rRMSE of a quarter against exchanged radii", quarter);
    page.check("rRMSE of an eighth against none", eighth);
    page.find(&format!(
        "half a turn changes the sphere by an rRMSE of {}, a quarter differs from exchanged α by {}; for comparison, an eighth changes it by {}.",
        number(half),
        number(quarter),
        number(eighth)
    ));
    Ok(())
}
