//! What an option is: its flag, help, values, JSON key and control in the window. Command line, refusals, window, `--json` and the
//! guide's tables read these rows; nothing about an option is written anywhere else.

use serde::Serialize;

use super::technique::Technique;

/// Parts of the help and of the guide, and what lies beside each other in the window.
#[expect(missing_docs, reason = "their words say it")]
pub mod headings {
    pub const SCENE: &str = "Scene and models";
    pub const MATERIAL: &str = "Material of the plane and the sphere";
    pub const SEA: &str = "Sea";
    pub const GEOMETRY: &str = "Relief and geometry";
    pub const LIGHT: &str = "Light and exposure";
    pub const CAMERA: &str = "Camera";
    pub const SHADING: &str = "Technique and shading";
    pub const QUALITY: &str = "Size and quality";
}

/// How an option is changed in the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// By a control that follows from its value.
    Control,
    /// By a control of its own, which the panel draws.
    Own,
    /// Not at all, for this reason.
    Without(&'static str),
}

/// What is said about an option, whatever it is an option of.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Its flag, without dashes.
    pub name: &'static str,
    /// A spelling that is still understood, and not shown.
    pub old_name: Option<&'static str>,
    /// What stands for its value in the help; empty for a flag without one.
    pub value_name: &'static str,
    /// What it does, without default, scenes and techniques, which are added.
    pub help: &'static str,
    /// The default in words; `None` for that of its value.
    pub default: Option<&'static str>,
    /// Where it stands in the help: one of the [`headings`].
    pub heading: &'static str,
    /// Whether the short help has it.
    pub is_common: bool,
    /// Where its value stands in JSON, with a slash between nested keys; `None` for its name with underscores.
    pub json: Option<&'static str>,
    /// How the window changes it.
    pub panel: Panel,
}

impl Spec {
    /// An option that only the long help shows.
    pub const fn new(heading: &'static str, name: &'static str, value_name: &'static str, help: &'static str) -> Self {
        let panel = Panel::Control;
        Self { name, old_name: None, value_name, help, default: None, heading, is_common: false, json: None, panel }
    }
}

/// Changes of a [`Spec`] in a table.
#[rustfmt::skip]
#[expect(missing_docs, reason = "they set the field of the same meaning")]
impl Spec {
    pub const fn common(self) -> Self { Self { is_common: true, ..self } }
    pub const fn default(self, words: &'static str) -> Self { Self { default: Some(words), ..self } }
    pub const fn formerly(self, name: &'static str) -> Self { Self { old_name: Some(name), ..self } }
    pub const fn key(self, key: &'static str) -> Self { Self { json: Some(key), ..self } }
    pub const fn panel(self, panel: Panel) -> Self { Self { panel, ..self } }
}

impl Spec {
    /// `--name`.
    pub fn flag(&self) -> String {
        format!("--{}", self.name)
    }

    /// Where its value stands in JSON.
    pub fn json_key(&self) -> String {
        self.json.map_or_else(|| self.name.replace('-', "_"), str::to_owned)
    }

    /// Its name in words.
    pub fn label(&self) -> String {
        self.name.replace('-', " ")
    }
}

/// A number that a slider changes.
#[derive(Clone, Copy, Debug)]
pub struct Slider {
    /// The least and the most that the slider has; a flag may go beyond. Above 0, equal steps are equal factors.
    pub ends: [f32; 2],
    /// Decimals that are shown.
    pub decimals: usize,
    /// What follows the number.
    pub unit: &'static str,
}

/// Where the value of an option lies in `C`, and how it is written.
pub enum Value<C: 'static> {
    /// `on` or `off`.
    Switch(fn(&mut C) -> &mut bool),
    /// A flag without a value that makes it this.
    Flag(fn(&mut C) -> &mut bool, bool),
    /// A number, read by the function.
    Number(fn(&mut C) -> &mut f32, fn(&str) -> Result<f32, String>, Slider),
    /// A whole number from the first to the second.
    Count(fn(&mut C) -> &mut u32, [u32; 2], Slider),
    /// One of a few names.
    Name(fn(&mut C) -> &mut dyn Named),
    /// Anything else.
    Text(Text<C>),
}

/// A value that is written in a form of its own.
pub struct Text<C: 'static> {
    /// Changes it to what is written; refuses what is not understood.
    pub read: fn(&mut C, &str) -> Result<(), String>,
    /// How it is written; `None` where another option says it.
    pub write: fn(&C) -> Option<String>,
    /// In JSON; `None` where it does not appear.
    pub json: fn(&C) -> Option<Json>,
}

/// A value in JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "the forms of JSON")]
pub enum Json {
    Bool(bool),
    Number(f32),
    Count(u32),
    Name(&'static str),
    Names(Vec<&'static str>),
}

/// One of a few values with names.
pub trait Named {
    /// Its name on the command line and in JSON.
    fn name(&self) -> &'static str;
    /// All names and what they are, in a line each.
    fn names(&self) -> Vec<(&'static str, &'static str)>;
    /// Becomes the one of this name; refuses others.
    fn choose(&mut self, name: &str) -> Result<(), String>;
}

/// [`Named`] of types that have `name` and `help`: the type, its default, and all that can be chosen.
#[macro_export]
#[doc(hidden)]
macro_rules! named {
    ($($type:ty: $choices:expr;)*) => {
        $(impl $crate::settings::Named for $type {
            fn name(&self) -> &'static str {
                <$type>::name(*self)
            }

            fn names(&self) -> Vec<(&'static str, &'static str)> {
                $choices.iter().map(|choice| (<$type>::name(*choice), <$type>::help(*choice))).collect()
            }

            fn choose(&mut self, name: &str) -> Result<(), String> {
                let known = || self.names().into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(", ");
                let found = $choices.iter().find(|choice| <$type>::name(**choice) == name);
                *self = *found.ok_or_else(|| format!("use one of {}", known()))?;
                Ok(())
            }
        })*
    };
}

/// An enumeration that is [`Named`]: each value with its name and what it is.
#[macro_export]
#[doc(hidden)]
macro_rules! named_enum {
    ($(#[$doc:meta])* pub enum $type:ident { $($(#[$of:meta])* $value:ident = $name:literal, $help:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $type {
            $($(#[$of])* $value,)*
        }

        impl $type {
            const fn name(self) -> &'static str {
                match self { $(Self::$value => $name,)* }
            }

            const fn help(self) -> &'static str {
                match self { $(Self::$value => $help,)* }
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        $crate::named! { $type: [$(Self::$value),*]; }
    };
}

impl<C: Copy> Value<C> {
    /// Changes it to what is written; refuses what is not understood.
    pub fn read(&self, config: &mut C, text: &str) -> Result<(), String> {
        match self {
            Self::Switch(at) => *at(config) = on_off(text)?,
            Self::Flag(at, given) => *at(config) = *given,
            Self::Number(at, read, _) => *at(config) = read(text)?,
            Self::Count(at, [least, most], _) => *at(config) = super::numbers::whole(text, *least, *most)?,
            Self::Name(at) => at(config).choose(text)?,
            Self::Text(form) => (form.read)(config, text)?,
        }
        Ok(())
    }

    /// How it is written on the command line; `None` where it is not: a flag that is not given, or what another option says.
    pub fn write(&self, mut config: C) -> Option<String> {
        match self {
            Self::Switch(at) => Some(if *at(&mut config) { "on" } else { "off" }.to_owned()),
            Self::Flag(at, given) => (*at(&mut config) == *given).then(String::new),
            Self::Number(at, ..) => Some(at(&mut config).to_string()),
            Self::Count(at, ..) => Some(at(&mut config).to_string()),
            Self::Name(at) => Some(at(&mut config).name().to_owned()),
            Self::Text(form) => (form.write)(&config),
        }
    }

    /// In JSON; `None` where it does not appear.
    pub fn json(&self, mut config: C) -> Option<Json> {
        Some(match self {
            Self::Switch(at) | Self::Flag(at, _) => Json::Bool(*at(&mut config)),
            Self::Number(at, ..) => Json::Number(*at(&mut config)),
            Self::Count(at, ..) => Json::Count(*at(&mut config)),
            Self::Name(at) => Json::Name(at(&mut config).name()),
            Self::Text(form) => return (form.json)(&config),
        })
    }

    /// Names of its values and what they are, if they are few.
    pub fn names(&self, mut config: C) -> Vec<(&'static str, &'static str)> {
        if let Self::Name(at) = self { at(&mut config).names() } else { Vec::new() }
    }
}

/// Reads `on` or `off`; refuses other words.
pub fn on_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("use on or off".to_owned()),
    }
}

/// Some of the techniques.
#[derive(Clone, Copy, Debug)]
pub struct Techniques {
    /// Whether a technique is one of them.
    pub has: fn(Technique) -> bool,
    /// Which they are, as the end of "techniques …".
    pub which: &'static str,
}

impl Techniques {
    /// Names of those there are.
    pub fn names(&self) -> String {
        Technique::ALL.into_iter().filter(|&t| (self.has)(t)).map(Technique::name).collect::<Vec<_>>().join(", ")
    }
}
