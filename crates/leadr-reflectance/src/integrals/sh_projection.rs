//! Projects radiance onto spherical harmonics, from a function on the sphere or from a cube map.

use super::sh::{Sh9, sh_add_light};
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::PI;

/// Returns the coefficients of `radiance`, a function of a unit direction. The quadrature has `rings` Gauss–Legendre nodes in z times
/// `2 rings` equal steps of azimuth. It is exact for functions of a degree below `2 rings`.
pub fn project_function(rings: usize, radiance: impl Fn(DVec3) -> DVec3) -> Sh9 {
    let steps = 2 * rings;
    let mut c = [DVec3::ZERO; 9];
    for (z, w) in gauss_legendre(rings) {
        let r = (1.0 - z * z).max(0.0).sqrt();
        for i in 0..steps {
            let (sin, cos) = (2.0 * PI * (i as f64 + 0.5) / steps as f64).sin_cos();
            let d = DVec3::new(r * cos, r * sin, z);
            sh_add_light(&mut c, d, radiance(d) * (w * 2.0 * PI / steps as f64));
        }
    }
    c
}

/// Returns the direction of the cube face coordinates `sc` and `tc` in `[−1, 1]`, by Vulkan's cube map face selection. `tc` points
/// downwards. The faces are `+X, −X, +Y, −Y, +Z, −Z`. The direction is not normalised, but lies on the cube of half extent 1.
///
/// # Panics
/// If `face` is not below 6.
pub fn cube_direction(face: usize, sc: f64, tc: f64) -> DVec3 {
    match face {
        0 => DVec3::new(1.0, -tc, -sc),
        1 => DVec3::new(-1.0, -tc, sc),
        2 => DVec3::new(sc, 1.0, tc),
        3 => DVec3::new(sc, -1.0, -tc),
        4 => DVec3::new(sc, -tc, 1.0),
        5 => DVec3::new(-sc, -tc, -1.0),
        _ => panic!("cube face {face} is outside 0..=5"),
    }
}

/// Returns the exact solid angle of texel `(x, y)` of a cube face of `size` texels per edge, in steradians.
pub fn texel_solid_angle(size: u32, x: u32, y: u32) -> f64 {
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(size) - 1.0;
    // This is the solid angle of the rectangle from the centre of the face to (u, v).
    let corner = |u: f64, v: f64| (u * v).atan2((u * u + v * v + 1.0).sqrt());
    let (x0, x1, y0, y1) = (at(x), at(x + 1), at(y), at(y + 1));
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

/// Returns the coefficients of a cube map of `size` texels per edge. `texel(face, x, y)` is the linear RGB radiance, with row 0 at the top.
///
/// Each texel is weighted by its exact solid angle, with the basis evaluated at its centre.
pub fn project_cube(size: u32, texel: impl Fn(usize, u32, u32) -> [f64; 3]) -> Sh9 {
    let mut c = [DVec3::ZERO; 9];
    let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
    for face in 0..6 {
        for y in 0..size {
            for x in 0..size {
                let d = cube_direction(face, centre(x), centre(y)).normalize();
                sh_add_light(&mut c, d, DVec3::from_array(texel(face, x, y)) * texel_solid_angle(size, x, y));
            }
        }
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrals::sh::sh_basis;

    /// Returns a radiance of exactly order 2, with a different value in every coefficient.
    fn radiance(d: DVec3) -> DVec3 {
        let coefficients = [1.0, 0.3, -0.2, 0.5, 0.11, -0.07, 0.19, 0.23, -0.13];
        let v: f64 = sh_basis(d).iter().zip(coefficients).map(|(b, c)| b * c).sum();
        DVec3::new(v, 2.0 * v, -v)
    }

    #[test]
    fn function_projection_returns_the_coefficients() {
        let c = project_function(4, radiance);
        for (c, expected) in c.iter().zip([1.0, 0.3, -0.2, 0.5, 0.11, -0.07, 0.19, 0.23, -0.13]) {
            assert!((*c - expected * DVec3::new(1.0, 2.0, -1.0)).length() < 1e-13);
        }
    }

    #[test]
    fn texels_cover_the_sphere() {
        for size in [1, 2, 7, 64] {
            let sum: f64 = (0..size * size).map(|i| texel_solid_angle(size, i % size, i / size)).sum();
            assert!((6.0 * sum - 4.0 * PI).abs() < 1e-12);
        }
    }

    #[test]
    fn cube_projection_converges_to_the_function() {
        let exact = project_function(4, radiance);
        let mut errors = Vec::new();
        for size in [16, 32, 64] {
            let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
            let c = project_cube(size, |face, x, y| {
                radiance(cube_direction(face, centre(x), centre(y)).normalize()).to_array()
            });
            errors.push(c.iter().zip(exact).map(|(a, b)| (*a - b).length()).fold(0.0, f64::max));
        }
        assert!(errors[2] < 1e-3 && errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1], "{errors:?}");
    }

    #[test]
    fn cube_faces_follow_vulkan() {
        // The directions of the texel in the upper left corner of each face, from the table of the Vulkan specification.
        let corners = [(1, 1, 1), (-1, 1, -1), (-1, 1, -1), (-1, -1, 1), (-1, 1, 1), (1, 1, -1)];
        for (face, (x, y, z)) in corners.into_iter().enumerate() {
            assert_eq!(cube_direction(face, -1.0, -1.0), DVec3::new(f64::from(x), f64::from(y), f64::from(z)));
        }
    }
}
