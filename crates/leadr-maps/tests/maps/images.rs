//! Tests that load and save maps: real files, round trips, orientation and atomic writes.

use std::fs;
use std::path::PathBuf;

use leadr_maps::save::{encode_exr, encode_png_grey16, encode_png_srgb8};
use leadr_maps::tonemap::Tonemap;
use leadr_maps::{
    HeightMap, LeadrMap, MapFault, Rgb8Image, RgbImage, Wrap, decode_color, decode_color_srgb8, decode_environment,
    decode_height_map, decode_picture, load_color_srgb8, load_environment, load_height_map, save,
};
use leadr_reflectance::color::luminance;
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

fn files(folder: PathBuf, end: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(path, end));
        } else if path.to_string_lossy().ends_with(end) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn gradient(width: u32, height: u32) -> HeightMap {
    let texels = (0..width * height).map(|i| i as f32 / (width * height) as f32).collect();
    HeightMap::new(width, height, texels).unwrap()
}

#[test]
fn real_height_maps_load() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("displacement") else { return };
    let maps = files(folder, "Displacement.png");
    assert!(!maps.is_empty());
    for path in maps {
        let map = load_height_map(&path).unwrap();
        let mean = map.texels.iter().map(|&h| f64::from(h)).sum::<f64>() / map.texels.len() as f64;
        let (low, high) = map.texels.iter().fold((f32::MAX, f32::MIN), |(a, b), &h| (a.min(h), b.max(h)));
        let m = LeadrMap::new(&map, Wrap::Repeat).mean();
        let [xx, yy, xy] = m.slope_covariance();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        println!(
            "{name}: {}x{} mean {mean:.4} range {low:.4}..{high:.4} slope sigma per height scale {:.2} {:.2}, cov {xy:.2}",
            map.width,
            map.height,
            xx.sqrt(),
            yy.sqrt()
        );
        assert_eq!((map.width, map.height), (1024, 1024));
        assert!(low >= 0.0 && high <= 1.0 && high - low > 0.05 && xx > 0.0 && yy > 0.0);
        // The mean slope of a map that tiles is 0.
        assert!(m.mean_slope.iter().all(|s| s.abs() < 1e-3), "{m:?}");
        // The loader keeps all 16 bits.
        let levels: std::collections::HashSet<u32> = map.texels.iter().map(|h| h.to_bits()).collect();
        assert!(levels.len() > 256, "{} distinct heights", levels.len());
    }
}

#[test]
fn real_colors_load() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("displacement") else { return };
    for path in files(folder, "Color.png") {
        let image = load_color_srgb8(&path).unwrap();
        let mean = image.to_linear().mean();
        println!("{}: linear mean {mean:.3?}", path.file_name().unwrap().to_string_lossy());
        assert!(mean.iter().all(|&m| m > 0.005 && m < 0.9));
    }
}

#[test]
fn real_environments_load() {
    let _unmeasured = unmeasured();
    let Some(folder) = shared_data("env") else { return };
    for path in files(folder, ".hdr") {
        let image = load_environment(&path).unwrap();
        let max = image.texels.iter().map(|&t| luminance(t.map(f64::from).into())).fold(0.0, f64::max);
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        println!("{name}: {}x{} mean {:.4?} max luminance {max:.1}", image.width, image.height, image.mean());
        assert_eq!((image.width, image.height), (1024, 512));
        // The maxima are from the notes beside the files.
        let noted = match name.as_str() {
            "night_pmndrs_1k.hdr" => 73.0,
            "spiaggia_di_mondello_1k.hdr" => 7.1e4,
            "spruit_sunrise_1k.hdr" => 1.6e5,
            "studio_pmndrs_1k.hdr" => 3352.0,
            _ => continue,
        };
        assert!((max / noted - 1.0).abs() < 0.03, "{name}: {max} against {noted}");
    }
}

#[test]
fn heights_round_trip() {
    let _unmeasured = unmeasured();
    let map = gradient(13, 7);
    let png = encode_png_grey16(&map, 0.0, 1.0).unwrap();
    let back = decode_height_map(&png).unwrap();
    assert_eq!((back.width, back.height), (13, 7));
    assert!(map.texels.iter().zip(&back.texels).all(|(a, b)| (a - b).abs() <= 0.5 / 65535.0 + 1e-7));

    let signed = HeightMap::new(13, 7, map.texels.iter().map(|h| 1000.0 * (h - 0.5)).collect()).unwrap();
    let exr = encode_exr(13, 7, &[("Z", &signed.texels)]).unwrap();
    assert_eq!(decode_height_map(&exr).unwrap(), signed);
}

#[test]
fn exr_height_channel_follows_the_rule() {
    let _unmeasured = unmeasured();
    let (a, b, c) = ([1.0f32], [2.0f32], [3.0f32]);
    let pick = |channels: &[(&str, &[f32])]| decode_height_map(&encode_exr(1, 1, channels).unwrap());
    assert_eq!(pick(&[("anything", &a)]).unwrap().texels, [1.0]);
    assert_eq!(pick(&[("B", &a), ("G", &b), ("R", &c)]).unwrap().texels, [3.0]);
    assert_eq!(pick(&[("R", &a), ("Height", &b), ("Y", &c)]).unwrap().texels, [2.0]);
    assert_eq!(pick(&[("A", &a), ("bake.Z", &b)]).unwrap().texels, [2.0]);
    let message = pick(&[("A", &a), ("Q", &b)]).unwrap_err().to_string();
    assert!(message.contains("A, Q") && message.contains("height"), "{message}");
}

#[test]
fn environments_round_trip_through_exr_with_layers() {
    let _unmeasured = unmeasured();
    let texels: Vec<[f32; 3]> = (0..40 * 20).map(|i| [i as f32 * 0.01, 1e4 / (1 + i) as f32, 0.0]).collect();
    let image = RgbImage::new(40, 20, texels).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("env.exr");
    save::save_exr_rgb(&path, &image).unwrap();
    assert_eq!(load_environment(&path).unwrap(), image);

    let plane = |c: usize| image.texels.iter().map(|t| t[c]).collect::<Vec<f32>>();
    let (r, g, b, depth) = (plane(0), plane(1), plane(2), vec![f32::INFINITY; 800]);
    let layers: [(&str, &[f32]); 4] = [("depth", &depth), ("color.R", &r), ("color.G", &g), ("color.B", &b)];
    let bytes = encode_exr(40, 20, &layers).unwrap();
    // The infinite depth is in another layer and must not affect the colour.
    assert_eq!(decode_environment(&bytes).unwrap(), image);
    assert_eq!(bytes, encode_exr(40, 20, &layers).unwrap(), "bytes differ between two runs");
    assert!(encode_exr(40, 20, &[("R", &r), ("R", &g)]).unwrap_err().to_string().contains("twice"));
    assert!(encode_exr(40, 21, &[("R", &r)]).unwrap_err().to_string().contains("800 values"));
    assert!(encode_exr(40, 20, &[]).is_err());
}

#[test]
fn colors_round_trip() {
    let _unmeasured = unmeasured();
    let texels: Vec<[u8; 3]> = (0..=255u8).map(|v| [v, 255 - v, v / 2]).collect();
    let image = Rgb8Image::new(16, 16, texels).unwrap();
    let bytes = encode_png_srgb8(&image).unwrap();
    assert_eq!(decode_color_srgb8(&bytes).unwrap(), image);
    assert_eq!(decode_color(&bytes).unwrap(), image.to_linear());
    assert_eq!(bytes, encode_png_srgb8(&image).unwrap());
    let linear = image.to_linear();
    assert_eq!(leadr_maps::tonemap::display_image(&linear, 1.0, Tonemap::Clamp), image);
}

/// A 16-bit colour PNG must keep more than 8 bits in linear values.
#[test]
fn wide_color_keeps_its_precision() {
    let _unmeasured = unmeasured();
    let map = HeightMap::new(2, 1, vec![0.5, 0.5 + 3.0 / 65535.0]).unwrap();
    let image = decode_color(&encode_png_grey16(&map, 0.0, 1.0).unwrap()).unwrap();
    assert!(image.texels[0][0] < image.texels[1][0] && image.texels[0][0] == image.texels[0][2]);
}

fn hdr(header: &str, body: &[u8]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\n{header}").into_bytes();
    bytes.extend_from_slice(body);
    bytes
}

/// Returns one RGBE texel whose red is `v`.
fn red(v: u8) -> [u8; 4] {
    [v, 9, 9, 136]
}

#[test]
fn hdr_axes_become_upright() {
    let _unmeasured = unmeasured();
    // The cases encode one 3 x 2 picture, with reds 11 12 13 / 21 22 23, in all eight scan orders.
    let cases: [(&str, [u8; 6]); 8] = [
        ("-Y 2 +X 3", [11, 12, 13, 21, 22, 23]),
        ("-Y 2 -X 3", [13, 12, 11, 23, 22, 21]),
        ("+Y 2 +X 3", [21, 22, 23, 11, 12, 13]),
        ("+Y 2 -X 3", [23, 22, 21, 13, 12, 11]),
        ("+X 3 -Y 2", [11, 21, 12, 22, 13, 23]),
        ("-X 3 -Y 2", [13, 23, 12, 22, 11, 21]),
        ("+X 3 +Y 2", [21, 11, 22, 12, 23, 13]),
        ("-X 3 +Y 2", [23, 13, 22, 12, 21, 11]),
    ];
    for (resolution, reds) in cases {
        let body: Vec<u8> = reds.iter().flat_map(|&v| red(v)).collect();
        let image = decode_environment(&hdr(&format!("\n{resolution}\n"), &body)).unwrap();
        assert_eq!((image.width, image.height), (3, 2));
        let seen: Vec<f32> = image.texels.iter().map(|t| t[0]).collect();
        assert_eq!(seen, [11.0, 12.0, 13.0, 21.0, 22.0, 23.0], "{resolution}");
    }
}

#[test]
fn hdr_exposure_runs_and_formats() {
    let _unmeasured = unmeasured();
    // With exponent 136 the value is the mantissa. Texels are divided by the product of all EXPOSURE values.
    let image = decode_environment(&hdr("EXPOSURE=2\nEXPOSURE=4.0\n\n-Y 1 +X 1\n", &red(16))).unwrap();
    assert_eq!(image.texels, [[2.0, 9.0 / 8.0, 9.0 / 8.0]]);
    // Two old runs follow: one texel with 3 repeats, and one with 300 = 44 + 1 * 256 repeats.
    let mut body = red(5).to_vec();
    body.extend([1, 1, 1, 44, 1, 1, 1, 1]);
    let image = decode_environment(&hdr("\n-Y 1 +X 301\n", &body)).unwrap();
    assert!(image.texels.iter().all(|t| *t == [5.0, 9.0, 9.0]) && image.width == 301);
    // The new run-length line mixes runs and literals.
    let mut body = vec![2, 2, 0, 9];
    body.extend([128 + 4, 7, 5, 1, 2, 3, 4, 5]);
    body.extend([128 + 9, 3, 128 + 9, 4, 128 + 9, 136]);
    let image = decode_environment(&hdr("FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 9\n", &body)).unwrap();
    let seen: Vec<f32> = image.texels.iter().map(|t| t[0]).collect();
    assert_eq!(seen, [7.0, 7.0, 7.0, 7.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    // XYZE white (D65) is Rec.709 white.
    let body = [243, 255, 255, 136];
    let image = decode_environment(&hdr("FORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", &body)).unwrap();
    assert!((image.texels[0][1] / 255.0 - 1.0).abs() < 0.03, "{:?}", image.texels[0]);
    let other = decode_environment(&hdr("FORMAT=16-bit\n\n-Y 1 +X 1\n", &body));
    assert!(matches!(other, Err(MapFault::Unsupported { .. })));
}

#[test]
fn bad_texels_report_their_coordinates() {
    let _unmeasured = unmeasured();
    let mut plane = vec![1.0f32; 12];
    plane[7] = 1e13;
    let message = decode_height_map(&encode_exr(4, 3, &[("Y", &plane)]).unwrap()).unwrap_err().to_string();
    assert!(message.contains("10000000000000") && message.contains("x = 3, y = 1"), "{message}");
    let fine = [1.0f32; 12];
    for bad in [f32::NAN, f32::INFINITY, -0.5, 1e30] {
        plane[7] = bad;
        let exr = encode_exr(4, 3, &[("R", &fine), ("G", &fine), ("B", &plane)]).unwrap();
        let message = decode_environment(&exr).unwrap_err().to_string();
        assert!(message.contains("channel B at x = 3, y = 1"), "{message}");
    }
    // A lossy codec causes small negative values, which become black.
    plane[7] = -0.001;
    let exr = encode_exr(4, 3, &[("R", &fine), ("G", &fine), ("B", &plane)]).unwrap();
    assert_eq!(decode_environment(&exr).unwrap().at(3, 1), [1.0, 1.0, 0.0]);
}

/// Small negative values from a resampling filter around a sun are accepted. An image with a negative half is refused.
#[test]
fn slightly_negative_light_reads_as_zero() {
    let _unmeasured = unmeasured();
    let fine = [1.0f32; 64];
    let with = |bad: &[f32]| {
        let mut plane = fine;
        plane[..bad.len()].copy_from_slice(bad);
        decode_environment(&encode_exr(8, 8, &[("R", &fine), ("G", &fine), ("B", &plane)]).unwrap())
    };
    assert_eq!(with(&[-0.5, -0.7]).unwrap().texels[..3], [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0; 3]]);
    assert!(with(&[-1.0; 2]).unwrap_err().to_string().contains("channel B at x = 0, y = 0"));
    assert!(with(&[f32::NEG_INFINITY]).is_err());
}

#[test]
fn non_height_maps_are_refused() {
    let _unmeasured = unmeasured();
    let text = |bytes: &[u8]| decode_height_map(bytes).unwrap_err().to_string();
    let photoshop = text(b"8BPS\0\x01");
    let is_named = photoshop.contains("a Photoshop document") && photoshop.contains("magick FILE -depth 16 FILE.png");
    assert!(is_named, "{photoshop}");
    assert!(decode_environment(b"RIFF\0\0\0\0WEBPVP8 ").unwrap_err().to_string().contains("magick FILE FILE.exr"));
    // Bumps are stored as normals, in codes and in floats.
    let normals: Vec<[u8; 3]> = (0..64 * 64)
        .map(|i| {
            let (x, y) = (0.5 * (i as f32 * 0.7).sin(), 0.4 * (i as f32 * 0.3).cos());
            [x, y, (1.0 - x * x - y * y).sqrt()].map(|v| (255.0 * (0.5 * v + 0.5)).round() as u8)
        })
        .collect();
    let floats = [0, 1, 2].map(|c| normals.iter().map(|n| f32::from(n[c]) / 255.0).collect::<Vec<_>>());
    let exr = encode_exr(64, 64, &[("R", &floats[0]), ("G", &floats[1]), ("B", &floats[2])]).unwrap();
    let png = encode_png_srgb8(&Rgb8Image::new(64, 64, normals).unwrap()).unwrap();
    for bytes in [&png, &exr] {
        assert!(text(bytes).contains("normal map") && text(bytes).contains("--normal-map"), "{}", text(bytes));
    }
    // Coloured images that are not normal maps use the first channel as height.
    let bricks = Rgb8Image::new(2, 1, vec![[51, 20, 10], [102, 30, 20]]).unwrap();
    assert_eq!(decode_height_map(&encode_png_srgb8(&bricks).unwrap()).unwrap().texels, [0.2, 0.4]);
    let plane = [0.5f32; 4];
    let chroma = encode_exr(2, 2, &[("BY", &plane), ("RY", &plane), ("Y", &plane)]).unwrap();
    for text in [text(&chroma), decode_environment(&chroma).unwrap_err().to_string()] {
        assert!(text.contains("luminance and chroma") && text.contains("save it as plain RGB"), "{text}");
    }
}

#[test]
fn pictures_as_people_have_them_load() {
    let Some(folder) = shared_data("reports") else { return };
    let _unmeasured = unmeasured();
    let read = |name: &str| {
        let bytes = fs::read(folder.join(name)).unwrap();
        leadr_maps::decode_raster_with_remarks(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    for (name, remarks) in [
        ("no_eoi.jpg", 1),
        ("exif6.jpg", 1),
        ("cmyk.jpg", 0),
        ("progressive.jpg", 0),
        ("trailing.jpg", 0),
        ("normal16_gl.png", 0),
        ("textures/sky.webp", 0),
        ("poliigon/Ground/Ground_Displacement.tiff", 0),
    ] {
        let (raster, said) = read(name);
        assert_eq!(said.len(), remarks, "{name}: {raster:?} {said:?}");
    }
    let tiff = load_height_map(folder.join("texturescom/Wall/TexturesCom_Wall_1K_height.tif")).unwrap();
    assert!(tiff.texels.iter().any(|&h| h != tiff.texels[0]));
}

#[test]
fn pictures_of_every_format_load() {
    let _unmeasured = unmeasured();
    let image = Rgb8Image::new(2, 1, vec![[255, 0, 10], [1, 2, 3]]).unwrap();
    let picture = decode_picture(&encode_png_srgb8(&image).unwrap()).unwrap();
    assert!(picture.display_referred && picture.image == image.to_linear());
    // A picture may contain NaN. Only comparisons refuse NaN.
    let plane = [f32::NAN, -2.0];
    let exr = encode_exr(2, 1, &[("R", &plane), ("G", &plane), ("B", &plane)]).unwrap();
    let picture = decode_picture(&exr).unwrap();
    assert!(!picture.display_referred && picture.image.texels[0][0].is_nan() && picture.image.texels[1] == [-2.0; 3]);
    assert!(!decode_picture(&hdr("\n-Y 1 +X 1\n", &red(16))).unwrap().display_referred);
    assert!(matches!(decode_picture(b"nothing"), Err(MapFault::Unrecognised { .. })));
}

#[test]
fn saving_is_all_or_nothing() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    let image = RgbImage::new(2, 2, vec![[0.5; 3]; 4]).unwrap();
    save::save_png(&path, &image, 1.0, Tonemap::Filmic).unwrap();
    let old = fs::read(&path).unwrap();
    save::save_png(&path, &image, 2.0, Tonemap::Filmic).unwrap();
    assert_ne!(old, fs::read(&path).unwrap());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);

    // Renaming a file onto a folder fails. The error names the file, and the temporary file is removed.
    let blocked = folder.path().join("blocked.png");
    fs::create_dir_all(blocked.join("inside")).unwrap();
    let message = save::save_png(&blocked, &image, 1.0, Tonemap::Filmic).unwrap_err().to_string();
    assert!(message.contains("blocked.png"), "{message}");
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(names.iter().all(|n| !n.to_string_lossy().ends_with(".part")), "{names:?}");
    // A file in the place of a folder is an error; missing folders are made.
    assert!(save::save_exr_rgb(path.join("image.exr"), &image).is_err());
    save::save_exr_rgb(folder.path().join("new/folder/image.exr"), &image).unwrap();
}

/// The reader uses the largest level of tiled files, and the part with colour of multi-part files.
#[test]
fn exr_levels_and_parts_are_sorted_out() {
    let _unmeasured = unmeasured();
    use exr::prelude::*;
    let plane = |w: usize, h: usize, start: f32| FlatSamples::F32((0..w * h).map(|i| start + i as f32).collect());
    let encoding = Encoding {
        compression: Compression::ZIP1,
        blocks: Blocks::Tiles(Vec2(4, 4)),
        line_order: LineOrder::Increasing,
    };
    let channel = AnyChannel {
        name: "Y".into(),
        sample_data: Levels::Mip {
            rounding_mode: exr::math::RoundingMode::Down,
            level_data: vec![plane(10, 6, 0.0), plane(5, 3, 500.0), plane(2, 1, 700.0), plane(1, 1, 900.0)],
        },
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    };
    let layer =
        Layer::new((10, 6), LayerAttributes::default(), encoding, AnyChannels::sort([channel].into_iter().collect()));
    let mut cursor = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut cursor).unwrap();
    let map = decode_height_map(&cursor.into_inner()).unwrap();
    assert_eq!((map.width, map.height), (10, 6));
    assert!(map.texels.iter().enumerate().all(|(i, &h)| h == i as f32), "{:?}", map.texels);

    let part = |name: &str, channels: &[&str], start: f32| {
        let list = channels.iter().map(|&c| AnyChannel::new(c, plane(3, 2, start))).collect();
        Layer::new((3, 2), LayerAttributes::named(name), Encoding::FAST_LOSSLESS, AnyChannels::sort(list))
    };
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((3, 2)));
    let parts: Vec<_> = vec![part("mask", &["A", "Q"], 5.0), part("beauty", &["B", "G", "R"], 10.0)];
    let mut cursor = std::io::Cursor::new(Vec::new());
    Image::from_layers(attributes, parts).write().to_buffered(&mut cursor).unwrap();
    let image = decode_environment(&cursor.into_inner()).unwrap();
    assert_eq!(image.texels[0], [10.0; 3]);
    assert_eq!(image.texels[5], [15.0; 3]);
}
