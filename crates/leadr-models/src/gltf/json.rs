//! Access to JSON. Every value is read with its type and range. An optional value that violates them is repaired, and the message
//! gives its location.

use std::fmt;
use std::ops::RangeInclusive;

use super::log::Log;
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
    log: &'a Log,
    /// Whether a violation is an error instead of a repair.
    exact: bool,
}

/// The repair of an optional value of the wrong type.
const IGNORED: &str = "it is ignored";

impl<'a> Item<'a> {
    pub(super) fn root(object: &'a Object<'a>, log: &'a Log) -> Self {
        Self { object, location: Location::ROOT, log, exact: false }
    }

    /// Returns the object with another place for its messages.
    pub(super) fn quietly<'b>(&self, log: &'b Log) -> Item<'b>
    where
        'a: 'b,
    {
        Item { log, ..*self }
    }

    fn below(&self, object: &'a Object<'a>, location: Location) -> Self {
        Self { object, location, log: self.log, exact: false }
    }

    fn exact(&self) -> Self {
        Self { exact: true, ..*self }
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> ModelFault {
        self.location.fault(what)
    }

    fn wrong(&self, key: &str, wanted: &str) -> ModelFault {
        self.fault(format!("`{}` must be {wanted}", shown(key)))
    }

    fn repair(&self, fault: ModelFault, repair: &str) -> Read<()> {
        if self.exact { Err(fault) } else { self.log.repair(fault, repair) }
    }

    /// Reads a property by `read`. Fails if it is missing or violates its type.
    pub(super) fn required<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Self, &'static str) -> Read<Option<T>>,
    ) -> Read<T> {
        read(&self.exact(), key)?.ok_or_else(|| self.fault(format!("`{key}` is missing")))
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.object.get(key).is_some()
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.object.keys()
    }

    /// Returns the value of a property, without a check of its type.
    pub(super) fn value(&self, key: &str) -> Option<&'a Value<'a>> {
        self.object.get(key)
    }

    /// Reads a property and converts it by `read`. `wanted` describes the valid values.
    fn get<T>(&self, key: &str, wanted: &str, read: impl Fn(&'a Value<'a>) -> Option<T>) -> Read<Option<T>> {
        let Some(value) = self.object.get(key) else { return Ok(None) };
        let converted = read(value);
        if converted.is_none() {
            self.repair(self.wrong(key, wanted), IGNORED)?;
        }
        Ok(converted)
    }

    /// Returns the values of an array, or an empty list if the array is missing.
    fn list(&self, key: &str, wanted: &str) -> Read<&'a [Value<'a>]> {
        Ok(self.exact().get(key, wanted, Value::as_list)?.unwrap_or_default())
    }

    pub(super) fn string(&self, key: &str) -> Read<Option<&'a str>> {
        self.get(key, "a string", Value::as_str)
    }

    /// Reads the name of the object, or an empty name if there is none.
    pub(super) fn name(&self) -> Read<String> {
        Ok(self.string("name")?.unwrap_or_default().to_owned())
    }

    /// Reads a boolean, which is `default` if it is missing.
    pub(super) fn flag(&self, key: &str, default: bool) -> Read<bool> {
        Ok(self.get(key, "true or false", Value::as_bool)?.unwrap_or(default))
    }

    /// Reads a non-negative integer, which may be written as `2.0`.
    pub(super) fn whole(&self, key: &str) -> Read<Option<u64>> {
        self.get(key, "a whole number, 0 or more", Value::as_whole)
    }

    /// Reads a 32-bit number. A number out of range becomes the nearest end.
    pub(super) fn number(&self, key: &str, range: RangeInclusive<f32>) -> Read<Option<f32>> {
        let wanted = in_range(&range);
        let Some(number) = self.get(key, &wanted, Value::as_number)? else { return Ok(None) };
        if !range.contains(&(number as f32)) {
            self.repair(self.wrong(key, &wanted), "the nearest valid number is used")?;
        }
        Ok(Some((number as f32).clamp(*range.start(), *range.end())))
    }

    /// Reads `N` numbers. Further numbers are ignored, and numbers out of range become the nearest end.
    pub(super) fn vector<const N: usize>(&self, key: &str, range: RangeInclusive<f32>) -> Read<Option<[f32; N]>> {
        let Some(numbers) = self.numbers(key, range)? else { return Ok(None) };
        if numbers.len() != N {
            let repair = if numbers.len() < N { IGNORED } else { "the further numbers are ignored" };
            self.repair(self.wrong(key, &format!("an array of {N} numbers")), repair)?;
        }
        Ok(numbers.first_chunk::<N>().copied())
    }

    /// Reads an array of numbers. Numbers out of range become the nearest end.
    pub(super) fn numbers(&self, key: &str, range: RangeInclusive<f32>) -> Read<Option<Vec<f32>>> {
        let wanted = || format!("an array of numbers, each {}", in_range(&range));
        let list = |value: &'a Value<'a>| {
            value.as_list()?.iter().map(|v| v.as_number().map(|v| v as f32)).collect::<Option<Vec<f32>>>()
        };
        let Some(mut numbers) = self.get(key, &wanted(), list)? else { return Ok(None) };
        if numbers.iter().any(|number| !range.contains(number)) {
            self.repair(self.wrong(key, &wanted()), "the nearest valid numbers are used")?;
            numbers.iter_mut().for_each(|number| *number = number.clamp(*range.start(), *range.end()));
        }
        Ok(Some(numbers))
    }

    /// Reads the index of another object, whose list has `count` objects.
    pub(super) fn index(&self, key: &str, kind: &str, count: usize) -> Read<Option<usize>> {
        let Some(index) = self.whole(key)? else { return Ok(None) };
        self.in_list(key, index, kind, count)
    }

    /// Like [`Self::index`], but fails on an index that is out of range.
    pub(super) fn exact_index(&self, key: &str, kind: &str, count: usize) -> Read<Option<usize>> {
        self.exact().index(key, kind, count)
    }

    /// Reads a list of indices. Those out of range are left out.
    pub(super) fn indices(&self, key: &str, kind: &str, count: usize) -> Read<Vec<usize>> {
        let wanted = "an array of whole numbers";
        let mut all = Vec::new();
        for value in self.get(key, wanted, Value::as_list)?.unwrap_or_default() {
            match value.as_whole() {
                Some(index) => all.extend(self.in_list(key, index, kind, count)?),
                None => self.repair(self.wrong(key, wanted), IGNORED)?,
            }
        }
        Ok(all)
    }

    fn in_list(&self, key: &str, index: u64, kind: &str, count: usize) -> Read<Option<usize>> {
        let found = usize::try_from(index).ok().filter(|&i| i < count);
        if found.is_none() {
            let what = format!("`{}` refers to {kind} {index}, but there are only {count}", shown(key));
            self.repair(self.fault(what), IGNORED)?;
        }
        Ok(found)
    }

    pub(super) fn item(&self, key: &'static str) -> Read<Option<Item<'a>>> {
        let object = self.get(key, "an object", Value::as_object)?;
        Ok(object.map(|object| self.below(object, self.location.below(key, None))))
    }

    /// Returns a nested object, or `None` if the value has another type.
    pub(super) fn object_or_nothing(&self, key: &'static str) -> Option<Item<'a>> {
        let object = self.object.get(key)?.as_object()?;
        Some(self.below(object, self.location.below(key, None)))
    }

    /// Returns the objects of an array, or an empty list if the array is missing. Messages call the objects `kind 0`, `kind
    /// 1` …
    pub(super) fn items(&self, key: &str, kind: &'static str) -> Read<Vec<Item<'a>>> {
        let item = |(i, value): (usize, &'a Value<'a>)| {
            let location = self.location.below(kind, Some(i));
            let object = match value.as_object() {
                Some(object) => object,
                None => {
                    self.repair(location.fault("must be an object"), "it is read as an object without properties")?;
                    Object::EMPTY
                }
            };
            Ok(self.below(object, location))
        };
        self.list(key, "an array")?.iter().enumerate().map(item).collect()
    }

    /// Returns the length of an array, or 0 if the array is missing.
    pub(super) fn length(&self, key: &str) -> Read<usize> {
        Ok(self.list(key, "an array")?.len())
    }

    pub(super) fn strings(&self, key: &str) -> Read<Vec<&'a str>> {
        let texts = |value: &'a Value<'a>| value.as_list()?.iter().map(Value::as_str).collect();
        Ok(self.get(key, "an array of strings", texts)?.unwrap_or_default())
    }

    /// Returns the whole numbers that have this key in the object, or in an object below it.
    pub(super) fn whole_numbers_below(&self, key: &str) -> Vec<usize> {
        let mut found = Vec::new();
        let mut objects = vec![self.object];
        while let Some(object) = objects.pop() {
            for (name, value) in object.entries() {
                objects.extend(value.as_object());
                let number = Some(value).filter(|_| name == key).and_then(Value::as_whole);
                found.extend(number.and_then(|number| usize::try_from(number).ok()));
            }
        }
        found
    }

    /// Returns the named extension of this object.
    pub(super) fn extension(&self, name: &'static str) -> Read<Option<Item<'a>>> {
        let Some(all) = self.item("extensions")? else { return Ok(None) };
        self.below(all.object, self.location).item(name)
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
