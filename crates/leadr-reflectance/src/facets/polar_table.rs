//! Any slope distribution, tabulated over the angle to the macrosurface normal and the azimuth (thesis 4.2 and 4.4).
//!
//! As in a [`RadialTable`](super::radial_table::RadialTable), `ln D` is stored at `θ = u² π/2` for evenly spaced `u`. This table also
//! stores `ln D` for evenly spaced azimuths of the normal. The visible area is a convolution over the azimuth,
//!
//! ```text
//! A(θ_o, φ_o) = Σ_k ∫ K_k(θ_o, θ) [a_k(θ) cos k φ_o + b_k(θ) sin k φ_o] sin θ dθ
//! K_k = ∫ max(0, cos θ_o cos θ + sin θ_o sin θ cos φ) cos k φ dφ
//! ```
//!
//! with the Fourier coefficients `a` and `b` of `D` along the azimuth. The kernel `K` has a closed form.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::curve::Curve;
use super::projected_area::meso_area;
use super::radial_table::{angle_at, angle_rule, logarithms, u_of_angle};
use super::slope_distribution::SlopeDistribution;
use crate::random::Random;
use crate::slopes::statistics::outer_square;

/// The number of intervals in the table of visible areas, which are equal in the square root of the cosine.
const AREA_NODES: usize = 96;
/// The number of cells of the proposal distribution along `u`, and along the azimuth.
const CELLS: usize = 128;
/// The factor by which the bound of a cell exceeds the largest value probed in the cell.
const MARGIN: f64 = 1.15;
/// The maximum number of proposals per sample. Fewer than a third of the proposals may be accepted, but the probability that all are
/// rejected is below 1e-30.
const MOST_PROPOSALS: u32 = 256;

/// A tabulated slope distribution, normalised to `∫ D cos θ dω = 1`.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarTable {
    ln_d: Rows,
    area: Rows,
    mean: DVec2,
    /// The second moments of the tabulated slopes about the mean slope.
    covariance: DVec3,
    /// The cumulative bounds of the cells, for slopes and for slopes weighted by length.
    proposals: [Vec<f64>; 2],
}

/// A set of curves, one per evenly spaced azimuth.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows(Vec<Curve>);

impl Rows {
    /// Creates the curves from at least one row. `rows[k]` holds the values along the curve at the azimuth `2π k/n`.
    pub fn new(rows: Vec<Vec<f64>>) -> Self {
        Self(rows.into_iter().map(Curve::new).collect())
    }

    /// Returns the value at `x` and azimuth `phi`, by a cubic through the four nearest curves.
    pub fn at(&self, x: f64, phi: f64) -> f64 {
        let n = self.0.len();
        let position = (phi / TAU).rem_euclid(1.0) * n as f64;
        let k = (position as usize).min(n - 1);
        let t = position - k as f64;
        let row = |i: usize| self.0[(k + n + i - 1) % n].at(x);
        let [a, b, c, d] = [0, 1, 2, 3].map(row);
        b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
    }

    fn last(&self) -> f64 {
        (self.0[0].values().len() - 1) as f64
    }
}

/// Computes `∫ max(0, a + b cos φ) cos k φ dφ` over 2π, for `b ≥ 0` and all `k` below `count`.
pub fn ring_harmonics(a: f64, b: f64, count: usize) -> Vec<f64> {
    let end = if a >= b {
        PI
    } else if a <= -b {
        0.0
    } else {
        (-a / b).acos()
    };
    let sine = |k: f64| (k * end).sin();
    (0..count)
        .map(|k| match k {
            0 => 2.0 * (a * end + b * sine(1.0)),
            1 => 2.0 * a * sine(1.0) + b * (end + 0.5 * sine(2.0)),
            k => {
                let k = k as f64;
                2.0 * a * sine(k) / k + b * (sine(k - 1.0) / (k - 1.0) + sine(k + 1.0) / (k + 1.0))
            }
        })
        .collect()
}

/// A transform between evenly spaced values over 2π and their cosine and sine Fourier coefficients.
pub struct Harmonics {
    /// The cosine and sine of each step.
    circle: Vec<(f64, f64)>,
}

impl Harmonics {
    /// Creates a transform for `steps` values.
    pub fn new(steps: usize) -> Self {
        let circle = (0..steps).map(|k| (TAU * k as f64 / steps as f64).sin_cos()).map(|(s, c)| (c, s)).collect();
        Self { circle }
    }

    /// Returns the number of Fourier coefficients.
    pub fn count(&self) -> usize {
        self.circle.len() / 2 + 1
    }

    /// Returns the Fourier coefficient `k` of the values.
    pub fn of(&self, values: &[f64], k: usize) -> DVec2 {
        let n = self.circle.len();
        let sum = values.iter().enumerate().fold(DVec2::ZERO, |sum, (i, v)| {
            let (c, s) = self.circle[i * k % n];
            sum + DVec2::new(c, s) * *v
        });
        sum * if k == 0 || 2 * k == n { 1.0 } else { 2.0 } / n as f64
    }

    /// Returns the values at the steps from their Fourier coefficients.
    pub fn values(&self, coefficients: &[DVec2]) -> Vec<f64> {
        let n = self.circle.len();
        let at = |i: usize| {
            coefficients.iter().enumerate().fold(0.0, |sum, (k, a)| {
                let (c, s) = self.circle[i * k % n];
                sum + a.x * c + a.y * s
            })
        };
        (0..n).map(at).collect()
    }
}

/// A kernel that computes visible areas, one row per viewer angle, from densities at the angles of a quadrature rule.
pub struct AreaKernel {
    harmonics: Harmonics,
    /// The entry `kernel[o][j * count + k]` for viewer angle `o`, rule angle `j` and harmonic `k`, including the rule's weight.
    kernel: Vec<Vec<f64>>,
}

impl AreaKernel {
    /// Creates a kernel for viewers at the angles `of`, densities at the angles of `rule`, and this number of `azimuths` for both.
    pub fn new(of: &[f64], rule: &[(f64, f64)], azimuths: usize) -> Self {
        let harmonics = Harmonics::new(azimuths);
        let count = harmonics.count();
        let kernel = of.iter().map(|theta_o| {
            let ring = |&(theta, w): &(f64, f64)| {
                let (a, b) = (theta_o.cos() * theta.cos(), theta_o.sin() * theta.sin());
                ring_harmonics(a, b, count).into_iter().map(move |k| w * theta.sin() * k)
            };
            rule.iter().flat_map(ring).collect()
        });
        Self { kernel: kernel.collect(), harmonics }
    }

    /// Returns the visible areas, indexed by `[o][azimuth]`, from `densities[j][azimuth]`.
    pub fn areas(&self, densities: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = self.harmonics.count();
        let of_rule: Vec<DVec2> =
            densities.iter().flat_map(|ring| (0..count).map(move |k| self.harmonics.of(ring, k))).collect();
        let area = |kernel: &Vec<f64>| {
            let mut sums = vec![DVec2::ZERO; count];
            for (i, (weight, a)) in kernel.iter().zip(&of_rule).enumerate() {
                sums[i % count] += *weight * *a;
            }
            self.harmonics.values(&sums)
        };
        self.kernel.iter().map(area).collect()
    }
}

/// Returns the [`logarithms`] of the densities at each azimuth. All azimuths get the same value at the normal.
pub fn rows_of_logarithms(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let largest = rows.iter().flatten().copied().filter(|d| d.is_finite()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let upright = rows.iter().map(|row| row[0]).filter(|d| d.is_finite()).sum::<f64>() / rows.len() as f64;
    let row = |row: &Vec<f64>| logarithms(&[&[upright], &row[1..]].concat(), largest);
    rows.iter().map(row).collect()
}

impl PolarTable {
    /// Builds a table from normal densities that are known up to a common factor. `rows[k][i]` is the density at the azimuth `2π k / rows`
    /// of the *normal* and at `u = i / n`. Negative values and NaN count as 0.
    ///
    /// Returns `None` for fewer than 4 azimuths or 3 angles, for rows of different lengths, or if no value is above 0.
    pub fn new(rows: &[Vec<f64>]) -> Option<Self> {
        let n = rows.first()?.len();
        let any = rows.iter().flatten().any(|d| d.is_finite() && *d > 0.0);
        if rows.len() < 4 || n < 3 || rows.iter().any(|row| row.len() != n) || !any {
            return None;
        }
        let mut ln = rows_of_logarithms(rows);
        let rule = angle_rule(n);
        let ring = |ln_d: &Rows, theta: f64| -> Vec<f64> {
            ln_d.0.iter().map(|row| row.at(u_of_angle(theta) * n as f64).exp()).collect()
        };
        let step = TAU / rows.len() as f64;
        let shape = Rows::new(ln.clone());
        let sum: f64 = rule
            .iter()
            .map(|&(theta, w)| w * theta.sin() * theta.cos() * step * ring(&shape, theta).iter().sum::<f64>())
            .sum();
        ln.iter_mut().flatten().for_each(|value| *value -= sum.ln());
        let ln_d = Rows::new(ln);
        let densities: Vec<Vec<f64>> = rule.iter().map(|&(theta, _)| ring(&ln_d, theta)).collect();

        let (mut mean, mut second) = (DVec2::ZERO, DVec3::ZERO);
        for (&(theta, w), ring) in rule.iter().zip(&densities) {
            for (k, d) in ring.iter().enumerate() {
                let slope = -theta.tan() * DVec2::from_angle(step * k as f64);
                let mass = w * theta.sin() * theta.cos() * step * d;
                mean += mass * slope;
                second += mass * outer_square(slope);
            }
        }
        let covariance = second - outer_square(mean);

        let angles: Vec<f64> = (0..=AREA_NODES).map(|j| (j as f64 / AREA_NODES as f64).powi(2).acos()).collect();
        let areas = AreaKernel::new(&angles, &rule, rows.len()).areas(&densities);
        let of_azimuth = |k: usize| areas.iter().map(|ring| ring[k].max(0.0)).collect();
        let area = Rows::new((0..rows.len()).map(of_azimuth).collect());

        let mut proposals = [Vec::with_capacity(CELLS * CELLS), Vec::with_capacity(CELLS * CELLS)];
        let mut sums = [0.0; 2];
        for i in 0..CELLS {
            for k in 0..CELLS {
                let mut bounds = [0.0f64; 2];
                for probe in 0..9 {
                    let (x, y) = (f64::from(probe % 3) * 0.5, f64::from(probe / 3) * 0.5);
                    let (u, phi) = ((i as f64 + x) / CELLS as f64, TAU * (k as f64 + y) / CELLS as f64);
                    let mass = mass(&ln_d, u, phi);
                    bounds[0] = bounds[0].max(mass);
                    // The clamp keeps the bound finite at the horizon, where the mass is 0.
                    bounds[1] = bounds[1].max(mass * angle_at(u).tan().min(1e6));
                }
                for which in 0..2 {
                    sums[which] += MARGIN * bounds[which];
                    proposals[which].push(sums[which]);
                }
            }
        }
        Some(Self { ln_d, area, mean, covariance, proposals })
    }

    /// Returns `D` of a normal at the angle `theta` and the azimuth `phi`.
    pub fn density(&self, theta: f64, phi: f64) -> f64 {
        self.ln_d.at(u_of_angle(theta) * self.ln_d.last(), phi).exp()
    }

    /// Returns one curve of `ln D` over `u` for each azimuth. Each step of a curve is one node.
    pub fn ln_d(&self) -> &[Curve] {
        &self.ln_d.0
    }

    /// Returns the number of angles and of azimuths in the input.
    pub fn nodes(&self) -> (usize, usize) {
        (self.ln_d.0[0].values().len() - 1, self.ln_d.0.len())
    }

    /// Returns the covariance of the tabulated slopes. The result is finite even if the covariance of the surface is infinite.
    pub fn covariance(&self) -> DVec3 {
        self.covariance
    }

    /// Returns `D cos θ sin θ dθ/du`, the mass of the facets per unit of `u` and of the normal's azimuth.
    pub(super) fn mass(&self, u: f64, phi: f64) -> f64 {
        mass(&self.ln_d, u, phi)
    }

    /// Integrates `f(slope) P22` over the tabulated slopes.
    pub fn mean_of(&self, f: impl Fn(DVec2) -> f64) -> f64 {
        // The quadrature is finer than the table, to handle functions with a kink.
        let (n, m) = self.nodes();
        let m = 4 * m;
        let step = TAU / m as f64;
        let ring = |(theta, w): (f64, f64)| {
            let at = |k: usize| {
                let phi = step * (k as f64 + 0.5);
                self.density(theta, phi) * f(-theta.tan() * DVec2::from_angle(phi))
            };
            w * theta.sin() * theta.cos() * step * (0..m).map(at).sum::<f64>()
        };
        angle_rule(n).into_iter().map(ring).sum()
    }
}

/// Returns `D cos θ sin θ dθ/du`, the mass of the facets per unit of `u` and azimuth.
fn mass(ln_d: &Rows, u: f64, phi: f64) -> f64 {
    let (sine, cosine) = angle_at(u).sin_cos();
    ln_d.at(u * ln_d.last(), phi).exp() * (sine * cosine).max(0.0) * PI * u
}

impl SlopeDistribution for PolarTable {
    fn p22(&self, slope: DVec2) -> f64 {
        let q = 1.0 + slope.length_squared();
        self.density(slope.length().atan(), (-slope.y).atan2(-slope.x)) / (q * q)
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        if wn.z <= 0.0 { 0.0 } else { self.density(wn.truncate().length().atan2(wn.z), wn.y.atan2(wn.x)) }
    }

    fn mean_slope(&self) -> DVec2 {
        self.mean
    }

    fn shape(&self) -> DVec3 {
        self.covariance
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        let up = if w.z < 0.0 { -w } else { w };
        let area =
            self.area.at(up.z.sqrt() * AREA_NODES as f64, up.y.atan2(up.x)).max(meso_area(up, self.mean)).max(0.0);
        // The facets that face away from w are the facets that face −w.
        if w.z < 0.0 { (area + meso_area(w, self.mean)).max(0.0) } else { area }
    }

    /// Draws the sample by rejection. The proposals have the density `P22 (cos θ_o + sin θ_o |slope|)`, which bounds the visible area of
    /// each facet. `u` seeds the random stream.
    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        let mut random = Random::stream(u.x.to_bits(), u.y.to_bits());
        let sine = wo.truncate().length();
        let factors = [wo.z.max(0.0), sine];
        let totals = [0, 1].map(|i| factors[i] * self.proposals[i][CELLS * CELLS - 1]);
        let cell_bound = |which: usize, cell: usize| {
            self.proposals[which][cell] - if cell == 0 { 0.0 } else { self.proposals[which][cell - 1] }
        };
        for _ in 0..MOST_PROPOSALS {
            let which = usize::from(random.unit() * (totals[0] + totals[1]) >= totals[0]);
            let sums = &self.proposals[which];
            let wanted = random.unit() * sums[CELLS * CELLS - 1];
            let cell = sums.partition_point(|sum| *sum <= wanted).min(CELLS * CELLS - 1);
            let u = ((cell / CELLS) as f64 + random.unit()) / CELLS as f64;
            let phi = TAU * ((cell % CELLS) as f64 + random.unit()) / CELLS as f64;
            let (sin_theta, cos_theta) = angle_at(u).sin_cos();
            let wn = DVec3::new(sin_theta * phi.cos(), sin_theta * phi.sin(), cos_theta);
            let seen = mass(&self.ln_d, u, phi) * (wo.dot(wn) / cos_theta.max(1e-9)).max(0.0);
            if random.unit() * (factors[0] * cell_bound(0, cell) + factors[1] * cell_bound(1, cell)) < seen {
                return wn;
            }
        }
        DVec3::Z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::Beckmann;
    use crate::facets::chi_square::chi_square;
    use crate::facets::ellipse::{Bivariate, covariance_from_roughness, roughness_from_bivariate};

    fn gaussian(alpha: DVec2, rho: f64) -> Beckmann {
        let a = roughness_from_bivariate(&Bivariate::new(alpha, rho));
        Beckmann::new(DVec2::ZERO, covariance_from_roughness(a))
    }

    fn table(of: &impl SlopeDistribution, angles: usize, azimuths: usize) -> PolarTable {
        let at = |i: usize, k: usize| {
            let (sine, cosine) = angle_at(i as f64 / angles as f64).sin_cos();
            let phi = TAU * k as f64 / azimuths as f64;
            of.ndf(DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine))
        };
        let rows: Vec<Vec<f64>> = (0..azimuths).map(|k| (0..angles).map(|i| at(i, k)).collect()).collect();
        PolarTable::new(&rows).unwrap()
    }

    #[test]
    fn harmonics_of_a_ring_are_its_integrals() {
        for (a, b) in [(0.5, 0.2), (0.1, 0.7), (0.0, 0.4), (-0.2, 0.5), (-0.9, 0.3)] {
            let found = ring_harmonics(a, b, 6);
            for (k, found) in found.iter().enumerate() {
                let n = 40_000;
                let at = |i: i32| {
                    let phi = TAU * (f64::from(i) + 0.5) / f64::from(n);
                    (a + b * phi.cos()).max(0.0) * (k as f64 * phi).cos() * TAU / f64::from(n)
                };
                let expected: f64 = (0..n).map(at).sum();
                assert!((found - expected).abs() < 1e-7, "{a} {b} {k}: {found} {expected}");
            }
        }
    }

    #[test]
    fn a_table_of_an_analytic_distribution_is_that_distribution() {
        for (alpha, rho, most) in
            [(DVec2::splat(0.1), 0.0, 1e-5), (DVec2::new(0.05, 0.2), 0.0, 5e-4), (DVec2::new(0.2, 0.5), 0.6, 1e-3)]
        {
            let gaussian = gaussian(alpha, rho);
            let table = table(&gaussian, 90, 90);
            let mut worst = [0.0f64; 2];
            for i in 0..2000 {
                let w = Random::stream(3, i).on_sphere();
                let (a, b) = (table.visible_area(w), gaussian.visible_area(w));
                worst[0] = worst[0].max((a - b).abs() / b.max(0.05));
                worst[1] = worst[1].max((table.ndf(w) - gaussian.ndf(w)).abs() / gaussian.ndf(DVec3::Z));
            }
            println!("{alpha} {rho}: {worst:?}");
            assert!(worst.iter().all(|error| *error < most), "{alpha} {rho}: {worst:?}");
            let error = (table.covariance() - gaussian.shape()).length() / gaussian.shape().length();
            assert!(error < 1e-4, "{alpha} {rho}: {error}");
        }
    }

    #[test]
    fn visible_normals_have_their_density() {
        let gaussian = gaussian(DVec2::new(0.15, 0.4), -0.4);
        let table = table(&gaussian, 60, 60);
        let other = self::gaussian(DVec2::new(0.16, 0.4), -0.4);
        for wo in [DVec3::Z, DVec3::new(0.5, -0.3, 0.8).normalize(), DVec3::new(-0.8, 0.7, 0.12).normalize()] {
            let (found, most) = chi_square(&table, &table, wo, 100_000);
            let (wrong, _) = chi_square(&table, &other, wo, 100_000);
            println!("χ² at {wo}: {found:.1}, wrong distribution {wrong:.1}, limit {most:.1}");
            assert!(found < most && wrong > most, "{wo}: {found} {wrong} {most}");
        }
    }

    #[test]
    fn empty_tables_are_refused() {
        assert_eq!(PolarTable::new(&[]), None);
        assert_eq!(PolarTable::new(&vec![vec![1.0; 5]; 3]), None);
        assert_eq!(PolarTable::new(&[vec![1.0; 5], vec![1.0; 5], vec![1.0; 5], vec![1.0; 4]]), None);
        assert_eq!(PolarTable::new(&vec![vec![0.0; 5]; 4]), None);
        let odd = PolarTable::new(&[vec![f64::NAN; 5], vec![1.0; 5], vec![0.0; 5], vec![-1.0; 5]]).unwrap();
        for i in 0..200 {
            let w = Random::stream(1, i).on_sphere();
            let wn = odd.sample_visible(w, DVec2::new(0.3, i as f64 / 200.0));
            assert!(odd.visible_area(w).is_finite() && (wn.length() - 1.0).abs() < 1e-9, "{w}");
        }
    }
}
