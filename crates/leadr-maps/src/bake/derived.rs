//! Maps derived before baking: heights from normals, and ambient visibility.

use super::Inputs;
use crate::derive::{About, Integrated, Integration, SLICES, Slopes, heights_of_slopes, visibility};
use crate::{MapFault, limits};

/// Fit of integrated heights to the normals' slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundHeights {
    /// RMS of the normals' slopes about their mean.
    pub slope_rms: f64,
    /// Share of their squared slopes that is curl, which no heights can have.
    pub curl_share: f64,
    /// RMS of the slope residual.
    pub residual_rms: f64,
    /// The mean slope, which repeating heights cannot have.
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
    /// Integrates the slopes of the normals to heights, in texture widths.
    ///
    /// # Errors
    /// If normals are missing, or memory is short.
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

    /// Computes the visibility of each texel from the heights. It uses the slopes of the heights, since those of the normals
    /// differ only by curl.
    ///
    /// # Errors
    /// If heights are missing, or memory is short.
    pub fn compute_occlusion(&mut self, progress: &dyn Fn(f32)) -> Result<(), MapFault> {
        let Some(heights) = &self.heights else {
            let what = "there are no heights to compute occlusion from";
            return Err(MapFault::unsupported(what, "give a height map or a normal map"));
        };
        // Heights without a known unit have no known steepness: assume the map is one unit wide.
        let scale = self.usual_height_scale();
        let found = visibility(heights, scale, self.wrap, About::Surface, SLICES, progress)?;
        let mut texels = limits::zeroed::<[f32; 4]>(found.visibility.len())?;
        for (i, texel) in texels.iter_mut().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| found.vectors[axis][i]);
            // y up, as in normal maps.
            *texel = [x, -y, z, found.visibility[i]];
        }
        self.visibility = Some(texels);
        Ok(())
    }
}
