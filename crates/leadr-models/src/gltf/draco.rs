//! Decodes primitives that are compressed by Draco (`KHR_draco_mesh_compression`).

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute};
use leadr_maps::MapFault;
use leadr_maps::guard::guarded;

use super::extensions::DRACO;
use super::json::{Item, Read};
use super::source::Source;
use crate::fault::Broken;

/// Bytes that a vertex may need, with all its attributes.
const VERTEX_BYTES: usize = 256;

pub(super) struct Draco<'a> {
    mesh: Mesh,
    /// The identifiers of the compressed attributes.
    attributes: Item<'a>,
}

impl<'a> Draco<'a> {
    /// Decodes the compressed data of a primitive, if there are any.
    pub(super) fn read(source: &Source<'_>, primitive: &Item<'a>) -> Read<Option<Self>> {
        let Some(extension) = primitive.extension(DRACO)? else { return Ok(None) };
        let view = extension.required("bufferView", |item, key| item.index(key, "buffer view", source.views.len()))?;
        let bytes = source.views[view].as_ref().map_err(Broken::fault)?.bytes()?;
        let attributes = extension.required("attributes", Item::item)?;
        // The accessors declare the size of the decoded data. Seams between attributes add vertices while decoding.
        let declared = primitive.required("attributes", Item::item)?;
        let declared = declared.required("POSITION", |item, key| source.accessor(item, key))?.count;
        let corners = source.accessor(primitive, "indices")?.map_or(declared, |accessor| accessor.count);
        let vertices = declared.saturating_add(corners);
        source.budget.take::<[u8; VERTEX_BYTES]>(vertices)?;
        let mut limits = DecodeLimits::default();
        limits.max_points = vertices as u64;
        limits.max_faces = corners as u64;
        limits.max_decoded_bytes = (vertices * VERTEX_BYTES) as u64;
        let mut mesh = Mesh::new();
        let decoded = guarded("Draco", || {
            let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
            MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|error| MapFault::damaged(error.to_string()))
        });
        let points = mesh.num_points();
        match decoded {
            Ok(()) if mesh.faces().iter().flatten().all(|corner| (corner.0 as usize) < points) => {
                Ok(Some(Self { mesh, attributes }))
            }
            Ok(()) => Err(extension.fault("has compressed triangles of vertices that do not exist")),
            Err(MapFault::Damaged { what }) => {
                Err(extension
                    .fault(format!("has damaged data of the compression Draco ({})", crate::fault::shown(&what))))
            }
            Err(fault) => Err(extension.fault(fault.to_string())),
        }
    }

    pub(super) fn triangles(&self) -> Vec<[u32; 3]> {
        self.mesh.faces().iter().map(|face| face.map(|corner| corner.0)).collect()
    }

    /// Returns the values of an attribute, if it is compressed. Integers keep their value, unless they are normalised. Missing
    /// numbers of a value are 1.
    pub(super) fn floats<const N: usize>(&self, name: &str, normalized: bool) -> Read<Option<Vec<[f32; N]>>> {
        let Some(id) = self.attributes.whole(name)?.and_then(|id| u32::try_from(id).ok()) else { return Ok(None) };
        let Some(attribute) = self.mesh.attribute_by_unique_id(id) else {
            return Err(self.attributes.fault(format!("`{name}` is not in the compressed data")));
        };
        let scale = if normalized { scale(attribute) } else { 1.0 };
        let width = usize::from(attribute.num_components());
        let numbers = attribute.read_f32s(self.mesh.num_points(), width);
        let value = |numbers: &[f32]| std::array::from_fn(|i| numbers.get(i).map_or(1.0, |v| v * scale));
        Ok(Some(numbers.chunks_exact(width.max(1)).map(value).collect()))
    }
}

/// Returns the factor by which the integers of an attribute become shares.
fn scale(attribute: &PointAttribute) -> f32 {
    match attribute.data_type() {
        DataType::Int8 => 1.0 / 127.0,
        DataType::Uint8 => 1.0 / 255.0,
        DataType::Int16 => 1.0 / 32767.0,
        DataType::Uint16 => 1.0 / 65535.0,
        _ => 1.0,
    }
}
