//! The baked animal on disk: written atomically, read as untrusted input.
//!
//! Layout (little endian): magic, key, checksum of everything after it, tile, counts, then the arrays back to back.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use bytemuck::Pod;
use glam::Vec3;

use super::atlas::Atlas;
use crate::render::surfaces::patch_mesh::{PatchMesh, SkinWeights, TileLayout};

const MAGIC: u64 = u64::from_le_bytes(*b"LEADRTRX");
/// Bytes of the header: magic, key, checksum, tile, vertices, patches, joints per vertex (0 or 4).
const HEADER: usize = 3 * 8 + 4 * 4;
/// Larger counts are not believed.
const MOST: u32 = 1 << 16;

/// Why a cache file was not used.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// Reading or writing failed.
    #[error("cache file {path}: {source}; the animal is baked anew")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The content is not what was written.
    #[error("cache file {path} is damaged ({fault}); the animal is baked anew and the file replaced")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: &'static str,
    },
}

/// The cache folder: `$LEADR_CACHE`, else `$XDG_CACHE_HOME/leadr`, else `~/.cache/leadr`; none if none is set.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    let variable = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    variable("LEADR_CACHE")
        .or_else(|| variable("XDG_CACHE_HOME").map(|p| p.join("leadr")))
        .or_else(|| variable("HOME").map(|p| p.join(".cache").join("leadr")))
}

/// A 64-bit checksum of `bytes`: four independent multiply-rotate lanes, folded. Guards against damage, not malice.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u64 {
    const P: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut lanes = [P, P ^ 1, P ^ 2, P ^ 3];
    let mut chunks = bytes.chunks_exact(32);
    for chunk in &mut chunks {
        for (lane, word) in lanes.iter_mut().zip(chunk.chunks_exact(8)) {
            let word = u64::from_le_bytes(word.try_into().expect("eight bytes"));
            *lane = (*lane ^ word).wrapping_mul(P).rotate_left(29);
        }
    }
    for &byte in chunks.remainder() {
        lanes[0] = (lanes[0] ^ u64::from(byte)).wrapping_mul(P).rotate_left(29);
    }
    let mut sum = bytes.len() as u64;
    for lane in lanes {
        sum = (sum ^ lane).wrapping_mul(P);
        sum ^= sum >> 32;
    }
    sum
}

/// Body mesh, its layout and atlas as stored.
pub struct Baked {
    /// The control mesh with texture coordinates and skin weights.
    pub body: PatchMesh,
    /// Layout of the atlas.
    pub layout: TileLayout,
    /// Heights and colours.
    pub atlas: Atlas,
}

struct Writer<W> {
    out: W,
}

impl<W: Write> Writer<W> {
    fn put<T: Pod>(&mut self, values: &[T]) -> std::io::Result<()> {
        self.out.write_all(bytemuck::cast_slice(values))
    }
}

fn vectors(values: &[Vec3]) -> Vec<[f32; 3]> {
    values.iter().map(|v| v.to_array()).collect()
}

fn payload(baked: &Baked) -> std::io::Result<Vec<u8>> {
    let mesh = &baked.body;
    let mut w = Writer { out: Vec::with_capacity(8 * baked.atlas.heights.len() + (1 << 20)) };
    let joints = if mesh.skin.is_empty() { 0 } else { 4 };
    w.put(&[baked.layout.tile, mesh.positions.len() as u32, mesh.patches.len() as u32, joints])?;
    w.put(&vectors(&mesh.positions))?;
    w.put(&vectors(&mesh.normals))?;
    w.put(&mesh.colors)?;
    w.put(&mesh.accessibility)?;
    w.put(&mesh.patches)?;
    w.put(&mesh.skin.iter().map(|s| s.weights).collect::<Vec<_>>())?;
    w.put(&mesh.skin.iter().map(|s| s.joints).collect::<Vec<_>>())?;
    w.put(&baked.atlas.heights)?;
    w.put(&baked.atlas.colors)?;
    Ok(w.out)
}

/// Writes `baked` under `key` to `path` by way of a temporary file in the same folder, which is created if missing.
///
/// # Errors
/// [`CacheError::Io`] if the folder cannot be made or written.
pub fn write(path: &Path, key: u64, baked: &Baked) -> Result<(), CacheError> {
    let io = |source| CacheError::Io { path: path.to_owned(), source };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(io)?;
    }
    let temporary = path.with_extension(format!("{}.tmp", std::process::id()));
    let attempt = || {
        let body = payload(baked)?;
        let mut w = Writer { out: File::create(&temporary)? };
        w.put(&[MAGIC, key, checksum(&body)])?;
        w.put(&body)?;
        w.out.sync_all()?;
        std::fs::rename(&temporary, path)
    };
    attempt().map_err(|source| {
        // Whatever was left half written is of no use; failing to remove it changes nothing.
        let _ = std::fs::remove_file(&temporary);
        io(source)
    })
}

/// Takes arrays off the front of the payload.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take<T: Pod>(&mut self, count: usize) -> Result<Vec<T>, &'static str> {
        let length = count.checked_mul(size_of::<T>()).ok_or("a count is too large")?;
        let (head, rest) = self.bytes.split_at_checked(length).ok_or("it is too short")?;
        self.bytes = rest;
        let mut values = vec![T::zeroed(); count];
        bytemuck::cast_slice_mut::<T, u8>(&mut values).copy_from_slice(head);
        Ok(values)
    }

    fn vectors(&mut self, count: usize) -> Result<Vec<Vec3>, &'static str> {
        Ok(self.take::<[f32; 3]>(count)?.into_iter().map(Vec3::from_array).collect())
    }
}

fn parse(bytes: &[u8], key: u64, tile: u32) -> Result<Option<Baked>, &'static str> {
    if bytes.len() < HEADER {
        return Err("it is too short");
    }
    let mut r = Reader { bytes };
    let head = r.take::<u64>(3)?;
    if head[0] != MAGIC {
        return Err("it is of another kind");
    }
    if head[1] != key {
        return Ok(None);
    }
    if checksum(r.bytes) != head[2] {
        return Err("its checksum differs");
    }
    let counts = r.take::<u32>(4)?;
    let [stored, vertices, patches, joints] = [counts[0], counts[1], counts[2], counts[3]];
    if stored != tile {
        return Ok(None);
    }
    if vertices > MOST || patches > MOST || !matches!(joints, 0 | 4) || patches == 0 {
        return Err("its counts are out of range");
    }
    let layout = TileLayout::new(patches, tile);
    let (width, height) = layout.size();
    let texels = width as usize * height as usize;
    let n = vertices as usize;
    let mut body = PatchMesh {
        positions: r.vectors(n)?,
        normals: r.vectors(n)?,
        colors: r.take(n)?,
        accessibility: r.take(n)?,
        patches: r.take(patches as usize)?,
        ..PatchMesh::default()
    };
    if joints == 4 {
        let weights = r.take::<[f32; 4]>(n)?;
        let joints = r.take::<[u16; 4]>(n)?;
        body.skin = joints.into_iter().zip(weights).map(|(joints, weights)| SkinWeights { joints, weights }).collect();
    }
    let atlas = Atlas { heights: r.take(texels)?, colors: r.take(texels)? };
    if !r.bytes.is_empty() {
        return Err("it is too long");
    }
    if body.patches.iter().flatten().any(|&v| v >= vertices) {
        return Err("a patch names a vertex that does not exist");
    }
    body.texcoords = (0..patches).map(|i| layout.texcoords(i)).collect();
    Ok(Some(Baked { body, layout, atlas }))
}

/// Reads the animal stored under `key` with tiles of `tile` texels; `None` if there is none or it is of another key.
///
/// # Errors
/// [`CacheError`] if the file exists but cannot be read or is damaged.
pub fn read(path: &Path, key: u64, tile: u32) -> Result<Option<Baked>, CacheError> {
    let io = |source| CacheError::Io { path: path.to_owned(), source };
    let damaged = |fault| CacheError::Damaged { path: path.to_owned(), fault };
    let file = match File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(io(e)),
    };
    // No more is read than the largest animal of this tile size could need.
    let most = 9 * u64::from(MOST) * u64::from(tile) * u64::from(tile);
    let length = file.metadata().map_err(io)?.len();
    if length > most {
        return Err(damaged("it is too long"));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    file.take(most).read_to_end(&mut bytes).map_err(io)?;
    parse(&bytes, key, tile).map_err(damaged)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Baked {
        let layout = TileLayout::new(1, 8);
        let (w, h) = layout.size();
        let texels = (w * h) as usize;
        let body = PatchMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            normals: vec![Vec3::Z; 4],
            colors: vec![[0.5; 4]; 4],
            accessibility: vec![0.75; 4],
            skin: vec![SkinWeights { joints: [3, 1, 0, 0], weights: [0.75, 0.25, 0.0, 0.0] }; 4],
            patches: vec![[0, 1, 2, 3]],
            texcoords: vec![layout.texcoords(0)],
            flat_repeat: None,
        };
        let atlas = Atlas { heights: (0..texels).map(|i| i as f32).collect(), colors: vec![[1, 2, 3, 4]; texels] };
        Baked { body, layout, atlas }
    }

    #[test]
    fn what_is_written_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("deeper").join("t.bin");
        assert!(read(&path, 7, 8).unwrap().is_none());
        let baked = small();
        write(&path, 7, &baked).unwrap();
        let back = read(&path, 7, 8).unwrap().unwrap();
        assert_eq!(back.body.positions, baked.body.positions);
        assert_eq!(back.body.skin, baked.body.skin);
        assert_eq!(back.body.texcoords, baked.body.texcoords);
        assert_eq!(back.atlas.heights, baked.atlas.heights);
        assert_eq!(back.atlas.colors, baked.atlas.colors);
        assert!(read(&path, 8, 8).unwrap().is_none(), "another key");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "nothing temporary is left");
    }

    #[test]
    fn every_kind_of_damage_is_noticed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.bin");
        write(&path, 7, &small()).unwrap();
        let good = std::fs::read(&path).unwrap();
        let cases: [Vec<u8>; 5] = [
            Vec::new(),
            good[..good.len() - 5].to_vec(),
            [&good[..], &[0]].concat(),
            good.iter().enumerate().map(|(i, b)| if i == 200 { b ^ 4 } else { *b }).collect(),
            good.iter().enumerate().map(|(i, b)| if i == 0 { b ^ 4 } else { *b }).collect(),
        ];
        for bytes in cases {
            std::fs::write(&path, bytes).unwrap();
            assert!(matches!(read(&path, 7, 8), Err(CacheError::Damaged { .. })));
        }
        // Counts that lie, under a checksum that fits.
        for (at, value) in [(4, 9_u32), (4, u32::MAX), (8, 70_000), (8, 4000), (12, 3)] {
            let mut bytes = good.clone();
            bytes[24 + at..28 + at].copy_from_slice(&value.to_le_bytes());
            let sum = checksum(&bytes[24..]);
            bytes[16..24].copy_from_slice(&sum.to_le_bytes());
            std::fs::write(&path, bytes).unwrap();
            assert!(matches!(read(&path, 7, 8), Err(CacheError::Damaged { .. })), "{at} {value}");
        }
    }
}
