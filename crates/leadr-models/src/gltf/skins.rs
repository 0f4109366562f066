//! Skins, and the check of the vertices' joint indices.

use std::collections::HashSet;

use glam::Mat4;

use super::accessor::Component;
use super::json::{Item, Read};
use super::nodes::affine;
use super::source::Source;
use crate::fault::ModelFault;
use crate::limits::MAX_JOINTS;
use crate::mesh::{Influences, Mesh};
use crate::model::{Node, Skin};

/// Reads all skins. A skin without joints has no effect.
pub(super) fn read(source: &Source<'_>) -> Read<Vec<Skin>> {
    source.root.items("skins", "skin")?.iter().map(|item| read_skin(source, item)).collect()
}

fn read_skin(source: &Source<'_>, item: &Item<'_>) -> Read<Skin> {
    let log = source.log;
    let nodes = source.root.length("nodes")?;
    let count = item.length("joints")?;
    if count > MAX_JOINTS {
        return Err(ModelFault::too_large(format!("{} has {count} joints; the limit is {MAX_JOINTS}", item.location)));
    }
    let mut skin =
        Skin { name: item.name()?, joints: item.indices("joints", "node", nodes)?, inverse_bind: Vec::new() };
    if skin.joints.len() != count {
        // The vertices refer to joints by their place in the list.
        log.repair(item.fault("has joints that are not nodes"), "the skin is ignored")?;
        skin.joints.clear();
    } else if skin.joints.is_empty() {
        log.repair(item.fault("has no joints"), "the skin is ignored")?;
    }
    let mut seen = HashSet::new();
    if let Some(twice) = skin.joints.iter().find(|&&joint| !seen.insert(joint)) {
        log.repair(item.fault(format!("has node {twice} as two of its joints")), "both move with the node")?;
    }
    item.index("skeleton", "node", nodes)?;
    match inverse_bind(source, item, skin.joints.len()) {
        Ok(matrices) => skin.inverse_bind = matrices,
        Err(fault) => log.repair(fault, "the joints are bound at the origin")?,
    }
    skin.inverse_bind.resize(skin.joints.len(), Mat4::IDENTITY);
    Ok(skin)
}

/// Reads the inverse bind matrices of a skin. There may be fewer than joints.
fn inverse_bind(source: &Source<'_>, item: &Item<'_>, joints: usize) -> Read<Vec<Mat4>> {
    let Some(accessor) = source.accessor(item, "inverseBindMatrices")? else { return Ok(Vec::new()) };
    let good = accessor.component == Some(Component::F32) && accessor.is_of("MAT4");
    accessor.expect(good, item.location, "inverseBindMatrices", "MAT4 of floats")?;
    if accessor.count < joints {
        let what = format!("has {joints} joints, but {} inverse bind matrices", accessor.count);
        source.log.repair(item.fault(what), "the other joints are bound at the origin")?;
    }
    let mut all = accessor.floats::<16>(false, &source.budget)?;
    all.truncate(joints);
    if let Some(fault) = accessor.not_finite(&all) {
        source.log.repair(fault, "joints with such matrices are bound at the origin")?;
    }
    let mut matrices = Vec::with_capacity(all.len());
    for (i, columns) in all.iter().enumerate() {
        let (matrix, fault) = affine(columns);
        if let Some(what) = fault {
            source.log.repair(item.fault(format!("inverse bind matrix {i} {what}")), "the row is replaced")?;
        }
        matrices.push(if matrix.is_finite() { matrix } else { Mat4::IDENTITY });
    }
    Ok(matrices)
}

/// Removes skins without effect from nodes, and joints outside the skin from vertices.
pub(super) fn check_joints(source: &Source<'_>, nodes: &mut [Node], meshes: &mut [Mesh], skins: &[Skin]) -> Read<()> {
    // The smallest number of joints for which the vertices of each mesh have been checked.
    let mut checked = vec![usize::MAX; meshes.len()];
    for (number, node) in nodes.iter_mut().enumerate() {
        let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { continue };
        let joints = skins[skin].joints.len();
        if joints == 0 {
            node.skin = None;
            continue;
        }
        let primitives = &meshes[mesh].primitives;
        if !primitives.is_empty() && primitives.iter().all(|primitive| primitive.influences.is_none()) {
            let fault =
                ModelFault::invalid(format!("node {number}"), format!("has a skin, but mesh {mesh} has no joints"));
            source.log.repair(fault, "the skin is ignored")?;
            node.skin = None;
        }
        if checked[mesh] <= joints {
            continue;
        }
        checked[mesh] = joints;
        for (part, primitive) in meshes[mesh].primitives.iter_mut().enumerate() {
            let all = primitive.influences.iter_mut().flatten();
            let most = all.map(|influences| influences.without_others(joints)).max().unwrap_or(0);
            if usize::from(most) >= joints {
                let what =
                    format!("mesh {mesh}, primitive {part} follows joint {most}, but skin {skin} has {joints} joints");
                let fault = ModelFault::invalid(format!("node {number}"), what);
                source.log.repair(fault, "joints outside the skin move nothing")?;
            }
        }
    }
    Ok(())
}

impl Influences {
    /// Gives the weights of joints from `joints` on to the others, or to the first joint if there are none. Returns the largest
    /// joint.
    fn without_others(&mut self, joints: usize) -> u16 {
        let most = self.joints.into_iter().max().unwrap_or(0);
        if usize::from(most) < joints {
            return most;
        }
        let mut kept: Vec<(u16, f32)> = self.joints.into_iter().zip(self.weights).collect();
        kept.retain(|&(joint, weight)| usize::from(joint) < joints && weight > 0.0);
        let sum: f32 = kept.iter().map(|(_, weight)| weight).sum();
        *self = Self { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
        for (i, (joint, weight)) in kept.into_iter().enumerate() {
            (self.joints[i], self.weights[i]) = (joint, weight / sum);
        }
        most
    }
}
