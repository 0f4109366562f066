//! The command-line syntax of camera views, and suggestions for misspelt names.

use std::path::PathBuf;

use super::config::SceneConfig;
use super::view::{CameraPose, ViewChoice};
use leadr_render::settings::numbers::finite;

/// Returns `; a similar name exists: 'NAME'` for the known name that is most like `name`, or an empty text if none is. Upper and lower case
/// are alike.
pub fn similar<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let name = name.to_lowercase();
    let alike = |known: &str| strsim::jaro_winkler(&name, &known.to_lowercase());
    let rated = known.into_iter().map(|known| (alike(known), known)).filter(|(alike, _)| *alike > 0.8);
    let best = rated.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, best)| format!("; a similar name exists: '{best}'")).unwrap_or_default()
}

/// Parses `X,Y,Z:X,Y,Z` with `:DEGREES` as an optional suffix. Returns `None` if `text` has another form.
fn pose(text: &str) -> Option<Result<CameraPose, String>> {
    let parts: Vec<&str> = text.split(':').collect();
    let numbers: Option<Vec<Vec<f32>>> =
        parts.iter().map(|part| part.split(',').map(|number| finite(number).ok()).collect()).collect();
    let point = |numbers: &Vec<f32>| <[f32; 3]>::try_from(numbers.as_slice()).ok();
    let numbers = numbers.filter(|numbers| (2..=3).contains(&numbers.len()))?;
    let fov_degrees = match numbers.get(2).map(Vec::as_slice) {
        None => CameraPose::FOV_DEGREES,
        Some([degrees]) => *degrees,
        Some(_) => return None,
    };
    let (position, target) = (point(&numbers[0])?, point(&numbers[1])?);
    let pose = CameraPose { position, target, up: CameraPose::usual_up(position, target), fov_degrees };
    Some(pose.check().map(|()| pose))
}

/// Sets the view of `config` from `text`. A camera file is not read yet.
///
/// # Errors
/// A sentence that lists all forms of a camera.
pub fn see(config: &mut SceneConfig, text: &str) -> Result<(), String> {
    (config.model_camera, config.camera_file) = (None, None);
    config.view = match text {
        "near" => ViewChoice::Near,
        "mid" => ViewChoice::Mid,
        "far" => ViewChoice::Far,
        "model" => ViewChoice::Model,
        _ => {
            let path = PathBuf::from(text);
            if let Some(name) = text.strip_prefix("model:") {
                config.model_camera = Some(name.to_owned());
                ViewChoice::Model
            } else if let Some(pose) = pose(text) {
                ViewChoice::Pose(pose?)
            } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
                config.camera_file = Some(path);
                config.view
            } else {
                let forms =
                    "'near', 'mid', 'far', 'model', 'model:NAME', a .json file, or position, target and field of view";
                return Err(format!("use {forms} in numbers: X,Y,Z:X,Y,Z[:DEGREES]"));
            }
        }
    };
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{EnvironmentChoice, SunDirection};
    use crate::view::Size;
    use std::str::FromStr;

    fn refused<T: FromStr>(texts: &[&str]) {
        for text in texts {
            assert!(text.parse::<T>().is_err(), "'{text}' must be refused");
        }
    }

    #[test]
    fn misspelt_names_have_a_suggestion() {
        let known = ["trex", "plane", "sphere", "spheres", "snake", "Crawl"];
        for (name, wanted) in [("spere", "'sphere'"), ("T-Rex", "'trex'"), ("crawl", "'Crawl'"), ("plain", "'plane'")] {
            assert!(similar(name, known).ends_with(wanted), "{name}: {}", similar(name, known));
        }
        assert!(["cube", "", "snail.obj", "walk"].iter().all(|name| similar(name, known).is_empty()));
    }

    #[test]
    fn sizes() {
        assert_eq!("1x1".parse(), Ok(Size { width: 1, height: 1 }));
        for text in ["1280x720", "1280X720", "1280×720"] {
            assert_eq!(text.parse(), Ok(Size { width: 1280, height: 720 }), "{text}");
        }
        assert_eq!(serde_json::to_string(&Size { width: 3, height: 2 }).unwrap(), "[3,2]");
        refused::<Size>(&["0x0", "0x5", "5x0", "5", "x", "-1x5", "5x5x5", "16385x1", "16384x16384", "99999999999x1"]);
    }

    #[test]
    fn suns() {
        assert_eq!("-30,45".parse(), Ok(SunDirection { azimuth: -30.0, elevation: 45.0 }));
        refused::<SunDirection>(&["", "1", "nan,1", "1,inf", "0,91", "400,1", "1,2,3"]);
    }

    #[test]
    fn file_extension_selects_the_format() {
        assert_eq!("a.HDR".parse(), Ok(EnvironmentChoice::File("a.HDR".into())));
        assert_eq!("sky".parse(), Ok(EnvironmentChoice::Sky));
        assert_eq!("Studio".parse(), Ok(EnvironmentChoice::Studio));
        assert!("stduio".parse::<EnvironmentChoice>().unwrap_err().contains("; a similar name exists: 'studio'"));
        refused::<EnvironmentChoice>(&["a.png", "skies", ""]);
        let mut config = SceneConfig::default();
        for text in ["close", "a.txt", "", "1,2,3", "1,2:3,4,5", "1,2,3:1,2,3", "1,2,3:0,0,0:200", "1,2,x:0,0,0"] {
            assert!(see(&mut config, text).is_err(), "'{text}' must be refused");
        }
        see(&mut config, "a.json").unwrap();
        assert_eq!(config.camera_file.take(), Some("a.json".into()));
        let mut pose = |text: &str| match see(&mut config, text).map(|()| config.view) {
            Ok(ViewChoice::Pose(pose)) => (pose.position, pose.target, pose.fov_degrees),
            other => panic!("{other:?}"),
        };
        assert_eq!(pose("1,-2,3:0,0,0.5"), ([1.0, -2.0, 3.0], [0.0, 0.0, 0.5], 35.0));
        assert_eq!(pose("1,-2,3:0,0,0.5:50").2, 50.0);
    }
}
