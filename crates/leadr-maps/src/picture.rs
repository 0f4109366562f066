//! Pictures as a viewer shows them.

use super::{MapFault, RgbImage};

/// A picture for comparison or display, loaded from any supported format.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The image in linear Rec.709.
    pub image: RgbImage,
    /// Whether the file contained display codes (PNG). [`crate::tonemap::Tonemap::Clamp`] at exposure 1 reproduces the
    /// codes. EXR and HDR files contain radiance instead, which needs tonemapping.
    pub display_referred: bool,
    /// The opacity of each pixel, from 0 to 1, or `None` if all pixels are opaque. The colours of an EXR are multiplied by it;
    /// those of a PNG are not.
    pub alpha: Option<Vec<f32>>,
    /// How the pixels lie on a screen.
    pub frame: Frame,
}

/// How the pixels of a picture lie on a screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The top left corner of the display window of an EXR, in pixels.
    pub origin: [i32; 2],
    /// The width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The orientation as in EXIF, 1 to 8. 1 is upright.
    pub orientation: u8,
    /// The colour space of the codes: `sRGB`, or the words of the file. `linear` for radiance, which is converted to Rec.709.
    pub color_space: String,
    /// The layer of an EXR, or an empty text for its unnamed layer.
    pub layer: String,
    /// The view of a stereo picture, such as `left`.
    pub view: Option<String>,
}

impl Default for Frame {
    fn default() -> Self {
        let (layer, color_space) = (String::new(), "linear".to_owned());
        Self { origin: [0; 2], pixel_aspect: 1.0, orientation: 1, color_space, layer, view: None }
    }
}

impl Picture {
    /// Whether some pixels are not opaque.
    pub fn is_transparent(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns the picture over an even background of this linear value.
    #[must_use]
    pub fn over(&self, background: f32) -> RgbImage {
        let Some(alpha) = &self.alpha else { return self.image.clone() };
        let over = |(texel, &alpha): (&[f32; 3], &f32)| {
            let own = if self.display_referred { alpha } else { 1.0 };
            texel.map(|value| own * value + (1.0 - alpha) * background)
        };
        RgbImage { texels: self.image.texels.iter().zip(alpha).map(over).collect(), ..self.image }
    }

    /// Checks that a viewer shows both pictures in the same place, shape and colour space.
    ///
    /// # Errors
    /// Fails if sizes, display windows, pixel shapes, orientations, colour spaces or views of stereo pictures differ. The fault
    /// is of this picture.
    pub fn check_same_frame(&self, reference: &Self) -> Result<(), MapFault> {
        let (own, other) = (&self.frame, &reference.frame);
        let differ = |what: &str, own: &dyn std::fmt::Display, other: &dyn std::fmt::Display, remedy: &str| {
            Err(MapFault::unsupported(format!("its {what} is {own}, and that of the reference is {other}"), remedy))
        };
        let size = |image: &RgbImage| format!("{} x {}", image.width, image.height);
        let (own_size, other_size) = (size(&self.image), size(&reference.image));
        if own_size != other_size {
            return Err(MapFault::SizeMismatch {
                what: format!("it is {own_size}, and the reference is {other_size}"),
            });
        }
        if own.origin != other.origin {
            let at = |[x, y]: [i32; 2]| format!("at ({x}, {y})");
            return differ(
                "display window",
                &at(own.origin),
                &at(other.origin),
                "save both with the same display window",
            );
        }
        if (own.pixel_aspect - other.pixel_aspect).abs() > 1e-3 {
            return differ(
                "pixel aspect ratio",
                &own.pixel_aspect,
                &other.pixel_aspect,
                "save both with the same ratio",
            );
        }
        if own.orientation != other.orientation {
            return differ("orientation (EXIF)", &own.orientation, &other.orientation, "save both upright");
        }
        if own.color_space != other.color_space {
            return differ("colour space", &own.color_space, &other.color_space, "convert both to sRGB");
        }
        match (&own.view, &other.view) {
            (Some(own), Some(other)) if own != other => {
                let [own, other] = [own, other].map(|view| crate::shown::shown(view));
                differ("view", &own, &other, "choose the same view in both, for example by --layer")
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(display_referred: bool, alpha: Option<Vec<f32>>) -> Picture {
        let image = RgbImage::new(2, 1, vec![[0.5; 3], [0.25; 3]]).unwrap();
        Picture { image, display_referred, alpha, frame: Frame::default() }
    }

    #[test]
    fn pictures_lie_over_a_background() {
        let over = |picture: &Picture| picture.over(1.0).texels.iter().map(|texel| texel[0]).collect::<Vec<_>>();
        assert_eq!(over(&picture(true, None)), [0.5, 0.25]);
        assert_eq!(over(&picture(true, Some(vec![0.5, 0.0]))), [0.75, 1.0]);
        assert_eq!(over(&picture(false, Some(vec![0.5, 1.0]))), [1.0, 0.25]);
    }

    #[test]
    fn pictures_of_other_frames_are_refused() {
        let plain = picture(true, None);
        assert!(plain.check_same_frame(&plain).is_ok());
        for (frame, words) in [
            (Frame { origin: [3, 4], ..Frame::default() }, "at (3, 4)"),
            (Frame { pixel_aspect: 2.0, ..Frame::default() }, "pixel aspect ratio is 2"),
            (Frame { orientation: 6, ..Frame::default() }, "orientation (EXIF) is 6"),
            (Frame { color_space: "gamma".into(), ..Frame::default() }, "colour space is gamma"),
        ] {
            let message = Picture { frame, ..plain.clone() }.check_same_frame(&plain).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
        let view =
            |view: &str| Picture { frame: Frame { view: Some(view.into()), ..Frame::default() }, ..plain.clone() };
        assert!(view("left").check_same_frame(&view("right")).unwrap_err().to_string().contains("view is left"));
        assert!(view("left").check_same_frame(&plain).is_ok());
    }
}
