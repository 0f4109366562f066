//! The fingerprint in each frame of a capture: a checksum of all data that determine the frame.

use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frames::Moment;
use crate::app::capture::pattern::{FileKind, StillKind};
use leadr_maps::checksum::checksum;
use leadr_maps::origin::Origin;
use leadr_maps::reads::FileRead;
use leadr_maps::tonemap::Tonemap;
use leadr_tools::program::{VERSION, build, commit};

/// All data that determine the frames of a capture, except the moments and the device.
pub struct Recipe<'a> {
    config: &'a CaptureConfig,
    /// A text that describes the program, scene, settings and files.
    common: String,
}

impl<'a> Recipe<'a> {
    /// Creates the recipe of `config` with these input files.
    pub fn new(config: &'a CaptureConfig, files: &[FileRead]) -> Self {
        // Display settings do not affect an EXR file, because it stores linear radiance.
        let shown = !matches!(config.output.kind, FileKind::Still(StillKind::Exr));
        let mut scene = config.scene.clone();
        if !shown {
            (scene.picture.exposure, scene.picture.tonemap) = (0.0, Tonemap::SHOWN);
        }
        let beside = config.beside.map(|(technique, _)| technique);
        let layers = &config.layers;
        // The derived `Debug` output includes every field.
        let common = format!("{}\n{scene:?}\n{beside:?}\n{layers:?}\n{files:?}", build());
        Self { config, common }
    }

    /// Returns the origin that is stored in the frame of a moment.
    pub fn origin(&self, moment: Moment) -> Origin {
        // The frame number matters only for the moving split between two techniques.
        let Moment { frame, time, distance, turn_degrees, technique } = moment;
        let split = self.config.beside.map(|(_, split)| split.of_frame(frame, self.config.timeline.frames()));
        let text = format!("{}\n{time:?} {distance:?} {turn_degrees:?} {split:?} {technique:?}", self.common);
        Origin {
            software: format!("leadr {VERSION} ({})", commit()),
            command: self.config.command.clone(),
            fingerprint: format!("{:016x}", checksum(text.as_bytes())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::args::tests::resolve;
    use std::collections::BTreeSet;

    fn fingerprints(flags: &[&str], files: &[FileRead]) -> Vec<String> {
        let config = resolve(flags).unwrap();
        let recipe = Recipe::new(&config, files);
        config.moments().into_iter().map(|moment| recipe.origin(moment).fingerprint).collect()
    }

    #[test]
    fn relevant_settings_change_the_fingerprint() {
        let plane = ["--scene", "plane", "-o", "a.png"];
        let one = |flags: &[&str]| fingerprints(&[&plane, flags].concat(), &[]).remove(0);
        let mut seen = BTreeSet::from([one(&[])]);
        for flags in [
            &["--technique", "constant"][..],
            &["--masking", "smith"],
            &["--sky-occlusion", "off"],
            &["--beside", "lean"],
            &["--beside", "lean", "--split", "0.25"],
            &["--size", "1280x721"],
            &["--samples", "5"],
            &["--msaa", "2"],
            &["--edge-samples", "2"],
            &["--seed", "1"],
            &["--camera", "far"],
            &["--camera", "0,-9,3:0,0,0"],
            &["--distance", "7"],
            &["--time", "0.5"],
            &["--exposure", "1"],
            &["--tonemap", "clamp"],
            &["--sun", "10,10"],
            &["--time-of-day", "7"],
            &["--environment", "studio"],
            &["--height-map", "a.png"],
            &["--height-scale", "0.5"],
            &["--roughness", "0.5"],
            &["--bare"],
            &["--no-repeats"],
            &["--map-precision", "f16"],
        ] {
            assert!(seen.insert(one(flags)), "{flags:?}");
        }
        let read = |checksum| [FileRead { path: "a.png".into(), checksum }];
        assert!(seen.insert(fingerprints(&plane, &read(1)).remove(0)), "a file is read");
        assert!(seen.insert(fingerprints(&plane, &read(2)).remove(0)), "the file says something else");
    }

    #[test]
    fn irrelevant_settings_keep_the_fingerprint() {
        let frames = |flags: &[&str]| fingerprints(&[&["-o", "{frame}.png"], flags].concat(), &[]);
        let first = frames(&["--frames", "0..4"]);
        assert_eq!(first.iter().collect::<BTreeSet<_>>().len(), 4);
        assert_eq!(frames(&["--frames", "0..9"])[..4], first, "a longer range");
        assert_eq!(frames(&["--frames", "0..4", "--shard", "2/2"]), [&first[1..2], &first[3..]].concat(), "a shard");
        assert_eq!(frames(&["--frames", "0..4", "--validation", "--resume"]), first);
        // Each range of frames is a different sweep.
        let sweep = |range| frames(&["--frames", range, "--sweep", "5..50"]);
        assert_ne!(sweep("0..9")[3], sweep("0..4")[3]);
        let exr = |flags: &[&str]| fingerprints(&[&["-o", "a.exr"], flags].concat(), &[]);
        assert_eq!(exr(&["--exposure", "1"]), exr(&[]), "an EXR keeps radiance");
        assert_ne!(exr(&["--layers", "depth"]), exr(&[]));
    }
}
