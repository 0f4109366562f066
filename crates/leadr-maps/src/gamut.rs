//! Conversion of linear colours to Rec.709 with a D65 white.

use glam::{DMat3, DVec3};

/// The matrix from CIE XYZ to linear Rec.709 (D65). The rows of the matrix are R, G and B.
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];
/// The matrix from CIE XYZ to the cone responses of Bradford.
const BRADFORD: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
/// The largest difference of a chromaticity that counts as rounding.
const ROUNDING: f64 = 1e-3;

/// The chromaticities (CIE x and y) of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gamut(pub [[f64; 2]; 4]);

/// The gamut of most displays, and of all colours in this program.
pub(crate) const REC709: Gamut = Gamut([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);
/// The gamut of ACES containers (AP0).
pub(crate) const ACES: Gamut = Gamut([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]]);

/// The gamut of most renderers for film (AP1).
const ACESCG: Gamut = Gamut([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]]);
const REC2020: Gamut = Gamut([[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]]);
const P3_D65: Gamut = Gamut([[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], [0.3127, 0.329]]);

/// A conversion of colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conversion(DMat3);

impl Conversion {
    /// Returns the conversion from CIE XYZ to Rec.709.
    pub fn from_xyz() -> Self {
        Self(rows(RGB_FROM_XYZ))
    }

    /// Converts a colour. Colours outside Rec.709 have negative channels, which become 0. NaN is kept.
    pub fn apply(&self, color: [f32; 3]) -> [f32; 3] {
        let converted = self.0 * DVec3::from(color.map(f64::from));
        converted.to_array().map(|v| if v < 0.0 { 0.0 } else { v as f32 })
    }
}

/// Linear colour spaces other than Rec.709 by their names in OpenImageIO, OpenColorIO and the Color Interop Forum.
const NAMED: [(&[&str], Gamut); 4] = [
    (&["acescg", "lin_ap1", "lin_ap1_scene", "aces - acescg"], ACESCG),
    (&["aces2065-1", "lin_ap0", "lin_ap0_scene", "aces - aces2065-1"], ACES),
    (&["lin_rec2020", "lin_rec2020_scene", "linear rec.2020"], REC2020),
    (&["lin_p3d65", "lin_p3d65_scene", "lin_displayp3", "linear p3-d65"], P3_D65),
];

impl Gamut {
    /// Returns the primaries of a linear colour space with this name, unless they are unknown or those of Rec.709.
    pub fn named(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_lowercase();
        NAMED.iter().find(|(names, _)| names.contains(&name.as_str())).map(|(_, gamut)| *gamut)
    }

    /// Returns the conversion to Rec.709, with Bradford adaptation between the whites. Returns `Ok(None)` for Rec.709 itself,
    /// and `Err` if the chromaticities span no gamut.
    pub fn conversion(&self) -> Result<Option<Conversion>, ()> {
        let pairs = self.0.as_flattened().iter().zip(REC709.0.as_flattened());
        if pairs.clone().all(|(own, other)| (own - other).abs() < ROUNDING) {
            return Ok(None);
        }
        let [red, green, blue, white] = self.0.map(|[x, y]| DVec3::new(x, y, 1.0 - x - y));
        let primaries = DMat3::from_cols(red, green, blue);
        let cones = rows(BRADFORD);
        let from_xyz = rows(RGB_FROM_XYZ);
        let own_white = white / white.y;
        let scale = primaries.inverse() * own_white;
        let target_white = from_xyz.inverse() * DVec3::ONE;
        let adaptation = cones.inverse() * DMat3::from_diagonal((cones * target_white) / (cones * own_white)) * cones;
        let matrix = from_xyz * adaptation * primaries * DMat3::from_diagonal(scale);
        let sound = primaries.determinant().abs() > 1e-4 && white.y > 0.01 && matrix.is_finite();
        if sound { Ok(Some(Conversion(matrix))) } else { Err(()) }
    }
}

fn rows(matrix: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&matrix).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamuts_become_rec709() {
        assert_eq!(REC709.conversion(), Ok(None));
        let acescg = Gamut::named("ACEScg").unwrap();
        // The matrix of the ACES project from AP1 to Rec.709 (Bradford).
        let published = [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]];
        let Conversion(found) = acescg.conversion().unwrap().unwrap();
        for (row, expected) in found.transpose().to_cols_array_2d().iter().zip(published) {
            for (value, expected) in row.iter().zip(expected) {
                assert!((value - expected).abs() < 2e-3, "{value} instead of {expected}");
            }
        }
        for gamut in [acescg, ACES, REC2020, P3_D65] {
            let white = gamut.conversion().unwrap().unwrap().apply([0.5; 3]);
            assert!(white.iter().all(|v| (v - 0.5).abs() < 1e-5), "{white:?}");
        }
        // Pure green of ACEScg lies outside Rec.709.
        assert_eq!(acescg.conversion().unwrap().unwrap().apply([0.0, 1.0, 0.0])[0], 0.0);
        assert!(acescg.conversion().unwrap().unwrap().apply([f32::NAN; 3]).iter().all(|v| v.is_nan()));
    }

    #[test]
    fn chromaticities_without_an_area_are_refused() {
        for gamut in
            [[[0.0; 2]; 4], [[0.3127, 0.329]; 4], [[f64::NAN; 2]; 4], [[0.6, 0.3], [0.3, 0.6], [0.1, 0.1], [0.3, 0.0]]]
        {
            assert_eq!(Gamut(gamut).conversion(), Err(()), "{gamut:?}");
        }
    }
}
