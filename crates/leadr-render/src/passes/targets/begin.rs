//! The initial content of targets into which several kinds of surface are drawn.

use leadr_gpu::{ColorTarget, Commands, DepthTarget, Image, Load, Use};

/// The initial content of targets that several kinds of surface share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// The targets start with zeros, for the first kind of surface. Some software drivers choose one level of detail for the
    /// environment lookups of a 2 × 2 quad, so uncovered pixels must not hold data from an earlier frame.
    Clear,
    /// The targets keep the pixels that earlier kinds of surface have drawn.
    Continue,
}

impl Begin {
    /// Makes an integer image a colour target.
    pub(super) fn color<'a>(self, cmd: &mut Commands, image: &'a Image) -> ColorTarget<'a> {
        let load = match self {
            Self::Clear => Load::ClearUint([0; 4]),
            Self::Continue => Load::Keep,
        };
        self.transition(cmd, image, Use::ColorTarget);
        ColorTarget { view: image.whole(), load }
    }

    /// Makes an image a depth target. For the first kind of surface, the image is cleared to infinity.
    pub(super) fn depth<'a>(self, cmd: &mut Commands, image: &'a Image) -> DepthTarget<'a> {
        self.transition(cmd, image, Use::DepthTarget);
        DepthTarget { view: image.whole(), clear: (self != Self::Continue).then_some(0.0) }
    }

    pub(super) fn transition(self, cmd: &mut Commands, image: &Image, to: Use) {
        match self {
            Self::Clear => cmd.image_barrier(image, Use::Undefined, to),
            Self::Continue => cmd.transition(image, to),
        }
    }
}
