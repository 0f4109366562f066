//! Class maps and colours as the content of a cache file.
//!
//! Most texels contain few classes, so a texel is a mask of its layers that are not zero, and the values of these layers.

use half::f16;

use super::{ClassColors, ClassLevel, ClassMap};
use crate::cache::{expect_all, put, take};
use crate::pyramid::level_sizes;

type Result<T> = std::result::Result<T, &'static str>;

const ZERO: [f16; 4] = [f16::ZERO; 4];

impl ClassLevel {
    fn put(&self, content: &mut Vec<u8>) {
        let texels = self.width as usize * self.height as usize;
        let mask = |texel: usize| {
            let is_set = |(k, layer): (usize, &Vec<[f16; 4]>)| u8::from(layer[texel] != ZERO) << k;
            self.layers.iter().enumerate().map(is_set).sum::<u8>()
        };
        let masks: Vec<u8> = (0..texels).map(mask).collect();
        put(content, &masks);
        for (k, layer) in self.layers.iter().enumerate() {
            let values = layer.iter().zip(&masks).filter(|(_, mask)| *mask >> k & 1 == 1);
            values.for_each(|(value, _)| put(content, &value.map(f16::to_bits)));
        }
    }

    fn take(content: &mut &[u8], [width, height]: [u32; 2], layers: usize) -> Result<Self> {
        let masks: Vec<u8> = take(content, width as usize * height as usize)?;
        let layer = |k: usize| {
            let is_set = |mask: &u8| mask >> k & 1 == 1;
            let mut values = take::<[u16; 4]>(content, masks.iter().filter(|mask| is_set(mask)).count())?.into_iter();
            let value = |mask: &u8| match is_set(mask) {
                true => values.next().map_or(ZERO, |value| value.map(f16::from_bits)),
                false => ZERO,
            };
            Ok(masks.iter().map(value).collect())
        };
        let layers = (0..layers).map(layer).collect::<Result<Vec<Vec<[f16; 4]>>>>()?;
        layers.iter().try_for_each(|layer| expect_all(layer, |value| value.iter().all(|v| v.is_finite())))?;
        Ok(Self { width, height, layers })
    }

    /// Checks that a channel of some layers is from 0 to 1.
    fn expect_shares<'a>(mut layers: impl Iterator<Item = &'a Vec<[f16; 4]>>, channels: usize) -> Result<()> {
        let is_share = |value: &[f16; 4]| value[..channels].iter().all(|v| (f16::ZERO..=f16::ONE).contains(v));
        layers.try_for_each(|layer| expect_all(layer, is_share))
    }
}

impl ClassMap {
    /// Appends the map to the content of a cache file.
    pub fn put(&self, content: &mut Vec<u8>) {
        put(content, &self.centers);
        put(content, &self.units);
        self.levels.iter().for_each(|level| level.put(content));
    }

    /// Removes a map with `count` classes from the front of a cache file's content.
    ///
    /// # Errors
    /// Fails if the content is too short, or if a value is out of range.
    pub fn take(content: &mut &[u8], size: [u32; 2], count: usize) -> Result<Self> {
        let centers: Vec<[f32; 3]> = take(content, count)?;
        let [units] = take::<[f32; 3]>(content, 1)?[..] else { return Err("it is too short") };
        expect_all(&centers, |center| center.iter().all(|v| v.is_finite()))?;
        expect_all(&units, |unit| unit.is_finite() && *unit > 0.0)?;
        let level = |size| {
            let level = ClassLevel::take(content, size, 2 * count)?;
            ClassLevel::expect_shares(level.layers.iter().step_by(2), 1)?;
            Ok(level)
        };
        Ok(Self { centers, units, levels: level_sizes(size).into_iter().map(level).collect::<Result<_>>()? })
    }
}

impl ClassColors {
    /// Appends the colours to the content of a cache file.
    pub fn put(&self, content: &mut Vec<u8>) {
        self.levels.iter().for_each(|level| level.put(content));
    }

    /// Removes the colours of `count` classes from the front of a cache file's content. `size` and `skipped` are those of
    /// [`new`](Self::new).
    ///
    /// # Errors
    /// Fails if the content is too short, or if a value is out of range.
    pub fn take(content: &mut &[u8], size: [u32; 2], skipped: usize, count: usize) -> Result<Self> {
        let level = |size| {
            let level = ClassLevel::take(content, size, count + 1)?;
            ClassLevel::expect_shares(level.layers.iter(), 4)?;
            Ok(level)
        };
        Ok(Self { levels: level_sizes(size).into_iter().skip(skipped).map(level).collect::<Result<_>>()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::{ClassMaterial, Facets, classes, classes_of_count};
    use crate::{HeightMap, Wrap, procedural};

    #[test]
    fn contents_come_back_and_planted_values_are_refused() {
        let relief: HeightMap = procedural::fbm(37, 23, 3, 4, 3, 0.5);
        let facets = Facets::OfHeights(&relief, Wrap::Repeat);
        let found = classes_of_count(facets, [1.0; 2], 3);
        let texel = |i: usize| [0.5, 0.4, 0.3, if i.is_multiple_of(3) { 0.1 } else { 0.6 }];
        let material = ClassMaterial { size: [16, 24], texel: &texel, follows_relief: false };
        let map = ClassMap::new(facets, &found, None);
        let painted = classes(facets, [1.0; 2], Some(&material));
        let colors = ClassColors::new(facets, &painted, &material, 1).expect("the roughness differs");
        let mut content = Vec::new();
        map.put(&mut content);
        let of_map = content.len();
        let dense: usize = map.levels.iter().map(|level| 8 * 6 * level.layers[0].len()).sum();
        assert!(of_map < dense, "{of_map} of {dense} bytes");
        let read = |mut content: &[u8]| {
            let map = ClassMap::take(&mut content, [37, 23], 3);
            map.and_then(|map| crate::cache::expect_end(content).map(|()| map))
        };
        assert!(read(&content) == Ok(map));
        assert_eq!(read(&content[..of_map - 1]).unwrap_err(), "it is too short");
        let changed = |at: usize, bytes: &[u8]| {
            let mut content = content.clone();
            content[at..at + bytes.len()].copy_from_slice(bytes);
            read(&content).err()
        };
        assert_eq!(changed(0, &f32::NAN.to_le_bytes()), Some("a value is out of range"));
        assert_eq!(changed(36, &(-1f32).to_le_bytes()), Some("a value is out of range"));
        // A set bit moves all later values.
        let mask = content[48];
        assert!(changed(48, &[mask ^ 1]).is_some());
        assert_eq!(changed(of_map - 2, &0x7e00_u16.to_le_bytes()), Some("a value is out of range"));
        let mut content = Vec::new();
        colors.put(&mut content);
        let left = &mut &content[..];
        assert!(ClassColors::take(left, material.size, 1, colors.count()) == Ok(colors));
        assert!(left.is_empty());
    }
}
