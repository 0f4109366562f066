//! The paper's tables over a full-screen quad, and the goals for the measured times.

use super::forward::Forward;
use super::goals::{Bound, Goal, TimeRef};
use super::rounds::{PIXELS, TOTAL, WITH_GEOMETRY};
use super::rows::Row;
use leadr_reflectance::integrals::slope_nodes::NodePlacement;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::materials::diffuse_models::DiffuseModel;
use leadr_render::scene::FrameState;
use leadr_render::settings::{
    BaseFrame, PixelKernel, Probes, Quadrature, RenderSettings, Shading, ShadingOptions, Technique, Terms,
};
use leadr_render::surfaces::tessellation::TessellationSettings;
use leadr_scenes::view::Size;

const LIGHT: &str = "specular, one light";
const SPECULAR: &str = "specular environment";
const DIFFUSE: &str = "diffuse environment";
const DIFFUSE_LIGHT: &str = "diffuse, one light";
const DIFFUSE_MODELS: &str = "diffuse base by model, environment and one light";
const AGAINST_FORWARD: &str = "against a forward pass";
const FIGURE_11_SPECULAR: &str = "figure 11, specular environment";
const FIGURE_11_DIFFUSE: &str = "figure 11, diffuse environment";
const VISIBILITY_LIGHT: &str = "visibility, one light";
const VISIBILITY_SPECULAR: &str = "visibility, specular environment";
const VISIBILITY_DIFFUSE: &str = "visibility, diffuse environment";

/// The name of the row with which the environment rows are compared.
const ONE_SAMPLE: &str = "one sample";
const LEADR_SMITH: &str = "leadr, smith";

/// The tables that plot times over the number of samples.
pub const FIGURE_11: [&str; 2] = [FIGURE_11_SPECULAR, FIGURE_11_DIFFUSE];

const fn pixels(table: &'static str, row: &'static str) -> TimeRef {
    TimeRef { table, row, pass: PIXELS, times: 1 }
}

/// Returns the time of 64 samples of a reference picture. The time favours the reference, because it omits the passes that
/// prepare a frame.
const fn reference(table: &'static str, row: &'static str) -> TimeRef {
    TimeRef { table, row, pass: "geometry+filter+shade+accumulate", times: 64 }
}

const fn total(table: &'static str, row: &'static str) -> TimeRef {
    TimeRef { table, row, pass: TOTAL, times: 1 }
}

const fn of_forward(
    row: &'static str,
    pass: &'static str,
    forward: &'static str,
    name: &'static str,
    most: f64,
) -> Goal {
    let of = TimeRef { table: AGAINST_FORWARD, row, pass, times: 1 };
    let to = TimeRef { table: AGAINST_FORWARD, row: forward, pass: TOTAL, times: 1 };
    Goal { name, of, to, bound: Bound::AtMost(most) }
}

/// The goals for times. Most goals have a corresponding bound on errors, which `leadr-lab report` measures.
pub const GOALS: [Goal; 12] = [
    Goal {
        name: "specular, one light: LEADR / LEAN",
        of: pixels(LIGHT, "leadr"),
        to: pixels(LIGHT, "lean"),
        bound: Bound::AtMost(1.0),
    },
    Goal {
        name: "diffuse environment: visible slopes / one sample",
        of: pixels(DIFFUSE, "leadr visible"),
        to: pixels(DIFFUSE, ONE_SAMPLE),
        bound: Bound::AtMost(2.0),
    },
    Goal {
        name: "specular environment: 16 visible slopes / one sample",
        of: pixels(SPECULAR, "leadr visible 16"),
        to: pixels(SPECULAR, ONE_SAMPLE),
        bound: Bound::AtMost(3.0),
    },
    Goal {
        name: "diffuse environment with shadows / one sample",
        of: pixels(VISIBILITY_DIFFUSE, "correlated"),
        to: pixels(DIFFUSE, ONE_SAMPLE),
        bound: Bound::AtMost(1.2),
    },
    Goal {
        name: "sphere: 64 samples of the reference / LEADR",
        of: reference("sphere", "reference"),
        to: total("sphere", "leadr"),
        bound: Bound::AtLeast(50.0),
    },
    Goal {
        name: "far trex: 64 samples of the reference / LEADR",
        of: reference("trex from afar", "reference at 8x"),
        to: total("trex from afar", "leadr at 8x"),
        bound: Bound::AtLeast(50.0),
    },
    of_forward("lean", PIXELS, "forward lean", "LEAN / a forward pass of LEAN", 2.0),
    of_forward("leadr", PIXELS, "forward leadr", "LEADR / a forward pass of LEADR", 2.0),
    of_forward("leadr", WITH_GEOMETRY, "forward leadr", "LEADR and its geometry / a forward pass of LEADR", 2.5),
    of_forward(
        "leadr 5x5, mirrored",
        PIXELS,
        "forward 5x5, mirrored",
        "specular environment: LEADR 5x5 / a forward pass of 5x5",
        0.8,
    ),
    of_forward(
        "leadr visible 16, mirrored",
        PIXELS,
        "forward 5x5, mirrored",
        "specular environment: 16 probes / a forward pass of 5x5",
        0.7,
    ),
    of_forward(
        "leadr visible, diffuse",
        PIXELS,
        "forward 5x5, diffuse",
        "diffuse environment: visible slopes / a forward pass of 5x5",
        1.0,
    ),
];

/// Whether any goal uses this row.
pub fn in_a_goal(row: &Row) -> bool {
    GOALS.iter().flat_map(|goal| [goal.of, goal.to]).any(|time| time.table == row.table && time.row == row.name)
}

/// Returns the settings of the paper's supplement, whose algorithms mask without shadowing. The base roughness is in the frame of the
/// macrosurface. The paper has no pixel kernel, no occlusion by the relief and one Gaussian of slopes.
pub fn paper(technique: Technique, quadrature: Quadrature, terms: Terms) -> Shading {
    technique.with(ShadingOptions {
        quadrature,
        terms,
        shadowing: Shadowing::None,
        base_frame: BaseFrame::Macro,
        pixel_kernel: PixelKernel::Off,
        relief_occlusion: false,
        sky_occlusion: false,
        relief_color: false,
        classes: false,
        ..Default::default()
    })
}

fn row(state: &FrameState, size: Size, table: &str, name: &str, base: Option<&str>, shading: Shading) -> Row {
    Row {
        table: table.to_owned(),
        name: name.to_owned(),
        base: base.map(str::to_owned),
        beside: None,
        compared: PIXELS,
        state: state.clone(),
        settings: RenderSettings {
            size: (size.width, size.height),
            shading,
            tessellation: TessellationSettings { max_factor: 1.0, cull: false, ..Default::default() },
            shadows: false,
            displacement: false,
            ..Default::default()
        },
        sun_hours: 0.0,
        set_up: None,
        forward: None,
    }
}

/// Returns rows of the renderer, and rows of a plain forward pass over the same quad for comparison.
pub fn against_forward(state: &FrameState, size: Size) -> Vec<Row> {
    let leadr = |rule, terms| paper(Technique::Leadr, rule, terms);
    let light = |technique| paper(technique, Quadrature::Grid(1), Terms::SPECULAR_LIGHTS);
    let (specular, diffuse) = (Terms::SPECULAR_ENVIRONMENT, Terms::DIFFUSE_ENVIRONMENT);
    let grid = |n| leadr(Quadrature::Grid(n), specular);
    let probes = leadr(Quadrature::VisibleSlopes(Probes::Sixteen), specular);
    let closed = leadr(Quadrature::VisibleSlopes(Probes::Five), diffuse);
    let finest = Forward::Environment(5);
    let pairs = [
        ("constant", light(Technique::Constant), Forward::Constant, None),
        ("blinn-phong", light(Technique::BlinnPhong), Forward::BlinnPhong, None),
        ("lean", light(Technique::Lean), Forward::Lean, None),
        ("leadr", light(Technique::Leadr), Forward::Leadr, None),
        ("leadr 1x1, mirrored", grid(1), Forward::Environment(1), None),
        ("leadr 3x3, mirrored", grid(3), Forward::Environment(3), None),
        ("leadr 5x5, mirrored", grid(5), finest, None),
        ("leadr visible 16, mirrored", probes, Forward::Environment(4), Some(finest)),
        ("leadr 5x5, diffuse", leadr(Quadrature::Grid(5), diffuse), Forward::Irradiance(5), None),
        ("leadr visible, diffuse", closed, Forward::Irradiance(5), None),
    ];
    let mut rows: Vec<Row> = Vec::new();
    for (name, shading, forward, beside) in pairs {
        let base = forward.to_string();
        let own = row(state, size, AGAINST_FORWARD, name, Some(&base), shading);
        rows.push(Row { beside: beside.map(|forward| forward.to_string()), ..own });
        if rows.iter().all(|row| row.name != base) {
            let plain = row(state, size, AGAINST_FORWARD, &base, None, shading);
            rows.push(Row { forward: Some(forward), ..plain });
        }
    }
    rows
}

/// Returns the rows of all tables of the full-screen quad in `state`.
pub fn rows(state: &FrameState, size: Size) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add =
        |table: &str, name: &str, base: &str, shading| rows.push(row(state, size, table, name, Some(base), shading));
    let leadr = |quadrature, terms| paper(Technique::Leadr, quadrature, terms);
    // The rows fetch the environment once along the reflection about the mean normal, and use the irradiance of the mean
    // normal.
    let one = |terms| paper(Technique::BlinnPhong, Quadrature::Grid(1), terms);
    // The number of samples of the diffuse rule does not depend on the probes.
    let visible = |terms| leadr(Quadrature::VisibleSlopes(Probes::Five), terms);

    // The paper times specular light with the shadowing of eq. 17 and Algorithm 1.
    let shadowed =
        |shading: Shading| shading.adjusted(|options| ShadingOptions { shadowing: Shadowing::Smith, ..options });

    for technique in Technique::ALL.into_iter().filter(|t| !t.is_reference()) {
        add(LIGHT, technique.name(), "lean", paper(technique, Quadrature::Grid(1), Terms::SPECULAR_LIGHTS));
    }
    add(LIGHT, LEADR_SMITH, "lean", shadowed(leadr(Quadrature::Grid(1), Terms::SPECULAR_LIGHTS)));
    let tables = [
        (SPECULAR, FIGURE_11_SPECULAR, Terms::SPECULAR_ENVIRONMENT),
        (DIFFUSE, FIGURE_11_DIFFUSE, Terms::DIFFUSE_ENVIRONMENT),
    ];
    for (table, figure, terms) in tables {
        add(table, ONE_SAMPLE, ONE_SAMPLE, one(terms));
        for n in [1, 3, 5, 7, 32] {
            add(table, &format!("leadr {n}x{n}"), ONE_SAMPLE, leadr(Quadrature::Grid(n), terms));
        }
        for &grid_nodes in &NodePlacement::ALL[1..] {
            let shading =
                leadr(Quadrature::Grid(5), terms).adjusted(|options| ShadingOptions { grid_nodes, ..options });
            add(table, &format!("leadr 5x5, {}", grid_nodes.name()), ONE_SAMPLE, shading);
        }
        if table == SPECULAR {
            for n in [3, 5, 7] {
                add(table, &format!("leadr {n}x{n}, smith"), ONE_SAMPLE, shadowed(leadr(Quadrature::Grid(n), terms)));
            }
            for probes in Probes::ALL {
                let (name, rule) = (format!("leadr visible {}", probes.count()), Quadrature::VisibleSlopes(probes));
                add(table, &name, ONE_SAMPLE, leadr(rule, terms));
            }
        } else {
            add(table, "leadr visible", ONE_SAMPLE, visible(terms));
        }
        for n in 1..=16 {
            add(figure, &format!("leadr {n}x{n}"), "leadr 1x1", leadr(Quadrature::Grid(n), terms));
        }
    }
    let terms = Terms::DIFFUSE_LIGHTS;
    add(DIFFUSE_LIGHT, ONE_SAMPLE, ONE_SAMPLE, one(terms));
    add(DIFFUSE_LIGHT, "leadr 5x5", ONE_SAMPLE, leadr(Quadrature::Grid(5), terms));
    add(DIFFUSE_LIGHT, "leadr visible", ONE_SAMPLE, visible(terms));

    for diffuse_model in DiffuseModel::ALL {
        let shading = visible(Terms::DIFFUSE_LIGHTS | Terms::DIFFUSE_ENVIRONMENT)
            .adjusted(|options| ShadingOptions { diffuse_model, ..options });
        add(DIFFUSE_MODELS, diffuse_model.name(), DiffuseModel::Lambert.name(), shading);
    }

    let tables = [
        (VISIBILITY_LIGHT, Terms::SPECULAR_LIGHTS | Terms::DIFFUSE_LIGHTS),
        (VISIBILITY_SPECULAR, Terms::SPECULAR_ENVIRONMENT),
        (VISIBILITY_DIFFUSE, Terms::DIFFUSE_ENVIRONMENT),
    ];
    for (table, terms) in tables {
        for shadowing in Shadowing::MAIN {
            let shading = visible(terms).adjusted(|options| ShadingOptions { shadowing, ..options });
            add(table, shadowing.name(), "masking", shading);
        }
    }
    rows
}

/// Returns the time in milliseconds that the paper reports for a row, on an NVIDIA GTX 480 (LEADR section 7).
pub fn paper_ms(row: &Row) -> Option<f64> {
    Some(match (row.table.as_str(), row.name.as_str()) {
        (LIGHT, "constant") => 0.055,
        (LIGHT, "blinn-phong") => 0.146,
        (LIGHT, "lean") => 0.266,
        (LIGHT, LEADR_SMITH) => 0.267,
        (SPECULAR, ONE_SAMPLE) => 0.402,
        (SPECULAR, "leadr 3x3, smith") => 0.433,
        (SPECULAR, "leadr 5x5, smith") => 1.704,
        (SPECULAR, "leadr 7x7, smith") => 4.284,
        (DIFFUSE, ONE_SAMPLE) => 0.148,
        (DIFFUSE, "leadr 3x3") => 1.067,
        (DIFFUSE, "leadr 5x5") => 2.750,
        (DIFFUSE, "leadr 7x7") => 5.027,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::super::scene::{distances, techniques};
    use super::*;
    use crate::bench::full_screen::full_screen_stage;
    use leadr_scenes::config::SceneConfig;
    use leadr_scenes::registry::NamedScene;
    use leadr_scenes::stage::Lights;

    fn all_rows() -> Vec<Row> {
        let stage = full_screen_stage((8, 8));
        let state = stage.state(0.0, &stage.views.mid, &Lights::default());
        let size = Size { width: 8, height: 8 };
        let mut rows = rows(&state, size);
        rows.extend(against_forward(&state, size));
        for name in ["sphere", "trex"] {
            let config = SceneConfig { scene: NamedScene::find(name).unwrap(), ..SceneConfig::default() };
            rows.extend(techniques(&config, &state, None));
            rows.extend(distances(&config, &state, None));
        }
        rows
    }

    #[test]
    fn rows_are_unique_and_have_their_base() {
        let rows = all_rows();
        for row in &rows {
            let same = rows.iter().filter(|r| r.table == row.table && r.name == row.name).count();
            assert_eq!(same, 1, "{}: {}", row.table, row.name);
            assert!(row.base.is_some() || row.forward.is_some(), "{}: {}", row.table, row.name);
            for base in row.base.iter().chain(&row.beside) {
                assert!(rows.iter().any(|r| r.table == row.table && r.name == *base), "{}: {base}", row.table);
            }
            row.settings.shading.check().unwrap();
        }
    }

    #[test]
    fn every_goal_uses_measured_rows() {
        let rows = all_rows();
        for goal in GOALS {
            for time in [goal.of, goal.to] {
                assert!(rows.iter().any(|r| r.table == time.table && r.name == time.row), "{}: {time:?}", goal.name);
            }
        }
    }

    #[test]
    fn goals_of_the_quad_need_seven_rows() {
        let rows: Vec<Row> =
            all_rows().into_iter().filter(|row| in_a_goal(row) && row.table != AGAINST_FORWARD).collect();
        let quad = rows.iter().filter(|r| r.compared == PIXELS);
        let found: Vec<_> = quad.map(|r| (r.table.as_str(), r.name.as_str())).collect();
        let expected = [(LIGHT, "lean"), (LIGHT, "leadr"), (SPECULAR, ONE_SAMPLE), (SPECULAR, "leadr visible 16")];
        let diffuse = [(DIFFUSE, ONE_SAMPLE), (DIFFUSE, "leadr visible"), (VISIBILITY_DIFFUSE, "correlated")];
        assert_eq!(found, [&expected[..], &diffuse[..]].concat());
    }

    #[test]
    fn the_papers_rows_are_there() {
        let rows = all_rows();
        assert_eq!(rows.iter().filter(|r| paper_ms(r).is_some()).count(), 12);
        let samples = |table: &str| -> Vec<u32> { rows.iter().filter(|r| r.table == table).map(Row::probes).collect() };
        for table in FIGURE_11 {
            assert_eq!(samples(table), (1..=16).map(|n| n * n).collect::<Vec<_>>());
        }
    }
}
