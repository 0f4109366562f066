//! Restores 16-bit maps that were reduced to 8 bits, and compares their slope statistics with the original.

use leadr_maps::derive::quantisation::{Quantisation, restore};
use leadr_maps::{HeightMap, LeadrMap, Wrap, load_height_map};
use leadr_testing::shared::shared_data;

/// Returns the slope variance along both axes, and its mean inside the texels of level 4.
fn variances(map: &HeightMap) -> [f64; 2] {
    let leadr = LeadrMap::new(map, Wrap::Repeat);
    let sum = |[xx, yy, _]: [f64; 3]| xx + yy;
    let inside = &leadr.levels[4].texels;
    let mean = inside.iter().map(|texel| sum(texel.slope_covariance())).sum::<f64>() / inside.len() as f64;
    [sum(leadr.mean().slope_covariance()), mean]
}

fn rms(a: &HeightMap, b: &HeightMap) -> f64 {
    let squares: f64 = a.texels.iter().zip(&b.texels).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / a.texels.len() as f64).sqrt()
}

fn restored(map: &HeightMap) -> (HeightMap, Quantisation) {
    let mut map = map.clone();
    let quantisation = restore(&mut map, Wrap::Repeat).expect("a coarse map");
    (map, quantisation)
}

#[test]
fn scanned_reliefs_of_8_bits_have_the_slopes_of_16_bits() {
    let Some(folder) = shared_data("displacement") else { return };
    for material in ["Ground054", "Leather027", "MetalWalkway006", "Rock003", "SheetMetal001"] {
        let relief =
            load_height_map(folder.join(material).join(format!("{material}_1K-PNG_Displacement.png"))).unwrap();
        let codes = relief.texels.iter().map(|h| (h * 255.0).round() / 255.0).collect();
        let raw = HeightMap::new(relief.width, relief.height, codes).unwrap();
        let (found, _) = restored(&raw);
        let [whole, inside] = [0, 1].map(|i| variances(&found)[i] / variances(&relief)[i]);
        assert!((0.95..1.02).contains(&whole) && (0.93..1.02).contains(&inside), "{material}: {whole}, {inside}");
        assert!(rms(&found, &relief) <= rms(&raw, &relief), "{material}");
        assert_eq!(restore(&mut relief.clone(), Wrap::Repeat), None, "{material}");
    }
}

#[test]
fn dunes_of_8_bits_have_the_slopes_of_16_bits() {
    let Some(folder) = shared_data("reports") else { return };
    let relief = load_height_map(folder.join("dunes_16bit.png")).unwrap();
    for (file, most, inside_most) in [("dunes_8bit.png", 0.15, 1.1), ("dunes_8bit.jpg", 0.5, 12.0)] {
        let raw = load_height_map(folder.join(file)).unwrap();
        let (found, quantisation) = restored(&raw);
        let [whole, inside] = [0, 1].map(|i| variances(&found)[i] / variances(&relief)[i]);
        assert!((whole - 1.0).abs() < 0.05 && inside < inside_most, "{file}: {whole}, {inside}");
        assert!(rms(&found, &relief) < most * rms(&raw, &relief), "{file}");
        println!("{file}: {quantisation:?}");
        assert!((0.31..0.37).contains(&quantisation.before) && quantisation.after < 0.02, "{file}: {quantisation:?}");
    }
}
