//! The keys of the window and their actions.

use glam::Vec3;
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

use super::viewer::Action;
use leadr_render::settings::Technique;

/// A line of the help: keys, mouse buttons or files, and what they do.
pub struct Help {
    /// The keys, buttons or files, as the help prints them.
    pub keys: &'static str,
    /// What they do, for all of [`does`](Self::does).
    pub text: &'static str,
    /// The keys with their actions; empty for the mouse and for files.
    pub does: &'static [(Press, Action)],
}

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// A key that types this character, in lower case.
    Types(char),
    /// A key without a character.
    Named(NamedKey),
}

use Press::{Named, Types};

const fn help(keys: &'static str, text: &'static str, does: &'static [(Press, Action)]) -> Help {
    Help { keys, text, does }
}

/// The keys and the mouse. [`Technique::key`] has the keys of techniques.
#[rustfmt::skip]
pub const KEYS: [Help; 24] = [
    help("Tab", "show or hide the panel", &[(Named(NamedKey::Tab), Action::Panel)]),
    help("F1", "show or hide this help", &[(Named(NamedKey::F1), Action::Help)]),
    help("left drag", "orbit around the target", &[]),
    help("right drag, shift+left drag", "pan", &[]),
    help("wheel", "zoom in and out", &[]),
    help("space", "pause or resume time", &[(Named(NamedKey::Space), Action::Pause)]),
    help("left, right", "step back or forward by half a second",
        &[(Named(NamedKey::ArrowLeft), Action::Scrub(-1)), (Named(NamedKey::ArrowRight), Action::Scrub(1))]),
    help(", .", "step back or forward by one frame", &[(Types(','), Action::Frame(-1)), (Types('.'), Action::Frame(1))]),
    help("g", "switch between the paper's grid and the visible-slope rules", &[(Types('g'), Action::Rule)]),
    help("v", "use the next shadowing model: masking alone, Smith, correlated", &[(Types('v'), Action::Shadowing)]),
    help("[ ]", "move the sun back or forward by half an hour", &[(Types('['), Action::Sun(-1)), (Types(']'), Action::Sun(1))]),
    help("t", "use the next speed of the sun: still, a day in two minutes, a day in twenty seconds",
        &[(Types('t'), Action::SunPace)]),
    help("e", "use the next environment", &[(Types('e'), Action::Environment)]),
    help("c", "compare with another technique on the right; drag the dividing line", &[(Types('c'), Action::Compare)]),
    help("o", "zoom out to the far view and back", &[(Types('o'), Action::Sweep)]),
    help("f", "fly: drag to look around, press W A S D Q E to move", &[(Types('f'), Action::Fly)]),
    help("l", "open a model, an environment or a material", &[(Types('l'), Action::Open)]),
    help("x", "copy the command that draws this picture", &[(Types('x'), Action::CopyCommand)]),
    help("F11", "full screen", &[(Named(NamedKey::F11), Action::FullScreen)]),
    help("r", "reset the view, the time and the sun", &[(Types('r'), Action::Reset)]),
    help("s, F12", "save a screenshot into out/",
        &[(Types('s'), Action::Screenshot), (Named(NamedKey::F12), Action::Screenshot)]),
    help("q", "quit", &[(Types('q'), Action::Quit)]),
    help("Esc", "close a list, the help or a message; quit if none is open", &[(Named(NamedKey::Escape), Action::Close)]),
    help("drop a file", "open the file", &[]),
];

/// The files that the window opens.
#[rustfmt::skip]
pub const FILES: [Help; 4] = [
    help(".hdr, .exr", "an environment", &[]),
    help(".glb, .gltf", "a model", &[]),
    help("FIT.json", "a measured material for the plane, the sphere or a model", &[]),
    help("a material folder", "a material for the plane or the sphere", &[]),
];

/// Returns the sections of the help: a heading, and lines of keys and what they do. Techniques are sorted by their keys.
pub fn sections() -> [(&'static str, Vec<(String, &'static str)>); 3] {
    let lines = |rows: &[Help]| rows.iter().map(|row| (row.keys.to_owned(), row.text)).collect();
    let mut techniques = Technique::ALL;
    techniques.sort_unstable_by_key(|technique| technique.key());
    let techniques = techniques.map(|technique| (technique.key().to_string(), technique.name())).to_vec();
    [
        ("In the window", lines(&KEYS)),
        ("Techniques", techniques),
        ("Files to drop on the window, or to open with l", lines(&FILES)),
    ]
}

/// Returns the sections as text, printed below the help of the command.
pub fn text() -> String {
    let section = |(title, lines): (&str, Vec<(String, &str)>)| {
        let lines = lines.into_iter().map(|(keys, text)| format!("  {keys:<28} {text}\n"));
        format!("{title}:\n{}", lines.collect::<String>())
    };
    sections().map(section).concat()
}

/// Returns what an action does, and its keys, for a tooltip.
pub fn tip(action: Action) -> String {
    let row = KEYS.iter().find(|row| row.does.iter().any(|(_, does)| *does == action));
    row.map(|row| format!("{} ({})", sentence(row.text), row.keys)).unwrap_or_default()
}

/// Returns the text with a capital.
fn sentence(text: &str) -> String {
    let (first, rest) = text.split_at(text.chars().next().map_or(0, char::len_utf8));
    first.to_uppercase() + rest
}

/// Returns the action of a pressed key.
pub fn action(key: &Key) -> Option<Action> {
    let press = match key {
        Key::Named(named) => Named(*named),
        Key::Character(text) => {
            let mut characters = text.chars().flat_map(char::to_lowercase);
            let (key, None) = (characters.next()?, characters.next()) else { return None };
            Types(key)
        }
        _ => return None,
    };
    let of_table = KEYS.iter().flat_map(|row| row.does).find(|(known, _)| *known == press).map(|(_, does)| *does);
    let technique = || Technique::ALL.into_iter().find(|t| press == Types(t.key())).map(Action::Technique);
    of_table.or_else(technique)
}

/// Returns the direction in which a held key moves a flying camera, as right, forward and up. The direction depends on the physical key,
/// and not on the keyboard layout.
pub fn flies(key: PhysicalKey) -> Option<Vec3> {
    let PhysicalKey::Code(code) = key else { return None };
    Some(match code {
        KeyCode::KeyW => Vec3::Y,
        KeyCode::KeyS => -Vec3::Y,
        KeyCode::KeyA => -Vec3::X,
        KeyCode::KeyD => Vec3::X,
        KeyCode::KeyE => Vec3::Z,
        KeyCode::KeyQ => -Vec3::Z,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(text: &str) -> Option<Action> {
        action(&Key::Character(text.into()))
    }

    fn presses() -> impl Iterator<Item = &'static (Press, Action)> {
        KEYS.iter().flat_map(|row| row.does)
    }

    #[test]
    fn every_technique_has_a_key_of_its_own() {
        for technique in Technique::ALL {
            assert_eq!(typed(&technique.key().to_string()), Some(Action::Technique(technique)));
            assert!(presses().all(|(press, _)| *press != Types(technique.key())), "{technique:?}");
        }
        for (number, (press, _)) in presses().enumerate() {
            assert!(presses().skip(number + 1).all(|(other, _)| other != press), "{press:?} has two actions");
        }
        assert_eq!((typed("10"), typed("")), (None, None));
        assert_eq!((typed("Q"), typed("%")), (Some(Action::Quit), None));
    }

    #[test]
    fn opposite_keys_stand_still() {
        let of = |code| flies(PhysicalKey::Code(code)).unwrap();
        let all = [KeyCode::KeyW, KeyCode::KeyS, KeyCode::KeyA, KeyCode::KeyD, KeyCode::KeyE, KeyCode::KeyQ];
        assert_eq!(all.map(of).into_iter().sum::<Vec3>(), Vec3::ZERO);
        assert_eq!(flies(PhysicalKey::Code(KeyCode::KeyX)), None);
    }
}
