//! The result that `leadr fit` prints.

use std::fmt;
use std::path::PathBuf;

use glam::DVec3;
use serde::Serialize;

use super::export::{Renderer, is_round};
use leadr_maps::shown::{shown, shown_path};
use leadr_measured::fit_file::masking_name;
use leadr_reflectance::extraction::fit::{Extraction, Fit, FitOptions};
use leadr_reflectance::extraction::power_iteration::Backscattering;
use leadr_reflectance::extraction::samples::Misfit;
use leadr_reflectance::facets::ellipse::{bivariate_from_roughness, ellipse_from_roughness};
use leadr_reflectance::facets::gaussian_mixture::Lobe;
use leadr_reflectance::facets::parametric_curve::ParametricCurve;
use leadr_tools::fit::spheres::SphereError;

/// A fitted material.
#[derive(Debug, Serialize)]
pub struct FitReport {
    command: &'static str,
    input: PathBuf,
    pub database: String,
    isotropic: bool,
    extraction: &'static str,
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
    /// The shifted gamma curve and the ABC curve that are nearest to the slopes; null for anisotropic materials.
    curves: Option<[CurveReport; 2]>,
    /// The misfits of this fit and of the two fits of backscattering, over all measured directions.
    misfit: MisfitReport,
    slice_misfit: MisfitReport,
    thesis_misfit: MisfitReport,
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
    rrmse: f64,
    cube_root_rrmse: f64,
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
    pub fn new(
        input: PathBuf,
        database: String,
        isotropic: bool,
        options: &FitOptions,
        fit: &Fit,
        seconds: Seconds,
    ) -> Self {
        let lobe = |lobe: &Lobe| LobeReport { share: lobe.share, roughness: Roughness::of(2.0 * lobe.covariance) };
        Self {
            command: "fit",
            input,
            database,
            isotropic,
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
            curves: fit.curves.map(|curves| curves.map(CurveReport::from)),
            misfit: fit.misfit.into(),
            slice_misfit: fit.slice_misfit.into(),
            thesis_misfit: fit.thesis_misfit.into(),
            exports: Vec::new(),
            spheres: Vec::new(),
            seconds,
            files: Vec::new(),
        }
    }
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
