//! A model as plain data: a node hierarchy, its contents and its animations.

use glam::{Mat4, Quat, Vec3};

use super::animation::Animation;
use super::mesh::Mesh;
use leadr_maps::material::Material;

/// The validated content of a model file. Every index is in range, every number is finite, and the nodes form a forest.
///
/// Lengths are in metres and angles in radians. The axes are right-handed with y up, and the front of a model faces +z.
/// Triangles are counter-clockwise when seen from the front, except under mirroring matrices. Texture coordinates start at
/// the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The file name without its extension.
    pub name: String,
    /// Scenes.
    pub scenes: Vec<SceneRoots>,
    /// The index of the default scene, if the file defines one.
    pub default_scene: Option<usize>,
    /// All nodes, in file order.
    pub nodes: Vec<Node>,
    /// The node indices in an order with parents before children.
    pub order: Vec<usize>,
    /// The meshes. Several nodes may share one mesh.
    pub meshes: Vec<Mesh>,
    /// The materials of the file, followed by glTF's default material if a primitive needs it.
    pub materials: Vec<Material>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Animations.
    pub animations: Vec<Animation>,
    /// Messages for the user, one for each repair or for each kind of ignored content.
    pub remarks: Vec<String>,
}

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneRoots {
    /// The name, or an empty string.
    pub name: String,
    /// The root nodes, whose descendants also belong to the scene.
    pub roots: Vec<usize>,
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The name, or an empty string.
    pub name: String,
    /// The index of the parent node.
    pub parent: Option<usize>,
    /// The indices of the child nodes.
    pub children: Vec<usize>,
    /// The default transform relative to the parent.
    pub transform: Transform,
    /// The index of the node's mesh.
    pub mesh: Option<usize>,
    /// The index of the skin of the mesh. A skinned mesh follows only its joints, and ignores the node's transform.
    pub skin: Option<usize>,
    /// The index of the camera at this node. The camera looks along -z with +y up.
    pub camera: Option<usize>,
    /// The index of the light at this node. A directional light shines along -z.
    pub light: Option<usize>,
    /// The default weights of the morph targets, one per target.
    pub weights: Vec<f32>,
    /// Whether the node and its descendants are visible.
    pub visible: bool,
}

/// The transform of a node relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// A scale, then a rotation, then a translation. Only nodes with separate parts can be animated.
    Parts {
        /// The translation in metres.
        translation: Vec3,
        /// The rotation as a unit quaternion.
        rotation: Quat,
        /// The scale factors. Negative factors mirror the node.
        scale: Vec3,
    },
    /// The affine matrix `parent_from_node`.
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
    /// The name, or an empty string.
    pub name: String,
    /// The joint nodes. A vertex refers to a joint by its index in this list.
    pub joints: Vec<usize>,
    /// The affine matrix of each joint from mesh vertex space to joint space.
    pub inverse_bind: Vec<Mat4>,
}

/// A camera, which looks along -z with +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The name, or an empty string.
    pub name: String,
    /// The projection.
    pub projection: Projection,
    /// The near distance in metres, which is above 0 for perspective cameras.
    pub near: f32,
    /// The far distance in metres. `None` means infinite.
    pub far: Option<f32>,
}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A perspective projection.
    Perspective {
        /// The vertical field of view in radians, above 0 and below π.
        vertical_angle: f32,
        /// The aspect ratio, width over height. `None` means the aspect ratio of the picture.
        aspect: Option<f32>,
    },
    /// An orthographic projection.
    Orthographic {
        /// Half of the visible width in metres, which is not 0.
        half_width: f32,
        /// Half of the visible height in metres, which is not 0.
        half_height: f32,
    },
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The name, or an empty string.
    pub name: String,
    /// The linear Rec.709 colour, whose components are at least 0.
    pub color: [f32; 3],
    /// The luminous intensity in candela, or the illuminance in lux for directional lights, at least 0.
    pub intensity: f32,
    /// The type of light.
    pub kind: LightKind,
    /// The distance in metres beyond which the light may be omitted. `None` means unlimited.
    pub range: Option<f32>,
}

/// The type of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// A directional light, which shines along -z.
    Directional,
    /// A point light, which shines in all directions.
    Point,
    /// A spot light, which shines in a cone about -z.
    Spot {
        /// The angle from the axis, in radians and below `outer_angle`, where the intensity starts to decrease.
        inner_angle: f32,
        /// The angle from the axis, in radians and at most π/2, where the light ends.
        outer_angle: f32,
    },
}

impl Model {
    /// Returns the visible nodes, with parents before children: the nodes of the default scene, else of the first scene,
    /// else all nodes.
    pub fn shown_nodes(&self) -> Vec<usize> {
        let scene = self.scenes.get(self.default_scene.unwrap_or(0));
        let mut shown = vec![scene.is_none(); self.nodes.len()];
        let mut visible = vec![true; self.nodes.len()];
        scene.iter().flat_map(|scene| &scene.roots).for_each(|&root| shown[root] = true);
        let in_scene = |&node: &usize| {
            let parent = self.nodes[node].parent;
            shown[node] |= parent.is_some_and(|parent| shown[parent]);
            visible[node] = self.nodes[node].visible && parent.is_none_or(|parent| visible[parent]);
            shown[node] && visible[node]
        };
        self.order.iter().copied().filter(in_scene).collect()
    }

    /// Returns the index of the animation with this name.
    pub fn animation_named(&self, name: &str) -> Option<usize> {
        self.animations.iter().position(|animation| animation.name == name)
    }
}
