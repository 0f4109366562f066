//! Animations. The reader checks that times increase and that values match their targets.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::Quat;

use super::accessor::{Accessor, Component};
use super::json::{Item, Read};
use super::nodes::unit_rotation;
use super::source::Source;
use crate::animation::{Animation, Channel, Curve, Interpolation, Property};
use crate::fault::shown;
use crate::limits::MAX_COORDINATE;
use crate::mesh::Mesh;
use crate::model::{Node, Transform};

/// A repair is reported if a quaternion's length differs from 1 by more than this limit.
const ROUNDING: f32 = 0.01;

pub(super) fn read(source: &Source<'_>, nodes: &[Node], meshes: &[Mesh]) -> Read<Vec<Animation>> {
    let items = source.root.items("animations", "animation")?;
    items.iter().map(|item| Reader { source, nodes, meshes }.read(item)).collect()
}

/// A squared length within this distance of 1 is exact up to rounding.
const NEARLY: f32 = 4.0 * f32::EPSILON;

struct Reader<'a> {
    source: &'a Source<'a>,
    nodes: &'a [Node],
    meshes: &'a [Mesh],
}

struct Sampler<'a> {
    item: Item<'a>,
    interpolation: Interpolation,
    times: Vec<f32>,
    output: &'a Accessor<'a>,
    /// The curve that was created from the sampler, and its property.
    curve: Option<(usize, Property)>,
}

impl Reader<'_> {
    fn read(&self, item: &Item<'_>) -> Read<Animation> {
        let mut animation = Animation { name: item.name()?, ..Animation::default() };
        let samplers = item.items("samplers", "sampler")?;
        let mut samplers = samplers.into_iter().map(|item| self.sampler(item)).collect::<Read<Vec<_>>>()?;
        let mut seen = HashMap::new();
        let channels = item.items("channels", "channel")?;
        if channels.is_empty() {
            return Err(item.fault("has no channels"));
        }
        for channel in channels {
            let sampler = channel.index("sampler", "sampler", samplers.len())?;
            let sampler = &mut samplers[channel.required("sampler", sampler)?];
            let target = channel.required("target", channel.item("target")?)?;
            let Some((node, property)) = self.target(&target)? else { continue };
            let width = self.width(&target, node, property)?;
            let curve = match sampler.curve {
                Some((curve, same)) if same == property => curve,
                _ => {
                    animation.curves.push(self.curve(sampler, property, width)?);
                    animation.curves.len() - 1
                }
            };
            sampler.curve = Some((curve, property));
            if animation.curves[curve].width != width {
                return Err(target.fault("its sampler is used with another number of morph targets"));
            }
            let moved = Channel { node, property, curve };
            match seen.entry((node, property)) {
                Entry::Vacant(first) => {
                    first.insert(animation.channels.len());
                    animation.channels.push(moved);
                }
                Entry::Occupied(earlier) => {
                    let location = channel.location;
                    self.source
                        .remark(format!("{location}: has the same target as an earlier channel, and replaces it"));
                    animation.channels[*earlier.get()] = moved;
                }
            }
        }
        let ends = animation.curves.iter().filter_map(|curve| curve.times.last());
        animation.duration = ends.fold(0.0, |end: f32, &t| end.max(t));
        Ok(animation)
    }

    /// Returns the target of a channel. Returns `None` if the target is not a core property or has no effect.
    fn target(&self, target: &Item<'_>) -> Read<Option<(usize, Property)>> {
        let node = target.index("node", "node", self.nodes.len())?;
        let path = target.required("path", target.string("path")?)?;
        let property = match path {
            "translation" => Property::Translation,
            "rotation" => Property::Rotation,
            "scale" => Property::Scale,
            "weights" => Property::Weights,
            other => {
                self.source.remark(format!("{}: animates `{}`, which is not supported", target.location, shown(other)));
                return Ok(None);
            }
        };
        let Some(node) = node else { return Ok(None) };
        if property != Property::Weights && matches!(self.nodes[node].transform, Transform::Matrix(_)) {
            return Err(
                target.fault(format!("animates node {node}, which has a matrix; such nodes cannot be animated"))
            );
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

    fn sampler<'b>(&'b self, item: Item<'b>) -> Read<Sampler<'b>> {
        let interpolation = match item.string("interpolation")? {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(other) => return Err(item.fault(format!("`interpolation` {} is unknown", shown(other)))),
        };
        let input = item.required("input", self.source.accessor(&item, "input")?)?;
        let output = item.required("output", self.source.accessor(&item, "output")?)?;
        let good = input.component == Some(Component::F32) && input.is_of("SCALAR");
        input.expect(good, item.location, "input", "SCALAR of floats")?;
        let times = input.floats::<1>(&self.source.budget)?.into_flattened();
        if times[0] < 0.0 {
            return Err(item.fault(format!("its first time is {}, but must be at least 0", times[0])));
        }
        if let Some(i) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let what = format!("time {} is {} after {}, but times must increase", i + 1, times[i + 1], times[i]);
            return Err(item.fault(what));
        }
        if interpolation == Interpolation::Cubic && times.len() < 2 {
            return Err(item.fault("is a cubic spline with one key; it needs two"));
        }
        Ok(Sampler { item, interpolation, times, output, curve: None })
    }

    fn curve(&self, sampler: &Sampler<'_>, property: Property, width: usize) -> Read<Curve> {
        let (output, location) = (sampler.output, sampler.item.location);
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
        let good = component_is_good && output.is_of(shape);
        let small = if may_be_small { " or normalised integers" } else { "" };
        output.expect(good, location, "output", &format!("{shape} of floats{small}"))?;
        let per_key = if sampler.interpolation == Interpolation::Cubic { 3 } else { 1 };
        let wanted = sampler.times.len().saturating_mul(per_key * elements);
        if output.count != wanted {
            let keys = sampler.times.len();
            return Err(location.fault(format!("has {} values for {keys} keys, but needs {wanted}", output.count)));
        }
        let budget = &self.source.budget;
        let mut values = match property {
            Property::Translation | Property::Scale => output.floats::<3>(budget)?.into_flattened(),
            Property::Rotation => output.floats::<4>(budget)?.into_flattened(),
            Property::Weights => output.floats::<1>(budget)?.into_flattened(),
        };
        if let Some(i) = values.iter().position(|v| v.abs() > MAX_COORDINATE) {
            return Err(location.fault(format!("value {} is {}; the limit is {MAX_COORDINATE}", i / width, values[i])));
        }
        if property == Property::Rotation {
            self.unit_rotations(sampler, &mut values, per_key)?;
        }
        budget.take::<f32>(sampler.times.len())?;
        Ok(Curve { interpolation: sampler.interpolation, times: sampler.times.clone(), width, values })
    }

    fn unit_rotations(&self, sampler: &Sampler<'_>, values: &mut [f32], per_key: usize) -> Read<()> {
        let mut uneven = 0;
        let (keys, _) = values.as_chunks_mut::<4>();
        for (number, value) in keys.iter_mut().skip(per_key / 2).step_by(per_key).enumerate() {
            let given = Quat::from_array(*value);
            if (given.length_squared() - 1.0).abs() < NEARLY {
                continue;
            }
            uneven += usize::from((given.length() - 1.0).abs() > ROUNDING);
            let unit = unit_rotation(given);
            *value = unit
                .ok_or_else(|| sampler.item.fault(format!("the rotation of key {number} has zero length")))?
                .to_array();
        }
        if uneven > 0 {
            let location = sampler.item.location;
            self.source.remark(format!("{location}: {uneven} rotations are not of unit length; they were scaled"));
        }
        Ok(())
    }
}
