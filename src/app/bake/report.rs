//! The result that `leadr bake` prints.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use super::sources::Sources;
use leadr_maps::bake::{FoundClasses, Layout, Plan, Report};
use leadr_maps::derive::quantisation::Quantisation;
use leadr_maps::material::Agreement;
use leadr_maps::shown::shown_path;
use leadr_reflectance::masking::classes::Class;
use leadr_tools::program::memory_of_process;

/// The result for a map.
#[derive(Debug, Serialize)]
pub struct BakeReport {
    command: &'static str,
    output: PathBuf,
    sources: Sources,
    kind: &'static str,
    format: &'static str,
    layout: &'static str,
    size: [u32; 2],
    levels: usize,
    /// The number of finest levels that the file leaves out.
    dropped_levels: usize,
    channels: Vec<&'static str>,
    /// The factor on the heights.
    height_scale: f32,
    /// Whether heights are in texture widths.
    #[serde(skip)]
    in_widths: bool,
    mean_slope: [f64; 2],
    /// The slope variances along s and t, and the covariance of both slopes, per unit of texture coordinate.
    slope_variance: [f64; 3],
    slope_range: [[f64; 2]; 2],
    height_range: [f64; 2],
    /// The agreement of heights and normals; null unless the input has both.
    agreement: Option<AgreementReport>,
    /// The shares of the slope variance that come from coarse codes; null if the heights are fine or are kept as read.
    quantisation: Option<QuantisationReport>,
    /// How far the relief is from one Gaussian, and its classes; null for other kinds than leadr.
    classes: Option<ClassesReport>,
    /// The bytes of a texel in memory.
    bytes_per_texel: usize,
    /// The error of the worst channel relative to 32-bit floats, for each level.
    error: Vec<f64>,
    /// The relative error of the slope variance, for each level.
    variance_error: Vec<f64>,
    bytes: u64,
    seconds: f64,
    /// The peak memory of the program in bytes, or null if the system does not report it.
    peak_bytes: Option<u64>,
}

#[derive(Debug, Serialize)]
struct ClassesReport {
    /// The number of classes in the file.
    stored: usize,
    /// The relative RMS error of reflections for 1, 2, … classes.
    reflection_error: Vec<f64>,
    /// The classes that suit the relief. Slopes are rise over run.
    found: Vec<ClassReport>,
    /// The relative error of the worst channel of a class, for each level.
    error: Vec<f64>,
}

#[derive(Debug, Serialize)]
struct ClassReport {
    share: f64,
    mean_slope: [f64; 2],
    /// The standard deviations of the slopes along s and t.
    slope_deviation: [f64; 2],
    height: f64,
    height_deviation: f64,
    /// Words for the slopes and the height.
    description: String,
}

impl ClassesReport {
    fn new(found: &FoundClasses, baked: &Report, stored: usize) -> Self {
        let classes = found.sampled();
        let height = classes.iter().map(|class| class.share * class.height).sum::<f64>();
        let square = |class: &Class| class.share * (class.height_variance + (class.height - height).powi(2));
        let deviation = classes.iter().map(square).sum::<f64>().sqrt();
        let one = |class: &Class| {
            let c = class.covariance;
            let steepness = (class.mean.length_squared() + c.x + c.y).sqrt();
            let slope = ["flat", "gentle", "steep"][usize::from(steepness > 0.1) + usize::from(steepness > 0.6)];
            let above = (class.height - height) / deviation;
            let level = if above > 0.5 {
                ", high"
            } else if above < -0.5 {
                ", low"
            } else {
                ""
            };
            ClassReport {
                share: class.share,
                mean_slope: class.mean.to_array(),
                slope_deviation: [c.x, c.y].map(|variance| variance.max(0.0).sqrt()),
                height: class.height,
                height_deviation: class.height_variance.max(0.0).sqrt(),
                description: format!("{slope}{level}"),
            }
        };
        Self {
            stored,
            reflection_error: found.errors().to_vec(),
            found: classes.iter().map(one).collect(),
            error: baked.errors.iter().map(|error| error.classes).collect(),
        }
    }
}

impl fmt::Display for ClassesReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let errors: Vec<String> = self.reflection_error.iter().map(|error| format!("{:.0}", 100.0 * error)).collect();
        write!(f, "classes         reflections err by {} %", errors[0])?;
        if errors.len() > 1 {
            write!(f, " with one Gaussian, and by {} % with 2 to {} classes", errors[1..].join(", "), errors.len())?;
        }
        match (self.stored, self.found.len()) {
            (1, 1) => return writeln!(f, "; one class suits the relief"),
            (1, count) => writeln!(f, "; --classes auto stores these {count}:")?,
            (count, _) => writeln!(f, "; the file has {count}:")?,
        }
        for (k, class) in self.found.iter().enumerate() {
            let ([x, y], [dx, dy]) = (class.mean_slope, class.slope_deviation);
            writeln!(
                f,
                "  {}: {:3.0} % {:13} slopes {x:.2} ± {dx:.2} along s, {y:.2} ± {dy:.2} along t; height {:.4} ± {:.4}",
                k + 1,
                100.0 * class.share,
                class.description,
                class.height,
                class.height_deviation
            )?;
        }
        Ok(())
    }
}

#[derive(Debug, Serialize)]
struct AgreementReport {
    correlation: f64,
    scale_texels: f64,
    left_over: f64,
    #[serde(skip)]
    sentence: String,
}

#[derive(Debug, Serialize)]
struct QuantisationReport {
    step: f32,
    share_before: f64,
    share_after: f64,
    #[serde(skip)]
    sentence: String,
}

/// What the height map shows before the bake.
#[derive(Clone, Copy, Debug)]
pub struct HeightFindings {
    /// The agreement with the normals, if there are both.
    pub agreement: Option<Agreement>,
    /// The result of restoring coarse heights.
    pub quantisation: Option<Quantisation>,
}

impl BakeReport {
    pub fn new(
        file: &Path,
        sources: &Sources,
        plan: &Plan,
        baked: &Report,
        heights: HeightFindings,
        classes: Option<&FoundClasses>,
        bytes: u64,
        time: Duration,
    ) -> Self {
        let agreement = heights.agreement.map(|agreed| AgreementReport {
            correlation: agreed.correlation,
            scale_texels: agreed.scale_texels,
            left_over: agreed.left_over,
            sentence: agreed.to_string(),
        });
        Self {
            command: "bake",
            output: file.to_path_buf(),
            sources: sources.clone(),
            kind: plan.kind.name(),
            format: plan.precision.name(),
            layout: if plan.layout == Layout::Oiio { "oiio" } else { "leadr" },
            size: baked.levels[0],
            levels: baked.levels.len(),
            dropped_levels: plan.dropped_levels,
            channels: plan.channels.clone(),
            height_scale: plan.height_scale,
            in_widths: plan.in_widths,
            mean_slope: baked.mean_slope,
            slope_variance: baked.slope_variance,
            slope_range: baked.slope_range,
            height_range: baked.height_range,
            agreement,
            quantisation: heights.quantisation.map(|found| QuantisationReport {
                step: found.step,
                share_before: found.before,
                share_after: found.after,
                sentence: found.to_string(),
            }),
            classes: classes.map(|found| ClassesReport::new(found, baked, plan.stored_classes())),
            bytes_per_texel: plan.bytes_per_texel(),
            error: baked.errors.iter().map(|e| e.channels).collect(),
            variance_error: baked.errors.iter().map(|e| e.variance).collect(),
            bytes,
            seconds: time.as_secs_f64(),
            peak_bytes: memory_of_process("VmHWM:"),
        }
    }
}

impl fmt::Display for BakeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([w, h], [xx, yy, xy], [x, y]) = (self.size, self.slope_variance, self.mean_slope);
        let bytes = self.bytes_per_texel;
        writeln!(f, "{} {w}x{h}, {} levels, {}, {bytes} bytes per texel", self.kind, self.levels, self.format)?;
        if self.dropped_levels > 0 {
            let levels = if self.dropped_levels == 1 { "level" } else { "levels" };
            writeln!(f, "dropped         {} finest {levels}", self.dropped_levels)?;
        }
        writeln!(f, "slope variance  {xx:.6} {yy:.6}, covariance {xy:.6}; mean {x:.6} {y:.6}")?;
        let [[x0, x1], [y0, y1]] = self.slope_range;
        let [low, high] = self.height_range;
        let unit = if self.in_widths { "texture widths" } else { "in the unit of the map" };
        writeln!(
            f,
            "slopes          {x0:.4} to {x1:.4} along s, {y0:.4} to {y1:.4} along t; heights {low:.4} to {high:.4} {unit}"
        )?;
        if let Some(agreement) = &self.agreement {
            writeln!(f, "normals         {}", agreement.sentence)?;
        }
        if let Some(quantisation) = &self.quantisation {
            writeln!(f, "codes           {}", quantisation.sentence)?;
        }
        if let Some(classes) = &self.classes {
            write!(f, "{classes}")?;
        }
        if self.format != "f32" {
            let stored = self.classes.as_ref().filter(|classes| classes.stored > 1);
            writeln!(
                f,
                "level   error     variance error{}",
                if stored.is_some() { "  error of classes" } else { "" }
            )?;
            for (level, (error, variance)) in self.error.iter().zip(&self.variance_error).enumerate() {
                write!(f, "{level:5}   {error:.2e}  {variance:.2e}")?;
                match stored {
                    Some(classes) => writeln!(f, "        {:.2e}", classes.error[level])?,
                    None => writeln!(f)?,
                }
            }
        }
        write!(f, "{} ({} bytes, {:.1} s", shown_path(&self.output), self.bytes, self.seconds)?;
        match self.peak_bytes {
            Some(peak) => write!(f, ", {} MiB of memory)", peak >> 20),
            None => write!(f, ")"),
        }
    }
}

/// The result for several maps of one surface.
#[derive(Debug, Serialize)]
pub struct BakedSet {
    command: &'static str,
    files: Vec<BakeReport>,
    bytes: u64,
    seconds: f64,
}

impl BakedSet {
    pub fn new(files: Vec<BakeReport>, time: Duration) -> Self {
        let bytes = files.iter().map(|file| file.bytes).sum();
        Self { command: "bake", files, bytes, seconds: time.as_secs_f64() }
    }
}

impl fmt::Display for BakedSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.files.iter().try_for_each(|file| writeln!(f, "{file}"))?;
        write!(f, "{} files, {} bytes, {:.1} s", self.files.len(), self.bytes, self.seconds)
    }
}
