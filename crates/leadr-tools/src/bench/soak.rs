//! The soak test, which measures memory use over many frames of a scene.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

use glam::{Quat, Vec3};
use serde::Serialize;

use crate::command::device::DeviceInfo;
use crate::command::output::Output;
use crate::error::LabError;
use crate::program::{commit, memory_of_process};
use leadr_gpu::Gpu;
use leadr_render::camera::Camera;
use leadr_render::settings::{RenderSettings, Technique};
use leadr_scenes::config::SceneConfig;
use leadr_scenes::daylight;
use leadr_scenes::set::{Inputs, Set, set};

/// The memory use after some number of frames.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MemorySample {
    /// The number of frames drawn so far.
    pub frame: u64,
    /// The resident memory of the process in bytes, if the system reports it.
    pub resident: Option<u64>,
    /// The memory of buffers and images in bytes.
    pub allocated: u64,
    /// The bytes that the driver has reserved for buffers and images.
    pub reserved: u64,
    /// The number of buffers and images.
    pub allocations: usize,
}

impl MemorySample {
    /// Samples the memory of this process and of a device after `frame` frames.
    pub fn after(frame: u64, gpu: &Gpu) -> Self {
        let memory = gpu.memory_use();
        Self {
            frame,
            resident: memory_of_process("VmRSS:"),
            allocated: memory.allocated,
            reserved: memory.reserved,
            allocations: memory.allocations,
        }
    }
}

/// The memory use over many frames.
#[derive(Clone, Debug, Serialize)]
pub struct SoakReport {
    command: &'static str,
    #[serde(flatten)]
    device: DeviceInfo,
    /// The number of frames drawn and read back.
    frames: u32,
    size: [u32; 2],
    scene: String,
    /// The number of samples along the edge of the sea's tiles, if there is a sea.
    fft: Option<u32>,
    samples: Vec<MemorySample>,
    /// The growth of buffers and images in bytes, from the second sample to the last.
    allocated_growth: i64,
    /// The growth of resident memory in bytes, from the second sample to the last.
    resident_growth: Option<i64>,
    /// The wall-clock time in seconds.
    seconds: f64,
}

const SAMPLES: u32 = 10;
/// The time between frames in seconds.
const STEP: f64 = 1.0 / 30.0;

/// Draws `frames` frames of `config` and reads all frames back. Time advances, the sun moves through one day, and the camera
/// moves. Over a sea the camera travels, rotates, and climbs from 2.5 m to a kilometre. In other scenes the camera circles
/// the scene near and far, on the same path between all memory samples. Techniques alternate, unless `only` selects one.
///
/// # Errors
/// Fails if the device fails, if validation reports a message, or if buffers and images grow from the second sample to the
/// last.
pub fn soak(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    frames: u32,
    only: Option<Technique>,
    output: &Output,
) -> Result<SoakReport, LabError> {
    let start = Instant::now();
    let inputs = Inputs::load(config)?;
    let Set { mut renderer, animation, .. } = set(config, inputs, gpu, None, &output.set_up())?;
    let settings = config.render_settings();
    // A memory sample follows a whole round of techniques, because techniques hold different resources.
    let round = if only.is_some() { 1 } else { Technique::ALL.len() as u32 };
    let interval = (frames / SAMPLES / round).max(1) * round;
    let bar = output.bar(frames as usize, &format!("rendering {frames} frames"));
    let mut samples = Vec::new();
    for frame in 0..frames {
        let mut state = animation(f64::from(frame) * STEP);
        state.camera = match config.scene.sea {
            Some(_) => sailing(&state.camera, frame, frames),
            None => circling(&state.camera, frame % interval, interval),
        };
        daylight::pass(&mut state, 24.0 * f64::from(frame) / f64::from(frames));
        let technique = only.unwrap_or(Technique::ALL[frame as usize % Technique::ALL.len()]);
        let shading = technique.with(settings.shading.options());
        renderer.render(&state, &RenderSettings { shading, ..settings })?;
        if (frame + 1) % interval == 0 {
            samples.push(MemorySample::after(u64::from(frame) + 1, gpu));
        }
        bar.step();
    }
    drop(bar);
    if let Some(message) = gpu.validation_messages().first() {
        return Err(LabError(format!("Vulkan validation: {message}")));
    }
    // All pipelines exist by the second sample.
    let ends = samples.get(1).zip(samples.last());
    let allocated_growth = ends.map_or(0, |(a, b)| b.allocated as i64 - a.allocated as i64);
    let resident_growth = ends.and_then(|(a, b)| Some(b.resident? as i64 - a.resident? as i64));
    if allocated_growth > 0 {
        return Err(LabError(format!("buffers and images grew by {allocated_growth} bytes: {samples:?}")));
    }
    Ok(SoakReport {
        command: "bench",
        device: DeviceInfo::of(gpu),
        frames,
        size: [config.size.width, config.size.height],
        scene: config.scene.name.to_owned(),
        fft: config.scene.sea.map(|_| config.waves.fft),
        samples,
        allocated_growth,
        resident_growth,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns the camera of a frame over a sea. The camera climbs and descends four times, rotates seven times, and travels 2
/// km.
fn sailing(camera: &Camera, frame: u32, frames: u32) -> Camera {
    let share = frame as f32 / frames.max(1) as f32;
    let turns = |n: f32| std::f32::consts::TAU * n * share;
    let height = 2.5 * 400f32.powf(0.5 - 0.5 * turns(4.0).cos());
    let direction = Quat::from_rotation_z(turns(7.0)) * (camera.target - camera.position).normalize_or(Vec3::X);
    let position = Vec3::new(2000.0 * share, 0.0, height);
    Camera::looking_at(position, position + direction * height, camera.fov_y.to_degrees())
}

/// Returns the camera of a frame. The camera moves once around its target, from a third of its distance to eight times its
/// distance and back.
fn circling(camera: &Camera, frame: u32, frames: u32) -> Camera {
    let share = frame as f32 / frames as f32;
    let nearness = 0.5 + 0.5 * (std::f32::consts::TAU * share).cos();
    let distance = camera.position.distance(camera.target) * 8.0 * (1.0f32 / 24.0).powf(nearness);
    camera.rotated(360.0 * share).at_distance(distance)
}

impl fmt::Display for SoakReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mib = |bytes: f64| format!("{:.2}", bytes / f64::from(1 << 20));
        writeln!(f, "{}, commit {}", self.device, commit())?;
        let [width, height] = self.size;
        writeln!(f, "{} frames of {}, {width}x{height}; MiB", self.frames, self.scene)?;
        writeln!(
            f,
            "  {:>8} {:>12} {:>12} {:>12} {:>12}",
            "frame", "resident", "allocated", "reserved", "allocations"
        )?;
        for s in &self.samples {
            let resident = s.resident.map_or("unknown".to_owned(), |bytes| mib(bytes as f64));
            let (allocated, reserved) = (mib(s.allocated as f64), mib(s.reserved as f64));
            writeln!(f, "  {:>8} {resident:>12} {allocated:>12} {reserved:>12} {:>12}", s.frame, s.allocations)?;
        }
        let growth = self.resident_growth.map_or("unknown".to_owned(), |bytes| mib(bytes as f64));
        writeln!(f, "growth: resident {growth}, buffers and images {}", mib(self.allocated_growth as f64))?;
        write!(f, "{:.0} s", self.seconds)
    }
}
