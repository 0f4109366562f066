//! A mesh of quads that is tessellated and displaced. Scenes create it, and the geometry pass draws it.

use glam::{Vec2, Vec3};

/// Up to four joints for linear blend skinning, with weights that sum to one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkinWeights {
    /// The indices of the joints. Unused slots have the weight zero.
    pub joints: [u16; 4],
    /// The weights in descending order, which sum to one.
    pub weights: [f32; 4],
}

/// A mesh of quad patches. The corner order and the limit surface are described in `render::surfaces::patch`.
#[derive(Clone, Debug, Default)]
pub struct PatchMesh {
    /// The positions of the vertices at rest, in metres.
    pub positions: Vec<Vec3>,
    /// The unit normals at rest. All patches around a vertex share its normal.
    pub normals: Vec<Vec3>,
    /// The linear albedo (rgb) and the Beckmann roughness `α` (a) of each vertex. The colour map, if there is one, multiplies them.
    pub colors: Vec<[f32; 4]>,
    /// The ambient accessibility of each vertex, from 0 to 1 (unoccluded).
    pub accessibility: Vec<f32>,
    /// The factor on the height scale at each vertex, 0 or more. The list is empty if all factors are 1.
    pub height_scales: Vec<f32>,
    /// The skinning weights of each vertex. The list is empty for a rigid mesh.
    pub skin: Vec<SkinWeights>,
    /// The vertex indices of each patch.
    pub patches: Vec<[u32; 4]>,
    /// Whether each patch is a flat triangle. A triangle uses the first two corners and the last, and the third repeats the last.
    /// Triangles are two-sided, and are shaded with the normals of their vertices. Relief displaces all vertices at a position in
    /// the same direction.
    pub triangles: bool,
    /// For each vertex of a triangle mesh, the first vertex at the same position. The list is empty if all positions are distinct.
    /// Vertices at the same position differ in normals or texture coordinates, and move together in every pose.
    pub welds: Vec<u32>,
    /// The edges at which another object continues the surface, as pairs of position indices. Relief fades to 0 at these edges, so
    /// that no gap opens between the two objects.
    pub rims: Vec<[u32; 2]>,
    /// The texture coordinates of each patch's corners. Patches do not share them, so every edge may be a seam.
    pub texcoords: Vec<[Vec2; 4]>,
    /// The length of one repeat of a triplanar relief at rest, in metres (`render::surfaces::triplanar`). Triangles with repeating
    /// maps use it instead of texture coordinates.
    pub triplanar: Option<f32>,
    /// The length of one repeat of the map in metres, for a mesh in the plane `z = 0` with texture coordinates `xy / flat_repeat`
    /// that no pose moves. The vertices of such a mesh can lie on texel centres.
    pub flat_repeat: Option<f32>,
}

impl PatchMesh {
    /// Returns the linear albedo and the Beckmann roughness of a vertex. If the mesh has no colours, it is grey and has a roughness
    /// of ½.
    pub fn color_of(&self, vertex: usize) -> [f32; 4] {
        self.colors.get(vertex).copied().unwrap_or([0.5; 4])
    }

    /// Returns the first vertex at the position of a vertex.
    pub fn weld_of(&self, vertex: u32) -> u32 {
        self.welds.get(vertex as usize).copied().unwrap_or(vertex)
    }

    /// Whether the mesh consists of quads without rims, and every vertex has the same texture coordinate in all its quads.
    pub fn is_seamless(&self) -> bool {
        let mut seen = vec![None; self.positions.len()];
        let mut agree = |vertex: u32, at: Vec2| *seen[vertex as usize].get_or_insert(at) == at;
        let whole = !self.triangles && self.triplanar.is_none() && self.welds.is_empty() && self.rims.is_empty();
        whole
            && self.texcoords.len() == self.patches.len()
            && self.patches.iter().zip(&self.texcoords).all(|(patch, at)| (0..4).all(|i| agree(patch[i], at[i])))
    }

    /// Returns the patches, where each corner is replaced by the first vertex at its position.
    pub fn welded_patches(&self) -> Vec<[u32; 4]> {
        self.patches.iter().map(|patch| patch.map(|vertex| self.weld_of(vertex))).collect()
    }

    /// Returns the mean length of the edges of the patches at rest, in metres, or 0 without patches.
    pub fn mean_edge(&self) -> f32 {
        let side = |patch: &[u32; 4], i: usize| {
            self.positions[patch[i] as usize].distance(self.positions[patch[(i + 1) & 3] as usize])
        };
        let sum: f32 = self.patches.iter().map(|patch| (0..4).map(|i| side(patch, i)).sum::<f32>()).sum();
        sum / (4 * self.patches.len()).max(1) as f32
    }

    /// Returns the factor on the height scale at a vertex, or 1 if the mesh has none.
    pub fn height_scale_of(&self, vertex: usize) -> f32 {
        self.height_scales.get(vertex).copied().unwrap_or(1.0)
    }

    /// Returns the ambient accessibility of a vertex, or 1 if the mesh has none.
    pub fn accessibility_of(&self, vertex: usize) -> f32 {
        self.accessibility.get(vertex).copied().unwrap_or(1.0)
    }
}

/// The positions and normals of a posed mesh in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// The world positions.
    pub positions: Vec<Vec3>,
    /// The unit normals.
    pub normals: Vec<Vec3>,
    /// The displacement directions as unit vectors, or zero for vertices that are not displaced. All vertices at a position have
    /// the same direction. The list is empty if the vertices are displaced along their normals.
    pub directions: Vec<Vec3>,
}

impl PosedVertices {
    /// Creates vertices that are displaced along their normals.
    pub const fn new(positions: Vec<Vec3>, normals: Vec<Vec3>) -> Self {
        Self { positions, normals, directions: Vec::new() }
    }

    /// Returns the displacement direction of each vertex.
    pub fn displaced_along(&self) -> &[Vec3] {
        if self.directions.is_empty() { &self.normals } else { &self.directions }
    }
}

/// The arrangement of tiles in an atlas with one tile per patch. Tiles are squares of `tile` texels per side, and a row has
/// `columns` tiles. The patch domain `[0,1]²` fills the inner `tile − 2·gutter` texels, with texel centres at `(i + ½) / (tile −
/// 2·gutter)`. The gutter continues the surface beyond the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileLayout {
    /// The side of a tile in texels, which is a power of two.
    pub tile: u32,
    /// The width of the gutter on each side of a tile, in texels.
    pub gutter: u32,
    /// The number of tiles per row.
    pub columns: u32,
    /// The number of rows of tiles.
    pub rows: u32,
}

impl TileLayout {
    /// Returns a roughly square layout for `count` tiles. The gutter is two texels wide.
    pub fn new(count: u32, tile: u32) -> Self {
        assert!(tile.is_power_of_two() && tile >= 8);
        let columns = (f64::from(count.max(1)).sqrt().ceil() as u32).next_multiple_of(4);
        Self { tile, gutter: 2, columns, rows: count.max(1).div_ceil(columns) }
    }

    /// Returns the width and height of the atlas in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.columns * self.tile, self.rows * self.tile)
    }

    /// Returns the number of texels of the patch domain along one axis of a tile.
    pub fn inner(&self) -> u32 {
        self.tile - 2 * self.gutter
    }

    /// Returns the position of the first texel of tile `index`. The gutter is part of the tile.
    pub fn origin(&self, index: u32) -> (u32, u32) {
        (index % self.columns * self.tile, index / self.columns * self.tile)
    }

    /// Returns the linear index of the first texel of tile `index` in the atlas, at a mip level. The gutter is part of the tile.
    pub fn first_texel(&self, index: usize, level: u32) -> usize {
        let ((x, y), (width, _)) = (self.origin(index as u32), self.size());
        (y >> level) as usize * (width >> level) as usize + (x >> level) as usize
    }

    /// Returns the texture coordinates of the four corners of patch `index`.
    pub fn texcoords(&self, index: u32) -> [Vec2; 4] {
        let (w, h) = self.size();
        let (x, y) = self.origin(index);
        let size = Vec2::new(w as f32, h as f32);
        let low = Vec2::new((x + self.gutter) as f32, (y + self.gutter) as f32);
        let high = low + Vec2::splat(self.inner() as f32);
        [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)].map(|t| t / size)
    }
}
