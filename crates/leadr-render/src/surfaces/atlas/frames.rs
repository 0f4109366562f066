//! Converts height gradients between the coordinates of patches.
//!
//! A tile stores the derivatives of the height with respect to its own texture coordinates. The derivatives describe the gradient
//! on the surface, a vector in the tangent plane. At a shared edge, each patch can express this vector in its own coordinates. The
//! frames are computed on the rest surface. A deformation moves the tangents of all patches alike, so the conversion between two
//! patches stays valid.

use glam::{Vec2, Vec3};

use super::turns::turned_tangents;
use crate::surfaces::patch::Patch;
use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};

/// The tangents with respect to texture coordinates, and the dual basis of the tangents.
#[derive(Clone, Copy, Debug, Default)]
pub struct TextureFrame {
    /// The tangents `∂X/∂s, ∂X/∂t`, in metres per unit of texture coordinate.
    pub tangents: [Vec3; 2],
    /// The gradients of `s` and `t` on the surface, with `tangents[i] · duals[j] = δij`.
    pub duals: [Vec3; 2],
}

impl TextureFrame {
    /// Returns the frame that has these two tangents. The duals stay bounded for degenerate tangents.
    pub fn new(s: Vec3, t: Vec3) -> Self {
        let (ss, tt, st) = (s.length_squared(), t.length_squared(), s.dot(t));
        let determinant = (ss * tt - st * st).max(1e-4 * ss * tt);
        let inverse = if determinant > 0.0 { 1.0 / determinant } else { 0.0 };
        Self { tangents: [s, t], duals: [(s * tt - t * st) * inverse, (t * ss - s * st) * inverse] }
    }
}

/// Returns the orthonormal pair that is nearest to two directions, as `cone_on_surface` of `passes/filter/filtered.glsl`.
pub fn orthonormal([s, t]: [Vec3; 2]) -> [Vec3; 2] {
    let (s, t) = (s.normalize_or_zero(), t.normalize_or_zero());
    // The bisectors of two unit vectors are orthogonal.
    let [between, across] = [s + t, s - t].map(|bisector| bisector.normalize_or_zero() * 0.5f32.sqrt());
    [between + across, between - across]
}

/// Returns the columns of the matrix that converts derivatives from the coordinates of `from` to the coordinates of `to`.
pub fn gradient_transform(from: &TextureFrame, to: &TextureFrame) -> [f32; 4] {
    let [s, t] = from.duals;
    [to.tangents[0].dot(s), to.tangents[1].dot(s), to.tangents[0].dot(t), to.tangents[1].dot(t)]
}

/// The texture frames of an atlas's patches at rest.
pub struct AtlasFrames {
    patches: Vec<Patch>,
    corners: Vec<[TextureFrame; 4]>,
    /// The number of patch coordinates per unit of texture coordinate.
    per_texture: Vec2,
}

impl AtlasFrames {
    /// Computes the frames of all patches of a mesh.
    pub fn new(mesh: &PatchMesh, layout: TileLayout) -> Self {
        let (width, height) = layout.size();
        let per_texture = Vec2::new(width as f32, height as f32) / layout.inner() as f32;
        let patches: Vec<Patch> = (mesh.patches.iter())
            .map(|p| Patch::new(p.map(|v| mesh.positions[v as usize]), p.map(|v| mesh.normals[v as usize])))
            .collect();
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let corners = patches.iter().map(|patch| corners.map(|uv| frame(patch, per_texture, uv))).collect();
        Self { patches, corners, per_texture }
    }

    /// Returns the frames whose tangents have unit length and are turned by these numbers of quarter turns.
    #[must_use]
    pub fn aligned(mut self, turns: &[u32]) -> Self {
        for (corners, turn) in self.corners.iter_mut().zip(turns) {
            for frame in corners {
                let [s, t] = turned_tangents(frame.tangents.map(Vec3::normalize_or_zero), *turn);
                *frame = TextureFrame::new(s, t);
            }
        }
        self
    }

    /// Returns the frame at a corner of a patch.
    pub fn corner(&self, patch: usize, corner: usize) -> TextureFrame {
        self.corners[patch][corner]
    }

    /// Returns the frame at parameter `uv` of a patch.
    pub fn at(&self, patch: usize, uv: Vec2) -> TextureFrame {
        frame(&self.patches[patch], self.per_texture, uv)
    }
}

fn frame(patch: &Patch, per_texture: Vec2, uv: Vec2) -> TextureFrame {
    let point = patch.at(uv);
    TextureFrame::new(point.du * per_texture.x, point.dv * per_texture.y)
}

/// Values that are stored in tiles and averaged across patches. A common form carries the values across patch borders.
pub trait Carried: Linear {
    /// The common form of the values, which does not depend on the patch.
    type Common: Linear;
    /// Converts the values from the coordinates of a patch to the common form.
    fn lift(&self, frame: &TextureFrame) -> Self::Common;
    /// Converts values from the common form to the coordinates of a patch.
    fn land(common: &Self::Common, frame: &TextureFrame) -> Self;
}

/// Values that can be averaged.
pub trait Linear: Copy + Default + Send + Sync {
    /// Adds `other · weight` to this value.
    fn add(&mut self, other: &Self, weight: f32);
}

impl<const N: usize> Linear for [f32; N]
where
    [f32; N]: Default,
{
    fn add(&mut self, other: &Self, weight: f32) {
        for (sum, value) in self.iter_mut().zip(other) {
            *sum += value * weight;
        }
    }
}

/// The moments of the height derivatives, `E[hs], E[ht], E[hs²], E[ht²], E[hs·ht]`. The common form has the mean gradient, and the
/// second moments `xx, yy, zz, yz, zx, xy` of the gradient.
impl Carried for [f32; 5] {
    type Common = [f32; 9];

    fn lift(&self, frame: &TextureFrame) -> [f32; 9] {
        let [s, t] = frame.duals;
        let [hs, ht, ss, tt, st] = *self;
        let mean = s * hs + t * ht;
        // These are products of the second-moment matrix with the dual basis.
        let (of_s, of_t) = (s * ss + t * st, s * st + t * tt);
        let row = |k: usize| of_s * s[k] + of_t * t[k];
        let (x, y, z) = (row(0), row(1), row(2));
        [mean.x, mean.y, mean.z, x.x, y.y, z.z, y.z, z.x, x.y]
    }

    fn land(common: &[f32; 9], frame: &TextureFrame) -> Self {
        let [s, t] = frame.tangents;
        let [gx, gy, gz, xx, yy, zz, yz, zx, xy] = *common;
        let mean = Vec3::new(gx, gy, gz);
        let second = |v: Vec3| {
            Vec3::new(xx * v.x + xy * v.y + zx * v.z, xy * v.x + yy * v.y + yz * v.z, zx * v.x + yz * v.y + zz * v.z)
        };
        let (of_s, of_t) = (second(s), second(t));
        [s.dot(mean), t.dot(mean), s.dot(of_s), t.dot(of_t), s.dot(of_t)]
    }
}

/// The moments of a class of facets, `w` times `1, x, y, z, xx, yy, xy, zz`, with the slopes `x` and `y`. The share `w` and the height `z` are the
/// same in all patches.
impl Carried for [f32; 8] {
    type Common = [f32; 12];

    fn lift(&self, frame: &TextureFrame) -> [f32; 12] {
        let [w, x, y, z, xx, yy, xy, zz] = *self;
        let mut common = [0.0; 12];
        common[..9].copy_from_slice(&[x, y, xx, yy, xy].lift(frame));
        common[9..].copy_from_slice(&[w, z, zz]);
        common
    }

    fn land(common: &[f32; 12], frame: &TextureFrame) -> Self {
        let [slopes @ .., w, z, zz] = *common;
        let [x, y, xx, yy, xy] = <[f32; 5]>::land(&slopes, frame);
        [w, x, y, z, xx, yy, xy, zz]
    }
}

/// Colours are the same in all patches.
impl Carried for [f32; 4] {
    type Common = [f32; 4];

    fn lift(&self, _: &TextureFrame) -> [f32; 4] {
        *self
    }

    fn land(common: &[f32; 4], _: &TextureFrame) -> Self {
        *common
    }
}

/// A cone of ambient visibility in a tile: the direction along `s`, `-t` and the normal, in the [orthonormal] frame nearest to the
/// tangents, and the accessibility. The common form has the part of the direction along the surface in space. The part along the normal
/// and the accessibility are the same in all patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConeTexel(pub [f32; 4]);

impl Linear for ConeTexel {
    fn add(&mut self, other: &Self, weight: f32) {
        self.0.add(&other.0, weight);
    }
}

impl Carried for ConeTexel {
    type Common = [f32; 5];

    fn lift(&self, frame: &TextureFrame) -> [f32; 5] {
        let ([s, t], [x, y, z, open]) = (orthonormal(frame.tangents), self.0);
        let along = s * x - t * y;
        [along.x, along.y, along.z, z, open]
    }

    fn land(&[x, y, z, up, open]: &[f32; 5], frame: &TextureFrame) -> Self {
        let ([s, t], along) = (orthonormal(frame.tangents), Vec3::new(x, y, z));
        Self([s.dot(along), -t.dot(along), up, open])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skewed() -> TextureFrame {
        TextureFrame::new(Vec3::new(2.0, 0.3, 0.1), Vec3::new(-0.4, 1.5, 0.2))
    }

    /// Returns another frame in the same plane as [`skewed`].
    fn other() -> TextureFrame {
        let [s, t] = skewed().tangents;
        TextureFrame::new(s * 0.2 - t * 1.1, s * 0.9 + t * 0.3)
    }

    fn moments(slopes: &[[f32; 2]]) -> [f32; 5] {
        let mut sum = [0.0; 5];
        for [s, t] in slopes {
            sum.add(&[*s, *t, s * s, t * t, s * t], 1.0 / slopes.len() as f32);
        }
        sum
    }

    #[test]
    fn moments_come_back_and_rotate_as_their_slopes_do() {
        let slopes = [[0.3, -0.2], [1.4, 0.9], [-0.8, 0.1]];
        let own = moments(&slopes);
        let lifted = own.lift(&skewed());
        let back = <[f32; 5]>::land(&lifted, &skewed());
        let [a, b, c, d] = gradient_transform(&skewed(), &other());
        let transformed = moments(&slopes.map(|[s, t]| [a * s + c * t, b * s + d * t]));
        let landed = <[f32; 5]>::land(&lifted, &other());
        for i in 0..5 {
            assert!((back[i] - own[i]).abs() < 1e-5, "{back:?} {own:?}");
            assert!((landed[i] - transformed[i]).abs() < 1e-5, "{landed:?} {transformed:?}");
        }
    }

    #[test]
    fn classes_rotate_as_their_slopes_do() {
        let frame = TextureFrame::new(Vec3::X, Vec3::Y);
        let rotated = TextureFrame::new(Vec3::NEG_Y, Vec3::X);
        let of_class = [0.5f32, 0.2, 0.05, 0.3, 0.4, 0.1, 0.02, 0.7];
        let found = <[f32; 8]>::land(&of_class.lift(&frame), &rotated);
        let expected = [0.5, -0.05, 0.2, 0.3, 0.1, 0.4, -0.02, 0.7];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn cones_keep_their_direction_in_every_frame() {
        let [s, t] = orthonormal(skewed().tangents);
        let [a, b] = skewed().tangents.map(Vec3::normalize);
        // The pair is as far from `s` as from `t`, and in their plane.
        assert!((s.dot(a) - t.dot(b)).abs() < 1e-6 && s.dot(a) > 0.98, "{s} {t}");
        assert!(s.dot(t).abs() < 1e-6 && s.cross(t).normalize().dot(a.cross(b).normalize()) > 0.999_999);
        let cone = ConeTexel([0.3, -0.2, 0.6, 0.7]);
        let landed = ConeTexel::land(&cone.lift(&skewed()), &other());
        let [p, q] = orthonormal(other().tangents);
        let there = p * landed.0[0] - q * landed.0[1];
        assert!(there.distance(s * 0.3 + t * 0.2) < 1e-6, "{there}");
        assert_eq!(landed.0[2..], [0.6, 0.7]);
        // A quarter turn of the tangents.
        let turned = TextureFrame::new(Vec3::Y, Vec3::NEG_X);
        let landed = ConeTexel::land(&cone.lift(&TextureFrame::new(Vec3::X, Vec3::Y)), &turned);
        assert!((landed.0[0] - 0.2).abs() < 1e-6 && (landed.0[1] - 0.3).abs() < 1e-6, "{landed:?}");
    }

    #[test]
    fn degenerate_frames_stay_finite() {
        for (s, t) in [(Vec3::ZERO, Vec3::X), (Vec3::X, Vec3::X), (Vec3::ZERO, Vec3::ZERO)] {
            let frame = TextureFrame::new(s, t);
            assert!(frame.duals.iter().all(|d| d.is_finite()));
            assert!([1.0f32, 2.0, 3.0, 4.0, 5.0].lift(&frame).iter().all(|v| v.is_finite()));
            assert!(ConeTexel([0.5; 4]).lift(&frame).iter().all(|v| v.is_finite()));
        }
    }
}
