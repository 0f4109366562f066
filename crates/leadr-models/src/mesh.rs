//! Meshes: triangles, vertex attributes and morph targets.

/// A mesh with one or more materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name, empty if missing.
    pub name: String,
    /// One primitive per material. Points and lines of the file are omitted.
    pub primitives: Vec<Primitive>,
    /// Number of morph targets of each primitive.
    pub target_count: usize,
    /// Target names, as most exporters store them; empty if missing.
    pub target_names: Vec<String>,
}

/// Triangles of one material. All lists over vertices have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Index in the model's list of materials.
    pub material: usize,
    /// Vertex triples, counter-clockwise seen from the front; may be degenerate.
    pub triangles: Vec<[u32; 3]>,
    /// Metres, in the space of the node, or of the skin for a skinned mesh.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors.
    pub normals: Vec<[f32; 3]>,
    /// Whether the file has no normals. Every triangle then has three vertices of its own with its plane normal, also when it
    /// deforms.
    pub flat: bool,
    /// Unit direction of increasing `s` in the first texture coordinates, and 1 or -1 as sign of the bitangent
    /// `sign · normal × tangent`. `None` if the file has none.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// Sets of texture coordinates, `t` down.
    pub texcoords: Vec<Vec<[f32; 2]>>,
    /// Factors on the material's base colour and opacity, linear, 0 to 1.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Skin joints of each vertex; `None` without skinning.
    pub influences: Option<Vec<Influences>>,
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
}

/// The four joints with the largest weights on a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influences {
    /// Indices in the skin's list of joints; 0 where the weight is 0.
    pub joints: [u16; 4],
    /// 0 to 1 in descending order, with sum 1.
    pub weights: [f32; 4],
}

/// Weighted vertex differences. Attributes without differences have empty lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Differences of normals.
    pub normals: Vec<[f32; 3]>,
    /// Differences of tangents; the sign does not change.
    pub tangents: Vec<[f32; 3]>,
}
