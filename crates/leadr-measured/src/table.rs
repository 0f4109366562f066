//! Measurements in `.csv` text. A header line has the column names, and every other line has one measurement.
//!
//! * `theta,r,g,b` or `theta,value`: the backscattering `f_r(o, o)` at angles to the normal. Such a table has no other directions.
//! * `theta_h,theta_d`, optionally `phi_d`, and then `r,g,b` or `value`: half and difference angles, which form a full grid in any order.
//!   Without `phi_d`, values do not depend on it.
//!
//! Angles are in degrees. Lines that start with `#` are comments. Values are interpolated linearly, and are constant beyond the ends.

use glam::DVec3;

use super::values::{around, bracket, polar, reflectance};
use leadr_maps::MapFault;
use leadr_reflectance::materials::half_difference::directions_to_half_difference;

const MOST_ROWS: usize = 4_000_000;
const MOST_COLUMNS: usize = 6;

/// A material that is measured in a table.
#[derive(Clone, Debug)]
pub struct Table {
    /// The angles along θ_h, θ_d and φ_d, in degrees.
    axes: [Vec<f64>; 3],
    /// The values, with θ_h varying slowest.
    values: Vec<DVec3>,
}

impl Table {
    /// Reads a material from the text of a file.
    ///
    /// # Errors
    /// Returns an error if a column is unknown, a field is not a number, or the grid is incomplete.
    pub fn read(text: &str) -> Result<Self, MapFault> {
        let mut lines = text.lines().enumerate().filter(|(_, line)| {
            let line = line.trim();
            !line.is_empty() && !line.starts_with('#')
        });
        let (_, head) = lines.next().ok_or_else(|| MapFault::damaged("it has no lines"))?;
        let names: Vec<String> =
            head.trim_start_matches('\u{feff}').split(',').map(|name| name.trim().to_ascii_lowercase()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).take(MOST_COLUMNS + 1).collect();
        let (angles, channels) = columns(&names)?;
        let mut rows: Vec<([f64; 3], DVec3)> = Vec::new();
        for (number, line) in lines {
            let fault = |what: String| MapFault::damaged(format!("line {}: {what}", number + 1));
            let mut fields = [0.0; MOST_COLUMNS];
            let mut count = 0;
            for field in line.split(',') {
                let value =
                    field.trim().parse::<f64>().map_err(|_| fault(format!("'{}' is not a number", shorten(field))))?;
                *fields.get_mut(count).ok_or_else(|| fault("too many columns".to_owned()))? = value;
                count += 1;
            }
            if count != names.len() {
                return Err(fault(format!("{count} columns instead of {}", names.len())));
            }
            if rows.len() == MOST_ROWS {
                return Err(fault(format!("more than {MOST_ROWS} measurements")));
            }
            let mut coordinates = [0.0; 3];
            for (i, &axis) in angles.iter().enumerate() {
                let most = if axis == 2 { 360.0 } else { 90.0 };
                if !(0.0..=most).contains(&fields[i]) {
                    return Err(fault(format!("{} is not an angle from 0 to {most} degrees", fields[i])));
                }
                coordinates[axis] = fields[i];
            }
            let mut value = [0.0; 3];
            for (c, value) in value.iter_mut().enumerate() {
                let column = angles.len() + if channels == 1 { 0 } else { c };
                *value = reflectance(fields[column], || format!("line {}", number + 1))?;
            }
            rows.push((coordinates, DVec3::from_array(value)));
        }
        Self::from_rows(rows)
    }

    pub(super) fn from_rows(mut rows: Vec<([f64; 3], DVec3)>) -> Result<Self, MapFault> {
        let axes = [0, 1, 2].map(|axis| {
            let mut all: Vec<f64> = rows.iter().map(|(coordinates, _)| coordinates[axis]).collect();
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        });
        if axes[0].len() < 3 {
            return Err(MapFault::damaged("it has fewer than three angles to the normal"));
        }
        let cells = axes.iter().try_fold(1usize, |product, axis| product.checked_mul(axis.len()));
        rows.sort_by(|(a, _), (b, _)| {
            a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        });
        if let Some(twice) = rows.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(MapFault::damaged(format!("the angles {:?} occur twice", twice[0].0)));
        }
        if cells != Some(rows.len()) {
            let sizes = axes.each_ref().map(Vec::len);
            let what = format!("its {} measurements are not a full grid of {sizes:?} angles", rows.len());
            return Err(MapFault::damaged(what));
        }
        Ok(Self { axes, values: rows.into_iter().map(|(_, value)| value).collect() })
    }

    /// Whether the table contains only backscattering.
    pub fn is_backscattering(&self) -> bool {
        self.axes[1].len() == 1
    }

    /// Returns `f_r` for two directions above the horizon.
    pub(super) fn value(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let p = directions_to_half_difference(wo, wi);
        let mut phi = p.wd.y.atan2(p.wd.x).to_degrees().rem_euclid(360.0);
        let most = self.axes[2].last().copied().unwrap_or(0.0);
        // Swapping the directions shifts φ_d by half a turn, so a table may omit the second half turn.
        if most <= 180.0 {
            phi = phi.rem_euclid(180.0);
        }
        let coordinates = [polar(p.wh).to_degrees(), polar(p.wd).to_degrees(), phi];
        let axes = [0, 1, 2].map(|axis| {
            let (low, high, t) = bracket(&self.axes[axis], coordinates[axis]);
            (self.axes[axis].len(), [low, high], t)
        });
        around(axes).filter(|(_, share)| *share > 0.0).map(|(index, share)| share * self.values[index]).sum()
    }
}

/// Returns which angle each leading column holds, and the number of channels.
fn columns(names: &[&str]) -> Result<(Vec<usize>, usize), MapFault> {
    let (angles, rest): (&[usize], &[&str]) = match names {
        ["theta", rest @ ..] => (&[0], rest),
        ["theta_h", "theta_d", "phi_d", rest @ ..] => (&[0, 1, 2], rest),
        ["theta_h", "theta_d", rest @ ..] => (&[0, 1], rest),
        _ => (&[], names),
    };
    let channels = match rest {
        ["r", "g", "b"] => 3,
        ["value"] => 1,
        _ => 0,
    };
    if angles.is_empty() || channels == 0 {
        let remedy = "start with the column names: theta or theta_h,theta_d[,phi_d], then r,g,b or value";
        return Err(MapFault::unsupported(format!("its first line is '{}'", shorten(&names.join(","))), remedy));
    }
    Ok((angles.to_vec(), channels))
}

fn shorten(text: &str) -> String {
    text.trim().chars().filter(|c| !c.is_control()).take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(degrees: f64) -> DVec3 {
        let theta = degrees.to_radians();
        DVec3::new(theta.sin(), 0.0, theta.cos())
    }

    #[test]
    fn tables_are_interpolated() {
        let back = Table::read("\u{feff}theta, r,g,b\n# a comment\n0,1,2,3\n\n30,0.5,1,1.5\n60,0,0,0\n").unwrap();
        assert!(back.is_backscattering());
        for (degrees, expected) in [(0.0, 1.0), (15.0, 0.75), (30.0, 0.5), (45.0, 0.25), (80.0, 0.0)] {
            let found = back.value(direction(degrees), direction(degrees));
            assert!((found - expected * DVec3::new(1.0, 2.0, 3.0)).length() < 1e-9, "{degrees}: {found}");
        }
        let grid = Table::read("theta_h,theta_d,value\n0,0,1\n0,80,3\n90,80,7\n90,0,5\n45,0,3\n45,80,5\n").unwrap();
        let found = grid.value(direction(40.0), direction(-40.0));
        assert!((found.x - 2.0).abs() < 1e-9, "{found}");
    }

    #[test]
    fn invalid_tables_report_their_line() {
        for (text, word) in [
            ("", "no lines"),
            ("angle,value\n1,2\n", "first line is 'angle,value'"),
            ("theta,value\n0,1\n30,x\n60,1\n", "line 3: 'x' is not a number"),
            ("theta,value\n0,1\n30\n60,1\n", "line 3: 1 columns instead of 2"),
            ("theta,value\n0,1,2,3,4,5,6,7,8\n", "line 2"),
            ("theta,value\n0,1\n95,1\n60,1\n", "95 is not an angle"),
            ("theta,value\n0,1\n30,NaN\n60,1\n", "line 3 is NaN"),
            ("theta,value\n0,1\n30,1\n", "fewer than three angles"),
            ("theta,value\n0,1\n30,1\n30,2\n60,1\n", "occur twice"),
            ("theta_h,theta_d,value\n0,0,1\n30,0,1\n60,0,1\n60,10,1\n", "not a full grid"),
        ] {
            let fault = Table::read(text).unwrap_err().to_string();
            assert!(fault.contains(word), "{text:?}: {fault}");
        }
    }
}
