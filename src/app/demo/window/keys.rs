//! The keys of the window and their actions.

use glam::Vec3;
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

use super::viewer::Action;
use leadr_render::settings::Technique;

/// Actions of character keys. [`Technique::key`] gives the keys of techniques.
pub const CHARACTERS: [(char, Action); 15] = [
    (',', Action::Frame(-1)),
    ('.', Action::Frame(1)),
    ('[', Action::Sun(-1)),
    (']', Action::Sun(1)),
    ('t', Action::SunPace),
    ('r', Action::Reset),
    ('s', Action::Screenshot),
    ('q', Action::Quit),
    ('g', Action::Rule),
    ('v', Action::Shadowing),
    ('e', Action::Environment),
    ('c', Action::Compare),
    ('o', Action::Sweep),
    ('f', Action::Fly),
    ('x', Action::CopyCommand),
];

/// Returns the action of a pressed key.
pub fn action(key: &Key) -> Option<Action> {
    Some(match key {
        Key::Named(NamedKey::Space) => Action::Pause,
        Key::Named(NamedKey::ArrowLeft) => Action::Scrub(-1),
        Key::Named(NamedKey::ArrowRight) => Action::Scrub(1),
        Key::Named(NamedKey::Tab) => Action::Panel,
        Key::Named(NamedKey::F1) => Action::Help,
        Key::Named(NamedKey::F11) => Action::FullScreen,
        Key::Named(NamedKey::F12) => Action::Screenshot,
        Key::Named(NamedKey::Escape) => Action::Quit,
        Key::Character(text) => {
            let mut characters = text.chars().flat_map(char::to_lowercase);
            let (key, None) = (characters.next()?, characters.next()) else { return None };
            let technique = || Technique::ALL.into_iter().find(|t| t.key() == key).map(Action::Technique);
            return CHARACTERS
                .iter()
                .find(|(character, _)| *character == key)
                .map(|(_, does)| *does)
                .or_else(technique);
        }
        _ => return None,
    })
}

/// Returns the direction in which a held key moves a flying camera: right, forward, up. It depends on the physical key, not on the layout.
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

    #[test]
    fn every_technique_has_a_key_of_its_own() {
        for technique in Technique::ALL {
            assert_eq!(typed(&technique.key().to_string()), Some(Action::Technique(technique)));
            assert!(CHARACTERS.iter().all(|(character, _)| *character != technique.key()), "{technique:?}");
        }
        assert_eq!((typed("10"), typed("")), (None, None));
        assert_eq!((typed("Q"), typed("z")), (Some(Action::Quit), None));
    }

    #[test]
    fn opposite_keys_stand_still() {
        let of = |code| flies(PhysicalKey::Code(code)).unwrap();
        let all = [KeyCode::KeyW, KeyCode::KeyS, KeyCode::KeyA, KeyCode::KeyD, KeyCode::KeyE, KeyCode::KeyQ];
        assert_eq!(all.map(of).into_iter().sum::<Vec3>(), Vec3::ZERO);
        assert_eq!(flies(PhysicalKey::Code(KeyCode::KeyX)), None);
    }
}
