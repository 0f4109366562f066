//! Rewrites a glTF model with filtered textures (`KHR_texture_basisu`).
//!
//! An image that materials use in several ways, such as one roughness texture beside two normal maps, becomes several textures.

mod container;
mod uses;

use std::collections::HashMap;

use leadr_maps::material::Encoding;
use leadr_maps::mips::{MipLevel, Mips, NormalMips, RoughnessSource, color_mips, data_mips, roughness_mips};
use leadr_models::Document;
use serde_json::{Value, json};

use self::container::Parts;
use self::uses::{Treatment, Use, uses};
use crate::blocks::{BLOCK_SIDE, compress, whole_blocks};
use crate::engine::Engine;
use crate::ktx2_file::ktx2;

const BASISU: &str = "KHR_texture_basisu";
const LINEAR: u64 = 9729;
const LINEAR_MIPMAP_LINEAR: u64 = 9987;

/// A fault of a model whose textures cannot be rewritten. The message is one line with the remedy.
#[derive(Debug, thiserror::Error)]
pub enum FilterError {
    /// The model has no texture that can be filtered.
    #[error(
        "has no texture that can be filtered; it needs materials with PNG, JPEG or WebP images whose sides are {BLOCK_SIDE} or more"
    )]
    Nothing,
    /// The material has no texture that can be filtered.
    #[error(
        "has no picture of colours, normals, roughness, occlusion or metalness whose sides are {BLOCK_SIDE} or more"
    )]
    NoTexture,
    /// The engine reads no models with these textures.
    #[error("is a model, and {engine}: {remedy}")]
    NoModels {
        /// What the engine does not do.
        engine: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A reference or a list of the model is invalid.
    #[error("is invalid: {what}; correct it with the help of a glTF validator, or export the model again")]
    Invalid {
        /// What is wrong, and where.
        what: String,
    },
    /// The result would not fit into a GLB.
    #[error("becomes {bytes} bytes, and a GLB has at most 4294967295; use smaller textures")]
    TooLarge {
        /// The size of the result.
        bytes: u64,
    },
}

/// A model with filtered textures.
#[derive(Clone, Debug)]
pub struct FilteredModel {
    parts: Parts,
    /// The textures that were filtered.
    pub textures: Vec<FilteredTexture>,
    /// What was left as it is, and why, one line each.
    pub remarks: Vec<String>,
}

impl FilteredModel {
    /// Returns the bytes of a `.glb` file.
    ///
    /// # Errors
    /// Fails if the file would be too large.
    pub fn glb(self) -> Result<Vec<u8>, FilterError> {
        self.parts.glb()
    }

    /// Returns the names and the bytes of the files of a `.gltf`. All names begin with `name`, and the `.gltf` is the last.
    ///
    /// # Errors
    /// Fails if the list of images is invalid.
    pub fn files(self, name: &str) -> Result<Vec<(String, Vec<u8>)>, FilterError> {
        self.parts.files(name)
    }
}

/// A texture that was filtered.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredTexture {
    /// The name of the image.
    pub name: String,
    /// What the texture is for, such as `normals`.
    pub role: &'static str,
    /// The width and height of the finest level.
    pub size: [u32; 2],
    /// The number of bytes of the KTX2 file.
    pub bytes: u64,
    /// The mean of the perceptual roughness over the finest and over the coarsest level, where the texture has a roughness.
    pub roughness: Option<[f32; 2]>,
}

/// Filters the textures of a model. `progress` receives the number of finished textures and the number of all.
///
/// # Errors
/// Fails if the model has no texture to filter, if its lists of textures are invalid, if the result is too large for a GLB, or if the engine
/// reads no such models.
pub fn filter_model(
    document: Document,
    engine: Engine,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<FilteredModel, FilterError> {
    match engine {
        Engine::Unity => {
            let engine = "Unity reads models through glTFast";
            return Err(FilterError::NoModels { engine, remedy: "use --for gltf, and glTFast with KTX for Unity" });
        }
        Engine::Unreal => {
            let engine = "Unreal's importer reads no KTX2";
            return Err(FilterError::NoModels { engine, remedy: "bake the folder of its material" });
        }
        Engine::Gltf | Engine::Bevy | Engine::Godot => {}
    }
    let mut remarks = document.remarks.clone();
    let mut rewriter = Rewriter::new(document, engine);
    let mut all = uses(&mut rewriter.document.json, &mut remarks)?;
    if engine == Engine::Godot {
        all.retain(|of| !matches!(of.treatment, Treatment::Color { .. }));
    }
    let jobs = rewriter.jobs(&all, &mut remarks);
    if jobs.is_empty() {
        return Err(FilterError::Nothing);
    }
    let count = jobs.len();
    let mut textures = Vec::new();
    for (i, (job, users)) in jobs.into_iter().enumerate() {
        progress(i, count);
        textures.push(rewriter.filter(&job, &users)?);
    }
    progress(count, count);
    if engine != Engine::Bevy {
        rewriter.declare();
    }
    Ok(FilteredModel { parts: Parts::new(rewriter.document, rewriter.replaced)?, textures, remarks })
}

/// An image and the way in which it is filtered. The image is missing where a material has no roughness texture yet.
#[derive(Clone, Debug, PartialEq)]
struct Job {
    image: Option<usize>,
    treatment: Treatment,
}

struct Rewriter {
    document: Document,
    engine: Engine,
    /// The new bytes of images, by number.
    replaced: HashMap<usize, Vec<u8>>,
    /// The textures that already have a new image.
    taken: HashMap<usize, usize>,
    normals: HashMap<(usize, u32), NormalMips>,
}

impl Rewriter {
    fn new(document: Document, engine: Engine) -> Self {
        Self { document, engine, replaced: HashMap::new(), taken: HashMap::new(), normals: HashMap::new() }
    }

    /// Returns the image of a texture. Other formats come after the plain image, which every program reads.
    fn image_of(&self, texture: usize) -> Option<usize> {
        let texture = self.document.json["textures"].get(texture)?;
        let of = |value: &Value| value["source"].as_u64().map(|image| image as usize);
        let others = ["EXT_texture_webp", BASISU, "EXT_texture_avif", "MSFT_texture_dds"];
        of(texture)
            .into_iter()
            .chain(others.into_iter().filter_map(|name| of(&texture["extensions"][name])))
            .find(|&image| self.document.images.get(image).is_some_and(|image| image.raster.is_some()))
    }

    fn size_of(&self, image: usize) -> [u32; 2] {
        self.document.images[image].raster.as_ref().expect("only readable images are filtered").size()
    }

    /// Groups the uses of textures by the way in which they are filtered.
    fn jobs(&self, all: &[Use], remarks: &mut Vec<String>) -> Vec<(Job, Vec<Use>)> {
        let mut jobs: Vec<(Job, Vec<Use>)> = Vec::new();
        let mut small = Vec::new();
        for of in all {
            let mut treatment = of.treatment.clone();
            if let Treatment::Roughness { normals, .. } = &mut treatment {
                // The spread of the normals belongs to an image, not to a texture with a sampler.
                *normals = normals.and_then(|(texture, scale)| Some((self.image_of(texture)?, scale)));
            }
            let image = match (of.texture, &treatment) {
                (Some(texture), _) => match self.image_of(texture) {
                    Some(image) => Some(image),
                    None => continue, // the document remarks on unreadable images
                },
                (None, Treatment::Roughness { normals: Some(_), .. }) => None,
                (None, _) => continue,
            };
            let texels = image.or(match &treatment {
                Treatment::Roughness { normals, .. } => normals.map(|(image, _)| image),
                _ => None,
            });
            if let Some(image) = texels
                && self.size_of(image).into_iter().any(|side| side < BLOCK_SIDE)
            {
                if !small.contains(&image) {
                    small.push(image);
                    let ([w, h], name) = (self.size_of(image), &self.document.images[image].name);
                    remarks.push(format!("{name:?} has {w} x {h} texels, fewer than a block; it stays as it is"));
                }
                continue;
            }
            let job = Job { image, treatment };
            match jobs.iter_mut().find(|(other, _)| *other == job) {
                Some((_, users)) => users.push(of.clone()),
                None => jobs.push((job, vec![of.clone()])),
            }
        }
        jobs
    }

    fn filter(&mut self, job: &Job, users: &[Use]) -> Result<FilteredTexture, FilterError> {
        let mips = self.mips(job);
        let file = ktx2(&compress(&mips, self.engine.blocks()));
        let mean = |level: &MipLevel, channel: usize| {
            level.texels.iter().map(|t| f32::from(t[channel])).sum::<f32>() / (255.0 * level.texels.len() as f32)
        };
        let roughness = match job.treatment {
            Treatment::Roughness { channel, .. } => {
                Some([&mips.levels[0], &mips.levels[mips.levels.len() - 1]].map(|level| mean(level, channel)))
            }
            _ => None,
        };
        let name =
            job.image.map_or_else(|| "new roughness".to_owned(), |image| self.document.images[image].name.clone());
        let filtered = FilteredTexture {
            name,
            role: job.treatment.role(),
            size: mips.levels[0].size,
            bytes: file.len() as u64,
            roughness,
        };
        let image = self.store(job.image, file)?;
        for of in users {
            self.point(of, image)?;
        }
        Ok(filtered)
    }

    fn mips(&mut self, job: &Job) -> Mips {
        let spread = match &job.treatment {
            Treatment::Normals { scale } => job.image.map(|image| (image, *scale)),
            Treatment::Roughness { normals, .. } => *normals,
            _ => None,
        };
        let document = &self.document;
        let raster_of = |image: usize, encoding| {
            let raster = document.images[image].raster.as_deref().expect("only readable images are filtered");
            // The extension asks for whole blocks.
            whole_blocks(raster, encoding)
        };
        let spread = spread.map(|(image, scale)| {
            let filter = || NormalMips::new(&raster_of(image, Encoding::Linear), scale);
            &*self.normals.entry((image, scale.to_bits())).or_insert_with(filter)
        });
        let raster = |encoding| job.image.map(|image| raster_of(image, encoding));
        match &job.treatment {
            Treatment::Normals { .. } => spread.expect("normals have an image").mips(),
            Treatment::Roughness { channel, factor, .. } => {
                let raster = raster(Encoding::Linear);
                let source = RoughnessSource { raster: raster.as_deref(), channel: *channel, factor: *factor };
                roughness_mips(source, spread)
            }
            Treatment::Color { alpha } => color_mips(&raster(Encoding::Srgb).expect("colours have an image"), *alpha),
            Treatment::Data => data_mips(&raster(Encoding::Linear).expect("data have an image")),
        }
    }

    /// Puts a new file in place of an image, or appends it. Returns the number of the image.
    fn store(&mut self, image: Option<usize>, file: Vec<u8>) -> Result<usize, FilterError> {
        let name = image.map(|image| self.document.json["images"][image]["name"].clone()).filter(Value::is_string);
        let number = match image.filter(|image| !self.replaced.contains_key(image)) {
            Some(image) => image,
            None => {
                list(&mut self.document.json, "images")?.push(Value::Null);
                list(&mut self.document.json, "images")?.len() - 1
            }
        };
        let mut entry = json!({ "mimeType": "image/ktx2" });
        if let Some(name) = name {
            entry["name"] = name;
        }
        self.document.json["images"][number] = entry;
        self.replaced.insert(number, file);
        Ok(number)
    }

    /// Makes a material's texture show an image.
    fn point(&mut self, of: &Use, image: usize) -> Result<(), FilterError> {
        let json = &mut self.document.json;
        // A texture can be used in several ways. Its first image takes its place.
        let texture = match of.texture {
            Some(texture) if *self.taken.entry(texture).or_insert(image) == image => texture,
            _ => {
                let copy =
                    of.texture.or(of.like).map_or_else(|| json!({}), |texture| json["textures"][texture].clone());
                let all = list(json, "textures")?;
                let same = |texture: &Value| {
                    let sources = [&texture["source"], &texture["extensions"][BASISU]["source"]];
                    sources.contains(&&json!(image)) && texture["sampler"] == copy["sampler"]
                };
                match all.iter().position(same) {
                    Some(texture) => texture,
                    None => {
                        all.push(copy);
                        all.len() - 1
                    }
                }
            }
        };
        let entry = json["textures"][texture].as_object_mut().ok_or_else(|| invalid(format!("texture {texture}")))?;
        // Other formats of the old image are left out.
        entry.remove("extensions");
        if self.engine == Engine::Bevy {
            entry.insert("source".to_owned(), json!(image));
        } else {
            entry.remove("source");
            entry.insert("extensions".to_owned(), json!({ BASISU: { "source": image } }));
        }
        if let Some(sampler) = json["textures"][texture]["sampler"].as_u64()
            && let Some(filter) = json.pointer_mut(&format!("/samplers/{sampler}/minFilter"))
            && filter.as_u64() == Some(LINEAR)
        {
            *filter = json!(LINEAR_MIPMAP_LINEAR);
        }
        let info = json.pointer_mut(&of.pointer).ok_or_else(|| invalid(of.pointer.clone()))?;
        info["index"] = json!(texture);
        Ok(())
    }

    /// Lists the extension.
    fn declare(&mut self) {
        for key in ["extensionsUsed", "extensionsRequired"] {
            let list = &mut self.document.json[key];
            if !list.is_array() {
                *list = json!([]);
            }
            if let Some(list) = list.as_array_mut()
                && !list.iter().any(|name| name == BASISU)
            {
                list.push(json!(BASISU));
            }
        }
    }
}

fn invalid(what: impl Into<String>) -> FilterError {
    FilterError::Invalid { what: what.into() }
}

/// Returns a list of the model, which is empty if the model has none.
fn list<'a>(json: &'a mut Value, key: &str) -> Result<&'a mut Vec<Value>, FilterError> {
    if json[key].is_null() {
        json[key] = json!([]);
    }
    json[key].as_array_mut().ok_or_else(|| invalid(format!("`{key}` must be an array")))
}
