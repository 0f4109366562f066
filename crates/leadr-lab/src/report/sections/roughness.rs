//! Measures how one sample filters a surface that has two roughnesses.

use glam::Vec3;
use serde::Serialize;

use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::verdict::judge;
use leadr_maps::material::alpha_code;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::camera::Camera;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{MaterialMap, Object};
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr_scenes::plane::{even, plane};
use leadr_scenes::stage::{Stage, Views};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "A chequered floor with the roughnesses .1 and .6 reflects the sun. In the nearest view a pixel is narrower than a \
    square; in far views it covers several. One sample of LEADR is compared with the supersampled reference for three roughness filters: \
    two lobes by classes, the program's default; one lobe of the mean variance, the paper's section 4.1; and one lobe of the mean roughness, the old \
    filter. The goal is an error of at most a quarter of the old filter's.";

const ALPHAS: [f32; 2] = [0.1, 0.6];
/// The number of texels along the map, and along a square. Texels between squares have a roughness between both.
const TEXELS: u32 = 512;
const SQUARE: u32 = 256;
/// The camera distances in metres. A pixel is .8 to 6.4 squares wide.
const DISTANCES: [f32; 6] = [6.0, 9.0, 12.0, 18.0, 24.0, 48.0];

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
enum Filtered {
    TwoLobes,
    MeanVariance,
    MeanRoughness,
}

const ALL: [(Filtered, &str); 3] = [
    (Filtered::TwoLobes, "two lobes"),
    (Filtered::MeanVariance, "one lobe of the mean variance"),
    (Filtered::MeanRoughness, "one lobe of the mean roughness (the old filter)"),
];

#[derive(Serialize)]
struct Entry {
    filtered: Filtered,
    distance: f32,
    rrmse: f64,
    flip: f64,
}

fn stage(filtered: Filtered, views: Views) -> Stage {
    let mean = 0.5 * (ALPHAS[0] + ALPHAS[1]);
    let alpha = |i: u32| match filtered {
        Filtered::MeanRoughness => mean,
        _ => ALPHAS[((i % TEXELS / SQUARE + i / TEXELS / SQUARE) % 2) as usize],
    };
    let colors = (0..TEXELS * TEXELS).map(|i| [90, 90, 90, alpha_code(alpha(i))]).collect();
    let map = MaterialMap::new(TEXELS, TEXELS, colors);
    let floor = Object::new("floor", plane(3.0, 4, 0.0625, [1.0; 4], even));
    Stage::still(vec![floor.with_material(map).with_specular_f0(0.3).without_shadow()], views)
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let size = studio.pick(48, 128);
    let samples = studio.pick(256, 512);
    let sun = Sky::default().sun_direction.normalize();
    let reflected = Vec3::new(-sun.x, -sun.y, sun.z);
    let (mut html, mut entries, mut findings) = (Html::new(), Vec::new(), Vec::new());
    for distance in DISTANCES {
        // Every picture shows the same part of the floor, so more distant cameras use fewer pixels.
        let pixels = (size as f32 * 6.0 / distance) as u32;
        let camera = Camera::looking_at(distance * reflected, Vec3::ZERO, 30.0 * 6.0 / distance);
        let views = Views { near: camera, mid: camera, far: camera };
        let settings = |technique: Technique, samples: u32, classes: bool| RenderSettings {
            size: (pixels, pixels),
            samples,
            shading: technique.with(ShadingOptions { shadowing: Shadowing::None, classes, ..Default::default() }),
            shadows: false,
            ..Default::default()
        };
        let mut subject = Subject::under_the_sky(studio, stage(Filtered::TwoLobes, views), 0.0)?;
        let state = subject.seen_by(&camera);
        let truth =
            studio.shoot_truth(&mut subject.renderer, &state, &settings(Technique::Reference, samples, false))?;
        let title = format!(
            "{} m, {pixels} pixels across; truth of {samples} samples, its noise {}",
            distance,
            number(truth.noise)
        );
        let mut table = Table::new(title, ["", "picture", "rRMSE", "FLIP"]);
        let shown = studio.picture(&format!("roughness-{distance}-truth"), &truth.image, 1.0, "truth", Vec::new())?;
        table.row([Cell::from("truth"), Cell::Figure(shown.enlarged((distance / 6.0) as u32))]);
        for (filtered, name) in ALL {
            let mut subject = Subject::under_the_sky(studio, stage(filtered, views), 0.0)?;
            let settings = settings(Technique::Leadr, 1, filtered == Filtered::TwoLobes);
            let shot = studio.shoot(&mut subject.renderer, &state, &settings)?;
            let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
            let file = format!("roughness-{distance}-{}", name.split(" (").next().unwrap_or(name).replace(' ', "-"));
            let figure = studio.picture(&file, &shot.image, 1.0, name, Vec::new())?;
            let (rrmse, flip) = (verdict.object.rrmse, verdict.object.flip);
            table.row([
                Cell::from(name),
                Cell::Figure(figure.enlarged((distance / 6.0) as u32)),
                Cell::from(rrmse),
                Cell::from(flip),
            ]);
            entries.push(Entry { filtered, distance, rrmse, flip });
        }
        let of = |which: Filtered| {
            let found = entries.iter().find(|entry| entry.filtered == which && entry.distance == distance);
            found.map_or(f64::NAN, |entry| entry.rrmse)
        };
        let (two, old) = (of(Filtered::TwoLobes), of(Filtered::MeanRoughness));
        findings.push(format!(
            "At {distance} m the error of one sample is {} with two lobes, {} with the mean variance and {} with the mean roughness: {} of the old filter's error; the goal is at most a quarter.",
            number(two),
            number(of(Filtered::MeanVariance)),
            number(old),
            number(two / old)
        ));
        html.table(&table);
    }
    Section::new(INTRO, findings, &html, &entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn half_the_floor_is_rough() {
        let camera = Camera::looking_at(Vec3::ONE, Vec3::ZERO, 30.0);
        let views = Views { near: camera, mid: camera, far: camera };
        let stage = stage(Filtered::TwoLobes, views);
        let colors = &stage.objects[0].material.as_ref().unwrap().colors;
        let rough = colors.iter().filter(|texel| texel[3] == alpha_code(ALPHAS[1])).count();
        assert_eq!(2 * rough, colors.len());
        assert_eq!(stage.objects[0].mesh.texcoords[0][0].fract(), Vec2::ZERO);
    }
}
