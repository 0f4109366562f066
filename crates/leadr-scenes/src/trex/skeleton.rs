//! The skeleton, which has forty joints. All rest orientations are the identity.

use glam::Vec3;

/// The number of joints.
pub const JOINT_COUNT: usize = 40;

/// A joint in the rest pose.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// The name of the joint. The names of limb joints end in `_L` or `_R`.
    pub name: &'static str,
    /// The index of the parent, which is smaller than the index of the joint.
    pub parent: Option<usize>,
    /// The rest position in metres of model space.
    pub position: Vec3,
}

const fn joint(name: &'static str, parent: Option<usize>, position: [f32; 3]) -> Joint {
    Joint { name, parent, position: Vec3::from_array(position) }
}

/// All joints. Parents come before their children.
#[rustfmt::skip]
pub const JOINTS: [Joint; JOINT_COUNT] = [
    joint("root", None, [0.0, 0.0, 0.0]),
    joint("pelvis", Some(0), [0.0, 0.0, 2.95]),
    joint("spine1", Some(1), [0.62, 0.0, 3.02]),
    joint("spine2", Some(2), [1.15, 0.0, 2.98]),
    joint("chest", Some(3), [1.65, 0.0, 2.94]),
    joint("neck1", Some(4), [2.3, 0.0, 2.98]),
    joint("neck2", Some(5), [2.66, 0.0, 3.2]),
    joint("neck3", Some(6), [2.87, 0.0, 3.5]),
    joint("head", Some(7), [3.26, 0.0, 3.92]),
    joint("jaw", Some(8), [3.406, 0.0, 3.737]),
    joint("eye_L", Some(8), [3.828, 0.307, 4.083]),
    joint("eye_R", Some(8), [3.828, -0.307, 4.083]),
    joint("tail1", Some(1), [-0.7, 0.0, 2.9]),
    joint("tail2", Some(12), [-1.3, 0.0, 2.83]),
    joint("tail3", Some(13), [-1.92, 0.0, 2.74]),
    joint("tail4", Some(14), [-2.6, 0.0, 2.66]),
    joint("tail5", Some(15), [-3.32, 0.0, 2.6]),
    joint("tail6", Some(16), [-4.1, 0.0, 2.57]),
    joint("tail7", Some(17), [-4.9, 0.0, 2.57]),
    joint("tail8", Some(18), [-5.68, 0.0, 2.61]),
    joint("hip_L", Some(1), [-0.05, 0.42, 2.8]),
    joint("knee_L", Some(20), [0.57, 0.558, 1.66]),
    joint("ankle_L", Some(21), [-0.06, 0.467, 0.7]),
    joint("toes_L", Some(22), [0.2, 0.42, 0.15]),
    joint("toe2_L", Some(23), [0.43, 0.22, 0.1]),
    joint("toe3_L", Some(23), [0.52, 0.42, 0.1]),
    joint("toe4_L", Some(23), [0.37, 0.64, 0.1]),
    joint("arm_L", Some(4), [2.06, 0.5, 2.36]),
    joint("elbow_L", Some(27), [1.93, 0.62, 2.03]),
    joint("wrist_L", Some(28), [2.13, 0.6, 1.9]),
    joint("hip_R", Some(1), [-0.05, -0.42, 2.8]),
    joint("knee_R", Some(30), [0.57, -0.558, 1.66]),
    joint("ankle_R", Some(31), [-0.06, -0.467, 0.7]),
    joint("toes_R", Some(32), [0.2, -0.42, 0.15]),
    joint("toe2_R", Some(33), [0.43, -0.22, 0.1]),
    joint("toe3_R", Some(33), [0.52, -0.42, 0.1]),
    joint("toe4_R", Some(33), [0.37, -0.64, 0.1]),
    joint("arm_R", Some(4), [2.06, -0.5, 2.36]),
    joint("elbow_R", Some(37), [1.93, -0.62, 2.03]),
    joint("wrist_R", Some(38), [2.13, -0.6, 1.9]),
];

/// The axial chain from the tip of the tail to the head, in the order of the chain coordinates of lofts.
pub const AXIAL_CHAIN: [&str; 16] = [
    "tail8", "tail7", "tail6", "tail5", "tail4", "tail3", "tail2", "tail1", "pelvis", "spine1", "spine2", "chest",
    "neck1", "neck2", "neck3", "head",
];

/// Returns the index of the named joint.
///
/// # Panics
/// If there is no such joint. All names are constants of this crate.
pub fn joint_index(name: &str) -> usize {
    JOINTS.iter().position(|j| j.name == name).unwrap_or_else(|| panic!("there is no joint named {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parents_come_first_and_sides_mirror() {
        for (i, j) in JOINTS.iter().enumerate() {
            assert!(j.parent.is_none_or(|p| p < i), "{}", j.name);
            assert_eq!(joint_index(j.name), i);
            if let Some(stem) = j.name.strip_suffix("_L") {
                let other = &JOINTS[joint_index(&format!("{stem}_R"))];
                assert_eq!(other.position, j.position * Vec3::new(1.0, -1.0, 1.0));
            }
        }
    }

    #[test]
    fn the_jaw_turns_about_the_hinge_of_the_mandible() {
        let hinge = crate::trex::parts::Space::Jaw.frame().origin;
        assert!(hinge.distance(JOINTS[joint_index("jaw")].position) < 1e-3);
    }
}
