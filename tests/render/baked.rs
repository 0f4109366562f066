//! Maps baked into a file give the same picture as maps baked by the renderer, to the last digits; smaller formats stay within their stated errors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use leadr::gpu::Gpu;
use leadr::maps::bake::{ExrFile, Inputs as BakeInputs, Kind, Ktx2File, Layout, Plan, Precision, Roughness, bake};
use leadr::maps::baked::BakedMap;
use leadr::maps::material::{Material, RoughnessMeaning};
use leadr::maps::save::save_exr;
use leadr::maps::{RgbImage, load_height_map, load_raster, procedural};
use leadr::render::frame::Layer;
use leadr::render::settings::{LodBias, RenderSettings, ShadingOptions};
use leadr::render::surfaces::moments::MomentFormat;
use leadr::scenes::config::{MaterialFiles, Picture, SceneConfig};
use leadr::scenes::registry::NamedScene;
use leadr::scenes::set::{Inputs, set};
use leadr::scenes::view::{Size, ViewChoice};
use leadr_testing::gpu::test_gpu;
use leadr_tools::metrics::compare::rrmse;

/// Files of one surface, in a folder.
struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    /// Heights of `size`² texels, with matching normals, roughness and colour.
    fn new(size: u32) -> Self {
        let files = Self { folder: tempfile::tempdir().unwrap() };
        let rock = procedural::rock(size, size, 3);
        save_exr(files.at("heights.exr"), size, size, &[("height", &rock.texels)]).unwrap();
        let code = |x: u32, y: u32, f: f32| ((f * 200.0) as u32 + 7 * x + 3 * y) as u8;
        let height = |x: u32, y: u32| rock.at(x % size, y % size);
        image::RgbImage::from_fn(size, size, |x, y| image::Rgb([code(x, y, height(x, y)), 90, 40]))
            .save(files.at("color.png"))
            .unwrap();
        image::GrayImage::from_fn(size, size, |x, y| image::Luma([90 + code(x, y, height(x, y)) / 4]))
            .save(files.at("roughness.png"))
            .unwrap();
        image::RgbImage::from_fn(size, size, |x, y| {
            let by = [height(x + 1, y) - height(x, y), height(x, y + 1) - height(x, y)].map(|d| 6.0 * d);
            let length = (1.0 + by[0] * by[0] + by[1] * by[1]).sqrt();
            image::Rgb([-by[0], by[1], 1.0].map(|v| ((v / length * 0.5 + 0.5) * 255.0 + 0.5) as u8))
        })
        .save(files.at("normals.png"))
        .unwrap();
        files
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Bakes the heights into a file, and with `all` the other maps.
    fn bake(&self, name: &str, all: bool, precision: Precision) -> PathBuf {
        write(&self.inputs(all), &self.at(name), precision, 0)
    }

    fn inputs(&self, all: bool) -> BakeInputs {
        let mut inputs =
            BakeInputs { heights: Some(load_height_map(self.at("heights.exr")).unwrap()), ..Default::default() };
        if all {
            let mut material = Material::new("normals");
            material.set_normals(&self.at("normals.png"), None).unwrap();
            inputs.normals = material.normal_map;
            inputs.color = Some(load_raster(self.at("color.png")).unwrap());
            let (raster, meaning) = (load_raster(self.at("roughness.png")).unwrap(), RoughnessMeaning::Perceptual);
            inputs.roughness = Some(Roughness { raster, channel: 0, meaning });
        }
        inputs
    }

    /// The separate files.
    fn apart(&self, all: bool) -> MaterialFiles {
        let file = |name: &str| all.then(|| self.at(name));
        MaterialFiles {
            folder: None,
            color_map: file("color.png"),
            normal_map: file("normals.png"),
            roughness_map: file("roughness.png"),
            ..MaterialFiles::default()
        }
    }
}

/// Bakes a map of kind leadr without its finest levels into a file, and returns its path.
fn write(inputs: &BakeInputs, path: &Path, precision: Precision, dropped_levels: usize) -> PathBuf {
    let plan = Plan::new(inputs, Kind::Leadr, Layout::Leadr, precision).unwrap();
    let plan = plan.without_levels(dropped_levels).unwrap();
    let mut file = std::fs::File::create(path).unwrap();
    if path.extension().is_some_and(|extension| extension == "exr") {
        let mut target = ExrFile::new(&plan).unwrap();
        let report = bake(inputs, &plan, &mut target, &|_| ()).unwrap();
        target.finish(&mut file, &report).unwrap();
    } else {
        let mut target = Ktx2File::new(&mut file, &plan).unwrap();
        let report = bake(inputs, &plan, &mut target, &|_| ()).unwrap();
        target.finish(&report).unwrap();
    }
    path.to_path_buf()
}

fn config(scene: &str, height_map: &Path, material: MaterialFiles) -> SceneConfig {
    SceneConfig {
        scene: NamedScene::find(scene).unwrap(),
        height_map: Some(height_map.to_path_buf()),
        material,
        view: ViewChoice::Mid,
        size: Size { width: 96, height: 64 },
        picture: Picture { samples: 1, ..Picture::default() },
        atlas_tile: 16,
        // Surroundings come from no file.
        bare: true,
        ..SceneConfig::default()
    }
}

fn picture(gpu: &Arc<Gpu>, config: &SceneConfig) -> RgbImage {
    picture_by(gpu, config, true)
}

/// Draws with classes of facets, or with one Gaussian of slopes.
fn picture_by(gpu: &Arc<Gpu>, config: &SceneConfig, classes: bool) -> RgbImage {
    let inputs = Inputs::load(config).unwrap();
    let mut set = set(config, inputs, gpu, None, &|_| ()).unwrap();
    let state = (set.animation)(0.0);
    let settings = config.render_settings();
    let shading = settings.shading.adjusted(|options| ShadingOptions { classes, ..options });
    set.renderer.render(&state, &RenderSettings { shading, ..settings }).unwrap().image()
}

#[test]
#[ignore = "long"]
fn a_file_gives_the_picture_of_its_maps() {
    let Some(gpu) = test_gpu() else { return };
    for (size, all) in [(64, false), (50, true)] {
        let files = Files::new(size);
        for (scene, names) in [("plane", &["baked.ktx2", "baked.exr"][..]), ("sphere", &["baked.ktx2"])] {
            let apart = config(scene, &files.at("heights.exr"), files.apart(all));
            let expected = picture(&gpu, &apart);
            let flat = SceneConfig { picture: Picture { height_scale: 0.0, ..apart.picture }, ..apart };
            assert!(rrmse(&expected, &picture(&gpu, &flat)).unwrap() > 0.05, "there is something to see");
            for name in names {
                let baked = config(scene, &files.bake(name, all, Precision::F32), MaterialFiles::default());
                let found = picture(&gpu, &baked);
                let error = rrmse(&expected, &found).unwrap();
                println!("{scene} {size} {all} {name}: {error:.1e}");
                // On the plane, the mean height is subtracted before or after baking, which differs in the last digits.
                let bound = if scene == "plane" && !all { 2e-6 } else { 0.0 };
                assert!(error <= bound, "{scene} {size} {all} {name}: {error:.1e}");
            }
        }
    }
}

#[test]
#[ignore = "long"]
fn smaller_formats_stay_within_error_bounds() {
    let Some(gpu) = test_gpu() else { return };
    let files = Files::new(128);
    for (scene, all) in [("plane", false), ("plane", true), ("sphere", true)] {
        let baked = |precision: Precision| {
            let name = format!("{}.ktx2", precision.name());
            // A facet near the border of two classes can change its class with the format.
            picture_by(&gpu, &config(scene, &files.bake(&name, all, precision), MaterialFiles::default()), false)
        };
        let exact = baked(Precision::F32);
        let [half, blocks] = [Precision::F16, Precision::Bc].map(|p| rrmse(&exact, &baked(p)).unwrap());
        let on_device = SceneConfig {
            map_precision: MomentFormat::Float16,
            ..config(scene, &files.at("heights.exr"), files.apart(all))
        };
        let on_device = rrmse(&exact, &picture_by(&gpu, &on_device, false)).unwrap();
        println!("{scene} {all}: f16 file {half:.2e}, f16 on the device {on_device:.2e}, blocks {blocks:.2e}");
        assert!(half > 0.0 && half < 1e-3, "{half}");
        assert!(on_device > 0.0 && on_device < 1e-3, "{on_device}");
        assert!(blocks > half && blocks < 1e-2, "{blocks}");
    }
}

#[test]
#[ignore = "long"]
fn steep_relief_keeps_spread_and_position() {
    let Some(gpu) = test_gpu() else { return };
    let files = Files::new(8);
    // Per unit of the map, slopes with a deviation of some 700: more than any valid rise over run.
    let wave = |x: u32, k: f32| (x as f32 * k).sin();
    let texels: Vec<f32> =
        (0..256 * 256).map(|i| 0.5 + 0.2 * (wave(i % 256, 2.1) + wave(i / 256, 1.3) * wave(i % 256, 0.05))).collect();
    save_exr(files.at("heights.exr"), 256, 256, &[("height", &texels)]).unwrap();
    let drawn = |file: &Path, map_precision| {
        picture(&gpu, &SceneConfig { map_precision, ..config("plane", file, MaterialFiles::default()) })
    };
    let heights = files.at("heights.exr");
    let exact = drawn(&heights, MomentFormat::Float32);
    let error = |found: RgbImage| rrmse(&exact, &found).unwrap();
    // The device uses another unit here, and must get the same result.
    let on_device = error(drawn(&heights, MomentFormat::Float16));
    let [half, blocks] = [Precision::F16, Precision::Bc]
        .map(|p| error(drawn(&files.bake(&format!("{}.ktx2", p.name()), false, p), MomentFormat::Float32)));
    println!("steep: f16 file {half:.2e}, f16 on the device {on_device:.2e}, blocks {blocks:.2e}");
    assert!(on_device > 0.0 && on_device < 1e-3 && half > 0.0 && half < 1e-3, "{on_device} {half}");
    assert!(blocks > half && blocks < 1e-2, "{blocks}");
}

/// A file that stores classes gives the picture of its maps, up to the samples in which the classes are found.
#[test]
fn a_file_with_classes_gives_the_picture_of_its_maps() {
    let Some(gpu) = test_gpu() else { return };
    let files = Files::new(8);
    // Grooves with a steep and a gentle side, so that a wrong orientation shows.
    let height = |y: u32| match y % 32 {
        0..8 => 0.0,
        y @ 8..10 => (y - 8) as f32 / 2.0,
        10..22 => 1.0,
        y => (32 - y) as f32 / 10.0,
    };
    let texels: Vec<f32> = (0..64 * 64).map(|i| height(i / 64)).collect();
    save_exr(files.at("heights.exr"), 64, 64, &[("height", &texels)]).unwrap();
    let maps = config("plane", &files.at("heights.exr"), MaterialFiles::default());
    let expected = picture(&gpu, &maps);
    let one_class = rrmse(&expected, &picture_by(&gpu, &maps, false)).unwrap();
    assert!(one_class > 0.01, "{one_class:.1e}");
    for (name, precision) in
        [("a.ktx2", Precision::F32), ("b.exr", Precision::F32), ("c.exr", Precision::F16), ("d.ktx2", Precision::Bc)]
    {
        let heights = load_height_map(files.at("heights.exr")).unwrap();
        // The default height of 0.12 m on the default repeat of 2 m.
        let mut inputs = BakeInputs { heights: Some(heights), height_scale: Some(0.06), ..Default::default() };
        inputs.classes = Some(inputs.find_classes(None));
        let file = write(&inputs, &files.at(name), precision, 0);
        assert!(BakedMap::load(&file).unwrap().openness.is_some());
        let error = rrmse(&expected, &picture(&gpu, &config("plane", &file, MaterialFiles::default()))).unwrap();
        println!("{name}: {error:.1e}");
        assert!(error < 3e-3, "{name}: {error:.1e}");
    }
}

/// Draws the scene of a file from `metres` away.
fn from_afar(gpu: &Arc<Gpu>, scene: &str, file: &Path, metres: f32) -> RgbImage {
    let config = SceneConfig { distance: Some(metres), ..config(scene, file, MaterialFiles::default()) };
    // Classes that are found in the moments of a coarse level differ from those of the facets.
    picture_by(gpu, &config, BakedMap::load(file).unwrap().classes.is_some())
}

/// At a distance, a file without its finest levels gives the picture of the whole file. Mean slopes alone do not.
#[test]
fn a_file_without_levels_looks_the_same_at_a_distance() {
    let Some(gpu) = test_gpu() else { return };
    let files = Files::new(128);
    for (scene, all, metres, most) in [
        ("plane", false, 60.0, 1e-3),
        ("plane", true, 60.0, 1e-3),
        ("sphere", false, 24.0, 0.03),
        ("sphere", true, 24.0, 0.03),
    ] {
        let [whole, coarse] = [0, 2]
            .map(|dropped| write(&files.inputs(all), &files.at(&format!("{dropped}.ktx2")), Precision::F16, dropped));
        let [expected, found] = [&whole, &coarse].map(|file| from_afar(&gpu, scene, file, metres));
        // The heights of the coarse file are those of the whole file, without the slopes between them.
        let heights = BakedMap::load(&coarse).unwrap().height_map().unwrap();
        save_exr(files.at("mean.exr"), heights.width, heights.height, &[("height", &heights.texels)]).unwrap();
        let naive = write(
            &BakeInputs { heights: Some(heights), height_scale: all.then_some(1.0), ..files.inputs(false) },
            &files.at("naive.ktx2"),
            Precision::F16,
            0,
        );
        let naive = (!all).then(|| rrmse(&expected, &from_afar(&gpu, scene, &naive, metres)).unwrap());
        let error = rrmse(&expected, &found).unwrap();
        println!("{scene} {all}: {error:.1e}, without moments {naive:?}");
        assert!(error < most, "{scene} {all}: {error:.1e}");
        assert!(naive.is_none_or(|naive| naive > 2.0 * error), "{scene} {all}: {naive:?} {error:.1e}");
    }
}

#[test]
fn a_bias_reads_coarser_levels_with_their_moments() {
    let Some(gpu) = test_gpu() else { return };
    let files = Files::new(128);
    let [whole, coarse] = [0, 2]
        .map(|dropped| write(&files.inputs(false), &files.at(&format!("{dropped}.ktx2")), Precision::F32, dropped));
    // The lod, the second moments of the slopes, and the squares of the mean slopes, each as a mean over the picture.
    let statistics = |file: &Path, bias: f32, metres: f32| {
        let mut config = SceneConfig { distance: Some(metres), ..config("plane", file, MaterialFiles::default()) };
        config.picture.options = ShadingOptions { lod_bias: LodBias(bias), classes: false, ..config.picture.options };
        // Displaced positions depend on the level.
        config.picture.displacement = false;
        let mut set = set(&config, Inputs::load(&config).unwrap(), &gpu, None, &|_| ()).unwrap();
        set.renderer.render(&(set.animation)(0.0), &config.render_settings()).unwrap();
        let [lods, means, covariances] =
            [Layer::Lod, Layer::MeanSlope, Layer::Covariance].map(|layer| set.renderer.layer(layer).unwrap());
        (lods, means, covariances)
    };
    for metres in [2.0, 7.0, 30.0] {
        let [(lods, means, covariances), (biased, biased_means, biased_covariances)] =
            [0.0, 1.0].map(|bias| statistics(&whole, bias, metres));
        let shifts: Vec<f32> = lods.iter().zip(&biased).map(|(a, b)| b[0] - a[0]).collect();
        assert!(shifts.iter().filter(|shift| **shift != 0.0).count() > 100);
        assert!(shifts.iter().all(|shift| *shift == 0.0 || (shift - 1.0).abs() < 2e-3), "{metres}: {shifts:?}");
        let squares = |means: &[[f32; 4]]| means.iter().map(|m| f64::from(m[0] * m[0] + m[1] * m[1])).sum::<f64>();
        let variances = |c: &[[f32; 4]]| c.iter().map(|c| f64::from(c[0] + c[1])).sum::<f64>();
        let [whole, wider] = [(&means, &covariances), (&biased_means, &biased_covariances)]
            .map(|(means, covariances)| (squares(means), squares(means) + variances(covariances)));
        println!("{metres} m: {whole:?} {wider:?}");
        assert!((wider.1 / whole.1 - 1.0).abs() < 0.02, "the second moment stays: {whole:?} {wider:?}");
        assert!(wider.0 < 0.9 * whole.0, "the mean slopes are smoother: {whole:?} {wider:?}");
    }
    // Where the map is magnified, a bias of 2 reads the levels with which a file without two levels begins.
    let (_, means, covariances) = statistics(&whole, 2.0, 0.1);
    let (_, dropped_means, dropped_covariances) = statistics(&coarse, 0.0, 0.1);
    for (found, expected) in [(means, dropped_means), (covariances, dropped_covariances)] {
        let worst =
            found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 2e-3, "{worst}");
    }
}
