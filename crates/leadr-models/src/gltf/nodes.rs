//! The node hierarchy: transforms, contents of nodes, and the check that nodes form a forest.

use std::f32::consts::SQRT_2;

use glam::{Mat4, Quat, Vec3};

use super::extensions::LIGHTS;
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
        for child in nodes[parent].children.clone() {
            if let Some(other) = nodes[child].parent.replace(parent) {
                let what = format!("is a child of node {other} and of node {parent}");
                return Err(location(child).fault(what));
            }
        }
    }
    Ok(nodes)
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
                weights = morph_weights(item, targets)?.unwrap_or_else(|| self.meshes.weights[mesh].clone());
            }
            None if skin.is_some() || item.has("weights") => {
                self.source.remark(format!("{}: has a skin or weights, but no mesh; they are ignored", item.location));
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
        })
    }

    fn transform(&self, item: &Item<'_>) -> Read<Transform> {
        let parts = ["translation", "rotation", "scale"].iter().any(|part| item.has(part));
        if let Some(matrix) = item.vector::<16>("matrix", COORDINATES)? {
            if parts {
                return Err(item.fault("has both a `matrix` and `translation`, `rotation` or `scale`"));
            }
            return affine(&matrix).map(Transform::Matrix).map_err(|what| item.fault(format!("`matrix` {what}")));
        }
        let given = Quat::from_array(item.vector("rotation", COORDINATES)?.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let rotation = unit_rotation(given).ok_or_else(|| item.fault("`rotation` has zero length"))?;
        if (given.length() - 1.0).abs() > ROUNDING {
            self.source.remark(format!("{}: its rotation is not of unit length; it was scaled", item.location));
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

/// Converts a column-major matrix, whose last row must be 0 0 0 1 up to rounding.
pub(super) fn affine(columns: &[f32; 16]) -> Result<Mat4, String> {
    const ROUNDING: f32 = 1e-3;
    let mut matrix = *columns;
    for (column, wanted) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        let value = &mut matrix[4 * column + 3];
        if (*value - wanted).abs() > ROUNDING {
            return Err(format!("has {value} in its last row, which must be 0 0 0 1"));
        }
        *value = wanted;
    }
    Ok(Mat4::from_cols_array(&matrix))
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
            return Err(item.fault(format!("lists node {root}, which is not a root but a child of node {parent}")));
        }
        roots.sort_unstable();
        roots.dedup();
        scenes.push(SceneRoots { name: item.name()?, roots });
    }
    Ok((scenes, default_scene(&source.root)?))
}

pub(super) fn default_scene(root: &Item<'_>) -> Read<Option<usize>> {
    root.index("scene", "scene", root.length("scenes")?)
}
