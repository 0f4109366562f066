//! Signed distances to the primitives of the model, which are round cones, ellipsoids and lofts.
//!
//! All distances are of first order (the value divided by the length of the gradient). The distances are exact on the surface and accurate
//! near it.

use glam::{Mat3, Vec3};

use super::parts::{Frame, PartSpec, Shape};

/// The number of samples between two specified stations of a loft.
const SUBDIVISIONS: usize = 6;

/// The distance and the chain coordinate at a point.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The signed distance in metres, negative inside.
    pub distance: f32,
    /// The chain coordinate of a loft, the position along the axis of a cone in `[0, 1]`, or zero for an ellipsoid.
    pub chain: f32,
}

/// Returns a polynomial smooth minimum of radius `k`. The result is at most `a.min(b)`, and equals `a.min(b)` if `|a − b| ≥ k`.
#[inline]
pub fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0);
    a.min(b) - h * h / (4.0 * k)
}

/// One section of a densified loft. Sections are contiguous in memory, for scans over consecutive pairs.
#[derive(Clone, Copy, Debug)]
struct Station {
    center: Vec3,
    tangent: Vec3,
    u: Vec3,
    v: Vec3,
    half_width: f32,
    up: f32,
    down: f32,
    exponent: f32,
    chain: f32,
}

/// A primitive in model space that is ready to evaluate.
#[derive(Clone, Debug)]
pub enum Primitive {
    /// A loft of superelliptic sections along a curve.
    Loft(Loft),
    /// An ellipsoid, with a `local_from_model` rotation.
    Ellipsoid {
        /// A rotation whose rows are the local axes.
        rotation: Mat3,
        /// The centre of the ellipsoid.
        center: Vec3,
        /// The semi-axes of the ellipsoid in metres.
        radii: Vec3,
    },
    /// A capsule whose radius varies linearly.
    Cone {
        /// The first end of the axis.
        a: Vec3,
        /// The second end minus the first end.
        axis: Vec3,
        /// The radius at the first end.
        radius: f32,
        /// The second radius minus the first radius.
        growth: f32,
    },
}

/// The densified sections of a loft, and the lengths of its rounded ends.
#[derive(Clone, Debug)]
pub struct Loft {
    stations: Vec<Station>,
    caps: [f32; 2],
}

/// An axis-aligned bounding box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The low corner of the box.
    pub low: Vec3,
    /// The high corner of the box.
    pub high: Vec3,
}

impl Bounds {
    /// Returns the distance from `p` to the box, or zero inside the box.
    pub fn distance(&self, p: Vec3) -> f32 {
        (self.low - p).max(p - self.high).max(Vec3::ZERO).length()
    }
}

/// Returns the model-from-local rotation of an ellipsoid. The rotation is first about x, then about y (a positive angle lifts the +x end),
/// and then about z.
pub fn ellipsoid_rotation(degrees: [f32; 3]) -> Mat3 {
    let [x, y, z] = degrees.map(f32::to_radians);
    Mat3::from_rotation_z(z) * Mat3::from_rotation_y(-y) * Mat3::from_rotation_x(x)
}

impl Primitive {
    /// Transforms a part to model space, and returns it with its bounds.
    pub fn new(spec: &PartSpec) -> (Self, Bounds) {
        let frame = spec.space.frame();
        let s = frame.scale;
        match &spec.shape {
            Shape::Cone(a, b, ra, rb) => {
                let (a, b) = (frame.point(Vec3::from(*a)), frame.point(Vec3::from(*b)));
                let (ra, rb) = (ra * s, rb * s);
                let bounds = Bounds { low: (a - ra).min(b - rb), high: (a + ra).max(b + rb) };
                (Self::Cone { a, axis: b - a, radius: ra, growth: rb - ra }, bounds)
            }
            Shape::Ellipsoid(center, radii, degrees) => {
                let (center, radii) = (frame.point(Vec3::from(*center)), Vec3::from(*radii) * s);
                let rotation = frame.rotation * ellipsoid_rotation(*degrees);
                let scaled =
                    Mat3::from_cols(rotation.x_axis * radii.x, rotation.y_axis * radii.y, rotation.z_axis * radii.z)
                        .transpose();
                let extent = Vec3::new(scaled.x_axis.length(), scaled.y_axis.length(), scaled.z_axis.length());
                let bounds = Bounds { low: center - extent, high: center + extent };
                (Self::Ellipsoid { rotation: rotation.transpose(), center, radii }, bounds)
            }
            Shape::Loft(side, caps, stations) => {
                let loft = Loft::new(&frame, *side, *caps, stations);
                let bounds = loft.bounds();
                (Self::Loft(loft), bounds)
            }
        }
    }

    /// Returns the distance, over all pairs of stations of a loft (see [`Self::hit_in`]).
    pub fn hit(&self, p: Vec3) -> Hit {
        self.hit_in(p, 0, u16::MAX)
    }

    /// Returns the distance. Of a loft, only the stations `first..=last` are scanned. A rounded end counts only if its station is in the
    /// range. If no pair of the loft faces `p`, the distance is `f32::MAX`.
    #[inline]
    pub fn hit_in(&self, p: Vec3, first: u16, last: u16) -> Hit {
        match self {
            Self::Loft(loft) => loft.hit(p, first.into(), last.into()),
            Self::Ellipsoid { rotation, center, radii } => {
                let q = *rotation * (p - *center) / *radii;
                let (k0, k1) = (q.length(), (q / *radii).length());
                let distance = if k1 < 1e-9 { -radii.min_element() } else { k0 * (k0 - 1.0) / k1 };
                Hit { distance, chain: 0.0 }
            }
            Self::Cone { a, axis, radius, growth } => {
                let to = p - *a;
                let h = (to.dot(*axis) / axis.length_squared()).clamp(0.0, 1.0);
                Hit { distance: (to - *axis * h).length() - (radius + growth * h), chain: h }
            }
        }
    }

    /// Returns the ranges of stations that can face a point of the box, or `[0, 0]` for primitives without stations.
    pub fn facing(&self, bounds: &Bounds) -> Vec<[u16; 2]> {
        match self {
            Self::Loft(loft) => loft.facing(bounds),
            _ => vec![[0, 0]],
        }
    }
}

/// Returns the superellipse radius `F` at `(u, w)` in units of the half axes, and the length of its gradient.
#[inline]
fn superellipse(u: f32, w: f32, a: f32, b: f32, n: f32) -> (f32, f32) {
    if n < 2.01 {
        let f = (u * u + w * w).sqrt().max(1e-9);
        return (f, ((u / a).powi(2) + (w / b).powi(2)).sqrt() / f);
    }
    // |u|^(n−1) and |w|^(n−1) take one power each. The n-th powers then need one multiplication each.
    let (pu, pw) = (u.max(1e-9).powf(n - 1.0), w.max(1e-9).powf(n - 1.0));
    let sum = (pu * u + pw * w).max(1e-20);
    let f = sum.powf(1.0 / n);
    (f, f / sum * ((pu / a).powi(2) + (pw / b).powi(2)).sqrt())
}

/// Returns `(F − 1)/|∇F|` of one section. The value is bounded at the centre, where the gradient vanishes.
#[inline]
fn section(s: f32, v: f32, a: f32, b: f32, n: f32) -> f32 {
    let (f, gradient) = superellipse(s.abs() / a, v.abs() / b, a, b, n);
    if f < 1e-6 { -a.min(b) } else { (f - 1.0) / gradient.max(1e-6) }
}

impl Station {
    #[inline]
    fn cap(&self, offset: Vec3, axial: f32, cap: f32) -> f32 {
        let v = offset.dot(self.v);
        let b = if v > 0.0 { self.up } else { self.down };
        let a = self.half_width;
        let (f, gradient) = superellipse(offset.dot(self.u).abs() / a, v.abs() / b, a, b, self.exponent);
        let gradient = if f > 1e-6 { gradient } else { 0.0 };
        let a0 = axial / cap;
        let k0 = (a0 * a0 + f * f).sqrt() + 1e-9;
        let slope = ((a0 / cap).powi(2) + (f * gradient).powi(2)).sqrt() / k0 + 1e-9;
        (k0 - 1.0) / slope
    }
}

impl Loft {
    fn new(frame: &Frame, side: Vec3, caps: [f32; 2], stations: &[[f32; 8]]) -> Self {
        let rows = densify(stations);
        let centers: Vec<Vec3> =
            rows.iter().map(|row| frame.point(Vec3::new(row[0] as f32, row[1] as f32, row[2] as f32))).collect();
        let last = rows.len() - 1;
        let station = |(i, row): (usize, &[f64; 8])| {
            let tangent = (centers[(i + 1).min(last)] - centers[i.saturating_sub(1)]).normalize();
            let v = tangent.cross(frame.rotation * side).normalize();
            let [half_width, up, down] = [row[3], row[4], row[5]].map(|r| (r * f64::from(frame.scale)) as f32);
            let (exponent, chain) = (row[6] as f32, row[7] as f32);
            Station { center: centers[i], tangent, u: v.cross(tangent), v, half_width, up, down, exponent, chain }
        };
        Self { stations: rows.iter().enumerate().map(station).collect(), caps: caps.map(|c| c * frame.scale) }
    }

    fn bounds(&self) -> Bounds {
        let cap = self.caps[0].max(self.caps[1]);
        let mut bounds = Bounds { low: Vec3::MAX, high: Vec3::MIN };
        for s in &self.stations {
            let r = s.half_width.max(s.up).max(s.down) + cap;
            bounds.low = bounds.low.min(s.center - r);
            bounds.high = bounds.high.max(s.center + r);
        }
        bounds
    }

    #[inline]
    fn hit(&self, p: Vec3, first: usize, last: usize) -> Hit {
        let end = self.stations.len() - 1;
        let last = last.min(end);
        let mut best = Hit { distance: f32::MAX, chain: 0.0 };
        let mut consider = |distance: f32, chain: f32| {
            if distance < best.distance {
                best = Hit { distance, chain };
            }
        };
        let mut previous = 0.0;
        for j in first..=last {
            let station = &self.stations[j];
            let offset = p - station.center;
            let g = offset.dot(station.tangent);
            if j == 0 && g < 0.0 {
                consider(station.cap(offset, g, self.caps[0]), station.chain);
            }
            if j > first && previous >= 0.0 && g <= 0.0 {
                let before = &self.stations[j - 1];
                let t = previous / (previous - g + 1e-12);
                let mix = |a: f32, b: f32| a + t * (b - a);
                let offset = p - before.center.lerp(station.center, t);
                let s = offset.dot(before.u.lerp(station.u, t));
                let v = offset.dot(before.v.lerp(station.v, t));
                let b = if v > 0.0 { mix(before.up, station.up) } else { mix(before.down, station.down) };
                let a = mix(before.half_width, station.half_width);
                let distance = section(s, v, a, b, mix(before.exponent, station.exponent));
                consider(distance, mix(before.chain, station.chain));
            }
            if j == end && g > 0.0 {
                consider(station.cap(offset, g, self.caps[1]), station.chain);
            }
            previous = g;
        }
        best
    }

    fn facing(&self, bounds: &Bounds) -> Vec<[u16; 2]> {
        let (center, half) = ((bounds.low + bounds.high) * 0.5, (bounds.high - bounds.low) * 0.5);
        // The minimum and the maximum of the linear function g over the box.
        let range = |s: &Station| {
            let (mid, reach) = ((center - s.center).dot(s.tangent), half.dot(s.tangent.abs()) + 1e-5);
            (mid - reach, mid + reach)
        };
        let end = self.stations.len() - 1;
        let mut runs: Vec<[u16; 2]> = Vec::new();
        let mut push = |from: usize, to: usize| match runs.last_mut() {
            Some(run) if usize::from(run[1]) >= from => run[1] = run[1].max(to as u16),
            _ => runs.push([from as u16, to as u16]),
        };
        if range(&self.stations[0]).0 < 0.0 {
            push(0, 0);
        }
        for j in 1..=end {
            if range(&self.stations[j - 1]).1 >= 0.0 && range(&self.stations[j]).0 <= 0.0 {
                push(j - 1, j);
            }
        }
        if range(&self.stations[end]).1 > 0.0 {
            push(end, end);
        }
        runs
    }
}

/// Densifies stations. Centres are interpolated by Akima splines over chord length. All other values are interpolated by PCHIP, so that
/// radii do not overshoot.
fn densify(stations: &[[f32; 8]]) -> Vec<[f64; 8]> {
    let n = stations.len();
    let rows: Vec<[f64; 8]> = stations.iter().map(|r| r.map(f64::from)).collect();
    let mut x = vec![0.0; n];
    for i in 1..n {
        let d: f64 = (0..3).map(|c| (rows[i][c] - rows[i - 1][c]).powi(2)).sum();
        x[i] = x[i - 1] + d.sqrt();
    }
    let mut out = vec![[0.0; 8]; (n - 1) * SUBDIVISIONS + 1];
    for c in 0..8 {
        let y: Vec<f64> = rows.iter().map(|r| r[c]).collect();
        let slopes = if c < 3 && n > 2 { akima_slopes(&x, &y) } else { pchip_slopes(&x, &y) };
        for (k, row) in out.iter_mut().enumerate() {
            let i = (k / SUBDIVISIONS).min(n - 2);
            let t = (k - i * SUBDIVISIONS) as f64 / SUBDIVISIONS as f64;
            row[c] = hermite(y[i], y[i + 1], slopes[i], slopes[i + 1], x[i + 1] - x[i], t);
        }
    }
    out
}

/// Evaluates a cubic Hermite polynomial at `t` in `[0, 1]` between two values with slopes `da`, `db` over an interval of length `h`.
pub fn hermite(a: f64, b: f64, da: f64, db: f64, h: f64, t: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + b * (3.0 * t2 - 2.0 * t3) + h * (da * (t3 - 2.0 * t2 + t) + db * (t3 - t2))
}

fn secants(x: &[f64], y: &[f64]) -> Vec<f64> {
    (1..x.len()).map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1])).collect()
}

/// Returns the slopes of Akima's spline (J. ACM 17, 1970). At the ends, the secants are continued linearly, as in the paper.
fn akima_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let inner = secants(x, y);
    let k = inner.len();
    let (a, b) = (2.0 * inner[0] - inner[1], 2.0 * inner[k - 1] - inner[k - 2]);
    let mut m = vec![2.0 * a - inner[0], a];
    m.extend_from_slice(&inner);
    m.extend([b, 2.0 * b - inner[k - 1]]);
    let weights: Vec<(f64, f64)> =
        (0..x.len()).map(|i| ((m[i + 3] - m[i + 2]).abs(), (m[i + 1] - m[i]).abs())).collect();
    let largest = weights.iter().map(|w| w.0 + w.1).fold(0.0, f64::max);
    (0..x.len())
        .map(|i| {
            let (after, before) = weights[i];
            if after + before > 1e-9 * largest {
                (after * m[i + 1] + before * m[i + 2]) / (after + before)
            } else {
                0.5 * (m[i + 1] + m[i + 2])
            }
        })
        .collect()
}

/// Returns the slopes of the monotone cubic of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984).
fn pchip_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let m = secants(x, y);
    let n = x.len();
    if n == 2 {
        return vec![m[0]; 2];
    }
    let h: Vec<f64> = (1..n).map(|i| x[i] - x[i - 1]).collect();
    // The estimate is one-sided, from three points, and limited so that the end remains monotone.
    let end = |h0: f64, h1: f64, m0: f64, m1: f64| {
        let d = ((2.0 * h0 + h1) * m0 - h0 * m1) / (h0 + h1);
        if d * m0 <= 0.0 {
            0.0
        } else if m0 * m1 < 0.0 && d.abs() > 3.0 * m0.abs() {
            3.0 * m0
        } else {
            d
        }
    };
    let mut d = vec![0.0; n];
    d[0] = end(h[0], h[1], m[0], m[1]);
    d[n - 1] = end(h[n - 2], h[n - 3], m[n - 2], m[n - 3]);
    for i in 1..n - 1 {
        if m[i - 1] * m[i] > 0.0 {
            let (w1, w2) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
            d[i] = (w1 + w2) / (w1 / m[i - 1] + w2 / m[i]);
        }
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trex::parts::GROUPS;

    #[test]
    fn radii_stay_between_their_stations() {
        for part in GROUPS.iter().flat_map(|g| g.parts) {
            let Shape::Loft(_, _, stations) = &part.shape else { continue };
            for (k, row) in densify(stations).iter().enumerate() {
                let i = (k / SUBDIVISIONS).min(stations.len() - 2);
                for c in 3..8 {
                    let (a, b) = (f64::from(stations[i][c]), f64::from(stations[i + 1][c]));
                    assert!(row[c] >= a.min(b) - 1e-9 && row[c] <= a.max(b) + 1e-9, "{} {k} {c}", part.name);
                }
            }
        }
    }

    #[test]
    fn distances_have_unit_slope_at_the_surface() {
        for part in GROUPS.iter().flat_map(|g| g.parts) {
            let (primitive, bounds) = Primitive::new(part);
            // The march goes from an inside point to an outside point, and the slope is checked where the sign changes.
            let center = (bounds.low + bounds.high) * 0.5;
            let f = |p: Vec3| primitive.hit(p).distance;
            let (mut inside, mut outside) = (center, bounds.high + 0.5);
            if f(inside) >= 0.0 {
                continue;
            }
            for _ in 0..40 {
                let mid = (inside + outside) * 0.5;
                if f(mid) < 0.0 { inside = mid } else { outside = mid }
            }
            let e = 1e-3;
            let d = |a: Vec3| (f(inside + a * e) - f(inside - a * e)) / (2.0 * e);
            let slope = Vec3::new(d(Vec3::X), d(Vec3::Y), d(Vec3::Z)).length();
            assert!((0.75..1.35).contains(&slope), "{} {slope}", part.name);
        }
    }
}
