//! Mip filtering of normals and gloss, for the kinds normal and gloss.

use glam::{DVec3, DVec4};

use super::Texels;
use super::inputs::{DetailNormals, Inputs};
use leadr_reflectance::facets::footprint_normals::{NormalTexel, continuous_normal_sum, normal_sum};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::{NormalArea, NormalFacets, Shortening};

/// Returns the function that shortens a texel's normal by its roughness. The function assumes GGX facets, as the gloss does.
const fn shortening(area: NormalArea) -> Shortening {
    Shortening { facets: NormalFacets::Ggx, area }
}

impl DetailNormals {
    /// Returns the detail texel that covers a given texel of a surface of `size` texels.
    fn texel(&self, [x, y]: [u32; 2], size: [u32; 2]) -> [u32; 2] {
        let raster = &self.normals.texture.raster;
        let at = |k: u32, of: u32, to: u32| {
            let position = (f64::from(k) + 0.5) / f64::from(of) * f64::from(self.repeat) * f64::from(to);
            (position as u64 % u64::from(to)) as u32
        };
        [at(x, size[0], raster.width()), at(y, size[1], raster.height())]
    }
}

impl Inputs {
    /// Returns the unit normals of a row after blending with the detail, in the tangent frame with y up.
    fn unit_normals(&self, scale: f32, y: u32) -> Vec<DVec3> {
        let size = self.size().expect("checked before baking");
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let slopes = self.slopes(scale, y).into_iter().enumerate();
        let normal = |(x, [s, t, _]): (usize, [f64; 3])| {
            let normal = DVec3::new(-s, t * aspect, 1.0).normalize();
            let Some(detail) = &self.detail else { return normal };
            let [u, v] = detail.texel([x as u32, y], size);
            let [s, t] = detail.normals.slope(u, v);
            (detail.blend)(normal, DVec3::new(-s, t, 1.0).normalize())
        };
        slopes.map(normal).collect()
    }

    /// Returns the unit normals of a row as four numbers each. The fourth number is 0.
    pub(super) fn normals_of_row(&self, scale: f32, y: u32) -> Vec<[f64; 4]> {
        self.unit_normals(scale, y).into_iter().map(|n| n.extend(0.0).to_array()).collect()
    }

    /// Returns the roughness `α` of a texel, which combines the roughness of the surface with the roughness of the detail.
    fn alpha(&self, x: u32, y: u32) -> f64 {
        let surface = self.roughness.as_ref().map_or(0.0, |roughness| roughness.alpha(x, y));
        let Some((detail, roughness)) = self.detail.as_ref().and_then(|d| Some((d, d.roughness.as_ref()?))) else {
            return surface;
        };
        // The roughness map may differ in size from the normal map.
        let size = self.size().expect("checked before baking");
        let [u, v] = detail.texel([x, y], size);
        let raster = &detail.normals.texture.raster;
        let at = |k: u32, of: u32, to: u32| (u64::from(k) * u64::from(to) / u64::from(of)) as u32;
        let (w, h) = (roughness.raster.width(), roughness.raster.height());
        let alpha = roughness.alpha(at(u, raster.width(), w), at(v, raster.height(), h));
        shortening(self.area).combine(surface, alpha)
    }

    fn texels_of_row(&self, scale: f32, y: u32) -> Vec<NormalTexel> {
        let normals = self.unit_normals(scale, y).into_iter().enumerate();
        normals.map(|(x, normal)| NormalTexel { normal, alpha: self.alpha(x as u32, y) }).collect()
    }

    /// Returns the values whose averages give the gloss (Chan 2018, algorithms 1 to 3): x, y, weight − z and weight of the
    /// shortened normal. The difference `weight − z` keeps 32-bit precision on smooth surfaces.
    pub(super) fn shortened_normals_of_row(&self, scale: f32, y: u32) -> Vec<[f64; 4]> {
        let [width, height] = self.size().expect("checked before baking");
        let shortening = shortening(self.area);
        let kept = |sum: DVec4| [sum.x, sum.y, sum.w - sum.z, sum.w];
        let here = self.texels_of_row(scale, y);
        if self.texels == Texels::Facets {
            return here.iter().map(|texel| kept(normal_sum(texel, shortening))).collect();
        }
        let beyond = |step: i64| self.texels_of_row(scale, self.wrap.texel(i64::from(y) + step, height) as u32);
        let rows = [beyond(-1), here, beyond(1)];
        let texel = |x: u32| {
            let columns = [-1, 0, 1].map(|step| self.wrap.texel(i64::from(x) + step, width));
            let around = std::array::from_fn(|j| columns.map(|column| rows[j][column]));
            kept(continuous_normal_sum(&around, shortening))
        };
        (0..width).map(texel).collect()
    }
}

pub(super) fn restore_length(texel: &mut [f32]) {
    let mean = DVec3::new(texel[0].into(), texel[1].into(), texel[2].into());
    texel[..3].copy_from_slice(&mean.normalize_or(DVec3::Z).as_vec3().to_array());
}

/// A table of the gloss as a function of the shortening `1 − ‖n̄‖` of a mean normal. Without the table, root finding for
/// every texel would dominate the baking time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GlossOfShortening {
    scale: Gloss,
    /// The values of `ln α` at equal steps of the log odds of the shortening. `ln α` is nearly linear in the log odds.
    logs: Vec<f64>,
}

impl GlossOfShortening {
    const LOW: f64 = -20.0;
    const HIGH: f64 = 10.0;
    const STEPS: usize = 3000;

    pub fn new(scale: Gloss, area: NormalArea) -> Self {
        let step = |i: usize| {
            let odds = (Self::LOW + (Self::HIGH - Self::LOW) * i as f64 / Self::STEPS as f64).exp();
            shortening(area).alpha_of_shortening(odds / (1.0 + odds)).ln()
        };
        Self { scale, logs: (0..=Self::STEPS).map(step).collect() }
    }

    /// Returns the gloss for a shortening that is below 1.
    fn gloss(&self, one_minus_length: f64) -> f64 {
        let odds = (one_minus_length / (1.0 - one_minus_length)).max(1e-30).ln();
        let at = ((odds - Self::LOW) / (Self::HIGH - Self::LOW)).clamp(0.0, 1.0) * Self::STEPS as f64;
        let i = (at as usize).min(Self::STEPS - 1);
        let log = self.logs[i] + (at - i as f64) * (self.logs[i + 1] - self.logs[i]);
        self.scale.gloss(log.exp())
    }
}

/// Converts the averages of [`Inputs::shortened_normals_of_row`] to a normal and a gloss.
pub(super) fn to_normal_and_gloss(texel: &mut [f32], gloss: &GlossOfShortening) {
    let [x, y, below, weight] = [0, 1, 2, 3].map(|i| f64::from(texel[i]));
    let [x, y, below] = [x, y, below].map(|v| v / weight.max(1e-30));
    let mean = DVec3::new(x, y, 1.0 - below);
    // 1 - |mean| is computed as (1 - |mean|²) / (1 + |mean|), which avoids cancellation.
    let one_minus_length = ((2.0 - below) * below - x * x - y * y) / (1.0 + mean.length());
    let normal = mean.normalize_or(DVec3::Z).as_vec3();
    texel[..4].copy_from_slice(&[
        normal.x,
        normal.y,
        normal.z,
        gloss.gloss(one_minus_length.clamp(0.0, 1.0 - 1e-9)) as f32,
    ]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gloss_of_a_table_is_that_of_roots() {
        for area in [NormalArea::Macro, NormalArea::Micro] {
            let table = GlossOfShortening::new(Gloss::Wwii, area);
            for i in 0..=400 {
                let alpha = Gloss::Wwii.alpha(f64::from(i) / 400.0);
                let found = table.gloss(shortening(area).one_minus_length(alpha));
                assert!((found - f64::from(i) / 400.0).abs() < 2e-6, "{i}: {found}");
            }
        }
    }

    #[test]
    fn smooth_texels_weigh_more_in_filtered_normals() {
        // The expected values are from Chan 2018, Figure 7.
        let sum = |x: f64, alpha| {
            let normal = DVec3::new(x, 0.0, 0.75f64.sqrt());
            normal_sum(&NormalTexel { normal, alpha }, shortening(NormalArea::Macro))
        };
        let sum = 0.5 * (sum(-0.5, 0.9) + sum(0.5, 0.1));
        let mean = [sum.x, sum.y, sum.w - sum.z, sum.w];
        let mut texel = mean.map(|v| v as f32);
        to_normal_and_gloss(&mut texel, &GlossOfShortening::new(Gloss::Perceptual, NormalArea::Macro));
        assert!(texel[0] > 0.05 && (texel[0].hypot(texel[2]) - 1.0).abs() < 1e-6, "{texel:?}");
        let alpha = Gloss::Perceptual.alpha(texel[3].into());
        assert!((0.6..0.9).contains(&alpha), "{alpha}");
    }
}
