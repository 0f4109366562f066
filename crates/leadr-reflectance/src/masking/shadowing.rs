//! The shadowing models.

/// Which of the facets visible to the viewer are lit. The numbers are those of the `LEADR_SHADOWING_` constants in
/// `leadr/masking/correlated.glsl`, which the tests of the shaders compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shadowing {
    /// All of them: masking alone (Algorithms 1 and 2 of the LEADR paper).
    None = 0,
    /// Those left by Smith's height-correlated form (LEADR eq. 13).
    Smith = 1,
    /// Those left by the direction-correlated form ([`correlated`](super::correlated)).
    Correlated = 2,
    /// Those left by its simple form, which is cheaper and less accurate.
    CorrelatedSimple = 3,
    /// All that face it, and all count alike for the viewer: a normal map on smooth geometry hides nothing, not even from the viewer
    /// ([`mapped`](crate::visible::mapped); thesis Table 2.IV).
    NormalMap = 4,
}

impl Shadowing {
    /// Every model, in the order of [`code`](Self::code).
    pub const ALL: [Self; 5] = [Self::None, Self::Smith, Self::Correlated, Self::CorrelatedSimple, Self::NormalMap];

    /// The models that are compared and timed in the renderer: those of displaced surfaces but the simple form.
    pub const MAIN: [Self; 3] = [Self::None, Self::Smith, Self::Correlated];

    /// Its `LEADR_SHADOWING_` number in `leadr/masking/correlated.glsl`.
    pub const fn code(self) -> i32 {
        self as i32
    }

    /// The model's name on the command line and in JSON; "masking" for no shadowing, since masking remains.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "masking",
            Self::Smith => "smith",
            Self::Correlated => "correlated",
            Self::CorrelatedSimple => "correlated-simple",
            Self::NormalMap => "normal-map",
        }
    }

    /// What the model does, in one line.
    pub const fn help(self) -> &'static str {
        match self {
            Self::None => "None: every facet that the viewer sees is lit, as in the LEADR paper",
            Self::Smith => "Shadowing that is correlated with masking by height (Smith)",
            Self::Correlated => "Shadowing that is correlated with masking by height and direction",
            Self::CorrelatedSimple => "The same, by a simpler formula",
            Self::NormalMap => {
                "Normal mapping: relief hides nothing, not even from the viewer; the default of a normal map alone"
            }
        }
    }

    /// The next entry of [`MAIN`](Self::MAIN), wrapping around at the end.
    #[must_use]
    pub fn next(self) -> Self {
        let after = Self::MAIN.iter().position(|&model| model == self).map_or(0, |i| i + 1);
        Self::MAIN[after % Self::MAIN.len()]
    }
}
