//! The memory that a model needs, checked before its nodes are expanded. A small file can draw a mesh many times.

use super::parts::{Part, Parted, Parts};
use crate::error::SceneError;
use leadr_gpu::machine_memory;
use leadr_maps::limits::format_bytes;
use leadr_models::Model;

/// Maximum memory of the triangles and vertices of a model in bytes, on the CPU and the device together.
const MOST_BYTES: u64 = 8 << 30;
/// Bytes of a triangle in an object, including the search for its edges.
const TRIANGLE_BYTES: u64 = 320;
/// Bytes of a vertex in an object.
const VERTEX_BYTES: u64 = 64;
/// Bytes of a triangle in each instance and frame.
const DRAWN_TRIANGLE_BYTES: u64 = 32;
/// Bytes of a vertex in each instance and frame.
const DRAWN_VERTEX_BYTES: u64 = 224;
/// Bytes of a vertex of a displaced model at each sampled time.
const WELDED_VERTEX_BYTES: u64 = 32;

/// Triangles and vertices.
#[derive(Clone, Copy, Default)]
struct Counts {
    triangles: u64,
    vertices: u64,
}

impl Counts {
    fn of<'a>(model: &Model, parts: impl IntoIterator<Item = &'a Part>) -> Self {
        parts.into_iter().fold(Self::default(), |sum, part| {
            let primitive = part.shown_in(model);
            Self {
                triangles: sum.triangles + primitive.triangles.len() as u64,
                vertices: sum.vertices + primitive.positions.len() as u64,
            }
        })
    }
}

/// Refuses a model that needs more than [`MOST_BYTES`], or more than the free memory. `times`: the number of sampled animation times.
pub fn check(model: &Model, parts: &Parts, times: u32) -> Result<(), SceneError> {
    let staged = Counts::of(model, parts.objects.iter().flat_map(Parted::staged));
    let drawn = Counts::of(model, parts.objects.iter().flat_map(|object| &object.parts));
    let welded = if parts.are_displaced(model) { u64::from(times) * WELDED_VERTEX_BYTES } else { 0 };
    let bytes = staged.triangles * TRIANGLE_BYTES
        + staged.vertices * VERTEX_BYTES
        + drawn.triangles * DRAWN_TRIANGLE_BYTES
        + drawn.vertices * (DRAWN_VERTEX_BYTES + welded);
    let most = MOST_BYTES.min(machine_memory().unwrap_or(u64::MAX));
    if bytes <= most {
        return Ok(());
    }
    let nodes = parts.objects.iter().map(|object| object.parts.len()).sum::<usize>();
    let Counts { triangles, vertices } = drawn;
    let [needed, most] = [bytes, most].map(format_bytes);
    Err(SceneError::Model(format!(
        "its nodes draw {nodes} meshes of {triangles} triangles and {vertices} vertices in total, which need about {needed}; the \
         limit is {most}; remove copies or simplify the meshes"
    )))
}
