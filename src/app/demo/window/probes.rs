//! What the places of the sky's volume see of their surroundings, as balls over the picture.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::over::LayerPicture;
use leadr_maps::srgb::srgb8_from_linear;
use leadr_render::camera::Camera;
use leadr_render::light::sky_visibility::SkyProbe;

/// Corners of a ball's rim.
pub const SIDES: usize = 10;
/// Radius of a ball, as a part of the distance to the nearest other one.
const RADIUS: f32 = 0.12;
/// Largest radius, as a part of the picture's height.
const LARGEST: f32 = 0.03;
/// Part of a direction that is hidden where a ball is more than a dot, and the size of a dot as a part of a ball's.
const HIDDEN: f32 = 0.1;
const DOT: f32 = 0.2;
/// What the legend says.
pub const SAYS: &str =
    "probes: what each place sees of the surroundings past large shapes, by direction: nothing is black, all white";
/// What it says where there are none.
pub const NONE: &str = "no probes: nothing throws shadows here, or large shapes hide no sky (Technique)";

/// A ball on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Ball {
    /// Its middle, as shares of the width and the height.
    pub middle: [f32; 2],
    /// Share of the height.
    pub radius: f32,
    /// Grey in the middle, which faces the viewer, and round the rim from the right and counter-clockwise, sRGB.
    pub greys: [u8; SIDES + 1],
}

/// The probes that a camera sees in front of what its picture shows, the farthest first. `depth`: [`Layer::Depth`] of that picture.
///
/// [`Layer::Depth`]: leadr_render::frame::Layer::Depth
pub fn balls(probes: &[SkyProbe], camera: &Camera, depth: &LayerPicture) -> Vec<Ball> {
    let (width, height) = depth.size;
    let clip_from_world = camera.clip_from_world(depth.size, Vec2::ZERO);
    let focal = camera.lens(height).focal_pixels / height as f32;
    let radius = RADIUS * spacing(probes);
    let ahead = (camera.target - camera.position).normalize_or(Vec3::X);
    let seen = |probe: &SkyProbe| {
        let clip = clip_from_world * probe.place.extend(1.0);
        let distance = (probe.place - camera.position).dot(ahead);
        let middle = [0.5 + 0.5 * clip.x / clip.w, 0.5 + 0.5 * clip.y / clip.w];
        if distance <= camera.near || !middle.iter().all(|share| (0.0..1.0).contains(share)) {
            return None;
        }
        let pixel = (middle[1] * height as f32) as u32 * width + (middle[0] * width as f32) as u32;
        let hidden = depth.values.get(pixel as usize).is_some_and(|behind| behind[0] < distance - radius);
        (!hidden).then(|| {
            // Where nothing is hidden there is little to see.
            let open = probe.mean - probe.lean.length() > 1.0 - HIDDEN;
            let radius = (radius * focal / distance).min(LARGEST) * if open { DOT } else { 1.0 };
            (distance, Ball { middle, radius, greys: greys(probe, camera.position) })
        })
    };
    let mut balls: Vec<(f32, Ball)> = probes.iter().filter_map(seen).collect();
    balls.sort_by(|a, b| b.0.total_cmp(&a.0));
    balls.into_iter().map(|(_, ball)| ball).collect()
}

/// The shortest distance between a probe and the next.
fn spacing(probes: &[SkyProbe]) -> f32 {
    let pairs = probes.windows(2).map(|pair| pair[0].place.distance(pair[1].place));
    let nearest = pairs.filter(|distance| *distance > 0.0).fold(f32::INFINITY, f32::min);
    if nearest.is_finite() { nearest } else { 1.0 }
}

/// What a ball shows: the share that is seen in the direction of each of its normals.
fn greys(probe: &SkyProbe, eye: Vec3) -> [u8; SIDES + 1] {
    let towards = (eye - probe.place).normalize_or(Vec3::Z);
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
    fn probes_stand_where_they_are_and_behind_what_hides_them() {
        let camera = Camera::looking_at(Vec3::new(0.0, -10.0, 0.0), Vec3::ZERO, 40.0);
        let probe = |x: f32, y: f32| SkyProbe { place: Vec3::new(x, y, 0.0), mean: 0.5, lean: Vec3::Z * 0.5 };
        let depth = LayerPicture { size: (64, 32), values: vec![[12.0, 0.0, 0.0, 0.0]; 64 * 32] };
        // In the middle, to the right, hidden, behind the eye, twice beside the picture and close together, so that balls are small.
        let places = [(0.0, 0.0), (2.0, 1.0), (0.0, 20.0), (0.0, -11.0), (50.0, 0.0), (50.2, 0.0)];
        let probes = places.map(|(x, y)| probe(x, y));
        let [far, near] = balls(&probes, &camera, &depth).try_into().expect("two balls");
        assert!((near.middle[0] - 0.5).abs() < 1e-5 && (near.middle[1] - 0.5).abs() < 1e-5, "{near:?}");
        assert!(far.middle[0] > 0.55 && far.radius < near.radius, "{far:?} {near:?}");
        // Half of it towards the viewer, all of it above, nothing below.
        let [middle, right, ..] = near.greys;
        assert_eq!((middle, right), (188, 188));
        assert!(near.greys[1 + SIDES / 4] > 240 && near.greys[1 + 3 * SIDES / 4] < 90, "{:?}", near.greys);
    }
}
