//! The sea's own tables: the time of its passes by the size of the transforms and of the picture.

use super::rounds::TOTAL;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::ocean::waves::Waves;
use leadr_scenes::view::Size;

/// The passes that make the waves' maps; they do not depend on the picture.
pub const WAVES: &str = "wave rows+wave columns+wave mips";

/// A row of one of the sea's tables.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The table.
    pub table: &'static str,
    /// Its name there.
    pub name: String,
    /// The row it is compared with.
    pub base: String,
    /// The time that is compared.
    pub compared: &'static str,
    /// What is drawn.
    pub config: SceneConfig,
}

/// Sizes of transforms that are measured: samples along a tile's edge.
const TRANSFORMS: [u32; 4] = [64, 128, 256, 512];

/// The sea of `config` with every size of transform, then in pictures with half, once and twice its sides.
pub fn variants(config: &SceneConfig) -> Vec<Variant> {
    let name = |fft: u32| format!("fft {fft}");
    let mut variants: Vec<Variant> = TRANSFORMS
        .into_iter()
        .map(|fft| Variant {
            table: "ocean, transforms",
            name: name(fft),
            base: name(256),
            compared: WAVES,
            config: SceneConfig { waves: Waves { fft, ..config.waves }, ..config.clone() },
        })
        .collect();
    let Size { width, height } = config.size;
    let halves = |n: u32| Size { width: (width * n / 2).max(1), height: (height * n / 2).max(1) };
    let name = |size: Size| format!("{}x{}", size.width, size.height);
    variants.extend([1, 2, 4].into_iter().map(halves).map(|size| Variant {
        table: "ocean, pictures",
        name: name(size),
        base: name(config.size),
        compared: TOTAL,
        config: SceneConfig { size, ..config.clone() },
    }));
    variants
}
