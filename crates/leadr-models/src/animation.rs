//! Animations. A curve gives values over time, and drives a property of a node.

use glam::Quat;

/// An animation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// The name, or an empty string.
    pub name: String,
    /// The animated properties. Each property of a node occurs at most once.
    pub channels: Vec<Channel>,
    /// The curves that the channels refer to.
    pub curves: Vec<Curve>,
    /// The time of the last key in seconds.
    pub duration: f32,
}

/// A property of a node that follows a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The index of the node.
    pub node: usize,
    /// The animated property.
    pub property: Property,
    /// The index in the animation's list of curves.
    pub curve: usize,
}

/// An animated node property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Property {
    /// The translation, as 3 numbers in metres.
    Translation,
    /// The rotation, as the 4 numbers of a unit quaternion x y z w.
    Rotation,
    /// The scale, as 3 factors.
    Scale,
    /// The morph weights, with one number per target of the node's mesh.
    Weights,
}

impl Property {
    /// Returns the property of this name in glTF.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "translation" => Self::Translation,
            "rotation" => Self::Rotation,
            "scale" => Self::Scale,
            "weights" => Self::Weights,
            _ => return None,
        })
    }
}

/// How values between keys are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The value is constant from each key to the next.
    Step,
    /// Values are interpolated linearly. Rotations take the shorter arc at constant speed.
    #[default]
    Linear,
    /// Values follow a cubic Hermite spline. Rotations are normalised.
    Cubic,
}

/// A curve of values over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// How values between keys are interpolated.
    pub interpolation: Interpolation,
    /// The times of the keys in seconds, in order. There is at least one key. If two keys have the same time, the value jumps.
    pub times: Vec<f32>,
    /// How many numbers form a value.
    pub width: usize,
    /// The values at the keys. Each key of a cubic curve has three: the in-tangent per second, the value, and the
    /// out-tangent per second.
    pub values: Vec<f32>,
}

impl Curve {
    /// Returns the value at a time as `width` numbers. Before the first key and after the last key the value is constant.
    /// Rotations are normalised.
    ///
    /// # Panics
    /// Panics if `rotation` is set for a curve without four numbers per value.
    pub fn sample(&self, seconds: f32, rotation: bool) -> Vec<f32> {
        assert!(!rotation || self.width == 4, "a rotation of {} numbers", self.width);
        let last = self.times.len() - 1;
        // This comparison maps NaN to the first key.
        let after = self.times.partition_point(|&t| t <= seconds);
        if after == 0 || after > last {
            return self.unit(self.value(if after == 0 { 0 } else { last }).to_vec(), rotation);
        }
        let (start, end) = (self.times[after - 1], self.times[after]);
        // The fraction is 0 at the previous key and 1 at the next key.
        let part = (seconds - start) / (end - start);
        let [before, next] = [after - 1, after].map(|key| self.value(key));
        let value = match self.interpolation {
            Interpolation::Step => before.to_vec(),
            // glam's `slerp` takes the shorter arc.
            Interpolation::Linear if rotation => {
                Quat::from_slice(before).slerp(Quat::from_slice(next), part).to_array().to_vec()
            }
            Interpolation::Linear => before.iter().zip(next).map(|(a, b)| a + (b - a) * part).collect(),
            Interpolation::Cubic => self.spline(after - 1, part, end - start),
        };
        self.unit(value, rotation)
    }

    fn value(&self, key: usize) -> &[f32] {
        match self.interpolation {
            Interpolation::Cubic => self.third(3 * key + 1),
            Interpolation::Step | Interpolation::Linear => self.third(key),
        }
    }

    fn third(&self, number: usize) -> &[f32] {
        &self.values[number * self.width..][..self.width]
    }

    /// Interpolates between a key and the next key, which is `seconds` later.
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
        // A spline may pass through zero, where the rotation is arbitrary.
        let unit = if length > 1e-20 && length.is_finite() { quaternion / length } else { Quat::IDENTITY };
        unit.to_array().to_vec()
    }
}
