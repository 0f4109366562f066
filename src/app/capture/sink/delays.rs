//! How long each frame of a moving picture is shown, in the whole units of its format.

use crate::app::flags::values::Rate;

/// Delays of frames in `1 / units` of a second. What rounding takes from one frame a later one gets back, so the whole is
/// never off by more than half a unit.
#[derive(Debug)]
pub struct Delays {
    rate: Rate,
    units: u32,
    frame: u64,
}

impl Delays {
    /// Frames at `rate`, in units of `1 / units` of a second.
    pub fn new(rate: Rate, units: u32) -> Self {
        Self { rate, units, frame: 0 }
    }

    /// The moment at which a frame begins, rounded to units.
    fn start(&self, frame: u64) -> u64 {
        let (over, under) = (u128::from(self.rate.numerator()), u128::from(self.rate.denominator()));
        let doubled = 2 * u128::from(frame) * u128::from(self.units) * under;
        ((doubled + over) / (2 * over)) as u64
    }
}

impl Iterator for Delays {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let start = self.start(self.frame);
        self.frame += 1;
        Some(self.start(self.frame) - start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_does_not_add_up() {
        for (rate, units) in [("24", 100), ("30", 100), ("30000/1001", 1000), ("48", 100), ("0.7", 1000)] {
            let rate: Rate = rate.parse().unwrap();
            let (mut sum, mut shortest, mut longest) = (0, u64::MAX, 0);
            for (count, delay) in (1..=1000).zip(Delays::new(rate, units)) {
                sum += delay;
                (shortest, longest) = (shortest.min(delay), longest.max(delay));
                let exact = f64::from(count) * f64::from(units) / rate.per_second();
                assert!((sum as f64 - exact).abs() <= 0.5 + 1e-9, "{rate:?}: {sum} {exact}");
            }
            assert!(longest - shortest <= 1, "{rate:?}: {shortest} {longest}");
        }
        let second: Vec<_> = Delays::new("24".parse().unwrap(), 100).take(24).collect();
        assert_eq!((second.iter().sum::<u64>(), &second[..6]), (100, &[4, 4, 5, 4, 4, 4][..]));
    }
}
