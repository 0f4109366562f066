//! Meshes: triangles, vertex attributes and morph targets.

/// A mesh with one or more materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name, empty if missing.
    pub name: String,
    /// Primitives, one per material. Points and lines of the file are omitted.
    pub primitives: Vec<Primitive>,
    /// Number of morph targets of each primitive.
    pub target_count: usize,
    /// Names of the morph targets, as most exporters store them. Empty if missing.
    pub target_names: Vec<String>,
}

/// Triangles of one material. All per-vertex lists have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Index in the model's list of materials.
    pub material: usize,
    /// Vertex triples, counter-clockwise when seen from the front. Triangles may be degenerate.
    pub triangles: Vec<[u32; 3]>,
    /// Positions in metres, in the space of the node, or of the skin for a skinned mesh.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Whether the file has no normals. Every triangle then has three separate vertices with its plane normal, even when it
    /// deforms.
    pub flat: bool,
    /// Unit tangent along increasing `s` in the first texture coordinates, and the sign, 1 or -1, of the bitangent `sign ·
    /// normal × tangent`. `None` if the file has none.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// Sets of texture coordinates, with `t` down.
    pub texcoords: Vec<Vec<[f32; 2]>>,
    /// Linear factors, 0 to 1, on the material's base colour and opacity.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Skin joints of each vertex; `None` without skinning.
    pub influences: Option<Vec<Influences>>,
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
}

/// The four joints with the largest weights on a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influences {
    /// Indices in the skin's list of joints, or 0 where the weight is 0.
    pub joints: [u16; 4],
    /// Weights from 0 to 1 in descending order, with sum 1.
    pub weights: [f32; 4],
}

/// Vertex differences of a morph target. Attributes without differences have empty lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Differences of positions in metres.
    pub positions: Vec<[f32; 3]>,
    /// Differences of normals.
    pub normals: Vec<[f32; 3]>,
    /// Differences of tangents. The sign does not change.
    pub tangents: Vec<[f32; 3]>,
}
