//! Stretches, shears and tilts a [`Tile`] to slopes of any mean and covariance, and computes what an observer sees of the
//! surface.
//!
//! An affine map of the plane preserves triangles and rays. Adding a plane to the heights also preserves triangles and rays.
//! One tile therefore serves every surface, and the slope moments are exact instead of expected values.

use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_PI, TAU};

use super::cast::{SurfacePoint, escapes, first_hit, next_hit};
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
    /// The linear map from lattice slopes. A slope is `mean + factor · (slope on the lattice)`.
    factor: DMat2,
}

/// A facet that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// The slope of the facet.
    pub slope: DVec2,
    /// The unit normal of the facet.
    pub normal: DVec3,
    point: SurfacePoint,
}

impl Facet {
    /// Returns the hit position over the lattice of the tile, which repeats with its size.
    pub fn over(&self) -> DVec2 {
        self.point.position.truncate()
    }
}

/// The means of `K` values over many rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<const K: usize> {
    /// The mean over all rays.
    pub mean: [f64; K],
    /// The means over two disjoint halves of the rays. The difference of the means estimates the noise of the rays, but not
    /// the variation between tiles, which needs several seeds.
    pub halves: [[f64; K]; 2],
}

impl<const K: usize> Estimate<K> {
    fn new(halves: [[f64; K]; 2]) -> Self {
        Self { mean: std::array::from_fn(|k| 0.5 * (halves[0][k] + halves[1][k])), halves }
    }

    /// Returns half the difference of the two halves, which is one sample of the mean's standard error.
    pub fn half_difference(&self) -> [f64; K] {
        std::array::from_fn(|k| 0.5 * (self.halves[0][k] - self.halves[1][k]))
    }
}

/// The visibility and lighting of facets with one slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenAndLit {
    /// The fraction of the facets that the viewer sees.
    pub seen: f64,
    /// The fraction of the facets that the light reaches.
    pub lit: f64,
    /// The fraction of the facets that are both visible and lit.
    pub both: f64,
    /// The number of triangles with the slope.
    pub facets: usize,
}

/// Returns the lower triangular `C` with `C Cᵀ` equal to the covariance.
fn cholesky(s: DVec3) -> DMat2 {
    let x = s.x.max(0.0).sqrt();
    let k = if x > 0.0 { s.z / x } else { 0.0 };
    DMat2::from_cols(DVec2::new(x, k), DVec2::new(0.0, (s.y - k * k).max(0.0).sqrt()))
}

impl<'a> Patch<'a> {
    /// Creates a surface of mean slope `m` and slope covariance `s = (s_xx, s_yy, s_xy)`. The covariance must be positive
    /// semidefinite.
    pub fn new(tile: &'a Tile, m: DVec2, s: DVec3) -> Self {
        Self { tile, mean: m, covariance: s, factor: cholesky(s) * cholesky(tile.covariance()).inverse() }
    }

    /// Transforms a direction to the lattice frame. The z component of the result is the projected area of the mesosurface.
    fn lattice(&self, w: DVec3) -> DVec3 {
        (self.factor.transpose() * w.xy()).extend(meso_area(w, self.mean))
    }

    fn facet(&self, point: SurfacePoint) -> Facet {
        let [x, y] = point.cell;
        let slope = self.mean + self.factor * self.tile.slopes(x, y)[usize::from(point.upper)];
        Facet { slope, normal: normal_of_slope(slope), point }
    }

    /// Computes `A(w)`, the area of all facets that face `w`, projected along `w`, per unit of macrosurface. The area is
    /// exact for the tile's triangles. For Gaussian slopes it would be
    /// [`visible_area`](leadr_reflectance::facets::projected_area::visible_area).
    pub fn facing_area(&self, w: DVec3) -> f64 {
        self.tile.mean_over_facets(|s| meso_area(w, self.mean + self.factor * s).max(0.0))
    }

    /// Computes the projected area of all facets along `w`, per unit of macrosurface. Facets that face away count as negative areas.
    pub fn signed_area(&self, w: DVec3) -> f64 {
        self.tile.mean_over_facets(|s| meso_area(w, self.mean + self.factor * s))
    }

    /// Whether light from `wi` reaches a facet. The facet must face the light and must not be blocked.
    pub fn is_lit(&self, facet: &Facet, wi: DVec3) -> bool {
        meso_area(wi, facet.slope) > 0.0 && escapes(self.tile, &facet.point, self.lattice(wi))
    }

    /// Computes means of `f` over the surface that is visible from direction `wo`. `n`² rays are spread evenly over one
    /// repeat and jittered by `seed`. If `f` is the radiance of a facet, the result is the mean over a pixel. `f` may draw
    /// random numbers.
    ///
    /// The result is `None` where the mesosurface faces away from the viewer, because nothing of an infinite surface is then
    /// visible.
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
        // Results are summed in row order, which makes them independent of the number of threads.
        let half = |first: usize| {
            let rows = rows.iter().skip(first).step_by(2);
            let count = f64::from(n) * rows.len() as f64;
            let sums = rows.fold([0.0; K], |a, b| std::array::from_fn(|k| a[k] + b[k]));
            sums.map(|sum| sum / count)
        };
        Some(Estimate::new([half(0), half(1)]))
    }

    /// Computes the mean and covariance of the visible slopes, with components `x, y` and `xx, yy, xy`.
    pub fn visible_slopes(&self, wo: DVec3, n: u32, seed: u64) -> Option<(DVec2, DVec3)> {
        let e = self.mean_over_visible(wo, n, seed, |f, _| {
            let s = f.slope - self.mean;
            [s.x, s.y, s.x * s.x, s.y * s.y, s.x * s.y]
        })?;
        let [x, y, xx, yy, xy] = e.mean;
        Some((self.mean + DVec2::new(x, y), DVec3::new(xx - x * x, yy - y * y, xy - x * y)))
    }

    /// Measures the hidden fraction of the projected area that faces `w`. `n`² rays start on the facets. An infinite surface
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

    /// Computes the radiance of white diffuse facets under a directional light, of unit irradiance. With the first value's
    /// masking only, all facets that face the light are lit. The second value includes shadows.
    pub fn diffuse_light(&self, wo: DVec3, wi: DVec3, n: u32, seed: u64) -> Option<Estimate<2>> {
        self.mean_over_visible(wo, n, seed, |facet, _| {
            let radiance = facet.normal.dot(wi).max(0.0) * FRAC_1_PI;
            [radiance, if radiance > 0.0 && self.is_lit(facet, wi) { radiance } else { 0.0 }]
        })
    }

    /// Computes the radiance of white diffuse facets under an environment, with `directions` rays from every facet. The
    /// first value has masking only. The second value includes shadows. Blocked light is black, and light is reflected only
    /// once.
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

    /// Returns the next facet on a ray from a facet, or `None` if the ray leaves the surface. The facet must face `w`.
    pub fn next_facet(&self, facet: &Facet, w: DVec3) -> Option<Facet> {
        let direction = self.lattice(w);
        let level = if direction.z == 0.0 { direction.with_z(-1e-12) } else { direction };
        next_hit(self.tile, &facet.point, level).map(|point| self.facet(point))
    }

    /// Draws a direction about the normal of a facet, with a density proportional to the cosine. Returns `None` if other facets block it.
    pub fn free_direction(&self, facet: &Facet, random: &mut Random) -> Option<DVec3> {
        let w = from_frame(&frame_about(facet.normal), cosine_direction(random));
        self.is_lit(facet, w).then_some(w)
    }

    /// Draws the radiance of a diffuse facet by tracing one path of at most `depth` bounces. The facets have the given `albedo`. The lights
    /// are a sun from `sun.0`, whose irradiance on a facet that faces it is `sun.1`, and a sky of the given `radiance`, which the surface
    /// blocks below its own plane. The first value has the light of one bounce, and the second that of all bounces.
    pub fn traced_light(
        &self,
        facet: &Facet,
        albedo: impl Fn(&Facet) -> f64,
        sun: (DVec3, f64),
        sky: impl Fn(DVec3) -> f64,
        depth: u32,
        random: &mut Random,
    ) -> [f64; 2] {
        let (mut facet, mut weight) = (*facet, 1.0);
        let mut light = [0.0; 2];
        for bounce in 0..depth {
            weight *= albedo(&facet);
            let facing = facet.normal.dot(sun.0).max(0.0);
            let mut add = |value: f64| {
                light[1] += value;
                light[0] += if bounce == 0 { value } else { 0.0 };
            };
            if sun.1 > 0.0 && facing > 0.0 && self.is_lit(&facet, sun.0) {
                add(weight * sun.1 * facing * FRAC_1_PI);
            }
            let w = from_frame(&frame_about(facet.normal), cosine_direction(random));
            match self.next_facet(&facet, w) {
                Some(next) => facet = next,
                None => {
                    add(weight * sky(w));
                    break;
                }
            }
        }
        light
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

    /// Measures the visibility from `wo` and the lighting from `wi` of facets whose slope is within `radius` standard
    /// deviations of `slope`. Up to `rays` rays start on these facets. Returns `None` if no triangle has such a slope.
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
        // On the lattice, the slopes have the tile's own covariance, which is nearly the identity.
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
                // Rays start evenly spread over all triangles that were found, even if there are few rays.
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

    /// Computes the radiance of ideal specular facets (`F = 1`) under a directional light of unit irradiance. The radiance
    /// is `P22 G / (4 a_o wh.z⁴)`, where `P22` is the density of Gaussian slopes at the half vector. `G` is the fraction of
    /// facets that are seen (masking only) or both seen and lit (with shadows), and `a_o` is the projected area of the
    /// mesosurface. The arguments are those of [`visibility_of_slope`](Self::visibility_of_slope).
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
