//! Height fields for ray casts, and their classes of facets.

use glam::{DVec2, DVec3};
use leadr_maps::derive::{Classes, Facets, Openness, classes};
use leadr_maps::{HeightMap, Wrap};
use leadr_reflectance::masking::classes::{Class, Correlation, MOST_CLASSES};

use crate::ray_cast::{Facet, Spectrum, Tile};

/// The slope unit of tables of openness, as rise over run.
const UNIT: f64 = 0.7;

/// A periodic height field with its classes of facets.
#[derive(Clone, Debug)]
pub struct Relief {
    /// The surface. Its slopes are those of the relief.
    pub tile: Tile,
    /// The moments of the classes found by [`classes`].
    pub classes: Vec<Class>,
    found: Classes,
    open: Openness,
    scale: f64,
}

impl Relief {
    /// Finds the classes of a square height map. `scale` converts heights to texture widths.
    ///
    /// # Panics
    /// Panics if the side of the map is not a power of two.
    pub fn new(map: &HeightMap, scale: f64) -> Self {
        let facets = Facets::OfHeights(map, Wrap::Repeat);
        let found = classes(facets, [scale; 2], None);
        let open = Openness::new(facets, &found, None, [(UNIT / scale) as f32; 3], false);
        let cells = scale * f64::from(map.width);
        let heights = map.texels.iter().map(|&height| (f64::from(height) * cells) as f32).collect();
        let tile = Tile::from_heights(map.width, heights);
        let mut relief = Self { tile, classes: Vec::new(), found, open, scale };
        let mut sums = vec![(0.0, DVec2::ZERO, DVec3::ZERO); relief.found.count()];
        let size = map.width as i32;
        let mut count = 0.0;
        for (x, y) in (0..size * size).map(|i| (i % size, i / size)) {
            let [h00, h10, h01, h11] = relief.tile.corners(x, y);
            for (s, height) in relief.tile.slopes(x, y).into_iter().zip([h00 + h10 + h11, h00 + h01 + h11]) {
                let sum = &mut sums[relief.class(s, height / 3.0)];
                sum.0 += 1.0;
                sum.1 += s;
                sum.2 += DVec3::new(s.x * s.x, s.y * s.y, s.x * s.y);
                count += 1.0;
            }
        }
        let class = |(own, mean, square): (f64, DVec2, DVec3)| {
            let m = mean / own;
            let covariance = square / own - DVec3::new(m.x * m.x, m.y * m.y, m.x * m.y);
            Class { share: own / count, mean: m, covariance, height: 0.0, height_variance: 0.0 }
        };
        relief.classes = sums.into_iter().map(class).collect();
        relief
    }

    /// Returns the class of a facet of this slope and height, in cells.
    fn class(&self, slope: DVec2, height: f64) -> usize {
        let cells = self.scale * f64::from(self.tile.size());
        self.found.of_relief(slope / self.scale, height / cells)
    }

    /// Returns the class of a facet.
    pub fn class_of(&self, facet: &Facet) -> usize {
        let over = facet.over();
        let (cell, part) = (over.floor(), over - over.floor());
        let [h00, h10, h01, h11] = self.tile.corners(cell.x as i32, cell.y as i32);
        self.class(facet.slope, (h00 + h11 + if part.y > part.x { h01 } else { h10 }) / 3.0)
    }

    /// Returns the openness of the classes towards a direction.
    pub fn openness(&self, w: DVec3) -> [f64; MOST_CLASSES] {
        self.open.towards(w, DVec2::splat(UNIT))
    }

    /// Returns the correlation of the openness of each class towards different directions.
    pub fn correlation(&self) -> &[Correlation; MOST_CLASSES] {
        &self.open.correlation
    }

    /// Returns the optical depths of the classes towards the sky.
    pub fn sky_depths(&self) -> [f64; MOST_CLASSES] {
        self.open.sky_depths(&self.classes, DVec2::splat(UNIT))
    }

    /// Returns a Gaussian field of this slope deviation.
    pub fn noise(size: u32, deviation: f64) -> Self {
        let tile = Tile::new(Spectrum::Gaussian, size, 8.0, 5);
        let map = HeightMap { width: size, height: size, texels: tile.heights().to_vec() };
        Self::new(&map, deviation / f64::from(size))
    }
}
