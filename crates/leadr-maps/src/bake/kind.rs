//! What a texel of a baked map contains: the kinds of maps, and the channel layouts of other programs.

/// The kind of a baked map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kind {
    /// LEADR mapping (LEADR section 4). A texel stores `E[x], E[y], E[x²], E[y²], E[xy]` of the slopes `dh/ds`, `dh/dt`, and
    /// the mean height. The surface between texels consists of the drawn triangles.
    #[default]
    Leadr,
    /// LEAN mapping (Olano and Baker 2010). A texel stores the mean height, `B = n.xy / n.z` for one normal per texel, and
    /// the second moments `M` of `B`. `B` is in the tangent frame of the base with y up.
    Lean,
    /// CLEAN mapping (Baker 2011). A texel stores `B`, one second moment `E[B.x² + B.y²]`, and the mean height.
    Clean,
    /// Conservative CLEAN mapping ([`pack_clean_conservative`](leadr_reflectance::slopes::packing::pack_clean_conservative)). A texel
    /// stores `B`, `|E[B]|² + λ` with the larger principal variance `λ` of `B`, and the mean height.
    CleanConservative,
    /// Toksvig maps (2005). A texel stores the mean height and the mean normal, which is shorter where normals vary more.
    Toksvig,
    /// Unit normals in the tangent frame of the base, y up. Mip levels hold renormalised mean normals.
    Normal,
    /// Normals and gloss (Chan 2018, section 2.2). Mip levels average normals that are shortened by roughness. The direction of
    /// the average is the normal, and its length gives the gloss.
    Gloss,
    /// Heights only.
    Height,
    /// Ambient occlusion: the visible, cosine-weighted fraction of the hemisphere.
    Occlusion,
    /// Visibility cones. A texel stores the mean open direction in the tangent frame of the base with y up, and the visible
    /// fraction. The vector is longer for a narrower cone
    /// ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)).
    Cones,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 10] = [
        Self::Leadr,
        Self::Lean,
        Self::Clean,
        Self::CleanConservative,
        Self::Toksvig,
        Self::Normal,
        Self::Gloss,
        Self::Height,
        Self::Occlusion,
        Self::Cones,
    ];

    /// Returns the name that the command line and files use.
    pub const fn name(self) -> &'static str {
        self.name_and_channels().0
    }

    /// Returns the names of the required channels in order. The optional channels follow in a file: `alpha2` and `alpha4`
    /// (means of α² and α⁴), `red`, `green`, `blue`.
    pub const fn channels(self) -> &'static [&'static str] {
        self.name_and_channels().1
    }

    const fn name_and_channels(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Leadr => ("leadr", &["x", "y", "xx", "yy", "xy", "height"]),
            Self::Lean => ("lean", &["B.x", "B.y", "M.xx", "M.yy", "M.xy", "height"]),
            Self::Clean => ("clean", &["B.x", "B.y", "M", "height"]),
            Self::CleanConservative => ("clean-conservative", &["B.x", "B.y", "M", "height"]),
            Self::Toksvig => ("toksvig", &["N.x", "N.y", "N.z", "height"]),
            Self::Normal => ("normal", &["N.x", "N.y", "N.z"]),
            Self::Gloss => ("gloss", &["N.x", "N.y", "N.z", "gloss"]),
            Self::Height => ("height", &["height"]),
            Self::Occlusion => ("occlusion", &["occlusion"]),
            Self::Cones => ("cones", &["C.x", "C.y", "C.z", "occlusion"]),
        }
    }

    /// Whether texels contain slope variance. Kinds with variance store roughness in separate channels. In kind gloss the
    /// roughness is part of the gloss, and all other kinds ignore roughness.
    pub const fn stores_variance(self) -> bool {
        matches!(self, Self::Leadr | Self::Lean | Self::Clean | Self::CleanConservative | Self::Toksvig)
    }

    /// Whether the map also stores an input colour. Maps without colour are single-purpose textures in engines.
    pub const fn has_color(self) -> bool {
        !matches!(self, Self::Height | Self::Occlusion | Self::Cones)
    }

    /// Returns the power of the slope that a channel stores, or `None` for heights.
    pub(super) fn power(self, channel: usize) -> Option<i32> {
        match (self, self.channels()[channel]) {
            (_, "height") => None,
            (Self::Toksvig | Self::Normal | Self::Gloss | Self::Occlusion | Self::Cones, _) => Some(0),
            (_, name) if name.starts_with("B.") || name.len() == 1 && name != "M" => Some(1),
            _ => Some(2),
        }
    }

    /// Returns the total slope variance of a texel, which is at least 0. For kinds without variance the result is 0.
    pub fn variance(self, texel: &[f64]) -> f64 {
        if !self.stores_variance() {
            return 0.0;
        }
        let square = texel[0] * texel[0] + texel[1] * texel[1];
        let variance = match self {
            Self::Leadr | Self::Lean => texel[2] + texel[3] - square,
            Self::Clean => texel[2] - square,
            // The variance is that of one axis, and stands for both.
            Self::CleanConservative => 2.0 * (texel[2] - square),
            Self::Toksvig => {
                let length = (square + texel[2] * texel[2]).sqrt().max(1e-6);
                // Toksvig's variance σ² is (1 - |N|) / |N| per axis, and there are two axes.
                2.0 * (1.0 - length) / length
            }
            _ => 0.0,
        };
        variance.max(0.0)
    }
}

/// The channel layout of a baked file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Layout {
    /// The channels that [`Kind::channels`] lists.
    #[default]
    Leadr,
    /// The six channels of `maketx --bumpslopes` (OpenImageIO): height, slopes per texel, and second moments of the slopes.
    Oiio,
}

/// The channel names of [`Layout::Oiio`], in the order of `maketx`.
pub(super) const OIIO_CHANNELS: [&str; 6] = ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];

/// The name of the last channel of 16-bit files with heights, which stores the rounding residual of `height`. Displacement
/// by 16-bit heights alone has visible steps and misplaces texels.
pub(crate) const HEIGHT_REST: &str = "height.rest";

/// What a texel of the finest gloss level represents (Chan 2018, section 2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Texels {
    /// The texel is a flat facet with one normal, so the finest level is stored as painted.
    #[default]
    Facets,
    /// The texel is a sample of a smooth surface. Normal variation towards neighbouring texels counts as roughness even on the
    /// finest level.
    Smooth,
}

/// The number format of a baked file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit floats.
    #[default]
    F32,
    /// 16-bit floats. The channels are scaled by power-of-two factors to fill the range of the format, and the file records
    /// the factors.
    F16,
    /// Blocks of 4 x 4 texels with 8 bits per number. Second moments are stored as deviations and correlation. Only KTX2
    /// supports blocks.
    Bc,
}

impl Precision {
    /// Returns the name that the command line uses.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Bc => "bc",
        }
    }

    /// Returns the number of bytes per float.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F16 => 2,
            Self::Bc => 1,
        }
    }
}
