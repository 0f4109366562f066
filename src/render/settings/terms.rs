//! Which light a picture contains.

use crate::render::constants;

/// The light transport a picture contains: a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Terms(i32);

impl Terms {
    /// Sun and point lights in mirrors.
    pub const SPECULAR_LIGHTS: Self = Self(constants::TERM_SPECULAR_LIGHTS);
    /// Sun and point lights on the diffuse surface.
    pub const DIFFUSE_LIGHTS: Self = Self(constants::TERM_DIFFUSE_LIGHTS);
    /// The environment in mirrors.
    pub const SPECULAR_ENVIRONMENT: Self = Self(constants::TERM_SPECULAR_ENVIRONMENT);
    /// The environment on the diffuse surface.
    pub const DIFFUSE_ENVIRONMENT: Self = Self(constants::TERM_DIFFUSE_ENVIRONMENT);
    /// Everything.
    pub const ALL: Self = Self(
        constants::TERM_SPECULAR_LIGHTS
            | constants::TERM_DIFFUSE_LIGHTS
            | constants::TERM_SPECULAR_ENVIRONMENT
            | constants::TERM_DIFFUSE_ENVIRONMENT,
    );
    /// Nothing: black.
    pub const NONE: Self = Self(0);

    /// Each term with its name on the command line.
    pub const NAMES: [(Self, &str); 4] = [
        (Self::SPECULAR_LIGHTS, "specular-lights"),
        (Self::DIFFUSE_LIGHTS, "diffuse-lights"),
        (Self::SPECULAR_ENVIRONMENT, "specular-environment"),
        (Self::DIFFUSE_ENVIRONMENT, "diffuse-environment"),
    ];

    /// Whether all of `other` is in it.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Without `other`.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// `TERM_` bits of the shading pass.
    #[must_use]
    pub fn bits(self) -> i32 {
        self.0
    }

    /// Names of its members.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES.into_iter().filter(move |(term, _)| self.contains(*term)).map(|(_, name)| name)
    }
}

impl std::ops::BitOr for Terms {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
