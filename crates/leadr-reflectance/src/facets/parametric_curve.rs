//! Published two-parameter curves for the normal density of measured materials: the shifted gamma distribution (SGD: Bagher, Soler and
//! Holzschuch 2012) and the ABC model (Löw, Kronander, Ynnerman and Unger 2012).

use super::radial_table::{RadialTable, angle_at};

/// The number of nodes in the table of a curve.
const NODES: usize = 180;

/// A family of parametric curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The shifted gamma distribution `P22 ∝ e^(−x) / x^p`, `x = α + tan² θ / α`.
    ShiftedGamma,
    /// The ABC model `D ∝ (1 + B (1 − cos θ))^(−C)`.
    Abc,
}

/// A parametric curve of the normal density, up to a constant factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParametricCurve {
    /// A curve of [`Family::ShiftedGamma`].
    ShiftedGamma {
        /// The positive width `α`.
        alpha: f64,
        /// The exponent `p`.
        p: f64,
    },
    /// A curve of [`Family::Abc`].
    Abc {
        /// The positive inverse width `B`.
        b: f64,
        /// The exponent `C`.
        c: f64,
    },
}

impl ParametricCurve {
    /// Returns the curve of a family with the logarithm of the width (`α` or `B`) and the exponent (`p` or `C`).
    pub fn of(family: Family, [width, exponent]: [f64; 2]) -> Self {
        match family {
            Family::ShiftedGamma => Self::ShiftedGamma { alpha: width.exp(), p: exponent },
            Family::Abc => Self::Abc { b: width.exp(), c: exponent },
        }
    }

    /// Returns `ln D` at the angle `theta` to the macrosurface normal, up to a constant.
    pub fn ln_density(&self, theta: f64) -> f64 {
        match *self {
            Self::ShiftedGamma { alpha, p } => {
                let cosine = theta.cos().max(1e-9);
                let x = alpha + theta.tan().powi(2) / alpha;
                // The logarithm is relative to the density at θ = 0, which can be huge.
                -(x - alpha) - p * (x / alpha).ln() - 4.0 * cosine.ln()
            }
            Self::Abc { b, c } => -c * (b * 2.0 * (0.5 * theta).sin().powi(2)).ln_1p(),
        }
    }

    /// Builds a table of the curve's slopes.
    pub fn table(&self) -> Option<RadialTable> {
        self.table_of(NODES)
    }

    /// Builds a table of the curve's slopes with this number of nodes.
    pub fn table_of(&self, nodes: usize) -> Option<RadialTable> {
        let density = |i: usize| self.ln_density(angle_at(i as f64 / nodes as f64)).exp();
        RadialTable::new(&(0..nodes).map(density).collect::<Vec<_>>())
    }
}
