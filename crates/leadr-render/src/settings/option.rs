//! Declarations of options. Each option has a flag, a help text, values, a JSON key and a window control. The command line, the
//! error messages, the window, `--json` and the tables of the guide all read these declarations, so each option is declared once.

use serde::Serialize;

use super::technique::Technique;

/// Sections of the help and the guide, and groups in the window.
#[expect(missing_docs, reason = "the names are self-explanatory")]
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

/// How the window shows an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// The option has the standard control for its value.
    Control,
    /// The option has a custom control, which the panel draws.
    Own,
    /// The option has no control. The text is the reason.
    Without(&'static str),
}

/// The description of an option, which does not depend on the type of its value.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// The name of the flag, without dashes.
    pub name: &'static str,
    /// A hidden alias of the flag.
    pub old_name: Option<&'static str>,
    /// The placeholder of the value in the help, empty for a flag without a value.
    pub value_name: &'static str,
    /// The help text, which says what the option does. Default, scenes and techniques are added automatically.
    pub help: &'static str,
    /// The default in words. `None` prints the default value itself.
    pub default: Option<&'static str>,
    /// The help section, which is one of the [`headings`].
    pub heading: &'static str,
    /// Whether the short help includes the option.
    pub is_common: bool,
    /// The JSON path of the value, with a slash between nested keys. `None` uses the name of the flag with underscores.
    pub json: Option<&'static str>,
    /// How the window shows the option.
    pub panel: Panel,
    /// Label of the window control. `None` uses the name with spaces.
    pub called: Option<&'static str>,
}

impl Spec {
    /// Creates an option that only the long help includes.
    pub const fn new(heading: &'static str, name: &'static str, value_name: &'static str, help: &'static str) -> Self {
        let (old_name, default, is_common, json) = (None, None, false, None);
        let (panel, called) = (Panel::Control, None);
        Self { name, old_name, value_name, help, default, heading, is_common, json, panel, called }
    }
}

/// Sets fields of a [`Spec`] in a table.
#[rustfmt::skip]
#[expect(missing_docs, reason = "each sets one field of the spec")]
impl Spec {
    pub const fn common(self) -> Self { Self { is_common: true, ..self } }
    pub const fn default(self, words: &'static str) -> Self { Self { default: Some(words), ..self } }
    pub const fn formerly(self, name: &'static str) -> Self { Self { old_name: Some(name), ..self } }
    pub const fn key(self, key: &'static str) -> Self { Self { json: Some(key), ..self } }
    pub const fn panel(self, panel: Panel) -> Self { Self { panel, ..self } }
    pub const fn called(self, label: &'static str) -> Self { Self { called: Some(label), ..self } }
}

impl Spec {
    /// Returns the flag with its dashes, `--name`.
    pub fn flag(&self) -> String {
        format!("--{}", self.name)
    }

    /// Returns the JSON path of the value.
    pub fn json_key(&self) -> String {
        self.json.map_or_else(|| self.name.replace('-', "_"), str::to_owned)
    }

    /// Returns the label of the window control.
    pub fn label(&self) -> String {
        self.called.map_or_else(|| self.name.replace('-', " "), str::to_owned)
    }
}

/// A slider for a number.
#[derive(Clone, Copy, Debug)]
pub struct Slider {
    /// The lowest and the highest position of the slider. A flag may exceed them. If the lowest position is above 0, the scale is
    /// logarithmic.
    pub ends: [f32; 2],
    /// The number of decimals that are displayed.
    pub decimals: usize,
    /// The unit that is printed after the number.
    pub unit: &'static str,
}

/// How an option's value is read from a `C`, changed and formatted.
pub enum Value<C: 'static> {
    /// A switch with the values `on` and `off`.
    Switch(fn(&mut C) -> &mut bool),
    /// A flag without a value, which sets the field to this boolean.
    Flag(fn(&mut C) -> &mut bool, bool),
    /// A number. The second function parses it.
    Number(fn(&mut C) -> &mut f32, fn(&str) -> Result<f32, String>, Slider),
    /// A whole number in this range, which includes both ends.
    Count(fn(&mut C) -> &mut u32, [u32; 2], Slider),
    /// A value out of a few named values.
    Name(fn(&mut C) -> &mut dyn Named),
    /// A value in any other format.
    Text(Text<C>),
}

/// A value with a custom format.
pub struct Text<C: 'static> {
    /// Parses the text and sets the value.
    pub read: fn(&mut C, &str) -> Result<(), String>,
    /// Formats the value. Returns `None` if another option prints the value.
    pub write: fn(&C) -> Option<String>,
    /// Returns the value as JSON, or `None` to leave it out.
    pub json: fn(&C) -> Option<Json>,
}

/// A value in JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "the JSON types")]
pub enum Json {
    Bool(bool),
    Number(f32),
    Count(u32),
    Name(&'static str),
    Names(Vec<&'static str>),
}

/// A type with a few named values.
pub trait Named {
    /// Returns the name of the value on the command line and in JSON.
    fn name(&self) -> &'static str;
    /// Returns the names of all values, each with a description of one line.
    fn names(&self) -> Vec<(&'static str, &'static str)>;
    /// Sets the value by its name. An unknown name is an error.
    fn choose(&mut self, name: &str) -> Result<(), String>;
}

/// Implements [`Named`] for a type that has the methods `name` and `help`. The arguments are the type, its default and its values.
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

/// Declares an enumeration that implements [`Named`]. Each value has a name and a description.
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
    /// Parses the text and sets the value.
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

    /// Returns the value as written on the command line. Returns `None` for a flag that is not set, or if another option prints the
    /// value.
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

    /// Returns the value as JSON, or `None` to leave it out.
    pub fn json(&self, mut config: C) -> Option<Json> {
        Some(match self {
            Self::Switch(at) | Self::Flag(at, _) => Json::Bool(*at(&mut config)),
            Self::Number(at, ..) => Json::Number(*at(&mut config)),
            Self::Count(at, ..) => Json::Count(*at(&mut config)),
            Self::Name(at) => Json::Name(at(&mut config).name()),
            Self::Text(form) => return (form.json)(&config),
        })
    }

    /// Returns the named values with their descriptions, if the type has any.
    pub fn names(&self, mut config: C) -> Vec<(&'static str, &'static str)> {
        if let Self::Name(at) = self { at(&mut config).names() } else { Vec::new() }
    }
}

/// Parses `on` or `off`.
pub fn on_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("use on or off".to_owned()),
    }
}

/// A set of techniques.
#[derive(Clone, Copy, Debug)]
pub struct Techniques {
    /// Whether the set contains a technique.
    pub has: fn(Technique) -> bool,
}

impl Techniques {
    /// Returns the names of the techniques.
    pub fn names(&self) -> String {
        Technique::ALL.into_iter().filter(|&t| (self.has)(t)).map(Technique::name).collect::<Vec<_>>().join(", ")
    }
}
