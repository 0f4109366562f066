//! Motions: curves over time and the properties of nodes that follow them.

use glam::Quat;

/// A motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Its name, empty if it has none.
    pub name: String,
    /// What moves; no property of a node twice.
    pub channels: Vec<Channel>,
    /// The curves that channels follow.
    pub curves: Vec<Curve>,
    /// Time of the last key, seconds.
    pub duration: f32,
}

/// A property of a node that follows a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The node.
    pub node: usize,
    /// What of it moves.
    pub property: Property,
    /// The curve, in the animation's list.
    pub curve: usize,
}

/// What of a node moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Property {
    /// 3 numbers: metres.
    Translation,
    /// 4 numbers: a quaternion of unit length, x y z w.
    Rotation,
    /// 3 numbers: factors.
    Scale,
    /// As many numbers as the node's mesh has morph targets.
    Weights,
}

/// How a curve gets from key to key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// It stays at a key's value up to the next key.
    Step,
    /// Straight; rotations go the short way round at constant speed.
    #[default]
    Linear,
    /// A cubic Hermite spline, whose rotations are brought back to unit length.
    Cubic,
}

/// Values over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// How it gets from key to key.
    pub interpolation: Interpolation,
    /// Seconds, 0 or more, increasing, at least one.
    pub times: Vec<f32>,
    /// Numbers of a value.
    pub width: usize,
    /// A value per key; of cubic curves three per key: in-tangent per second, value, out-tangent per second.
    pub values: Vec<f32>,
}

impl Curve {
    /// The value at a time, `width` numbers; before the first and after the last key that key's. Rotations are of unit length.
    ///
    /// # Panics
    /// If `rotation` is asked of a curve whose values do not have four numbers.
    pub fn sample(&self, seconds: f32, rotation: bool) -> Vec<f32> {
        assert!(!rotation || self.width == 4, "a rotation of {} numbers", self.width);
        let last = self.times.len() - 1;
        // The order of the comparison sends NaN to the first key.
        let after = self.times.partition_point(|&t| t <= seconds);
        if after == 0 || after > last {
            return self.unit(self.value(if after == 0 { 0 } else { last }).to_vec(), rotation);
        }
        let (start, end) = (self.times[after - 1], self.times[after]);
        // 0 at the key before, 1 at the one after.
        let part = (seconds - start) / (end - start);
        let [before, next] = [after - 1, after].map(|key| self.value(key));
        let value = match self.interpolation {
            Interpolation::Step => before.to_vec(),
            // `slerp` of glam takes the short way.
            Interpolation::Linear if rotation => {
                Quat::from_slice(before).slerp(Quat::from_slice(next), part).to_array().to_vec()
            }
            Interpolation::Linear => before.iter().zip(next).map(|(a, b)| a + (b - a) * part).collect(),
            Interpolation::Cubic => self.spline(after - 1, part, end - start),
        };
        self.unit(value, rotation)
    }

    /// The value of a key.
    fn value(&self, key: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::Cubic => self.third(3 * key + 1),
            Interpolation::Step | Interpolation::Linear => self.third(key),
        }
    }

    fn third(&self, number: usize) -> &[f32] {
        &self.values[number * self.width..][..self.width]
    }

    /// Between a key and the next, which are so many seconds apart.
    fn spline(&self, key: usize, t: f32, seconds: f32) -> Vec<f32> {
        let (t2, t3) = (t * t, t * t * t);
        let (from, leave) = (2.0 * t3 - 3.0 * t2 + 1.0, (t3 - 2.0 * t2 + t) * seconds);
        let (to, arrive) = (3.0 * t2 - 2.0 * t3, (t3 - t2) * seconds);
        let number = |i: usize| {
            from * self.third(3 * key + 1)[i]
                + leave * self.third(3 * key + 2)[i]
                + to * self.third(3 * key + 4)[i]
                + arrive * self.third(3 * key + 3)[i]
        };
        (0..self.width).map(number).collect()
    }

    fn unit(&self, value: Vec<f32>, rotation: bool) -> Vec<f32> {
        if !rotation {
            return value;
        }
        let quaternion = Quat::from_slice(&value);
        let length = quaternion.length();
        // A spline may pass through zero, where no rotation is better than another.
        let unit = if length > 1e-20 && length.is_finite() { quaternion / length } else { Quat::IDENTITY };
        unit.to_array().to_vec()
    }
}
