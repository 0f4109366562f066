//! Classes of the facets of a baked map: their channels, and the rows that fill them.

use std::ops::Range;

use leadr_reflectance::masking::classes::{Class, MOST_CLASSES};
use rayon::prelude::*;

use super::Inputs;
use crate::class_map::{ClassFrame, ClassRows};
use crate::derive::{Classes, Facets, Openness, classes, classes_of_count, usual_scale};
use crate::pyramid::Row;
use crate::{HeightMap, MomentLevel, Wrap};

/// The channels of each class, in the order of the layers of a [`ClassMap`](crate::ClassMap).
pub(crate) const CLASS_CHANNELS: [[&str; 8]; MOST_CLASSES] = [
    ["class1.w", "class1.x", "class1.y", "class1.z", "class1.xx", "class1.yy", "class1.xy", "class1.zz"],
    ["class2.w", "class2.x", "class2.y", "class2.z", "class2.xx", "class2.yy", "class2.xy", "class2.zz"],
    ["class3.w", "class3.x", "class3.y", "class3.z", "class3.xx", "class3.yy", "class3.xy", "class3.zz"],
    ["class4.w", "class4.x", "class4.y", "class4.z", "class4.xx", "class4.yy", "class4.xy", "class4.zz"],
];

/// Returns the number of channels before the channels of classes.
pub(crate) fn channels_before_classes(channels: &[impl AsRef<str>]) -> usize {
    channels.iter().position(|name| name.as_ref() == CLASS_CHANNELS[0][0]).unwrap_or(channels.len())
}

/// The standard deviation of the slopes of a base material of Beckmann roughness 0.35. Errors of smaller slopes are relative to it.
const SIGNIFICANT_SLOPE: f64 = 0.35 * std::f64::consts::FRAC_1_SQRT_2;
/// The height, relative to the deviation of the heights from the centres of their classes, to which errors of smaller heights are
/// relative.
const SIGNIFICANT_HEIGHT: f64 = 0.1;

/// The classes of a planned map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ClassPlan {
    pub frame: ClassFrame,
    pub open: Openness,
    /// The size of a significant moment in each channel of a class of share 1.
    significant: [f64; 8],
}

impl ClassPlan {
    /// Returns the error of the worst channel. `differences` and `finest` have the mean square of the error of each channel, and of
    /// its values on the finest level.
    pub fn error(&self, differences: &[f64], finest: &[f64]) -> f64 {
        let classes = differences.as_chunks::<8>().0.iter().zip(finest.as_chunks::<8>().0);
        let of_class = |(differences, finest): (&[f64; 8], &[f64; 8])| {
            let of_channel = |channel: usize| {
                let least = self.significant[channel].powi(2) * finest[0];
                let error = differences[channel];
                if error > 0.0 { (error / (finest[channel] + least)).sqrt() } else { 0.0 }
            };
            (0..8).map(of_channel).fold(0.0, f64::max)
        };
        classes.map(of_class).fold(0.0, f64::max)
    }
}

/// The classes of the facets of [`Inputs`].
#[derive(Clone, Debug)]
pub struct FoundClasses {
    relief: Relief,
    classes: Classes,
    wrap: Wrap,
    /// The factors from slopes along `s` and `t` to rise over run.
    scale: [f64; 2],
}

#[derive(Clone, Debug)]
enum Relief {
    Heights(HeightMap),
    Texels(MomentLevel),
}

impl Relief {
    const fn facets(&self, wrap: Wrap) -> Facets<'_> {
        match self {
            Self::Heights(map) => Facets::OfHeights(map, wrap),
            Self::Texels(level) => Facets::OfTexels(level, wrap),
        }
    }
}

impl Inputs {
    /// Finds the classes of the slopes and heights that a map of kind leadr stores: this number of classes, or the number that suits
    /// the relief. If the unit of the heights is unknown, they are taken as high as the renderer takes them by default.
    pub fn find_classes(&self, count: Option<usize>) -> FoundClasses {
        let by = self.usual_height_scale();
        let [width, height] = self.size().expect("checked before baking").map(f64::from);
        let relief = match (&self.heights, &self.normals) {
            (Some(map), None) => {
                let texels = map.texels.iter().map(|h| by * h).collect();
                Relief::Heights(HeightMap { texels, ..*map })
            }
            _ => {
                let rows = (0..height as u32).into_par_iter().map(|y| self.moments(by, y));
                let texels = rows.flat_map_iter(|row| row.into_iter().map(bytemuck::cast)).collect();
                Relief::Texels(MomentLevel { width: width as u32, height: height as u32, texels })
            }
        };
        let of_unit = match &relief {
            Relief::Heights(map) if self.height_scale.is_none() => f64::from(usual_scale(map)),
            _ => 1.0,
        };
        // Texels are square, so a repeat along t is `height / width` texture widths long.
        let scale = [of_unit, of_unit * width / height];
        let classes = match count {
            Some(count) => classes_of_count(relief.facets(self.wrap), scale, count),
            None => classes(relief.facets(self.wrap), scale, None),
        };
        FoundClasses { relief, classes, wrap: self.wrap, scale }
    }
}

impl FoundClasses {
    /// Returns the number of classes.
    pub fn count(&self) -> usize {
        self.classes.count()
    }

    /// Returns the error of reflections for 1, 2, … classes ([`Classes::errors`]).
    pub fn errors(&self) -> &[f64] {
        &self.classes.errors
    }

    /// Returns the classes of sampled facets. Slopes are rise over run, and heights are in the unit of the baked map.
    pub fn sampled(&self) -> Vec<Class> {
        self.classes.sampled(self.scale)
    }

    pub(super) fn plan(&self) -> ClassPlan {
        let facets = self.relief.facets(self.wrap);
        let frame = ClassFrame::new(facets, &self.classes);
        let open = Openness::new(facets, &self.classes, None, frame.units, false);
        let [s, t] = [0, 1].map(|axis| SIGNIFICANT_SLOPE / (f64::from(frame.units[axis]) * self.scale[axis].abs()));
        let z = SIGNIFICANT_HEIGHT;
        ClassPlan { frame, open, significant: [0.0, s, t, z, s * s, t * t, s * t, z * z] }
    }

    /// Appends the channels of the classes to each texel of rows of the finest level.
    pub(super) fn append(&self, frame: &ClassFrame, rows: &mut [Row], range: Range<u32>) {
        let of_classes = ClassRows::new(self.relief.facets(self.wrap), &self.classes, None, frame).rows(range);
        let channels = 8 * self.count();
        rows.par_iter_mut().zip(of_classes).for_each(|(row, of_classes)| {
            let before = row.len() / (of_classes.len() / channels);
            let texels = row.chunks_exact(before).zip(of_classes.chunks_exact(channels));
            *row = texels.flat_map(|(a, b)| a.iter().chain(b).copied()).collect();
        });
    }
}
