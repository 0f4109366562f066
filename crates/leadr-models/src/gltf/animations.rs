//! Animations. A channel that cannot be read is left out, and so is an animation without channels.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::Quat;

use super::accessor::Component;
use super::extensions::POINTER;
use super::json::{Item, Read};
use super::nodes::unit_rotation;
use super::source::Source;
use crate::animation::{Animation, Channel, Curve, Interpolation, Property};
use crate::fault::shown;
use crate::limits::COORDINATES;
use crate::mesh::Mesh;
use crate::model::{Node, Transform};

/// A repair is reported if a quaternion's length differs from 1 by more than this limit.
const ROUNDING: f32 = 0.01;

/// A squared length within this distance of 1 is exact up to rounding.
const NEARLY: f32 = 4.0 * f32::EPSILON;

pub(super) fn read(source: &Source<'_>, nodes: &mut [Node], meshes: &[Mesh]) -> Read<Vec<Animation>> {
    let mut reader = Reader { source, nodes, meshes };
    let mut all = Vec::new();
    for item in source.root.items("animations", "animation")? {
        match reader.read(&item) {
            Ok(animation) => all.extend(Some(animation).filter(|animation| !animation.channels.is_empty())),
            Err(fault) => source.log.repair(fault, "the animation is left out")?,
        }
    }
    Ok(all)
}

struct Reader<'a> {
    source: &'a Source<'a>,
    nodes: &'a mut [Node],
    meshes: &'a [Mesh],
}

impl Reader<'_> {
    fn read(&mut self, item: &Item<'_>) -> Read<Animation> {
        let log = self.source.log;
        let mut animation = Animation { name: item.name()?, ..Animation::default() };
        let samplers = item.items("samplers", "sampler")?;
        let channels = item.items("channels", "channel")?;
        if channels.is_empty() {
            return Err(item.fault("has no channels"));
        }
        let (mut seen, mut curves) = (HashMap::new(), HashMap::new());
        for channel in &channels {
            let moved = self.channel(channel, &samplers, &mut curves, &mut animation.curves);
            let moved = match moved {
                Ok(Some(moved)) => moved,
                Ok(None) => continue,
                Err(fault) => {
                    log.repair(fault, "the channel is left out")?;
                    continue;
                }
            };
            match seen.entry((moved.node, moved.property)) {
                Entry::Vacant(first) => {
                    first.insert(animation.channels.len());
                    animation.channels.push(moved);
                }
                Entry::Occupied(earlier) => {
                    let fault = channel.fault("has the same target as an earlier channel");
                    log.repair(fault, "it replaces the earlier one")?;
                    animation.channels[*earlier.get()] = moved;
                }
            }
        }
        let ends = animation.curves.iter().filter_map(|curve| curve.times.last());
        animation.duration = ends.fold(0.0, |end: f32, &t| end.max(t));
        Ok(animation)
    }

    /// Reads a channel and its curve. `known` has the curves of a sampler by property and width. Returns `None` if the target is not
    /// a core property or has no effect.
    fn channel(
        &mut self,
        channel: &Item<'_>,
        samplers: &[Item<'_>],
        known: &mut HashMap<(usize, Property, usize), usize>,
        curves: &mut Vec<Curve>,
    ) -> Read<Option<Channel>> {
        let sampler = channel.required("sampler", |channel, key| channel.index(key, "sampler", samplers.len()))?;
        let target = channel.required("target", Item::item)?;
        let Some((node, property)) = self.target(&target)? else { return Ok(None) };
        let width = self.width(&target, node, property)?;
        let curve = match known.entry((sampler, property, width)) {
            Entry::Occupied(curve) => *curve.get(),
            Entry::Vacant(new) => {
                curves.push(self.curve(&samplers[sampler], property, width)?);
                *new.insert(curves.len() - 1)
            }
        };
        Ok(Some(Channel { node, property, curve }))
    }

    /// Returns the target of a channel. Returns `None` if the target is not a core property or has no effect.
    fn target(&mut self, target: &Item<'_>) -> Read<Option<(usize, Property)>> {
        let mut node = target.exact_index("node", "node", self.nodes.len())?;
        let mut path = target.required("path", Item::string)?;
        if let (Some(extension), "pointer") = (target.extension(POINTER)?, path) {
            path = extension.required("pointer", Item::string)?;
            let of_node = path.strip_prefix("/nodes/").and_then(|path| path.split_once('/'));
            if let Some((number, property)) = of_node {
                node = number.parse().ok().filter(|&node| node < self.nodes.len());
                path = if node.is_some() { property } else { path };
            }
        }
        let Some(property) = Property::named(path) else {
            self.source.log.remark(format!("{}: animates `{}`, which is not supported", target.location, shown(path)));
            return Ok(None);
        };
        let Some(node) = node else { return Ok(None) };
        if let (Transform::Matrix(matrix), true) = (self.nodes[node].transform, property != Property::Weights) {
            let fault = target.fault(format!("animates node {node}, which has a matrix"));
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            let parts = Transform::Parts { translation, rotation, scale };
            let error = (parts.matrix() - matrix).to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
            let error = if parts.matrix().is_finite() { error } else { f32::NAN };
            let size = matrix.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
            // Matrices without an inverse give NaN.
            if error.is_nan() || error > 1e-4 * size {
                return Err(fault);
            }
            self.source.log.repair(fault, "the matrix is split into its parts")?;
            self.nodes[node].transform = parts;
        }
        Ok(Some((node, property)))
    }

    fn width(&self, target: &Item<'_>, node: usize, property: Property) -> Read<usize> {
        let targets = self.nodes[node].mesh.map_or(0, |mesh| self.meshes[mesh].target_count);
        match property {
            Property::Translation | Property::Scale => Ok(3),
            Property::Rotation => Ok(4),
            Property::Weights if targets > 0 => Ok(targets),
            Property::Weights => {
                Err(target.fault(format!("animates the weights of node {node}, which has no morph targets")))
            }
        }
    }

    fn curve(&self, item: &Item<'_>, property: Property, width: usize) -> Read<Curve> {
        let (log, budget, location) = (self.source.log, &self.source.budget, item.location);
        let interpolation = match item.string("interpolation")? {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(other) => {
                let fault = item.fault(format!("`interpolation` {} is unknown", shown(other)));
                log.repair(fault, "it is read as LINEAR")?;
                Interpolation::Linear
            }
        };
        let input = item.required("input", |item, key| self.source.accessor(item, key))?;
        let output = item.required("output", |item, key| self.source.accessor(item, key))?;
        let good = input.component == Some(Component::F32) && input.is_of("SCALAR");
        input.expect(good, location, "input", "SCALAR of floats")?;
        let (shape, elements) = match property {
            Property::Translation | Property::Scale => ("VEC3", 1),
            Property::Rotation => ("VEC4", 1),
            Property::Weights => ("SCALAR", width),
        };
        let may_be_small = matches!(property, Property::Rotation | Property::Weights) && output.normalized;
        let component_is_good = match output.component {
            Some(Component::F32) => true,
            Some(Component::U32) | None => false,
            Some(_) => may_be_small,
        };
        let small = if may_be_small { " or normalised integers" } else { "" };
        let good = component_is_good && output.is_of(shape);
        output.expect(good, location, "output", &format!("{shape} of floats{small}"))?;
        let per_key = if interpolation == Interpolation::Cubic { 3 } else { 1 };
        let wanted = input.count.saturating_mul(per_key * elements);
        if output.count != wanted {
            let keys = input.count;
            return Err(location.fault(format!("has {} values for {keys} keys, but needs {wanted}", output.count)));
        }
        let times = input.floats::<1>(false, budget)?.into_flattened();
        let values = match property {
            Property::Translation | Property::Scale => output.floats::<3>(may_be_small, budget)?.into_flattened(),
            Property::Rotation => output.floats::<4>(may_be_small, budget)?.into_flattened(),
            Property::Weights => output.floats::<1>(may_be_small, budget)?.into_flattened(),
        };
        if interpolation == Interpolation::Cubic && times.len() < 2 {
            log.repair(item.fault("is a cubic spline with one key; it needs two"), "its value is constant")?;
        }
        let mut curve = self.ordered(item, Curve { interpolation, times, width, values }, per_key * width)?;
        if property == Property::Rotation {
            self.unit_rotations(item, &mut curve.values, per_key)?;
        }
        Ok(curve)
    }

    /// Sorts the keys of a curve by time, and leaves out keys that are not numbers. A key has `size` values.
    fn ordered(&self, item: &Item<'_>, curve: Curve, size: usize) -> Read<Curve> {
        let (log, times) = (self.source.log, &curve.times);
        let is_good = |key: usize| {
            times[key].is_finite() && curve.values[key * size..][..size].iter().all(|value| COORDINATES.contains(value))
        };
        let mut keys: Vec<usize> = (0..times.len()).filter(|&key| is_good(key)).collect();
        if keys.len() < times.len() {
            let bad = times.len() - keys.len();
            log.repair(item.fault(format!("{bad} keys are not numbers or too large")), "these keys are left out")?;
        }
        if let Some(pair) = keys.windows(2).find(|pair| times[pair[1]] <= times[pair[0]]) {
            let [before, key] = [pair[0], pair[1]];
            let what = format!("time {key} is {} after {}, but times must increase", times[key], times[before]);
            log.repair(item.fault(what), "the keys are sorted")?;
            keys.sort_by(|&a, &b| times[a].total_cmp(&times[b]));
        }
        let Some(&first) = keys.first() else { return Err(item.fault("has no keys")) };
        if times[first] < 0.0 {
            let fault = item.fault(format!("its first time is {}, but must be at least 0", times[first]));
            log.repair(fault, "the animation starts at 0")?;
        }
        if keys.iter().copied().eq(0..times.len()) {
            return Ok(curve);
        }
        let values = keys.iter().flat_map(|&key| &curve.values[key * size..][..size]).copied().collect();
        Ok(Curve { times: keys.iter().map(|&key| times[key]).collect(), values, ..curve })
    }

    fn unit_rotations(&self, item: &Item<'_>, values: &mut [f32], per_key: usize) -> Read<()> {
        let (mut uneven, mut lost) = (0, None);
        let (keys, _) = values.as_chunks_mut::<4>();
        for (number, value) in keys.iter_mut().skip(per_key / 2).step_by(per_key).enumerate() {
            let given = Quat::from_array(*value);
            if (given.length_squared() - 1.0).abs() < NEARLY {
                continue;
            }
            uneven += usize::from((given.length() - 1.0).abs() > ROUNDING);
            let unit = unit_rotation(given);
            if unit.is_none() {
                lost.get_or_insert(number);
            }
            *value = unit.unwrap_or(Quat::IDENTITY).to_array();
        }
        if let Some(number) = lost {
            let fault = item.fault(format!("the rotation of key {number} has zero length"));
            self.source.log.repair(fault, "such rotations are replaced by none")
        } else if uneven > 0 {
            let fault = item.fault(format!("{uneven} rotations are not of unit length"));
            self.source.log.repair(fault, "they are scaled to unit length")
        } else {
            Ok(())
        }
    }
}
