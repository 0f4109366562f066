//! A model as plain data: a hierarchy of nodes, what hangs on them, and what moves them.

use glam::{Mat4, Quat, Vec3};

use super::animation::Animation;
use super::mesh::Mesh;
use leadr_maps::material::Material;

/// All that a model file holds, checked: every index leads somewhere, every number is finite, the nodes are a forest.
///
/// Metres and radians, right-handed, y up; the front of a model looks along +z. Triangles are counter-clockwise seen from their
/// front, except on nodes whose matrix mirrors. Texture coordinates have their origin at the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The file's name without its ending.
    pub name: String,
    /// Selections of nodes to be shown together.
    pub scenes: Vec<SceneRoots>,
    /// The scene to show first, if the file names one.
    pub default_scene: Option<usize>,
    /// All nodes, in the file's order.
    pub nodes: Vec<Node>,
    /// Every node after its parent.
    pub order: Vec<usize>,
    /// Shapes, each of which any number of nodes may show.
    pub meshes: Vec<Mesh>,
    /// The materials of the file, and the one of glTF's defaults as the last if a primitive has none of its own.
    pub materials: Vec<Material>,
    /// Sets of joints that bend meshes.
    pub skins: Vec<Skin>,
    /// Ways to look at the model.
    pub cameras: Vec<Camera>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Motions.
    pub animations: Vec<Animation>,
    /// What was read otherwise than the file says, or not at all: one sentence each, to be shown to the user.
    pub remarks: Vec<String>,
}

/// A selection of nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneRoots {
    /// Its name, empty if it has none.
    pub name: String,
    /// Nodes without parents; all nodes below them belong to the scene, too.
    pub roots: Vec<usize>,
}

/// A place in the hierarchy, with what hangs on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its name, empty if it has none.
    pub name: String,
    /// The node it moves with.
    pub parent: Option<usize>,
    /// The nodes that move with it.
    pub children: Vec<usize>,
    /// Where it is, seen from its parent, at rest.
    pub transform: Transform,
    /// The mesh it shows.
    pub mesh: Option<usize>,
    /// The skin that bends the mesh. A skinned mesh follows its joints alone: where this node is has no effect on it.
    pub skin: Option<usize>,
    /// The camera at this place, which looks along -z with +y up.
    pub camera: Option<usize>,
    /// The light at this place, which shines along -z if it has a direction.
    pub light: Option<usize>,
    /// How far the mesh goes towards each of its morph targets at rest; as many as there are targets.
    pub weights: Vec<f32>,
}

/// Where a node is, seen from its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// Scaled, then rotated, then moved. Only such nodes are animated.
    Parts {
        /// Metres.
        translation: Vec3,
        /// Of unit length.
        rotation: Quat,
        /// Factors; negative ones mirror.
        scale: Vec3,
    },
    /// An affine matrix, `parent_from_node`.
    Matrix(Mat4),
}

impl Transform {
    /// In its parent's place.
    pub const IDENTITY: Self = Self::Parts { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    /// The matrix `parent_from_node`.
    pub fn matrix(&self) -> Mat4 {
        match *self {
            Self::Parts { translation, rotation, scale } => {
                Mat4::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Matrix(matrix) => matrix,
        }
    }
}

/// A set of joints that bends meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Its name, empty if it has none.
    pub name: String,
    /// Nodes; the vertices of a skinned mesh name them by their place in this list.
    pub joints: Vec<usize>,
    /// For each joint, the affine matrix from the space of the mesh's vertices to the joint's own.
    pub inverse_bind: Vec<Mat4>,
}

/// A way to look at the model, along -z with +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its name, empty if it has none.
    pub name: String,
    /// What it sees.
    pub projection: Projection,
    /// Distance of the nearest thing that is seen, metres; above 0 for perspectives.
    pub near: f32,
    /// Distance of the farthest thing that is seen, metres; `None` if there is no limit.
    pub far: Option<f32>,
}

/// What a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// As an eye sees.
    Perspective {
        /// Angle from bottom to top, radians, 0 to π without the ends.
        vertical_angle: f32,
        /// Width over height; `None` leaves it to the picture.
        aspect: Option<f32>,
    },
    /// Without vanishing points.
    Orthographic {
        /// Half of the width that is seen, metres; not 0.
        half_width: f32,
        /// Half of the height that is seen, metres; not 0.
        half_height: f32,
    },
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Its name, empty if it has none.
    pub name: String,
    /// Linear Rec.709, 0 or more.
    pub color: [f32; 3],
    /// Luminous intensity in candela, of suns illuminance in lux; 0 or more.
    pub intensity: f32,
    /// How it shines.
    pub kind: LightKind,
    /// Metres beyond which it may be left out; `None` if it is never.
    pub range: Option<f32>,
}

/// How a light shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From infinitely far, along -z.
    Directional,
    /// From a point in all directions.
    Point,
    /// From a point into a cone about -z.
    Spot {
        /// Angle from the axis up to which it has its full intensity, radians, below the outer one.
        inner_angle: f32,
        /// Angle from the axis at which it ends, radians, at most π/2.
        outer_angle: f32,
    },
}

impl Model {
    /// The nodes that are shown: those of the default scene, or of the first scene, or all; parents before their children.
    pub fn shown_nodes(&self) -> Vec<usize> {
        let Some(scene) = self.scenes.get(self.default_scene.unwrap_or(0)) else { return self.order.clone() };
        let mut shown = vec![false; self.nodes.len()];
        scene.roots.iter().for_each(|&root| shown[root] = true);
        let in_scene = |&node: &usize| {
            let parent = self.nodes[node].parent;
            shown[node] |= parent.is_some_and(|parent| shown[parent]);
            shown[node]
        };
        self.order.iter().copied().filter(in_scene).collect()
    }

    /// The number of the animation with this name.
    pub fn animation_named(&self, name: &str) -> Option<usize> {
        self.animations.iter().position(|animation| animation.name == name)
    }
}
