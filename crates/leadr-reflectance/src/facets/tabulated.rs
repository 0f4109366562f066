//! A table of slopes, isotropic or not.

use glam::{DVec2, DVec3};

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
