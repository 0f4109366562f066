//! Draws polar plots of rough specular reflection in the plane of incidence. The example needs no GPU.
//!
//! ```sh
//! cargo run --example 04_plot_a_lobe -- 50      # degrees of the view from the normal; writes out/lobes.png
//! ```

use leadr::maps::Rgb8Image;
use leadr::maps::save::save_png_srgb8;
use leadr::reflectance::facets::beckmann::Beckmann;
use leadr::reflectance::facets::fresnel::Fresnel;
use leadr::reflectance::facets::ggx::Ggx;
use leadr::reflectance::facets::slope_distribution::SlopeDistribution;
use leadr::reflectance::masking::variants::Masking;
use leadr::reflectance::materials::brdf::Brdf;
use leadr::reflectance::materials::lambert::Lambert;
use leadr::reflectance::materials::microfacet::Microfacet;

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

const WIDTH: u32 = 1200;
const HEIGHT: u32 = 620;
/// The centre of the plot, and the radius of its outer circle, in pixels.
const CENTRE: DVec2 = DVec2::new(600.0, 560.0);
const RADIUS: f64 = 520.0;

fn mirror<D: SlopeDistribution + 'static>(distribution: D, masking: Masking) -> Box<dyn Brdf> {
    Box::new(Microfacet { distribution, masking, fresnel: Fresnel::Ideal })
}

/// Returns the direction at `angle` from the normal, in the plane of incidence.
fn direction(angle: f64) -> DVec3 {
    DVec3::new(angle.sin(), 0.0, angle.cos())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let view: f64 = std::env::args().nth(1).map_or(Ok(50.0), |degrees| degrees.parse())?;
    let wo = direction(-view.to_radians());
    let sigma = 0.25;
    let s = DVec3::new(sigma * sigma, sigma * sigma, 0.0);
    // The α of GGX is √2 times the σ of the Gaussian that has the same density at the peak.
    let central = |m: f64| Beckmann::new(DVec2::new(m, 0.0), s);
    let ggx = Ggx::new(DVec2::ZERO, 2.0 * s);
    let lobes: [(&str, [u8; 3], Box<dyn Brdf>); 6] = [
        ("Beckmann", [230, 80, 60], mirror(central(0.0), Masking::SmithCorrelated)),
        ("GGX", [240, 170, 50], mirror(ggx, Masking::SmithCorrelated)),
        ("Beckmann, V-grooves", [160, 90, 220], mirror(central(0.0), Masking::VGroove)),
        ("Beckmann, mean slope +0.25", [60, 140, 240], mirror(central(0.25), Masking::SmithCorrelated)),
        ("Beckmann, mean slope -0.25", [60, 190, 110], mirror(central(-0.25), Masking::SmithCorrelated)),
        ("Lambert", [150, 150, 150], Box::new(Lambert { albedo: DVec3::ONE })),
    ];

    // The radiance by angle, in steps of a quarter of a degree. The range includes directions below the horizon, where steep facets
    // reflect.
    let curves: Vec<Vec<f64>> = lobes
        .iter()
        .map(|(_, _, brdf)| (-480..=480).map(|i| brdf.eval_cos(wo, direction(f64::from(i) / 480.0 * 2.0)).x).collect())
        .collect();
    let top = curves.iter().flatten().fold(0.0f64, |a, &b| a.max(b));
    for ((name, color, _), curve) in lobes.iter().zip(&curves) {
        let (at, peak) = curve.iter().enumerate().fold((0, 0.0), |a, (i, &v)| if v > a.1 { (i, v) } else { a });
        let degrees = ((at as f64 - 480.0) / 480.0 * 2.0).to_degrees();
        let mean: f64 = curve.iter().sum::<f64>() / curve.len() as f64;
        println!("{name:<27} #{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
        println!("    peak {peak:.3} at {degrees:+.1} degrees, mean over the plane {mean:.3}");
    }

    let mut image = Rgb8Image { width: WIDTH, height: HEIGHT, texels: vec![[250; 3]; (WIDTH * HEIGHT) as usize] };
    grid(&mut image);
    stroke(&mut image, [CENTRE, CENTRE + RADIUS * DVec2::new(wo.x, -wo.z)].into_iter(), [40; 3], 2.5);
    for ((_, color, _), curve) in lobes.iter().zip(&curves) {
        let points = curve.iter().enumerate().map(|(i, value)| {
            let angle = (i as f64 - 480.0) / 480.0 * 2.0;
            CENTRE + value / top * RADIUS * DVec2::new(angle.sin(), -angle.cos())
        });
        stroke(&mut image, points, *color, 2.0);
    }
    std::fs::create_dir_all("out")?;
    save_png_srgb8("out/lobes.png", &image)?;
    println!("out/lobes.png: the black line is the view, the outer circle {top:.3} per steradian");
    Ok(())
}

/// Draws the horizon, four circles, and a line every 15 degrees.
fn grid(image: &mut Rgb8Image) {
    for ring in 1..=4 {
        let r = RADIUS * f64::from(ring) / 4.0;
        let points = (0..=360).map(|i| CENTRE + r * DVec2::from_angle(f64::from(i) / 360.0 * TAU));
        stroke(image, points, [225; 3], 1.0);
    }
    for i in 0..=12 {
        let angle = f64::from(i) / 12.0 * 2.0 * FRAC_PI_2;
        stroke(image, [CENTRE, CENTRE - RADIUS * DVec2::from_angle(angle)].into_iter(), [225; 3], 1.0);
    }
    let ends = [DVec2::new(0.0, CENTRE.y), DVec2::new(f64::from(WIDTH), CENTRE.y)];
    stroke(image, ends.into_iter(), [120; 3], 1.5);
}

/// Draws a smooth line through `points` that is `width` pixels wide.
fn stroke(image: &mut Rgb8Image, points: impl Iterator<Item = DVec2>, color: [u8; 3], width: f64) {
    let mut cover = vec![0.0f64; image.texels.len()];
    let mut last: Option<DVec2> = None;
    for point in points {
        let from = last.replace(point).unwrap_or(point);
        let (low, high) = (from.min(point) - width - 1.0, from.max(point) + width + 1.0);
        let clamp = |v: f64, end: u32| v.clamp(0.0, f64::from(end)) as u32;
        for y in clamp(low.y, HEIGHT)..clamp(high.y, HEIGHT) {
            for x in clamp(low.x, WIDTH)..clamp(high.x, WIDTH) {
                let (p, d) = (DVec2::new(f64::from(x), f64::from(y)) + 0.5 - from, point - from);
                let along = (p.dot(d) / d.length_squared().max(1e-9)).clamp(0.0, 1.0);
                let inside = (0.5 * width + 0.5 - (p - along * d).length()).clamp(0.0, 1.0);
                let texel = &mut cover[(y * WIDTH + x) as usize];
                *texel = texel.max(inside);
            }
        }
    }
    for (texel, cover) in image.texels.iter_mut().zip(cover) {
        for (channel, ink) in texel.iter_mut().zip(color) {
            *channel = (f64::from(*channel) * (1.0 - cover) + f64::from(ink) * cover).round() as u8;
        }
    }
}
