//! Spatially varying materials, filtered: compared with supersampled pictures of the same surface.

use glam::Vec3;
use leadr::maps::derive::{USUAL_HEIGHT, USUAL_SLOPE};
use leadr::maps::material::{
    Encoding, GreenAxis, Input, Material, MaterialFolder, NormalMap, Raster, Relief, Samples, Texture, agreement,
    alpha_code, green_axis,
};
use leadr::maps::tonemap::Tonemap;
use leadr::maps::{RgbImage, Wrap};
use leadr::reflectance::facets::fresnel::fresnel_schlick;
use leadr::reflectance::facets::metals::Metal;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, MaterialMap, Object, Pose};
use leadr::render::settings::{FresnelForm, RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::cover::SampledMaterial;
use leadr::scenes::dressed;
use leadr::scenes::plane::{even, plane};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, in_room, under_sky};
use leadr_testing::shared::shared_data;
use leadr_tools::metrics::compare::compare;

const GREY: [u8; 3] = [90; 3];
const SMOOTH: f32 = 0.1;
const ROUGH: f32 = 0.6;

/// Filter of the roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Filtered {
    /// One lobe for each class.
    Classes,
    /// One lobe of the mean `α²` (LEADR section 4.1).
    Variance,
    /// One lobe of the mean `α`.
    Mean,
}

fn dressed(width: u32, height: u32, alphas: Vec<f32>, filtered: Filtered) -> MaterialMap {
    let mean = alphas.iter().sum::<f32>() / alphas.len() as f32;
    let alpha = |alpha: f32| if filtered == Filtered::Mean { mean } else { alpha };
    let colors = alphas.iter().map(|&a| [GREY[0], GREY[1], GREY[2], alpha_code(alpha(a))]).collect();
    MaterialMap::new(width, height, colors)
}

/// A checker in two roughnesses. Texels at the borders of squares have a roughness between both, so squares have many texels.
fn checker(texels: u32, square: u32, filtered: Filtered) -> MaterialMap {
    let alpha = |i: u32| if (i % texels / square + i / texels / square).is_multiple_of(2) { SMOOTH } else { ROUGH };
    dressed(texels, texels, (0..texels * texels).map(alpha).collect(), filtered)
}

/// A floor that reflects the sun, chequered in two roughnesses; a pixel covers several squares.
fn floor(gpu: &TestGpu, filtered: Filtered) -> Renderer {
    let object = Object::new("floor", plane(4.0, 8, 0.05, [1.0; 4], even))
        .with_material(checker(512, 256, filtered))
        .with_specular_f0(0.3)
        .without_shadow();
    under_sky(gpu, vec![object], 64)
}

/// Bumps with a checker, whose squares are wider than bumps.
fn bumpy(gpu: &TestGpu, filtered: Filtered) -> Renderer {
    let object = Object::new("bumps", plane(4.0, 32, 1.0, [1.0; 4], even))
        .with_material(checker(1024, 64, filtered))
        .with_heights(bumps(256, 5.0, 3), 0.1)
        .with_specular_f0(0.3)
        .without_shadow();
    under_sky(gpu, vec![object], 64)
}

/// A square picture of `size` pixels per side.
fn picture(
    renderer: &mut Renderer,
    camera: Camera,
    size: u32,
    technique: Technique,
    classes: bool,
    samples: u32,
) -> RgbImage {
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    let settings = RenderSettings {
        size: (size, size),
        samples,
        // As in the reference, where bumps do not shadow each other.
        shading: technique.with(ShadingOptions {
            shadowing: Shadowing::None,
            classes,
            relief_occlusion: false,
            ..Default::default()
        }),
        tessellation: TessellationSettings { to_texels: technique == Technique::Reference, ..Default::default() },
        shadows: false,
        ..Default::default()
    };
    let output = renderer.render(&state, &settings).unwrap();
    RgbImage::new(size, size, output.color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap()
}

/// Relative RMSE of LEADR against the reference, with these sample counts, by roughness filter.
fn errors(
    gpu: &TestGpu,
    scene: fn(&TestGpu, Filtered) -> Renderer,
    camera: Camera,
    [samples, of_truth]: [u32; 2],
) -> [f64; 3] {
    let truth = picture(&mut scene(gpu, Filtered::Classes), camera, 48, Technique::Reference, false, of_truth);
    [Filtered::Classes, Filtered::Variance, Filtered::Mean].map(|filtered| {
        let classes = filtered == Filtered::Classes;
        let one = picture(&mut scene(gpu, filtered), camera, 48, Technique::Leadr, classes, samples);
        let error = compare(&truth, &one, 1.0, Tonemap::Filmic).unwrap();
        println!("{filtered:?}: relative RMSE {:.4}, FLIP {:.4}", error.rrmse, error.flip);
        error.rrmse
    })
}

/// The camera that sees the sun's reflection in a floor.
fn in_the_suns_mirror(distance: f32) -> Camera {
    let sun = Sky::default().sun_direction.normalize();
    Camera::looking_at(distance * Vec3::new(-sun.x, -sun.y, sun.z), Vec3::ZERO, 30.0)
}

#[test]
fn two_roughnesses_keep_both_highlights() {
    let Some(gpu) = test_gpu() else { return };
    let [classes, variance, mean] = errors(&gpu, floor, in_the_suns_mirror(6.0), [1, 256]);
    assert!(classes < 0.25 * variance.min(mean), "{classes} {variance} {mean}");
    // A variance-only filter loses the sharp highlight.
    assert!(variance > 0.1);
}

/// Where a pixel is as wide as the squares, one tap would blur neighbours together.
#[test]
#[ignore = "long"]
fn pixels_as_wide_as_the_change_stay_sharp() {
    let Some(gpu) = test_gpu() else { return };
    for distance in [2.0, 3.5] {
        let [classes, variance, mean] = errors(&gpu, floor, in_the_suns_mirror(distance), [1, 256]);
        assert!(classes < 0.15 * variance.min(mean), "{distance}: {classes} {variance} {mean}");
    }
}

#[test]
#[ignore = "long"]
fn two_roughnesses_on_relief() {
    let Some(gpu) = test_gpu() else { return };
    let camera = Camera::looking_at(Vec3::new(0.6, -0.7, 0.9).normalize() * 16.0, Vec3::ZERO, 10.0);
    let [classes, variance, mean] = errors(&gpu, bumpy, camera, [1, 64]);
    assert!(classes < 0.8 * variance.min(mean), "{classes} {variance} {mean}");
}

/// Metres per unit of height of [`material`].
const HEIGHT: f32 = 0.4;

/// A noise material with everything: colours, patches of metal, two roughnesses, heights and their normals. Texels at the borders of
/// stripes have a roughness between both, so stripes have many texels.
fn material() -> Material {
    const SIZE: u32 = 256;
    let texture = |channels: usize, value: &dyn Fn(u32, usize) -> u8| {
        let texels = (0..SIZE * SIZE).flat_map(|i| (0..channels).map(move |c| (i, c)));
        let codes = texels.map(|(i, c)| value(i, c)).collect();
        Texture::new(Raster::new(SIZE, SIZE, channels, Samples::U8(codes)).unwrap(), "made", Encoding::Linear)
    };
    let heights = bumps(SIZE, 24.0, 5);
    // Normals of the same heights on a plane with textures that repeat every 2 m.
    let normal = |i: u32, channel: usize| {
        let at = |dx: u32, dy: u32| heights.map.texels[((i / SIZE + dy) % SIZE * SIZE + (i + dx) % SIZE) as usize];
        let per_metre = HEIGHT * SIZE as f32 / 2.0 / 2.0;
        let [s, t] = [at(1, 0) - at(SIZE - 1, 0), at(0, 1) - at(0, SIZE - 1)].map(|rise| rise * per_metre);
        let length = (1.0 + s * s + t * t).sqrt();
        (127.5 + 127.5 * [-s, t][channel] / length + 0.5) as u8
    };
    let mut material = Material::new("everything");
    material.base_color = Input::colors(texture(3, &|i, c| (60 + (i * (c as u32 + 7)) % 150) as u8));
    material.metalness = Input::texture(texture(1, &|i, _| if i % 16 < 8 { 255 } else { 0 }), 0);
    material.roughness = Input::texture(texture(1, &|i, _| if i / SIZE % 64 < 32 { 60 } else { 200 }), 0);
    material.normal_map = Some(NormalMap { texture: texture(2, &normal), green: GreenAxis::Up, scale: 1.0 });
    let map = heights.map.clone();
    material.relief = Some(Relief { map, scale: Some(HEIGHT), in_widths: false, middle: 0.0 });
    material
}

/// Frames filtered and shaded in one pass, and frames with a G-buffer, show the same material.
#[test]
#[ignore = "long"]
fn the_g_buffer_keeps_a_material() {
    let Some(gpu) = test_gpu() else { return };
    for mut stage in [dressed::plane_stage(&material(), None), dressed::sphere_stage(&material(), None, 16)] {
        let object = &stage.objects[0];
        let map = object.material.as_ref().unwrap();
        assert!(map.f0.is_some() && object.slopes.is_some(), "{}", object.name);
        let camera = stage.views.mid;
        let mut renderer = under_sky(&gpu, stage.take_scene(), 32);
        let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
        // With several classes, shading does not read the G-buffer.
        let shading = Technique::Leadr.with(ShadingOptions { classes: false, ..Default::default() });
        let settings = RenderSettings { size: (64, 48), samples: 1, shading, ..Default::default() };
        let at_once = renderer.render(&state, &settings).unwrap().color;
        let through = renderer.render_in_two_passes(&state, &settings).unwrap().color;
        let (mut error, mut power) = (0.0, 0.0);
        for (a, b) in at_once.iter().zip(&through) {
            for c in 0..3 {
                error += (a[c] - b[c]).powi(2);
                power += a[c] * a[c];
            }
        }
        let error = (error / power).sqrt();
        println!("relative RMSE through the G-buffer {error:.5}");
        // 16-bit floats.
        assert!(error > 0.0 && error < 0.004, "{error}");
    }
}

/// One sample of a material with relief and normals, at a distance, against the reference.
#[test]
#[ignore = "long"]
fn material_keeps_its_appearance_at_a_distance() {
    let Some(gpu) = test_gpu() else { return };
    let mut stage = dressed::plane_stage(&material(), None);
    let mut renderer = under_sky(&gpu, stage.take_scene(), 64);
    for from in [Vec3::new(4.0, -14.0, 28.0), Vec3::new(6.0, -26.0, 14.0)] {
        let camera = Camera::looking_at(from, Vec3::ZERO, 10.0);
        let truth = picture(&mut renderer, camera, 16, Technique::Reference, false, 128);
        let mut error = |technique| {
            let one = picture(&mut renderer, camera, 16, technique, true, 1);
            let error = compare(&truth, &one, 1.0, Tonemap::Filmic).unwrap();
            println!("{from}, {}: relative RMSE {:.4}, FLIP {:.4}", technique.name(), error.rrmse, error.flip);
            println!("mean {:?} of {:?}", one.mean(), truth.mean());
            error.rrmse
        };
        let (leadr, mip) = (error(Technique::Leadr), error(Technique::NormalMip));
        assert!(leadr < 0.075 && leadr < 0.6 * mip, "{leadr} {mip}");
    }
}

/// Materials from libraries, and their known properties (`SOURCES.md` of the shared data).
#[test]
fn folders_of_materials_open() {
    let Some(shared) = shared_data("displacement") else { return };
    // Heights in texels that agree with the normals, or slopes of the default relief.
    for (name, metal, texels, steep) in [
        ("MetalWalkway006", true, Some(4.4), 0.0),
        ("SheetMetal001", true, Some(16.7), 0.0),
        ("Leather027", false, None, 6.564),
        ("Rock003", false, None, 0.518),
        ("Ground054", false, None, 0.728),
    ] {
        let folder = MaterialFolder::open(shared.join(name), Default::default()).unwrap();
        let material = folder.load().unwrap();
        assert!(material.base_color.texture.is_some() && material.roughness.texture.is_some(), "{name}");
        assert_eq!(material.metalness.texture.is_some(), metal, "{name}");
        let sampled = SampledMaterial::new(&material);
        assert_eq!(sampled.size, (1024, 1024));
        let relief = material.relief.as_ref().unwrap();
        let found = material.normal_map.as_ref().and_then(|normals| agreement(&relief.map, normals, Wrap::Repeat));
        match (found, texels) {
            (Some(found), Some(texels)) => {
                let scale = found.scale_texels;
                assert!((f64::from(sampled.unit(1.0)) * 1024.0 / scale - 1.0).abs() < 1e-5);
                println!("{name}: {scale:.2} texels of height, correlation {:.3}", found.correlation);
                assert!((scale / texels - 1.0).abs() < 0.1, "{name}: {scale} texels");
                assert!(found.correlation > 0.9);
                // Detection without the file name finds the same axis.
                let normals = material.normal_map.unwrap();
                assert_eq!(green_axis(&normals.texture.raster), normals.green, "{name}");
            }
            (None, None) => {
                let unit = sampled.unit(2.0);
                assert!((unit * steep / (USUAL_HEIGHT * USUAL_SLOPE) - 1.0).abs() < 2e-3, "{name}: {unit}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// In a white furnace a smooth ball shows its reflectance at every angle: a metal's follows its indices of refraction, not Schlick's form. The
/// exact form is closer than the edge tint; the rest is the width of the lobe, and colours of 8 bits.
#[test]
fn metals_dip_before_they_rise() {
    let Some(gpu) = test_gpu() else { return };
    const SIZE: u32 = 256;
    for (name, schlick_errs, fresnel, most) in [
        ("iron", 0.15, FresnelForm::Schlick, 0.03),
        ("copper", 0.02, FresnelForm::Schlick, 0.03),
        ("iron", 0.15, FresnelForm::Exact, 0.012),
        ("copper", 0.02, FresnelForm::Exact, 0.012),
    ] {
        let metal = Metal::named(name).unwrap();
        let mut material = Material::new(name);
        material.base_color = Input::constant(metal.f0().as_vec3().to_array());
        material.metalness = Input::constant(1.0);
        material.roughness = Input::constant(0.2);
        material.edge_tint = metal.edge_tint().as_vec3().to_array();
        let objects = std::mem::take(&mut dressed::sphere_stage(&material, None, 16).objects);
        let centre = objects[0].mesh.positions.iter().sum::<Vec3>() / objects[0].mesh.positions.len() as f32;
        let mut renderer = in_room(&gpu, objects, [1.0; 3]);
        let away = Vec3::new(0.3, -0.8, 0.52).normalize() * 200.0;
        let camera = Camera {
            near: 1.0,
            ..Camera::looking_at(centre + away, centre, 2.0 * (1.0f32 / 200.0).atan().to_degrees())
        };
        let mut worst = [0.0f64; 2];
        for in_two in [false, true] {
            let state = FrameState::new(camera, vec![Pose::REST]);
            let settings = RenderSettings {
                size: (SIZE, SIZE),
                samples: 1,
                shading: Technique::Leadr.with(ShadingOptions { fresnel, ..Default::default() }),
                ..Default::default()
            };
            let output = if in_two {
                renderer.render_in_two_passes(&state, &settings)
            } else {
                renderer.render(&state, &settings)
            };
            for (i, pixel) in output.unwrap().color.iter().enumerate() {
                let [x, y] =
                    [i as u32 % SIZE, i as u32 / SIZE].map(|k| (f64::from(k) + 0.5) * 2.0 / f64::from(SIZE) - 1.0);
                let cosine = (1.0 - x * x - y * y).max(0.0).sqrt();
                if cosine > 0.16 {
                    let (want, schlick) = (metal.reflectance(cosine), fresnel_schlick(metal.f0(), cosine));
                    for c in 0..3 {
                        worst[0] = worst[0].max((f64::from(pixel[c]) - want[c]).abs());
                        worst[1] = worst[1].max((schlick[c] - want[c]).abs());
                    }
                }
            }
        }
        println!("{name}, {fresnel:?}: at most {:.4} from its indices; Schlick {:.4}", worst[0], worst[1]);
        assert!(worst[0] < most && worst[1] > schlick_errs, "{name}: {worst:?}");
    }
}
