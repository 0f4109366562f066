//! What baking found out.

/// Error of a level against 32-bit floats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelError {
    /// Root mean square difference of the worst channel, over its root mean square on level 0.
    pub channels: f64,
    /// Root mean square difference of the variance that texels tell (what is left after subtracting the squares of means), over
    /// the variance of the whole map. Infinite where that has none.
    pub variance: f64,
}

/// What was baked. Slopes are `dh/ds`, `dh/dt` (module documentation), of level 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Texels of each level, the largest first.
    pub levels: Vec<[u32; 2]>,
    /// Mean slope.
    pub mean_slope: [f64; 2],
    /// Variances of slope along `s` and `t`, and their covariance.
    pub slope_variance: [f64; 3],
    /// Least and greatest mean slope of a texel, along `s` and `t`.
    pub slope_range: [[f64; 2]; 2],
    /// Least and greatest height.
    pub height_range: [f64; 2],
    /// Least and greatest value of each channel.
    pub channel_ranges: Vec<[f64; 2]>,
    /// Error of each level.
    pub errors: Vec<LevelError>,
}
