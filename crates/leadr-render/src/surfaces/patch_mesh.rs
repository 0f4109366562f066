//! A quad mesh ready to be tessellated and displaced: scenes produce it and the geometry pass draws it.

use glam::{Vec2, Vec3};

/// Up to four joints and their weights (sum 1) for linear blend skinning.
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
    /// Linear albedo (rgb) and Beckmann roughness `α` (a) per vertex; multiplied with the colour map where there is one.
    pub colors: Vec<[f32; 4]>,
    /// Ambient accessibility in `[0, 1]` per vertex (1: unoccluded).
    pub accessibility: Vec<f32>,
    /// Skinning weights per vertex; empty for a rigid mesh.
    pub skin: Vec<SkinWeights>,
    /// Vertex indices of each patch.
    pub patches: Vec<[u32; 4]>,
    /// Whether each patch is a flat triangle of its first two corners and its last, which stands for the third as well. Triangles are
    /// drawn from both sides and shaded by the normals of their own vertices; what relief they have displaces them along the
    /// directions of their places.
    pub triangles: bool,
    /// For each vertex of a mesh of triangles the first one at the same place; empty where every vertex has a place of its own.
    /// Vertices of a place differ in normals or texture coordinates, and go the same way in every pose.
    pub places: Vec<u32>,
    /// Pairs of places between which the surface goes on as another object: relief ends there, so that both objects meet.
    pub rims: Vec<[u32; 2]>,
    /// Texture coordinates of each patch's corners (not shared between patches, so every edge may be a seam).
    pub texcoords: Vec<[Vec2; 4]>,
    /// Metres per repeat of a relief that is seen along the axes where the mesh is at rest (`render::surfaces::triplanar`) instead of by
    /// texture coordinates: for triangles, and maps that repeat.
    pub triplanar: Option<f32>,
    /// Metres per repeat of the map if this is a part of the plane `z = 0` at rest whose texture coordinates are `xy` divided by
    /// them, and no pose moves it: then vertices can stand at the centres of texels.
    pub flat_repeat: Option<f32>,
}

impl PatchMesh {
    /// Linear albedo and Beckmann roughness of a vertex; grey and half rough where the mesh has no colours.
    pub fn color_of(&self, vertex: usize) -> [f32; 4] {
        self.colors.get(vertex).copied().unwrap_or([0.5; 4])
    }

    /// The first vertex at the place of a vertex.
    pub fn place_of(&self, vertex: u32) -> u32 {
        self.places.get(vertex as usize).copied().unwrap_or(vertex)
    }

    /// Whether it consists of quads that have the same texture coordinates where they meet, and ends nowhere at another object.
    pub fn is_seamless(&self) -> bool {
        let mut seen = vec![None; self.positions.len()];
        let mut agree = |vertex: u32, at: Vec2| *seen[vertex as usize].get_or_insert(at) == at;
        let whole = !self.triangles && self.triplanar.is_none() && self.places.is_empty() && self.rims.is_empty();
        whole
            && self.texcoords.len() == self.patches.len()
            && self.patches.iter().zip(&self.texcoords).all(|(patch, at)| (0..4).all(|i| agree(patch[i], at[i])))
    }

    /// The places of the patches' corners.
    pub fn patches_by_place(&self) -> Vec<[u32; 4]> {
        self.patches.iter().map(|patch| patch.map(|vertex| self.place_of(vertex))).collect()
    }

    /// Mean length of the patches' sides at rest, metres; 0 without patches.
    pub fn mean_edge(&self) -> f32 {
        let side = |patch: &[u32; 4], i: usize| {
            self.positions[patch[i] as usize].distance(self.positions[patch[(i + 1) & 3] as usize])
        };
        let sum: f32 = self.patches.iter().map(|patch| (0..4).map(|i| side(patch, i)).sum::<f32>()).sum();
        sum / (4 * self.patches.len()).max(1) as f32
    }

    /// Ambient accessibility of a vertex; 1 where the mesh has none.
    pub fn accessibility_of(&self, vertex: usize) -> f32 {
        self.accessibility.get(vertex).copied().unwrap_or(1.0)
    }
}

/// World-space positions and normals of a posed mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// Positions.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Directions of displacement, of unit length or 0 where nothing is displaced: the same for all vertices of a place. Empty where
    /// the surface is displaced along its normals.
    pub directions: Vec<Vec3>,
}

impl PosedVertices {
    /// Vertices that are displaced along their normals.
    pub const fn new(positions: Vec<Vec3>, normals: Vec<Vec3>) -> Self {
        Self { positions, normals, directions: Vec::new() }
    }

    /// The direction in which each vertex is displaced.
    pub fn displaced_along(&self) -> &[Vec3] {
        if self.directions.is_empty() { &self.normals } else { &self.directions }
    }
}

/// How per-patch tiles are arranged in an atlas: square tiles of `tile` texels, `columns` to a row. Each holds the patch
/// domain `[0,1]²` in its inner `tile − 2·gutter` texels, whose centres lie at `(i + ½) / (tile − 2·gutter)`; the gutter
/// continues the surface beyond the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileLayout {
    /// Tile edge in texels, a power of two.
    pub tile: u32,
    /// Gutter in texels on each side.
    pub gutter: u32,
    /// Number of tiles per row.
    pub columns: u32,
    /// Number of rows of tiles.
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

    /// First texel of tile `index`, gutter included.
    pub fn origin(&self, index: u32) -> (u32, u32) {
        (index % self.columns * self.tile, index / self.columns * self.tile)
    }

    /// Number of the first texel of tile `index` at a mip level, row by row over the whole atlas, gutter included.
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
