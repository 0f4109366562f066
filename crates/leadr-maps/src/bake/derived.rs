//! What is found from the pictures before they are baked: heights of normals, and what of the surroundings texels see.

use super::Inputs;
use crate::derive::{About, Integrated, Integration, SLICES, Slopes, heights_of_slopes, visibility};
use crate::{MapFault, limits};

/// How well the slopes of found heights are those of the normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundHeights {
    /// Root mean square of the normals' slopes about their mean.
    pub slope_rms: f64,
    /// Share of their squares that no heights have, as the slopes have curl.
    pub curl_share: f64,
    /// Root mean square of the slopes that the heights leave over.
    pub residual_rms: f64,
    /// The mean slope, which heights that repeat leave out.
    pub mean_slope: [f64; 2],
}

impl std::fmt::Display for FoundHeights {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { slope_rms, curl_share, residual_rms, mean_slope: [s, t] } = self;
        write!(
            f,
            "slopes of {slope_rms:.4} rms, of which {residual_rms:.4} are left over; no heights have {:.2} % of their squares; mean slope {s:.4} {t:.4}",
            100.0 * curl_share
        )
    }
}

impl Inputs {
    /// Finds heights, in widths of the texture, from the slopes of the normals.
    ///
    /// # Errors
    /// If there are no normals, or memory is short.
    pub fn find_heights(&mut self, progress: &dyn Fn(f32)) -> Result<FoundHeights, MapFault> {
        let Some(normals) = &self.normals else {
            return Err(MapFault::unsupported("there are no normals to find heights of", "give a normal map"));
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

    /// Finds what each texel sees of its surroundings past the heights, which must be there. About the slopes of the heights: those of
    /// the normals differ only in what no height has.
    ///
    /// # Errors
    /// If there are no heights, or memory is short.
    pub fn look_around(&mut self, progress: &dyn Fn(f32)) -> Result<(), MapFault> {
        let Some(heights) = &self.heights else {
            let what = "there are no heights to look around from";
            return Err(MapFault::unsupported(what, "give a height map or a normal map"));
        };
        // With heights in the unit of their map nothing tells how steep they are: the map is taken to be as wide as that.
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
