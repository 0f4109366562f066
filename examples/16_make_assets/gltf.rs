//! Builds a binary glTF file.

use serde_json::{Value, json};

/// The JSON parts and the binary data of a file.
#[derive(Default)]
pub struct Glb {
    views: Vec<Value>,
    accessors: Vec<Value>,
    bytes: Vec<u8>,
}

impl Glb {
    /// Appends bytes as a buffer view. `target` is the use of the view in a mesh.
    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends floats, `N` per element. `bounds` is whether `min` and `max` are written.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]], target: Option<u32>, bounds: bool) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"].get(N - 1).copied().unwrap_or("MAT4");
        let mut accessor = json!({ "componentType": 5126, "count": values.len(), "type": kind });
        if bounds {
            let fold = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
                (0..N).map(|i| values.iter().map(|v| v[i]).reduce(pick).unwrap_or(0.0)).collect()
            };
            accessor["min"] = json!(fold(f32::min));
            accessor["max"] = json!(fold(f32::max));
        }
        self.accessor(accessor, &bytes, target)
    }

    /// Appends 16-bit integers, `N` per element.
    pub fn shorts<const N: usize>(&mut self, values: &[[u16; N]], target: u32) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let kind = if N == 1 { "SCALAR" } else { "VEC4" };
        let accessor = json!({ "componentType": 5123, "count": values.len(), "type": kind });
        self.accessor(accessor, &bytes, Some(target))
    }

    fn accessor(&mut self, mut accessor: Value, bytes: &[u8], target: Option<u32>) -> usize {
        accessor["bufferView"] = json!(self.view(bytes, target));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Returns the file. `rest` contains the JSON except for buffers, views and accessors.
    pub fn file(mut self, mut rest: Value) -> Vec<u8> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        rest["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        rest["bufferViews"] = Value::Array(self.views);
        rest["accessors"] = Value::Array(self.accessors);
        let mut text = rest.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        let mut file = Vec::with_capacity(length);
        for word in [0x4654_6c67, 2, length as u32, text.len() as u32, 0x4e4f_534a] {
            file.extend(u32::to_le_bytes(word));
        }
        file.extend(text);
        for word in [self.bytes.len() as u32, 0x004e_4942] {
            file.extend(u32::to_le_bytes(word));
        }
        file.extend(self.bytes);
        file
    }
}
