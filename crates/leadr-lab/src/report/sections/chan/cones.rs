//! Draws figures 19 and 20: the table of specular reflectance under cones, and a box on a puddle.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::laws::direction;
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use leadr_maps::RgbImage;
use leadr_reflectance::facets::fresnel::fresnel_schlick;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::masking::occlusion::{Cone, ConeLobe};
use leadr_reflectance::visible::cone_specular::{CONE_TABLE, ConeTable, cone_specular};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};

/// The gloss and the reflectance of water with small ripples.
const GLOSS: f64 = 0.7;
const WATER: f64 = 0.02;
/// The lower and upper corner of the box.
const BOX: [DVec3; 2] = [DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 1.0, 1.0)];
const BOX_RADIANCE: f64 = 0.06;
const EYE: DVec3 = DVec3::new(-1.2, -4.0, 1.4);
/// The numbers of directions to the sky and of reflected directions of a pixel.
const SKY: [u32; 2] = [10, 40];
const REFLECTED: u32 = 32;

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    let table = ConeTable::new(|gloss| Gloss::Wwii.alpha(gloss));
    table_of_cones(studio, page, &table)?;
    puddle(studio, page, &table)
}

fn table_of_cones(studio: &mut Studio, page: &mut Page, table: &ConeTable) -> Result<(), LabError> {
    page.begin(
        "Chan Figure 19",
        "The table of specular reflectance under occlusion cones, as leadr bake --cone-table writes it: eight cones from the open hemisphere \
        to the closed cone, each with the viewer's cosine to the right and the gloss downwards. Red is the factor of F0, and green is added.",
    );
    let [nx, ny, nz] = CONE_TABLE;
    let texel = |i: usize| {
        let (x, y) = (i % (nx * nz), i / (nx * nz));
        let [scale, bias] = table.texels()[x % nx + nx * (y + ny * (x / nx))];
        [scale, bias, 0.0]
    };
    let image = RgbImage::new((nx * nz) as u32, ny as u32, (0..nx * ny * nz).map(texel).collect()).map_err(fault)?;
    let figure = studio.picture("chan-cone-table", &image, 1.0, "the table", vec!["32 × 32 × 8".to_owned()])?;
    page.html.figures(&[figure.enlarged(3)]);
    let closed = table.texels()[nx * ny * (nz - 1)..].iter().map(|t| t[0].abs()).fold(0.0, f32::max);
    let [open, half] = [0.0, 3.0 / 7.0].map(|cosine| table.albedo(0.5, 0.3, cosine).scale());
    page.check("largest value of the closed cone (the paper: completely black)", closed.into());
    page.check("open hemisphere, cosine .5, gloss .3", open);
    page.check("cone of cosine 3/7, cosine .5, gloss .3", half);
    page.find(&format!(
        "the closed cone is black; at a viewer's cosine of .5 and gloss .3, a cone of cosine 3/7 leaves {} of {}.",
        number(half),
        number(open)
    ));
    Ok(())
}

/// Returns the distance along a ray to the box.
fn to_box(from: DVec3, towards: DVec3) -> Option<f64> {
    let [a, b] = BOX.map(|corner| (corner - from) / towards);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    (near < far && far > 1e-6).then_some(near.max(0.0))
}

fn sky(w: DVec3) -> f64 {
    let up = w.z.max(0.0);
    0.25 + 0.75 * (1.0 - up).powi(3)
}

/// The sky's share of a point's hemisphere, and its visibility vector.
fn visible(p: DVec3) -> (f64, DVec3) {
    let [rings, sectors] = SKY;
    let (mut share, mut vector) = (0.0, DVec3::ZERO);
    for (i, k) in (0..rings).flat_map(|i| (0..sectors).map(move |k| (i, k))) {
        // Equal steps of the squared sine have equal weights.
        let sine2 = (f64::from(i) + 0.5) / f64::from(rings);
        let w = direction((1.0 - sine2).sqrt(), TAU * (f64::from(k) + 0.5 * f64::from(i % 2)) / f64::from(sectors));
        if to_box(p, w).is_none() {
            let weight = 1.0 / f64::from(rings * sectors);
            share += weight;
            vector += weight * w / w.z.max(1e-3);
        }
    }
    (share, vector)
}

/// The reflected radiance of the water: the truth, and each cone's share of the sky.
fn reflected(p: DVec3, table: &ConeTable) -> [f64; 5] {
    let (wo, alpha) = ((EYE - p).normalize(), Gloss::Wwii.alpha(GLOSS));
    let (mut truth, mut open) = (0.0, 0.0);
    for i in 0..REFLECTED {
        let u = DVec2::new((f64::from(i) + 0.5) / f64::from(REFLECTED), (f64::from(i) * 0.618_034).fract());
        let cosine = ((1.0 - u.x) / (1.0 + (alpha * alpha - 1.0) * u.x)).sqrt();
        let wh = direction(cosine, TAU * u.y);
        let wi = 2.0 * wo.dot(wh) * wh - wo;
        if wi.z > 0.0 {
            let weight = fresnel_schlick(DVec3::splat(WATER), wo.dot(wh)).x / f64::from(REFLECTED);
            open += weight * sky(wi);
            truth += weight * to_box(p, wi).map_or_else(|| sky(wi), |_| BOX_RADIANCE);
        }
    }
    let (share, vector) = visible(p);
    let bent = Cone::of_vector(vector);
    let f0 = DVec3::splat(WATER);
    let by_table = |lobe: ConeLobe| {
        let cone = lobe.of(bent, share, GLOSS, wo.z);
        open * table.albedo(wo.z, GLOSS, cone.cosine).of(f0).x / table.albedo(wo.z, GLOSS, 0.0).of(f0).x
    };
    let [normal, adjusted, biased] = [ConeLobe::Normal, ConeLobe::Adjusted, ConeLobe::Biased].map(by_table);
    [truth, normal, adjusted, biased, open * cone_specular(alpha, wo, &bent)]
}

fn puddle(studio: &mut Studio, page: &mut Page, table: &ConeTable) -> Result<(), LabError> {
    page.begin(
        "Chan Figure 20",
        "A box on a puddle: the traced reflection, and the reflection of the sky times the share of a cone. A cone about the normal hides \
        too much of the smooth water, and the published adjustment with the bias of the gloss (eq. 60) hides nothing.",
    );
    let (width, height) = studio.pick((72u32, 48u32), (180, 120));
    let forward = (DVec3::new(0.0, 0.4, 0.35) - EYE).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let pixel = |i: u32| -> (bool, [f64; 5]) {
        let x = (f64::from(i % width) + 0.5) / f64::from(width) - 0.5;
        let y = 0.5 - (f64::from(i / width) + 0.5) / f64::from(height);
        let ray = (forward + 0.75 * (x * right + y * f64::from(height) / f64::from(width) * up)).normalize();
        if let Some(distance) = to_box(EYE, ray) {
            // The faces of the box differ in brightness, so that its edges are visible.
            let p = EYE + distance * ray;
            let face = if p.z > BOX[1].z - 1e-6 {
                4.0
            } else if p.y < BOX[0].y + 1e-6 {
                1.0
            } else {
                2.0
            };
            return (false, [face * BOX_RADIANCE; 5]);
        }
        if ray.z >= 0.0 {
            return (false, [sky(ray); 5]);
        }
        (true, reflected(EYE - ray * (EYE.z / ray.z), table))
    };
    let pixels: Vec<(bool, [f64; 5])> = (0..width * height).into_par_iter().map(pixel).collect();
    let names = ["traced", "cone about the normal", "eq. 59", "eq. 60 and listing 3", "bent cone"];
    let (mut figures, mut errors) = (Vec::new(), Vec::new());
    for (k, name) in names.into_iter().enumerate() {
        let texels = pixels.iter().map(|(_, values)| [values[k] as f32; 3]).collect();
        let image = RgbImage::new(width, height, texels).map_err(fault)?;
        figures
            .push(studio.picture(&format!("chan-puddle-{k}"), &image, 1.6, name, vec![name.to_owned()])?.enlarged(2));
        let water: Vec<f64> = pixels.iter().filter(|(water, _)| *water).map(|(_, v)| v[k] - v[0]).collect();
        let mean = pixels.iter().filter(|(water, _)| *water).map(|(_, v)| v[0]).sum::<f64>() / water.len() as f64;
        let rms = (water.iter().map(|e| e * e).sum::<f64>() / water.len() as f64).sqrt() / mean;
        errors.push((rms, water.iter().sum::<f64>() / water.len() as f64 / mean));
    }
    page.html.figures(&figures);
    let mut rows = Table::new(
        "Reflection of the water, relative to the mean of the traced reflection",
        ["", "rms error", "mean error"],
    );
    for (name, (rms, mean)) in names.into_iter().zip(&errors).skip(1) {
        rows.row([Cell::from(name), Cell::from(*rms), Cell::from(*mean)]);
        page.check(format!("{name}: rms error"), *rms);
        page.check(format!("{name}: mean error"), *mean);
    }
    page.html.table(&rows);
    let list: Vec<String> = names
        .into_iter()
        .zip(&errors)
        .skip(1)
        .map(|(name, (rms, _))| format!("{} with {name}", number(*rms)))
        .collect();
    page.find(&format!("the water's reflection errs by {} of its mean, rms.", list.join(", ")));
    Ok(())
}
