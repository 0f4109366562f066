//! How the word for the visible surface of a pixel is split into an object number and a patch number (`passes/visible.glsl`).

use crate::scene::Object;
use leadr_gpu::{GpuError, Result, SpecValue};

/// The number of bits of the word that object and patch use together.
const BITS: u32 = 30;
/// The allowed numbers of bits for the object. The object depth has 16 bits, and its largest value means that there is no object
/// (`passes/object_depth.glsl`).
const OBJECT_BITS: std::ops::RangeInclusive<u32> = 6..=14;

/// The maximum number of objects in a scene. Two more numbers are reserved, for the background and for the sea.
pub const MAX_OBJECTS: usize = (1 << *OBJECT_BITS.end()) - 2;

/// The number of bits for the object. Scenes with fewer objects allow more patches per object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbering {
    object_bits: u32,
}

impl Numbering {
    /// Returns the numbering for a scene. Each instance counts as an object.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for more than [`MAX_OBJECTS`] objects, or if an object has too many patches.
    pub fn of(objects: &[Object]) -> Result<Self> {
        let count: usize = objects.iter().map(|object| object.instances as usize).sum();
        if count > MAX_OBJECTS {
            let fault = format!("{count} objects exceed the limit of {MAX_OBJECTS}");
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        let numbering = Self::of_count(count);
        let most = numbering.patches();
        match objects.iter().find(|object| object.mesh.patches.len() > most) {
            Some(object) => {
                let patches = object.mesh.patches.len();
                let fault = format!("{patches} patches exceed the limit of {most} per object in a scene of {count}");
                Err(GpuError::Usage { name: object.name.clone(), fault })
            }
            None => Ok(numbering),
        }
    }

    /// Returns the numbering of a scene with this number of objects, at most [`MAX_OBJECTS`].
    pub fn of_count(objects: usize) -> Self {
        Self { object_bits: (objects as u32 + 2).next_power_of_two().ilog2().max(*OBJECT_BITS.start()) }
    }

    /// Returns the maximum number of patches of an object.
    pub fn patches(self) -> usize {
        1 << (BITS - self.object_bits)
    }

    /// Returns the object number of the sea.
    pub fn sea(self) -> u32 {
        (1 << self.object_bits) - 1
    }

    /// Returns the object number in a word (counted from 1, or 0 in empty pixels), and the patch number.
    pub fn parts(self, word: u32) -> [u32; 2] {
        let shift = BITS - self.object_bits;
        [word >> shift & self.sea(), word & ((1 << shift) - 1)]
    }

    /// Returns the specialisation constant for the shaders.
    pub fn spec(self) -> (&'static str, SpecValue) {
        ("OBJECT_BIT_COUNT", SpecValue::U32(self.object_bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::patch_mesh::PatchMesh;

    fn scene(objects: usize) -> Vec<Object> {
        (0..objects).map(|_| Object::new("test", PatchMesh::default())).collect()
    }

    #[test]
    fn objects_take_the_bits_that_they_need() {
        for (objects, bits) in [(0, 6), (62, 6), (63, 7), (126, 7), (127, 8), (1000, 10), (MAX_OBJECTS, 14)] {
            let numbering = Numbering::of(&scene(objects)).unwrap();
            assert_eq!((numbering.sea() + 1).ilog2(), bits, "{objects} objects");
            assert!(numbering.sea() > objects as u32);
            let last = numbering.patches() as u32 - 1;
            let word = numbering.sea() << (30 - bits) | last;
            assert_eq!(numbering.parts(word | 3 << 30), [numbering.sea(), last]);
        }
        let error = Numbering::of(&scene(MAX_OBJECTS + 1)).unwrap_err().to_string();
        assert!(error.contains("16383 objects exceed the limit of 16382"), "{error}");
    }

    #[test]
    fn crowded_scenes_limit_patches_per_object() {
        let mut objects = scene(10_000);
        objects[7].mesh.patches = vec![[0; 4]; (1 << 16) + 1];
        let error = Numbering::of(&objects).unwrap_err().to_string();
        assert!(error.contains("65537 patches exceed the limit of 65536"), "{error}");
        objects.truncate(1000);
        assert!(Numbering::of(&objects).is_ok());
    }
}
