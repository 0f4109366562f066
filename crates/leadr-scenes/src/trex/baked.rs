//! The baked animal as a [cache](leadr_maps::cache) file, which is untrusted input.
//!
//! The file (little endian) has the tile size, the counts, and then the arrays without gaps.

use glam::Vec3;

use super::skeleton::JOINT_COUNT;
use leadr_maps::cache::{expect_all, expect_end, put, take};
use leadr_render::surfaces::patch_mesh::{PatchMesh, SkinWeights, TileLayout};

/// The largest count that is accepted.
const MOST: u32 = 1 << 16;

/// Maximum distance of a vertex from the origin along an axis, metres.
const FARTHEST: f32 = 30.0;

/// Returns the maximum file size for tiles of `tile` texels, bytes.
pub fn most_bytes(tile: u32) -> u64 {
    9 * u64::from(MOST) * u64::from(tile) * u64::from(tile)
}

/// The stored body mesh, tile layout and atlas.
pub struct Baked {
    /// The control mesh with texture coordinates and skin weights.
    pub body: PatchMesh,
    /// The layout of the atlas.
    pub layout: TileLayout,
    /// The displacement along the patch normal in metres, in rows.
    pub heights: Vec<f32>,
    /// The sRGB-encoded albedo (rgb) and the linear Beckmann `α` (a), in rows.
    pub colors: Vec<[u8; 4]>,
}

impl Baked {
    /// Serialises the file's content.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mesh = &self.body;
        let mut out = Vec::with_capacity(8 * self.heights.len() + (1 << 20));
        put(&mut out, &[self.layout.tile, mesh.positions.len() as u32, mesh.patches.len() as u32]);
        put(&mut out, &mesh.positions);
        put(&mut out, &mesh.normals);
        put(&mut out, &mesh.colors);
        put(&mut out, &mesh.accessibility);
        put(&mut out, &mesh.patches);
        put(&mut out, &mesh.skin.iter().map(|s| s.weights).collect::<Vec<_>>());
        put(&mut out, &mesh.skin.iter().map(|s| s.joints).collect::<Vec<_>>());
        put(&mut out, &self.heights);
        put(&mut out, &self.colors);
        out
    }

    /// Parses the content of a file, for tiles of `tile` texels.
    ///
    /// # Errors
    /// If the content is invalid; the text gives the reason.
    pub fn from_bytes(mut bytes: &[u8], tile: u32) -> Result<Self, &'static str> {
        let r = &mut bytes;
        let counts = take::<u32>(r, 3)?;
        let [stored, vertices, patches] = [counts[0], counts[1], counts[2]];
        if stored != tile {
            return Err("its tiles have another size");
        }
        if vertices > MOST || patches > MOST || patches == 0 {
            return Err("its counts are out of range");
        }
        let layout = TileLayout::new(patches, tile);
        let (width, height) = layout.size();
        let texels = width as usize * height as usize;
        let n = vertices as usize;
        let mut body = PatchMesh {
            positions: take(r, n)?,
            normals: take(r, n)?,
            colors: take(r, n)?,
            accessibility: take(r, n)?,
            patches: take(r, patches as usize)?,
            ..PatchMesh::default()
        };
        let (weights, joints) = (take(r, n)?, take(r, n)?);
        body.skin = joints.into_iter().zip(weights).map(|(joints, weights)| SkinWeights { joints, weights }).collect();
        let (heights, colors) = (take(r, texels)?, take(r, texels)?);
        expect_end(r)?;
        if body.patches.iter().flatten().any(|&v| v >= vertices) {
            return Err("a patch names a vertex that does not exist");
        }
        let is_share = |v: &f32| (0.0..=1.0).contains(v);
        let is_near = |p: &Vec3| p.abs().max_element() <= FARTHEST && p.is_finite();
        expect_all(&body.positions, is_near)?;
        expect_all(&body.normals, |n| (n.length() - 1.0).abs() < 1e-3)?;
        expect_all(&body.colors, |color| color.iter().all(is_share) && color[3] > 0.0)?;
        expect_all(&body.accessibility, is_share)?;
        expect_all(&body.skin, |skin| {
            let sum: f32 = skin.weights.iter().sum();
            skin.weights.iter().all(is_share)
                && (sum - 1.0).abs() < 1e-3
                && skin.joints.iter().all(|&joint| usize::from(joint) < JOINT_COUNT)
        })?;
        expect_all(&heights, |height: &f32| height.abs() <= 1.0)?;
        body.texcoords = (0..patches).map(|i| layout.texcoords(i)).collect();
        Ok(Self { body, layout, heights, colors })
    }
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
            ..PatchMesh::default()
        };
        Baked {
            body,
            layout,
            heights: (0..texels).map(|i| i as f32 * 1e-3).collect(),
            colors: vec![[1, 2, 3, 4]; texels],
        }
    }

    #[test]
    fn written_text_reads_back() {
        let baked = small();
        let back = Baked::from_bytes(&baked.to_bytes(), 8).unwrap();
        assert_eq!(back.body.positions, baked.body.positions);
        assert_eq!(back.body.skin, baked.body.skin);
        assert_eq!(back.body.texcoords, baked.body.texcoords);
        assert_eq!(back.heights, baked.heights);
        assert_eq!(back.colors, baked.colors);
    }

    #[test]
    fn planted_values_are_refused() {
        for (what, plant) in [
            ("position", (|baked| baked.body.positions[1].x = f32::NAN) as fn(&mut Baked)),
            ("far position", |baked| baked.body.positions[1].y = 1e9),
            ("normal", |baked| baked.body.normals[2] = Vec3::ZERO),
            ("normal", |baked| baked.body.normals[2].z = f32::NAN),
            ("colour", |baked| baked.body.colors[3][0] = f32::INFINITY),
            ("roughness", |baked| baked.body.colors[3][3] = 0.0),
            ("accessibility", |baked| baked.body.accessibility[0] = -1.0),
            ("joint", |baked| baked.body.skin[0].joints[3] = 65535),
            ("weight", |baked| baked.body.skin[0].weights = [2.0, -1.0, 0.0, 0.0]),
            ("sum of weights", |baked| baked.body.skin[0].weights = [0.0; 4]),
            ("height", |baked| baked.heights[5] = f32::NAN),
            ("high height", |baked| baked.heights[5] = 3e8),
        ] {
            let mut baked = small();
            plant(&mut baked);
            assert!(Baked::from_bytes(&baked.to_bytes(), 8).is_err(), "{what}");
        }
    }

    #[test]
    fn inconsistent_content_is_refused() {
        let good = small().to_bytes();
        for (at, value) in [(0, 16_u32), (4, 9), (4, u32::MAX), (8, 70_000), (8, 4000), (8, 0)] {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            assert!(Baked::from_bytes(&bytes, 8).is_err(), "{at} {value}");
        }
        assert!(Baked::from_bytes(&good[..good.len() - 1], 8).is_err());
        assert!(Baked::from_bytes(&[&good[..], &[0]].concat(), 8).is_err());
        assert!(Baked::from_bytes(&[], 8).is_err());
    }
}
