//! Arguments of `leadr fit`.

use std::path::PathBuf;

use clap::Args;

use crate::app::flags::scene::{Names, one_of};
use leadr_reflectance::extraction::fit::Extraction;
use leadr_reflectance::extraction::power_iteration::Backscattering;
use leadr_reflectance::facets::gaussian_mixture::{DRAWN_LOBES, MOST_LOBES};
use leadr_render::settings::numbers::whole;

/// Examples that are printed after the help text.
pub const EXAMPLES: &str = "Examples:
  leadr fit gold.binary -o gold.json                       fit a material of the MERL database
  leadr fit paper_white_rgb.bsdf -o paper.json --page paper.html   also compare the fit with the measurement
  leadr fit fabric106.bin -o fabric.json                   fit an anisotropic material of the UTIA database
  leadr fit gold.binary --masking vgroove --json           print the numbers only
  leadr fit gold.binary --extraction thesis                use the Fresnel term of the thesis
  leadr fit merl -o fits --csv fits.csv --page fits.html   fit every material of a folder
  leadr fit gold.binary --mitsuba gold.xml --pbrt gold.pbrt
  leadr fit paper_white_rgb.bsdf --export paper.binary     for BRDF Explorer and other viewers of MERL files
  leadr capture --scene sphere --material gold.json        draw the fitted material

A .csv file has one line per pair of half and difference angles: theta_h,theta_d[,phi_d],r,g,b. A .csv file of backscattering
alone has lines theta,r,g,b. Angles are in degrees, and r,g,b are the BRDF f_r per steradian.";

/// Arguments of `leadr fit`.
#[derive(Clone, Debug, Args)]
pub struct FitArgs {
    /// A measured material: a MERL .binary, an RGL .bsdf, a UTIA .bin, a .csv or a .pfm file; or a folder of such files
    #[arg(value_name = "FILE|FOLDER")]
    pub input: PathBuf,
    /// Set the masking model of the facets
    #[arg(long, value_name = "HOW", value_parser = one_of(MASKINGS), default_value = "smith")]
    pub masking: Backscattering,
    /// Sample backscattering at N angles from the normal
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = |text: &str| whole(text, 8_u32, 720))]
    pub angles: u32,
    /// Sample an anisotropic material at N azimuths
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = |text: &str| whole(text, 8_u32, 360))]
    pub azimuths: u32,
    /// Approximate the slope distribution by up to N Gaussian lobes; the renderer draws at most 4
    #[arg(long, value_name = "N", default_value_t = DRAWN_LOBES as u32, value_parser = |text: &str| whole(text, 1, MOST_LOBES as u32))]
    pub lobes: u32,
    /// Set how the facets are extracted
    #[arg(long, value_name = "HOW", value_parser = one_of(EXTRACTIONS), default_value = "refined")]
    extraction: Extraction,
    /// The same as --extraction slice
    #[arg(long, hide = true, conflicts_with = "extraction")]
    backscattering_only: bool,
    /// Also compute the errors of the fit with 1 to 8 Gaussian lobes
    #[arg(long)]
    pub lobe_errors: bool,
    /// Write the fitted material to this file; other commands read the file with --material. For a folder, write NAME.json to this folder
    #[arg(long, short, value_name = "FILE.json|FOLDER")]
    pub output: Option<PathBuf>,
    /// Write a table with one line per material
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Draw spheres in the same light: the measurement, the fit, the fits of --extraction slice and thesis, GGX and Beckmann with the same roughness, and fits of the SGD and ABC models. A folder has one row per material
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// Draw the colour difference ΔE of each model's sphere from the measured one, as the mean over all materials: black is 0, yellow is 20
    #[arg(long, value_name = "FILE.png")]
    pub delta_e: Option<PathBuf>,
    /// Write a page that shows the spheres, their errors and cross sections of the lobes; the picture is the one of --picture, else a new FILE.png
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// Export the closest Mitsuba 3 material to this file
    #[arg(long, value_name = "FILE.xml")]
    pub mitsuba: Option<PathBuf>,
    /// Export the closest pbrt-v4 material to this file
    #[arg(long, value_name = "FILE.pbrt")]
    pub pbrt: Option<PathBuf>,
    /// Export the fit at the angles of a MERL file (.binary), as a file of the RGL database for the measured materials of Mitsuba and pbrt (.bsdf), or its slice at φ_d = 90° as a 90 x 90 picture of floats (.pfm)
    #[arg(long, value_name = "FILE.binary|FILE.bsdf|FILE.pfm")]
    pub export: Option<PathBuf>,
}

impl FitArgs {
    /// Returns the requested extraction.
    pub fn extraction(&self) -> Extraction {
        if self.backscattering_only { Extraction::Slice } else { self.extraction }
    }
}

const EXTRACTIONS: Names<Extraction> = &[
    ("refined", Extraction::Refined, "Slopes, Fresnel term and diffuse base from all directions"),
    ("slice", Extraction::Slice, "Slopes from backscattering, Fresnel term from the slice φ_d = 90° and at most 1"),
    (
        "thesis",
        Extraction::Thesis,
        "Slopes from backscattering, Fresnel term from all directions (algorithm 2), which may exceed 1",
    ),
];

const MASKINGS: Names<Backscattering> = &[
    ("smith", Backscattering::Smith, "Smith's masking"),
    ("vgroove", Backscattering::VGroove, "V-groove masking"),
    ("normal-map", Backscattering::NormalMap, "No masking, as on a normal map"),
];
