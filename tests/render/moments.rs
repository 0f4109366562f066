//! The moments pass against the CPU's LEADR maps, and atlases against separate maps of their tiles.

use std::f64::consts::TAU;

use leadr::maps::{HeightMap, LeadrMap, Wrap};
use leadr::render::surfaces::displacement::Border;
use leadr::render::surfaces::moments::{LeadrMapGpu, MomentFormat};
use leadr::render::surfaces::patch_mesh::TileLayout;
use leadr_testing::gpu::test_gpu;

/// Bumps of several sizes, without symmetry.
fn bumpy(width: u32, height: u32) -> HeightMap {
    let mut texels = Vec::new();
    for j in 0..height {
        for i in 0..width {
            let (s, t) = ((f64::from(i) + 0.5) / f64::from(width), (f64::from(j) + 0.5) / f64::from(height));
            let h =
                0.2 * (TAU * (3.0 * s + t)).sin() + 0.1 * (9.0 * s * t + 2.0 * t).cos() + 0.05 * (TAU * 7.0 * t).sin();
            texels.push((h + 0.3 * t * t) as f32);
        }
    }
    HeightMap::new(width, height, texels).unwrap()
}

/// A level as six numbers per texel, in the order of `maps::moments::Moments`.
fn read(map: &LeadrMapGpu, mip: u32) -> Vec<[f32; 6]> {
    let (slopes, joint) = (map.read_slopes(mip).unwrap(), map.read_joint(mip).unwrap());
    let heights: Vec<f32> = map.heights.read(mip, 0).unwrap();
    slopes.iter().zip(joint.iter().zip(&heights)).map(|(a, (&b, &h))| [a[0], a[1], a[2], a[3], b, h]).collect()
}

/// Largest difference of each of the six numbers on any level, relative to the largest of its kind in the map.
fn difference(gpu: &LeadrMapGpu, cpu: &LeadrMap) -> [f64; 6] {
    assert_eq!(gpu.levels() as usize, cpu.levels.len());
    let mut scale = [1e-12f64; 6];
    let mut worst = [0.0f64; 6];
    for (mip, level) in cpu.levels.iter().enumerate() {
        let texels = read(gpu, mip as u32);
        assert_eq!(texels.len(), level.texels.len());
        for (a, b) in texels.iter().zip(&level.texels) {
            let b: [f32; 6] = bytemuck::cast(*b);
            for k in 0..6 {
                scale[k] = scale[k].max(f64::from(b[k].abs()));
                worst[k] = worst[k].max((f64::from(a[k]) - f64::from(b[k])).abs());
            }
        }
    }
    std::array::from_fn(|k| worst[k] / scale[k])
}

#[test]
fn maps_match_the_cpu_at_any_size_and_edge() {
    let Some(gpu) = test_gpu() else { return };
    for (width, height) in [(64, 64), (37, 23), (1, 19), (100, 3), (1, 1), (7, 128), (255, 257)] {
        let map = bumpy(width, height);
        for (wrap, border) in [(Wrap::Repeat, Border::Wrap), (Wrap::Clamp, Border::Clamp)] {
            let made = LeadrMapGpu::new(&gpu, &map, border, MomentFormat::Float32).unwrap();
            // Bitwise equal: files baked without a device give the same pictures as the device's maps.
            let worst = difference(&made, &LeadrMap::new(&map, wrap)).into_iter().fold(0.0, f64::max);
            assert_eq!(worst, 0.0, "{width}x{height} {wrap:?}");
            // the other border rule must give other values, except on levels without a border
            let other = if wrap == Wrap::Clamp { Wrap::Repeat } else { Wrap::Clamp };
            let apart = difference(&made, &LeadrMap::new(&map, other)).into_iter().fold(0.0, f64::max);
            assert!(apart > 1e-3 || (width.max(height) == 1), "{apart}");
        }
    }
}

#[test]
fn sixteen_bits_have_a_known_error() {
    let Some(gpu) = test_gpu() else { return };
    let map = bumpy(128, 96);
    let made = LeadrMapGpu::new(&gpu, &map, Border::Wrap, MomentFormat::Float16).unwrap();
    let errors = difference(&made, &LeadrMap::new(&map, Wrap::Repeat));
    println!("16 bits, relative to the largest of each kind: {errors:.6?}");
    // up to one unit in the last place (9.8e-4) per write, since drivers may truncate, and more from level to level
    assert!(errors[..5].iter().all(|e| *e > 1e-6 && *e < 3e-3) && errors[5] == 0.0);
    // The device's rounding and the CPU's for file levels: the same 16-bit floats on level 0.
    let map_moments = LeadrMap::new(&map, Wrap::Repeat);
    let loaded = LeadrMapGpu::with_moments(&gpu, &map_moments, Border::Wrap, MomentFormat::Float16).unwrap();
    assert_eq!(read(&made, 0), read(&loaded, 0));
    // Steep slopes that change evenly: one rounding of their squares loses up to 2^-11 of the variance. The device rounds on every level;
    // half of each loss remains on the next.
    let hill = HeightMap::new(64, 64, (0..64 * 64).map(|i| 0.01 * ((i % 64) as f32).powi(2)).collect()).unwrap();
    let exact = LeadrMap::new(&hill, Wrap::Clamp);
    for (made, most) in [
        (LeadrMapGpu::new(&gpu, &hill, Border::Clamp, MomentFormat::Float16).unwrap(), 1e-3),
        (LeadrMapGpu::with_moments(&gpu, &exact, Border::Clamp, MomentFormat::Float16).unwrap(), 5e-4),
    ] {
        let mut worst = 0.0f64;
        for (mip, level) in exact.levels.iter().enumerate() {
            for (stored, m) in read(&made, mip as u32).iter().zip(&level.texels) {
                let variance = f64::from(stored[2]) - f64::from(stored[0]).powi(2);
                worst = worst.max((variance - m.slope_covariance()[0]).abs() / f64::from(m.second[0]).max(1e-9));
            }
        }
        println!("variance of 16 bits: off by up to {worst:.2e} of the squares");
        assert!(worst < most, "{worst}");
    }

    // values beyond 16-bit floats are clamped: a cliff of slope 1000 has a square beyond 65504
    let cliff = HeightMap::new(4, 1, vec![0.0, 0.0, 500.0, 500.0]).unwrap();
    let made = LeadrMapGpu::new(&gpu, &cliff, Border::Wrap, MomentFormat::Float16).unwrap();
    let texels = read(&made, 0);
    assert_eq!((texels[1][0], texels[1][2]), (1000.0, 65504.0));
}

/// Expected content of one tile on a level, in 64 bits: only the triangles of its own cells, slopes per unit of the atlas.
fn tile_reference(tile: &[f64], edge: usize, atlas: [f64; 2]) -> Vec<Vec<[f64; 6]>> {
    let at = |x: usize, y: usize| tile[y * edge + x];
    let mut level: Vec<[f64; 6]> = (0..edge * edge).map(|i| [0.0, 0.0, 0.0, 0.0, 0.0, tile[i]]).collect();
    let mut areas = vec![0.0; edge * edge];
    for y in 0..edge - 1 {
        for x in 0..edge - 1 {
            let [s0, s1] = [y, y + 1].map(|y| (at(x + 1, y) - at(x, y)) * atlas[0]);
            let [t0, t1] = [x, x + 1].map(|x| (at(x, y + 1) - at(x, y)) * atlas[1]);
            let [s, t] = [0.5 * (s0 + s1), 0.5 * (t0 + t1)];
            // Each of four triangles has a quarter of the cell: an eighth at each end of its edge.
            for ([sx, sy], corners) in [
                ([s0, t], [(0, 0), (1, 0)]),
                ([s1, t], [(0, 1), (1, 1)]),
                ([s, t0], [(0, 0), (0, 1)]),
                ([s, t1], [(1, 0), (1, 1)]),
            ] {
                for (dx, dy) in corners {
                    let texel = (y + dy) * edge + x + dx;
                    let moments = [sx, sy, sx * sx, sy * sy, sx * sy];
                    level[texel].iter_mut().zip(moments).for_each(|(sum, m)| *sum += 0.125 * m);
                    areas[texel] += 0.125;
                }
            }
        }
    }
    for (texel, area) in level.iter_mut().zip(areas) {
        texel[..5].iter_mut().for_each(|m| *m /= area);
    }
    let mut levels = vec![level];
    let mut size = edge;
    while size > 1 {
        let fine = &levels[levels.len() - 1];
        size /= 2;
        let mean = |i: usize| {
            let at = 4 * size * (i / size) + 2 * (i % size);
            std::array::from_fn(|k| {
                (fine[at][k] + fine[at + 1][k] + fine[at + 2 * size][k] + fine[at + 2 * size + 1][k]) / 4.0
            })
        };
        let coarse = (0..size * size).map(mean).collect();
        levels.push(coarse);
    }
    levels
}

#[test]
fn tiles_of_an_atlas_are_independent() {
    let Some(gpu) = test_gpu() else { return };
    let layout = TileLayout { tile: 8, gutter: 2, columns: 4, rows: 3 };
    let (width, height) = layout.size();
    let edge = layout.tile as usize;
    // every tile has its own height offset, so that a difference across tiles would be large
    let bumps = bumpy(width, height);
    let texels: Vec<f32> = (0..width * height)
        .map(|i| bumps.texels[i as usize] + 10.0 * ((i % width / layout.tile) + 7 * (i / width / layout.tile)) as f32)
        .collect();
    let heights = HeightMap { width, height, texels: texels.clone() };
    let made = LeadrMapGpu::new(&gpu, &heights, Border::Tiles(layout), MomentFormat::Float32).unwrap();
    assert_eq!(made.levels(), 4);
    let mut worst = 0.0f64;
    for tile in 0..layout.columns * layout.rows {
        let (x0, y0) = layout.origin(tile);
        let inside: Vec<f64> = (0..edge * edge)
            .map(|i| texels[(y0 as usize + i / edge) * width as usize + x0 as usize + i % edge].into())
            .collect();
        let reference = tile_reference(&inside, edge, [width.into(), height.into()]);
        for (mip, level) in reference.iter().enumerate() {
            let all = read(&made, mip as u32);
            let size = edge >> mip;
            let stride = width as usize >> mip;
            for (i, expected) in level.iter().enumerate() {
                let at = ((y0 as usize >> mip) + i / size) * stride + (x0 as usize >> mip) + i % size;
                for k in 0..6 {
                    let scale = [10.0, 10.0, 100.0, 100.0, 100.0, 100.0][k];
                    worst = worst.max((f64::from(all[at][k]) - expected[k]).abs() / scale);
                }
            }
        }
    }
    println!("atlas: {worst:.2e}");
    assert!(worst < 1e-4, "{worst}"); // heights up to 170 leave 1e-5 of a texel's difference, times 32 texels
    // differences across tiles must fail the same check
    let through = LeadrMapGpu::new(&gpu, &heights, Border::Clamp, MomentFormat::Float32).unwrap();
    let (a, b) = (read(&made, 0), read(&through, 0));
    assert!((a[7][0] - b[7][0]).abs() > 50.0);
}

#[test]
fn wrong_sizes_are_explained() {
    let Some(gpu) = test_gpu() else { return };
    let fails = |width, height, count: usize, border| {
        let texels = vec![0.0; count];
        let heights = HeightMap { width, height, texels };
        LeadrMapGpu::new(&gpu, &heights, border, MomentFormat::Float32).err().expect("refused").to_string()
    };
    assert!(fails(4, 4, 15, Border::Wrap).contains("15 heights do not match 4x4"));
    assert!(fails(0, 4, 0, Border::Wrap).contains("0x4"));
    let layout = TileLayout { tile: 8, gutter: 2, columns: 4, rows: 3 };
    assert!(fails(32, 16, 512, Border::Tiles(layout)).contains("the atlas has 32x24"));
    let moments = |change: &dyn Fn(&mut LeadrMap)| {
        let mut map = LeadrMap::new(&bumpy(8, 8), Wrap::Repeat);
        change(&mut map);
        let made = LeadrMapGpu::with_moments(&gpu, &map, Border::Wrap, MomentFormat::Float32);
        made.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(moments(&|_| ()), "");
    assert!(moments(&|map| map.levels.truncate(3)).contains("has 3 levels instead of 4"));
    assert!(moments(&|map| map.levels[1].width = 5).contains("level 1 has 16 texels"));
    assert!(moments(&|map| map.levels.clear()).contains("no levels"));
}

/// The T-rex's atlas: 4096 x 5696 texels, 839 MB with mips and heights, on a heap of 2 GiB.
#[test]
#[ignore = "takes a gigabyte and some seconds"]
fn creature_sized_atlas_fits_in_memory() {
    let Some(gpu) = test_gpu() else { return };
    let layout = TileLayout { tile: 32, gutter: 2, columns: 128, rows: 178 };
    let (width, height) = layout.size();
    let texels: Vec<f32> = (0..width * height).map(|i| (i as f32 * 0.37).sin()).collect();
    let clock = std::time::Instant::now();
    let heights = HeightMap { width, height, texels: texels.clone() };
    let made = LeadrMapGpu::new(&gpu, &heights, Border::Tiles(layout), MomentFormat::Float32).unwrap();
    println!("{width}x{height}: {} levels in {:?}", made.levels(), clock.elapsed());
    let last = read(&made, made.levels() - 1);
    assert_eq!(last.len(), (layout.columns * layout.rows) as usize);
    assert!(last.iter().all(|t| t[2] > 0.0 && t[3] > 0.0 && t[5].abs() < 1.0));
}
