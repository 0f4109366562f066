//! How the word that tells what a pixel sees is divided between object and patch (`passes/visible.glsl`).

use crate::scene::Object;
use leadr_gpu::{GpuError, Result, SpecValue};

/// Bits of a word for object and patch.
const BITS: u32 = 30;
/// Fewest and most bits for the object. Its depth has 16, the last of which is that of no object (`passes/object_depth.glsl`).
const OBJECT_BITS: std::ops::RangeInclusive<u32> = 6..=14;

/// Largest number of objects in a scene: the background and the sea have numbers too.
pub const MAX_OBJECTS: usize = (1 << *OBJECT_BITS.end()) - 2;

/// How many bits objects have. The fewer objects a scene has, the more patches each may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbering {
    object_bits: u32,
}

impl Numbering {
    /// That of a scene. Each instance of an object counts.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for more than [`MAX_OBJECTS`], and for an object with more patches than there are numbers left for.
    pub fn of(objects: &[Object]) -> Result<Self> {
        let count: usize = objects.iter().map(|object| object.instances as usize).sum();
        if count > MAX_OBJECTS {
            let fault = format!("{count} objects are more than {MAX_OBJECTS}");
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        let object_bits = (count as u32 + 2).next_power_of_two().ilog2().max(*OBJECT_BITS.start());
        let numbering = Self { object_bits };
        let most = numbering.patches();
        match objects.iter().find(|object| object.mesh.patches.len() > most) {
            Some(object) => {
                let patches = object.mesh.patches.len();
                let fault =
                    format!("its {patches} patches are more than {most}, as many as each of {count} objects may have");
                Err(GpuError::Usage { name: object.name.clone(), fault })
            }
            None => Ok(numbering),
        }
    }

    /// Largest number of patches of an object.
    pub fn patches(self) -> usize {
        1 << (BITS - self.object_bits)
    }

    /// The number of the sea.
    pub fn sea(self) -> u32 {
        (1 << self.object_bits) - 1
    }

    /// The object, from 1, or 0 where nothing is, and its patch.
    pub fn parts(self, word: u32) -> [u32; 2] {
        let shift = BITS - self.object_bits;
        [word >> shift & self.sea(), word & ((1 << shift) - 1)]
    }

    /// The constant of the shaders.
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
        assert!(error.contains("16383 objects are more than 16382"), "{error}");
    }

    #[test]
    fn an_object_of_many_has_fewer_patches() {
        let mut objects = scene(10_000);
        objects[7].mesh.patches = vec![[0; 4]; (1 << 16) + 1];
        let error = Numbering::of(&objects).unwrap_err().to_string();
        assert!(error.contains("65537 patches are more than 65536"), "{error}");
        objects.truncate(1000);
        assert!(Numbering::of(&objects).is_ok());
    }
}
