//! What can be chosen.

use std::collections::BTreeMap;

use egui::{ComboBox, Slider, Ui};

use super::facts::{Facts, Request};
use crate::app::demo::window::choices::{Compare, Look};
use crate::app::demo::window::show::{Roughness, Worn};
use crate::app::demo::window::viewer::{Action, Viewer};
use leadr_maps::tonemap::Tonemap;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{Probes, Quadrature, Technique, Terms};
use leadr_scenes::deform::FACTORS;
use leadr_scenes::light::SunDirection;

/// Seconds on the timeline; it grows as time goes on.
const TIMELINE: f64 = 30.0;
/// Points down a list that is shown whole.
const LIST: f32 = 400.0;

/// Which sections are open, by their titles, where the user has ever told.
pub type Sections = BTreeMap<String, bool>;

/// All choices, in the order in which they matter.
pub fn show(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>, sections: &mut Sections, requests: &mut Vec<Request>) {
    ui.add_space(6.0);
    scene(ui, facts, requests);
    section(ui, "Technique", true, sections, |ui| technique(ui, viewer));
    section(ui, "Side by side", true, sections, |ui| compare(ui, viewer));
    section(ui, "Camera and time", true, sections, |ui| view(ui, viewer, requests));
    section(ui, "Light", true, sections, |ui| light(ui, viewer, facts));
    section(ui, "Surface and picture", false, sections, |ui| picture(ui, viewer, facts, requests));
}

/// Shows so many decimals. A slider with `fixed_decimals` would round the value itself, which changes it.
fn shown(decimals: usize) -> impl Fn(f64, std::ops::RangeInclusive<usize>) -> String {
    move |value, _| format!("{value:.decimals$}")
}

/// A part with a title that opens and closes, as the user last left it.
pub fn section(ui: &mut Ui, title: &str, open: bool, sections: &mut Sections, contents: impl FnOnce(&mut Ui)) {
    let was = sections.get(title).copied().unwrap_or(open);
    let header = egui::CollapsingHeader::new(title).default_open(was).show(ui, contents);
    // Opening takes a few frames.
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
        .on_hover_text("Or drop a .glb or .gltf model on the window");
    }
    let shown = facts.environments.get(facts.environment).map_or("", String::as_str);
    named(ui, "light from", shown, |ui| {
        for (number, name) in facts.environments.iter().enumerate() {
            if ui.selectable_label(number == facts.environment, name).clicked() {
                requests.push(Request::Environment(number));
            }
        }
    })
    .on_hover_text("Or drop a .hdr or .exr panorama on the window (e)");
}

/// A list to choose from with its name on the left.
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

fn technique(ui: &mut Ui, viewer: &mut Viewer) {
    techniques(ui, "drawn by", &mut viewer.choices.technique);
    let technique = viewer.choices.technique;
    let options = &mut viewer.choices.options;
    if technique.integrates() {
        let rules = Probes::ALL.map(Quadrature::VisibleSlopes).into_iter().chain([5, 9, 17].map(Quadrature::Grid));
        let label = |rule: Quadrature| match rule {
            Quadrature::VisibleSlopes(probes) => format!("{} probes", probes.count()),
            Quadrature::Grid(side) => format!("{side} x {side} slopes"),
        };
        named(ui, "integrals", &label(options.quadrature), |ui| {
            for rule in rules {
                ui.selectable_value(&mut options.quadrature, rule, label(rule));
            }
        })
        .on_hover_text(
            "At how many slopes the environment is looked up; the paper's grids, or rules for visible slopes (g)",
        );
        named(ui, "visibility", options.shadowing.name(), |ui| {
            for model in Shadowing::MAIN {
                ui.selectable_value(&mut options.shadowing, model, model.name());
            }
        })
        .on_hover_text("How facets hide each other from viewer and light (v)");
        ui.checkbox(&mut options.relief_occlusion, "bumps hide the surroundings");
    }
    if technique.has_pixel_kernel() {
        ui.checkbox(&mut options.pixel_kernel, "curvature counts as roughness");
    }
    if technique.has_multiscattering() {
        ui.checkbox(&mut options.multiscattering, "facets light each other");
    }
    if technique.is_lit() {
        ui.checkbox(&mut options.sky_occlusion, "large shapes hide the sky");
        ui.horizontal_wrapped(|ui| {
            for (term, name) in Terms::NAMES {
                let mut on = options.terms.contains(term);
                if ui.checkbox(&mut on, name).changed() {
                    options.terms = if on { options.terms | term } else { options.terms.without(term) };
                }
            }
        });
    }
}

fn compare(ui: &mut Ui, viewer: &mut Viewer) {
    let mut on = viewer.choices.compare.is_some();
    if ui.checkbox(&mut on, "a technique on the right (c)").changed() {
        viewer.act(Action::Compare);
    }
    if let Some(Compare { technique, difference, .. }) = &mut viewer.choices.compare {
        techniques(ui, "right", technique);
        ui.checkbox(difference, "difference (FLIP) when still").on_hover_text(
            "Of both sides; beside the reference, which gathers 256 samples, that is the error of the left one",
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
        let button = ui.add_enabled(viewer.has_sweep(), egui::Button::new(label));
        if button.on_hover_text("From near to far and back (o)").clicked() {
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
        let turned = ui
            .add(Slider::new(&mut sun.azimuth, -180.0..=180.0).suffix("°").custom_formatter(shown(0)).text("azimuth"));
        let raised = ui.add(
            Slider::new(&mut sun.elevation, -12.0..=90.0).suffix("°").custom_formatter(shown(0)).text("elevation"),
        );
        if turned.changed() || raised.changed() {
            viewer.put_sun(sun);
        }
        ui.horizontal(|ui| {
            if ui.button("the sun's own way").on_hover_text("Back to where the scene has it").clicked() {
                viewer.choices.sun = None;
            }
            if ui.button("let it run").on_hover_text("t").clicked() {
                viewer.act(Action::SunPace);
            }
        });
    }
    ui.add(
        Slider::new(&mut viewer.choices.exposure, -4.0..=4.0).suffix(" EV").custom_formatter(shown(1)).text("exposure"),
    );
}

/// The roughness of displaced surfaces. Their maps are made again for it, so only when the slider is let go.
fn roughness(ui: &mut Ui, roughness: Roughness, requests: &mut Vec<Request>) {
    let chosen = match roughness {
        Roughness::Fixed => return,
        Roughness::Own => None,
        Roughness::Chosen(alpha) => Some(alpha),
    };
    let held = ui.id().with("roughness");
    let mut alpha = ui.data(|data| data.get_temp(held)).or(chosen).unwrap_or(0.3);
    ui.horizontal(|ui| {
        let slider = ui.add(Slider::new(&mut alpha, 0.02..=1.0).custom_formatter(shown(2)).text("roughness"));
        let slider = slider.on_hover_text("Beckmann alpha of displaced surfaces, which are made again when you let go");
        if slider.is_pointer_button_down_on() && !slider.drag_stopped() {
            ui.data_mut(|data| data.insert_temp(held, alpha));
        } else if slider.drag_stopped() || slider.changed() {
            ui.data_mut(|data| data.remove::<f32>(held));
            requests.push(Request::Roughness(Some((alpha * 1000.0).round() / 1000.0)));
        }
        if chosen.is_some() && ui.small_button("own").on_hover_text("The scene's own roughness").clicked() {
            requests.push(Request::Roughness(None));
        }
    });
}

/// What displaced surfaces are made of.
fn material(ui: &mut Ui, worn: &Worn, requests: &mut Vec<Request>) {
    const HINT: &str = "Drop a measured material (FIT.json of leadr fit) on the window, or for the plane and the sphere a folder of maps";
    match worn {
        Worn::Fixed => (),
        Worn::Own => _ = ui.weak("material: drop one here").on_hover_text(HINT),
        Worn::Chosen(name) => {
            _ = ui.horizontal(|ui| {
                ui.label(format!("material: {name}")).on_hover_text(HINT);
                if ui.small_button("own").on_hover_text("The scene's own material").clicked() {
                    requests.push(Request::OwnMaterial);
                }
            })
        }
    }
}

fn picture(ui: &mut Ui, viewer: &mut Viewer, facts: &Facts<'_>, requests: &mut Vec<Request>) {
    material(ui, &facts.worn, requests);
    roughness(ui, facts.roughness, requests);
    let choices = &mut viewer.choices;
    ui.add(Slider::new(&mut choices.height_scale, 0.0..=3.0).custom_formatter(shown(2)).text("x heights"));
    if facts.stretches {
        let slider = Slider::new(&mut choices.stretch, FACTORS).logarithmic(true).custom_formatter(shown(2));
        ui.add(slider.text("stretch")).on_hover_text("Wider along x and lower along z; the maps stay as they are");
    }
    ui.add(Slider::new(&mut choices.triangle_pixels, 1.0..=32.0).logarithmic(true).text("px/triangle"));
    ui.add(Slider::new(&mut choices.samples, 1..=64).logarithmic(true).text("samples"))
        .on_hover_text("Of a picture that stands still");
    named(ui, "tone curve", choices.tonemap.name(), |ui| {
        for tonemap in Tonemap::ALL {
            ui.selectable_value(&mut choices.tonemap, tonemap, tonemap.name()).on_hover_text(tonemap.help());
        }
    });
    let name = Look::all().find(|(look, _)| *look == choices.look).map_or("", |(_, name)| name);
    named(ui, "show", name, |ui| {
        for (look, name) in Look::all() {
            ui.selectable_value(&mut choices.look, look, name);
        }
    });
}

/// What else can be done.
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
