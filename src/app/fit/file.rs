//! `leadr fit FILE`: fits one material and writes its files.

use super::args::FitArgs;
use super::export::{Renderer, Simple, identifier};
use super::fitted::{Fitted, SPHERE};
use super::page::of_material;
use super::report::{ExportReport, csv};
use super::targets::Targets;
use leadr_maps::new_file::write_atomic;
use leadr_maps::save::{save_png, save_png_srgb8};
use leadr_maps::shown::shown_path;
use leadr_maps::tonemap::Tonemap;
use leadr_measured::export::Export;
use leadr_reflectance::extraction::fit::Step;
use leadr_reflectance::extraction::roughness::ggx_roughness;
use leadr_reflectance::facets::ellipse::ellipse_from_roughness;
use leadr_scenes::file_kind::FileKind;
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;
use leadr_tools::fit::mean_difference::MeanDifference;
use leadr_tools::fit::spheres::contact_sheet;

pub fn run(arguments: &FitArgs, output: &Output) -> Result<(), AppError> {
    let targets = Targets::of_file(arguments)?;
    FileKind::check("leadr fit", &arguments.input, &[])?;
    let bar = output.bar(4, "fitting");
    let mut fitted = Fitted::new(&arguments.input, arguments, &mut |step| {
        bar.message(match step {
            Step::Slopes => "fitting slopes",
            Step::Fresnel => "fitting the Fresnel term",
            Step::Refinement => "refining the fit over all directions",
            Step::Lobes => "fitting lobes",
        });
        bar.step();
    })?;
    drop(bar);
    if targets.draws() {
        output.say("drawing spheres");
        let drawn = fitted.draw();
        if let Some(picture) = &targets.picture {
            save_png(picture, &contact_sheet(&drawn.spheres), 1.0, Tonemap::Clamp)?;
        }
        if let Some(file) = &targets.delta_e {
            let mut mean = MeanDifference::new(SPHERE);
            for ((name, _), sphere) in drawn.models.named().iter().zip(&drawn.spheres[1..]) {
                mean.add(name, &drawn.spheres[0], sphere);
            }
            save_png_srgb8(file, &mean.image())?;
        }
        if let (Some(file), Some(picture)) = (&targets.page, &targets.picture) {
            let html = of_material(&fitted, &drawn, picture, targets.delta_e.as_deref());
            write_atomic(file, html.as_bytes())?;
        }
    }
    export(&mut fitted, arguments)?;
    if let Some(file) = &arguments.output {
        write_atomic(file, fitted.text().as_bytes())?;
    }
    if let Some(file) = &arguments.csv {
        write_atomic(file, csv(std::slice::from_ref(&fitted.report), &[]).as_bytes())?;
    }
    fitted.report.files = targets.all;
    output.result(&fitted.report)
}

/// Writes the materials for other programs.
fn export(fitted: &mut Fitted, arguments: &FitArgs) -> Result<(), AppError> {
    if let Some((file, format)) = arguments.export.as_deref().and_then(|file| Some((file, Export::of(file)?))) {
        if !fitted.measured.is_isotropic() && format != Export::Rgl {
            let (input, file) = (shown_path(&arguments.input), shown_path(file));
            return Err(AppError::Failed(format!(
                "{input}: the material is anisotropic, but '{file}' would hold an isotropic one: use --mitsuba, --pbrt or a .bsdf file"
            )));
        }
        let stem = arguments.input.file_stem().unwrap_or_default().to_string_lossy();
        let isotropic = fitted.measured.is_isotropic();
        write_atomic(file, &format.bytes(&fitted.fit.fitted, isotropic, &stem))?;
    }
    if arguments.mitsuba.is_none() && arguments.pbrt.is_none() {
        return Ok(());
    }
    let stem = arguments.input.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    // The diffuse base is exported separately, so this is the roughness of the fitted slopes.
    let roughness = ggx_roughness(&fitted.fit.fitted.facets.distribution);
    let (samples, ellipse) = (fitted.samples(), ellipse_from_roughness(roughness));
    for (file, renderer) in [(&arguments.mitsuba, Renderer::Mitsuba), (&arguments.pbrt, Renderer::Pbrt)] {
        let Some(file) = file else { continue };
        let (simple, wrong) = Simple::nearest(&samples, ellipse, &fitted.fit.lobes, renderer);
        write_atomic(file, simple.text(&identifier(&stem)).as_bytes())?;
        fitted.report.exports.push(ExportReport { renderer, misfit: wrong.into() });
    }
    Ok(())
}
