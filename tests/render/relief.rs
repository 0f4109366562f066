//! Bumps that occlude the environment: against ray casts, at every distance.

use glam::{DVec2, Vec3};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr_lab::ray_cast::{Patch, Spectrum, Tile};

use crate::reference::{VIEW, mean, plane_of, renderer, state};
use leadr_testing::gpu::test_gpu;

fn settings(technique: Technique, size: (u32, u32), samples: u32, relief_occlusion: bool) -> RenderSettings {
    RenderSettings {
        size,
        samples,
        shading: technique.with(ShadingOptions { relief_occlusion, ..Default::default() }),
        tessellation: TessellationSettings { to_texels: true, ..Default::default() },
        shadows: false,
        ..Default::default()
    }
}

/// Under a white sky: bumps of sixteen texels resolved by many pixels, half resolved, and all within a pixel, where only the slope
/// statistics act.
#[test]
fn bumps_occlude_sky_as_in_ray_casts() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 1);
    let patch = Patch::new(&tile, DVec2::ZERO, tile.covariance());
    let [_, want] = patch.diffuse_environment(VIEW.as_dvec3(), 300, 4, 1, |_| 1.0).unwrap().mean;
    let mut renderer = renderer(&gpu, plane_of(&tile, 1.0, false), 1.0);
    for (name, technique, size, samples, bounds) in [
        ("reference", Technique::Reference, (64, 32), 8, [0.13, 0.3]),
        ("LEADR, 1 pixel for 1 texel", Technique::Leadr, (64, 32), 1, [0.12, 0.3]),
        ("LEADR, 1 pixel for 8 texels", Technique::Leadr, (8, 4), 1, [0.07, 0.06]),
        ("LEADR, 1 pixel for 32 texels", Technique::Leadr, (2, 1), 1, [0.03, -0.03]),
    ] {
        let [on, off] = [true, false].map(|on| {
            let picture = renderer.render(&state(None), &settings(technique, size, samples, on)).unwrap();
            mean(&picture.color) / want - 1.0
        });
        println!("{name}: {:+.1} % with occlusion, {:+.1} % without", 100.0 * on, 100.0 * off);
        assert!(on.abs() < bounds[0] && off > bounds[1], "{name}: {on:+.3}, without {off:+.3}");
    }
}

/// Flat ground does not change with occlusion.
#[test]
fn flat_ground_hides_nothing() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 1);
    let mut renderer = renderer(&gpu, plane_of(&tile, 0.0, false), 1.0);
    let state = state(Some(Vec3::new(0.0, 0.6, 0.8)));
    let [on, off] =
        [true, false].map(|on| renderer.render(&state, &settings(Technique::Leadr, (32, 16), 1, on)).unwrap().color);
    assert_eq!(on, off);
}
