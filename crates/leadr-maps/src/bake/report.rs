//! Statistics of a bake.

/// Error of a level relative to 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelError {
    /// RMS difference of the worst channel, over its RMS on level 0.
    pub channels: f64,
    /// RMS difference of the texels' variance (second moments minus squared means), over the variance of the whole map. Infinite
    /// if that is 0.
    pub variance: f64,
}

/// Statistics of level 0. Slopes are `dh/ds`, `dh/dt` (see the module documentation).
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Size of each level in texels, largest first.
    pub levels: Vec<[u32; 2]>,
    /// Mean slope.
    pub mean_slope: [f64; 2],
    /// Variances of slope along `s` and `t`, and their covariance.
    pub slope_variance: [f64; 3],
    /// Minimum and maximum mean slope of a texel, along `s` and `t`.
    pub slope_range: [[f64; 2]; 2],
    /// Minimum and maximum height.
    pub height_range: [f64; 2],
    /// Minimum and maximum of each channel.
    pub channel_ranges: Vec<[f64; 2]>,
    /// Error of each level.
    pub errors: Vec<LevelError>,
}
