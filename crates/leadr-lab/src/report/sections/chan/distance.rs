//! Measures section 4.8: whether bumps with occlusion cones are as bright near as at a distance, where they are gloss.

use glam::{Vec2, Vec3};

use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use leadr_maps::derive::{Occlusion, visibility};
use leadr_maps::material::TextureWrap;
use leadr_maps::{HeightMap, RgbImage, procedural};
use leadr_reflectance::color::luminance;
use leadr_reflectance::masking::occlusion::ConeEdge;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::materials::diffuse_models::DiffuseModel;
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::scene::{FrameState, MaterialMap, Object, Pose, PropertyMap, Sun};
use leadr_render::settings::{RenderSettings, Shading, ShadingOptions, Technique, Terms};
use leadr_render::surfaces::displacement::HeightField;
use leadr_scenes::plane::{even, plane};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};

/// The number of texels along a side of the map.
const TEXELS: u32 = 128;
/// The deviation of the slopes, and the width of the bumps in texels.
const STEEP: f32 = 0.55;
const BUMP: f32 = 10.0;
const ALBEDO: f32 = 0.5;
/// The direction to the viewer.
const VIEW: Vec3 = Vec3::new(0.0, -0.5, 0.866);
/// The elevations and azimuths of the suns in degrees.
const SUNS: [(f32, f32, &str); 3] =
    [(60.0, 0.0, "behind the viewer"), (25.0, 0.0, "behind the viewer"), (25.0, 180.0, "opposite")];
/// The distance at which a tile is smaller than a pixel.
const FAR: f32 = 400.0;

/// A plane with a normal map and occlusion cones of bumps, without displacement. A tile of the maps is one metre wide.
pub struct Bumps(Renderer);

impl Bumps {
    /// Uploads the plane, in a dark room.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn new(studio: &Studio) -> Result<Self, LabError> {
        let map = procedural::gaussian(TEXELS, TEXELS, 3, STEEP, BUMP / TEXELS as f32);
        let open = visibility(&map, 1.0, &Occlusion::default(), &|_| ()).map_err(fault)?;
        let field = HeightField::repeating(map);
        let centre = |i: u32| (Vec2::new((i % TEXELS) as f32, (i / TEXELS) as f32) + 0.5) / TEXELS as f32;
        let step = 0.5 / TEXELS as f32;
        let slope = |i: u32| {
            let along = |d: Vec2| (field.bicubic(centre(i) + d) - field.bicubic(centre(i) - d)) / (2.0 * step);
            [along(Vec2::X * step), along(Vec2::Y * step)]
        };
        let slopes: Vec<[f32; 2]> = (0..TEXELS * TEXELS).map(slope).collect();
        let cone = |i: u32| {
            let [x, y, z] = open.at(i % TEXELS, i / TEXELS);
            // In cone maps, y points up.
            [x, -y, z, open.visibility[i as usize]]
        };
        let texels = (0..TEXELS * TEXELS).map(cone).collect();
        let cones = PropertyMap { width: TEXELS, height: TEXELS, texels, wrap: [TextureWrap::Repeat; 2] };
        let code = leadr_maps::srgb::srgb8_from_linear(ALBEDO);
        let rough = leadr_maps::material::alpha_code(0.5);
        let material = MaterialMap { cones: Some(cones), ..MaterialMap::new(1, 1, vec![[code, code, code, rough]]) };
        let flat = HeightMap { width: TEXELS, height: TEXELS, texels: vec![0.0; slopes.len()] };
        let object = Object::new("bumps", plane(64.0, 64, 1.0, [1.0; 4], even))
            .with_heights(HeightField::repeating(flat), 1.0)
            .with_slopes(slopes)
            .with_material(material)
            .without_shadow();
        let dark = RgbImage::new(8, 4, vec![[0.0; 3]; 32]).map_err(fault)?;
        Ok(Self(Renderer::new(&studio.gpu, vec![object], Environment::from_equirect(&studio.gpu, 16, &dark)?)?))
    }

    fn draw(
        &mut self,
        studio: &Studio,
        size: u32,
        shading: Shading,
        sun: Vec3,
        camera: Camera,
    ) -> Result<RgbImage, LabError> {
        let sun = Some(Sun { direction: sun, irradiance: Vec3::splat(3.0) });
        let state = FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) };
        let settings = RenderSettings {
            size: (size, size),
            samples: 4,
            displacement: false,
            shadows: false,
            shading,
            ..Default::default()
        };
        Ok(studio.shoot(&mut self.0, &state, &settings)?.image)
    }

    /// Draws one tile of the map, nearly without perspective.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn near(&mut self, studio: &Studio, size: u32, shading: Shading, sun: Vec3) -> Result<RgbImage, LabError> {
        let distance = 12.0f32;
        let degrees = 2.0 * (0.5 / distance).atan().to_degrees();
        self.draw(studio, size, shading, sun, Camera::looking_at(VIEW * distance, Vec3::ZERO, degrees))
    }

    /// Draws the plane at a distance at which a tile is below a pixel.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn far(&mut self, studio: &Studio, shading: Shading, sun: Vec3) -> Result<RgbImage, LabError> {
        self.draw(studio, 8, shading, sun, Camera::looking_at(VIEW * FAR, Vec3::ZERO, 2.0))
    }

    /// Returns the mean luminance of a picture.
    pub fn mean(image: &RgbImage) -> f64 {
        let sum: f64 = image.texels.iter().map(|t| luminance(Vec3::from_array(*t).as_dvec3())).sum();
        sum / image.texels.len() as f64
    }
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Chan section 4.8",
        "The spot meter: mean luminance of bumps with a sun at several heights, seen from 60° above the plane. Near, each bump has its \
        normal and, with the soft edge, its cone. At a distance, the bumps are roughness. Cones are filtered as well, and the mean cone is so \
        wide that it hides none of these suns. The last column is LEADR with the normal map's facets, far divided by near, without cones.",
    );
    let size = studio.pick(64, 192);
    let mut bumps = Bumps::new(studio)?;
    let mut table = Table::new(
        "Luminance near and far",
        ["model", "sun", "near, no cones", "near, cones", "far", "far / near, cones", "LEADR: far / near"],
    );
    let models = [DiffuseModel::Lambert, DiffuseModel::CallOfDuty, DiffuseModel::Multiscattering];
    for diffuse_model in models {
        let mut errors = [0.0f64; 2];
        for (elevation, azimuth, place) in SUNS {
            let (sine, cosine) = elevation.to_radians().sin_cos();
            let (across, along) = azimuth.to_radians().sin_cos();
            let sun = Vec3::new(cosine * across, -cosine * along, sine);
            let terms = Terms::DIFFUSE_LIGHTS;
            let shading = |technique: Technique, cone_edge| {
                let shadowing = Shadowing::NormalMap;
                technique.with(ShadingOptions { terms, cone_edge, diffuse_model, shadowing, ..Default::default() })
            };
            let (open, soft) = (ConeEdge::Open, ConeEdge::Soft);
            let mut near =
                |technique, edge| bumps.near(studio, size, shading(technique, edge), sun).map(|i| Bumps::mean(&i));
            let [bare, hidden, leadr] =
                [near(Technique::Gloss, open)?, near(Technique::Gloss, soft)?, near(Technique::Leadr, open)?];
            let mut far = |technique, edge| bumps.far(studio, shading(technique, edge), sun).map(|i| Bumps::mean(&i));
            let [far, far_leadr] = [far(Technique::Gloss, soft)?, far(Technique::Leadr, open)?];
            let ratios = [far / hidden, far_leadr / leadr];
            table.row([
                Cell::from(diffuse_model.name()),
                Cell::from(format!("{elevation}°, {place}")),
                Cell::from(bare),
                Cell::from(hidden),
                Cell::from(far),
                Cell::from(ratios[0]),
                Cell::from(ratios[1]),
            ]);
            let what = |of: &str| format!("{}, sun {elevation}° {place}: far / near, {of}", diffuse_model.name());
            page.check(what("gloss and cones"), ratios[0]);
            page.check(what("LEADR"), ratios[1]);
            errors = [0, 1].map(|k| errors[k].max((ratios[k] - 1.0).abs()));
        }
        page.find(&format!(
            "{}: gloss far differs from bumps with cones near by up to {}; LEADR far from bumps near by up to {}.",
            diffuse_model.name(),
            number(errors[0]),
            number(errors[1])
        ));
    }
    page.html.table(&table);
    Ok(())
}
