//! Attaches props to bending skin. The props follow the skin around them instead of a single joint.

use glam::Vec3;

use super::skeleton::joint_index;
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// The joints whose props (dew claws with their horn) are on skin that is moved by several joints.
const BENDING: [&str; 2] = ["ankle_L", "ankle_R"];

/// Gives all vertices of a dew claw the weights of one body vertex. The chosen vertex is nearest to the highest point of the claw, where
/// the claw leaves the leg. The claw stays rigid and attached.
pub fn attach(props: &mut PatchMesh, body: &PatchMesh) {
    for joint in BENDING {
        let joint = joint_index(joint) as u16;
        let members: Vec<usize> = (0..props.skin.len()).filter(|&v| props.skin[v].joints[0] == joint).collect();
        let Some(root) = members.iter().map(|&v| props.positions[v]).max_by(|a, b| a.z.total_cmp(&b.z)) else {
            continue;
        };
        let Some(nearest) = nearest(&body.positions, root) else { continue };
        for v in members {
            props.skin[v] = body.skin[nearest];
        }
    }
}

fn nearest(positions: &[Vec3], p: Vec3) -> Option<usize> {
    let distance = |v: usize| positions[v].distance_squared(p);
    (0..positions.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trex::{Trex, skin::Skin, walk};
    use leadr_maps::cache::MapCache;
    use leadr_render::surfaces::skinning::skin;

    #[test]
    fn dew_claws_stay_on_the_leg_through_a_stride() {
        let cache = MapCache::in_folder(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/tmp/trex"));
        let trex = Trex::load_from(Some(&cache), 8, &|_| {}).unwrap();
        let joint = joint_index("ankle_L") as u16;
        let plain = crate::trex::props::build(&Skin::new(), crate::trex::props::Detail::Fine);
        let members: Vec<usize> = (0..plain.skin.len()).filter(|&v| plain.skin[v].joints[0] == joint).collect();
        let root = *members.iter().max_by(|&&a, &&b| plain.positions[a].z.total_cmp(&plain.positions[b].z)).unwrap();
        let body = nearest(&trex.body.positions, plain.positions[root]).unwrap();
        let drift = |props: &PatchMesh| {
            let offset = |time: f64| {
                let joints = walk::pose(time);
                let (prop, leg) = (skin(props, &joints).positions[root], skin(&trex.body, &joints).positions[body]);
                prop.distance(leg)
            };
            let rest = plain.positions[root].distance(trex.body.positions[body]);
            (0..16).map(|i| (offset(f64::from(i) * 0.1) - rest).abs()).fold(0.0, f32::max)
        };
        let (attached, rigid) = (drift(&trex.props), drift(&plain));
        println!("root of the dew claw moves {:.1} mm against the leg, {:.1} mm before", attached * 1e3, rigid * 1e3);
        assert!(attached < 0.003 && attached <= rigid);
    }
}
