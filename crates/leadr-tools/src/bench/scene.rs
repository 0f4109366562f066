//! The tables of a scene, for several views, techniques, distances, resolutions, triangle sizes and map sizes.

use clap::ValueEnum;
use glam::Vec3;

use super::quad;
use super::rounds::TOTAL;
use super::rows::Row;
use leadr_render::scene::{FrameState, PointLight};
use leadr_render::settings::{DiffuseLights, Probes, Quadrature, RenderSettings, ShadingOptions, Technique, Terms};
use leadr_scenes::config::{Picture, SceneConfig};
use leadr_scenes::registry::{Choice, NamedScene};
use leadr_scenes::view::{Size, ViewChoice};

/// A table of a scene, in the order of measurement. The doc comments of the variants are the help texts of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Table {
    /// Near, mid and far views at several picture sizes
    Views,
    /// Every technique, and a moving sun
    Techniques,
    /// Half to sixteen times the distance of the middle view
    Distance,
    /// A quarter to twice the picture size along each side
    Resolution,
    /// Triangles of 1, 2, 4, 8 and 16 pixels
    Triangles,
    /// 0 to 256 point lights around the middle view
    Lights,
    /// Maps of increasing size, with LEADR and LEAN in sunlight
    Maps,
    /// One Beckmann lobe, a GGX base, and the lobes of a measured material
    Bases,
    /// The passes of the open sea by size of transform and of picture
    Waves,
    /// Balls by number of objects, materials, triangles, pixels and texels, and their set-up times
    Scale,
}

impl Table {
    /// Returns the name that the command line uses.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether a scene supports this table.
    pub fn is_of(self, scene: &NamedScene) -> bool {
        match self {
            Self::Maps => scene.offers(Choice::AtlasTile) || scene.offers(Choice::HeightMap),
            Self::Bases => scene.offers(Choice::HeightMap),
            // With the objects of a beach, the sea is only a small part of a frame.
            Self::Waves => scene.offers(Choice::Waves) && !scene.offers(Choice::Objects),
            Self::Scale => scene.name == "sphere",
            _ => true,
        }
    }
}

/// The motion of the sun per round: one minute, in hours.
const SUN_STEP: f64 = 1.0 / 60.0;
/// The distances of the camera, as multiples of the middle view's distance.
const ZOOM: [f32; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
/// The multiple of the distance at which the reference is also measured.
const AFAR: f32 = 8.0;
/// The triangle sizes in pixels, and the size of the row with which all others are compared.
const TRIANGLES: [f32; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
const USUAL_TRIANGLES: f32 = 4.0;
/// The numbers of point lights.
const LIGHTS: [usize; 6] = [0, 1, 4, 16, 64, 256];

/// Returns a row of a scene. The total time is compared with the row `base` in the same table.
pub fn row(config: &SceneConfig, technique: Technique, state: FrameState, [table, name, base]: [String; 3]) -> Row {
    // With 64 samples, every round of a reference draws a different sample.
    let samples = if technique.is_reference() { 64 } else { 1 };
    Row {
        table,
        name,
        base: Some(base),
        beside: None,
        compared: TOTAL,
        state,
        settings: SceneConfig { picture: Picture { technique, samples, ..config.picture }, ..config.clone() }
            .render_settings(),
        sun_hours: 0.0,
        set_up: None,
        forward: None,
    }
}

/// Returns rows for the scene's own views, with one table per picture size. `seen` returns the state for a view and a picture size.
pub fn views(
    config: &SceneConfig,
    sizes: &[Size],
    seen: impl Fn(ViewChoice, Size) -> FrameState,
    only: Option<Technique>,
) -> Vec<Row> {
    const VIEWS: [(&str, ViewChoice); 3] =
        [("near", ViewChoice::Near), ("mid", ViewChoice::Mid), ("far", ViewChoice::Far)];
    let technique = only.unwrap_or(Technique::Leadr);
    let rows = sizes.iter().flat_map(|&size| VIEWS.map(|(name, view)| (size, name, view)));
    rows.map(|(size, name, view)| {
        let names = [format!("{} views, {size}", config.scene.name), name.to_owned(), "near".to_owned()];
        row(&SceneConfig { size, ..config.clone() }, technique, seen(view, size), names)
    })
    .collect()
}

/// Returns rows at the middle view of `state`: one for each technique, and one for LEADR with a moving sun. `only` replaces
/// all techniques.
pub fn techniques(config: &SceneConfig, state: &FrameState, only: Option<Technique>) -> Vec<Row> {
    let base = only.unwrap_or(Technique::Leadr);
    let names = |name: &str| [config.scene.name.to_owned(), name.to_owned(), base.name().to_owned()];
    let wanted = Technique::ALL.into_iter().filter(|t| only.is_none_or(|only| only == *t));
    let mut rows: Vec<Row> =
        wanted.map(|technique| row(config, technique, state.clone(), names(technique.name()))).collect();
    let moving = row(config, base, state.clone(), names(&format!("{}, moving sun", base.name())));
    rows.push(Row { sun_hours: SUN_STEP, ..moving });
    rows
}

/// Returns rows for LEADR (or the technique `only`) at multiples of the distance of the middle view of `state`.
pub fn distances(config: &SceneConfig, state: &FrameState, only: Option<Technique>) -> Vec<Row> {
    let base = only.unwrap_or(Technique::Leadr);
    let middle = state.camera.position.distance(state.camera.target);
    let mut rows = Vec::new();
    for factor in ZOOM {
        let techniques = [Some(base), (factor == AFAR && only.is_none()).then_some(Technique::Reference)];
        for technique in techniques.into_iter().flatten() {
            let state = FrameState { camera: state.camera.at_distance(middle * factor), ..state.clone() };
            let name = format!("{} at {factor}x", technique.name());
            let names = [format!("{} from afar", config.scene.name), name, format!("{} at 1x", base.name())];
            rows.push(row(config, technique, state, names));
        }
    }
    rows
}

/// Returns rows for the middle view of `state` at a quarter to twice the picture size along each side.
pub fn resolutions(config: &SceneConfig, state: &FrameState, only: Option<Technique>) -> Vec<Row> {
    let Size { width, height } = config.size;
    let quarters = |n: u32| Size { width: (width * n / 4).max(1), height: (height * n / 4).max(1) };
    let sizes = [1, 2, 4, 8].map(quarters);
    let mut rows = Vec::new();
    for size in sizes {
        let names = [format!("{} by size of picture", config.scene.name), size.to_string(), config.size.to_string()];
        let config = SceneConfig { size, ..config.clone() };
        rows.push(row(&config, only.unwrap_or(Technique::Leadr), state.clone(), names));
    }
    // Very small pictures can have the same size after rounding.
    rows.dedup_by(|a, b| a.name == b.name);
    rows
}

/// Returns rows for the middle view of `state` with triangles of increasing size.
pub fn triangles(config: &SceneConfig, state: &FrameState, only: Option<Technique>) -> Vec<Row> {
    let name = |pixels: f32| format!("{pixels} px a triangle");
    let divided = |triangle_pixels: f32| {
        let names =
            [format!("{} by size of triangles", config.scene.name), name(triangle_pixels), name(USUAL_TRIANGLES)];
        let config = SceneConfig { picture: Picture { triangle_pixels, ..config.picture }, ..config.clone() };
        row(&config, only.unwrap_or(Technique::Leadr), state.clone(), names)
    };
    TRIANGLES.map(divided).into()
}

/// Returns rows for the middle view of `state` with increasing numbers of point lights above the target of the camera. The lights have no
/// range, so each of them lights every pixel. Together they always have the same intensity. For LEADR, more tables draw diffuse light with
/// the settings of the paper: each light is integrated over a grid, all lights are integrated at once (Algorithm 2), or each light has a
/// closed form.
pub fn lights(config: &SceneConfig, state: &FrameState, only: Option<Technique>) -> Vec<Row> {
    let technique = only.unwrap_or(Technique::Leadr);
    let away = state.camera.position.distance(state.camera.target);
    let lit = |count: usize| {
        let intensity = Vec3::splat(2.0 * away * away / state.exposure() / count.max(1) as f32);
        let light = |i: usize| {
            // A spiral of even density over the hemisphere.
            let (height, angle) = ((i as f32 + 0.5) / count as f32, 2.399_963 * i as f32);
            let level = (1.0 - height * height).sqrt();
            let direction = Vec3::new(level * angle.cos(), level * angle.sin(), height);
            PointLight::new(state.camera.target + away * direction, intensity)
        };
        FrameState { point_lights: (0..count).map(light).collect(), ..state.clone() }
    };
    let usual = row(config, technique, state.clone(), Default::default()).settings.shading;
    let diffuse = |quadrature| quad::paper(technique, quadrature, Terms::DIFFUSE_LIGHTS);
    let grid = diffuse(Quadrature::Grid(5));
    let kinds = [
        ("", usual),
        (", diffuse, 5x5 grid for each", grid),
        (", diffuse, 5x5 grid for all", grid.adjusted(|o| ShadingOptions { diffuse_lights: DiffuseLights::Sh, ..o })),
        (", diffuse, closed form", diffuse(Quadrature::VisibleSlopes(Probes::Sixteen))),
    ];
    let kinds = if technique == Technique::Leadr { &kinds[..] } else { &kinds[..1] };
    let rows = kinds.iter().flat_map(|&(kind, shading)| LIGHTS.map(|count| (kind, shading, count)));
    rows.map(|(kind, shading, count)| {
        let names = [format!("{} by number of lights{kind}", config.scene.name), count.to_string(), "0".to_owned()];
        let row = row(config, technique, lit(count), names);
        Row { settings: RenderSettings { shading, ..row.settings }, ..row }
    })
    .collect()
}

/// Returns rows for LEADR and LEAN (or the technique `only`) with maps of this size in texels. `first` is the size with which all
/// others are compared. The techniques use the paper's settings under the sun alone, so they differ only in their filtering.
pub fn maps(
    config: &SceneConfig,
    state: &FrameState,
    [size, first]: [(u32, u32); 2],
    only: Option<Technique>,
) -> Vec<Row> {
    let name = |technique: Technique, (width, height): (u32, u32)| format!("{} {width}x{height}", technique.name());
    let base = only.unwrap_or(Technique::Leadr);
    let names =
        |technique| [format!("{} by size of maps", config.scene.name), name(technique, size), name(base, first)];
    let sunlit = |technique| {
        let row = row(config, technique, state.clone(), names(technique));
        let shading = quad::paper(technique, Quadrature::Grid(1), Terms::SPECULAR_LIGHTS | Terms::DIFFUSE_LIGHTS);
        Row { settings: RenderSettings { shading, ..row.settings }, ..row }
    };
    let own = sunlit(base);
    if only.is_some() {
        return vec![own];
    }
    let lean = sunlit(Technique::Lean);
    vec![Row { beside: Some(lean.name.clone()), ..own }, lean]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::full_screen::full_screen_stage;
    use leadr_scenes::registry::SCENES;
    use leadr_scenes::stage::Lights;

    fn config() -> SceneConfig {
        SceneConfig { size: Size { width: 64, height: 32 }, ..SceneConfig::default() }
    }

    fn state() -> FrameState {
        let stage = full_screen_stage((8, 8));
        stage.state(0.0, &stage.views.mid, &Lights::default())
    }

    #[test]
    fn rows_are_unique_and_have_their_reference() {
        let (config, state, lean) = (config(), state(), Some(Technique::Lean));
        let sizes = [Size { width: 8, height: 8 }, Size { width: 16, height: 9 }];
        for only in [None, lean] {
            let mut rows = views(&config, &sizes, |_, _| state.clone(), only);
            rows.extend(techniques(&config, &state, only));
            rows.extend(distances(&config, &state, only));
            rows.extend(resolutions(&config, &state, only));
            rows.extend(triangles(&config, &state, only));
            rows.extend(lights(&config, &state, only));
            for size in [(32, 16), (64, 32)] {
                rows.extend(maps(&config, &state, [size, (32, 16)], only));
            }
            for row in &rows {
                let found = |name: &str| rows.iter().filter(|r| r.table == row.table && r.name == name).count();
                assert_eq!(found(&row.name), 1, "{}: {}", row.table, row.name);
                for name in row.base.iter().chain(&row.beside) {
                    assert_eq!(found(name), 1, "{}: {} against {name}", row.table, row.name);
                }
            }
            assert!(only.is_none() || rows.iter().all(|row| row.settings.shading.technique() == Technique::Lean));
        }
    }

    #[test]
    fn rows_differ_in_their_tables_subject() {
        let (config, state) = (config(), state());
        let sizes: Vec<_> = resolutions(&config, &state, None).iter().map(|row| row.settings.size).collect();
        assert_eq!(sizes, [(16, 8), (32, 16), (64, 32), (128, 64)]);
        let rows = triangles(&config, &state, None);
        let pixels: Vec<f32> = rows.iter().map(|row| row.settings.tessellation.pixels_per_triangle).collect();
        assert_eq!(pixels, TRIANGLES);
        let tiny = SceneConfig { size: Size { width: 1, height: 1 }, ..config };
        let names: Vec<String> = resolutions(&tiny, &state, None).into_iter().map(|row| row.name).collect();
        assert_eq!(names, ["1x1", "2x2"]);
    }

    #[test]
    fn table_scenes_support_their_options() {
        let of = |table: Table| SCENES.iter().filter(|s| table.is_of(s)).map(|s| s.name).collect::<Vec<_>>();
        assert_eq!(of(Table::Views).len(), SCENES.len());
        assert_eq!(of(Table::Waves), ["ocean"]);
        assert_eq!(of(Table::Bases), ["plane", "sphere"]);
        assert_eq!(of(Table::Scale), ["sphere"]);
        assert_eq!(of(Table::Maps), ["trex", "plane", "sphere", "pillow", "snake", "shore"]);
    }
}
