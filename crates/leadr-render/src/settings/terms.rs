//! The light terms that contribute to an image.

use std::fmt;

use crate::constants;

/// A set of light terms, which are the components of the light transport in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Terms(i32);

impl Terms {
    /// The specular reflection of the sun and of point lights.
    pub const SPECULAR_LIGHTS: Self = Self(constants::TERM_SPECULAR_LIGHTS);
    /// The diffuse reflection of the sun and of point lights.
    pub const DIFFUSE_LIGHTS: Self = Self(constants::TERM_DIFFUSE_LIGHTS);
    /// The specular reflection of the environment.
    pub const SPECULAR_ENVIRONMENT: Self = Self(constants::TERM_SPECULAR_ENVIRONMENT);
    /// The diffuse reflection of the environment.
    pub const DIFFUSE_ENVIRONMENT: Self = Self(constants::TERM_DIFFUSE_ENVIRONMENT);
    /// All light terms.
    pub const ALL: Self = Self(
        Self::SPECULAR_LIGHTS.0 | Self::DIFFUSE_LIGHTS.0 | Self::SPECULAR_ENVIRONMENT.0 | Self::DIFFUSE_ENVIRONMENT.0,
    );
    /// The set without any light terms, which gives a black image.
    pub const NONE: Self = Self(0);

    /// The single terms, each with its name on the command line.
    pub const NAMES: [(Self, &str); 4] = [
        (Self::SPECULAR_LIGHTS, "specular-lights"),
        (Self::DIFFUSE_LIGHTS, "diffuse-lights"),
        (Self::SPECULAR_ENVIRONMENT, "specular-environment"),
        (Self::DIFFUSE_ENVIRONMENT, "diffuse-environment"),
    ];

    /// Whether the set contains all of `other`.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Returns the set without the terms of `other`.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns the `TERM_` bits of the set for the shading pass.
    pub fn bits(self) -> i32 {
        self.0
    }

    /// Parses `all` or a comma-separated list of terms.
    ///
    /// # Errors
    /// Returns an error for an unknown name.
    pub fn named(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::ALL);
        }
        text.split(',').try_fold(Self::NONE, |terms, name| {
            let term = Self::NAMES.iter().find(|(_, known)| *known == name.trim()).map(|(term, _)| *term);
            let known = Self::ALL.names().collect::<Vec<_>>().join(", ");
            Ok(terms | term.ok_or(format!("'{name}' is not a term: use all, or some of {known}"))?)
        })
    }

    /// Returns the names of the terms in the set.
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

impl fmt::Display for Terms {
    /// Formats the set in the syntax that [`named`](Self::named) parses.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::ALL { f.write_str("all") } else { f.write_str(&self.names().collect::<Vec<_>>().join(",")) }
    }
}
