//! Maps the textures of a material to a mesh. Each type of image has a chart, and covers the unit square of this chart.
//!
//! Textures that are filtered together (colours, metalness, roughness) share a chart. If all textures agree on coordinates, transform and
//! wrap mode, the chart is their own layout. If not, the textures are resampled into a common chart.

use glam::{Affine2, Mat2, Vec2};

use leadr_maps::material::{ClearCoat, Material, Opacity, Texture, TextureWrap};
use leadr_render::constants::{CHART_COLORS, CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY, CHARTS};

/// The texture coordinates of one type of image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// The index of the mesh's texture coordinate set.
    pub coordinates: usize,
    /// The transform from the coordinate set to the chart.
    pub transform: Affine2,
    /// The wrap modes outside the unit square.
    pub wrap: [TextureWrap; 2],
    /// Whether all textures of the chart share its exact layout.
    exact: bool,
}

/// Returns the lower and upper corner of a texture coordinate set's bounding box.
pub type Bounds<'a> = &'a dyn Fn(usize) -> (Vec2, Vec2);

impl Chart {
    /// The chart of a material without textures.
    const NONE: Self =
        Self { coordinates: 0, transform: Affine2::IDENTITY, wrap: [TextureWrap::Repeat; 2], exact: true };

    /// Returns the chart of textures that are filtered together, and whether all of them use one coordinate set. Returns `None` without
    /// textures.
    fn of(textures: &[&Texture], bounds: Bounds<'_>) -> Option<(Self, bool)> {
        let first = textures.first()?;
        let coordinates = first.coordinates as usize;
        let layout = |t: &Texture| (t.coordinates, t.transform, t.wrap);
        if textures.iter().all(|texture| layout(texture) == layout(first)) {
            return Some((Self { coordinates, transform: first.transform, wrap: first.wrap, exact: true }, true));
        }
        let one_set = textures.iter().all(|texture| texture.coordinates == first.coordinates);
        let whole = |m: Mat2| m.to_cols_array().iter().all(|v| (v - v.round()).abs() < 1e-5);
        let periodic = |t: &&Texture| t.wrap == [TextureWrap::Repeat; 2] && whole(t.transform.matrix2);
        if textures.iter().all(periodic) {
            return Some((Self { coordinates, exact: false, ..Self::NONE }, one_set));
        }
        let (low, high) = bounds(coordinates);
        let scale = (high - low).max(Vec2::splat(1e-6)).recip();
        let transform = Affine2::from_scale(scale) * Affine2::from_translation(-low);
        Some((Self { coordinates, transform, wrap: [TextureWrap::Clamp; 2], exact: false }, one_set))
    }

    /// Makes the transform of a texture relative to this chart.
    fn seen(&self, texture: &mut Texture) {
        texture.transform = if self.exact { Affine2::IDENTITY } else { texture.transform * self.transform.inverse() };
    }

    /// Returns the coordinates of a triangle corner in the chart.
    pub fn texcoord(&self, sets: &dyn Fn(usize) -> Vec2) -> Vec2 {
        self.transform.transform_point2(sets(self.coordinates))
    }
}

/// Returns the transform from texture coordinates to an atlas of UDIM tiles. In models, `t` points down, and tile 1001 is the unit square.
pub fn onto_tiles([columns, rows]: [u32; 2]) -> Affine2 {
    let grid = Vec2::new(columns as f32, rows as f32);
    Affine2::from_scale(grid.recip()) * Affine2::from_translation(Vec2::Y * (grid.y - 1.0))
}

/// The charts of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charts {
    /// The chart of the slopes and heights.
    pub slopes: Chart,
    /// The charts of the images, in the order of the `CHART_` constants.
    pub images: [Chart; CHARTS as usize],
    /// Whether any texture uses a different coordinate set than the file requests.
    pub compromise: bool,
}

impl Charts {
    /// Returns the charts for a material on a mesh with these bounds of texture coordinates, and the material rewritten for these charts.
    pub fn of(material: &Material, bounds: Bounds<'_>) -> (Self, Material) {
        let mut material = material.clone();
        let m = &material;
        let colors = [&m.base_color, &m.f0].into_iter().filter_map(|input| input.texture.as_ref());
        let numbers = [&m.metalness, &m.roughness, &m.specular].into_iter().filter_map(|input| input.texture.as_ref());
        let coat = m.coat.iter().flat_map(ClearCoat::textures);
        let colors: Vec<&Texture> = colors.chain(numbers).chain(coat).collect();
        let opacity = match &m.opacity {
            Opacity::Opaque => None,
            Opacity::Mask { mask: input, .. } | Opacity::Blend { share: input } => input.texture.as_ref(),
        };
        let one = |texture: Option<&Texture>| Chart::of(texture.as_slice(), bounds);
        let normal = m.normal_map.as_ref().map(|map| &map.texture);
        // Heights use the first coordinate set, and the slopes of a normal map share their chart.
        let transform = onto_tiles(m.relief_tiles);
        let relief = m.relief.as_ref().map(|_| (Chart { exact: normal.is_none(), transform, ..Chart::NONE }, true));
        let slopes = relief.or_else(|| one(normal));
        let [color, emission, occlusion, opacity] = [
            Chart::of(&colors, bounds),
            // Unlit materials emit their base colour.
            one(if m.unlit { m.base_color.texture.as_ref() } else { m.emission.texture.as_ref() }),
            one(m.cones.as_ref().or(m.occlusion.texture.as_ref())),
            one(opacity),
        ];
        let compromise = [slopes, color].into_iter().flatten().any(|(_, just)| !just);
        // A property without textures is constant, so any chart can be used.
        let any = slopes.or(color).or(emission).or(occlusion).or(opacity).map_or(Chart::NONE, |(chart, _)| chart);
        let chart = |found: Option<(Chart, bool)>| found.map_or(any, |(chart, _)| chart);
        let mut images = [any; CHARTS as usize];
        images[CHART_COLORS as usize] = chart(color);
        images[CHART_EMISSION as usize] = chart(emission);
        images[CHART_OCCLUSION as usize] = chart(occlusion);
        images[CHART_OPACITY as usize] = chart(opacity);
        let charts = Self { slopes: chart(slopes), images, compromise };
        charts.lay_out(&mut material);
        (charts, material)
    }

    /// Makes the transforms of the textures relative to the charts.
    fn lay_out(&self, material: &mut Material) {
        let [colors, emission, occlusion, opacity] =
            [CHART_COLORS, CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY].map(|chart| self.images[chart as usize]);
        material.normal_map.iter_mut().for_each(|map| self.slopes.seen(&mut map.texture));
        let glowing = if material.unlit { &mut material.base_color } else { &mut material.emission };
        glowing.texture.iter_mut().for_each(|texture| emission.seen(texture));
        let [base, f0] = [&mut material.base_color, &mut material.f0].map(|input| input.texture.as_mut());
        let base = base.filter(|_| !material.unlit);
        let numbers = [&mut material.metalness, &mut material.roughness, &mut material.specular];
        let numbers = numbers.into_iter().filter_map(|input| input.texture.as_mut());
        let coat = material.coat.iter_mut().flat_map(ClearCoat::textures_mut);
        base.into_iter().chain(f0).chain(numbers).chain(coat).for_each(|texture| colors.seen(texture));
        material.occlusion.texture.iter_mut().chain(&mut material.cones).for_each(|texture| occlusion.seen(texture));
        if let Opacity::Mask { mask: input, .. } | Opacity::Blend { share: input } = &mut material.opacity {
            input.texture.iter_mut().for_each(|texture| opacity.seen(texture));
        }
    }

    /// Whether all images use the chart of the slopes.
    pub fn are_one(&self) -> bool {
        let mapping = |chart: &Chart| (chart.coordinates, chart.transform);
        self.images.iter().all(|chart| mapping(chart) == mapping(&self.slopes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::material::{Encoding, Input, NormalMap, Raster, Samples};

    fn texture(coordinates: u32, scale: f32, wrap: TextureWrap) -> Texture {
        let raster = Raster::new(4, 4, 1, Samples::U8(vec![128; 16])).unwrap();
        let transform = Affine2::from_scale(Vec2::splat(scale));
        Texture { coordinates, transform, wrap: [wrap; 2], ..Texture::new(raster, "t", Encoding::Linear) }
    }

    #[test]
    fn textures_that_agree_keep_their_own_layout() {
        let mut material = Material::new("m");
        material.base_color = Input::colors(texture(1, 1.5, TextureWrap::Clamp));
        let (charts, laid) = Charts::of(&material, &|_| panic!("not asked for"));
        let chart = charts.images[CHART_COLORS as usize];
        assert_eq!((chart.coordinates, chart.wrap), (1, [TextureWrap::Clamp; 2]));
        assert_eq!(chart.texcoord(&|set| Vec2::splat(set as f32)), Vec2::splat(1.5));
        assert_eq!(laid.base_color.texture.unwrap().transform, Affine2::IDENTITY);
        assert!(charts.are_one() && !charts.compromise);
    }

    #[test]
    fn images_have_charts_of_their_own() {
        let mut material = Material::new("m");
        material.base_color = Input::colors(texture(0, 2.0, TextureWrap::Repeat));
        material.occlusion = Input::texture(texture(1, 1.0, TextureWrap::Repeat), 0);
        let (charts, _) = Charts::of(&material, &|_| panic!("not asked for"));
        assert!(!charts.are_one() && !charts.compromise);
        let at = |chart: u32| charts.images[chart as usize].texcoord(&|set| Vec2::new(0.25, set as f32));
        assert_eq!((at(CHART_COLORS), at(CHART_OCCLUSION)), (Vec2::new(0.5, 0.0), Vec2::new(0.25, 1.0)));
    }

    #[test]
    fn disagreeing_textures_are_resampled() {
        let mut material = Material::new("m");
        material.base_color = Input::colors(texture(0, 1.0, TextureWrap::Clamp));
        material.roughness = Input::texture(texture(0, 3.0, TextureWrap::Repeat), 1);
        let (charts, laid) = Charts::of(&material, &|_| (Vec2::splat(-1.0), Vec2::splat(1.0)));
        let chart = charts.images[CHART_COLORS as usize];
        let at = |uv: f32| chart.texcoord(&|_| Vec2::splat(uv));
        assert_eq!((at(-1.0), at(1.0)), (Vec2::ZERO, Vec2::ONE));
        // The chart coordinates of each texture map back to its original coordinates.
        let back = |texture: &Texture| texture.transform.transform_point2(at(0.5)).x;
        assert_eq!(back(&laid.base_color.texture.unwrap()), 0.5);
        assert_eq!(back(&laid.roughness.texture.unwrap()), 1.5);
        assert!(!charts.compromise);
        let normal = texture(1, 1.0, TextureWrap::Repeat);
        material.normal_map = Some(NormalMap { texture: normal, green: Default::default(), scale: 1.0 });
        assert!(!Charts::of(&material, &|_| (Vec2::ZERO, Vec2::ONE)).0.are_one());
        material.metalness = Input::texture(texture(1, 1.0, TextureWrap::Repeat), 2);
        assert!(Charts::of(&material, &|_| (Vec2::ZERO, Vec2::ONE)).0.compromise);
    }
}
