//! Colour differences as CIEDE2000 (Sharma, Wu and Dalal 2005).

use super::compare::{same_size, size_of};
use leadr_maps::tonemap::Tonemap;
use leadr_maps::{MapFault, RgbImage};

/// Converts linear RGB (Rec. 709, white D65), clamped to 0..1, to CIE L*a*b*.
pub fn lab(color: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = color.map(|c| c.clamp(0.0, 1.0));
    let xyz = [
        (0.412_390_80 * r + 0.357_584_34 * g + 0.180_480_79 * b) / 0.950_455_93,
        0.212_639_01 * r + 0.715_168_68 * g + 0.072_192_32 * b,
        (0.019_330_82 * r + 0.119_194_78 * g + 0.950_532_15 * b) / 1.089_057_75,
    ];
    let [x, y, z] = xyz.map(|t| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Returns ΔE₀₀ of two colours in L*a*b*. A difference of about 1 is just noticeable.
pub fn delta_e_2000([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
    let mean_chroma = 0.5 * (a1.hypot(b1) + a2.hypot(b2));
    let seventh = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let stretch = 1.0 + 0.5 * (1.0 - seventh(mean_chroma));
    let polar = |a: f64, b: f64| {
        let a = a * stretch;
        (a.hypot(b), if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).to_degrees().rem_euclid(360.0) })
    };
    let ((c1, h1), (c2, h2)) = (polar(a1, b1), polar(a2, b2));
    let colourless = c1 * c2 == 0.0;
    let turn = if colourless { 0.0 } else { (h2 - h1 + 180.0).rem_euclid(360.0) - 180.0 };
    let hue = if colourless {
        h1 + h2
    } else if (h1 - h2).abs() <= 180.0 {
        0.5 * (h1 + h2)
    } else if h1 + h2 < 360.0 {
        0.5 * (h1 + h2 + 360.0)
    } else {
        0.5 * (h1 + h2 - 360.0)
    };
    let (light, chroma) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(hue - 30.0) + 0.24 * cos(2.0 * hue) + 0.32 * cos(3.0 * hue + 6.0)
        - 0.20 * cos(4.0 * hue - 63.0);
    let off = (light - 50.0).powi(2);
    let (sl, sc, sh) = (1.0 + 0.015 * off / (20.0 + off).sqrt(), 1.0 + 0.045 * chroma, 1.0 + 0.015 * chroma * t);
    let turned = 60.0 * (-((hue - 275.0) / 25.0).powi(2)).exp();
    let rotation = -turned.to_radians().sin() * 2.0 * seventh(chroma);
    let (dl, dc, dh) = ((l2 - l1) / sl, (c2 - c1) / sc, 2.0 * (c1 * c2).sqrt() * (0.5 * turn).to_radians().sin() / sh);
    (dl * dl + dc * dc + dh * dh + rotation * dc * dh).max(0.0).sqrt()
}

/// Returns ΔE₀₀ of every pixel of two linear pictures that are displayed with the same `exposure` and `tonemap`. Fails if the sizes differ.
pub fn delta_e_map(a: &RgbImage, b: &RgbImage, exposure: f32, tonemap: Tonemap) -> Result<Vec<f64>, MapFault> {
    same_size("the reference is", size_of(a), "the test", size_of(b))?;
    let shown = |color: &[f32; 3]| lab(tonemap.display(color.map(|c| c * exposure)).map(f64::from));
    Ok(a.texels.iter().zip(&b.texels).map(|(a, b)| delta_e_2000(shown(a), shown(b))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks pairs of the paper's table 1, including pairs that detect a wrong hue mean or rotation.
    #[test]
    fn agrees_with_the_published_pairs() {
        for (a, b, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [50.0, 3.1736, 0.5854], 1.0),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
        ] {
            for (a, b) in [(a, b), (b, a)] {
                let found = delta_e_2000(a, b);
                assert!((found - expected).abs() < 6e-5, "{a:?} {b:?}: {found} instead of {expected}");
            }
        }
    }

    #[test]
    fn pictures_are_compared_as_displayed() {
        let picture = |grey: f32| RgbImage { width: 2, height: 1, texels: vec![[0.1, 0.2, 0.3], [grey; 3]] };
        let map = |a: f32, b: f32, exposure| delta_e_map(&picture(a), &picture(b), exposure, Tonemap::Clamp).unwrap();
        let grey = |value: f64| lab([value; 3]);
        let found = map(0.25, 0.125, 2.0);
        assert!(found[0] == 0.0 && (found[1] - delta_e_2000(grey(0.5), grey(0.25))).abs() < 1e-9, "{found:?}");
        // Both are white on the display.
        assert_eq!(map(0.7, 0.9, 2.0), [0.0; 2]);
        assert!(
            delta_e_map(&picture(0.0), &RgbImage { width: 1, height: 2, ..picture(0.0) }, 1.0, Tonemap::Clamp).is_err()
        );
    }

    #[test]
    fn white_and_black_have_no_hue() {
        let [l, a, b] = lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-4 && a.abs() < 1e-3 && b.abs() < 1e-3, "{l} {a} {b}");
        assert!((lab([0.0; 3])[0]).abs() < 1e-9);
        assert_eq!(delta_e_2000(lab([0.2, 0.3, 0.4]), lab([0.2, 0.3, 0.4])), 0.0);
    }
}
