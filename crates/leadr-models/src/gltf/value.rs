//! JSON values that borrow from the text. Values are small, and searches are fast even for hostile input.

use std::borrow::Cow;
use std::cell::Cell;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use crate::fault::ModelFault;
use crate::limits::{MAX_OBJECTS, MAX_VALUES};

pub(super) enum Value<'a> {
    Null,
    Flag(bool),
    Whole(u64),
    Number(f64),
    Text(Cow<'a, str>),
    List(Vec<Value<'a>>),
    Object(Object<'a>),
}

/// The properties of an object, sorted by name if there are more than [`FEW`].
pub(super) struct Object<'a>(Vec<(Cow<'a, str>, Value<'a>)>);

/// With up to this number of properties, a linear search is as fast as a binary search.
const FEW: usize = 16;

impl<'a> Object<'a> {
    /// An object without properties.
    pub(super) const EMPTY: &'static Object<'static> = &Object(Vec::new());

    /// Creates the object, or returns `None` if two properties have the same name.
    fn new(mut all: Vec<(Cow<'a, str>, Value<'a>)>) -> Option<Self> {
        let twice = if all.len() > FEW {
            all.sort_by(|(a, _), (b, _)| a.cmp(b));
            all.windows(2).any(|pair| pair[0].0 == pair[1].0)
        } else {
            (1..all.len()).any(|i| all[..i].iter().any(|(name, _)| *name == all[i].0))
        };
        (!twice).then_some(Self(all))
    }

    pub(super) fn get(&self, key: &str) -> Option<&Value<'a>> {
        if self.0.len() <= FEW {
            return self.0.iter().find(|(name, _)| *name == key).map(|(_, value)| value);
        }
        let index = self.0.binary_search_by(|(name, _)| (**name).cmp(key)).ok()?;
        Some(&self.0[index].1)
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        self.entries().map(|(name, _)| name)
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = (&str, &Value<'a>)> {
        self.0.iter().map(|(name, value)| (&**name, value))
    }
}

impl<'a> Value<'a> {
    pub(super) fn as_bool(&self) -> Option<bool> {
        if let Self::Flag(flag) = self { Some(*flag) } else { None }
    }

    pub(super) fn as_str(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    pub(super) fn as_list(&self) -> Option<&[Self]> {
        if let Self::List(list) = self { Some(list) } else { None }
    }

    pub(super) fn as_object(&self) -> Option<&Object<'a>> {
        if let Self::Object(object) = self { Some(object) } else { None }
    }

    pub(super) fn as_number(&self) -> Option<f64> {
        match self {
            Self::Whole(number) => Some(*number as f64),
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// Returns the value if it is a non-negative integer, in any notation.
    pub(super) fn as_whole(&self) -> Option<u64> {
        const EXACT: f64 = (1u64 << 53) as f64;
        match self {
            Self::Whole(number) => Some(*number),
            Self::Number(number) if number.fract() == 0.0 && (0.0..=EXACT).contains(number) => Some(*number as u64),
            _ => None,
        }
    }
}

/// Parses the text of a model. The outermost value must be an object.
pub(super) fn parse(text: &[u8]) -> Result<Object<'_>, ModelFault> {
    let amount = Amount::default();
    let mut parser = serde_json::Deserializer::from_slice(text);
    let parsed = Seed(&amount).deserialize(&mut parser).and_then(|value| parser.end().map(|()| value));
    for (counter, most, what) in [(&amount.objects, MAX_OBJECTS, "objects"), (&amount.values, MAX_VALUES, "values")] {
        if counter.get() > most {
            return Err(ModelFault::too_large(format!("its JSON has more than {most} {what}")));
        }
    }
    match parsed {
        Ok(Value::Object(root)) => Ok(root),
        Ok(_) => Err(ModelFault::damaged("its JSON is not an object")),
        Err(error) => Err(ModelFault::damaged(format!("its JSON cannot be read ({error})"))),
    }
}

#[derive(Default)]
struct Amount {
    objects: Cell<usize>,
    values: Cell<usize>,
}

impl Amount {
    /// Counts one item. An error stops the parser, and [`parse`] reports the reason.
    fn count<E: Error>(counter: &Cell<usize>, limit: usize) -> Result<(), E> {
        counter.set(counter.get() + 1);
        if counter.get() > limit { Err(E::custom("too much")) } else { Ok(()) }
    }
}

/// Parses a value and counts its items.
struct Seed<'c>(&'c Amount);

impl<'de> DeserializeSeed<'de> for Seed<'_> {
    type Value = Value<'de>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value<'de>, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Seed<'_> {
    type Value = Value<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Value<'de>, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Value<'de>, E> {
        Ok(Value::Flag(flag))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value<'de>, E> {
        Ok(Value::Whole(number))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value<'de>, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value<'de>, E> {
        Ok(Value::Number(number))
    }

    fn visit_borrowed_str<E>(self, text: &'de str) -> Result<Value<'de>, E> {
        Ok(Value::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value<'de>, E> {
        Ok(Value::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value<'de>, A::Error> {
        let mut list = Vec::new();
        while let Some(value) = items.next_element_seed(Self(self.0))? {
            Amount::count(&self.0.values, MAX_VALUES)?;
            list.push(value);
        }
        Ok(Value::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut items: A) -> Result<Value<'de>, A::Error> {
        Amount::count(&self.0.objects, MAX_OBJECTS)?;
        let mut all = Vec::new();
        // Names are parsed as values, because a value borrows a text without escapes.
        while let Some(Value::Text(name)) = items.next_key_seed(Self(self.0))? {
            Amount::count(&self.0.values, MAX_VALUES)?;
            all.push((name, items.next_value_seed(Self(self.0))?));
        }
        // Programs differ in which of two properties with equal names they use.
        let object = Object::new(all);
        object.map(Value::Object).ok_or_else(|| A::Error::custom("an object has two properties of the same name"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_are_found_among_few_and_many() {
        for count in [0, 1, FEW, FEW + 1, 300] {
            let items: Vec<String> = (0..count).rev().map(|i| format!(r#""k{i}":{i}"#)).collect();
            let text = format!("{{{}}}", items.join(","));
            let object = parse(text.as_bytes()).unwrap();
            assert_eq!(object.keys().count(), count);
            for i in 0..count {
                assert_eq!(object.get(&format!("k{i}")).unwrap().as_whole(), Some(i as u64));
            }
            assert!(object.get("k").is_none());
            let twice = format!("{{{}}}", [items, vec![r#""x":1,"\u0078":2"#.into()]].concat().join(","));
            assert!(parse(twice.as_bytes()).err().unwrap().to_string().contains("two properties of the same name"));
        }
    }

    #[test]
    fn numbers_are_whole_however_they_are_spelt() {
        let object = parse(br#"{"a":2,"b":2.0,"c":2e0,"d":2.5,"e":-2,"f":18446744073709551615,"g":1e300}"#).unwrap();
        let whole = |key| object.get(key).unwrap().as_whole();
        assert_eq!(["a", "b", "c", "d", "e", "g"].map(whole), [Some(2), Some(2), Some(2), None, None, None]);
        assert_eq!((whole("f"), object.get("e").unwrap().as_number()), (Some(u64::MAX), Some(-2.0)));
    }

    #[test]
    fn invalid_json_is_refused() {
        for wrong in
            ["", "{", "[]", "7", "{} {}", "{\"a\":01}", "{\"a\":1e999}", "{a:1}", "{\"a\":NaN}", "{\"\u{1}\":1}"]
        {
            assert!(parse(wrong.as_bytes()).is_err(), "{wrong}");
        }
        assert!(parse(b"{\"\xff\":1}").is_err());
    }
}
