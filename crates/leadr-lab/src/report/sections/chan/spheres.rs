//! Draws figures 23 to 26, 33 and 34: spheres of diffuse laws.

use glam::{Affine3A, DVec3, Quat, Vec3};
use rayon::prelude::*;

use super::GLOSSES;
use super::laws::{F0, Law};
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use crate::report::verdict::Shot;
use leadr_maps::RgbImage;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::frame::{frame_about, to_frame};
use leadr_reflectance::materials::diffuse_models::{DiffuseModel, diffuse_value};
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::scene::{FrameState, Object, Pose, Sun};
use leadr_render::settings::{PixelKernel, RenderSettings, ShadingOptions, Technique, Terms};
use leadr_scenes::plane::{even, plane};
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

/// Returns the left half of `first` and the right half of `second`.
fn halves(size: u32, first: &[Option<f64>], second: &[Option<f64>]) -> Vec<Option<f64>> {
    (0..size * size).map(|i| if i % size < size / 2 { first[i as usize] } else { second[i as usize] }).collect()
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
            keep(0, &halves(size, &first, &second), &format!("{a} | {b}"), &|left| if left { YELLOW } else { CYAN })?;
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

/// A sphere on a floor of the same material, with the light of the CPU's spheres.
struct Ball(Renderer);

/// The angle of the camera above the floor, in degrees.
const ABOVE: f32 = 15.0;

impl Ball {
    fn new(studio: &Studio, alpha: f64, f0: f64) -> Result<Self, LabError> {
        let dark = RgbImage::new(8, 4, vec![[0.0; 3]; 32]).map_err(fault)?;
        let color = [1.0, 1.0, 1.0, alpha as f32];
        let f0 = f0 as f32;
        let sphere = Object::new("sphere", cube_sphere(24, color)).with_specular_f0(f0);
        let floor = Object::new("floor", plane(20.0, 16, 1.0, color, even)).with_specular_f0(f0).without_shadow();
        let environment = Environment::from_equirect(&studio.gpu, 16, &dark)?;
        Ok(Self(Renderer::new(&studio.gpu, vec![sphere, floor], environment)?))
    }

    /// Draws the sphere, which stands on the floor if `on_floor`.
    fn draw(&mut self, studio: &Studio, size: u32, model: DiffuseModel, on_floor: bool) -> Result<Shot, LabError> {
        // The viewer is along z in the frame of LIGHT, and along -y and up in the scene.
        let turn = Quat::from_rotation_x(-ABOVE.to_radians());
        let [x, y, z] = LIGHT.as_vec3().to_array();
        let direction = turn * Vec3::new(x, -z, y);
        let sun = Some(Sun { direction, irradiance: Vec3::splat(std::f32::consts::PI) });
        let half = if on_floor { 1.4f32 } else { 1.05 };
        let camera = Camera::looking_at(turn * Vec3::NEG_Y * 60.0, Vec3::ZERO, 2.0 * (half / 60.0).atan().to_degrees());
        // Far above the camera, the floor is out of the picture.
        let below = if on_floor { Vec3::NEG_Z } else { Vec3::Z * 1000.0 };
        let poses = vec![Pose::REST, Pose::Rigid(Affine3A::from_translation(below))];
        let state = FrameState { sun, ..FrameState::new(camera, poses) };
        let shading = Technique::Leadr.with(ShadingOptions {
            terms: Terms::DIFFUSE_LIGHTS,
            diffuse_model: model,
            pixel_kernel: PixelKernel::Off,
            ..Default::default()
        });
        let settings =
            RenderSettings { size: (size, size), samples: 4, shadows: on_floor, shading, ..Default::default() };
        studio.shoot(&mut self.0, &state, &settings)
    }
}

/// Draws figures 24 and 25 with the renderer's `--diffuse-model`, and compares the pictures with the formulas.
fn models(studio: &mut Studio, page: &mut Page, size: u32) -> Result<(), LabError> {
    for (figure, gloss, line) in [
        (
            "Chan Figure 24",
            0.0,
            "The renderer's diffuse models on a rough sphere and floor (gloss 0). As in the paper, Lambert's law and Oren and Nayar's model have \
            no coat (F0 = 0). Light is flatter than with Lambert's law. Last, Lambert's law (left) and multiscattering (right).",
        ),
        (
            "Chan Figure 25",
            1.0,
            "The same on a smooth sphere and floor (gloss 1). Light is rounder with Disney's model and the models of facets.",
        ),
    ] {
        page.begin(figure, line);
        let alpha = Gloss::Wwii.alpha(gloss);
        let (mut bare, mut coated) = (Ball::new(studio, alpha, 0.0)?, Ball::new(studio, alpha, F0)?);
        let (mut figures, mut table): (Vec<Figure>, _) = (
            Vec::new(),
            Table::new(
                "Radiance at the pole towards the light, and at grazing views",
                ["model", "F0", "middle", "rim", "formula, rms"],
            ),
        );
        let mut compared = Vec::new();
        for diffuse_model in DiffuseModel::ALL {
            let has_coat = !matches!(diffuse_model, DiffuseModel::Lambert | DiffuseModel::OrenNayar);
            let (ball, f0) = if has_coat { (&mut coated, F0) } else { (&mut bare, 0.0) };
            let shot = ball.draw(studio, size, diffuse_model, false)?;
            let drawn: Vec<Option<f64>> =
                shot.image.texels.iter().zip(&shot.coverage).map(|(t, c)| (*c > 0.99).then_some(t[1].into())).collect();
            let formula = match diffuse_model {
                DiffuseModel::Lambert | DiffuseModel::OrenNayar | DiffuseModel::Disney | DiffuseModel::CallOfDuty => {
                    let truth = sphere(size, |_, wo, wi, _| diffuse_value(diffuse_model, wo, wi, alpha, DVec3::ONE).x);
                    Some(rms(&drawn, &truth))
                }
                // The others depend on the coat of the renderer.
                _ => None,
            };
            let at = |x: f64, y: f64| {
                let k = |v: f64| ((v + 1.05) / 2.1 * f64::from(size)) as u32;
                drawn[(k(-y) * size + k(x)) as usize].unwrap_or(f64::NAN)
            };
            let (middle, rim) = (at(LIGHT.x, LIGHT.y), at(-0.8 * 0.93, 0.6 * 0.93));
            let rms_cell = formula.map_or_else(|| Cell::from(""), Cell::from);
            let name = diffuse_model.name();
            table.row([Cell::from(name), Cell::from(f0), Cell::from(middle), Cell::from(rim), rms_cell]);
            page.check(format!("{name}: rim / middle"), rim / middle);
            if let Some(formula) = formula {
                page.check(format!("{name}: picture less formula, rms"), formula);
            }
            let shown = ball.draw(studio, size, diffuse_model, true)?.image;
            let file = format!("chan-model-{gloss}-{name}");
            figures.push(studio.picture(&file, &shown, 0.8, name, vec![name.to_owned()])?.enlarged(2));
            if matches!(diffuse_model, DiffuseModel::Lambert | DiffuseModel::Multiscattering) {
                compared.push(drawn);
            }
        }
        let [lambert, facets] = [&compared[0], &compared[1]];
        let both = image(size, &halves(size, lambert, facets), |left| if left { YELLOW } else { CYAN })?;
        let caption = "lambert | multiscattering";
        let file = format!("chan-model-{gloss}-split");
        figures.push(studio.picture(&file, &both, 0.8, caption, vec![caption.to_owned()])?.enlarged(2));
        page.check("lambert less multiscattering, rms", rms(lambert, facets));
        page.html.figures(&figures);
        page.html.table(&table);
    }
    Ok(())
}
