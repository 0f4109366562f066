//! The shadowing models.

/// The model for the lit fraction of the visible facets. The numbers equal the `LEADR_SHADOWING_` constants in
/// `leadr/masking/correlated.glsl`. Shader tests compare the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shadowing {
    /// Only masking, so all visible facets are lit (the simplified algorithms of LEADR's supplement).
    None = 0,
    /// Smith's height-correlated form (LEADR eq. 13, Algorithm 1).
    Smith = 1,
    /// The direction-correlated form ([`correlated`](super::correlated)).
    Correlated = 2,
    /// The simple direction-correlated form, which is cheaper and less accurate.
    CorrelatedSimple = 3,
    /// A normal map on smooth geometry, without masking or shadowing, so that all front-facing facets are lit and weighted equally
    /// ([`mapped`](crate::visible::mapped); thesis Table 2.IV).
    NormalMap = 4,
    /// Smith's form with independent masking and shadowing, `G = G₁(o) G₁(i)` (Walter et al. 2007).
    SmithSeparable = 5,
    /// Symmetric V-grooves, which hide a part of each facet ([`grooves`](super::grooves); Torrance and Sparrow 1967).
    VGroove = 6,
}

impl Shadowing {
    /// Every model, in the order of [`code`](Self::code).
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Smith,
        Self::Correlated,
        Self::CorrelatedSimple,
        Self::NormalMap,
        Self::SmithSeparable,
        Self::VGroove,
    ];

    /// The models that the window cycles through, and that the benchmark times.
    pub const MAIN: [Self; 3] = [Self::None, Self::Smith, Self::Correlated];

    /// Returns the model's `LEADR_SHADOWING_` number in `leadr/masking/correlated.glsl`.
    pub const fn code(self) -> i32 {
        self as i32
    }

    /// Returns the model's name on the command line and in JSON. [`Shadowing::None`] has the name "masking", because masking remains.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "masking",
            Self::Smith => "smith",
            Self::Correlated => "correlated",
            Self::CorrelatedSimple => "correlated-simple",
            Self::NormalMap => "normal-map",
            Self::SmithSeparable => "separable",
            Self::VGroove => "v-groove",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::None => "No shadowing: all visible facets are lit, as in the LEADR paper",
            Self::Smith => "Smith shadowing, height-correlated with masking",
            Self::Correlated => "Smith shadowing, correlated with masking by height and direction",
            Self::CorrelatedSimple => "The direction-correlated model with a simpler formula",
            Self::NormalMap => {
                "Normal mapping: no masking or shadowing; the default for a normal map without displacement"
            }
            Self::SmithSeparable => "Smith masking and Smith shadowing, as if they were independent",
            Self::VGroove => "Symmetric V-grooves (Torrance and Sparrow), summed over a grid of slopes (--grid)",
        }
    }

    /// Returns the next entry of [`MAIN`](Self::MAIN), wrapping around at the end.
    #[must_use]
    pub fn next(self) -> Self {
        let after = Self::MAIN.iter().position(|&model| model == self).map_or(0, |i| i + 1);
        Self::MAIN[after % Self::MAIN.len()]
    }
}
