//! What the user of the window has chosen about the picture, apart from where it is seen from and when.

use leadr_render::frame::Layer;
use leadr_render::light::sky::Sky;
use leadr_render::scene::FrameState;
use leadr_render::settings::{RenderSettings, Technique};
use leadr_scenes::config::Picture;
use leadr_scenes::deform;
use leadr_scenes::light::SunDirection;

/// Samples of a still picture by the reference beside another technique.
const REFERENCE_SAMPLES: u32 = 256;

/// Choices about the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// How the scene is drawn; by its technique on the left of two sides.
    pub picture: Picture,
    /// Another technique beside it.
    pub compare: Option<Compare>,
    /// Where the sun is, if not where the scene has it.
    pub sun: Option<SunDirection>,
    /// What of the picture is shown.
    pub look: Look,
}

/// A second technique.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compare {
    /// On the right side.
    pub technique: Technique,
    /// Where that begins, as a share of the width.
    pub split: f32,
    /// Whether the difference of both is shown over the picture.
    pub difference: bool,
}

impl Default for Compare {
    fn default() -> Self {
        Self { technique: Technique::NormalMip, split: 0.5, difference: false }
    }
}

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Look {
    /// The picture.
    #[default]
    Picture,
    /// The picture, and ellipses of the slopes that vary under a pixel.
    Ellipses,
    /// The picture, and what the places of the sky's volume see of the surroundings.
    Probes,
    /// A quantity that it is shaded by, in false colours.
    Layer(Layer),
}

impl Look {
    /// All of them with their names.
    pub fn all() -> impl Iterator<Item = (Self, &'static str)> {
        let layers = Layer::ALL.into_iter().map(|layer| (Self::Layer(layer), layer.name()));
        let pictures = [(Self::Picture, "picture"), (Self::Ellipses, "slope ellipses"), (Self::Probes, "sky probes")];
        pictures.into_iter().chain(layers)
    }

    /// The quantity that must be read back for it.
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
    /// Draws so.
    pub fn new(picture: Picture) -> Self {
        Self { picture, compare: None, sun: None, look: Look::Picture }
    }

    /// The settings of the picture, or of both its sides, in place of those in `base`.
    pub fn sides(&self, base: &RenderSettings) -> Vec<RenderSettings> {
        let side = |technique: Technique, samples: u32| Picture { technique, samples, ..self.picture }.settings(base);
        let Picture { technique, samples: chosen, .. } = self.picture;
        // What is read back is that of one sample.
        let own = side(technique, if self.look.layer().is_some() { 1 } else { chosen });
        let other = self.compare.filter(|_| self.look == Look::Picture).map(|compare| {
            let reference = compare.technique.is_reference();
            side(compare.technique, if reference { REFERENCE_SAMPLES.max(chosen) } else { chosen })
        });
        std::iter::once(own).chain(other).collect()
    }

    /// Whether another picture must be drawn for these: not where only the line between two moves.
    pub fn draws_like(&self, other: &Self) -> bool {
        let still = |choices: &Self| {
            let compare = choices.compare.map(|compare| Compare { split: 0.0, ..compare });
            Self { compare, ..choices.clone() }
        };
        still(self) == still(other)
    }

    /// Changes the state of the scene.
    pub fn apply(&self, state: &mut FrameState) {
        state.height_scale *= self.picture.height_scale;
        deform::stretch(state, self.picture.stretch);
        if let (Some(sun), Some(sky)) = (self.sun, state.sky) {
            *state = state.clone().under(&Sky { sun_direction: sun.vector(), ..sky });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::scene::Pose;

    #[test]
    fn the_reference_beside_a_technique_gathers_samples_of_its_own() {
        let base = RenderSettings { samples: 4, msaa: 4, ..Default::default() };
        let mut choices = Choices::new(Picture::of(&base));
        assert_eq!(choices.sides(&base), [base]);
        choices.compare = Some(Compare { technique: Technique::Reference, ..Default::default() });
        let [own, other] = choices.sides(&base).try_into().expect("two sides");
        assert_eq!((own, other.samples, other.msaa), (base, REFERENCE_SAMPLES, 1));
        assert!(other.tessellation.to_texels && !own.tessellation.to_texels);
        let moved = Choices { compare: choices.compare.map(|c| Compare { split: 0.2, ..c }), ..choices.clone() };
        assert!(moved.draws_like(&choices) && moved != choices);
        choices.look = Look::Ellipses;
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
        assert!(state.height_scale == 2.0 && state.sun.expect("a sun").direction.distance(glam::Vec3::Y) < 1e-6);
        // A picture has its own light.
        let mut state = FrameState::new(camera, Vec::new());
        choices.apply(&mut state);
        assert!(state.sun.is_none());
    }
}
