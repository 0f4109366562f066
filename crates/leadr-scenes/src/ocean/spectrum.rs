//! The spectrum of a wind sea, which gives the variance of height and slope by wave vector.
//!
//! * Energy-carrying waves follow JONSWAP (Hasselmann et al. 1973) with the depth factor of TMA (Bouws et al. 1985, Kitaigorodskii et al.
//!   1975).
//! * Shorter waves, which carry the slopes, follow Elfouhaily et al. 1997. The equilibrium range of these waves (`ω⁻⁴`, Toba 1973, Donelan
//!   et al. 1985) starts where it exceeds JONSWAP's `ω⁻⁵`. Elfouhaily's roll-off and gravity–capillary spectrum are included. JONSWAP's own
//!   tail was fitted near the peak, and lacks a quarter of the slopes that Cox and Munk (1954) measured at 7 m/s.
//! * Directions spread as `cos^2s(θ/2)` (Longuet-Higgins et al. 1963), with `s` chosen to match Elfouhaily's second harmonic. Unlike
//!   Elfouhaily's `1 + Δ cos 2θ`, this spread has no symmetric waves against the wind.
//!
//! All quantities are in SI units and radians; `k` is a wave number in rad/m.

use std::f64::consts::{PI, TAU};

/// The gravity in m/s².
pub const GRAVITY: f64 = 9.81;
/// The surface tension of sea water divided by its density, in m³/s².
const TENSION: f64 = 7.4e-5;
/// The peak enhancement factor of JONSWAP.
const PEAK_ENHANCEMENT: f64 = 3.3;
/// The smallest phase speed of a water wave in m/s, as rounded by Elfouhaily.
const SLOWEST: f64 = 0.23;
/// The upper limit of the slope integrals in rad/m, for waves 2 mm long, far in the viscous range.
const SHORTEST: f64 = 3000.0;

/// A sea under a steady wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sea {
    /// The wind speed 10 m above the water in m/s; above 0.
    pub wind_speed: f64,
    /// The direction in which the wind blows, in radians counter-clockwise from +x.
    pub wind_direction: f64,
    /// The fetch, which is the distance over which the wind has blown, in metres; above 0.
    pub fetch: f64,
    /// The depth of the water in metres; above 0.
    pub depth: f64,
}

impl Default for Sea {
    fn default() -> Self {
        Self { wind_speed: 8.0, wind_direction: 0.6, fetch: 120e3, depth: 200.0 }
    }
}

/// The height variance, slope variances and slope covariance of a wave band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaveMoments {
    /// `E[h²]` in m².
    pub height: f64,
    /// The slope moments `E[h_x²], E[h_y²], E[h_x h_y]` of the linear surface, without choppiness.
    pub slopes: [f64; 3],
}

impl Sea {
    /// Returns the angular frequency of wave number `k` in rad/s, from gravity, capillarity and the finite depth.
    pub fn angular_frequency(&self, k: f64) -> f64 {
        (self.stiffness(k) * (k * self.depth).tanh()).sqrt()
    }

    fn stiffness(&self, k: f64) -> f64 {
        k * (GRAVITY + TENSION * k * k)
    }

    /// Returns the group speed `dω/dk` in m/s.
    pub fn group_speed(&self, k: f64) -> f64 {
        let t = (k * self.depth).tanh();
        let slope = (GRAVITY + 3.0 * TENSION * k * k) * t + self.stiffness(k) * self.depth * (1.0 - t * t);
        slope / (2.0 * self.angular_frequency(k)).max(1e-12)
    }

    /// Returns the angular frequency of the spectral peak in rad/s. The frequency follows JONSWAP's growth with the fetch, and is at least
    /// the frequency of a fully developed sea.
    pub fn peak_frequency(&self) -> f64 {
        let growing = 22.0 * (GRAVITY * GRAVITY / (self.wind_speed * self.fetch)).cbrt();
        growing.max(0.855 * GRAVITY / self.wind_speed)
    }

    /// Returns the wave number of the peak in rad/m, which solves the dispersion relation by bisection.
    pub fn peak_wave_number(&self) -> f64 {
        let target = self.peak_frequency();
        let (mut low, mut high) = (1e-6f64.ln(), 1e3f64.ln());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.angular_frequency(middle.exp()) < target { low = middle } else { high = middle }
        }
        (0.5 * (low + high)).exp()
    }

    /// Returns the JONSWAP spectrum with TMA's depth factor by frequency, in m² s. `∫ S dω` is the height variance.
    pub fn tma(&self, omega: f64) -> f64 {
        let peak = self.peak_frequency();
        let alpha = 0.076 * (self.wind_speed * self.wind_speed / (self.fetch * GRAVITY)).powf(0.22);
        let width = if omega <= peak { 0.07 } else { 0.09 };
        let r = (-0.5 * ((omega - peak) / (width * peak)).powi(2)).exp();
        let jonswap = alpha
            * GRAVITY
            * GRAVITY
            * omega.powi(-5)
            * (-1.25 * (peak / omega).powi(4)).exp()
            * PEAK_ENHANCEMENT.powf(r);
        let shallow = omega * (self.depth / GRAVITY).sqrt();
        let factor = match shallow {
            s if s <= 1.0 => 0.5 * s * s,
            s if s < 2.0 => 1.0 - 0.5 * (2.0 - s).powi(2),
            _ => 1.0,
        };
        jonswap * factor
    }

    /// Returns the omnidirectional spectrum in m³. `∫ S dk` is the height variance.
    pub fn omnidirectional(&self, k: f64) -> f64 {
        Tail::new(self).omnidirectional(self, k)
    }

    /// Returns the exponent `s` of the spreading function `cos^2s(θ/2)` at wave number `k`.
    pub fn spreading(&self, k: f64) -> f64 {
        Tail::new(self).spreading(self, k)
    }

    /// Returns the spectral density by wave vector, in m⁴. `∫∫ Ψ dkx dky` is the height variance.
    pub fn density(&self) -> impl Fn(f64, f64) -> f64 {
        let (sea, tail) = (*self, Tail::new(self));
        move |kx, ky| {
            let k = kx.hypot(ky);
            if k <= 0.0 {
                return 0.0;
            }
            let angle = ky.atan2(kx) - sea.wind_direction;
            tail.omnidirectional(&sea, k) * cosine_spreading(angle, tail.spreading(&sea, k)) / k
        }
    }

    /// Returns the moments of the waves with `low ≤ k < high`, integrated by Gauss–Legendre panels in `ln k`. `high` may be infinite.
    pub fn moments(&self, low: f64, high: f64) -> WaveMoments {
        let (low, high) = (low.max(self.peak_wave_number() * 0.05), high.min(SHORTEST));
        let mut sum = WaveMoments::default();
        if high <= low {
            return sum;
        }
        let tail = Tail::new(self);
        let (sin2, cos2) = (2.0 * self.wind_direction).sin_cos();
        for (x, weight) in leadr_reflectance::quadrature::composite_gauss(low.ln(), high.ln(), 40, 8) {
            let k = x.exp();
            let variance = tail.omnidirectional(self, k) * k * weight;
            // The value is E[cos 2θ] of cos^2s(θ/2). E[sin 2θ] relative to the wind is 0.
            let s = tail.spreading(self, k);
            let second = s * (s - 1.0) / ((s + 1.0) * (s + 2.0));
            let steep = 0.5 * variance * k * k;
            sum.height += variance;
            sum.slopes[0] += steep * (1.0 + second * cos2);
            sum.slopes[1] += steep * (1.0 - second * cos2);
            sum.slopes[2] += steep * second * sin2;
        }
        sum
    }

    /// Returns the significant wave height in metres, which is four standard deviations of the height.
    pub fn significant_height(&self) -> f64 {
        4.0 * self.moments(0.0, f64::INFINITY).height.sqrt()
    }
}

/// The terms of Elfouhaily's spectrum that depend on the wind.
struct Tail {
    peak: f64,
    /// The inverse wave age.
    age: f64,
    /// The phase speed of the peak in m/s.
    peak_speed: f64,
    /// The level of the equilibrium range, Elfouhaily's `α_p`.
    equilibrium: f64,
    /// The level of the gravity–capillary range, Elfouhaily's `α_m`.
    level: f64,
    /// The value of Elfouhaily's `0.13 u* / c_m`.
    crossing: f64,
}

impl Tail {
    fn new(sea: &Sea) -> Self {
        let peak = sea.peak_wave_number();
        let peak_speed = sea.peak_frequency() / peak;
        // The drag coefficient, which determines the friction velocity, grows with the wind.
        let friction = sea.wind_speed * ((0.8 + 0.065 * sea.wind_speed) * 1e-3).sqrt();
        let ratio = (friction / SLOWEST).ln();
        let level = 0.01 * (1.0 + if ratio < 0.0 { ratio } else { 3.0 * ratio });
        let age = sea.wind_speed / peak_speed;
        Self {
            peak,
            age,
            peak_speed,
            equilibrium: 0.006 * age.sqrt(),
            level: level.max(0.0),
            crossing: 0.13 * friction / SLOWEST,
        }
    }

    fn omnidirectional(&self, sea: &Sea, k: f64) -> f64 {
        let omega = sea.angular_frequency(k);
        let roll_off = (-self.age / 10f64.sqrt() * ((k / self.peak).sqrt() - 1.0).max(0.0)).exp();
        let cut_off = (-1.25 * (self.peak / k).powi(2)).exp();
        let mut long = sea.tma(omega) * sea.group_speed(k);
        if k > self.peak {
            long = long.max(0.5 * self.equilibrium * (self.peak_speed * k / omega) * cut_off / (k * k * k));
        }
        let slowest_at = 2.0 * GRAVITY / (SLOWEST * SLOWEST);
        let shape = (-0.25 * (k / slowest_at - 1.0).powi(2)).exp() * cut_off;
        long * roll_off + 0.5 * self.level * (SLOWEST * k / omega) * shape / (k * k * k)
    }

    fn spreading(&self, sea: &Sea, k: f64) -> f64 {
        let speed = sea.angular_frequency(k) / k;
        let delta = (0.25 * 2f64.ln()
            + 4.0 * (speed / self.peak_speed).powf(2.5)
            + self.crossing * (SLOWEST / speed).powf(2.5))
        .tanh();
        // The equation E[cos 2θ] = Δ/2 = s (s − 1) / ((s + 1)(s + 2)) is solved for s.
        let x = 0.5 * delta;
        let b = 1.0 + 3.0 * x;
        (b + (b * b + 8.0 * x * (1.0 - x)).sqrt()) / (2.0 * (1.0 - x))
    }
}

/// Returns `cos^2s(θ/2)`, normalised over the circle.
fn cosine_spreading(theta: f64, s: f64) -> f64 {
    let cosine = (0.5 * theta).cos().abs();
    let norm = (ln_gamma(s + 1.0) - ln_gamma(s + 0.5)).exp() / (2.0 * PI.sqrt());
    norm * cosine.powf(2.0 * s)
}

/// Returns `ln Γ(x)` for `x > 0` by Stirling's series, shifted to `x ≥ 8`, with an error below 1e-12.
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 8.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    let series = (1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r / 1680.0))) / x;
    shift + (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_and_the_spreading_are_normalised() {
        for (x, value) in [(0.5, PI.sqrt().ln()), (1.0, 0.0), (5.0, 24f64.ln()), (11.0, 3_628_800f64.ln())] {
            assert!((ln_gamma(x) - value).abs() < 1e-11, "{x}");
        }
        for s in [0.7, 1.0, 2.5, 9.0] {
            let n = 4000;
            let (mut sum, mut second) = (0.0, 0.0);
            for i in 0..n {
                let theta = TAU * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
                let d = cosine_spreading(theta, s) * TAU / f64::from(n);
                sum += d;
                second += d * (2.0 * theta).cos();
            }
            assert!((sum - 1.0).abs() < 1e-4, "{s} {sum}");
            assert!((second - s * (s - 1.0) / ((s + 1.0) * (s + 2.0))).abs() < 1e-4, "{s} {second}");
        }
    }

    #[test]
    fn group_speed_is_the_derivative_of_the_frequency() {
        for depth in [2.0, 20.0, 1000.0] {
            let sea = Sea { depth, ..Sea::default() };
            for k in [0.01, 0.3, 5.0, 400.0] {
                let h = 1e-4 * k;
                let numeric = (sea.angular_frequency(k + h) - sea.angular_frequency(k - h)) / (2.0 * h);
                assert!((sea.group_speed(k) / numeric - 1.0).abs() < 1e-6, "{depth} {k}");
            }
        }
    }

    #[test]
    fn the_frequency_spectrum_keeps_its_variance_in_wave_numbers() {
        // Only the long waves satisfy S(k) dk = S(ω) dω. The roll-off of the long waves and the short waves hardly change the height.
        let sea = Sea { wind_speed: 10.0, fetch: 100e3, depth: 1000.0, ..Sea::default() };
        let n = 20_000;
        let (low, high) = (0.3, 20.0f64);
        let step = (high - low) / f64::from(n);
        let variance: f64 = (0..n).map(|i| sea.tma(low + (f64::from(i) + 0.5) * step) * step).sum();
        let all = sea.moments(0.0, f64::INFINITY).height;
        assert!((all / variance - 1.0).abs() < 0.03, "{all} {variance}");
        // JONSWAP's significant height at this fetch is 2.1 m.
        assert!((sea.significant_height() - 2.1).abs() < 0.1);
    }

    #[test]
    fn slopes_follow_the_wind_as_cox_and_munk_saw_them() {
        // Cox and Munk fitted the slopes on clean water to the wind at 12.5 m: cross-wind 0.003 + 0.00192 U, along-wind 0.00316 U, each ±
        // 0.004. By the logarithmic law, the wind at 12.5 m is 2 % above the wind at 10 m.
        for wind_speed in [5.0, 7.0, 8.0, 10.0, 12.0, 14.0] {
            let sea = Sea { wind_speed, wind_direction: 0.0, fetch: 100e3, depth: 1000.0 };
            let [up, cross, mixed] = sea.moments(0.0, f64::INFINITY).slopes;
            let (across, along) = (0.003 + 0.00192 * 1.02 * wind_speed, 0.00316 * 1.02 * wind_speed);
            let ratios = [(up + cross) / (across + along), cross / across, up / along];
            println!(
                "{wind_speed} m/s: {up:.4} + {cross:.4}, Cox and Munk {along:.4} + {across:.4}; ratios {ratios:.3?}"
            );
            for (ratio, tolerance) in ratios.into_iter().zip([0.08, 0.08, 0.15]) {
                assert!((ratio - 1.0).abs() < tolerance, "{wind_speed} m/s: {ratios:?}");
            }
            assert!(mixed.abs() < 1e-12);
        }
    }

    #[test]
    fn rotating_the_wind_rotates_the_slopes_and_the_density_integrates_to_the_moments() {
        let sea = Sea { wind_direction: 0.7, ..Sea::default() };
        let density = sea.density();
        let (low, high) = (0.2, 2.0f64);
        let (rings, spokes) = (400, 256);
        let mut sum = WaveMoments::default();
        for i in 0..rings {
            let k = low * (high / low).powf((f64::from(i) + 0.5) / f64::from(rings));
            let dk = k * (high / low).ln() / f64::from(rings);
            for j in 0..spokes {
                let angle = TAU * f64::from(j) / f64::from(spokes);
                let (kx, ky) = (k * angle.cos(), k * angle.sin());
                let v = density(kx, ky) * k * dk * TAU / f64::from(spokes);
                sum.height += v;
                sum.slopes[0] += v * kx * kx;
                sum.slopes[1] += v * ky * ky;
                sum.slopes[2] += v * kx * ky;
            }
        }
        let exact = sea.moments(low, high);
        assert!((sum.height / exact.height - 1.0).abs() < 1e-3);
        for i in 0..3 {
            assert!((sum.slopes[i] - exact.slopes[i]).abs() < 1e-3 * exact.slopes[0], "{i} {sum:?} {exact:?}");
        }
    }

    #[test]
    fn shallow_water_has_lower_waves() {
        let deep = Sea { wind_speed: 15.0, fetch: 300e3, depth: 500.0, wind_direction: 0.0 };
        let shallow = Sea { depth: 8.0, ..deep };
        assert!(shallow.significant_height() < 0.6 * deep.significant_height());
    }
}
