//! Shapes: triangles, what their vertices carry, and the targets they morph towards.

/// A shape of one or more materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Its name, empty if it has none.
    pub name: String,
    /// A part for each material. What the file draws as points or lines is not among them.
    pub primitives: Vec<Primitive>,
    /// How many morph targets each of its primitives has.
    pub target_count: usize,
    /// The names of the targets, as most exporters store them; empty if the file has none.
    pub target_names: Vec<String>,
}

/// Triangles of one material. All lists over vertices have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Its material in the model's list.
    pub material: usize,
    /// Three vertices each, counter-clockwise seen from the front; some may have no area.
    pub triangles: Vec<[u32; 3]>,
    /// Metres, in the space of the node or, of a skinned mesh, of the skin.
    pub positions: Vec<[f32; 3]>,
    /// Of unit length.
    pub normals: Vec<[f32; 3]>,
    /// Whether the file has no normals: every triangle then has three vertices of its own and the normal of its plane, also when
    /// it moves.
    pub flat: bool,
    /// Direction of growing `s` of the first texture coordinates, of unit length, and 1 or -1 as the sign of the bitangent
    /// `sign · normal × tangent`; `None` if the file has none.
    pub tangents: Option<Vec<[f32; 4]>>,
    /// Sets of texture coordinates, `t` down.
    pub texcoords: Vec<Vec<[f32; 2]>>,
    /// Factors on the material's base colour and opacity, linear, 0 to 1.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Which joints of the skin move a vertex; `None` if none do.
    pub influences: Option<Vec<Influences>>,
    /// What the vertices may morph towards.
    pub targets: Vec<MorphTarget>,
}

/// The joints that move a vertex: the four with the largest weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influences {
    /// Places in the skin's list of joints; those with weight 0 are 0.
    pub joints: [u16; 4],
    /// 0 to 1, the largest first; their sum is 1.
    pub weights: [f32; 4],
}

/// Differences that are added to the vertices by a weight. Each list is empty if the target leaves it alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Differences of normals.
    pub normals: Vec<[f32; 3]>,
    /// Differences of tangents; the sign stays.
    pub tangents: Vec<[f32; 3]>,
}
