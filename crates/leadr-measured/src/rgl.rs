//! The RGL database (Dupuy and Jakob 2018, "An adaptive parameterization for efficient material acquisition and rendering").
//!
//! A *tensor file* holds named arrays. The material is stored for a few light directions, in coordinates of the unit square in which its
//! visible normals are uniform:
//!
//! ```text
//! f_r(wi, wo) cos θ_o = value(u) D(wm) / (4 σ(wi)),   where u is the cumulative share of visible normals up to wm, along θ and φ
//! ```
//!
//! The file also has arrays for `D`, `σ` and the visible normals, all over `√(θ · 2/π)` and `(φ + π) / 2π`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use super::bytes::Bytes;
use super::values::{bracket, polar};
use leadr_maps::MapFault;
use leadr_maps::shown::shown;

pub(super) const MAGIC: &[u8] = b"tensor_file\0";
/// The maximum number of arrays in a file. No file of the database has as many.
const MOST_FIELDS: u32 = 64;
const MOST_AXES: u16 = 8;

/// A material of the RGL database, in linear RGB.
#[derive(Clone, Debug)]
pub struct Rgl {
    description: String,
    phi_i: Vec<f64>,
    theta_i: Vec<f64>,
    /// The symmetry factor of the light's azimuth. It is 1 if the file covers a full turn, 2 for half a turn, and 4 for a quarter turn.
    reduction: u32,
    jacobian: bool,
    ndf: Grid,
    sigma: Grid,
    /// The visible normals for each light direction.
    visible: Vec<Warp>,
    /// The grids of each light direction, with its R, G and B grids in sequence.
    values: Vec<Grid>,
}

/// Whether the bytes start with the tensor file signature.
pub fn is_rgl(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// A grid of at least 2 × 2 values over the unit square, with bilinear interpolation.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) values: Vec<f32>,
}

impl Grid {
    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    fn get(&self, x: usize, y: usize) -> f64 {
        f64::from(self.values[y * self.width + x])
    }

    /// Returns the column and row of the cell around a position, and the fractions of the position within the cell.
    fn cell(&self, at: DVec2) -> (usize, usize, f64, f64) {
        let along = |t: f64, n: usize| {
            let cell = if t > 0.0 { t.min(1.0) } else { 0.0 } * (n - 1) as f64;
            let low = (cell as usize).min(n - 2);
            (low, cell - low as f64)
        };
        let ((x, fx), (y, fy)) = (along(at.x, self.width), along(at.y, self.height()));
        (x, y, fx, fy)
    }

    pub(super) fn at(&self, at: DVec2) -> f64 {
        let (x, y, fx, fy) = self.cell(at);
        let row = |y| (1.0 - fx) * self.get(x, y) + fx * self.get(x + 1, y);
        (1.0 - fy) * row(y) + fy * row(y + 1)
    }
}

/// A density over the unit square, with cumulative sums along each row and over the rows.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    density: Grid,
    before: Vec<f64>,
    rows_before: Vec<f64>,
}

impl Warp {
    pub(super) fn new(mut density: Grid) -> Self {
        let (w, h) = (density.width, density.height());
        let sums = |density: &Grid| {
            let mut before = vec![0.0; w * h];
            for y in 0..h {
                for x in 1..w {
                    before[y * w + x] = before[y * w + x - 1] + 0.5 * (density.get(x - 1, y) + density.get(x, y));
                }
            }
            let mut rows = vec![0.0; h];
            for y in 1..h {
                rows[y] = rows[y - 1] + 0.5 * (before[y * w - 1] + before[(y + 1) * w - 1]);
            }
            (before, rows)
        };
        let (mut before, mut rows_before) = sums(&density);
        let all = rows_before[h - 1].max(1e-30);
        density.values.iter_mut().for_each(|v| *v = (f64::from(*v) / all) as f32);
        before.iter_mut().chain(&mut rows_before).for_each(|v| *v /= all);
        Self { density, before, rows_before }
    }

    /// Returns three cumulative sums at a position: over the square before its row, over its row before the position, and over its whole
    /// row. The sums are linear in the density, so the sums of several densities can be blended.
    pub(super) fn shares(&self, at: DVec2) -> DVec3 {
        let (x, y, fx, fy) = self.density.cell(at);
        let w = self.density.width;
        let mix = |a: f64, b: f64| (1.0 - fy) * a + fy * b;
        let (this, next) = (self.before[(y + 1) * w - 1], self.before[(y + 2) * w - 1]);
        let density = |x| mix(self.density.get(x, y), self.density.get(x, y + 1));
        let (from, to) = (density(x), density(x + 1));
        let rows = self.rows_before[y] + fy * (this + 0.5 * fy * (next - this));
        let before = mix(self.before[y * w + x], self.before[(y + 1) * w + x]) + fx * (from + 0.5 * fx * (to - from));
        DVec3::new(rows, before, mix(this, next))
    }
}

impl Rgl {
    /// Whether the material is isotropic.
    pub fn is_isotropic(&self) -> bool {
        self.phi_i.len() <= 2
    }

    /// Returns the description in the file.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Reads a material from the content of a file.
    ///
    /// # Errors
    /// Returns an error if the version is unsupported, if arrays are missing, of the wrong type or size, or outside the file, or if the
    /// file holds spectra instead of RGB.
    pub fn read(bytes: &[u8]) -> Result<Self, MapFault> {
        let fields = Fields::read(bytes)?;
        if fields.find("rgb").is_none() && fields.find("spectra").is_some() {
            return Err(MapFault::unsupported("it holds spectra", "download its _rgb.bsdf from the database"));
        }
        let [phi_i, theta_i] = ["phi_i", "theta_i"].map(|name| fields.axis(name));
        let (phi_i, theta_i) = (phi_i?, theta_i?);
        let grids = |name: &str, leading: &[usize]| fields.grids(name, leading);
        let one = |name: &str| -> Result<Grid, MapFault> { Ok(grids(name, &[])?.remove(0)) };
        let visible = grids("vndf", &[phi_i.len(), theta_i.len()])?.into_iter().map(Warp::new).collect();
        let values = grids("rgb", &[phi_i.len(), theta_i.len(), 3])?;
        let range = phi_i[phi_i.len() - 1] - phi_i[0];
        let reduction = if phi_i.len() <= 2 { 1 } else { (TAU / range).round().clamp(1.0, 4.0) as u32 };
        if reduction == 3 {
            let what = format!("its phi_i span {range} radians, which is not a full, half or quarter turn");
            return Err(MapFault::damaged(what));
        }
        let text = fields.bytes("description").unwrap_or_default();
        let description = String::from_utf8_lossy(text).trim_end_matches('\0').trim().to_owned();
        let jacobian = fields.bytes("jacobian").is_none_or(|bytes| bytes.first() != Some(&0));
        Ok(Self {
            description,
            phi_i,
            theta_i,
            reduction,
            jacobian,
            ndf: one("ndf")?,
            sigma: one("sigma")?,
            visible,
            values,
        })
    }

    /// Returns `f_r` for two directions above the horizon.
    pub(super) fn value(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let flipped =
            |v: DVec3, x: bool, y: bool| DVec3::new(if x { -v.x } else { v.x }, if y { -v.y } else { v.y }, v.z);
        let (flip_x, flip_y) = match self.reduction {
            4 => (wi.x > 0.0, wi.y > 0.0),
            2 => (wi.y > 0.0, wi.y > 0.0),
            _ => (false, false),
        };
        let (wo, wi) = (flipped(wo, flip_x, flip_y), flipped(wi, flip_x, flip_y));
        let wm = (wo + wi).normalize_or(DVec3::Z);
        let angles = |w: DVec3| (polar(w), w.y.atan2(w.x));
        let ((theta_i, phi_i), (theta_m, phi_m)) = (angles(wi), angles(wm));
        let cell = |theta: f64, phi: f64| DVec2::new((theta / FRAC_PI_2).sqrt(), ((phi + PI) / TAU).rem_euclid(1.0));
        let to_m = cell(theta_m, if self.is_isotropic() { phi_m - phi_i } else { phi_m });
        let (p0, p1, p) = bracket(&self.phi_i, phi_i);
        let (t0, t1, t) = bracket(&self.theta_i, theta_i);
        let index = |p: usize, t: usize| p * self.theta_i.len() + t;
        let around = [
            (index(p0, t0), (1.0 - p) * (1.0 - t)),
            (index(p0, t1), (1.0 - p) * t),
            (index(p1, t0), p * (1.0 - t)),
            (index(p1, t1), p * t),
        ];
        let around = || around.into_iter().filter(|(_, weight)| *weight > 0.0);
        let shares = around().map(|(i, weight)| weight * self.visible[i].shares(to_m));
        let [rows, before, row] = shares.fold(DVec3::ZERO, |sum, share| sum + share).to_array();
        let u = DVec2::new(before / row.max(1e-30), rows);
        let channel = |c: usize| around().map(|(i, weight)| weight * self.values[3 * i + c].at(u)).sum::<f64>();
        let scale =
            if self.jacobian { self.ndf.at(to_m) / (4.0 * self.sigma.at(cell(theta_i, phi_i)).max(1e-9)) } else { 1.0 };
        (DVec3::new(channel(0), channel(1), channel(2)) * (scale / wo.z.max(1e-6))).max(DVec3::ZERO)
    }
}

/// The arrays of a tensor file.
struct Fields<'a> {
    all: Vec<Field<'a>>,
}

struct Field<'a> {
    name: &'a [u8],
    kind: u8,
    shape: Vec<usize>,
    bytes: &'a [u8],
}

/// The type codes of signed and unsigned bytes.
const BYTE_KINDS: [u8; 2] = [1, 2];
const FLOAT: u8 = 10;

/// The size in bytes of each type code, starting with code 1.
const KIND_BYTES: [usize; 11] = [1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

impl<'a> Fields<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, MapFault> {
        let mut from = Bytes::new(bytes);
        from.take(MAGIC.len())?;
        let [major, minor] = [from.u8()?, from.u8()?];
        if major != 1 {
            let what = format!("it is a tensor file of version {major}.{minor}");
            return Err(MapFault::unsupported(what, "only version 1 is supported"));
        }
        let count = from.u32()?;
        if count > MOST_FIELDS {
            return Err(MapFault::damaged(format!("it declares {count} arrays")));
        }
        let all = (0..count).map(|_| Field::read(&mut from, bytes)).collect::<Result<_, _>>()?;
        Ok(Self { all })
    }

    fn find(&self, name: &str) -> Option<&Field<'a>> {
        self.all.iter().find(|field| field.name == name.as_bytes())
    }

    fn bytes(&self, name: &str) -> Option<&'a [u8]> {
        self.find(name).filter(|field| BYTE_KINDS.contains(&field.kind)).map(|field| field.bytes)
    }

    fn floats(&self, name: &str) -> Result<(&[usize], Vec<f32>), MapFault> {
        let field = self.find(name).ok_or_else(|| MapFault::damaged(format!("it has no array '{name}'")))?;
        if field.kind != FLOAT {
            return Err(MapFault::damaged(format!("its array '{name}' does not hold 32-bit floats")));
        }
        let floats: Vec<f32> = field.bytes.as_chunks().0.iter().map(|chunk| f32::from_le_bytes(*chunk)).collect();
        match floats.iter().position(|v| !v.is_finite()) {
            Some(i) => Err(MapFault::damaged(format!("value {i} of its array '{name}' is {}", floats[i]))),
            None => Ok((&field.shape, floats)),
        }
    }

    /// Returns an array of ascending angles.
    fn axis(&self, name: &str) -> Result<Vec<f64>, MapFault> {
        let (shape, floats) = self.floats(name)?;
        if shape.len() != 1 || floats.is_empty() || floats.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(MapFault::damaged(format!("its array '{name}' is not a row of ascending angles")));
        }
        Ok(floats.into_iter().map(f64::from).collect())
    }

    /// Returns one grid per combination of the leading axes.
    fn grids(&self, name: &str, leading: &[usize]) -> Result<Vec<Grid>, MapFault> {
        let (shape, floats) = self.floats(name)?;
        let wrong =
            || MapFault::damaged(format!("its array '{name}' has {shape:?} values, which do not fit the others"));
        let (first, last) = shape.split_at_checked(leading.len()).ok_or_else(wrong)?;
        let &[height, width] = last else { return Err(wrong()) };
        if first != leading || height < 2 || width < 2 {
            return Err(wrong());
        }
        // Out-of-gamut colours may be negative, but densities may not.
        if name != "rgb" && floats.iter().any(|v| *v < -1e-3) {
            return Err(MapFault::damaged(format!("its array '{name}' has negative values")));
        }
        Ok(floats.chunks_exact(width * height).map(|values| Grid { width, values: values.to_vec() }).collect())
    }
}

impl<'a> Field<'a> {
    fn read(from: &mut Bytes<'a>, file: &'a [u8]) -> Result<Self, MapFault> {
        let length = from.u16()?;
        let name = from.take(usize::from(length))?;
        let named = || shown(&String::from_utf8_lossy(name));
        let axes = from.u16()?;
        if axes > MOST_AXES {
            return Err(MapFault::damaged(format!("its array '{}' has {axes} axes", named())));
        }
        let kind = from.u8()?;
        let offset = from.u64()?;
        let outside = || MapFault::damaged(format!("its array '{}' lies outside the file (truncated?)", named()));
        let (mut shape, mut count) = (Vec::new(), 1usize);
        for _ in 0..axes {
            let size = usize::try_from(from.u64()?).map_err(|_| outside())?;
            count = count.checked_mul(size).ok_or_else(outside)?;
            shape.push(size);
        }
        let size = usize::from(kind).checked_sub(1).and_then(|i| KIND_BYTES.get(i).copied());
        let size = size.ok_or_else(|| MapFault::damaged(format!("its array '{}' is of type {kind}", named())))?;
        let start = usize::try_from(offset).map_err(|_| outside())?;
        let end = count.checked_mul(size).and_then(|n| start.checked_add(n)).ok_or_else(outside)?;
        let bytes = file.get(start..end).ok_or_else(outside)?;
        Ok(Self { name, kind, shape, bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a tensor file of floats and bytes.
    fn file(fields: &[(&str, &[u64], Vec<f32>)]) -> Vec<u8> {
        let mut head = MAGIC.to_vec();
        head.extend([1, 0]);
        head.extend((fields.len() as u32).to_le_bytes());
        let length = |(name, shape, _): &(&str, &[u64], Vec<f32>)| 2 + name.len() + 2 + 1 + 8 + 8 * shape.len();
        let mut offset = head.len() + fields.iter().map(length).sum::<usize>();
        let mut body = Vec::new();
        for (name, shape, values) in fields {
            head.extend((name.len() as u16).to_le_bytes());
            head.extend(name.as_bytes());
            head.extend((shape.len() as u16).to_le_bytes());
            head.push(FLOAT);
            head.extend((offset as u64).to_le_bytes());
            shape.iter().for_each(|n| head.extend(n.to_le_bytes()));
            values.iter().for_each(|v| body.extend(v.to_le_bytes()));
            offset += 4 * values.len();
        }
        head.extend(body);
        head
    }

    /// Returns a constant material with normals of density 1 and projected area 1, so that `f_r cos θ_o` is a quarter of the value.
    fn plain() -> Vec<(&'static str, &'static [u64], Vec<f32>)> {
        vec![
            ("phi_i", &[1], vec![0.0]),
            ("theta_i", &[2], vec![0.0, 1.5]),
            ("sigma", &[2, 4], vec![1.0; 8]),
            ("ndf", &[2, 4], vec![1.0; 8]),
            ("vndf", &[1, 2, 4, 4], vec![1.0; 32]),
            ("rgb", &[1, 2, 3, 2, 2], [[0.8f32; 4], [0.4; 4], [0.2; 4], [1.6; 4], [0.8; 4], [0.4; 4]].concat()),
        ]
    }

    fn direction(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    #[test]
    fn values_are_scaled_by_facets_and_cosine() {
        let rgl = Rgl::read(&file(&plain())).unwrap();
        assert!(rgl.is_isotropic());
        for (theta_i, factor) in [(0.0, 1.0), (0.75, 1.5), (1.5, 2.0)] {
            let (wi, wo) = (direction(theta_i, 0.4), direction(0.6, 2.0));
            let expected = DVec3::new(0.8, 0.4, 0.2) * factor / (4.0 * wo.z);
            assert!((rgl.value(wo, wi) - expected).length() < 1e-5, "{theta_i}: {}", rgl.value(wo, wi));
        }
    }

    #[test]
    fn warp_is_the_cumulative_share() {
        // The density is 2x over the unit square.
        let n = 5usize;
        let values = (0..n * n).map(|i| (i % n) as f32 / 4.0).collect();
        let warp = Warp::new(Grid { width: n, values });
        for (x, y) in [(0.0, 0.0), (0.3, 0.4), (0.5, 0.9), (1.0, 1.0)] {
            let [rows, before, row] = warp.shares(DVec2::new(x, y)).to_array();
            assert!((before / row - x * x).abs() < 1e-6 && (rows - y).abs() < 1e-6, "{x} {y}");
        }
    }

    #[test]
    fn damage_is_reported() {
        let good = file(&plain());
        // Every truncation gives an error or the same material.
        for length in 0..good.len() {
            let _ = Rgl::read(&good[..length]);
        }
        for i in 0..good.len().min(400) {
            for bit in [1u8, 0x80] {
                let mut bytes = good.clone();
                bytes[i] ^= bit;
                let _ = Rgl::read(&bytes).map(|rgl| rgl.value(direction(0.3, 0.0), direction(0.5, 1.0)));
            }
        }
        let changed = |field: usize, shape: &'static [u64], values: Vec<f32>| {
            let mut fields = plain();
            fields[field] = (fields[field].0, shape, values);
            Rgl::read(&file(&fields)).unwrap_err().to_string()
        };
        assert!(changed(1, &[2], vec![1.0, 0.5]).contains("'theta_i' is not a row of ascending angles"));
        assert!(changed(3, &[4], vec![1.0; 4]).contains("'ndf' has [4] values"));
        assert!(changed(3, &[2, 4], vec![f32::NAN; 8]).contains("value 0 of its array 'ndf' is NaN"));
        assert!(changed(4, &[1, 2, 4, 4], vec![-1.0; 32]).contains("negative"));
        assert!(changed(4, &[2, 1, 4, 4], vec![1.0; 32]).contains("'vndf' has"));
        let mut fields = plain();
        fields[5].0 = "spectra";
        assert!(Rgl::read(&file(&fields)).unwrap_err().to_string().contains("_rgb.bsdf"));
        fields.pop();
        assert!(Rgl::read(&file(&fields)).unwrap_err().to_string().contains("no array 'rgb'"));
        let mut bytes = good.clone();
        bytes[12] = 2;
        assert!(Rgl::read(&bytes).unwrap_err().to_string().contains("version 2.0"));
        bytes = good;
        bytes[14..18].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(Rgl::read(&bytes).unwrap_err().to_string().contains("4294967295 arrays"));
    }
}
