//! Cameras and lights.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::extensions::LIGHTS;
use super::json::{Item, Read};
use super::source::Source;
use crate::fault::shown;
use crate::limits::{COORDINATES, MAX_COORDINATE};
use crate::model::{Camera, Light, LightKind, Projection};

/// The smallest field of view of a camera.
const LEAST: f32 = f32::MIN_POSITIVE;

/// The near distance in metres of a perspective camera that has none.
const NEAR: f32 = 0.01;

/// The field of view, 170°, that replaces one of 180° or more, which cannot be projected.
const WIDEST: f32 = PI * 170.0 / 180.0;

pub(super) fn cameras(source: &Source<'_>) -> Read<Vec<Camera>> {
    let read = |item: &Item<'_>| {
        camera(source, item).or_else(|fault| {
            source.log.repair(fault, "it is replaced by a camera of 45°")?;
            let projection = Projection::Perspective { vertical_angle: FRAC_PI_4, aspect: None };
            Ok(Camera { name: item.name()?, projection, near: NEAR, far: None })
        })
    };
    source.root.items("cameras", "camera")?.iter().map(read).collect()
}

fn camera(source: &Source<'_>, item: &Item<'_>) -> Read<Camera> {
    let log = source.log;
    let kind = item.required("type", Item::string)?;
    let other = match kind {
        "perspective" => "orthographic",
        "orthographic" => "perspective",
        other => return Err(item.fault(format!("`type` {} is unknown", shown(other)))),
    };
    if item.has(other) {
        log.repair(item.fault(format!("is {kind} but also has `{other}`")), "its type decides")?;
    }
    let positive = |lens: &Item<'_>, key: &str| -> Read<Option<f32>> {
        let number = lens.number(key, 0.0..=f32::MAX)?;
        if number == Some(0.0) {
            log.repair(lens.fault(format!("`{key}` must not be 0")), "it is replaced")?;
        }
        Ok(number.filter(|&number| number > 0.0))
    };
    let (projection, near, mut far) = if kind == "perspective" {
        let lens = item.required("perspective", Item::item)?;
        let mut vertical_angle = lens.required("yfov", |lens, key| lens.number(key, LEAST..=MAX_COORDINATE))?;
        if vertical_angle >= PI {
            log.remark(format!("{}: `yfov` is {vertical_angle}, which is not below π; it was narrowed", lens.location));
            vertical_angle = WIDEST;
        }
        let aspect = positive(&lens, "aspectRatio")?;
        let near = positive(&lens, "znear")?.unwrap_or(NEAR).min(MAX_COORDINATE);
        (Projection::Perspective { vertical_angle, aspect }, near, positive(&lens, "zfar")?)
    } else {
        let lens = item.required("orthographic", Item::item)?;
        let size = |key| -> Read<f32> {
            let size = lens.required(key, |lens, key| lens.number(key, COORDINATES))?;
            if size == 0.0 { Err(lens.fault(format!("`{key}` must not be 0"))) } else { Ok(size) }
        };
        let near = lens.number("znear", 0.0..=MAX_COORDINATE)?.unwrap_or(0.0);
        let far = positive(&lens, "zfar")?;
        (Projection::Orthographic { half_width: size("xmag")?, half_height: size("ymag")? }, near, far)
    };
    if far.is_some_and(|far| far <= near) {
        let fault = item.fault(format!("`zfar` must be above `znear`, which is {near}"));
        log.repair(fault, "it sees any distance")?;
        far = None;
    }
    Ok(Camera { name: item.name()?, projection, near, far })
}

pub(super) fn lights(source: &Source<'_>) -> Read<Vec<Light>> {
    let read = |item: &Item<'_>| {
        light(source, item).or_else(|fault| {
            source.log.repair(fault, "it is not lit")?;
            let kind = LightKind::Point;
            Ok(Light { name: item.name()?, color: [0.0; 3], intensity: 0.0, kind, range: None })
        })
    };
    match source.root.extension(LIGHTS)? {
        Some(extension) => extension.items("lights", "light")?.iter().map(read).collect(),
        None => Ok(Vec::new()),
    }
}

fn light(source: &Source<'_>, item: &Item<'_>) -> Read<Light> {
    let kind = match item.required("type", Item::string)? {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        "spot" => spot(source, item)?,
        other => return Err(item.fault(format!("`type` {} is unknown", shown(other)))),
    };
    let range = item.number("range", 0.0..=f32::MAX)?;
    if range == Some(0.0) {
        source.log.repair(item.fault("`range` must be above 0"), "it shines at any distance")?;
    }
    Ok(Light {
        name: item.name()?,
        color: item.vector("color", 0.0..=MAX_COORDINATE)?.unwrap_or([1.0; 3]),
        intensity: item.number("intensity", 0.0..=MAX_COORDINATE)?.unwrap_or(1.0),
        kind,
        range: range.filter(|&range| range > 0.0),
    })
}

fn spot(source: &Source<'_>, item: &Item<'_>) -> Read<LightKind> {
    let (mut inner_angle, mut outer_angle) = (0.0, FRAC_PI_4);
    if let Some(spot) = item.item("spot")? {
        // Other programs may round π/2 to slightly more than our constant.
        inner_angle = spot.number("innerConeAngle", 0.0..=FRAC_PI_2 + 1e-5)?.unwrap_or(0.0);
        outer_angle = spot.number("outerConeAngle", 1e-4..=FRAC_PI_2 + 1e-5)?.unwrap_or(FRAC_PI_4).min(FRAC_PI_2);
        if inner_angle >= outer_angle {
            let what = format!("`innerConeAngle` {inner_angle} must be below `outerConeAngle` {outer_angle}");
            source.log.repair(spot.fault(what), "its edge is sharp")?;
            inner_angle = outer_angle * 0.999;
        }
    }
    Ok(LightKind::Spot { inner_angle, outer_angle })
}
