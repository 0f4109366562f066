//! Reading baked KTX2 files back, level by level, with nothing believed that the file is too short to hold.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use half::f16;
use ktx2::{Format, Header, KeyValueDataIterator, LevelIndex};

use super::bake::{Kind, Precision};
use super::guard::guarded;
use super::moments::{LeadrMap, MomentLevel, Moments};
use super::{MapError, MapFault, Wrap, limits};

/// Most layers of four channels.
const MOST_LAYERS: u32 = 4;
/// Most bytes of keys.
const MOST_KEYS: u32 = 1 << 16;

/// A baked map. Values are as they were before the factors of 16-bit files were put on them.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMap {
    /// How slopes are kept.
    pub kind: Kind,
    /// Width of the numbers in the file.
    pub precision: Precision,
    /// Names of the channels: four for each layer, `-` for one that is not used.
    pub channels: Vec<String>,
    /// What lies beyond the edges.
    pub wrap: Wrap,
    /// Factor that heights were multiplied by.
    pub height_scale: f64,
    /// The levels, the largest first, down to 1 x 1.
    pub levels: Vec<BakedLevel>,
}

/// A level of a baked map.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedLevel {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// For each layer `width * height` texels of four channels, row-major.
    pub layers: Vec<Vec<[f32; 4]>>,
}

impl BakedMap {
    /// Reads a file that `leadr bake` wrote.
    ///
    /// # Errors
    /// If it cannot be read, is damaged, is KTX2 of another kind, or holds a number that is not finite (its place is named).
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MapError> {
        let path = path.as_ref();
        let io = |doing| move |source| MapFault::Io { doing, source };
        (|| {
            // Asked before opening: opening a pipe would wait for its writer.
            let metadata = std::fs::metadata(path).map_err(io("cannot be found"))?;
            if !metadata.is_file() {
                return Err(MapFault::NotAFile);
            }
            let mut file = File::open(path).map_err(io("cannot be opened"))?;
            guarded("KTX2", || read(&mut file, metadata.len()))
        })()
        .map_err(|fault| fault.in_file(path))
    }

    /// Reads it from memory; as [`load`](Self::load).
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn decode(bytes: &[u8]) -> Result<Self, MapFault> {
        guarded("KTX2", || read(&mut std::io::Cursor::new(bytes), bytes.len() as u64))
    }

    /// The moments of a LEADR map: those of [`LeadrMap::new`], to the last bit if the file has 32 bits. `None` for other kinds.
    #[must_use]
    pub fn moments(&self) -> Option<LeadrMap> {
        if self.kind != Kind::Leadr {
            return None;
        }
        let level = |level: &BakedLevel| {
            let texel = |(&[x, y, xx, yy], &[cross, height, ..]): (&[f32; 4], &[f32; 4])| Moments {
                mean_slope: [x, y],
                second: [xx, yy],
                cross,
                height,
            };
            let texels = level.layers[0].iter().zip(&level.layers[1]).map(texel).collect();
            MomentLevel { width: level.width, height: level.height, texels }
        };
        Some(LeadrMap { levels: self.levels.iter().map(level).collect() })
    }
}

trait ReadSeek: Read + Seek {}
impl<T: Read + Seek> ReadSeek for T {}

/// `length` bytes from `start`, if the file has them.
fn part(file: &mut dyn ReadSeek, file_length: u64, start: u64, length: u64, what: &str) -> Result<Vec<u8>, MapFault> {
    if start.checked_add(length).is_none_or(|end| end > file_length) {
        return Err(MapFault::damaged(format!("its {what} lies beyond the end of the file (truncated?)")));
    }
    let length = usize::try_from(length).map_err(|_| MapFault::damaged(format!("its {what} is too long")))?;
    let mut bytes = limits::zeroed::<u8>(length)?;
    let read = file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes));
    read.map_err(|source| MapFault::Io { doing: "cannot be read", source })?;
    Ok(bytes)
}

fn read(file: &mut dyn ReadSeek, length: u64) -> Result<BakedMap, MapFault> {
    let start = part(file, length, 0, (Header::LENGTH as u64).min(length), "header")?;
    if !start.starts_with(&ktx2::MAGIC) {
        return Err(MapFault::Unrecognised { expected: "a KTX2 file of leadr bake" });
    }
    let header: [u8; Header::LENGTH] =
        start.try_into().map_err(|_| MapFault::damaged("it ends within its header (truncated?)"))?;
    // Before the crate turns what it does not know into nothing.
    let scheme = u32::from_le_bytes(header[44..48].try_into().expect("four bytes"));
    let header = Header::from_bytes(&header).map_err(|e| MapFault::damaged(format!("its header is wrong ({e:?})")))?;
    let foreign = |what: String| MapFault::Unsupported { what, remedy: "give a file that leadr bake wrote".into() };
    let precision = match header.format {
        Some(Format::R32G32B32A32_SFLOAT) => Precision::F32,
        Some(Format::R16G16B16A16_SFLOAT) => Precision::F16,
        other => return Err(foreign(format!("its texels are {other:?}, not four floats of 32 or 16 bits"))),
    };
    if scheme != 0 || header.face_count != 1 || header.pixel_depth != 0 {
        return Err(foreign("it is compressed, a cube or a volume".into()));
    }
    let (width, height, layers) = (header.pixel_width, header.pixel_height, header.layer_count.max(1));
    let texel = 4 * precision.bytes() as u64;
    let too_large = u64::from(width.max(height)) > limits::MAX_SIDE;
    if height == 0 || too_large || u64::from(width) * u64::from(height) > limits::MAX_TEXELS || layers > MOST_LAYERS {
        let what = format!("{width} x {height} texels in {layers} layers");
        return Err(MapFault::TooLarge { what });
    }
    let count = width.max(height).ilog2() + 1;
    if header.level_count != count || header.type_size as usize != precision.bytes() {
        return Err(MapFault::damaged(format!("it has {} of {count} levels", header.level_count)));
    }
    let index =
        part(file, length, Header::LENGTH as u64, u64::from(count) * LevelIndex::LENGTH as u64, "list of levels")?;
    let (keys_at, keys_length) = (header.index.kvd_byte_offset, header.index.kvd_byte_length);
    if keys_length > MOST_KEYS {
        return Err(MapFault::damaged(format!("it claims {keys_length} bytes of keys")));
    }
    let keys = part(file, length, keys_at.into(), keys_length.into(), "list of keys")?;
    let keys = Keys::new(&keys, layers as usize)?;

    let mut levels = Vec::new();
    for (i, entry) in index.chunks_exact(LevelIndex::LENGTH).enumerate() {
        let entry = LevelIndex::from_bytes(entry.try_into().expect("as long as an entry"));
        let [w, h] = [width, height].map(|side| (side >> i).max(1));
        let plane = u64::from(w) * u64::from(h);
        if entry.byte_length != plane * u64::from(layers) * texel || entry.uncompressed_byte_length != entry.byte_length
        {
            return Err(MapFault::damaged(format!(
                "level {i} has {} bytes, not those of {w} x {h}",
                entry.byte_length
            )));
        }
        let bytes = part(file, length, entry.byte_offset, entry.byte_length, "level")?;
        let planes = bytes.chunks_exact((plane * texel) as usize).enumerate();
        let planes = planes.map(|(layer, bytes)| keys.plane(bytes, precision, layer, w)).collect::<Result<_, _>>()?;
        levels.push(BakedLevel { width: w, height: h, layers: planes });
    }
    let Keys { kind, channels, wrap, height_scale, .. } = keys;
    Ok(BakedMap { kind, precision, channels, wrap, height_scale, levels })
}

/// What the keys say.
struct Keys {
    kind: Kind,
    channels: Vec<String>,
    factors: Vec<f64>,
    wrap: Wrap,
    height_scale: f64,
}

impl Keys {
    fn new(bytes: &[u8], layers: usize) -> Result<Self, MapFault> {
        let pairs: Vec<(&str, &[u8])> = KeyValueDataIterator::new(bytes).collect();
        let value = |key: &str| {
            let found = pairs.iter().find(|(name, _)| *name == key).and_then(|(_, v)| v.strip_suffix(&[0]));
            let text = found.and_then(|text| std::str::from_utf8(text).ok());
            text.ok_or_else(|| MapFault::Unsupported {
                what: format!("its key {key} is missing or no text"),
                remedy: "give a file that leadr bake wrote".into(),
            })
        };
        let wrong = |key: &str| MapFault::damaged(format!("its key {key} makes no sense"));
        if value("KTXorientation")? != "rd" {
            return Err(wrong("KTXorientation"));
        }
        let name = value("leadr.kind")?;
        let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| wrong("leadr.kind"))?;
        let channels: Vec<String> = value("leadr.channels")?.split(' ').map(str::to_owned).collect();
        if channels.len() != 4 * layers
            || !channels.iter().zip(kind.channels()).all(|(a, b)| a == b)
            || channels.len() < kind.channels().len()
        {
            return Err(wrong("leadr.channels"));
        }
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let factors = value("leadr.factors")?.split(' ').map(|text| number(text).filter(|f| *f > 0.0));
        let factors: Vec<f64> = factors.collect::<Option<_>>().ok_or_else(|| wrong("leadr.factors"))?;
        if factors.len() != channels.len() {
            return Err(wrong("leadr.factors"));
        }
        let wrap = match value("leadr.wrap")? {
            "repeat" => Wrap::Repeat,
            "clamp" => Wrap::Clamp,
            _ => return Err(wrong("leadr.wrap")),
        };
        let height_scale = number(value("leadr.height_scale")?).ok_or_else(|| wrong("leadr.height_scale"))?;
        Ok(Self { kind, channels, factors, wrap, height_scale })
    }

    /// The texels of a layer, checked.
    fn plane(&self, bytes: &[u8], precision: Precision, layer: usize, width: u32) -> Result<Vec<[f32; 4]>, MapFault> {
        let factors = &self.factors[4 * layer..4 * layer + 4];
        let mut texels = limits::zeroed::<[f32; 4]>(bytes.len() / (4 * precision.bytes()))?;
        for (i, (texel, bytes)) in texels.iter_mut().zip(bytes.chunks_exact(4 * precision.bytes())).enumerate() {
            for (c, (value, bytes)) in texel.iter_mut().zip(bytes.chunks_exact(precision.bytes())).enumerate() {
                *value = match precision {
                    Precision::F32 => f32::from_le_bytes(bytes.try_into().expect("four bytes")),
                    Precision::F16 => f16::from_le_bytes(bytes.try_into().expect("two bytes")).to_f32(),
                };
                if factors[c] != 1.0 {
                    *value = (f64::from(*value) / factors[c]) as f32;
                }
                if !value.is_finite() {
                    let place = [i % width as usize, i / width as usize].map(|p| p as u32);
                    let channel = ["R", "G", "B", "A"][c];
                    let remedy = "every value must be finite; bake the map again";
                    return Err(MapFault::BadTexel { channel, x: place[0], y: place[1], value: *value, remedy });
                }
            }
        }
        Ok(texels)
    }
}
