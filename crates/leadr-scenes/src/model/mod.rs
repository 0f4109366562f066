//! A glTF model that stands on open ground and is seen from slightly above, with a looping animation.

mod budget;
mod charts;
pub mod cones;
pub mod displacement;
mod dress;
mod floor;
mod instances;
mod join;
mod lights;
pub mod measured;
pub mod named;
mod parts;
mod relief;
mod remarks;
mod welds;

use std::str::FromStr;
use std::sync::Arc;

use glam::Vec3;
use serde::Serialize;

use super::error::SceneError;
use super::ground::{RELIEF, ground};
use super::stage::{Stage, Views};
use super::text::similar;
use charts::Charts;
use leadr_maps::material::Material;
use leadr_models::Model;
use leadr_render::camera::Camera;
use leadr_render::scene::{MAX_LAMPS, Object, Pose};
use leadr_render::surfaces::numbering::MAX_OBJECTS;
use lights::Lamps;
use parts::{Parts, Placement};
use welds::{Surface, Welds};

/// A model with a selected animation and camera.
#[derive(Clone, Debug)]
pub struct ModelChoice {
    /// The model.
    pub model: Model,
    /// The index of the animation; `None` shows the rest pose.
    pub animation: Option<usize>,
    /// The node of the selected camera; `None` uses the standard views.
    pub camera: Option<usize>,
    /// Whether ground is drawn below the model.
    pub ground: Ground,
}

/// Whether ground is drawn below a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// Ground is drawn unless the model has a floor of its own.
    #[default]
    Auto,
    /// Ground is drawn.
    On,
    /// No ground is drawn.
    Off,
}

impl FromStr for Ground {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "on" => Ok(Self::On),
            "off" => Ok(Self::Off),
            _ => Err("use 'on', 'off' or 'auto'".to_owned()),
        }
    }
}

impl ModelChoice {
    /// Selects the animation of this name or number (from 1), or the first for `None`.
    ///
    /// # Errors
    /// If the model has no such animation; the message lists the existing names.
    pub fn new(model: Model, animation: Option<&str>) -> Result<Self, SceneError> {
        let numbered =
            |wanted: &str| wanted.parse::<usize>().ok()?.checked_sub(1).filter(|&n| n < model.animations.len());
        let animation = match animation {
            None => (!model.animations.is_empty()).then_some(0),
            Some(name) => match model.animation_named(name).or_else(|| numbered(name)) {
                Some(number) => Some(number),
                None => {
                    let names: Vec<&str> = model.animations.iter().map(|a| a.name.as_str()).collect();
                    let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                    let similar = similar(name, names);
                    return Err(SceneError::Model(format!(
                        "no animation is named {name}{similar}; available: {there}"
                    )));
                }
            },
        };
        Ok(Self { model, animation, camera: None, ground: Ground::Auto })
    }

    /// Sets whether ground is drawn below the model.
    #[must_use]
    pub fn on(self, ground: Ground) -> Self {
        Self { ground, ..self }
    }

    /// Selects a camera of the file by its name or its number (from 1). `None` selects the first camera.
    ///
    /// # Errors
    /// If there is no such camera; the message lists the existing cameras.
    pub fn seen_by(self, camera: Option<&str>) -> Result<Self, SceneError> {
        let model = &self.model;
        let nodes: Vec<usize> = model.shown_nodes().into_iter().filter(|&n| model.nodes[n].camera.is_some()).collect();
        let name = |node: usize| {
            let camera = model.nodes[node].camera.map_or("", |number| model.cameras[number].name.as_str());
            if camera.is_empty() { model.nodes[node].name.as_str() } else { camera }
        };
        let numbered = |wanted: &str| wanted.parse::<usize>().ok().and_then(|n| nodes.get(n.checked_sub(1)?).copied());
        let found = match camera {
            None => nodes.first().copied(),
            Some(wanted) => nodes.iter().copied().find(|&n| name(n) == wanted).or_else(|| numbered(wanted)),
        };
        let Some(node) = found else {
            let names: Vec<String> = nodes
                .iter()
                .enumerate()
                .map(|(i, &n)| format!("{} {}", i + 1, name(n)).trim_end().to_owned())
                .collect();
            let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            let similar = |wanted| similar(wanted, nodes.iter().map(|&n| name(n)));
            let wanted = camera.map_or("it has no camera".to_owned(), |wanted| {
                format!("no camera is named {wanted}{}", similar(wanted))
            });
            return Err(SceneError::Model(format!("{wanted}; available: {there}")));
        };
        Ok(Self { camera: Some(node), ..self })
    }
}

/// The number of animation times at which the bounds of a model are sampled.
const MEASURED: u32 = 24;

/// Builds a stage from the model, with z up and the front along -y. A model smaller than 0.3 m or larger than 30 m is scaled to three
/// metres.
///
/// # Errors
/// If nothing of the model is visible, its nodes need too much memory, or it has more materials than the renderer allows objects.
pub fn stage(choice: ModelChoice) -> Result<Stage, SceneError> {
    let ModelChoice { mut model, animation, camera, ground: wanted } = choice;
    join::join_plain(&mut model);
    let mut parts = Parts::of(&model);
    if parts.objects.is_empty() {
        let fault = "it has no triangles, and points and lines are not drawn; export it with meshes";
        return Err(SceneError::Model(fault.into()));
    }
    if parts.objects.len() >= MAX_OBJECTS {
        let fault = format!("it has {} materials, and a scene has at most {}", parts.objects.len(), MAX_OBJECTS - 1);
        return Err(SceneError::Model(format!("{fault}; join some of them")));
    }
    instances::share_meshes(&model, &mut parts, 1);
    let duration = animation.map_or(0.0, |number| model.animations[number].duration);
    let times = if duration > 0.0 { MEASURED } else { 1 };
    budget::check(&model, &parts, times)?;
    let charts: Vec<(Charts, Material)> = (0..parts.objects.len())
        .map(|i| Charts::of(&model.materials[parts.objects[i].material], &|set| parts.reached(&model, i, set)))
        .collect();
    remarks::of(&model, &parts, &charts, camera).iter().for_each(|remark| tracing::warn!("{}: {remark}", model.name));
    let time = |i: u32| duration * i as f32 / times as f32;
    let (low, high) = (0..times)
        .map(|i| parts.bounds(&model, &model.pose(animation, time(i))))
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)));
    if !low.is_finite() || !high.is_finite() || !low.distance(high).is_finite() {
        let fault = "its node transforms overflow the vertex positions; use sizes in metres";
        return Err(SceneError::Model(fault.into()));
    }
    let placement = Placement::on_ground(low, high);
    let rest = model.pose(animation, 0.0);
    // Flat models and floors lie on top of the soil's bumps. Other models may sink slightly into the soil.
    let lies = high.y - low.y < 0.1 * (high.x - low.x).max(high.z - low.z);
    let has_floor = lies || floor::has_floor(&model, &parts, &rest);
    let has_ground = match wanted {
        Ground::Auto => lies || !has_floor,
        Ground::On => true,
        Ground::Off => false,
    };
    let placement = if has_floor {
        placement.lifted(0.5 * RELIEF + 0.005 * low.distance(high) * placement.scale())
    } else {
        placement
    };
    let poses = || (0..times).map(|i| parts.all_posed(&model, &model.pose(animation, time(i)), &placement));
    let displaced = parts.are_displaced(&model);
    let corners = |(i, (charts, _)): (usize, &(Charts, Material))| parts.triangles(&model, i, charts).0;
    let triangles: Vec<Vec<[u32; 3]>> =
        if displaced { charts.iter().enumerate().map(corners).collect() } else { Vec::new() };
    let welds = displaced.then(|| Welds::of(&poses().collect::<Vec<_>>(), &triangles));
    let surface = Surface {
        rims: welds.as_ref().map_or(Vec::new(), |welds| welds.rims(&triangles)),
        welds,
        placement,
        size: low.distance(high) * placement.scale(),
    };
    let mut at_rest = surface.posed(&model, &parts, &rest).into_iter();
    let mut object = |(i, charts): (usize, &(Charts, Material))| {
        let count = parts.objects[i].instances().len();
        let rest = at_rest.by_ref().take(count).reduce(|first, _| first).unwrap_or_default();
        dress::object(&model, &parts, &surface, charts, i, rest).with_instances(count as u32)
    };
    let mut objects: Vec<Object> = charts.iter().enumerate().map(&mut object).collect();
    if has_ground {
        objects.push(ground());
    }
    let (a, b) = (placement.to_world(low), placement.to_world(high));
    let corners = (a.min(b), a.max(b));
    let views = views(corners.0, corners.1);
    let lamps = Lamps::of(&model, &rest, &placement, corners);
    if lamps.unlit > 0 {
        tracing::warn!(
            "{}: {} of its lights are not lit; a scene has at most {MAX_LAMPS} lights and a sun",
            model.name,
            lamps.unlit
        );
    }
    let model = Arc::new(model);
    let pose = {
        let model = model.clone();
        move |seconds: f64| {
            let at = if duration > 0.0 { seconds.rem_euclid(f64::from(duration)) as f32 } else { 0.0 };
            model.pose(animation, at)
        }
    };
    let (lit, pose_of_lamps) = (model.clone(), pose.clone());
    let (seen, pose_of_camera) = (model.clone(), pose.clone());
    let motion = move |seconds: f64| {
        let posed = surface.posed(&model, &parts, &pose(seconds)).into_iter().map(Pose::Vertices);
        posed.chain(has_ground.then_some(Pose::REST)).collect()
    };
    let stage = Stage::moving(objects, views, motion, |_| Vec3::ZERO)
        .with_own_lights(lamps.irradiance, move |seconds| lamps.at(&lit, &pose_of_lamps(seconds), &placement));
    Ok(match camera {
        None => stage,
        Some(node) => stage
            .with_own_camera(move |seconds| lights::camera(&seen, node, &pose_of_camera(seconds), &placement, corners)),
    })
}

/// The fraction of the middle view's height and width (at 4:3) that a model fills.
const FILLED: f32 = 0.8;

/// Returns views of a bounding box from the front, slightly from the side and from above. Flat boxes are seen from a higher position.
fn views(low: Vec3, high: Vec3) -> Views {
    let (centre, size) = (0.5 * (low + high), (high - low).max(Vec3::splat(1e-4)));
    let (wide, upright) = (size.x.max(size.y), size.z);
    let direction = if size.y < 0.2 * size.x.max(upright) {
        Vec3::new(0.25, -1.0, 0.12)
    } else if size.x < 0.2 * size.y.max(upright) {
        Vec3::new(1.0, -0.35, 0.15)
    } else if upright < 0.2 * wide {
        Vec3::new(0.5, -0.8, 0.75)
    } else {
        Vec3::new(0.65, -0.8, 0.28)
    };
    let degrees: f32 = 35.0;
    let from = |factor: f32| {
        let eye = direction.normalize();
        let right = Vec3::Z.cross(eye).normalize();
        let up = eye.cross(right);
        let tangent = FILLED * (0.5 * degrees.to_radians()).tan();
        let needed = |corner: usize| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 };
            let c = size * Vec3::new(pick(0), pick(1), pick(2));
            let across = (c.dot(right).abs() / (tangent * 4.0 / 3.0)).max(c.dot(up).abs() / tangent);
            across + c.dot(eye)
        };
        let fits = (0..8).map(needed).fold(0.0, f32::max);
        let position = centre + eye * (fits * factor);
        // The camera stays above the ground.
        Camera::looking_at(position.max(Vec3::new(f32::MIN, f32::MIN, 0.02 * fits)), centre, degrees)
    };
    Views { near: from(0.55), mid: from(1.0), far: from(4.5) }
}
