//! A row of a bench table, with a configuration that is drawn repeatedly, and its times.

use super::forward::Forward;
use super::rounds::{PIXELS, Series};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::scene::FrameState;
use leadr_render::settings::{Quadrature, RenderSettings};

/// A configuration that is drawn repeatedly, as one row of a table.
#[derive(Clone, Debug)]
pub struct Row {
    /// The name of the row's table.
    pub table: String,
    /// The name of the row.
    pub name: String,
    /// The name of the row with which this row is compared, in the same table.
    pub base: Option<String>,
    /// A second row of the table with which the per-pixel passes are compared.
    pub beside: Option<String>,
    /// The passes whose time is compared: the per-pixel passes or all passes.
    pub compared: &'static str,
    /// The state of the scene.
    pub state: FrameState,
    /// The render settings.
    pub settings: RenderSettings,
    /// The hours by which the sun moves between rounds. If the sun moves, every round recomputes the sky, its mips and its
    /// irradiance.
    pub sun_hours: f64,
    /// The set-up time in seconds, for tables that measure set-up.
    pub set_up: Option<f64>,
    /// The plain forward pass that draws the row instead of the renderer. Rows of the renderer are compared with the total
    /// time of the forward pass.
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
    /// Returns the quadrature over slopes, or a grid of one for techniques with a single slope.
    fn quadrature(&self) -> Quadrature {
        self.settings.shading.quadrature().unwrap_or(Quadrature::Grid(1))
    }

    /// Returns the number of slopes per pixel at which the environment is looked up (probes, or samples of the grid), which is 1 for
    /// techniques with a single slope.
    pub fn probes(&self) -> u32 {
        self.forward.map_or_else(|| self.quadrature().samples(), Forward::samples)
    }

    /// Returns the name of the quadrature rule.
    pub fn rule(&self) -> &'static str {
        self.forward.map_or_else(|| self.quadrature().name(), |_| Quadrature::Grid(1).name())
    }

    /// Returns the name of the shadowing model. For techniques with a single slope, the name is masking alone.
    pub fn shadowing(&self) -> &'static str {
        let shading = self.settings.shading;
        if shading.technique().integrates() { shading.options().shadowing } else { Shadowing::None }.name()
    }

    /// Returns the distance in metres from the camera to its target, to a tenth of a millimetre, for tables with several distances.
    pub fn distance(&self) -> Option<f64> {
        let camera = &self.state.camera;
        let metres = || f64::from(camera.position.distance(camera.target));
        self.is_of_a_frame().then(|| (metres() * 1e4).round() / 1e4)
    }

    /// Whether the row measures whole frames, with triangles and CPU time, instead of pixels only.
    pub fn is_of_a_frame(&self) -> bool {
        self.compared != PIXELS
    }
}
