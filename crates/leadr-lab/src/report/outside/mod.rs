//! Reads the truths of an independent renderer, which `scripts/external-truth` stored beside this file. Each truth has the
//! block means of a picture, the picture's content and noise.

pub mod panoramas;
pub mod reliefs;

use glam::Vec3;
use serde::Deserialize;

use leadr_tools::error::LabError;
use leadr_tools::metrics::Mask;

use leadr_maps::{MapFault, RgbImage, decode_environment};
use leadr_render::camera::Camera;
use leadr_render::settings::Terms;

/// The content of one truth, as the scripts write it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct OutsideCase {
    /// The name in the form `group/subject/…/terms`.
    pub name: String,
    /// The name of the scene, which is `sphere` or `plane`.
    pub scene: String,
    /// The name of the panorama.
    pub panorama: String,
    /// The name of the height map.
    pub relief: String,
    /// The factor that multiplies the heights. 0 makes the surface flat.
    pub scale: f32,
    /// The Beckmann roughness.
    pub alpha: f32,
    /// The light term from the environment, which is `specular` or `diffuse`.
    pub terms: String,
    /// The size of the whole picture in pixels.
    pub size: [u32; 2],
    camera: StoredCamera,
    /// The number of pixels along a side of a stored block.
    pub block: u32,
    /// The standard error of the truth's pixels, relative like rRMSE.
    pub noise: f64,
    /// The index of the truth's first texel in the texels of all truths.
    start: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
struct StoredCamera {
    position: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov_degrees: f32,
}

impl OutsideCase {
    /// Returns the camera of the picture.
    pub fn camera(&self) -> Camera {
        let StoredCamera { position, target, up, fov_degrees } = self.camera;
        Camera { up: up.into(), ..Camera::looking_at(Vec3::from(position), Vec3::from(target), fov_degrees) }
    }

    /// Returns the light term of the picture.
    pub fn terms(&self) -> Terms {
        if self.terms == "diffuse" { Terms::DIFFUSE_ENVIRONMENT } else { Terms::SPECULAR_ENVIRONMENT }
    }

    /// Returns the first part of the name, which groups the tables: `sphere`, `flat` or `plane`.
    pub fn group(&self) -> &str {
        self.name.split('/').next().unwrap_or_default()
    }
}

/// A truth, and the blocks that are compared.
#[derive(Clone, Debug)]
pub struct OutsideTruth {
    /// The description of the truth.
    pub case: OutsideCase,
    /// The means of the picture's blocks.
    pub image: RgbImage,
    /// The blocks that lie entirely on the object.
    pub mask: Mask,
}

/// Returns all stored truths.
///
/// # Errors
/// Fails if the stored files are inconsistent.
pub fn truths() -> Result<Vec<OutsideTruth>, LabError> {
    let cases: Vec<OutsideCase> =
        serde_json::from_str(include_str!("truths.json")).map_err(|e| LabError(format!("truths.json: {e}")))?;
    let all = decode_environment(include_bytes!("truths.hdr")).map_err(|e| LabError(format!("truths.hdr: {e}")))?;
    cases
        .into_iter()
        .map(|case| {
            let [width, height] = case.size.map(|n| n / case.block.max(1));
            let end = case.start + (width * height) as usize;
            let texels = all.texels.get(case.start..end).map(<[_]>::to_vec);
            let texels = texels.ok_or_else(|| LabError(format!("truths.hdr has no texels for {}", case.name)))?;
            let inside = texels.iter().map(|t| t.iter().any(|&c| c > 0.0)).collect();
            let image = RgbImage::new(width, height, texels).map_err(|e| LabError(format!("{}: {e}", case.name)))?;
            Ok(OutsideTruth { case, image, mask: Mask { width, height, inside } })
        })
        .collect()
}

/// Computes the means of blocks of `side × side` pixels.
///
/// # Errors
/// Fails if the picture is smaller than a block.
pub fn block_means(image: &RgbImage, side: u32) -> Result<RgbImage, MapFault> {
    let (width, height) = (image.width / side, image.height / side);
    let mean = |x: u32, y: u32| {
        let mut sum = [0.0f32; 3];
        for (dx, dy) in (0..side * side).map(|i| (i % side, i / side)) {
            let texel = image.at(x * side + dx, y * side + dy);
            (0..3).for_each(|c| sum[c] += texel[c]);
        }
        sum.map(|s| s / (side * side) as f32)
    };
    RgbImage::new(width, height, (0..width * height).map(|i| mean(i % width, i / width)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_cases_are_complete_and_valid() {
        let truths = truths().unwrap();
        assert!(truths.len() > 60, "{}", truths.len());
        for OutsideTruth { case, image, mask } in &truths {
            assert!(panoramas::NAMES.contains(&case.panorama.as_str()), "{}", case.panorama);
            assert!(reliefs::NAMES.contains(&case.relief.as_str()), "{}", case.relief);
            assert!(case.noise > 0.0 && case.noise < 0.1, "{}: {}", case.name, case.noise);
            let share = mask.count() as f64 / mask.inside.len() as f64;
            assert!((0.2..=1.0).contains(&share), "{}: {share}", case.name);
            image.check_radiance().unwrap();
            assert_eq!(case.camera().target.truncate(), glam::Vec2::ZERO);
        }
    }

    #[test]
    fn blocks_are_means() {
        let image = RgbImage::new(4, 2, (0..8).map(|i| [i as f32, 1.0, 0.0]).collect()).unwrap();
        assert_eq!(block_means(&image, 2).unwrap().texels, [[2.5, 1.0, 0.0], [4.5, 1.0, 0.0]]);
    }
}
