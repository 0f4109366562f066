//! A glTF model on open ground: it stands on the soil, is seen from a little above, and plays its animation over and over.

mod dress;
mod parts;
mod remarks;

use glam::{Affine3A, Vec3};

use super::error::SceneError;
use super::ground::ground;
use super::stage::{Stage, Views};
use crate::models::Model;
use crate::render::camera::Camera;
use crate::render::scene::{Object, Pose};
use crate::render::surfaces::object::MAX_OBJECTS;
use parts::{Parts, Placement};

/// A model and the animation that it plays.
#[derive(Clone, Debug)]
pub struct ModelChoice {
    /// The model.
    pub model: Model,
    /// Number of the animation; `None` at rest.
    pub animation: Option<usize>,
}

impl ModelChoice {
    /// A model that plays the animation of this name, or without a name its first.
    ///
    /// # Errors
    /// If it has no animation of this name; those that it has are listed.
    pub fn new(model: Model, animation: Option<&str>) -> Result<Self, SceneError> {
        let animation = match animation {
            None => (!model.animations.is_empty()).then_some(0),
            Some(name) => match model.animation_named(name) {
                Some(number) => Some(number),
                None => {
                    let names: Vec<&str> = model.animations.iter().map(|a| a.name.as_str()).collect();
                    let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                    return Err(SceneError::Model(format!("no animation is called {name}; there are: {there}")));
                }
            },
        };
        Ok(Self { model, animation })
    }
}

/// Times at which an animated model is measured.
const MEASURED: u32 = 24;

/// The model as a stage. Coordinates become ours, z up and its front along -y; a model that is not between a foot and a hundred feet
/// long is scaled to three metres.
///
/// # Errors
/// If it shows nothing, or has more materials than the renderer has objects.
pub fn stage(choice: ModelChoice) -> Result<Stage, SceneError> {
    let ModelChoice { model, animation } = choice;
    let parts = Parts::of(&model);
    if parts.objects.is_empty() {
        return Err(SceneError::Model(format!("{} shows no triangles; export meshes with it", model.name)));
    }
    if parts.objects.len() >= MAX_OBJECTS {
        let fault =
            format!("its {} materials are more than the {} that a scene has", parts.objects.len(), MAX_OBJECTS - 1);
        return Err(SceneError::Model(format!("{}: {fault}; join some of them", model.name)));
    }
    remarks::of(&model, &parts).iter().for_each(|remark| tracing::warn!("{}: {remark}", model.name));
    let duration = animation.map_or(0.0, |number| model.animations[number].duration);
    let times = if duration > 0.0 { MEASURED } else { 1 };
    let time = |i: u32| duration * i as f32 / times as f32;
    let (low, high) = (0..times)
        .map(|i| parts.bounds(&model, &model.pose(animation, time(i))))
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)));
    let placement = Placement::on_ground(low, high);
    let rest = model.pose(animation, 0.0);
    let mut objects: Vec<Object> = (0..parts.objects.len())
        .map(|i| dress::object(&model, &parts, i, parts.posed(&model, &rest, i, &placement)))
        .collect();
    objects.push(ground());
    let views = views(placement.place(low), placement.place(high));
    let motion = move |seconds: f64| {
        let at = if duration > 0.0 { seconds.rem_euclid(f64::from(duration)) as f32 } else { 0.0 };
        let pose = model.pose(animation, at);
        let posed = |i| Pose::Vertices(parts.posed(&model, &pose, i, &placement));
        (0..parts.objects.len()).map(posed).chain([Pose::Rigid(Affine3A::IDENTITY)]).collect()
    };
    Ok(Stage::moving(objects, views, motion, |_| Vec3::ZERO))
}

/// Views of what lies between two corners.
fn views(a: Vec3, b: Vec3) -> Views {
    let (low, high) = (a.min(b), a.max(b));
    let (centre, radius) = (0.5 * (low + high), 0.5 * low.distance(high));
    let degrees: f32 = 35.0;
    let fits = radius / (0.5 * degrees.to_radians()).sin();
    let from = |distance: f32| {
        let direction = Vec3::new(0.55, -0.8, 0.25).normalize();
        let position = centre + direction * (fits * distance);
        // Never below the ground.
        Camera::looking_at(position.max(Vec3::new(f32::MIN, f32::MIN, 0.1)), centre, degrees)
    };
    Views { near: from(0.45), mid: from(1.0), far: from(7.0) }
}
