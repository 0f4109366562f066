//! Stretches, shears and tilts a [`Tile`] to slopes of any mean and covariance, and computes what an observer sees of it.
//!
//! An affine map of the plane plus a plane added to the heights preserves triangles and rays. One tile therefore serves every surface, and
//! its slope moments are exact rather than expected values.

use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_PI, TAU};

use super::cast::{SurfacePoint, escapes, first_hit};
use super::tile::Tile;
use leadr_reflectance::facets::beckmann::beckmann_p22;
use leadr_reflectance::facets::projected_area::meso_area;
use leadr_reflectance::frame::{frame_about, from_frame};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::normal_of_slope;

/// An infinite displaced patch that consists of the facets of a [`Tile`], with exactly the given slope mean and covariance.
#[derive(Clone, Copy, Debug)]
pub struct Patch<'a> {
    tile: &'a Tile,
    mean: DVec2,
    covariance: DVec3,
    /// Linear map from lattice slopes: slopes are `mean + factor · (slope on the lattice)`.
    factor: DMat2,
}

/// A facet hit by a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Slope of the facet.
    pub slope: DVec2,
    /// Unit normal of the facet.
    pub normal: DVec3,
    point: SurfacePoint,
}

impl Facet {
    /// Returns the hit position over the lattice of the tile, which repeats with its size.
    pub fn over(&self) -> DVec2 {
        self.point.position.truncate()
    }
}

/// Means of `K` values over rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<const K: usize> {
    /// Mean over all rays.
    pub mean: [f64; K],
    /// Means over two disjoint halves of the rays. Their difference estimates ray noise, but not the variation between tiles, which needs
    /// several seeds.
    pub halves: [[f64; K]; 2],
}

impl<const K: usize> Estimate<K> {
    fn new(halves: [[f64; K]; 2]) -> Self {
        Self { mean: std::array::from_fn(|k| 0.5 * (halves[0][k] + halves[1][k])), halves }
    }

    /// Returns half the difference of the halves, one sample of the mean's standard error.
    pub fn half_difference(&self) -> [f64; K] {
        std::array::from_fn(|k| 0.5 * (self.halves[0][k] - self.halves[1][k]))
    }
}

/// Visibility and lighting of facets with one slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenAndLit {
    /// Fraction of the facets visible to the viewer.
    pub seen: f64,
    /// Fraction of the facets reached by the light.
    pub lit: f64,
    /// Fraction of the facets that are both visible and lit.
    pub both: f64,
    /// Number of triangles with the slope.
    pub facets: usize,
}

/// Returns the lower triangular `C` with `C Cᵀ` equal to the covariance.
fn cholesky(s: DVec3) -> DMat2 {
    let x = s.x.max(0.0).sqrt();
    let k = if x > 0.0 { s.z / x } else { 0.0 };
    DMat2::from_cols(DVec2::new(x, k), DVec2::new(0.0, (s.y - k * k).max(0.0).sqrt()))
}

impl<'a> Patch<'a> {
    /// Creates a surface of mean slope `m` and slope covariance `s = (s_xx, s_yy, s_xy)`, which must be positive semidefinite.
    pub fn new(tile: &'a Tile, m: DVec2, s: DVec3) -> Self {
        Self { tile, mean: m, covariance: s, factor: cholesky(s) * cholesky(tile.covariance()).inverse() }
    }

    /// Transforms a direction to the lattice frame. The result's height is the projected area of the mesosurface.
    fn lattice(&self, w: DVec3) -> DVec3 {
        (self.factor.transpose() * w.xy()).extend(meso_area(w, self.mean))
    }

    fn facet(&self, point: SurfacePoint) -> Facet {
        let [x, y] = point.cell;
        let slope = self.mean + self.factor * self.tile.slopes(x, y)[usize::from(point.upper)];
        Facet { slope, normal: normal_of_slope(slope), point }
    }

    /// Computes `A(w)`, the area of all facets facing `w`, projected along it, per unit of macrosurface. It is exact for these triangles;
    /// for Gaussian slopes it is [`visible_area`](leadr_reflectance::facets::projected_area::visible_area).
    pub fn facing_area(&self, w: DVec3) -> f64 {
        self.tile.mean_over_facets(|s| meso_area(w, self.mean + self.factor * s).max(0.0))
    }

    /// Whether light from `wi` reaches a facet: the facet faces the light and is not blocked.
    pub fn is_lit(&self, facet: &Facet, wi: DVec3) -> bool {
        meso_area(wi, facet.slope) > 0.0 && escapes(self.tile, &facet.point, self.lattice(wi))
    }

    /// Computes means of `f` over the visible surface from direction `wo`, with `n`² rays spread evenly over one repeat (jittered by
    /// `seed`). The result is a pixel's mean if `f` is a facet's radiance. `f` may draw random numbers.
    ///
    /// The result is `None` where the mesosurface faces away from the viewer, so that nothing of an infinite surface is visible.
    pub fn mean_over_visible<const K: usize>(
        &self,
        wo: DVec3,
        n: u32,
        seed: u64,
        f: impl Fn(&Facet, &mut Random) -> [f64; K] + Sync,
    ) -> Option<Estimate<K>> {
        let direction = self.lattice(wo);
        if direction.z <= 0.0 {
            return None;
        }
        let n = n.max(2);
        let cell = f64::from(self.tile.size()) / f64::from(n);
        let rows: Vec<[f64; K]> = (0..n)
            .into_par_iter()
            .map(|y| {
                let mut sum = [0.0; K];
                for x in 0..n {
                    let mut random = Random::stream(seed, u64::from(y) << 32 | u64::from(x));
                    let jitter = DVec2::new(random.unit(), random.unit());
                    let over = (DVec2::new(f64::from(x), f64::from(y)) + jitter) * cell;
                    let point = first_hit(self.tile, over, direction).expect("an upward direction");
                    let values = f(&self.facet(point), &mut random);
                    for (sum, value) in sum.iter_mut().zip(values) {
                        *sum += value;
                    }
                }
                sum
            })
            .collect();
        // Results are summed in row order, so that they do not depend on threads.
        let half = |first: usize| {
            let rows = rows.iter().skip(first).step_by(2);
            let count = f64::from(n) * rows.len() as f64;
            let sums = rows.fold([0.0; K], |a, b| std::array::from_fn(|k| a[k] + b[k]));
            sums.map(|sum| sum / count)
        };
        Some(Estimate::new([half(0), half(1)]))
    }

    /// Computes mean and covariance of the visible slopes, with components `x, y` and `xx, yy, xy`.
    pub fn visible_slopes(&self, wo: DVec3, n: u32, seed: u64) -> Option<(DVec2, DVec3)> {
        let e = self.mean_over_visible(wo, n, seed, |f, _| {
            let s = f.slope - self.mean;
            [s.x, s.y, s.x * s.x, s.y * s.y, s.x * s.y]
        })?;
        let [x, y, xx, yy, xy] = e.mean;
        Some((self.mean + DVec2::new(x, y), DVec3::new(xx - x * x, yy - y * y, xy - x * y)))
    }

    /// Measures the hidden fraction of the area that faces `w`, projected along it, by rays that start on `n`² facets. An infinite surface
    /// hides `1 − a(w) / A(w)`.
    pub fn masked_fraction(&self, w: DVec3, n: u32, seed: u64) -> f64 {
        let direction = self.lattice(w);
        let n = n.max(1);
        let cell = f64::from(self.tile.size()) / f64::from(n);
        let rows: Vec<[f64; 2]> = (0..n)
            .into_par_iter()
            .map(|y| {
                let mut sums = [0.0; 2];
                for x in 0..n {
                    let mut random = Random::stream(seed, u64::from(y) << 32 | u64::from(x));
                    let jitter = DVec2::new(random.unit(), random.unit());
                    let over = (DVec2::new(f64::from(x), f64::from(y)) + jitter) * cell;
                    let corner = over.floor();
                    let point = SurfacePoint::over(self.tile, corner.as_ivec2().to_array(), over - corner);
                    let area = meso_area(w, self.facet(point).slope);
                    if area > 0.0 {
                        sums[0] += area;
                        sums[1] += area * f64::from(!escapes(self.tile, &point, direction));
                    }
                }
                sums
            })
            .collect();
        let [all, hidden] = rows.into_iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        hidden / all.max(f64::MIN_POSITIVE)
    }

    /// Computes the radiance of white diffuse facets under a directional light of unit irradiance on a plane facing it. The first value has
    /// masking only, with all facets facing the light lit; the second has shadows.
    pub fn diffuse_light(&self, wo: DVec3, wi: DVec3, n: u32, seed: u64) -> Option<Estimate<2>> {
        self.mean_over_visible(wo, n, seed, |facet, _| {
            let radiance = facet.normal.dot(wi).max(0.0) * FRAC_1_PI;
            [radiance, if radiance > 0.0 && self.is_lit(facet, wi) { radiance } else { 0.0 }]
        })
    }

    /// Computes the radiance of white diffuse facets under an environment, with `directions` rays from every facet. The first value has
    /// masking only; the second has shadows (blocked light is black; light is not reflected twice).
    pub fn diffuse_environment(
        &self,
        wo: DVec3,
        n: u32,
        directions: u32,
        seed: u64,
        radiance: impl Fn(DVec3) -> f64 + Sync,
    ) -> Option<Estimate<2>> {
        let directions = directions.max(1);
        self.mean_over_visible(wo, n, seed, |facet, random| {
            let frame = frame_about(facet.normal);
            let mut sums = [0.0; 2];
            for _ in 0..directions {
                let wi = from_frame(&frame, cosine_direction(random));
                let incident = radiance(wi) / f64::from(directions);
                sums[0] += incident;
                sums[1] += if self.is_lit(facet, wi) { incident } else { 0.0 };
            }
            sums
        })
    }

    /// Computes the radiance of ideal specular facets (`F = 1`) under an environment, with masking only and with shadows.
    pub fn specular_environment(
        &self,
        wo: DVec3,
        n: u32,
        seed: u64,
        radiance: impl Fn(DVec3) -> f64 + Sync,
    ) -> Option<Estimate<2>> {
        self.mean_over_visible(wo, n, seed, |facet, _| {
            let wi = 2.0 * facet.normal.dot(wo) * facet.normal - wo;
            let incident = radiance(wi);
            [incident, if self.is_lit(facet, wi) { incident } else { 0.0 }]
        })
    }

    /// Measures the visibility from `wo` and the lighting from `wi` of facets with a slope within `radius` standard deviations of `slope`,
    /// by up to `rays` rays that start on them. Returns `None` if no triangle has a slope in this range.
    pub fn visibility_of_slope(
        &self,
        slope: DVec2,
        radius: f64,
        wo: DVec3,
        wi: DVec3,
        rays: u32,
        seed: u64,
    ) -> Option<SeenAndLit> {
        let size = self.tile.size() as i32;
        // On the lattice, slopes are whitened up to the tile's own, nearly unit, covariance.
        let centre = self.factor.inverse() * (slope - self.mean);
        if !centre.is_finite() {
            return None;
        }
        let rows: Vec<Vec<([i32; 2], bool)>> = (0..size)
            .into_par_iter()
            .map(|y| {
                let near = |s: DVec2| s.distance_squared(centre) <= radius * radius;
                let cells = (0..size).flat_map(|x| {
                    let [lower, upper] = self.tile.slopes(x, y);
                    [([x, y], false, near(lower)), ([x, y], true, near(upper))]
                });
                cells.filter(|c| c.2).map(|c| (c.0, c.1)).collect()
            })
            .collect();
        let found = rows.concat();
        if found.is_empty() || rays == 0 {
            return None;
        }
        let counts = (0..rays)
            .into_par_iter()
            .map(|i| {
                let mut random = Random::stream(seed, u64::from(i));
                // Ray starts are spread evenly over all found triangles, however few rays there are.
                let at = (u64::from(i) * found.len() as u64 / u64::from(rays)) as usize;
                let (cell, upper) = found[at];
                let (a, b) = (random.unit(), random.unit());
                let offset = if upper { DVec2::new(a.min(b), a.max(b)) } else { DVec2::new(a.max(b), a.min(b)) };
                let facet = self.facet(SurfacePoint::over(self.tile, cell, offset));
                let (seen, lit) = (self.is_lit(&facet, wo), self.is_lit(&facet, wi));
                [seen, lit, seen && lit].map(u64::from)
            })
            .reduce(|| [0; 3], |a, b| std::array::from_fn(|k| a[k] + b[k]));
        let [seen, lit, both] = counts.map(|count| count as f64 / f64::from(rays));
        Some(SeenAndLit { seen, lit, both, facets: found.len() })
    }

    /// Computes the radiance of ideal specular facets (`F = 1`) under a directional light of unit irradiance on a plane facing it. It is
    /// the density of Gaussian slopes at the half vector, times the fraction of facets seen (masking only) or both seen and lit (with
    /// shadows), per projected area of the mesosurface: `P22 G / (4 a_o wh.z⁴)`. The arguments are those of
    /// [`visibility_of_slope`](Self::visibility_of_slope).
    pub fn specular_light(&self, wo: DVec3, wi: DVec3, radius: f64, rays: u32, seed: u64) -> Option<[f64; 2]> {
        let half = (wo + wi).normalize();
        let area = meso_area(wo, self.mean);
        if half.z <= 0.0 || area <= 0.0 {
            return None;
        }
        let slope = -half.xy() / half.z;
        let visibility = self.visibility_of_slope(slope, radius, wo, wi, rays, seed)?;
        let density = beckmann_p22(slope, self.mean, self.covariance) / (4.0 * area * half.z.powi(4));
        Some([density * visibility.seen, density * visibility.both])
    }
}

/// Samples a direction about z with density `cos θ / π`.
pub(crate) fn cosine_direction(random: &mut Random) -> DVec3 {
    let (u, v) = (random.unit(), random.unit());
    let (sin, cos) = (TAU * v).sin_cos();
    let r = u.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - u).sqrt())
}
