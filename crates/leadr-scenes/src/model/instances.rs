//! Selects nodes of a mesh that are drawn as instances, which share the triangles and the maps of one object.

use std::collections::HashMap;

use super::parts::{Part, Parted, Parts};
use crate::cover::finest;
use leadr_models::Model;
use leadr_render::surfaces::numbering::{MAX_OBJECTS, Numbering};

/// Minimum triangles of a mesh that is drawn as instances. One draw of many smaller meshes costs less than a draw for each node.
const LEAST_TRIANGLES: usize = 256;
/// Bytes that a triangle takes in an object, besides its vertices.
const TRIANGLE_BYTES: usize = 256;
/// Bytes that a texel of a material takes in an object.
const TEXEL_BYTES: usize = 32;

/// Draws the nodes that share a mesh as instances, where this saves memory. Objects beside the model take `others` of the renderer's objects.
///
/// Displaced models are unchanged, because relief must meet in the edges between nodes.
pub fn share_meshes(model: &Model, parts: &mut Parts, others: usize) {
    if parts.are_displaced(model) {
        return;
    }
    let taken = others + parts.objects.len();
    let mut most = MAX_OBJECTS;
    while most > taken {
        let objects = shared(model, &parts.objects, most - taken);
        let count = others + objects.iter().map(|object| object.instances().len()).sum::<usize>();
        let triangles = |object: &Parted| object.staged().iter().map(|part| part.shown_in(model).triangles.len()).sum();
        if objects.iter().map(triangles).max() <= Some(Numbering::of_count(count).patches()) {
            parts.objects = objects;
            return;
        }
        // The more objects a scene has, the fewer triangles each may have.
        most /= 2;
    }
}

/// Splits objects into instances and the rest. The result has at most `room` more objects.
fn shared(model: &Model, all: &[Parted], mut room: usize) -> Vec<Parted> {
    let mut objects = Vec::new();
    for Parted { material, parts, .. } in all.iter().cloned() {
        let (width, height) = finest(&model.materials[material]);
        let maps = TEXEL_BYTES * width as usize * height as usize;
        let all = parts.len();
        let mut copies: HashMap<_, usize> = HashMap::new();
        parts.iter().for_each(|part| *copies.entry(mesh_of(model, part)).or_default() += 1);
        // Objects are in the order of their first nodes.
        let mut instanced: HashMap<_, Option<usize>> = HashMap::new();
        let mut merged = Vec::new();
        for part in parts {
            let mesh = mesh_of(model, &part);
            let copies = copies[&mesh];
            let object = *instanced.entry(mesh).or_insert_with(|| {
                let triangles = part.shown_in(model).triangles.len();
                // A further object of the material needs maps of its own.
                let saves = copies == all || (copies - 1) * triangles * TRIANGLE_BYTES > maps;
                let suits = copies > 1 && triangles >= LEAST_TRIANGLES && saves && copies <= room;
                suits.then(|| {
                    room -= copies;
                    objects.push(Parted { material, parts: Vec::new(), instanced: true });
                    objects.len() - 1
                })
            });
            match object {
                Some(object) => objects[object].parts.push(part),
                None => merged.push(part),
            }
        }
        if !merged.is_empty() {
            objects.push(Parted { material, parts: merged, instanced: false });
        }
    }
    objects
}

/// Returns a key that is equal for parts with the same triangles in the same winding.
fn mesh_of(model: &Model, part: &Part) -> (Option<usize>, usize, bool) {
    (model.nodes[part.node].mesh, part.primitive, part.mirrored)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::parts::tests::node;
    use glam::Vec3;
    use leadr_maps::HeightMap;
    use leadr_maps::material::{Encoding, Input, Material, Raster, Relief, Samples, Texture};
    use leadr_models::{Mesh, Node, Primitive, Transform};

    /// Returns a model with a node for each of `meshes`, from meshes of these triangles and one material.
    fn model(triangles: &[usize], meshes: &[usize]) -> Model {
        let mesh = |&count: &usize| {
            let primitive =
                Primitive { triangles: vec![[0, 1, 2]; count], positions: vec![[0.0; 3]; 3], ..Primitive::default() };
            Mesh { primitives: vec![primitive], ..Mesh::default() }
        };
        Model {
            nodes: meshes.iter().map(|&mesh| Node { mesh: Some(mesh), ..node() }).collect(),
            order: (0..meshes.len()).collect(),
            meshes: triangles.iter().map(mesh).collect(),
            materials: vec![Material::new("m")],
            ..Model::default()
        }
    }

    /// Returns the nodes of each object, and whether the nodes are instances.
    fn objects(model: &Model, others: usize) -> Vec<(Vec<usize>, bool)> {
        let mut parts = Parts::of(model);
        share_meshes(model, &mut parts, others);
        let nodes = |object: &Parted| object.parts.iter().map(|part| part.node).collect();
        parts.objects.iter().map(|object| (nodes(object), object.instanced)).collect()
    }

    #[test]
    fn nodes_of_a_large_mesh_become_instances() {
        let mut both = model(&[300, 300, 2], &[0, 2, 0, 1, 2, 0]);
        assert_eq!(objects(&both, 1), [(vec![0, 2, 5], true), (vec![1, 3, 4], false)]);
        // Mirrored nodes have the opposite winding.
        let scale = Vec3::new(-1.0, 1.0, 1.0);
        let Transform::Parts { translation, rotation, .. } = Transform::IDENTITY else { panic!() };
        both.nodes[0].transform = Transform::Parts { translation, rotation, scale };
        assert_eq!(objects(&both, 1), [(vec![2, 5], true), (vec![0, 1, 3, 4], false)]);
        // A large object leaves no numbers for many instances.
        let crowd = model(&[300, 70_000], &[vec![1], vec![0; 9000]].concat());
        assert!(objects(&crowd, 1).iter().all(|(_, instanced)| !instanced));
        assert!(objects(&model(&[300, 60_000], &[vec![1], vec![0; 9000]].concat()), 1)[0].1);
        // Nodes beyond the renderer's objects are merged.
        assert_eq!(objects(&both, MAX_OBJECTS - 2), [(vec![0, 1, 2, 3, 4, 5], false)]);
    }

    #[test]
    fn instances_save_memory_or_are_merged() {
        let mut part = model(&[300, 2], &[0, 0, 1]);
        let raster = Raster::new(256, 256, 1, Samples::U8(vec![0; 256 * 256])).unwrap();
        part.materials[0].base_color = Input::colors(Texture::new(raster, "t", Encoding::Srgb));
        assert_eq!(objects(&part, 1), [(vec![0, 1, 2], false)], "a second object needs a second texture");
        part.nodes.pop();
        part.order.pop();
        assert_eq!(objects(&part, 1), [(vec![0, 1], true)]);
        let map = HeightMap { width: 1, height: 1, texels: vec![0.0] };
        part.materials[0].relief = Some(Relief { map, scale: None, in_widths: false, middle: 0.0 });
        assert_eq!(objects(&part, 1), [(vec![0, 1], false)], "relief meets in the edges between nodes");
    }

    #[test]
    fn a_small_file_with_many_copies_is_refused_with_its_counts() {
        let copies = |count: usize| model(&[3000], &vec![0; count]);
        let check = |model: &Model| {
            let mut parts = Parts::of(model);
            share_meshes(model, &mut parts, 1);
            crate::model::budget::check(model, &parts, 1)
        };
        assert!(check(&copies(4000)).is_ok());
        let error = check(&copies(20_000)).unwrap_err().to_string();
        assert!(error.contains("draw 20000 meshes of 60000000 triangles and 60000 vertices in total"), "{error}");
        assert!(error.contains("; the limit is ") && error.contains("; remove copies"), "{error}");
    }
}
