//! `leadr bake`: filters heights, normals or a material folder into maps with all mip levels.

pub mod args;
mod cone_table;
#[cfg(feature = "textures")]
mod model;
mod report;
mod sources;
#[cfg(feature = "textures")]
mod textures;

use std::io::Seek;
use std::path::Path;
use std::time::Instant;

use self::args::{BakeArgs, ClassCount};
use self::report::{BakeReport, BakedSet, HeightFindings};
use self::sources::Sources;
use leadr_maps::MapFault;
use leadr_maps::bake::{ExrFile, Inputs, Kind, Ktx2File, Layout, Plan, PngFile, Precision, Report, Texels, bake};
use leadr_maps::new_file::NewFile;
use leadr_maps::shown::shown_path;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::NormalArea;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension, keep_inputs};
use leadr_tools::command::output::Output;

#[cfg(not(feature = "textures"))]
const NO_ENCODERS: &str = "this program was built without texture encoders; build it with --features textures";

/// The smallest number of texels for which a progress bar is shown. Smaller maps take less than a second.
const LONG: u64 = 1 << 20;

/// The file format of a map.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Container {
    Ktx2,
    Exr,
    Png,
}

/// A map that will be written.
struct Job {
    kind: Kind,
    container: Container,
    file: NewFile,
}

/// Returns the maps to bake. The files of the maps are already open.
fn jobs(arguments: &BakeArgs) -> Result<Vec<Job>, AppError> {
    let precision = arguments.format;
    let kinds = &arguments.kind;
    if let Some(twice) = kinds.iter().enumerate().find(|(i, kind)| kinds[..*i].contains(kind)) {
        return Err(AppError::Usage(format!("--kind names {} twice: name it once", twice.1.name())));
    }
    let output = &arguments.output;
    let container = match extension(output).as_deref() {
        Some("ktx2") => Some(Container::Ktx2),
        Some("exr") => Some(Container::Exr),
        Some("png") => Some(Container::Png),
        _ => None,
    };
    let of_one = |container, kind, path: &Path| {
        if container == Container::Exr && precision == Precision::Bc {
            return Err(AppError::Usage("--format bc is for .ktx2: choose f32 or f16 for an .exr".into()));
        }
        if container == Container::Png && !PngFile::holds(kind) {
            let what = "a .png holds the finest level of --kind height, occlusion, normal, gloss or cones";
            return Err(AppError::Usage(format!("{what}; for kind {} write .ktx2 or .exr", kind.name())));
        }
        if container == Container::Png && precision != Precision::F32 {
            return Err(AppError::Usage("a .png always has 16 bits: leave --format out".into()));
        }
        // The file is opened first, so an unwritable folder is reported before any work.
        Ok(Job { kind, container, file: begin(path)? })
    };
    match (container, kinds.as_slice()) {
        (Some(container), &[kind]) => Ok(vec![of_one(container, kind, output)?]),
        (Some(_), _) => {
            let what = "several kinds make several files";
            Err(AppError::Usage(format!("{what}: name a folder, not '{}'", shown_path(output))))
        }
        (None, &[_]) if !names_a_folder(output) => Err(AppError::Usage(format!(
            "'{}' must end in .ktx2, .exr or .png, or in / for a folder",
            shown_path(output)
        ))),
        (None, _) => {
            let name = arguments.input.as_ref().or(arguments.normal.as_ref()).and_then(|path| path.file_stem());
            let name = name.map_or_else(|| "map".into(), |name| name.to_string_lossy().into_owned());
            let file = |kind: Kind| output.join(format!("{name}_{}.ktx2", kind.name()));
            kinds.iter().map(|&kind| of_one(Container::Ktx2, kind, &file(kind))).collect()
        }
    }
}

/// Whether a path has the suffix of a model.
fn is_model(path: &Path) -> bool {
    matches!(extension(path).as_deref(), Some("glb" | "gltf")) && !path.is_dir()
}

/// Whether a path without a known extension means a folder.
fn names_a_folder(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR])
}

/// Bakes the maps and prints their statistics.
pub fn run(arguments: &BakeArgs, output: &Output) -> Result<(), AppError> {
    if arguments.cone_table {
        return cone_table::run(arguments, output);
    }
    if let Some(input) = arguments.input.as_deref().filter(|input| is_model(input)) {
        #[cfg(feature = "textures")]
        return model::run(arguments, input, output);
        #[cfg(not(feature = "textures"))]
        return Err(AppError::Usage(format!("{}: {NO_ENCODERS}", shown_path(input))));
    }
    if arguments.engine.is_some() {
        #[cfg(feature = "textures")]
        return textures::run(arguments, output);
        #[cfg(not(feature = "textures"))]
        return Err(AppError::Usage(format!("--for: {NO_ENCODERS}")));
    }
    let start = Instant::now();
    let (layout, precision) = (arguments.layout, arguments.format);
    check_flags(arguments)?;
    let jobs = jobs(arguments)?;
    if layout == Layout::Oiio {
        if jobs.iter().any(|job| job.container != Container::Exr || job.kind != Kind::Leadr) {
            return Err(AppError::Usage("--layout oiio needs --kind leadr and an .exr file".into()));
        }
        if arguments.roughness.is_some() || arguments.gloss.is_some() || arguments.color.is_some() {
            let what = "--layout oiio has no channels for --roughness, --gloss or --color: leave them out";
            return Err(AppError::Usage(what.into()));
        }
    }
    let sources = Sources::find(arguments, layout == Layout::Oiio)?;
    keep_inputs(jobs.iter().map(|job| job.file.target()), sources.files())?;
    for remark in &sources.remarks {
        output.say(remark);
    }
    let (mut inputs, quantisation) = sources.load(arguments, output)?;
    inputs.size().map_err(|fault| fault.in_file(sources.main()))?;
    // The heights and the normals from the files are compared before heights are derived.
    let agreement = inputs.agree();
    if let Some(agreement) = &agreement {
        if agreement.is_of_one_surface() {
            output.say(&format!("heights and normals agree: {agreement}"));
        } else {
            tracing::warn!("heights and normals disagree: {agreement}; try --normal-y, or bake only one of them");
        }
    }
    let heights = HeightFindings { agreement, quantisation };
    let in_proportion = [Kind::Toksvig, Kind::Normal, Kind::Gloss, Kind::Occlusion, Kind::Cones];
    let has_scale = inputs.height_scale.is_some() || inputs.normals.is_some() || inputs.heights.is_none();
    if !has_scale && arguments.kind.iter().any(|kind| in_proportion.contains(kind)) {
        output.say("heights from 0 to 1 are taken as one width of the map: give their true range by --height-scale, such as 0.06");
    }
    derive(&mut inputs, &arguments.kind, &sources, output)?;
    let found = arguments.kind.contains(&Kind::Leadr).then(|| match arguments.classes {
        ClassCount::Exactly(count) if count > 1 => inputs.find_classes(Some(count)),
        _ => inputs.find_classes(None),
    });
    let is_stored = arguments.classes != ClassCount::Exactly(1);
    inputs.classes = found.clone().filter(|found| is_stored && found.count() > 1);
    let mut reports = Vec::new();
    for mut job in jobs {
        let begun = Instant::now();
        let kind = job.kind;
        let plan_of =
            |precision| Plan::new(&inputs, kind, layout, precision)?.without_levels(arguments.drop_levels as usize);
        let plan_of = |precision| plan_of(precision).map_err(|fault: MapFault| fault.in_file(sources.main()));
        let mut plan = plan_of(precision)?;
        let long = u64::from(plan.size[0]) * u64::from(plan.size[1]) >= LONG;
        let what = format!("baking {}", plan.kind.name());
        let progress = output.share(long.then_some(&what));
        let target = job.file.target().to_path_buf();
        let mut write = |plan: &Plan| write(&inputs, plan, &mut job, &progress).map_err(|fault| fault.in_file(&target));
        let mut baked = write(&plan)?;
        if let Some(worst) = classes_beyond_blocks(precision, &baked) {
            output
                .say(&format!("the classes lose {:.1} % in blocks: the file has 16-bit floats instead", 100.0 * worst));
            plan = plan_of(Precision::F16)?;
            baked = write(&plan)?;
        }
        drop(progress);
        if let Some(warning) = beyond_the_goal(plan.precision, &baked) {
            output.say(&warning);
        }
        let bytes = job.file.file.metadata().map_or(0, |metadata| metadata.len());
        job.file.finish()?;
        let time = if arguments.kind.len() == 1 { start.elapsed() } else { begun.elapsed() };
        let classes = found.as_ref().filter(|_| plan.kind == Kind::Leadr && layout == Layout::Leadr);
        reports.push(BakeReport::new(&target, &sources, &plan, &baked, heights, classes, bytes, time));
    }
    match &reports[..] {
        [one] => output.result(one),
        _ => output.result(&BakedSet::new(reports, start.elapsed())),
    }
}

/// Computes heights and occlusion if the requested kinds need them and the files do not contain them.
fn derive(inputs: &mut Inputs, kinds: &[Kind], sources: &Sources, output: &Output) -> Result<(), AppError> {
    let size = inputs.size().map_err(|fault| fault.in_file(sources.main()))?;
    let long = u64::from(size[0]) * u64::from(size[1]) >= LONG / 4;
    let in_main = |fault: MapFault| fault.in_file(sources.main());
    if kinds.iter().any(|kind| matches!(kind, Kind::Height | Kind::Occlusion | Kind::Cones)) && inputs.heights.is_none()
    {
        let progress = output.share(long.then_some("computing heights"));
        let found = inputs.find_heights(&progress).map_err(in_main)?;
        drop(progress);
        output.say(&format!("heights from normals: {found}"));
    }
    if kinds.iter().any(|kind| matches!(kind, Kind::Occlusion | Kind::Cones)) {
        let progress = output.share(long.then_some("computing occlusion"));
        inputs.compute_occlusion(&progress).map_err(in_main)?;
    }
    Ok(())
}

/// Writes a map, over what the file already holds.
fn write(inputs: &Inputs, plan: &Plan, job: &mut Job, progress: &dyn Fn(f32)) -> Result<Report, MapFault> {
    let file = &mut job.file.file;
    file.set_len(0).and_then(|()| file.rewind()).map_err(MapFault::io("cannot be written"))?;
    match job.container {
        Container::Ktx2 => {
            let mut target = Ktx2File::new(file, plan)?;
            let report = bake(inputs, plan, &mut target, progress)?;
            target.finish(&report)?;
            Ok(report)
        }
        Container::Exr => {
            let mut target = ExrFile::new(plan)?;
            let report = bake(inputs, plan, &mut target, progress)?;
            target.finish(file, &report)?;
            Ok(report)
        }
        Container::Png => {
            let mut target = PngFile::new(plan)?;
            let report = bake(inputs, plan, &mut target, progress)?;
            target.finish(file, &report)?;
            Ok(report)
        }
    }
}

/// Refuses flags that do not affect any of the baked kinds.
fn check_flags(arguments: &BakeArgs) -> Result<(), AppError> {
    let a = arguments;
    let has_gloss = a.gloss.is_some() || a.detail_gloss.is_some();
    let heights: &[Kind] = &[Kind::Height, Kind::Occlusion, Kind::Cones];
    for (flag, is_given, kinds, for_what) in [
        ("--detail", a.detail.is_some(), &[Kind::Normal, Kind::Gloss][..], "normal and gloss"),
        ("--area", a.area != NormalArea::Macro, &[Kind::Gloss], "gloss"),
        (
            "--smoothness",
            a.smoothness.is_some(),
            heights,
            "height, occlusion and cones, when heights are computed from normals",
        ),
        (
            "--occlusion-distance",
            a.occlusion_distance.is_some(),
            &[Kind::Occlusion, Kind::Cones],
            "occlusion and cones",
        ),
        ("--classes", a.classes != ClassCount::Exactly(1), &[Kind::Leadr], "leadr"),
        ("--texels", a.texels != Texels::Facets, &[Kind::Gloss], "gloss"),
        ("--gloss-scale", a.gloss_scale != Gloss::Perceptual && !has_gloss, &[Kind::Gloss], "gloss and --gloss"),
    ] {
        if is_given && !a.kind.iter().any(|kind| kinds.contains(kind)) {
            return Err(AppError::Usage(format!("{flag} is for --kind {for_what}: leave it out")));
        }
    }
    Ok(())
}

/// The largest relative error of the channels of a class that blocks may have.
const BLOCKS_OF_CLASSES: f64 = 0.03;

/// Returns the error of the classes on the worst level, if it is too large for blocks.
fn classes_beyond_blocks(precision: Precision, baked: &Report) -> Option<f64> {
    let worst = baked.errors.iter().map(|error| error.classes).fold(0.0, f64::max);
    (precision == Precision::Bc && worst > BLOCKS_OF_CLASSES).then_some(worst)
}

/// Relative error of a channel that is not stored in any useful way.
const LOST: f64 = 0.5;

/// Returns a warning if a channel is lost, or if the error of the slope variance exceeds the limit for pictures.
fn beyond_the_goal(precision: Precision, baked: &Report) -> Option<String> {
    let (most, remedy) = match precision {
        Precision::F32 => return None,
        Precision::F16 => (1e-3, "use --format f32"),
        Precision::Bc => (1e-2, "--format f16 is closer"),
    };
    let name = precision.name();
    if let Some(level) = baked.errors.iter().position(|error| error.channels > LOST) {
        return Some(format!("warning: {name} cannot hold the range of a channel on level {level}: use --format f32"));
    }
    let finite =
        baked.errors.iter().map(|error| error.variance).enumerate().filter(|(_, variance)| variance.is_finite());
    let (level, worst) = finite.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (worst > most).then(|| {
        format!("warning: {name} has an error of {worst:.1e} in the slope variance of level {level}, over {most:.0e}: {remedy}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::bake::LevelError;

    #[test]
    fn large_losses_are_reported() {
        let error = |variance| LevelError { channels: 0.1, variance, classes: 0.0 };
        let report = |errors: &[f64]| Report {
            levels: Vec::new(),
            mean_slope: [0.0; 2],
            slope_variance: [0.0; 3],
            slope_range: [[0.0; 2]; 2],
            height_range: [0.0; 2],
            channel_ranges: Vec::new(),
            errors: errors.iter().map(|&v| error(v)).collect(),
        };
        let steep = report(&[2e-4, 2e-3, 1e-3]);
        let message = beyond_the_goal(Precision::F16, &steep).unwrap();
        assert!(
            message.contains("2.0e-3") && message.contains("level 1") && message.contains("--format f32"),
            "{message}"
        );
        assert_eq!(beyond_the_goal(Precision::Bc, &steep), None);
        assert_eq!(beyond_the_goal(Precision::F32, &report(&[1.0])), None);
        let lost = Report { errors: vec![LevelError { channels: 1.0, ..LevelError::default() }], ..report(&[]) };
        assert!(beyond_the_goal(Precision::F16, &lost).unwrap().contains("f16 cannot hold the range of a channel"));
        let classes = |classes| Report { errors: vec![LevelError { classes, ..LevelError::default() }], ..report(&[]) };
        assert_eq!(classes_beyond_blocks(Precision::Bc, &classes(0.05)), Some(0.05));
        assert_eq!(classes_beyond_blocks(Precision::Bc, &classes(0.01)), None);
        assert_eq!(classes_beyond_blocks(Precision::F16, &classes(0.05)), None);
        // A flat level has no variance, so its relative error is infinite and ignored.
        assert_eq!(beyond_the_goal(Precision::F16, &report(&[f64::INFINITY])), None);
    }
}
