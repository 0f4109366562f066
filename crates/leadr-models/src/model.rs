//! A model as plain data: a node hierarchy, its contents and its animations.

use glam::{Mat4, Quat, Vec3};

use super::animation::Animation;
use super::mesh::Mesh;
use leadr_maps::material::Material;

/// The validated content of a model file: every index is in range, every number is finite, and the nodes form a forest.
///
/// Metres and radians, right-handed, y up; the front of a model faces +z. Triangles are counter-clockwise seen from their front,
/// except under mirroring matrices. Texture coordinates start at the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// File name without extension.
    pub name: String,
    /// Scenes.
    pub scenes: Vec<SceneRoots>,
    /// Default scene, if the file defines one.
    pub default_scene: Option<usize>,
    /// All nodes, in file order.
    pub nodes: Vec<Node>,
    /// Node indices, parents before children.
    pub order: Vec<usize>,
    /// Meshes; several nodes may share one.
    pub meshes: Vec<Mesh>,
    /// Materials of the file, followed by glTF's default material if a primitive needs it.
    pub materials: Vec<Material>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Animations.
    pub animations: Vec<Animation>,
    /// Repairs and ignored content: one message each, for display to the user.
    pub remarks: Vec<String>,
}

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneRoots {
    /// Name, empty if missing.
    pub name: String,
    /// Root nodes; their descendants belong to the scene too.
    pub roots: Vec<usize>,
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name, empty if missing.
    pub name: String,
    /// Parent node.
    pub parent: Option<usize>,
    /// Child nodes.
    pub children: Vec<usize>,
    /// Rest transform relative to the parent.
    pub transform: Transform,
    /// Mesh of the node.
    pub mesh: Option<usize>,
    /// Skin of the mesh. A skinned mesh follows only its joints; the node's transform has no effect on it.
    pub skin: Option<usize>,
    /// Camera at this node, looking along -z with +y up.
    pub camera: Option<usize>,
    /// Light at this node, shining along -z if it is directional.
    pub light: Option<usize>,
    /// Rest weights of the morph targets, one per target.
    pub weights: Vec<f32>,
}

/// Transform of a node relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// Scale, then rotation, then translation. Only these nodes can be animated.
    Parts {
        /// Metres.
        translation: Vec3,
        /// Of unit length.
        rotation: Quat,
        /// Factors; negative values mirror.
        scale: Vec3,
    },
    /// An affine matrix, `parent_from_node`.
    Matrix(Mat4),
}

impl Transform {
    /// The identity transform.
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

/// A skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Name, empty if missing.
    pub name: String,
    /// Joint nodes; vertices refer to them by their index in this list.
    pub joints: Vec<usize>,
    /// Per joint, the affine matrix from mesh vertex space to joint space.
    pub inverse_bind: Vec<Mat4>,
}

/// A camera, looking along -z with +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name, empty if missing.
    pub name: String,
    /// Projection.
    pub projection: Projection,
    /// Near distance, metres; above 0 for perspective.
    pub near: f32,
    /// Far distance, metres; `None` is infinite.
    pub far: Option<f32>,
}

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection.
    Perspective {
        /// Vertical field of view, radians, in the open interval 0 to π.
        vertical_angle: f32,
        /// Width over height; `None` uses that of the picture.
        aspect: Option<f32>,
    },
    /// Orthographic projection.
    Orthographic {
        /// Half of the visible width, metres; not 0.
        half_width: f32,
        /// Half of the visible height, metres; not 0.
        half_height: f32,
    },
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name, empty if missing.
    pub name: String,
    /// Linear Rec.709, 0 or more.
    pub color: [f32; 3],
    /// Luminous intensity in candela, or illuminance in lux for directional lights; at least 0.
    pub intensity: f32,
    /// Type of light.
    pub kind: LightKind,
    /// Range in metres beyond which the light may be omitted; `None` is unlimited.
    pub range: Option<f32>,
}

/// Type of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Directional, along -z.
    Directional,
    /// Point light, in all directions.
    Point,
    /// Spot light, into a cone about -z.
    Spot {
        /// Angle from the axis where the intensity starts to decrease, radians, below `outer_angle`.
        inner_angle: f32,
        /// Angle from the axis where the light ends, radians, at most π/2.
        outer_angle: f32,
    },
}

impl Model {
    /// The visible nodes: those of the default scene, else of the first scene, else all. Parents precede children.
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

    /// Index of the animation with this name.
    pub fn animation_named(&self, name: &str) -> Option<usize> {
        self.animations.iter().position(|animation| animation.name == name)
    }
}
