//! Arguments of `leadr fit`.

use std::path::PathBuf;

use clap::Args;

use crate::app::flags::scene::{Names, one_of};
use leadr_reflectance::extraction::power_iteration::Backscattering;
use leadr_reflectance::facets::gaussian_mixture::MOST_LOBES;
use leadr_render::settings::numbers::whole;

/// Shown below the help.
pub const EXAMPLES: &str = "Examples:
  leadr fit gold.binary -o gold.json                       of the MERL database
  leadr fit paper_white_rgb.bsdf -o paper.json --page paper.html   with spheres and lobes beside the measured ones
  leadr fit fabric106.bin -o fabric.json                   of the UTIA database, anisotropic
  leadr fit gold.binary --masking vgroove --json           only the numbers
  leadr fit gold.binary --mitsuba gold.xml --pbrt gold.pbrt
  leadr capture --scene sphere --material gold.json        draw with it

A .csv has a line for each pair of half and difference angles, theta_h,theta_d[,phi_d],r,g,b in degrees and f_r, or theta,r,g,b of
what is scattered back.";

/// Arguments of `leadr fit`.
#[derive(Clone, Debug, Args)]
pub struct FitArgs {
    /// A measured material: MERL .binary, RGL .bsdf, UTIA .bin or .csv
    #[arg(value_name = "FILE")]
    pub input: PathBuf,
    /// How facets hide each other
    #[arg(long, value_name = "HOW", value_parser = one_of(MASKINGS), default_value = "smith")]
    pub masking: Backscattering,
    /// Angles at which the material is asked what it scatters back
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = |text: &str| whole(text, 8_u32, 720))]
    pub angles: u32,
    /// Azimuths of an anisotropic material
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = |text: &str| whole(text, 8_u32, 360))]
    pub azimuths: u32,
    /// Gaussian lobes that stand for the slopes
    #[arg(long, value_name = "N", default_value_t = MOST_LOBES as u32, value_parser = |text: &str| whole(text, 1, MOST_LOBES as u32))]
    pub lobes: u32,
    /// Keep what backscattering alone tells (the thesis' fit), without improving it by all other directions
    #[arg(long)]
    pub backscattering_only: bool,
    /// The fitted material, which every command reads as --material
    #[arg(long, short, value_name = "FILE.json")]
    pub output: Option<PathBuf>,
    /// Spheres in one light: measured, fitted, the thesis' fit, GGX and Beckmann of the same roughness
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// A page with the spheres, their errors and cuts through the lobes; its picture lies beside it
    #[arg(long, value_name = "FILE.html", conflicts_with = "picture")]
    pub page: Option<PathBuf>,
    /// The nearest material that Mitsuba 3 has
    #[arg(long, value_name = "FILE.xml")]
    pub mitsuba: Option<PathBuf>,
    /// The nearest material that pbrt-v4 has
    #[arg(long, value_name = "FILE.pbrt")]
    pub pbrt: Option<PathBuf>,
}

const MASKINGS: Names<Backscattering> = &[
    ("smith", Backscattering::Smith, "As Smith's"),
    ("vgroove", Backscattering::VGroove, "As V-grooves"),
    ("normal-map", Backscattering::NormalMap, "Not at all, as those of a normal map"),
];
