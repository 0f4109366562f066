//! The contents and method of a frame's drawing, which depend only on its state and settings.

use super::surfaces::SurfaceDrawing;
use crate::light::environment::Environment;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::shade::{Edges, LightSet, ShadeKind};
use crate::scene::FrameState;
use crate::settings::{RenderSettings, ShadingOptions};
use crate::surfaces::material::Bases;

/// The purpose of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The picture.
    Picture,
    /// The picture, always through the G-buffer.
    GBuffer,
    /// The fractions of the light that arrive at each pixel, instead of radiance.
    Light,
    /// Only the geometry, as triangle edges.
    Wires,
}

/// The shading features that the surfaces of a frame require.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demands {
    /// Whether bumps occlude the environment.
    pub relief: bool,
    /// Whether any surface casts shadows.
    pub casters: bool,
    /// Base materials of the surfaces.
    pub bases: Bases,
    /// Whether any colours follow the relief.
    pub relief_color: bool,
}

/// Returns the shading of the pixels, without relief occlusion and colours if no surface has them, and without shadow maps and sky
/// occlusion if none casts shadows.
pub(super) fn shade_kind(
    state: &FrameState,
    settings: &RenderSettings,
    environment: &Environment,
    demands: Demands,
) -> ShadeKind {
    let Demands { relief, casters, bases, relief_color } = demands;
    let needed = |options: ShadingOptions| ShadingOptions {
        relief_occlusion: options.relief_occlusion && relief,
        relief_color: options.relief_color && relief_color,
        sky_occlusion: options.sky_occlusion && casters && settings.shadows,
        ..options
    };
    ShadeKind {
        shading: settings.shading.plain().adjusted(needed),
        lights: LightSet::new(state, environment, settings.shadows && casters),
        edges: if settings.edges().is_some() { Edges::Joined } else { Edges::None },
        // Techniques without a Beckmann base use only the roughness of measured materials.
        bases: if settings.shading.technique().has_base_frame() { bases } else { Bases { fit_lobes: 0, ..bases } },
        light_visibility: false,
    }
}

/// Returns the drawing of surfaces for this shading, and the adjusted settings. Multisampling needs a filter pass that also shades.
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
    };
    (settings, drawing)
}
