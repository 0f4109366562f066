//! A row of a bench table: a configuration that is drawn repeatedly, and its times.

use super::forward::Forward;
use super::rounds::{PIXELS, Series};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::scene::FrameState;
use leadr_render::settings::{Quadrature, RenderSettings};

/// A configuration that is drawn repeatedly.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of its table.
    pub table: String,
    /// Name of the row.
    pub name: String,
    /// The row of the table that this one is compared with.
    pub base: Option<String>,
    /// Another row of the table that its per-pixel passes are compared with.
    pub beside: Option<String>,
    /// The compared time: that of the per-pixel passes, or of all passes.
    pub compared: &'static str,
    /// The state of the scene.
    pub state: FrameState,
    /// The render settings.
    pub settings: RenderSettings,
    /// Hours that the sun moves between rounds. If it moves, every round recomputes the sky, its mips and its irradiance.
    pub sun_hours: f64,
    /// Seconds of the set-up, for rows that measure it.
    pub set_up: Option<f64>,
    /// The plain forward pass that draws it instead of the renderer. Other rows are compared with its total time.
    pub forward: Option<Forward>,
}

/// A row and its times.
pub struct Measured {
    /// The row.
    pub row: Row,
    /// The times.
    pub series: Series,
}

impl Row {
    /// The quadrature over slopes; a grid of one for techniques with a single slope.
    fn quadrature(&self) -> Quadrature {
        self.settings.shading.quadrature().unwrap_or(Quadrature::Grid(1))
    }

    /// Slope samples (or probes) per pixel; 1 for techniques with a single slope.
    pub fn samples(&self) -> u32 {
        self.forward.map_or_else(|| self.quadrature().samples(), Forward::samples)
    }

    /// Name of the quadrature rule.
    pub fn rule(&self) -> &'static str {
        self.forward.map_or_else(|| self.quadrature().name(), |_| Quadrature::Grid(1).name())
    }

    /// Name of the shadowing model; that of masking alone for techniques with a single slope.
    pub fn shadowing(&self) -> &'static str {
        let shading = self.settings.shading;
        if shading.technique().integrates() { shading.options().shadowing } else { Shadowing::None }.name()
    }

    /// Distance of the camera to its target, metres, if it differs between rows.
    pub fn distance(&self) -> Option<f32> {
        let camera = &self.state.camera;
        self.is_of_a_frame().then(|| camera.position.distance(camera.target))
    }

    /// Whether the row measures whole frames, with triangles and CPU time, instead of pixels only.
    pub fn is_of_a_frame(&self) -> bool {
        self.compared != PIXELS
    }
}
