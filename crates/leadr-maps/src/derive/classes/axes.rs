//! The two coordinates of a material that can separate classes: its roughness, and one direction in the space of colours.

use glam::{DVec2, DVec3};

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

/// The colours and the weights of the facets of a class, summed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ColorSums {
    number: f64,
    color: DVec3,
    weights: DVec3,
    products: [DVec3; 3],
}

impl ColorSums {
    /// Adds a facet. The weights are twice the rank of the height, and the slopes in standard deviations. All have a mean of 1 or 0.
    pub fn add(&mut self, color: DVec3, weights: DVec3) {
        self.number += 1.0;
        self.color += color;
        self.weights += weights;
        self.products.iter_mut().zip(weights.to_array()).for_each(|(product, weight)| *product += weight * color);
    }

    pub fn join(&mut self, other: &Self) {
        self.number += other.number;
        self.color += other.color;
        self.weights += other.weights;
        self.products.iter_mut().zip(other.products).for_each(|(product, other)| *product += other);
    }

    /// Returns the sums of the products of colour and weight about the means of the class.
    fn within(&self) -> [DVec3; 3] {
        let weights = self.weights.to_array();
        std::array::from_fn(|axis| self.products[axis] - self.color * (weights[axis] / self.number.max(1.0)))
    }
}

/// Returns the largest change of the mean colour within classes for a shift of the weights, relative to the mean of the brightest
/// channel.
pub(super) fn change_within<'a>(classes: impl Iterator<Item = &'a ColorSums>) -> f64 {
    let (mut within, mut color) = ([DVec3::ZERO; 3], DVec3::ZERO);
    for class in classes {
        within.iter_mut().zip(class.within()).for_each(|(sum, within)| *sum += within);
        color += class.color;
    }
    let most = within.into_iter().map(|covariance| covariance.abs().max_element()).fold(0.0, f64::max);
    most / color.max_element().max(1e-6)
}

/// Returns the direction of colours that follows the relief most. The colours have a standard deviation of 1 along it. `all` are the
/// sums over all of them.
pub(super) fn color_axis(colors: &[DVec3], all: &ColorSums) -> DVec3 {
    let longest = all.within().into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let along = longest.unwrap_or(DVec3::ZERO).normalize_or_zero();
    let mean = all.color.dot(along) / all.number.max(1.0);
    let variance = colors.iter().map(|color| (color.dot(along) - mean).powi(2)).sum::<f64>() / all.number.max(1.0);
    if variance > 0.0 { along / variance.sqrt() } else { DVec3::ZERO }
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
