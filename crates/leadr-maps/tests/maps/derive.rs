//! Tests of derived maps on scans. Heights from normals are compared with the curl, and occlusion and cones with rays.

use std::path::PathBuf;

use glam::DVec3;

use leadr_maps::derive::{
    About, Difference, Integration, Occlusion, Slopes, VisibilityMap, heights_of_slopes, slopes_of_heights, visibility,
};
use leadr_maps::material::{Encoding, NormalMap, Texture, green_axis};
use leadr_maps::{HeightMap, Wrap, load_height_map, load_raster};
use leadr_reflectance::masking::occlusion::{Cone, cone_light};
use leadr_testing::height_rays::HeightRays;
use leadr_testing::shared::shared_data;
use rayon::prelude::*;

/// Returns the files of the scanned materials whose names have this ending.
fn files(end: &str) -> Vec<PathBuf> {
    let Some(folder) = shared_data("displacement") else { return Vec::new() };
    let folders = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = folders.flat_map(|folder| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    let mut files: Vec<PathBuf> = files.filter(|file| file.to_string_lossy().ends_with(end)).collect();
    files.sort();
    files
}

/// Returns the heights, and the factor for which their slopes have a standard deviation of 0.5.
fn scaled(file: &PathBuf) -> (HeightMap, f32) {
    let map = load_height_map(file).unwrap();
    let slopes = slopes_of_heights(&map, 1.0, Wrap::Repeat, Difference::Triangles);
    let square: f64 = slopes.texels().iter().flatten().map(|&v| f64::from(v).powi(2)).sum();
    let rms = (0.5 * square / slopes.texels().len() as f64).sqrt();
    (map, (0.5 / rms) as f32)
}

/// Returns the angle in degrees between the slopes and the slopes of their integrated heights, and the fraction of curl.
fn round_trip(slopes: &Slopes, smoothness: f64) -> [f64; 2] {
    let how = Integration { smoothness, ..Integration::default() };
    let found = heights_of_slopes(slopes, &how, &|_| {}).unwrap();
    let again = slopes_of_heights(&found.heights, 1.0, how.wrap, how.difference);
    let mean = found.mean_slope.map(|v| v as f32);
    let texels = again.texels().iter().map(|s| [s[0] + mean[0], s[1] + mean[1]]).collect();
    let [width, height] = slopes.size();
    [slopes.angle_to(&Slopes::new(width, height, texels).unwrap()), found.curl_share()]
}

#[test]
fn slopes_of_scanned_heights_come_back() {
    for file in files("Displacement.png") {
        let (map, scale) = scaled(&file);
        let slopes = slopes_of_heights(&map, scale, Wrap::Repeat, Difference::Triangles);
        let [[exact, curl], [near, _]] = [0.0, 0.01].map(|smoothness| round_trip(&slopes, smoothness));
        println!("{}: {exact:.4} degrees, {near:.3} at smoothness 0.01, curl {curl:.1e}", file.display());
        assert!(exact < 0.01 && near < 1.0 && curl < 1e-6, "{}: {exact} {near} {curl}", file.display());
    }
}

#[test]
fn scanned_normals_leave_their_curl_alone() {
    for file in files("NormalGL.png") {
        let raster = load_raster(&file).unwrap();
        let green = green_axis(&raster);
        let map = NormalMap { texture: Texture::new(raster, "normals", Encoding::Linear), green, scale: 1.0 };
        let slopes = Slopes::of_normal_map(&map).unwrap();
        let [degrees, curl] = round_trip(&slopes, 0.0);
        println!("{}: {degrees:.3} degrees, curl {:.3} %", file.display(), 100.0 * curl);
        // The curl alone causes errors of 1.34 and 2.50 degrees.
        assert!(degrees < 2.6 && (0.002..0.005).contains(&curl), "{}: {degrees} {curl}", file.display());
        // Smooth heights match the scan's displacement map after the best scaling.
        let how = Integration { smoothness: 1.0, ..Integration::default() };
        let found = heights_of_slopes(&slopes, &how, &|_| {}).unwrap().heights;
        let scan = load_height_map(file.to_string_lossy().replace("NormalGL", "Displacement")).unwrap();
        let mean = scan.mean();
        let sums = found.texels.iter().zip(&scan.texels).fold([0.0; 3], |s, (a, b)| {
            let (a, b) = (f64::from(*a), f64::from(b - mean));
            [s[0] + a * a, s[1] + a * b, s[2] + b * b]
        });
        let left = (1.0 - sums[1] * sums[1] / (sums[0] * sums[2])).sqrt();
        assert!(sums[1] > 0.0 && left < 0.08, "{}: {left} of the scan's heights", file.display());
    }
}

/// Returns texels that two irrational steps spread over a map.
fn spread(map: &HeightMap, count: u32) -> Vec<[u32; 2]> {
    let part = |i: u32, step: f64, of: u32| ((f64::from(i) * step).fract() * f64::from(of)) as u32;
    (0..count).map(|i| [part(i, 0.754_877_666, map.width), part(i, 0.569_840_291, map.height)]).collect()
}

fn normal_of(slopes: &Slopes, [x, y]: [u32; 2]) -> [f64; 3] {
    let [s, t] = slopes.texels()[(y * slopes.size()[0] + x) as usize].map(f64::from);
    let length = (1.0 + s * s + t * t).sqrt();
    [-s / length, -t / length, 1.0 / length]
}

/// Returns the RMS error of a map's visibility compared with rays.
fn error(found: &VisibilityMap, texels: &[[u32; 2]], truth: &[f64]) -> f64 {
    let at = |[x, y]: [u32; 2]| f64::from(found.visibility[(y * found.width + x) as usize]);
    let sum: f64 = texels.iter().zip(truth).map(|(&texel, truth)| (at(texel) - truth).powi(2)).sum();
    (sum / texels.len() as f64).sqrt()
}

#[test]
#[ignore = "long"]
fn occlusion_and_cones_match_ray_casts() {
    for file in files("Displacement.png") {
        let (map, scale) = scaled(&file);
        let slopes = slopes_of_heights(&map, scale, Wrap::Repeat, Difference::Triangles);
        let rays = HeightRays::new(&map, scale, Wrap::Repeat);
        let texels = spread(&map, 500);
        let seen = |normal: fn(&Slopes, [u32; 2]) -> [f64; 3]| -> Vec<f64> {
            texels.par_iter().map(|&[x, y]| rays.visibility(x, y, normal(&slopes, [x, y]), 20)).collect()
        };
        let (surface, flat) = (seen(normal_of), seen(|_, _| [0.0, 0.0, 1.0]));
        let of = |about| visibility(&map, scale, &Occlusion { about, ..Occlusion::default() }, &|_| {}).unwrap();
        let found = of(About::Surface);
        let errors = [error(&found, &texels, &surface), error(&of(About::Flat), &texels, &flat)];
        // The comparison must fail for the other hemisphere, and for a neighbouring texel.
        let aside: Vec<[u32; 2]> = texels.iter().map(|&[x, y]| [(x + 3) % map.width, y]).collect();
        assert!(error(&found, &aside, &surface) > 2.0 * errors[0] && error(&found, &texels, &flat) > 1.5 * errors[1]);
        println!("{}: visibility off by {errors:.4?}", file.display());
        assert!(errors.iter().all(|&error| error < 0.01), "{}: {errors:?}", file.display());
        // A limited distance is compared with rays of that length.
        let mut distances = Vec::new();
        for distance in [0.005, 0.02, 0.1, 0.5] {
            let rays = HeightRays::within(&map, scale, Wrap::Repeat, f64::from(distance));
            let seen: Vec<f64> =
                texels.par_iter().map(|&[x, y]| rays.visibility(x, y, normal_of(&slopes, [x, y]), 20)).collect();
            let found = visibility(&map, scale, &Occlusion { distance, ..Occlusion::default() }, &|_| {}).unwrap();
            distances.push([error(&found, &texels, &seen), error(&found, &texels, &surface)]);
        }
        println!("{}: at distances off by {distances:.4?}", file.display());
        assert!(distances.iter().all(|[error, _]| *error < 0.013), "{}: {distances:?}", file.display());
        // The comparison must fail for rays of unlimited length.
        assert!(distances[0][1] > 2.0 * distances[0][0], "{}: {distances:?}", file.display());
        // A low sun tests cones about the normal and about the mean free direction.
        let mut wrong = [0u32; 2];
        for &[x, y] in &texels {
            let normal = normal_of(&slopes, [x, y]);
            let visible = f64::from(found.visibility[(y * map.width + x) as usize]);
            let cones = [
                Cone::about_normal(DVec3::from_array(normal), visible),
                Cone::of_vector(found.at(x, y).map(f64::from).into()),
            ];
            for k in 0..12 {
                let (elevation, azimuth) = ([15f64, 30.0, 45.0][k % 3].to_radians(), 0.3 + k as f64 * 0.52);
                let r = elevation.cos();
                let sun = [r * azimuth.cos(), r * azimuth.sin(), elevation.sin()];
                let faces = (0..3).map(|i| normal[i] * sun[i]).sum::<f64>() > 0.0;
                let lit = faces && rays.is_free(x, y, sun);
                cones.iter().zip(&mut wrong).for_each(|(cone, wrong)| {
                    *wrong += u32::from((faces && (cone_light(cone, sun.into()) > 0.0)) != lit)
                });
            }
        }
        let share = wrong.map(|count| f64::from(count) / (12.0 * texels.len() as f64));
        println!("{}: cones are wrong about the sun for {share:.3?} of the texels", file.display());
        assert!(share[1] < 0.12 && share[1] < 0.6 * share[0], "{}: {share:?}", file.display());
    }
}
