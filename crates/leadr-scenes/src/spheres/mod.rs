//! Spheres of specified roughness: the cells of the LEADR supplement's tables.
//!
//! [`noise`] is the height function, and [`surface`] bakes it for the renderer. [`cell`] is one sphere of a table, with the three kinds of
//! lighting. [`grid`] shows all sixteen spheres.

pub mod cell;
pub mod grid;
pub mod noise;
pub mod surface;

use glam::Vec2;

/// The standard deviations `σ = σ_θ = σ_φ` of the isotropic rows (supplement, tables 4, 6, 8).
pub const ISOTROPIC: [f32; 7] = [0.01, 0.05, 0.25, 0.5, 1.0, 1.5, 2.0];

/// The standard deviations `(σ_θ, σ_φ)` of the anisotropic rows (supplement, tables 5, 7, 9), with the pairs that table 5 prints. All have
/// `σ_θ < σ_φ`: slopes are steeper along the parallels, so scratches run from pole to pole (longitudinal in the supplement's text). A pair
/// with swapped components has scratches parallel to the equator (latitudinal).
pub const ANISOTROPIC: [Vec2; 9] = [
    Vec2::new(0.01, 0.02),
    Vec2::new(0.01, 0.04),
    Vec2::new(0.01, 0.08),
    Vec2::new(0.05, 0.1),
    Vec2::new(0.05, 0.2),
    Vec2::new(0.05, 0.4),
    Vec2::new(0.2, 0.4),
    Vec2::new(0.2, 0.8),
    Vec2::new(0.2, 1.6),
];
