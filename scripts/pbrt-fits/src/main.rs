//! What pbrt makes of the materials that `leadr fit --pbrt` writes:
//! `cargo run --release --manifest-path scripts/pbrt-fits/Cargo.toml -- MEASURED FILE.pbrt`
//!
//! The crate `pbrt4` reads the file as pbrt-v4 does. Facets and bodies are evaluated by `rs_pbrt`, a port of pbrt-v3, whose GGX, masking and
//! conductors are those of v4. It prints the error beside `MEASURED`, which is to be the one that `leadr fit --json` tells. Coats, which v4
//! draws by random walks, are read and not evaluated.

use std::collections::HashMap;
use std::path::Path;
use std::process::ExitCode;

use glam::DVec3;
use leadr_measured::Measured;
use leadr_reflectance::extraction::samples::{misfit, samples};
use leadr_reflectance::materials::brdf::Brdf;
use rs_pbrt::core::geometry::Vector3f;
use rs_pbrt::core::microfacet::{MicrofacetDistribution, TrowbridgeReitzDistribution};
use rs_pbrt::core::pbrt::Spectrum;
use rs_pbrt::core::reflection::{Bxdf, Fresnel, FresnelConductor, LambertianReflection, MicrofacetReflection};

/// Bases of rs_pbrt, each with its share.
struct Material(Vec<(f64, Bxdf)>);

impl Brdf for Material {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let vector = |w: DVec3| Vector3f { x: w.x as f32, y: w.y as f32, z: w.z as f32 };
        let value = |bxdf: &Bxdf| DVec3::from(bxdf.f(&vector(wo), &vector(wi)).c.map(f64::from));
        wi.z.max(0.0) * self.0.iter().map(|(share, bxdf)| *share * value(bxdf)).sum::<DVec3>()
    }
}

/// Values of a material's parameters, by type and name.
type Parameters<'a> = HashMap<&'a str, Vec<&'a str>>;

/// Words, brackets, and strings with their quotes.
fn tokens(text: &str) -> Vec<&str> {
    let (mut rest, mut all) = (text, Vec::new());
    loop {
        rest = rest.trim_start();
        let length = match rest.chars().next() {
            None => return all,
            Some('#') => {
                rest = rest.split_once('\n').map_or("", |(_, after)| after);
                continue;
            }
            Some('"') => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            Some('[' | ']') => 1,
            Some(_) => rest.find(|c: char| c.is_whitespace() || "[]\"#".contains(c)).unwrap_or(rest.len()),
        };
        all.push(&rest[..length]);
        rest = &rest[length..];
    }
}

/// The named materials of a file, in its order.
fn named(text: &str) -> Result<Vec<(&str, Parameters<'_>)>, String> {
    let mut all: Vec<(&str, Parameters<'_>)> = Vec::new();
    let mut tokens = tokens(text).into_iter().peekable();
    while let Some(word) = tokens.next() {
        if word == "MakeNamedMaterial" {
            all.push((tokens.next().ok_or("a material without a name")?.trim_matches('"'), Parameters::new()));
            continue;
        }
        let (_, parameters) = all.last_mut().ok_or(format!("{word}: no material yet"))?;
        let mut values = vec![tokens.next().ok_or(format!("{word}: no value"))?];
        if values == ["["] {
            values = tokens.by_ref().take_while(|&token| token != "]").collect();
        }
        let values = values.into_iter().map(|value| value.trim_matches('"')).collect();
        parameters.insert(word.trim_matches('"'), values);
    }
    Ok(all)
}

fn values<'a, const N: usize>(parameters: &Parameters<'a>, name: &str) -> Result<[&'a str; N], String> {
    let values = parameters.get(name).ok_or(format!("no {name}"))?;
    values.as_slice().try_into().map_err(|_| format!("{name} has {} values instead of {N}", values.len()))
}

fn number(parameters: &Parameters<'_>, name: &str) -> Result<f32, String> {
    let [value] = values(parameters, name)?;
    value.parse().map_err(|error| format!("{name}: {error}"))
}

fn spectrum(parameters: &Parameters<'_>, name: &str) -> Result<Spectrum, String> {
    let mut color = [0.0; 3];
    for (channel, value) in color.iter_mut().zip(values::<3>(parameters, name)?) {
        *channel = value.parse().map_err(|error| format!("{name}: {error}"))?;
    }
    Ok(Spectrum { c: color })
}

/// The material of this name as rs_pbrt evaluates it; `None`: it has a coat.
fn material(name: &str, all: &HashMap<&str, Parameters<'_>>) -> Result<Option<Material>, String> {
    let parameters = all.get(name).ok_or(format!("no material {name}"))?;
    let bxdf = match values(parameters, "string type")? {
        ["conductor"] => {
            if values(parameters, "bool remaproughness")? != ["false"] {
                return Err("its roughness would be remapped".into());
            }
            let [u, v] = [number(parameters, "float uroughness")?, number(parameters, "float vroughness")?];
            let facets = MicrofacetDistribution::TrowbridgeReitz(TrowbridgeReitzDistribution::new(u, v, true));
            let (eta_t, k) = (spectrum(parameters, "rgb eta")?, spectrum(parameters, "rgb k")?);
            let fresnel = Fresnel::Conductor(FresnelConductor { eta_i: Spectrum::new(1.0), eta_t, k });
            Bxdf::MicrofacetRefl(MicrofacetReflection::new(Spectrum::new(1.0), facets, fresnel, None))
        }
        ["diffuse"] => Bxdf::LambertianRefl(LambertianReflection::new(spectrum(parameters, "rgb reflectance")?, None)),
        ["mix"] => {
            let [first, second] = values(parameters, "string materials")?;
            // The amount is the second's share.
            let amount = f64::from(number(parameters, "float amount")?);
            let mut both = Vec::new();
            for (share, part) in [(1.0 - amount, first), (amount, second)] {
                let Some(Material(parts)) = material(part, all)? else { return Ok(None) };
                both.extend(parts.into_iter().map(|(own, bxdf)| (share * own, bxdf)));
            }
            return Ok(Some(Material(both)));
        }
        ["coateddiffuse"] => return Ok(None),
        [other] => return Err(format!("{other} is no material that leadr writes")),
    };
    Ok(Some(Material(vec![(1.0, bxdf)])))
}

fn compare(measured: &Path, export: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(export).map_err(|error| error.to_string())?;
    let scene = pbrt4::Scene::load(&text, None).map_err(|error| format!("pbrt4 does not read it: {error}"))?;
    let all = named(&text)?;
    let name = all.last().ok_or("no material")?.0;
    if scene.materials.len() != all.len() {
        return Err(format!("pbrt4 reads {} materials instead of {}", scene.materials.len(), all.len()));
    }
    let found = material(name, &all.into_iter().collect())?;
    let measured = Measured::load(measured).map_err(|error| error.to_string())?;
    let samples = samples(&measured, measured.is_isotropic());
    Ok(match found {
        Some(material) => format!("rRMSE {:.6}", misfit(&samples, &material).rrmse),
        None => "read; coats are not evaluated".to_owned(),
    })
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [measured, export] = &arguments[..] else {
        eprintln!("usage: pbrt-fits MEASURED FILE.pbrt");
        return ExitCode::from(2);
    };
    match compare(Path::new(measured), Path::new(export)) {
        Ok(line) => {
            println!("{export}: {line}");
            ExitCode::SUCCESS
        }
        Err(fault) => {
            eprintln!("{export}: {fault}");
            ExitCode::FAILURE
        }
    }
}
