//! The lamps of a frame: its point lights and spots, and its directional lights beside the sun.

use super::relief_shadow::Caster;
use super::shade::SUN_RADIUS;
use super::shadow::ShadowView;
use crate::constants::{MAX_LAMP_MAPS, MAX_LAMPS};
use crate::scene::{FrameState, PointLight, Sun};
use crate::surfaces::sphere::Sphere;
use glam::Vec3;
use leadr_gpu::{Buffer, Result, shared_struct};

shared_struct! {
    /// A lamp as the shaders read it (`Lamp` in `passes/shade/lamps.glsl`).
    pub struct LampGpu for "Lamp" {
        /// The position, with w = 1. For a directional light, the direction toward the light, with w = 0.
        pub position: [f32; 4],
        /// The intensity or, for a directional light, the irradiance. The reciprocal of the squared range, or 0, is in w.
        pub power: [f32; 4],
        /// The spot cone, as [`Lamp::falloff`].
        pub falloff: [f32; 4],
    }
}

/// The size in bytes of a buffer with room for the lamps of any frame.
pub const BUFFER_SIZE: u64 = size_of::<LampGpu>() as u64 * MAX_LAMPS as u64;

/// A point light, a spot, or a directional light beside the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The position or the direction of the light.
    pub caster: Caster,
    /// The intensity of a point light, or the irradiance of a directional light.
    pub power: Vec3,
    /// The coefficients of the falloff of a spot's cone. If `d` is a unit direction away from the light, the factor is `clamp(d · xyz +
    /// w, 0, 1)²`.
    pub falloff: [f32; 4],
    /// The reciprocal of the squared range, or 0 without a range.
    pub inverse_square_range: f32,
    /// The radius of a point light in metres, or the tangent of the angular radius of a directional light.
    radius: f32,
}

impl Lamp {
    fn of_point(light: &PointLight) -> Self {
        Self {
            caster: Caster::Point(light.position),
            power: light.intensity,
            falloff: light.falloff(),
            inverse_square_range: light.inverse_square_range(),
            radius: light.radius.max(0.0),
        }
    }

    fn of_sun(sun: &Sun) -> Self {
        Self {
            caster: Caster::Directional(sun.direction.normalize_or(Vec3::Z)),
            power: sun.irradiance,
            falloff: [0.0, 0.0, 0.0, 1.0],
            inverse_square_range: 0.0,
            radius: SUN_RADIUS.tan(),
        }
    }

    /// Returns the lamp as the shaders read it.
    pub fn gpu(&self) -> LampGpu {
        let position = match self.caster {
            Caster::Directional(direction) => direction.extend(0.0),
            Caster::Point(position) => position.extend(1.0),
        };
        let power = self.power.extend(self.inverse_square_range);
        LampGpu { position: position.to_array(), power: power.to_array(), falloff: self.falloff }
    }

    /// Returns the view of the lamp's shadow map, with `size` texels a side, of the casters in a sphere.
    pub fn shadow_view(&self, casters: Sphere, size: u32) -> ShadowView {
        match self.caster {
            Caster::Directional(direction) => ShadowView::around(direction, casters, size),
            Caster::Point(position) => ShadowView::from_point(position, casters, size),
        }
    }

    /// Returns the width of the penumbra in texels of the shadow map per unit of depth, and the size of a texel at distance 1.
    pub fn penumbra(&self, view: &ShadowView) -> [f32; 4] {
        let wide = match self.caster {
            // The depth range of a parallel view equals its width.
            Caster::Directional(_) => self.radius * view.size as f32,
            Caster::Point(_) => self.radius / (view.texel * view.near),
        };
        [wide, view.texel, 0.0, 0.0]
    }

    /// Returns the irradiance at a sphere, apart from cones and ranges.
    fn irradiance(&self, at: Sphere) -> f32 {
        let square = match self.caster {
            Caster::Directional(_) => 1.0,
            Caster::Point(position) => {
                let distance = (position.distance(at.centre) - at.radius).max(0.25 * at.radius);
                distance * distance
            }
        };
        self.power.max_element() / square
    }
}

/// Lists the lamps of a frame. The first [`MAX_LAMP_MAPS`] lamps have shadow maps. If there are more lamps, these are the brightest at the
/// casters.
pub fn lamps_of(state: &FrameState, casters: Option<Sphere>) -> Vec<Lamp> {
    let points = state.point_lights.iter().map(Lamp::of_point);
    let mut lamps: Vec<Lamp> = points.chain(state.more_suns.iter().map(Lamp::of_sun)).collect();
    let mapped = MAX_LAMP_MAPS as usize;
    if let Some(casters) = casters.filter(|_| lamps.len() > mapped) {
        let mut order: Vec<usize> = (0..lamps.len()).collect();
        // Equally bright lamps keep their order, so that the choice is stable from frame to frame.
        order.sort_by(|&a, &b| lamps[b].irradiance(casters).total_cmp(&lamps[a].irradiance(casters)));
        order[..mapped].sort_unstable();
        order[mapped..].sort_unstable();
        lamps = order.into_iter().map(|i| lamps[i]).collect();
    }
    lamps
}

/// Counts the lamps of a frame. Refuses a frame with too many lamps, and lamps that are not finite.
///
/// # Errors
/// A sentence that names the fault and the remedy.
pub fn check(state: &FrameState) -> std::result::Result<usize, String> {
    let count = state.point_lights.len() + state.more_suns.len();
    if count > MAX_LAMPS as usize {
        return Err(format!("{count} lights exceed the limit of {MAX_LAMPS}: leave some out"));
    }
    let finite = |lamp: &Lamp| {
        let (Caster::Point(at) | Caster::Directional(at)) = lamp.caster;
        let numbers = [lamp.inverse_square_range, lamp.radius].into_iter().chain(lamp.falloff);
        at.is_finite() && lamp.power.is_finite() && numbers.into_iter().all(f32::is_finite)
    };
    match lamps_of(state, None).iter().position(|lamp| !finite(lamp)) {
        Some(number) => Err(format!("light {} has a number that is not finite: correct it", number + 1)),
        None => Ok(count),
    }
}

/// Writes the lamps into a buffer of [`BUFFER_SIZE`] bytes.
///
/// # Errors
/// Fails if the device fails.
pub fn write(buffer: &Buffer, lamps: &[Lamp]) -> Result<()> {
    buffer.write(0, &lamps.iter().map(Lamp::gpu).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    fn state(point_lights: Vec<PointLight>, more_suns: Vec<Sun>) -> FrameState {
        let camera = Camera::looking_at(Vec3::NEG_Y, Vec3::ZERO, 40.0);
        FrameState { point_lights, more_suns, ..FrameState::new(camera, Vec::new()) }
    }

    #[test]
    fn the_brightest_lamps_at_the_casters_come_first() {
        let at = |x: f32, power: f32| PointLight::new(Vec3::X * x, Vec3::splat(power));
        let sun = Sun { direction: Vec3::Z, irradiance: Vec3::splat(2.0) };
        let casters = Sphere { centre: Vec3::ZERO, radius: 1.0 };
        let points = vec![at(11.0, 1.0), at(2.0, 1.0), at(11.0, 500.0), at(3.0, 1.0), at(2.0, 9.0)];
        let powers = |lamps: Vec<Lamp>| lamps.iter().map(|lamp| lamp.power.x).collect::<Vec<_>>();
        let sorted = powers(lamps_of(&state(points.clone(), vec![sun]), Some(casters)));
        assert_eq!(sorted, [1.0, 500.0, 9.0, 2.0, 1.0, 1.0]);
        // Without casters, or with a map for each lamp, the order is that of the frame.
        assert_eq!(powers(lamps_of(&state(points.clone(), vec![]), None)), [1.0, 1.0, 500.0, 1.0, 9.0]);
        assert_eq!(powers(lamps_of(&state(points[..4].to_vec(), vec![]), Some(casters))), [1.0, 1.0, 500.0, 1.0]);
    }

    #[test]
    fn invalid_lamps_are_refused() {
        let lamp = PointLight::new(Vec3::ZERO, Vec3::ONE);
        assert_eq!(check(&state(vec![lamp; MAX_LAMPS as usize], vec![])), Ok(MAX_LAMPS as usize));
        let sun = Sun { direction: Vec3::Z, irradiance: Vec3::ONE };
        let fault = check(&state(vec![lamp; MAX_LAMPS as usize], vec![sun])).unwrap_err();
        assert_eq!(fault, "1025 lights exceed the limit of 1024: leave some out");
        for bad in [f32::NAN, f32::INFINITY] {
            let broken = [
                PointLight::new(Vec3::X * bad, Vec3::ONE),
                PointLight::new(Vec3::X, Vec3::Y * bad),
                lamp.with_radius(bad),
                PointLight { range: Some(bad), ..lamp },
            ];
            for (i, light) in broken.into_iter().enumerate() {
                // An infinite range is no limit, a range of NaN is 0, and a radius of NaN is 0.
                let valid = i == 3 || (i == 2 && bad.is_nan());
                assert_eq!(check(&state(vec![lamp, light], vec![])).is_ok(), valid, "{i} {bad}");
            }
            let sun = Sun { direction: Vec3::Z, irradiance: Vec3::X * bad };
            assert!(check(&state(vec![], vec![sun])).unwrap_err().contains("light 1"));
        }
    }
}
