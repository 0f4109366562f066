//! The lights and cameras of a model file, in world space.

use std::f32::consts::PI;

use glam::{Mat4, Vec2, Vec3};

use super::parts::{Placement, to_z_up};
use crate::stage::OwnLights;
use leadr_models::{Light, LightKind, Model, Pose, Projection};
use leadr_render::camera::Camera;
use leadr_render::scene::{Cone, MAX_LAMPS, PointLight, Sun};

/// The largest irradiance at the model. This irradiance makes a white surface as bright as the picture's white. Stronger lights are dimmed.
const BRIGHTEST: f32 = PI;
/// The vertical field of view, in radians, that approximates an orthographic camera.
const NEARLY_PARALLEL: f32 = 0.02;

/// The lights of a model, dimmed to the range of the picture.
#[derive(Clone, Debug)]
pub struct Lamps {
    /// The node of the brightest directional light.
    sun: Option<usize>,
    /// The nodes of the other lights, at most [`MAX_LAMPS`].
    nodes: Vec<usize>,
    /// The factor that dims all intensities.
    dimmed: f32,
    /// The irradiance of all lights at the centre of the model, at most π.
    pub irradiance: f32,
    /// The number of lights that are not lit.
    pub unlit: usize,
}

impl Lamps {
    /// Collects the lights of visible nodes. `corners` has the bounds of the model in the world.
    pub fn of(model: &Model, pose: &Pose, placement: &Placement, corners: (Vec3, Vec3)) -> Self {
        let light = |node: usize| model.nodes[node].light.map(|number| &model.lights[number]);
        let brightness =
            |node: usize| light(node).map_or(0.0, |light| light.intensity * Vec3::from(light.color).max_element());
        let mut nodes: Vec<usize> = model.shown_nodes();
        nodes.retain(|&node| brightness(node) > 0.0);
        let suns = nodes.iter().copied().filter(|&n| light(n).is_some_and(|l| l.kind == LightKind::Directional));
        let sun = suns.reduce(|a, b| if brightness(b) > brightness(a) { b } else { a });
        nodes.retain(|&node| Some(node) != sun);
        let unlit = nodes.len().saturating_sub(MAX_LAMPS);
        nodes.truncate(MAX_LAMPS);
        let (size, middle) = (corners.0.distance(corners.1).max(1e-3), 0.5 * (corners.0 + corners.1));
        let mut lamps = Self { sun, nodes, dimmed: 1.0, irradiance: 0.0, unlit };
        let reaching = |lamp: &PointLight| {
            let distance = lamp.position.distance(middle).max(0.25 * size);
            lamp.intensity.max_element() / (distance * distance)
        };
        let own = lamps.at(model, pose, placement);
        let of_suns = own.sun.iter().chain(&own.more_suns).map(|sun| sun.irradiance.max_element()).sum::<f32>();
        let sum = own.points.iter().map(reaching).sum::<f32>() + of_suns;
        lamps.dimmed = (BRIGHTEST / sum.max(1e-20)).min(1.0);
        lamps.irradiance = sum * lamps.dimmed;
        lamps
    }

    /// Returns the lights in a pose. Under an illuminance of π, a white surface facing the light is as bright as an emission of 1.
    pub fn at(&self, model: &Model, pose: &Pose, placement: &Placement) -> OwnLights {
        let power = |light: &Light| Vec3::from(light.color) * (light.intensity * self.dimmed);
        let forward = |node: usize| along(&pose.world_from_node[node], Vec3::NEG_Z);
        let light = |&node: &usize| model.nodes[node].light.map(|number| (node, &model.lights[number]));
        let lamp = |(node, light): (usize, &Light)| {
            let position = placement.to_world(pose.world_from_node[node].w_axis.truncate());
            // Intensities scale with the model, so that the illuminance on the model does not change.
            let square = placement.scale() * placement.scale();
            let lamp = PointLight {
                range: light.range.map(|range| range * placement.scale()),
                ..PointLight::new(position, power(light) * square)
            };
            match light.kind {
                LightKind::Spot { inner_angle, outer_angle } => {
                    PointLight { cone: Some(Cone { axis: forward(node), inner_angle, outer_angle }), ..lamp }
                }
                LightKind::Point | LightKind::Directional => lamp,
            }
        };
        let sun = |(node, light): (usize, &Light)| Sun { direction: -forward(node), irradiance: power(light) };
        let (suns, lamps): (Vec<_>, Vec<_>) =
            self.nodes.iter().filter_map(light).partition(|(_, light)| light.kind == LightKind::Directional);
        OwnLights {
            sun: self.sun.as_ref().and_then(light).map(sun),
            more_suns: suns.into_iter().map(sun).collect(),
            // A node far outside the model can overflow.
            points: lamps.into_iter().map(lamp).filter(|l| l.position.is_finite() && l.intensity.is_finite()).collect(),
        }
    }
}

/// Returns the view of a node's camera in a pose. Orthographic cameras are moved far away. `corners` has the bounds of the model in the
/// world.
pub fn camera(model: &Model, node: usize, pose: &Pose, placement: &Placement, corners: (Vec3, Vec3)) -> Camera {
    let matrix = pose.world_from_node[node];
    let (position, forward, up) =
        (placement.to_world(matrix.w_axis.truncate()), along(&matrix, Vec3::NEG_Z), along(&matrix, Vec3::Y));
    let middle = 0.5 * (corners.0 + corners.1);
    let ahead = (middle - position).dot(forward).max(0.1 * corners.0.distance(corners.1)).max(1e-3);
    let seen = model.nodes[node].camera.map(|number| &model.cameras[number]);
    let near = seen.map_or(0.0, |camera| camera.near * placement.scale());
    let of = |position: Vec3, target: Vec3, fov_y: f32, near: f32| {
        let shift = Vec2::ZERO;
        Camera { position, target, up, fov_y, near, shift }
    };
    match seen.map(|camera| camera.projection) {
        Some(Projection::Orthographic { half_height, .. }) => {
            let distance = (half_height.abs() * placement.scale()).max(1e-4) / (0.5 * NEARLY_PARALLEL).tan();
            let target = position + forward * ahead;
            let eye = target - forward * distance;
            of(eye, target, NEARLY_PARALLEL, ((position - eye).dot(forward) + near).max(1e-3 * distance))
        }
        Some(Projection::Perspective { vertical_angle, .. }) => of(
            position,
            position + forward * ahead,
            vertical_angle.clamp(0.01, 2.9),
            near.clamp(1e-4 * ahead, 0.5 * ahead),
        ),
        None => Camera::looking_at(position, position + forward * ahead, 35.0),
    }
}

/// Transforms the direction of a node to world space.
fn along(matrix: &Mat4, direction: Vec3) -> Vec3 {
    to_z_up(matrix.transform_vector3(direction)).normalize_or(Vec3::NEG_Y)
}
