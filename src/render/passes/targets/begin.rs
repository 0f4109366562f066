//! How a kind of surface begins to draw into targets that several kinds share.

use crate::gpu::{ColorTarget, Commands, DepthTarget, Image, Load, Use};

/// Content of the targets when a kind of surface begins to draw into them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// Zeros, for the first kind.
    Clear,
    /// Anything: for the first kind, where nothing reads the pixels it does not cover.
    Discard,
    /// The pixels of earlier kinds.
    Continue,
}

impl Begin {
    /// Makes an integer image a colour target.
    pub(super) fn color<'a>(self, cmd: &mut Commands, image: &'a Image) -> ColorTarget<'a> {
        let load = match self {
            Self::Clear => Load::ClearUint([0; 4]),
            Self::Discard => Load::Discard,
            Self::Continue => Load::Keep,
        };
        self.transition(cmd, image, Use::ColorTarget);
        ColorTarget { view: image.whole(), load }
    }

    /// Makes an image a depth target; for the first kind everything is infinitely far away.
    pub(super) fn depth<'a>(self, cmd: &mut Commands, image: &'a Image) -> DepthTarget<'a> {
        self.transition(cmd, image, Use::DepthTarget);
        DepthTarget { view: image.whole(), clear: (self != Self::Continue).then_some(0.0) }
    }

    fn transition(self, cmd: &mut Commands, image: &Image, to: Use) {
        match self {
            Self::Clear | Self::Discard => cmd.image_barrier(image, Use::Undefined, to),
            Self::Continue => cmd.transition(image, to),
        }
    }
}
