//! Maps that are derived before baking: heights that are integrated from normals, and ambient visibility.

use super::Inputs;
use crate::derive::{Integrated, Integration, Occlusion, Slopes, heights_of_slopes, visibility};
use crate::{MapFault, limits};

/// How well the integrated heights fit the slopes of the normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundHeights {
    /// The RMS of the normals' slopes about their mean.
    pub slope_rms: f64,
    /// The fraction of the squared slopes that is curl, which no height map can represent.
    pub curl_share: f64,
    /// The RMS difference between the normals' slopes and the slopes of the heights.
    pub residual_rms: f64,
    /// The mean slope of the normals, which repeating heights cannot represent.
    pub mean_slope: [f64; 2],
}

impl std::fmt::Display for FoundHeights {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { slope_rms, curl_share, residual_rms, mean_slope: [s, t] } = self;
        write!(
            f,
            "slope RMS {slope_rms:.4}, residual RMS {residual_rms:.4}, curl {:.2} % of the squared slopes, mean slope {s:.4} {t:.4}",
            100.0 * curl_share
        )
    }
}

impl Inputs {
    /// Integrates the slopes of the normals to heights in texture widths.
    ///
    /// # Errors
    /// Fails if normals are missing or memory runs out.
    pub fn find_heights(&mut self, progress: &dyn Fn(f32)) -> Result<FoundHeights, MapFault> {
        let Some(normals) = &self.normals else {
            return Err(MapFault::unsupported("there are no normals to compute heights from", "give a normal map"));
        };
        let slopes = Slopes::of_normal_map(normals)?;
        let default = Integration::default();
        let how = Integration { wrap: self.wrap, smoothness: self.smoothness.unwrap_or(default.smoothness), ..default };
        let found = heights_of_slopes(&slopes, &how, progress)?;
        let curl_share = found.curl_share();
        let Integrated { heights, mean_slope, slope_rms, residual_rms, .. } = found;
        self.heights = Some(heights);
        self.height_scale = Some(1.0);
        Ok(FoundHeights { slope_rms, curl_share, residual_rms, mean_slope })
    }

    /// Computes the ambient visibility of each texel from the heights. Normals are not used, because the slopes of normals
    /// and heights differ only by curl.
    ///
    /// # Errors
    /// Fails if heights are missing or memory runs out.
    pub fn compute_occlusion(&mut self, progress: &dyn Fn(f32)) -> Result<(), MapFault> {
        let Some(heights) = &self.heights else {
            let what = "there are no heights to compute occlusion from";
            return Err(MapFault::unsupported(what, "give a height map or a normal map"));
        };
        // If the unit of the heights is unknown, the map is assumed to be one unit wide.
        let scale = self.usual_height_scale();
        let default = Occlusion::default();
        let distance = self.occlusion_distance.unwrap_or(default.distance);
        let found = visibility(heights, scale, &Occlusion { wrap: self.wrap, distance, ..default }, progress)?;
        let mut texels = limits::zeroed::<[f32; 4]>(found.visibility.len())?;
        for (i, texel) in texels.iter_mut().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| found.vectors[axis][i]);
            // The y axis of the stored vector points up, as in normal maps.
            *texel = [x, -y, z, found.visibility[i]];
        }
        self.visibility = Some(texels);
        Ok(())
    }
}
