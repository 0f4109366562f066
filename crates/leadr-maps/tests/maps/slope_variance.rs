//! Compares the moments of LEADR maps at every level with triangle slopes from vertices, on scanned materials and on the
//! most difficult maps.

use leadr_maps::{HeightMap, LeadrMap, Wrap, load_height_map};
use leadr_testing::shared::shared_data;

/// The means `E[x], E[y], E[xx], E[yy], E[xy]` over the square of one texel.
type Means = [f64; 5];

/// Returns the slope of the plane through three points.
fn slope(p: [[f64; 3]; 3]) -> [f64; 2] {
    let edge = |i: usize| -> [f64; 3] { std::array::from_fn(|k| p[i][k] - p[0][k]) };
    let (u, v) = (edge(1), edge(2));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    [-normal[0] / normal[2], -normal[1] / normal[2]]
}

/// Returns the moments per texel of a repeating map's triangles. Four of them meet in the centre of each cell.
fn triangles(map: &HeightMap) -> Vec<Means> {
    let (w, h) = (map.width as usize, map.height as usize);
    let mut texels = vec![[0.0; 5]; w * h];
    for y in 0..h {
        for x in 0..w {
            // A cell lies between the centres of four texels.
            let corner = |i: usize| {
                let (cx, cy) = (x + (i & 1), y + (i >> 1));
                let position = [(cx as f64 + 0.5) / w as f64, (cy as f64 + 0.5) / h as f64];
                let texel = (cy % h) * w + cx % w;
                (texel, [position[0], position[1], f64::from(map.texels[texel])])
            };
            let corners = [0, 1, 2, 3].map(corner);
            let middle = std::array::from_fn(|k| 0.25 * corners.iter().map(|(_, p)| p[k]).sum::<f64>());
            // A triangle covers half a quarter of the cell at each end of its edge.
            for edge in [[0, 1], [2, 3], [0, 2], [1, 3]] {
                let [(first, from), (second, to)] = edge.map(|i| corners[i]);
                let [sx, sy] = slope([from, to, middle]);
                let moments = [sx, sy, sx * sx, sy * sy, sx * sy];
                for texel in [first, second] {
                    texels[texel].iter_mut().zip(moments).for_each(|(sum, m)| *sum += 0.125 * m);
                }
            }
        }
    }
    texels
}

/// Returns the means over squares of `2^level` texels. The map must be square with a power-of-two side.
fn level_of(texels: &[Means], side: usize, level: u32) -> Vec<Means> {
    let coarse = side >> level;
    let mut means = vec![[0.0; 5]; coarse * coarse];
    for (i, texel) in texels.iter().enumerate() {
        let at = ((i / side) >> level) * coarse + ((i % side) >> level);
        means[at].iter_mut().zip(texel).for_each(|(sum, m)| *sum += m / f64::from(1u32 << (2 * level)));
    }
    means
}

/// Returns the mean over a level of the variances and the covariance inside its texels.
fn variance(texels: &[Means]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &[x, y, xx, yy, xy] in texels {
        let texel = [xx - x * x, yy - y * y, xy - x * y];
        sum.iter_mut().zip(texel).for_each(|(sum, v)| *sum += v / texels.len() as f64);
    }
    sum
}

/// Returns the largest relative errors of `leadr` over all levels compared with triangles: of the variances, and of the
/// covariance in the same unit.
fn errors(map: &HeightMap, leadr: &LeadrMap) -> [f64; 2] {
    assert_eq!(map.width, map.height);
    let side = map.width as usize;
    let texels = triangles(map);
    let mut worst = [0.0f64; 2];
    for (level, of_map) in leadr.levels.iter().enumerate() {
        let expected = variance(&level_of(&texels, side, level as u32));
        let stored: Vec<Means> = of_map
            .texels
            .iter()
            .map(|t| [t.mean_slope[0], t.mean_slope[1], t.second[0], t.second[1], t.cross].map(f64::from))
            .collect();
        let found = variance(&stored);
        let scale = 0.5 * (expected[0] + expected[1]);
        for k in 0..2 {
            // Along an axis without slopes, any slope counts as an error.
            let error = (found[k] - expected[k]).abs() / expected[k].max(1e-6 * scale);
            worst[0] = worst[0].max(error);
        }
        worst[1] = worst[1].max((found[2] - expected[2]).abs() / scale);
    }
    worst
}

/// Returns the variance of level 0 by central differences.
fn central_variance(map: &HeightMap) -> [f64; 2] {
    let n = map.width;
    let mut sum = [0.0f64; 2];
    for y in 0..n {
        for x in 0..n {
            let difference = |a: f32, b: f32| 0.5 * f64::from(n) * f64::from(a - b);
            sum[0] += difference(map.at((x + 1) % n, y), map.at((x + n - 1) % n, y)).powi(2);
            sum[1] += difference(map.at(x, (y + 1) % n), map.at(x, (y + n - 1) % n)).powi(2);
        }
    }
    sum.map(|s| s / f64::from(n * n))
}

fn check(name: &str, map: &HeightMap) {
    let [variance_error, covariance_error] = errors(map, &LeadrMap::new(map, Wrap::Repeat));
    let all = variance(&level_of(&triangles(map), map.width as usize, map.width.ilog2()));
    let central = central_variance(map);
    let lost = |k: usize| 100.0 * (central[k] / all[k] - 1.0);
    println!(
        "{name}: variance within {:.4} % of the triangles' at every level, covariance within {:.4} %; central differences \
         {:+.0} and {:+.0} %",
        100.0 * variance_error,
        100.0 * covariance_error,
        lost(0),
        lost(1)
    );
    assert!(variance_error < 2e-3 && covariance_error < 2e-3, "{name}: {variance_error} {covariance_error}");
}

fn made(height: impl Fn(u32, u32) -> f32) -> HeightMap {
    HeightMap::new(64, 64, (0..64 * 64).map(|i| height(i % 64, i / 64)).collect()).unwrap()
}

#[test]
fn hard_maps_keep_the_variance_of_their_triangles() {
    let noise = |x: u32, y: u32| {
        let mixed = (x * 64 + y + 1).wrapping_mul(0x9e37_79b1);
        ((mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b) >> 8) as f32 / (1 << 24) as f32
    };
    check("white noise", &made(noise));
    check("checker of one texel", &made(|x, y| ((x + y) % 2) as f32));
    check("step", &made(|x, y| f32::from(u8::from(x < 20)) + 0.3 * f32::from(u8::from(y > 40 && x > 30))));
    // Central differences must fail the check, because they find no variance on a checkerboard.
    assert!(central_variance(&made(|x, y| ((x + y) % 2) as f32))[0] == 0.0);
    let mut broken = LeadrMap::new(&made(noise), Wrap::Repeat);
    broken.levels[3].texels.iter_mut().for_each(|t| t.second[0] *= 1.01);
    assert!(errors(&made(noise), &broken)[0] > 2e-3);
}

#[test]
#[ignore = "long"]
fn scanned_materials_keep_the_variance_of_their_triangles() {
    let Some(folder) = shared_data("displacement") else { return };
    let mut found = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let folder = entry.unwrap().path();
        for file in std::fs::read_dir(&folder).unwrap() {
            let file = file.unwrap().path();
            if file.to_string_lossy().ends_with("Displacement.png") {
                check(&folder.file_name().unwrap().to_string_lossy(), &load_height_map(&file).unwrap());
                found += 1;
            }
        }
    }
    assert!(found >= 5, "{found} maps");
}
