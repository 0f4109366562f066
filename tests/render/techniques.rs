//! Slopes under a pixel by technique, on every kind of surface.

use glam::Vec3;
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::{RenderSettings, Technique};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::ocean::sea::ocean;
use leadr::scenes::ocean::spectrum::Sea;
use leadr::scenes::plane::{even, plane};

use crate::edges::{rock, settings_of};
use leadr_testing::render::{bumps, seascape, under_sky};

/// A windy sea seen from above.
fn sea(gpu: &leadr_testing::gpu::TestGpu) -> (Renderer, FrameState) {
    let sea = Sea { wind_speed: 9.0, wind_direction: 0.4, ..Sea::default() };
    let renderer = seascape(gpu, ocean(&sea, 64, 2));
    let camera = Camera::looking_at(Vec3::Z * 300.0, Vec3::new(230.0, 0.0, 107.0), 40.0);
    (renderer, FrameState::new(camera, Vec::new()).under(&Sky::default()))
}

/// CLEAN's covariance is LEAN's reduced to one variance for all directions, the mean or the largest: in filtered pixels, in resolved edge
/// samples, and on the sea.
#[test]
fn clean_has_one_variance_on_every_surface() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    for (name, (mut renderer, state), edge_samples) in
        [("skin", rock(&gpu, 6.0), 1), ("joined edges", rock(&gpu, 20.0), 16), ("sea", sea(&gpu), 1)]
    {
        let mut covariance = |technique| {
            renderer.render(&state, &settings_of(technique, 1, edge_samples)).unwrap();
            renderer.layer(Layer::Covariance).unwrap()
        };
        let lean = covariance(Technique::Lean);
        let forms = [covariance(Technique::Clean), covariance(Technique::CleanConservative)];
        let (mut pixels, mut stretched) = (0, 0);
        for (i, [xx, yy, xy, _]) in lean.into_iter().enumerate().filter(|(_, lean)| lean[0] + lean[1] > 1e-5) {
            pixels += 1;
            stretched += u32::from((xx - yy).abs().max(xy.abs()) > 0.1 * (xx + yy));
            let mean = 0.5 * (xx + yy);
            let largest = mean + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
            for (form, variance) in forms.iter().zip([mean, largest]) {
                let [x, y, mixed, _] = form[i];
                assert!((x, mixed) == (y, 0.0), "{name}: {:?} is not isotropic", form[i]);
                // Resolved samples are isotropic before they are rotated and joined.
                let bound = if edge_samples > 1 { 0.1 } else { 1e-5 } * variance;
                assert!(
                    edge_samples > 1 && variance == largest || (x - variance).abs() < bound,
                    "{name}: {x}, not {variance}"
                );
            }
        }
        println!("{name}: {pixels} pixels, {stretched} of them stretched");
        assert!(pixels > 100 && 4 * stretched > pixels, "{name}: {stretched} of {pixels}");
    }
}

/// Layers of a pixel: nothing, or a point on a patch of an object, and the visible area of its bumps.
#[test]
fn layers_report_patches_and_visible_areas() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (mut renderer, state) = rock(&gpu, 20.0);
    renderer.render(&state, &settings_of(Technique::Leadr, 1, 1)).unwrap();
    let mut layer = |layer| renderer.layer(layer).unwrap();
    let (depth, patches, areas) = (layer(Layer::Depth), layer(Layer::Patch), layer(Layer::VisibleArea));
    let (normals, covariances) = (layer(Layer::Normal), layer(Layer::Covariance));
    let (mut seen, mut different) = (0, std::collections::BTreeSet::new());
    let mut steepest = [(1.0f32, 0.0f32), (0.0, 0.0)];
    for (i, [object, patch, u, v]) in patches.iter().enumerate() {
        assert_eq!(depth[i][0].is_finite(), *object > 0.0, "pixel {i}");
        if *object == 0.0 {
            assert_eq!(areas[i][0], 0.0);
            continue;
        }
        seen += 1;
        different.insert(*patch as u32);
        // Pixels at an edge lie beyond it by the rasteriser's interpolation.
        assert!([u, v].iter().all(|coordinate| (-0.01..=1.01).contains(*coordinate)), "{u} {v}");
        assert!(areas[i][0].is_finite() && areas[i][0] > 0.0, "{:?}", areas[i]);
        let normal = Vec3::new(normals[i][0], normals[i][1], normals[i][2]);
        let cosine = normal.dot((state.camera.position - state.camera.target).normalize());
        assert!(covariances[i][0] > 0.0);
        // The pixels seen at the most and the least grazing angle.
        if cosine < steepest[0].0 {
            steepest[0] = (cosine, areas[i][0]);
        }
        if cosine > steepest[1].0 {
            steepest[1] = (cosine, areas[i][0]);
        }
    }
    println!("{seen} pixels of {} patches; areas {steepest:?}", different.len());
    assert!(seen > 50 && different.len() > 10, "{seen} {different:?}");
    // From the front all bumps are visible, with the area of their base; from the side they stand out of it.
    assert!((steepest[1].1 - 1.0).abs() < 0.1 && steepest[0].1 > 1.1, "{steepest:?}");
}

/// Number of lines crossed by a row of pixels.
fn crossings(row: &[[f32; 4]]) -> usize {
    let mut edges: Vec<bool> = row.iter().map(|edge| edge[0] == 1.0).collect();
    edges.dedup();
    edges.into_iter().filter(|edge| *edge).count()
}

/// The segment layer shows the settings' values, and the tessellator makes as many triangles: between two rows of vertices each cell has a
/// side and a diagonal. Nothing else is an edge, and the other layers are unchanged.
#[test]
fn triangle_count_follows_the_segments() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (size, patches) = (240u32, 2u32);
    let mesh = plane(1.0, patches, 1.0, [0.4, 0.4, 0.4, 0.3], even);
    let object = Object::new("plane", mesh).with_heights(bumps(64, 8.0, 3), 0.003);
    let mut renderer = under_sky(&gpu, vec![object], 16);
    // The whole plane and a rim of sky.
    let camera = Camera { up: Vec3::Y, ..Camera::looking_at(Vec3::Z * 10.0, Vec3::ZERO, 12.0) };
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    for (technique, msaa, segments) in [
        (Technique::Leadr, 1, 5u32),
        (Technique::Leadr, 4, 9),
        (Technique::Reference, 1, 9),
        (Technique::Constant, 1, 1),
    ] {
        let tessellation = TessellationSettings { to_texels: true, max_factor: segments as f32, ..Default::default() };
        let settings =
            RenderSettings { size: (size, size), msaa, shading: technique.into(), tessellation, ..Default::default() };
        renderer.render(&state, &settings).unwrap();
        let mut layer = |layer| renderer.layer(layer).unwrap();
        let before = layer(Layer::Patch);
        let (wires, divided) = (layer(Layer::Triangles), layer(Layer::Tessellation));
        assert_eq!(layer(Layer::Patch), before);
        for (i, [object, ..]) in before.iter().enumerate() {
            let expected = if *object > 0.0 { segments as f32 } else { 0.0 };
            assert_eq!((divided[i][0], divided[i][1]), (expected, expected), "{technique:?}, pixel {i}");
        }
        let mut counts: Vec<usize> = wires.chunks(size as usize).map(crossings).filter(|count| *count > 0).collect();
        counts.sort_unstable();
        let (median, cells) = (counts[counts.len() / 2], (patches * segments) as usize);
        let edges = wires.iter().filter(|edge| edge[0] == 1.0).count();
        println!("{technique:?}: {median} lines across {cells} cells, {edges} pixels");
        // Both ends of a row are sides, and steps of a line near a vertex may join it to the next.
        assert!(median.abs_diff(2 * cells + 1) <= 1 + cells / 8, "{technique:?}: {median} lines across {cells} cells");
        assert!(wires.iter().all(|edge| edge[0] == 0.0 || edge[0] == 1.0));
    }
}

/// Hidden edges are not drawn: a ball shows only the edges of its front.
#[test]
fn edges_of_triangles_hide_behind_surfaces() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (mut renderer, state) = rock(&gpu, 6.0);
    renderer.render(&state, &settings_of(Technique::Leadr, 1, 1)).unwrap();
    let (wires, patches) = (renderer.layer(Layer::Triangles).unwrap(), renderer.layer(Layer::Patch).unwrap());
    assert!(wires.iter().any(|edge| edge[0] == 1.0));
    let size = (wires.len() as f32).sqrt() as usize;
    for (i, edge) in wires.iter().enumerate().filter(|(_, edge)| edge[0] == 1.0) {
        let near = |j: usize| (i % size).abs_diff(j % size) <= 1 && (i / size).abs_diff(j / size) <= 1;
        assert!((0..wires.len()).any(|j| near(j) && patches[j][0] > 0.0), "pixel {i} {edge:?} is beside the rock");
    }
}

/// A sea also has triangles, except in the reference, which marches rays.
#[test]
fn a_sea_has_triangles_and_segments() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (mut renderer, state) = sea(&gpu);
    for (technique, least) in [(Technique::Leadr, 1.0), (Technique::Reference, 0.0)] {
        renderer.render(&state, &settings_of(technique, 1, 1)).unwrap();
        let segments = renderer.layer(Layer::Tessellation).unwrap();
        let right = if least == 0.0 { 0.0..=0.0 } else { 1.0..=63.0 };
        assert!(segments.iter().all(|s| right.contains(&s[0]) && right.contains(&s[1])), "{technique:?}");
        let edges = renderer.layer(Layer::Triangles).unwrap().iter().filter(|edge| edge[0] == 1.0).count();
        assert!(technique != Technique::Leadr || edges > 0);
    }
}
