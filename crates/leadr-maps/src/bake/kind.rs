//! What a baked texel holds: the kinds of maps, and the layout of other programs.

/// What is kept of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kind {
    /// LEADR mapping (LEADR section 4): `E[x], E[y], E[x²], E[y²], E[xy]` of `dh/ds`, `dh/dt`, and mean height. Heights are
    /// triangles between texels, as they are drawn.
    #[default]
    Leadr,
    /// LEAN mapping (Olano and Baker 2010): `B = n.xy / n.z` of one normal for a texel, in the tangent frame of the base with y up, and
    /// its second moments `M`; mean height.
    Lean,
    /// CLEAN mapping (Baker 2011): `B`, one second moment `E[B.x² + B.y²]`, and mean height.
    Clean,
    /// Toksvig (2005): the mean normal, shorter where normals differ, and mean height.
    Toksvig,
    /// Normals in the tangent frame of the base with y up. Levels hold mean normals, made as long as before.
    Normal,
    /// Normals and gloss (Chan 2018, section 2.2): levels hold the direction of the mean of normals that are the shorter the rougher they
    /// are, and the gloss that its length stands for.
    Gloss,
    /// Heights.
    Height,
    /// Occlusion as textures have it: the share of the surroundings, weighted by the cosine, that is seen past the relief.
    Occlusion,
    /// Where that share lies: the mean direction in which a texel is open, as long as the cone about it is narrow, in the tangent frame of
    /// the base with y up ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)), and the share itself.
    Cones,
}

impl Kind {
    /// All of them.
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

    /// Its name on the command line and in files.
    pub const fn name(self) -> &'static str {
        self.name_and_channels().0
    }

    /// Its channels, in their order. More may follow: `alpha2`, `alpha4` (means of α² and α⁴), `red`, `green`, `blue`.
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

    /// Whether its texels tell how much slopes differ under them. Roughness then has channels beside them; gloss has it within, and
    /// others have no use for it.
    pub const fn tells_variance(self) -> bool {
        matches!(self, Self::Leadr | Self::Lean | Self::Clean | Self::Toksvig)
    }

    /// Whether colour stands beside its channels, if there is one. What engines keep as textures of one purpose is left alone.
    pub const fn has_color(self) -> bool {
        !matches!(self, Self::Height | Self::Occlusion | Self::Cones)
    }

    /// The power of a slope that each channel has; heights have `None`.
    pub(super) fn power(self, channel: usize) -> Option<i32> {
        match (self, self.channels()[channel]) {
            (_, "height") => None,
            (Self::Toksvig | Self::Normal | Self::Gloss | Self::Occlusion | Self::Cones, _) => Some(0),
            (_, name) if name.starts_with("B.") || name.len() == 1 && name != "M" => Some(1),
            _ => Some(2),
        }
    }

    /// Total variance of slope that a texel tells, not below zero; 0 for kinds that tell none.
    pub fn variance(self, texel: &[f64]) -> f64 {
        if !self.tells_variance() {
            return 0.0;
        }
        let square = texel[0] * texel[0] + texel[1] * texel[1];
        let variance = match self {
            Self::Leadr | Self::Lean => texel[2] + texel[3] - square,
            Self::Clean => texel[2] - square,
            Self::Toksvig => {
                let length = (square + texel[2] * texel[2]).sqrt().max(1e-6);
                // Toksvig's σ² of one axis, (1 - |N|) / |N|.
                2.0 * (1.0 - length) / length
            }
            _ => 0.0,
        };
        variance.max(0.0)
    }
}

/// Whose layout the file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Layout {
    /// The channels of [`Kind::channels`].
    #[default]
    Leadr,
    /// The six channels that `maketx --bumpslopes` of OpenImageIO writes: height, slopes and their second moments, per texel.
    Oiio,
}

/// Channels of [`Layout::Oiio`], in the order and with the names that `maketx` gives them.
pub(super) const OIIO_CHANNELS: [&str; 6] = ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"];

/// In files of 16 bits, the last channel of maps with heights: what they leave over of `height`. A surface that is displaced by so few bits has
/// steps, and texels are seen where they are not.
pub(crate) const HEIGHT_REST: &str = "height.rest";

/// What a texel of the finest level of a gloss map is (Chan 2018, section 2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Texels {
    /// A plane with one normal: the finest level is what the artist painted.
    #[default]
    Facets,
    /// A sample of a smooth surface, whose normals change towards the next texels: that spread counts as roughness on the finest level, too.
    Smooth,
}

/// Width of a number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit float.
    #[default]
    F32,
    /// 16-bit float. Channels are multiplied by powers of two, which the file tells, so that they fill its range.
    F16,
    /// Blocks of 4 x 4 texels, 8 bits for a number, whose second moments are kept as deviations and correlation. KTX2 only.
    Bc,
}

impl Precision {
    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Bc => "bc",
        }
    }

    /// Bytes of a number of floats.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F16 => 2,
            Self::Bc => 1,
        }
    }
}
