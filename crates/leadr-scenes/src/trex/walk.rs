//! The joint matrices of the walk, as functions of time. The inverse kinematics of a leg is exact for the position of the foot, so feet do
//! not slide.

use glam::{DMat3, DMat4, DVec2, DVec3, Mat4};

use super::gait::{Foot, JointAngles, PERIOD, STRIDE, foot, joint_angles, pelvis};
use super::skeleton::{JOINT_COUNT, JOINTS, joint_index};

/// The walking speed in metres per second.
pub const SPEED: f64 = STRIDE / PERIOD;

/// Returns the world-from-rest matrix of every joint at a time, for linear blend skinning of rest positions. The animal walks along +x at
/// [`SPEED`]. At time zero, the left foot touches down and the rest position of the pelvis is over the origin.
pub fn pose(time_seconds: f64) -> Vec<Mat4> {
    let cycles = time_seconds / PERIOD;
    skinning(&world_from_joint(cycles.rem_euclid(1.0), cycles * STRIDE))
}

fn skinning(world_from_joint: &[Mat4; JOINT_COUNT]) -> Vec<Mat4> {
    let joints = world_from_joint.iter().zip(&JOINTS);
    joints.map(|(m, joint)| *m * Mat4::from_translation(-joint.position)).collect()
}

fn rotation(angles: JointAngles) -> DMat3 {
    DMat3::from_rotation_z(angles.yaw) * DMat3::from_rotation_x(angles.roll) * DMat3::from_rotation_y(angles.pitch)
}

fn rest(name: &str) -> DVec3 {
    JOINTS[joint_index(name)].position.as_dvec3()
}

/// Returns the world-from-joint matrices, in the order of [`JOINTS`], at a phase of the walk. The animal has walked `travelled` metres.
fn world_from_joint(t: f64, travelled: f64) -> [Mat4; JOINT_COUNT] {
    let mut local = joint_angles(t).map(rotation);
    let (offset, pelvis_angles) = pelvis(t);
    local[joint_index("pelvis")] = rotation(pelvis_angles);
    for (side, sign) in [("L", 1.0), ("R", -1.0)] {
        let foot = foot(t + if sign < 0.0 { 0.5 } else { 0.0 });
        solve_leg(&mut local, side, sign, &foot, offset, pelvis_angles);
    }
    // This is forward kinematics from the root.
    let root = offset + DVec3::X * travelled;
    let mut world = [DMat4::IDENTITY; JOINT_COUNT];
    for (i, joint) in JOINTS.iter().enumerate() {
        world[i] = match joint.parent {
            None => DMat4::from_translation(root),
            Some(p) => {
                let arm = (joint.position - JOINTS[p].position).as_dvec3();
                world[p] * DMat4::from_translation(arm) * DMat4::from_mat3(local[i])
            }
        };
    }
    world.map(|m| m.as_mat4())
}

/// Returns the angle of a vector in the sagittal plane, which increases with positive pitch.
fn sagittal_angle(v: DVec2) -> f64 {
    v.x.atan2(v.y)
}

/// Solves the five joints of a leg and its toes for the foot pose `foot`.
///
/// The lateral offsets of a leg's bones cancel (hip and metatarsal joint have the same rest `y`). After yaw and roll of the hip, the
/// problem is planar. The metatarsus determines the ankle, and the two bones above determine the knee.
fn solve_leg(local: &mut [DMat3], side: &str, sign: f64, foot: &Foot, root: DVec3, pelvis_angles: JointAngles) {
    let joint = |name: &str| joint_index(&format!("{name}_{side}"));
    let [hip, knee, ankle, toes] = ["hip", "knee", "ankle", "toes"].map(|n| rest(&format!("{n}_{side}")));
    let pelvis_rotation = rotation(pelvis_angles);
    let pelvis_rest = rest("pelvis");
    let hip_world = root + pelvis_rest + pelvis_rotation * (hip - pelvis_rest);
    let target = DVec3::new(foot.joint.x + hip.x, sign * foot.joint.y, foot.joint.z);
    // Feet point ahead, so the hip cancels the yaw of the pelvis.
    let yaw = -pelvis_angles.yaw;
    let reach = (pelvis_rotation * DMat3::from_rotation_z(yaw)).transpose() * (target - hip_world);
    let roll = (-reach.y / reach.z).atan();
    let planar = DMat3::from_rotation_x(-roll) * reach;
    let sagittal = |v: DVec3| DVec2::new(v.x, v.z);
    let (femur, tibia, metatarsus) = (sagittal(knee - hip), sagittal(ankle - knee), sagittal(toes - ankle));
    let shaft = DVec2::new(foot.metatarsus.sin(), -foot.metatarsus.cos()) * metatarsus.length();
    let ankle_at = sagittal(planar) - shaft;
    // The knee follows from the inverse kinematics of two bones, with the knee in front.
    let (a, b) = (femur.length(), tibia.length());
    let distance = ankle_at.length().clamp((a - b).abs() + 1e-6, a + b - 1e-6);
    let direction = ankle_at.normalize();
    let along = (a * a - b * b + distance * distance) / (2.0 * distance);
    let ahead = DVec2::new(-direction.y, direction.x);
    let knee_at = direction * along + ahead * (a * a - along * along).max(0.0).sqrt();
    let thigh = sagittal_angle(knee_at) - sagittal_angle(femur);
    let shank = sagittal_angle(direction * distance - knee_at) - sagittal_angle(tibia);
    let foot_bone = sagittal_angle(shaft) - sagittal_angle(metatarsus);
    local[joint("hip")] = rotation(JointAngles { roll, pitch: thigh, yaw });
    local[joint("knee")] = DMat3::from_rotation_y(shank - thigh);
    local[joint("ankle")] = DMat3::from_rotation_y(foot_bone - shank);
    // The foot stays level sideways in any pose of the leg.
    let ankle_world = pelvis_rotation * rotation(JointAngles { roll, pitch: foot_bone, yaw });
    local[joint("toes")] = ankle_world.transpose() * DMat3::from_rotation_y(foot.pitch);
    for (i, name) in ["toe2", "toe3", "toe4"].into_iter().enumerate() {
        let yaw = foot.closing * sign * [1.0, 0.0, -1.0][i];
        local[joint(name)] = DMat3::from_rotation_y(foot.toes[i] - foot.pitch) * DMat3::from_rotation_z(yaw);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trex::gait::{DUTY, HEEL_OFF};
    use crate::trex::sdf::TrexSdf;
    use glam::Vec3;
    use leadr_render::surfaces::patch_mesh::PatchMesh;

    /// Returns the joints at a time. The animal travels, or walks on a treadmill.
    fn joints(time: f64, travels: bool) -> [Mat4; JOINT_COUNT] {
        let cycles = time / PERIOD;
        world_from_joint(cycles.rem_euclid(1.0), if travels { cycles * STRIDE } else { 0.0 })
    }

    #[test]
    fn the_walk_repeats_a_stride_further() {
        for k in 0..50 {
            let time = 0.0321 * f64::from(k);
            let [a, b] = [time, time + PERIOD].map(|time| joints(time, true));
            for (m, n) in a.iter().zip(&b) {
                let moved = Mat4::from_translation(Vec3::X * STRIDE as f32) * *m;
                assert!(moved.abs_diff_eq(*n, 2e-6), "{time}: {moved} {n}");
            }
            let [c, d] = [time, time + PERIOD].map(|time| joints(time, false));
            assert!(c.iter().zip(&d).all(|(m, n)| m.abs_diff_eq(*n, 2e-6)));
        }
    }

    #[test]
    fn legs_reach_their_feet_and_bend_as_designed() {
        let mut range = [[f64::MAX, f64::MIN]; 3];
        for k in 0..200 {
            let time = PERIOD * f64::from(k) / 200.0;
            let p = joints(time, true);
            for (side, sign, shift) in [("L", 1.0, 0.0), ("R", -1.0, 0.5)] {
                let at = |n: &str| p[joint_index(&format!("{n}_{side}"))].w_axis.truncate().as_dvec3();
                let f = foot(time / PERIOD + shift);
                let target = DVec3::new(f.joint.x - 0.05 + SPEED * time, sign * f.joint.y, f.joint.z);
                assert!(at("toes").distance(target) < 1e-5, "{side} {time}");
                let angles = [
                    sagittal_angle(DVec2::new((at("knee") - at("hip")).x, (at("knee") - at("hip")).z)),
                    sagittal_angle(DVec2::new((at("ankle") - at("knee")).x, (at("ankle") - at("knee")).z)),
                    0.0,
                ];
                let knee = (angles[0] - angles[1]).rem_euclid(std::f64::consts::TAU);
                let reach = at("ankle").distance(at("hip")) / 2.455;
                for (r, v) in range.iter_mut().zip([knee.to_degrees(), reach, at("toes").z]) {
                    *r = [r[0].min(v), r[1].max(v)];
                }
            }
        }
        println!(
            "angle between femur and tibia {:.1?} deg, reach {:.3?}, foot height {:.3?}",
            range[0], range[1], range[2]
        );
        assert!(range[1][1] < 0.97, "the leg is stretched: {:?}", range[1]);
    }

    /// Returns the skinned positions of all vertices of the cage.
    fn skinned(mesh: &PatchMesh, pose: &[Mat4]) -> Vec<Vec3> {
        leadr_render::surfaces::skinning::skin(mesh, pose).positions
    }

    #[test]
    fn planted_feet_do_not_slide_and_nothing_sinks() {
        let mesh = super::super::cage::build(&TrexSdf::new());
        let weight = |v: usize, name: &str| {
            let skin = &mesh.skin[v];
            (0..4).filter(|&k| usize::from(skin.joints[k]) == joint_index(name)).map(|k| skin.weights[k]).sum::<f32>()
        };
        for (side, index) in [("L", 0), ("R", 1)] {
            let of = |names: &[&str], least: f32| -> Vec<usize> {
                let held = |v: usize| names.iter().map(|n| weight(v, &format!("{n}_{side}"))).sum::<f32>();
                (0..mesh.positions.len()).filter(|&v| mesh.positions[v].z < 0.08 && held(v) > least).collect()
            };
            // The whole sole is planted while the foot is flat. The middle toe is planted until it leaves the ground.
            let sole = of(&["toes", "toe2", "toe3", "toe4"], 0.999);
            for (points, until) in [(sole, HEEL_OFF), (of(&["toe3"], 0.995), DUTY)] {
                assert!(points.len() > 8, "{}", points.len());
                let start = PERIOD * (1.0 - 0.5 * f64::from(index));
                let mut slip = 0.0_f32;
                let before = skinned(&mesh, &pose(start));
                for k in 0..=40 {
                    let now = skinned(&mesh, &pose(start + PERIOD * until * f64::from(k) / 40.0));
                    slip = points.iter().map(|&v| now[v].distance(before[v])).fold(slip, f32::max);
                }
                println!("{side} {} points until {until}: slip {:.4} mm", points.len(), slip * 1e3);
                assert!(slip < 1e-3);
                // The comparison detects a foot that is not planted.
                let late = skinned(&mesh, &pose(start + PERIOD * (DUTY + 0.1)));
                assert!(points.iter().any(|&v| late[v].distance(before[v]) > 0.05));
            }
        }
        for k in 0..32 {
            let time = PERIOD * f64::from(k) / 32.0;
            let now = skinned(&mesh, &skinning(&joints(time, false)));
            let (v, low) = now.iter().enumerate().min_by(|a, b| a.1.z.total_cmp(&b.1.z)).unwrap();
            println!("{k} lowest {:.1} mm at {:.2}", low.z * 1e3, mesh.positions[v]);
            assert!((-0.015..=0.005).contains(&low.z), "{k}: {} at {}", low.z, mesh.positions[v]);
        }
    }
}
