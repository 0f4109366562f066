//! The map of a height scale on the surfaces of a scene.

use glam::{Affine2, Vec2};

use super::error::SceneError;
use leadr_render::scene::{FactorMap, Object};
use leadr_render::surfaces::displacement::{Border, HeightField};
use leadr_render::surfaces::height_scale::field_of;

/// Multiplies the height scale of every displaced object by a map over its texture coordinates.
///
/// # Errors
/// If no object has relief over texture coordinates.
pub fn vary_height(objects: &mut [Object], map: FactorMap) -> Result<(), SceneError> {
    let takes = |object: &&mut Object| {
        object.mesh.triplanar.is_none() && object.heights.as_ref().is_some_and(|field| field.border == Border::Wrap)
    };
    let mut displaced = objects.iter_mut().filter(takes).peekable();
    if displaced.peek().is_none() {
        let fault = "--height-scale-map needs relief over texture coordinates; add a height map, or remove it";
        return Err(SceneError::Model(fault.into()));
    }
    displaced.for_each(|object| object.height_scale_map = Some(map.clone()));
    Ok(())
}

/// Returns a map whose image is upright on the plane, where texture coordinates point up.
pub fn upright(map: FactorMap) -> FactorMap {
    let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
    FactorMap { transform: map.transform * flip, ..map }
}

/// A height scale that is sampled on the CPU.
pub struct SampledScale(Option<(HeightField, Affine2)>);

impl SampledScale {
    /// Prepares sampling of a map. Without a map, the factor is 1.
    pub fn new(map: Option<&FactorMap>) -> Self {
        Self(map.map(|map| (field_of(map), map.transform)))
    }

    /// Returns the factor at a position in the images of the material, and its derivatives by the position.
    pub fn at(&self, at: Vec2) -> (f32, Vec2) {
        let Some((field, transform)) = &self.0 else { return (1.0, Vec2::ZERO) };
        let here = transform.transform_point2(at);
        let half = 0.5 / Vec2::new(field.map.width as f32, field.map.height as f32);
        let across = |step: Vec2| field.bilinear(here + step) - field.bilinear(here - step);
        let change = Vec2::new(across(Vec2::X * half.x), across(Vec2::Y * half.y)) / (2.0 * half);
        (field.bilinear(here), transform.matrix2.transpose() * change)
    }
}
