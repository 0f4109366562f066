//! Meshes, with triangles and vertex attributes. An attribute, a triangle or a primitive that cannot be read is left out.

use super::accessor::{Accessor, Component};
use super::draco::Draco;
use super::extensions::VARIANTS;
use super::influences;
use super::json::{Item, Read};
use super::log::Log;
use super::repair::{self, Finding};
use super::source::Source;
use super::topology::{Mode, per_corner};
use crate::deform::flat_normals;
use crate::limits::{COORDINATES, MAX_COORDINATE, MAX_HEIGHT_SCALE, MAX_TARGETS};
use crate::mesh::{Influences, Mesh, MorphTarget, Primitive};

/// The meshes of a model, and the default weights of their morph targets.
pub(super) struct Meshes {
    pub(super) meshes: Vec<Mesh>,
    pub(super) weights: Vec<Vec<f32>>,
    /// Whether a primitive needs the default material, which comes after the file's own materials.
    pub(super) use_default_material: bool,
}

pub(super) fn read(source: &Source<'_>) -> Read<Meshes> {
    let mut all = Meshes { meshes: Vec::new(), weights: Vec::new(), use_default_material: false };
    let materials = source.root.length("materials")?;
    for item in source.root.items("meshes", "mesh")? {
        let (mesh, weights) = match read_mesh(source, &item, materials) {
            Ok(mesh) => mesh,
            Err(fault) => {
                source.log.lose(fault, "the mesh is left out")?;
                Default::default()
            }
        };
        all.use_default_material |= mesh.primitives.iter().any(|p| p.material == materials);
        all.meshes.push(mesh);
        all.weights.push(weights);
    }
    Ok(all)
}

fn read_mesh(source: &Source<'_>, item: &Item<'_>, materials: usize) -> Read<(Mesh, Vec<f32>)> {
    let primitives = item.items("primitives", "primitive")?;
    if primitives.is_empty() {
        return Err(item.fault("has no primitives"));
    }
    let counts = primitives.iter().map(|primitive| primitive.length("targets")).collect::<Read<Vec<_>>>()?;
    let target_count = counts.iter().copied().max().unwrap_or(0);
    if target_count > MAX_TARGETS {
        return Err(item.fault(format!("has {target_count} morph targets; the limit is {MAX_TARGETS}")));
    }
    if counts.iter().any(|&count| count != target_count) {
        let fault = item.fault("has primitives with different numbers of morph targets");
        source.log.repair(fault, "the missing targets move nothing")?;
    }
    // Target names are not part of the specification, but a convention of exporters.
    let names = item.object_or_nothing("extras").and_then(|extras| extras.strings("targetNames").ok());
    let names = names.filter(|names| names.len() == target_count).unwrap_or_default();
    let target_names = names.into_iter().map(str::to_owned).collect();
    let mut mesh = Mesh { name: item.name()?, primitives: Vec::new(), target_count, target_names };
    for primitive in &primitives {
        let draco = Draco::read(source, primitive);
        match draco.and_then(|draco| Reader { source, item: primitive, draco }.read(materials)) {
            Ok(read) => mesh.primitives.extend(read),
            Err(fault) => source.log.lose(fault, "the primitive is left out")?,
        }
    }
    let weights = morph_weights(item, target_count, source.log)?.unwrap_or_else(|| vec![0.0; target_count]);
    Ok((mesh, weights))
}

/// Returns the material of a primitive, of `count` materials, in the selected variant.
pub(super) fn material(source: &Source<'_>, primitive: &Item<'_>, count: usize) -> Read<Option<usize>> {
    if let (Some(variant), Some(extension)) = (source.variant, primitive.extension(VARIANTS)?) {
        for mapping in extension.items("mappings", "mapping")? {
            if mapping.indices("variants", "variant", usize::MAX)?.contains(&variant) {
                return mapping.index("material", "material", count);
            }
        }
    }
    primitive.index("material", "material", count)
}

/// Reads the `weights` of a mesh or node. There is one weight per morph target.
pub(super) fn morph_weights(item: &Item<'_>, targets: usize, log: &Log) -> Read<Option<Vec<f32>>> {
    let Some(mut weights) = item.numbers("weights", COORDINATES)? else { return Ok(None) };
    if weights.len() != targets {
        let fault = item.fault(format!("has {} weights for {targets} morph targets", weights.len()));
        log.repair(fault, "the missing weights are 0")?;
        weights.resize(targets, 0.0);
    }
    Ok(Some(weights))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Types {
    /// Floats, and quantised types if the model declares their extension.
    Float,
    /// Floats, normalised unsigned bytes, normalised unsigned 16-bit numbers, and quantised types.
    Unit,
    /// Like `Unit`, but integers are always normalised.
    Share,
    /// Floats, normalised signed bytes, normalised signed 16-bit numbers, and quantised types. Differences need a sign.
    Difference,
}

struct Reader<'a> {
    source: &'a Source<'a>,
    item: &'a Item<'a>,
    draco: Option<Draco<'a>>,
}

/// The repair of an attribute that cannot be read.
const IGNORED: &str = "the attribute is ignored";

impl Reader<'_> {
    /// Reads the primitive. Returns `None` for a primitive without triangles.
    fn read(&self, materials: usize) -> Read<Option<Primitive>> {
        let attributes = self.item.required("attributes", Item::item)?;
        let code = self.item.whole("mode")?.unwrap_or(4);
        let mode =
            Mode::of_code(code).ok_or_else(|| self.item.fault(format!("`mode` is {code}, but must be 0 to 6")))?;
        if matches!(mode, Mode::Points | Mode::Lines) {
            let what = if mode == Mode::Points { "points" } else { "lines" };
            self.remark(&format!("consists of {what}, which are not drawn"));
            return Ok(None);
        }
        let material = material(self.source, self.item, materials)?.unwrap_or(materials);
        let mut primitive = Primitive { material, ..Primitive::default() };
        let positions = self.attribute::<3>(&attributes, "POSITION", Types::Float, None)?;
        if self.log().strict {
            // Attributes that are not read must refer to accessors too.
            for key in attributes.keys() {
                self.source.accessor(&attributes, key)?;
            }
        }
        let Some(positions) = positions else {
            self.remark("has no positions and is not drawn");
            return Ok(None);
        };
        let count = Some(positions.len());
        primitive.positions = positions;
        primitive.triangles = self.triangles(mode, primitive.positions.len())?;
        self.drop_unplaced(&mut primitive)?;
        let normals = self.optional(self.attribute::<3>(&attributes, "NORMAL", Types::Float, count))?;
        let tangents = self.optional(self.attribute::<4>(&attributes, "TANGENT", Types::Float, count))?;
        primitive.texcoords = self.texcoords(&attributes, count)?;
        primitive.colors = self.optional(self.colors(&attributes, count))?;
        primitive.height_scales = self.optional(self.height_scales(&attributes, count))?;
        primitive.influences = self.optional(self.influences(&attributes, count))?;
        primitive.targets = self.targets(count, normals.is_some(), tangents.is_some())?;
        match normals {
            Some(normals) => {
                primitive.normals = normals;
                primitive.tangents = tangents;
                self.report(repair::directions(&mut primitive))?;
            }
            None => self.flatten(&mut primitive)?,
        }
        Ok(Some(primitive))
    }

    fn log(&self) -> &Log {
        self.source.log
    }

    fn remark(&self, what: &str) {
        self.log().remark(format!("{}: {what}", self.item.location));
    }

    fn report(&self, findings: Vec<Finding>) -> Read<()> {
        findings.into_iter().try_for_each(|Finding { what, repair }| match repair {
            Some(repair) => self.log().repair(self.item.fault(what), repair),
            None => {
                self.remark(&what);
                Ok(())
            }
        })
    }

    /// Ignores an attribute that cannot be read.
    fn optional<T>(&self, attribute: Read<Option<T>>) -> Read<Option<T>> {
        attribute.or_else(|fault| self.log().repair(fault, IGNORED).map(|()| None))
    }

    /// Reads an attribute. Values that are not finite are refused in strict mode only.
    fn attribute<const N: usize>(
        &self,
        attributes: &Item<'_>,
        name: &str,
        types: Types,
        count: Option<usize>,
    ) -> Read<Option<Vec<[f32; N]>>> {
        let Some(accessor) = self.source.accessor(attributes, name)? else { return Ok(None) };
        if let Some(draco) = self.draco.as_ref().filter(|_| types != Types::Difference)
            && let Some(values) = draco.floats::<N>(name, accessor.normalized || types == Types::Share)?
        {
            return if values.len() < count.unwrap_or(0) {
                Err(attributes.fault(format!("`{name}` has fewer compressed values than `POSITION`")))
            } else {
                Ok(Some(values))
            };
        }
        if name == "POSITION" && accessor.is_zeros() && !self.source.unread.is_empty() {
            let unread = self.source.unread.join(", ");
            return Err(accessor.fault(format!("has no data without {unread}, which is not supported")));
        }
        let normalized = self.check_type(accessor, attributes, name, types, N)?;
        self.check_count(accessor, attributes, name, count)?;
        let mut values = accessor.floats::<N>(normalized, &self.source.budget)?;
        values.truncate(count.unwrap_or(usize::MAX));
        if let Some(fault) = accessor.not_finite(&values) {
            self.log().refuse(fault)?;
        }
        Ok(Some(values))
    }

    /// Checks the type of an attribute of `n` numbers. Returns whether integers are normalised.
    fn check_type(&self, accessor: &Accessor<'_>, item: &Item<'_>, name: &str, types: Types, n: usize) -> Read<bool> {
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][n - 1];
        let normalized = |of: bool| of && accessor.normalized;
        let (unit, difference) = (matches!(types, Types::Unit | Types::Share), types == Types::Difference);
        let quantized = self.source.quantized && types != Types::Share;
        let type_is_good = match accessor.component {
            Some(Component::F32) => true,
            Some(Component::U8 | Component::U16) => normalized(unit) || quantized,
            Some(Component::I8 | Component::I16) => normalized(difference) || quantized,
            Some(Component::U32) | None => false,
        };
        let wanted = if unit { "floats or normalised bytes or 16-bit numbers" } else { "floats" };
        let wanted = format!("{shape} of {wanted}");
        let expected = accessor.expect(type_is_good && accessor.is_of(shape), item.location, name, &wanted);
        // Only the sign of a tangent, which is its last number, has a plain value if it is missing.
        let least = if name == "TANGENT" { 3 } else { n };
        let has_reading = !matches!(accessor.component, Some(Component::U32) | None)
            && (least..=4).contains(&accessor.numbers())
            && !accessor.shape.is_some_and(|shape| shape.name.starts_with("MAT"));
        match expected {
            Err(fault) if has_reading => {
                let repair = if type_is_good {
                    "its first numbers are read"
                } else if accessor.normalized || types == Types::Share {
                    "it is read as normalised numbers"
                } else {
                    "its numbers are read as they are"
                };
                self.log().repair(fault, repair)?;
            }
            other => other?,
        }
        Ok(accessor.normalized || types == Types::Share)
    }

    fn check_count(&self, accessor: &Accessor<'_>, item: &Item<'_>, name: &str, count: Option<usize>) -> Read<()> {
        match count {
            Some(count) if count != accessor.count => {
                let what = format!("`{name}` has {} elements, but `POSITION` has {count}", accessor.count);
                if accessor.count < count {
                    return Err(item.fault(what));
                }
                self.log().repair(item.fault(what), "the further elements are ignored")
            }
            _ => Ok(()),
        }
    }

    /// Replaces values that are not finite or too large by 0.
    fn bounded<const N: usize>(&self, name: &str, values: &mut [[f32; N]]) -> Read<()> {
        let bad = |values: &[f32; N]| !values.iter().all(|value| COORDINATES.contains(value));
        if let Some(vertex) = values.iter().position(bad) {
            let value = values[vertex].into_iter().find(|value| !COORDINATES.contains(value)).unwrap_or_default();
            let what = format!("`{name}` of vertex {vertex} is {value}, but must be within ±{MAX_COORDINATE:e}");
            self.log().repair(self.item.fault(what), "such values are read as 0")?;
            values.iter_mut().filter(|values| bad(values)).for_each(|values| *values = [0.0; N]);
        }
        Ok(())
    }

    /// Removes triangles with a corner that has no position or that does not exist.
    fn drop_unplaced(&self, primitive: &mut Primitive) -> Read<()> {
        let vertices = primitive.positions.len();
        let all = primitive.triangles.len();
        let missing = primitive.triangles.as_flattened().iter().find(|&&v| v as usize >= vertices).copied();
        if let Some(vertex) = missing {
            primitive.triangles.retain(|triangle| triangle.iter().all(|&v| (v as usize) < vertices));
            let left_out = all - primitive.triangles.len();
            let what = format!(
                "{left_out} of {all} triangles refer to vertices such as {vertex}, but there are only {vertices}"
            );
            self.log().lose(self.item.fault(what), "these triangles are left out")?;
        }
        let placed = |position: &[f32; 3]| position.iter().all(|value| COORDINATES.contains(value));
        if let Some(vertex) = primitive.positions.iter().position(|position| !placed(position)) {
            let value = primitive.positions[vertex].into_iter().find(|value| !COORDINATES.contains(value));
            let value = value.unwrap_or_default();
            let what = format!("`POSITION` of vertex {vertex} is {value}, but must be within ±{MAX_COORDINATE:e}");
            self.log().lose(self.item.fault(what), "the triangles around such vertices are left out")?;
            let positions = &primitive.positions;
            primitive.triangles.retain(|triangle| triangle.iter().all(|&v| placed(&positions[v as usize])));
            let first = positions.iter().find(|position| placed(position)).copied().unwrap_or_default();
            primitive.positions.iter_mut().filter(|position| !placed(position)).for_each(|p| *p = first);
        }
        Ok(())
    }

    /// Returns the triangles, whose vertices may not exist.
    fn triangles(&self, mode: Mode, vertices: usize) -> Read<Vec<[u32; 3]>> {
        if let Some(draco) = &self.draco {
            return Ok(draco.triangles());
        }
        let indices = match self.source.accessor(self.item, "indices")? {
            None => None,
            Some(accessor) => {
                let good = accessor.is_of("SCALAR") && !accessor.normalized;
                let read = if good { accessor.whole_numbers::<1>(&self.source.budget)? } else { None };
                accessor.expect(read.is_some(), self.item.location, "indices", "SCALAR of unsigned numbers")?;
                read
            }
        };
        let count = indices.as_ref().map_or(vertices, Vec::len);
        let (triangles, left) = mode.triangles(count);
        if left > 0 {
            let rest = if left == 1 { "index was".into() } else { format!("{left} indices were") };
            self.remark(&format!("the last {rest} ignored, because a triangle needs three"));
        }
        self.source.budget.take::<[u32; 3]>(triangles)?;
        Ok(match indices {
            Some(indices) => mode.wind(count, |i| indices[i][0]),
            None => mode.wind(count, |i| i as u32),
        })
    }

    fn texcoords(&self, attributes: &Item<'_>, count: Option<usize>) -> Read<Vec<Vec<[f32; 2]>>> {
        let mut sets = Vec::new();
        loop {
            let name = format!("TEXCOORD_{}", sets.len());
            if !attributes.has(&name) {
                return Ok(sets);
            }
            match self.optional(self.attribute::<2>(attributes, &name, Types::Unit, count))? {
                Some(mut set) => {
                    self.bounded(&name, &mut set)?;
                    sets.push(set);
                }
                // Further sets keep their numbers.
                None => {
                    let count = count.unwrap_or(0);
                    self.source.budget.take::<[f32; 2]>(count)?;
                    sets.push(vec![[0.0; 2]; count]);
                }
            }
        }
    }

    fn colors(&self, attributes: &Item<'_>, count: Option<usize>) -> Read<Option<Vec<[f32; 4]>>> {
        const NAME: &str = "COLOR_0";
        let opaque = self.source.accessor(attributes, NAME)?.is_some_and(|a| a.is_of("VEC3"));
        let mut colors = if opaque {
            let colors = self.attribute::<3>(attributes, NAME, Types::Share, count)?;
            colors.map(|all| all.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
        } else {
            self.attribute::<4>(attributes, NAME, Types::Share, count)?
        };
        if let Some(all) = &mut colors
            && repair::clamp(all)
        {
            self.log().repair(self.item.fault("has colours outside 0 to 1"), "they are clamped")?;
        }
        Ok(colors)
    }

    fn height_scales(&self, attributes: &Item<'_>, count: Option<usize>) -> Read<Option<Vec<f32>>> {
        const NAME: &str = "_HEIGHT_SCALE";
        let Some(values) = self.attribute::<1>(attributes, NAME, Types::Unit, count)? else { return Ok(None) };
        let mut scales: Vec<f32> = values.into_iter().flatten().collect();
        let bad = |scale: &f32| !(0.0..=MAX_HEIGHT_SCALE).contains(scale);
        if let Some(vertex) = scales.iter().position(bad) {
            let what =
                format!("`{NAME}` of vertex {vertex} is {}, but must be from 0 to {MAX_HEIGHT_SCALE}", scales[vertex]);
            self.log().repair(self.item.fault(what), "such values are read as 1")?;
            scales.iter_mut().filter(|scale| bad(scale)).for_each(|scale| *scale = 1.0);
        }
        Ok(Some(scales))
    }

    fn influences(&self, attributes: &Item<'_>, count: Option<usize>) -> Read<Option<Vec<Influences>>> {
        let mut sets = Vec::new();
        loop {
            let (joints, weights) = (format!("JOINTS_{}", sets.len()), format!("WEIGHTS_{}", sets.len()));
            if attributes.has(&joints) != attributes.has(&weights) {
                return Err(attributes.fault(format!("`{joints}` and `{weights}` must be given together")));
            }
            let Some(accessor) = self.source.accessor(attributes, &joints)? else { break };
            let compressed = match &self.draco {
                Some(draco) => draco.floats::<4>(&joints, false)?,
                None => None,
            };
            self.check_count(accessor, attributes, &joints, count)?;
            let is_whole = |component| matches!(component, Some(Component::U8 | Component::U16));
            let good = is_whole(accessor.component) && accessor.is_of("VEC4") && !accessor.normalized;
            let wanted = "VEC4 of unsigned bytes or 16-bit numbers";
            let expected = accessor.expect(good, attributes.location, &joints, wanted);
            match (expected, accessor.component) {
                // Other exporters write floats, 32-bit numbers or the normalised flag.
                (Err(fault), Some(_)) if accessor.is_of("VEC4") => {
                    self.log().repair(fault, "it is read as whole numbers")?;
                }
                (expected, _) => expected?,
            }
            let mut joints = match compressed {
                Some(joints) => joints,
                None => accessor.floats::<4>(false, &self.source.budget)?,
            };
            joints.truncate(count.unwrap_or(usize::MAX));
            // The conversion maps NaN and negative numbers to 0.
            let joints = joints.into_iter().map(|four| four.map(|joint| joint as u32)).collect();
            let weights = self.attribute::<4>(attributes, &weights, Types::Share, count)?.unwrap_or_default();
            sets.push((joints, weights));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let (influences, findings) = influences::strongest(&sets);
        self.report(findings)?;
        Ok(Some(influences))
    }

    fn targets(&self, count: Option<usize>, normals: bool, tangents: bool) -> Read<Vec<MorphTarget>> {
        let read = |item: Item<'_>| {
            let list = |name: &str, base: bool| -> Read<Vec<[f32; 3]>> {
                let differences = self.optional(self.attribute::<3>(&item, name, Types::Difference, count))?;
                let mut differences = differences.unwrap_or_default();
                if !differences.is_empty() && !base {
                    let fault = item.fault(format!("has `{name}`, but the primitive itself has none"));
                    self.log().repair(fault, IGNORED)?;
                    return Ok(Vec::new());
                }
                self.bounded(name, &mut differences)?;
                Ok(differences)
            };
            Ok(MorphTarget {
                positions: list("POSITION", true)?,
                normals: list("NORMAL", normals)?,
                tangents: list("TANGENT", tangents && normals)?,
            })
        };
        self.item.items("targets", "target")?.into_iter().map(read).collect()
    }

    /// Gives every triangle its own vertices, with the normal of the triangle's plane.
    fn flatten(&self, primitive: &mut Primitive) -> Read<()> {
        let triangles = std::mem::take(&mut primitive.triangles);
        let corners = 3 * triangles.len();
        // The budget allows for the largest possible vertex, and for each morph target.
        self.source.budget.take::<[f32; 32]>(corners)?;
        self.source.budget.take::<[f32; 3]>(corners.saturating_mul(primitive.targets.len()))?;
        if u32::try_from(corners).is_err() {
            return Err(self.item.fault(format!("{} triangles without normals are too many", triangles.len())));
        }
        primitive.flat = true;
        primitive.positions = per_corner(&primitive.positions, &triangles);
        for set in &mut primitive.texcoords {
            *set = per_corner(set, &triangles);
        }
        primitive.colors = primitive.colors.take().map(|colors| per_corner(&colors, &triangles));
        primitive.height_scales = primitive.height_scales.take().map(|all| per_corner(&all, &triangles));
        primitive.influences = primitive.influences.take().map(|all| per_corner(&all, &triangles));
        for target in primitive.targets.iter_mut().filter(|target| !target.positions.is_empty()) {
            target.positions = per_corner(&target.positions, &triangles);
        }
        primitive.triangles = (0..corners as u32).step_by(3).map(|i| [i, i + 1, i + 2]).collect();
        primitive.normals = flat_normals(&primitive.positions, &primitive.triangles);
        Ok(())
    }
}
