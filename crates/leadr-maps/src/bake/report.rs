//! Statistics of a bake.

/// Error of a stored level relative to 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelError {
    /// RMS difference of the worst channel, relative to the channel's RMS on level 0.
    pub channels: f64,
    /// RMS difference of the texels' variance (second moments minus squared means), relative to the variance of the whole map.
    /// Infinite if the map has no variance.
    pub variance: f64,
}

/// Statistics of level 0. Slopes are `dh/ds`, `dh/dt` (see the module documentation).
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Size of each level in texels, largest first.
    pub levels: Vec<[u32; 2]>,
    /// Mean of the slopes along `s` and `t`.
    pub mean_slope: [f64; 2],
    /// Variances of the slopes along `s` and `t`, and their covariance.
    pub slope_variance: [f64; 3],
    /// Minimum and maximum of the texels' mean slopes, along `s` and `t`.
    pub slope_range: [[f64; 2]; 2],
    /// Minimum and maximum height.
    pub height_range: [f64; 2],
    /// Minimum and maximum of each channel.
    pub channel_ranges: Vec<[f64; 2]>,
    /// Error of each level.
    pub errors: Vec<LevelError>,
}
