//! The node hierarchy: transforms, contents of nodes, and the check that nodes form a forest.

use std::f32::consts::SQRT_2;

use glam::{Mat4, Quat, Vec3};

use super::accessor::Accessor;
use super::extensions::{INSTANCING, LEVELS, LIGHTS, VISIBILITY};
use super::json::{Item, Location, Read};
use super::meshes::{Meshes, morph_weights};
use super::source::Source;
use crate::limits::COORDINATES;
use crate::model::{Model, Node, SceneRoots, Transform};

/// A repair is reported if a quaternion's length differs from 1 by more than this limit.
const ROUNDING: f32 = 0.005;

pub(super) fn read(source: &Source<'_>, meshes: &Meshes, lights: usize) -> Read<Vec<Node>> {
    let items = source.root.items("nodes", "node")?;
    let reader = Reader { source, meshes, lights, count: items.len() };
    let mut nodes = items.iter().map(|item| reader.read(item)).collect::<Read<Vec<_>>>()?;
    for parent in 0..nodes.len() {
        let mut children = std::mem::take(&mut nodes[parent].children);
        let mut kept = Ok(());
        children.retain(|&child| {
            let what = match nodes[child].parent {
                _ if child == parent => "is its own child".to_owned(),
                Some(earlier) => format!("is a child of node {earlier} and of node {parent}"),
                None => {
                    nodes[child].parent = Some(parent);
                    return true;
                }
            };
            if kept.is_ok() {
                kept = source.log.repair(location(child).fault(what), "only its first parent moves it");
            }
            false
        });
        kept?;
        nodes[parent].children = children;
    }
    for (number, item) in items.iter().enumerate() {
        if let Some(levels) = item.extension(LEVELS)? {
            // The node itself is the finest level.
            for level in levels.indices("ids", "node", items.len())? {
                nodes[level].visible &= level == number;
            }
        }
        if let Some(extension) = item.extension(INSTANCING)? {
            match instances(source, &extension) {
                Ok(transforms) => place_copies(source, &mut nodes, number, transforms)?,
                Err(fault) => source.log.lose(fault, "its mesh is drawn once")?,
            }
        }
    }
    Ok(nodes)
}

/// Reads the transforms of the copies of a node's mesh.
fn instances(source: &Source<'_>, extension: &Item<'_>) -> Read<Vec<Transform>> {
    let attributes = extension.required("attributes", Item::item)?;
    let [translation, rotation, scale] =
        ["TRANSLATION", "ROTATION", "SCALE"].map(|name| source.accessor(&attributes, name));
    let (translation, rotation, scale) = (translation?, rotation?, scale?);
    let counts = [translation, rotation, scale].into_iter().flatten().map(|accessor| accessor.count);
    let Some(count) = counts.clone().min() else { return Err(attributes.fault("has no transforms")) };
    if counts.max() != Some(count) {
        let fault = attributes.fault("has attributes of different lengths");
        source.log.repair(fault, "the shortest gives the number of copies")?;
    }
    fn values<const N: usize>(source: &Source<'_>, accessor: Option<&Accessor<'_>>) -> Read<Option<Vec<[f32; N]>>> {
        accessor.map(|accessor| accessor.floats::<N>(accessor.normalized, &source.budget)).transpose()
    }
    let translations = values::<3>(source, translation)?;
    let rotations = values::<4>(source, rotation)?;
    let scales = values::<3>(source, scale)?;
    source.budget.take::<Node>(count)?;
    let transform = |i: usize| {
        let rotation = rotations.as_ref().map_or(Quat::IDENTITY, |all| Quat::from_array(all[i]));
        Transform::Parts {
            translation: translations.as_ref().map_or(Vec3::ZERO, |all| Vec3::from(all[i])),
            rotation: unit_rotation(rotation).unwrap_or(Quat::IDENTITY),
            scale: scales.as_ref().map_or(Vec3::ONE, |all| Vec3::from(all[i])),
        }
    };
    let all: Vec<Transform> = (0..count).map(transform).collect();
    match all.iter().position(|transform| !transform.matrix().is_finite()) {
        Some(i) => Err(attributes.fault(format!("has a transform {i} that is not a number"))),
        None => Ok(all),
    }
}

/// Replaces the mesh of a node by child nodes that draw it.
fn place_copies(source: &Source<'_>, nodes: &mut Vec<Node>, number: usize, transforms: Vec<Transform>) -> Read<()> {
    if nodes[number].mesh.is_none() {
        return Ok(());
    }
    source.budget.take::<f32>(transforms.len().saturating_mul(nodes[number].weights.len()))?;
    let first = nodes.len();
    for transform in transforms {
        let copy = Node {
            parent: Some(number),
            children: Vec::new(),
            transform,
            skin: None,
            camera: None,
            light: None,
            visible: true,
            ..nodes[number].clone()
        };
        nodes.push(copy);
    }
    let added = first..nodes.len();
    nodes[number].children.extend(added);
    nodes[number].mesh = None;
    Ok(())
}

fn location(node: usize) -> Location {
    Location::ROOT.below("node", Some(node))
}

struct Reader<'a> {
    source: &'a Source<'a>,
    meshes: &'a Meshes,
    lights: usize,
    count: usize,
}

impl Reader<'_> {
    fn read(&self, item: &Item<'_>) -> Read<Node> {
        let root = &self.source.root;
        let mesh = item.index("mesh", "mesh", self.meshes.meshes.len())?;
        let mut skin = item.index("skin", "skin", root.length("skins")?)?;
        let light = match item.extension(LIGHTS)? {
            Some(extension) => extension.index("light", "light", self.lights)?,
            None => None,
        };
        let mut weights = Vec::new();
        match mesh {
            Some(mesh) => {
                let targets = self.meshes.meshes[mesh].target_count;
                self.source.budget.take::<f32>(targets)?;
                weights =
                    morph_weights(item, targets, self.source.log)?.unwrap_or_else(|| self.meshes.weights[mesh].clone());
            }
            None if skin.is_some() || item.has("weights") => {
                let fault = item.fault("has a skin or weights, but no mesh");
                self.source.log.repair(fault, "they are ignored")?;
                skin = None;
            }
            None => {}
        }
        Ok(Node {
            name: item.name()?,
            parent: None,
            children: item.indices("children", "node", self.count)?,
            transform: self.transform(item)?,
            mesh,
            skin,
            camera: item.index("camera", "camera", root.length("cameras")?)?,
            light,
            weights,
            visible: match item.extension(VISIBILITY)? {
                Some(extension) => extension.flag("visible", true)?,
                None => true,
            },
        })
    }

    fn transform(&self, item: &Item<'_>) -> Read<Transform> {
        let log = self.source.log;
        let parts = ["translation", "rotation", "scale"].iter().any(|part| item.has(part));
        if let Some(matrix) = item.vector::<16>("matrix", COORDINATES)? {
            if parts {
                let fault = item.fault("has both a `matrix` and `translation`, `rotation` or `scale`");
                log.repair(fault, "the matrix is used")?;
            }
            let (matrix, fault) = affine(&matrix);
            if let Some(what) = fault {
                log.repair(item.fault(format!("`matrix` {what}")), "the row is replaced")?;
            }
            return Ok(Transform::Matrix(matrix));
        }
        let given = Quat::from_array(item.vector("rotation", COORDINATES)?.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let rotation = match unit_rotation(given) {
            Some(rotation) => rotation,
            None => {
                log.repair(item.fault("`rotation` has zero length"), "the node is not rotated")?;
                Quat::IDENTITY
            }
        };
        if given.length() > 0.0 && (given.length() - 1.0).abs() > ROUNDING {
            let what = format!("`rotation` has the length {}, which must be 1", given.length());
            log.repair(item.fault(what), "it is scaled to unit length")?;
        }
        Ok(Transform::Parts {
            translation: Vec3::from(item.vector("translation", COORDINATES)?.unwrap_or([0.0; 3])),
            rotation,
            scale: Vec3::from(item.vector("scale", COORDINATES)?.unwrap_or([1.0; 3])),
        })
    }
}

/// Normalises a quaternion, or returns `None` if its length is 0.
pub(super) fn unit_rotation(given: Quat) -> Option<Quat> {
    let unit = given.as_dquat();
    let length = unit.length();
    (length > f64::from(f32::MIN_POSITIVE) * f64::from(SQRT_2)).then(|| (unit / length).as_quat())
}

/// Converts a column-major matrix. Its last row is replaced by 0 0 0 1, and the fault of another row is returned.
pub(super) fn affine(columns: &[f32; 16]) -> (Mat4, Option<String>) {
    const ROUNDING: f32 = 1e-3;
    let mut matrix = *columns;
    let mut fault = None;
    for (column, wanted) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        let value = &mut matrix[4 * column + 3];
        if (*value - wanted).abs() > ROUNDING {
            fault.get_or_insert(format!("has {value} in its last row, which must be 0 0 0 1"));
        }
        *value = wanted;
    }
    (Mat4::from_cols_array(&matrix), fault)
}

/// Returns the node indices in an order with parents before children. Fails if a node is its own ancestor.
pub(super) fn order(nodes: &[Node]) -> Read<Vec<usize>> {
    let mut order: Vec<usize> = (0..nodes.len()).filter(|&node| nodes[node].parent.is_none()).collect();
    let mut next = 0;
    while next < order.len() {
        // Every node has at most one parent, so no node is added twice.
        order.extend(&nodes[order[next]].children);
        next += 1;
    }
    if order.len() < nodes.len() {
        let mut reached = vec![false; nodes.len()];
        order.iter().for_each(|&node| reached[node] = true);
        let lost = reached.iter().position(|reached| !reached).unwrap_or_default();
        return Err(location(lost).fault("is its own ancestor, or below a node that is"));
    }
    Ok(order)
}

/// Refuses a hierarchy in which a matrix exceeds the range of 32 bits.
pub(super) fn check_reach(model: &Model) -> Read<()> {
    let world = model.pose(None, 0.0).world_from_node;
    match model.order.iter().find(|&&node| !world[node].is_finite()) {
        None => Ok(()),
        Some(&node) => {
            Err(location(node)
                .fault("is scaled or moved so far that its position overflows; check the nodes above it too"))
        }
    }
}

pub(super) fn scenes(source: &Source<'_>, nodes: &[Node]) -> Read<(Vec<SceneRoots>, Option<usize>)> {
    let mut scenes = Vec::new();
    for item in source.root.items("scenes", "scene")? {
        let mut roots = item.indices("nodes", "node", nodes.len())?;
        if let Some((&root, parent)) = roots.iter().find_map(|root| Some((root, nodes[*root].parent?))) {
            let what = format!("lists node {root}, which is not a root but a child of node {parent}");
            source.log.repair(item.fault(what), "the node is shown where its parent places it")?;
        }
        roots.sort_unstable();
        roots.dedup();
        scenes.push(SceneRoots { name: item.name()?, roots });
    }
    Ok((scenes, source.root.index("scene", "scene", source.root.length("scenes")?)?))
}
