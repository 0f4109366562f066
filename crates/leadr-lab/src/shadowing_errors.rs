//! Compares the shadowing models with ray casts. The results are rows of relative errors over a sphere.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::ray_cast::{Patch, Spectrum, SphereError, SpherePixel, SphereTruth, Tile, cosine_direction};
use crate::shadowed_reference::Surface;
use leadr_reflectance::frame::{frame_about, from_frame, to_frame};
use leadr_reflectance::integrals::reference::diffuse_directional;
use leadr_reflectance::integrals::sh::{Sh9, sh_basis, sh_irradiance};
use leadr_reflectance::masking::correlated::{direction_area, lit_fraction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::slope_cholesky;
use leadr_reflectance::visible::shadowed_environment::{bent_normal, visible_slope_shift};
use leadr_reflectance::visible::shadowed_specular::visible_specular_environment;
use leadr_reflectance::visible::specular::{VisibleProbe, probe_rule};

/// The light on the sphere. The viewer is at `+z`, with x to the right and y up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ShadowingLight {
    /// Diffuse facets under a light from the viewer.
    Front,
    /// Diffuse facets under a light from (0.6, 0.5, 0.62).
    Side,
    /// Diffuse facets under [`ENVIRONMENT`].
    DiffuseEnvironment,
    /// Specular facets under a constant environment.
    WhiteSpecular,
    /// Specular facets under [`ENVIRONMENT`] plus two lights that are 18° and 10° wide.
    SpecularEnvironment,
}

/// The models that are compared with ray casts. The integrals of all models are converged, except for the bent normal and
/// the probes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ShadowingModel {
    /// Masking only (the simplified algorithms of LEADR's supplement).
    Masking,
    /// Smith's height-correlated shadowing (LEADR eq. 13).
    Smith,
    /// Direction-correlated shadowing in its simple form.
    CorrelatedSimple,
    /// Direction-correlated shadowing in its full form.
    Correlated,
    /// Occlusion, and one irradiance lookup along the bent normal, for diffuse environments.
    BentNormal,
    /// A rule with this many probes, for specular environments.
    Probes(u32),
}

/// One entry of the table of errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowingRow {
    /// The light on the sphere.
    pub light: ShadowingLight,
    /// The shadowing model of the entry.
    pub model: ShadowingModel,
    /// The error of the model.
    pub error: SphereError,
}

/// The settings of the ray casts that compute the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowingSettings {
    /// The number of pixels along a side of the sphere's picture.
    pub size: u32,
    /// The square root of the number of rays per pixel.
    pub rays: u32,
    /// The number of cells along a side of the tile, which is a power of two.
    pub tile: u32,
    /// The spectrum of the relief.
    pub spectrum: Spectrum,
    /// The seed of the relief and the rays.
    pub seed: u64,
}

impl Default for ShadowingSettings {
    fn default() -> Self {
        Self { size: 24, rays: 32, tile: 512, spectrum: Spectrum::Gaussian, seed: 1 }
    }
}

/// A radiance of order 2 by world direction: `1 + E·d + 0.2 y z + 0.15 (x² − y²)` with `E = (0.3, 0.5, 0.2)`.
pub const ENVIRONMENT: fn(DVec3) -> f64 = |d| environment(d, 0.0);

/// Evaluates the environment after a blur by a kernel with `variance` per axis, in radians squared. The blur scales band `l`
/// by `exp(−l (l + 1) variance / 2)`.
fn environment(d: DVec3, variance: f64) -> f64 {
    let (one, two) = ((-variance).exp(), (-3.0 * variance).exp());
    1.0 + one * d.dot(DVec3::new(0.3, 0.5, 0.2)) + two * (0.2 * d.y * d.z + 0.15 * (d.x * d.x - d.y * d.y))
}

/// Evaluates the environment plus two lights. A lobe with concentration `k` has variance `1/k`.
fn lights(d: DVec3, variance: f64) -> f64 {
    let lobe = |k: f64, towards: DVec3| {
        let wider = 1.0 + k * variance;
        (k / wider * (d.dot(towards.normalize()) - 1.0)).exp() / wider
    };
    0.3 * environment(d, variance)
        + 2.0 * lobe(20.0, DVec3::new(0.5, 0.6, 0.6))
        + 1.5 * lobe(60.0, DVec3::new(-0.7, 0.1, 0.3))
}

/// Returns the coefficients of [`ENVIRONMENT`], which is a radiance of order 2.
fn harmonics() -> Sh9 {
    // Each term of the polynomial is a basis function times a factor. The factor is read where all other basis functions are
    // 0.
    let mut c = [DVec3::ZERO; 9];
    let unit = |k: usize, d: DVec3| sh_basis(d)[k];
    c[0] = DVec3::splat(1.0 / unit(0, DVec3::Z));
    c[1] = DVec3::splat(0.5 / unit(1, DVec3::Y));
    c[2] = DVec3::splat(0.2 / unit(2, DVec3::Z));
    c[3] = DVec3::splat(0.3 / unit(3, DVec3::X));
    let diagonal = DVec3::new(0.0, 1.0, 1.0).normalize();
    c[5] = DVec3::splat(0.1 / unit(5, diagonal));
    c[8] = DVec3::splat(0.15 / unit(8, DVec3::X));
    c
}

const SIDE: DVec3 = DVec3::new(0.6, 0.5, 0.62);
/// The probe counts that the table lists.
const PROBES: [u32; 3] = [5, 9, 16];
const PANELS: usize = 8;

/// Computes relative RMS errors of every model under every light, without the truth's noise. In the frame of each pixel
/// ([`SpherePixel`]), the sphere's relief has the slopes of `surface`. The default settings take a few seconds.
pub fn shadowing_errors(surface: Surface, settings: &ShadowingSettings) -> Vec<ShadowingRow> {
    let tile = Tile::new(settings.spectrum, settings.tile, 8.0, settings.seed);
    let patch = Patch::new(&tile, surface.m, surface.s);
    let truth = SphereTruth::cast(&patch, settings.size, 0.97, settings.rays, settings.seed, |pixel, facet, random| {
        let light = |towards: DVec3| {
            let wi = to_frame(&pixel.frame, towards);
            let value = facet.normal.dot(wi).max(0.0) / PI;
            if value > 0.0 && patch.is_lit(facet, wi) { value } else { 0.0 }
        };
        // Four directions sample the cosine lobe for the diffuse environment.
        let about = frame_about(facet.normal);
        let mut diffuse = 0.0;
        for _ in 0..4 {
            let wi = from_frame(&about, cosine_direction(random));
            if patch.is_lit(facet, wi) {
                diffuse += 0.25 * environment(from_frame(&pixel.frame, wi), 0.0);
            }
        }
        let mirror = 2.0 * facet.normal.dot(pixel.wo) * facet.normal - pixel.wo;
        let open = f64::from(patch.is_lit(facet, mirror));
        let incident = lights(from_frame(&pixel.frame, mirror), 0.0);
        [light(DVec3::Z), light(SIDE.normalize()), diffuse, open, open * incident]
    });
    use ShadowingLight::{DiffuseEnvironment, Front, Side, SpecularEnvironment, WhiteSpecular};
    use ShadowingModel::{BentNormal, Correlated, CorrelatedSimple, Masking, Probes, Smith};
    let columns: Vec<(ShadowingLight, ShadowingModel)> = [Front, Side]
        .iter()
        .flat_map(|l| [Masking, Smith, CorrelatedSimple, Correlated].map(|m| (*l, m)))
        .chain([Masking, BentNormal].map(|m| (DiffuseEnvironment, m)))
        .chain([WhiteSpecular, SpecularEnvironment].iter().flat_map(|l| {
            let converged = [Masking, Smith, Correlated].map(|m| (*l, m));
            converged.into_iter().chain(PROBES.map(|n| (*l, Probes(n))))
        }))
        .collect();
    let values: Vec<Option<Vec<f64>>> = (0..settings.size * settings.size)
        .into_par_iter()
        .map(|i| {
            SpherePixel::new(i % settings.size, i / settings.size, settings.size, 0.97).map(|p| models(&surface, &p))
        })
        .collect();
    let picture = |light| {
        [Front, Side, DiffuseEnvironment, WhiteSpecular, SpecularEnvironment]
            .iter()
            .position(|l| *l == light)
            .expect("all are listed")
    };
    columns
        .iter()
        .enumerate()
        .map(|(k, &(light, model))| {
            let value = |x: u32, y: u32| values[(y * settings.size + x) as usize].as_ref().map_or(0.0, |v| v[k]);
            ShadowingRow { light, model, error: truth.compare(picture(light), |x, y, _| value(x, y)) }
        })
        .collect()
}

/// The light of a white room on the facets that are visible from one angle. Each pair has a value from ray casts and a value
/// from [`bent_normal`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitFacets {
    /// The fraction of the light that reaches the visible facets.
    pub open: (f64, f64),
    /// The tilt of the light's mean direction, relative to the tilt of the mean visible slope. 1 means that both tilts are
    /// equal.
    pub bend: (f64, f64),
}

/// Computes data for the constants of [`bent_normal`]. The data are means over eight view azimuths at `degrees` from the
/// normal, for a surface of mean slope 0.
pub fn lit_facets(s: DVec3, degrees: f64, settings: &ShadowingSettings) -> LitFacets {
    const AZIMUTHS: u32 = 8;
    const DIRECTIONS: u32 = 8;
    let tile = Tile::new(settings.spectrum, settings.tile, 8.0, settings.seed);
    let patch = Patch::new(&tile, DVec2::ZERO, s);
    let cholesky = slope_cholesky(s);
    let (mut open, mut bend) = ((0.0, 0.0), (0.0, 0.0));
    for k in 0..AZIMUTHS {
        let (sin, cos) = (2.0 * PI * (f64::from(k) + 0.3) / f64::from(AZIMUTHS)).sin_cos();
        let (down, up) = degrees.to_radians().sin_cos();
        let (toward, wo) = (DVec2::new(cos, sin), DVec3::new(down * cos, down * sin, up));
        let o = direction_area(wo, DVec2::ZERO, cholesky);
        let visible = -visible_slope_shift(&o, cholesky).dot(toward);
        let cast = patch.mean_over_visible(wo, 4 * settings.rays, settings.seed, |facet, random| {
            let about = frame_about(facet.normal);
            let mut sums = [0.0; 3];
            for _ in 0..DIRECTIONS {
                let wi = from_frame(&about, cosine_direction(random));
                if patch.is_lit(facet, wi) {
                    let values = [1.0, wi.truncate().dot(toward), wi.z];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value / f64::from(DIRECTIONS));
                }
            }
            sums
        });
        let [lit, along, height] = cast.expect("the mesosurface faces the viewer").mean;
        let model = bent_normal(&o, DVec2::ZERO, cholesky);
        open = (open.0 + lit, open.1 + model.open);
        let lean = model.normal.truncate().dot(toward) / model.normal.z;
        bend = (bend.0 + along / height / visible, bend.1 + lean / visible);
    }
    let mean = |(a, b): (f64, f64)| (a / f64::from(AZIMUTHS), b / f64::from(AZIMUTHS));
    LitFacets { open: mean(open), bend: mean(bend) }
}

/// Evaluates all models at one pixel, in the order of the columns.
fn models(surface: &Surface, pixel: &SpherePixel) -> Vec<f64> {
    let wo = pixel.wo;
    let (m, s) = (surface.m, surface.s);
    let mut out = Vec::new();
    for towards in [DVec3::Z, SIDE.normalize()] {
        let wi = to_frame(&pixel.frame, towards);
        let cosine = diffuse_directional(wo, wi, m, s, false, PANELS);
        let (o, i) = (surface.area(wo), surface.area(wi));
        for v in [Shadowing::None, Shadowing::Smith, Shadowing::CorrelatedSimple, Shadowing::Correlated] {
            out.push(cosine * lit_fraction(v, &o, &i));
        }
    }
    // The harmonics are in world space, so normals are transformed to world space.
    let c = harmonics();
    let world = |n: DVec3| sh_irradiance(&c, from_frame(&pixel.frame, n)).x / PI;
    let masked = leadr_reflectance::integrals::reference::visible_mean(wo, m, s, PANELS, |x| {
        DVec3::splat(world(leadr_reflectance::slopes::grid::normal_of_slope(x)))
    });
    out.push(masked.x);
    let bent = bent_normal(&surface.area(wo), m, slope_cholesky(s));
    out.push(bent.open * world(bent.normal));
    for radiance in [(|_, _| 1.0) as fn(DVec3, f64) -> f64, lights] {
        let at = |d: DVec3, variance: f64| radiance(from_frame(&pixel.frame, d), variance);
        out.extend(surface.specular_environment(wo, PANELS, |d| at(d, 0.0)).to_array());
        for n in PROBES {
            let lookup = |p: &VisibleProbe| DVec3::splat(at(p.wi, p.variance));
            let (v, rule) = (Shadowing::Correlated, probe_rule(n));
            let value = visible_specular_environment(v, wo, m, s, DVec3::ONE, rule, lookup);
            out.push(value.reflected.x);
        }
    }
    out
}
