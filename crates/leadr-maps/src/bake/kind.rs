//! Content of a baked texel: the kinds of maps, and the channel layouts of other programs.

/// Kind of baked map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kind {
    /// LEADR mapping (LEADR section 4): `E[x], E[y], E[x²], E[y²], E[xy]` of the slopes `dh/ds`, `dh/dt`, and the mean height.
    /// The surface between texels consists of the drawn triangles.
    #[default]
    Leadr,
    /// LEAN mapping (Olano and Baker 2010): `B = n.xy / n.z` for one normal per texel in the tangent frame of the base, y up;
    /// its second moments `M`; and the mean height.
    Lean,
    /// CLEAN mapping (Baker 2011): `B`, one second moment `E[B.x² + B.y²]`, and mean height.
    Clean,
    /// Toksvig (2005): the mean normal, shortened by the variation of the normals, and the mean height.
    Toksvig,
    /// Unit normals in the tangent frame of the base, y up. Mip levels hold renormalised mean normals.
    Normal,
    /// Normals and gloss (Chan 2018, section 2.2). Mip levels average normals that are shortened by roughness. The direction of
    /// the average is the normal, and its length gives the gloss.
    Gloss,
    /// Heights.
    Height,
    /// Ambient occlusion: the visible, cosine-weighted fraction of the hemisphere.
    Occlusion,
    /// Visibility cones: the mean open direction in the tangent frame of the base, y up, and the visible fraction. The vector
    /// is longer for a narrower cone ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)).
    Cones,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Leadr,
        Self::Lean,
        Self::Clean,
        Self::Toksvig,
        Self::Normal,
        Self::Gloss,
        Self::Height,
        Self::Occlusion,
        Self::Cones,
    ];

    /// Returns the name on the command line and in files.
    pub const fn name(self) -> &'static str {
        self.name_and_channels().0
    }

    /// Returns the channel names in order. Optional channels follow: `alpha2`, `alpha4` (means of α² and α⁴), `red`, `green`,
    /// `blue`.
    pub const fn channels(self) -> &'static [&'static str] {
        self.name_and_channels().1
    }

    const fn name_and_channels(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Leadr => ("leadr", &["x", "y", "xx", "yy", "xy", "height"]),
            Self::Lean => ("lean", &["B.x", "B.y", "M.xx", "M.yy", "M.xy", "height"]),
            Self::Clean => ("clean", &["B.x", "B.y", "M", "height"]),
            Self::Toksvig => ("toksvig", &["N.x", "N.y", "N.z", "height"]),
            Self::Normal => ("normal", &["N.x", "N.y", "N.z"]),
            Self::Gloss => ("gloss", &["N.x", "N.y", "N.z", "gloss"]),
            Self::Height => ("height", &["height"]),
            Self::Occlusion => ("occlusion", &["occlusion"]),
            Self::Cones => ("cones", &["C.x", "C.y", "C.z", "occlusion"]),
        }
    }

    /// Whether texels contain slope variance. Roughness has separate channels in these kinds, is part of the gloss in kind
    /// gloss, and is ignored in all others.
    pub const fn stores_variance(self) -> bool {
        matches!(self, Self::Leadr | Self::Lean | Self::Clean | Self::Toksvig)
    }

    /// Whether an input colour is stored too. Kinds that engines use as single-purpose textures omit the colour.
    pub const fn has_color(self) -> bool {
        !matches!(self, Self::Height | Self::Occlusion | Self::Cones)
    }

    /// Returns the exponent of the slope in a channel, or `None` for heights.
    pub(super) fn power(self, channel: usize) -> Option<i32> {
        match (self, self.channels()[channel]) {
            (_, "height") => None,
            (Self::Toksvig | Self::Normal | Self::Gloss | Self::Occlusion | Self::Cones, _) => Some(0),
            (_, name) if name.starts_with("B.") || name.len() == 1 && name != "M" => Some(1),
            _ => Some(2),
        }
    }

    /// Returns the total slope variance of a texel, at least 0. Kinds without variance return 0.
    pub fn variance(self, texel: &[f64]) -> f64 {
        if !self.stores_variance() {
            return 0.0;
        }
        let square = texel[0] * texel[0] + texel[1] * texel[1];
        let variance = match self {
            Self::Leadr | Self::Lean => texel[2] + texel[3] - square,
            Self::Clean => texel[2] - square,
            Self::Toksvig => {
                let length = (square + texel[2] * texel[2]).sqrt().max(1e-6);
                // Toksvig's σ² per axis is (1 - |N|) / |N|.
                2.0 * (1.0 - length) / length
            }
            _ => 0.0,
        };
        variance.max(0.0)
    }
}

/// Channel layout of a baked file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Layout {
    /// The channels of [`Kind::channels`].
    #[default]
    Leadr,
    /// The six channels of `maketx --bumpslopes` (OpenImageIO): height, slopes per texel, and second moments of the slopes.
    Oiio,
}

/// Channel names of [`Layout::Oiio`], in the order of `maketx`.
pub(super) const OIIO_CHANNELS: [&str; 6] = ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];

/// Name of the last channel of 16-bit files with heights, which stores the rounding residual of `height`. Displacement by
/// 16-bit heights alone has visible steps and misplaces texels.
pub(crate) const HEIGHT_REST: &str = "height.rest";

/// Meaning of a texel of the finest gloss level (Chan 2018, section 2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Texels {
    /// The texel is a plane with one normal, so the finest level is stored as painted.
    #[default]
    Facets,
    /// The texel is a sample of a smooth surface. Normal variation towards neighbouring texels counts as roughness even on the
    /// finest level.
    Smooth,
}

/// Number format of a baked file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit float.
    #[default]
    F32,
    /// 16-bit float. Power-of-two factors, which the file records, scale the channels to fill the range of the format.
    F16,
    /// Blocks of 4 x 4 texels with 8 bits per number. Second moments are stored as deviations and correlation. Only KTX2
    /// supports blocks.
    Bc,
}

impl Precision {
    /// Returns the name on the command line.
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
