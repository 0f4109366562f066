//! The displacement, albedo and roughness of the skin, as functions of the rest position.
//!
//! The skin is symmetric, because `y` is folded. The layers of the skin are pebble scales of three sizes, scattered feature scales, folds
//! by zone, slack skin, scutes on the feet, and labial scales along the lips.

use glam::Vec3;

use super::noise::{value, worley};
use super::parts::{Frame, Space};
use leadr_maps::noise::smoothstep as ss;

/// A ball of skin with wrinkles, which are rounded ridges across `direction`.
#[derive(Clone, Copy, Debug)]
struct Fold {
    centre: Vec3,
    radius: f32,
    direction: Vec3,
    wavelength: f32,
    amplitude: f32,
}

const fn fold(c: [f32; 3], radius: f32, d: [f32; 3], wavelength: f32, amplitude: f32) -> Fold {
    Fold { centre: Vec3::from_array(c), radius, direction: Vec3::from_array(d), wavelength, amplitude }
}

/// The zones of folds for `y ≥ 0`, in metres.
const FOLDS: [Fold; 18] = [
    fold([2.55, 0.20, 2.90], 0.62, [0.75, 0.0, 0.66], 0.155, 0.014), // lower neck
    fold([3.00, 0.10, 3.35], 0.50, [0.45, 0.0, 0.89], 0.120, 0.011), // throat
    fold([3.35, 0.22, 3.85], 0.32, [0.90, 0.0, 0.30], 0.085, 0.007), // nape to head
    fold([3.45, 0.25, 3.70], 0.25, [0.80, 0.0, 0.60], 0.060, 0.006), // jaw corner
    fold([2.02, 0.52, 2.25], 0.33, [0.30, 0.2, 0.93], 0.075, 0.008), // armpit
    fold([0.72, 0.50, 2.45], 0.48, [0.93, 0.0, -0.35], 0.150, 0.018), // flank before the thigh
    fold([0.60, 0.52, 1.70], 0.30, [0.55, 0.0, 0.83], 0.075, 0.008), // knee, front
    fold([0.30, 0.52, 1.72], 0.24, [0.30, 0.0, 0.95], 0.065, 0.009), // knee, back
    fold([-0.05, 0.44, 0.70], 0.24, [0.35, 0.0, 0.93], 0.055, 0.006), // ankle
    fold([0.22, 0.38, 0.18], 0.26, [1.00, 0.0, 0.20], 0.050, 0.005), // toe root
    fold([-0.62, 0.40, 2.55], 0.50, [0.92, 0.0, 0.38], 0.170, 0.013), // tail base
    fold([1.35, 0.62, 2.78], 0.75, [1.00, 0.0, 0.28], 0.235, 0.015), // ribs
    fold([-0.05, 0.62, 2.55], 0.55, [0.80, 0.0, 0.60], 0.200, 0.010), // thigh muscle slips
    fold([0.50, 0.25, 2.05], 0.45, [1.00, 0.0, 0.0], 0.120, 0.008),  // groin
    fold([1.15, 0.60, 2.35], 0.55, [0.55, 0.0, -0.83], 0.210, 0.017), // slack flank
    fold([1.30, 0.15, 1.92], 0.70, [1.00, 0.0, 0.10], 0.095, 0.007), // gastralia
    fold([2.25, 0.10, 2.20], 0.50, [0.55, 0.0, 0.83], 0.130, 0.012), // breast
    fold([-1.60, 0.25, 2.45], 0.60, [1.00, 0.0, 0.10], 0.140, 0.007), // underside of the tail
];
/// The ridge of the shoulder blade under the skin, from top to bottom.
const SCAPULA: [Vec3; 2] = [Vec3::new(1.42, 0.50, 3.06), Vec3::new(2.02, 0.56, 2.40)];
/// The centre of the eyeball in the head frame.
const EYE: Vec3 = Vec3::new(0.418, 0.282, 0.150);
/// The centre of the nostril in the head frame.
const NOSTRIL: Vec3 = Vec3::new(1.20, 0.145, 0.030);
/// The points `(x, z)` of the lip lines in the frames of head and jaw.
const UPPER_LIP: [[f32; 2]; 7] =
    [[0.16, -0.225], [0.36, -0.255], [0.56, -0.290], [0.80, -0.310], [1.02, -0.280], [1.18, -0.235], [1.31, -0.205]];
const LOWER_LIP: [[f32; 2]; 5] = [[0.20, -0.040], [0.42, -0.035], [0.66, -0.030], [0.90, -0.028], [1.20, -0.030]];

fn line(points: &[[f32; 2]], x: f32) -> f32 {
    let span = points.windows(2).find(|w| x <= w[1][0]).unwrap_or(&points[points.len() - 2..]);
    let t = ((x - span[0][0]) / (span[1][0] - span[0][0])).clamp(0.0, 1.0);
    span[0][1] + (span[1][1] - span[0][1]) * t
}

fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a + (b - a) * t
}

/// Returns the profile of a ridge with sharp valleys. The mean is close to zero, and the range is about `[-0.65, 0.35]`.
fn ridge(phase: f32) -> f32 {
    (std::f32::consts::PI * phase).sin().abs().powf(0.7) - 0.65
}

/// Evaluates the skin, using the frames of head and jaw.
pub struct Skin {
    head: Frame,
    jaw: Frame,
}

/// The inputs for the shading of a point, in addition to its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    /// The displacement along the surface normal in metres (about -16 to 22 mm).
    pub height: f32,
    /// The position on a scale, from 0 in the grooves to 1 on top.
    pub top: f32,
    /// The depth of folds, from 0 (none) to 1 (bottom of a deep valley).
    pub fold: f32,
}

/// The weights of facial details around the eye, the nostril and the lips, from the position in the head frame.
struct Face {
    head: f32,
    eye: f32,
    nostril: f32,
    upper: f32,
    lower: f32,
    lip_x: f32,
}

impl Skin {
    /// Creates a skin for the animal in its bind pose.
    pub fn new() -> Self {
        Self { head: Space::Head.frame(), jaw: Space::Jaw.frame() }
    }

    fn face(&self, p: Vec3) -> Face {
        let head = ss(3.25, 3.6, p.x);
        let mut face = Face { head, eye: 1.0, nostril: 1.0, upper: 0.0, lower: 0.0, lip_x: 0.0 };
        if p.x < 3.4 {
            return face;
        }
        let (h, j) = (self.head.local(p), self.jaw.local(p));
        face.eye = h.distance(EYE);
        let n = (h - NOSTRIL) / Vec3::new(1.3, 1.0, 0.8);
        face.nostril = n.length();
        let band = |d: f32| (-(d / 0.030) * (d / 0.030)).exp();
        let (u, l) = (h.z - line(&UPPER_LIP, h.x), j.z - line(&LOWER_LIP, j.x));
        // The lower jaw is in front of its hinge, and clearly below the line of the upper lip.
        face.upper = band(u - 0.012) * ss(0.15, 0.3, h.x) * ss(-0.06, -0.02, u);
        face.lower = band(l + 0.012) * ss(0.2, 0.35, j.x) * ss(-0.05, -0.10, u).max(1.0 - ss(-0.12, -0.06, u));
        face.lip_x = if face.upper > face.lower { h.x } else { j.x + 0.02 };
        face
    }

    /// Returns the relief at the rest position `p` on the surface. `mouth` in `[0, 1]` smooths the lining of the mouth.
    pub fn relief(&self, p: Vec3, mouth: f32) -> SkinPoint {
        let p = Vec3::new(p.x, p.y.abs(), p.z);
        let face = self.face(p);
        let (head, foot, tail) = (face.head, 1.0 - ss(0.5, 1.1, p.z), ss(2.0, 5.5, -p.x));
        let fine = head.max(0.8 * foot).max(0.7 * tail);
        let coarse = (1.0 - fine) * ss(2.3, 3.1, p.z);
        let sizes = [(0.021, fine), (0.034, (1.0 - fine - coarse).max(0.0)), (0.052, coarse)];
        // Scales fade near the eye and the mouth, because shrunken scales would look like knitwear.
        let warp = Vec3::new(value(p * 9.0, 1), value(p * 9.0, 2), value(p * 9.0, 3)) - 0.5;
        let warped = p + 0.018 * warp;
        let lips = face.upper.max(face.lower);
        let (scutes, scute) = scutes(p, foot);
        let quiet = (1.0 - 0.55 * lips) * (1.0 - 0.75 * scutes) * (1.0 - 0.6 * (1.0 - ss(0.05, 0.09, face.eye)));
        let (mut pebbles, mut top) = (0.0, 0.0);
        for (i, (size, weight)) in sizes.into_iter().enumerate().filter(|(_, s)| s.1 >= 0.02) {
            let w = worley(warped / size, 3 * i as u32 + 1);
            let edge = ss(0.02, 0.38, w.f2 - w.f1);
            // The tops of scales are slightly domed, so that they do not look like flat tiles.
            let crown = 0.82 + 0.18 * (1.0 - (w.f1 / 0.6).min(1.0));
            pebbles += weight * size * 0.095 * edge * crown * (0.75 + 0.5 * w.id);
            top += weight * edge;
        }
        let feature = worley(warped / 0.115, 41);
        let dorsal = ss(3.25, 3.45, p.z) * (1.0 - head) * ss(-0.12, 0.0, 0.12 - p.y);
        let brow = head * ss(4.12, 4.22, p.z);
        let kept = ss(0.0, 0.03, feature.id - (0.62 - 0.35 * dorsal.max(brow)));
        let near_face = ss(0.08, 0.16, face.eye) * ss(0.04, 0.10, face.nostril);
        let bosses = kept
            * near_face
            * (1.0 - 0.7 * foot)
            * (0.0065 + 0.006 * dorsal.max(brow))
            * (1.0 - ss(0.16, 0.34, feature.f1));
        let (mut folds, mut valley) = (0.0, 0.0_f32);
        for (m, zone) in FOLDS.iter().enumerate() {
            let d = p - zone.centre;
            let r2 = d.length_squared() / (zone.radius * zone.radius);
            if r2 >= 1.0 {
                continue;
            }
            let w = (1.0 - r2) * (1.0 - r2);
            let phase = d.dot(zone.direction) / zone.wavelength
                + 1.1 * (value(p * 4.0, 11 + m as u32) - 0.5)
                + 0.35 * (value(p * 12.0, 51 + m as u32) - 0.5);
            let profile = ridge(phase);
            folds += zone.amplitude * w * profile;
            valley = valley.max(w * (-0.15 - profile).max(0.0) * 2.0);
        }
        let slack = 0.012 * (value(p * 3.1, 91) - 0.5) * (1.0 - head) + 0.004 * (value(p * 11.0, 92) - 0.5);
        let mut height = pebbles * quiet + bosses + folds + slack + scute + scapula(p);
        // Wrinkles surround the eye and the nostril. A row of labial scales lines the lips.
        let rings = 0.0022 * (1.0 - ss(0.07, 0.15, face.eye)) * ss(0.045, 0.06, face.eye);
        height += rings * (value(p * 14.0, 93) * 2.0 + face.eye / 0.016 * std::f32::consts::TAU).sin();
        height += 0.005 * ((-((face.nostril - 0.058) / 0.016).powi(2)).exp());
        let labial = ridge(face.lip_x / 0.044 + 0.5 * (value(p * 17.0, 94) - 0.5));
        height += lips * (0.0075 * labial + 0.003);
        top = (top * quiet).max(scutes * 0.8).max(lips * (labial + 0.65));
        let pit = 1.0 - ss(0.040, 0.056, face.nostril);
        height *= (1.0 - 0.85 * mouth) * (1.0 - 0.8 * pit);
        SkinPoint { height, top, fold: valley.min(1.0) }
    }

    /// Returns the linear albedo (rgb) and the Beckmann roughness `α` at the rest position `p` with this relief.
    ///
    /// The roughness values in the code are perceptual, and `α` is their square. There are no inter-reflections, so cavities (grooves
    /// between scales, folds) have a darker albedo instead.
    pub fn shade(&self, p: Vec3, relief: &SkinPoint, mouth: f32) -> [f32; 4] {
        let p = Vec3::new(p.x, p.y.abs(), p.z);
        let (n1, n2, n3) = (value(p * 2.1, 61), value(p * 7.0, 62), value(p * 23.0, 63));
        let face = self.face(p);
        let h = relief.height;
        let mut back = ss(2.35, 3.25, p.z + 0.5 * (n1 - 0.5));
        back += (ss(2.40, 2.80, p.z + 0.3 * (n1 - 0.5)) - back) * ss(0.4, 2.0, -p.x);
        back += (ss(3.45, 3.95, p.z + 0.2 * (n1 - 0.5)) - back) * ss(2.6, 3.5, p.x);
        let mut c = mix(Vec3::new(0.300, 0.225, 0.140), Vec3::new(0.105, 0.082, 0.052), back);
        c = mix(c, Vec3::new(0.150, 0.115, 0.080), 0.55 * (1.0 - ss(1.2, 2.3, p.z)));
        let stripes = 0.5 + 0.5 * (4.6 * p.x + 2.6 * (n1 - 0.5) + 1.5 * (n2 - 0.5)).sin();
        let band =
            ss(0.50, 0.78, stripes) * ss(2.55, 3.1, p.z + 0.24 * (-p.x - 1.0).max(0.0)) * (1.0 - ss(3.0, 3.4, p.x));
        c *= 1.0 - 0.45 * band;
        let crest = ss(3.5, 3.8, p.x) * ss(4.10, 4.30, p.z);
        c = mix(c, Vec3::new(0.20, 0.075, 0.045), 0.6 * crest);
        c *= 1.25 * (0.72 + 0.35 * n2 + 0.22 * n3) * (0.72 + 0.28 * ss(-0.006, 0.008, h));
        // The height gives the broad occlusion of cavities, and the grooves give the sharp occlusion.
        c *= (0.70 + 0.30 * ((h + 0.006) / 0.012).clamp(0.0, 1.0)) * (0.62 + 0.38 * relief.top.min(1.0));
        c *= 1.0 - 0.35 * relief.fold;
        // The skin is dark around the eye and inside the nostril, and paler on the lips.
        c *= 1.0 - 0.6 * (1.0 - ss(0.055, 0.10, face.eye));
        let inside = 1.0 - ss(0.042, 0.062, face.nostril);
        c *= 1.0 - 0.92 * inside;
        let lips = face.upper.max(face.lower);
        c = mix(c, c * Vec3::new(1.15, 1.0, 0.95), lips);
        let mud = (1.0 - ss(0.05, 0.30, p.z)) * ss(0.35, 0.6, n2 * 0.5 + n1 * 0.5);
        c = mix(c, Vec3::new(0.075, 0.058, 0.040), 0.5 * mud);
        // The lining of the mouth is wet and slightly mottled. The lining fades into the lips at the gum line.
        let lining = Vec3::new(0.42, 0.13, 0.12) * (0.75 + 0.3 * n3 + 0.2 * n2);
        let gum = 4.0 * mouth * (1.0 - mouth);
        c = mix(mix(c, lining, mouth), Vec3::new(0.17, 0.055, 0.05), 0.7 * gum);
        let mut rough = 0.62 - 0.14 * ss(0.2, 0.9, relief.top) + 0.16 * (1.0 - ss(0.0, 0.5, relief.top));
        rough += 0.10 * relief.fold + 0.06 * (n3 - 0.5) + 0.10 * mud;
        let soft = lips.max(1.0 - ss(0.06, 0.10, face.eye)).max(1.0 - ss(0.05, 0.09, face.nostril));
        rough += (0.45 - rough) * soft;
        // The wall of the nostril is too steep for displacement, so its roughness is high to suppress glints.
        rough += (0.85 - rough) * inside;
        rough += (0.27 - rough) * mouth;
        let rough = rough.clamp(0.2, 0.85);
        [c.x.clamp(0.004, 0.9), c.y.clamp(0.004, 0.9), c.z.clamp(0.004, 0.9), rough * rough]
    }
}

/// Returns the weight and the height (in metres) of the scutes on the toes and down the front of the metatarsus.
fn scutes(p: Vec3, foot: f32) -> (f32, f32) {
    if foot <= 0.0 || p.x < -0.1 {
        return (0.0, 0.0);
    }
    let along = ((p.x - 0.10).powi(2) + (p.y - 0.42).powi(2)).sqrt();
    // The metatarsus axis in the xz plane runs from (-0.07, 0.74) to (0.20, 0.17).
    let axis_x = -0.07 + 0.27 * ((0.74 - p.z) / 0.57);
    let toes = ss(0.20, 0.30, along) * ss(0.075, 0.11, p.z) * (1.0 - ss(0.17, 0.24, p.z));
    let shin = ss(0.03, 0.08, p.x - axis_x) * ss(0.19, 0.26, p.z) * (1.0 - ss(0.60, 0.75, p.z));
    let (weight, phase) = if toes > shin { (toes, along / 0.040) } else { (shin, p.z / 0.042) };
    let ruffle = 0.5 * (value(p * 15.0, 95) - 0.5);
    let mut height = weight * 0.006 * (ridge(phase + ruffle) + 0.3);
    // Knuckle creases mark the joints between phalanges.
    for joint in [0.34_f32, 0.50, 0.64] {
        let d = (along - joint + 0.02 * (value(p * 9.0, 96) - 0.5)) / 0.008;
        height -= toes * 0.004 * (-d * d).exp();
    }
    (weight, height)
}

/// Returns the relief of the shoulder blade in metres.
fn scapula(p: Vec3) -> f32 {
    let [a, b] = SCAPULA;
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    let d = (p - a.lerp(b, t)).length();
    0.020 * (1.0 - ss(0.03, 0.15, d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trex::noise::{hash, unit};

    #[test]
    fn relief_and_colour_stay_in_their_ranges_and_are_symmetric() {
        let skin = Skin::new();
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for i in 0..30_000 {
            let t = |k| unit(hash(i, k, 0, 9));
            let p = Vec3::new(-6.7 + 11.6 * t(0), -0.8 + 1.6 * t(1), 4.3 * t(2));
            let mouth = if i % 5 == 0 { t(3) } else { 0.0 };
            let relief = skin.relief(p, mouth);
            assert_eq!(relief, skin.relief(p * Vec3::new(1.0, -1.0, 1.0), mouth));
            (low, high) = (low.min(relief.height), high.max(relief.height));
            let c = skin.shade(p, &relief, mouth);
            assert!(c.iter().all(|v| *v > 0.0 && *v < 1.0), "{c:?} at {p}");
        }
        println!("height {low} .. {high}");
        assert!(low > -0.035 && low < -0.004 && high > 0.012 && high < 0.045, "{low} {high}");
    }

    #[test]
    fn scales_are_finer_on_the_head_than_on_the_back() {
        let skin = Skin::new();
        // For fine patterns, the mean absolute second difference over 5 mm is high.
        let busy = |from: Vec3| -> f32 {
            let h = |i: i32| skin.relief(from + Vec3::X * (i as f32 * 0.005), 0.0).top;
            (0..120).map(|i| (h(i) - 2.0 * h(i + 1) + h(i + 2)).abs()).sum()
        };
        assert!(busy(Vec3::new(4.0, 0.05, 4.1)) > 1.3 * busy(Vec3::new(0.0, 0.3, 3.5)));
    }
}
