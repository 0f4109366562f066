//! Converts environments in other layouts to the equirectangular layout: crosses and strips of a cube, and light probes.
//!
//! Directions are those of a viewer inside: x to the right, y up, z to the front, which is the centre of a panorama. All
//! pictures show their surroundings as seen from inside.
//!
//! | layout | width : height | faces |
//! |---|---|---|
//! | horizontal cross | 4 : 3 | left, front, right, back in the middle row; top and bottom above and below the front |
//! | vertical cross | 3 : 4 | left, front, right in the second row; top, front, bottom, back (upside down) in the middle column |
//! | strip | 6 : 1 or 1 : 6 | right, left, top, bottom, front, back, as in DDS files |
//! | cube of OpenEXR | 1 : 6 | left, right, top, bottom, front, back; the attribute `envmap` is `cube` |
//! | light probe | 1 : 1 | an angular map (Debevec): the front in the centre, the back along the circle around it |
//!
//! A square is read as an angular map instead of the photograph of a mirror ball, because published light probes are angular
//! maps. Crosses and light probes leave parts of the picture blank; a picture with contents there is none.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::RgbImage;

/// The largest width of a converted panorama, twice as fine as the cube that lights scenes.
const WIDEST: usize = 2048;
/// Directions along each side of a texel of the panorama, if it is as fine as the picture.
const SAMPLES: usize = 4;
/// The smallest side of the faces of a cube. A smaller picture is no use as a panorama.
const SMALLEST: u32 = 4;
/// The largest relative difference between blank texels.
const BLANK: f32 = 0.01;
/// The largest relative difference between the width and twice the height of a panorama.
const RATIO: f64 = 0.01;

/// A face of a cube: the cell of its picture, and the directions of its centre, its right edge and its top edge.
struct Face {
    cell: [usize; 2],
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

enum Layout {
    Cube { faces: Box<[Face; 6]>, side: usize },
    Angular { side: usize },
}

/// A position in the picture, in texels, and the texels that may be read there: left, top, right, bottom.
struct Position {
    at: DVec2,
    within: [usize; 4],
}

/// Converts an environment to the equirectangular layout. Returns it unchanged if it has this layout, or no known layout.
/// `is_cube` is the layout that the file declares. The second result is a remark on the layout.
pub(crate) fn equirectangular(image: RgbImage, is_cube: Option<bool>) -> (RgbImage, Option<String>) {
    if is_cube == Some(false) {
        return (image, None);
    }
    let Some((name, layout)) = layout_of(&image, is_cube == Some(true)) else {
        let ratio = f64::from(image.width) / (2.0 * f64::from(image.height));
        let (width, height) = (image.width, image.height);
        let remark = format!(
            "its width is not twice its height ({width} x {height}), and it is no cube or light probe; it is stretched over \
             the sphere as an equirectangular panorama"
        );
        return (image, ((ratio - 1.0).abs() > RATIO).then_some(remark));
    };
    let converted = layout.converted(image);
    let (width, height) = (converted.width, converted.height);
    (
        converted,
        Some(format!("it is read as {name}, and converted to an equirectangular panorama of {width} x {height}")),
    )
}

fn layout_of(image: &RgbImage, declared: bool) -> Option<(&'static str, Layout)> {
    let (width, height) = (image.width, image.height);
    let cube = |side: u32, faces: [Face; 6]| Layout::Cube { faces: Box::new(faces), side: side as usize };
    let shape = |across: u32, down: u32| {
        let side = width / across;
        (side >= SMALLEST && (side * across, side * down) == (width, height)).then_some(side)
    };
    if let Some(side) = shape(1, 6) {
        let faces = if declared { openexr() } else { strip(|index| [0, index]) };
        return Some(("the faces of a cube, below each other", cube(side, faces)));
    }
    if let Some(side) = shape(6, 1) {
        return Some(("the faces of a cube, side by side", cube(side, strip(|index| [index, 0]))));
    }
    for (name, shape, faces) in [
        ("the horizontal cross of a cube", shape(4, 3), horizontal_cross()),
        ("the vertical cross of a cube", shape(3, 4), vertical_cross()),
    ] {
        let Some(side) = shape else { continue };
        let on_face = |x: u32, y: u32| {
            let cell = [x / side, y / side].map(|k| k as usize);
            faces.iter().any(|face| face.cell == cell)
        };
        if is_blank(image, |x, y| !on_face(x, y)) {
            return Some((name, cube(side, faces)));
        }
    }
    let radius = f64::from(width) / 2.0;
    // Some programs draw a little beyond the circle.
    let outside = |x: u32, y: u32| center(x, y).distance(DVec2::splat(radius)) > 1.02 * radius + 1.0;
    let is_probe = width == height && width >= 4 * SMALLEST && is_blank(image, outside);
    is_probe.then_some(("a light probe (angular map)", Layout::Angular { side: width as usize }))
}

fn center(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}

/// Whether the selected texels have one colour.
fn is_blank(image: &RgbImage, selected: impl Fn(u32, u32) -> bool) -> bool {
    let mean = image.mean().iter().sum::<f64>() as f32 / 3.0;
    let positions = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let mut texels = positions.filter(|&(x, y)| selected(x, y)).map(|(x, y)| image.at(x, y));
    let Some(first) = texels.next() else { return true };
    texels.all(|texel| texel.iter().zip(first).all(|(a, b)| (a - b).abs() <= BLANK * (mean + b.abs())))
}

const fn face(cell: [usize; 2], forward: DVec3, right: DVec3, up: DVec3) -> Face {
    Face { cell, forward, right, up }
}

const fn horizontal_cross() -> [Face; 6] {
    use DVec3 as V;
    [
        face([0, 1], V::NEG_X, V::Z, V::Y),
        face([1, 1], V::Z, V::X, V::Y),
        face([2, 1], V::X, V::NEG_Z, V::Y),
        face([3, 1], V::NEG_Z, V::NEG_X, V::Y),
        face([1, 0], V::Y, V::X, V::NEG_Z),
        face([1, 2], V::NEG_Y, V::X, V::Z),
    ]
}

fn vertical_cross() -> [Face; 6] {
    let [left, front, right, _, top, bottom] = horizontal_cross();
    [left, front, right, face([1, 3], DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y), top, bottom]
}

fn strip(cell: impl Fn(usize) -> [usize; 2]) -> [Face; 6] {
    let [left, front, right, back, top, bottom] = horizontal_cross();
    let mut index = 0;
    [right, left, top, bottom, front, back].map(|face| {
        index += 1;
        Face { cell: cell(index - 1), ..face }
    })
}

/// The faces +X, −X, +Y, −Y, +Z, −Z of OpenEXR. Its panoramas have +Z in the centre and +X on the left.
fn openexr() -> [Face; 6] {
    let [right, left, top, bottom, front, back] = strip(|index| [0, index]);
    let turned = |face: Face| Face { right: -face.right, up: -face.up, ..face };
    let swapped = [Face { cell: [0, 0], ..left }, Face { cell: [0, 1], ..right }];
    let [first, second] = swapped;
    [first, second, turned(top), turned(bottom), front, back]
}

impl Layout {
    /// Returns the position of a direction in the picture.
    fn position(&self, direction: DVec3) -> Position {
        match self {
            Self::Cube { faces, side } => {
                let toward = |face: &&Face| direction.dot(face.forward);
                let face = faces.iter().max_by(|a, b| toward(a).total_cmp(&toward(b))).expect("a cube has faces");
                let on_face = DVec2::new(direction.dot(face.right), -direction.dot(face.up)) / toward(&face);
                let [left, top] = face.cell.map(|k| k * side);
                let corner = DVec2::new(left as f64, top as f64);
                let at = corner + (on_face + 1.0) * (0.5 * *side as f64);
                Position { at, within: [left, top, left + side - 1, top + side - 1] }
            }
            Self::Angular { side } => {
                let radius = 0.5 * *side as f64;
                let across = DVec2::new(direction.x, -direction.y);
                let angle = across.length().atan2(direction.z);
                let at = DVec2::splat(radius) + across.normalize_or_zero() * (angle / PI * radius);
                Position { at, within: [0, 0, side - 1, side - 1] }
            }
        }
    }

    /// Returns the solid angle of a texel, up to a factor.
    fn solid_angle(&self, x: u32, y: u32) -> f64 {
        match self {
            Self::Cube { faces, side } => {
                let cell = [x, y].map(|k| k as usize / side);
                if !faces.iter().any(|face| face.cell == cell) {
                    return 0.0;
                }
                let [x, y] = [x, y].map(|k| 2.0 * ((k as usize % side) as f64 + 0.5) / *side as f64 - 1.0);
                (1.0 + x * x + y * y).powf(-1.5)
            }
            Self::Angular { side } => {
                let radius = 0.5 * *side as f64;
                let distance = center(x, y).distance(DVec2::splat(radius)) / radius;
                if distance < 1.0 { (PI * distance).sin() / distance.max(1e-9) } else { 0.0 }
            }
        }
    }

    /// Returns the interpolated colour in a direction. Texels without a solid angle are left out.
    fn color(&self, image: &RgbImage, direction: DVec3) -> DVec3 {
        let Position { at, within: [left, top, right, bottom] } = self.position(direction);
        let corner = at - 0.5;
        let [x, y] = [corner.x.floor(), corner.y.floor()];
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (row, v) in [(y, 1.0 - (corner.y - y)), (y + 1.0, corner.y - y)] {
            for (column, u) in [(x, 1.0 - (corner.x - x)), (x + 1.0, corner.x - x)] {
                let [column, row] = [column.clamp(left as f64, right as f64), row.clamp(top as f64, bottom as f64)];
                let weight = u * v;
                let (column, row) = (column as u32, row as u32);
                if weight > 0.0 && (matches!(self, Self::Cube { .. }) || self.solid_angle(column, row) > 0.0) {
                    sum += weight * DVec3::from(image.at(column, row).map(f64::from));
                    weights += weight;
                }
            }
        }
        if weights > 0.0 { sum / weights } else { DVec3::ZERO }
    }

    /// Returns the width of a panorama as fine as the picture, and the side of a face or of the light probe.
    fn resolution(&mut self) -> (usize, &mut usize) {
        match self {
            Self::Cube { side, .. } => (4 * *side, side),
            Self::Angular { side } => (2 * *side, side),
        }
    }

    /// Returns a picture of half the size, with the means of the light of 2 × 2 texels.
    fn halved(&self, image: &RgbImage) -> RgbImage {
        let (width, height) = (image.width / 2, image.height / 2);
        let texel = |i: u32| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            let (sum, weights) = sum(four.into_iter().map(|(x, y)| (self.solid_angle(x, y), image.at(x, y))));
            (sum / weights.max(f64::MIN_POSITIVE)).as_vec3().to_array()
        };
        RgbImage { width, height, texels: (0..width * height).map(texel).collect() }
    }

    /// Converts a picture. Each texel is the mean over its directions. The mean radiance over the sphere is kept.
    fn converted(mut self, mut image: RgbImage) -> RgbImage {
        while self.resolution().0 > WIDEST && self.resolution().1.is_multiple_of(2) {
            image = self.halved(&image);
            *self.resolution().1 /= 2;
        }
        let full = self.resolution().0;
        let (layout, image) = (&self, &image);
        let width = full.min(WIDEST);
        let height = width / 2;
        let samples = SAMPLES * full.div_ceil(width);
        let step = 1.0 / samples as f64;
        let longitudes: Vec<(f64, f64)> =
            (0..width * samples).map(|k| (((k as f64 + 0.5) * step / width as f64 - 0.5) * TAU).sin_cos()).collect();
        let row = |y: usize| -> Vec<[f32; 3]> {
            let latitudes: Vec<(f64, f64)> = (0..samples)
                .map(|k| ((0.5 - (y as f64 + (k as f64 + 0.5) * step) / height as f64) * PI).sin_cos())
                .collect();
            let area: f64 = latitudes.iter().map(|(_, cos)| cos).sum::<f64>() * samples as f64;
            let texel = |x: usize| {
                let mut sum = DVec3::ZERO;
                for &(up, across) in &latitudes {
                    for &(right, front) in &longitudes[x * samples..(x + 1) * samples] {
                        let direction = DVec3::new(across * right, up, across * front);
                        sum += across * layout.color(image, direction);
                    }
                }
                (sum / area).as_vec3().to_array()
            };
            (0..width).map(texel).collect()
        };
        let mut texels: Vec<[f32; 3]> = (0..height).into_par_iter().flat_map_iter(row).collect();
        let positions = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
        let before = mean(positions.map(|(x, y)| (layout.solid_angle(x, y), image.at(x, y))));
        let latitude = |index: usize| ((index / width) as f64 + 0.5) / height as f64 * PI;
        let after = mean(texels.iter().enumerate().map(|(index, &texel)| (latitude(index).sin(), texel)));
        let kept = DVec3::select(after.cmpgt(DVec3::ZERO), before / after, DVec3::ONE).as_vec3();
        texels.iter_mut().for_each(|texel| *texel = (glam::Vec3::from(*texel) * kept).to_array());
        RgbImage { width: width as u32, height: height as u32, texels }
    }
}

/// Returns the mean of weighted colours.
fn mean(colors: impl Iterator<Item = (f64, [f32; 3])>) -> DVec3 {
    let (sum, weights) = sum(colors);
    sum / weights
}

/// Returns the weighted sum of colours, and the sum of their weights.
fn sum(colors: impl Iterator<Item = (f64, [f32; 3])>) -> (DVec3, f64) {
    let add = |(sum, weights): (DVec3, f64), (weight, color): (f64, [f32; 3])| {
        (sum + weight * DVec3::from(color.map(f64::from)), weights + weight)
    };
    colors.fold((DVec3::ZERO, 0.0), add)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth environment with a small sun, as a function of the direction.
    fn light(direction: DVec3) -> DVec3 {
        let sun = if direction.dot(DVec3::new(0.6, 0.48, 0.64)) > 0.998 { 400.0 } else { 0.0 };
        0.6 + 0.4 * direction + DVec3::splat(sun)
    }

    /// Draws an environment in a layout. `direction` returns the direction of a point, from 0 to 1 in both axes.
    fn drawn(width: u32, height: u32, direction: impl Fn(f64, f64) -> Option<DVec3>) -> RgbImage {
        let texel = |i: u32| {
            let at = center(i % width, i / width) / DVec2::new(width.into(), height.into());
            direction(at.x, at.y).map_or([0.0; 3], |d| light(d.normalize()).as_vec3().to_array())
        };
        RgbImage::new(width, height, (0..width * height).map(texel).collect()).unwrap()
    }

    /// Each layout is drawn by a description of its own.
    fn layouts() -> [(&'static str, RgbImage, Option<bool>); 6] {
        // The coordinates in a face, from -1 to 1, right and up.
        let cell = |u: f64, v: f64, across: f64, down: f64| {
            let (x, y) = (u * across, v * down);
            ((x as usize, y as usize), 2.0 * x.fract() - 1.0, 1.0 - 2.0 * y.fract())
        };
        let horizontal = move |u, v| {
            let (cell, a, b) = cell(u, v, 4.0, 3.0);
            Some(match cell {
                (1, 1) => DVec3::new(a, b, 1.0),
                (2, 1) => DVec3::new(1.0, b, -a),
                (3, 1) => DVec3::new(-a, b, -1.0),
                (0, 1) => DVec3::new(-1.0, b, a),
                (1, 0) => DVec3::new(a, 1.0, -b),
                (1, 2) => DVec3::new(a, -1.0, b),
                _ => return None,
            })
        };
        let vertical = move |u, v| {
            let (cell, a, b) = cell(u, v, 3.0, 4.0);
            Some(match cell {
                (1, 1) => DVec3::new(a, b, 1.0),
                (2, 1) => DVec3::new(1.0, b, -a),
                (0, 1) => DVec3::new(-1.0, b, a),
                (1, 0) => DVec3::new(a, 1.0, -b),
                (1, 2) => DVec3::new(a, -1.0, b),
                (1, 3) => DVec3::new(a, -b, -1.0),
                _ => return None,
            })
        };
        // The faces of OpenGL and Direct3D: the bottom edge of the top face touches the front.
        let dds = |index: usize, a: f64, b: f64| {
            Some(match index {
                0 => DVec3::new(1.0, b, -a),
                1 => DVec3::new(-1.0, b, a),
                2 => DVec3::new(a, 1.0, -b),
                3 => DVec3::new(a, -1.0, b),
                4 => DVec3::new(a, b, 1.0),
                _ => DVec3::new(-a, b, -1.0),
            })
        };
        let (across, down) = (
            move |u, v| {
                let (cell, a, b) = cell(u, v, 6.0, 1.0);
                dds(cell.0, a, b)
            },
            move |u, v| {
                let (cell, a, b) = cell(u, v, 1.0, 6.0);
                dds(cell.1, a, b)
            },
        );
        // The formulas of ImfEnvmap, whose x points to the left of a panorama.
        let openexr = move |u, v| {
            let (cell, a, b) = cell(u, v, 1.0, 6.0);
            let [x, y, z] = match cell.1 {
                0 => [1.0, b, a],
                1 => [-1.0, b, -a],
                2 => [a, 1.0, b],
                3 => [a, -1.0, -b],
                4 => [-a, b, 1.0],
                _ => [a, b, -1.0],
            };
            Some(DVec3::new(-x, y, z))
        };
        let probe = |u: f64, v: f64| {
            let (x, y) = (2.0 * u - 1.0, 1.0 - 2.0 * v);
            let (angle, radius) = (PI * x.hypot(y), x.hypot(y));
            (radius < 1.02).then(|| DVec3::new(x / radius * angle.sin(), y / radius * angle.sin(), angle.cos()))
        };
        [
            ("horizontal cross", drawn(256, 192, horizontal), None),
            ("vertical cross", drawn(192, 256, vertical), None),
            ("side by side", drawn(384, 64, across), None),
            ("below each other", drawn(64, 384, down), None),
            ("below each other", drawn(64, 384, openexr), Some(true)),
            ("light probe", drawn(256, 256, probe), None),
        ]
    }

    fn direction(u: f64, v: f64) -> DVec3 {
        let ((right, front), (up, across)) = (((u - 0.5) * TAU).sin_cos(), ((0.5 - v) * PI).sin_cos());
        DVec3::new(across * right, up, across * front)
    }

    #[test]
    fn every_layout_becomes_the_same_panorama() {
        let expected = drawn(256, 128, |u, v| Some(direction(u, v)));
        let sphere_mean = |image: &RgbImage| {
            let weight = |i: usize| ((i as u32 / image.width) as f64 + 0.5) / f64::from(image.height) * PI;
            mean(image.texels.iter().enumerate().map(|(i, &texel)| (weight(i).sin(), texel)))
        };
        for (name, image, is_cube) in layouts() {
            let (found, remark) = equirectangular(image, is_cube);
            let remark = remark.unwrap();
            assert!(remark.contains(name) && remark.contains("converted"), "{name}: {remark}");
            let (u, v) = (f64::from(found.width), f64::from(found.height));
            assert_eq!(u, 2.0 * v);
            for (i, texel) in found.texels.iter().enumerate() {
                let at = center(i as u32 % found.width, i as u32 / found.width);
                let direction = direction(at.x / u, at.y / v);
                if direction.dot(DVec3::new(0.6, 0.48, 0.64)) < 0.99 {
                    let off = (glam::Vec3::from(*texel).as_dvec3() - light(direction)).abs().max_element();
                    assert!(off < 0.02, "{name}: {texel:?} toward {direction}");
                }
            }
            let ratio = sphere_mean(&found) / sphere_mean(&expected);
            assert!((ratio - 1.0).abs().max_element() < 0.03, "{name}: {ratio}");
        }
    }

    #[test]
    fn a_sun_of_one_texel_keeps_its_energy() {
        let solid_angle = |image: &RgbImage, layout: &Layout| {
            let positions = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
            positions.map(|(x, y)| layout.solid_angle(x, y)).sum::<f64>()
        };
        for (name, mut image, is_cube) in layouts() {
            image.texels.iter_mut().for_each(|texel| *texel = [0.0; 3]);
            let layout = layout_of(&image, is_cube == Some(true)).unwrap().1;
            let whole = solid_angle(&image, &layout);
            let (x, y) = (image.width / 2 + 11, image.height / 2 - 7);
            image.texels[(y * image.width + x) as usize] = [1000.0; 3];
            let share = layout.solid_angle(x, y) / whole;
            let found = layout.converted(image);
            let weight = |i: usize| ((i as u32 / found.width) as f64 + 0.5) / f64::from(found.height) * PI;
            let mean = mean(found.texels.iter().enumerate().map(|(i, &texel)| (weight(i).sin(), texel))).x;
            assert!((mean / (1000.0 * share) - 1.0).abs() < 1e-3, "{name}: {mean} instead of {}", 1000.0 * share);
        }
    }

    #[test]
    fn large_pictures_are_halved() {
        let side = 2 * WIDEST as u32;
        let texel = |i: u32| {
            let at = (center(i % side, i / side) / f64::from(side) * 2.0 - 1.0).length();
            if at > 1.0 { [0.0; 3] } else { [2.0, 4.0 + (i % 2) as f32, 8.0] }
        };
        let image = RgbImage::new(side, side, (0..side * side).map(texel).collect()).unwrap();
        let found = Layout::Angular { side: side as usize }.converted(image);
        assert_eq!((found.width, found.height), (WIDEST as u32, WIDEST as u32 / 2));
        for texel in found.texels {
            let off = (glam::Vec3::from(texel) - glam::Vec3::new(2.0, 4.5, 8.0)).abs().max_element();
            assert!(off < 0.1, "{texel:?}");
        }
    }

    #[test]
    fn other_pictures_stay_as_they_are() {
        let contents = |width, height| {
            let texel = |i: u32| [(i % 7) as f32, (i % 5) as f32, 1.0];
            RgbImage::new(width, height, (0..width * height).map(texel).collect()).unwrap()
        };
        for (width, height, is_cube, remarked) in [
            (64, 32, None, false),
            (65, 33, None, true),
            (201, 100, None, false),
            (64, 48, None, true),
            (48, 64, None, true),
            (64, 64, None, true),
            (96, 64, None, true),
            (2, 12, None, true),
            (64, 384, Some(false), false),
            (1, 1, None, true),
        ] {
            let image = contents(width, height);
            let (same, remark) = equirectangular(image.clone(), is_cube);
            assert_eq!((same == image, remark.is_some()), (true, remarked), "{width} x {height}: {remark:?}");
        }
    }
}
