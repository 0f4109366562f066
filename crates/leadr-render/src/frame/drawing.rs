//! Decides what a frame draws and how it draws it. The decision depends only on the frame's state and settings.

use super::surfaces::SurfaceDrawing;
use crate::light::environment::Environment;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::shade::{Edges, LightSet, ShadeKind};
use crate::scene::FrameState;
use crate::settings::{LodBias, RenderSettings, ShadingOptions, Technique};
use crate::surfaces::material::Bases;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The frame draws the picture.
    Picture,
    /// The frame draws the picture, and always uses the G-buffer.
    GBuffer,
    /// The frame draws the fraction of the light that arrives at each pixel, instead of radiance.
    Light,
    /// The frame draws only the geometry, as triangle edges.
    Wires,
}

/// The shading features that the surfaces of a frame require.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demands {
    /// Whether bumps occlude the environment.
    pub relief: bool,
    /// Whether any surface casts shadows.
    pub casters: bool,
    /// The base materials of the surfaces.
    pub bases: Bases,
}

/// Returns the shading of the pixels. Relief occlusion is off if no surface has relief. Shadow
/// maps and sky occlusion are off if nothing casts shadows.
pub(super) fn shade_kind(
    state: &FrameState,
    settings: &RenderSettings,
    environment: &Environment,
    demands: Demands,
) -> ShadeKind {
    let Demands { relief, casters, bases } = demands;
    let needed = |options: ShadingOptions| ShadingOptions {
        relief_occlusion: options.relief_occlusion && relief,
        sky_occlusion: options.sky_occlusion && casters && settings.shadows,
        // The records of the views hold the bias, so it needs no other pipelines.
        lod_bias: LodBias::default(),
        ..options
    };
    let has_layers = settings.shading.technique().integrates() && !settings.shadows_of_relief();
    ShadeKind {
        shading: settings.shading.plain().adjusted(needed),
        lights: LightSet::new(state, environment, settings.shadows && casters),
        edges: if settings.edges().is_some() { Edges::Joined } else { Edges::None },
        bases: Bases {
            // A GGX base replaces the lobes of measured materials by one. The other techniques use only their roughness.
            fit_lobes: match settings.shading.technique() {
                Technique::LeadrGgx => bases.fit_lobes.min(1),
                technique if technique.has_base_frame() => bases.fit_lobes,
                _ => 0,
            },
            classes: if settings.shading.has_classes() { bases.classes } else { 1 },
            // The other techniques have no lobes for coats and refraction.
            coat: bases.coat && has_layers,
            transmits: bases.transmits && has_layers,
            ..bases
        },
        light_visibility: false,
    }
}

/// Returns how surfaces are drawn for this shading, and the adjusted settings. Multisampling is only possible if the filter pass
/// also shades.
pub(super) fn drawing(settings: RenderSettings, kind: ShadeKind, purpose: Purpose) -> (RenderSettings, SurfaceDrawing) {
    let filter = match kind {
        // Edge samples are joined in the G-buffer, and the reference has its own shading pass.
        ShadeKind { edges: Edges::None, .. }
            if purpose != Purpose::GBuffer
                && !settings.shadows_of_relief()
                && !settings.shading.needs().is_finest() =>
        {
            FilterInto::Radiance(kind)
        }
        _ => FilterInto::GBuffer,
    };
    // The G-buffer has room for only one surface per pixel.
    let msaa = if filter == FilterInto::GBuffer { 1 } else { settings.msaa };
    let settings = RenderSettings { msaa, ..settings };
    let drawing = SurfaceDrawing {
        shadow_maps: kind.lights.shadow_maps(),
        sun_maps: kind.lights.sun_maps(),
        geometry: match purpose {
            Purpose::Wires => GeometryKind::Wires,
            _ => GeometryKind::of(settings.pixel_samples()),
        },
        edges: settings.edges().is_some(),
        filter,
        by_class: (filter == FilterInto::GBuffer && !settings.shadows_of_relief() && kind.bases.classes > 1)
            .then_some(kind),
    };
    (settings, drawing)
}
