//! Pictures of numbers over the picture: what it is shaded by, and how two sides differ.

use std::thread::JoinHandle;

use leadr_maps::tonemap::Tonemap;
use leadr_maps::{Rgb8Image, RgbImage};
use leadr_render::frame::Layer;
use leadr_render::surfaces::tessellation::MAX_FACTOR;
use leadr_tools::metrics::compare::compare;

/// A quantity in every pixel, row by row.
pub struct LayerPicture {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// As [`Renderer::layer`](leadr_render::frame::Renderer::layer) gives them.
    pub values: Vec<[f32; 4]>,
}

/// A quantity in false colours, and what they mean.
pub fn false_colors(layer: Layer, picture: &LayerPicture) -> (Rgb8Image, String) {
    let LayerPicture { size: (width, height), values } = picture;
    let (width, height) = (*width, *height);
    let grey = |share: f32| [(share.clamp(0.0, 1.0) * 255.0) as u8; 3];
    let signed = |v: f32| ((0.5 + 0.5 * v.clamp(-1.0, 1.0)) * 255.0) as u8;
    let finite = || values.iter().map(|v| v[0]).filter(|v| v.is_finite());
    let (low, high) = finite().fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
    let says = match layer {
        Layer::Depth => format!("depth: white {low:.1} m, black {high:.1} m and beyond"),
        Layer::Normal => "normal: x, y, z from -1 to 1 are red, green, blue".to_owned(),
        Layer::MeanSlope => "mean slope: x is red, y green; none is the middle, 1 the end".to_owned(),
        Layer::Covariance => {
            "slope deviations: along x red, along y green, root of the covariance blue; 1 is the end".to_owned()
        }
        Layer::Lod => format!("level of detail: black {low:.1}, white {high:.1}"),
        Layer::Albedo => "albedo".to_owned(),
        Layer::Roughness => "roughness: alpha from 0, black, to 1, white".to_owned(),
        Layer::VisibleArea => {
            "area of bumps that is seen: the smooth surface's is grey, twice that or more white".to_owned()
        }
        Layer::Patch => "patches: a colour each, darker along u and v".to_owned(),
        Layer::Shadow => "light of suns and lamps that arrives: none is black, all white".to_owned(),
        Layer::Sky => "surroundings that large shapes leave: none is black, all white".to_owned(),
        Layer::Triangles => "edges of triangles; with more px/triangle they lie further apart".to_owned(),
        Layer::Tessellation => {
            let most = values.iter().map(|v| v[0].max(v[1])).filter(|v| v.is_finite()).fold(0.0, f32::max);
            format!("segments of a patch: blue 1, green 8, red 63; at most {most:.0} here")
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

/// Blue for 1 segment over green for 8 to red for 63, evenly in the logarithm.
fn segment_color(segments: f32) -> [u8; 3] {
    let share = segments.max(1.0).ln() / MAX_FACTOR.ln();
    let [blue, green, red] = [0.0, 0.5, 1.0].map(|middle| (1.0 - 2.0 * (share - middle).abs()).clamp(0.0, 1.0));
    [red, green, blue].map(|part| (part.sqrt() * 255.0) as u8)
}

/// Finds the difference of two pictures beside the frames.
#[derive(Default)]
pub struct Difference {
    running: Option<JoinHandle<Option<(Rgb8Image, String)>>>,
    /// Samples of the pictures that were compared last.
    compared: (u32, u32),
}

impl Difference {
    /// Whether pictures with so many samples are worth comparing: at first, when they have doubled, and at last.
    pub fn wants(&self, samples: (u32, u32)) -> bool {
        let news = samples.0 >= 2 * self.compared.0.max(1) || samples.0 >= samples.1;
        self.running.is_none() && self.compared != samples && news
    }

    /// Whether something is on its way.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Begins to compare the pictures, which have so many samples.
    pub fn begin(&mut self, left: RgbImage, right: RgbImage, exposure: f32, tonemap: Tonemap, samples: (u32, u32)) {
        self.compared = samples;
        let names = format!("sample {} of {}", samples.0, samples.1);
        self.running = Some(std::thread::spawn(move || {
            let found = compare(&right, &left, exposure, tonemap).ok()?;
            let says = format!("FLIP of left and right: mean {:.4}, rRMSE {:.4} ({names})", found.flip, found.rrmse);
            Some((found.error_image(), says))
        }));
    }

    /// What was found, once.
    pub fn found(&mut self) -> Option<(Rgb8Image, String)> {
        let done = self.running.take_if(|running| running.is_finished())?;
        done.join().ok().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colors_tell_near_from_far() {
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
        assert!(difference.wants((2, 256)));
        let image = |v: f32| RgbImage { width: 16, height: 16, texels: vec![[v; 3]; 256] };
        difference.begin(image(0.2), image(0.4), 1.0, Tonemap::Agx, (2, 256));
        assert!(!difference.wants((200, 256)));
        let (picture, says) = loop {
            if let Some(found) = difference.found() {
                break found;
            }
            std::thread::yield_now();
        };
        assert!(picture.texels.len() == 256 && says.contains("sample 2 of 256") && !difference.is_running());
        assert!(!difference.wants((2, 256)) && !difference.wants((3, 256)) && difference.wants((4, 256)));
        difference.compared = (200, 256);
        assert!(difference.wants((256, 256)));
    }
}
