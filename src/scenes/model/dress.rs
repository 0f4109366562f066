//! A model's triangles in their material.

use glam::Vec2;
use rayon::prelude::*;

use super::parts::Parts;
use crate::models::Model;
use crate::render::scene::Object;
use crate::render::surfaces::displacement::{Border, HeightField};
use crate::render::surfaces::patch_mesh::{PatchMesh, PosedVertices};
use crate::scenes::cover::{Cover, Texel};

/// An object of the model, at rest in this pose.
pub fn object(model: &Model, parts: &Parts, index: usize, rest: PosedVertices) -> Object {
    let (corners, texcoords) = parts.triangles(model, index);
    let mesh = PatchMesh {
        accessibility: vec![1.0; rest.positions.len()],
        positions: rest.positions,
        normals: rest.normals,
        colors: parts.colors(model, index),
        patches: corners.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        texcoords: texcoords.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        triangles: true,
        ..PatchMesh::default()
    };
    let material = &model.materials[parts.objects[index].material];
    let cover = Cover::new(material);
    let (width, height) = cover.size;
    let size = Vec2::new(width as f32, height as f32);
    let place = |index: usize| {
        let [x, y] = [index % width as usize, index / width as usize].map(|k| k as f32 + 0.5);
        Vec2::new(x, y) / size
    };
    let places = 0..width as usize * height as usize;
    let texels: Vec<Texel> = places.clone().into_par_iter().map(|index| cover.texel(place(index))).collect();
    let object = Object::new(format!("{} {}", model.name, material.name), mesh)
        .with_specular_f0(texels[0].body_f0)
        .with_material(Cover::map(width, height, &texels));
    if !cover.has_slopes() {
        return object;
    }
    let flat = vec![0.0; places.len()];
    object
        .with_heights(HeightField { width, height, texels: flat, border: Border::Wrap }, 1.0)
        .with_slopes(places.into_par_iter().map(|index| cover.slope(place(index)).to_array()).collect())
}
