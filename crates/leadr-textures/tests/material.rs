//! Textures of a material for each engine: names, channels, directions, and roughness that contains the spread of the normals.

use leadr_maps::decode_raster;
use leadr_maps::material::{
    Encoding, GreenAxis, Input, Material, NormalMap, Opacity, Raster, RoughnessMeaning, Samples, Texture,
};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_textures::engine::Engine;
use leadr_textures::material::{FilteredMaterial, filter_material};
use leadr_textures::model::FilterError;

const SIDE: u32 = 32;

fn texture(channels: usize, texel: impl Fn(u32, u32) -> Vec<u8>) -> Texture {
    let codes = (0..SIDE * SIDE).flat_map(|i| texel(i % SIDE, i / SIDE)).collect();
    Texture::new(Raster::new(SIDE, SIDE, channels, Samples::U8(codes)).unwrap(), "made", Encoding::Linear)
}

/// Normals that lean alternately to the four sides.
fn normals(green: GreenAxis) -> NormalMap {
    let lean = |x: u32, y: u32| {
        vec![if x.is_multiple_of(2) { 70 } else { 190 }, if y.is_multiple_of(2) { 80 } else { 170 }, 230]
    };
    NormalMap { texture: texture(3, lean), green, scale: 1.0 }
}

fn bumpy() -> Material {
    let mut material = Material::new("bumpy");
    material.base_color =
        Input::colors(Texture { encoding: Encoding::Srgb, ..texture(3, |x, y| vec![8 * x as u8, 8 * y as u8, 60]) });
    material.roughness = Input::texture(texture(1, |_, _| vec![51]), 0);
    material.occlusion = Input::texture(texture(1, |x, _| vec![100 + x as u8]), 0);
    material.metalness = Input::constant(0.0);
    material.normal_map = Some(normals(GreenAxis::Up));
    material
}

fn filtered(material: &Material, engine: Engine) -> FilteredMaterial {
    filter_material(material, engine, &mut |_, _| {}).expect("textures")
}

/// The finest level of a DDS file.
fn finest(of: &FilteredMaterial, name: &str) -> Vec<[u8; 4]> {
    let (_, bytes) = of.files.iter().find(|(texture, _)| texture.name == name).expect(name);
    let raster = decode_raster(bytes).unwrap();
    let Samples::U8(codes) = raster.samples() else { panic!("8 bits") };
    codes.as_chunks::<4>().0.to_vec()
}

/// The coarsest level of a DDS file, which is its last texel, as RGBA.
fn coarsest(of: &FilteredMaterial, name: &str) -> [u8; 4] {
    let (_, bytes) = of.files.iter().find(|(texture, _)| texture.name == name).expect(name);
    let [b, g, r, a] = *bytes.last_chunk::<4>().unwrap();
    [r, g, b, a]
}

#[test]
fn every_engine_gets_its_files() {
    let material = bumpy();
    for (engine, names) in [
        (Engine::Gltf, ["_BaseColor.ktx2", "_Normal.ktx2", "_ORM.ktx2"]),
        (Engine::Bevy, ["_BaseColor.ktx2", "_Normal.ktx2", "_ORM.ktx2"]),
        (Engine::Godot, ["_BaseColor.dds", "_Normal.dds", "_ORM.dds"]),
        (Engine::Unity, ["_BaseColor.dds", "_Normal.dds", "_Mask.dds"]),
        (Engine::Unreal, ["_BaseColor.dds", "_Normal.dds", "_ORM.dds"]),
    ] {
        let mut steps = Vec::new();
        let found = filter_material(&material, engine, &mut |done, all| steps.push((done, all))).unwrap();
        assert_eq!(found.files.iter().map(|(texture, _)| texture.name.as_str()).collect::<Vec<_>>(), names);
        assert!(found.remarks.is_empty(), "{:?}", found.remarks);
        assert_eq!(steps, [(0, 3), (1, 3), (2, 3), (3, 3)]);
        let [near, far] = found.files[2].0.roughness.unwrap();
        assert!((near - 0.2).abs() < 0.005 && far > 0.5, "{engine:?}: {near} {far}");
    }
}

#[test]
fn channels_and_directions_are_those_of_the_engine() {
    let material = bumpy();
    let [godot, unity, unreal] =
        [Engine::Godot, Engine::Unity, Engine::Unreal].map(|engine| filtered(&material, engine));
    let source = normals(GreenAxis::Up).texture.raster;
    for (i, (up, down)) in finest(&godot, "_Normal.dds").iter().zip(finest(&unreal, "_Normal.dds")).enumerate() {
        let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
        let codes = [0, 1, 2].map(|c| (255.0 * source.value(x, y, c)).round() as u8);
        assert_eq!(up[..3], codes);
        assert_eq!(down[..3], [codes[0], 255 - codes[1], codes[2]]);
    }
    for (orm, mask) in finest(&godot, "_ORM.dds").iter().zip(finest(&unity, "_Mask.dds")) {
        let [occlusion, roughness, metalness, alpha] = *orm;
        assert_eq!((roughness, metalness, alpha), (51, 0, 255));
        assert_eq!(mask, [metalness, occlusion, 0, 255 - roughness]);
    }
    let [occlusion, roughness, ..] = coarsest(&godot, "_ORM.dds");
    assert_eq!(coarsest(&unity, "_Mask.dds"), [0, occlusion, 0, 255 - roughness]);
    assert!(occlusion.abs_diff(116) < 2 && roughness > 128, "{occlusion} {roughness}");
    // A source with green down gives the same.
    let mut turned = material.clone();
    turned.normal_map = Some(normals(GreenAxis::Down));
    assert_eq!(finest(&filtered(&turned, Engine::Unreal), "_Normal.dds").len(), 1024);
    let codes = |material: &Material, engine| finest(&filtered(material, engine), "_Normal.dds");
    assert_eq!(codes(&turned, Engine::Unreal), codes(&material, Engine::Godot));
}

#[test]
fn masks_and_alpha_of_facets_are_converted() {
    let mut material = bumpy();
    material.opacity =
        Opacity::Mask { mask: Input::texture(texture(1, |x, _| vec![if x < 16 { 255 } else { 0 }]), 0), cutoff: 0.5 };
    material.roughness = Input::constant(0.25);
    material.roughness_meaning = RoughnessMeaning::Alpha;
    let found = filtered(&material, Engine::Godot);
    let colors = finest(&found, "_BaseColor.dds");
    assert_eq!((colors[3][3], colors[20][3]), (255, 0));
    // The roughness of engines is the root of alpha.
    assert_eq!(finest(&found, "_ORM.dds")[0][1], 128);
    // Gloss is one minus the roughness.
    material.roughness_meaning = RoughnessMeaning::Gloss(Gloss::Perceptual);
    assert_eq!(finest(&filtered(&material, Engine::Godot), "_ORM.dds")[0][1], 191);
    // Half of the surface stays covered.
    let (_, bytes) = &found.files[0];
    let level = &bytes[bytes.len() - 4 * 5..][..4 * 4];
    let covered = level.as_chunks::<4>().0.iter().filter(|texel| texel[3] >= 128).count();
    assert_eq!(covered, 2, "{level:?}");
}

#[test]
fn what_is_missing_is_said() {
    let mut material = bumpy();
    material.normal_map = None;
    let found = filtered(&material, Engine::Unity);
    assert_eq!(found.files.len(), 2);
    assert!(found.remarks[0].contains("no normal map"), "{:?}", found.remarks);
    let empty = filter_material(&Material::new("empty"), Engine::Gltf, &mut |_, _| {}).unwrap_err();
    assert!(matches!(empty, FilterError::NoTexture));
}
