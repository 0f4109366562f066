//! The eighty primitives of the animal in seven groups. All coordinates are in metres, in the bind pose.
//!
//! Only the left side is listed, because the evaluator folds `y` to `|y|`. A smooth union of radius [`Group::blend`] joins each group to
//! the preceding groups. Within a group, each part has its own radius.

use glam::{Mat3, Vec3};

use Binding::{Axis, Blend, Rigid};
use Op::{Add, Carve};
use Shape::{Cone, Ellipsoid, Loft};
use Space::{Head, Jaw, Model};

/// The opening of the mouth in the bind pose, in degrees. The mouth is opened so wide that the coarse cells of the cage do not bridge the
/// lips.
pub const BIND_GAPE_DEGREES: f32 = 28.0;

/// The coordinate frame of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Model space.
    Model,
    /// Skull space, enlarged by 1.09. The origin is at the occipital joint, and x points towards the snout.
    Head,
    /// Mandible space, whose origin is at the hinge.
    Jaw,
}

/// The rotation, origin and uniform scale that map a [`Space`] to model space.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The rotation from local to model space.
    pub rotation: Mat3,
    /// The local origin in metres of model space.
    pub origin: Vec3,
    /// The uniform scale of local lengths.
    pub scale: f32,
}

/// Returns a rotation about the lateral axis. Positive angles raise the end at local +x.
fn pitch(degrees: f32) -> Mat3 {
    Mat3::from_rotation_y(-degrees.to_radians())
}

impl Space {
    /// Returns the frame in model space.
    #[must_use]
    pub fn frame(self) -> Frame {
        const HEAD_SCALE: f32 = 1.09;
        let head = Frame { rotation: pitch(-5.0), origin: Vec3::new(3.36, 0.0, 3.96), scale: HEAD_SCALE };
        match self {
            Model => Frame { rotation: Mat3::IDENTITY, origin: Vec3::ZERO, scale: 1.0 },
            Head => head,
            Jaw => Frame {
                rotation: pitch(-5.0 - BIND_GAPE_DEGREES),
                origin: head.point(Vec3::new(0.06, 0.0, -0.20)),
                scale: HEAD_SCALE,
            },
        }
    }
}

impl Frame {
    /// Converts a local point to model space.
    pub fn point(&self, local: Vec3) -> Vec3 {
        self.origin + self.rotation * (local * self.scale)
    }

    /// Converts a point of model space to local coordinates.
    pub fn local(&self, point: Vec3) -> Vec3 {
        self.rotation.transpose() * (point - self.origin) / self.scale
    }
}

/// The operation that joins a part to the preceding parts of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Op {
    /// Smooth union.
    Add,
    /// Smooth subtraction.
    Carve,
}

/// The joints that move the skin near a part. The names of limb joints do not include the side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    /// The joints of the axial chain. The chain coordinate is the index in this chain, from the tail tip (0) to the head (15).
    Axis,
    /// Two joints. The chain coordinate blends from the first joint (0) to the second joint (1).
    Blend(&'static str, &'static str),
    /// A single joint.
    Rigid(&'static str),
}

/// The geometry of a part in its space.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A loft of superelliptic sections along a curve. The loft has the direction of the half width (z for curves that cross the midline),
    /// the lengths of the rounded ends in metres, and stations in order. A station is x, y, z, half width, half height up, half height
    /// down, exponent and chain coordinate.
    Loft(Vec3, [f32; 2], &'static [[f32; 8]]),
    /// An ellipsoid with its centre, its radii, and its rotation about x, y, z in degrees (see `primitive::ellipsoid_rotation`).
    Ellipsoid([f32; 3], [f32; 3], [f32; 3]),
    /// A cone with the ends of its axis and the radii at both ends.
    Cone([f32; 3], [f32; 3], f32, f32),
}

/// A primitive of the model.
#[derive(Clone, Debug)]
pub struct PartSpec {
    /// The unique name of the part.
    pub name: &'static str,
    /// The operation that joins the part: union or subtraction.
    pub op: Op,
    /// The space of all coordinates and lengths except `blend`.
    pub space: Space,
    /// The joints that the part follows.
    pub binding: Binding,
    /// The radius of the smooth union or subtraction, in metres of model space.
    pub blend: f32,
    /// The geometry of the part.
    pub shape: Shape,
}

/// Parts that are combined before they join other groups.
#[derive(Clone, Debug)]
pub struct Group {
    /// The radius of the smooth union with the preceding groups in metres.
    pub blend: f32,
    /// The parts in the order of evaluation.
    pub parts: &'static [PartSpec],
}

/// Parts that are smaller than a cell of the cage. These parts are left out of the coarse distance field, because, for example, the lower
/// lip would crumple the rim of the mandible.
pub const TOO_FINE_FOR_CAGE: [&str; 10] =
    ["lower_lip", "palate", "mouth_floor", "tongue", "nostril", "lid", "lid_open", "finger1", "finger2", "hallux"];

const fn part(name: &'static str, op: Op, space: Space, binding: Binding, blend: f32, shape: Shape) -> PartSpec {
    PartSpec { name, op, space, binding, blend, shape }
}

/// All groups in the order of evaluation.
#[rustfmt::skip]
#[allow(clippy::approx_constant)] // 3.14 m is a position on the neck
pub static GROUPS: [Group; 7] = [
    // body
    Group { blend: 0.12, parts: &[
        part("axis", Add, Model, Axis, 0.1, Loft(Vec3::Y, [0.05, 0.15], &[
            [-6.7, 0.0, 2.72, 0.02, 0.024, 0.026, 2.0, 0.0],
            [-6.05, 0.0, 2.64, 0.048, 0.058, 0.06, 2.0, 0.0],
            [-5.3, 0.0, 2.58, 0.082, 0.1, 0.108, 2.0, 1.0],
            [-4.5, 0.0, 2.56, 0.125, 0.155, 0.17, 2.0, 2.0],
            [-3.7, 0.0, 2.58, 0.175, 0.21, 0.245, 2.0, 3.0],
            [-2.95, 0.0, 2.63, 0.235, 0.27, 0.33, 2.1, 4.0],
            [-2.25, 0.0, 2.7, 0.3, 0.33, 0.42, 2.1, 5.0],
            [-1.6, 0.0, 2.79, 0.36, 0.4, 0.51, 2.15, 6.0],
            [-1.0, 0.0, 2.87, 0.41, 0.485, 0.59, 2.15, 7.0],
            [-0.4, 0.0, 2.93, 0.45, 0.58, 0.68, 2.15, 8.0],
            [0.2, 0.0, 2.92, 0.52, 0.64, 0.78, 2.15, 8.0],
            [0.8, 0.0, 2.85, 0.64, 0.69, 0.87, 2.1, 9.0],
            [1.35, 0.0, 2.8, 0.7, 0.72, 0.95, 2.1, 10.0],
            [1.85, 0.0, 2.8, 0.63, 0.7, 0.93, 2.1, 11.0],
            [2.25, 0.0, 2.9, 0.5, 0.6, 0.76, 2.1, 11.5],
            [2.56, 0.0, 3.08, 0.39, 0.47, 0.54, 2.1, 12.0],
            [2.8, 0.0, 3.33, 0.32, 0.37, 0.41, 2.1, 13.0],
            [2.96, 0.0, 3.6, 0.285, 0.32, 0.345, 2.1, 14.0],
            [3.14, 0.0, 3.83, 0.28, 0.3, 0.32, 2.1, 14.5],
            [3.42, 0.0, 3.97, 0.285, 0.26, 0.3, 2.1, 15.0],
        ])),
        part("spine_ridge", Add, Model, Axis, 0.16, Loft(Vec3::Y, [0.2, 0.2], &[
            [-4.2, 0.0, 2.62, 0.05, 0.05, 0.05, 2.0, 2.4],
            [-3.0, 0.0, 2.8, 0.06, 0.06, 0.06, 2.0, 4.0],
            [-1.6, 0.0, 3.12, 0.075, 0.075, 0.075, 2.0, 6.0],
            [-0.4, 0.0, 3.43, 0.09, 0.09, 0.09, 2.0, 8.0],
            [0.4, 0.0, 3.49, 0.09, 0.09, 0.09, 2.0, 8.5],
            [1.3, 0.0, 3.47, 0.085, 0.085, 0.085, 2.0, 10.0],
            [1.95, 0.0, 3.45, 0.085, 0.085, 0.085, 2.0, 11.2],
            [2.4, 0.0, 3.47, 0.08, 0.08, 0.08, 2.0, 12.0],
            [2.7, 0.0, 3.66, 0.07, 0.07, 0.07, 2.0, 13.2],
        ])),
        part("ilium", Add, Model, Rigid("pelvis"), 0.25, Ellipsoid([-0.02, 0.27, 3.25], [0.8, 0.2, 0.22], [0.0, 3.0, 0.0])),
        part("caudofem", Add, Model, Axis, 0.24, Loft(Vec3::Y, [0.3, 0.5], &[
            [-0.2, 0.3, 2.62, 0.19, 0.24, 0.26, 2.1, 7.6],
            [-0.9, 0.27, 2.62, 0.2, 0.25, 0.28, 2.1, 7.0],
            [-1.7, 0.2, 2.6, 0.16, 0.18, 0.22, 2.1, 6.0],
            [-2.6, 0.12, 2.55, 0.11, 0.11, 0.14, 2.1, 4.5],
        ])),
        part("epaxial", Add, Model, Axis, 0.2, Loft(Vec3::Y, [0.3, 0.3], &[
            [-2.6, 0.1, 2.78, 0.1, 0.1, 0.1, 2.0, 4.5],
            [-1.4, 0.17, 3.03, 0.14, 0.14, 0.14, 2.0, 6.3],
            [-0.3, 0.22, 3.28, 0.16, 0.15, 0.15, 2.0, 8.0],
            [0.9, 0.26, 3.3, 0.18, 0.14, 0.14, 2.0, 9.2],
            [1.9, 0.22, 3.28, 0.17, 0.14, 0.14, 2.0, 11.0],
        ])),
        part("pubic_boot", Add, Model, Rigid("pelvis"), 0.22, Ellipsoid([0.4, 0.0, 2.16], [0.34, 0.14, 0.13], [0.0, 6.0, 0.0])),
        part("ischium", Add, Model, Rigid("pelvis"), 0.2, Ellipsoid([-0.45, 0.0, 2.33], [0.46, 0.13, 0.13], [0.0, -28.0, 0.0])),
        part("shoulder", Add, Model, Rigid("chest"), 0.28, Ellipsoid([1.84, 0.42, 2.74], [0.56, 0.15, 0.24], [0.0, -48.0, 0.0])),
        part("pectoral", Add, Model, Rigid("chest"), 0.28, Ellipsoid([1.98, 0.26, 2.24], [0.4, 0.24, 0.22], [0.0, -28.0, 0.0])),
        part("ribcage", Add, Model, Rigid("spine2"), 0.25, Ellipsoid([1.15, 0.42, 2.62], [0.6, 0.28, 0.52], [0.0, 0.0, 0.0])),
        part("neck_side", Add, Model, Axis, 0.14, Loft(Vec3::Y, [0.5, 0.1], &[
            [1.75, 0.26, 2.86, 0.1, 0.1, 0.1, 2.0, 10.7],
            [2.2, 0.3, 2.94, 0.15, 0.16, 0.16, 2.0, 11.5],
            [2.55, 0.27, 3.16, 0.14, 0.15, 0.15, 2.0, 12.0],
            [2.84, 0.21, 3.52, 0.11, 0.12, 0.12, 2.0, 13.4],
            [3.14, 0.2, 3.86, 0.1, 0.1, 0.1, 2.0, 14.5],
        ])),
        part("nape", Add, Model, Axis, 0.12, Loft(Vec3::Y, [0.5, 0.1], &[
            [1.7, 0.06, 3.22, 0.12, 0.1, 0.1, 2.0, 10.6],
            [2.2, 0.08, 3.4, 0.14, 0.1, 0.1, 2.0, 11.5],
            [2.55, 0.09, 3.48, 0.13, 0.11, 0.11, 2.0, 12.3],
            [2.82, 0.1, 3.72, 0.13, 0.11, 0.11, 2.0, 13.5],
            [3.1, 0.12, 4.03, 0.14, 0.11, 0.11, 2.0, 14.5],
            [3.36, 0.13, 4.15, 0.14, 0.1, 0.1, 2.0, 15.0],
        ])),
        part("throat", Add, Model, Axis, 0.14, Loft(Vec3::Y, [0.2, 0.1], &[
            [2.55, 0.0, 2.62, 0.16, 0.14, 0.14, 2.0, 11.8],
            [2.86, 0.0, 2.98, 0.14, 0.12, 0.12, 2.0, 12.6],
            [3.1, 0.0, 3.36, 0.13, 0.11, 0.11, 2.0, 13.6],
            [3.38, 0.0, 3.64, 0.14, 0.1, 0.1, 2.0, 14.6],
        ])),
        part("gular", Add, Model, Rigid("neck3"), 0.14, Ellipsoid([3.48, 0.0, 3.66], [0.24, 0.18, 0.14], [0.0, -15.0, 0.0])),
    ] },
    // head
    Group { blend: 0.14, parts: &[
        part("skull", Add, Head, Rigid("head"), 0.05, Loft(Vec3::Y, [0.1, 0.1], &[
            [-0.12, 0.0, 0.08, 0.27, 0.16, 0.22, 2.2, 0.0],
            [0.0, 0.0, 0.08, 0.365, 0.22, 0.28, 2.3, 0.0],
            [0.16, 0.0, 0.08, 0.4, 0.25, 0.3, 2.4, 0.0],
            [0.34, 0.0, 0.07, 0.355, 0.27, 0.3, 2.4, 0.0],
            [0.5, 0.0, 0.04, 0.275, 0.275, 0.3, 2.5, 0.0],
            [0.68, 0.0, 0.01, 0.222, 0.265, 0.31, 2.5, 0.0],
            [0.88, 0.0, -0.01, 0.195, 0.245, 0.3, 2.5, 0.0],
            [1.08, 0.0, -0.03, 0.176, 0.22, 0.25, 2.5, 0.0],
            [1.22, 0.0, -0.055, 0.152, 0.182, 0.185, 2.3, 0.0],
            [1.31, 0.0, -0.075, 0.128, 0.15, 0.145, 2.2, 0.0],
        ])),
        part("nasal", Add, Head, Rigid("head"), 0.1, Loft(Vec3::Y, [0.15, 0.08], &[
            [0.4, 0.0, 0.235, 0.08, 0.06, 0.06, 2.0, 0.0],
            [0.6, 0.0, 0.25, 0.075, 0.06, 0.06, 2.0, 0.0],
            [0.9, 0.0, 0.205, 0.065, 0.055, 0.05, 2.0, 0.0],
            [1.18, 0.0, 0.125, 0.055, 0.045, 0.05, 2.0, 0.0],
        ])),
        part("nasal_boss0", Add, Head, Rigid("head"), 0.04, Ellipsoid([0.6, 0.012, 0.297], [0.0525, 0.0525, 0.02604], [0.0, -9.0, 0.0])),
        part("nasal_boss1", Add, Head, Rigid("head"), 0.04, Ellipsoid([0.69, 0.012, 0.288], [0.05625, 0.05625, 0.0279], [0.0, -9.0, 0.0])),
        part("nasal_boss2", Add, Head, Rigid("head"), 0.04, Ellipsoid([0.79, 0.012, 0.268], [0.05375, 0.05375, 0.02666], [0.0, -9.0, 0.0])),
        part("nasal_boss3", Add, Head, Rigid("head"), 0.04, Ellipsoid([0.89, 0.012, 0.245], [0.05, 0.05, 0.0248], [0.0, -9.0, 0.0])),
        part("nasal_boss4", Add, Head, Rigid("head"), 0.04, Ellipsoid([0.98, 0.012, 0.221], [0.045, 0.045, 0.02232], [0.0, -9.0, 0.0])),
        part("lacrimal_horn", Add, Head, Rigid("head"), 0.08, Ellipsoid([0.5, 0.205, 0.285], [0.13, 0.055, 0.055], [8.0, -6.0, -18.0])),
        part("lacrimal_tip", Add, Head, Rigid("head"), 0.05, Ellipsoid([0.505, 0.21, 0.322], [0.07, 0.036, 0.036], [0.0, 14.0, -18.0])),
        part("brow", Add, Head, Rigid("head"), 0.06, Ellipsoid([0.4, 0.285, 0.258], [0.14, 0.062, 0.04], [18.0, 7.0, -20.0])),
        part("postorb_boss", Add, Head, Rigid("head"), 0.07, Ellipsoid([0.265, 0.325, 0.2], [0.085, 0.055, 0.085], [0.0, 25.0, -8.0])),
        part("supratemporal", Add, Head, Rigid("head"), 0.1, Ellipsoid([0.06, 0.23, 0.25], [0.2, 0.12, 0.09], [0.0, 14.0, 10.0])),
        part("jaw_muscle", Add, Head, Rigid("head"), 0.09, Ellipsoid([0.09, 0.33, -0.03], [0.19, 0.1, 0.24], [0.0, 10.0, 0.0])),
        part("quadratojugal", Add, Head, Rigid("head"), 0.08, Ellipsoid([0.02, 0.315, -0.22], [0.13, 0.075, 0.11], [0.0, 0.0, 0.0])),
        part("upper_lip", Add, Head, Rigid("head"), 0.085, Loft(Vec3::Z, [0.08, 0.04], &[
            [0.16, 0.335, -0.185, 0.065, 0.05, 0.05, 2.0, 0.0],
            [0.36, 0.292, -0.215, 0.062, 0.05, 0.05, 2.0, 0.0],
            [0.56, 0.232, -0.255, 0.06, 0.045, 0.045, 2.0, 0.0],
            [0.8, 0.192, -0.275, 0.058, 0.042, 0.042, 2.0, 0.0],
            [1.02, 0.16, -0.245, 0.055, 0.04, 0.04, 2.0, 0.0],
            [1.18, 0.12, -0.2, 0.05, 0.04, 0.04, 2.0, 0.0],
            [1.28, 0.07, -0.18, 0.048, 0.042, 0.042, 2.0, 0.0],
            [1.31, 0.03, -0.176, 0.048, 0.042, 0.042, 2.0, 0.0],
        ])),
        part("jugal_horn", Add, Head, Rigid("head"), 0.07, Ellipsoid([0.3, 0.315, -0.16], [0.15, 0.05, 0.06], [0.0, 8.0, -16.0])),
        part("snout_side", Add, Head, Rigid("head"), 0.09, Ellipsoid([0.98, 0.155, 0.03], [0.26, 0.05, 0.1], [0.0, -8.0, -5.0])),
        part("antorbital", Carve, Head, Rigid("head"), 0.11, Ellipsoid([0.67, 0.29, 0.045], [0.15, 0.062, 0.1], [0.0, -16.0, -8.0])),
        part("infratemporal", Carve, Head, Rigid("head"), 0.12, Ellipsoid([0.19, 0.47, 0.02], [0.075, 0.06, 0.13], [0.0, 18.0, 0.0])),
        part("preorb_groove", Carve, Head, Rigid("head"), 0.06, Ellipsoid([0.5, 0.33, 0.12], [0.035, 0.06, 0.12], [0.0, 12.0, 0.0])),
        part("orbit", Carve, Head, Rigid("head"), 0.05, Ellipsoid([0.405, 0.35, 0.15], [0.085, 0.085, 0.075], [0.0, 0.0, -12.0])),
        part("nostril", Carve, Head, Rigid("head"), 0.035, Ellipsoid([1.2, 0.145, 0.03], [0.06, 0.035, 0.03], [0.0, -28.0, 0.0])),
        part("palate", Carve, Head, Rigid("head"), 0.03, Loft(Vec3::Y, [0.08, 0.06], &[
            [0.16, 0.0, -0.3, 0.245, 0.08, 0.2, 2.3, 0.0],
            [0.5, 0.0, -0.31, 0.19, 0.12, 0.2, 2.3, 0.0],
            [0.85, 0.0, -0.31, 0.13, 0.12, 0.2, 2.3, 0.0],
            [1.16, 0.0, -0.26, 0.085, 0.1, 0.2, 2.3, 0.0],
        ])),
        part("lid", Add, Head, Rigid("head"), 0.04, Ellipsoid([0.415, 0.28, 0.15], [0.072, 0.058, 0.064], [0.0, 0.0, -14.0])),
        part("lid_open", Carve, Head, Rigid("head"), 0.01, Ellipsoid([0.422, 0.33, 0.147], [0.05, 0.06, 0.027], [0.0, 6.0, -12.0])),
    ] },
    // jaw
    Group { blend: 0.05, parts: &[
        part("mandible", Add, Jaw, Rigid("jaw"), 0.05, Loft(Vec3::Y, [0.1, 0.05], &[
            [-0.12, 0.0, -0.05, 0.29, 0.08, 0.12, 2.3, 0.0],
            [0.04, 0.0, -0.09, 0.34, 0.09, 0.17, 2.4, 0.0],
            [0.22, 0.0, -0.11, 0.315, 0.1, 0.225, 2.5, 0.0],
            [0.44, 0.0, -0.12, 0.25, 0.095, 0.2, 2.5, 0.0],
            [0.7, 0.0, -0.12, 0.197, 0.085, 0.15, 2.5, 0.0],
            [0.94, 0.0, -0.115, 0.166, 0.08, 0.12, 2.4, 0.0],
            [1.1, 0.0, -0.105, 0.138, 0.075, 0.108, 2.3, 0.0],
            [1.2, 0.0, -0.095, 0.095, 0.062, 0.08, 2.2, 0.0],
        ])),
        part("lower_lip", Add, Jaw, Rigid("jaw"), 0.07, Loft(Vec3::Z, [0.1, 0.04], &[
            [0.2, 0.29, -0.06, 0.05, 0.045, 0.045, 2.0, 0.0],
            [0.42, 0.232, -0.058, 0.046, 0.042, 0.042, 2.0, 0.0],
            [0.66, 0.184, -0.054, 0.044, 0.038, 0.038, 2.0, 0.0],
            [0.9, 0.152, -0.052, 0.044, 0.036, 0.036, 2.0, 0.0],
            [1.08, 0.112, -0.052, 0.044, 0.036, 0.036, 2.0, 0.0],
            [1.16, 0.065, -0.054, 0.044, 0.036, 0.036, 2.0, 0.0],
            [1.185, 0.03, -0.055, 0.044, 0.036, 0.036, 2.0, 0.0],
        ])),
        part("surangular", Add, Jaw, Rigid("jaw"), 0.09, Ellipsoid([0.14, 0.3, -0.11], [0.24, 0.06, 0.12], [0.0, 0.0, -14.0])),
        part("mouth_floor", Carve, Jaw, Rigid("jaw"), 0.03, Loft(Vec3::Y, [0.08, 0.06], &[
            [0.12, 0.0, 0.04, 0.23, 0.2, 0.13, 2.3, 0.0],
            [0.45, 0.0, 0.03, 0.185, 0.2, 0.15, 2.3, 0.0],
            [0.8, 0.0, 0.02, 0.125, 0.2, 0.13, 2.3, 0.0],
            [1.04, 0.0, 0.02, 0.075, 0.2, 0.1, 2.3, 0.0],
        ])),
        part("tongue", Add, Jaw, Rigid("jaw"), 0.02, Loft(Vec3::Y, [0.05, 0.05], &[
            [0.1, 0.0, -0.11, 0.15, 0.05, 0.06, 2.2, 0.0],
            [0.45, 0.0, -0.085, 0.12, 0.045, 0.06, 2.2, 0.0],
            [0.75, 0.0, -0.065, 0.085, 0.035, 0.05, 2.2, 0.0],
            [0.9, 0.0, -0.055, 0.05, 0.025, 0.04, 2.2, 0.0],
        ])),
    ] },
    // cheek
    Group { blend: 0.06, parts: &[
        part("cheek", Add, Model, Blend("head", "jaw"), 0.06, Cone([3.432, 0.3543, 3.779], [3.444, 0.3325, 3.635], 0.06, 0.065)),
        part("cheek2", Add, Model, Blend("head", "jaw"), 0.06, Cone([3.578, 0.327, 3.706], [3.556, 0.3106, 3.568], 0.034, 0.034)),
    ] },
    // leg
    Group { blend: 0.14, parts: &[
        part("thigh", Add, Model, Blend("hip", "knee"), 0.1, Loft(Vec3::Y, [0.25, 0.12], &[
            [-0.1, 0.33, 3.22, 0.14, 0.24, 0.24, 2.1, 0.0],
            [-0.06, 0.39, 3.0, 0.22, 0.42, 0.42, 2.1, 0.0],
            [0.05, 0.45, 2.7, 0.27, 0.52, 0.5, 2.1, 0.0],
            [0.19, 0.5, 2.38, 0.27, 0.47, 0.47, 2.1, 0.0],
            [0.35, 0.535, 2.06, 0.235, 0.36, 0.39, 2.1, 0.1],
            [0.49, 0.55, 1.8, 0.19, 0.25, 0.28, 2.1, 0.5],
            [0.58, 0.5584, 1.62, 0.16, 0.17, 0.2, 2.1, 1.0],
        ])),
        part("iliotib", Add, Model, Blend("hip", "knee"), 0.14, Loft(Vec3::Y, [0.25, 0.12], &[
            [0.42, 0.4, 3.02, 0.12, 0.16, 0.16, 2.0, 0.0],
            [0.46, 0.52, 2.6, 0.16, 0.18, 0.18, 2.0, 0.0],
            [0.56, 0.58, 2.15, 0.13, 0.15, 0.15, 2.0, 0.1],
            [0.64, 0.58, 1.82, 0.1, 0.1, 0.1, 2.0, 0.6],
        ])),
        part("flexor", Add, Model, Blend("hip", "knee"), 0.16, Loft(Vec3::Y, [0.2, 0.12], &[
            [-0.42, 0.34, 2.92, 0.12, 0.18, 0.18, 2.0, 0.0],
            [-0.34, 0.46, 2.52, 0.15, 0.18, 0.18, 2.0, 0.0],
            [-0.06, 0.52, 2.1, 0.13, 0.15, 0.15, 2.0, 0.1],
            [0.22, 0.5496, 1.72, 0.09, 0.09, 0.09, 2.0, 0.8],
        ])),
        part("kneecap", Add, Model, Rigid("knee"), 0.12, Ellipsoid([0.665, 0.5591, 1.68], [0.105, 0.115, 0.15], [0.0, -20.0, 0.0])),
        part("shank", Add, Model, Blend("knee", "ankle"), 0.1, Loft(Vec3::Y, [0.12, 0.1], &[
            [0.58, 0.5596, 1.72, 0.165, 0.19, 0.19, 2.1, 0.0],
            [0.48, 0.5571, 1.52, 0.18, 0.185, 0.24, 2.1, 0.0],
            [0.33, 0.5441, 1.28, 0.175, 0.165, 0.235, 2.1, 0.0],
            [0.16, 0.511, 1.03, 0.14, 0.135, 0.185, 2.1, 0.0],
            [0.02, 0.4785, 0.83, 0.112, 0.118, 0.13, 2.1, 0.3],
            [-0.05, 0.4667, 0.69, 0.112, 0.118, 0.115, 2.1, 0.8],
        ])),
        part("calf", Add, Model, Rigid("knee"), 0.14, Ellipsoid([0.24, 0.5601, 1.36], [0.15, 0.15, 0.33], [0.0, -32.0, 0.0])),
        part("cnemial", Add, Model, Rigid("knee"), 0.12, Ellipsoid([0.545, 0.5669, 1.5], [0.085, 0.095, 0.27], [0.0, -32.0, 0.0])),
        part("achilles", Add, Model, Rigid("ankle"), 0.08, Cone([0.02, 0.4911, 1.04], [-0.11, 0.4664, 0.66], 0.075, 0.07)),
        part("metatarsus", Add, Model, Blend("ankle", "toes"), 0.1, Loft(Vec3::Y, [0.1, 0.1], &[
            [-0.07, 0.4674, 0.74, 0.11, 0.11, 0.11, 2.2, 0.0],
            [-0.01, 0.4604, 0.58, 0.116, 0.096, 0.108, 2.3, 0.0],
            [0.06, 0.4434, 0.42, 0.126, 0.094, 0.104, 2.3, 0.0],
            [0.14, 0.4316, 0.28, 0.14, 0.105, 0.115, 2.3, 0.3],
            [0.2, 0.4203, 0.17, 0.16, 0.115, 0.12, 2.3, 1.0],
        ])),
        part("footpad", Add, Model, Rigid("toes"), 0.07, Ellipsoid([0.2, 0.42, 0.105], [0.19, 0.18, 0.105], [0.0, 0.0, 0.0])),
    ] },
    // toes
    Group { blend: 0.06, parts: &[
        part("toe3_0", Add, Model, Rigid("toes"), 0.035, Cone([0.25, 0.42, 0.13], [0.5198, 0.4294, 0.1], 0.098, 0.08428)),
        part("toe3_pad0", Add, Model, Rigid("toes"), 0.035, Ellipsoid([0.3984, 0.4252, 0.058], [0.1242, 0.09016, 0.06], [0.0, 0.0, 2.0])),
        part("toe3_1", Add, Model, Rigid("toe3"), 0.035, Cone([0.5198, 0.4294, 0.1], [0.7297, 0.4368, 0.085], 0.084, 0.07224)),
        part("toe3_pad1", Add, Model, Rigid("toe3"), 0.035, Ellipsoid([0.6353, 0.4335, 0.058], [0.0966, 0.07728, 0.06], [0.0, 0.0, 2.0])),
        part("toe3_2", Add, Model, Rigid("toe3"), 0.035, Cone([0.7297, 0.4368, 0.085], [0.8896, 0.4423, 0.075], 0.072, 0.06192)),
        part("toe3_pad2", Add, Model, Rigid("toe3"), 0.035, Ellipsoid([0.8177, 0.4398, 0.058], [0.0736, 0.06624, 0.06], [0.0, 0.0, 2.0])),
        part("toe2_0", Add, Model, Rigid("toes"), 0.035, Cone([0.2, 0.325, 0.125], [0.4266, 0.2193, 0.1], 0.09, 0.0774)),
        part("toe2_pad0", Add, Model, Rigid("toes"), 0.035, Ellipsoid([0.3246, 0.2669, 0.058], [0.115, 0.0828, 0.06], [0.0, 0.0, -25.0])),
        part("toe2_1", Add, Model, Rigid("toe2"), 0.035, Cone([0.4266, 0.2193, 0.1], [0.5988, 0.139, 0.085], 0.076, 0.06536)),
        part("toe2_pad1", Add, Model, Rigid("toe2"), 0.035, Ellipsoid([0.5213, 0.1752, 0.058], [0.0874, 0.06992, 0.06], [0.0, 0.0, -25.0])),
        part("toe4_0", Add, Model, Rigid("toes"), 0.035, Cone([0.2, 0.53, 0.125], [0.3677, 0.6389, 0.1], 0.086, 0.07396)),
        part("toe4_pad0", Add, Model, Rigid("toes"), 0.035, Ellipsoid([0.2923, 0.5899, 0.058], [0.092, 0.07912, 0.06], [0.0, 0.0, 33.0])),
        part("toe4_1", Add, Model, Rigid("toe4"), 0.035, Cone([0.3677, 0.6389, 0.1], [0.5019, 0.7261, 0.085], 0.076, 0.06536)),
        part("toe4_pad1", Add, Model, Rigid("toe4"), 0.035, Ellipsoid([0.4415, 0.6869, 0.058], [0.0736, 0.06992, 0.06], [0.0, 0.0, 33.0])),
        part("toe4_2", Add, Model, Rigid("toe4"), 0.035, Cone([0.5019, 0.7261, 0.085], [0.6026, 0.7914, 0.075], 0.066, 0.05676)),
        part("toe4_pad2", Add, Model, Rigid("toe4"), 0.035, Ellipsoid([0.5573, 0.762, 0.058], [0.0552, 0.06072, 0.06], [0.0, 0.0, 33.0])),
        part("hallux", Add, Model, Rigid("ankle"), 0.04, Cone([0.05, 0.3521, 0.32], [0.02, 0.2906, 0.2], 0.05, 0.036)),
    ] },
    // arm
    Group { blend: 0.09, parts: &[
        part("humerus", Add, Model, Rigid("arm"), 0.06, Cone([2.06, 0.52, 2.36], [1.93, 0.62, 2.03], 0.135, 0.085)),
        part("deltoid", Add, Model, Rigid("arm"), 0.12, Ellipsoid([2.04, 0.54, 2.3], [0.14, 0.1, 0.2], [0.0, -22.0, 0.0])),
        part("forearm", Add, Model, Rigid("elbow"), 0.05, Cone([1.92, 0.62, 2.02], [2.13, 0.6, 1.9], 0.082, 0.056)),
        part("hand", Add, Model, Rigid("wrist"), 0.04, Cone([2.13, 0.6, 1.9], [2.22, 0.585, 1.84], 0.056, 0.048)),
        part("finger1", Add, Model, Rigid("wrist"), 0.025, Cone([2.21, 0.555, 1.84], [2.31, 0.525, 1.76], 0.034, 0.025)),
        part("finger2", Add, Model, Rigid("wrist"), 0.025, Cone([2.22, 0.6, 1.83], [2.32, 0.6, 1.73], 0.036, 0.026)),
    ] },
];
