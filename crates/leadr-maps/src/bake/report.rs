//! Statistics of a bake.

/// The error of a stored level compared to 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelError {
    /// The RMS difference of the worst channel that is not of a class, relative to the channel's RMS on level 0.
    pub channels: f64,
    /// The RMS difference of the texels' variance (second moments minus squared means), relative to the variance of the
    /// whole map. The result is infinite if the map has no variance.
    pub variance: f64,
    /// The RMS difference of the worst channel of a class, relative to the channel's RMS on level 0. Slopes that are small compared
    /// with a base material of roughness 0.35 count as such slopes, and small heights as a tenth of the deviation.
    pub classes: f64,
}

/// The statistics of level 0. The slopes are `dh/ds` and `dh/dt` (see the module documentation).
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The size of each level in texels, largest first.
    pub levels: Vec<[u32; 2]>,
    /// The mean of the slopes along `s` and `t`.
    pub mean_slope: [f64; 2],
    /// The variances of the slopes along `s` and `t`, and their covariance.
    pub slope_variance: [f64; 3],
    /// The minimum and maximum of the texels' mean slopes, first along `s`, then along `t`.
    pub slope_range: [[f64; 2]; 2],
    /// The minimum and maximum height.
    pub height_range: [f64; 2],
    /// The minimum and maximum of each channel.
    pub channel_ranges: Vec<[f64; 2]>,
    /// The error of each level.
    pub errors: Vec<LevelError>,
}
