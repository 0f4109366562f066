//! Measures the quality and the speed of derived maps: heights from normals, occlusion from heights, and visibility cones.
//!
//! ```sh
//! cargo run --release --no-default-features --example 21_derived_maps -- MAP.png …     # file names with "normal" are normal maps
//! cargo run --release --no-default-features --example 21_derived_maps -- --speed 4096  # a noise map with this many texels per side
//! ```
//!
//! Height maps without normals are scaled to a slope standard deviation of 0.5.

use std::path::Path;
use std::time::Instant;

use leadr::maps::derive::{
    About, Difference, Integration, Occlusion, SLICES, Slopes, heights_of_slopes, slopes_of_heights, visibility,
};
use leadr::maps::material::{Encoding, NormalMap, Texture, green_axis};
use leadr::maps::{HeightMap, Wrap, load_height_map, load_raster};
use leadr::reflectance::masking::occlusion::{Cone, cone_light, cone_light_smooth};
use leadr_testing::height_rays::HeightRays;
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error>;

/// The number of texels with ray casts, and the square root of the number of rays per texel.
const TEXELS: u32 = 64 * 64;
const RAYS: u32 = 24;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, side] = &arguments[..]
        && flag == "--speed"
    {
        return speed(side.parse()?);
    }
    for file in &arguments {
        let path = Path::new(file);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if name.to_lowercase().contains("normal") {
            let raster = load_raster(path)?;
            let green = green_axis(&raster);
            let map = NormalMap { texture: Texture::new(raster, "normals", Encoding::Linear), green, scale: 1.0 };
            let slopes = Slopes::of_normal_map(&map)?;
            println!("{name}: {:?}", slopes.faults);
            let other = path.with_file_name(
                path.file_name().unwrap_or_default().to_string_lossy().replace("NormalGL", "Displacement"),
            );
            let heights = integrate(&slopes, load_height_map(other).ok().as_ref())?;
            occlude(&heights, 1.0)?;
        } else {
            let map = load_height_map(path)?;
            let rms = rms(&slopes_of_heights(&map, 1.0, Wrap::Repeat, Difference::Triangles));
            let scale = (0.5 / rms.max(1e-9)) as f32;
            let slopes = slopes_of_heights(&map, scale, Wrap::Repeat, Difference::Triangles);
            println!("{name}: heights times {scale:.4} widths");
            integrate(&slopes, Some(&map))?;
            occlude(&map, scale)?;
        }
    }
    Ok(())
}

/// Returns the RMS slope over both axes.
fn rms(slopes: &Slopes) -> f64 {
    let sum: f64 = slopes.texels().iter().flatten().map(|&v| f64::from(v).powi(2)).sum();
    (0.5 * sum / slopes.texels().len() as f64).sqrt()
}

/// Returns the slopes of heights plus the mean slope, which repeating heights cannot have.
fn with_mean(heights: &HeightMap, mean: [f64; 2], difference: Difference) -> Slopes {
    let slopes = slopes_of_heights(heights, 1.0, Wrap::Repeat, difference);
    let texels = slopes.texels().iter().map(|s| [s[0] + mean[0] as f32, s[1] + mean[1] as f32]).collect();
    Slopes::new(heights.width, heights.height, texels).expect("the size is its own")
}

fn integrate(slopes: &Slopes, known: Option<&HeightMap>) -> Result<HeightMap, Failure> {
    println!(
        "  heights by                         seconds  curl, share  degrees rms  in texels: rms height, edge rms; error against the height file"
    );
    let mut kept = None;
    for (difference, smoothness) in [
        (Difference::Triangles, 0.0),
        (Difference::Triangles, 0.001),
        (Difference::Triangles, 0.01),
        (Difference::Triangles, 0.1),
        (Difference::Triangles, 1.0),
        (Difference::Central, 0.01),
        (Difference::Forward, 0.0),
    ] {
        let start = Instant::now();
        let how = Integration { wrap: Wrap::Repeat, difference, smoothness };
        let found = heights_of_slopes(slopes, &how, &|_| {})?;
        let seconds = start.elapsed().as_secs_f64();
        let degrees = slopes.angle_to(&with_mean(&found.heights, found.mean_slope, difference));
        println!(
            "  {:<34} {seconds:7.2}  {:8.4} %  {degrees:11.4}  {}",
            format!("{difference:?}, smoothness {smoothness}"),
            100.0 * found.curl_share(),
            sizes(&found.heights) + &apart(&found.heights, known)
        );
        if how == Integration::default() {
            kept = Some(found);
        }
    }
    let kept = kept.ok_or("the default is missing in the table")?;
    println!("  mean slope {:.5} {:.5}", kept.mean_slope[0], kept.mean_slope[1]);
    Ok(kept.heights)
}

/// Returns the unexplained fraction of a reference file's heights and row differences, at the scale that fits best.
fn apart(found: &HeightMap, known: Option<&HeightMap>) -> String {
    let Some(known) = known else { return String::new() };
    let left = |pairs: &[(f64, f64)]| {
        let sums = pairs.iter().fold([0.0; 3], |s, (a, b)| [s[0] + a * a, s[1] + a * b, s[2] + b * b]);
        100.0 * (1.0 - sums[1] * sums[1] / (sums[0] * sums[2]).max(1e-30)).max(0.0).sqrt()
    };
    let mean = [found, known].map(|map| f64::from(map.mean()));
    let texels = found.texels.iter().zip(&known.texels);
    let heights: Vec<_> = texels.map(|(a, b)| (f64::from(*a) - mean[0], f64::from(*b) - mean[1])).collect();
    let edges: Vec<_> = heights.windows(2).map(|p| (p[1].0 - p[0].0, p[1].1 - p[0].1)).collect();
    format!("; {:.2} %, edges {:.2} %", left(&heights), left(&edges))
}

/// Returns the RMS of the heights, and of the differences between neighbours.
fn sizes(heights: &HeightMap) -> String {
    let w = f64::from(heights.width);
    let square = |v: f64| (w * v).powi(2);
    let all: f64 = heights.texels.iter().map(|&h| square(h.into())).sum();
    let edges: f64 = heights
        .texels
        .chunks(heights.width as usize)
        .flat_map(|row| row.windows(2))
        .map(|p| square(f64::from(p[1] - p[0])))
        .sum();
    let n = heights.texels.len() as f64;
    format!("{:.3}, {:.4}", (all / n).sqrt(), (edges / n).sqrt())
}

fn occlude(heights: &HeightMap, scale: f32) -> Result<(), Failure> {
    let slopes = slopes_of_heights(heights, scale, Wrap::Repeat, Difference::Triangles);
    let rays = HeightRays::new(heights, scale, Wrap::Repeat);
    // Two irrational steps spread the texels over the map.
    let texels: Vec<[u32; 2]> = (0..TEXELS)
        .map(|i| {
            let part = |step: f64, of: u32| ((f64::from(i) * step).fract() * f64::from(of)) as u32;
            [part(0.754_877_666, heights.width), part(0.569_840_291, heights.height)]
        })
        .collect();
    let normal = |[x, y]: [u32; 2]| {
        let [s, t] = slopes.texels()[(y * heights.width + x) as usize].map(f64::from);
        [-s, -t, 1.0]
    };
    let about_normal: Vec<f64> = texels.par_iter().map(|&[x, y]| rays.visibility(x, y, normal([x, y]), RAYS)).collect();
    let about_flat: Vec<f64> = texels.par_iter().map(|&[x, y]| rays.visibility(x, y, [0.0, 0.0, 1.0], RAYS)).collect();
    println!("  visibility by                      seconds  mean    rays    rms error  bias");
    let mut kept = None;
    for (about, truth, slices) in [
        (About::Surface, &about_normal, 4),
        (About::Surface, &about_normal, SLICES),
        (About::Surface, &about_normal, 32),
        (About::Flat, &about_flat, SLICES),
    ] {
        let start = Instant::now();
        let found = visibility(heights, scale, &Occlusion { about, slices, ..Occlusion::default() }, &|_| {})?;
        let seconds = start.elapsed().as_secs_f64();
        let at = |[x, y]: [u32; 2]| f64::from(found.visibility[(y * heights.width + x) as usize]);
        let errors = || texels.iter().zip(truth).map(|(&texel, truth)| at(texel) - truth);
        let n = f64::from(TEXELS);
        println!(
            "  {:<34} {seconds:7.2}  {:.4}  {:.4}  {:9.4}  {:+.4}",
            format!("{about:?}, {slices} slices"),
            texels.iter().map(|&texel| at(texel)).sum::<f64>() / n,
            truth.iter().sum::<f64>() / n,
            (errors().map(|e| e * e).sum::<f64>() / n).sqrt(),
            errors().sum::<f64>() / n,
        );
        if about == About::Surface && slices == SLICES {
            kept = Some(found);
        }
    }
    let kept = kept.ok_or("the default is missing in the table")?;
    println!("  sun at elevation   lit    wrong: all lit   facing   cone about the normal   about b");
    for elevation in [15.0f64, 30.0, 45.0, 60.0] {
        let wrong: Vec<([u32; 5], [f64; 6])> = texels
            .par_iter()
            .map(|&[x, y]| {
                let (mut counts, mut squares) = ([0; 5], [0.0; 6]);
                let normal = normal([x, y]);
                let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
                let normal = normal.map(|v| v / length);
                let vector = kept.at(x, y);
                let seen = f64::from(kept.visibility[(y * heights.width + x) as usize]);
                let cones = [Cone::about_normal(normal.into(), seen), Cone::of_vector(vector.map(f64::from).into())];
                for k in 0..8 {
                    let azimuth = std::f64::consts::TAU * (f64::from(k) + 0.3) / 8.0;
                    let (r, z) = (elevation.to_radians().cos(), elevation.to_radians().sin());
                    let sun = [r * azimuth.cos(), r * azimuth.sin(), z];
                    let cosine = (0..3).map(|i| normal[i] * sun[i]).sum::<f64>().max(0.0);
                    let facing = cosine > 0.0;
                    let lit = facing && rays.is_free(x, y, sun);
                    // Facets that face away are dark even without a cone.
                    let guesses = [
                        true,
                        facing,
                        facing && cone_light(&cones[0], sun.into()) > 0.0,
                        facing && cone_light(&cones[1], sun.into()) > 0.0,
                    ];
                    counts[0] += u32::from(lit);
                    guesses.iter().zip(&mut counts[1..]).for_each(|(guess, count)| *count += u32::from(*guess != lit));
                    // The visible fraction of the light, in total and with hard and soft cone edges.
                    let [about_normal, about_b] = [0, 1].map(|k| cone_light_smooth(&cones[k], sun.into()));
                    let hard = [0, 1].map(|k| cone_light(&cones[k], sun.into()));
                    let shares = [1.0, hard[0], about_normal.sqrt(), about_normal, hard[1], about_b];
                    let truth = f64::from(u8::from(lit));
                    shares.iter().zip(&mut squares).for_each(|(s, sum)| *sum += (cosine * (s - truth)).powi(2));
                }
                (counts, squares)
            })
            .collect();
        let share = |i: usize| 100.0 * wrong.iter().map(|(c, _)| f64::from(c[i])).sum::<f64>() / f64::from(8 * TEXELS);
        println!(
            "  {elevation:16.0}  {:5.1}  {:14.1} % {:7.1} %  {:20.1} %  {:7.1} %",
            share(0),
            share(1),
            share(2),
            share(3),
            share(4)
        );
        let rms = |i: usize| (wrong.iter().map(|(_, s)| s[i]).sum::<f64>() / f64::from(8 * TEXELS)).sqrt();
        println!(
            "        light, rms error: no cone {:.3}; about the normal hard {:.3}, falling off once {:.3}, twice (eq. 58) {:.3}; about b {:.3}, {:.3}",
            rms(0),
            rms(1),
            rms(2),
            rms(3),
            rms(4),
            rms(5)
        );
    }
    Ok(())
}

/// Times the derivation on a map of waves of many sizes, whose slopes have a standard deviation of about 0.5.
///
/// Prints the elapsed seconds and, if available, the CPU seconds of all threads.
fn speed(side: u32) -> Result<(), Failure> {
    let waves = [(1, 3, 0.02f32), (5, -2, 0.008), (17, 23, 0.002), (71, -60, 0.0006), (301, 280, 0.00015)];
    let texel = |i: u32| {
        let [s, t] = [i % side, i / side].map(|k| std::f32::consts::TAU * (k as f32 + 0.5) / side as f32);
        waves.iter().map(|&(a, b, height)| height * (a as f32 * s + b as f32 * t).sin()).sum()
    };
    let texels = (0..side * side).into_par_iter().map(texel).collect();
    let heights = HeightMap::new(side, side, texels)?;
    let slopes = slopes_of_heights(&heights, 1.0, Wrap::Repeat, Difference::Triangles);
    println!("{side} x {side}, slopes {:.3}, {} threads", rms(&slopes), rayon::current_num_threads());
    for wrap in [Wrap::Repeat, Wrap::Clamp] {
        let how = Integration { wrap, ..Integration::default() };
        timed(&format!("heights, {wrap:?}"), || heights_of_slopes(&slopes, &how, &|_| {}))?;
    }
    let all = Occlusion::default();
    for how in [
        all,
        Occlusion { slices: 2 * SLICES, ..all },
        Occlusion { wrap: Wrap::Clamp, ..all },
        Occlusion { distance: 0.01, ..all },
        Occlusion { distance: 0.1, ..all },
        Occlusion { distance: 1.0, ..all },
        Occlusion { distance: 0.1, wrap: Wrap::Clamp, ..all },
    ] {
        let what = format!("visibility, {:?}, {} slices, distance {}", how.wrap, how.slices, how.distance);
        timed(&what, || visibility(&heights, 1.0, &how, &|_| {}))?;
    }
    Ok(())
}

fn timed<T, E>(what: &str, make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let (start, before) = (Instant::now(), processor_seconds());
    let made = make();
    let (clock, all) = (start.elapsed().as_secs_f64(), processor_seconds());
    let all = before.zip(all).map_or_else(String::new, |(before, after)| format!(", {:.2} s CPU", after - before));
    println!("{what}: {clock:.2} s{all}");
    made
}

/// Returns the CPU seconds of all threads from Linux's process table, which counts ticks of 1/100 s.
fn processor_seconds() -> Option<f64> {
    let table = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = table.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}
