//! Layers that the images of a sample do not contain. To make these layers, the sample is drawn again, and the picture does not
//! change.

use super::Layer;
use super::drawing::Purpose;
use super::prepared::PreparedFrame;
use super::renderer::{KeptTargets, LastSample, Renderer};
use super::timing::CpuTime;
use crate::light::sky_visibility::SkyProbe;
use crate::settings::RenderSettings;
use leadr_gpu::Result;

/// The largest depth difference between a line and the surface below it, relative to their distance. Depths differ because lines
/// and surfaces are rasterised separately.
const LINE_SLACK: f32 = 1e-3;

impl Renderer {
    /// Returns the fractions of light that arrive at each pixel: one for suns and lamps, and one for the environment. Both
    /// fractions are 1 in empty pixels.
    pub(super) fn light_shares(&mut self) -> Result<Vec<[f32; 2]>> {
        let shares = self.once_more(Purpose::Light, |frame, index| {
            frame.draw_sample(index)?;
            frame.image().read::<[f32; 4]>(0, 0)
        })?;
        let share = |&[light, sky, _, covered]: &[f32; 4]| if covered > 0.0 { [light, sky] } else { [1.0; 2] };
        Ok(shares.iter().flatten().map(share).collect())
    }

    /// Returns 1 for each pixel on a triangle edge, and 0 elsewhere.
    pub(super) fn wires(&mut self) -> Result<Vec<[f32; 4]>> {
        let (patches, depth) = (self.layer(Layer::Patch)?, self.layer(Layer::Depth)?);
        let lines = self.once_more(Purpose::Wires, |frame, index| {
            let pixels = frame.plan.pixels(index);
            frame.set_view(&pixels, index)?;
            frame.renderer.timer.clone().submit(&mut CpuTime::default(), |passes| {
                frame.plan.surfaces.record_motion(passes);
                frame.record_pixel_geometry(passes, &pixels);
            })?;
            let visible = &frame.plan.targets.pixels.visible;
            let (seen, depth) = (visible.surface.read::<[u32; 4]>(0, 0)?, visible.depth.read::<f32>(0, 0)?);
            let near = pixels.camera.near;
            Ok((frame.plan.settings.size, seen.iter().zip(&depth).map(|(s, z)| (s[0], near / z)).collect::<Vec<_>>()))
        })?;
        let Some(((width, height), lines)) = lines else { return Ok(Vec::new()) };
        let numbering = self.numbering;
        // Lines occlude each other, but triangles do not occlude lines. A line lies on a visible surface if it is no farther than
        // the farthest neighbouring pixel.
        let shows = |(i, &(word, distance)): (usize, &(u32, f32))| {
            let [object, _] = numbering.parts(word);
            let (x, y) = (i as u32 % width, i as u32 / width);
            let about = (y.saturating_sub(1)..(y + 2).min(height))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| (y * width + x) as usize));
            let farthest = about.filter(|&j| patches[j][0] as u32 == object).map(|j| depth[j][0]).fold(0.0, f32::max);
            let shown = object > 0 && distance <= farthest * (1.0 + LINE_SLACK);
            [f32::from(u8::from(shown)), 0.0, 0.0, 0.0]
        };
        Ok(lines.iter().enumerate().map(shows).collect())
    }

    /// Returns the number of segments along u and v of each pixel's patch, or 0 where nothing is tessellated.
    pub(super) fn segments(&mut self) -> Result<Vec<[f32; 4]>> {
        let patches = self.layer(Layer::Patch)?;
        let segments = self.once_more(Purpose::Picture, |frame, index| {
            let pixels = frame.plan.pixels(index);
            frame.set_view(&pixels, index)?;
            let of = |&[object, patch, ..]: &[f32; 4]| {
                let divided = frame.plan.surfaces.segments(object as u32, patch as u32);
                let [u, v] = divided.unwrap_or([0.0; 2]);
                [u, v, 0.0, 0.0]
            };
            Ok(patches.iter().map(of).collect())
        })?;
        Ok(segments.unwrap_or_default())
    }

    /// Returns the sky occlusion probes of the last frame. The list is empty if nothing casts shadows or if sky occlusion is off.
    pub fn sky_probes(&self) -> Vec<SkyProbe> {
        let shaded = self
            .last
            .as_ref()
            .is_some_and(|last| last.settings.shading.options().sky_occlusion && last.settings.shadows);
        if shaded { self.sky.probes() } else { Vec::new() }
    }

    /// Draws the last sample again for another purpose, with one sample per pixel, into separate images. The picture stays
    /// unchanged. Returns `None` before the first sample.
    fn once_more<T>(
        &mut self,
        purpose: Purpose,
        draw: impl FnOnce(&mut PreparedFrame<'_>, u32) -> Result<T>,
    ) -> Result<Option<T>> {
        let Some(LastSample { state, settings, index, .. }) = self.last.clone() else { return Ok(None) };
        let settings = RenderSettings { msaa: 1, shading: settings.shading.plain(), ..settings };
        let mut kept = KeptTargets::default();
        self.swap_targets(&mut kept);
        let drawn = self.prepare_for(&state, &settings, purpose).and_then(|mut frame| draw(&mut frame, index));
        self.swap_targets(&mut kept);
        drawn.map(Some)
    }
}
