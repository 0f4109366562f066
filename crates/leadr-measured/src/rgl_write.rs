//! Writes files of the RGL database ([`super::rgl`]), which the `measured` materials of Mitsuba 3 and pbrt-v4 read.
//!
//! The table of a file is a ratio to the facets of the file, so it is smooth where the facets contain all narrow parts of the material. The
//! facets are those of the fit plus a constant, which stands for the diffuse base:
//!
//! ```text
//! D'(m) = D(m) + k,   σ'(w) = σ(w) + k ∫ max(0, w·m) dm,   value = f_r cos θ_o · 4 σ'/D'
//! ```
//!
//! The constant is chosen so that specular and diffuse part have values of about the same size at normal incidence.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::rgl::{Grid, MAGIC, Warp};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::fitted::FittedBrdf;

/// The number of values along an axis of the unit square.
const SIDE: usize = 48;
/// The number of angles of the facets in a file.
const FACETS: usize = 256;
/// The number of angles and azimuths of the visible normals for each direction of the light.
const NORMALS: usize = 128;
/// The number of angles of the light, which are dense where reflectances change most.
const ANGLES: usize = 16;
/// The number of azimuths of the light for an anisotropic material.
const AZIMUTHS: usize = 16;

/// The smallest cosine of a direction in the table.
const HORIZON: f64 = 1e-3;

/// The wavelengths of the spectra, in nanometres. Renderers extend the first and the last value.
const WAVELENGTHS: [f32; 16] =
    [400., 420., 440., 460., 480., 500., 520., 540., 560., 580., 600., 620., 640., 660., 680., 700.];

/// The fraction of green and of blue in the spectra of linear Rec.709 red, green and blue, which sum to one. Among all reflectances from 0 to 1
/// that have exactly these colours under the illuminant D65 (CIE 1931), these have the smallest curvature.
const GREEN: [f32; 16] = [0., 0., 0., 0., 0.25748, 0.75077, 1., 1., 1., 0.78922, 0.20421, 0., 0., 0., 0., 0.];
const BLUE: [f32; 16] =
    [0.80912, 0.90406, 0.98916, 1., 0.74252, 0.24923, 0., 0., 0., 0.07294, 0.00191, 0., 0., 0., 0., 0.];

/// An array of a tensor file.
enum Array {
    Bytes(Vec<u8>),
    Floats(Vec<u64>, Vec<f32>),
}

fn tensor_file(arrays: &[(&str, Array)]) -> Vec<u8> {
    let shape = |array: &Array| match array {
        Array::Bytes(bytes) => vec![bytes.len() as u64],
        Array::Floats(shape, _) => shape.clone(),
    };
    let mut head = MAGIC.to_vec();
    head.extend([1, 0]);
    head.extend((arrays.len() as u32).to_le_bytes());
    let header = |(name, array): &(&str, Array)| 2 + name.len() + 2 + 1 + 8 + 8 * shape(array).len();
    // Arrays start at multiples of eight bytes.
    let mut offset = (head.len() + arrays.iter().map(header).sum::<usize>()).next_multiple_of(8);
    let start = offset;
    let mut body = Vec::new();
    for (name, array) in arrays {
        let (kind, mut bytes) = match array {
            Array::Bytes(bytes) => (1, bytes.clone()),
            Array::Floats(_, values) => (10, values.iter().flat_map(|v| v.to_le_bytes()).collect()),
        };
        head.extend((name.len() as u16).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((shape(array).len() as u16).to_le_bytes());
        head.push(kind);
        head.extend((offset as u64).to_le_bytes());
        shape(array).iter().for_each(|n| head.extend(n.to_le_bytes()));
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        offset += bytes.len();
        body.extend(bytes);
    }
    head.resize(start, 0);
    head.extend(body);
    head
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Returns the normal at a point of the unit square, for light of azimuth `phi`.
fn normal(at: DVec2, phi: f64) -> DVec3 {
    direction(at.x * at.x * FRAC_PI_2, (2.0 * at.y - 1.0) * PI + phi)
}

/// Returns the values of a function over a grid of the unit square.
fn grid(width: usize, height: usize, f: impl Fn(DVec2) -> f64) -> Grid {
    let step = DVec2::new((width - 1) as f64, (height - 1) as f64);
    let at = |i: usize| DVec2::new((i % width) as f64, (i / width) as f64) / step;
    Grid { width, values: (0..width * height).map(|i| f(at(i)) as f32).collect() }
}

/// Returns the point of the unit square in front of which a share of the visible normals lies, along θ and φ.
fn point_of_share(warp: &Warp, share: DVec2) -> DVec2 {
    const HALVINGS: usize = 30;
    let solved = |goal: f64, f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if f(middle) < goal { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let y = solved(share.y, &|y| warp.shares(DVec2::new(0.5, y)).x);
    let x = solved(share.x, &|x| {
        let [_, before, row] = warp.shares(DVec2::new(x, y)).to_array();
        before / row.max(1e-30)
    });
    DVec2::new(x, y)
}

/// Returns the content of a `.bsdf` file of a material, with the values of an isotropic or an anisotropic table.
pub(super) fn write<D: SlopeDistribution>(brdf: &FittedBrdf<D>, isotropic: bool, description: &str) -> Vec<u8> {
    let facets = &brdf.facets.distribution;
    let fresnel = brdf.facets.fresnel.at(1.0).max_element().max(1e-3);
    let floor = 4.0 / PI * brdf.diffuse.max_element() / fresnel + 1e-4 * facets.ndf(DVec3::Z);
    let azimuths: Vec<f64> =
        if isotropic { vec![0.0] } else { (0..=AZIMUTHS).map(|i| TAU * i as f64 / AZIMUTHS as f64 - PI).collect() };
    let angles: Vec<f64> =
        (0..ANGLES).map(|i| FRAC_PI_2 * (i as f64 / (ANGLES - 1) as f64).sqrt().min(0.9999)).collect();
    let rows = if isotropic { 2 } else { NORMALS };
    let ndf = grid(FACETS, rows, |at| facets.ndf(normal(at, 0.0)) + floor);
    let sigma = grid(FACETS, rows, |at| {
        let w = normal(at, 0.0);
        facets.visible_area(w) + floor * FRAC_PI_2 * (1.0 + w.z)
    });
    let (mut vndf, mut rgb, mut spectra, mut luminance) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for &phi in &azimuths {
        for &theta in &angles {
            let wi = direction(theta, phi);
            let turn = if isotropic { phi } else { 0.0 };
            let visible = grid(NORMALS, NORMALS, |at| {
                let m = normal(at, turn);
                let jacobian = at.x * (at.x * at.x * FRAC_PI_2).sin();
                (facets.ndf(m) + floor) * wi.dot(m).max(0.0) * jacobian
            });
            vndf.extend_from_slice(&visible.values);
            let warp = Warp::new(visible);
            let cell = DVec2::new((theta / FRAC_PI_2).sqrt(), (phi + PI) / TAU);
            let values: Vec<DVec3> = (0..SIDE * SIDE)
                .map(|i| {
                    let share = DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) / (SIDE - 1) as f64;
                    let to_m = point_of_share(&warp, share);
                    let m = normal(to_m, turn);
                    let mirrored = 2.0 * wi.dot(m).max(0.0) * m - wi;
                    // Below the horizon, the table continues the values at the horizon.
                    let wo = DVec3::new(mirrored.x, mirrored.y, mirrored.z.max(HORIZON)).normalize();
                    let density = if mirrored.z < HORIZON {
                        facets.ndf((wi + wo).normalize_or(DVec3::Z)) + floor
                    } else {
                        ndf.at(to_m)
                    };
                    brdf.eval_cos(wi, wo) * (4.0 * sigma.at(cell) / density)
                })
                .collect();
            (0..3).for_each(|c| rgb.extend(values.iter().map(|v| v[c] as f32)));
            for (green, blue) in GREEN.iter().zip(BLUE) {
                let weights = DVec3::new(f64::from(1.0 - green - blue), f64::from(*green), f64::from(blue));
                spectra.extend(values.iter().map(|v| v.dot(weights) as f32));
            }
            luminance.extend(values.iter().map(|v| v.dot(DVec3::new(0.2126, 0.7152, 0.0722)).max(1e-6) as f32));
        }
    }
    let [p, t, n] = [azimuths.len(), angles.len(), SIDE].map(|n| n as u64);
    let of_facets = vec![rows as u64, FACETS as u64];
    let floats = |values: Vec<f64>| values.into_iter().map(|v| v as f32).collect::<Vec<f32>>();
    tensor_file(&[
        ("description", Array::Bytes(description.as_bytes().to_vec())),
        ("phi_i", Array::Floats(vec![p], floats(azimuths))),
        ("theta_i", Array::Floats(vec![t], floats(angles))),
        ("sigma", Array::Floats(of_facets.clone(), sigma.values)),
        ("ndf", Array::Floats(of_facets, ndf.values)),
        ("vndf", Array::Floats(vec![p, t, NORMALS as u64, NORMALS as u64], vndf)),
        ("luminance", Array::Floats(vec![p, t, n, n], luminance)),
        ("rgb", Array::Floats(vec![p, t, 3, n, n], rgb)),
        ("wavelengths", Array::Floats(vec![WAVELENGTHS.len() as u64], WAVELENGTHS.to_vec())),
        ("spectra", Array::Floats(vec![p, t, WAVELENGTHS.len() as u64, n, n], spectra)),
        ("jacobian", Array::Bytes(vec![1])),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::rgl::Rgl;
    use super::*;
    use leadr_reflectance::facets::beckmann::Beckmann;
    use leadr_reflectance::facets::fresnel::Fresnel;
    use leadr_reflectance::facets::ggx::Ggx;
    use leadr_reflectance::masking::variants::Masking;
    use leadr_reflectance::materials::microfacet::Microfacet;
    use leadr_reflectance::random::Random;

    /// Returns the relative root mean square error of a material that is written and read back, weighted by cosines. Light and viewer are up
    /// to 80° from the normal.
    fn error<D: SlopeDistribution>(brdf: &FittedBrdf<D>, isotropic: bool) -> f64 {
        let read = Rgl::read(&write(brdf, isotropic, "a test")).unwrap();
        assert_eq!((read.description(), read.is_isotropic()), ("a test", isotropic));
        let mut random = Random::stream(3, 1);
        let (mut wrong, mut all) = (0.0, 0.0);
        for i in 0..20_000 {
            let mut above = || direction(1.4 * random.unit(), TAU * random.unit());
            let (wi, mut wo) = (above(), above());
            if i % 2 == 0 {
                // Half of the directions lie in the lobe.
                let Some(sample) = brdf.facets.sample(wi, DVec2::new(random.unit(), random.unit())) else { continue };
                wo = sample.wi;
            }
            if wo.z < 0.17 {
                continue;
            }
            let (found, truth) = (read.value(wo, wi) * wo.z, brdf.eval_cos(wi, wo));
            // Values of a narrow lobe do not dominate.
            let per = 1.0 / (0.05 + truth.element_sum());
            wrong += ((found - truth) * per).length_squared();
            all += (truth * per).length_squared();
        }
        (wrong / all).sqrt()
    }

    #[test]
    fn materials_come_back() {
        let fresnel = Fresnel::Schlick(DVec3::new(0.9, 0.6, 0.3));
        let masking = Masking::SmithCorrelated;
        let ggx = |alpha: f64| {
            let distribution = Ggx::new(DVec2::ZERO, DVec3::new(alpha * alpha, alpha * alpha, 0.0));
            Microfacet { distribution, masking, fresnel: fresnel.clone() }
        };
        for (alpha, diffuse, most) in [(0.1, 0.0, 0.02), (0.4, 0.0, 0.02), (0.2, 0.5, 0.02)] {
            let brdf = FittedBrdf { facets: ggx(alpha), diffuse: DVec3::new(1.0, 0.5, 0.2) * diffuse };
            let wrong = error(&brdf, true);
            println!("GGX {alpha} on {diffuse}: {wrong:.4}");
            assert!(wrong < most, "{alpha} {diffuse}: {wrong}");
        }
        let distribution = Beckmann::new(DVec2::ZERO, DVec3::new(0.05, 0.01, 0.01));
        let brdf = FittedBrdf { facets: Microfacet { distribution, masking, fresnel }, diffuse: DVec3::splat(0.2) };
        let wrong = error(&brdf, false);
        println!("anisotropic: {wrong:.4}");
        // The table is interpolated between azimuths.
        assert!(wrong < 0.1, "{wrong}");
    }

    #[test]
    fn spectra_are_sums_of_primaries() {
        for (green, blue) in GREEN.iter().zip(BLUE) {
            assert!(*green >= 0.0 && blue >= 0.0 && green + blue <= 1.00001);
        }
        assert_eq!((GREEN[7], BLUE[3], GREEN[15] + BLUE[15]), (1.0, 1.0, 0.0));
    }
}
