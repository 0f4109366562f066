//! A row: something that is drawn again and again, and its times.

use super::forward::Forward;
use super::rounds::{PIXELS, Series};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::scene::FrameState;
use leadr_render::settings::{Quadrature, RenderSettings};

/// One row: something that is drawn again and again.
#[derive(Clone, Debug)]
pub struct Row {
    /// The table it belongs to.
    pub table: String,
    /// Its name there.
    pub name: String,
    /// The row of the table that this one is compared with.
    pub base: Option<String>,
    /// Another row of the table that its passes per pixel are compared with.
    pub beside: Option<String>,
    /// The time that is compared: that of the passes per pixel, or of all passes.
    pub compared: &'static str,
    /// The scene.
    pub state: FrameState,
    /// How it is drawn.
    pub settings: RenderSettings,
    /// Hours that the sun moves between rounds; if it moves, every round makes the sky, its mips and its irradiance anew.
    pub sun_hours: f64,
    /// Seconds that setting it up took, where that is of interest.
    pub set_up: Option<f64>,
    /// The plain forward pass that draws it instead of the renderer; rows that are compared with it are compared with its total.
    pub forward: Option<Forward>,
}

/// A row with its times.
pub struct Measured {
    /// What was measured.
    pub row: Row,
    /// The times.
    pub series: Series,
}

impl Row {
    /// Where it integrates over slopes; techniques that look at one slope are a grid of one.
    fn quadrature(&self) -> Quadrature {
        self.settings.shading.quadrature().unwrap_or(Quadrature::Grid(1))
    }

    /// Slope samples, or probes, of a pixel; 1 for techniques that look at one slope.
    pub fn samples(&self) -> u32 {
        self.forward.map_or_else(|| self.quadrature().samples(), Forward::samples)
    }

    /// The rule that places them.
    pub fn rule(&self) -> &'static str {
        self.forward.map_or_else(|| self.quadrature().name(), |_| Quadrature::Grid(1).name())
    }

    /// The shadowing model; none for techniques that look at one slope.
    pub fn shadowing(&self) -> &'static str {
        let shading = self.settings.shading;
        if shading.technique().integrates() { shading.options().shadowing } else { Shadowing::None }.name()
    }

    /// Metres to the camera's target, where that differs between rows.
    pub fn distance(&self) -> Option<f32> {
        let camera = &self.state.camera;
        self.is_of_a_frame().then(|| camera.position.distance(camera.target))
    }

    /// Whether the whole frame is of interest, with its triangles and the processor's time, and not its pixels alone.
    pub fn is_of_a_frame(&self) -> bool {
        self.compared != PIXELS
    }
}
