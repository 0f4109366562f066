//! An analytic clear sky with a movable sun: Rayleigh and aerosol scattering and ozone over a spherical Earth, single
//! scattering integrated numerically, the higher orders as an isotropic series (Hillaire 2020, "A Scalable and
//! Production Ready Sky and Atmosphere Rendering Technique"), a lambertian ground below a soft horizon.
//!
//! This file is the model in 64 bits and its documentation; `shaders-glsl/passes/sky.glsl` is the same in 32 bits with
//! the same names, and `tests/environment.rs` holds one against the other. The sun's disk is not in the sky: it is
//! the directional light [`Sky::sun_irradiance`], attenuated by the same air, in the same units.
//!
//! Three small tables stand between the integrals and the picture: the isotropic multiple scattering by altitude, the
//! scattering integrals without their phase functions by view direction (smooth, so 64×16 entries are enough), and
//! the light on the ground. The phase functions are applied per texel, so the glow around the sun is not filtered.

use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Rows of the view table: elevation `π/2·(row/(ROWS−1))²`.
pub const ROWS: usize = 64;
/// Columns of the view table: azimuth from the sun `π·column/(COLUMNS−1)`.
pub const COLUMNS: usize = 16;
/// Entries of the multiple scattering table: altitude `ATMOSPHERE·(i/(ALTITUDES−1))²`.
pub const ALTITUDES: usize = 16;

/// Earth's radius, km.
const EARTH: f64 = 6360.0;
/// Thickness of the atmosphere, km.
const ATMOSPHERE: f64 = 100.0;
/// Scale heights of air and aerosol, km.
const AIR_HEIGHT: f64 = 8.0;
const HAZE_HEIGHT: f64 = 1.2;
/// Ozone: a tent around this altitude with this half width, km.
const OZONE_CENTRE: f64 = 25.0;
const OZONE_HALF_WIDTH: f64 = 15.0;
/// Scattering and absorption per km at the ground (ozone: at its centre) at 630, 550 and 450 nm, which stand for the
/// Rec.709 primaries: λ⁻⁴·⁰⁸ through 0.01356 at 550 nm for air, the Chappuis band for ozone. (The primaries' dominant
/// wavelengths 612, 549, 465 make the zenith too white; 680, 550, 440, often used, make sunlight too orange.)
const AIR: DVec3 = DVec3::new(0.007_79, 0.013_56, 0.030_75);
const OZONE: DVec3 = DVec3::new(0.001_90, 0.001_88, 0.000_14);
/// Aerosol extinction relative to 550 nm (Ångström exponent 1.3), its single-scattering albedo and asymmetry.
const HAZE: DVec3 = DVec3::new(0.838, 1.0, 1.298);
const HAZE_ALBEDO: f64 = 0.92;
const HAZE_ASYMMETRY: f64 = 0.76;
/// Vertical optical thickness of air at 550 nm, the unit of turbidity.
const AIR_THICKNESS: f64 = 0.013_56 * AIR_HEIGHT;
/// Sunlight above the atmosphere: white (pictures are balanced for it), so that a mid-morning sun gives about 3.
const SUNLIGHT: DVec3 = DVec3::splat(4.8);
/// Angular radius of the sun, radians: how fast it sets.
const SUN_RADIUS: f64 = 0.004_65;
/// Width of the haze band in which the ground fades into the horizon, as a sine of elevation.
const HORIZON: f64 = 0.02;
/// Steps along a path to the sun and along a view ray, and directions per axis of the multiple scattering.
const SUN_STEPS: usize = 24;
const VIEW_STEPS: usize = 32;
const SPHERE_STEPS: usize = 8;

/// A clear sky over flat ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Towards the sun, world, z up; need not be unit.
    pub sun_direction: Vec3,
    /// Optical thickness of haze and air together over that of air, 1 (pure air) to 10 (mist).
    pub turbidity: f32,
    /// Linear albedo of the ground, `[0, 1]`.
    pub ground_albedo: [f32; 3],
    /// Scale of sun and sky; at 1 a mid-morning sun gives an irradiance of about 3.
    pub intensity: f32,
}

impl Default for Sky {
    /// A clear mid-morning: the sun 40° high in the south-east (world +y is north).
    fn default() -> Self {
        Self::with_sun(0.70, -0.80)
    }
}

impl Sky {
    /// The default air and ground with the sun at `elevation` and `azimuth` (from +x towards +y), radians.
    #[must_use]
    pub fn with_sun(elevation: f32, azimuth: f32) -> Self {
        let (se, ce) = elevation.sin_cos();
        let (sa, ca) = azimuth.sin_cos();
        Self {
            sun_direction: Vec3::new(ce * ca, ce * sa, se),
            turbidity: 2.2,
            ground_albedo: [0.22, 0.20, 0.17],
            intensity: 1.0,
        }
    }

    /// RGB irradiance of the sun on a surface that faces it, at the ground; fades to 0 as the disk sets.
    #[must_use]
    pub fn sun_irradiance(&self) -> [f32; 3] {
        (self.sunlight() * sun_transmittance(0.0, self.sun().z, self.haze())).to_array().map(|x| x as f32)
    }

    /// Integrates the tables: some 30 ms of one core. The GPU pass does the same every time the sun moves.
    #[must_use]
    pub fn tables(&self) -> SkyTables {
        SkyTables::new(self)
    }

    /// Unit direction of the sun; a zero or non-finite direction means the zenith.
    pub(crate) fn sun(&self) -> DVec3 {
        self.sun_direction.as_dvec3().try_normalize().unwrap_or(DVec3::Z)
    }

    /// Aerosol extinction at the ground at 550 nm, per km.
    pub(crate) fn haze(&self) -> f64 {
        (f64::from(self.turbidity).clamp(1.0, 20.0) - 1.0) * AIR_THICKNESS / HAZE_HEIGHT
    }

    /// RGB irradiance of the sun above the atmosphere.
    pub(crate) fn sunlight(&self) -> DVec3 {
        SUNLIGHT * f64::from(self.intensity.max(0.0))
    }

    /// The ground's albedo, within `[0, 1]`.
    pub(crate) fn albedo(&self) -> DVec3 {
        Vec3::from(self.ground_albedo).as_dvec3().clamp(DVec3::ZERO, DVec3::ONE)
    }
}

/// Altitude after `t` km from altitude `h` along a ray with zenith cosine `mu`, km; written without the difference of
/// two radii, which in 32 bits would leave half a metre.
fn altitude_along(h: f64, mu: f64, t: f64) -> f64 {
    let r = EARTH + h;
    let excess = h * (2.0 * EARTH + h) + t * t + 2.0 * r * t * mu;
    excess / ((EARTH * EARTH + excess).max(0.0).sqrt() + EARTH)
}

/// Distance from altitude `h` to the top of the atmosphere, km.
fn distance_to_top(h: f64, mu: f64) -> f64 {
    let r = EARTH + h;
    let gap = (ATMOSPHERE - h) * (2.0 * EARTH + ATMOSPHERE + h);
    let b = r * mu;
    let root = (b * b + gap.max(0.0)).sqrt();
    if b > 0.0 { gap / (root + b) } else { root - b }
}

/// Distance from altitude `h` to the ground, km; negative when the ray misses it.
fn distance_to_ground(h: f64, mu: f64) -> f64 {
    let r = EARTH + h;
    let gap = h * (2.0 * EARTH + h);
    let discriminant = r * r * mu * mu - gap;
    if mu >= 0.0 || discriminant < 0.0 { -1.0 } else { gap / (discriminant.sqrt() - r * mu) }
}

/// Densities of air, aerosol and ozone at an altitude, relative to where their coefficients are given.
fn densities(h: f64) -> DVec3 {
    let h = h.max(0.0);
    let ozone = (1.0 - (h - OZONE_CENTRE).abs() / OZONE_HALF_WIDTH).max(0.0);
    DVec3::new((-h / AIR_HEIGHT).exp(), (-h / HAZE_HEIGHT).exp(), ozone)
}

fn extinction(density: DVec3, haze: f64) -> DVec3 {
    AIR * density.x + HAZE * (haze * density.y) + OZONE * density.z
}

fn scattering_of_haze(density: DVec3, haze: f64) -> DVec3 {
    HAZE * (HAZE_ALBEDO * haze * density.y)
}

fn exp3(v: DVec3) -> DVec3 {
    DVec3::new(v.x.exp(), v.y.exp(), v.z.exp())
}

/// `(1 − exp(−x)) / x`, kept accurate towards 0.
fn share_within(x: DVec3) -> DVec3 {
    let one = |x: f64| if x < 1e-2 { 1.0 - x * (0.5 - x / 6.0) } else { (1.0 - (-x).exp()) / x };
    DVec3::new(one(x.x), one(x.y), one(x.z))
}

/// What share of the sun's light arrives at altitude `h` when its zenith cosine is `mu`: air, and the setting disk.
fn sun_transmittance(h: f64, mu: f64, haze: f64) -> DVec3 {
    let ratio = EARTH / (EARTH + h);
    let horizon = -(1.0 - ratio * ratio).max(0.0).sqrt();
    let risen = ((mu - horizon) / (2.0 * SUN_RADIUS) + 0.5).clamp(0.0, 1.0);
    if risen == 0.0 {
        return DVec3::ZERO;
    }
    // t = length·s³: short steps low down, where the aerosol is
    let length = distance_to_top(h, mu);
    let mut depth = DVec3::ZERO;
    for i in 0..SUN_STEPS {
        let s = (i as f64 + 0.5) / SUN_STEPS as f64;
        let dt = 3.0 * s * s * length / SUN_STEPS as f64;
        depth += dt * densities(altitude_along(h, mu, length * s * s * s));
    }
    risen * risen * (3.0 - 2.0 * risen) * exp3(-extinction(depth, haze))
}

/// Scattering integrals along a ray per unit of sunlight, without phase functions.
#[derive(Clone, Copy, Debug, Default)]
struct Scattered {
    air: DVec3,
    haze: DVec3,
    /// Light scattered more than once (view rays), or the share of isotropic light scattered (multiple scattering).
    multiple: DVec3,
    transmittance: DVec3,
}

/// Marches from altitude `h` over `length` km. `mu`: zenith cosine of the ray, `mu_sun`: of the sun, `nu`: between them.
fn march(h: f64, mu: f64, mu_sun: f64, nu: f64, length: f64, haze: f64, multiple: impl Fn(f64) -> DVec3) -> Scattered {
    let mut sum = Scattered { transmittance: DVec3::ONE, ..Scattered::default() };
    let r = EARTH + h;
    for i in 0..VIEW_STEPS {
        // t = length·s², the step's ends at s = i/n: the mean density is taken at its middle
        let (s0, s1) = (i as f64 / VIEW_STEPS as f64, (i as f64 + 1.0) / VIEW_STEPS as f64);
        let (t0, t1) = (length * s0 * s0, length * s1 * s1);
        let (t, dt) = (0.5 * (t0 + t1), t1 - t0);
        let height = altitude_along(h, mu, t).max(0.0);
        let density = densities(height);
        let sigma = extinction(density, haze);
        let step = exp3(-sigma * dt);
        // exact within the step for constant density: never brighter than what the step can scatter
        let weight = sum.transmittance * share_within(sigma * dt) * dt;
        let sun = sun_transmittance(height, (r * mu_sun + t * nu) / (EARTH + height), haze);
        let air = AIR * density.x;
        let aerosol = scattering_of_haze(density, haze);
        sum.air += weight * sun * air;
        sum.haze += weight * sun * aerosol;
        sum.multiple += weight * (air + aerosol) * multiple(height);
        sum.transmittance *= step;
    }
    sum
}

/// Rayleigh's phase function, per steradian.
fn phase_of_air(nu: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + nu * nu)
}

/// Cornette and Shanks' phase function for the aerosol, per steradian.
fn phase_of_haze(nu: f64) -> f64 {
    let g = HAZE_ASYMMETRY;
    let g2 = g * g;
    let base = (1.0 + g2 - 2.0 * g * nu).max(1e-6);
    3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + nu * nu) / ((2.0 + g2) * base * base.sqrt())
}

/// What the sky needs per sun position; all per unit of sunlight above the atmosphere.
#[derive(Clone, Debug)]
pub struct SkyTables {
    sky: Sky,
    multiple: Vec<DVec3>,
    view: Vec<[DVec3; 3]>,
    irradiance: DVec3,
    ground: DVec3,
}

impl SkyTables {
    fn new(sky: &Sky) -> Self {
        let (sun, haze, albedo) = (sky.sun(), sky.haze(), sky.albedo());
        let multiple: Vec<DVec3> = (0..ALTITUDES)
            .map(|i| {
                let s = i as f64 / (ALTITUDES - 1) as f64;
                multiple_at(ATMOSPHERE * s * s, sun.z, haze, albedo)
            })
            .collect();
        let mut tables = Self {
            sky: *sky,
            multiple,
            view: Vec::with_capacity(ROWS * COLUMNS),
            ground: DVec3::ZERO,
            irradiance: DVec3::ZERO,
        };
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let (mu, nu) = tables.view_cosines(row as f64, column as f64);
                let ray = march(0.0, mu, sun.z, nu, distance_to_top(0.0, mu), haze, |h| tables.multiple_along(h));
                tables.view.push([ray.air, ray.haze, ray.multiple]);
            }
        }
        // the sky's irradiance on the ground: midpoints between the rows, trapezium in azimuth
        let mut irradiance = DVec3::ZERO;
        for row in 0..ROWS - 1 {
            let span = FRAC_PI_2_SQUARED_ROWS * (2.0 * row as f64 + 1.0);
            for column in 0..COLUMNS {
                let edge = if column == 0 || column == COLUMNS - 1 { 0.5 } else { 1.0 };
                let (mu, nu) = tables.view_cosines(row as f64 + 0.5, column as f64);
                let weight = edge * 2.0 * PI / (COLUMNS - 1) as f64 * span * mu * (1.0 - mu * mu).max(0.0).sqrt();
                irradiance += weight * tables.scattered(row as f64 + 0.5, column as f64, nu);
            }
        }
        let direct = sun_transmittance(0.0, sun.z, haze) * sun.z.max(0.0);
        tables.irradiance = irradiance;
        tables.ground = albedo / PI * (irradiance + direct);
        tables
    }

    /// Radiance arriving from a unit world direction, RGB, without the sun's disk.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let sun = self.sky.sun();
        // below the horizon: the horizon above the same azimuth, into which the ground fades
        let mut w = direction;
        w.z = w.z.max(0.0);
        let w = w.try_normalize().unwrap_or(DVec3::X);
        let level = w.truncate().length();
        let elevation = w.z.atan2(level);
        let row = (elevation / (PI / 2.0)).max(0.0).sqrt() * (ROWS - 1) as f64;
        let across = w.x * sun.y - w.y * sun.x;
        let along = w.x * sun.x + w.y * sun.y;
        let azimuth = if across == 0.0 && along == 0.0 { 0.0 } else { across.abs().atan2(along) };
        let column = azimuth / PI * (COLUMNS - 1) as f64;
        let sky = self.scattered(row, column, w.dot(sun));
        let ground = if direction.z < 0.0 { 1.0 - (direction.z / HORIZON).exp() } else { 0.0 };
        self.sky.sunlight() * sky.lerp(self.ground, ground)
    }

    /// RGB irradiance of the sky, without the sun, on level ground.
    #[must_use]
    pub fn ground_irradiance(&self) -> DVec3 {
        self.sky.sunlight() * self.irradiance
    }

    /// Zenith cosine of a place in the view table, and its cosine to the sun.
    fn view_cosines(&self, row: f64, column: f64) -> (f64, f64) {
        let s = row / (ROWS - 1) as f64;
        let (mu, level) = (PI / 2.0 * s * s).sin_cos();
        let sun = self.sky.sun();
        (mu, mu * sun.z + level * sun.truncate().length() * (PI * column / (COLUMNS - 1) as f64).cos())
    }

    /// Radiance per unit of sunlight at a place in the view table (bilinear) whose cosine to the sun is `nu`.
    fn scattered(&self, row: f64, column: f64, nu: f64) -> DVec3 {
        let r = (row as usize).min(ROWS - 2);
        let c = (column as usize).min(COLUMNS - 2);
        let (fr, fc) = (row - r as f64, column - c as f64);
        let at = |k: usize, r: usize, c: usize| self.view[r * COLUMNS + c][k];
        let mix = |k| at(k, r, c).lerp(at(k, r, c + 1), fc).lerp(at(k, r + 1, c).lerp(at(k, r + 1, c + 1), fc), fr);
        phase_of_air(nu) * mix(0) + phase_of_haze(nu) * mix(1) + mix(2)
    }

    /// The multiple scattering table at an altitude, linear in its square root.
    fn multiple_along(&self, h: f64) -> DVec3 {
        let x = (h / ATMOSPHERE).clamp(0.0, 1.0).sqrt() * (ALTITUDES - 1) as f64;
        let i = (x as usize).min(ALTITUDES - 2);
        self.multiple[i].lerp(self.multiple[i + 1], x - i as f64)
    }
}

/// `(π/2)/(ROWS−1)²`: the elevation spanned by table row k is this times `2k + 1`.
const FRAC_PI_2_SQUARED_ROWS: f64 = PI / 2.0 / ((ROWS - 1) * (ROWS - 1)) as f64;

/// Isotropic radiance of all orders above the first at an altitude: second order over one minus the share of light
/// that each further order keeps (Hillaire 2020, eq. 5–10).
fn multiple_at(h: f64, mu_sun: f64, haze: f64, albedo: DVec3) -> DVec3 {
    let mut second = DVec3::ZERO;
    let mut kept = DVec3::ZERO;
    let isotropic = 1.0 / (4.0 * PI);
    let level_sun = (1.0 - mu_sun * mu_sun).max(0.0).sqrt();
    for i in 0..SPHERE_STEPS {
        for j in 0..SPHERE_STEPS {
            let mu = (2.0 * i as f64 + 1.0) / SPHERE_STEPS as f64 - 1.0;
            let phi = PI * (j as f64 + 0.5) / SPHERE_STEPS as f64;
            let nu = mu * mu_sun + (1.0 - mu * mu).sqrt() * level_sun * phi.cos();
            let ground = distance_to_ground(h, mu);
            let length = if ground >= 0.0 { ground } else { distance_to_top(h, mu) };
            let ray = march(h, mu, mu_sun, nu, length, haze, |_| DVec3::ONE);
            second += isotropic * (ray.air + ray.haze);
            kept += isotropic * ray.multiple;
            if ground >= 0.0 {
                let mu_there = ((EARTH + h) * mu_sun + length * nu) / EARTH;
                let lit = sun_transmittance(0.0, mu_there, haze) * mu_there.max(0.0);
                second += ray.transmittance * lit * albedo / PI;
            }
        }
    }
    // each direction stands for 4π/64 sr
    let weight = 4.0 * PI / (SPHERE_STEPS * SPHERE_STEPS) as f64;
    (second * weight * isotropic) / (DVec3::ONE - kept * weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(c: DVec3) -> f64 {
        c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn mid_morning_has_the_documented_light() {
        let sky = Sky::default();
        let sun = luminance(Vec3::from(sky.sun_irradiance()).as_dvec3());
        let diffuse = luminance(sky.tables().ground_irradiance());
        assert!((2.7..3.5).contains(&sun), "{sun}");
        assert!((0.55..0.95).contains(&diffuse), "{diffuse}");
        let zenith = sky.tables().radiance(DVec3::Z);
        assert!(zenith.z > 1.5 * zenith.x, "the zenith is blue: {zenith}");
    }

    #[test]
    fn optical_depths_match_closed_forms_and_fine_integration() {
        // straight up, an exponential atmosphere has its scale height as depth (and the ozone tent its half width)
        let depth = |n: usize, h: f64, mu: f64| {
            let length = distance_to_top(h, mu);
            (0..n).fold(DVec3::ZERO, |sum, i| {
                let s = (i as f64 + 0.5) / n as f64;
                sum + 3.0 * s * s * length / n as f64 * densities(altitude_along(h, mu, length * s * s * s))
            })
        };
        let up = depth(SUN_STEPS, 0.0, 1.0);
        assert!((up.x / AIR_HEIGHT - 1.0).abs() < 1e-4 && (up.y / HAZE_HEIGHT - 1.0).abs() < 1e-4, "{up}");
        for (h, mu) in [(0.0, 0.0), (0.0, 0.1), (1.0, 0.02), (10.0, -0.02), (10.0, 0.5)] {
            let (coarse, fine) = (depth(SUN_STEPS, h, mu), depth(50_000, h, mu));
            let air = ((coarse - fine) / fine).abs();
            assert!(air.x < 1e-4 && air.y < 1e-3 && air.z < 0.06, "h {h} mu {mu}: {air}");
        }
    }

    #[test]
    fn transmittance_at_the_zenith_is_beers_law() {
        let sky = Sky { sun_direction: Vec3::Z, turbidity: 1.0, ..Sky::default() };
        let law = exp3(-(AIR * AIR_HEIGHT + OZONE * OZONE_HALF_WIDTH)) * SUNLIGHT;
        let got = Vec3::from(sky.sun_irradiance()).as_dvec3();
        assert!(((got - law) / law).abs().max_element() < 1e-3, "{got} {law}");
    }

    #[test]
    fn phase_functions_integrate_to_one() {
        let n = 20_000;
        for phase in [phase_of_air as fn(f64) -> f64, phase_of_haze] {
            let sum: f64 = (0..n).map(|i| phase((2.0 * i as f64 + 1.0) / n as f64 - 1.0)).sum();
            assert!((sum * 4.0 * PI / n as f64 - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_sky_neither_makes_nor_swallows_much_light() {
        // what leaves the ground upwards, the air keeps no more than ozone and aerosol absorb: sun and sky together
        // on level ground must stay below the sunlight that enters, and above a half of it
        for elevation in [20.0f32, 40.0, 80.0] {
            let sky = Sky { ground_albedo: [0.0; 3], ..Sky::with_sun(elevation.to_radians(), 0.0) };
            let sun = Vec3::from(sky.sun_irradiance()).as_dvec3() * sky.sun().z;
            let share = (sun + sky.tables().ground_irradiance()) / (SUNLIGHT * sky.sun().z);
            assert!(share.max_element() < 1.0 && share.min_element() > 0.5, "{elevation}: {share}");
        }
    }

    #[test]
    fn tables_interpolate_the_integral() {
        let sky = Sky::with_sun(0.3, 0.0);
        let tables = sky.tables();
        let mut worst = 0.0f64;
        for i in 0..200 {
            let (row, column) = (1.0 + 61.0 * f64::from(i) / 199.0, 14.9 * f64::from(i * 37 % 200) / 199.0);
            let (mu, nu) = tables.view_cosines(row, column);
            let ray =
                march(0.0, mu, sky.sun().z, nu, distance_to_top(0.0, mu), sky.haze(), |h| tables.multiple_along(h));
            let exact = phase_of_air(nu) * ray.air + phase_of_haze(nu) * ray.haze + ray.multiple;
            worst = worst.max(((tables.scattered(row, column, nu) - exact) / exact).abs().max_element());
        }
        println!("bilinear table against the integral: {worst:.4}");
        assert!(worst < 0.02, "{worst}");
    }

    #[test]
    fn no_sun_below_the_horizon_and_no_bad_numbers() {
        for elevation in [-1.5f32, -0.2, -0.01, 0.0, 0.01, 1.57] {
            let sky = Sky { turbidity: 10.0, ..Sky::with_sun(elevation, 2.0) };
            let tables = sky.tables();
            assert!(elevation > -0.005 || sky.sun_irradiance() == [0.0; 3]);
            for w in [DVec3::Z, DVec3::X, -DVec3::Z, DVec3::new(0.6, 0.0, -0.8), sky.sun()] {
                let l = tables.radiance(w);
                assert!(l.is_finite() && l.min_element() >= 0.0, "{elevation} {w}: {l}");
            }
        }
    }
}
