//! Tests of baked maps against closed forms, brute-force sums, and the renderer's maps.

use std::f64::consts::TAU;
use std::fs::File;

use leadr_maps::bake::{ExrFile, Inputs, Kind, Ktx2File, Layout, Plan, Precision, Report, Roughness, bake};
use leadr_maps::baked::{BakedMap, HeightUnit};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{
    Encoding, GreenAxis, MaterialFolder, NormalMap, Raster, Role, RoughnessMeaning, Samples, Texture,
};
use leadr_maps::{HeightMap, LeadrMap, Wrap, load_height_map};
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

pub fn heights(width: u32, height: u32, f: impl Fn(f64, f64) -> f64) -> HeightMap {
    let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let texels = (0..width * height).map(|i| f(at(i % width, width), at(i / width, height)) as f32).collect();
    HeightMap::new(width, height, texels).unwrap()
}

fn bumpy(width: u32, height: u32) -> HeightMap {
    heights(width, height, |s, t| 0.05 * (TAU * (3.0 * s + t)).sin() + 0.02 * (31.0 * s * t).cos() + 0.1 * t)
}

pub fn of_heights(map: &HeightMap) -> Inputs {
    Inputs { heights: Some(map.clone()), ..Inputs::default() }
}

pub fn file() -> File {
    tempfile::tempfile().unwrap()
}

pub fn bytes_of(inputs: &Inputs, kind: Kind, precision: Precision) -> (Vec<u8>, Report) {
    bytes_of_plan(inputs, &Plan::new(inputs, kind, Layout::Leadr, precision).unwrap())
}

fn bytes_of_plan(inputs: &Inputs, plan: &Plan) -> (Vec<u8>, Report) {
    use std::io::{Read, Seek};
    let mut file = file();
    let mut target = Ktx2File::new(&mut file, plan).unwrap();
    let report = bake(inputs, plan, &mut target, &|_| ()).unwrap();
    target.finish(&report).unwrap();
    let mut bytes = Vec::new();
    file.rewind().unwrap();
    file.read_to_end(&mut bytes).unwrap();
    (bytes, report)
}

pub fn baked(inputs: &Inputs, kind: Kind, precision: Precision) -> (BakedMap, Report) {
    let (bytes, report) = bytes_of(inputs, kind, precision);
    (BakedMap::decode(&bytes).unwrap(), report)
}

fn normal_map(size: [u32; 2], green: GreenAxis, normal: impl Fn(u32, u32) -> [f32; 3]) -> NormalMap {
    let texels = (0..size[0] * size[1]).flat_map(|i| normal(i % size[0], i / size[0]).map(|v| 0.5 * v + 0.5));
    let raster = Raster::new(size[0], size[1], 3, Samples::F32(texels.collect())).unwrap();
    NormalMap { texture: Texture::new(raster, "normals", Encoding::Linear), green, scale: 1.0 }
}

#[test]
fn heights_are_the_leadr_map_to_the_last_bit() {
    for (w, h) in [(64, 64), (37, 23), (1, 19), (100, 3), (1, 1), (5, 200)] {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let map = bumpy(w, h);
            let inputs = Inputs { wrap, ..of_heights(&map) };
            let (read, report) = baked(&inputs, Kind::Leadr, Precision::F32);
            let expected = LeadrMap::new(&map, wrap);
            assert_eq!(read.moments().unwrap(), expected, "{w} x {h}");
            assert_eq!(read.wrap, wrap);
            let [xx, yy, _] = expected.mean().slope_covariance();
            let scale = xx + yy + 1e-12;
            assert!(
                (report.slope_variance[0] - xx).abs() < 1e-4 * scale
                    && (report.slope_variance[1] - yy).abs() < 1e-4 * scale
            );
            assert!(report.errors.iter().all(|e| e.channels == 0.0 && e.variance == 0.0));
        }
    }
    // A different map must fail the comparison.
    let (other, _) =
        baked(&Inputs { height_scale: Some(1.0 + 1e-6), ..of_heights(&bumpy(37, 23)) }, Kind::Leadr, Precision::F32);
    assert_ne!(other.moments().unwrap(), LeadrMap::new(&bumpy(37, 23), Wrap::Repeat));
}

#[test]
fn height_scale_scales_slopes_and_their_squares() {
    let map = bumpy(32, 16);
    let (one, _) = baked(&of_heights(&map), Kind::Leadr, Precision::F32);
    let (half, _) = baked(&Inputs { height_scale: Some(0.5), ..of_heights(&map) }, Kind::Leadr, Precision::F32);
    // Multiplication by a power of two is exact.
    let halved: Vec<_> = one.moments().unwrap().levels[2].texels.iter().map(|m| m.scaled(0.5)).collect();
    assert_eq!(half.moments().unwrap().levels[2].texels, halved);
}

#[test]
fn planes_sines_and_checkers_have_their_closed_forms() {
    let last = |map: &BakedMap| map.levels.last().unwrap().layers.iter().map(|l| l[0]).collect::<Vec<_>>();
    // For a sine with one central-difference slope per texel, the slope is A k cos(k s) sinc(k / n).
    let (n, k, a) = (256.0, TAU * 4.0, 0.03);
    let sine = heights(256, 8, |s, _| a * (k * s).sin());
    let seen = a * n * (k / n).sin();
    for (kind, channel) in [(Kind::Lean, 2), (Kind::Clean, 2)] {
        let (map, _) = baked(&of_heights(&sine), kind, Precision::F32);
        let found = f64::from(last(&map)[0][channel]);
        assert!((found / (seen * seen / 2.0) - 1.0).abs() < 1e-4, "{kind:?}: {found}");
    }
    // The normals of a tilted plane have no variance. y points up, and t points down.
    let plane = normal_map([16, 8], GreenAxis::Up, |_, _| [-0.3, 0.4, 0.75f32.sqrt()]);
    let slope = [0.3 / 0.75f64.sqrt(), 0.4 / 0.75f64.sqrt()];
    let inputs = Inputs { normals: Some(plane), ..Inputs::default() };
    let (map, report) = baked(&inputs, Kind::Leadr, Precision::F32);
    let texel = last(&map)[0].map(f64::from);
    // Texels are square, so the map is half as long along t as along s.
    assert!((texel[0] - slope[0]).abs() < 1e-6 && (texel[1] - 0.5 * slope[1]).abs() < 1e-6, "{texel:?}");
    // Moments are summed in 32 bits, as in the renderer.
    assert!(report.slope_variance.iter().all(|v| v.abs() < 1e-7), "{:?}", report.slope_variance);
    let (map, _) = baked(&inputs, Kind::Lean, Precision::F32);
    let texel = last(&map)[0].map(f64::from);
    assert!((texel[0] + slope[0]).abs() < 1e-6 && (texel[1] - slope[1]).abs() < 1e-6, "{texel:?}");
    let (map, _) = baked(&inputs, Kind::Toksvig, Precision::F32);
    let [x, y, z, _] = last(&map)[0];
    assert!((x + 0.3).abs() < 1e-6 && (y - 0.4).abs() < 1e-6 && (x * x + y * y + z * z - 1.0).abs() < 1e-6);
    // On a checkerboard of two opposite normals, the length of the mean normal is the z of each normal.
    let tilt = 0.6f32;
    let checker = normal_map([8, 8], GreenAxis::Up, |x, y| [if (x + y) % 2 == 0 { tilt } else { -tilt }, 0.0, 0.8]);
    let inputs = Inputs { normals: Some(checker), ..Inputs::default() };
    let (map, _) = baked(&inputs, Kind::Toksvig, Precision::F32);
    let [x, _, z, _] = last(&map)[0];
    assert!(x.abs() < 1e-6 && (z - 0.8).abs() < 1e-6);
    let (map, report) = baked(&inputs, Kind::Clean, Precision::F32);
    assert!((f64::from(last(&map)[0][2]) - 0.5625).abs() < 1e-6 && (report.slope_variance[0] - 0.5625).abs() < 1e-6);
}

#[test]
fn every_kind_is_its_brute_force_sum() {
    let size = [13, 6];
    let normal = |x: u32, y: u32| {
        let n = [0.1 * ((x * 5 + y * 3) % 7) as f32 - 0.3, 0.08 * ((x + y * 4) % 5) as f32 - 0.1];
        [n[0], n[1], (1.0 - n[0] * n[0] - n[1] * n[1]).sqrt()]
    };
    for green in [GreenAxis::Up, GreenAxis::Down] {
        let inputs = Inputs { normals: Some(normal_map(size, green, normal)), ..Inputs::default() };
        let mut sums = [[0.0f64; 6]; 3];
        for i in 0..size[0] * size[1] {
            let [nx, ny, nz] = normal(i % size[0], i / size[0]).map(f64::from);
            let ny = if green == GreenAxis::Up { ny } else { -ny };
            let (bx, by) = (nx / nz, ny / nz);
            let texels = [
                [bx, by, bx * bx, by * by, bx * by, 0.0],
                [bx, by, bx * bx + by * by, 0.0, 0.0, 0.0],
                [nx, ny, nz, 0.0, 0.0, 0.0],
            ];
            let count = f64::from(size[0] * size[1]);
            sums.iter_mut().zip(texels).for_each(|(s, t)| s.iter_mut().zip(t).for_each(|(s, t)| *s += t / count));
        }
        for (kind, sum) in [Kind::Lean, Kind::Clean, Kind::Toksvig].into_iter().zip(sums) {
            let (map, _) = baked(&inputs, kind, Precision::F32);
            let last = map.levels.last().unwrap();
            let found: Vec<f32> = last.layers.iter().flat_map(|layer| layer[0]).collect();
            for (i, expected) in sum.into_iter().take(kind.channels().len()).enumerate() {
                assert!((f64::from(found[i]) - expected).abs() < 2e-6, "{kind:?} {i}: {} {expected}", found[i]);
            }
        }
    }
}

/// Every texel of every level has the larger principal variance, and no direction between texels has more than is read back.
#[test]
fn conservative_clean_is_never_too_small() {
    let ridges = heights(64, 64, |s, t| 0.02 * (TAU * (9.3 * s + 4.1 * t)).sin() + 0.01 * (TAU * 17.0 * s * t).cos());
    let inputs = of_heights(&ridges);
    let [lean, clean, conservative] =
        [Kind::Lean, Kind::Clean, Kind::CleanConservative].map(|kind| baked(&inputs, kind, Precision::F32).0);
    assert_eq!(conservative.kind, Kind::CleanConservative);
    let (mut below, mut checked) = (0, 0);
    for (level, of) in conservative.levels.iter().enumerate() {
        let n = of.width as usize;
        let moments = |i: usize| {
            let [a, b] = [&lean.levels[level].layers[0][i], &lean.levels[level].layers[1][i]];
            [a[0], a[1], a[2], a[3], b[0]].map(f64::from)
        };
        let packed = |map: &BakedMap, i: usize| map.levels[level].layers[0][i].map(f64::from);
        let largest = |m: [f64; 5]| {
            let [xx, yy, xy] = [m[2] - m[0] * m[0], m[3] - m[1] * m[1], m[4] - m[0] * m[1]];
            0.5 * (xx + yy) + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt()
        };
        for i in 0..n * n {
            let m = packed(&conservative, i);
            let square = m[0] * m[0] + m[1] * m[1];
            let error = (m[2] - square - largest(moments(i))).abs();
            assert!(error < 1e-5 * (1.0 + square), "level {level}, texel {i}: off by {error}");
            // Halfway to the neighbour along s.
            let j = i / n * n + (i + 1) % n;
            let mean = |a: [f64; 5], b: [f64; 5]| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
            let truth = largest(mean(moments(i), moments(j)));
            let read = |map: &BakedMap| {
                let [a, b] = [packed(map, i), packed(map, j)];
                let between: [f64; 3] = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
                between[2] - between[0] * between[0] - between[1] * between[1]
            };
            assert!(read(&conservative) > truth - 1e-5 * (1.0 + square), "level {level}, texel {i}");
            below += usize::from(0.5 * read(&clean) < truth - 1e-3 * truth);
            checked += 1;
        }
    }
    // The usual form has the mean of the principal variances, which is too small along ridges.
    assert!(below > checked / 2, "{below} of {checked}");
}

#[test]
fn roughness_is_averaged_as_a_variance_and_colour_as_light() {
    let codes = |f: &dyn Fn(u32) -> u8| Samples::U8((0..16).map(f).collect());
    let roughness = Raster::new(4, 4, 1, codes(&|i| if i % 2 == 0 { 51 } else { 204 })).unwrap();
    let color = Raster::new(4, 4, 1, codes(&|i| if i < 8 { 0 } else { 255 })).unwrap();
    let inputs = Inputs {
        roughness: Some(Roughness { raster: roughness, channel: 0, meaning: RoughnessMeaning::Alpha }),
        color: Some(color),
        ..of_heights(&bumpy(4, 4))
    };
    for kind in Kind::ALL.into_iter().filter(|kind| kind.stores_variance()) {
        let (map, _) = baked(&inputs, kind, Precision::F32);
        let texel: Vec<f32> = map.levels.last().unwrap().layers.iter().flat_map(|layer| layer[0]).collect();
        let value = |name: &str| texel[map.channels.iter().position(|c| c == name).unwrap()];
        assert!((value("alpha2") - 0.5 * (0.04 + 0.64)).abs() < 1e-5, "{kind:?}");
        assert!((value("alpha4") - 0.5 * (0.0016 + 0.4096)).abs() < 1e-5, "{kind:?}");
        assert_eq!([value("red"), value("blue")], [0.5, 0.5], "{kind:?}");
    }
}

#[test]
fn half_float_error_matches_its_bound() {
    let map = bumpy(96, 64);
    for kind in Kind::ALL.into_iter().filter(|kind| kind.stores_variance()) {
        let (exact, _) = baked(&of_heights(&map), kind, Precision::F32);
        let (half, report) = baked(&of_heights(&map), kind, Precision::F16);
        // The reader has added the 16-bit residual to the height.
        let (named, left) = half.channels.split_at(exact.channels.len());
        assert_eq!(named, exact.channels);
        assert!(left.iter().all(|name| name == "-"), "{left:?}");
        for (level, (a, b)) in exact.levels.iter().zip(&half.levels).enumerate() {
            let mut worst = 0.0f64;
            for channel in 0..kind.channels().len() {
                let values = |l: &leadr_maps::baked::BakedLevel| -> Vec<f64> {
                    l.layers[channel / 4].iter().map(|t| f64::from(t[channel % 4])).collect()
                };
                let (a, b) = (values(a), values(b));
                let difference: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
                let finest = values(&exact.levels[0]);
                let square: f64 = finest.iter().map(|a| a * a).sum();
                if difference > 0.0 {
                    let means = difference / a.len() as f64 / (square / finest.len() as f64);
                    worst = worst.max(means.sqrt());
                }
            }
            let reported = report.errors[level].channels;
            assert!((worst - reported).abs() <= 1e-3 * reported, "{kind:?} {level}: {worst} {reported}");
            // The limit is half a unit in the last place of eleven bits. There are no denormals.
            assert!(reported < 5e-4, "{kind:?} level {level}: {reported}");
        }
        assert!(report.errors[0].channels > 1e-5, "{kind:?}: 16 bits cannot be exact");
    }
    // The slopes are far above or far below the range of 16-bit floats.
    for scale in [1e6, 1e-6] {
        let inputs = Inputs { height_scale: Some(scale), ..of_heights(&map) };
        let (_, report) = baked(&inputs, Kind::Leadr, Precision::F16);
        assert!(report.errors[0].channels < 5e-4, "{scale}: {:?}", report.errors[0]);
    }
}

#[test]
fn heights_preserve_displacement() {
    // The heights are large and their relief is small, so 11 bits alone would give steps.
    let texels = (0..64 * 64).map(|i| 0.8 + 1e-3 * ((i % 64) as f32 * 0.3).sin() + 1e-5 * (i / 64) as f32).collect();
    let map = HeightMap::new(64, 64, texels).unwrap();
    let color = Raster::new(64, 64, 3, Samples::U8(vec![99; 64 * 64 * 3])).unwrap();
    for kind in Kind::ALL.into_iter().filter(|kind| kind.stores_variance()) {
        for color in [None, Some(color.clone())] {
            let inputs = Inputs { color, ..of_heights(&map) };
            for (precision, most) in [(Precision::F16, 2e-7), (Precision::Bc, 4e-7)] {
                let (stored, _) = baked(&inputs, kind, precision);
                for (a, b) in map.texels.iter().zip(&stored.height_map().unwrap().texels) {
                    assert!((a - b).abs() <= most, "{kind:?} {precision:?}: {a} {b}");
                }
            }
        }
    }
    // The residual uses a free slot, which other programs can see.
    let keys = |inputs: &Inputs| {
        let bytes = bytes_of(inputs, Kind::Leadr, Precision::F16).0;
        let reader = ktx2::Reader::new(&bytes[..]).unwrap();
        let (_, names) = reader.key_value_data().find(|(key, _)| *key == "leadr.channels").unwrap();
        String::from_utf8(names.strip_suffix(&[0]).unwrap().to_vec()).unwrap()
    };
    assert_eq!(keys(&of_heights(&map)), "x y xx yy xy height height.rest -");
    let colored = Inputs { color: Some(color), ..of_heights(&map) };
    assert_eq!(keys(&colored), "x y xx yy xy height - - red green blue height.rest");
}

#[test]
fn foreign_readers_accept_the_file() {
    let (bytes, report) = bytes_of(&of_heights(&bumpy(37, 23)), Kind::Leadr, Precision::F32);
    let reader = ktx2::Reader::new(&bytes[..]).unwrap();
    let header = reader.header();
    assert_eq!((header.pixel_width, header.pixel_height, header.layer_count, header.level_count), (37, 23, 2, 6));
    let description = reader.basic_dfd().unwrap();
    assert_eq!(description.color_model, Some(ktx2::ColorModel::RGBSDA));
    assert_eq!(description.sample_information.len(), 4);
    let keys: Vec<(String, String)> = reader
        .key_value_data()
        .map(|(key, value)| (key.to_owned(), String::from_utf8(value.strip_suffix(&[0]).unwrap().to_vec()).unwrap()))
        .collect();
    assert!(keys.is_sorted(), "{keys:?}");
    let value = |name: &str| &keys.iter().find(|(key, _)| key == name).unwrap().1;
    assert_eq!(value("leadr.channels"), "x y xx yy xy height - -");
    assert_eq!(value("KTXorientation"), "rd");
    let ranges: Vec<f64> = value("leadr.ranges").split_whitespace().map(|v| v.parse().unwrap()).collect();
    assert!((ranges[0] - report.channel_ranges[0][0]).abs() < 1e-5 * ranges[0].abs());
    let sizes: Vec<usize> = reader.levels().map(|level| level.data.len()).collect();
    assert_eq!(sizes, [37 * 23 * 32, 18 * 11 * 32, 9 * 5 * 32, 4 * 2 * 32, 2 * 32, 32]);
}

#[test]
fn damaged_files_are_faults_and_never_panics() {
    let (bytes, _) = bytes_of(&of_heights(&bumpy(9, 6)), Kind::Leadr, Precision::F16);
    assert!(BakedMap::decode(&bytes).is_ok());
    let whole = bytes.len();
    for length in (0..whole).step_by(7).chain([whole - 1]) {
        let error = BakedMap::decode(&bytes[..length]).map(|_| ()).unwrap_err().to_string();
        assert!(!error.contains('\n') && !error.contains("internal panic"), "{length}: {error}");
    }
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let mut random = move |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % n as u64) as usize
    };
    let mut refused = 0;
    for _ in 0..20_000 {
        let mut damaged = bytes.clone();
        for _ in 0..=random(3) {
            // Most bytes that can break a reader are at the front of the file.
            let span = if random(4) == 0 { whole } else { 700 };
            let at = random(span);
            damaged[at] ^= 1 << random(8);
        }
        if let Err(error) = BakedMap::decode(&damaged) {
            refused += 1;
            assert!(!error.to_string().contains("internal panic"), "{error}");
        }
    }
    assert!(refused > 5_000, "{refused}");
    let mut nan = bytes_of(&of_heights(&bumpy(9, 6)), Kind::Leadr, Precision::F32).0;
    let end = nan.len();
    nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = BakedMap::decode(&nan).unwrap_err().to_string();
    assert!(error.contains("holds NaN in channel A at x = 8, y = 5"), "{error}");
    let foreign = [&bytes[..12], &37u32.to_le_bytes(), &bytes[16..]].concat();
    let error = BakedMap::decode(&foreign).unwrap_err().to_string();
    assert!(error.contains("its texels are R8G8B8A8_UNORM; supported"), "{error}");
    let png = BakedMap::decode(b"\x89PNG\r\n\x1a\n").unwrap_err().to_string();
    assert!(png.contains("is not"), "{png}");
}

fn exr_levels(inputs: &Inputs, layout: Layout, precision: Precision) -> Vec<(String, Vec<Vec<f32>>)> {
    use exr::prelude::*;
    use std::io::Seek;
    let plan = Plan::new(inputs, Kind::Leadr, layout, precision).unwrap();
    let mut file = file();
    let mut target = ExrFile::new(&plan).unwrap();
    let report = bake(inputs, &plan, &mut target, &|_| ()).unwrap();
    target.finish(&mut file, &report).unwrap();
    file.rewind().unwrap();
    let reader = read().no_deep_data().all_resolution_levels().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(std::io::BufReader::new(file)).unwrap();
    let levels = |levels: &Levels<FlatSamples>| match levels {
        Levels::Mip { level_data, .. } => level_data.iter().map(|plane| plane.values_as_f32().collect()).collect(),
        other => panic!("no mip levels: {other:?}"),
    };
    let channels = image.layer_data.channel_data.list.iter();
    channels.map(|channel| (channel.name.to_string(), levels(&channel.sample_data))).collect()
}

#[test]
fn exr_holds_every_level() {
    let map = bumpy(130, 67);
    let expected = LeadrMap::new(&map, Wrap::Repeat);
    let channels = exr_levels(&of_heights(&map), Layout::Leadr, Precision::F32);
    let names: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["height", "x", "xx", "xy", "y", "yy"]);
    for (level, moments) in expected.levels.iter().enumerate() {
        let plane = |f: &dyn Fn(&leadr_maps::Moments) -> f32| moments.texels.iter().map(f).collect::<Vec<f32>>();
        assert_eq!(channels[0].1[level], plane(&|m| m.height));
        assert_eq!(channels[1].1[level], plane(&|m| m.mean_slope[0]));
        assert_eq!(channels[3].1[level], plane(&|m| m.cross));
        assert_eq!(channels[5].1[level], plane(&|m| m.second[1]));
    }
}

#[test]
fn few_channels_use_few_bytes() {
    let inputs = of_heights(&bumpy(64, 32));
    let texels = 2 * 64 * 32;
    // Kind height ignores all other inputs.
    let color = Raster::new(64, 32, 3, Samples::U8(vec![90; 64 * 32 * 3])).unwrap();
    let (with_color, _) = bytes_of(&Inputs { color: Some(color), ..inputs.clone() }, Kind::Height, Precision::F32);
    assert_eq!(with_color.len(), bytes_of(&inputs, Kind::Height, Precision::F32).0.len());
    for (kind, precision, format, bytes_of_texel) in [
        (Kind::Height, Precision::F32, ktx2::Format::R32_SFLOAT, 4),
        // The second channel is the 16-bit residual.
        (Kind::Height, Precision::F16, ktx2::Format::R16G16_SFLOAT, 4),
        (Kind::Clean, Precision::F32, ktx2::Format::R32G32B32A32_SFLOAT, 16),
    ] {
        let (bytes, _) = bytes_of(&inputs, kind, precision);
        let header = ktx2::Reader::new(&bytes).unwrap().header();
        assert_eq!((header.format, header.layer_count), (Some(format), 0));
        assert!(bytes.len() < bytes_of_texel * texels, "{kind:?} {precision:?}: {} bytes", bytes.len());
        let read = BakedMap::decode(&bytes).unwrap().channel("height").unwrap();
        let errs =
            read.iter().zip(&inputs.heights.as_ref().unwrap().texels).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(errs <= if precision == Precision::F32 { 0.0 } else { 1e-6 }, "{errs}");
    }
}

#[test]
fn exr_is_read_back_as_ktx2_is() {
    let color = Raster::new(13, 9, 3, Samples::U8((0..13 * 9 * 3).map(|i| (i * 7 % 256) as u8).collect())).unwrap();
    let inputs = Inputs { color: Some(color), height_scale: Some(0.37), ..of_heights(&bumpy(13, 9)) };
    for kind in Kind::ALL.into_iter().filter(|kind| kind.stores_variance()) {
        for precision in [Precision::F32, Precision::F16] {
            let plan = Plan::new(&inputs, kind, Layout::Leadr, precision).unwrap();
            let mut file = file();
            let mut target = ExrFile::new(&plan).unwrap();
            let report = bake(&inputs, &plan, &mut target, &|_| ()).unwrap();
            target.finish(&mut file, &report).unwrap();
            let read = BakedMap::decode(&content(file)).unwrap();
            assert_eq!(read, baked(&inputs, kind, precision).0, "{kind:?} {precision:?}");
            assert_eq!((read.heights, read.of_normals, read.height_scale), (HeightUnit::Width, false, 0.37));
        }
    }
}

pub fn content(mut file: File) -> Vec<u8> {
    use std::io::{Read, Seek};
    let mut bytes = Vec::new();
    file.rewind().unwrap();
    file.read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn damaged_exr_are_faults_and_never_panics() {
    let inputs = of_heights(&bumpy(70, 9));
    let plan = Plan::new(&inputs, Kind::Leadr, Layout::Leadr, Precision::F16).unwrap();
    let mut file = file();
    let mut target = ExrFile::new(&plan).unwrap();
    let report = bake(&inputs, &plan, &mut target, &|_| ()).unwrap();
    target.finish(&mut file, &report).unwrap();
    let bytes = content(file);
    assert!(BakedMap::decode(&bytes).is_ok());
    let mut refused = 0;
    for i in 0..3000 {
        let mut damaged = bytes.clone();
        let at = i * 7919 % bytes.len();
        damaged[at] ^= 1 << (i % 8);
        let length = if i % 3 == 0 { at } else { bytes.len() };
        if let Err(error) = BakedMap::decode(&damaged[..length]) {
            let error = error.to_string();
            refused += 1;
            assert!(!error.contains('\n'), "{error}");
        }
    }
    assert!(refused > 1000, "{refused}");
    // The picture is not a baked map.
    let plain = leadr_maps::save::encode_exr(2, 1, &[("height", &[0.0, 1.0])]).unwrap();
    let error = BakedMap::decode(&plain).unwrap_err().to_string();
    assert!(error.contains("leadr.kind is missing") && error.contains("leadr bake"), "{error}");
}

#[test]
fn block_compression_error_matches_its_bound() {
    let color = Raster::new(30, 21, 3, Samples::U8((0..30 * 21 * 3).map(|i| (i / 7 % 256) as u8).collect())).unwrap();
    for kind in Kind::ALL.into_iter().filter(|kind| kind.stores_variance()) {
        let inputs = Inputs { color: Some(color.clone()), ..of_heights(&bumpy(30, 21)) };
        let (exact, _) = baked(&inputs, kind, Precision::F32);
        let (bytes, report) = bytes_of(&inputs, kind, Precision::Bc);
        let blocks = BakedMap::decode(&bytes).unwrap();
        assert_eq!((&blocks.channels, blocks.precision), (&exact.channels, Precision::Bc));
        for (level, (a, b)) in exact.levels.iter().zip(&blocks.levels).enumerate() {
            let mut sums = [0.0f64; 2];
            let channels = kind.channels().len();
            let texel = |l: &leadr_maps::baked::BakedLevel, i: usize| -> Vec<f64> {
                (0..channels).map(|c| f64::from(l.layers[c / 4][i][c % 4])).collect()
            };
            for i in 0..a.layers[0].len() {
                sums[0] += (kind.variance(&texel(a, i)) - kind.variance(&texel(b, i))).powi(2);
                sums[1] += 1.0;
            }
            let last = exact.levels.last().unwrap();
            let found = (sums[0] / sums[1]).sqrt() / kind.variance(&texel(last, 0));
            let reported = report.errors[level].variance;
            assert!((found - reported).abs() <= 2e-3 * reported + 1e-9, "{kind:?} {level}: {found} {reported}");
            assert!(reported < 0.02, "{kind:?} {level}: {reported}");
        }
        // Heights and mean slopes have four layers, other quantities two. Channels form pairs, and the last colour channel
        // has its own layer.
        let reader = ktx2::Reader::new(&bytes[..]).unwrap();
        let header = reader.header();
        assert_eq!((header.format, header.type_size), (Some(ktx2::Format::BC5_SNORM_BLOCK), 1));
        let layers = 3 + match kind {
            Kind::Leadr | Kind::Lean => 9,
            Kind::Clean | Kind::CleanConservative => 7,
            _ => 5,
        };
        assert_eq!(header.layer_count as usize, layers);
        assert_eq!(reader.levels().next().unwrap().data.len(), layers * 8 * 6 * 16);
        assert_eq!(reader.basic_dfd().unwrap().color_model, Some(ktx2::ColorModel::BC5));
    }
    // A damaged file gives a fault or another map, but never a panic.
    let (bytes, _) = bytes_of(&of_heights(&bumpy(9, 6)), Kind::Leadr, Precision::Bc);
    let mut refused = 0;
    for i in 0..6000 {
        let mut damaged = bytes.clone();
        let at = i * 7919 % bytes.len().min(1500);
        damaged[at] ^= 1 << (i % 8);
        if let Err(error) = BakedMap::decode(&damaged[..if i % 5 == 0 { at } else { bytes.len() }]) {
            refused += 1;
            assert!(!error.to_string().contains("internal panic"), "{error}");
        }
    }
    assert!(refused > 1500, "{refused}");
}

/// Returns the file as EXR.
fn exr_of_plan(inputs: &Inputs, plan: &Plan) -> Vec<u8> {
    use std::io::{Read, Seek};
    let (mut file, mut bytes) = (file(), Vec::new());
    let mut target = ExrFile::new(plan).unwrap();
    let report = bake(inputs, plan, &mut target, &|_| ()).unwrap();
    target.finish(&mut file, &report).unwrap();
    file.rewind().unwrap();
    file.read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_file_without_levels_has_the_other_levels_of_the_whole_file() {
    let (w, h) = (75, 46);
    let raster = |channels: usize| {
        let codes = (0..w as usize * h as usize * channels).map(|i| (i * 37 % 251) as u8).collect();
        Raster::new(w, h, channels, Samples::U8(codes)).unwrap()
    };
    let roughness = Some(Roughness { raster: raster(1), channel: 0, meaning: RoughnessMeaning::Perceptual });
    let mut inputs = Inputs { roughness, color: Some(raster(3)), ..of_heights(&bumpy(w, h)) };
    inputs.classes = Some(inputs.find_classes(Some(2)));
    for (kind, precision) in [
        (Kind::Leadr, Precision::F32),
        (Kind::Leadr, Precision::F16),
        (Kind::Leadr, Precision::Bc),
        (Kind::Gloss, Precision::F32),
        (Kind::Toksvig, Precision::F16),
    ] {
        let plan = Plan::new(&inputs, kind, Layout::Leadr, precision).unwrap();
        let (bytes, report) = bytes_of_plan(&inputs, &plan);
        let whole = BakedMap::decode(&bytes).unwrap();
        for count in [0, 1, 3, 6] {
            let plan = plan.clone().without_levels(count).unwrap();
            let (fewer_bytes, fewer) = bytes_of_plan(&inputs, &plan);
            let read = BakedMap::decode(&fewer_bytes).unwrap();
            assert_eq!(read.levels, whole.levels[count..], "{kind:?} {precision:?} {count}");
            assert_eq!((read.dropped_levels, &fewer.levels[..]), (count as u32, &report.levels[count..]));
            assert_eq!((read.middle, &read.classes, &read.openness), (whole.middle, &whole.classes, &whole.openness));
            assert_eq!((fewer.slope_variance, fewer.height_range), (report.slope_variance, report.height_range));
            if precision != Precision::Bc {
                assert_eq!(BakedMap::decode(&exr_of_plan(&inputs, &plan)).unwrap().levels, whole.levels[count..]);
            }
            if count == 1 && precision != Precision::Bc {
                assert!(3 * fewer_bytes.len() < bytes.len(), "{kind:?} {precision:?}: {} bytes", fewer_bytes.len());
            }
        }
        let error = plan.without_levels(7).unwrap_err().to_string();
        assert!(error.contains("a map of 75 x 46 texels has no level 7") && error.contains("at most 6"), "{error}");
    }
}

#[test]
fn only_moments_that_repeat_are_drawn() {
    let drawable = |kind, wrap| {
        let inputs = Inputs { wrap, ..of_heights(&bumpy(8, 8)) };
        baked(&inputs, kind, Precision::F32).0.check_drawable().map_err(|fault| fault.to_string())
    };
    assert_eq!(drawable(Kind::Leadr, Wrap::Repeat), Ok(()));
    assert!(drawable(Kind::Lean, Wrap::Repeat).unwrap_err().contains("--kind leadr"));
    assert!(drawable(Kind::Leadr, Wrap::Clamp).unwrap_err().contains("--wrap repeat"));
}

#[test]
fn bump_slopes_are_per_texel_in_the_order_of_maketx() {
    let map = heights(32, 16, |s, t| 8.0 * s - 2.0 * t);
    let channels = exr_levels(&Inputs { wrap: Wrap::Clamp, ..of_heights(&map) }, Layout::Oiio, Precision::F32);
    let names: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["b0_h", "b1_dhds", "b2_dhdt", "b3_dhds2", "b4_dhdt2", "b5_dh2dsdt"]);
    // In the middle, the slopes are 8 over 32 texels and -2 over 16 texels.
    let middle = 8 * 32 + 16;
    let texel: Vec<f32> = channels.iter().map(|(_, levels)| levels[0][middle]).collect();
    for (found, expected) in texel[1..].iter().zip([0.25, -0.125, 0.0625, 0.015_625, -0.031_25]) {
        assert!((found - expected).abs() < 1e-5, "{texel:?}");
    }
    assert_eq!(texel[0], map.at(16, 8));
    // A normal map gives slopes as rise over run, but no heights.
    let normals = normal_map([4, 2], GreenAxis::Up, |_, _| [-0.6, 0.0, 0.8]);
    let inputs = Inputs { normals: Some(normals), ..Inputs::default() };
    let channels = exr_levels(&inputs, Layout::Oiio, Precision::F16);
    assert!((channels[1].1[0][0] - 0.75).abs() < 1e-3 && channels[0].1[0][0] == -1.0, "{channels:?}");
}

#[test]
fn incompatible_inputs_are_refused() {
    let raster = |w, h| Raster::new(w, h, 1, Samples::U8(vec![9; (w * h) as usize])).unwrap();
    let wrong = Inputs { color: Some(raster(3, 4)), ..of_heights(&bumpy(4, 4)) };
    let error = Plan::new(&wrong, Kind::Leadr, Layout::Leadr, Precision::F32).unwrap_err().to_string();
    assert!(error.contains("the colour map has 3 x 4 texels, and the height map 4 x 4"), "{error}");
    let none = Inputs { color: Some(raster(4, 4)), ..Inputs::default() };
    assert!(Plan::new(&none, Kind::Leadr, Layout::Leadr, Precision::F32).is_err());
    let colored = Inputs { color: Some(raster(4, 4)), ..of_heights(&bumpy(4, 4)) };
    assert!(Plan::new(&colored, Kind::Leadr, Layout::Oiio, Precision::F32).is_err());
    assert!(Plan::new(&of_heights(&bumpy(4, 4)), Kind::Lean, Layout::Oiio, Precision::F32).is_err());
    let per_texel = Plan::new(&of_heights(&bumpy(4, 4)), Kind::Leadr, Layout::Oiio, Precision::F32).unwrap();
    assert!(per_texel.clone().without_levels(0).is_ok() && per_texel.without_levels(1).is_err());
}

#[test]
fn smooth_roughness_survives_every_format() {
    let _unmeasured = unmeasured();
    // Perceptual roughness from 0.002 to 0.02, and none at all.
    for most in [0.02f32, 0.0] {
        let codes = (0..64 * 32).map(|i| most * (0.1 + 0.9 * (i % 97) as f32 / 96.0)).collect();
        let raster = Raster::new(64, 32, 1, Samples::F32(codes)).unwrap();
        let roughness = Some(Roughness { raster, channel: 0, meaning: RoughnessMeaning::Perceptual });
        let inputs = Inputs { roughness, ..of_heights(&bumpy(64, 32)) };
        let (exact, _) = baked(&inputs, Kind::Leadr, Precision::F32);
        for (precision, tolerance) in [(Precision::F16, 1e-3), (Precision::Bc, 1e-2)] {
            let (read, report) = baked(&inputs, Kind::Leadr, precision);
            for name in ["alpha2", "alpha4"] {
                let [a, b] = [&exact, &read].map(|map| map.channel(name).unwrap());
                let greatest = a.iter().fold(0.0f32, |most, v| most.max(*v));
                let worst = a.iter().zip(&b).fold(0.0f32, |most, (a, b)| most.max((a - b).abs()));
                assert!(worst <= tolerance * greatest, "{precision:?} {name}: {worst} of {greatest}");
            }
            let worst = report.errors.iter().fold(0.0f64, |most, error| most.max(error.channels));
            assert!(precision == Precision::Bc || worst < 1e-3, "{precision:?}: {worst}");
        }
    }
}

#[test]
fn heights_fit_scanned_normals_at_the_known_scale() {
    let Some(folder) = shared_data("displacement") else { return };
    for (name, scale, correlation) in [("MetalWalkway006", 4.4, 0.945), ("SheetMetal001", 16.7, 0.99)] {
        let found = MaterialFolder::open(folder.join(name), OutsideLinks::Refused).unwrap();
        let material = found.load().unwrap();
        let inputs = Inputs {
            heights: Some(load_height_map(found.picture(Role::Height).unwrap()).unwrap()),
            normals: material.normal_map,
            ..Inputs::default()
        };
        let agreement = inputs.agreement().unwrap();
        println!("{name}: {agreement}");
        assert!((agreement.scale_texels / scale - 1.0).abs() < 0.1, "{name}: {agreement:?}");
        assert!((agreement.correlation - correlation).abs() < 0.015, "{name}: {agreement:?}");
        // With green flipped, the correlation is low.
        let mut flipped = inputs.clone();
        flipped.normals.as_mut().unwrap().green = GreenAxis::Down;
        assert!(flipped.agreement().unwrap().correlation < 0.5, "{:?}", flipped.agreement());
        assert!((inputs.agreement().unwrap().left_over - (1.0 - agreement.correlation.powi(2))).abs() < 1e-12);
    }
}
