//! The pose of a model at one time: node transforms, morph weights and joint transforms.

use glam::{Mat4, Quat, Vec3};

use super::animation::Property;
use super::model::{Model, Transform};

/// The pose of a model at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// The matrix of each node from node space to model space.
    pub world_from_node: Vec<Mat4>,
    /// The weights of the morph targets of each node's mesh.
    pub weights: Vec<Vec<f32>>,
    /// The matrix of each joint of each skin from mesh vertex space to model space.
    pub world_from_bind: Vec<Vec<Mat4>>,
}

impl Model {
    /// Returns the pose at a time of an animation, or the rest pose without an animation. A curve is constant before its
    /// first key and after its last key. To loop, pass `seconds` modulo the duration.
    ///
    /// # Panics
    /// Panics if the animation does not exist.
    pub fn pose(&self, animation: Option<usize>, seconds: f32) -> Pose {
        let mut transforms: Vec<Transform> = self.nodes.iter().map(|node| node.transform).collect();
        let mut weights: Vec<Vec<f32>> = self.nodes.iter().map(|node| node.weights.clone()).collect();
        if let Some(animation) = animation.map(|number| &self.animations[number]) {
            for channel in &animation.channels {
                let value = animation.curves[channel.curve].sample(seconds, channel.property == Property::Rotation);
                match channel.property {
                    Property::Weights => weights[channel.node] = value,
                    _ => set(&mut transforms[channel.node], channel.property, &value),
                }
            }
        }
        let mut world_from_node = vec![Mat4::IDENTITY; self.nodes.len()];
        for &node in &self.order {
            let above = self.nodes[node].parent.map_or(Mat4::IDENTITY, |parent| world_from_node[parent]);
            world_from_node[node] = above * transforms[node].matrix();
        }
        let skins = self.skins.iter();
        let world_from_bind = skins
            .map(|skin| {
                skin.joints.iter().zip(&skin.inverse_bind).map(|(&j, bind)| world_from_node[j] * *bind).collect()
            })
            .collect();
        Pose { world_from_node, weights, world_from_bind }
    }
}

/// Sets one property of a transform. Matrices cannot be animated.
fn set(transform: &mut Transform, property: Property, value: &[f32]) {
    let Transform::Parts { translation, rotation, scale } = transform else { return };
    match property {
        Property::Translation => *translation = Vec3::from_slice(value),
        Property::Rotation => *rotation = Quat::from_slice(value),
        Property::Scale => *scale = Vec3::from_slice(value),
        Property::Weights => {}
    }
}
