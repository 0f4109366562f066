//! The sections of the report. Each has one file, and one row in the table.

mod bench;
mod chan;
mod classes;
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
mod papers;
mod precision;
mod quadrature;
mod resolution;
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

/// A section of the report, as one row of [`SECTIONS`].
#[derive(Clone, Copy, Debug)]
pub struct SectionEntry {
    /// The name on the command line and in the data.
    pub key: &'static str,
    /// The description in the command's help.
    pub help: &'static str,
    /// The heading on the page.
    pub title: &'static str,
    /// Whether the section judges pictures of other sections. A judging section must be rebuilt after any judged section.
    pub judges_others: bool,
    run: fn(&mut Studio) -> Result<Section, LabError>,
}

/// All sections, in the order of the page.
pub static SECTIONS: [SectionEntry; 26] = [
    SectionEntry {
        key: "papers",
        help: "Figures of the papers in their order, with links",
        title: "Figures of the papers in their order",
        judges_others: false,
        run: papers::run,
    },
    SectionEntry {
        key: "convergence",
        help: "Convergence of the reference",
        title: "Convergence of the reference",
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
        help: "Required number of slope samples",
        title: "Required number of slope samples",
        judges_others: false,
        run: table10::run,
    },
    SectionEntry {
        key: "quadrature",
        help: "The visible-slope rules against converged integrals",
        title: "The visible-slope rules",
        judges_others: false,
        run: quadrature::run,
    },
    SectionEntry {
        key: "model",
        help: "Shadowing models against ray casts",
        title: "Masking and shadowing against ray casts",
        judges_others: false,
        run: model::run,
    },
    SectionEntry {
        key: "techniques",
        help: "Every technique at several distances",
        title: "Techniques side by side",
        judges_others: false,
        run: techniques::run,
    },
    SectionEntry {
        key: "shadows",
        help: "Shadows between bumps",
        title: "Shadows between bumps",
        judges_others: false,
        run: shadows::run,
    },
    SectionEntry {
        key: "classes",
        help: "Hard-edged relief by classes of facets against one Gaussian",
        title: "Classes of facets",
        judges_others: false,
        run: classes::run,
    },
    SectionEntry {
        key: "roughness",
        help: "Filtering of two roughnesses on one surface",
        title: "Two roughnesses on one surface",
        judges_others: false,
        run: roughness::run,
    },
    SectionEntry {
        key: "measured",
        help: "Measured materials: extraction, fits and displaced spheres",
        title: "Measured materials",
        judges_others: false,
        run: measured::run,
    },
    SectionEntry {
        key: "colour",
        help: "Colours on tops, in cracks and on one side of the relief",
        title: "Colours that follow the relief",
        judges_others: false,
        run: colour::run,
    },
    SectionEntry {
        key: "normals",
        help: "Normal maps, with and without heights",
        title: "Normal maps",
        judges_others: false,
        run: normals::run,
    },
    SectionEntry {
        key: "textures",
        help: "Normal map filters: shortened normals, Toksvig, CLEAN, LEAN, LEADR",
        title: "Normal map filters",
        judges_others: false,
        run: textures::run,
    },
    SectionEntry {
        key: "shapes",
        help: "Deforming surfaces with fixed maps, and shapes that displacement makes (LEADR Figures 5 and 9)",
        title: "Deforming surfaces",
        judges_others: false,
        run: shapes::run,
    },
    SectionEntry {
        key: "zoom",
        help: "Flicker while the camera moves away",
        title: "Flicker while the camera moves away",
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
        help: "Cracks in displaced third-party models",
        title: "Displaced third-party models",
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
        help: "Pictures with 16-bit and block-compressed maps against 32 bits",
        title: "Smaller maps",
        judges_others: false,
        run: precision::run,
    },
    SectionEntry {
        key: "resolution",
        help: "One view with maps of falling resolution",
        title: "Maps of falling resolution",
        judges_others: false,
        run: resolution::run,
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
        help: "Figures of the papers not in other sections",
        title: "More figures of the papers",
        judges_others: false,
        run: figures::run,
    },
    SectionEntry {
        key: "chan",
        help: "Figures of Material Advances in Call of Duty: WWII",
        title: "Figures of Chan 2018",
        judges_others: false,
        run: chan::run,
    },
    SectionEntry {
        key: "bench",
        help: "The bench's tables and goals",
        title: "Times",
        judges_others: false,
        run: bench::run,
    },
    SectionEntry {
        key: "misses",
        help: "The worst pictures of the other sections",
        title: "The largest errors of LEADR",
        judges_others: true,
        run: misses::run,
    },
];

impl SectionEntry {
    /// Finds a section by key.
    pub fn find(key: &str) -> Option<&'static Self> {
        SECTIONS.iter().find(|section| section.key == key)
    }

    /// Builds the section.
    ///
    /// # Errors
    /// Fails if the device fails or a measurement is not finite.
    pub fn run(&self, studio: &mut Studio) -> Result<Section, LabError> {
        (self.run)(studio)
    }
}
