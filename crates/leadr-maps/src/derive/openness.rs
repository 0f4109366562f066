//! How much of each class of facets other facets hide, measured on the relief.
//!
//! Smith's form assumes that heights and slopes are unrelated. On walls and grooves with regular distances, this assumption lets
//! too much light into the gaps: at 75 degrees from the normal, 50 % of the bottom of a metal grid instead of 20 %. The openness of
//! a class is the visible part of its projected area, for each direction. It depends only on the direction in the space of the map,
//! so it holds for all height scales and stretches.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use half::f16;
use leadr_reflectance::masking::classes::{Azimuths, Correlation, MOST_CLASSES};
use rayon::prelude::*;

use super::classes::{Cell, ClassMaterial, Classes, Facet, Facets};
use crate::cache::{expect_all, put, take};
use crate::{HeightMap, Moments, Wrap};

/// The number of texels along one side of a table.
pub const OPENNESS_SIDE: usize = 32;
/// The number of texels of a table.
const TEXELS: usize = OPENNESS_SIDE * OPENNESS_SIDE;
/// The number of azimuths and of elevations that are measured.
const AZIMUTHS: usize = 32;
const ELEVATIONS: usize = 20;
/// The maximum number of facets that are measured, for all classes and for each class.
const MOST_FACETS: usize = 1 << 15;
const MOST_OF_CLASS: usize = 1 << 10;
/// Steps of a march are one texel up to this distance in texels, and grow in proportion beyond.
const FINE: f64 = 24.0;
/// The largest distance of a march, in repeats.
const MOST_REPEATS: f64 = 1.5;

/// The version of the directions and values of a stored table.
const VERSION: u32 = 2;

/// The smallest correlation of directions.
const LEAST_CORRELATION: f64 = -6.0;
/// The widths of a [`Correlation`] that are tried.
const WIDTHS: [f64; 9] = [0.02, 0.04, 0.08, 0.13, 0.2, 0.3, 0.45, 0.7, 1.1];
/// The elevations and the step in azimuth at which the correlation is measured.
const CORRELATED_ROWS: [usize; 3] = [9, 12, 15];
const CORRELATED_STEP: usize = 2;

/// The openness of each class as a table over directions.
///
/// The direction `(x, y, z)` of the space of the map has the coordinates `q = (x uₛ, y uₜ) / z`, where `uₛ` and `uₜ` are the slope
/// units of a [`ClassMap`](crate::ClassMap), `x` and `y` are in repeats, and `z` is in units of height. The table covers the disc
/// `q / (1 + |q|)`, from -1 to 1 in both coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Openness {
    /// Whether facets that are open to one direction are also open to others, for
    /// [`lit_fractions`](leadr_reflectance::masking::classes::ClassesSeen::lit_fractions).
    pub correlation: [Correlation; MOST_CLASSES],
    /// The rows of the table, with [`OPENNESS_SIDE`] texels each. A texel holds one value per class, from 0 to 1.
    pub texels: Vec<[f16; MOST_CLASSES]>,
}

/// A part of a surface, and the heights around it, for a surface whose relief is not a single map. Texture coordinates are those of the
/// heights.
pub struct OpennessWindow {
    /// The heights of the part and of its surroundings, as a square.
    pub heights: HeightMap,
    /// Facets of the part. The slopes are per unit of texture coordinate.
    pub facets: Vec<WindowFacet>,
}

/// A facet of an [`OpennessWindow`].
pub struct WindowFacet {
    /// The texture coordinate.
    pub at: [f64; 2],
    /// The slopes and the height.
    pub moments: Moments,
    /// The texture coordinate in the material of the classes.
    pub material_at: [f64; 2],
}

/// A facet that is measured.
struct Sampled {
    class: usize,
    /// The number of the field in which its rays march.
    field: usize,
    /// The texture coordinate in the field.
    at: DVec2,
    /// The slopes and the height.
    facet: DVec3,
}

/// Values by azimuth and elevation.
pub(super) struct Polar<const N: usize> {
    /// The number of elevations, which are even in a table.
    pub elevations: usize,
    /// The values of each elevation of the first azimuth, which is that of `x`, then those of the other azimuths.
    pub values: Vec<[f64; N]>,
    /// The values of the direction straight up.
    pub above: [f64; N],
}

impl Openness {
    /// Measures the openness of a relief. `units` are those of the class map, and `material` is that of the classes. If `upside_down` is
    /// true, the heights are negated.
    pub fn new(
        facets: Facets<'_>,
        classes: &Classes,
        material: Option<&ClassMaterial<'_>>,
        units: [f32; 3],
        upside_down: bool,
    ) -> Self {
        let field = Field::new(facets, if upside_down { -1.0 } else { 1.0 });
        let sampled = field.sampled(facets, classes, material);
        Self::of_sampled(&[field], &sampled, units)
    }

    /// Measures the openness of a relief in some of its parts, like [`new`](Self::new).
    pub fn of_windows(
        windows: &[OpennessWindow],
        classes: &Classes,
        material: Option<&ClassMaterial<'_>>,
        units: [f32; 3],
        upside_down: bool,
    ) -> Self {
        let sign = if upside_down { -1.0 } else { 1.0 };
        let fields = Field::of_windows(windows, sign);
        let material = classes.material(material);
        let facet = |(field, WindowFacet { at, moments, material_at }): (usize, &WindowFacet)| {
            let facet = Facet { material: material.at(*material_at), ..Facet::of_texel(moments) };
            let class = classes.of(&facet).min(MOST_CLASSES - 1);
            Sampled { class, field, at: DVec2::from(*at), facet: sign * facet.point }
        };
        let all = windows.iter().enumerate().flat_map(|(i, window)| window.facets.iter().map(move |facet| (i, facet)));
        Self::of_sampled(&fields, &all.map(facet).collect::<Vec<_>>(), units)
    }

    fn of_sampled(fields: &[Field], sampled: &[Sampled], units: [f32; 3]) -> Self {
        let unit = DVec2::new(f64::from(units[0]), f64::from(units[1]));
        let alongs: Vec<DVec2> = (0..AZIMUTHS)
            .map(|i| {
                let angle = 2.0 * PI * i as f64 / AZIMUTHS as f64;
                DVec2::new(angle.cos(), angle.sin()) / unit
            })
            .collect();
        let most = distance(ELEVATIONS - 1, ELEVATIONS);
        let reaches: Vec<Vec<f64>> = alongs
            .par_iter()
            .map(|along| {
                let reach = |s: &Sampled| fields[s.field].reach(s.at, s.facet.z, *along, most);
                sampled.iter().map(reach).collect()
            })
            .collect();
        let rows = alongs.par_iter().zip(&reaches).map(|(along, reaches)| {
            let mut sums = [[[0.0; 2]; MOST_CLASSES]; ELEVATIONS];
            for (Sampled { class, facet, .. }, reach) in sampled.iter().zip(reaches) {
                let slope = along.dot(facet.truncate());
                for (row, sums) in sums.iter_mut().enumerate() {
                    let q = distance(row, ELEVATIONS);
                    let area = (1.0 - q * slope).max(0.0);
                    sums[*class][0] += if q < *reach { area } else { 0.0 };
                    sums[*class][1] += area;
                }
            }
            // Where no facet of a class faces the direction, the value of the next steeper direction applies.
            let mut last = [1.0; MOST_CLASSES];
            let open = |sums: &[[f64; 2]; MOST_CLASSES]| {
                for ([open, all], last) in sums.iter().zip(&mut last) {
                    *last = if *all > 0.0 { open / all } else { *last };
                }
                last
            };
            sums.iter().map(open).collect::<Vec<_>>()
        });
        let polar =
            Polar { elevations: ELEVATIONS, values: rows.collect::<Vec<_>>().concat(), above: [1.0; MOST_CLASSES] };
        let texel = |open: [f64; MOST_CLASSES]| open.map(|open| f16::from_f64(open.clamp(0.0, 1.0)));
        let correlation = std::array::from_fn(|class| {
            let seen = |(i, reaches): (usize, &Vec<f64>)| {
                let along = alongs[i * CORRELATED_STEP];
                let facets = sampled.iter().zip(reaches).filter(|(sampled, _)| sampled.class == class);
                let facets: Vec<(f64, f64)> =
                    facets.map(|(sampled, reach)| (along.dot(sampled.facet.truncate()), *reach)).collect();
                CORRELATED_ROWS.map(|row| {
                    let q = distance(row, ELEVATIONS);
                    let of_facet = |&(slope, reach): &(f64, f64)| ((1.0 - q * slope).max(0.0), q < reach);
                    (i, facets.iter().map(of_facet).collect::<Vec<_>>())
                })
            };
            let directions: Vec<_> = reaches.iter().step_by(CORRELATED_STEP).enumerate().flat_map(seen).collect();
            correlation(&directions)
        });
        Self { correlation, texels: polar.table(OPENNESS_SIDE).into_iter().map(texel).collect() }
    }

    /// Appends the table to the content of a cache file.
    pub fn put(&self, content: &mut Vec<u8>) {
        put(content, &self.correlation.map(numbers));
        self.texels.iter().for_each(|texel| put(content, &texel.map(f16::to_bits)));
    }

    /// Removes a table from the front of a cache file's content.
    ///
    /// # Errors
    /// Fails if the content is too short, or if a value is out of range.
    pub fn take(content: &mut &[u8]) -> Result<Self, &'static str> {
        let correlation: [[f64; 3]; MOST_CLASSES] =
            take(content, MOST_CLASSES)?.try_into().map_err(|_| "it is too short")?;
        let texels = take::<[u16; MOST_CLASSES]>(content, TEXELS)?;
        Self::new_checked(correlation, texels.into_iter().map(|texel| texel.map(f16::from_bits)).collect())
    }

    /// Returns the table as the text of a key in a baked file: the version, the correlations, and the texels as 16-bit floats in
    /// hexadecimal digits.
    pub(crate) fn text(&self) -> String {
        let mut text = VERSION.to_string();
        self.correlation.map(numbers).as_flattened().iter().for_each(|c| text += &format!(" {c:e}"));
        text.push(' ');
        self.texels.as_flattened().iter().for_each(|open| text += &format!("{:04x}", open.to_bits()));
        text
    }

    /// Reads the text of a key in a baked file. A text of another version is `Some(None)`, and a damaged text is `None`.
    #[expect(clippy::option_option, reason = "two kinds of missing tables")]
    pub(crate) fn of_text(text: &str) -> Option<Option<Self>> {
        let mut words = text.split(' ');
        if words.next()?.parse::<u32>().ok()? != VERSION {
            return Some(None);
        }
        let mut correlation = [[0.0; 3]; MOST_CLASSES];
        for c in correlation.as_flattened_mut() {
            *c = words.next()?.parse().ok()?;
        }
        let digits = words.next()?.as_bytes();
        let value = |digits: &[u8; 4]| {
            let text = std::str::from_utf8(digits).ok().filter(|_| digits.iter().all(u8::is_ascii_hexdigit))?;
            u16::from_str_radix(text, 16).ok().map(f16::from_bits)
        };
        let values: Vec<f16> = digits.as_chunks().0.iter().map(value).collect::<Option<_>>()?;
        if words.next().is_some() || digits.len() != 4 * MOST_CLASSES * TEXELS {
            return None;
        }
        Self::new_checked(correlation, values.as_chunks().0.to_vec()).ok().map(Some)
    }

    /// Creates a table from stored values.
    ///
    /// # Errors
    /// Fails if a value is out of range.
    fn new_checked(
        correlation: [[f64; 3]; MOST_CLASSES],
        texels: Vec<[f16; MOST_CLASSES]>,
    ) -> Result<Self, &'static str> {
        expect_all(&correlation, |[width, across, opposite]| {
            (0.0..=10.0).contains(width) && [across, opposite].iter().all(|c| (LEAST_CORRELATION..=1.0).contains(*c))
        })?;
        let correlation = correlation.map(|[width, across, opposite]| Correlation { width, across, opposite });
        expect_all(&texels, |texel| texel.iter().all(|open| (f16::ZERO..=f16::ONE).contains(open)))?;
        Ok(Self { correlation, texels })
    }
}

fn numbers(Correlation { width, across, opposite }: Correlation) -> [f64; 3] {
    [width, across, opposite]
}

/// Returns the correlation of pairs of directions, by least squares. A direction has its azimuth, and the area and openness of each facet.
fn correlation(directions: &[(usize, Vec<(f64, bool)>)]) -> Correlation {
    const TURN: usize = AZIMUTHS / CORRELATED_STEP;
    let mut fit = CorrelationFit::default();
    for (i, (first, o)) in directions.iter().enumerate() {
        for (second, i) in &directions[..i] {
            if first != second {
                let mut pair = PairArea::default();
                for (&(area_o, o), &(area_i, i)) in o.iter().zip(i) {
                    pair.add(area_o * area_i, o, i);
                }
                fit.add(&pair, o.len() as f64, turned(first.abs_diff(*second), TURN));
            }
        }
    }
    fit.correlation()
}

/// Returns the angle between azimuths that are some steps of a turn apart.
pub(super) fn turned(steps: usize, of: usize) -> Azimuths {
    Azimuths::between(DVec2::X, DVec2::from_angle(2.0 * PI * steps as f64 / of as f64))
}

/// The product of the projected areas towards two directions, summed over facets, and the parts of it that are open to the directions.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairArea {
    all: f64,
    open: [f64; 2],
    both: f64,
}

impl PairArea {
    #[inline]
    pub fn add(&mut self, area: f64, open_o: bool, open_i: bool) {
        self.all += area;
        self.open[0] += if open_o { area } else { 0.0 };
        self.open[1] += if open_i { area } else { 0.0 };
        self.both += if open_o && open_i { area } else { 0.0 };
    }

    #[inline]
    pub fn join(&mut self, other: &Self) {
        self.all += other.all;
        self.open[0] += other.open[0];
        self.open[1] += other.open[1];
        self.both += other.both;
    }
}

/// The fit of a correlation to pairs of directions. The part `1 / (1 + more + f less (1 + (1 − c) more))` of the facets is open to both
/// ([`class_lit_fraction`](leadr_reflectance::masking::classes::class_lit_fraction)).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CorrelationFit {
    of_widths: [LinearFit; WIDTHS.len()],
}

/// The sums of a fit of `y = a x + b z`.
#[derive(Clone, Copy, Debug, Default)]
struct LinearFit {
    xx: f64,
    xz: f64,
    zz: f64,
    xy: f64,
    zy: f64,
    yy: f64,
}

impl LinearFit {
    fn add(&mut self, weight: f64, x: f64, z: f64, y: f64) {
        self.xx += weight * x * x;
        self.xz += weight * x * z;
        self.zz += weight * z * z;
        self.xy += weight * x * y;
        self.zy += weight * z * y;
        self.yy += weight * y * y;
    }

    /// Returns the correlations across and opposite, and the sum of the squares of the errors.
    fn solved(&self) -> ([f64; 2], f64) {
        let (xx, zz) = (1.001 * self.xx, 1.001 * self.zz);
        let determinant = (xx * zz - self.xz * self.xz).max(1e-30);
        let limited = |c: f64| c.clamp(LEAST_CORRELATION, 1.0);
        let across = limited(1.0 - (self.xy * zz - self.zy * self.xz) / determinant);
        // The best opposite correlation for this one across.
        let a = 1.0 - across;
        let opposite = limited(across - (self.zy - a * self.xz) / zz.max(1e-30));
        let b = across - opposite;
        let error =
            self.yy - 2.0 * (a * self.xy + b * self.zy) + a * a * self.xx + 2.0 * a * b * self.xz + b * b * self.zz;
        ([across, opposite], error)
    }
}

impl CorrelationFit {
    /// Adds a pair of directions, over this number of facets.
    pub fn add(&mut self, pair: &PairArea, facets: f64, apart: Azimuths) {
        if pair.all <= 1e-3 * facets {
            return;
        }
        let lambda = |open: f64| 1.0 / (open / pair.all).max(0.02) - 1.0;
        let (o, i) = (lambda(pair.open[0]), lambda(pair.open[1]));
        let (more, less) = (o.max(i), o.min(i));
        // Errors count by the fraction of facets that they change.
        let independent = 1.0 / (1.0 + o + i + o * i);
        let per = pair.all * independent.powi(4);
        let hidden = 1.0 / (pair.both / pair.all).max(0.1 * independent) - 1.0 - more;
        for (fit, width) in self.of_widths.iter_mut().zip(WIDTHS) {
            let f = apart.half / (apart.half + width);
            let x = f * less * more;
            fit.add(per, x, x * apart.opposite, hidden - f * less);
        }
    }

    pub fn correlation(&self) -> Correlation {
        if self.of_widths[0].xx <= 0.0 {
            return Correlation::SMITH;
        }
        let solved = self.of_widths.iter().zip(WIDTHS).map(|(fit, width)| (width, fit.solved()));
        let best = solved.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)).expect("there are widths");
        let (width, ([across, opposite], _)) = best;
        Correlation { width, across, opposite }
    }
}

/// Returns the value of `|q|` at one of `of` elevations, which are even in the table.
pub(super) fn distance(row: usize, of: usize) -> f64 {
    let r = (row as f64 + 0.5) / of as f64;
    r / (1.0 - r)
}

impl<const N: usize> Polar<N> {
    /// Interpolates the values at a point of the disc.
    fn at(&self, at: DVec2) -> [f64; N] {
        let azimuths = self.values.len() / self.elevations;
        let row = at.length() * self.elevations as f64 - 0.5;
        let column = (at.y.atan2(at.x) / (2.0 * PI)).rem_euclid(1.0) * azimuths as f64;
        let (x, y) = (column.floor(), row.floor().min((self.elevations - 2) as f64));
        let (across, down) = (column - x, (row - y).clamp(0.0, 1.0));
        let value = |x: usize, y: f64| {
            if y < 0.0 { self.above } else { self.values[x % azimuths * self.elevations + y as usize] }
        };
        let [a, b, c, d] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| value(x as usize + i, y + j as f64));
        std::array::from_fn(|k| {
            (1.0 - down) * ((1.0 - across) * a[k] + across * b[k]) + down * ((1.0 - across) * c[k] + across * d[k])
        })
    }

    /// Returns the rows of a table over the disc with texels `side` along each side.
    pub fn table(&self, side: usize) -> Vec<[f64; N]> {
        let unit = |k: usize| (2 * k + 1) as f64 / side as f64 - 1.0;
        (0..side * side).map(|i| self.at(DVec2::new(unit(i % side), unit(i / side)))).collect()
    }
}

/// The heights of a relief, with coarser levels.
pub(super) struct Field {
    levels: Vec<Level>,
    top: f64,
    sign: f64,
    wrap: Wrap,
}

/// A level of the heights, with a border of one texel for interpolation across the edges.
struct Level {
    size: [usize; 2],
    /// The rows, each `size[0] + 2` texels long, with a row above the first and a row below the last one.
    heights: Vec<f32>,
}

impl Level {
    fn new(size: [usize; 2], wrap: Wrap, height: impl Fn(usize) -> f32) -> Self {
        let sides = size.map(|side| side as i64);
        let row = |y: i64| (-1..=sides[0]).map(move |x| [x, y]);
        let texel = |[x, y]: [i64; 2]| height(wrap.texel(y, size[1] as u32) * size[0] + wrap.texel(x, size[0] as u32));
        Self { size, heights: (-1..=sides[1]).flat_map(row).map(texel).collect() }
    }

    /// Returns the next level, whose texels are the means of four texels each.
    fn half(&self, wrap: Wrap) -> Self {
        let size = self.size.map(|side| side / 2);
        let stride = self.size[0] + 2;
        let texel = |i: usize| {
            let first = (2 * (i / size[0]) + 1) * stride + 2 * (i % size[0]) + 1;
            let [above, below] = [first, first + stride].map(|first| self.heights[first] + self.heights[first + 1]);
            0.25 * (above + below)
        };
        Self::new(size, wrap, texel)
    }

    /// Returns the height at a texture coordinate, interpolated linearly.
    #[inline]
    fn at(&self, texcoord: DVec2, wrap: Wrap) -> f64 {
        let [width, height] = self.size;
        let (x, y) = (at_texel(texcoord.x, width, wrap), at_texel(texcoord.y, height, wrap));
        let (column, row) = (x as usize, y as usize);
        let (right, down) = ((x - column as f64) as f32, (y - row as f64) as f32);
        let first = row * (width + 2) + column;
        let upper = self.heights[first] + right * (self.heights[first + 1] - self.heights[first]);
        let below = first + width + 2;
        let lower = self.heights[below] + right * (self.heights[below + 1] - self.heights[below]);
        f64::from(upper + down * (lower - upper))
    }
}

/// Returns a texture coordinate as a position between the texel centres of a side with borders.
#[inline]
fn at_texel(v: f64, side: usize, wrap: Wrap) -> f64 {
    let inside = match wrap {
        Wrap::Repeat => {
            // `f64::floor` is a function call on processors without SSE 4.1.
            let part = v - (v as i64) as f64;
            if part < 0.0 { part + 1.0 } else { part }
        }
        Wrap::Clamp => v.clamp(0.0, 1.0),
    };
    inside * side as f64 + 0.5
}

impl Field {
    pub(super) fn new(facets: Facets<'_>, sign: f64) -> Self {
        let wrap = facets.wrap();
        let size = facets.size(None).map(|side| side as usize);
        let height = |i: usize| match facets {
            Facets::OfHeights(map, _) => map.texels[i],
            Facets::OfTexels(level, _) => level.texels[i].height,
            Facets::Flat => 0.0,
        };
        Self::of(size, wrap, sign, height)
    }

    /// Returns the heights of each window.
    pub(super) fn of_windows(windows: &[OpennessWindow], sign: f64) -> Vec<Self> {
        let of_window = |OpennessWindow { heights: HeightMap { width, height, texels }, .. }: &OpennessWindow| {
            Self::of([*width, *height].map(|side| side as usize), Wrap::Clamp, sign, |i| texels[i])
        };
        windows.par_iter().map(of_window).collect()
    }

    fn of(size: [usize; 2], wrap: Wrap, sign: f64, height: impl Fn(usize) -> f32) -> Self {
        let first = Level::new(size, wrap, |i| sign as f32 * height(i));
        let top = f64::from(first.heights.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        let mut levels = vec![first];
        while let Some(last) = levels.last().filter(|last| last.size.iter().all(|side| *side >= 8)) {
            levels.push(last.half(wrap));
        }
        Self { levels, top, sign, wrap }
    }

    /// Returns the height of a level at a texture coordinate.
    pub(super) fn height(&self, level: usize, at: DVec2) -> f64 {
        self.levels[level.min(self.levels.len() - 1)].at(at, self.wrap)
    }

    /// Returns facets from all parts of the map.
    fn sampled(&self, facets: Facets<'_>, classes: &Classes, material: Option<&ClassMaterial<'_>>) -> Vec<Sampled> {
        let material = classes.material(material);
        let size = DVec2::from(self.levels[0].size.map(|side| side as f64));
        let mut counts = [0; MOST_CLASSES];
        let mut sampled = Vec::new();
        for i in 0..MOST_FACETS {
            // The sequence R2, which covers the square evenly.
            let at = (DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053) * (i as f64 + 0.5)).fract() * size;
            let (facet, height) = facet_at(facets, at);
            let facet = Facet { material: material.at((at / size).to_array()), ..facet };
            let class = classes.of(&facet).min(MOST_CLASSES - 1);
            if counts[class] < MOST_OF_CLASS {
                counts[class] += 1;
                let facet = self.sign * facet.point.truncate().extend(height);
                sampled.push(Sampled { class, field: 0, at: at / size, facet });
            }
        }
        sampled
    }

    /// Returns the largest `|q|` at which a ray along `along`, from a height at a texture coordinate, passes all of the relief. Values above
    /// `most` are not exact.
    pub(super) fn reach(&self, from: DVec2, height: f64, along: DVec2, most: f64) -> f64 {
        self.reach_over(0, from, height, along, most)
    }

    /// Returns the reach of a ray over the texels of a level.
    pub(super) fn reach_over(&self, first: usize, from: DVec2, height: f64, along: DVec2, most: f64) -> f64 {
        let first = first.min(self.levels.len() - 1);
        let texel = (1u64 << first) as f64;
        let room = self.top - height;
        let size = DVec2::from(self.levels[0].size.map(|side| side as f64));
        let per_texel = (along * size).length().recip();
        let (mut reach, mut texels) = (f64::INFINITY, 0.25 * texel);
        let farthest = MOST_REPEATS * size.max_element();
        let mut levels = self.levels[first..].iter();
        let (mut level, mut last_step) = (levels.next().expect("there is a level"), 2.0 * texel);
        loop {
            let x = texels * per_texel;
            if x >= room * reach.min(most) || texels > farthest {
                return reach;
            }
            let step = (texels / FINE).max(0.5 * texel);
            // The texels of a level are at most as long as the steps.
            if step >= last_step {
                level = levels.next().unwrap_or(level);
                last_step *= 2.0;
            }
            let rise = level.at(from + along * x, self.wrap) - height;
            if rise * reach > x {
                reach = x / rise;
            }
            texels += step;
        }
    }
}

/// Returns the facet at a position in texels, and its height there.
fn facet_at(facets: Facets<'_>, at: DVec2) -> (Facet, f64) {
    match facets {
        Facets::OfTexels(level, _) => {
            let texel = &level.texels[at.y as usize * level.width as usize + at.x as usize];
            (Facet::of_texel(texel), f64::from(texel.height))
        }
        Facets::Flat => (Facet::default(), 0.0),
        Facets::OfHeights(map, wrap) => {
            let (cell, part) = ((at - 0.5).floor(), at - 0.5 - (at - 0.5).floor());
            let [x, y] = [cell.x as i64, cell.y as i64];
            let heights = [0, 1].map(|down| [0, 1].map(|right| map.beyond(x + right, y + down, wrap)));
            let size = DVec2::new(f64::from(map.width), f64::from(map.height));
            let cell = Cell::new(heights, size.to_array());
            let facet = cell.facet(Cell::edge_at(part));
            // Interpolated as in the field, so that no facet lies below it.
            let [upper, lower] = heights.map(|[left, right]| f64::from(left) + part.x * f64::from(right - left));
            (facet, upper + part.y * (lower - upper))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::classes;
    use crate::{ClassMap, HeightMap, procedural};

    /// Grooves across x with walls of slope 8 and a depth of 1/8, so the flat parts are 15/64 wide.
    fn grooves() -> HeightMap {
        let height = |x: f64| 0.125 * ((x - 0.5).abs() * 64.0 - 15.0).clamp(0.0, 1.0);
        let texels = (0..256 * 64).map(|i| height((f64::from(i % 256) + 0.5) / 256.0) as f32).collect();
        HeightMap { width: 256, height: 64, texels }
    }

    #[test]
    fn bottoms_close_where_walls_hide_them() {
        let map = grooves();
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [1.0; 2], None);
        let table = ClassMap::new(facets, &found, None);
        let open = Openness::new(facets, &found, None, table.units, false);
        let of_classes = table.mean();
        // The flat parts may be one class or two.
        let flat: Vec<_> = of_classes.iter().enumerate().filter(|(_, class)| class.covariance.x < 0.1).collect();
        let all: f64 = flat.iter().map(|(_, class)| class.share).sum();
        assert!((all - 62.0 / 64.0).abs() < 0.01, "{of_classes:?}");
        let units = DVec2::new(f64::from(table.units[0]), f64::from(table.units[1]));
        let at = |q: DVec2| {
            let open = open.towards(q.extend(1.0).normalize(), units);
            flat.iter().map(|&(k, class)| class.share / all * open[k]).sum::<f64>()
        };
        // Along the grooves nothing hides. Across, the wall hides a part of the bottom that is `q` times its height wide.
        assert!(at(DVec2::new(0.0, 3.0)) > 0.97);
        for q in [0.5, 1.0, 2.0, 3.0] {
            let (hidden, found) = (q * 0.125 * 64.0 / 62.0, 1.0 - at(DVec2::new(q, 0.0)));
            assert!((found - hidden).abs() < 0.05, "{q}: {found} instead of {hidden}");
        }
    }

    /// The table has few facets, azimuths and elevations, and marches in steps that grow.
    #[test]
    fn tables_agree_with_dense_marches() {
        let mut map = procedural::fbm(64, 48, 3, 4, 3, 0.5);
        map.texels.iter_mut().for_each(|h| *h = 0.2 * (6.0 * *h - 2.5).clamp(0.0, 1.0) + 0.02 * *h);
        let facets = Facets::OfHeights(&map, Wrap::Repeat);
        let found = classes(facets, [1.0; 2], None);
        assert!(found.count() > 1);
        let units = ClassMap::new(facets, &found, None).units;
        let open = Openness::new(facets, &found, None, units, false);
        let field = Field::new(facets, 1.0);
        let units = DVec2::new(f64::from(units[0]), f64::from(units[1]));
        let (mut squares, mut worst, mut count) = (0.0, 0.0f64, 0.0);
        for (i, q) in [0.3, 0.7, 1.5, 3.0, 6.0].into_iter().cycle().take(25).enumerate() {
            let angle = 2.4 * i as f64;
            // In repeats per unit of height.
            let along = DVec2::new(angle.cos(), angle.sin()) / units;
            let mut sums = [[0.0; 2]; MOST_CLASSES];
            for quarter in 0..4 * 64 * 48 {
                // A point anywhere in each quarter of a texel.
                let off = (DVec2::new(0.754_877_666, 0.569_840_291) * f64::from(quarter)).fract();
                let at = (DVec2::new(f64::from(quarter % 128), f64::from(quarter / 128)) + off) * 0.5;
                let (facet, height) = facet_at(facets, at);
                let area = (1.0 - q * along.dot(facet.point.truncate())).max(0.0);
                let class = found.of(&facet);
                let from = at / DVec2::new(64.0, 48.0);
                // Distances in units of `along`, in steps of a quarter of a texel. The triangle itself hides nothing.
                let marched = (2..).map(|step| 0.25 * f64::from(step) / 64.0 / along.length());
                let is_open = marched
                    .take_while(|x| height + x / q <= field.top)
                    .all(|x| field.levels[0].at(from + along * x, Wrap::Repeat) < height + x / q);
                sums[class][0] += if is_open { area } else { 0.0 };
                sums[class][1] += area;
            }
            let table = open.towards((along * units * q).extend(1.0).normalize(), DVec2::ONE);
            for ([open, all], table) in sums.into_iter().zip(table).filter(|(sums, _)| sums[1] > 400.0) {
                let error = table - open / all;
                (squares, count) = (squares + error * error, count + 1.0);
                worst = worst.max(error.abs());
            }
        }
        let rms = (squares / count).sqrt();
        println!("openness errs by {rms:.4}, at most {worst:.4}");
        assert!(rms < 0.02 && worst < 0.1, "{rms} {worst}");
    }
}
