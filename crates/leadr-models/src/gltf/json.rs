//! Strict access to JSON. Every value is read with its type and range, and errors give the location of the value.

use std::fmt;
use std::ops::RangeInclusive;

use super::value::{Object, Value};
use crate::fault::{ModelFault, shown};
use crate::limits::MAX_COORDINATE;

/// The result of reading a part of the model.
pub(super) type Read<T> = Result<T, ModelFault>;

/// The location of a value in the model, such as `mesh 2, primitive 0`.
#[derive(Clone, Copy)]
pub(super) struct Location {
    parts: [(&'static str, Option<usize>); 5],
    depth: usize,
}

impl Location {
    pub(super) const ROOT: Self = Self { parts: [("", None); 5], depth: 0 };

    /// Returns the location of a part of the object. Locations deeper than five levels are omitted.
    pub(super) fn below(mut self, kind: &'static str, number: Option<usize>) -> Self {
        if let Some(part) = self.parts.get_mut(self.depth) {
            *part = (kind, number);
            self.depth += 1;
        }
        self
    }

    pub(super) fn fault(self, what: impl Into<String>) -> ModelFault {
        ModelFault::invalid(self, what)
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.depth == 0 {
            return f.write_str("the model");
        }
        for (i, (kind, number)) in self.parts[..self.depth].iter().enumerate() {
            f.write_str(if i == 0 { "" } else { ", " })?;
            f.write_str(kind)?;
            if let Some(number) = number {
                write!(f, " {number}")?;
            }
        }
        Ok(())
    }
}

#[derive(Clone, Copy)]
pub(super) struct Item<'a> {
    object: &'a Object<'a>,
    pub(super) location: Location,
}

impl<'a> Item<'a> {
    pub(super) fn root(object: &'a Object<'a>) -> Self {
        Self { object, location: Location::ROOT }
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> ModelFault {
        self.location.fault(what)
    }

    fn wrong(&self, key: &str, wanted: &str) -> ModelFault {
        self.fault(format!("`{}` must be {wanted}", shown(key)))
    }

    /// Fails if the property is missing.
    pub(super) fn required<T>(&self, key: &str, value: Option<T>) -> Read<T> {
        value.ok_or_else(|| self.fault(format!("`{key}` is missing")))
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.object.get(key).is_some()
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.object.keys()
    }

    /// Reads a property and converts it by `read`. `wanted` describes the valid values.
    fn get<T>(&self, key: &str, wanted: &str, read: impl Fn(&'a Value<'a>) -> Option<T>) -> Read<Option<T>> {
        let read = |value| read(value).ok_or_else(|| self.wrong(key, wanted));
        self.object.get(key).map(read).transpose()
    }

    /// Returns the values of an array, or an empty list if the array is missing.
    fn list(&self, key: &str, wanted: &str) -> Read<&'a [Value<'a>]> {
        Ok(self.get(key, wanted, Value::as_list)?.unwrap_or_default())
    }

    pub(super) fn string(&self, key: &str) -> Read<Option<&'a str>> {
        self.get(key, "a string", Value::as_str)
    }

    /// Reads the name of the object, or an empty name if there is none.
    pub(super) fn name(&self) -> Read<String> {
        Ok(self.string("name")?.unwrap_or_default().to_owned())
    }

    /// Reads a boolean, which is false if it is missing.
    pub(super) fn flag(&self, key: &str) -> Read<bool> {
        Ok(self.get(key, "true or false", Value::as_bool)?.unwrap_or(false))
    }

    /// Reads a non-negative integer, which may be written as `2.0`.
    pub(super) fn whole(&self, key: &str) -> Read<Option<u64>> {
        self.get(key, "a whole number, 0 or more", Value::as_whole)
    }

    /// Reads a 32-bit number and checks its range.
    pub(super) fn number(&self, key: &str, range: RangeInclusive<f32>) -> Read<Option<f32>> {
        let number = |value: &Value<'_>| {
            let number = value.as_number().map(|v| v as f32).filter(|v| range.contains(v));
            number.ok_or_else(|| self.wrong(key, &in_range(&range)))
        };
        self.object.get(key).map(number).transpose()
    }

    /// Reads `N` numbers and checks the range of each.
    pub(super) fn vector<const N: usize>(&self, key: &str, range: RangeInclusive<f32>) -> Read<Option<[f32; N]>> {
        let Some(numbers) = self.numbers(key, range.clone())? else { return Ok(None) };
        let vector = <[f32; N]>::try_from(numbers);
        vector.map(Some).map_err(|_| self.wrong(key, &format!("an array of {N} numbers")))
    }

    /// Reads an array of numbers and checks the range of each.
    pub(super) fn numbers(&self, key: &str, range: RangeInclusive<f32>) -> Read<Option<Vec<f32>>> {
        let Some(value) = self.object.get(key) else { return Ok(None) };
        let wrong = || self.wrong(key, &format!("an array of numbers, each {}", in_range(&range)));
        let number =
            |value: &Value<'_>| value.as_number().map(|v| v as f32).filter(|v| range.contains(v)).ok_or_else(wrong);
        value.as_list().ok_or_else(wrong)?.iter().map(number).collect::<Read<_>>().map(Some)
    }

    /// Reads the index of another object, whose list has `count` objects.
    pub(super) fn index(&self, key: &str, kind: &str, count: usize) -> Read<Option<usize>> {
        let Some(index) = self.whole(key)? else { return Ok(None) };
        self.in_list(key, index, kind, count).map(Some)
    }

    pub(super) fn indices(&self, key: &str, kind: &str, count: usize) -> Read<Vec<usize>> {
        let wanted = "an array of whole numbers";
        let index = |value: &Value<'_>| {
            let index = value.as_whole().ok_or_else(|| self.wrong(key, wanted))?;
            self.in_list(key, index, kind, count)
        };
        self.list(key, wanted)?.iter().map(index).collect()
    }

    fn in_list(&self, key: &str, index: u64, kind: &str, count: usize) -> Read<usize> {
        let found = usize::try_from(index).ok().filter(|&i| i < count);
        found
            .ok_or_else(|| self.fault(format!("`{}` refers to {kind} {index}, but there are only {count}", shown(key))))
    }

    pub(super) fn item(&self, key: &'static str) -> Read<Option<Item<'a>>> {
        let object = self.get(key, "an object", Value::as_object)?;
        Ok(object.map(|object| Item { object, location: self.location.below(key, None) }))
    }

    /// Returns a nested object, or `None` if the value has another type.
    pub(super) fn object_or_nothing(&self, key: &'static str) -> Option<Item<'a>> {
        let object = self.object.get(key)?.as_object()?;
        Some(Item { object, location: self.location.below(key, None) })
    }

    /// Returns the objects of an array, or an empty list if the array is missing. Messages call the objects `kind 0`, `kind
    /// 1` …
    pub(super) fn items(&self, key: &str, kind: &'static str) -> Read<Vec<Item<'a>>> {
        let item = |(i, value): (usize, &'a Value<'a>)| {
            let location = self.location.below(kind, Some(i));
            let object = value.as_object().ok_or_else(|| location.fault("must be an object"))?;
            Ok(Item { object, location })
        };
        self.list(key, "an array")?.iter().enumerate().map(item).collect()
    }

    /// Returns the length of an array, or 0 if the array is missing.
    pub(super) fn length(&self, key: &str) -> Read<usize> {
        Ok(self.list(key, "an array")?.len())
    }

    pub(super) fn strings(&self, key: &str) -> Read<Vec<&'a str>> {
        let wanted = "an array of strings";
        let text = |value: &'a Value<'a>| value.as_str().ok_or_else(|| self.wrong(key, wanted));
        self.list(key, wanted)?.iter().map(text).collect()
    }

    /// Returns the named extension of this object.
    pub(super) fn extension(&self, name: &'static str) -> Read<Option<Item<'a>>> {
        let Some(all) = self.item("extensions")? else { return Ok(None) };
        Item { object: all.object, location: self.location }.item(name)
    }
}

fn in_range(range: &RangeInclusive<f32>) -> String {
    let (start, end) = (*range.start(), *range.end());
    match (start > -MAX_COORDINATE, end < MAX_COORDINATE) {
        (false, false) => format!("a number within ±{end:e}"),
        (true, false) => format!("a number from {start:?} to {end:e}"),
        _ => format!("a number from {start} to {end}"),
    }
}
