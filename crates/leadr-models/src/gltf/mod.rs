//! Reader for glTF 2.0, which converts the bytes of a file to a [`Model`]. All data are checked before use. What violates glTF is
//! repaired or left out with a remark, or refused in strict mode.

mod accessor;
mod animations;
mod document;
mod draco;
mod extensions;
mod glb;
mod images;
mod influences;
mod json;
mod log;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod repair;
mod skins;
mod source;
mod textures;
mod topology;
mod uri;
mod value;
mod views;

use std::path::Path;

use self::json::{Item, Read};
use self::log::Log;
use self::source::Source;
use self::uri::Folder;
use super::fault::shown;
use super::load::LoadOptions;
use super::model::Model;

pub use document::{Document, DocumentImage};
pub use extensions::READ as EXTENSIONS_READ;

/// Decodes a model from the bytes of its file. Other files are read from `folder`.
pub(super) fn decode(bytes: &[u8], name: &str, folder: Option<&Path>, options: &LoadOptions) -> Read<Model> {
    let folder = folder.map(|path| Folder { path, links: options.links });
    let log = Log::new(options.strict);
    let container = glb::open(bytes, &log)?;
    let json = value::parse(container.json)?;
    let root = Item::root(&json, &log);
    extensions::check_version(&root, &log)?;
    let buffers = source::buffers(&root, container.binary, folder, &log)?;
    let budget = source::budget(&buffers);
    let unpacked = meshopt::views(&root, &buffers, &budget, &log)?;
    let source = Source::open(root, &log, &buffers, &unpacked, budget, folder, options.variant.as_deref())?;
    let mut model = Model { name: name.to_owned(), ..Model::default() };
    read_parts(&source, &mut model)?;
    let mut primitives = model.meshes.iter().flat_map(|mesh| &mesh.primitives);
    if primitives.all(|primitive| primitive.triangles.is_empty())
        && let Some(fault) = log.first_loss()
    {
        return Err(fault);
    }
    model.remarks = log.into_remarks();
    Ok(model)
}

/// Reads each part of the model after the parts that it refers to.
fn read_parts(source: &Source<'_>, model: &mut Model) -> Read<()> {
    model.materials = materials::read(source)?;
    let meshes = meshes::read(source)?;
    if meshes.use_default_material {
        model.materials.push(materials::default());
    }
    model.cameras = views::cameras(source)?;
    model.lights = views::lights(source)?;
    model.nodes = nodes::read(source, &meshes, model.lights.len())?;
    model.order = nodes::order(&model.nodes)?;
    nodes::check_reach(model)?;
    (model.scenes, model.default_scene) = nodes::scenes(source, &model.nodes)?;
    model.skins = skins::read(source)?;
    model.meshes = meshes.meshes;
    skins::check_joints(source, &mut model.nodes, &mut model.meshes, &model.skins)?;
    model.animations = animations::read(source, &mut model.nodes, &model.meshes)?;
    remark_on_coordinates(source, model);
    Ok(())
}

/// Adds a message for each texture whose coordinate set is missing from a mesh.
fn remark_on_coordinates(source: &Source<'_>, model: &Model) {
    let sets: Vec<usize> = model.materials.iter().map(|m| m.coordinate_sets() as usize).collect();
    for (number, mesh) in model.meshes.iter().enumerate() {
        for (part, primitive) in mesh.primitives.iter().enumerate() {
            let (wanted, given) = (sets[primitive.material], primitive.texcoords.len());
            if wanted > given {
                let name = shown(&model.materials[primitive.material].name);
                source.log.remark(format!(
                    "mesh {number}, primitive {part}: has {given} sets of texture coordinates, but its material {name:?} uses {wanted}"
                ));
            }
        }
    }
}
