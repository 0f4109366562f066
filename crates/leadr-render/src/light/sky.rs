//! An analytic clear sky with a movable sun, Rayleigh scattering, aerosol scattering and ozone over a spherical Earth. Single
//! scattering is integrated numerically. Higher orders form an isotropic series (Hillaire 2020, "A Scalable and Production Ready
//! Sky and Atmosphere Rendering Technique"). The ground below a soft horizon is Lambertian.
//!
//! This file documents the model and computes it in 64 bits. `shaders-glsl/passes/light/sky.glsl` computes it in 32 bits with the
//! same names, and `tests/render/environment.rs` compares the results. The sky does not contain the disk of the sun. The disk is
//! the directional light [`Sky::sun_irradiance`], which has the same units and is attenuated by the same air.
//!
//! Three small tables hold the integrals. One table has the isotropic multiple scattering by altitude, and one has the light on the
//! ground. The third table has the scattering integrals without phase functions by view direction, which are smooth enough for
//! 64×16 entries. Phase functions are applied per texel, so the tables do not blur the glow around the sun.

use glam::{DVec3, Vec3};
use std::f64::consts::PI;

use super::atmosphere::{
    AIR_THICKNESS, distance_to_top, march, multiple_at, phase_of_air, phase_of_haze, sun_transmittance,
};
use super::constants::{self, AIR, ATMOSPHERE, HAZE, HAZE_HEIGHT, HORIZON, MOON, NIGHT, NIGHT_HORIZON, NIGHT_ZENITH};

/// The number of rows of the view table.
pub const ROWS: usize = constants::ROWS as usize;
/// The number of columns of the view table.
pub const COLUMNS: usize = constants::COLUMNS as usize;
/// The number of entries of the multiple scattering table.
pub const ALTITUDES: usize = constants::ALTITUDES as usize;

/// The sunlight above the atmosphere, which is white and scaled so that a mid-morning sun gives an irradiance of about 3.
const SUNLIGHT: DVec3 = DVec3::splat(4.8);
/// A clear sky over flat ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The direction towards the sun in world space, of any length. z is up.
    pub sun_direction: Vec3,
    /// The optical thickness of haze and air together, relative to air alone, from 1 (pure air) to 10 (mist).
    pub turbidity: f32,
    /// The linear albedo of the ground, from 0 to 1.
    pub ground_albedo: [f32; 3],
    /// The scale of sun and sky. At 1, the mid-morning sun gives an irradiance of about 3.
    pub intensity: f32,
}

impl Default for Sky {
    /// Returns a clear mid-morning sky, with the sun 40° high in the south-east. World +y is north.
    fn default() -> Self {
        Self::with_sun(0.70, -0.80)
    }
}

impl Sky {
    /// Returns a sky with the default atmosphere and ground. The sun is at `elevation` and `azimuth` (from +x towards +y), in
    /// radians.
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

    /// Returns the RGB irradiance of the sun on a surface at the ground that faces it. The irradiance fades to 0 as the disk sets.
    pub fn sun_irradiance(&self) -> [f32; 3] {
        (self.sunlight() * sun_transmittance(0.0, self.sun().z, self.haze())).to_array().map(|x| x as f32)
    }

    /// Returns the RGB irradiance of a full moon on a surface that faces it. The moon stands opposite to the sun, and brightens
    /// while the sun sinks from 1° to 7° below the horizon.
    pub fn moon_irradiance(&self) -> [f32; 3] {
        let t = ((-self.sun().z - 0.0175) / 0.105).clamp(0.0, 1.0);
        (self.sunlight() * MOON * (t * t * (3.0 - 2.0 * t))).to_array().map(|x| x as f32)
    }

    /// Returns the RGB extinction of air and haze at the ground, per metre.
    pub fn extinction(&self) -> Vec3 {
        ((AIR + HAZE * self.haze()) * 1e-3).as_vec3()
    }

    /// Integrates the tables, in about 30 ms on one core. The GPU pass does the same whenever the sun moves.
    pub fn tables(&self) -> SkyTables {
        SkyTables::new(self)
    }

    /// Returns the unit direction of the sun. A zero or non-finite direction becomes the zenith.
    pub(crate) fn sun(&self) -> DVec3 {
        self.sun_direction.as_dvec3().try_normalize().unwrap_or(DVec3::Z)
    }

    /// Returns the aerosol extinction at the ground at 550 nm, per km. Turbidity is clamped to the range from 1 to 20.
    pub(crate) fn haze(&self) -> f64 {
        (f64::from(self.turbidity).clamp(1.0, 20.0) - 1.0) * AIR_THICKNESS / HAZE_HEIGHT
    }

    /// Returns the RGB irradiance of the sun above the atmosphere.
    pub(crate) fn sunlight(&self) -> DVec3 {
        SUNLIGHT * f64::from(self.intensity.max(0.0))
    }

    /// Returns the albedo of the ground, clamped to the range from 0 to 1.
    pub(crate) fn albedo(&self) -> DVec3 {
        Vec3::from(self.ground_albedo).as_dvec3().clamp(DVec3::ZERO, DVec3::ONE)
    }
}

/// The tables for one position of the sun, per unit of sunlight above the atmosphere.
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
        // The sky's irradiance on the ground is integrated with the midpoint rule between rows, and with the trapezium rule in
        // azimuth.
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

    /// Returns the RGB radiance that arrives from a unit world direction, without the sun's disk.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let sun = self.sky.sun();
        // Below the horizon, the sky fades into the ground, starting with the horizon's radiance at the same azimuth.
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
        let airglow = NIGHT_ZENITH + (NIGHT_HORIZON - NIGHT_ZENITH) * (1.0 - direction.z.max(0.0)).powi(2);
        let night = (NIGHT * airglow).lerp(NIGHT * self.sky.albedo(), ground);
        self.sky.sunlight() * (sky.lerp(self.ground, ground) + night)
    }

    /// Returns the RGB irradiance of the sky on level ground, without the sun.
    pub fn ground_irradiance(&self) -> DVec3 {
        self.sky.sunlight() * (self.irradiance + PI * NIGHT)
    }

    /// Returns the cosines of the angles to the zenith and to the sun, at a position in the view table.
    fn view_cosines(&self, row: f64, column: f64) -> (f64, f64) {
        let s = row / (ROWS - 1) as f64;
        let (mu, level) = (PI / 2.0 * s * s).sin_cos();
        let sun = self.sky.sun();
        (mu, mu * sun.z + level * sun.truncate().length() * (PI * column / (COLUMNS - 1) as f64).cos())
    }

    /// Returns the radiance per unit of sunlight, interpolated bilinearly in the view table. `nu` is the cosine of the angle to the
    /// sun.
    fn scattered(&self, row: f64, column: f64, nu: f64) -> DVec3 {
        let r = (row as usize).min(ROWS - 2);
        let c = (column as usize).min(COLUMNS - 2);
        let (fr, fc) = (row - r as f64, column - c as f64);
        let at = |k: usize, r: usize, c: usize| self.view[r * COLUMNS + c][k];
        let mix = |k| at(k, r, c).lerp(at(k, r, c + 1), fc).lerp(at(k, r + 1, c).lerp(at(k, r + 1, c + 1), fc), fr);
        phase_of_air(nu) * mix(0) + phase_of_haze(nu) * mix(1) + mix(2)
    }

    /// Returns the multiple scattering at an altitude. The table is linear in the square root of the altitude.
    fn multiple_along(&self, h: f64) -> DVec3 {
        let x = (h / ATMOSPHERE).clamp(0.0, 1.0).sqrt() * (ALTITUDES - 1) as f64;
        let i = (x as usize).min(ALTITUDES - 2);
        self.multiple[i].lerp(self.multiple[i + 1], x - i as f64)
    }
}

/// The constant `(π/2)/(ROWS−1)²`. Row `k` of the view table spans an elevation of `2k + 1` times this constant.
const FRAC_PI_2_SQUARED_ROWS: f64 = PI / 2.0 / ((ROWS - 1) * (ROWS - 1)) as f64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::constants::{AIR_HEIGHT, OZONE, OZONE_HALF_WIDTH};
    use leadr_reflectance::color::luminance;

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
    fn transmittance_at_the_zenith_is_beers_law() {
        let sky = Sky { sun_direction: Vec3::Z, turbidity: 1.0, ..Sky::default() };
        let law = (-(AIR * AIR_HEIGHT + OZONE * OZONE_HALF_WIDTH)).exp() * SUNLIGHT;
        let got = Vec3::from(sky.sun_irradiance()).as_dvec3();
        assert!(((got - law) / law).abs().max_element() < 1e-3, "{got} {law}");
    }

    #[test]
    fn the_sky_neither_makes_nor_swallows_much_light() {
        // Only ozone and aerosol absorb light, so level ground must receive between half and all of the incoming sunlight.
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
    fn the_night_sky_is_brighter_at_the_horizon_and_keeps_its_irradiance() {
        let tables = Sky::with_sun(-0.6, 0.0).tables();
        let rings = 2000;
        let irradiance: DVec3 = (0..rings)
            .map(|i| {
                let z = (f64::from(i) + 0.5) / f64::from(rings);
                tables.radiance(DVec3::new((1.0 - z * z).sqrt(), 0.0, z)) * (2.0 * PI * z / f64::from(rings))
            })
            .sum();
        let wanted = tables.ground_irradiance();
        assert!(((irradiance - wanted) / wanted).abs().max_element() < 0.01, "{irradiance} {wanted}");
        assert!(tables.radiance(DVec3::X).y > 2.0 * tables.radiance(DVec3::Z).y);
    }

    #[test]
    fn the_moon_brightens_after_sunset() {
        let moon = |degrees: f32| Sky::with_sun(degrees.to_radians(), 0.0).moon_irradiance()[1];
        let rising: Vec<f32> = (0..200).map(|i| moon(0.5 - 0.05 * i as f32)).collect();
        assert!(rising.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 0.05 * moon(-30.0)), "{rising:?}");
        assert_eq!((moon(40.0), moon(-0.5)), (0.0, 0.0));
        assert!((2e-3..3e-3).contains(&moon(-7.0)), "{}", moon(-7.0));
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
