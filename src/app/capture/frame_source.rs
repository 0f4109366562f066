//! The source of a capture's pictures: the renderer, or a test double without a device.

use serde::Serialize;

use super::frames::Moment;
use leadr_maps::reads::FileRead;
use leadr_render::frame::Layer;
use leadr_render::light::panorama::EnvironmentLight;
use leadr_tools::command::device::DeviceInfo;
use leadr_tools::command::error::AppError;

/// The device time of one pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: String,
    /// Device time of the pass, milliseconds.
    pub ms: f64,
}

/// One picture, in rows from the top left corner.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Linear Rec. 709 radiance and coverage, `width · height` long.
    pub color: Vec<[f32; 4]>,
    /// The requested layers. Each plane is `width · height` long, in the order of [`Layer::channels`].
    pub layers: Vec<(Layer, Vec<Vec<f32>>)>,
    /// Exposure factor for display.
    pub exposure: f32,
    /// Device time per pass, in order.
    pub passes: Vec<PassTime>,
}

/// Renders the moments of one capture.
pub struct FrameSource<'a> {
    /// The device that renders.
    pub device: DeviceInfo,
    /// The input files of the pictures.
    pub files: Vec<FileRead>,
    /// The lights extracted from the environment image.
    pub lights: Vec<EnvironmentLight>,
    /// Duration of the set-up, seconds.
    pub set_up_seconds: f64,
    /// Renders a moment, and reports the sample count after each sample. A moment always renders to the same bits.
    pub render: Box<Render<'a>>,
}

type Render<'a> = dyn FnMut(Moment, &mut dyn FnMut(u32)) -> Result<Frame, AppError> + 'a;
