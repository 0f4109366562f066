//! What of a model is drawn together: its triangles by material, carried to where they are at a time.

use glam::{Vec2, Vec3};

use crate::models::{Model, Pose};
use crate::render::surfaces::patch_mesh::PosedVertices;

/// The triangles of one primitive as a node shows them.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub node: usize,
    pub primitive: usize,
}

/// All that is shown of one material.
#[derive(Clone, Debug)]
pub struct Parted {
    /// Its number.
    pub material: usize,
    /// What wears it.
    pub parts: Vec<Part>,
}

/// The triangles of a model by material.
#[derive(Clone, Debug)]
pub struct Parts {
    pub objects: Vec<Parted>,
}

impl Parts {
    /// What the model's scene shows.
    pub fn of(model: &Model) -> Self {
        let mut objects: Vec<Parted> = Vec::new();
        for node in model.shown_nodes() {
            let Some(mesh) = model.nodes[node].mesh else { continue };
            for (primitive, shown) in model.meshes[mesh].primitives.iter().enumerate() {
                if shown.triangles.is_empty() {
                    continue;
                }
                let part = Part { node, primitive };
                match objects.iter_mut().find(|object| object.material == shown.material) {
                    Some(object) => object.parts.push(part),
                    None => objects.push(Parted { material: shown.material, parts: vec![part] }),
                }
            }
        }
        Self { objects }
    }

    /// Corners of what a pose reaches, in the model's coordinates.
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

    /// The vertices of an object in a pose.
    pub fn posed(&self, model: &Model, pose: &Pose, object: usize, placement: &Placement) -> PosedVertices {
        let mut posed = PosedVertices::default();
        for part in &self.objects[object].parts {
            let part = model.posed_vertices(pose, part.node, part.primitive);
            posed.positions.extend(part.positions.iter().map(|&p| placement.place(Vec3::from(p))));
            posed.normals.extend(part.normals.iter().map(|&n| ours(Vec3::from(n))));
        }
        posed
    }

    /// The corners of an object's triangles among its vertices, counter-clockwise, and their texture coordinates.
    pub fn triangles(&self, model: &Model, object: usize) -> (Vec<[u32; 3]>, Vec<[Vec2; 3]>) {
        let Parted { material, parts } = &self.objects[object];
        let set = coordinate_set(&model.materials[*material]);
        let (mut corners, mut texcoords, mut first) = (Vec::new(), Vec::new(), 0);
        let pose = model.pose(None, 0.0);
        for part in parts {
            let mesh = model.nodes[part.node].mesh.unwrap_or_default();
            let primitive = &model.meshes[mesh].primitives[part.primitive];
            let mirrored = model.posed_vertices(&pose, part.node, part.primitive).mirrored;
            let coordinates = primitive.texcoords.get(set);
            for &[a, b, c] in &primitive.triangles {
                let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
                corners.push(triangle.map(|v| first + v));
                let at = |v: u32| coordinates.map_or(Vec2::ZERO, |all| Vec2::from(all[v as usize]));
                texcoords.push(triangle.map(at));
            }
            first += primitive.positions.len() as u32;
        }
        (corners, texcoords)
    }

    /// Colours of an object's vertices, linear; white where they have none.
    pub fn colors(&self, model: &Model, object: usize) -> Vec<[f32; 4]> {
        let mut all = Vec::new();
        for part in &self.objects[object].parts {
            let mesh = model.nodes[part.node].mesh.unwrap_or_default();
            let primitive = &model.meshes[mesh].primitives[part.primitive];
            match &primitive.colors {
                Some(colors) => all.extend(colors.iter().map(|&[r, g, b, _]| [r, g, b, 1.0])),
                None => all.extend(std::iter::repeat_n([1.0; 4], primitive.positions.len())),
            }
        }
        all
    }
}

/// The set of texture coordinates that a material follows: that of its colours, or of whatever texture it has.
pub fn coordinate_set(material: &crate::maps::material::Material) -> usize {
    let color = material.base_color.texture.as_ref();
    let normal = material.normal_map.as_ref().map(|map| &map.texture);
    let numbers = [&material.roughness, &material.metalness].into_iter().filter_map(|input| input.texture.as_ref());
    color.into_iter().chain(normal).chain(numbers).next().map_or(0, |texture| texture.coordinates as usize)
}

/// From glTF's coordinates, y up and the front along z, to ours, z up and the front along -y.
fn ours(v: Vec3) -> Vec3 {
    Vec3::new(v.x, -v.z, v.y)
}

/// Where a model stands.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    scale: f32,
    offset: Vec3,
}

impl Placement {
    /// On the ground, in the middle. `low`, `high`: corners of the model in its own coordinates.
    pub fn on_ground(low: Vec3, high: Vec3) -> Self {
        let size = low.distance(high);
        let scale = if (0.3..=30.0).contains(&size) { 1.0 } else { 3.0 / size.max(1e-20) };
        let (a, b) = (ours(low), ours(high));
        let (low, high) = (a.min(b), a.max(b));
        Self { scale, offset: -scale * (0.5 * (low + high)).with_z(low.z) }
    }

    /// A point of the model in the world.
    pub fn place(&self, point: Vec3) -> Vec3 {
        ours(point) * self.scale + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_stand_in_the_middle_of_the_ground() {
        let place = Placement::on_ground(Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 5.0, 4.0));
        assert_eq!(place.place(Vec3::new(2.0, 2.0, 3.5)), Vec3::ZERO);
        // Its top is up, its front toward -y.
        assert_eq!(place.place(Vec3::new(2.0, 5.0, 3.5)), 3.0 * Vec3::Z);
        assert_eq!(place.place(Vec3::new(2.0, 2.0, 4.0)), -0.5 * Vec3::Y);
        let huge = Placement::on_ground(Vec3::ZERO, Vec3::new(0.0, 300.0, 0.0));
        assert!((huge.place(Vec3::new(0.0, 300.0, 0.0)) - 3.0 * Vec3::Z).length() < 1e-5);
    }
}
