//! The visible surface of a picture, which is shaded on the CPU with any BRDFs. The renderer provides the surface as layers, so a picture
//! has the geometry, the camera, the lights and the shadow maps of the renderer's own pictures.

use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::studio::{Studio, fault};
use super::truth::Truth;
use super::verdict::Shot;
use leadr_maps::RgbImage;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::frame::{frame_about, from_frame, to_frame};
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::microfacet::Microfacet;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::normal_of_slope;
use leadr_render::frame::{Layer, Renderer};
use leadr_render::scene::FrameState;
use leadr_render::settings::{RenderSettings, ShadingOptions, Terms};
use leadr_tools::error::LabError;
use leadr_tools::fit::reflected::{LightLobe, Surroundings, reflected};

/// The number of directions per point and half, for each sampling strategy. Several points share a pixel.
const DIRECTIONS: u32 = 2;
/// The concentration of the sky's glow around the sun, from which directions are drawn.
const GLOW: f64 = 8.0;

/// The BRDFs with which an object is drawn in each of `N` pictures.
pub struct Drawn<'a, const N: usize> {
    /// The BRDFs, which must be isotropic, because the layers contain no tangents.
    pub materials: [&'a (dyn Brdf + Sync); N],
    /// The BRDF from which directions are drawn for all pictures.
    pub guide: Microfacet<Ggx>,
}

/// The surface in one pixel.
#[derive(Clone, Copy)]
struct Point {
    /// The index of the object in the scene.
    object: usize,
    /// The mesonormal.
    normal: DVec3,
    towards_eye: DVec3,
    /// The part of the sunlight that arrives, from 0 to 1.
    lit: f64,
}

/// The surface at the centres of the pixels of a picture.
pub struct VisibleSurface {
    size: (u32, u32),
    points: Vec<Option<Point>>,
}

impl VisibleSurface {
    /// Reads the surface of a picture of `size` pixels.
    ///
    /// # Errors
    /// Returns the errors of [`Studio::shoot`].
    pub fn of(
        studio: &Studio,
        renderer: &mut Renderer,
        state: &FrameState,
        size: (u32, u32),
    ) -> Result<Self, LabError> {
        // The slopes of the truth are those of the finest level. Its light is not needed.
        let truth = Truth::Displacement.settings(size, 1, 0);
        let shading = truth.shading.adjusted(|options| ShadingOptions { terms: Terms::NONE, ..options });
        studio.shoot(renderer, state, &RenderSettings { shading, ..truth })?;
        let mut layer = |layer| renderer.layer(layer);
        let (patches, normals) = (layer(Layer::Patch)?, layer(Layer::Normal)?);
        let (slopes, shadows) = (layer(Layer::MeanSlope)?, layer(Layer::Shadow)?);
        // A single sample is at the centre of its pixel.
        let [across, down, middle] = state.camera.rays(size, Vec2::ZERO);
        let point = |i: u32| {
            let at = |layer: &[[f32; 4]]| layer[i as usize];
            let object = (at(&patches)[0] as usize).checked_sub(1)?;
            let [x, y] = [(i % size.0, size.0), (i / size.0, size.1)]
                .map(|(pixel, count)| 2.0 * (pixel as f32 + 0.5) / count as f32 - 1.0);
            let [nx, ny, nz, _] = at(&normals);
            let [sx, sy, ..] = at(&slopes);
            let frame = frame_about(Vec3::new(nx, ny, nz).as_dvec3().normalize());
            Some(Point {
                object,
                normal: from_frame(&frame, normal_of_slope(Vec2::new(sx, sy).as_dvec2())),
                towards_eye: -(middle + across * x + down * y).as_dvec3().normalize(),
                lit: at(&shadows)[0].into(),
            })
        };
        Ok(Self { size, points: (0..size.0 * size.1).map(point).collect() })
    }

    /// Returns one picture for each BRDF of an object, under the sky and the sun of `state`. Objects without BRDFs and empty pixels are
    /// black and not covered. The sky is not occluded, as in the truth. The noise is estimated from two halves with different directions.
    ///
    /// # Errors
    /// Fails if a pixel is not finite. The error gives the position of the pixel.
    pub fn shaded<const N: usize>(
        &self,
        objects: &[Option<Drawn<'_, N>>],
        state: &FrameState,
    ) -> Result<Vec<Shot>, LabError> {
        let [first, second] = [1, 2].map(|seed| self.half(objects, state, seed));
        first?.iter().zip(&second?).map(|(a, b)| Shot::mean_of(a, b).map_err(fault)).collect()
    }

    fn half<const N: usize>(
        &self,
        objects: &[Option<Drawn<'_, N>>],
        state: &FrameState,
        seed: u64,
    ) -> Result<Vec<Shot>, LabError> {
        let drawn = |point: &Point| objects.get(point.object).and_then(Option::as_ref);
        let tables = state.sky.unwrap_or_default().tables();
        let sun = state.sun();
        let glow = sun.map(|sun| LightLobe { toward: sun.direction.as_dvec3(), sharpness: GLOW });
        let around = Surroundings { radiance: &|w| tables.radiance(w), lobes: glow.as_slice(), directions: DIRECTIONS };
        let shade = |(i, point): (usize, &Option<Point>)| {
            let (point, Drawn { materials, guide }) = point.as_ref().and_then(|point| Some((point, drawn(point)?)))?;
            let mut random = Random::stream(seed, i as u64);
            let shift = DVec2::new(random.unit(), random.unit());
            let frame = frame_about(point.normal);
            let mut colors = reflected(materials, guide, &around, &frame, point.towards_eye, shift);
            if let Some(sun) = sun {
                let [wo, wi] =
                    [point.towards_eye, sun.direction.as_dvec3()].map(|direction| to_frame(&frame, direction));
                let irradiance = sun.irradiance.as_dvec3() * point.lit;
                for (color, material) in colors.iter_mut().zip(materials) {
                    *color += material.eval_cos(wo, wi) * irradiance;
                }
            }
            Some(colors)
        };
        let pixels: Vec<Option<Vec<DVec3>>> = self.points.par_iter().enumerate().map(shade).collect();
        let (width, height) = self.size;
        let picture = |k: usize| {
            let color =
                |pixel: &Option<Vec<DVec3>>| pixel.as_ref().map_or([0.0; 3], |colors| colors[k].as_vec3().to_array());
            let image = RgbImage::new(width, height, pixels.iter().map(color).collect()).map_err(fault)?;
            image.check_finite().map_err(fault)?;
            let coverage = pixels.iter().map(|pixel| f32::from(u8::from(pixel.is_some()))).collect();
            Ok(Shot { image, coverage, milliseconds: 0.0, samples: 1, noise: 0.0 })
        };
        (0..N).map(picture).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_PI;
    use std::sync::Arc;

    use super::*;
    use crate::report::subject::Subject;
    use leadr_maps::procedural;
    use leadr_reflectance::materials::fitted::FittedBrdf;
    use leadr_reflectance::materials::lambert::Lambert;
    use leadr_render::camera::Camera;
    use leadr_render::light::sky::Sky;
    use leadr_scenes::dressed::sphere_stage;
    use leadr_scenes::stage::SPHERE_REPEAT;
    use leadr_testing::gpu::test_gpu;
    use leadr_tools::command::output::Output;
    use leadr_tools::fit::specimen::{Lacquer, dressed};
    use leadr_tools::metrics::compare::rrmse_over;

    #[test]
    fn level_points_reflect_the_sky_and_their_part_of_the_sun() {
        let sky = Sky::default();
        let state = FrameState::new(Camera::looking_at(Vec3::Z, Vec3::ZERO, 45.0), Vec::new()).under(&sky);
        let towards_eye = DVec3::new(0.3, 0.4, 1.0).normalize();
        let point = |object: usize, lit: f64| Some(Point { object, normal: DVec3::Z, towards_eye, lit });
        let kinds = [point(0, 1.0), point(0, 0.25), point(1, 1.0), None];
        let surface =
            VisibleSurface { size: (128, 4), points: kinds.into_iter().flat_map(|kind| vec![kind; 128]).collect() };
        let [white, grey] = [1.0, 0.5].map(|albedo| Lambert { albedo: DVec3::splat(albedo) });
        let guide = Lacquer::fit().unwrap().as_ggx();
        let objects = [Some(Drawn { materials: [&white, &grey], guide }), None];
        let shots = surface.shaded(&objects, &state).unwrap();
        let (covered, empty) = shots[0].coverage.split_at(256);
        assert!(covered.iter().all(|&c| c == 1.0) && empty.iter().all(|&c| c == 0.0));
        let sun = state.sun().unwrap();
        let direct = sun.irradiance.as_dvec3() * f64::from(sun.direction.z);
        for (row, lit) in [(0, 1.0), (1, 0.25)] {
            let wanted = FRAC_1_PI * (sky.tables().ground_irradiance() + lit * direct);
            let [of_white, of_grey] = [0, 1].map(|k: usize| {
                let texels = &shots[k].image.texels[128 * row..][..128];
                texels.iter().map(|&texel| Vec3::from(texel).as_dvec3()).sum::<DVec3>() / 128.0
            });
            assert!((of_white - wanted).length() < 0.02 * wanted.length(), "{of_white} {wanted}");
            assert!((of_white - 2.0 * of_grey).length() < 1e-6 * wanted.length(), "{of_white} {of_grey}");
        }
        assert!(shots[0].image.texels[256..].iter().all(|&texel| texel == [0.0; 3]));
    }

    /// A wrong frame, sign of the slopes, sun or shadow would exceed the bound by far.
    #[test]
    fn a_fit_on_bumps_agrees_with_the_renderer() {
        let Some(gpu) = test_gpu() else { return };
        let output = Output::new(false, true);
        let studio = Studio::new(Arc::clone(&gpu), true, &output);
        let fit = Lacquer::fit().unwrap();
        let material = dressed(&fit, "lacquer", procedural::gaussian(64, 64, 5, 1.0, 0.06), 0.15 * SPHERE_REPEAT);
        let mut subject = Subject::under_the_sky(&studio, sphere_stage(&material, None, 32), 0.0).unwrap();
        let state = subject.seen_by(&subject.stage.views.mid);
        let truth = Truth::Displacement.settings((64, 64), 16, 1);
        let truth = studio.shoot_truth(&mut subject.renderer, &state, &truth).unwrap();
        let surface = VisibleSurface::of(&studio, &mut subject.renderer, &state, (192, 192)).unwrap();
        let error = |diffuse: DVec3| {
            let brdf = FittedBrdf { diffuse, ..fit.fitted.clone() };
            let objects = [Some(Drawn { materials: [&brdf], guide: fit.as_ggx() }), None];
            let shot = surface.shaded(&objects, &state).unwrap()[0].of_blocks(3).unwrap();
            rrmse_over(&truth.image, &shot.image, &shot.interior().unwrap()).unwrap()
        };
        let (same, brighter) = (error(fit.fitted.diffuse), error(fit.fitted.diffuse + 0.1));
        println!("{same} {brighter}, noise {}", truth.noise);
        assert!(same < 0.06 && brighter > 3.0 * same, "{same} {brighter}");
    }
}
