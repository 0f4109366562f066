//! Tests of pictures as other programs write them: EXR layers, windows, primaries and views, Radiance headers, alpha, and files
//! that are no pictures.

use std::fs;
use std::io::Cursor;
use std::path::PathBuf;

use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use leadr_maps::save::encode_png_srgb8;
use leadr_maps::{
    ImageHeader, Rgb8Image, decode_environment, decode_height_map, decode_picture, load_color_raster, load_environment,
    load_environment_layer, load_height_map, load_picture, load_picture_layer, load_raster,
};
use leadr_testing::memory::unmeasured;
use leadr_testing::shared::shared_data;

const WIDTH: usize = 32;
const HEIGHT: usize = 16;

/// A part of a file: its attributes, its size, and its channels, each with one value.
type Part<'a> = (LayerAttributes, [usize; 2], &'a [(&'a str, f32)]);

/// Encodes parts of even channels.
fn encode(attributes: ImageAttributes, parts: Vec<Part<'_>>) -> Vec<u8> {
    let layers: Vec<_> = parts
        .into_iter()
        .map(|(own, [width, height], channels)| {
            let plane = |value: f32| FlatSamples::F32(vec![value; width * height]);
            let list = channels.iter().map(|&(name, value)| AnyChannel::new(name, plane(value))).collect();
            Layer::new((width, height), own, Encoding::FAST_LOSSLESS, AnyChannels::sort(list))
        })
        .collect();
    let mut cursor = Cursor::new(Vec::new());
    Image::from_layers(attributes, layers).write().to_buffered(&mut cursor).unwrap();
    cursor.into_inner()
}

fn whole() -> ImageAttributes {
    ImageAttributes::new(IntegerBounds::from_dimensions((WIDTH, HEIGHT)))
}

fn one_part(channels: &[(&str, f32)]) -> Vec<u8> {
    encode(whole(), vec![(LayerAttributes::default(), [WIDTH, HEIGHT], channels)])
}

fn saved(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("picture.exr");
    fs::write(&file, bytes).unwrap();
    (folder, file)
}

fn report(name: &str) -> Option<PathBuf> {
    Some(shared_data("reports")?.join(name))
}

#[test]
fn the_layer_of_the_finished_picture_is_read() {
    let _unmeasured = unmeasured();
    let cases: [(&[(&str, f32)], f32); 12] = [
        (&[("R", 1.0), ("G", 1.0), ("B", 1.0), ("AO.R", 2.0), ("AO.G", 2.0), ("AO.B", 2.0)], 1.0),
        (
            &[
                ("View.AO.R", 2.0),
                ("View.AO.G", 2.0),
                ("View.AO.B", 2.0),
                ("View.Combined.R", 1.0),
                ("View.Combined.G", 1.0),
                ("View.Combined.B", 1.0),
            ],
            1.0,
        ),
        (
            &[
                ("albedo.R", 2.0),
                ("albedo.G", 2.0),
                ("albedo.B", 2.0),
                ("Beauty.r", 1.0),
                ("Beauty.g", 1.0),
                ("Beauty.b", 1.0),
            ],
            1.0,
        ),
        (&[("A.R", 2.0), ("A.G", 2.0), ("A.B", 2.0), ("rgba.R", 1.0), ("rgba.G", 1.0), ("rgba.B", 1.0)], 1.0),
        (&[("r", 1.0), ("g", 1.0), ("b", 1.0)], 1.0),
        (&[("Red", 1.0), ("Green", 1.0), ("Blue", 1.0)], 1.0),
        (&[("Y", 1.0), ("A", 0.5)], 1.0),
        (&[("y", 1.0)], 1.0),
        (&[(".R", 1.0), (".G", 1.0), (".B", 1.0)], 1.0),
        // A position and a normal are no colours.
        (&[("P.X", 2.0), ("P.Y", 2.0), ("P.Z", 2.0), ("diffuse.R", 1.0), ("diffuse.G", 1.0), ("diffuse.B", 1.0)], 1.0),
        (&[("Z", 7.0), ("Y", 1.0)], 1.0),
        (&[("Y", 2.0), ("Main.Combined.R", 1.0), ("Main.Combined.G", 1.0), ("Main.Combined.B", 1.0)], 1.0),
    ];
    for (channels, expected) in cases {
        let bytes = one_part(channels);
        assert_eq!(decode_environment(&bytes).unwrap().texels[5], [expected; 3], "{channels:?}");
        assert_eq!(decode_picture(&bytes).unwrap().image.texels[5], [expected; 3], "{channels:?}");
        let (_folder, file) = saved(&bytes);
        assert_eq!(
            load_color_raster(&file).unwrap().value(5, 5, 1),
            expected / channels.iter().find(|(c, _)| *c == "A").map_or(1.0, |a| a.1)
        );
    }
    let ambiguous = one_part(&[("a.R", 1.0), ("a.G", 1.0), ("a.B", 1.0), ("b.R", 2.0), ("b.G", 2.0), ("b.B", 2.0)]);
    for fault in [decode_environment(&ambiguous).unwrap_err(), decode_picture(&ambiguous).unwrap_err()] {
        let text = fault.to_string();
        assert!(text.contains("several layers with colour: `a`, `b`") && text.contains("--layer NAME"), "{text}");
    }
    let chroma = one_part(&[("BY", 0.0), ("RY", 0.0), ("Y", 1.0)]);
    assert!(decode_picture(&chroma).unwrap_err().to_string().contains("luminance and chroma"));
    let numbers = saved(&one_part(&[("roughness", 0.25)]));
    assert_eq!(load_raster(&numbers.1).unwrap().value(1, 1, 0), 0.25);
    assert!(load_environment(&numbers.1).unwrap_err().to_string().contains("only: roughness"));
}

#[test]
fn layers_are_chosen_by_name() {
    let _unmeasured = unmeasured();
    let color = |name: &str, value: f32| ["R", "G", "B"].map(|c| (format!("{name}{c}"), value));
    let own = [color("View.Combined.", 1.0), color("View.AO.", 2.0), color("Other.AO.", 3.0)].concat();
    let mut channels: Vec<(&str, f32)> = own.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    channels.extend([
        ("View.Depth.Z", 9.0),
        ("View.Normal.X", 4.0),
        ("View.Normal.Y", 5.0),
        ("View.Normal.Z", 6.0),
        ("View.UV.U", 1.0),
        ("View.UV.V", 1.0),
    ]);
    let (_folder, file) = saved(&one_part(&channels));
    for (name, expected) in [
        ("View.AO", [2.0; 3]),
        ("view.ao", [2.0; 3]),
        ("combined", [1.0; 3]),
        ("Other.AO", [3.0; 3]),
        ("Depth", [9.0; 3]),
        ("Normal", [4.0, 5.0, 6.0]),
    ] {
        assert_eq!(load_picture_layer(&file, Some(name)).unwrap().image.texels[3], expected, "{name}");
        assert_eq!(load_environment_layer(&file, Some(name)).unwrap().texels[3], expected, "{name}");
    }
    for (name, words) in
        [("AO", "several layers `AO`"), ("beauty", "no layer `beauty`; its layers are"), ("UV", "2 channels")]
    {
        let text = load_picture_layer(&file, Some(name)).unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
    }
    let png = encode_png_srgb8(&Rgb8Image::new(1, 1, vec![[1, 2, 3]]).unwrap()).unwrap();
    fs::write(&file, png).unwrap();
    assert!(load_picture_layer(&file, Some("AO")).unwrap_err().to_string().contains("only EXR files have layers"));
}

#[test]
fn parts_are_layers_and_views() {
    let _unmeasured = unmeasured();
    let rgb = |value: f32| [("R", value), ("G", value), ("B", value)];
    let [left, right, other] = [rgb(1.0), rgb(2.0), rgb(3.0)];
    let named = |name: &str, view: Option<&str>| LayerAttributes {
        view_name: view.map(Text::from),
        ..LayerAttributes::named(name)
    };
    let size = [WIDTH, HEIGHT];
    let beauty = encode(
        whole(),
        vec![
            (named("albedo", None), size, &other),
            (named("ViewLayer.Combined", None), size, &left),
            (named("depth", None), size, &[("Z", 1.0)]),
        ],
    );
    assert_eq!(decode_picture(&beauty).unwrap().image.texels[0], [1.0; 3]);
    let stereo = |order: [usize; 2]| {
        let parts = [
            (named("rgba.left", Some("left")), size, &left[..]),
            (named("rgba.right", Some("right")), size, &right[..]),
        ];
        decode_picture(&encode(whole(), order.map(|i| parts[i].clone()).to_vec())).unwrap()
    };
    let (a, b) = (stereo([0, 1]), stereo([1, 0]));
    assert_eq!((a.frame.view.as_deref(), a.image.texels[0]), (Some("left"), [1.0; 3]));
    assert_eq!((b.frame.view.as_deref(), b.image.texels[0]), (Some("right"), [2.0; 3]));
    assert!(b.check_same_frame(&a).unwrap_err().to_string().contains("view is right"));
    // In a single part, the names of further views are prefixes.
    let views =
        LayerAttributes { multi_view_names: Some(vec!["left".into(), "right".into()]), ..LayerAttributes::default() };
    let single = [&left[..], &[("right.R", 2.0), ("right.G", 2.0), ("right.B", 2.0)]].concat();
    let (_folder, file) = saved(&encode(whole(), vec![(views, size, &single)]));
    let picture = load_picture(&file).unwrap();
    assert_eq!((picture.frame.view.as_deref(), picture.image.texels[0]), (Some("left"), [1.0; 3]));
    let picture = load_picture_layer(&file, Some("right")).unwrap();
    assert_eq!((picture.frame.view.as_deref(), picture.image.texels[0]), (Some("right"), [2.0; 3]));
}

#[test]
fn pictures_fill_their_display_window() {
    let _unmeasured = unmeasured();
    let rgb = [("R", 1.0), ("G", 1.0), ("B", 1.0), ("A", 1.0)];
    let windowed = |[x, y]: [i32; 2], size: [usize; 2], display: [i32; 2], channels: &[(&str, f32)]| {
        let own = LayerAttributes { layer_position: Vec2(x, y), ..LayerAttributes::default() };
        let bounds = IntegerBounds::new((display[0], display[1]), (WIDTH, HEIGHT));
        encode(ImageAttributes::new(bounds), vec![(own, size, channels)])
    };
    for ([x, y], [width, height], display) in [
        ([4, 3], [5, 6], [0, 0]),
        ([-2, -3], [5, 6], [0, 0]),
        ([104, -1], [300, 4], [100, 0]),
        ([-50, -60], [200, 200], [0, 0]),
        ([40, 0], [4, 4], [0, 0]),
    ] {
        let bytes = windowed([x, y], [width, height], display, &rgb);
        let picture = decode_picture(&bytes).unwrap();
        assert_eq!((picture.image.width, picture.image.height), (WIDTH as u32, HEIGHT as u32));
        assert_eq!(picture.frame.origin, display);
        for (i, texel) in picture.image.texels.iter().enumerate() {
            let at = [(i % WIDTH) as i32 + display[0] - x, (i / WIDTH) as i32 + display[1] - y];
            let inside = (0..width as i32).contains(&at[0]) && (0..height as i32).contains(&at[1]);
            assert_eq!(texel[0], f32::from(u8::from(inside)), "{at:?}");
            assert_eq!(picture.alpha.as_ref().map_or(1.0, |alpha| alpha[i]), f32::from(u8::from(inside)));
        }
        assert_eq!(decode_environment(&bytes).unwrap(), picture.image);
        let header = ImageHeader::read(&bytes, bytes.len() as u64).unwrap();
        assert!(header.texels() >= picture.image.texels.len() as u64);
    }
    let heights =
        |[x, y]: [i32; 2], size: [usize; 2]| decode_height_map(&windowed([x, y], size, [0, 0], &[("Y", 3.0)]));
    let filled = heights([0, 0], [WIDTH, 9]).unwrap();
    assert_eq!((filled.height, filled.texels.iter().all(|&h| h == 3.0)), (HEIGHT as u32, true));
    let text = heights([0, 0], [WIDTH, 7]).unwrap_err().to_string();
    assert!(text.contains("56.2 % of its heights are missing (its data window"), "{text}");
    // A display window may be far larger than the file.
    let mut huge = windowed([0, 0], [2, 2], [0, 0], &rgb);
    let name = b"displayWindow\0box2i\0";
    let at = huge.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    huge[at + 8..at + 16].copy_from_slice(&[60_000i32.to_le_bytes(), 4000i32.to_le_bytes()].concat());
    assert!(decode_picture(&huge).unwrap_err().to_string().contains("too large"));
}

#[test]
fn primaries_become_rec709() {
    let _unmeasured = unmeasured();
    let gamut = |corners: [[f32; 2]; 4]| {
        let [red, green, blue, white] = corners.map(|[x, y]| Vec2(x, y));
        Chromaticities { red, green, blue, white }
    };
    let acescg = gamut([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.321_68, 0.337_67]]);
    let with = |chromaticities: Option<Chromaticities>, color: [f32; 3]| {
        let channels = [("R", color[0]), ("G", color[1]), ("B", color[2])];
        let attributes = ImageAttributes { chromaticities, ..whole() };
        encode(attributes, vec![(LayerAttributes::default(), [WIDTH, HEIGHT], &channels)])
    };
    let near = |found: [f32; 3], expected: [f32; 3]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-3);
    // Rec.709 red in ACEScg, by the matrix of the ACES project.
    let bytes = with(Some(acescg), [0.613_1, 0.070_2, 0.020_6]);
    assert!(near(decode_picture(&bytes).unwrap().image.texels[0], [1.0, 0.0, 0.0]));
    let (_folder, file) = saved(&bytes);
    let value = |raster: leadr_maps::material::Raster| raster.value(0, 0, 0);
    assert!((value(load_color_raster(&file).unwrap()) - 1.0).abs() < 2e-3);
    assert_eq!(value(load_raster(&file).unwrap()), 0.613_1, "numbers are not converted");
    assert_eq!(decode_height_map(&with(Some(acescg), [0.25, 0.25, 0.25])).unwrap().texels[0], 0.25);
    let (rec709, nothing) = (gamut([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]), gamut([[0.0; 2]; 4]));
    for same in [None, Some(rec709), Some(nothing)] {
        assert_eq!(decode_picture(&with(same, [0.1, 0.2, 0.3])).unwrap().image.texels[0], [0.1, 0.2, 0.3]);
    }
    // Other programs name the colour space.
    for (name, value) in
        [("oiio:ColorSpace", "ACEScg"), ("colorInteropID", "lin_ap1_scene"), ("oiio:ColorSpace", "lin_rec709")]
    {
        let mut own = LayerAttributes::default();
        own.other.insert(name.into(), AttributeValue::Text(value.into()));
        let channels = [("R", 0.613_1), ("G", 0.070_2), ("B", 0.020_6)];
        let found = decode_picture(&encode(whole(), vec![(own, [WIDTH, HEIGHT], &channels)])).unwrap().image.texels[0];
        assert_eq!(near(found, [1.0, 0.0, 0.0]), value != "lin_rec709", "{value}: {found:?}");
    }
    // The same picture in two gamuts.
    let (Some(a), Some(b)) = (report("cmp_rec709.exr"), report("env_acescg_chromaticities.exr")) else { return };
    let (a, b) = (load_picture(a).unwrap().image, load_picture(b).unwrap().image);
    let off = a.texels.iter().flatten().zip(b.texels.iter().flatten()).map(|(a, b)| (a - b).abs() / (1.0 + a));
    assert!(off.clone().fold(0.0, f32::max) < 2e-3, "{}", off.fold(0.0, f32::max));
}

#[test]
fn headers_of_other_programs_are_read() {
    let _unmeasured = unmeasured();
    let Some(plain) = report("env_flat.hdr") else { return };
    let plain = load_environment(plain).unwrap();
    for name in ["autopano", "exposure0", "flat_starts_like_rle", "format_spaces", "no_format", "photoshop", "plus_y"] {
        let image = load_environment(report(&format!("env_{name}.hdr")).unwrap()).unwrap();
        assert_eq!((image.width, image.height), (plain.width, plain.height), "{name}");
        let mean = image.mean();
        assert!(mean.iter().all(|&v| v > 0.01 && v < 100.0), "{name}: {mean:?}");
    }
    for name in ["env_lowercase.exr", "env_grey_alpha.exr", "env_vray_dot.exr"] {
        assert!(load_environment(report(name).unwrap()).is_ok(), "{name}");
    }
    for (name, size) in [("env_cube_cross.hdr", (128, 64)), ("env_probe_square.hdr", (192, 96))] {
        let image = load_environment(report(name).unwrap()).unwrap();
        assert_eq!((image.width, image.height), size, "{name}");
    }
    let blender = load_environment(report("env_blender_multilayer.exr").unwrap()).unwrap();
    assert!(blender.texels.iter().any(|texel| texel[0] != texel[2]), "the grey occlusion was read");
    let top = load_environment(report("env_data_window_top_half.exr").unwrap()).unwrap();
    assert_eq!((top.width, top.height, top.at(3, 40)), (128, 64, [0.0; 3]));
}

/// A flat picture whose first texel is the start of a run-length line, and one whose texels look like repeats.
#[test]
fn flat_texels_that_look_like_runs_are_read() {
    let _unmeasured = unmeasured();
    let header = b"#?OWN\nEXPOSURE=-1\nFORMAT = 32-bit_rle_rgbe \n\n-Y 2 +X 16\n";
    for texel in [[2, 2, 0, 130], [2, 2, 0, 16], [1, 1, 1, 130], [1, 1, 1, 0]] {
        let mut bytes = header.to_vec();
        (0..32).for_each(|i| bytes.extend(if i % 3 == 0 { texel } else { [200, 100, 50, 136] }));
        let image = decode_environment(&bytes).unwrap();
        let scale = if texel[3] == 0 { 0.0 } else { f32::from(texel[3] as i16 - 136).exp2() };
        assert_eq!(image.texels[3], [0, 1, 2].map(|c| f32::from(texel[c]) * scale), "{texel:?}");
        assert_eq!(image.texels[4], [200.0, 100.0, 50.0]);
        bytes.pop();
        assert!(decode_environment(&bytes).is_err(), "{texel:?}");
    }
}

#[test]
fn holes_of_elevation_models_are_filled() {
    let _unmeasured = unmeasured();
    for name in ["height_dem_nodata.exr", "height_dem_nan.exr"] {
        let (Some(file), Some(whole)) = (report(name), report("height_dem_metres.exr")) else { return };
        let (map, whole) = (load_height_map(file).unwrap(), load_height_map(whole).unwrap());
        let range = |texels: &[f32]| texels.iter().fold([f32::MAX, f32::MIN], |[a, b], &h| [a.min(h), b.max(h)]);
        let ([low, high], [least, most]) = (range(&map.texels), range(&whole.texels));
        assert!(low >= least && high <= most, "{name}: {low} to {high}");
    }
    let declared = |value: AttributeValue| {
        let mut own = LayerAttributes::default();
        own.other.insert("GDAL_NODATA".into(), value);
        let plane = FlatSamples::F32((0..16).map(|i| if i == 5 { -1.0 } else { 2.0 }).collect());
        let channels = AnyChannels::sort([AnyChannel::new("Y", plane)].into_iter().collect());
        let layer = Layer::new((4, 4), own, Encoding::FAST_LOSSLESS, channels);
        let mut cursor = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut cursor).unwrap();
        decode_height_map(&cursor.into_inner()).unwrap().texels
    };
    assert_eq!(declared(AttributeValue::Text("-1 ".into())), [2.0; 16]);
    assert_eq!(declared(AttributeValue::F32(-1.0)), [2.0; 16]);
    assert_eq!(declared(AttributeValue::F32(7.0))[5], -1.0);
}

#[test]
fn alpha_of_pictures_is_read() {
    let _unmeasured = unmeasured();
    let grey = decode_picture(&one_part(&[("Y", 0.25), ("A", 0.5)])).unwrap();
    assert_eq!((grey.alpha.as_deref().map(|alpha| alpha[0]), grey.over(1.0).texels[0]), (Some(0.5), [0.75; 3]));
    let opaque = decode_picture(&one_part(&[("R", 0.5), ("G", 0.5), ("B", 0.5), ("A", 1.0)])).unwrap();
    assert_eq!((opaque.alpha, opaque.frame.color_space), (None, "linear".into()));
    let mut png = Cursor::new(Vec::new());
    let texel = image::LumaA([255u8, 51]);
    image::DynamicImage::from(image::ImageBuffer::from_pixel(3, 2, texel))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let picture = decode_picture(&png.into_inner()).unwrap();
    assert!((picture.over(0.0).texels[0][0] - 0.2).abs() < 1e-6 && picture.is_transparent());
    // A mask may be stored in the alpha of an EXR.
    let (_folder, file) = saved(&one_part(&[("R", 0.5), ("G", 0.5), ("B", 0.5), ("A", 0.25)]));
    assert_eq!((load_raster(&file).unwrap().value(0, 0, 3), load_raster(&file).unwrap().value(0, 0, 0)), (0.25, 0.5));
    assert_eq!(load_color_raster(&file).unwrap().value(0, 0, 0), 2.0);
}

/// The same codes with 8 and 16 bits are one picture.
#[test]
fn bits_of_a_png_do_not_matter() {
    let _unmeasured = unmeasured();
    let codes: Vec<u8> = (0..=255).collect();
    let encode = |image: image::DynamicImage| {
        let mut png = Cursor::new(Vec::new());
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        decode_picture(&png.into_inner()).unwrap()
    };
    let wide = codes.iter().map(|&code| u16::from(code) * 257).collect();
    let narrow = encode(image::GrayImage::from_raw(16, 16, codes).unwrap().into());
    let wide = encode(image::ImageBuffer::<image::Luma<u16>, _>::from_raw(16, 16, wide).unwrap().into());
    let off = narrow.image.texels.iter().zip(&wide.image.texels).map(|(a, b)| (a[0] - b[0]).abs());
    assert!(off.fold(0.0, f32::max) < 1e-6);
}

#[test]
fn pointers_of_git_lfs_are_named() {
    let _unmeasured = unmeasured();
    let (_folder, file) = saved(b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n");
    let faults = [
        load_environment(&file).unwrap_err(),
        load_height_map(&file).unwrap_err(),
        load_raster(&file).unwrap_err(),
        load_picture(&file).unwrap_err(),
    ];
    for text in faults.map(|fault| fault.to_string()) {
        assert!(
            text.contains("pointer of Git LFS") && text.ends_with("run `git lfs pull` in its repository"),
            "{text}"
        );
    }
    assert!(ImageHeader::of_file(&file).unwrap_err().to_string().contains("git lfs pull"));
}

#[test]
fn animations_are_no_pictures() {
    let _unmeasured = unmeasured();
    let png = encode_png_srgb8(&Rgb8Image::new(1, 1, vec![[1, 2, 3]]).unwrap()).unwrap();
    let data = b"acTL\0\0\0\x03\0\0\0\0";
    let mut checksum = u32::MAX;
    for byte in data {
        checksum ^= u32::from(*byte);
        (0..8).for_each(|_| checksum = if checksum & 1 == 1 { checksum >> 1 ^ 0xedb8_8320 } else { checksum >> 1 });
    }
    let chunk = [&[0, 0, 0, 8], &data[..], &(!checksum).to_be_bytes()].concat();
    let animated = [&png[..33], &chunk, &png[33..]].concat();
    let text = decode_picture(&animated).unwrap_err().to_string();
    assert!(text.contains("an animation of 3 frames"), "{text}");
    assert!(decode_picture(&png).is_ok());
}
