//! Accessors, with views, strides, component types and sparse data. Every bound is checked before data are read.

use std::borrow::Cow;

use super::json::{Item, Location, Read};
use super::log::Log;
use crate::fault::{Broken, ModelFault, shown};
use crate::limits::Budget;

/// A buffer's declared length and its bytes, of which there may be more.
pub(super) struct Buffer<'a> {
    pub(super) length: u64,
    pub(super) bytes: Result<Cow<'a, [u8]>, Broken>,
}

/// The decompressed bytes of a buffer view, or the fault of compressed data. `None` for views without compression.
pub(super) type Unpacked = Option<Result<Vec<u8>, Broken>>;

#[derive(Clone, Copy)]
pub(super) struct BufferView<'a> {
    offset: u64,
    length: u64,
    /// The bytes of the whole buffer.
    buffer: Result<&'a [u8], &'a Broken>,
    /// The number of bytes from one element to the next, if specified.
    stride: Option<usize>,
}

impl<'a> BufferView<'a> {
    pub(super) fn read(item: &Item<'_>, buffers: &'a [Buffer<'_>], log: &Log) -> Read<Self> {
        let whole = &buffers[item.required("buffer", |item, key| item.index(key, "buffer", buffers.len()))?];
        let offset = item.required("byteOffset", |item, key| Ok(Some(item.whole(key)?.unwrap_or(0))))?;
        let mut length = item.required("byteLength", Item::whole)?;
        if length == 0 {
            return Err(item.fault("`byteLength` must be 1 or more"));
        }
        let end = offset.saturating_add(length);
        let there = whole.bytes.as_ref().map_or(whole.length, |bytes| bytes.len() as u64);
        if end > whole.length {
            let fault = item.fault(format!("needs bytes {offset} to {end}, but the buffer has {}", whole.length));
            if offset >= there {
                return Err(fault);
            }
            log.repair(fault, "it is read as far as it is there")?;
            length = length.min(there - offset);
        }
        // A stride of 0 is invalid, but older exporters write 0 for "no stride".
        let stride = item.whole("byteStride")?.filter(|&stride| stride != 0);
        if stride.is_some_and(|s| !(4..=252).contains(&s) || s % 4 != 0) {
            log.repair(item.fault("`byteStride` must be a multiple of 4 from 4 to 252"), "it is used as it is")?;
        }
        let stride = stride.map(|stride| usize::try_from(stride).unwrap_or(usize::MAX));
        Ok(Self { offset, length, buffer: whole.bytes.as_deref(), stride })
    }

    /// Returns a view of decompressed bytes.
    pub(super) fn unpacked(item: &Item<'_>, bytes: &'a Result<Vec<u8>, Broken>) -> Read<Self> {
        let bytes = bytes.as_deref();
        let stride = item.whole("byteStride")?.filter(|&stride| stride != 0);
        let stride = stride.map(|stride| usize::try_from(stride).unwrap_or(usize::MAX));
        Ok(Self { offset: 0, length: bytes.map_or(u64::MAX, |bytes| bytes.len() as u64), buffer: bytes, stride })
    }

    /// Returns the bytes, or an error if the buffer has none.
    pub(super) fn bytes(&self) -> Read<&'a [u8]> {
        let bytes = self.buffer.map_err(Broken::fault)?;
        Ok(slice(bytes, self.offset, self.length).unwrap_or_default())
    }

    /// Returns a range of the view, or the fault of its buffer. `what` describes the content in errors.
    fn part(
        &self,
        item: &Item<'_>,
        offset: u64,
        length: u64,
        what: &str,
        log: &Log,
    ) -> Read<Result<&'a [u8], &'a Broken>> {
        let end = offset.saturating_add(length);
        let bytes = self.buffer.map(|bytes| slice(bytes, self.offset.saturating_add(offset), length));
        if end > self.length {
            let all = self.length;
            let fault = item.fault(format!("{what} need bytes {offset} to {end}, but the buffer view has {all}"));
            // Some exporters leave padding out of the length of a view.
            if !matches!(bytes, Ok(Some(_))) || end - self.length >= 4 {
                return Err(fault);
            }
            log.repair(fault, "the bytes after the view are read")?;
        }
        Ok(bytes.map(Option::unwrap_or_default))
    }
}

fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    bytes.get(start..start.checked_add(usize::try_from(length).ok()?)?)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    const ALL: [Self; 6] = [Self::I8, Self::U8, Self::I16, Self::U16, Self::U32, Self::F32];

    fn of_code(code: u64) -> Option<Self> {
        Self::ALL.into_iter().find(|component| component.facts().0 == code)
    }

    const fn bytes(self) -> usize {
        self.facts().1
    }

    const fn name(self) -> &'static str {
        self.facts().2
    }

    /// Returns the glTF code, the size in bytes, and a description.
    const fn facts(self) -> (u64, usize, &'static str) {
        match self {
            Self::I8 => (5120, 1, "signed bytes"),
            Self::U8 => (5121, 1, "bytes"),
            Self::I16 => (5122, 2, "signed 16-bit numbers"),
            Self::U16 => (5123, 2, "16-bit numbers"),
            Self::U32 => (5125, 4, "32-bit numbers"),
            Self::F32 => (5126, 4, "floats"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    /// The name of the type, such as `SCALAR` or `VEC3`.
    pub(super) name: &'static str,
    rows: usize,
    columns: usize,
}

/// The names of all element types, each with its number of rows and columns.
const SHAPES: [(&str, usize, usize); 7] =
    [("SCALAR", 1, 1), ("VEC2", 2, 1), ("VEC3", 3, 1), ("VEC4", 4, 1), ("MAT2", 2, 2), ("MAT3", 3, 3), ("MAT4", 4, 4)];

impl Shape {
    fn of_name(text: &str) -> Option<Self> {
        let found = SHAPES.iter().find(|(name, ..)| *name == text);
        found.map(|&(name, rows, columns)| Self { name, rows, columns })
    }

    /// Returns the number of bytes from one element to the next. Matrix columns are aligned to four bytes.
    const fn stride(self, component: Component) -> usize {
        let column = self.rows * component.bytes();
        if self.columns == 1 { column } else { column.next_multiple_of(4) * self.columns }
    }

    /// Returns the size of an element in bytes, without trailing padding.
    const fn bytes(self, component: Component) -> usize {
        let column = self.rows * component.bytes();
        column.next_multiple_of(4) * (self.columns - 1) + column
    }
}

struct Sparse<'a> {
    count: usize,
    indices: &'a [u8],
    index: Component,
    values: &'a [u8],
}

/// The values of an accessor before its sparse substitutions.
#[derive(Clone, Copy)]
enum Base<'a> {
    Zeros,
    /// The bytes, starting at the first element.
    Bytes(&'a [u8]),
    /// The accessor's buffer has no data.
    Absent(&'a Broken),
}

pub(super) struct Accessor<'a> {
    location: Location,
    /// The number of elements, at least 1.
    pub(super) count: usize,
    /// The component type, or `None` if glTF 2.0 does not define it.
    pub(super) component: Option<Component>,
    /// The element type, or `None` if glTF 2.0 does not define it.
    pub(super) shape: Option<Shape>,
    /// Whether integers represent 0..1 or -1..1.
    pub(super) normalized: bool,
    base: Base<'a>,
    stride: usize,
    sparse: Option<Sparse<'a>>,
}

impl<'a> Accessor<'a> {
    /// Reads an accessor and checks that it lies inside its views.
    pub(super) fn read(
        item: &Item<'_>,
        views: &[Result<BufferView<'a>, Broken>],
        budget: &Budget,
        log: &Log,
    ) -> Read<Self> {
        let code = item.required("componentType", Item::whole)?;
        let kind = item.required("type", Item::string)?;
        let count = item.required("count", Item::whole)?;
        let (component, shape) = (Component::of_code(code), Shape::of_name(kind));
        let mut accessor = Self {
            location: item.location,
            count: usize::try_from(count).unwrap_or(usize::MAX),
            component,
            shape,
            normalized: item.flag("normalized", false)?,
            base: Base::Zeros,
            stride: 0,
            sparse: None,
        };
        if count == 0 {
            return Err(item.fault("`count` must be 1 or more"));
        }
        let (Some(component), Some(shape)) = (component, shape) else { return Ok(accessor) };
        accessor.stride = shape.stride(component);
        if let Some(view) = item.exact_index("bufferView", "buffer view", views.len())? {
            accessor.attach_view(item, views[view].as_ref().map_err(Broken::fault)?, shape.bytes(component), log)?;
        } else if item.has("byteOffset") {
            log.repair(item.fault("`byteOffset` needs a `bufferView`"), "it is ignored")?;
        }
        if let Some(sparse) = item.item("sparse")? {
            match Sparse::read(&sparse, accessor.count, shape.stride(component), views, log)? {
                Ok(sparse) => accessor.sparse = sparse,
                Err(broken) => accessor.base = Base::Absent(broken),
            }
            // Many accessors may share the indices, and each accessor unpacks them again.
            budget.take::<u32>(accessor.sparse.as_ref().map_or(0, |sparse| sparse.count))?;
        }
        Ok(accessor)
    }

    fn attach_view(&mut self, item: &Item<'_>, view: &BufferView<'a>, element: usize, log: &Log) -> Read<()> {
        self.stride = view.stride.unwrap_or(self.stride);
        if self.stride < element {
            return Err(item.fault(format!("an element has {element} bytes, but `byteStride` is {}", self.stride)));
        }
        let offset = item.required("byteOffset", |item, key| Ok(Some(item.whole(key)?.unwrap_or(0))))?;
        let length = (self.count as u64 - 1).saturating_mul(self.stride as u64).saturating_add(element as u64);
        let bytes = view.part(item, offset, length, &format!("{} elements", self.count), log)?;
        self.base = bytes.map_or_else(Base::Absent, Base::Bytes);
        Ok(())
    }

    /// Whether the accessor has neither data nor substitutions, and so consists of zeros.
    pub(super) fn is_zeros(&self) -> bool {
        matches!(self.base, Base::Zeros) && self.sparse.is_none()
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> ModelFault {
        self.location.fault(what)
    }

    pub(super) fn format(&self) -> String {
        let shape = self.shape.map_or("an unknown type", |s| s.name);
        let component = self.component.map_or("unknown components", Component::name);
        format!("{shape} of {}{component}", if self.normalized { "normalised " } else { "" })
    }

    pub(super) fn is_of(&self, shape: &str) -> bool {
        self.shape.is_some_and(|s| s.name == shape)
    }

    /// Returns the number of components per element, or 0 for an unknown type.
    pub(super) fn numbers(&self) -> usize {
        self.shape.map_or(0, |shape| shape.rows * shape.columns)
    }

    /// Fails unless `good` is true. In the message, `user` and `name` locate the reference, and `wanted` describes a valid
    /// accessor.
    pub(super) fn expect(&self, good: bool, user: Location, name: &str, wanted: &str) -> Read<()> {
        if good {
            return Ok(());
        }
        let what = format!("`{}` must be {wanted}, but {} is {}", shown(name), self.location, self.format());
        Err(user.fault(what))
    }

    /// Reads all elements as floats, which may be NaN or infinite. Integers keep their value. Normalised integers become 0..1 or
    /// -1..1. Of longer elements, the first `N` numbers are read, and shorter ones end in ones. Matrices of small integers are
    /// unsupported.
    pub(super) fn floats<const N: usize>(&self, normalized: bool, budget: &Budget) -> Read<Vec<[f32; N]>> {
        let (most, least) = match self.component {
            Some(Component::U8) => (255.0, 0.0),
            Some(Component::I8) => (127.0, -1.0),
            Some(Component::U16) => (65535.0, 0.0),
            Some(Component::I16) => (32767.0, -1.0),
            _ => (1.0, 0.0),
        };
        // The smallest signed code would be slightly below -1 and is defined as -1.
        let (scale, least) = if normalized { (1.0 / most, least) } else { (1.0, f32::MIN) };
        let mut zero = [0.0; N];
        zero.iter_mut().skip(self.numbers()).for_each(|missing| *missing = 1.0);
        match self.component {
            None => Err(self.fault("has components of an unknown type")),
            Some(Component::F32) => self.elements(budget, zero, f32::from_le_bytes),
            Some(Component::U8) => self.elements(budget, zero, |b: [u8; 1]| f32::from(b[0]) * scale),
            Some(Component::I8) => {
                self.elements(budget, zero, |b| (f32::from(i8::from_le_bytes(b)) * scale).max(least))
            }
            Some(Component::U16) => self.elements(budget, zero, |b| f32::from(u16::from_le_bytes(b)) * scale),
            Some(Component::I16) => {
                self.elements(budget, zero, |b| (f32::from(i16::from_le_bytes(b)) * scale).max(least))
            }
            Some(Component::U32) => self.elements(budget, zero, |b| u32::from_le_bytes(b) as f32),
        }
    }

    /// Returns the fault of the first value that is NaN or infinite.
    pub(super) fn not_finite<const N: usize>(&self, values: &[[f32; N]]) -> Option<ModelFault> {
        let values = values.as_flattened();
        let i = values.iter().position(|v| !v.is_finite())?;
        Some(self.fault(format!("element {} holds {}", i / N, values[i])))
    }

    /// Reads all elements as integers. Returns `None` if components are not unsigned integers.
    pub(super) fn whole_numbers<const N: usize>(&self, budget: &Budget) -> Read<Option<Vec<[u32; N]>>> {
        match self.component {
            Some(Component::U8) => self.elements(budget, [0; N], |b: [u8; 1]| u32::from(b[0])),
            Some(Component::U16) => self.elements(budget, [0; N], |b| u32::from(u16::from_le_bytes(b))),
            Some(Component::U32) => self.elements(budget, [0; N], u32::from_le_bytes),
            _ => return Ok(None),
        }
        .map(Some)
    }

    fn elements<T: Copy, const N: usize, const B: usize>(
        &self,
        budget: &Budget,
        zero: [T; N],
        convert: impl Fn([u8; B]) -> T,
    ) -> Read<Vec<[T; N]>> {
        budget.take::<[T; N]>(self.count)?;
        let mut out = Vec::new();
        let short = |_| ModelFault::too_large(format!("no memory for {} elements", self.count));
        out.try_reserve_exact(self.count).map_err(short)?;
        let element = |bytes: &[u8]| {
            let mut numbers = bytes.as_chunks::<B>().0.iter().take(self.numbers());
            zero.map(|zero| numbers.next().map_or(zero, |b| convert(*b)))
        };
        let size = self.numbers() * B;
        match self.base {
            Base::Absent(broken) => return Err(broken.fault()),
            Base::Zeros => out.resize(self.count, zero),
            Base::Bytes(bytes) if self.stride == size => out.extend(bytes.chunks_exact(size).map(element)),
            // The last element may be shorter than the stride.
            Base::Bytes(bytes) => out.extend(bytes.chunks(self.stride).map(element)),
        }
        if let Some(sparse) = &self.sparse {
            let values = sparse.values.chunks_exact(size);
            for (index, value) in sparse.element_indices().zip(values) {
                out[index] = element(value);
            }
        }
        Ok(out)
    }
}

impl<'a> Sparse<'a> {
    /// Reads the sparse substitutions, or the fault of a buffer without data.
    fn read(
        item: &Item<'_>,
        count: usize,
        element: usize,
        views: &[Result<BufferView<'a>, Broken>],
        log: &Log,
    ) -> Read<Result<Option<Self>, &'a Broken>> {
        let changed = item.required("count", Item::whole)?;
        if changed == 0 || changed > count as u64 {
            let what = format!("`count` is {changed}, but must be from 1 to {count}, the number of elements");
            return if changed == 0 {
                log.repair(item.fault(what), "nothing is substituted").map(|()| Ok(None))
            } else {
                Err(item.fault(what))
            };
        }
        let index = {
            let indices = item.required("indices", Item::item)?;
            let code = indices.required("componentType", Item::whole)?;
            let unsigned = [Component::U8, Component::U16, Component::U32];
            let component = Component::of_code(code).filter(|c| unsigned.contains(c));
            component.ok_or_else(|| indices.fault("`componentType` must be 5121, 5123 or 5125 (unsigned)"))?
        };
        let part = |key: &'static str, size: usize| -> Read<(Item<'_>, Result<&'a [u8], &'a Broken>)> {
            let part = item.required(key, Item::item)?;
            let view = part.required("bufferView", |part, key| part.index(key, "buffer view", views.len()))?;
            let view = views[view].as_ref().map_err(Broken::fault)?;
            let offset = part.required("byteOffset", |part, key| Ok(Some(part.whole(key)?.unwrap_or(0))))?;
            let length = changed.saturating_mul(size as u64);
            let bytes = view.part(&part, offset, length, &format!("{changed} elements"), log)?;
            Ok((part, bytes))
        };
        let (location, indices) = part("indices", index.bytes())?;
        let (_, values) = part("values", element)?;
        let (indices, values) = match (indices, values) {
            (Ok(indices), Ok(values)) => (indices, values),
            (Err(broken), _) | (_, Err(broken)) => return Ok(Err(broken)),
        };
        let sparse = Self { count: changed as usize, indices, index, values };
        let (mut least, mut sorted) = (0, true);
        for (i, at) in sparse.element_indices().enumerate() {
            if at < least || at >= count {
                let what = format!("index {i} is {at}, but indices must increase and stay below {count}");
                if at >= count {
                    return Err(location.fault(what));
                }
                if sorted {
                    log.repair(location.fault(what), "they are used in their order")?;
                }
                sorted = false;
            }
            least = at + 1;
        }
        Ok(Ok(Some(sparse)))
    }

    fn element_indices(&self) -> impl Iterator<Item = usize> {
        let size = self.index.bytes();
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, &b| sum << 8 | usize::from(b));
        self.indices.chunks_exact(size).take(self.count).map(number)
    }
}
