//! Draws figures 23 to 26, 33 and 34: spheres of diffuse laws.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::GLOSSES;
use super::laws::{F0, Law};
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use leadr_maps::RgbImage;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::frame::{frame_about, to_frame};
use leadr_reflectance::materials::diffuse_models::{DiffuseModel, diffuse_value};
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::scene::{FrameState, Object, Pose, Sun};
use leadr_render::settings::{PixelKernel, RenderSettings, ShadingOptions, Technique, Terms};
use leadr_scenes::sphere::cube_sphere;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Figure, Table, number};

/// The direction to the light of the CPU's spheres. The viewer is along z.
const LIGHT: DVec3 = DVec3::new(-0.48, 0.36, 0.8);
const YELLOW: DVec3 = DVec3::new(1.0, 1.0, 0.1);
const CYAN: DVec3 = DVec3::new(0.1, 1.0, 1.0);

/// The radiance of a sphere at each pixel of a square picture, or `None` beside it. `light` returns `π f_r` by the position in the picture.
fn sphere(size: u32, value: impl Fn(bool, DVec3, DVec3, u64) -> f64 + Sync) -> Vec<Option<f64>> {
    let pixel = |i: u32| {
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(size) * 2.1 - 1.05;
        let (x, y) = (at(i % size), -at(i / size));
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        if z == 0.0 {
            return None;
        }
        let frame = frame_about(DVec3::new(x, y, z));
        let [wo, wi] = [DVec3::Z, LIGHT].map(|w| to_frame(&frame, w));
        let is_lit = wi.z > 1e-3 && wo.z > 1e-3;
        Some(if is_lit { value(x < 0.0, wo, wi, u64::from(i)) * wi.z } else { 0.0 })
    };
    (0..size * size).into_par_iter().map(pixel).collect()
}

fn image(size: u32, radiance: &[Option<f64>], tint: impl Fn(bool) -> DVec3) -> Result<RgbImage, LabError> {
    let texel = |(i, value): (usize, &Option<f64>)| {
        let left = (i as u32 % size) < size / 2;
        value.map_or([0.02; 3], |v| (tint(left) * v).as_vec3().to_array())
    };
    RgbImage::new(size, size, radiance.iter().enumerate().map(texel).collect()).map_err(fault)
}

/// Returns the root mean square of the difference over the pixels of a sphere.
fn rms(a: &[Option<f64>], b: &[Option<f64>]) -> f64 {
    let squares: Vec<f64> = a.iter().zip(b).filter_map(|(a, b)| Some((a.as_ref()? - b.as_ref()?).powi(2))).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Draws rows of spheres with one column per gloss: two laws, and the amplified difference.
struct Row<'a> {
    name: &'a str,
    laws: [(&'a str, Law); 2],
    /// Whether each sphere is split into a yellow and a cyan half, instead of three rows.
    split: bool,
}

fn row(studio: &mut Studio, page: &mut Page, size: u32, row: &Row<'_>, glosses: &[f64]) -> Result<(), LabError> {
    let (mut figures, mut errors) = ([const { Vec::new() }; 3], Vec::new());
    for &gloss in glosses {
        let g = gloss / 255.0;
        let [first, second] = row.laws.map(|(_, law)| sphere(size, |_, wo, wi, seed| law.value(wo, wi, g, seed)));
        errors.push(rms(&first, &second));
        let mut keep = |k: usize, radiance: &[Option<f64>], what: &str, tint: &dyn Fn(bool) -> DVec3| {
            let name = format!("chan-{}-{gloss}-{k}", row.name);
            let caption = format!("{what}, gloss {gloss}/255");
            let picture = image(size, radiance, tint)?;
            figures[k].push(studio.picture(&name, &picture, 0.8, &caption, vec![caption.clone()])?.enlarged(2));
            Ok::<_, LabError>(())
        };
        let [a, b] = row.laws.map(|(name, _)| name);
        if row.split {
            let halves: Vec<Option<f64>> = (0..size * size)
                .map(|i| if i % size < size / 2 { first[i as usize] } else { second[i as usize] })
                .collect();
            keep(0, &halves, &format!("{a} | {b}"), &|left| if left { YELLOW } else { CYAN })?;
        } else {
            let apart: Vec<Option<f64>> =
                first.iter().zip(&second).map(|(a, b)| Some(4.0 * (a.as_ref()? - b.as_ref()?).abs())).collect();
            keep(0, &first, a, &|_| DVec3::ONE)?;
            keep(1, &second, b, &|_| DVec3::ONE)?;
            keep(2, &apart, "difference, times 4", &|_| DVec3::ONE)?;
        }
    }
    figures.iter().filter(|figures| !figures.is_empty()).for_each(|figures| page.html.figures(figures));
    for (gloss, error) in glosses.iter().zip(&errors) {
        page.check(format!("{} less {}, gloss {gloss}, rms", row.laws[0].0, row.laws[1].0), *error);
    }
    let list: Vec<String> = errors.iter().map(|e| number(*e)).collect();
    page.find(&format!(
        "{} less {}, rms of the radiance at gloss {}: {}.",
        row.laws[0].0,
        row.laws[1].0,
        glosses.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
        list.join(", ")
    ));
    Ok(())
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    let (size, walked) = (studio.pick(40, 96), studio.pick(20, 64));
    let walks = Law::Walks(studio.pick(200, 2000));
    page.begin(
        "Chan Figure 23",
        "Top: Lambert's law, with energy conservation (listing 5), and the difference. Below: Lambert's law against the published fit, which \
        contains F0 = .04. Gloss 1.",
    );
    let against = |name, law| [("Lambert", Law::Lambert), (name, law)];
    for (name, laws) in [
        ("conserving", against("Lambert with energy conservation", Law::Conserving)),
        ("published", against("the published fit", Law::Published)),
    ] {
        row(studio, page, size, &Row { name, laws, split: false }, &[255.0])?;
    }
    models(studio, page, size)?;
    page.begin("Chan Figure 26", "Left halves, yellow: Lambert's law. Right halves, cyan: the full BRDF.");
    row(studio, page, walked, &Row { name: "full", laws: against("the full BRDF", walks), split: true }, &GLOSSES)?;
    page.begin(
        "Chan Figure 33",
        "Left halves, yellow: the full BRDF. Right halves, cyan: the published fit, then the model of this project.",
    );
    for (name, title, law) in
        [("hand", "the published fit", Law::Published), ("own", "multiscattering_diffuse", Law::Ours)]
    {
        let laws = [("the full BRDF", walks), (title, law)];
        row(studio, page, walked, &Row { name, laws, split: true }, &GLOSSES)?;
    }
    page.begin("Chan Figure 34", "Lambert's law, the published fit, and the difference.");
    let laws = against("the published fit", Law::Published);
    row(studio, page, size, &Row { name: "fit", laws, split: false }, &GLOSSES)
}

/// Draws figures 24 and 25 with the renderer's `--diffuse-model`, and compares the pictures with the formulas.
fn models(studio: &mut Studio, page: &mut Page, size: u32) -> Result<(), LabError> {
    let dark = RgbImage::new(8, 4, vec![[0.0; 3]; 32]).map_err(fault)?;
    for (figure, gloss, line) in [
        (
            "Chan Figure 24",
            0.0,
            "The renderer's diffuse models on a rough sphere (gloss 0). Light is flatter than with Lambert's law, \
            which is below the coat's Fresnel term here.",
        ),
        (
            "Chan Figure 25",
            1.0,
            "The same on a smooth sphere (gloss 1). Light is rounder with Disney's model and the models of facets.",
        ),
    ] {
        page.begin(figure, line);
        let alpha = Gloss::Wwii.alpha(gloss);
        let mesh = cube_sphere(24, [1.0, 1.0, 1.0, alpha as f32]);
        let object = Object::new("sphere", mesh).with_specular_f0(F0 as f32).without_shadow();
        let environment = Environment::from_equirect(&studio.gpu, 16, &dark)?;
        let mut renderer = Renderer::new(&studio.gpu, vec![object], environment)?;
        // The light of the CPU's spheres, with the viewer along -y and z up.
        let [x, y, z] = LIGHT.as_vec3().to_array();
        let sun = Some(Sun { direction: Vec3::new(x, -z, y), irradiance: Vec3::splat(std::f32::consts::PI) });
        let camera = Camera::looking_at(Vec3::NEG_Y * 60.0, Vec3::ZERO, 2.0 * (1.05f32 / 60.0).atan().to_degrees());
        let state = FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) };
        let (mut figures, mut table): (Vec<Figure>, _) = (
            Vec::new(),
            Table::new(
                "Radiance at the pole towards the light, and at grazing views",
                ["model", "middle", "rim", "formula, rms"],
            ),
        );
        for diffuse_model in DiffuseModel::ALL {
            let shading = Technique::Leadr.with(ShadingOptions {
                terms: Terms::DIFFUSE_LIGHTS,
                diffuse_model,
                pixel_kernel: PixelKernel::Off,
                ..Default::default()
            });
            let settings =
                RenderSettings { size: (size, size), samples: 4, shadows: false, shading, ..Default::default() };
            let shot = studio.shoot(&mut renderer, &state, &settings)?;
            let drawn: Vec<Option<f64>> =
                shot.image.texels.iter().zip(&shot.coverage).map(|(t, c)| (*c > 0.99).then_some(t[1].into())).collect();
            let formula = match diffuse_model {
                DiffuseModel::Disney | DiffuseModel::CallOfDuty => {
                    let truth = sphere(size, |_, wo, wi, _| diffuse_value(diffuse_model, wo, wi, alpha, DVec3::ONE).x);
                    Some(rms(&drawn, &truth))
                }
                // The others also have the coat of the renderer.
                _ => None,
            };
            let at = |x: f64, y: f64| {
                let k = |v: f64| ((v + 1.05) / 2.1 * f64::from(size)) as u32;
                drawn[(k(-y) * size + k(x)) as usize].unwrap_or(f64::NAN)
            };
            let (middle, rim) = (at(LIGHT.x, LIGHT.y), at(-0.8 * 0.93, 0.6 * 0.93));
            let rms_cell = formula.map_or_else(|| Cell::from(""), Cell::from);
            table.row([Cell::from(diffuse_model.name()), Cell::from(middle), Cell::from(rim), rms_cell]);
            page.check(format!("{}: rim / middle", diffuse_model.name()), rim / middle);
            if let Some(formula) = formula {
                page.check(format!("{}: picture less formula, rms", diffuse_model.name()), formula);
            }
            let (name, caption) =
                (format!("chan-model-{gloss}-{}", diffuse_model.name()), diffuse_model.name().to_owned());
            figures.push(studio.picture(&name, &shot.image, 0.8, &caption, vec![caption.clone()])?.enlarged(2));
        }
        page.html.figures(&figures);
        page.html.table(&table);
    }
    Ok(())
}
