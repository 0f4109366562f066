//! Shows how a polished plate sparkles when the camera drifts past. Each column has a picture with one filter of the normal map. Below the
//! picture are the middle rows of all frames, one frame per line. A stable filter gives even slanted lines. Sparkle breaks the lines into
//! dots.
//!
//! `cargo run --release --example 23_flicker_strips [FOLDER [METRES [PICTURE.png]]]`
//!
//! FOLDER contains a material, which is rendered as polished steel. Without FOLDER, or with `-`, the plate is a generated hammered plate.
//! The columns are mipmapped normals, Toksvig, shortened normals, LEADR, and the normal map with 144 samples per pixel.

use std::error::Error;

use glam::Vec3;
use leadr::gpu::GpuOptions;
use leadr::maps::folders::OutsideLinks;
use leadr::maps::material::{Input, Material, MaterialFolder, Relief};
use leadr::maps::save::save_png_srgb8;
use leadr::maps::tonemap::{Tonemap, display_srgb8};
use leadr::maps::{Rgb8Image, procedural};
use leadr::open_gpu;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::dressed::plane_stage;
use leadr::scenes::stage::Lights;

/// The width and the height of a picture in pixels.
const SIZE: u32 = 96;
/// The number of frames. Each frame moves the camera by a quarter of a pixel.
const FRAMES: u32 = 72;
const STEP: f32 = 0.25;
/// The number of pixels of the result per pixel of a picture, and between columns.
const ZOOM: u32 = 2;
const GUTTER: u32 = 8;
const FIELD: f32 = 10.0;
/// The exposure that suits the reflected sun.
const EXPOSURE: f32 = 0.08;

fn polished(mut material: Material) -> Material {
    material.base_color = Input::constant([0.56, 0.55, 0.53]);
    material.metalness = Input::constant(1.0);
    material.roughness = Input::constant(0.3);
    material.occlusion = Input::constant(1.0);
    material
}

/// Returns dents of a few centimetres with slopes of 0.2, on a plate of 2 m.
fn hammered() -> Material {
    let map = procedural::gaussian(512, 512, 4, 0.2, 0.008);
    let mut material = Material::new("hammered steel");
    material.relief = Some(Relief { map, scale: None, in_widths: true, middle: 0.0 });
    material
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let material = match arguments.next().as_deref() {
        None | Some("-") => hammered(),
        Some(folder) => MaterialFolder::open(folder, OutsideLinks::Refused)?.load()?,
    };
    let metres = arguments.next().map_or(Ok(30.0), |text| text.parse::<f32>())?;
    let file = arguments.next().unwrap_or_else(|| "out/flicker-strips.png".to_owned());
    let gpu = open_gpu(&GpuOptions::default())?;
    // The plate reflects this sun towards the camera.
    let sky = Sky::with_sun(37.0f32.to_radians(), 90.0f32.to_radians());
    let mut stage = plane_stage(&polished(material), None);
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?;
    let mut renderer = Renderer::new(&gpu, stage.take_scene(), environment)?;
    let lights = Lights::under(&sky);
    let normal_mapped = ShadingOptions { shadowing: Shadowing::NormalMap, ..Default::default() };
    let columns = [
        (Technique::NormalMip, 1),
        (Technique::Toksvig, 1),
        (Technique::Gloss, 1),
        (Technique::Leadr, 1),
        (Technique::Reference, 144),
    ];
    let width = columns.len() as u32 * (SIZE * ZOOM + GUTTER) - GUTTER;
    let height = (SIZE + FRAMES) * ZOOM + GUTTER;
    let mut sheet = Rgb8Image { width, height, texels: vec![[255; 3]; (width * height) as usize] };
    for (column, (technique, samples)) in columns.into_iter().enumerate() {
        let settings = RenderSettings {
            size: (SIZE, SIZE),
            samples,
            displacement: false,
            shading: technique.with(ShadingOptions { relief_occlusion: !technique.is_reference(), ..normal_mapped }),
            tessellation: TessellationSettings { to_texels: false, ..Default::default() },
            ..Default::default()
        };
        let left = column as u32 * (SIZE * ZOOM + GUTTER);
        let mut changes = 0.0f64;
        let mut before: Option<Vec<[f32; 4]>> = None;
        for frame in 0..FRAMES {
            let moved = STEP * frame as f32 / SIZE as f32 * 2.0 * metres * (0.5 * FIELD.to_radians()).tan();
            let target = Vec3::new(moved, 0.0, 0.0);
            let camera = Camera::looking_at(target + Vec3::new(0.0, -0.8, 0.6) * metres, target, FIELD);
            let color = renderer.render(&stage.state(0.0, &camera, &lights), &settings)?.color;
            let rows = if frame == 0 { 0..SIZE } else { 0..0 };
            for (row, line) in rows.map(|row| (row, row)).chain([(SIZE / 2, SIZE + frame)]) {
                let gap = if line >= SIZE { GUTTER } else { 0 };
                for x in 0..SIZE {
                    let [r, g, b, _] = color[(row * SIZE + x) as usize];
                    let code = display_srgb8([r, g, b], EXPOSURE, Tonemap::default());
                    for (dx, dy) in (0..ZOOM * ZOOM).map(|k| (k % ZOOM, k / ZOOM)) {
                        sheet.texels[((line * ZOOM + gap + dy) * width + left + x * ZOOM + dx) as usize] = code;
                    }
                }
            }
            if let Some(before) = before.replace(color.clone()) {
                let [change, mean] = [
                    before.iter().zip(&color).map(|(a, b)| f64::from(b[1] - a[1]).powi(2)).sum::<f64>(),
                    color.iter().map(|c| f64::from(c[1])).sum::<f64>(),
                ];
                changes += (change / color.len() as f64).sqrt() / (mean / color.len() as f64);
            }
        }
        println!(
            "{:<11} change of a pixel per frame: {:.3} of the mean",
            technique.name(),
            changes / f64::from(FRAMES - 1)
        );
    }
    save_png_srgb8(&file, &sheet)?;
    println!("{file}");
    Ok(())
}
