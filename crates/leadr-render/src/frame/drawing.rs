//! What of a scene is drawn for a frame, and how: known from its state and settings alone.

use super::surfaces::SurfaceDrawing;
use crate::light::environment::Environment;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::shade::{Edges, LightSet, ShadeKind};
use crate::scene::FrameState;
use crate::settings::{RenderSettings, ShadingOptions};
use crate::surfaces::material::Bases;

/// What a frame is prepared for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The picture.
    Picture,
    /// The picture by way of the G-buffer, which filter passes fill in any case.
    GBuffer,
    /// Which shares of the light arrive, in place of radiance.
    Light,
    /// Geometry alone, and of that the edges of triangles.
    Wires,
}

/// What surfaces make necessary of a frame's shading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demands {
    /// Bumps hide the surroundings from each other.
    pub relief: bool,
    /// Something casts shadows.
    pub casters: bool,
    /// Bases of the surfaces.
    pub bases: Bases,
    /// Colours follow the relief of a surface.
    pub relief_color: bool,
}

/// How pixels are shaded; without the relief's occlusion and colours, where there are none, and without shadow maps and what large
/// shapes hide of the sky, where nothing casts shadows.
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
        // Other techniques than those of a Beckmann base see its roughness.
        bases: if settings.shading.technique().has_base_frame() { bases } else { Bases { fit_lobes: 0, ..bases } },
        tells_light: false,
    }
}

/// What is drawn of surfaces for frames that are shaded so, and their settings: only what is shaded as it is filtered can be
/// multisampled.
pub(super) fn drawing(settings: RenderSettings, kind: ShadeKind, purpose: Purpose) -> (RenderSettings, SurfaceDrawing) {
    let filter = match kind {
        // Edge samples are joined to what was filtered, and the reference has filter passes of its own.
        ShadeKind { edges: Edges::None, .. }
            if purpose != Purpose::GBuffer
                && !settings.shadows_of_relief()
                && !settings.shading.needs().is_finest() =>
        {
            FilterInto::Radiance(kind)
        }
        _ => FilterInto::GBuffer,
    };
    // The G-buffer has no slots for other surfaces.
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
