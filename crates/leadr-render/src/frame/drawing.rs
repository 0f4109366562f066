//! What a frame draws, and how. It depends on the frame's state and settings alone.

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
    /// The fractions of light that arrive, instead of radiance.
    Light,
    /// Geometry only, as triangle edges.
    Wires,
}

/// What the surfaces require from a frame's shading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demands {
    /// Bumps occlude the environment.
    pub relief: bool,
    /// Something casts shadows.
    pub casters: bool,
    /// Bases of the surfaces.
    pub bases: Bases,
    /// Some colours follow the relief.
    pub relief_color: bool,
}

/// The shading of the pixels. It omits relief occlusion and relief colours if no surface has them, and shadow maps and sky
/// occlusion if nothing casts shadows.
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
        // Techniques without a Beckmann base only use the roughness of measured materials.
        bases: if settings.shading.technique().has_base_frame() { bases } else { Bases { fit_lobes: 0, ..bases } },
        light_visibility: false,
    }
}

/// The drawing of surfaces for this shading, with adjusted settings. Multisampling needs a filter pass that also shades.
pub(super) fn drawing(settings: RenderSettings, kind: ShadeKind, purpose: Purpose) -> (RenderSettings, SurfaceDrawing) {
    let filter = match kind {
        // Edge samples are joined in the G-buffer; the reference has its own shading pass.
        ShadeKind { edges: Edges::None, .. }
            if purpose != Purpose::GBuffer
                && !settings.shadows_of_relief()
                && !settings.shading.needs().is_finest() =>
        {
            FilterInto::Radiance(kind)
        }
        _ => FilterInto::GBuffer,
    };
    // The G-buffer has no slots for the other surfaces of a pixel.
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
