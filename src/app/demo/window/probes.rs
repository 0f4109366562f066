//! Draws the probes of the volume of sky occlusion as shaded balls over the picture.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::over::LayerPicture;
use leadr_maps::srgb::srgb8_from_linear;
use leadr_render::camera::Camera;
use leadr_render::light::sky_visibility::SkyProbe;

/// The number of vertices on the rim of a ball.
pub const SIDES: usize = 10;
/// The radius of a ball as a fraction of the distance between neighbouring probes.
const RADIUS: f32 = 0.12;
/// The largest radius of a ball, as a fraction of the picture height.
const LARGEST: f32 = 0.03;
/// A probe whose occlusion is below this value in every direction is drawn as a dot. `DOT` is the size of a dot relative to a ball.
const HIDDEN: f32 = 0.1;
const DOT: f32 = 0.2;
/// The legend if probes are visible.
pub const SAYS: &str =
    "sky probes: visible surroundings by direction; black is occluded by large shapes, white is open";
/// The legend if no probes are visible.
pub const NONE: &str = "no sky probes: nothing casts shadows here, or sky occlusion is off (Technique)";

/// A shaded ball on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Ball {
    /// The centre of the ball, as fractions of the width and the height.
    pub middle: [f32; 2],
    /// The radius of the ball, as a fraction of the height.
    pub radius: f32,
    /// The sRGB greys of the centre, which faces the viewer, and then of the rim, counter-clockwise from the right.
    pub greys: [u8; SIDES + 1],
}

/// Returns the visible probes. The farthest probe is first. `depth` is [`Layer::Depth`] of the picture of `camera`. Surfaces in the picture
/// hide the probes behind them.
///
/// [`Layer::Depth`]: leadr_render::frame::Layer::Depth
pub fn balls(probes: &[SkyProbe], camera: &Camera, depth: &LayerPicture) -> Vec<Ball> {
    let (width, height) = depth.size;
    let clip_from_world = camera.clip_from_world(depth.size, Vec2::ZERO);
    let focal = camera.lens(height).focal_pixels / height as f32;
    let radius = RADIUS * spacing(probes);
    let ahead = (camera.target - camera.position).normalize_or(Vec3::X);
    let seen = |probe: &SkyProbe| {
        let clip = clip_from_world * probe.position.extend(1.0);
        let distance = (probe.position - camera.position).dot(ahead);
        let middle = [0.5 + 0.5 * clip.x / clip.w, 0.5 + 0.5 * clip.y / clip.w];
        if distance <= camera.near || !middle.iter().all(|share| (0.0..1.0).contains(share)) {
            return None;
        }
        let pixel = (middle[1] * height as f32) as u32 * width + (middle[0] * width as f32) as u32;
        let hidden = depth.values.get(pixel as usize).is_some_and(|behind| behind[0] < distance - radius);
        (!hidden).then(|| {
            // Probes without occlusion are drawn small, because they carry little information.
            let open = probe.mean - probe.lean.length() > 1.0 - HIDDEN;
            let radius = (radius * focal / distance).min(LARGEST) * if open { DOT } else { 1.0 };
            (distance, Ball { middle, radius, greys: greys(probe, camera.position) })
        })
    };
    let mut balls: Vec<(f32, Ball)> = probes.iter().filter_map(seen).collect();
    balls.sort_by(|a, b| b.0.total_cmp(&a.0));
    balls.into_iter().map(|(_, ball)| ball).collect()
}

/// Returns the smallest distance between consecutive probes in metres.
fn spacing(probes: &[SkyProbe]) -> f32 {
    let pairs = probes.windows(2).map(|pair| pair[0].position.distance(pair[1].position));
    let nearest = pairs.filter(|distance| *distance > 0.0).fold(f32::INFINITY, f32::min);
    if nearest.is_finite() { nearest } else { 1.0 }
}

/// Returns the greys of a ball. A grey is the visible fraction of the environment along one normal.
fn greys(probe: &SkyProbe, eye: Vec3) -> [u8; SIDES + 1] {
    let towards = (eye - probe.position).normalize_or(Vec3::Z);
    let right = Vec3::Z.cross(towards).try_normalize().unwrap_or(Vec3::X);
    let up = towards.cross(right);
    std::array::from_fn(|i| {
        let normal = match i.checked_sub(1) {
            None => towards,
            Some(corner) => {
                let (sine, cosine) = (corner as f32 / SIDES as f32 * TAU).sin_cos();
                right * cosine + up * sine
            }
        };
        srgb8_from_linear((probe.mean + probe.lean.dot(normal)).clamp(0.0, 1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_are_positioned_and_depth_tested() {
        let camera = Camera::looking_at(Vec3::new(0.0, -10.0, 0.0), Vec3::ZERO, 40.0);
        let probe = |x: f32, y: f32| SkyProbe { position: Vec3::new(x, y, 0.0), mean: 0.5, lean: Vec3::Z * 0.5 };
        let depth = LayerPicture { size: (64, 32), values: vec![[12.0, 0.0, 0.0, 0.0]; 64 * 32] };
        // The probes are in the centre, to the right, hidden, and behind the eye. Two probes outside the picture are close together, which
        // makes balls small.
        let positions = [(0.0, 0.0), (2.0, 1.0), (0.0, 20.0), (0.0, -11.0), (50.0, 0.0), (50.2, 0.0)];
        let probes = positions.map(|(x, y)| probe(x, y));
        let [far, near] = balls(&probes, &camera, &depth).try_into().expect("two balls");
        assert!((near.middle[0] - 0.5).abs() < 1e-5 && (near.middle[1] - 0.5).abs() < 1e-5, "{near:?}");
        assert!(far.middle[0] > 0.55 && far.radius < near.radius, "{far:?} {near:?}");
        // The visibility is one half towards the viewer, one upwards, and zero downwards.
        let [middle, right, ..] = near.greys;
        assert_eq!((middle, right), (188, 188));
        assert!(near.greys[1 + SIDES / 4] > 240 && near.greys[1 + 3 * SIDES / 4] < 90, "{:?}", near.greys);
    }
}
