//! EXR reader for baked maps with all mip levels. Each map channel is an EXR channel, and each key is a text in the header.

use exr::meta::attribute::{AttributeValue, SampleType};

use super::keys::{Keys, names};
use super::map::{BakedLevel, BakedMap};
use crate::bake::{Precision, packed};
use crate::{MapFault, exr_read};

pub(super) fn read(bytes: &[u8]) -> Result<BakedMap, MapFault> {
    let header = exr_read::header(bytes)?;
    let texts = &header.own_attributes.other;
    let text = |key: &str| match texts.get(&exr::prelude::Text::from(key)) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    };
    let keys = [
        "channels",
        "class_centers",
        "class_openness",
        "class_units",
        "dropped_levels",
        "factors",
        "height_scale",
        "heights",
        "kind",
        "middle",
        "slopes",
        "wrap",
    ];
    let texts = keys.map(|key| format!("leadr.{key}")).map(|key| (text(&key), key));
    let find = |key: &str| texts.iter().find(|(_, name)| name == key).and_then(|(text, _)| text.as_deref());
    let list = &header.channels.list;
    let halves = list.iter().all(|c| c.sample_type == SampleType::F16);
    let mut keys = Keys::new(find, list.len(), if halves { Precision::F16 } else { Precision::F32 })?;
    let channels = keys.map.channels.clone();
    let indices: Option<Vec<usize>> = channels.iter().map(|name| list.iter().position(|c| c.name.eq(name))).collect();
    let indices = indices.ok_or_else(|| MapFault::damaged("its key leadr.channels is invalid"))?;
    let planes = exr_read::decode_levels(bytes, &indices)?;

    let slots = packed(&channels);
    let mut levels = Vec::new();
    for exr_read::Planes { width, height, planes } in planes {
        for (index, plane) in planes.iter().enumerate() {
            if let Some(at) = plane.iter().position(|v| !v.is_finite()) {
                let texel = [at % width as usize, at / width as usize].map(|p| p as u32);
                let what = format!("{} at x = {}, y = {} of {width} x {height}", plane[at], texel[0], texel[1]);
                return Err(MapFault::damaged(format!("channel {} holds {what}", channels[index])));
            }
        }
        let value =
            |slot: Option<usize>, texel: usize| slot.map_or(0.0, |i| unscaled(planes[i][texel], keys.factors[i]));
        let texels = 0..width as usize * height as usize;
        let layers = slots.chunks_exact(4);
        let layers = layers.map(|slots| texels.clone().map(|t| [0, 1, 2, 3].map(|c| value(slots[c], t))).collect());
        levels.push(BakedLevel { width, height, layers: layers.collect() });
    }
    keys.map.channels = names(&channels, &slots);
    Ok(keys.map(levels))
}

fn unscaled(value: f32, factor: f64) -> f32 {
    if factor == 1.0 { value } else { (f64::from(value) / factor) as f32 }
}
