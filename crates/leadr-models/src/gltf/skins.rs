//! Skins, and the check of the vertices' joint indices.

use std::collections::{HashMap, HashSet};

use glam::Mat4;

use super::accessor::Component;
use super::json::{Item, Read};
use super::nodes::affine;
use super::source::Source;
use crate::fault::ModelFault;
use crate::limits::MAX_JOINTS;
use crate::mesh::{Mesh, Primitive};
use crate::model::{Node, Skin};

pub(super) fn read(source: &Source<'_>) -> Read<Vec<Skin>> {
    source.root.items("skins", "skin")?.iter().map(|item| read_skin(source, item)).collect()
}

fn read_skin(source: &Source<'_>, item: &Item<'_>) -> Read<Skin> {
    let nodes = source.root.length("nodes")?;
    let count = item.length("joints")?;
    if count > MAX_JOINTS {
        return Err(item.fault(format!("has {count} joints; the limit is {MAX_JOINTS}")));
    }
    let joints = item.indices("joints", "node", nodes)?;
    if joints.is_empty() {
        return Err(item.fault("has no joints"));
    }
    let mut seen = HashSet::new();
    if let Some(twice) = joints.iter().find(|&&joint| !seen.insert(joint)) {
        return Err(item.fault(format!("has node {twice} as two of its joints")));
    }
    item.index("skeleton", "node", nodes)?;
    let inverse_bind = match source.accessor(item, "inverseBindMatrices")? {
        None => vec![Mat4::IDENTITY; count],
        Some(accessor) => {
            let good = accessor.component == Some(Component::F32) && accessor.is_of("MAT4");
            accessor.expect(good, item.location, "inverseBindMatrices", "MAT4 of floats")?;
            if accessor.count < count {
                return Err(item.fault(format!("has {count} joints, but {} inverse bind matrices", accessor.count)));
            }
            let all = accessor.floats::<16>(&source.budget)?;
            let matrix = |(i, columns): (usize, &[f32; 16])| {
                affine(columns).map_err(|what| item.fault(format!("inverse bind matrix {i} {what}")))
            };
            all.iter().take(count).enumerate().map(matrix).collect::<Read<_>>()?
        }
    };
    Ok(Skin { name: item.name()?, joints, inverse_bind })
}

/// Refuses vertices whose joint index is outside the node's skin, and reports skins that have no effect.
pub(super) fn check_joints(source: &Source<'_>, nodes: &[Node], meshes: &[Mesh], skins: &[Skin]) -> Read<()> {
    let mut known = HashMap::new();
    for (number, node) in nodes.iter().enumerate() {
        let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { continue };
        let joints = skins[skin].joints.len();
        let most = *known.entry(mesh).or_insert_with(|| most_joint(&meshes[mesh]));
        match most {
            Some((most, primitive)) if usize::from(most) >= joints => {
                let what = format!(
                    "mesh {mesh}, primitive {primitive} follows joint {most}, but skin {skin} has {joints} joints"
                );
                return Err(ModelFault::invalid(format!("node {number}"), what));
            }
            Some(_) => {}
            None => {
                source.remark(format!("node {number}: has a skin, but mesh {mesh} has no joints; the skin is ignored"))
            }
        }
    }
    Ok(())
}

/// Returns the largest joint index in a mesh, and the index of the primitive that uses the joint.
fn most_joint(mesh: &Mesh) -> Option<(u16, usize)> {
    let of_primitive = |(number, primitive): (usize, &Primitive)| {
        let influences = primitive.influences.as_ref()?;
        Some((influences.iter().flat_map(|i| i.joints).max().unwrap_or(0), number))
    };
    mesh.primitives.iter().enumerate().filter_map(of_primitive).max()
}
