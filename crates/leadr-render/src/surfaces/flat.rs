//! Planes and surfaces of uniform colour. Shaders need not evaluate such surfaces for each patch.

use glam::{Mat2, Vec2, Vec3};

use super::patch_mesh::{PatchMesh, PosedVertices};

/// The largest relative difference between the tangents of a flat mesh.
const SAME: f32 = 1e-4;

/// The tangents with respect to texture coordinates in metres per unit, and their orientation, both from the first patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// The tangent along the texture coordinate s.
    pub tangent_s: Vec3,
    /// The tangent along the texture coordinate t.
    pub tangent_t: Vec3,
    /// Whether `tangent_s × tangent_t` points outwards.
    pub outward: bool,
}

impl Chart {
    /// Returns the chart of a mesh in a pose. Returns `None` if the mesh has no patches or has degenerate texture coordinates.
    pub fn of(mesh: &PatchMesh, posed: &PosedVertices) -> Option<Self> {
        let (patch, texcoords) = (mesh.patches.first()?, mesh.texcoords.first()?);
        let [s, t] = tangents(patch.map(|v| posed.positions[v as usize]), texcoords)?;
        let normal = posed.normals[patch[0] as usize];
        Some(Self { tangent_s: s, tangent_t: t, outward: s.cross(t).dot(normal) > 0.0 })
    }
}

/// Returns the tangents of a flat patch with respect to texture coordinates, at corner 0.
fn tangents(corners: [Vec3; 4], texcoords: &[Vec2; 4]) -> Option<[Vec3; 2]> {
    let texcoord_by_uv = Mat2::from_cols(texcoords[1] - texcoords[0], texcoords[3] - texcoords[0]);
    if texcoord_by_uv.determinant().abs() < 1e-20 {
        return None;
    }
    let (by_texcoord, du, dv) = (texcoord_by_uv.inverse(), corners[1] - corners[0], corners[3] - corners[0]);
    Some([by_texcoord.x_axis, by_texcoord.y_axis].map(|column| du * column.x + dv * column.y))
}

/// Whether a mesh is a plane with affine texture coordinates at rest, and therefore also in every rigid pose.
pub fn is_flat(mesh: &PatchMesh) -> bool {
    let rest = PosedVertices::new(mesh.positions.clone(), mesh.normals.clone());
    let Some(Chart { tangent_s, tangent_t, .. }) = Chart::of(mesh, &rest) else { return false };
    let normal = tangent_s.cross(tangent_t).normalize_or_zero();
    let tolerance = SAME * tangent_s.length().min(tangent_t.length());
    let patch_is_flat = |(patch, texcoords): (&[u32; 4], &[Vec2; 4])| {
        let corners = patch.map(|v| mesh.positions[v as usize]);
        let fourth = texcoords[2] - texcoords[1] - (texcoords[3] - texcoords[0]);
        let across = (texcoords[1] - texcoords[0]).length().max((texcoords[3] - texcoords[0]).length());
        tangents(corners, texcoords).is_some_and(|[s, t]| {
            let same = (s - tangent_s).length() < tolerance && (t - tangent_t).length() < tolerance;
            let square = corners[2] - corners[1] - (corners[3] - corners[0]);
            let size = corners[0].distance(corners[2]);
            same && fourth.length() <= SAME * across && square.length() <= SAME * size
        })
    };
    mesh.skin.is_empty()
        && mesh.texcoords.len() == mesh.patches.len()
        && mesh.normals.iter().all(|n| n.dot(normal).abs() > 1.0 - 1e-6 && n.dot(mesh.normals[0]) > 0.0)
        && mesh.patches.iter().zip(&mesh.texcoords).all(patch_is_flat)
}

/// Whether all vertices have the same colour and accessibility.
pub fn is_plain(mesh: &PatchMesh) -> bool {
    mesh.colors.windows(2).all(|pair| pair[0] == pair[1])
        && mesh.accessibility.windows(2).all(|pair| pair[0] == pair[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two adjacent patches in the plane z = x / 2, with mirrored texture coordinates.
    fn roof() -> PatchMesh {
        let positions: Vec<Vec3> =
            (0..6).map(|i| Vec3::new((i % 3) as f32, (i / 3) as f32, (i % 3) as f32 * 0.5)).collect();
        let patches = vec![[0, 1, 4, 3], [1, 2, 5, 4]];
        let texcoord = |v: &u32| Vec2::new(-positions[*v as usize].x, positions[*v as usize].y * 3.0);
        PatchMesh {
            texcoords: patches.iter().map(|patch: &[u32; 4]| [0, 1, 2, 3].map(|i| texcoord(&patch[i]))).collect(),
            normals: vec![Vec3::new(-0.5, 0.0, 1.0).normalize(); 6],
            colors: vec![[0.5; 4]; 6],
            patches,
            positions,
            ..PatchMesh::default()
        }
    }

    #[test]
    fn a_plane_has_one_chart() {
        let mesh = roof();
        assert!(is_flat(&mesh) && is_plain(&mesh));
        let rest = PosedVertices::new(mesh.positions.clone(), mesh.normals.clone());
        let chart = Chart::of(&mesh, &rest).unwrap();
        assert!((chart.tangent_s - Vec3::new(-1.0, 0.0, -0.5)).length() < 1e-6);
        assert!((chart.tangent_t - Vec3::Y / 3.0).length() < 1e-6);
        assert!(!chart.outward);
    }

    #[test]
    fn bent_stretched_or_coloured_surfaces_are_not_flat() {
        let bent = |change: fn(&mut PatchMesh)| {
            let mut mesh = roof();
            change(&mut mesh);
            mesh
        };
        assert!(!is_flat(&bent(|mesh| mesh.positions[5].z += 0.01)));
        assert!(!is_flat(&bent(|mesh| mesh.positions[5].x += 0.01)));
        assert!(!is_flat(&bent(|mesh| mesh.normals[4] = Vec3::Z)));
        assert!(!is_flat(&bent(|mesh| mesh.texcoords[1][2].y += 0.01)));
        assert!(!is_flat(&bent(|mesh| mesh.texcoords.truncate(1))));
        assert!(!is_flat(&PatchMesh::default()));
        // Bending adds no seam, but a different texture coordinate on one side of an edge does.
        assert!(bent(|mesh| mesh.positions[5].z += 0.01).is_seamless());
        assert!(!bent(|mesh| mesh.texcoords[1][0].y += 0.01).is_seamless());
        assert!(!bent(|mesh| mesh.texcoords.truncate(1)).is_seamless());
        assert!(!bent(|mesh| mesh.triangles = true).is_seamless());
        assert!(!bent(|mesh| mesh.rims = vec![[0, 1]]).is_seamless());
        assert!(!is_plain(&bent(|mesh| mesh.colors[2][3] = 0.4)));
        assert!(!is_plain(&bent(|mesh| mesh.accessibility = vec![1.0, 0.5])));
    }
}
