//! Bakes [`SphereNoise`] into the tiles of a cube sphere.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, Vec2};

use super::noise::SphereNoise;
use crate::sphere::{bake_tiles, cube_sphere, layout_tiles, tiled};
use leadr_maps::cache::cached;
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// The size of the bumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Frequency {
    /// Bumps that are large enough to see and count.
    Low,
    /// The smallest bumps that the tiles can store. Such bumps are much smaller than the pixels of a table.
    High,
}

/// The size of the mesh and its tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Detail {
    /// The number of patches along the edge of a cube face. The sphere has `6 n²` patches.
    pub patches: u32,
    /// The number of texels along a tile, including the gutter. Up to 64 texels, each texel has a vertex in a reference picture.
    pub tile: u32,
}

impl Detail {
    /// The detail for tables, with 1536 patches and 3840 texels around the equator. A reference that is tessellated to texels draws about 6
    /// million triangles. The maps take 200 MB on the device.
    pub const TABLE: Self = Self { patches: 16, tile: 64 };
    /// The detail for pictures with many spheres, with 1920 texels around the equator. The maps take 50 MB on the device.
    pub const PICTURE: Self = Self { patches: 8, tile: 64 };

    /// Returns the angle in radians that the longest texel covers, which is at the centre of a face.
    pub fn texel(&self) -> f64 {
        FRAC_PI_2 / f64::from(self.patches * (self.tile - 4))
    }
}

/// The mean square of the texel side over the sphere, in units of the square of [`Detail::texel`]. Texels shrink toward the edges of a
/// face.
const MEAN_SQUARE_TEXEL: f64 = 0.876;

/// A baked sphere. Its steeper slope has a standard deviation of 1.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The unit sphere.
    pub mesh: PatchMesh,
    /// The heights, whose steeper slope has a standard deviation of 1.
    pub heights: HeightField,
    /// The angle from the poles, in radians, within which the slope ratio is inexact ([`SphereNoise::cap`]).
    pub cap: f32,
    /// The standard deviation of the kernel along the steeper direction, in radians. The standard deviation is half the correlation length
    /// in this direction.
    pub length: f32,
}

/// Returns the standard deviation of the kernel along the steeper direction, in radians, for slopes in the ratio of `sigma`.
fn length_of(sigma: Vec2, frequency: Frequency, detail: Detail) -> f64 {
    let aspect = f64::from(sigma.max_element()) / f64::from(sigma.min_element());
    match frequency {
        // Stretched kernels are narrower, because pixels must still be large enough to cover the length of the kernel.
        Frequency::High => detail.texel() * (4.0 - (aspect.log2() - 1.0).clamp(0.0, 2.0) * 0.5),
        Frequency::Low => 0.03 / aspect.cbrt(),
    }
}

impl Surface {
    /// Bakes a surface whose slopes are in the ratio of `sigma = (σ_θ, σ_φ)`. Surfaces with equal ratios differ only in scale. The ratio
    /// holds for the slopes of the triangles between texels, averaged over the sphere. For a kernel of `w` texels, triangles lose 0.12 / w²
    /// of the variance, and the heights compensate for this loss.
    pub fn bake(sigma: Vec2, frequency: Frequency, detail: Detail) -> Self {
        Self::of_length(sigma, length_of(sigma, frequency, detail), detail)
    }

    /// Like [`Self::bake`], but reads and writes the user's cache.
    pub fn kept(sigma: Vec2, frequency: Frequency, detail: Detail) -> Self {
        let programs = [
            include_str!("surface.rs"),
            include_str!("noise.rs"),
            include_str!("../sphere.rs"),
            leadr_render::surfaces::patch::SOURCE,
        ];
        let length = length_of(sigma, frequency, detail);
        Self::with(sigma, length, detail, |count, make| {
            let of = format!("{sigma:?} {length:?} {detail:?}");
            cached("rough-sphere", &[&programs[..], &[&of]].concat(), count, |height: &f32| height.abs() < 100.0, make)
        })
    }

    /// Like [`Self::bake`], but with a kernel of `length` radians along the steeper direction, at least 2 texels.
    pub fn of_length(sigma: Vec2, length: f64, detail: Detail) -> Self {
        Self::with(sigma, length, detail, |_, make| make())
    }

    /// Bakes the surface. `known` returns this many texels from the cache, or computes them.
    fn with(
        sigma: Vec2,
        length: f64,
        detail: Detail,
        known: impl FnOnce(usize, &dyn Fn() -> Vec<f32>) -> Vec<f32>,
    ) -> Self {
        let unit = sigma.as_dvec2() / f64::from(sigma.max_element());
        // C is the kernel's autocorrelation. C(0) − C(t) is used to fourth order, where the second term is ∫f″² / ∫f′² / 12 per squared
        // standard deviation.
        let texels = DVec2::splat(length) / unit / detail.texel();
        let seen = DVec2::ONE - 0.133 * MEAN_SQUARE_TEXEL / (texels * texels);
        let noise = SphereNoise::new(1, unit / DVec2::new(seen.x.sqrt(), seen.y.sqrt()), length);
        let mut mesh = cube_sphere(detail.patches, [1.0; 4]);
        let layout = layout_tiles(&mut mesh, detail.tile);
        let (width, height) = layout.size();
        let make = || bake_tiles(&mut mesh.clone(), detail.tile, |p, _| noise.at(p.normalize())).1;
        let texels = known(width as usize * height as usize, &make);
        Self { mesh, heights: tiled(layout, texels), cap: noise.cap(), length: length as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use leadr_render::surfaces::displacement::Border;
    use leadr_render::surfaces::patch::Patch;

    /// Returns the points where four texels of a tile meet, and the slopes along `(ω_θ, ω_φ)`. Each slope is a mean of the adjacent
    /// triangles, which loses `0.3 / w²` of the variance.
    fn slopes(surface: &Surface) -> Vec<(Vec3, DVec2)> {
        let Border::Tiles(layout) = surface.heights.border else { panic!("tiles") };
        let mut slopes = Vec::new();
        for (index, patch) in surface.mesh.patches.iter().enumerate() {
            let patch = Patch::new(
                patch.map(|v| surface.mesh.positions[v as usize]),
                patch.map(|v| surface.mesh.normals[v as usize]),
            );
            let (x0, y0) = layout.origin(index as u32);
            let at =
                |x: u32, y: u32| surface.heights.map.texels[((y0 + y) * surface.heights.map.width + x0 + x) as usize];
            for y in (2..layout.tile - 2).step_by(3) {
                for x in (2..layout.tile - 2).step_by(3) {
                    let inner = layout.inner() as f32;
                    let point = patch.at((Vec2::new(x as f32, y as f32) + 1.0 - layout.gutter as f32) / inner);
                    let [near, right, down, far] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                    let hu = 0.5 * (right + far - near - down) * inner;
                    let hv = 0.5 * (down + far - near - right) * inner;
                    // The gradient g on the surface satisfies g·du = hu and g·dv = hv.
                    let n = point.du.cross(point.dv);
                    let gradient = (hu * point.dv.cross(n) + hv * n.cross(point.du)) / n.length_squared();
                    let east = Vec3::Z.cross(point.position).normalize();
                    let south = east.cross(point.position.normalize());
                    slopes.push((point.position, DVec2::new(gradient.dot(south).into(), gradient.dot(east).into())));
                }
            }
        }
        slopes
    }

    #[test]
    fn baked_slopes_are_as_prescribed() {
        for sigma in [Vec2::ONE, Vec2::new(0.2, 0.4), Vec2::new(0.01, 0.04), Vec2::new(0.2, 1.6)] {
            for frequency in [Frequency::High, Frequency::Low] {
                let detail = Detail { patches: 6, tile: 64 };
                let surface = Surface::bake(sigma, frequency, detail);
                let unit = sigma.as_dvec2() / f64::from(sigma.max_element());
                // The excess variance vanishes at twice the angle of the cap.
                let rim = (2.0 * surface.cap).cos().max(0.0);
                let slopes = slopes(&surface);
                let inside: Vec<DVec2> =
                    slopes.iter().filter(|(p, _)| p.z.abs() <= rim).map(|(_, s)| *s / unit).collect();
                let n = inside.len() as f64;
                let mean = inside.iter().sum::<DVec2>() / n;
                let square = inside.iter().map(|s| *s * *s).sum::<DVec2>() / n;
                let cross = inside.iter().map(|s| s.x * s.y).sum::<f64>() / n;
                let fourth = inside.iter().map(|s| *s * *s * *s * *s).sum::<DVec2>() / n;
                let kurtosis = fourth / (square * square);
                println!("{sigma} {frequency:?}: mean {mean} square {square} cross {cross:.4} kurtosis {kurtosis}");
                // A single field deviates from its expectation. The deviation is larger if there are fewer bumps.
                let (variance, fourth) = if frequency == Frequency::High { (0.06, 0.15) } else { (0.08, 0.2) };
                assert!(mean.abs().max_element() < 0.02, "{sigma} {frequency:?}: {mean}");
                assert!((square - 1.0).abs().max_element() < variance, "{sigma} {frequency:?}: {square}");
                assert!(cross.abs() < 0.05, "{sigma} {frequency:?}: {cross}");
                assert!((kurtosis - 3.0).abs().max_element() < fourth, "{sigma} {frequency:?}: {kurtosis}");
            }
        }
    }
}
