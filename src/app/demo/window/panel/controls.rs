//! The controls of the panel.

use std::collections::BTreeMap;

use egui::{ComboBox, Slider, SliderClamping, Ui};

use super::facts::{Facts, Request};
use crate::app::demo::window::choices::{Compare, DisplayMode};
use crate::app::demo::window::keys;
use crate::app::demo::window::show::OfSurfaces;
use crate::app::demo::window::viewer::{Action, Viewer};
use leadr_render::settings::{self, Panel, Probes, Quadrature, Technique, Terms, Value, headings};
use leadr_scenes::config::Picture;
use leadr_scenes::light::SunDirection;
use leadr_scenes::options::{SceneOption, Sets};

/// The initial length of the timeline, and the step by which it grows, in seconds.
const TIMELINE: f64 = 30.0;
/// Decimals of the time in seconds and of the sun's angles in degrees.
const TIME_DECIMALS: usize = 2;
const SUN_DECIMALS: usize = 1;
/// Width of a slider without its number and label, points.
const SLIDER: f32 = 72.0;
/// Maximum height of a list without scrolling, points.
const LIST: f32 = 400.0;

/// Whether a section is open, by title, for each section that the user has opened or closed.
pub type Sections = BTreeMap<String, bool>;

/// Shows all controls. The most important controls come first.
pub fn show(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>, sections: &mut Sections, requests: &mut Vec<Request>) {
    ui.add_space(6.0);
    ui.spacing_mut().slider_width = SLIDER;
    scene(ui, facts, requests);
    section(ui, "Technique", true, sections, |ui| technique(ui, viewer, facts));
    section(ui, "Side by side", true, sections, |ui| compare(ui, viewer));
    section(ui, "Camera and time", true, sections, |ui| view(ui, viewer, requests));
    section(ui, "Light", true, sections, |ui| light(ui, viewer, facts));
    section(ui, "Surface and picture", false, sections, |ui| picture(ui, viewer, facts, requests));
}

/// Shows those options under a heading that the scene and the technique support.
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

/// Shows a control, with a tooltip over all its parts.
fn tipped<R>(ui: &mut Ui, tip: impl Into<egui::WidgetText>, control: impl FnOnce(&mut Ui) -> R) -> R {
    let shown = ui.scope(control);
    // Something that only senses hovering must lie over widgets that sense clicks, not below.
    let over = ui.interact(shown.response.rect, shown.response.id.with("tip"), egui::Sense::hover());
    over.on_hover_text(tip);
    shown.inner
}

/// Returns the help of an option, the tooltip of its control.
fn help(option: &str) -> String {
    SceneOption::find(option).map(SceneOption::help).unwrap_or_default()
}

/// Shows the control of an option.
fn control<C: Copy>(ui: &mut Ui, option: &SceneOption, value: &Value<C>, config: &mut C) {
    let label = option.spec.label();
    tipped(ui, option.help(), |ui| match value {
        Value::Switch(at) => _ = ui.checkbox(at(config), label),
        Value::Flag(at, given) => {
            let mut on = *at(config) == *given;
            ui.checkbox(&mut on, label);
            *at(config) = on == *given;
        }
        Value::Number(at, _, slider) => {
            let [least, most] = slider.ends;
            let number = at(config);
            if ui.add(shown_as(Slider::new(number, least..=most), slider).text(label)).changed() {
                *number = rounded(*number, slider.decimals);
            }
        }
        Value::Count(at, _, slider) => {
            let [least, most] = slider.ends.map(|end| end as u32);
            ui.add(shown_as(Slider::new(at(config), least..=most), slider).text(label));
        }
        Value::Name(at) => {
            let chosen = at(config);
            named(ui, &label, chosen.name(), |ui| {
                for (name, help) in chosen.names() {
                    if ui.selectable_label(name == chosen.name(), name).on_hover_text(help).clicked() {
                        // The list contains only valid names, so the result is ignored.
                        _ = chosen.choose(name);
                    }
                }
            });
        }
        // Options with a special format have separate controls.
        Value::Text(_) => (),
    });
}

/// Rounds a number that the user has set to the step that its control displays.
pub fn rounded(number: f32, decimals: usize) -> f32 {
    let step = 10f64.powi(decimals as i32);
    ((f64::from(number) * step).round() / step) as f32
}

/// Creates a slider. A value outside its range is kept until the slider is dragged.
fn shown_as<'a>(slider: Slider<'a>, spec: &settings::Slider) -> Slider<'a> {
    let slider = slider.clamping(SliderClamping::Edits).logarithmic(spec.ends[0] > 0.0);
    slider.suffix(spec.unit).custom_formatter(shown(spec.decimals))
}

/// Formats a number with this number of decimals. `fixed_decimals` of a slider would also round the value.
fn shown(decimals: usize) -> impl Fn(f64, std::ops::RangeInclusive<usize>) -> String {
    move |value, _| format!("{value:.decimals$}")
}

/// Shows a collapsible section as the user left it, open or closed.
pub fn section(ui: &mut Ui, title: &str, open: bool, sections: &mut Sections, contents: impl FnOnce(&mut Ui)) {
    let was = sections.get(title).copied().unwrap_or(open);
    let header = egui::CollapsingHeader::new(title).default_open(was).show(ui, contents).header_response;
    // The opening animation takes several frames, so the click sets the state.
    if header.on_hover_text("Show or hide these controls").clicked() {
        sections.insert(title.to_owned(), !was);
    }
}

fn scene(ui: &mut Ui, facts: &Facts<'_>, requests: &mut Vec<Request>) {
    if !facts.scenes.is_empty() {
        tipped(ui, help("scene"), |ui| {
            named(ui, "scene", facts.scene, |ui| {
                for name in facts.scenes {
                    if ui.selectable_label(name == facts.scene, name).clicked() {
                        requests.push(Request::Open(name.into()));
                    }
                }
            });
        });
    }
    if !facts.animations.is_empty() {
        let shown = facts.animations.get(facts.animation).map_or("", String::as_str);
        tipped(ui, help("animation"), |ui| {
            named(ui, "animation", shown, |ui| {
                for (number, name) in facts.animations.iter().enumerate() {
                    if ui.selectable_label(number == facts.animation, name).clicked() {
                        requests.push(Request::Animation(name.clone()));
                    }
                }
            });
        });
    }
    let shown = facts.environments.get(facts.environment).map_or("", String::as_str);
    tipped(ui, help("environment"), |ui| {
        named(ui, "environment", shown, |ui| {
            for (number, name) in facts.environments.iter().enumerate() {
                if ui.selectable_label(number == facts.environment, name).clicked() {
                    requests.push(Request::Environment(number));
                }
            }
        });
    });
    action(ui, "open a file", Action::Open, requests);
}

/// Shows the button of an action, with the help of its key.
fn action(ui: &mut Ui, name: &str, action: Action, requests: &mut Vec<Request>) {
    if ui.button(name).on_hover_text(keys::tip(action)).clicked() {
        requests.push(Request::Act(action));
    }
}

/// Shows a drop-down list with a label on the left.
fn named(ui: &mut Ui, name: &str, shown: &str, list: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.label(name);
        ComboBox::from_id_salt(name)
            .selected_text(shown)
            .width(ui.available_width() - 8.0)
            .truncate()
            .height(LIST)
            .show_ui(ui, list);
    });
}

fn techniques(ui: &mut Ui, name: &str, chosen: &mut Technique) {
    let tip = format!("{}\n\n{}: {}", help("technique"), chosen.name(), chosen.help());
    tipped(ui, tip, |ui| {
        named(ui, name, chosen.name(), |ui| {
            for technique in Technique::ALL {
                ui.selectable_value(chosen, technique, technique.name()).on_hover_text(format!(
                    "{} ({})",
                    technique.help(),
                    technique.key()
                ));
            }
        });
    });
}

/// The terms of the light in a user's words.
const TERMS: [(Terms, &str); 4] = [
    (Terms::SPECULAR_LIGHTS, "shine of sun and lamps"),
    (Terms::DIFFUSE_LIGHTS, "matte light of sun and lamps"),
    (Terms::SPECULAR_ENVIRONMENT, "shine of the surroundings"),
    (Terms::DIFFUSE_ENVIRONMENT, "matte light of the surroundings"),
];

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
        let tip = ["rule", "grid", "probes"].map(|option| format!("--{option}: {}", help(option))).join("\n\n");
        tipped(ui, tip, |ui| {
            named(ui, "light samples", &label(*chosen), |ui| {
                for rule in rules {
                    ui.selectable_value(chosen, rule, label(rule));
                }
            });
        });
    }
    options(ui, headings::SHADING, picture, facts);
    if picture.technique.is_lit() {
        let terms = &mut picture.options.terms;
        for (term, name) in TERMS {
            let mut on = terms.contains(term);
            if ui.checkbox(&mut on, name).on_hover_text(help("terms")).changed() {
                *terms = if on { *terms | term } else { terms.without(term) };
            }
        }
    }
}

fn compare(ui: &mut Ui, viewer: &mut Viewer) {
    let mut on = viewer.choices.compare.is_some();
    if ui.checkbox(&mut on, "two techniques").on_hover_text(keys::tip(Action::Compare)).changed() {
        viewer.act(Action::Compare);
    }
    if let Some(Compare { technique, difference, .. }) = &mut viewer.choices.compare {
        techniques(ui, "right", technique);
        ui.checkbox(difference, "difference when still").on_hover_text(
            "Show the visible difference (FLIP) of both sides. With the reference (256 samples) on the right, it is the error of the left side",
        );
        ui.weak("Drag the line in the picture.");
    }
}

/// The views of a scene, with their tooltips.
const VIEWS: [(&str, &str); 3] =
    [("near", "Look from close by"), ("mid", "Look at the whole scene"), ("far", "Look from far away")];

fn view(ui: &mut Ui, viewer: &mut Viewer, requests: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        for (number, (name, tip)) in VIEWS.into_iter().enumerate() {
            if ui.button(name).on_hover_text(tip).clicked() {
                requests.push(Request::View(number));
            }
        }
        let label = if viewer.sweep_progress().is_some() { "stop" } else { "zoom out" };
        let button = ui.add_enabled(viewer.sweep.is_some(), egui::Button::new(label));
        if button.on_hover_text(keys::tip(Action::Sweep)).clicked() {
            viewer.act(Action::Sweep);
        }
    });
    ui.horizontal(|ui| {
        ui.selectable_value(&mut viewer.fly, false, "orbit").on_hover_text("Orbit around the target (left drag)");
        ui.selectable_value(&mut viewer.fly, true, "fly").on_hover_text(keys::tip(Action::Fly));
        ui.weak(format!("{:.1} m", viewer.orbit.distance())).on_hover_text("Distance to the target");
    });
    ui.horizontal(|ui| {
        let pause = ui.button(if viewer.paused { "play" } else { "pause" });
        if pause.on_hover_text(keys::tip(Action::Pause)).clicked() {
            viewer.act(Action::Pause);
        }
        let end = TIMELINE * (viewer.time / TIMELINE).floor() + TIMELINE;
        let mut time = viewer.time;
        ui.spacing_mut().slider_width = 96.0;
        let slider = Slider::new(&mut time, 0.0..=end).suffix(" s").custom_formatter(shown(TIME_DECIMALS));
        if tipped(ui, "Time of the animation", |ui| ui.add(slider)).changed() {
            viewer.time = f64::from(rounded(time as f32, TIME_DECIMALS));
        }
    });
}

fn light(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>) {
    if let Some([azimuth, elevation]) = facts.sun {
        let mut sun = SunDirection { azimuth, elevation };
        let mut degrees = |value: &mut f32, ends, name| {
            let slider = Slider::new(value, ends).suffix("°").custom_formatter(shown(SUN_DECIMALS)).text(name);
            let changed = tipped(ui, help("sun"), |ui| ui.add(slider)).changed();
            if changed {
                *value = rounded(*value, SUN_DECIMALS);
            }
            changed
        };
        let azimuth_changed = degrees(&mut sun.azimuth, -180.0..=180.0, "sun direction");
        let raised = degrees(&mut sun.elevation, -12.0..=90.0, "sun height");
        if azimuth_changed || raised {
            viewer.put_sun(sun);
        }
        ui.horizontal(|ui| {
            if ui.button("scene's sun").on_hover_text("Return to the scene's own sun").clicked() {
                viewer.choices.sun = None;
            }
            if ui.button("animate sun").on_hover_text(keys::tip(Action::SunPace)).clicked() {
                viewer.act(Action::SunPace);
            }
        });
    }
    options(ui, headings::LIGHT, &mut viewer.choices.picture, facts);
}

/// Shows the roughness of displaced surfaces. A change applies when the slider is released, because it rebuilds the maps of the surfaces.
fn roughness(ui: &mut Ui, roughness: &OfSurfaces<f32>, requests: &mut Vec<Request>) {
    let chosen = match *roughness {
        OfSurfaces::Fixed => return,
        OfSurfaces::Own => None,
        OfSurfaces::Chosen(alpha) => Some(alpha),
    };
    let held = ui.id().with("roughness");
    let mut alpha = ui.data(|data| data.get_temp(held)).or(chosen).unwrap_or(0.3);
    ui.horizontal(|ui| {
        let slider = Slider::new(&mut alpha, 0.02..=1.0).custom_formatter(shown(2)).text("roughness");
        let tip = format!("{}. Applied when you release the slider", help("roughness"));
        let slider = tipped(ui, tip, |ui| ui.add(slider));
        if slider.is_pointer_button_down_on() && !slider.drag_stopped() {
            ui.data_mut(|data| data.insert_temp(held, alpha));
        } else if slider.drag_stopped() || slider.changed() {
            ui.data_mut(|data| data.remove::<f32>(held));
            requests.push(Request::Roughness(Some(rounded(alpha, 3))));
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
    tipped(ui, "The picture, or values of its pixels in false colours", |ui| {
        named(ui, "show", name, |ui| {
            for (mode, name) in DisplayMode::all() {
                ui.selectable_value(&mut choices.display_mode, mode, name);
            }
        });
    });
}

/// Shows the buttons at the end of the panel.
pub fn buttons(ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        for (name, does) in [
            ("screenshot", Action::Screenshot),
            ("copy as command", Action::CopyCommand),
            ("reset", Action::Reset),
            ("help", Action::Help),
            ("hide", Action::Panel),
        ] {
            action(ui, name, does, requests);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::demo::orbit::Orbit;
    use crate::app::demo::window::choices::Choices;
    use crate::app::demo::window::panel::set_style;
    use egui::{Pos2, RawInput, Rect, Shape, Vec2};
    use leadr_scenes::view::CameraPose;

    /// Options with special controls, each with a text of its control.
    const OWN: [(&str, &str); 16] = [
        ("scene", "scene"),
        ("animation", "animation"),
        ("environment", "environment"),
        ("technique", "technique"),
        ("rule", "light samples"),
        ("grid", "light samples"),
        ("probes", "light samples"),
        ("terms", "shine of sun and lamps"),
        ("camera", "orbit"),
        ("distance", "zoom out"),
        ("sun", "sun direction"),
        ("time-of-day", "animate sun"),
        ("day-length", "animate sun"),
        ("material", "material: drop one here"),
        ("measured", "material: drop one here"),
        ("roughness", "roughness"),
    ];

    /// A panel with all controls for a technique.
    struct Shown {
        context: egui::Context,
        viewer: Viewer,
        sections: Sections,
    }

    impl Shown {
        fn new(technique: Technique) -> Self {
            let pose = CameraPose { position: [1.0; 3], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_degrees: 35.0 };
            let choices = Choices::new(Picture { technique, ..Picture::default() });
            let mut viewer = Viewer::new(Orbit::new(&pose), 0.0, choices, None);
            viewer.act(Action::Compare);
            let sections = Sections::from([("Surface and picture".to_owned(), true)]);
            let context = egui::Context::default();
            set_style(&context);
            context.all_styles_mut(|style| style.interaction.tooltip_delay = 0.0);
            Self { context, viewer, sections }
        }

        /// Lays the panel out, with the pointer at a position.
        fn frame(&mut self, time: f64, pointer: Option<Pos2>) -> egui::FullOutput {
            let facts = Facts {
                scenes: &["plane".to_owned()],
                scene: "plane",
                animations: &["walk".to_owned()],
                animation: 0,
                environments: &["sky".to_owned()],
                environment: 0,
                sun: Some([0.0, 45.0]),
                roughness: OfSurfaces::Chosen(0.5),
                applied_material: OfSurfaces::Own,
                offers: &|_| true,
                device: "",
                fps: None,
                passes: &[],
                samples: (1, 1),
                pixels: (1, 1),
                triangles: (0, 0),
            };
            let screen = Rect::from_min_size(Pos2::ZERO, Vec2::new(400.0, 4000.0));
            let events = pointer.map(egui::Event::PointerMoved).into_iter().collect();
            let input = RawInput { screen_rect: Some(screen), time: Some(time), events, ..RawInput::default() };
            let Self { context, viewer, sections } = self;
            let mut output = context.clone().run_ui(input, |ui| {
                show(ui, viewer, &facts, sections, &mut Vec::new());
                buttons(ui, &mut Vec::new());
            });
            output.textures_delta.clear();
            output
        }
    }

    /// Returns the texts of the panel for a technique.
    fn texts(technique: Technique) -> Vec<String> {
        let text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
            Shape::Text(text) => Some(text.galley.text().to_owned()),
            _ => None,
        };
        Shown::new(technique).frame(0.0, None).shapes.iter().filter_map(text).collect()
    }

    #[test]
    fn every_control_has_a_tooltip() {
        for technique in [Technique::Leadr, Technique::Reference, Technique::NormalMip] {
            let mut shown = Shown::new(technique);
            (0..3).for_each(|i| _ = shown.frame(f64::from(i), None));
            let widgets: Vec<(egui::Id, Pos2)> = shown.context.viewport(|viewport| {
                let of = |widget: &egui::WidgetRect| (widget.id, widget.interact_rect.center());
                let interactive = |widget: &&egui::WidgetRect| widget.sense.interactive() && widget.enabled;
                viewport
                    .prev_pass
                    .widgets
                    .layers()
                    .flat_map(|(_, of_layer)| of_layer)
                    .filter(interactive)
                    .map(of)
                    .collect()
            });
            assert!(widgets.len() > 20, "{technique:?}: {}", widgets.len());
            for (number, (id, at)) in widgets.into_iter().enumerate() {
                let time = 10.0 + 10.0 * number as f64;
                (0..4).for_each(|i| _ = shown.frame(time + f64::from(i), Some(at)));
                let has_tip = shown.context.memory(|memory| {
                    memory.areas().visible_layer_ids().iter().any(|layer| layer.order == egui::Order::Tooltip)
                });
                assert!(has_tip, "{technique:?}: the control {id:?} at {at} has no tooltip");
            }
        }
    }

    #[test]
    fn numbers_are_rounded_to_the_step_of_their_control() {
        for option in SceneOption::all() {
            let (Sets::Picture(Value::Number(.., slider)), true) = (&option.sets, option.spec.panel == Panel::Control)
            else {
                continue;
            };
            let [least, most] = slider.ends;
            for step in 0..=97 {
                let number = least + (most - least) * step as f32 / 97.0;
                let text = rounded(number, slider.decimals).to_string();
                let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
                assert!(decimals <= slider.decimals, "--{}: {text}", option.spec.name);
            }
        }
        assert_eq!(rounded(-49.999_996, SUN_DECIMALS), -50.0);
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
