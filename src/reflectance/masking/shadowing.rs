//! The shadowing models.

/// Which of the facets that the viewer sees are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shadowing {
    /// All of them: masking alone (Algorithms 1 and 2 of the LEADR paper).
    None,
    /// Those that Smith's height-correlated form leaves (LEADR eq. 13).
    Smith,
    /// Those that the direction-correlated form leaves ([`correlated`](super::correlated)).
    Correlated,
    /// The same by its simple form, which is cheaper and less exact.
    CorrelatedSimple,
}

impl Shadowing {
    /// Every model, in the order of [`code`](Self::code).
    pub const ALL: [Self; 4] = [Self::None, Self::Smith, Self::Correlated, Self::CorrelatedSimple];

    /// Those that the renderer is compared and timed with: all but the simple form.
    pub const MAIN: [Self; 3] = [Self::None, Self::Smith, Self::Correlated];

    /// Its `LEADR_SHADOWING_` number in `leadr/masking/correlated.glsl`.
    #[must_use]
    pub const fn code(self) -> i32 {
        self as i32
    }

    /// Its name on the command line and in JSON. Without shadowing, what is left is masking.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "masking",
            Self::Smith => "smith",
            Self::Correlated => "correlated",
            Self::CorrelatedSimple => "correlated-simple",
        }
    }

    /// What it does, in a line.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::None => "None: every facet that the viewer sees is lit, as in the LEADR paper",
            Self::Smith => "Shadowing that is correlated with masking by height (Smith)",
            Self::Correlated => "Shadowing that is correlated with masking by height and direction",
            Self::CorrelatedSimple => "The same, by a simpler formula",
        }
    }

    /// The next of [`MAIN`](Self::MAIN), the first after the last.
    #[must_use]
    pub fn next(self) -> Self {
        let after = Self::MAIN.iter().position(|&model| model == self).map_or(0, |i| i + 1);
        Self::MAIN[after % Self::MAIN.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glsl_library_knows_the_same_models() {
        let glsl = include_str!("../../../shaders-glsl/leadr/masking/correlated.glsl");
        let declared = glsl.lines().filter(|line| line.starts_with("const int LEADR_SHADOWING_")).count();
        assert_eq!(declared, Shadowing::ALL.len());
        for model in Shadowing::ALL {
            let name = match model {
                Shadowing::None => "NONE".to_owned(),
                other => other.name().to_uppercase().replace('-', "_"),
            };
            let line = format!("const int LEADR_SHADOWING_{name} = {};", model.code());
            assert!(glsl.contains(&line), "{line}");
        }
    }
}
