//! The picture settings that the user chose in the window, except camera and time.

use leadr_render::frame::Layer;
use leadr_render::scene::FrameState;
use leadr_render::settings::{RenderSettings, Technique};
use leadr_scenes::config::Picture;
use leadr_scenes::deform;
use leadr_scenes::light::SunDirection;

/// The number of samples of a still reference picture on the right side.
const REFERENCE_SAMPLES: u32 = 256;

/// The picture settings of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// The render settings. If there are two sides, the technique is the technique of the left side.
    pub picture: Picture,
    /// The settings of the right side, if there are two sides.
    pub compare: Option<Compare>,
    /// The direction of the sun that replaces the sun of the scene, if there is one.
    pub sun: Option<SunDirection>,
    /// The view of the picture that is shown.
    pub display_mode: DisplayMode,
}

/// The settings of the right side of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compare {
    /// The technique of the right side.
    pub technique: Technique,
    /// The start position of the right side, as a fraction of the width.
    pub split: f32,
    /// Whether the difference between the two sides covers the picture.
    pub difference: bool,
}

impl Default for Compare {
    fn default() -> Self {
        Self { technique: Technique::NormalMip, split: 0.5, difference: false }
    }
}

/// A view of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplayMode {
    /// The picture without an overlay.
    #[default]
    Picture,
    /// The picture with ellipses of the slope covariance under some of its pixels.
    Ellipses,
    /// The picture with the probes of the volume of sky occlusion.
    Probes,
    /// A layer of the picture in false colours.
    Layer(Layer),
}

impl DisplayMode {
    /// Returns all views and their names.
    pub fn all() -> impl Iterator<Item = (Self, &'static str)> {
        let layers = Layer::ALL.into_iter().map(|layer| (Self::Layer(layer), layer.name()));
        let pictures = [(Self::Picture, "picture"), (Self::Ellipses, "slope ellipses"), (Self::Probes, "sky probes")];
        pictures.into_iter().chain(layers)
    }

    /// Returns the layer that must be read back from the device for this view.
    #[must_use]
    pub fn layer(self) -> Option<Layer> {
        match self {
            Self::Picture => None,
            Self::Ellipses => Some(Layer::Covariance),
            Self::Probes => Some(Layer::Depth),
            Self::Layer(layer) => Some(layer),
        }
    }
}

impl Choices {
    /// Creates settings with one side and with the sun of the scene.
    pub fn new(picture: Picture) -> Self {
        Self { picture, compare: None, sun: None, display_mode: DisplayMode::Picture }
    }

    /// Returns the render settings of each side, based on `base`.
    pub fn sides(&self, base: &RenderSettings) -> Vec<RenderSettings> {
        let side = |technique: Technique, samples: u32| Picture { technique, samples, ..self.picture }.settings(base);
        let Picture { technique, samples: chosen, .. } = self.picture;
        // Layers are read back from a single sample per pixel.
        let own = side(technique, if self.display_mode.layer().is_some() { 1 } else { chosen });
        let other = self.compare.filter(|_| self.display_mode == DisplayMode::Picture).map(|compare| {
            let reference = compare.technique.is_reference();
            side(compare.technique, if reference { REFERENCE_SAMPLES.max(chosen) } else { chosen })
        });
        std::iter::once(own).chain(other).collect()
    }

    /// Whether two settings draw the same pictures. The positions of the split may differ.
    pub fn draws_like(&self, other: &Self) -> bool {
        let still = |choices: &Self| {
            let compare = choices.compare.map(|compare| Compare { split: 0.0, ..compare });
            Self { compare, ..choices.clone() }
        };
        still(self) == still(other)
    }

    /// Applies the height scale, the stretch and the sun to a state of the scene.
    pub fn apply(&self, state: &mut FrameState) {
        state.height_scale *= self.picture.height_scale;
        deform::stretch(state, self.picture.stretch);
        if let (Some(sun), Some(sky)) = (self.sun, &mut state.sky) {
            (sky.sun_direction, state.sun) = (sun.vector(), None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::light::sky::Sky;
    use leadr_render::scene::Pose;

    #[test]
    fn split_reference_accumulates_separately() {
        let base = RenderSettings { samples: 4, msaa: 4, ..Default::default() };
        let mut choices = Choices::new(Picture::of(&base));
        assert_eq!(choices.sides(&base), [base]);
        choices.compare = Some(Compare { technique: Technique::Reference, ..Default::default() });
        let [own, other] = choices.sides(&base).try_into().expect("two sides");
        assert_eq!((own, other.samples, other.msaa), (base, REFERENCE_SAMPLES, 1));
        assert!(other.tessellation.to_texels && !own.tessellation.to_texels);
        let moved = Choices { compare: choices.compare.map(|c| Compare { split: 0.2, ..c }), ..choices.clone() };
        assert!(moved.draws_like(&choices) && moved != choices);
        choices.display_mode = DisplayMode::Ellipses;
        assert!(!moved.draws_like(&choices));
        assert_eq!(choices.sides(&base).len(), 1);
    }

    #[test]
    fn the_sun_goes_where_it_is_put() {
        let camera = leadr_render::camera::Camera::looking_at(glam::Vec3::X, glam::Vec3::ZERO, 40.0);
        let mut choices = Choices::new(Picture::default());
        (choices.picture.height_scale, choices.picture.stretch) = (2.0, 1.5);
        choices.sun = Some(SunDirection { azimuth: 90.0, elevation: 0.0 });
        let mut state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
        choices.apply(&mut state);
        assert_ne!(state.poses[0], Pose::REST);
        assert!(state.height_scale == 2.0 && state.sun().expect("a sun").direction.distance(glam::Vec3::Y) < 1e-6);
        // An environment image replaces the sun.
        let mut state = FrameState::new(camera, Vec::new());
        choices.apply(&mut state);
        assert!(state.sun().is_none());
    }
}
