//! Classes of facets in baked files.

use leadr_maps::bake::{ExrFile, Inputs, Kind, Layout, Plan, Precision, bake};
use leadr_maps::baked::BakedMap;
use leadr_maps::derive::{Facets, Openness, classes_of_count};
use leadr_maps::{ClassMap, HeightMap, LeadrMap, Wrap};
use leadr_reflectance::masking::classes::Class;

use super::bake::{baked, bytes_of, content, file, heights, of_heights};

/// Returns tiles with steep borders and a fine grain.
fn tiles(width: u32, height: u32) -> HeightMap {
    let border = |v: f64| (8.0 * (0.5 - (4.0 * v).fract().abs() - 0.2).abs()).clamp(0.0, 1.0);
    heights(width, height, |s, t| 0.05 * border(s).min(border(t)) + 0.001 * (40.0 * s).sin() * (37.0 * t).cos())
}

/// Returns the inputs with this number of classes.
fn with_classes(map: &HeightMap, count: usize) -> Inputs {
    let mut inputs = Inputs { height_scale: Some(1.0), ..of_heights(map) };
    inputs.classes = Some(inputs.find_classes(Some(count)));
    inputs
}

fn exr(inputs: &Inputs, precision: Precision) -> BakedMap {
    let plan = Plan::new(inputs, Kind::Leadr, Layout::Leadr, precision).unwrap();
    let mut target = ExrFile::new(&plan).unwrap();
    let report = bake(inputs, &plan, &mut target, &|_| ()).unwrap();
    let mut file = file();
    target.finish(&mut file, &report).unwrap();
    BakedMap::decode(&content(file)).unwrap()
}

#[test]
fn classes_come_back_to_the_last_bit() {
    for (width, height, count) in [(64, 64, 3), (37, 23, 2), (16, 40, 4)] {
        let relief = tiles(width, height);
        let facets = Facets::OfHeights(&relief, Wrap::Repeat);
        let scale = [1.0, f64::from(width) / f64::from(height)];
        let found = classes_of_count(facets, scale, count);
        let exact = ClassMap::new(facets, &found, None);
        let open = Openness::new(facets, &found, None, exact.units, false);
        let inputs = with_classes(&relief, count);
        for precision in [Precision::F32, Precision::F16] {
            let (ktx2, _) = baked(&inputs, Kind::Leadr, precision);
            for map in [ktx2, exr(&inputs, precision)] {
                assert!(map.class_map().unwrap() == exact, "{width}x{height} {count} {precision:?}");
                assert!(map.openness.as_ref() == Some(&open), "{width}x{height} {count} {precision:?}");
                let plain = baked(&Inputs { classes: None, ..inputs.clone() }, Kind::Leadr, precision).0;
                assert!(plain.class_map().is_none() && plain.moments() == map.moments());
            }
        }
    }
}

#[test]
fn kinds_without_classes_ignore_them() {
    let inputs = with_classes(&tiles(16, 16), 2);
    assert_eq!(bytes_of(&inputs, Kind::Lean, Precision::F32).0, {
        let plain = Inputs { classes: None, ..inputs.clone() };
        bytes_of(&plain, Kind::Lean, Precision::F32).0
    });
    let error = Plan::new(&inputs, Kind::Leadr, Layout::Oiio, Precision::F32).unwrap_err().to_string();
    assert!(error.contains("the layout oiio holds no classes"), "{error}");
}

/// Returns the error of the slope variance of the whole surface: the classes of each texel joined, relative to the mean variance.
fn variance_error(map: &ClassMap, leadr: &LeadrMap, level: usize) -> f64 {
    let (mut difference, mut whole) = (0.0, 0.0);
    for (at, texel) in leadr.levels[level].texels.iter().enumerate() {
        let classes = map.classes_of_texel(level, at);
        let mean = |f: &dyn Fn(&Class) -> f64| classes.iter().map(|class| class.share * f(class)).sum::<f64>();
        let (x, xx) = (mean(&|c| c.mean.x), mean(&|c| c.covariance.x + c.mean.x * c.mean.x));
        let [truth, ..] = texel.slope_covariance();
        difference += (xx - x * x - truth).powi(2);
        whole += truth * truth;
    }
    (difference / whole).sqrt()
}

#[test]
fn blocks_hold_classes_with_a_measured_error() {
    let relief = tiles(128, 128);
    let leadr = LeadrMap::new(&relief, Wrap::Repeat);
    let inputs = with_classes(&relief, 3);
    let (map, report) = baked(&inputs, Kind::Leadr, Precision::Bc);
    let classes = map.class_map().unwrap();
    for level in [2, 4, 6] {
        let (error, of_classes) = (variance_error(&classes, &leadr, level), report.errors[level].classes);
        println!("level {level}: variance {error:.4}, channels {of_classes:.4}");
        assert!(error < 0.02 && of_classes > 1e-5 && of_classes < 0.03, "{level}: {error} {of_classes}");
    }
    assert!(report.errors.iter().all(|error| error.classes < 0.03), "{:?}", report.errors);
    let exact = baked(&inputs, Kind::Leadr, Precision::F32).1;
    assert!(exact.errors.iter().all(|error| error.classes == 0.0));
    let bytes = |precision| Plan::new(&inputs, Kind::Leadr, Layout::Leadr, precision).unwrap().bytes_per_texel();
    assert_eq!([Precision::F32, Precision::F16, Precision::Bc].map(bytes), [128, 64, 9 + 3 * 10]);
}

#[test]
fn damaged_classes_are_faults_and_never_panics() {
    let inputs = with_classes(&tiles(9, 6), 2);
    for precision in [Precision::F32, Precision::F16, Precision::Bc] {
        let (bytes, _) = bytes_of(&inputs, Kind::Leadr, precision);
        assert!(BakedMap::decode(&bytes).unwrap().class_map().is_some());
        let replaced = |from: &str, to: &str| {
            let at = bytes.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
            let mut damaged = bytes.clone();
            damaged[at..at + to.len()].copy_from_slice(to.as_bytes());
            BakedMap::decode(&damaged).map_err(|fault| fault.to_string())
        };
        let digits = bytes.windows(64).find(|part| part.iter().all(u8::is_ascii_hexdigit)).unwrap();
        let digits = String::from_utf8(digits.to_vec()).unwrap();
        for (from, to, what) in [
            ("leadr.class_centers", "leadr.class_zenters", "leadr.class_centers is missing"),
            ("leadr.class_units", "leadr.class_unitz", "leadr.class_units is missing"),
            ("leadr.class_units\0", "leadr.class_units\0-", "leadr.class_units is invalid"),
            ("leadr.class_units\0", "leadr.class_units\0nan ", "leadr.class_units is invalid"),
            ("leadr.class_centers\0", "leadr.class_centers\x001 2 ", "leadr.class_centers is invalid"),
            ("leadr.class_openness\0", "leadr.class_openness\0one", "leadr.class_openness is invalid"),
            ("leadr.class_openness\0", "leadr.class_openness\x002 9 ", "leadr.class_openness is invalid"),
            ("leadr.class_openness\0", "leadr.class_openness\x002 nan ", "leadr.class_openness is invalid"),
            // The first value of the table is not a number, or not a share.
            (digits.as_str(), "00g0", "leadr.class_openness is invalid"),
            (digits.as_str(), "4000", "leadr.class_openness is invalid"),
        ] {
            let error = replaced(from, to).unwrap_err();
            assert!(error.contains(what), "{precision:?} {to}: {error}");
        }
        for to in ["class3.w", "class1.w", "class2.q"] {
            let error = replaced("class2.w", to).unwrap_err();
            assert!(error.contains("leadr.channels is invalid"), "{precision:?} {to}: {error}");
        }
        // Files of other versions lack the table.
        for to in ["leadr.class_openzess", "leadr.class_openness\x001"] {
            let map = replaced("leadr.class_openness", to).unwrap();
            assert!(map.class_map().is_some() && map.openness.is_none(), "{to}");
        }
        let whole = bytes.len();
        let mut state = 7u64;
        let mut random = move |n: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) % n as u64) as usize
        };
        for _ in 0..3000 {
            let mut damaged = bytes.clone();
            for _ in 0..=random(3) {
                damaged[random(whole.min(1500))] ^= 1 << random(8);
            }
            let read = BakedMap::decode(&damaged[..whole - random(2) * random(whole)]);
            // A panic of the conversion fails the test.
            if let Err(error) = read.as_ref().map(BakedMap::class_map).map_err(ToString::to_string) {
                assert!(!error.contains("internal panic") && !error.contains('\n'), "{error}");
            }
        }
    }
    // A number that is not finite in a class is refused.
    let (mut bytes, _) = bytes_of(&inputs, Kind::Leadr, Precision::F32);
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(BakedMap::decode(&bytes).unwrap_err().to_string().contains("holds NaN"));
}
