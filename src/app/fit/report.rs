//! The result that `leadr fit` prints.

use std::fmt;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Serialize;

use super::export::{Renderer, is_round};
use super::folder::FailedFile;
use leadr_maps::shown::{shown, shown_path};
use leadr_measured::Measured;
use leadr_measured::fit_file::masking_name;
use leadr_reflectance::extraction::fit::{Extraction, Fit, FitOptions};
use leadr_reflectance::extraction::lobes::LobeErrors;
use leadr_reflectance::extraction::power_iteration::Backscattering;
use leadr_reflectance::extraction::samples::{Misfit, Sample, misfit};
use leadr_reflectance::facets::ellipse::{bivariate_from_roughness, ellipse_from_roughness};
use leadr_reflectance::facets::gaussian_mixture::Lobe;
use leadr_reflectance::facets::parametric_curve::ParametricCurve;
use leadr_reflectance::materials::fitted_table::FittedTable;
use leadr_reflectance::materials::shifted_gamma::ShiftedGammaChannel;
use leadr_tools::csv::quoted;
use leadr_tools::fit::models::{Models, NAMES};
use leadr_tools::fit::spheres::SphereError;

/// A fitted material.
#[derive(Debug, Serialize)]
pub struct FitReport {
    command: &'static str,
    pub input: PathBuf,
    pub database: String,
    isotropic: bool,
    pub extraction: &'static str,
    masking: &'static str,
    /// The masking model that the fit used for backscattering.
    backscattering: &'static str,
    /// The roughness of the slopes from backscattering alone, for a Beckmann and for a GGX distribution.
    pub beckmann: Roughness,
    pub ggx: Roughness,
    /// The luminance of F0 from backscattering alone.
    extracted_f0: f64,
    iterations: u32,
    /// The F0 and the diffuse albedo of the fitted material, in linear RGB.
    pub f0: [f64; 3],
    pub diffuse: [f64; 3],
    lobes: Vec<LobeReport>,
    pub bytes: Bytes,
    /// The errors of the fit with 1 to 8 lobes. The list is empty unless it was requested.
    pub lobe_errors: Vec<LobeErrorReport>,
    /// The shifted gamma curve and the ABC curve that are nearest to the slopes; null for anisotropic materials.
    curves: Option<[CurveReport; 2]>,
    /// The misfits of this fit and of the two fits of backscattering, over all measured directions.
    misfit: MisfitReport,
    slice_misfit: MisfitReport,
    thesis_misfit: MisfitReport,
    /// The fits of the SGD and ABC models. The list is empty if no spheres were drawn.
    pub published: Vec<PublishedReport>,
    /// The misfits of the exports to other renderers.
    pub exports: Vec<ExportReport>,
    /// The errors of the rendered spheres. The list is empty if no spheres were drawn.
    pub spheres: Vec<SphereReport>,
    pub seconds: Seconds,
    pub files: Vec<PathBuf>,
}

/// The axes of a roughness matrix.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Roughness {
    /// The geometric mean of `alpha_x` and `alpha_y`.
    pub alpha: f64,
    pub alpha_x: f64,
    pub alpha_y: f64,
    pub rho: f64,
    /// The angle of the larger half-axis from the x axis, in degrees.
    pub rotation_degrees: f64,
}

#[derive(Debug, Serialize)]
struct LobeReport {
    share: f64,
    #[serde(flatten)]
    roughness: Roughness,
}

/// A two-parameter slope distribution.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(tag = "family", rename_all = "snake_case")]
enum CurveReport {
    ShiftedGamma { alpha: f64, p: f64 },
    Abc { b: f64, c: f64 },
}

impl From<ParametricCurve> for CurveReport {
    fn from(curve: ParametricCurve) -> Self {
        match curve {
            ParametricCurve::ShiftedGamma { alpha, p } => Self::ShiftedGamma { alpha, p },
            ParametricCurve::Abc { b, c } => Self::Abc { b, c },
        }
    }
}

impl fmt::Display for CurveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShiftedGamma { alpha, p } => write!(f, "shifted gamma α {alpha:.4}, p {p:.3}"),
            Self::Abc { b, c } => write!(f, "ABC B {b:.4}, C {c:.3}"),
        }
    }
}

/// The misfit of the material that is exported to a renderer.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExportReport {
    pub renderer: Renderer,
    pub misfit: MisfitReport,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct MisfitReport {
    pub rrmse: f64,
    pub cube_root_rrmse: f64,
    divergence: f64,
}

/// The error of a sphere relative to the sphere with the measured material.
#[derive(Clone, Debug, Serialize)]
pub struct SphereReport {
    pub material: &'static str,
    #[serde(flatten)]
    pub error: SphereError,
}

/// The duration of each step in seconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    pub reading: f64,
    /// The duration of the power iteration, and of computing tables from its result.
    pub slopes: f64,
    pub fresnel: f64,
    pub refinement: f64,
    pub lobes: f64,
    pub picture: f64,
}

/// The sizes of a fit in bytes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Bytes {
    /// The numbers that the renderer uploads.
    renderer: u64,
    /// The tables of the thesis (4.3) with as many angles: the Fresnel term, slopes, masking and quantiles, in 32 bits.
    thesis: u64,
    /// The JSON file.
    pub file: u64,
}

impl Bytes {
    fn of(fit: &Fit) -> Self {
        let (angles, azimuths) = fit.fitted.facets.distribution.nodes();
        // The thesis has 6 N numbers if isotropic, and 3 N_θ (1 + N_φ) numbers otherwise.
        let numbers = 3 * angles * (1 + azimuths);
        let renderer = FittedTable::new(&fit.fitted, &fit.lobes, 1.0).words().len();
        Self { renderer: 4 * renderer as u64, thesis: 4 * numbers as u64, file: 0 }
    }
}

/// The error of a fit with Gaussian lobes in place of its table.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LobeErrorReport {
    /// The requested number of lobes. Lobes of negligible weight are left out.
    pub lobes: usize,
    found: usize,
    /// The divergence of the lobes from the slopes of the table, in nats.
    #[serde(rename = "slope_divergence")]
    pub slopes: f64,
    pub misfit: MisfitReport,
}

impl LobeErrorReport {
    pub fn new(count: usize, errors: &LobeErrors) -> Self {
        Self { lobes: count, found: errors.lobes.len(), slopes: errors.slopes, misfit: errors.misfit.into() }
    }
}

/// A fit of a published model.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "model")]
pub enum PublishedReport {
    #[serde(rename = "SGD")]
    ShiftedGamma {
        /// The parameters of red, green and blue.
        channels: [ShiftedGammaReport; 3],
        misfit: MisfitReport,
    },
    #[serde(rename = "ABC")]
    Abc { diffuse: [f64; 3], a: [f64; 3], b: f64, c: f64, index: f64, misfit: MisfitReport },
}

/// The parameters of a channel of SGD.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ShiftedGammaReport {
    alpha: f64,
    p: f64,
    diffuse: f64,
    specular: f64,
    f0: f64,
    f1: f64,
}

impl From<ShiftedGammaChannel> for ShiftedGammaReport {
    fn from(channel: ShiftedGammaChannel) -> Self {
        let ShiftedGammaChannel { alpha, p, diffuse, specular, fresnel: [f0, f1] } = channel;
        Self { alpha, p, diffuse, specular, f0, f1 }
    }
}

/// Returns the parameters and misfits of the published models.
pub fn published_reports(models: &Models, samples: &[Sample]) -> Vec<PublishedReport> {
    let shifted_gamma = models.shifted_gamma.as_ref().map(|model| PublishedReport::ShiftedGamma {
        channels: model.channels().map(ShiftedGammaReport::from),
        misfit: misfit(samples, model).into(),
    });
    let abc = models.abc.as_ref().map(|model| PublishedReport::Abc {
        diffuse: model.diffuse.to_array(),
        a: model.a.to_array(),
        b: model.b,
        c: model.c,
        index: model.index,
        misfit: misfit(samples, model).into(),
    });
    shifted_gamma.into_iter().chain(abc).collect()
}

impl From<Misfit> for MisfitReport {
    fn from(misfit: Misfit) -> Self {
        Self { rrmse: misfit.rrmse, cube_root_rrmse: misfit.perceptual, divergence: misfit.divergence }
    }
}

impl Roughness {
    pub fn of(a: DVec3) -> Self {
        let (bivariate, ellipse) = (bivariate_from_roughness(a), ellipse_from_roughness(a));
        let round = is_round(&ellipse);
        Self {
            alpha: (bivariate.alpha.x * bivariate.alpha.y).sqrt(),
            alpha_x: bivariate.alpha.x,
            alpha_y: bivariate.alpha.y,
            rho: if round { 0.0 } else { bivariate.rho },
            rotation_degrees: if round { 0.0 } else { ellipse.angle.to_degrees() },
        }
    }
}

const fn backscattering_name(kind: Backscattering) -> &'static str {
    match kind {
        Backscattering::Smith => "smith",
        Backscattering::SmithRendered => "smith-rendered",
        Backscattering::VGroove => "vgroove",
        Backscattering::NormalMap => "normal-map",
    }
}

const fn extraction_name(extraction: Extraction) -> &'static str {
    match extraction {
        Extraction::Refined => "refined",
        Extraction::Slice => "slice",
        Extraction::Thesis => "thesis",
    }
}

impl FitReport {
    pub fn new(input: PathBuf, measured: &Measured, options: &FitOptions, fit: &Fit, seconds: Seconds) -> Self {
        let lobe = |lobe: &Lobe| LobeReport { share: lobe.share, roughness: Roughness::of(2.0 * lobe.covariance) };
        Self {
            command: "fit",
            input,
            database: measured.description(),
            isotropic: measured.is_isotropic(),
            extraction: extraction_name(options.extraction),
            masking: masking_name(options.hiding.masking()),
            backscattering: backscattering_name(fit.backscattering),
            beckmann: Roughness::of(fit.beckmann),
            ggx: Roughness::of(fit.ggx),
            extracted_f0: fit.extracted.reflectance,
            iterations: fit.extracted.iterations,
            f0: fit.fitted.facets.fresnel.at(1.0).to_array(),
            diffuse: fit.fitted.diffuse.to_array().map(|c| if c < 1e-6 { 0.0 } else { c }),
            lobes: fit.lobes.iter().map(lobe).collect(),
            bytes: Bytes::of(fit),
            lobe_errors: Vec::new(),
            curves: fit.curves.map(|curves| curves.map(CurveReport::from)),
            misfit: fit.misfit.into(),
            slice_misfit: fit.slice_misfit.into(),
            thesis_misfit: fit.thesis_misfit.into(),
            published: Vec::new(),
            exports: Vec::new(),
            spheres: Vec::new(),
            seconds,
            files: Vec::new(),
        }
    }
}

impl FitReport {
    /// Returns the results in one line, without the files.
    pub fn line(&self) -> String {
        let name = self.input.file_name().map(Path::new).unwrap_or(&self.input);
        let mut line = format!("{}: GGX {}; relative RMSE", shown_path(name), self.ggx);
        for (name, wrong) in
            [(self.extraction, self.misfit), ("slice", self.slice_misfit), ("thesis", self.thesis_misfit)]
        {
            line.push_str(&format!(" {name} {:.3},", wrong.rrmse));
        }
        line.pop();
        if let Some(sphere) = self.spheres.first() {
            line.push_str(&format!("; ΔE₀₀ {:.2}", sphere.error.delta_e));
        }
        line
    }
}

/// The columns before the spheres.
const COLUMNS: [&str; 24] = [
    "file",
    "fault",
    "database",
    "isotropic",
    "extraction",
    "beckmann_alpha",
    "ggx_alpha",
    "f0_r",
    "f0_g",
    "f0_b",
    "diffuse_r",
    "diffuse_g",
    "diffuse_b",
    "lobes",
    "rrmse",
    "cube_root_rrmse",
    "slice_rrmse",
    "slice_cube_root_rrmse",
    "thesis_rrmse",
    "thesis_cube_root_rrmse",
    "renderer_bytes",
    "thesis_bytes",
    "file_bytes",
    "fit_seconds",
];

/// Returns a table with one line per material, followed by one line per file without a fit. Numbers that a file lacks are empty.
pub fn csv(reports: &[FitReport], failed: &[FailedFile]) -> String {
    let name = |file: &Path| quoted(&shown(&file.file_name().unwrap_or_default().to_string_lossy()));
    let spheres = NAMES.map(|name| name.to_ascii_lowercase());
    let spheres = spheres.iter().flat_map(|name| ["rrmse", "delta_e_2000"].map(|what| format!("{name}_sphere_{what}")));
    let head: Vec<String> = COLUMNS.map(str::to_owned).into_iter().chain(spheres).collect();
    let fit = |report: &FitReport| {
        let mut fields = vec![name(&report.input), String::new(), quoted(&shown(&report.database))];
        fields.extend([report.isotropic.to_string(), report.extraction.to_owned()]);
        let misfits = [report.misfit, report.slice_misfit, report.thesis_misfit];
        let numbers = [report.beckmann.alpha, report.ggx.alpha].into_iter().chain(report.f0).chain(report.diffuse);
        fields.extend(numbers.map(|number| number.to_string()));
        fields.push(report.lobes.len().to_string());
        fields.extend(misfits.iter().flat_map(|misfit| [misfit.rrmse, misfit.cube_root_rrmse]).map(|e| e.to_string()));
        let Bytes { renderer, thesis, file } = report.bytes;
        fields.extend([renderer, thesis, file].map(|bytes| bytes.to_string()));
        let Seconds { slopes, fresnel, refinement, lobes, .. } = report.seconds;
        fields.push((slopes + fresnel + refinement + lobes).to_string());
        for name in NAMES {
            let sphere = report.spheres.iter().find(|sphere| sphere.material == name);
            let errors = sphere.map(|sphere| [sphere.error.rrmse, sphere.error.delta_e].map(|e| e.to_string()));
            fields.extend(errors.unwrap_or_default());
        }
        fields
    };
    let fault = |FailedFile { file, fault }: &FailedFile| {
        let mut fields = vec![name(file), quoted(&shown(fault))];
        fields.resize(head.len(), String::new());
        fields
    };
    let rows = reports.iter().map(fit).chain(failed.iter().map(fault));
    [head.clone()].into_iter().chain(rows).map(|fields| fields.join(",") + "\n").collect()
}

impl fmt::Display for Roughness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if (self.alpha_x - self.alpha_y).abs() < 1e-6 * self.alpha && self.rho.abs() < 1e-6 {
            write!(f, "α {:.4}", self.alpha)
        } else {
            write!(f, "α {:.4} x {:.4}, ρ {:.3}", self.alpha_x, self.alpha_y, self.rho)
        }
    }
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rgb = |c: [f64; 3]| format!("{:.3} {:.3} {:.3}", c[0], c[1], c[2]);
        let symmetry = if self.isotropic { "isotropic" } else { "anisotropic" };
        writeln!(f, "{} ({}), {symmetry}", shown_path(&self.input), shown(&self.database))?;
        writeln!(f, "  slopes from backscattering: Beckmann {}; GGX {}", self.beckmann, self.ggx)?;
        writeln!(f, "  F0 {}, diffuse {}", rgb(self.f0), rgb(self.diffuse))?;
        for lobe in &self.lobes {
            writeln!(f, "  lobe: {:4.1} % of the facets, {}", 100.0 * lobe.share, lobe.roughness)?;
        }
        if let Some([gamma, abc]) = &self.curves {
            writeln!(f, "  other curves: {gamma}; {abc}")?;
        }
        write!(f, "  all directions:")?;
        for (name, wrong) in
            [(self.extraction, self.misfit), ("slice", self.slice_misfit), ("thesis", self.thesis_misfit)]
        {
            write!(f, "\n    {name}: relative RMSE {:.3}, of cube roots {:.3}", wrong.rrmse, wrong.cube_root_rrmse)?;
        }
        let Bytes { renderer, thesis, file } = self.bytes;
        write!(f, "\n  bytes: {renderer} in the renderer, {file} in a file (tables of the thesis: {thesis})")?;
        for LobeErrorReport { lobes, slopes, misfit: MisfitReport { rrmse, cube_root_rrmse, .. }, .. } in
            &self.lobe_errors
        {
            write!(f, "\n  with {lobes} lobes: relative RMSE {rrmse:.4}, of cube roots {cube_root_rrmse:.4}")?;
            write!(f, ", divergence of the slopes {slopes:.2e}")?;
        }
        for ExportReport { renderer, misfit } in &self.exports {
            let (rrmse, roots) = (misfit.rrmse, misfit.cube_root_rrmse);
            write!(f, "\n  for {renderer}: relative RMSE {rrmse:.3}, of cube roots {roots:.3}")?;
        }
        for SphereReport { material, error: SphereError { rrmse, delta_e } } in &self.spheres {
            write!(f, "\n  sphere, {material}: relative RMSE {rrmse:.4}, ΔE₀₀ {delta_e:.2}")?;
        }
        for file in &self.files {
            write!(f, "\n  {}", shown_path(file))?;
        }
        Ok(())
    }
}
