//! Draws the figures of Chan's *Material Advances in Call of Duty: WWII* (2018). Some figures show the project's own bricks instead of the
//! game's assets.

mod bricks;
mod cones;
mod distance;
mod gloss;
mod gloss_fit;
mod laws;
mod occlusion;
mod plots;
mod rational;
mod slices;
mod spheres;

use crate::report::page::Page;
use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_tools::error::LabError;

const INTRO: &str = "Figures 3, 6, 8, 9, 11 to 15, 17 to 20 and 23 to 34 of Material Advances in Call of Duty: WWII (Chan 2018), its algorithm \
    5, the fits of its section 5.7, and the measurement that its section 4.8 asks for. Figures 3, 8, 9, 13, 14 and 17 show the bricks of assets/ \
    instead of the game's. Figures 1, 21, 35 and 36 show the game, and the others are diagrams. The full BRDF of figures 26 to 33 is a random \
    walk between GGX facets, which loses the light that the coat of F0 = .04 reflects. The published fit is listing 1, and the model of this \
    project is multiscattering_diffuse.";

/// The glosses of the paper's figures, in 255ths.
const GLOSSES: [f64; 5] = [0.0, 60.0, 120.0, 180.0, 240.0];

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let mut page = Page::default();
    type Figures = fn(&mut Studio, &mut Page) -> Result<(), LabError>;
    let figures: [Figures; 9] = [
        gloss::draw,
        bricks::draw,
        occlusion::draw,
        cones::draw,
        distance::draw,
        spheres::draw,
        plots::draw,
        slices::draw,
        gloss_fit::draw,
    ];
    studio.steps(figures.len());
    for draw in figures {
        draw(studio, &mut page)?;
        studio.step();
    }
    Section::new(INTRO, page.findings, &page.html, &page.checks)
}
