//! Colours and roughness per class, with all mip levels.

use glam::DVec4;
use half::f16;
use leadr_reflectance::masking::classes::MOST_CLASSES;
use rayon::prelude::*;

use super::{ClassLevel, ClassMap, filtered};
use crate::derive::{ClassMaterial, Classes, Facet, Facets, FacetsAt};
use crate::pyramid::Row;

/// The smallest significant change of the mean colour if a class is hidden, relative to the mean of the brightest channel, and of the
/// mean `α²`, relative to it.
const LEAST_CHANGE: [f64; 2] = [0.01, 0.05];
/// The largest number of positions along one axis at which the facets of a texel are found.
const MOST_POSITIONS: u32 = 8;

/// The colours and the roughness of each class, at the texels of a colour map.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassColors {
    /// The mip levels, from the first that is stored. Layer `k` of a level holds `(w r, w g, w b, w α²)`, with the share `w` of class
    /// `k` in the texel, its linear albedo and its Beckmann roughness. The last layer holds the shares of classes 0 to 3.
    pub levels: Vec<ClassLevel>,
}

impl ClassColors {
    /// Creates the colours of classes of these facets and this material, without the `skipped` finest levels. Returns `None` if the
    /// classes have the same colour and roughness.
    pub fn new(facets: Facets<'_>, classes: &Classes, material: &ClassMaterial<'_>, skipped: usize) -> Option<Self> {
        let count = classes.count();
        if count == 1 {
            return None;
        }
        let [width, height] = material.size;
        let of_facets = facets.size(Some(material));
        let positions = |axis: usize| (2 * of_facets[axis]).div_ceil(material.size[axis]).clamp(1, MOST_POSITIONS);
        let (across, down) = (positions(0), positions(1));
        let at = classes.material(Some(material));
        let part = 1.0 / f64::from(across * down);
        let shares_of_row = |y: u32| {
            let mut shares = vec![DVec4::ZERO; width as usize];
            let position = |texel: u32, i: u32, of: u32, side: u32| {
                (f64::from(texel) + (f64::from(i) + 0.5) / f64::from(of)) / f64::from(side)
            };
            for i in 0..down {
                let t = position(y, i, down, height);
                let facets = FacetsAt::new(facets, t);
                for (x, shares) in (0..width).zip(&mut shares) {
                    let material = at.at([(f64::from(x) + 0.5) / f64::from(width), t]);
                    for j in 0..across {
                        facets.for_each(position(x, j, across, width), |weight, facet| {
                            shares[classes.of(&Facet { material, ..facet })] += part * weight;
                        });
                    }
                }
            }
            shares
        };
        Self::of_shares(count, material, skipped, shares_of_row)
    }

    /// Creates the colours of the classes of a map that was read from a file, like [`new`](Self::new). A texel of the colour map has
    /// the shares of the texel of the class map at its centre.
    pub fn of_map(map: &ClassMap, material: &ClassMaterial<'_>, skipped: usize) -> Option<Self> {
        if map.count() == 1 {
            return None;
        }
        let finest = &map.levels[0];
        let shares_of_row = |y: u32| {
            let texel =
                |i: u32, side: u32, to: u32| ((u64::from(2 * i + 1) * u64::from(to)) / (2 * u64::from(side))) as usize;
            let row = texel(y, material.size[1], finest.height) * finest.width as usize;
            let shares = |x: u32| {
                let at = row + texel(x, material.size[0], finest.width);
                let mut shares = [0.0; MOST_CLASSES];
                shares
                    .iter_mut()
                    .zip(finest.layers.iter().step_by(2))
                    .for_each(|(w, layer)| *w = layer[at][0].to_f64());
                DVec4::from(shares)
            };
            (0..material.size[0]).map(shares).collect()
        };
        Self::of_shares(map.count(), material, skipped, shares_of_row)
    }

    /// Creates the colours from the shares of the classes in the texels of a row.
    fn of_shares(
        count: usize,
        material: &ClassMaterial<'_>,
        skipped: usize,
        shares_of_row: impl Fn(u32) -> Vec<DVec4> + Sync,
    ) -> Option<Self> {
        let row = |y: u32| -> Row {
            let mut row = Row::with_capacity(4 * (count + 1) * material.size[0] as usize);
            for (x, shares) in shares_of_row(y).into_iter().enumerate() {
                let [r, g, b, alpha] = (material.texel)(y as usize * material.size[0] as usize + x);
                let shares = shares.as_vec4().to_array();
                for share in &shares[..count] {
                    row.extend([r, g, b, alpha * alpha].map(|v| share * v));
                }
                row.extend(shares);
            }
            row
        };
        let skipped = skipped.min(material.size[0].max(material.size[1]).ilog2() as usize);
        let levels = filtered(material.size, count + 1, skipped, |rows| rows.into_par_iter().map(row).collect());
        let colors = Self { levels };
        colors.differ().then_some(colors)
    }

    /// Returns the number of classes.
    pub fn count(&self) -> usize {
        self.levels[0].layers.len() - 1
    }

    /// Returns the share, the mean linear albedo and the mean `α²` of each class in a texel of a stored level. All are 0 for a class
    /// that the texel does not contain.
    ///
    /// # Panics
    /// Panics if the level or the texel does not exist.
    pub fn of_texel(&self, level: usize, texel: usize) -> Vec<(f64, DVec4)> {
        let layers = &self.levels[level].layers;
        let shares = layers[self.count()][texel].map(f64::from);
        let class = |(layer, share): (&Vec<[f16; 4]>, f64)| {
            let sum = DVec4::from(layer[texel].map(f64::from));
            (share, if share > 0.0 { sum / share } else { DVec4::ZERO })
        };
        layers[..self.count()].iter().zip(shares).map(class).collect()
    }

    fn differ(&self) -> bool {
        let classes = self.of_texel(self.levels.len() - 1, 0);
        let mean: DVec4 = classes.iter().map(|&(share, value)| share * value).sum();
        let [of_color, of_roughness] = LEAST_CHANGE;
        let least = DVec4::splat(of_color * mean.truncate().max_element()).truncate().extend(of_roughness * mean.w);
        classes.iter().any(|&(share, value)| (share * (value - mean)).abs().cmpgt(least).any())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derive::classes;
    use crate::{HeightMap, Wrap, procedural};

    /// Returns the classes of a flat surface with this roughness at each texel of 64 x 64.
    fn flat(alpha: impl Fn(usize) -> f32 + Sync) -> (Classes, Option<ClassColors>) {
        let texel = |i: usize| [0.5, 0.4, 0.3, alpha(i)];
        let material = ClassMaterial { size: [64, 64], texel: &texel, follows_relief: true };
        let found = classes(Facets::Flat, [1.0; 2], Some(&material));
        let colors = ClassColors::new(Facets::Flat, &found, &material, 0);
        (found, colors)
    }

    #[test]
    fn two_roughnesses_are_two_classes() {
        for (every, least_share) in [(2, 0.5), (8, 0.125)] {
            let (found, colors) = flat(|i| if (i + i / 64) % every == 0 { 0.1 } else { 0.6 });
            let colors = colors.unwrap();
            assert_eq!((found.count(), colors.levels[0].layers.len()), (2, 3), "{:?}", found.errors);
            let mut mean = colors.of_texel(6, 0);
            mean.sort_by(|a, b| a.1.w.total_cmp(&b.1.w));
            assert!((mean[0].0 - least_share).abs() < 1e-3 && (mean[0].1.w - 0.01).abs() < 1e-4, "{mean:?}");
            assert!((mean[1].1.w - 0.36).abs() < 1e-3 && (mean[1].1.y - 0.4).abs() < 1e-3, "{mean:?}");
        }
    }

    #[test]
    fn one_roughness_is_one_class() {
        for spread in [0.0, 0.1] {
            let (found, colors) = flat(|i| 0.3 + spread * ((i * 7919) % 64) as f32 / 64.0);
            assert!(found.count() == 1 && colors.is_none(), "{:?}", found.errors);
        }
    }

    /// Returns the classes of rock with this colour by height and slope, with and without a search for colours that follow the relief.
    fn painted(paint: impl Fn(f32, f32) -> bool + Sync) -> [(Classes, Option<ClassColors>); 2] {
        let rock = procedural::fbm(128, 128, 3, 8, 4, 0.5);
        let texel = |i: usize| {
            let next = rock.texels[i / 128 * 128 + (i + 1) % 128];
            let c = if paint(rock.texels[i], next - rock.texels[i]) { 0.8 } else { 0.2 };
            [c, c, 0.2, 0.3]
        };
        [true, false].map(|follows_relief| {
            let material = ClassMaterial { size: [128, 128], texel: &texel, follows_relief };
            let facets = Facets::OfHeights(&rock, Wrap::Repeat);
            let found = classes(facets, [0.1; 2], Some(&material));
            let colors = ClassColors::new(facets, &found, &material, 0);
            (found, colors)
        })
    }

    #[test]
    fn paint_that_follows_the_relief_is_a_class() {
        for paint in [(|h, _| h > 0.5) as fn(f32, f32) -> bool, |_, rise| rise > 0.0] {
            let [(found, colors), (without, none)] = painted(paint);
            assert!(without.count() == 1 && none.is_none(), "{:?}", without.errors);
            let colors = colors.unwrap();
            // Classes are of one colour. Their heights or slopes differ.
            for (share, value) in colors.of_texel(7, 0) {
                assert!(share < 0.01 || !(0.23..0.77).contains(&value.x), "{share} {value} {:?}", found.errors);
            }
        }
    }

    #[test]
    fn paint_without_relation_to_the_relief_is_no_class() {
        let rock = procedural::fbm(128, 128, 3, 8, 4, 0.5);
        let other = procedural::fbm(128, 128, 9, 32, 1, 0.5);
        let texel = |i: usize| if other.texels[i] > 0.5 { [0.8, 0.8, 0.2, 0.3] } else { [0.2, 0.2, 0.2, 0.3] };
        let material = ClassMaterial { size: [128, 128], texel: &texel, follows_relief: true };
        let found = classes(Facets::OfHeights(&rock, Wrap::Repeat), [0.1; 2], Some(&material));
        assert!(found.errors[0] < 0.5 && found.count() <= 2, "{:?}", found.errors);
    }

    #[test]
    fn colors_of_any_resolution_have_the_shares_of_the_relief() {
        // A plateau over a quarter of the map, whose top is red.
        let top = |x: u32, y: u32, side: u32| 2 * x < side && 2 * y < side;
        let texels = (0..64 * 64).map(|i| 0.1 * f32::from(u8::from(top(i % 64, i / 64, 64)))).collect();
        let relief = HeightMap { width: 64, height: 64, texels };
        let facets = Facets::OfHeights(&relief, Wrap::Repeat);
        for side in [16, 64, 128] {
            let texel = |i: usize| {
                let red = if top(i as u32 % side, i as u32 / side, side) { 0.9 } else { 0.1 };
                [red, 0.1, 0.1, 0.3]
            };
            let material = ClassMaterial { size: [side; 2], texel: &texel, follows_relief: true };
            let found = classes(facets, [1.0; 2], Some(&material));
            let colors = ClassColors::new(facets, &found, &material, 1).unwrap();
            assert_eq!((colors.levels[0].width, colors.count()), (side / 2, found.count()));
            let map = ClassMap::new(facets, &found, Some(&material));
            let of_map = ClassColors::of_map(&map, &material, 1).unwrap();
            let last = colors.levels.len() - 1;
            for (a, b) in colors.of_texel(last, 0).into_iter().zip(of_map.of_texel(last, 0)) {
                assert!((a.0 - b.0).abs() < 0.05 && (a.0 * a.1 - b.0 * b.1).length() < 0.05, "{side}: {a:?} {b:?}");
            }
            assert!(side != 64 || colors == of_map, "the same texels");
            let classes = colors.of_texel(colors.levels.len() - 1, 0);
            let mut red = 0.0;
            for (class, &(share, value)) in map.mean().iter().zip(&classes) {
                assert!((class.share - share).abs() < 0.05, "{side}: {} {share}", class.share);
                red += share * value.x;
            }
            assert!((red - 0.3).abs() < 2e-3, "{side}: {red}");
            let high =
                (0..found.count()).max_by(|&a, &b| map.mean()[a].height.total_cmp(&map.mean()[b].height)).unwrap();
            assert!(classes[high].1.x > 0.7, "{side}: {classes:?}");
        }
    }
}
