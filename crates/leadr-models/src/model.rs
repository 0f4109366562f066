//! A model as plain data: a node hierarchy, its contents and its animations.

use glam::{Mat4, Quat, Vec3};

use super::animation::Animation;
use super::mesh::Mesh;
use leadr_maps::material::Material;

/// Validated content of a model file. Every index is in range, every number is finite, and the nodes form a forest.
///
/// Units are metres and radians, right-handed, y up. The front of a model faces +z. Triangles are counter-clockwise when seen
/// from the front, except under mirroring matrices. Texture coordinates start at the top left.
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
    /// Node indices in an order with parents before children.
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
    /// Messages for the user, one for each repair or ignored content.
    pub remarks: Vec<String>,
}

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneRoots {
    /// Name, empty if missing.
    pub name: String,
    /// Root nodes. Their descendants belong to the scene too.
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
    /// Default transform relative to the parent.
    pub transform: Transform,
    /// Mesh of the node.
    pub mesh: Option<usize>,
    /// Skin of the mesh. A skinned mesh follows only its joints; the node's transform has no effect on it.
    pub skin: Option<usize>,
    /// Camera at this node, looking along -z with +y up.
    pub camera: Option<usize>,
    /// Light at this node, shining along -z if it is directional.
    pub light: Option<usize>,
    /// Default weights of the morph targets, one per target.
    pub weights: Vec<f32>,
}

/// Transform of a node relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// Scale, then rotation, then translation. Only nodes in this form can be animated.
    Parts {
        /// Translation in metres.
        translation: Vec3,
        /// Unit quaternion.
        rotation: Quat,
        /// Scale factors. Negative factors mirror.
        scale: Vec3,
    },
    /// An affine matrix, `parent_from_node`.
    Matrix(Mat4),
}

impl Transform {
    /// The identity transform.
    pub const IDENTITY: Self = Self::Parts { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    /// Returns the matrix `parent_from_node`.
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
    /// Joint nodes. Vertices refer to joints by the index in this list.
    pub joints: Vec<usize>,
    /// Affine matrix from mesh vertex space to joint space, for each joint.
    pub inverse_bind: Vec<Mat4>,
}

/// A camera, looking along -z with +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name, empty if missing.
    pub name: String,
    /// Projection.
    pub projection: Projection,
    /// Near distance in metres, above 0 for perspective cameras.
    pub near: f32,
    /// Far distance in metres. `None` is infinite.
    pub far: Option<f32>,
}

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection.
    Perspective {
        /// Vertical field of view in radians, above 0 and below π.
        vertical_angle: f32,
        /// Aspect ratio, width over height. `None` uses that of the picture.
        aspect: Option<f32>,
    },
    /// Orthographic projection.
    Orthographic {
        /// Half of the visible width in metres, not 0.
        half_width: f32,
        /// Half of the visible height in metres, not 0.
        half_height: f32,
    },
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name, empty if missing.
    pub name: String,
    /// Linear Rec.709 colour, 0 or more.
    pub color: [f32; 3],
    /// Luminous intensity in candela, or illuminance in lux for directional lights; at least 0.
    pub intensity: f32,
    /// Type of light.
    pub kind: LightKind,
    /// Distance in metres beyond which the light may be omitted. `None` is unlimited.
    pub range: Option<f32>,
}

/// Type of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Directional light along -z.
    Directional,
    /// Point light in all directions.
    Point,
    /// Spot light, a cone about -z.
    Spot {
        /// Angle from the axis in radians where the intensity starts to decrease, below `outer_angle`.
        inner_angle: f32,
        /// Angle from the axis in radians where the light ends, at most π/2.
        outer_angle: f32,
    },
}

impl Model {
    /// Returns the visible nodes: those of the default scene, else of the first scene, else all. Parents precede children.
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

    /// Returns the index of the animation with this name.
    pub fn animation_named(&self, name: &str) -> Option<usize> {
        self.animations.iter().position(|animation| animation.name == name)
    }
}
