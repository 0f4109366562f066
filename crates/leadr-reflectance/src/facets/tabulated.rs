//! A tabulated slope distribution, which is isotropic or anisotropic.

use glam::{DVec2, DVec3};

use super::curve::Curve;
use super::polar_table::PolarTable;
use super::radial_table::RadialTable;
use super::slope_distribution::SlopeDistribution;

/// A tabulated slope distribution.
#[derive(Clone, Debug, PartialEq)]
pub enum Tabulated {
    /// An isotropic table over the angle.
    Radial(RadialTable),
    /// A table over the angle and the azimuth.
    Polar(PolarTable),
}

impl Tabulated {
    /// Builds a table from normal densities, with one row per azimuth. A single row gives a [`RadialTable`], and several rows give a
    /// [`PolarTable`].
    pub fn from_rows(rows: &[Vec<f64>]) -> Option<Self> {
        match rows {
            [row] => RadialTable::new(row).map(Self::Radial),
            rows => PolarTable::new(rows).map(Self::Polar),
        }
    }

    /// Returns the number of input angles and of azimuths. An isotropic table has one azimuth.
    pub fn nodes(&self) -> (usize, usize) {
        match self {
            Self::Radial(table) => (table.nodes(), 1),
            Self::Polar(table) => table.nodes(),
        }
    }

    /// Returns one curve of `ln D` over `u` for each azimuth. Each step of a curve is one node.
    pub fn ln_d(&self) -> &[Curve] {
        match self {
            Self::Radial(table) => std::slice::from_ref(table.ln_d()),
            Self::Polar(table) => table.ln_d(),
        }
    }

    /// Returns `D` at the nodes of each azimuth, in the form that [`Self::from_rows`] takes.
    pub fn densities(&self) -> Vec<Vec<f64>> {
        let (angles, _) = self.nodes();
        self.ln_d().iter().map(|row| row.values()[..angles].iter().map(|ln| ln.exp()).collect()).collect()
    }

    /// Integrates `f(slope) P22` over the tabulated slopes.
    pub fn mean_of(&self, f: impl Fn(DVec2) -> f64) -> f64 {
        match self {
            Self::Radial(table) => table.mean_of(f),
            Self::Polar(table) => table.mean_of(f),
        }
    }

    fn inner(&self) -> &dyn SlopeDistribution {
        match self {
            Self::Radial(table) => table,
            Self::Polar(table) => table,
        }
    }
}

impl SlopeDistribution for Tabulated {
    fn p22(&self, slope: DVec2) -> f64 {
        self.inner().p22(slope)
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        self.inner().ndf(wn)
    }

    fn mean_slope(&self) -> DVec2 {
        self.inner().mean_slope()
    }

    fn shape(&self) -> DVec3 {
        self.inner().shape()
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        self.inner().visible_area(w)
    }

    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        self.inner().sample_visible(wo, u)
    }
}
