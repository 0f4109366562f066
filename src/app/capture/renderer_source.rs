//! The renderer as a [`FrameSource`], which draws a scene with one configuration at the requested times.

use std::time::Instant;

use super::args::CaptureConfig;
use super::frame_source::{Frame, FrameSource, PassTime};
use super::frames::Moment;
use leadr_maps::reads::recorded;
use leadr_render::frame::Renderer;
use leadr_render::scene::FrameState;
use leadr_scenes::set::{Inputs, Set, SetUp, set};
use leadr_tools::command::device::DeviceInfo;
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;

/// Loads the inputs of `config`, opens the device and prepares the renderer.
pub fn open<'a>(config: &'a CaptureConfig, output: &Output) -> Result<FrameSource<'a>, AppError> {
    // Files are read before a device is opened, so that errors in files are reported even without a device.
    let scene = &config.scene;
    let begun = Instant::now();
    let watch = output.set_up();
    watch(SetUp::Begins("reading files"));
    let (made, files) = recorded(|| -> Result<Set, AppError> {
        let inputs = Inputs::load(scene)?;
        watch(SetUp::Begins("opening the device"));
        let gpu = config.device.open()?;
        Ok(set(scene, inputs, &gpu, Some(&scene.render_settings()), &watch)?)
    });
    let Set { mut renderer, animation, .. } = made?;
    Ok(FrameSource {
        device: DeviceInfo::of(renderer.gpu()),
        files,
        lights: renderer.environment().lights().to_vec(),
        set_up_seconds: begun.elapsed().as_secs_f64(),
        render: Box::new(move |moment, done| render(config, &mut renderer, animation(moment.time), moment, done)),
    })
}

/// Replaces the right side of `color` by pixels of `right`, behind a white line. `share` is the position of the line as a fraction of the
/// width.
fn composite_split(color: &mut [[f32; 4]], right: &[[f32; 4]], width: u32, share: f32, exposure: f32) {
    let white = 100.0 / exposure.max(1e-12);
    let line = (share * width as f32).round() as usize;
    let half = (width as usize / 800).max(1) as isize;
    for (index, texel) in color.iter_mut().enumerate() {
        let from_line = (index % width as usize) as isize - line as isize;
        if (-half..half).contains(&from_line) {
            *texel = [white, white, white, 1.0];
        } else if from_line >= 0 {
            *texel = right[index];
        }
    }
}

/// Draws a moment of a scene. `state` is the scene at this moment.
fn render(
    config: &CaptureConfig,
    renderer: &mut Renderer,
    mut state: FrameState,
    moment: Moment,
    done: &mut dyn FnMut(u32),
) -> Result<Frame, AppError> {
    if let Some(distance) = moment.distance {
        state.camera = state.camera.at_distance(distance);
    }
    if let Some(degrees) = moment.turn_degrees {
        state.camera = state.camera.rotated(degrees);
    }
    let mut settings = config.scene.render_settings();
    if let Some(technique) = moment.technique {
        settings.samples = config.samples_of(moment);
        settings = settings.shaded_by(technique.with(config.scene.picture.options));
    }
    let mut output = renderer.render_watched(&state, &settings, done)?;
    if let Some((technique, split)) = config.beside {
        let left = settings.samples.max(1);
        let settings = settings.shaded_by(technique.with(config.scene.picture.options));
        let right = renderer.render_watched(&state, &settings, &mut |samples| done(left + samples))?;
        let share = split.of_frame(moment.frame, config.timeline.frames());
        composite_split(&mut output.color, &right.color, output.size.0, share, state.exposure());
    }
    let mut layers = Vec::new();
    for &layer in &config.layers {
        let texels = renderer.layer(layer)?;
        let plane = |i: usize| texels.iter().map(|texel| texel[i]).collect();
        layers.push((layer, (0..layer.channels().len()).map(plane).collect()));
    }
    if config.device.validation
        && let Some(first) = renderer.gpu().take_validation_messages().first()
    {
        return Err(AppError::Failed(format!("Vulkan validation: {first}")));
    }
    let (width, height) = output.size;
    let passes = output.times.into_iter().map(|time| PassTime { pass: time.pass, ms: time.milliseconds }).collect();
    Ok(Frame { width, height, color: output.color, layers, exposure: state.exposure(), passes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_right_side_begins_at_its_line() {
        let mut left = vec![[0.25, 0.0, 0.0, 1.0]; 20];
        composite_split(&mut left, &[[0.0, 0.5, 0.0, 1.0]; 20], 10, 0.4, 2.0);
        let row: Vec<_> = left[10..]
            .iter()
            .map(|c| {
                if c[2] > 1.0 {
                    'w'
                } else if c[0] > 0.0 {
                    'l'
                } else {
                    'r'
                }
            })
            .collect();
        assert_eq!(row.into_iter().collect::<String>(), "lllwwrrrrr");
        let mut none = vec![[0.25; 4]; 10];
        composite_split(&mut none, &[[0.5; 4]; 10], 10, 1.0, 1.0);
        assert!(none[..9].iter().all(|c| c[0] == 0.25));
    }
}
