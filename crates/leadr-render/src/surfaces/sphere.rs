//! Bounding spheres.

use glam::Vec3;

/// A sphere in world space, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre of the sphere.
    pub centre: Vec3,
    /// The radius of the sphere.
    pub radius: f32,
}

impl Sphere {
    /// Returns a sphere around other spheres, centred on their bounding box. Returns `None` for an empty slice.
    pub fn enclosing(spheres: &[Self]) -> Option<Self> {
        let (low, high) = spheres
            .iter()
            .map(|s| (s.centre - s.radius, s.centre + s.radius))
            .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))?;
        let centre = (low + high) * 0.5;
        let radius = spheres.iter().map(|s| s.centre.distance(centre) + s.radius).fold(0.0, f32::max);
        Some(Self { centre, radius: radius.max(1e-6) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_enclosing_sphere_holds_the_others() {
        let spheres = [(Vec3::ZERO, 1.0), (Vec3::X * 8.0, 2.0), (Vec3::Y * -3.0, 0.5)];
        let spheres = spheres.map(|(centre, radius)| Sphere { centre, radius });
        let around = Sphere::enclosing(&spheres).unwrap();
        assert!(spheres.iter().all(|s| s.centre.distance(around.centre) + s.radius <= around.radius * 1.000_001));
        assert!(around.radius < 8.0);
        assert_eq!(Sphere::enclosing(&[]), None);
    }
}
