//! The exposure of an image. Under the sky it follows the sun's elevation like a partly adapted eye: dusk is dimmer than noon, and
//! night is darker. Under a panorama it is metered, because the unit of the radiance is unknown.

use super::sky::Sky;
use super::texels::Texels;
use leadr_maps::RgbImage;

/// The luminance of level ground under sun and sky, by the elevation of the sun in degrees, for the default atmosphere at intensity
/// 1.
const LEVEL: [(f32, f32); 16] = [
    (-18.0, 4.755e-4),
    (-15.0, 4.755e-4),
    (-12.0, 4.756e-4),
    (-9.0, 4.794e-4),
    (-7.0, 5.254e-4),
    (-5.0, 1.027e-3),
    (-3.0, 4.679e-3),
    (-1.0, 1.847e-2),
    (0.0, 3.067e-2),
    (1.0, 4.694e-2),
    (3.0, 9.500e-2),
    (6.0, 2.168e-1),
    (10.0, 4.563e-1),
    (18.0, 1.051),
    (28.0, 1.831),
    (38.0, 2.559),
];

/// Fractions of the brightness difference, in stops, that the exposure compensates: of the first stops, and of those beyond.
const ADAPTATION: [f32; 2] = [0.68, 0.75];
/// Number of stops with the first fraction.
const FIRST_STOPS: f32 = 6.0;

/// Returns the factor on the radiance under `sky`: 1 from a mid-morning sun upwards, and about 500 at night.
pub fn exposure(sky: &Sky) -> f32 {
    let elevation = sky.sun_direction.normalize_or(glam::Vec3::Z).z.clamp(-1.0, 1.0).asin().to_degrees();
    let stops = (LEVEL[LEVEL.len() - 1].1 / level(elevation)).log2();
    let first = stops.min(FIRST_STOPS);
    (ADAPTATION[0] * first + ADAPTATION[1] * (stops - first)).exp2()
}

/// Returns the exposure factor for the radiance under a panorama. The factor makes level ground as bright as under a mid-morning
/// sky. A panorama that does not light the ground has the factor 1.
pub fn metered(panorama: &RgbImage) -> f32 {
    let irradiance = Texels::new(panorama).integral(panorama, |z| z.max(0.0));
    let factor = f64::from(LEVEL[LEVEL.len() - 1].1) / irradiance;
    if (1e-30..=1e30).contains(&factor) { factor as f32 } else { 1.0 }
}

/// Returns the luminance at an elevation in degrees. The table is interpolated log-linearly, and is constant beyond its ends.
fn level(elevation: f32) -> f32 {
    let next = LEVEL.partition_point(|entry| entry.0 <= elevation);
    if next == 0 || next == LEVEL.len() {
        return LEVEL[next.saturating_sub(1)].1;
    }
    let ((e0, l0), (e1, l1)) = (LEVEL[next - 1], LEVEL[next]);
    l0 * (l1 / l0).powf((elevation - e0) / (e1 - e0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use leadr_reflectance::color::luminance;

    #[test]
    fn the_table_is_the_skys() {
        let measured = LEVEL.map(|(degrees, _)| {
            let sky = Sky::with_sun(degrees.to_radians(), 0.0);
            let direct = Vec3::from(sky.sun_irradiance()).as_dvec3() * f64::from(degrees.to_radians().sin().max(0.0));
            luminance(direct + sky.tables().ground_irradiance()) as f32
        });
        for ((degrees, stored), measured) in LEVEL.into_iter().zip(measured) {
            assert!((stored / measured - 1.0).abs() < 0.02, "{degrees}: {stored} {measured:.3e}");
        }
    }

    #[test]
    fn panoramas_are_exposed_for_level_ground() {
        // A uniform sphere of radiance L gives level ground an irradiance of pi L.
        let even = |radiance: f32| RgbImage::new(64, 32, vec![[radiance; 3]; 64 * 32]).unwrap();
        for radiance in [1e-4, 1.0, 3e5] {
            let lit = f64::from(metered(&even(radiance)) * radiance) * std::f64::consts::PI;
            assert!((lit / f64::from(LEVEL[15].1) - 1.0).abs() < 2e-3, "{radiance}: {lit}");
        }
        assert_eq!(metered(&even(0.0)), 1.0);
        // Light from below does not reach the ground.
        let mut below = even(1.0);
        below.texels[..64 * 16].fill([0.0; 3]);
        assert_eq!(metered(&below), 1.0);
    }

    #[test]
    fn the_exposure_never_falls_as_the_sun_sets_and_daylight_keeps_its_own() {
        let at = |degrees: f32| exposure(&Sky::with_sun(degrees.to_radians(), 1.0));
        assert_eq!((at(38.1), at(60.0), at(90.0)), (1.0, 1.0, 1.0));
        let steps: Vec<f32> = (0..400).map(|i| at(39.0 - 0.2 * i as f32)).collect();
        assert!(steps.windows(2).all(|w| w[1] >= w[0] && w[1] / w[0] < 1.2), "{steps:?}");
        assert!((250.0..750.0).contains(&at(-40.0)), "{}", at(-40.0));
    }
}
