//! Stores fitted materials as JSON files. `leadr fit` writes the files, and every command reads them.
//!
//! | field | content |
//! |---|---|
//! | `format`, `version` | `"leadr fit"`, 1 |
//! | `masking` | the masking model of the fit: `smith`, `vgroove` or `normal-map` |
//! | `diffuse` | the albedo of the diffuse base, in linear RGB |
//! | `fresnel` | the reflectances of the facets at even steps of the difference angle from 0 to 90°, in linear RGB |
//! | `residual` | whether `fresnel` is a residual, whose values can exceed 1; false if absent |
//! | `density` | the densities of facet normals at `θ = (i/n)² 90°`; if anisotropic, one row per azimuth `k/rows` of a turn |
//! | `lobes` | the Gaussian lobes of the same slopes: `share` and `covariance` `[xx, yy, xy]` |
//!
//! All other fields, such as roughness and errors, are informative only.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use leadr_maps::{MapError, MapFault, limits};
use leadr_reflectance::facets::fresnel::{Fresnel, FresnelTable, MAX_RESIDUAL};
use leadr_reflectance::facets::gaussian_mixture::{Lobe, MOST_LOBES};
use leadr_reflectance::facets::polar_table::PolarTable;
use leadr_reflectance::facets::radial_table::RadialTable;
use leadr_reflectance::facets::tabulated::Tabulated;
use leadr_reflectance::masking::variants::Masking;
use leadr_reflectance::materials::fitted::FittedBrdf;
use leadr_reflectance::materials::microfacet::Microfacet;

const FORMAT: &str = "leadr fit";
const VERSION: u64 = 1;
/// The maximum number of angles or azimuths in a table.
const MOST_NODES: usize = 1024;
const MOST_BYTES: u64 = 64 << 20;
/// The number of reflectances in a file.
const FRESNEL_ANGLES: usize = 46;
const MASKINGS: [(&str, Masking); 3] =
    [("smith", Masking::SmithCorrelated), ("vgroove", Masking::VGroove), ("normal-map", Masking::NormalMap)];

/// A fitted material that is stored in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FitFile {
    /// The facets and the diffuse base.
    pub brdf: FittedBrdf,
    /// The Gaussian lobes of the facets' slopes, at least one.
    pub lobes: Vec<Lobe>,
}

/// Returns the name that files use for a masking model.
pub fn masking_name(masking: Masking) -> &'static str {
    MASKINGS.iter().find(|(_, form)| *form == masking).map_or("smith", |(name, _)| name)
}

impl FitFile {
    /// Returns the stored fields as JSON. Callers may add informative fields.
    pub fn to_json(&self) -> Value {
        let facets = &self.brdf.facets;
        let step = std::f64::consts::FRAC_PI_2 / (FRESNEL_ANGLES - 1) as f64;
        let fresnel: Vec<[f64; 3]> =
            (0..FRESNEL_ANGLES).map(|i| facets.fresnel.at((step * i as f64).cos()).to_array()).collect();
        let density = match &facets.distribution {
            table @ Tabulated::Radial(_) => json!(table.densities()[0]),
            table @ Tabulated::Polar(_) => json!(table.densities()),
        };
        let lobes: Vec<Value> =
            self.lobes.iter().map(|l| json!({ "share": l.share, "covariance": l.covariance.to_array() })).collect();
        let mut value = json!({
            "format": FORMAT,
            "version": VERSION,
            "masking": masking_name(facets.masking),
            "diffuse": self.brdf.diffuse.to_array(),
            "fresnel": fresnel,
            "density": density,
            "lobes": lobes,
        });
        if matches!(&facets.fresnel, Fresnel::Tabulated(table) if table.is_residual()) {
            value["residual"] = json!(true);
        }
        value
    }

    /// Reads a fitted material from a file.
    ///
    /// # Errors
    /// Returns an error if the file is missing, has another format or version, or has missing or invalid fields.
    pub fn load(file: &Path) -> Result<Self, MapError> {
        Self::load_bytes(file).map_err(|fault| fault.in_file(file))
    }

    fn load_bytes(file: &Path) -> Result<Self, MapFault> {
        let bytes = limits::read_start(file, MOST_BYTES)?;
        let value: Value = serde_json::from_slice(&bytes)
            .map_err(|fault| MapFault::damaged(format!("it is not valid JSON ({fault})")))?;
        Self::from_json(&value)
    }

    /// Converts the JSON of a file to a fitted material.
    ///
    /// # Errors
    /// Returns the same errors as [`Self::load`].
    pub fn from_json(value: &Value) -> Result<Self, MapFault> {
        const REMEDY: &str = "give a file that leadr fit wrote";
        if value["format"].as_str() != Some(FORMAT) {
            return Err(MapFault::unsupported("it is not a fitted material", REMEDY));
        }
        if value["version"].as_u64() != Some(VERSION) {
            let what = format!("its version is {}; only {VERSION} is supported", value["version"]);
            return Err(MapFault::unsupported(what, REMEDY));
        }
        let name = value["masking"].as_str().unwrap_or_default();
        let masking = MASKINGS.iter().find(|(known, _)| *known == name).map(|(_, form)| *form);
        let masking = masking.ok_or_else(|| MapFault::damaged("its masking is not smith, vgroove or normal-map"))?;
        let diffuse = color(&value["diffuse"], "diffuse", 1.0)?;
        let reflectances = array(&value["fresnel"], "fresnel")?;
        if reflectances.len() > MOST_NODES {
            return Err(MapFault::damaged("its 'fresnel' is too long"));
        }
        let most = if value["residual"].as_bool() == Some(true) { MAX_RESIDUAL } else { 1.0 };
        let fresnel = reflectances.iter().map(|f| color(f, "fresnel", most)).collect::<Result<_, _>>()?;
        let fresnel = FresnelTable::residual(fresnel).map_err(MapFault::damaged)?;
        let rows = array(&value["density"], "density")?;
        let empty = || MapFault::damaged("its 'density' is not a table of densities");
        let distribution = if rows.iter().all(Value::is_number) {
            RadialTable::new(&densities(rows)?).map(Tabulated::Radial)
        } else {
            if rows.len() > MOST_NODES {
                return Err(empty());
            }
            let rows: Vec<Vec<f64>> =
                rows.iter().map(|row| densities(row.as_array().ok_or_else(empty)?)).collect::<Result<_, _>>()?;
            PolarTable::new(&rows).map(Tabulated::Polar)
        };
        let lobes = array(&value["lobes"], "lobes")?.iter().map(lobe).collect::<Result<Vec<_>, _>>()?;
        if lobes.is_empty() || lobes.len() > MOST_LOBES {
            return Err(MapFault::damaged(format!("it has {} lobes instead of 1 to {MOST_LOBES}", lobes.len())));
        }
        let facets =
            Microfacet { distribution: distribution.ok_or_else(empty)?, masking, fresnel: Fresnel::Tabulated(fresnel) };
        Ok(Self { brdf: FittedBrdf { facets, diffuse }, lobes })
    }
}

fn array<'a>(value: &'a Value, name: &str) -> Result<&'a Vec<Value>, MapFault> {
    value.as_array().ok_or_else(|| MapFault::damaged(format!("it has no array '{name}'")))
}

fn number(value: &Value, name: &str, least: f64, most: f64) -> Result<f64, MapFault> {
    let number = value.as_f64().filter(|x| (least..=most).contains(x));
    number.ok_or_else(|| MapFault::damaged(format!("'{name}' must contain numbers from {least} to {most}")))
}

fn numbers(value: &Value, name: &str, least: [f64; 3], most: f64) -> Result<DVec3, MapFault> {
    match value.as_array().map(Vec::as_slice) {
        Some([x, y, z]) => {
            let of = |value, axis: usize| number(value, name, least[axis], most);
            Ok(DVec3::new(of(x, 0)?, of(y, 1)?, of(z, 2)?))
        }
        _ => Err(MapFault::damaged(format!("'{name}' must be an array of three numbers"))),
    }
}

fn color(value: &Value, name: &str, most: f64) -> Result<DVec3, MapFault> {
    numbers(value, name, [0.0; 3], most)
}

fn densities(values: &[Value]) -> Result<Vec<f64>, MapFault> {
    if values.len() > MOST_NODES {
        return Err(MapFault::damaged(format!("its 'density' has more than {MOST_NODES} angles")));
    }
    values.iter().map(|d| number(d, "density", 0.0, 1e30)).collect()
}

fn lobe(value: &Value) -> Result<Lobe, MapFault> {
    let share = number(&value["share"], "share", 0.0, 1.0)?;
    let covariance = numbers(&value["covariance"], "covariance", [0.0, 0.0, -1e12], 1e12)?;
    if covariance.z * covariance.z > covariance.x * covariance.y {
        return Err(MapFault::damaged("a lobe's covariance is not positive semidefinite"));
    }
    Ok(Lobe { share, covariance })
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::materials::brdf::Brdf as _;

    fn sample(polar: bool) -> FitFile {
        let d = |i: usize, k: usize| (-(i as f64) * 0.3 * (1.0 + 0.1 * k as f64)).exp();
        let distribution = if polar {
            let rows: Vec<Vec<f64>> = (0..4).map(|k| (0..12).map(|i| d(i, k % 2)).collect()).collect();
            Tabulated::Polar(PolarTable::new(&rows).unwrap())
        } else {
            Tabulated::Radial(RadialTable::new(&(0..12).map(|i| d(i, 0)).collect::<Vec<_>>()).unwrap())
        };
        let fresnel = FresnelTable::new(vec![DVec3::new(0.9, 0.5, 0.2), DVec3::ONE]).unwrap();
        FitFile {
            brdf: FittedBrdf {
                facets: Microfacet { distribution, masking: Masking::VGroove, fresnel: Fresnel::Tabulated(fresnel) },
                diffuse: DVec3::new(0.1, 0.2, 0.3),
            },
            lobes: vec![Lobe { share: 1.0, covariance: DVec3::new(0.1, 0.2, 0.05) }],
        }
    }

    #[test]
    fn files_hold_the_material() {
        for polar in [false, true] {
            let fit = sample(polar);
            let text = fit.to_json().to_string();
            let back = FitFile::from_json(&serde_json::from_str(&text).unwrap()).unwrap();
            assert_eq!(back.lobes, fit.lobes);
            for (x, y) in [(0.1, 0.2), (-0.5, 0.3), (0.0, 0.9f64)] {
                let (wo, wi) = (DVec3::new(x, y, 0.6).normalize(), DVec3::new(y, -x, 0.7).normalize());
                let (a, b) = (fit.brdf.eval(wo, wi), back.brdf.eval(wo, wi));
                assert!((a - b).length() < 1e-9 * a.length().max(1e-3), "{a} {b}");
            }
        }
    }

    #[test]
    fn residuals_are_kept_only_if_declared() {
        let mut fit = sample(false);
        fit.brdf.facets.fresnel =
            Fresnel::Tabulated(FresnelTable::residual(vec![DVec3::new(1.7, 0.5, 0.2), DVec3::splat(40.0)]).unwrap());
        let mut value = fit.to_json();
        let back = FitFile::from_json(&value).unwrap().brdf.facets.fresnel;
        assert!((back.at(1.0) - DVec3::new(1.7, 0.5, 0.2)).length() < 1e-12 && back.at(0.0).x > 39.0);
        value["residual"] = json!(false);
        assert!(FitFile::from_json(&value).unwrap_err().to_string().contains("fresnel"));
    }

    #[test]
    fn missing_files_are_reported() {
        let good = sample(false).to_json();
        assert!(FitFile::from_json(&good).is_ok());
        for (field, bad, word) in [
            ("format", json!("other"), "not a fitted material"),
            ("version", json!(2), "version is 2"),
            ("masking", json!("fog"), "masking"),
            ("diffuse", json!([0.1, 0.2]), "diffuse"),
            ("diffuse", json!([0.1, 0.2, 7.0]), "diffuse"),
            ("fresnel", json!([[1.0, 1.0, 1.0]]), "Fresnel"),
            ("density", json!([1.0, 0.5, -1.0]), "density"),
            ("density", json!([0.0, 0.0, 0.0]), "density"),
            ("density", json!([[1.0, 0.5], [1.0, 0.5]]), "density"),
            ("density", json!(["a"]), "density"),
            ("density", json!(vec![1.0; 2000]), "density"),
            ("lobes", json!([]), "0 lobes"),
            ("lobes", json!([{ "share": 1.0, "covariance": [0.1, 0.1, 0.2] }]), "covariance"),
            ("lobes", json!([{ "share": 1e300, "covariance": [0.1, 0.1, 0.0] }]), "share"),
        ] {
            let mut value = good.clone();
            value[field] = bad;
            let fault = FitFile::from_json(&value).unwrap_err().to_string();
            assert!(fault.contains(word), "{field}: {fault}");
        }
    }
}
