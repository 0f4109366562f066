//! Height maps that displace the materials of a model. The user specifies them, or they are found by name in the folder of the model.
//!
//! Priority: the user's maps, then `extras.leadr_displacement` in the file (read with the model), then maps in the folder of the file.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Serialize, Serializer};

use super::named::{NamedFile, materials_named};
use crate::error::SceneError;
use leadr_maps::folders::{OutsideLinks, matching};
use leadr_maps::limits::ImageBudget;
use leadr_maps::material::{Material, Relief, Role, role_of};
use leadr_maps::udim::Tiles;
use leadr_maps::{MapError, MapFault, load_height_map};
use leadr_models::Model;

/// A height map for a material, written as `MATERIAL=FILE`, `MATERIAL=FILE,SCALE` or `MATERIAL=FILE,SCALE,MIDDLE`.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacement {
    /// The material and its height map, a PNG or EXR file.
    pub named: NamedFile,
    /// The height difference between map values 0 and 1, in metres of the model's coordinates; `None` fits the normals or uses the default.
    pub scale: Option<f32>,
    /// The map value at which the surface coincides with the mesh; `None` uses the mean of the map.
    pub middle: Option<f32>,
}

/// Splits a file name from up to two numbers that follow it, separated by commas.
fn file_and_numbers(text: &str) -> (&str, Vec<f32>) {
    let mut file = text;
    // File names may contain commas, so numbers are read from the end.
    let mut numbers = Vec::new();
    while numbers.len() < 2
        && let Some((before, number)) = file.rsplit_once(',')
        && let Ok(number) = number.trim().parse::<f32>()
    {
        numbers.insert(0, number);
        file = before;
    }
    (file, numbers)
}

impl FromStr for Displacement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "write MATERIAL=FILE or MATERIAL=FILE,SCALE in metres, as in skin=scales.png,0.01";
        let (named, numbers) = NamedFile::read(text, form, file_and_numbers)?;
        if let Some(number) = numbers.iter().find(|number| !(-1e6..=1e6).contains(*number)) {
            return Err(format!("{number} is not a height; {form}"));
        }
        if numbers.first().is_some_and(|scale| *scale < 0.0) {
            return Err(format!("the scale is below 0; {form}"));
        }
        Ok(Self { named, scale: numbers.first().copied(), middle: numbers.get(1).copied() })
    }
}

impl Serialize for Displacement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut text = self.named.to_string();
        for number in [self.scale, self.middle].into_iter().flatten() {
            text += &format!(",{number}");
        }
        serializer.serialize_str(&text)
    }
}

/// Reads heights without a scale, relative to their mean.
fn relief_of(file: &Path) -> Result<Relief, MapError> {
    let map = load_height_map(file)?;
    let middle = map.mean();
    Ok(Relief { map, scale: None, in_widths: false, middle })
}

/// Applies the user's height maps to the materials of the model in `file`, and then the maps found in the folder of the file.
///
/// # Errors
/// If no material has the name (the message lists all names), a map is damaged, or a map beside the model is behind a link out of its folder
/// and `links` refuses it.
pub fn displace(
    model: &mut Model,
    file: &Path,
    requested: &[Displacement],
    links: OutsideLinks,
) -> Result<(), SceneError> {
    // Each displaced material has heights of its own.
    let budget = ImageBudget::default();
    let room = |relief: &Relief, map: &Path| {
        let bytes = size_of_val(&relief.map.texels[..]) as u64;
        budget.take(bytes).map_err(|fault| SceneError::from(fault.in_file(map)))
    };
    let mut reliefs: HashMap<PathBuf, Relief> = HashMap::new();
    for (material, map) in beside(model, file, links)? {
        let name = map.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let material = &mut model.materials[material];
        tracing::warn!("{}: found {name} beside the model; it displaces material {}", model.name, material.name);
        if !reliefs.contains_key(&map) {
            reliefs.insert(map.clone(), relief_of(&map)?);
        }
        room(&reliefs[&map], &map)?;
        material.relief = reliefs.get(&map).cloned();
    }
    for Displacement { named, scale, middle } in requested {
        let indices = materials_named(model, named.material.as_deref())?;
        let relief = relief_of(&named.file)?;
        let grid = Tiles::find(&named.file)?.map_or([1; 2], |tiles| tiles.grid);
        let relief = Relief { scale: *scale, middle: middle.unwrap_or(relief.middle), ..relief };
        for index in indices {
            room(&relief, &named.file)?;
            model.materials[index].relief = Some(relief.clone());
            model.materials[index].relief_tiles = grid;
        }
    }
    Ok(())
}

/// Finds height maps beside a model, named like a material without heights or its base colour image, plus a word for heights.
fn beside(model: &Model, file: &Path, links: OutsideLinks) -> Result<Vec<(usize, PathBuf)>, SceneError> {
    let names = |material: &Material| {
        let image = material.base_color.texture.as_ref().and_then(|texture| {
            let stem = Path::new(&texture.name).file_stem()?.to_str()?;
            let is_color = role_of(Path::new(&texture.name)) == Some(Role::Color);
            if is_color { without_role(stem) } else { Some(stem.to_lowercase()) }
        });
        [Some(material.name.to_lowercase()), image].into_iter().flatten()
    };
    let bare = || model.materials.iter().enumerate().filter(|(_, material)| material.relief.is_none());
    let wanted: HashSet<String> = bare().flat_map(|(_, material)| names(material)).collect();
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let of_name = |map: &Path| {
        let extension = map.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        let is_map =
            matches!(extension.as_deref(), Some("png" | "exr" | "tif" | "tiff")) && role_of(map) == Some(Role::Height);
        if is_map { without_role(map.file_stem()?.to_str()?).filter(|name| wanted.contains(name)) } else { None }
    };
    // A model of readable bytes needs no readable folder.
    let found = match matching(folder, |map| of_name(map).is_some()) {
        Err(MapFault::Io { .. }) => Vec::new(),
        found => found.map_err(|fault| fault.in_file(folder))?,
    };
    // The first map of a name counts.
    let maps: HashMap<String, PathBuf> =
        found.into_iter().rev().filter_map(|map| Some((of_name(&map)?, map))).collect();
    let map =
        |(number, material): (usize, &Material)| Some((number, names(material).find_map(|name| maps.get(&name))?));
    let found: Vec<(usize, PathBuf)> = bare().filter_map(map).map(|(number, map)| (number, map.clone())).collect();
    for (_, map) in &found {
        links.check(folder, Path::new(map.file_name().unwrap_or_default())).map_err(|fault| fault.in_file(map))?;
    }
    Ok(found)
}

/// Returns a name in lower case, without its last word.
fn without_role(stem: &str) -> Option<String> {
    let (name, _) = stem.rsplit_once(|c: char| !c.is_alphanumeric())?;
    (!name.is_empty()).then(|| name.to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::HeightMap;
    use leadr_maps::material::{Encoding, Input, Raster, Samples, Texture};
    use leadr_maps::save::save_png_grey16;
    use leadr_models::{Mesh, Node, Primitive};

    use crate::model::parts::tests::node;
    use crate::model::{ModelChoice, stage};

    #[test]
    fn displacements_are_read_as_they_are_written() {
        let read = |text: &str| text.parse::<Displacement>().unwrap();
        let skin = read("skin=a,b.png,0.02,0.5");
        assert_eq!(skin.named.file, Path::new("a,b.png"));
        assert_eq!((skin.named.material.as_deref(), skin.scale, skin.middle), (Some("skin"), Some(0.02), Some(0.5)));
        assert_eq!(serde_json::to_value(&skin).unwrap(), "skin=a,b.png,0.02,0.5");
        let all = read("*=a.exr");
        assert_eq!((all.named.material, all.scale, all.middle), (None, None, None));
        assert_eq!(read("a b=1,2.png").named.file, Path::new("1,2.png"));
        for wrong in ["skin.png", "=a.png", "skin=", "skin=,0.1", "skin=a.png,-1", "skin=a.png,nan"] {
            assert!(wrong.parse::<Displacement>().unwrap_err().contains("skin=scales.png"), "{wrong}");
        }
    }

    #[test]
    fn model_maps_are_found_by_name_after_explicit_ones() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, height: f32| {
            let map = HeightMap { width: 1, height: 1, texels: vec![height] };
            save_png_grey16(folder.path().join(name), &map, 0.0, 1.0).unwrap();
            folder.path().join(name)
        };
        put("Bark_Height.png", 0.2);
        put("leaf_disp.png", 0.4);
        put("stone_Color.png", 0.6);
        let requested = put("other.png", 0.8);
        let mut leaf = Material::new("Material.001");
        let raster = Raster::new(1, 1, 3, Samples::U8(vec![0; 3])).unwrap();
        leaf.base_color = Input::colors(Texture::new(raster, "leaf_BaseColor.png", Encoding::Srgb));
        let materials = vec![Material::new("bark"), leaf, Material::new("stone")];
        let model = Model { materials, ..Model::default() };
        let file = folder.path().join("tree.glb");
        let heights = |requested: &[Displacement]| {
            let mut model = model.clone();
            displace(&mut model, &file, requested, OutsideLinks::Refused).unwrap();
            let height = |m: &Material| m.relief.as_ref().map(|relief| (relief.map.texels[0] * 10.0).round());
            model.materials.iter().map(height).collect::<Vec<_>>()
        };
        assert_eq!(heights(&[]), [Some(2.0), Some(4.0), None]);
        let requested = |name: &str| format!("{name}={}", requested.to_string_lossy()).parse::<Displacement>().unwrap();
        assert_eq!(heights(&[requested("bark")]), [Some(8.0), Some(4.0), None]);
        assert_eq!(heights(&[requested("*")]), [Some(8.0); 3]);
        let error =
            displace(&mut model.clone(), &file, &[requested("moss")], OutsideLinks::Refused).unwrap_err().to_string();
        assert!(error.ends_with("no material is named moss; available: bark, Material.001, stone"), "{error}");
    }

    #[test]
    fn a_model_spans_several_tiles() {
        let folder = tempfile::tempdir().unwrap();
        for (tile, height) in [(1001, 0.2), (1002, 0.6), (1011, 0.9)] {
            let map = HeightMap { width: 4, height: 4, texels: vec![height; 16] };
            save_png_grey16(folder.path().join(format!("skin.{tile}.png")), &map, 0.0, 1.0).unwrap();
        }
        let at = [[0.5, 0.5], [1.5, 0.5], [0.5, -0.5]];
        let primitive = Primitive {
            triangles: vec![[0, 1, 2]],
            positions: at.map(|[x, y]| [x, -y, 0.0]).to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 3],
            texcoords: vec![at.to_vec()],
            ..Primitive::default()
        };
        let heights = |name: &str| {
            let mut model = Model {
                materials: vec![Material::new("skin")],
                meshes: vec![Mesh { primitives: vec![primitive.clone()], ..Mesh::default() }],
                nodes: vec![Node { mesh: Some(0), ..node() }],
                order: vec![0],
                ..Model::default()
            };
            model.scenes = vec![leadr_models::SceneRoots { name: String::new(), roots: vec![0] }];
            let map = folder.path().join(name);
            let requested = format!("skin={},2", map.to_string_lossy()).parse().unwrap();
            displace(&mut model, &folder.path().join("a.glb"), &[requested], OutsideLinks::Refused).unwrap();
            let object = stage(ModelChoice::new(model, None).unwrap()).unwrap().objects.remove(0);
            let field = object.heights.unwrap();
            [0, 1, 3].map(|corner| field.bilinear(object.mesh.texcoords[0][corner]))
        };
        for name in ["skin.<UDIM>.png", "skin.1001.png"] {
            let [first, right, above] = heights(name);
            assert!(
                (right - first - 0.8).abs() < 1e-3 && (above - first - 1.4).abs() < 1e-3,
                "{first} {right} {above}"
            );
        }
    }

    #[test]
    fn other_maps_hide_no_map_beside_a_model() {
        let folder = tempfile::tempdir().unwrap();
        let add = |name: &str| std::fs::write(folder.path().join(name), b"").unwrap();
        (0..=leadr_maps::folders::MAX_MATCHES).for_each(|i| add(&format!("{i}_Height.png")));
        add("zinc_Height.png");
        let model = Model { materials: vec![Material::new("tin"), Material::new("zinc")], ..Model::default() };
        let found = beside(&model, &folder.path().join("a.glb"), OutsideLinks::Refused).unwrap();
        assert_eq!(found, [(1, folder.path().join("zinc_Height.png"))]);
    }

    #[cfg(unix)]
    #[test]
    fn maps_behind_links_out_of_the_folder_are_refused() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::fs::write(other.path().join("secret"), b"").unwrap();
        std::os::unix::fs::symlink(other.path().join("secret"), folder.path().join("tin_Height.png")).unwrap();
        let model = Model { materials: vec![Material::new("tin")], ..Model::default() };
        let found = |links| beside(&model, &folder.path().join("a.glb"), links);
        let error = found(OutsideLinks::Refused).unwrap_err().to_string();
        assert!(error.contains("\"tin_Height.png\" leads out") && error.contains("--follow-links"), "{error}");
        assert_eq!(found(OutsideLinks::Followed).unwrap().len(), 1);
    }
}
