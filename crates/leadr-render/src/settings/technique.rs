//! The table of techniques. Each technique is declared only here.
//!
//! A new technique needs a row here and a line in `docs/guide/techniques.md`. If no [`Family`] shades it yet, it also needs a
//! constant and a function in `shaders-glsl/passes/shade/families.glsl`. The command line, help, JSON, window keys, report and
//! bench all read the table. Shaders receive only the inputs of a technique ([`Needs`]), never its name.

use super::shading::PixelKernel;
use super::shading_options::ShadingOptions;
use leadr_gpu::SpecValue;
use leadr_reflectance::integrals::slope_nodes::NodePlacement;
use leadr_shaders::families;

/// The table's entry for one technique.
struct Row {
    /// Returns the name on the command line and in JSON.
    name: &'static str,
    /// The line of the technique in `--help`.
    help: &'static str,
    /// Returns the technique's key in the window.
    key: char,
    family: Family,
    slopes: Slopes,
    /// The distribution of the facets of the base material.
    base: Base,
    /// Whether the setting `pixel_kernel` applies.
    pixel_kernel: bool,
}

/// A distribution of facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Base {
    Beckmann,
    /// The base is GGX, and the relief Gaussian.
    Ggx,
    /// The base and the relief together have Phong's distribution.
    Phong,
}

/// Returns the row of a technique that has a Beckmann base and no pixel kernel.
const fn row(name: &'static str, key: char, family: Family, slopes: Slopes, help: &'static str) -> Row {
    Row { name, help, key, family, slopes, base: Base::Beckmann, pixel_kernel: false }
}

#[rustfmt::skip]
impl Row {
    const fn ggx(self) -> Self { Self { base: Base::Ggx, ..self } }
    const fn phong(self) -> Self { Self { base: Base::Phong, ..self } }
    const fn pixel_kernel(self) -> Self { Self { pixel_kernel: true, ..self } }
}

/// The function that shades the pixels of a technique, as a `FAMILY_` constant of `passes/shade/families.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Returns the albedo, without light.
    Unlit = families::UNLIT,
    /// Evaluates a Blinn-Phong lobe about the mean normal.
    BlinnPhong = families::BLINN_PHONG,
    /// Evaluates a Blinn-Phong lobe that is rougher for shorter filtered normals.
    Toksvig = families::TOKSVIG,
    /// Evaluates a Beckmann lobe over the slopes, without projected areas.
    Lean = families::LEAN,
    /// Integrates over the visible slopes.
    Leadr = families::LEADR,
    /// Evaluates a GGX lobe about the mean normal, with roughness from the length of filtered normals, which the base roughness
    /// shortens.
    Gloss = families::GLOSS,
}

/// The slope statistics that a technique receives per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Slopes {
    /// Receives no statistics, so surfaces are smooth.
    None,
    /// Receives the mean slope.
    Mean,
    /// Receives the mean slope and the slope covariance.
    Covariance,
    /// Receives the mean slope, and one variance for all directions.
    Isotropic,
    /// Receives the mean slope, and the largest variance along any direction for all directions.
    Largest,
    /// Receives the finest level of the maps at every distance. The samples per pixel do the filtering.
    Finest,
}

macro_rules! techniques {
    ($($(#[$doc:meta])* $technique:ident = $row:expr;)*) => {
        /// A technique that filters and shades surfaces.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Technique {
            $($(#[$doc])* $technique,)*
        }

        impl Technique {
            /// All techniques, simplest first.
            pub const ALL: [Self; Self::COUNT] = [$(Self::$technique),*];
            const COUNT: usize = [$(Self::$technique),*].len();

            const fn row(self) -> Row {
                match self {
                    $(Self::$technique => $row,)*
                }
            }
        }
    };
}

techniques! {
    /// The albedo without light, which shows the cost of the geometry and of filtering the colours.
    Constant = row("constant", '9', Family::Unlit, Slopes::None, "Albedo without light");
    /// Mipmapped normals, shaded with a normalised Blinn-Phong lobe.
    BlinnPhong = row("blinn-phong", '7', Family::BlinnPhong, Slopes::Mean, "Mipmapped normals, Blinn-Phong");
    /// Mipmapped normals, shaded with the LEADR BRDF from the mean slope alone.
    NormalMip = row("normal-mip", '2', Family::Leadr, Slopes::Mean,
        "Mipmapped normals, LEADR BRDF without slope statistics");
    /// Mipmapped normals, whose length gives the roughness (Toksvig 2005).
    Toksvig = row("toksvig", '6', Family::Toksvig, Slopes::Covariance,
        "Mipmapped normals, roughness from their length");
    /// Mipmapped normals, shaded with a GGX lobe. The roughness shortens the normals, and is recovered from their mean length (Chan
    /// 2018). The length is that of Gaussian slopes with the covariance of the footprint.
    Gloss = row("gloss", 'y', Family::Gloss, Slopes::Covariance,
        "Normals shortened by roughness, GGX lobe from their length (Call of Duty: WWII)").ggx();
    /// A single slope variance for all directions (CLEAN mapping, Baker 2011).
    Clean = row("clean", '5', Family::Lean, Slopes::Isotropic, "One slope variance for all directions (CLEAN mapping)");
    /// The largest slope variance along any direction, so that no direction has too little
    /// ([`leadr_reflectance::slopes::packing::pack_clean_conservative`]).
    CleanConservative = row("clean-conservative", 'k', Family::Lean, Slopes::Largest,
        "The largest slope variance for all directions, which never aliases (CLEAN mapping)");
    /// A slope covariance, shaded with a Beckmann lobe without projected areas (LEAN mapping, Olano & Baker 2010).
    Lean = row("lean", '4', Family::Lean, Slopes::Covariance,
        "Slope covariance without projected areas (LEAN mapping)");
    /// LEADR mapping, with the mean slope and the slope covariance of each pixel.
    Leadr = row("leadr", '1', Family::Leadr, Slopes::Covariance,
        "Slope covariance and projected areas (LEADR mapping)").pixel_kernel();
    /// LEADR mapping of a GGX base, which is represented by two lobes.
    LeadrGgx = row("leadr-ggx", '8', Family::Leadr, Slopes::Covariance,
        "LEADR mapping of a GGX base").ggx().pixel_kernel();
    /// LEADR mapping of facets with Phong's distribution of normals ([`leadr_reflectance::integrals::phong`]).
    LeadrPhong = row("leadr-phong", 'j', Family::Leadr, Slopes::Covariance,
        "LEADR mapping of facets with Phong's distribution").phong().pixel_kernel();
    /// The finest level of the maps, without slope statistics. The result is correct with enough samples per pixel.
    Reference = row("reference", '3', Family::Leadr, Slopes::Finest,
        "The finest map level at every distance: correct with enough samples per pixel");
    /// The reference for a GGX base, with which [`LeadrGgx`](Self::LeadrGgx) can be compared.
    ReferenceGgx = row("reference-ggx", '0', Family::Leadr, Slopes::Finest,
        "The reference with a GGX base, for comparison with leadr-ggx").ggx();
    /// The reference for a Phong base, with which [`LeadrPhong`](Self::LeadrPhong) can be compared.
    ReferencePhong = row("reference-phong", 'z', Family::Leadr, Slopes::Finest,
        "The reference with a Phong base, for comparison with leadr-phong").phong();
}

impl Technique {
    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns a description of one line.
    pub const fn help(self) -> &'static str {
        self.row().help
    }

    /// Returns the technique's key in the window.
    pub const fn key(self) -> char {
        self.row().key
    }

    /// Whether the technique is lit.
    pub fn is_lit(self) -> bool {
        self.row().family != Family::Unlit
    }

    /// Whether the technique integrates over the visible slopes.
    pub fn integrates(self) -> bool {
        self.row().family == Family::Leadr
    }

    /// Whether the setting [`base_frame`](super::ShadingOptions::base_frame) applies.
    pub fn has_base_frame(self) -> bool {
        self.integrates() && self.row().base == Base::Beckmann
    }

    /// Whether the setting [`diffuse_model`](super::ShadingOptions::diffuse_model) applies.
    pub fn has_diffuse_model(self) -> bool {
        // LEADR's GGX and Phong bases are excluded. At grazing angles, its lobes reflect more of the environment than the GGX of the energy
        // tables.
        self.has_base_frame() || self.row().family == Family::Gloss
    }

    /// Whether the settings of occlusion cones, such as [`cone_edge`](super::ShadingOptions::cone_edge), apply.
    pub fn has_cones(self) -> bool {
        self.integrates() || self.row().family == Family::Gloss
    }

    /// Whether the setting [`pixel_kernel`](super::ShadingOptions::pixel_kernel) applies.
    pub const fn has_pixel_kernel(self) -> bool {
        self.row().pixel_kernel
    }

    /// Whether the technique reads the finest level of the maps, and leaves the filtering to the samples per pixel.
    pub fn is_reference(self) -> bool {
        self.row().slopes == Slopes::Finest
    }

    /// Whether the setting [`relief_shadows`](super::ShadingOptions::relief_shadows) applies.
    pub fn has_relief_shadows(self) -> bool {
        self.is_reference() && self.row().base == Base::Beckmann
    }

    /// Whether the base material is GGX instead of Beckmann.
    pub fn has_ggx_base(self) -> bool {
        self.row().base == Base::Ggx
    }

    /// Returns the reference that has the same base material.
    #[must_use]
    pub fn reference(self) -> Self {
        match self.row().base {
            Base::Beckmann => Self::Reference,
            Base::Ggx => Self::ReferenceGgx,
            Base::Phong => Self::ReferencePhong,
        }
    }

    /// Whether the settings [`relief_color`](super::ShadingOptions::relief_color) and [`classes`](super::ShadingOptions::classes) apply.
    pub fn has_relief_color(self) -> bool {
        self.row().family == Family::Leadr && self.row().slopes == Slopes::Covariance
    }

    /// Returns the inputs of the technique with these options.
    pub(super) fn needs(self, options: ShadingOptions) -> Needs {
        let Row { family, slopes, base, pixel_kernel: has_kernel, .. } = self.row();
        Needs {
            family,
            slopes,
            base,
            kernel: if has_kernel { options.pixel_kernel } else { PixelKernel::Off },
            tilt: family == Family::Leadr
                && (options.pixel_kernel != PixelKernel::Off || !has_kernel)
                && options.grid_nodes != NodePlacement::Micronormal,
            horizon: family == Family::Leadr && options.relief_occlusion,
        }
    }
}

/// The inputs that a technique needs from the passes between filtering and shading, which are the cache key of the pipelines that
/// depend on nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Needs {
    family: Family,
    slopes: Slopes,
    base: Base,
    kernel: PixelKernel,
    tilt: bool,
    horizon: bool,
}

impl Needs {
    /// Returns the specialisation constants of `passes/technique.glsl`.
    #[must_use]
    pub fn spec(self) -> Vec<(&'static str, SpecValue)> {
        let covariance =
            matches!(self.slopes, Slopes::Covariance | Slopes::Isotropic | Slopes::Largest | Slopes::Finest);
        vec![
            ("FAMILY", SpecValue::I32(self.family as i32)),
            ("USES_SLOPES", SpecValue::Bool(self.slopes != Slopes::None)),
            ("USES_COVARIANCE", SpecValue::Bool(covariance)),
            ("ISOTROPIC_COVARIANCE", SpecValue::Bool(matches!(self.slopes, Slopes::Isotropic | Slopes::Largest))),
            ("LARGEST_VARIANCE", SpecValue::Bool(self.slopes == Slopes::Largest)),
            ("FINEST_LEVEL", SpecValue::Bool(self.is_finest())),
            ("GGX_BASE", SpecValue::Bool(self.base == Base::Ggx)),
            ("PHONG_FACETS", SpecValue::Bool(self.base == Base::Phong)),
            ("USES_CURVATURE", SpecValue::Bool(self.kernel != PixelKernel::Off)),
            ("PER_LIGHT_KERNEL", SpecValue::Bool(self.kernel == PixelKernel::HalfVector)),
            ("TILTS_TO_EDGE", SpecValue::Bool(self.tilt)),
            ("USES_HORIZON", SpecValue::Bool(self.horizon)),
            ("DETAIL_IN_GLOSS", SpecValue::Bool(self.family == Family::Gloss)),
        ]
    }

    /// Whether the technique reads the finest level of the maps at every distance.
    pub fn is_finest(self) -> bool {
        self.slopes == Slopes::Finest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_keys_are_distinct() {
        for (i, a) in Technique::ALL.iter().enumerate() {
            for b in &Technique::ALL[..i] {
                assert!(a.name() != b.name() && a.key() != b.key(), "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn settings_affect_only_their_techniques() {
        let off = ShadingOptions { pixel_kernel: PixelKernel::Normal, relief_occlusion: false, ..Default::default() };
        for technique in Technique::ALL {
            let differs = |options| technique.needs(options) != technique.needs(off);
            for pixel_kernel in [PixelKernel::Off, PixelKernel::HalfVector] {
                assert_eq!(differs(ShadingOptions { pixel_kernel, ..off }), technique.has_pixel_kernel());
            }
            assert_eq!(differs(ShadingOptions { relief_occlusion: true, ..off }), technique.integrates());
        }
    }
}
