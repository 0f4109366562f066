//! Overlays on the picture: layers in false colours, and the difference between the two sides.

use std::thread::JoinHandle;

use leadr_maps::tonemap::Tonemap;
use leadr_maps::{Rgb8Image, RgbImage};
use leadr_render::frame::Layer;
use leadr_render::surfaces::tessellation::MAX_FACTOR;
use leadr_tools::metrics::compare::compare;

/// A layer of a picture, as values in rows.
pub struct LayerPicture {
    /// The width and height in pixels.
    pub size: (u32, u32),
    /// Values from [`Renderer::layer`](leadr_render::frame::Renderer::layer).
    pub values: Vec<[f32; 4]>,
}

/// Returns a layer in false colours, and the legend.
pub fn false_colors(layer: Layer, picture: &LayerPicture) -> (Rgb8Image, String) {
    let LayerPicture { size: (width, height), values } = picture;
    let (width, height) = (*width, *height);
    let grey = |share: f32| [(share.clamp(0.0, 1.0) * 255.0) as u8; 3];
    let signed = |v: f32| ((0.5 + 0.5 * v.clamp(-1.0, 1.0)) * 255.0) as u8;
    let finite = || values.iter().map(|v| v[0]).filter(|v| v.is_finite());
    let (low, high) = finite().fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
    let says = match layer {
        Layer::Depth => format!("depth: white is {low:.1} m, black is {high:.1} m or more"),
        Layer::Normal => "normal: red, green, blue are x, y, z from -1 to 1".to_owned(),
        Layer::MeanSlope => "mean slope: red is x, green is y, from -1 to 1".to_owned(),
        Layer::Covariance => {
            "slope deviations from 0 to 1: red along x, green along y, blue the root of the covariance".to_owned()
        }
        Layer::Lod => format!("level of detail: black is {low:.1}, white is {high:.1}"),
        Layer::Albedo => "albedo".to_owned(),
        Layer::Roughness => "roughness: black is alpha 0, white is 1".to_owned(),
        Layer::VisibleArea => "visible area over that of the smooth surface: grey is 1, white is 2 or more".to_owned(),
        Layer::Patch => "patches: one colour each, darker along u and v".to_owned(),
        Layer::Shadow => "shadows of the sun and lamps: black is none of the light, white is all".to_owned(),
        Layer::Sky => "sky occlusion by large shapes: black is occluded, white is open".to_owned(),
        Layer::Triangles => "triangle edges: more triangle pixels move them apart".to_owned(),
        Layer::Tessellation => {
            let most = values.iter().map(|v| v[0].max(v[1])).filter(|v| v.is_finite()).fold(0.0, f32::max);
            format!("segments along a patch: blue is 1, green 8, red 63; here at most {most:.0}")
        }
    };
    let color = |v: &[f32; 4]| match layer {
        Layer::Depth if v[0].is_finite() => grey(1.0 - (v[0] / low).max(1.0).ln() / (high / low).max(1.001).ln()),
        Layer::Depth => [0; 3],
        Layer::Normal => [v[0], v[1], v[2]].map(signed),
        Layer::MeanSlope => [signed(v[0]), signed(v[1]), 128],
        Layer::Covariance => [v[0], v[1], v[2].abs()].map(|v| grey(v.max(0.0).sqrt())[0]),
        Layer::Lod => grey((v[0] - low) / (high - low).max(1e-6)),
        Layer::Albedo => [v[0], v[1], v[2]].map(leadr_maps::srgb::srgb8_from_linear),
        Layer::Roughness | Layer::Shadow | Layer::Sky => grey(v[0]),
        Layer::Triangles => grey(0.15 + 0.85 * v[0]),
        Layer::Tessellation if v[0] == 0.0 => [0; 3],
        Layer::Tessellation => segment_color(v[0].max(v[1])),
        Layer::VisibleArea => grey(0.5 * v[0]),
        Layer::Patch if v[0] == 0.0 => [0; 3],
        Layer::Patch => {
            let hash = [v[0] as u32, v[1] as u32].iter().fold(0x9e37_79b9, |hash: u32, &number| {
                let mixed = (hash ^ number).wrapping_mul(0x85eb_ca6b);
                (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35)
            });
            let shade = 1.0 - 0.35 * (v[2] + v[3]).clamp(0.0, 2.0) / 2.0;
            [hash >> 8, hash >> 16, hash >> 24].map(|part| ((64.0 + 0.75 * (part & 0xff) as f32) * shade) as u8)
        }
    };
    (Rgb8Image { width, height, texels: values.iter().map(color).collect() }, says)
}

/// Returns a colour from blue (1 segment) over green (8 segments) to red (63 segments). The scale is logarithmic.
fn segment_color(segments: f32) -> [u8; 3] {
    let share = segments.max(1.0).ln() / MAX_FACTOR.ln();
    let [blue, green, red] = [0.0, 0.5, 1.0].map(|middle| (1.0 - 2.0 * (share - middle).abs()).clamp(0.0, 1.0));
    [red, green, blue].map(|part| (part.sqrt() * 255.0) as u8)
}

/// Computes the difference between two pictures on another thread.
#[derive(Default)]
pub struct Difference {
    running: Option<JoinHandle<Option<(Rgb8Image, String)>>>,
    /// The current and final sample counts of the pictures that were compared last.
    compared: (u32, u32),
}

impl Difference {
    /// Whether pictures with these sample counts (current, final) need a comparison. A comparison is needed at first, whenever the count
    /// has doubled, and at the end.
    pub fn needs_samples(&self, samples: (u32, u32)) -> bool {
        let news = samples.0 >= 2 * self.compared.0.max(1) || samples.0 >= samples.1;
        self.running.is_none() && self.compared != samples && news
    }

    /// Whether a comparison is running.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Starts the comparison of two pictures. `samples` are their current and final sample counts.
    pub fn begin(&mut self, left: RgbImage, right: RgbImage, exposure: f32, tonemap: Tonemap, samples: (u32, u32)) {
        self.compared = samples;
        let names = format!("sample {} of {}", samples.0, samples.1);
        // Without a thread there is no comparison.
        let thread = std::thread::Builder::new();
        let running = thread.spawn(move || {
            let found = compare(&right, &left, exposure, tonemap).ok()?;
            let says =
                format!("FLIP between left and right: mean {:.4}, rRMSE {:.4} ({names})", found.flip, found.rrmse);
            Some((found.error_image(), says))
        });
        self.running = running.ok();
    }

    /// Returns the error image and its legend when the comparison is finished.
    pub fn found(&mut self) -> Option<(Rgb8Image, String)> {
        let done = self.running.take_if(|running| running.is_finished())?;
        done.join().ok().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colors_distinguish_depth() {
        let values = [[2.0, 0.0, 0.0, 0.0], [8.0, 0.0, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0, 0.0], [f32::NAN; 4]];
        let picture = LayerPicture { size: (4, 1), values: values.to_vec() };
        let (image, says) = false_colors(Layer::Depth, &picture);
        assert_eq!(image.texels, [[255; 3], [0; 3], [0; 3], [0; 3]]);
        assert!(says.contains("2.0 m") && says.contains("8.0 m"), "{says}");
        let colors = [1.0, 7.9, 63.0].map(segment_color);
        assert!(colors[0] == [0, 0, 255] && colors[1][1] > 250 && colors[2] == [255, 0, 0], "{colors:?}");
        for layer in Layer::ALL {
            assert_eq!(false_colors(layer, &picture).0.texels.len(), 4);
        }
    }

    #[test]
    fn pictures_are_compared_when_they_have_doubled_and_at_last() {
        let mut difference = Difference::default();
        assert!(difference.needs_samples((2, 256)));
        let image = |v: f32| RgbImage { width: 16, height: 16, texels: vec![[v; 3]; 256] };
        difference.begin(image(0.2), image(0.4), 1.0, Tonemap::Agx, (2, 256));
        assert!(!difference.needs_samples((200, 256)));
        let (picture, says) = loop {
            if let Some(found) = difference.found() {
                break found;
            }
            std::thread::yield_now();
        };
        assert!(picture.texels.len() == 256 && says.contains("sample 2 of 256") && !difference.is_running());
        assert!(
            !difference.needs_samples((2, 256))
                && !difference.needs_samples((3, 256))
                && difference.needs_samples((4, 256))
        );
        difference.compared = (200, 256);
        assert!(difference.needs_samples((256, 256)));
    }
}
