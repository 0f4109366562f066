//! Compares relief by classes of facets with one Gaussian of slopes, in pictures, in motion and in files.

use glam::Vec3;
use serde::Serialize;

use super::precision::baked;
use super::resolution::MEAN_SHOWN;
use crate::hard_edges::{bricks, grooves, shingles, studs, tiles};
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::Shot;
use leadr_maps::bake::{Inputs, Kind, Layout, Plan, Precision};
use leadr_maps::material::{Input, Material, Relief, RoughnessMeaning};
use leadr_maps::{HeightMap, MapFault, RgbImage};
use leadr_reflectance::facets::metals::Metal;
use leadr_render::camera::Camera;
use leadr_render::sampling::independent_seed;
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr_scenes::dressed::plane_stage;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::{bias_over, rrmse_over};
use leadr_tools::metrics::flicker::{change, excess, magnitude};

const INTRO: &str = "Reliefs with hard edges on a plane, under the sky and its sun. One sample of LEADR shades them as one Gaussian of \
    slopes (--classes off) and by classes of facets (the default). Both are compared with the supersampled reference, whose bumps cast \
    shadows. A near picture has the pixels of the reference. Pixels of the other pictures are as large as blocks of these.";

/// The width of a repeat in metres, and of a picture. The plane of 8 m has two repeats along each side, and the relief around the
/// picture casts shadows into it.
const REPEAT: f32 = 4.0;
/// The number of samples of the reference.
const SAMPLES: u32 = 32;
const QUICK_SAMPLES: u32 = 8;
const ALBEDO: f32 = 0.5;
const ALPHA: f32 = 0.35;

/// A relief, and the function that makes its heights with a number of texels along a side.
type NamedRelief = (&'static str, fn(u32) -> HeightMap);

/// The reliefs after the roof tiles.
const RELIEFS: [NamedRelief; 4] =
    [("bricks", bricks), ("shingles", shingles), ("studs", crowded_studs), ("grooves", grooves)];

fn crowded_studs(texels: u32) -> HeightMap {
    let unit = f64::from(texels) / 64.0;
    studs(texels, 1.1 * unit, 0.5 * unit, 0.5, 0.75 * unit)
}

/// The directions of view around the vertical, in degrees. Under one sun, a single direction can hide or favour an error.
const AZIMUTHS: [f32; 3] = [-40.0, 80.0, 200.0];

/// A view at an angle from the vertical, in degrees, with the number of pixels along a repeat.
#[derive(Clone, Copy)]
struct View {
    name: &'static str,
    degrees: f32,
    pixels: u32,
}

/// The number of pixels of the reference along a repeat.
const FINEST: u32 = 64;
const FAR: [View; 2] = [View { name: "far", degrees: 45.0, pixels: 4 }, View { name: "low", degrees: 75.0, pixels: 4 }];
const VIEWS: [View; 4] = [
    View { name: "near", degrees: 45.0, pixels: FINEST },
    View { name: "mid", degrees: 45.0, pixels: 16 },
    FAR[0],
    FAR[1],
];

impl View {
    /// Returns the size of a picture with the reference's pixels, whose blocks are pixels of the view.
    fn finest(self) -> (u32, u32) {
        let far = FAR[0].pixels;
        let rows = (far as f32 * self.degrees.to_radians().cos()).round() as u32;
        (FINEST, rows.max(1) * (FINEST / far))
    }

    fn size(self) -> (u32, u32) {
        let (width, height) = self.finest();
        let block = FINEST / self.pixels;
        (width / block, height / block)
    }

    /// Returns the camera of a picture, with nearly parallel rays.
    fn camera(self, azimuth: f32) -> Camera {
        let (sine, cosine) = self.degrees.to_radians().sin_cos();
        let (y, x) = azimuth.to_radians().sin_cos();
        let (distance, pixel) = (100.0 * REPEAT, REPEAT / FINEST as f32);
        let fov = 2.0 * (0.5 * self.finest().1 as f32 * pixel / distance).atan().to_degrees();
        let toward = Vec3::new(x * sine, y * sine, cosine);
        Camera { near: 1.0, ..Camera::looking_at(toward * distance, Vec3::ZERO, fov) }
    }
}

/// The two ways to shade a relief, in the order of all pairs.
const WAYS: [&str; 2] = ["one Gaussian", "classes"];

/// The errors of a view: the RMS over the azimuths, and the mean bias.
#[derive(Serialize)]
struct Row {
    subject: String,
    view: &'static str,
    degrees: f32,
    texels_per_pixel: u32,
    rrmse: [f64; 2],
    bias: [f64; 2],
    noise: f64,
}

/// The changes between the frames of a zoom, as RMS relative to those of the reference.
#[derive(Serialize)]
struct Zoom {
    change: [f64; 2],
    /// The changes that the reference does not have.
    flicker: [f64; 2],
}

#[derive(Serialize)]
struct File {
    classes: usize,
    format: &'static str,
    bytes_per_texel: f64,
    /// The error of reflections by the classes, before they are stored.
    error: f64,
    /// The largest error of the classes by the format, on any level.
    stored_error: f64,
}

#[derive(Serialize)]
struct Data {
    pictures: Vec<Row>,
    zoom: Zoom,
    files: Vec<File>,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let texels = studio.pick(128, 256);
    let reliefs = studio.pick(&RELIEFS[..1], &RELIEFS);
    studio.steps(reliefs.len() + 4);
    let plaster = Material { base_color: Input::constant([ALBEDO; 3]), ..rough("plaster") };
    let (mut html, mut pictures) = (Html::new(), Vec::new());
    let mut of_tiles = subject(studio, &plaster, &tiles(texels))?;
    pictures.extend(compared(studio, &mut of_tiles, ("roof tiles", texels), &VIEWS, &mut html)?);
    let zoom = zoom(studio, &mut of_tiles)?;
    for &(name, map) in reliefs {
        let mut subject = subject(studio, &plaster, &map(texels))?;
        pictures.extend(compared(studio, &mut subject, (name, texels), &VIEWS, &mut html)?);
    }
    let mut gold = subject(studio, &metal("gold")?, &tiles(texels))?;
    pictures.extend(compared(studio, &mut gold, ("gold roof tiles", texels), &FAR, &mut html)?);
    let files = files(&bricks(texels))?;
    studio.step();
    html.table(&zoom_table(&zoom));
    html.table(&files_table(&files));
    Section::new(INTRO, findings(&pictures, &zoom, &files), &html, Data { pictures, zoom, files })
}

fn rough(name: &str) -> Material {
    Material { roughness: Input::constant(ALPHA), roughness_meaning: RoughnessMeaning::Alpha, ..Material::new(name) }
}

fn metal(name: &str) -> Result<Material, LabError> {
    let metal = Metal::named(name).ok_or_else(|| LabError(format!("there is no {name}")))?;
    Ok(Material {
        base_color: Input::constant(metal.f0().as_vec3().to_array()),
        metalness: Input::constant(1.0),
        edge_tint: metal.edge_tint().as_vec3().to_array(),
        ..rough(name)
    })
}

fn subject(studio: &Studio, material: &Material, map: &HeightMap) -> Result<Subject, LabError> {
    let relief = Relief { map: map.clone(), scale: Some(REPEAT), in_widths: false, middle: map.mean() };
    let material = Material { relief: Some(relief), ..material.clone() };
    Subject::under_the_sky(studio, plane_stage(&material, Some(REPEAT)), 0.0)
}

/// Returns the settings of one sample without and with classes.
fn settings(size: (u32, u32)) -> [RenderSettings; 2] {
    [false, true].map(|classes| {
        let shading = Technique::Leadr.with(ShadingOptions { classes, sky_occlusion: false, ..Default::default() });
        RenderSettings { size, samples: 1, shading, ..Default::default() }
    })
}

/// The pictures of a view from one azimuth.
struct Shots {
    /// The halves of the reference, which share no sample.
    halves: [Shot; 2],
    shaded: [Shot; 2],
}

/// The relative RMSE and the bias of both ways, and the noise of the reference.
type OfAzimuth = ([f64; 2], [f64; 2], f64);

impl Shots {
    fn truth(&self) -> Result<Shot, MapFault> {
        Shot::mean(&self.halves)
    }

    fn errors(&self) -> Result<OfAzimuth, MapFault> {
        let (truth, [a, b]) = (self.truth()?.image, &self.halves);
        let everywhere = Mask::all(truth.width, truth.height);
        let rrmse = |of: usize| rrmse_over(&truth, &self.shaded[of].image, &everywhere);
        let bias = |of: usize| bias_over(&truth, &self.shaded[of].image, &everywhere);
        let noise = 0.5 * rrmse_over(&a.image, &b.image, &everywhere)?;
        Ok(([rrmse(0)?, rrmse(1)?], [bias(0)?, bias(1)?], noise))
    }
}

/// Renders the pictures of all views at an angle, from one azimuth.
fn shots(studio: &Studio, subject: &mut Subject, views: &[View], azimuth: f32) -> Result<Vec<Shots>, LabError> {
    let samples = studio.pick(QUICK_SAMPLES, SAMPLES) / 2;
    let state = subject.seen_by(&views[0].camera(azimuth));
    let mut half = |seed: u64| {
        let settings = Truth::Shadowed.settings(views[0].finest(), samples, seed);
        studio.shoot(&mut subject.renderer, &state, &settings)
    };
    let halves = [half(1)?, half(independent_seed(samples, 1))?];
    let of_view = |view: &View| {
        let blocks = |half: &Shot| half.of_blocks(FINEST / view.pixels).map_err(fault);
        let [gaussian, classes] =
            settings(view.size()).map(|settings| studio.shoot(&mut subject.renderer, &state, &settings));
        Ok(Shots { halves: [blocks(&halves[0])?, blocks(&halves[1])?], shaded: [gaussian?, classes?] })
    };
    views.iter().map(of_view).collect()
}

/// Compares the pictures of a relief in some views.
fn compared(
    studio: &mut Studio,
    subject: &mut Subject,
    (name, texels): (&str, u32),
    views: &[View],
    html: &mut Html,
) -> Result<Vec<Row>, LabError> {
    let samples = studio.pick(QUICK_SAMPLES, SAMPLES);
    let title = format!(
        "{name}: pictures from the first of {} azimuths, errors over all; reference of {samples} samples per pixel of the near picture",
        AZIMUTHS.len()
    );
    let numbers = ["rRMSE, one Gaussian", "rRMSE, classes", "bias, one Gaussian", "bias, classes", "noise"];
    let mut table = Table::new(title, ["view", "reference"].into_iter().chain(WAYS).chain(numbers));
    let mut rows = Vec::new();
    for views in views.chunk_by(|a, b| a.degrees == b.degrees) {
        let all = AZIMUTHS.iter().map(|&azimuth| shots(studio, subject, views, azimuth));
        let all = all.collect::<Result<Vec<_>, _>>()?;
        for (i, view) in views.iter().enumerate() {
            let texels_per_pixel = texels / view.pixels;
            let what = format!("{}: {}°, {texels_per_pixel} texels a pixel", view.name, view.degrees);
            let mut cells = vec![Cell::from(what)];
            let first = &all[0][i];
            let truth = first.truth().map_err(fault)?;
            let exposure = (MEAN_SHOWN / truth.luminance(&truth.object().map_err(fault)?)) as f32;
            for (shot, what) in [&truth].into_iter().chain(&first.shaded).zip(["reference"].into_iter().chain(WAYS)) {
                let file = format!("classes-{name}-{}-{what}", view.name).replace(' ', "-");
                let figure = studio.picture(&file, &shot.image, exposure, what, Vec::new())?;
                cells.push(Cell::Figure(figure.enlarged(2 * FINEST / view.pixels)));
            }
            let errors = all.iter().map(|of_azimuth| of_azimuth[i].errors()).collect::<Result<Vec<_>, _>>();
            let errors = errors.map_err(fault)?;
            let mean = |of: &dyn Fn(&OfAzimuth) -> f64| errors.iter().map(of).sum::<f64>() / errors.len() as f64;
            let rms = |of: &dyn Fn(&OfAzimuth) -> f64| mean(&|all| of(all).powi(2)).sqrt();
            let rrmse = [0, 1].map(|way| rms(&|errors| errors.0[way]));
            let bias = [0, 1].map(|way| mean(&|errors| errors.1[way]));
            let noise = rms(&|errors| errors.2);
            table.row(cells.into_iter().chain(rrmse.into_iter().chain(bias).chain([noise]).map(Cell::from)));
            let (subject, view, degrees) = (name.to_owned(), view.name, view.degrees);
            rows.push(Row { subject, view, degrees, texels_per_pixel, rrmse, bias, noise });
        }
    }
    html.table(&table);
    studio.step();
    Ok(rows)
}

/// The factor of the distance between two frames of the zoom.
const RATIO: f64 = 1.06;

/// Moves the camera away from a relief, and compares the changes between frames with those of the reference.
fn zoom(studio: &Studio, subject: &mut Subject) -> Result<Zoom, LabError> {
    let (steps, samples) = studio.pick((4, QUICK_SAMPLES / 2), (24, SAMPLES / 4));
    let view = View { pixels: 16, ..FAR[0] };
    let last = view.camera(AZIMUTHS[0]);
    let mut frames: Vec<[RgbImage; 3]> = Vec::new();
    for step in 0..=steps {
        let distance = (last.position - last.target).length() * RATIO.powi(step - steps) as f32;
        let state = subject.seen_by(&Camera { near: 1.0, ..last.at_distance(distance) });
        // All frames share the directions of the sky, whose noise therefore does not change.
        let truth = Truth::Shadowed.settings(view.finest(), samples, 1);
        let truth = studio.shoot(&mut subject.renderer, &state, &truth)?;
        let [gaussian, classes] = settings(view.size()).map(|one| studio.shoot(&mut subject.renderer, &state, &one));
        let truth = truth.of_blocks(FINEST / view.pixels).map_err(fault)?;
        frames.push([truth.image, gaussian?.image, classes?.image]);
    }
    let everywhere = Mask::all(view.size().0, view.size().1);
    let (mut own, mut beyond) = ([0.0; 3], [0.0; 3]);
    for pair in frames.windows(2) {
        let changes = (0..3).map(|kind| change(&pair[0][kind], &pair[1][kind], RATIO));
        let changes = changes.collect::<Result<Vec<_>, _>>().map_err(fault)?;
        for (kind, change) in changes.iter().enumerate() {
            own[kind] += magnitude(change, &everywhere).map_err(fault)?.rms.powi(2);
            beyond[kind] += excess(change, &changes[0], &everywhere).map_err(fault)?.rms.powi(2);
        }
    }
    studio.step();
    let relative = |squares: [f64; 3]| [1, 2].map(|kind| (squares[kind] / own[0]).sqrt());
    Ok(Zoom { change: relative(own), flicker: relative(beyond) })
}

fn zoom_table(zoom: &Zoom) -> Table {
    let title =
        "A camera that moves away from roof tiles: RMS change from frame to frame, relative to the reference's own";
    let mut table = Table::new(title, ["shading", "change", "change that the reference does not have"]);
    for (way, name) in WAYS.into_iter().enumerate() {
        table.row([Cell::from(name), zoom.change[way].into(), zoom.flicker[way].into()]);
    }
    table
}

/// Bakes a relief with one to four classes.
fn files(map: &HeightMap) -> Result<Vec<File>, LabError> {
    let mut inputs = Inputs { heights: Some(map.clone()), height_scale: Some(1.0), ..Inputs::default() };
    let mut files = Vec::new();
    for classes in 1..=4 {
        let found = inputs.find_classes(Some(classes));
        let error = found.errors().last().copied().unwrap_or_default();
        inputs.classes = (classes > 1).then_some(found);
        for precision in [Precision::F16, Precision::Bc] {
            let plan = Plan::new(&inputs, Kind::Leadr, Layout::Leadr, precision).map_err(fault)?;
            let file = baked(&inputs, &plan)?;
            let bytes_per_texel = file.bytes as f64 / map.texels.len() as f64;
            files.push(File { classes, format: precision.name(), bytes_per_texel, error, stored_error: file.classes });
        }
    }
    Ok(files)
}

fn files_table(files: &[File]) -> Table {
    let head = ["classes", "format", "bytes per texel", "error of reflections", "error of the stored classes"];
    let mut table = Table::new("Files of bricks: size and error by the number of classes", head);
    for file in files {
        let numbers = [file.bytes_per_texel, file.error, file.stored_error].map(Cell::from);
        table.row([Cell::from(file.classes.to_string()), file.format.into()].into_iter().chain(numbers));
    }
    table
}

fn findings(pictures: &[Row], zoom: &Zoom, files: &[File]) -> Vec<String> {
    let mut findings: Vec<String> = pictures
        .chunk_by(|a, b| a.subject == b.subject)
        .map(|rows| {
            let of_view = |row: &Row| {
                let [gaussian, classes] = row.rrmse.map(number);
                format!("{} {gaussian} and {classes}", row.view)
            };
            let views: Vec<String> = rows.iter().map(of_view).collect();
            format!("{}: rRMSE with one Gaussian and with classes: {}.", rows[0].subject, views.join("; "))
        })
        .collect();
    let [gaussian, classes] = zoom.change.map(number);
    findings.push(format!(
        "Change from frame to frame, relative to that of the reference: {gaussian} with one Gaussian and {classes} with classes."
    ));
    if let (Some(first), Some(last)) = (files.first(), files.last()) {
        findings.push(format!(
            "Files of bricks: from {} class to {} classes, the error of reflections goes from {} to {}.",
            first.classes,
            last.classes,
            number(first.error),
            number(last.error)
        ));
    }
    findings
}
