//! Content of a baked texel: the kinds of maps, and the layouts of other programs.

/// Kind of baked map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kind {
    /// LEADR mapping (LEADR section 4): `E[x], E[y], E[x²], E[y²], E[xy]` of `dh/ds`, `dh/dt`, and mean height. The surface
    /// between texels consists of the drawn triangles.
    #[default]
    Leadr,
    /// LEAN mapping (Olano and Baker 2010): `B = n.xy / n.z` of one normal per texel in the tangent frame of the base, y up; its
    /// second moments `M`; mean height.
    Lean,
    /// CLEAN mapping (Baker 2011): `B`, one second moment `E[B.x² + B.y²]`, and mean height.
    Clean,
    /// Toksvig (2005): the mean normal, shortened by variation of the normals, and mean height.
    Toksvig,
    /// Unit normals in the tangent frame of the base, y up. Levels hold renormalised mean normals.
    Normal,
    /// Normals and gloss (Chan 2018, section 2.2). Levels average normals that roughness shortens: the mean's direction is the
    /// normal, and its length gives the gloss.
    Gloss,
    /// Heights.
    Height,
    /// Ambient occlusion: the visible, cosine-weighted share of the surroundings.
    Occlusion,
    /// Visibility cones: the mean open direction in the tangent frame of the base, y up, longer for a narrower cone
    /// ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)), and the visible share.
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

    /// The name on the command line and in files.
    pub const fn name(self) -> &'static str {
        self.name_and_channels().0
    }

    /// Ordered channel names. Optional channels follow: `alpha2`, `alpha4` (means of α² and α⁴), `red`, `green`, `blue`.
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

    /// Whether texels contain slope variance. If so, roughness gets its own channels. Kind gloss includes roughness; other kinds
    /// ignore it.
    pub const fn stores_variance(self) -> bool {
        matches!(self, Self::Leadr | Self::Lean | Self::Clean | Self::Toksvig)
    }

    /// Whether an input colour is stored too. Kinds that engines use as single-purpose textures omit it.
    pub const fn has_color(self) -> bool {
        !matches!(self, Self::Height | Self::Occlusion | Self::Cones)
    }

    /// Exponent of the slope in each channel; `None` for heights.
    pub(super) fn power(self, channel: usize) -> Option<i32> {
        match (self, self.channels()[channel]) {
            (_, "height") => None,
            (Self::Toksvig | Self::Normal | Self::Gloss | Self::Occlusion | Self::Cones, _) => Some(0),
            (_, name) if name.starts_with("B.") || name.len() == 1 && name != "M" => Some(1),
            _ => Some(2),
        }
    }

    /// Total slope variance of a texel, at least 0; 0 for kinds without variance.
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
                // Toksvig's σ² per axis, (1 - |N|) / |N|.
                2.0 * (1.0 - length) / length
            }
            _ => 0.0,
        };
        variance.max(0.0)
    }
}

/// Channel layout of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Layout {
    /// The channels of [`Kind::channels`].
    #[default]
    Leadr,
    /// The six channels of `maketx --bumpslopes` (OpenImageIO): height, slopes and their second moments, per texel.
    Oiio,
}

/// Channels of [`Layout::Oiio`], in `maketx` order and naming.
pub(super) const OIIO_CHANNELS: [&str; 6] = ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];

/// Last channel of 16-bit files with heights: the rounding residual of `height`. Displacement by 16-bit heights alone has visible
/// steps and misplaces texels.
pub(crate) const HEIGHT_REST: &str = "height.rest";

/// Meaning of a texel of the finest gloss level (Chan 2018, section 2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Texels {
    /// A plane with one normal: the finest level is as painted.
    #[default]
    Facets,
    /// A sample of a smooth surface. Normal variation towards neighbouring texels counts as roughness on the finest level too.
    Smooth,
}

/// Number format of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit float.
    #[default]
    F32,
    /// 16-bit float. Power-of-two factors, recorded in the file, make channels fill its range.
    F16,
    /// Blocks of 4 x 4 texels, 8 bits per number. Second moments are stored as deviations and correlation. KTX2 only.
    Bc,
}

impl Precision {
    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Bc => "bc",
        }
    }

    /// Bytes of one float.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F16 => 2,
            Self::Bc => 1,
        }
    }
}
