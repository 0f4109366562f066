//! A table of slopes, isotropic or not.

use glam::{DVec2, DVec3};

use super::curve::Curve;
use super::polar_table::PolarTable;
use super::radial_table::RadialTable;
use super::slope_distribution::SlopeDistribution;

/// Slopes as a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Tabulated {
    /// The same at all azimuths.
    Radial(RadialTable),
    /// Of the angle and the azimuth.
    Polar(PolarTable),
}

impl Tabulated {
    /// From densities of normals, a row for each azimuth, as [`RadialTable::new`] takes one row and [`PolarTable::new`] several.
    pub fn from_rows(rows: &[Vec<f64>]) -> Option<Self> {
        match rows {
            [row] => RadialTable::new(row).map(Self::Radial),
            rows => PolarTable::new(rows).map(Self::Polar),
        }
    }

    /// Angles and azimuths that it was made from; one azimuth where all are the same.
    pub fn nodes(&self) -> (usize, usize) {
        match self {
            Self::Radial(table) => (table.nodes(), 1),
            Self::Polar(table) => table.nodes(),
        }
    }

    /// `ln D` over `u`, in steps of one node, for each azimuth.
    pub fn ln_d(&self) -> &[Curve] {
        match self {
            Self::Radial(table) => std::slice::from_ref(table.ln_d()),
            Self::Polar(table) => table.ln_d(),
        }
    }

    /// `D` at its nodes, for each azimuth: what [`Self::from_rows`] makes it from.
    pub fn densities(&self) -> Vec<Vec<f64>> {
        let (angles, _) = self.nodes();
        self.ln_d().iter().map(|row| row.values()[..angles].iter().map(|ln| ln.exp()).collect()).collect()
    }

    /// `∫ f(slope) P22` over the slopes that the table has.
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
