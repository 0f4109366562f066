//! Lists the figures and tables of the papers in their order, with links to the sections that draw them.

use serde::Serialize;

use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table};

const INTRO: &str = "The figures and tables of the papers that the report repeats, in their order, with the section that draws each. \
    Links work if the report has the section. Diagrams, and pictures of models that only the authors have, are left out.";

/// A figure or table of a paper.
#[derive(Serialize)]
struct Entry {
    figure: &'static str,
    shows: &'static str,
    section: &'static str,
}

const fn row(figure: &'static str, shows: &'static str, section: &'static str) -> Entry {
    Entry { figure, shows, section }
}

/// The papers with their figures.
const PAPERS: [(&str, &[Entry]); 5] = [
    (
        "LEADR mapping (Dupuy et al. 2013)",
        &[
            row("Figure 1", "T-rex, near, in the middle and far", "figures"),
            row("Figure 2", "visible normals depend on the viewer", "figures"),
            row("Figure 5", "stretched, sheared and flattened surfaces, near and far", "shapes"),
            row("Figure 6", "the grid of slopes", "figures"),
            row("Figure 7", "an environment as the samples of a pixel see it", "figures"),
            row("Section 6", "claws, with and without curvature", "figures"),
            row("Figure 8", "very rough spheres", "spheres"),
            row("Figure 9", "a pillow and a snake of diffuse microfacets", "shapes"),
            row("Figure 10", "the ocean from near to far", "ocean"),
            row("Section 7, tables", "times of techniques and grids", "bench"),
            row("Figure 11", "time against the number of samples", "bench"),
            row("Section 7", "times of the T-rex", "bench"),
        ],
    ),
    (
        "LEADR mapping, supplement",
        &[
            row("Figures 1 to 3", "Jacobian of slopes; Beckmann from slopes; Jacobian of reflection", "figures"),
            row("Table 1", "projected areas by four ways", "model"),
            row("Table 2", "low and high frequency", "spheres"),
            row("Table 3", "normal against displacement mapping", "spheres"),
            row("Tables 4 and 5", "diffuse facets, one light", "spheres"),
            row("Tables 6 and 7", "diffuse facets, irradiance", "spheres"),
            row("Tables 8 and 9", "specular facets, environment", "spheres"),
            row("Table 10", "grids of increasing size", "table10"),
            row("Figure 5", "reconstruction filters and the reconstructed environment", "figures"),
            row("Figure 6", "black pixels at silhouettes", "figures"),
        ],
    ),
    (
        "Improved Geometric Specular Antialiasing, supplement (Tokuyoshi and Kaplanyan 2019)",
        &[row("no figures", "its kernel on claws", "figures")],
    ),
    (
        "Photorealistic Surface Rendering with Microfacet Theory (Dupuy 2015)",
        &[
            row("Figures 2.2 to 2.6", "Fresnel terms, masking, roughness", "figures"),
            row("Figure 3.5", "a Gaussian surface against its BRDF", "figures"),
            row("Figure 3.6", "differences of heights", "figures"),
            row("Figures 3.7 to 3.9", "stretching, shearing, height scale", "shapes"),
            row("Figure 3.10", "an ocean", "ocean"),
            row("Figure 3.11", "a T-rex", "figures"),
            row("Table 4.I and Figures 4.2 to 4.6", "fits of measured materials", "measured"),
            row("Figure 5.3", "maps of falling resolution", "resolution"),
            row("Figures 5.4 and 5.5", "scratched and rugged materials", "measured"),
        ],
    ),
    (
        "Material Advances in Call of Duty: WWII (Chan 2018)",
        &[
            row("Figures 3, 8 and 9", "filtered normals and gloss, of bricks", "chan"),
            row("Figure 6", "two averages of normals", "chan"),
            row("Figures 11 and 12", "combined gloss and fits", "chan"),
            row("Figures 13, 14 and 17", "heights and occlusion of bricks", "chan"),
            row("Algorithm 5", "relaxation of heights", "chan"),
            row("Figures 15 and 18 to 20", "occlusion and cones", "chan"),
            row("Figures 23 to 34", "scattering between facets", "chan"),
            row("no figure", "filters of textures, error and flicker", "textures"),
        ],
    ),
];

pub fn run(_: &mut Studio) -> Result<Section, LabError> {
    let mut html = Html::new();
    for (paper, entries) in PAPERS {
        let mut table = Table::new(paper, ["figure", "shows", "section"]);
        for entry in entries {
            table.row([Cell::from(entry.figure), Cell::from(entry.shows), Cell::Section(entry.section.to_owned())]);
        }
        html.table(&table);
    }
    Section::new(INTRO, Vec::new(), &html, PAPERS.map(|(_, entries)| entries))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sections::SectionEntry;

    #[test]
    fn every_figure_is_in_a_section() {
        for entry in PAPERS.iter().flat_map(|(_, entries)| *entries) {
            assert!(SectionEntry::find(entry.section).is_some(), "{}: {}", entry.figure, entry.section);
        }
    }
}
