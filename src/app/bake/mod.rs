//! `leadr bake`: heights, normals or the folder of a material become filtered maps with all mip levels.

pub mod args;
mod report;
mod sources;

use std::time::Instant;

use self::args::{BakeArgs, Format};
use self::report::BakeReport;
use self::sources::Sources;
use crate::app::error::AppError;
use crate::app::files::{extension, make_folder_of};
use crate::app::output::Output;
use crate::lab::progress::Progress;
use crate::maps::bake::{ExrFile, Kind, Ktx2File, Layout, Plan, Precision, Report, bake};
use crate::maps::save::NewFile;

/// Texels from which a bar is shown: smaller maps take less than a second.
const LONG: u64 = 1 << 20;

/// Where the result goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Container {
    Ktx2,
    Exr,
}

/// Bakes a map and prints what it is like.
///
/// # Errors
/// [`AppError::Usage`] if flags do not go together; [`AppError::Failed`] if a file is damaged, sizes differ, or the result cannot be
/// written.
pub fn run(arguments: &BakeArgs, output: &Output) -> Result<(), AppError> {
    let start = Instant::now();
    let container = match extension(&arguments.output).as_deref() {
        Some("ktx2") => Container::Ktx2,
        Some("exr") => Container::Exr,
        _ => return Err(AppError::Usage(format!("'{}' must end in .ktx2 or .exr", arguments.output.display()))),
    };
    let precision = match arguments.format {
        Format::F32 => Precision::F32,
        Format::F16 => Precision::F16,
        Format::Bc if container == Container::Exr => {
            return Err(AppError::Usage("--format bc is for .ktx2; an .exr holds --format f32 or f16".into()));
        }
        Format::Bc => Precision::Bc,
    };
    let (kind, layout) = (Kind::from(arguments.kind), Layout::from(arguments.layout));
    if layout == Layout::Oiio {
        if container != Container::Exr || kind != Kind::Leadr {
            return Err(AppError::Usage("--layout oiio is an .exr of --kind leadr".into()));
        }
        if arguments.roughness.is_some() || arguments.gloss.is_some() || arguments.color.is_some() {
            let what =
                "--layout oiio has six channels for heights and slopes, none for --roughness, --gloss or --color";
            return Err(AppError::Usage(what.into()));
        }
    }
    // Before any work: a folder that refuses the result is found at once.
    make_folder_of(&arguments.output)?;
    let mut file = NewFile::create(&arguments.output)?;
    let sources = Sources::find(arguments, layout == Layout::Oiio)?;
    for remark in &sources.remarks {
        output.say(remark);
    }
    let inputs = sources.load(arguments)?;
    let plan = Plan::new(&inputs, kind, layout, precision).map_err(|fault| fault.in_file(sources.main()))?;
    let agreement = inputs.agreement();
    if let Some(agreement) = &agreement {
        output.say(&format!("heights and normals: {agreement}"));
    }
    let long = u64::from(plan.size[0]) * u64::from(plan.size[1]) >= LONG;
    let progress = output.share(long.then_some("baking"));
    let written: Result<Report, _> = match container {
        Container::Ktx2 => (|| {
            let mut target = Ktx2File::new(&mut file.file, &plan)?;
            let report = bake(&inputs, &plan, &mut target, &*progress)?;
            target.finish(&report)?;
            Ok(report)
        })(),
        Container::Exr => (|| {
            let mut target = ExrFile::new(&plan)?;
            let report = bake(&inputs, &plan, &mut target, &*progress)?;
            target.finish(&mut file.file, &report)?;
            Ok(report)
        })(),
    };
    drop(progress);
    let baked = written.map_err(|fault: crate::maps::MapFault| fault.in_file(&arguments.output))?;
    if let Some(warning) = beyond_the_goal(precision, &baked) {
        output.say(&warning);
    }
    let bytes = file.file.metadata().map_or(0, |metadata| metadata.len());
    file.finish()?;
    output.result(&BakeReport::new(arguments, &sources, &plan, &baked, agreement, bytes, start.elapsed()))
}

/// Says so if a level loses more of the variance than pictures may of themselves.
fn beyond_the_goal(precision: Precision, baked: &Report) -> Option<String> {
    let (most, remedy) = match precision {
        Precision::F32 => return None,
        Precision::F16 => (1e-3, "--format f32 keeps it"),
        Precision::Bc => (1e-2, "--format f16 keeps more"),
    };
    let finite =
        baked.errors.iter().map(|error| error.variance).enumerate().filter(|(_, variance)| variance.is_finite());
    let (level, worst) = finite.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let name = precision.name();
    (worst > most).then(|| {
        format!("warning: {name} loses {worst:.1e} of the variance of slopes on level {level}, and should not lose {most:.0e}: {remedy}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::bake::LevelError;

    #[test]
    fn what_loses_much_is_told() {
        let error = |variance| LevelError { channels: 0.1, variance };
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
        let said = beyond_the_goal(Precision::F16, &steep).unwrap();
        assert!(said.contains("2.0e-3") && said.contains("level 1") && said.contains("--format f32"), "{said}");
        assert_eq!(beyond_the_goal(Precision::Bc, &steep), None);
        assert_eq!(beyond_the_goal(Precision::F32, &report(&[1.0])), None);
        // Nothing is lost of what is flat.
        assert_eq!(beyond_the_goal(Precision::F16, &report(&[f64::INFINITY])), None);
    }
}
