//! Tests that the bench's plain forward pass draws the same pictures as the renderer, so that times are comparable.

use leadr_scenes::view::Size;
use leadr_tools::bench::{Forward, FullScreen, against_forward};

use leadr_testing::gpu::test_gpu;

const SIZE: Size = Size { width: 96, height: 64 };

/// Returns the RMS colour difference relative to the reference's RMS, and the largest difference relative to the reference's
/// mean.
fn difference(reference: &[[f32; 4]], test: &[[f32; 4]]) -> (f64, f64) {
    assert!(reference.len() == test.len() && test.iter().flatten().all(|value| value.is_finite()));
    let colors =
        |picture: &[[f32; 4]]| -> Vec<f64> { picture.iter().flat_map(|c| &c[..3]).map(|v| f64::from(*v)).collect() };
    let (reference, test) = (colors(reference), colors(test));
    let squares = |values: &dyn Fn(usize) -> f64| (0..test.len()).map(|i| values(i).powi(2)).sum::<f64>();
    let mean = reference.iter().sum::<f64>() / reference.len() as f64;
    let worst = (0..test.len()).map(|i| (test[i] - reference[i]).abs()).fold(0.0, f64::max);
    ((squares(&|i| test[i] - reference[i]) / squares(&|i| reference[i])).sqrt(), worst / mean)
}

#[test]
fn forward_pass_matches_the_renderer() {
    let Some(gpu) = test_gpu() else { return };
    let mut quad = FullScreen::new(SIZE, &gpu).unwrap();
    let rows = against_forward(&quad.state, SIZE);
    let forward = quad.forward(SIZE, &rows[0].settings).unwrap();
    let settings = |name: &str| rows.iter().find(|row| row.name == name).unwrap().settings;
    let mut drawn = |name: &str, kind: Forward, height_scale: f32| {
        let mut state = quad.state.clone();
        state.height_scale *= height_scale;
        quad.renderer.measure(&state, &settings(name), 0, 1).unwrap();
        forward.measure(kind, quad.renderer.environment().cube(), 1).unwrap();
        let picture: Vec<[f32; 4]> = quad.renderer.image().unwrap().read(0, 0).unwrap();
        let (rms, worst) = difference(&picture, &forward.picture().unwrap());
        println!("{name} and {kind}, heights times {height_scale}: rms {rms:.2e}, worst {worst:.2e}");
        rms
    };
    let same = [
        // The G-buffer stores the albedo in eight bits.
        ("constant", Forward::Constant, 5e-3),
        ("blinn-phong", Forward::BlinnPhong, 1e-3),
        ("lean", Forward::Lean, 1e-3),
        ("leadr", Forward::Leadr, 1e-3),
        ("leadr 1x1, mirrored", Forward::Environment(1), 1e-3),
        ("leadr 3x3, mirrored", Forward::Environment(3), 1e-3),
        ("leadr 5x5, mirrored", Forward::Environment(5), 1e-3),
        // The renderer subtracts the specular reflection from the diffuse light.
        ("leadr 5x5, diffuse", Forward::Irradiance(5), 6e-2),
    ];
    let mut faults = Vec::new();
    for (name, kind, tolerance) in same {
        let rms = drawn(name, kind, 1.0);
        faults.extend((rms > tolerance).then(|| format!("{name} and {kind}: {rms}")));
    }
    // The test must detect another technique, fewer samples and steeper bumps.
    let wrong = [
        ("lean", Forward::Leadr, 1.0),
        ("leadr", Forward::Lean, 1.0),
        ("leadr", Forward::Leadr, 1.1),
        ("lean", Forward::Lean, 1.1),
        ("leadr 5x5, mirrored", Forward::Environment(3), 1.0),
    ];
    for (name, kind, height_scale) in wrong {
        let rms = drawn(name, kind, height_scale);
        faults.extend((rms < 5e-3).then(|| format!("{name} and {kind} differ by only {rms}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    gpu.assert_silent();
}
