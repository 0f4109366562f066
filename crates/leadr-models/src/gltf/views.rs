//! Cameras and lights.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::extensions::LIGHTS;
use super::json::{Item, Read};
use super::source::Source;
use crate::fault::shown;
use crate::limits::{COORDINATES, MAX_COORDINATE};
use crate::model::{Camera, Light, LightKind, Projection};

/// The smallest positive distance or size of a camera.
const LEAST: f32 = f32::MIN_POSITIVE;

/// The field of view, 170°, that replaces one of 180° or more, which cannot be projected.
const WIDEST: f32 = PI * 170.0 / 180.0;

pub(super) fn cameras(source: &Source<'_>) -> Read<Vec<Camera>> {
    source.root.items("cameras", "camera")?.iter().map(|item| camera(source, item)).collect()
}

fn camera(source: &Source<'_>, item: &Item<'_>) -> Read<Camera> {
    let kind = item.required("type", item.string("type")?)?;
    let other = match kind {
        "perspective" => "orthographic",
        "orthographic" => "perspective",
        other => return Err(item.fault(format!("`type` {} is unknown", shown(other)))),
    };
    if item.has(other) {
        return Err(item.fault(format!("is {kind} but also has `{other}`")));
    }
    let (projection, near, far) = if kind == "perspective" {
        let lens = item.required(kind, item.item("perspective")?)?;
        let mut vertical_angle = lens.required("yfov", lens.number("yfov", LEAST..=MAX_COORDINATE)?)?;
        if vertical_angle >= PI {
            source.remark(format!(
                "{}: `yfov` is {vertical_angle}, which is not below π; it was narrowed",
                lens.location
            ));
            vertical_angle = WIDEST;
        }
        let aspect = lens.number("aspectRatio", LEAST..=MAX_COORDINATE)?;
        let near = lens.required("znear", lens.number("znear", LEAST..=MAX_COORDINATE)?)?;
        let far = lens.number("zfar", LEAST..=f32::MAX)?;
        (Projection::Perspective { vertical_angle, aspect }, near, far)
    } else {
        let lens = item.required(kind, item.item("orthographic")?)?;
        let size = |key| -> Read<f32> {
            let size = lens.required(key, lens.number(key, COORDINATES)?)?;
            if size == 0.0 { Err(lens.fault(format!("`{key}` must not be 0"))) } else { Ok(size) }
        };
        let near = lens.required("znear", lens.number("znear", 0.0..=MAX_COORDINATE)?)?;
        let far = lens.required("zfar", lens.number("zfar", LEAST..=f32::MAX)?)?;
        (Projection::Orthographic { half_width: size("xmag")?, half_height: size("ymag")? }, near, Some(far))
    };
    if far.is_some_and(|far| far <= near) {
        return Err(item.fault(format!("`zfar` must be above `znear`, which is {near}")));
    }
    Ok(Camera { name: item.name()?, projection, near, far })
}

pub(super) fn lights(source: &Source<'_>) -> Read<Vec<Light>> {
    match source.root.extension(LIGHTS)? {
        Some(extension) => extension.items("lights", "light")?.iter().map(light).collect(),
        None => Ok(Vec::new()),
    }
}

fn light(item: &Item<'_>) -> Read<Light> {
    let kind = match item.required("type", item.string("type")?)? {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        "spot" => spot(item)?,
        other => return Err(item.fault(format!("`type` {} is unknown", shown(other)))),
    };
    Ok(Light {
        name: item.name()?,
        color: item.vector("color", 0.0..=MAX_COORDINATE)?.unwrap_or([1.0; 3]),
        intensity: item.number("intensity", 0.0..=MAX_COORDINATE)?.unwrap_or(1.0),
        kind,
        range: item.number("range", LEAST..=f32::MAX)?,
    })
}

fn spot(item: &Item<'_>) -> Read<LightKind> {
    let (mut inner_angle, mut outer_angle) = (0.0, FRAC_PI_4);
    if let Some(spot) = item.item("spot")? {
        // Other programs may round π/2 to slightly more than our constant.
        inner_angle = spot.number("innerConeAngle", 0.0..=FRAC_PI_2 + 1e-5)?.unwrap_or(0.0);
        outer_angle = spot.number("outerConeAngle", 0.0..=FRAC_PI_2 + 1e-5)?.unwrap_or(FRAC_PI_4).min(FRAC_PI_2);
        if inner_angle >= outer_angle {
            return Err(
                spot.fault(format!("`innerConeAngle` {inner_angle} must be below `outerConeAngle` {outer_angle}"))
            );
        }
    }
    Ok(LightKind::Spot { inner_angle, outer_angle })
}
