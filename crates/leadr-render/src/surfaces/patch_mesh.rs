//! A quad mesh for tessellation and displacement: made by scenes and drawn by the geometry pass.

use glam::{Vec2, Vec3};

/// Up to four joints with weights (sum 1) for linear blend skinning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkinWeights {
    /// Joint indices; unused slots have weight zero.
    pub joints: [u16; 4],
    /// Weights in descending order, summing to one.
    pub weights: [f32; 4],
}

/// A mesh of quad patches (see `render::surfaces::patch` for the corner order and the limit surface).
#[derive(Clone, Debug, Default)]
pub struct PatchMesh {
    /// Rest positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit rest normals, shared by all patches around a vertex.
    pub normals: Vec<Vec3>,
    /// Linear albedo (rgb) and Beckmann roughness `α` (a) per vertex. The colour map, if any, multiplies them.
    pub colors: Vec<[f32; 4]>,
    /// Ambient accessibility in `[0, 1]` per vertex (1: unoccluded).
    pub accessibility: Vec<f32>,
    /// Skinning weights per vertex; empty for a rigid mesh.
    pub skin: Vec<SkinWeights>,
    /// Vertex indices of each patch.
    pub patches: Vec<[u32; 4]>,
    /// Whether each patch is a flat triangle. It uses the first two corners and the last; the third repeats the last. Triangles are
    /// two-sided and shaded by their vertex normals. Relief displaces them along one direction per position.
    pub triangles: bool,
    /// For each vertex of a triangle mesh, the first vertex at the same position; empty if all positions are distinct. Vertices at
    /// one position differ in normals or texture coordinates, and move together in every pose.
    pub welds: Vec<u32>,
    /// Edges, as pairs of positions, where another object continues the surface. Relief fades to 0 there so that both objects meet.
    pub rims: Vec<[u32; 2]>,
    /// Texture coordinates of each patch's corners. They are not shared between patches, so every edge may be a seam.
    pub texcoords: Vec<[Vec2; 4]>,
    /// Metres per repeat of a triplanar relief at rest (`render::surfaces::triplanar`), instead of texture coordinates. For
    /// triangles and repeating maps.
    pub triplanar: Option<f32>,
    /// Metres per repeat of the map, for a part of the plane `z = 0` with texture coordinates `xy / flat_repeat` that no pose
    /// moves. Vertices can then lie on texel centres.
    pub flat_repeat: Option<f32>,
}

impl PatchMesh {
    /// Linear albedo and Beckmann roughness of a vertex. Grey with roughness ½ if the mesh has no colours.
    pub fn color_of(&self, vertex: usize) -> [f32; 4] {
        self.colors.get(vertex).copied().unwrap_or([0.5; 4])
    }

    /// The first vertex at the position of a vertex.
    pub fn weld_of(&self, vertex: u32) -> u32 {
        self.welds.get(vertex as usize).copied().unwrap_or(vertex)
    }

    /// Whether the mesh consists of quads that agree on texture coordinates where they meet, without rims.
    pub fn is_seamless(&self) -> bool {
        let mut seen = vec![None; self.positions.len()];
        let mut agree = |vertex: u32, at: Vec2| *seen[vertex as usize].get_or_insert(at) == at;
        let whole = !self.triangles && self.triplanar.is_none() && self.welds.is_empty() && self.rims.is_empty();
        whole
            && self.texcoords.len() == self.patches.len()
            && self.patches.iter().zip(&self.texcoords).all(|(patch, at)| (0..4).all(|i| agree(patch[i], at[i])))
    }

    /// The patches' corners as position indices.
    pub fn welded_patches(&self) -> Vec<[u32; 4]> {
        self.patches.iter().map(|patch| patch.map(|vertex| self.weld_of(vertex))).collect()
    }

    /// Mean length of the patches' edges at rest, metres; 0 without patches.
    pub fn mean_edge(&self) -> f32 {
        let side = |patch: &[u32; 4], i: usize| {
            self.positions[patch[i] as usize].distance(self.positions[patch[(i + 1) & 3] as usize])
        };
        let sum: f32 = self.patches.iter().map(|patch| (0..4).map(|i| side(patch, i)).sum::<f32>()).sum();
        sum / (4 * self.patches.len()).max(1) as f32
    }

    /// Ambient accessibility of a vertex; 1 if the mesh has none.
    pub fn accessibility_of(&self, vertex: usize) -> f32 {
        self.accessibility.get(vertex).copied().unwrap_or(1.0)
    }
}

/// World-space positions and normals of a posed mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// World positions.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Displacement directions, of unit length, or 0 without displacement; equal for all vertices at a position. Empty if
    /// displacement follows the normals.
    pub directions: Vec<Vec3>,
}

impl PosedVertices {
    /// Vertices displaced along their normals.
    pub const fn new(positions: Vec<Vec3>, normals: Vec<Vec3>) -> Self {
        Self { positions, normals, directions: Vec::new() }
    }

    /// The displacement direction of each vertex.
    pub fn displaced_along(&self) -> &[Vec3] {
        if self.directions.is_empty() { &self.normals } else { &self.directions }
    }
}

/// Arrangement of per-patch tiles in an atlas: square tiles of `tile` texels, `columns` per row. The patch domain `[0,1]²` fills
/// the inner `tile − 2·gutter` texels, with centres at `(i + ½) / (tile − 2·gutter)`. The gutter continues the surface beyond the
/// patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileLayout {
    /// Tile edge in texels, a power of two.
    pub tile: u32,
    /// Gutter in texels on each side.
    pub gutter: u32,
    /// Number of tiles per row.
    pub columns: u32,
    /// Number of rows.
    pub rows: u32,
}

impl TileLayout {
    /// A roughly square layout for `count` tiles, with a gutter of two texels.
    pub fn new(count: u32, tile: u32) -> Self {
        assert!(tile.is_power_of_two() && tile >= 8);
        let columns = (f64::from(count.max(1)).sqrt().ceil() as u32).next_multiple_of(4);
        Self { tile, gutter: 2, columns, rows: count.max(1).div_ceil(columns) }
    }

    /// Atlas size in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.columns * self.tile, self.rows * self.tile)
    }

    /// Number of texels of the patch domain inside a tile, per axis.
    pub fn inner(&self) -> u32 {
        self.tile - 2 * self.gutter
    }

    /// First texel of tile `index`, including the gutter.
    pub fn origin(&self, index: u32) -> (u32, u32) {
        (index % self.columns * self.tile, index / self.columns * self.tile)
    }

    /// Texel index of the first texel of tile `index` at a mip level, row by row over the whole atlas, including the gutter.
    pub fn first_texel(&self, index: usize, level: u32) -> usize {
        let ((x, y), (width, _)) = (self.origin(index as u32), self.size());
        (y >> level) as usize * (width >> level) as usize + (x >> level) as usize
    }

    /// Texture coordinates of the four corners of patch `index`.
    pub fn texcoords(&self, index: u32) -> [Vec2; 4] {
        let (w, h) = self.size();
        let (x, y) = self.origin(index);
        let size = Vec2::new(w as f32, h as f32);
        let low = Vec2::new((x + self.gutter) as f32, (y + self.gutter) as f32);
        let high = low + Vec2::splat(self.inner() as f32);
        [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)].map(|t| t / size)
    }
}
