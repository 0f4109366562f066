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

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::HeightMap;
    use leadr_render::surfaces::patch_mesh::PatchMesh;

    fn map(texels: Vec<f32>) -> FactorMap {
        FactorMap { width: 8, height: 8, texels, transform: Affine2::from_scale(Vec2::splat(0.5)) }
    }

    #[test]
    fn factors_change_as_their_derivatives_say() {
        let wave = |i: u32| 0.5 + 0.5 * (std::f32::consts::TAU * (i % 8) as f32 / 8.0).cos() * (i / 8) as f32 / 8.0;
        let scale = SampledScale::new(Some(&map((0..64).map(wave).collect())));
        // Central differences are exact at texel centres, whose distance is 1/4 of a unit.
        for at in [Vec2::new(0.375, 0.625), Vec2::new(1.125, 0.875)] {
            let (factor, change) = scale.at(at);
            let step = 0.125;
            let [s, t] = [Vec2::X, Vec2::Y]
                .map(|axis| (scale.at(at + step * axis).0 - scale.at(at - step * axis).0) / (2.0 * step));
            assert!((0.0..=1.0).contains(&factor) && (change - Vec2::new(s, t)).length() < 1e-5, "{change} {s} {t}");
        }
        assert_eq!(SampledScale::new(None).at(Vec2::ONE), (1.0, Vec2::ZERO));
    }

    #[test]
    fn only_relief_over_texture_coordinates_varies() {
        let smooth = || Object::new("smooth", PatchMesh::default());
        let error = vary_height(&mut [smooth()], map(vec![1.0; 64])).unwrap_err().to_string();
        assert!(error.contains("--height-scale-map needs relief"), "{error}");
        let heights = HeightField::repeating(HeightMap { width: 1, height: 1, texels: vec![0.0] });
        let mut objects = [smooth(), smooth().with_heights(heights, 1.0)];
        vary_height(&mut objects, map(vec![1.0; 64])).unwrap();
        assert!(objects[0].height_scale_map.is_none() && objects[1].height_scale_map.is_some());
        // The top of the image lies at the largest t of the plane.
        let top = upright(map(vec![1.0; 64])).transform.transform_point2(Vec2::new(0.0, 1.0));
        assert_eq!(top, Vec2::ZERO);
    }
}
