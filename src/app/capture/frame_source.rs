//! The source of a capture's pictures. The source is the renderer, or a test double that needs no device.

use serde::Serialize;

use super::frames::Moment;
use leadr_maps::reads::FileRead;
use leadr_render::frame::Layer;
use leadr_render::light::panorama::EnvironmentLight;
use leadr_tools::command::device::DeviceInfo;
use leadr_tools::command::error::AppError;

/// The time that one pass takes on the device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// The name of the pass.
    pub pass: String,
    /// The time of the pass on the device in milliseconds.
    pub ms: f64,
}

/// One picture, as rows that start at the top left corner.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The width of the picture in pixels.
    pub width: u32,
    /// The height of the picture in pixels.
    pub height: u32,
    /// Linear Rec. 709 radiance and coverage. The length is `width · height`.
    pub color: Vec<[f32; 4]>,
    /// The requested layers. Each plane has the length `width · height`. Planes are in the order of [`Layer::channels`].
    pub layers: Vec<(Layer, Vec<Vec<f32>>)>,
    /// The exposure factor for display.
    pub exposure: f32,
    /// The time of each pass on the device, in order.
    pub passes: Vec<PassTime>,
}

/// A source that renders the moments of one capture.
pub struct FrameSource<'a> {
    /// The device that renders.
    pub device: DeviceInfo,
    /// The input files of the pictures.
    pub files: Vec<FileRead>,
    /// The lights extracted from the environment image.
    pub lights: Vec<EnvironmentLight>,
    /// The duration of the set-up in seconds.
    pub set_up_seconds: f64,
    /// Renders a moment, and reports the number of samples after each sample. Rendering the same moment always gives the same bits.
    pub render: Box<Render<'a>>,
}

type Render<'a> = dyn FnMut(Moment, &mut dyn FnMut(u32)) -> Result<Frame, AppError> + 'a;
