//! The target poses of the pelvis, the feet and the other joints during the walk, as functions of the phase.
//!
//! Phase `t` is in `[0, 1)`: 0 is the touchdown of the left foot, and the right leg is half a cycle later. Angles are in radians, and
//! lengths in metres. A positive pitch lowers the nose, and moves the far end of a leg backwards.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::DVec3;

use super::primitive;
use super::skeleton::{JOINT_COUNT, joint_index};

/// The distance walked in one cycle in metres.
pub const STRIDE: f64 = 3.6;
/// The duration of one walk cycle in seconds.
pub const PERIOD: f64 = 1.6;
/// The fraction of the cycle during which a foot is on the ground.
pub const DUTY: f64 = 0.62;
/// The phase at which the heel starts to lift.
pub const HEEL_OFF: f64 = 0.48;
/// Half the distance between the mid-lines of the feet, in metres.
const TRACK: f64 = 0.35;
/// The distance in metres by which the metatarsal joint is ahead of the rest position of the hip at touchdown.
const REACH: f64 = 1.17;
/// The height of the metatarsal joint over flat ground in metres.
const FOOT_HEIGHT: f64 = 0.15;
/// The position of the middle toe's joint relative to the metatarsal joint. The foot rolls over the toe's joint.
const PIVOT: [f64; 2] = [0.32, -0.05];
/// The lift of the heel at the end of the stance in degrees.
const HEEL_LIFT: f64 = 42.0;

/// Roll, pitch and yaw of a joint. The rotation is yaw · roll · pitch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointAngles {
    /// The rotation about x.
    pub roll: f64,
    /// The rotation about y.
    pub pitch: f64,
    /// The rotation about z.
    pub yaw: f64,
}

/// Returns the displacement of the root in the travelling frame, and the rotation of the pelvis.
pub fn pelvis(t: f64) -> (DVec3, JointAngles) {
    let wave = |h: f64, at: f64| (TAU * h * (t - at)).cos();
    let offset =
        DVec3::new(0.03 * (2.0 * TAU * (t - 0.02)).sin(), 0.060 * wave(1.0, 0.31), -0.085 - 0.040 * wave(2.0, 0.07));
    let degrees = |d: f64| d.to_radians();
    let angles = JointAngles {
        roll: degrees(2.2 * wave(1.0, 0.29)),
        pitch: degrees(0.4 * wave(2.0, 0.12)),
        yaw: degrees(-4.0 * wave(1.0, 0.02)),
    };
    (offset, angles)
}

/// The pose of a foot: the metatarsal joint in the travelling frame, the tilt of the metatarsus, and the pitch of the foot and of its toes.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// The position of the metatarsal joint: x relative to the rest position of the hip, the distance from the mid-line, and the height.
    pub joint: DVec3,
    /// The angle by which the metatarsus leans backwards from the vertical.
    pub metatarsus: f64,
    /// The pitch of the foot; positive lifts the heel.
    pub pitch: f64,
    /// The pitch of toes II, III and IV relative to the ground.
    pub toes: [f64; 3],
    /// The angle by which the outer toes close toward the middle toe, in radians.
    pub closing: f64,
}

/// Returns the pose of the left foot at phase `t`. For the right foot, pass `t + ½` and mirror `y`.
pub fn foot(t: f64) -> Foot {
    let t = t.rem_euclid(1.0);
    let metatarsus = metatarsus(t).to_radians();
    if t < DUTY {
        let [x, z, pitch] = stance(t);
        let lift = pitch.sin();
        // The joints of toes II and IV are behind the pivot and rise with the heel. The tips of these toes stay near the ground.
        let toes = [(0.09 * lift / 0.23).asin() * 0.9, 0.0, (0.15 * lift / 0.29).asin() * 0.9];
        return Foot { joint: DVec3::new(x, TRACK, z), metatarsus, pitch, toes, closing: 0.0 };
    }
    let end = stance(DUTY);
    let step = 1e-5;
    let before = stance(DUTY - step);
    let speed = [0, 1, 2].map(|i| (end[i] - before[i]) / step);
    let passing = ([0.05, 0.66, 32_f64.to_radians()], [8.2, 0.3, -150_f64.to_radians()]);
    let landing = ([REACH, FOOT_HEIGHT, 0.0], [-STRIDE, -0.25, 0.0]);
    let [x, z, pitch] = [0, 1, 2].map(|i| {
        if t < 0.80 {
            hermite(t, DUTY, 0.80, end[i], passing.0[i], speed[i], passing.1[i])
        } else {
            hermite(t, 0.80, 1.0, passing.0[i], landing.0[i], passing.1[i], landing.1[i])
        }
    });
    let s = (t - DUTY) / (1.0 - DUTY);
    // Toes trail after lift-off, and rise before they land flat.
    let droop = 28_f64.to_radians() * bump(s / 0.55) - 10_f64.to_radians() * bump((s - 0.55) / 0.45);
    let fade = (1.0 - s / 0.3).clamp(0.0, 1.0).powi(2) * (1.0 + 2.0 * (s / 0.3).clamp(0.0, 1.0));
    let lift = end[2].sin();
    let toes =
        [droop + fade * (0.09 * lift / 0.23).asin() * 0.9, droop, droop + fade * (0.15 * lift / 0.29).asin() * 0.9];
    let y = TRACK + 0.05 * (PI * s).sin();
    Foot { joint: DVec3::new(x, y, z.max(FOOT_HEIGHT)), metatarsus, pitch, toes, closing: 0.14 * bump(s) }
}

/// Returns the metatarsal joint (x, z) and the pitch of a foot on the ground. The foot is flat at first, and then rolls over the fixed
/// joint of the middle toe.
fn stance(t: f64) -> [f64; 3] {
    let roll = ((t - HEEL_OFF) / (DUTY - HEEL_OFF)).max(0.0);
    let pitch = HEEL_LIFT.to_radians() * roll * roll;
    let [forward, down] = PIVOT;
    let (s, c) = pitch.sin_cos();
    let x = REACH - STRIDE * t + forward * (1.0 - c) - down * s;
    [x, FOOT_HEIGHT + forward * s + down * (1.0 - c), pitch]
}

/// Returns a smooth hump, which is one at ½. Outside `(0, 1)`, its value and slope are zero.
fn bump(s: f64) -> f64 {
    (PI * s.clamp(0.0, 1.0)).sin().powi(2)
}

/// Evaluates a cubic Hermite polynomial over `[t0, t1]` with values `a`, `b` and slopes `da`, `db`.
fn hermite(t: f64, t0: f64, t1: f64, a: f64, b: f64, da: f64, db: f64) -> f64 {
    primitive::hermite(a, b, da, db, t1 - t0, (t - t0) / (t1 - t0))
}

/// The tilt of the metatarsus (phase, degrees) at the knots of a periodic cubic spline with continuous second derivatives.
const METATARSUS: [(f64, f64); 8] =
    [(0.0, 22.0), (0.15, 34.0), (0.35, 32.0), (0.50, 14.0), (0.62, -22.0), (0.72, -52.0), (0.82, -40.0), (0.93, 8.0)];

/// The slopes of the metatarsus spline at its knots.
static SLOPES: LazyLock<[f64; 8]> = LazyLock::new(|| {
    let n = METATARSUS.len();
    let h = |i: usize| (METATARSUS[(i + 1) % n].0 - METATARSUS[i % n].0).rem_euclid(1.0);
    let secant = |i: usize| (METATARSUS[(i + 1) % n].1 - METATARSUS[i % n].1) / h(i);
    // The linear system for the slopes is diagonally dominant, so each Gauss–Seidel sweep at least halves the error.
    let mut slopes = [0.0; 8];
    for _ in 0..100 {
        for i in 0..n {
            let last = (i + n - 1) % n;
            let (before, after) = (h(last), h(i));
            let right = 3.0 * (after * secant(last) + before * secant(i));
            let neighbors = after * slopes[last] + before * slopes[(i + 1) % n];
            slopes[i] = (right - neighbors) / (2.0 * (before + after));
        }
    }
    slopes
});

/// Returns the tilt of the metatarsus in degrees at phase `t` in `[0, 1)`.
fn metatarsus(t: f64) -> f64 {
    let i = METATARSUS.partition_point(|&(knot, _)| knot <= t) - 1;
    let j = (i + 1) % METATARSUS.len();
    let ((begin, a), (end, b)) = (METATARSUS[i], METATARSUS[j]);
    hermite(t, begin, if j == 0 { end + 1.0 } else { end }, a, b, SLOPES[i], SLOPES[j])
}

/// A term of a joint angle: `amplitude · cos(2π · harmonic · (t − phase))` degrees. A term with harmonic 0 is constant.
struct Swing(&'static str, fn(&mut JointAngles) -> &mut f64, f64, f64, f64);

const ROLL: fn(&mut JointAngles) -> &mut f64 = |angles| &mut angles.roll;
const PITCH: fn(&mut JointAngles) -> &mut f64 = |angles| &mut angles.pitch;
const YAW: fn(&mut JointAngles) -> &mut f64 = |angles| &mut angles.yaw;

/// The terms of all joints except those of the legs. The terms of arms are for the left side.
#[rustfmt::skip]
const SWINGS: [Swing; 48] = [
    Swing("spine1", YAW, 1.0, -1.5, 0.53), Swing("spine1", ROLL, 1.0, -0.8, 0.29),
    Swing("spine2", YAW, 1.0, -1.5, 0.54), Swing("spine2", ROLL, 1.0, -0.8, 0.29),
    Swing("chest", YAW, 1.0, -1.4, 0.55), Swing("chest", ROLL, 1.0, -0.6, 0.30), Swing("chest", PITCH, 2.0, -0.5, 0.14),
    Swing("neck1", YAW, 1.0, 0.5, 0.55), Swing("neck1", PITCH, 2.0, 0.6, 0.20),
    Swing("neck2", YAW, 1.0, 0.3, 0.55), Swing("neck2", PITCH, 2.0, -0.8, 0.22),
    Swing("neck3", PITCH, 2.0, -0.5, 0.20),
    Swing("head", PITCH, 2.0, 0.3, 0.17), Swing("head", YAW, 1.0, -0.5, 0.52),
    Swing("jaw", PITCH, 0.0, -21.0, 0.0), Swing("jaw", PITCH, 1.0, 1.5, 0.30),
    Swing("arm_L", PITCH, 1.0, 5.0, 0.55), Swing("arm_L", PITCH, 0.0, 4.0, 0.0),
    Swing("elbow_L", PITCH, 1.0, 4.0, 0.62), Swing("wrist_L", PITCH, 1.0, 5.0, 0.70),
    Swing("tail1", YAW, 1.0, 1.4, 0.555), Swing("tail1", PITCH, 2.0, 0.3, 0.145), Swing("tail1", ROLL, 1.0, -0.25, 0.3),
    Swing("tail2", YAW, 1.0, 1.9, 0.610), Swing("tail2", PITCH, 2.0, 0.4, 0.190), Swing("tail2", ROLL, 1.0, -0.25, 0.3),
    Swing("tail3", YAW, 1.0, 2.4, 0.665), Swing("tail3", PITCH, 2.0, 0.5, 0.235), Swing("tail3", ROLL, 1.0, -0.25, 0.3),
    Swing("tail4", YAW, 1.0, 2.9, 0.720), Swing("tail4", PITCH, 2.0, 0.6, 0.280), Swing("tail4", ROLL, 1.0, -0.25, 0.3),
    Swing("tail5", YAW, 1.0, 3.3, 0.775), Swing("tail5", PITCH, 2.0, 0.7, 0.325),
    Swing("tail6", YAW, 1.0, 3.6, 0.830), Swing("tail6", PITCH, 2.0, 0.8, 0.370),
    Swing("tail7", YAW, 1.0, 3.8, 0.885), Swing("tail7", PITCH, 2.0, 0.9, 0.415),
    Swing("tail8", YAW, 1.0, 3.8, 0.940), Swing("tail8", PITCH, 2.0, 0.9, 0.460),
    // The right arm lags by half a cycle.
    Swing("arm_R", PITCH, 1.0, 5.0, 0.05), Swing("arm_R", PITCH, 0.0, 4.0, 0.0),
    Swing("elbow_R", PITCH, 1.0, 4.0, 0.12), Swing("wrist_R", PITCH, 1.0, 5.0, 0.20),
    // The eyes cancel the rotation of the head to keep the gaze ahead.
    Swing("eye_L", YAW, 1.0, 0.5, 0.52), Swing("eye_R", YAW, 1.0, 0.5, 0.52),
    Swing("eye_L", PITCH, 2.0, -0.3, 0.17), Swing("eye_R", PITCH, 2.0, -0.3, 0.17),
];

/// Returns the local rotations of all joints. The pelvis and the legs are at rest.
pub fn joint_angles(t: f64) -> [JointAngles; JOINT_COUNT] {
    let mut angles = [JointAngles::default(); JOINT_COUNT];
    for &Swing(joint, channel, harmonic, amplitude, phase) in &SWINGS {
        let own = &mut angles[joint_index(joint)];
        *channel(own) += (amplitude * (TAU * harmonic * (t - phase)).cos()).to_radians();
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rolling_foot_keeps_its_pivot() {
        for k in 0..=100 {
            let t = DUTY * f64::from(k) / 100.0;
            let [x, z, pitch] = stance(t);
            let (s, c) = pitch.sin_cos();
            // A positive pitch about y lowers the front.
            let px = x + c * PIVOT[0] + s * PIVOT[1] + STRIDE * t;
            let pz = z - s * PIVOT[0] + c * PIVOT[1];
            assert!((px - REACH - PIVOT[0]).abs() < 1e-12, "{t} {px}");
            assert!((pz - FOOT_HEIGHT - PIVOT[1]).abs() < 1e-12, "{t} {pz}");
        }
    }

    #[test]
    fn foot_path_has_no_jumps() {
        let n = 4000;
        for k in 0..n {
            let (a, b) = (foot(f64::from(k) / f64::from(n)), foot(f64::from(k + 1) / f64::from(n)));
            let moved = (b.joint - a.joint).length() * f64::from(n);
            assert!(moved < 12.0, "{k}: {moved} metres per cycle");
            assert!((b.metatarsus - a.metatarsus).abs() < 0.01 && (b.pitch - a.pitch).abs() < 0.01, "{k}");
            for i in 0..3 {
                assert!((b.toes[i] - a.toes[i]).abs() < 0.01, "{k} {i}");
            }
        }
    }
}
