//! The two coordinates of a material that can separate classes: its roughness, and one direction in the space of colours.

use glam::{DVec2, DVec3};

use super::LEAST_CHANGE;

/// The smallest Beckmann roughness that is compared.
const LEAST_ALPHA: f64 = 1e-3;

/// The coordinates of a material on which classes depend. An unused coordinate is 0 everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MaterialAxes {
    /// Whether the first coordinate is the logarithm of the roughness.
    pub roughness: bool,
    /// The direction in colour space of the second coordinate, or zero.
    pub color: DVec3,
}

impl MaterialAxes {
    pub const fn is_none(&self) -> bool {
        let DVec3 { x, y, z } = self.color;
        !self.roughness && x == 0.0 && y == 0.0 && z == 0.0
    }

    /// Returns the coordinates of a linear albedo and a roughness.
    pub fn of(&self, [r, g, b, alpha]: [f64; 4]) -> DVec2 {
        let roughness = if self.roughness { alpha.max(LEAST_ALPHA).ln() } else { 0.0 };
        DVec2::new(roughness, self.color.dot(DVec3::new(r, g, b)))
    }
}

/// The correlation of colours with heights and slopes.
pub(super) struct Correlation<'a> {
    pub colors: &'a [DVec3],
    /// The weights of the facets: twice the rank of the height, and the slopes in standard deviations. All have a mean of 1 or 0.
    pub weights: &'a [DVec3],
}

impl Correlation<'_> {
    /// Returns the covariances of colour with each weight within the classes, averaged over the classes.
    pub fn within(&self, class_of: &[usize], count: usize) -> [DVec3; 3] {
        let mut sums = vec![(0.0, DVec3::ZERO, DVec3::ZERO, [DVec3::ZERO; 3]); count];
        for ((&color, &weights), &class) in self.colors.iter().zip(self.weights).zip(class_of) {
            let (number, mean_color, mean_weights, products) = &mut sums[class];
            *number += 1.0;
            *mean_color += color;
            *mean_weights += weights;
            products.iter_mut().zip(weights.to_array()).for_each(|(product, weight)| *product += weight * color);
        }
        let all = self.colors.len() as f64;
        let mut within = [DVec3::ZERO; 3];
        for (number, color, weights, products) in sums.into_iter().filter(|sum| sum.0 > 0.0) {
            for (axis, product) in products.into_iter().enumerate() {
                within[axis] += (product - color * weights[axis] / number) / all;
            }
        }
        within
    }

    /// Returns the largest change of the mean colour, relative to the mean of the brightest channel.
    pub fn change(&self, within: [DVec3; 3]) -> f64 {
        let brightest = self.colors.iter().sum::<DVec3>().max_element() / self.colors.len() as f64;
        within.into_iter().map(|covariance| covariance.abs().max_element()).fold(0.0, f64::max) / brightest.max(1e-6)
    }

    /// Returns the direction of colours that follows the relief most, or zero if no colour does. The colours have a standard deviation
    /// of 1 along it. `one` has a single class.
    pub fn axis(&self, one: &[usize]) -> DVec3 {
        let within = self.within(one, 1);
        if self.change(within) <= LEAST_CHANGE {
            return DVec3::ZERO;
        }
        let longest = within.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let along = longest.unwrap_or(DVec3::ZERO).normalize_or_zero();
        let all = self.colors.len() as f64;
        let mean = self.colors.iter().map(|color| color.dot(along)).sum::<f64>() / all;
        let variance = self.colors.iter().map(|color| (color.dot(along) - mean).powi(2)).sum::<f64>() / all;
        if variance > 0.0 { along / variance.sqrt() } else { DVec3::ZERO }
    }
}

/// Returns twice the rank of each height, with a mean of 1.
pub(super) fn double_ranks(heights: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
    let mut ranks = vec![1.0; heights.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| heights[a] == heights[b]) {
        // Equal heights share the middle of their ranks.
        let rank = (2 * first + equal.len()) as f64 / heights.len() as f64;
        equal.iter().for_each(|&i| ranks[i] = rank);
        first += equal.len();
    }
    ranks
}
