//! Periodic lattice noise, a pure function of seed and place. Coordinates are in lattice cells; `period` cells repeat.

/// A well-mixed 32-bit number of a seed and a cell (Murmur's finaliser between the words).
pub(crate) fn hash(seed: u32, x: i32, y: i32) -> u32 {
    let mix = |mut h: u32| {
        h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^ (h >> 16)
    };
    let h = mix(seed.wrapping_mul(0x9e37_79b1).wrapping_add(0x7f4a_7c15));
    let h = mix(h ^ (x as u32).wrapping_mul(0x9e37_79b1));
    mix(h ^ (y as u32).wrapping_mul(0x27d4_eb2f))
}

/// Uniform in 0..1.
pub(crate) fn unit(h: u32) -> f32 {
    (h >> 8) as f32 / (1 << 24) as f32
}

/// Gradient noise with unit gradients and quintic blending, scaled into -1..1, mean 0.
pub(crate) fn gradient(seed: u32, x: f32, y: f32, period: i32) -> f32 {
    let (cx, cy) = (x.floor(), y.floor());
    let (fx, fy) = (x - cx, y - cy);
    let corner = |i: i32, j: i32| {
        let cell = hash(seed, (cx as i32 + i).rem_euclid(period), (cy as i32 + j).rem_euclid(period));
        let (sin, cos) = (unit(cell) * std::f32::consts::TAU).sin_cos();
        cos * (fx - i as f32) + sin * (fy - j as f32)
    };
    let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let (u, v) = (fade(fx), fade(fy));
    let value = mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v);
    value * std::f32::consts::SQRT_2
}

/// Octaves of [`gradient`], each of twice the frequency and `gain` times the height.
pub(crate) fn fractal(seed: u32, x: f32, y: f32, period: i32, octaves: u32, gain: f32) -> f32 {
    let (mut sum, mut amplitude) = (0.0, 1.0);
    for octave in 0..octaves {
        let scale = (1 << octave) as f32;
        sum += amplitude * gradient(seed.wrapping_add(octave), x * scale, y * scale, period << octave);
        amplitude *= gain;
    }
    sum
}

/// One feature point near a place, of one random point per cell.
#[derive(Clone, Copy)]
pub(crate) struct Feature {
    /// From the point to the place, in cells.
    pub offset: [f32; 2],
    /// The cell's random number.
    pub id: u32,
}

/// Calls `visit` with the feature points of the `(2 reach + 1)^2` cells around a place.
pub(crate) fn features(seed: u32, x: f32, y: f32, period: i32, reach: i32, mut visit: impl FnMut(Feature)) {
    let (cx, cy) = (x.floor() as i32, y.floor() as i32);
    for j in -reach..=reach {
        for i in -reach..=reach {
            let id = hash(seed, (cx + i).rem_euclid(period), (cy + j).rem_euclid(period));
            let (px, py) = (unit(id), unit(hash(id, 1, 2)));
            let offset = [x - (cx + i) as f32 - px, y - (cy + j) as f32 - py];
            visit(Feature { offset, id });
        }
    }
}

/// Distances to the nearest and second nearest feature point, in cells; their difference is 0 on cell borders.
pub(crate) fn nearest_two(seed: u32, x: f32, y: f32, period: i32) -> [f32; 2] {
    let mut best = [f32::MAX; 2];
    features(seed, x, y, period, 2, |feature| {
        let d = feature.offset[0].hypot(feature.offset[1]);
        if d < best[0] {
            best = [d, best[0]];
        } else if d < best[1] {
            best[1] = d;
        }
    });
    best
}
