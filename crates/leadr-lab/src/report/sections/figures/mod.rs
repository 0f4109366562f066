//! Draws the figures of the papers that other sections do not cover. A number checks each figure.

mod claws;
mod differences;
mod environment;
mod facets;
mod grid;
mod microsurface;
mod normals;
mod reconstruction;
mod silhouettes;
mod trex;
mod visible;

use crate::report::page::Page;
use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_tools::error::LabError;

const INTRO: &str = "Figures 1, 2, 6 and 7 of the LEADR paper and the claws of its section 6, Figures 1, 2, 3, 5 and 6 of its supplement, and 2.2 to 2.6, 3.5 and 3.6 of Dupuy's thesis. \
    Each has a caption; its numbers are checks, most of them against a closed form or a truth. The papers' other figures are diagrams or \
    appear in other sections: deformed surfaces (Figure 5), the pillow and the snake (9), the sea (10), normal maps and displacement (8), \
    and measured materials.";

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let mut page = Page::default();
    type Figures = fn(&mut Studio, &mut Page) -> Result<(), LabError>;
    let figures: [Figures; 11] = [
        trex::draw,
        visible::draw,
        grid::draw,
        normals::draw,
        silhouettes::draw,
        environment::draw,
        claws::draw,
        reconstruction::draw,
        facets::draw,
        microsurface::draw,
        differences::draw,
    ];
    studio.steps(figures.len());
    for draw in figures {
        draw(studio, &mut page)?;
        studio.step();
    }
    Section::new(INTRO, page.findings, &page.html, &page.checks)
}
