//! Meshes, with triangles and vertex attributes. Obvious defects are repaired, and other defects are refused.

use super::accessor::{Accessor, Component};
use super::influences;
use super::json::{Item, Read};
use super::repair;
use super::source::Source;
use super::topology::{Mode, per_corner};
use crate::deform::flat_normals;
use crate::limits::{COORDINATES, MAX_COORDINATE, MAX_TARGETS};
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
        let (mesh, weights) = read_mesh(source, &item, materials)?;
        all.use_default_material |= mesh.primitives.iter().any(|p| p.material == materials);
        all.meshes.push(mesh);
        all.weights.push(weights);
    }
    Ok(all)
}

fn read_mesh(source: &Source<'_>, item: &Item<'_>, materials: usize) -> Read<(Mesh, Vec<f32>)> {
    let primitives = item.items("primitives", "primitive")?;
    let Some(first) = primitives.first() else { return Err(item.fault("has no primitives")) };
    let target_count = first.length("targets")?;
    if target_count > MAX_TARGETS {
        return Err(item.fault(format!("has {target_count} morph targets; the limit is {MAX_TARGETS}")));
    }
    // Target names are not part of the specification, but a convention of exporters.
    let names = item.object_or_nothing("extras").and_then(|extras| extras.strings("targetNames").ok());
    let names = names.filter(|names| names.len() == target_count).unwrap_or_default();
    let target_names = names.into_iter().map(str::to_owned).collect();
    let mut mesh = Mesh { name: item.name()?, primitives: Vec::new(), target_count, target_names };
    for primitive in &primitives {
        if primitive.length("targets")? != target_count {
            return Err(primitive.fault("does not have as many morph targets as the mesh's first primitive"));
        }
        mesh.primitives.extend(Reader { source, item: primitive }.read(materials)?);
    }
    let weights = morph_weights(item, target_count)?.unwrap_or_else(|| vec![0.0; target_count]);
    Ok((mesh, weights))
}

/// Reads the `weights` of a mesh or node. There is one weight per morph target.
pub(super) fn morph_weights(item: &Item<'_>, targets: usize) -> Read<Option<Vec<f32>>> {
    let weights = item.numbers("weights", COORDINATES)?;
    match &weights {
        Some(given) if given.len() != targets => {
            Err(item.fault(format!("has {} weights for {targets} morph targets", given.len())))
        }
        _ => Ok(weights),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Types {
    /// Floats, and quantised types if the model declares their extension.
    Float,
    /// Floats, normalised unsigned bytes, normalised unsigned 16-bit numbers, and quantised types.
    Unit,
    /// Floats, normalised signed bytes, normalised signed 16-bit numbers, and quantised types. Differences need a sign.
    Difference,
}

struct Reader<'a> {
    source: &'a Source<'a>,
    item: &'a Item<'a>,
}

impl Reader<'_> {
    /// Reads the primitive. Returns `None` for a primitive without triangles.
    fn read(&self, materials: usize) -> Read<Option<Primitive>> {
        let attributes = self.item.required("attributes", self.item.item("attributes")?)?;
        let code = self.item.whole("mode")?.unwrap_or(4);
        let mode =
            Mode::of_code(code).ok_or_else(|| self.item.fault(format!("`mode` is {code}, but must be 0 to 6")))?;
        let material = self.item.index("material", "material", materials)?.unwrap_or(materials);
        let mut primitive = Primitive { material, ..Primitive::default() };
        let positions = self.attribute::<3>(&attributes, "POSITION", Types::Float, None)?;
        let count = positions.as_ref().map(Vec::len);
        self.check_unread(&attributes)?;
        let Some(positions) = positions else {
            self.remark("has no positions and is not drawn");
            return Ok(None);
        };
        primitive.positions = self.bounded("POSITION", positions)?;
        primitive.triangles = self.triangles(mode, primitive.positions.len())?;
        if matches!(mode, Mode::Points | Mode::Lines) {
            let what = if mode == Mode::Points { "points" } else { "lines" };
            self.remark(&format!("consists of {what}, which are not drawn"));
            return Ok(None);
        }
        let normals = self.attribute::<3>(&attributes, "NORMAL", Types::Float, count)?;
        let tangents = self.attribute::<4>(&attributes, "TANGENT", Types::Float, count)?;
        primitive.texcoords = self.texcoords(&attributes, count)?;
        primitive.colors = self.colors(&attributes, count)?;
        primitive.influences = self.influences(&attributes, count)?;
        primitive.targets = self.targets(count, normals.is_some(), tangents.is_some())?;
        match normals {
            Some(normals) => {
                primitive.normals = normals;
                primitive.tangents = tangents;
                for what in repair::directions(&mut primitive) {
                    self.remark(&what);
                }
            }
            None => self.flatten(&mut primitive)?,
        }
        Ok(Some(primitive))
    }

    fn remark(&self, what: &str) {
        self.source.remark(format!("{}: {what}", self.item.location));
    }

    fn attribute<const N: usize>(
        &self,
        attributes: &Item<'_>,
        name: &str,
        types: Types,
        count: Option<usize>,
    ) -> Read<Option<Vec<[f32; N]>>> {
        let Some(accessor) = self.source.accessor(attributes, name)? else { return Ok(None) };
        self.check_type(accessor, attributes, name, types, N)?;
        self.check_count(accessor, attributes, name, count)?;
        accessor.floats::<N>(&self.source.budget).map(Some)
    }

    fn check_type(&self, accessor: &Accessor<'_>, item: &Item<'_>, name: &str, types: Types, n: usize) -> Read<()> {
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][n - 1];
        let normalized = |of: Types| types == of && accessor.normalized;
        let type_is_good = match accessor.component {
            Some(Component::F32) => true,
            Some(Component::U8 | Component::U16) => normalized(Types::Unit) || self.source.quantized,
            Some(Component::I8 | Component::I16) => normalized(Types::Difference) || self.source.quantized,
            Some(Component::U32) | None => false,
        };
        let wanted = if types == Types::Unit { "floats or normalised bytes or 16-bit numbers" } else { "floats" };
        let good = type_is_good && accessor.is_of(shape);
        accessor.expect(good, item.location, name, &format!("{shape} of {wanted}"))
    }

    fn check_count(&self, accessor: &Accessor<'_>, item: &Item<'_>, name: &str, count: Option<usize>) -> Read<()> {
        match count {
            Some(count) if count != accessor.count => {
                Err(item.fault(format!("`{name}` has {} elements, but `POSITION` has {count}", accessor.count)))
            }
            _ => Ok(()),
        }
    }

    /// Checks that unused attributes refer to valid accessors.
    fn check_unread(&self, attributes: &Item<'_>) -> Read<()> {
        for key in attributes.keys() {
            attributes.index(key, "accessor", self.source.accessors.len())?;
        }
        Ok(())
    }

    fn bounded<const N: usize>(&self, name: &str, values: Vec<[f32; N]>) -> Read<Vec<[f32; N]>> {
        match values.as_flattened().iter().position(|v| !COORDINATES.contains(v)) {
            None => Ok(values),
            Some(i) => {
                let value = values.as_flattened()[i];
                Err(self.item.fault(format!("`{name}` of vertex {} is {value}, beyond {MAX_COORDINATE}", i / N)))
            }
        }
    }

    fn triangles(&self, mode: Mode, vertices: usize) -> Read<Vec<[u32; 3]>> {
        let indices = match self.source.accessor(self.item, "indices")? {
            None => None,
            Some(accessor) => {
                let good = accessor.is_of("SCALAR") && !accessor.normalized;
                let read = if good { accessor.whole_numbers::<1>(&self.source.budget)? } else { None };
                accessor.expect(read.is_some(), self.item.location, "indices", "SCALAR of unsigned numbers")?;
                read
            }
        };
        if let Some(indices) = &indices
            && let Some(i) = indices.iter().position(|&[v]| v as usize >= vertices)
        {
            let what = format!("index {i} refers to vertex {}, but there are only {vertices}", indices[i][0]);
            return Err(self.item.fault(what));
        }
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
        while let Some(set) =
            self.attribute::<2>(attributes, &format!("TEXCOORD_{}", sets.len()), Types::Unit, count)?
        {
            sets.push(self.bounded(&format!("TEXCOORD_{}", sets.len()), set)?);
        }
        Ok(sets)
    }

    fn colors(&self, attributes: &Item<'_>, count: Option<usize>) -> Read<Option<Vec<[f32; 4]>>> {
        const NAME: &str = "COLOR_0";
        let opaque = self.source.accessor(attributes, NAME)?.is_some_and(|a| a.is_of("VEC3"));
        let mut colors = if opaque {
            let colors = self.attribute::<3>(attributes, NAME, Types::Unit, count)?;
            colors.map(|all| all.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
        } else {
            self.attribute::<4>(attributes, NAME, Types::Unit, count)?
        };
        if let Some(all) = &mut colors
            && repair::clamp(all)
        {
            self.remark("has colours outside 0 to 1, which were clamped");
        }
        Ok(colors)
    }

    fn influences(&self, attributes: &Item<'_>, count: Option<usize>) -> Read<Option<Vec<Influences>>> {
        let mut sets = Vec::new();
        loop {
            let (joints, weights) = (format!("JOINTS_{}", sets.len()), format!("WEIGHTS_{}", sets.len()));
            if attributes.has(&joints) != attributes.has(&weights) {
                return Err(attributes.fault(format!("`{joints}` and `{weights}` must be given together")));
            }
            let Some(accessor) = self.source.accessor(attributes, &joints)? else { break };
            self.check_count(accessor, attributes, &joints, count)?;
            let component_is_good = matches!(accessor.component, Some(Component::U8 | Component::U16));
            let good = component_is_good && accessor.is_of("VEC4") && !accessor.normalized;
            accessor.expect(good, attributes.location, &joints, "VEC4 of unsigned bytes or 16-bit numbers")?;
            let joints = accessor.whole_numbers::<4>(&self.source.budget)?.unwrap_or_default();
            let weights = self.attribute::<4>(attributes, &weights, Types::Unit, count)?.unwrap_or_default();
            sets.push((joints, weights));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        let (influences, remarks) = influences::strongest(&sets).map_err(|what| self.item.fault(what))?;
        remarks.iter().for_each(|what| self.remark(what));
        Ok(Some(influences))
    }

    fn targets(&self, count: Option<usize>, normals: bool, tangents: bool) -> Read<Vec<MorphTarget>> {
        let read = |item: Item<'_>| {
            let list = |name: &str, base: bool| -> Read<Vec<[f32; 3]>> {
                let differences = self.attribute::<3>(&item, name, Types::Difference, count)?.unwrap_or_default();
                if !differences.is_empty() && !base {
                    self.source.remark(format!(
                        "{}: `{name}` is ignored, because the primitive itself has none",
                        item.location
                    ));
                    return Ok(Vec::new());
                }
                self.bounded(name, differences)
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
        primitive.influences = primitive.influences.take().map(|all| per_corner(&all, &triangles));
        for target in primitive.targets.iter_mut().filter(|target| !target.positions.is_empty()) {
            target.positions = per_corner(&target.positions, &triangles);
        }
        primitive.triangles = (0..corners as u32).step_by(3).map(|i| [i, i + 1, i + 2]).collect();
        primitive.normals = flat_normals(&primitive.positions, &primitive.triangles);
        Ok(())
    }
}
