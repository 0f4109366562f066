//! Meshes: triangles, vertex attributes and morph targets.

/// A mesh with one or more materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The name, or an empty string.
    pub name: String,
    /// The primitives, each with one material. Points and lines are omitted.
    pub primitives: Vec<Primitive>,
    /// The number of morph targets of each primitive.
    pub target_count: usize,
    /// The names of the morph targets, as most exporters store them. The list is empty if the file has none.
    pub target_names: Vec<String>,
}

/// Triangles with one material. All per-vertex lists have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// The index in the model's list of materials.
    pub material: usize,
    /// The vertex indices of each triangle, counter-clockwise when seen from the front. Triangles may be degenerate.
    pub triangles: Vec<[u32; 3]>,
    /// The positions in metres, in the space of the node, or of the skin for a skinned mesh.
    pub positions: Vec<[f32; 3]>,
    /// The unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Whether the file has no normals. Every triangle then has its own three vertices with the normal of the triangle's
    /// plane, even under deformation.
    pub flat: bool,
    /// The unit tangent along increasing `s` in the first texture coordinates, and a sign, 1 or -1. The bitangent is `sign ·
    /// normal × tangent`. `None` if the file has no tangents.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// The sets of texture coordinates. `t` points down.
    pub texcoords: Vec<Vec<[f32; 2]>>,
    /// The linear factors, from 0 to 1, that multiply the material's base colour and opacity.
    pub colors: Option<Vec<[f32; 4]>>,
    /// The factors on the height of relief, from 0 to [`MAX_HEIGHT_SCALE`](crate::limits::MAX_HEIGHT_SCALE), from the attribute
    /// `_HEIGHT_SCALE`.
    pub height_scales: Option<Vec<f32>>,
    /// The joints that move each vertex, or `None` without skinning.
    pub influences: Option<Vec<Influences>>,
    /// The morph targets.
    pub targets: Vec<MorphTarget>,
}

/// The four joints with the largest weights on a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influences {
    /// The indices in the skin's list of joints, or 0 where the weight is 0.
    pub joints: [u16; 4],
    /// The weights from 0 to 1, in descending order. The sum of the four weights is 1.
    pub weights: [f32; 4],
}

/// The differences that a morph target adds to vertices. The list of an attribute without differences is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// The differences of the positions in metres.
    pub positions: Vec<[f32; 3]>,
    /// The differences of the normals.
    pub normals: Vec<[f32; 3]>,
    /// The differences of the tangents. The sign of a tangent does not change.
    pub tangents: Vec<[f32; 3]>,
}
