//! Writes the corpus that fuzzing begins with, a folder for each target: small files of every kind, made by this project's own
//! writers or by hand. `seeds FOLDER`.

use std::error::Error;
use std::fs::{File, create_dir_all, write};
use std::io::{Cursor, Read, Seek};
use std::path::Path;

use exr::prelude::{Blocks, Compression, Encoding, Image, LineOrder, SpecificChannels, Vec2, WritableImage};
use image::codecs::jpeg::JpegEncoder;
use leadr_maps::bake::{ExrFile, Inputs, Kind, Ktx2File, Layout, Plan, Precision, bake};
use leadr_maps::save::{encode_exr, encode_png_grey16, encode_png_srgb8};
use leadr_maps::{HeightMap, Rgb8Image};
use serde_json::json;

type Done<T = ()> = Result<T, Box<dyn Error>>;

const SIDE: u32 = 8;

fn main() -> Done {
    let folder = std::env::args().nth(1).ok_or("say where: seeds FOLDER")?;
    let put = |target: &str, name: &str, bytes: &[u8]| -> Done {
        let folder = Path::new(&folder).join(target);
        create_dir_all(&folder)?;
        Ok(write(folder.join(name), bytes)?)
    };
    pictures(&put)?;
    exr_files(&put)?;
    environments(&put)?;
    baked(&put)?;
    models(&put)?;
    measured(&put)?;
    put("camera", "plain", br#"{"position": [0, -10, 3], "target": [0, 0, 3], "up": [0, 0, 1], "fov_degrees": 40}"#)?;
    // Magic, key, a checksum that is none, content.
    let header = [*b"LEADRBAK", 7u64.to_le_bytes(), 0u64.to_le_bytes()].concat();
    put("cache", "plain", &[&header[..], &[1, 2, 3]].concat())
}

type Put<'a> = &'a dyn Fn(&str, &str, &[u8]) -> Done;

fn bumps() -> Done<HeightMap> {
    let texels = (0..SIDE * SIDE).map(|i| ((i * 37) % 64) as f32 / 64.0).collect();
    Ok(HeightMap::new(SIDE, SIDE, texels)?)
}

fn colors() -> Vec<[u8; 3]> {
    (0..SIDE * SIDE).map(|i| [i * 3, 255 - i * 2, i * 29].map(|v| (v % 256) as u8)).collect()
}

fn pictures(put: Put) -> Done {
    let image = Rgb8Image::new(SIDE, SIDE, colors())?;
    put("pictures", "rgb.png", &encode_png_srgb8(&image)?)?;
    put("pictures", "grey16.png", &encode_png_grey16(&bumps()?, 0.0, 1.0)?)?;
    let mut jpeg = Vec::new();
    let pixels = colors().concat();
    JpegEncoder::new_with_quality(&mut jpeg, 80).encode(&pixels, SIDE, SIDE, image::ExtendedColorType::Rgb8)?;
    put("pictures", "rgb.jpg", &jpeg)?;
    let pixels = image::RgbImage::from_raw(SIDE, SIDE, pixels).ok_or("too few colours")?;
    for (name, format) in [
        ("rgb.tiff", image::ImageFormat::Tiff),
        ("rgb.webp", image::ImageFormat::WebP),
        ("rgb.tga", image::ImageFormat::Tga),
        ("rgb.bmp", image::ImageFormat::Bmp),
        ("rgb.ppm", image::ImageFormat::Pnm),
    ] {
        let mut bytes = Cursor::new(Vec::new());
        pixels.write_to(&mut bytes, format)?;
        put("pictures", name, &bytes.into_inner())?;
    }
    // Textures of one level of 4 x 4 texels: each format of a block of 16 bytes, with and without supercompression.
    let block: Vec<u8> = (0..16u8).map(|i| i.wrapping_mul(13).wrapping_add(64)).collect();
    for (format, scheme) in [(146u32, 0u32), (138, 0), (152, 0), (156, 0), (158, 0), (9, 0), (146, 2), (146, 3)] {
        let words = [format, 1, 4, 4, 0, 0, 1, 1, scheme, 0, 0, 0, 0, 0, 0, 0, 0];
        let header = [&b"\xabKTX 20\xbb\r\n\x1a\n"[..], &words.map(u32::to_le_bytes).concat()].concat();
        let index = [104u64, 16, 16].map(u64::to_le_bytes).concat();
        put("pictures", &format!("{format}-{scheme}.ktx2"), &[header, index, block.clone()].concat())?;
    }
    for code in [*b"DXT1", *b"DXT5", *b"BC4U", *b"BC5S"] {
        let mut words = [0u32; 31];
        (words[0], words[2], words[3], words[18], words[19]) = (124, 4, 4, 32, 4);
        words[20] = u32::from_le_bytes(code);
        let name = String::from_utf8_lossy(&code).to_lowercase();
        let file = [&b"DDS "[..], &words.map(u32::to_le_bytes).concat(), &block].concat();
        put("pictures", &format!("{name}.dds"), &file)?;
    }
    Ok(())
}

fn exr_files(put: Put) -> Done {
    let plane: Vec<f32> = bumps()?.texels;
    put("exr", "height.exr", &encode_exr(SIDE, SIDE, &[("height", &plane)])?)?;
    let layered = [("view.B", &plane[..]), ("view.G", &plane), ("view.R", &plane), ("view.Z", &plane)];
    put("exr", "layered.exr", &encode_exr(SIDE, SIDE, &layered)?)?;
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ];
    for (number, compression) in compressions.into_iter().enumerate() {
        for (kind, blocks) in [("lines", Blocks::ScanLines), ("tiles", Blocks::Tiles(Vec2(4, 4)))] {
            let texel = |at: Vec2<usize>| (at.0 as f32 / 8.0, at.1 as f32 / 8.0, 0.25f32);
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let size = (SIDE as usize, SIDE as usize);
            let image = Image::from_encoded_channels(size, encoding, SpecificChannels::rgb(texel));
            let mut bytes = Vec::new();
            image.write().non_parallel().to_buffered(Cursor::new(&mut bytes))?;
            for target in ["exr", "environments"] {
                put(target, &format!("{kind}-{number}.exr"), &bytes)?;
            }
        }
    }
    Ok(())
}

fn environments(put: Put) -> Done {
    let head = |lines: &str| format!("#?RADIANCE\n{lines}\n\n-Y 2 +X 9\n").into_bytes();
    let flat: Vec<u8> = (0..18u8).flat_map(|i| [10 * i, 200, 30, 128]).collect();
    put("environments", "flat.hdr", &[head("FORMAT=32-bit_rle_rgbe\nEXPOSURE=2"), flat].concat())?;
    let mut line = vec![2, 2, 0, 9];
    line.extend([128 + 4, 7, 5, 1, 2, 3, 4, 5]);
    line.extend([128 + 9, 3, 128 + 9, 4, 128 + 9, 136]);
    put("environments", "runs.hdr", &[head("FORMAT=32-bit_rle_xyze"), line.clone(), line].concat())
}

fn baked(put: Put) -> Done {
    let inputs = Inputs { heights: Some(bumps()?), ..Inputs::default() };
    for kind in [Kind::Leadr, Kind::Lean, Kind::Clean, Kind::CleanConservative, Kind::Toksvig] {
        for precision in [Precision::F32, Precision::F16, Precision::Bc] {
            let name = format!("{}-{}", kind.name(), precision.name());
            let bytes_of = |write: &dyn Fn(&mut File, &Plan) -> Done| -> Done<Vec<u8>> {
                let plan = Plan::new(&inputs, kind, Layout::Leadr, precision)?;
                let mut file = tempfile::tempfile()?;
                write(&mut file, &plan)?;
                let mut bytes = Vec::new();
                file.rewind()?;
                file.read_to_end(&mut bytes)?;
                Ok(bytes)
            };
            let ktx2 = bytes_of(&|file, plan| {
                let mut target = Ktx2File::new(file, plan)?;
                let report = bake(&inputs, plan, &mut target, &|_| ())?;
                Ok(target.finish(&report)?)
            });
            // Not every kind comes in every precision.
            if let Ok(bytes) = ktx2 {
                put("baked", &format!("{name}.ktx2"), &bytes)?;
            }
            let exr = bytes_of(&|file, plan| {
                let mut target = ExrFile::new(plan)?;
                let report = bake(&inputs, plan, &mut target, &|_| ())?;
                Ok(target.finish(file, &report)?)
            });
            if let Ok(bytes) = exr {
                put("exr", &format!("{name}.exr"), &bytes)?;
            }
        }
    }
    Ok(())
}

/// A triangle with a material, a camera, a light and an animation, whose numbers stand in the binary chunk.
fn models(put: Put) -> Done {
    let floats: Vec<f32> = vec![
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // positions
        0.0, 0.0, 1.0, 0.0, 0.0, 1.0, // texture coordinates
        0.0, 1.0, // times
        0.0, 0.0, 0.0, 0.0, 2.0, 0.0, // translations
    ];
    let mut binary: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    let indices = binary.len();
    binary.extend([0u16, 1, 2, 0].iter().flat_map(|v| v.to_le_bytes()));
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let root = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0, "name": "leaf" }, { "camera": 0, "rotation": [0, 0, 0, 1] }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "materials": [{
            "name": "green", "doubleSided": true, "alphaMode": "MASK",
            "pbrMetallicRoughness": { "baseColorFactor": [0.2, 0.5, 0.1, 1], "roughnessFactor": 0.4 },
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0 }] }],
        "animations": [{
            "samplers": [{ "input": 3, "output": 4, "interpolation": "LINEAR" }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        }],
        "accessors": [
            { "bufferView": 0, "type": "VEC3", "componentType": 5126, "count": 3, "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "type": "VEC2", "componentType": 5126, "count": 3 },
            { "bufferView": 2, "type": "SCALAR", "componentType": 5123, "count": 3 },
            { "bufferView": 3, "type": "SCALAR", "componentType": 5126, "count": 2, "min": [0], "max": [1] },
            { "bufferView": 4, "type": "VEC3", "componentType": 5126, "count": 2 },
        ],
        "bufferViews": [view(0, 36), view(36, 24), view(indices, 6), view(60, 8), view(68, 24)],
        "buffers": [{ "byteLength": binary.len() }],
    });
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &binary)].concat();
    let head = [&b"glTF"[..], &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes()].concat();
    put("gltf", "leaf.glb", &[head, chunks].concat())?;
    let mut alone = root;
    alone["buffers"][0]["uri"] = json!("data:application/octet-stream;base64,AAAAAAAAAAAAAAAA");
    put("gltf", "leaf.gltf", alone.to_string().as_bytes())
}

fn measured(put: Put) -> Done {
    let sizes: Vec<u8> = [90u32, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect();
    put("merl", "even", &[&sizes[..], &100.0f64.to_le_bytes()].concat())?;
    put("utia", "even", &0.2f64.to_le_bytes())?;
    put("table", "backscattering", b"theta,r,g,b\n# degrees\n0,0.4,0.3,0.2\n45,0.3,0.2,0.1\n80,0.1,0.1,0.1\n")?;
    put("table", "grid", b"theta_h,theta_d,value\n0,0,0.4\n0,60,0.3\n50,0,0.2\n50,60,0.1\n")?;
    let fresnel = vec![[0.9, 0.8, 0.7]; 46];
    let fit = json!({
        "format": "leadr fit", "version": 1, "masking": "smith", "diffuse": [0.1, 0.1, 0.1], "fresnel": fresnel,
        "density": (0..16).map(|i| f64::exp(-0.5 * f64::from(i))).collect::<Vec<_>>(),
        "lobes": [{ "share": 1.0, "covariance": [0.02, 0.02, 0.0] }],
    });
    put("fit", "plain.json", fit.to_string().as_bytes())?;
    put("rgl", "plain.bsdf", &tensors())
}

/// A tensor file of a material that is the same everywhere.
fn tensors() -> Vec<u8> {
    let fields: [(&str, &[u64], Vec<f32>); 6] = [
        ("phi_i", &[1], vec![0.0]),
        ("theta_i", &[2], vec![0.0, 1.5]),
        ("sigma", &[2, 4], vec![1.0; 8]),
        ("ndf", &[2, 4], vec![1.0; 8]),
        ("vndf", &[1, 2, 4, 4], vec![1.0; 32]),
        ("rgb", &[1, 2, 3, 2, 2], vec![0.5; 24]),
    ];
    const FLOAT: u8 = 10;
    let mut head = b"tensor_file\0\x01\0".to_vec();
    head.extend((fields.len() as u32).to_le_bytes());
    let described: usize = fields.iter().map(|(name, shape, _)| 2 + name.len() + 2 + 1 + 8 + 8 * shape.len()).sum();
    let mut offset = head.len() + described;
    let mut body = Vec::new();
    for (name, shape, values) in &fields {
        head.extend((name.len() as u16).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((shape.len() as u16).to_le_bytes());
        head.push(FLOAT);
        head.extend((offset as u64).to_le_bytes());
        shape.iter().for_each(|n| head.extend(n.to_le_bytes()));
        values.iter().for_each(|v| body.extend(v.to_le_bytes()));
        offset += 4 * values.len();
    }
    head.extend(body);
    head
}
