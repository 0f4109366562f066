//! Groups the triangles of a model by material, and moves their vertices to a pose.

use glam::{Vec2, Vec3};

use super::charts::{Chart, Charts};
use leadr_models::{Model, Pose, Primitive};
use leadr_render::scene::TriangleCharts;
use leadr_render::surfaces::patch_mesh::PosedVertices;

/// The triangles of one primitive, placed by one node.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub node: usize,
    pub primitive: usize,
    /// Whether the node mirrors its mesh at rest.
    pub mirrored: bool,
}

impl Part {
    pub fn shown_in<'a>(&self, model: &'a Model) -> &'a Primitive {
        let mesh = model.nodes[self.node].mesh.unwrap_or_default();
        &model.meshes[mesh].primitives[self.primitive]
    }
}

/// The corners of triangles in the charts of a material.
#[derive(Debug)]
pub struct ChartTexcoords {
    /// The coordinates in the chart of slopes and heights.
    pub slopes: Vec<[Vec2; 3]>,
    /// The coordinates in the charts of the images, if the charts differ.
    pub images: Option<Vec<TriangleCharts>>,
}

/// Visible parts that use one material, drawn as one object.
#[derive(Clone, Debug)]
pub struct Parted {
    /// The index of the material.
    pub material: usize,
    /// The visible parts that have this material.
    pub parts: Vec<Part>,
    /// Whether the parts are instances of one mesh. Otherwise the object has the triangles of all parts.
    pub instanced: bool,
}

impl Parted {
    /// Returns the parts whose triangles the object has.
    pub fn staged(&self) -> &[Part] {
        if self.instanced { &self.parts[..1] } else { &self.parts }
    }

    /// Returns the parts of each instance.
    pub fn instances(&self) -> std::slice::Chunks<'_, Part> {
        self.parts.chunks(if self.instanced { 1 } else { self.parts.len().max(1) })
    }
}

/// The visible triangles of a model, grouped by material.
#[derive(Clone, Debug)]
pub struct Parts {
    pub objects: Vec<Parted>,
}

impl Parts {
    /// Collects the visible parts of the model's scene.
    pub fn of(model: &Model) -> Self {
        let mut objects: Vec<Parted> = Vec::new();
        let mut of_material = vec![None; model.materials.len()];
        let rest = model.pose(None, 0.0);
        for node in model.shown_nodes() {
            let Some(mesh) = model.nodes[node].mesh else { continue };
            for (primitive, shown) in model.meshes[mesh].primitives.iter().enumerate() {
                if shown.triangles.is_empty() {
                    continue;
                }
                let object = *of_material[shown.material].get_or_insert_with(|| {
                    objects.push(Parted { material: shown.material, parts: Vec::new(), instanced: false });
                    objects.len() - 1
                });
                let mirrored = model.is_mirrored(&rest, node, primitive);
                objects[object].parts.push(Part { node, primitive, mirrored });
            }
        }
        Self { objects }
    }

    /// Whether any object is displaced.
    pub fn are_displaced(&self, model: &Model) -> bool {
        self.objects.iter().any(|object| model.materials[object.material].relief.is_some())
    }

    /// Returns the bounding corners of a pose, in the model's coordinates.
    pub fn bounds(&self, model: &Model, pose: &Pose) -> (Vec3, Vec3) {
        let mut corners = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in self.objects.iter().flat_map(|object| &object.parts) {
            for position in model.posed_vertices(pose, part.node, part.primitive).positions {
                let position = Vec3::from(position);
                corners = (corners.0.min(position), corners.1.max(position));
            }
        }
        corners
    }

    /// Returns the vertices of all instances of all objects in a pose.
    pub fn all_posed(&self, model: &Model, pose: &Pose, placement: &Placement) -> Vec<PosedVertices> {
        let instances = self.objects.iter().flat_map(Parted::instances);
        instances.map(|parts| posed(model, pose, parts, placement)).collect()
    }

    /// Returns an object's triangles as vertex indices, counter-clockwise, and the coordinates of the corners in the charts of the
    /// material.
    pub fn triangles(&self, model: &Model, object: usize, charts: &Charts) -> (Vec<[u32; 3]>, ChartTexcoords) {
        let (mut corners, mut first) = (Vec::new(), 0);
        let mut texcoords = ChartTexcoords { slopes: Vec::new(), images: (!charts.are_one()).then(Vec::new) };
        for part in self.objects[object].staged() {
            let primitive = part.shown_in(model);
            for &[a, b, c] in &primitive.triangles {
                let triangle = if part.mirrored { [a, c, b] } else { [a, b, c] };
                corners.push(triangle.map(|v| first + v));
                let texcoord = |chart: &Chart, vertex: u32| chart.texcoord(&|set| coordinates(primitive, set, vertex));
                texcoords.slopes.push(triangle.map(|v| texcoord(&charts.slopes, v)));
                if let Some(images) = &mut texcoords.images {
                    images.push(charts.images.map(|chart| triangle.map(|v| texcoord(&chart, v))));
                }
            }
            first += primitive.positions.len() as u32;
        }
        (corners, texcoords)
    }

    /// Returns the lower and upper corner of a texture coordinate set's bounding box on an object.
    pub fn reached(&self, model: &Model, object: usize, set: usize) -> (Vec2, Vec2) {
        let parts = self.objects[object].staged().iter().map(|part| part.shown_in(model));
        let used = parts.flat_map(|primitive| {
            primitive.triangles.iter().flatten().map(move |&vertex| coordinates(primitive, set, vertex))
        });
        used.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
    }

    /// Returns the factors on the height scale at an object's vertices, or an empty list if all are 1.
    pub fn height_scales(&self, model: &Model, object: usize) -> Vec<f32> {
        let parts = self.objects[object].staged().iter().map(|part| part.shown_in(model));
        if parts.clone().all(|primitive| primitive.height_scales.is_none()) {
            return Vec::new();
        }
        parts.flat_map(|p| p.height_scales.clone().unwrap_or_else(|| vec![1.0; p.positions.len()])).collect()
    }

    /// Returns the linear colours and the opacity of an object's vertices. The default is white and opaque.
    pub fn colors(&self, model: &Model, object: usize) -> Vec<[f32; 4]> {
        let of_part = |part: &Part| {
            let primitive = part.shown_in(model);
            primitive.colors.clone().unwrap_or_else(|| vec![[1.0; 4]; primitive.positions.len()])
        };
        self.objects[object].staged().iter().flat_map(of_part).collect()
    }
}

/// Returns the vertices of parts in a pose.
fn posed(model: &Model, pose: &Pose, parts: &[Part], placement: &Placement) -> PosedVertices {
    let mut posed = PosedVertices::default();
    for part in parts {
        let part = model.posed_vertices(pose, part.node, part.primitive);
        posed.positions.extend(part.positions.iter().map(|&p| placement.to_world(Vec3::from(p))));
        posed.normals.extend(part.normals.iter().map(|&n| to_z_up(Vec3::from(n))));
    }
    posed
}

/// Returns the texture coordinates of a vertex; the origin if the file has none.
fn coordinates(primitive: &Primitive, set: usize, vertex: u32) -> Vec2 {
    primitive.texcoords.get(set).map_or(Vec2::ZERO, |all| Vec2::from(all[vertex as usize]))
}

/// Converts the coordinates of glTF (y up, front along z) to those of the renderer (z up, front along -y).
pub fn to_z_up(v: Vec3) -> Vec3 {
    Vec3::new(v.x, -v.z, v.y)
}

/// The transform from a model to the world.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    scale: f32,
    offset: Vec3,
}

impl Placement {
    /// Centres a model on the ground. `low` and `high` are the bounds of the model in its own coordinates.
    pub fn on_ground(low: Vec3, high: Vec3) -> Self {
        let size = low.distance(high);
        let scale = if (0.3..=30.0).contains(&size) { 1.0 } else { 3.0 / size.max(1e-20) };
        let (a, b) = (to_z_up(low), to_z_up(high));
        let (low, high) = (a.min(b), a.max(b));
        Self { scale, offset: -scale * (0.5 * (low + high)).with_z(low.z) }
    }

    /// Raises the placement by this number of metres.
    pub fn lifted(self, metres: f32) -> Self {
        Self { offset: self.offset + metres * Vec3::Z, ..self }
    }

    /// Returns the number of world metres per unit of the model.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Maps a point of the model to the world.
    pub fn to_world(self, point: Vec3) -> Vec3 {
        to_z_up(point) * self.scale + self.offset
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use leadr_models::{Node, Transform};

    /// Returns a node with nothing.
    pub fn node() -> Node {
        let transform = Transform::IDENTITY;
        let (parent, mesh, skin, camera, light) = (None, None, None, None, None);
        Node {
            name: String::new(),
            parent,
            children: Vec::new(),
            transform,
            mesh,
            skin,
            camera,
            light,
            weights: Vec::new(),
            visible: true,
        }
    }

    #[test]
    fn models_stand_in_the_middle_of_the_ground() {
        let placement = Placement::on_ground(Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 5.0, 4.0));
        assert_eq!(placement.to_world(Vec3::new(2.0, 2.0, 3.5)), Vec3::ZERO);
        // The top of the model faces up, and its front faces -y.
        assert_eq!(placement.to_world(Vec3::new(2.0, 5.0, 3.5)), 3.0 * Vec3::Z);
        assert_eq!(placement.to_world(Vec3::new(2.0, 2.0, 4.0)), -0.5 * Vec3::Y);
        let huge = Placement::on_ground(Vec3::ZERO, Vec3::new(0.0, 300.0, 0.0));
        assert!((huge.to_world(Vec3::new(0.0, 300.0, 0.0)) - 3.0 * Vec3::Z).length() < 1e-5);
    }
}
