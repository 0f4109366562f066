//! The sections of the report, one file each: what it measures, and what it makes of it.

mod bench;
mod convergence;
mod misses;
mod model;
mod ocean;
mod quadrature;
mod samples;
mod shadows;
mod shapes;
mod spheres;
mod table10;
mod techniques;
mod zoom;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::html::Html;
use super::studio::Studio;
use crate::app::error::AppError;

/// What a section has to say.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Section {
    /// For people.
    pub html: Html,
    /// For programs.
    pub data: serde_json::Value,
    /// Conclusions, each computed from the data.
    pub findings: Vec<String>,
}

impl Section {
    /// A section that opens with `intro`, goes on with its findings, and then shows what they were made from.
    ///
    /// # Errors
    /// If the data cannot be written as JSON.
    pub fn new(intro: &str, findings: Vec<String>, shown: &Html, data: impl Serialize) -> Result<Self, AppError> {
        let mut html = Html::new();
        html.paragraph(intro);
        html.findings(&findings);
        html.append(shown);
        let data = serde_json::to_value(data).map_err(|e| AppError::Failed(format!("cannot write JSON: {e}")))?;
        Ok(Self { html, data, findings })
    }
}

/// The sections, in the order of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum SectionName {
    /// How the reference converges.
    Convergence,
    /// The sphere grid of the supplement's tables.
    Spheres,
    /// How many slope samples it takes.
    Table10,
    /// Rules for visible slopes against converged integrals.
    Quadrature,
    /// Shadowing models against ray casts.
    Model,
    /// Every technique from near to far.
    Techniques,
    /// Shadows that the relief throws on itself.
    Shadows,
    /// Surfaces that deform under maps that do not.
    Shapes,
    /// What flickers when the camera moves away.
    Zoom,
    /// The sea against ray-marched truth, near and far.
    Ocean,
    /// One sample of LEADR against many of the reference.
    Samples,
    /// The bench's tables and goals.
    Bench,
    /// The worst pictures of the other sections.
    Misses,
}

impl SectionName {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Convergence,
        Self::Spheres,
        Self::Table10,
        Self::Quadrature,
        Self::Model,
        Self::Techniques,
        Self::Shadows,
        Self::Shapes,
        Self::Zoom,
        Self::Ocean,
        Self::Samples,
        Self::Bench,
        Self::Misses,
    ];

    /// Name on the command line and in the data.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Convergence => "convergence",
            Self::Spheres => "spheres",
            Self::Table10 => "table10",
            Self::Quadrature => "quadrature",
            Self::Model => "model",
            Self::Techniques => "techniques",
            Self::Shadows => "shadows",
            Self::Shapes => "shapes",
            Self::Zoom => "zoom",
            Self::Ocean => "ocean",
            Self::Samples => "samples",
            Self::Bench => "bench",
            Self::Misses => "misses",
        }
    }

    /// Heading on the page.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Convergence => "The reference converges",
            Self::Spheres => "The sphere grid",
            Self::Table10 => "How many slope samples it takes",
            Self::Quadrature => "Fewer, better-placed samples",
            Self::Model => "Beyond the model: masking and shadowing against ray casts",
            Self::Techniques => "Techniques side by side",
            Self::Shadows => "Shadows that the relief throws on itself",
            Self::Shapes => "Surfaces that deform",
            Self::Zoom => "Moving away: what flickers",
            Self::Ocean => "The sea",
            Self::Samples => "One sample of LEADR against many of the reference",
            Self::Bench => "What it costs",
            Self::Misses => "Where LEADR is not close to truth",
        }
    }

    /// Makes the section.
    ///
    /// # Errors
    /// If the device fails or a measurement is not finite.
    pub fn run(self, studio: &mut Studio) -> Result<Section, AppError> {
        match self {
            Self::Convergence => convergence::run(studio),
            Self::Spheres => spheres::run(studio),
            Self::Table10 => table10::run(studio),
            Self::Quadrature => quadrature::run(studio),
            Self::Model => model::run(studio),
            Self::Techniques => techniques::run(studio),
            Self::Shadows => shadows::run(studio),
            Self::Shapes => shapes::run(studio),
            Self::Zoom => zoom::run(studio),
            Self::Ocean => ocean::run(studio),
            Self::Samples => samples::run(studio),
            Self::Bench => bench::run(studio),
            Self::Misses => misses::run(studio),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_on_the_command_line_are_the_keys_of_the_data() {
        for (value, name) in SectionName::value_variants().iter().zip(SectionName::ALL) {
            assert_eq!(*value, name);
            assert_eq!(name.to_possible_value().unwrap().get_name(), name.key());
        }
        assert_eq!(SectionName::value_variants().len(), SectionName::ALL.len());
    }
}
