//! Small curved glossy parts do not sparkle. The sun's highlight on a sphere, a ring and a tooth of a few pixels, moved by fractions of a
//! pixel, with and without the macrosurface's curvature in the slope covariance (IGSA; LEADR 4.2).
//!
//! The 64-sample reference uses a box filter of one pixel, the kernel a Gaussian of standard deviation half a pixel. On surfaces this
//! glossy the Gaussian is wider: highlights are softer than the reference's and 9 to 19 % brighter in total. With the variance of the box,
//! 1/12, the sphere of 6 pixels is closer to the reference (4 % too dark), but its brightness varies by 55 % instead of 5 %.

use glam::{Affine3A, Vec2, Vec3};
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::scene::{FrameState, Object, PointLight, Pose, Sun};
use leadr::render::settings::{PixelKernel, RenderSettings, Shading, ShadingOptions, Technique};
use leadr::render::surfaces::patch_mesh::PatchMesh;
use leadr::scenes::sphere::cube_sphere;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::in_room;

const SIZE: u32 = 24;
/// Positions along two pixels, an eighth of a pixel apart.
const POSITIONS: u32 = 16;

/// Black except for its reflections, with Beckmann roughness `alpha`.
fn color(alpha: f32) -> [f32; 4] {
    [0.0, 0.0, 0.0, alpha]
}

/// An ellipsoid of half axes `axes`.
fn ellipsoid(axes: Vec3, alpha: f32) -> PatchMesh {
    let mut mesh = cube_sphere(8, color(alpha));
    for (p, n) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        *n = (*p / axes).normalize();
        *p *= axes;
    }
    mesh
}

/// A torus of radii 1 − `tube` and `tube`, about the z axis.
fn torus(tube: f32, alpha: f32) -> PatchMesh {
    let (around, across) = (32u32, 12u32);
    let mut mesh = PatchMesh::default();
    for i in 0..around * across {
        let u = (i / across) as f32 / around as f32 * std::f32::consts::TAU;
        let v = (i % across) as f32 / across as f32 * std::f32::consts::TAU;
        let (out, normal) = (Vec3::new(u.cos(), u.sin(), 0.0), v.cos());
        let normal = out * normal + Vec3::Z * v.sin();
        mesh.positions.push(out * (1.0 - tube) + normal * tube);
        mesh.normals.push(normal);
    }
    let at = |i: u32, j: u32| i % around * across + j % across;
    for i in 0..around {
        for j in 0..across {
            mesh.patches.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            let uv = |i: u32, j: u32| Vec2::new(i as f32 / around as f32, j as f32 / across as f32);
            mesh.texcoords.push([uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j + 1)]);
        }
    }
    mesh.colors = vec![color(alpha); mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    mesh
}

/// Changes of pictures between positions.
struct Motion {
    /// Largest change of a pixel.
    flicker: f32,
    /// Difference of the largest and the smallest total brightness, relative to its mean.
    throb: f32,
    /// Mean of all pixels and positions.
    mean: f32,
    images: Vec<Vec<f32>>,
}

fn motion(renderer: &mut Renderer, shading: Shading, samples: u32, diameter: f32) -> Motion {
    let distance = 40.0;
    let camera = Camera::looking_at(Vec3::new(0.4, -0.8, 0.45).normalize() * distance, Vec3::ZERO, {
        // The unit object is `diameter` pixels across.
        (2.0 * (SIZE as f32 / diameter / distance).atan()).to_degrees()
    });
    let pixel = 2.0 / diameter;
    let right = camera.position.cross(Vec3::Z).normalize();
    let settings = RenderSettings {
        size: (SIZE, SIZE),
        samples,
        shading: shading.adjusted(|options| ShadingOptions { shadowing: Shadowing::None, ..options }),
        shadows: false,
        ..Default::default()
    };
    let images: Vec<Vec<f32>> = (0..POSITIONS)
        .map(|i| {
            let shift = (right + 0.37 * Vec3::Z) * (pixel * i as f32 / 8.0);
            let state = FrameState {
                sun: Some(Sun { direction: Vec3::new(0.7, -0.3, 0.8).normalize(), irradiance: Vec3::ONE }),
                // As bright as the sun. With more highlights, the result does not depend on the position of a single one.
                point_lights: [(0.2, -0.9, 0.1), (-0.5, -0.6, 0.6), (0.9, -0.1, 0.2), (0.5, -0.8, -0.4)]
                    .map(|(x, y, z)| Vec3::new(x, y, z).normalize() * 1e3)
                    .map(|position| PointLight::new(position, Vec3::splat(1e6)))
                    .to_vec(),
                ..FrameState::new(camera, vec![Pose::Rigid(Affine3A::from_translation(shift))])
            };
            renderer.render(&state, &settings).unwrap().color.iter().map(|c| c[0]).collect()
        })
        .collect();
    let change = |w: &[Vec<f32>]| w[0].iter().zip(&w[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let flicker = images.windows(2).map(change).fold(0.0, f32::max);
    let sums: Vec<f32> = images.iter().map(|image| image.iter().sum()).collect();
    let (low, high) = sums.iter().fold((f32::MAX, 0.0f32), |(l, h), &v| (l.min(v), h.max(v)));
    let mean = sums.iter().sum::<f32>() / sums.len() as f32;
    Motion { flicker, throb: (high - low) / mean, mean, images }
}

/// RMS error over all pixels and positions, relative to the reference's.
fn error(motion: &Motion, reference: &Motion) -> f32 {
    let (mut sum, mut norm) = (0.0, 0.0);
    for (a, b) in motion.images.iter().flatten().zip(reference.images.iter().flatten()) {
        sum += (a - b) * (a - b);
        norm += b * b;
    }
    (sum / norm).sqrt()
}

#[test]
#[ignore = "long"]
fn small_glossy_parts_do_not_sparkle() {
    let Some(gpu) = test_gpu() else { return };
    for (name, mesh, diameter) in [
        ("sphere of 6 pixels", ellipsoid(Vec3::ONE, 0.05), 6.0),
        ("tooth of 4 by 12 pixels", ellipsoid(Vec3::new(0.33, 0.33, 1.0), 0.08), 12.0),
        ("ring of 20 pixels, 4 thick", torus(0.2, 0.08), 20.0),
    ] {
        let object = Object::new(name, mesh).with_specular_f0(1.0).without_shadow();
        let mut renderer = in_room(&gpu, vec![object], [0.0; 3]);
        // Without bumps, the techniques differ only in the treatment of the macrosurface's curvature.
        let reference = motion(&mut renderer, Technique::Reference.into(), 64, diameter);
        let kernel = |pixel_kernel| Technique::Leadr.with(ShadingOptions { pixel_kernel, ..Default::default() });
        let with = motion(&mut renderer, kernel(PixelKernel::Normal), 1, diameter);
        let per_light = motion(&mut renderer, kernel(PixelKernel::HalfVector), 1, diameter);
        let without = motion(&mut renderer, Technique::NormalMip.into(), 1, diameter);
        let (e, f) = (error(&with, &reference), error(&without, &reference));
        println!(
            "{name}: largest change of a pixel {:.3} filtered, {:.3} unfiltered, {:.3} at 64 samples; brightness swings \
             by {:.0} %, {:.0} %, {:.0} %; relative error {e:.2}, {f:.2}; mean brightness {:+.1} %, {:+.1} %",
            with.flicker,
            without.flicker,
            reference.flicker,
            100.0 * with.throb,
            100.0 * without.throb,
            100.0 * reference.throb,
            100.0 * (with.mean / reference.mean - 1.0),
            100.0 * (without.mean / reference.mean - 1.0),
        );
        println!(
            "half vectors: {:.3}, {:.0} %, {:.2}, {:+.1} %",
            per_light.flicker,
            100.0 * per_light.throb,
            error(&per_light, &reference),
            100.0 * (per_light.mean / reference.mean - 1.0)
        );
        // Measured: flicker 6.2, 2.4, 1.7 times smaller, brightness variation 19, 5, 5 times. The kernel of the half vector is linear in the
        // slope, and these pixels are so curved that they are 3.6 to 4.7 times brighter than the reference.
        assert!(per_light.flicker < 0.65 * without.flicker, "the {name} flickers with half vectors");
        assert!(per_light.throb < 0.3 * without.throb, "the brightness of the {name} varies with half vectors");
        // Measured reductions on llvmpipe: flicker 47, 13, 4.8 times; brightness variation 71, 15, 10 times; errors 6.1, 5.3, 4.7 times.
        assert!(with.flicker < without.flicker / 4.5, "the {name} flickers");
        assert!(with.throb < without.throb / 8.0 && with.throb < 0.2, "the brightness of the {name} varies");
        assert!(e < f / 3.0, "the {name} differs from the reference");
        // The picture must be steady without losing the highlight.
        assert!((with.mean / reference.mean - 1.0).abs() < 0.25, "the {name} is too dark or too bright");
        assert!(with.flicker > 0.1 * reference.flicker, "the {name} has no highlight");
    }
}
