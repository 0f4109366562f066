//! The sections of the report: one file each, one row each.

mod bench;
mod colour;
mod convergence;
mod figures;
mod measured;
mod misses;
mod model;
mod models;
mod normals;
mod ocean;
mod outside;
mod precision;
mod quadrature;
mod roughness;
mod samples;
mod shadows;
mod shapes;
mod spheres;
mod table10;
mod techniques;
mod textures;
mod zoom;

use super::section::Section;
use super::studio::Studio;
use leadr_tools::error::LabError;

/// A section: one row of [`SECTIONS`].
#[derive(Clone, Copy, Debug)]
pub struct SectionEntry {
    /// Its name on the command line and in the data.
    pub key: &'static str,
    /// What it measures, for the command's help.
    pub help: &'static str,
    /// Heading on the page.
    pub title: &'static str,
    /// Whether it judges the pictures of the other sections, and so must be made again whenever one of them is.
    pub judges_others: bool,
    run: fn(&mut Studio) -> Result<Section, LabError>,
}

/// Every section, in the order of the page.
pub static SECTIONS: [SectionEntry; 22] = [
    SectionEntry {
        key: "convergence",
        help: "How the reference converges",
        title: "The reference converges",
        judges_others: false,
        run: convergence::run,
    },
    SectionEntry {
        key: "spheres",
        help: "The sphere grid of the supplement's tables",
        title: "The sphere grid",
        judges_others: false,
        run: spheres::run,
    },
    SectionEntry {
        key: "table10",
        help: "How many slope samples are needed",
        title: "How many slope samples are needed",
        judges_others: false,
        run: table10::run,
    },
    SectionEntry {
        key: "quadrature",
        help: "The visible-slope rules against converged integrals",
        title: "Fewer, better-placed samples",
        judges_others: false,
        run: quadrature::run,
    },
    SectionEntry {
        key: "model",
        help: "Shadowing models against ray casts",
        title: "Beyond the model: masking and shadowing against ray casts",
        judges_others: false,
        run: model::run,
    },
    SectionEntry {
        key: "techniques",
        help: "Every technique from near to far",
        title: "Techniques side by side",
        judges_others: false,
        run: techniques::run,
    },
    SectionEntry {
        key: "shadows",
        help: "Shadows that the bumps cast on each other",
        title: "Shadows that bumps cast on each other",
        judges_others: false,
        run: shadows::run,
    },
    SectionEntry {
        key: "roughness",
        help: "Two roughnesses that share a surface",
        title: "Two roughnesses that share a surface",
        judges_others: false,
        run: roughness::run,
    },
    SectionEntry {
        key: "measured",
        help: "Measured materials, extracted, fitted and displaced",
        title: "Measured materials",
        judges_others: false,
        run: measured::run,
    },
    SectionEntry {
        key: "colour",
        help: "Paint on tops, in cracks and on one side of the relief",
        title: "Colours that follow the relief",
        judges_others: false,
        run: colour::run,
    },
    SectionEntry {
        key: "normals",
        help: "Normal maps beside heights, and alone",
        title: "Normal maps",
        judges_others: false,
        run: normals::run,
    },
    SectionEntry {
        key: "textures",
        help: "Which filter of normal maps serves where: shortened normals, Toksvig, CLEAN, LEAN, LEADR",
        title: "Which filter of normal maps serves where",
        judges_others: false,
        run: textures::run,
    },
    SectionEntry {
        key: "shapes",
        help: "Surfaces that deform under maps that do not",
        title: "Surfaces that deform",
        judges_others: false,
        run: shapes::run,
    },
    SectionEntry {
        key: "zoom",
        help: "What flickers when the camera moves away",
        title: "Moving away: what flickers",
        judges_others: false,
        run: zoom::run,
    },
    SectionEntry {
        key: "ocean",
        help: "The sea against ray-marched truth, near and far",
        title: "The sea",
        judges_others: false,
        run: ocean::run,
    },
    SectionEntry {
        key: "models",
        help: "Cracks in the displaced skins of models of others",
        title: "Models of others, displaced",
        judges_others: false,
        run: models::run,
    },
    SectionEntry {
        key: "outside",
        help: "Spheres, planes and reliefs against another renderer's pictures",
        title: "Against another renderer",
        judges_others: false,
        run: outside::run,
    },
    SectionEntry {
        key: "precision",
        help: "Pictures of 16-bit and block-compressed maps against 32 bits",
        title: "Smaller maps",
        judges_others: false,
        run: precision::run,
    },
    SectionEntry {
        key: "samples",
        help: "One sample of LEADR against many of the reference",
        title: "One sample of LEADR against many of the reference",
        judges_others: false,
        run: samples::run,
    },
    SectionEntry {
        key: "figures",
        help: "Figures of the papers that no other section draws",
        title: "Figures of the papers",
        judges_others: false,
        run: figures::run,
    },
    SectionEntry {
        key: "bench",
        help: "The bench's tables and goals",
        title: "What it costs",
        judges_others: false,
        run: bench::run,
    },
    SectionEntry {
        key: "misses",
        help: "The worst pictures of the other sections",
        title: "Where LEADR is far from the truth",
        judges_others: true,
        run: misses::run,
    },
];

impl SectionEntry {
    /// The section of this key.
    pub fn find(key: &str) -> Option<&'static Self> {
        SECTIONS.iter().find(|section| section.key == key)
    }

    /// Makes the section.
    ///
    /// # Errors
    /// If the device fails or a measurement is not finite.
    pub fn run(&self, studio: &mut Studio) -> Result<Section, LabError> {
        (self.run)(studio)
    }
}
