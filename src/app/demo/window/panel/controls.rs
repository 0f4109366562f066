//! The controls of the panel.

use std::collections::BTreeMap;

use egui::{ComboBox, Slider, SliderClamping, Ui};

use super::facts::{Facts, Request};
use crate::app::demo::window::choices::{Compare, DisplayMode};
use crate::app::demo::window::show::OfSurfaces;
use crate::app::demo::window::viewer::{Action, Viewer};
use leadr_render::settings::{self, Panel, Probes, Quadrature, Technique, Terms, Value, headings};
use leadr_scenes::config::Picture;
use leadr_scenes::light::SunDirection;
use leadr_scenes::options::{SceneOption, Sets};

/// Initial length of the timeline and step of its growth, seconds.
const TIMELINE: f64 = 30.0;
/// Maximum height of a list without scrolling, points.
const LIST: f32 = 400.0;

/// Whether each section that the user has opened or closed is open, by title.
pub type Sections = BTreeMap<String, bool>;

/// Shows all controls, with the most important first.
pub fn show(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>, sections: &mut Sections, requests: &mut Vec<Request>) {
    ui.add_space(6.0);
    scene(ui, facts, requests);
    section(ui, "Technique", true, sections, |ui| technique(ui, viewer, facts));
    section(ui, "Side by side", true, sections, |ui| compare(ui, viewer));
    section(ui, "Camera and time", true, sections, |ui| view(ui, viewer, requests));
    section(ui, "Light", true, sections, |ui| light(ui, viewer, facts));
    section(ui, "Surface and picture", false, sections, |ui| picture(ui, viewer, facts, requests));
}

/// Shows the options under a heading that the scene and the technique support.
fn options(ui: &mut Ui, heading: &str, picture: &mut Picture, facts: &Facts<'_>) {
    let under = |option: &&SceneOption| option.spec.heading == heading && option.spec.panel == Panel::Control;
    for option in SceneOption::all().iter().filter(under) {
        if option.choice.is_some_and(|choice| !(facts.offers)(choice)) {
            continue;
        }
        match &option.sets {
            Sets::Picture(value) => control(ui, option, value, picture),
            Sets::Shading(row) if row.applies_to(picture.technique) => {
                control(ui, option, &row.value, &mut picture.options);
            }
            _ => {}
        }
    }
}

/// Shows the control of an option.
fn control<C: Copy>(ui: &mut Ui, option: &SceneOption, value: &Value<C>, config: &mut C) {
    let label = option.spec.label();
    let response = match value {
        Value::Switch(at) => ui.checkbox(at(config), label),
        Value::Flag(at, given) => {
            let mut on = *at(config) == *given;
            let response = ui.checkbox(&mut on, label);
            *at(config) = on == *given;
            response
        }
        Value::Number(at, _, slider) => {
            let [least, most] = slider.ends;
            ui.add(shown_as(Slider::new(at(config), least..=most), slider).text(label))
        }
        Value::Count(at, _, slider) => {
            let [least, most] = slider.ends.map(|end| end as u32);
            ui.add(shown_as(Slider::new(at(config), least..=most), slider).text(label))
        }
        Value::Name(at) => {
            let chosen = at(config);
            named(ui, &label, chosen.name(), |ui| {
                for (name, help) in chosen.names() {
                    if ui.selectable_label(name == chosen.name(), name).on_hover_text(help).clicked() {
                        // The list contains only valid names.
                        _ = chosen.choose(name);
                    }
                }
            })
        }
        // Options with a special format have separate controls.
        Value::Text(_) => return,
    };
    response.on_hover_text(option.help());
}

/// Creates a slider that keeps a value outside its range until it is dragged.
fn shown_as<'a>(slider: Slider<'a>, spec: &settings::Slider) -> Slider<'a> {
    let slider = slider.clamping(SliderClamping::Edits).logarithmic(spec.ends[0] > 0.0);
    slider.suffix(spec.unit).custom_formatter(shown(spec.decimals))
}

/// Formats a number with this many decimals. `fixed_decimals` of a slider would also round the value.
fn shown(decimals: usize) -> impl Fn(f64, std::ops::RangeInclusive<usize>) -> String {
    move |value, _| format!("{value:.decimals$}")
}

/// Shows a collapsible section in the state in which the user left it.
pub fn section(ui: &mut Ui, title: &str, open: bool, sections: &mut Sections, contents: impl FnOnce(&mut Ui)) {
    let was = sections.get(title).copied().unwrap_or(open);
    let header = egui::CollapsingHeader::new(title).default_open(was).show(ui, contents);
    // The opening animation takes several frames, so the click sets the state.
    if header.header_response.clicked() {
        sections.insert(title.to_owned(), !was);
    }
}

fn scene(ui: &mut Ui, facts: &Facts<'_>, requests: &mut Vec<Request>) {
    if !facts.scenes.is_empty() {
        named(ui, "scene", facts.scene, |ui| {
            for name in facts.scenes {
                if ui.selectable_label(name == facts.scene, name).clicked() {
                    requests.push(Request::Scene(name.clone()));
                }
            }
        })
        .on_hover_text("You can also drop a .glb or .gltf model on the window");
    }
    let shown = facts.environments.get(facts.environment).map_or("", String::as_str);
    named(ui, "environment", shown, |ui| {
        for (number, name) in facts.environments.iter().enumerate() {
            if ui.selectable_label(number == facts.environment, name).clicked() {
                requests.push(Request::Environment(number));
            }
        }
    })
    .on_hover_text("You can also drop a .hdr or .exr panorama on the window (e: next)");
}

/// Shows a drop-down list with a label on the left.
fn named(ui: &mut Ui, name: &str, shown: &str, list: impl FnOnce(&mut Ui)) -> egui::Response {
    ui.horizontal(|ui| {
        ui.label(name);
        ComboBox::from_id_salt(name)
            .selected_text(shown)
            .width(ui.available_width() - 8.0)
            .height(LIST)
            .show_ui(ui, list)
            .response
    })
    .inner
}

fn techniques(ui: &mut Ui, name: &str, chosen: &mut Technique) {
    named(ui, name, chosen.name(), |ui| {
        for technique in Technique::ALL {
            ui.selectable_value(chosen, technique, technique.name()).on_hover_text(format!(
                "{} ({})",
                technique.help(),
                technique.key()
            ));
        }
    })
    .on_hover_text(chosen.help());
}

fn technique(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>) {
    let picture = &mut viewer.choices.picture;
    techniques(ui, "technique", &mut picture.technique);
    if picture.technique.integrates() {
        let chosen = &mut picture.options.quadrature;
        let rules = Probes::ALL.map(Quadrature::VisibleSlopes).into_iter().chain([5, 9, 17].map(Quadrature::Grid));
        let label = |rule: Quadrature| match rule {
            Quadrature::VisibleSlopes(probes) => format!("{} probes", probes.count()),
            Quadrature::Grid(side) => format!("{side} x {side} slopes"),
        };
        named(ui, "integrals", &label(*chosen), |ui| {
            for rule in rules {
                ui.selectable_value(chosen, rule, label(rule));
            }
        })
        .on_hover_text(
            "Slope samples of the environment integrals: the paper's grids, or rules for visible slopes (g)",
        );
    }
    options(ui, headings::SHADING, picture, facts);
    if picture.technique.is_lit() {
        ui.horizontal_wrapped(|ui| {
            let terms = &mut picture.options.terms;
            for (term, name) in Terms::NAMES {
                let mut on = terms.contains(term);
                if ui.checkbox(&mut on, name).changed() {
                    *terms = if on { *terms | term } else { terms.without(term) };
                }
            }
        });
    }
}

fn compare(ui: &mut Ui, viewer: &mut Viewer) {
    let mut on = viewer.choices.compare.is_some();
    if ui.checkbox(&mut on, "compare with the right side (c)").changed() {
        viewer.act(Action::Compare);
    }
    if let Some(Compare { technique, difference, .. }) = &mut viewer.choices.compare {
        techniques(ui, "right", technique);
        ui.checkbox(difference, "difference (FLIP) when still").on_hover_text(
            "Difference of both sides. With the reference (256 samples) on the right, it is the error of the left side",
        );
        ui.weak("Drag the line in the picture.");
    }
}

fn view(ui: &mut Ui, viewer: &mut Viewer, requests: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        for (number, name) in ["near", "mid", "far"].into_iter().enumerate() {
            if ui.button(name).clicked() {
                requests.push(Request::View(number));
            }
        }
        let label = if viewer.sweep_progress().is_some() { "stop" } else { "zoom out" };
        let button = ui.add_enabled(viewer.sweep.is_some(), egui::Button::new(label));
        if button.on_hover_text("Move from near to far and back (o)").clicked() {
            viewer.act(Action::Sweep);
        }
    });
    ui.horizontal(|ui| {
        ui.selectable_value(&mut viewer.fly, false, "orbit");
        ui.selectable_value(&mut viewer.fly, true, "fly").on_hover_text("Drag to look; W A S D, Q and E move (f)");
        ui.weak(format!("{:.1} m", viewer.orbit.distance()));
    });
    ui.horizontal(|ui| {
        if ui.button(if viewer.paused { "play" } else { "pause" }).on_hover_text("space").clicked() {
            viewer.act(Action::Pause);
        }
        let end = TIMELINE * (viewer.time / TIMELINE).floor() + TIMELINE;
        let mut time = viewer.time;
        ui.spacing_mut().slider_width = 96.0;
        if ui.add(Slider::new(&mut time, 0.0..=end).suffix(" s").custom_formatter(shown(2))).changed() {
            viewer.time = time;
        }
    });
}

fn light(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>) {
    if let Some([azimuth, elevation]) = facts.sun {
        let mut sun = SunDirection { azimuth, elevation };
        let mut degrees = |value: &mut f32, ends, name| {
            ui.add(Slider::new(value, ends).suffix("°").custom_formatter(shown(0)).text(name)).changed()
        };
        let azimuth_changed = degrees(&mut sun.azimuth, -180.0..=180.0, "azimuth");
        let raised = degrees(&mut sun.elevation, -12.0..=90.0, "elevation");
        if azimuth_changed || raised {
            viewer.put_sun(sun);
        }
        ui.horizontal(|ui| {
            if ui.button("scene's sun").on_hover_text("Return to the scene's own sun").clicked() {
                viewer.choices.sun = None;
            }
            if ui.button("animate sun").on_hover_text("Next speed of the sun (t)").clicked() {
                viewer.act(Action::SunPace);
            }
        });
    }
    options(ui, headings::LIGHT, &mut viewer.choices.picture, facts);
}

/// Shows the roughness of displaced surfaces. It applies when the slider is released, because it rebuilds their maps.
fn roughness(ui: &mut Ui, roughness: &OfSurfaces<f32>, requests: &mut Vec<Request>) {
    let chosen = match *roughness {
        OfSurfaces::Fixed => return,
        OfSurfaces::Own => None,
        OfSurfaces::Chosen(alpha) => Some(alpha),
    };
    let held = ui.id().with("roughness");
    let mut alpha = ui.data(|data| data.get_temp(held)).or(chosen).unwrap_or(0.3);
    ui.horizontal(|ui| {
        let slider = ui.add(Slider::new(&mut alpha, 0.02..=1.0).custom_formatter(shown(2)).text("roughness"));
        let slider = slider.on_hover_text("Beckmann alpha of displaced surfaces; applied when you release the slider");
        if slider.is_pointer_button_down_on() && !slider.drag_stopped() {
            ui.data_mut(|data| data.insert_temp(held, alpha));
        } else if slider.drag_stopped() || slider.changed() {
            ui.data_mut(|data| data.remove::<f32>(held));
            requests.push(Request::Roughness(Some((alpha * 1000.0).round() / 1000.0)));
        }
        if chosen.is_some() && ui.small_button("own").on_hover_text("Use the scene's own roughness").clicked() {
            requests.push(Request::Roughness(None));
        }
    });
}

/// Shows the material of displaced surfaces.
fn material(ui: &mut Ui, applied_material: &OfSurfaces<String>, requests: &mut Vec<Request>) {
    const HINT: &str =
        "Drop a measured material (FIT.json from leadr fit) on the window; the plane and the sphere take a folder, too";
    match applied_material {
        OfSurfaces::Fixed => (),
        OfSurfaces::Own => _ = ui.weak("material: drop one here").on_hover_text(HINT),
        OfSurfaces::Chosen(name) => {
            _ = ui.horizontal(|ui| {
                ui.label(format!("material: {name}")).on_hover_text(HINT);
                if ui.small_button("own").on_hover_text("Use the scene's own material").clicked() {
                    requests.push(Request::OwnMaterial);
                }
            })
        }
    }
}

fn picture(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>, requests: &mut Vec<Request>) {
    material(ui, &facts.applied_material, requests);
    roughness(ui, &facts.roughness, requests);
    let choices = &mut viewer.choices;
    options(ui, headings::GEOMETRY, &mut choices.picture, facts);
    options(ui, headings::QUALITY, &mut choices.picture, facts);
    let name = DisplayMode::all().find(|(mode, _)| *mode == choices.display_mode).map_or("", |(_, name)| name);
    named(ui, "show", name, |ui| {
        for (mode, name) in DisplayMode::all() {
            ui.selectable_value(&mut choices.display_mode, mode, name);
        }
    });
}

/// Shows the buttons at the end of the panel.
pub fn buttons(ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        for (name, key, action) in [
            ("screenshot", "s, F12", Action::Screenshot),
            ("copy as command", "x", Action::CopyCommand),
            ("reset", "r", Action::Reset),
            ("help", "F1", Action::Help),
            ("hide", "Tab", Action::Panel),
        ] {
            if ui.button(name).on_hover_text(key).clicked() {
                requests.push(Request::Act(action));
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::demo::orbit::Orbit;
    use crate::app::demo::window::choices::Choices;
    use egui::{Pos2, RawInput, Rect, Shape, Vec2};
    use leadr_scenes::view::CameraPose;

    /// Options with special controls, each with a text of its control.
    const OWN: [(&str, &str); 15] = [
        ("scene", "scene"),
        ("environment", "environment"),
        ("technique", "technique"),
        ("rule", "integrals"),
        ("grid", "integrals"),
        ("probes", "integrals"),
        ("terms", "specular-lights"),
        ("camera", "orbit"),
        ("distance", "zoom out"),
        ("sun", "azimuth"),
        ("time-of-day", "animate sun"),
        ("day-length", "animate sun"),
        ("material", "material: drop one here"),
        ("measured", "material: drop one here"),
        ("roughness", "roughness"),
    ];

    /// Returns the texts of the panel for a technique.
    fn texts(technique: Technique) -> Vec<String> {
        let pose = CameraPose { position: [1.0; 3], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_degrees: 35.0 };
        let choices = Choices::new(Picture { technique, ..Picture::default() });
        let mut viewer = Viewer::new(Orbit::new(&pose), 0.0, choices, None);
        let facts = Facts {
            scenes: &["plane".to_owned()],
            scene: "plane",
            environments: &["sky".to_owned()],
            environment: 0,
            sun: Some([0.0, 45.0]),
            roughness: OfSurfaces::Own,
            applied_material: OfSurfaces::Own,
            offers: &|_| true,
            device: "",
            fps: None,
            passes: &[],
            samples: (1, 1),
            pixels: (1, 1),
            triangles: (0, 0),
        };
        let mut sections = Sections::from([("Surface and picture".to_owned(), true)]);
        let screen = Rect::from_min_size(Pos2::ZERO, Vec2::new(400.0, 4000.0));
        let input = RawInput { screen_rect: Some(screen), ..RawInput::default() };
        let mut output =
            egui::Context::default().run_ui(input, |ui| show(ui, &mut viewer, &facts, &mut sections, &mut Vec::new()));
        let text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
            Shape::Text(text) => Some(text.galley.text().to_owned()),
            _ => None,
        };
        output.textures_delta.clear();
        output.shapes.iter().filter_map(text).collect()
    }

    #[test]
    fn every_option_has_a_control_or_a_reason() {
        let shown: Vec<String> = Technique::ALL.into_iter().flat_map(texts).collect();
        let own = |name: &str| OWN.iter().find(|(known, _)| *known == name).map(|(_, text)| (*text).to_owned());
        for option in SceneOption::all() {
            let name = option.spec.name;
            let text = match option.spec.panel {
                Panel::Control => Some(option.spec.label()),
                Panel::Own => own(name),
                Panel::Without(reason) => {
                    assert!(!reason.is_empty() && own(name).is_none(), "--{name}");
                    continue;
                }
            };
            assert!(text.is_some_and(|text| shown.contains(&text)), "the panel has no control for --{name}: {shown:?}");
        }
    }
}
