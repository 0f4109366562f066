//! Tests of untrusted images. Every damaged file gives a result or a one-line error in bounded time and memory.
//!
//! The test program counts allocations. A test that measures allocations runs alone, even if all tests share one process.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::MaterialFolder;
use leadr_maps::save::{encode_exr, encode_png_grey16, encode_png_srgb8};
use leadr_maps::{
    HeightMap, MapFault, Rgb8Image, decode_color, decode_environment, decode_height_map, decode_raster, load_color,
    load_environment, load_height_map,
};
use leadr_testing::memory::{Counting, alone, measured};
use leadr_testing::shared::shared_data;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[derive(Default)]
struct Tally {
    accepted: usize,
    refused: usize,
    peak: usize,
    slowest: Duration,
    messages: Vec<String>,
}

/// The memory limit for damaged files. The sizes in the files' headers are far larger, up to 2^62 bytes.
const MEMORY_LIMIT: usize = 160 << 20;
const TIME_LIMIT: Duration = Duration::from_secs(10);

impl Tally {
    fn run<T>(&mut self, path: &Path, load: impl FnOnce(&Path) -> Result<T, leadr_maps::MapError>) {
        let (result, peak, time) = measured(|| load(path).map(drop));
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(peak < MEMORY_LIMIT, "{name} took {peak} bytes");
        assert!(time < TIME_LIMIT, "{name} took {time:?}");
        self.peak = self.peak.max(peak);
        self.slowest = self.slowest.max(time);
        match result {
            Ok(()) => self.accepted += 1,
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains(&name), "the file is not named: {message}");
                assert!(!message.contains('\n') && message.len() < 700, "not one line: {message}");
                self.refused += 1;
                self.messages.push(message);
            }
        }
    }

    fn print(&self, what: &str) {
        let Self { accepted, refused, peak, slowest, .. } = self;
        println!("{what}: {accepted} accepted, {refused} refused, peak {peak} bytes, slowest {slowest:?}");
    }
}

/// Returns the third-party files of `data/bad-input/<folder>`.
fn bad_files(folder: &str) -> Option<Vec<PathBuf>> {
    let folder = shared_data(&format!("bad-input/{folder}"))?;
    let mut found: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    found.sort();
    Some(found)
}

#[test]
fn corrupt_pngs_are_refused() {
    let _alone = alone();
    let Some(files) = bad_files("png-corrupt") else { return };
    let (mut heights, mut colors) = (Tally::default(), Tally::default());
    for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "png")) {
        heights.run(path, |p| load_height_map(p));
        colors.run(path, |p| load_color(p));
    }
    heights.print("png-corrupt as heights");
    colors.print("png-corrupt as colours");
    heights.messages.iter().for_each(|m| println!("  {}", m.rsplit('/').next().unwrap()));
    assert!(heights.refused > 0, "no file was read");
    assert_eq!((heights.accepted, colors.accepted), (0, 0));
}

#[test]
fn damaged_exrs_are_answered() {
    let _alone = alone();
    let Some(files) = bad_files("exr-damaged") else { return };
    let (mut heights, mut environments) = (Tally::default(), Tally::default());
    for path in files {
        heights.run(&path, |p| load_height_map(p));
        environments.run(&path, |p| load_environment(p));
    }
    heights.print("exr-damaged as heights");
    environments.print("exr-damaged as environments");
    let panics = heights.messages.iter().chain(&environments.messages).filter(|m| m.contains("internal panic"));
    println!("of these, {} were caught panics of the decoder", panics.count());
    environments.messages.iter().take(20).for_each(|m| println!("  {}", m.rsplit('/').next().unwrap()));
}

#[test]
fn handmade_hdrs_match_their_notes() {
    let _alone = alone();
    let Some(files) = bad_files("handmade") else { return };
    let mut tally = Tally::default();
    for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "hdr")) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let accepted = tally.accepted;
        tally.run(path, |p| load_environment(p));
        // The notes call two of the files valid. A header with CRLF line ends is unambiguous, so it is accepted too.
        let legal = ["hdr_flipped_axes_valid", "hdr_xyze_valid", "hdr_crlf_header"].contains(&name.as_str());
        assert_eq!(tally.accepted > accepted, legal, "{name}");
        if name == "hdr_flipped_axes_valid" {
            let image = load_environment(path).unwrap();
            assert_eq!((image.width, image.height), (2, 3));
        }
    }
    tally.print("handmade hdr");
    tally.messages.iter().for_each(|m| println!("  {}", m.rsplit('/').next().unwrap()));
}

/// A loader for a valid file of one kind.
type Decode = fn(&[u8]) -> Result<(), MapFault>;

fn valid_files() -> Vec<(&'static str, Vec<u8>, Decode)> {
    let heights: Vec<f32> = (0..64 * 48).map(|i| ((i * 7919) % 1000) as f32 / 1000.0).collect();
    let map = HeightMap::new(64, 48, heights.clone()).unwrap();
    let codes = (0..64 * 48u32).map(|i| [(i % 251) as u8, (i / 7) as u8, (i % 13) as u8]).collect();
    let image = Rgb8Image::new(64, 48, codes).unwrap();
    let channels: [(&str, &[f32]); 3] = [("R", &heights), ("G", &heights), ("B", &heights)];
    let mut flat = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 6 +X 5\n".to_vec();
    (0..30u8).for_each(|i| flat.extend([i + 2, 100, 50, 128]));
    let mut runs = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 6 +X 40\n".to_vec();
    for i in 0..6u8 {
        runs.extend([2, 2, 0, 40]);
        (0..4).for_each(|c| runs.extend([128 + 38, 120 + i + c, 2, 120, 130]));
    }
    let colors = image::RgbImage::from_fn(64, 48, |x, y| image::Rgb([x as u8 * 3, (x * y) as u8, y as u8]));
    let as_kind = |kind| {
        let mut file = std::io::Cursor::new(Vec::new());
        colors.write_to(&mut file, kind).unwrap();
        file.into_inner()
    };
    let mut tiff = std::io::Cursor::new(Vec::new());
    let mut encoder =
        tiff::encoder::TiffEncoder::new(&mut tiff).unwrap().with_compression(tiff::encoder::Compression::Lzw);
    encoder.write_image::<tiff::encoder::colortype::Gray32Float>(64, 48, &heights).unwrap();
    let texels: Vec<u8> = (0..64 * 48 / 16 * 16).map(|i| (i * 31 % 253) as u8).collect();
    let words = [145u32, 1, 64, 48, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0].map(u32::to_le_bytes).concat();
    let index = [104, texels.len() as u64, texels.len() as u64].map(u64::to_le_bytes).concat();
    let ktx2 = [&b"\xabKTX 20\xbb\r\n\x1a\n"[..], &words, &index, &texels].concat();
    let mut words = [0u32; 31];
    (words[0], words[2], words[3], words[18], words[19]) = (124, 48, 64, 32, 4);
    words[20] = u32::from_le_bytes(*b"DXT5");
    let dds = [&b"DDS "[..], &words.map(u32::to_le_bytes).concat(), &texels].concat();
    let raster: Decode = |b| decode_raster(b).map(drop);
    vec![
        ("tiff floats", tiff.into_inner(), |b| decode_height_map(b).map(drop)),
        ("webp", as_kind(image::ImageFormat::WebP), raster),
        ("tga", as_kind(image::ImageFormat::Tga), raster),
        ("bmp", as_kind(image::ImageFormat::Bmp), raster),
        ("ppm", as_kind(image::ImageFormat::Pnm), raster),
        ("ktx2", ktx2, raster),
        ("dds", dds, raster),
        ("png heights", encode_png_grey16(&map, 0.0, 1.0).unwrap(), |b| decode_height_map(b).map(drop)),
        ("png colours", encode_png_srgb8(&image).unwrap(), |b| decode_color(b).map(drop)),
        ("exr heights", encode_exr(64, 48, &[("Y", &heights)]).unwrap(), |b| decode_height_map(b).map(drop)),
        ("exr colours", encode_exr(64, 48, &channels).unwrap(), |b| decode_environment(b).map(drop)),
        ("hdr flat", flat, |b| decode_environment(b).map(drop)),
        ("hdr runs", runs, |b| decode_environment(b).map(drop)),
        ("jpeg grey", jpeg(image::ExtendedColorType::L8), |b| decode_raster(b).map(drop)),
        ("jpeg colours", jpeg(image::ExtendedColorType::Rgb8), |b| decode_raster(b).map(drop)),
    ]
}

fn jpeg(kind: image::ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let texels: Vec<u8> = (0..64 * 48 * u32::from(kind.bits_per_pixel()) / 8).map(|i| (i * 7 % 251) as u8).collect();
    image::codecs::jpeg::JpegEncoder::new(&mut bytes).encode(&texels, 64, 48, kind).unwrap();
    bytes
}

#[test]
fn truncated_files_are_refused() {
    let _alone = alone();
    for (name, bytes, decode) in valid_files().into_iter().chain(exr_variants()) {
        decode(&bytes).unwrap_or_else(|fault| panic!("the whole {name} must load: {fault}"));
        for sixteenth in 0..16 {
            let short = &bytes[..bytes.len() * sixteenth / 16];
            let (result, peak, _) = measured(|| decode(short));
            assert!(result.is_err(), "{name} cut to {sixteenth}/16 was accepted");
            assert!(peak < 4 << 20, "{name} cut to {sixteenth}/16 took {peak} bytes");
        }
    }
}

/// Encodes one picture as half floats in other compressions of the `exr` crate, with tiles and mip levels.
fn exr_variants() -> Vec<(&'static str, Vec<u8>, Decode)> {
    use exr::prelude::*;
    let decode: Decode = |b| decode_environment(b).map(drop);
    let tiles = Blocks::Tiles(Vec2(16, 32));
    let cases = [
        ("exr none", Compression::Uncompressed, Blocks::ScanLines),
        ("exr rle", Compression::RLE, Blocks::ScanLines),
        ("exr zip1", Compression::ZIP1, tiles),
        ("exr piz", Compression::PIZ, Blocks::ScanLines),
        ("exr piz tiles", Compression::PIZ, tiles),
        ("exr pxr24", Compression::PXR24, Blocks::ScanLines),
        ("exr b44a", Compression::B44A, Blocks::ScanLines),
        ("exr dwaa", Compression::DWAA(None), Blocks::ScanLines),
    ];
    let variants = cases.map(|(name, compression, blocks)| {
        let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
            let v = f16::from_f32(((x * 13 + y * 7) % 31) as f32 * 0.1);
            (v, f16::from_f32(1.0), v)
        });
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let layer = Layer::new((64, 48), LayerAttributes::default(), encoding, channels);
        let mut cursor = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut cursor).unwrap();
        (name, cursor.into_inner(), decode)
    });
    variants.into()
}

/// A DWA block declares section sizes, which the decoder allocates at once.
#[test]
fn sizes_claimed_by_dwa_blocks_are_not_believed() {
    let _alone = alone();
    let (_, bytes, decode) = exr_variants().into_iter().find(|(name, ..)| *name == "exr dwaa").unwrap();
    // The two-block offset table is followed by the row, the length, the version and the sizes.
    let version = bytes.windows(8).position(|eight| eight == 2u64.to_le_bytes()).unwrap();
    decode(&bytes).unwrap();
    for counter in 1..10 {
        for claim in [1u64 << 40, u64::MAX >> 1] {
            let mut altered = bytes.clone();
            altered[version + 8 * counter..][..8].copy_from_slice(&claim.to_le_bytes());
            let (result, peak, _) = measured(|| decode(&altered));
            let message = result.unwrap_err().to_string();
            assert!(message.contains("for one of its sections"), "{counter}: {message}");
            assert!(peak < 4 << 20, "{peak} bytes");
        }
    }
}

/// Valid files with altered bytes are accepted or refused, but never cause a crash.
#[test]
fn altered_files_never_panic() {
    let _alone = alone();
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    for (name, bytes, decode) in valid_files().into_iter().chain(exr_variants()) {
        let (mut accepted, mut refused, mut caught, mut most) = (0, 0, 0, 0);
        for round in 0..400 {
            let mut altered = bytes.clone();
            // Half of the changes affect the header, which contains the sizes.
            let reach = if round % 2 == 0 { altered.len().min(400) } else { altered.len() };
            for _ in 0..1 + round % 4 {
                let at = random() as usize % reach;
                altered[at] = random() as u8;
            }
            let (result, peak, time) = measured(|| decode(&altered));
            assert!(peak < MEMORY_LIMIT && time < TIME_LIMIT, "{name} round {round}: {peak} bytes, {time:?}");
            most = most.max(peak);
            match result {
                Ok(()) => accepted += 1,
                Err(fault) => {
                    refused += 1;
                    caught += usize::from(fault.to_string().contains("internal panic"));
                }
            }
        }
        println!("{name}: {accepted} accepted, {refused} refused ({caught} caught panics), peak {most} bytes");
        assert!(refused > 0);
    }
}

fn png_with_size(width: u32, height: u32) -> Vec<u8> {
    png_of_kind(width, height, 0)
}

/// Returns a grey PNG whose header declares a size and a kind of colours: 0 is grey, 2 is RGB.
fn png_of_kind(width: u32, height: u32, kind: u8) -> Vec<u8> {
    let map = HeightMap::new(1, 1, vec![0.5]).unwrap();
    let mut bytes = encode_png_grey16(&map, 0.0, 1.0).unwrap();
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    bytes[25] = kind;
    let mut crc = 0xffff_ffffu32;
    for &byte in &bytes[12..29] {
        crc ^= u32::from(byte);
        (0..8).for_each(|_| crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 });
    }
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}

/// Returns a 1 x 1 EXR whose data window declares a different size.
fn exr_with_size(width: i32, height: i32) -> Vec<u8> {
    let mut bytes = encode_exr(1, 1, &[("Y", &[0.5])]).unwrap();
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    bytes[at + 8..at + 12].copy_from_slice(&(width - 1).to_le_bytes());
    bytes[at + 12..at + 16].copy_from_slice(&(height - 1).to_le_bytes());
    bytes
}

fn hdr_with_size(width: u64, height: u64) -> Vec<u8> {
    format!("#?RADIANCE\n\n-Y {height} +X {width}\n\u{8}\u{8}\u{8}\u{8}").into_bytes()
}

/// Each of these pictures is within the limits of one image, but all of them need 12 GiB.
#[test]
fn a_material_is_counted_before_it_is_decoded() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    // The length of the file makes its size plausible.
    let png = [png_of_kind(16384, 16384, 2), vec![0; 1500 << 10]].concat();
    for role in ["Color", "Roughness", "Metalness", "NormalGL", "Displacement", "AO", "Cones", "Opacity", "Emission"] {
        fs::write(folder.path().join(format!("x_{role}.png")), &png).unwrap();
    }
    let material = MaterialFolder::open(folder.path(), OutsideLinks::Refused).unwrap();
    let (result, peak, _) = measured(|| material.load().map(drop));
    let message = result.unwrap_err().to_string();
    assert!(message.contains("with the images before it, it needs more than 4 GiB"), "{message}");
    assert!(peak < 1 << 20, "{peak} bytes");
}

#[test]
fn sizes_claimed_by_headers_are_not_believed() {
    let _alone = alone();
    assert_eq!(decode_height_map(&png_with_size(1, 1)).unwrap().texels.len(), 1);
    assert_eq!(decode_height_map(&exr_with_size(1, 1)).unwrap().texels, [0.5]);
    assert_eq!(decode_environment(&hdr_with_size(1, 1)).unwrap().texels.len(), 1);

    let sizes =
        [(0, 0), (0, 5), (60_000, 60_000), (20_000, 20_000), (1, 2_000_000_000), (2_000_000_000, 1), (9000, 9000)];
    for (width, height) in sizes {
        let png = png_with_size(width, height);
        let exr = exr_with_size(width as i32, height as i32);
        let hdr = hdr_with_size(width.into(), height.into());
        let mut jpeg = jpeg(image::ExtendedColorType::L8);
        let start = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        // JPEG supports sizes up to 65535.
        jpeg[start + 5..start + 7].copy_from_slice(&(height.min(65535) as u16).to_be_bytes());
        jpeg[start + 7..start + 9].copy_from_slice(&(width.min(65535) as u16).to_be_bytes());
        let results = [
            ("jpeg", measured(|| decode_raster(&jpeg).map(drop))),
            ("png", measured(|| decode_height_map(&png).map(drop))),
            ("exr", measured(|| decode_height_map(&exr).map(drop))),
            ("hdr", measured(|| decode_environment(&hdr).map(drop))),
        ];
        for (kind, (result, peak, time)) in results {
            if kind == "jpeg" && width.min(height) == 1 {
                // A small file may declare a row or column of 65535 texels.
                assert!(peak < 16 << 20, "{peak} bytes");
                continue;
            }
            let fault = result.expect_err(kind);
            println!("{kind} {width}x{height}: {fault} ({peak} bytes, {time:?})");
            assert!(peak < 1 << 20, "{kind} {width}x{height} took {peak} bytes");
            if kind == "hdr" {
                let zero = width == 0 || height == 0;
                assert_eq!(matches!(fault, MapFault::Empty { .. }), zero, "{fault}");
                assert_eq!(matches!(fault, MapFault::TooLarge { .. }), !zero, "{fault}");
            }
        }
    }
}

#[test]
fn non_image_files_are_refused() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let message = load_height_map(folder.path()).unwrap_err().to_string();
    assert!(message.contains("not a regular file"), "{message}");
    let missing = folder.path().join("nothing.png");
    let message = load_environment(&missing).unwrap_err().to_string();
    assert!(message.contains("nothing.png") && message.contains("check the path"), "{message}");
    let text = folder.path().join("notes.hdr");
    fs::write(&text, "just text").unwrap();
    assert!(matches!(load_environment(&text).unwrap_err().fault, MapFault::Unrecognised { .. }));
    // A wrong file extension has no effect, because the content determines the format.
    let misnamed = folder.path().join("heights.hdr");
    fs::write(&misnamed, encode_exr(1, 1, &[("Y", &[0.5])]).unwrap()).unwrap();
    assert_eq!(load_height_map(&misnamed).unwrap().texels, [0.5]);
    // A device has no end.
    #[cfg(unix)]
    assert!(matches!(load_height_map("/dev/zero").unwrap_err().fault, MapFault::NotAFile));
}

/// The counter must detect a large allocation. If not, the memory tests prove nothing.
#[test]
fn the_allocation_counter_counts() {
    let _alone = alone();
    let (buffer, peak, _) = measured(|| vec![1u8; 3 << 20]);
    assert!(peak >= buffer.len());
}
