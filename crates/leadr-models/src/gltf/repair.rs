//! Repairs of directions and colours whose meaning is obvious.

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};

use crate::deform::plane_normal;
use crate::mesh::Primitive;

/// A repair is reported if a length differs from 1 by more than this limit. Lengths from normalised bytes differ by up to
/// 0.7 %.
const ROUNDING: f32 = 0.01;

/// What is unusual in a primitive, and its repair if it violates glTF.
pub(super) struct Finding {
    pub(super) what: String,
    pub(super) repair: Option<&'static str>,
}

/// Normalises normals and tangents, and replaces vectors without a direction. Returns what was repaired.
pub(super) fn directions(primitive: &mut Primitive) -> Vec<Finding> {
    let mut findings = Vec::new();
    let vertices = primitive.positions.len();
    let mut note = |count: usize, what: &str, repair| {
        if count > 0 {
            findings.push(Finding { what: format!("{count} of {vertices} {what}"), repair: Some(repair) });
        }
    };
    let (mut uneven, mut missing) = (0, Vec::new());
    for (vertex, normal) in primitive.normals.iter_mut().enumerate() {
        let given = Vec3::from(*normal);
        match unit(given) {
            Some(unit) => {
                uneven += usize::from(differs(given.length()));
                *normal = unit.to_array();
            }
            None => missing.push(vertex),
        }
    }
    note(uneven, "normals are not of unit length", "they are scaled");
    note(missing.len(), "normals have no direction", "they are replaced by those of the adjacent triangles");
    if !missing.is_empty() {
        let around = normals_around(primitive);
        missing.iter().for_each(|&vertex| primitive.normals[vertex] = around[vertex]);
    }

    let Some(tangents) = &mut primitive.tangents else { return findings };
    let (mut uneven, mut signs) = (0, 0);
    for (tangent, normal) in tangents.iter_mut().zip(&primitive.normals) {
        let given = Vec4::from(*tangent);
        uneven += usize::from(differs(given.xyz().length()));
        signs += usize::from(differs(given.w.abs()));
        let [x, y, z] = unit(given.xyz()).unwrap_or_else(|| Vec3::from(*normal).any_orthonormal_vector()).to_array();
        *tangent = [x, y, z, if given.w < 0.0 { -1.0 } else { 1.0 }];
    }
    note(uneven, "tangents are not of unit length", "they are scaled or replaced");
    note(signs, "tangents have a sign that is neither 1 nor -1", "its own sign is used");
    findings
}

/// Whether a length is not 1, or not a number.
fn differs(length: f32) -> bool {
    length.is_nan() || (length - 1.0).abs() > ROUNDING
}

/// Returns the unit vector in a direction, if there is one. In 32 bits, squares of very small or very large vectors would
/// overflow.
fn unit(direction: Vec3) -> Option<Vec3> {
    direction.as_dvec3().try_normalize().map(|unit| unit.as_vec3())
}

/// Returns the area-weighted mean normal of the triangles at each vertex. A vertex without triangles gets +z.
fn normals_around(primitive: &Primitive) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; primitive.positions.len()];
    for triangle in &primitive.triangles {
        let normal = plane_normal(triangle.map(|v| primitive.positions[v as usize]));
        triangle.iter().for_each(|&v| sums[v as usize] += normal);
    }
    sums.into_iter().map(|sum| sum.normalize_or(DVec3::Z).as_vec3().to_array()).collect()
}

/// Clamps colours to 0..1, and replaces NaN by 1. Returns whether any colour changed.
pub(super) fn clamp(colors: &mut [[f32; 4]]) -> bool {
    let mut changed = false;
    for value in colors.as_flattened_mut() {
        let clamped = if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) };
        changed |= clamped != *value;
        *value = clamped;
    }
    changed
}
