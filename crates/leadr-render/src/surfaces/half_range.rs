//! Rescales the slopes of an object to the range of 16-bit floats. The scale is a power of two, so scaling is exact, and only the
//! conversion to 16 bits rounds.

use rayon::prelude::*;

use super::displacement::{Border, HeightField};
use crate::scene::Object;
use leadr_maps::halves::factor;

/// Rescales heights, slopes and moments for the best precision in 16 bits. The object's height scale compensates for it.
pub fn fill_half_range(object: &mut Object) {
    let Some(field) = &mut object.heights else { return };
    let steepest = match (&object.moments, &object.slopes) {
        (Some(moments), _) => {
            let squares = moments.levels.iter().take(1).flat_map(|level| &level.texels);
            squares.fold(0.0f32, |most, m| most.max(m.second[0]).max(m.second[1])).sqrt()
        }
        (None, Some(slopes)) => slopes.iter().flatten().fold(0.0f32, |most, slope| most.max(slope.abs())),
        (None, None) => steepest_slope(field),
    };
    let factor = factor(steepest);
    field.map.texels.par_iter_mut().for_each(|height| *height *= factor);
    if let Some(slopes) = &mut object.slopes {
        slopes.as_flattened_mut().iter_mut().for_each(|slope| *slope *= factor);
    }
    if let Some(moments) = &mut object.moments {
        for level in &mut moments.levels {
            level.texels.iter_mut().for_each(|texel| *texel = texel.scaled(factor));
        }
    }
    if let Some(classes) = &mut object.classes {
        classes.scale(factor);
    }
    object.height_scale /= factor;
}

/// Returns the steepest slope between adjacent texels, per unit of texture coordinate. Height differences between two tiles are
/// ignored.
fn steepest_slope(field: &HeightField) -> f32 {
    let (width, height) = (field.map.width as usize, field.map.height as usize);
    let tile = match field.border {
        Border::Tiles(layout) => layout.tile as usize,
        Border::Wrap | Border::Clamp => usize::MAX,
    };
    let repeats = field.border == Border::Wrap;
    let row = |y: usize| {
        let texels = &field.map.texels[y * width..][..width];
        let across = texels.windows(2).enumerate().filter(|(x, _)| (x + 1) % tile != 0);
        let across = across.fold(0.0f32, |most, (_, pair)| most.max((pair[1] - pair[0]).abs()));
        let across = if repeats { across.max((texels[0] - texels[width - 1]).abs()) } else { across };
        let below = if y + 1 < height { Some(y + 1) } else { repeats.then_some(0) };
        let below = below.filter(|_| !(y + 1).is_multiple_of(tile)).map_or(0.0, |below| {
            let next = &field.map.texels[below * width..][..width];
            texels.iter().zip(next).fold(0.0f32, |most, (a, b)| most.max((b - a).abs()))
        });
        (across * width as f32).max(below * height as f32)
    };
    (0..height).into_par_iter().map(row).reduce(|| 0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};
    use leadr_maps::HeightMap;

    fn field(border: Border, texels: Vec<f32>) -> HeightField {
        HeightField { map: HeightMap { width: 8, height: 4, texels }, border }
    }

    #[test]
    fn the_steepest_slope_is_that_of_one_surface() {
        let mut texels = vec![0.0; 32];
        texels[8 + 4..8 + 8].fill(1.0);
        assert_eq!(steepest_slope(&field(Border::Wrap, texels.clone())), 8.0);
        // The step between tiles, which are 4 texels wide, does not count. Within a tile, heights fall by 1 per row.
        let layout = TileLayout { tile: 4, gutter: 1, columns: 2, rows: 1 };
        assert_eq!(steepest_slope(&field(Border::Tiles(layout), texels.clone())), 4.0);
        texels[4..8].fill(1.0);
        texels[20..24].fill(1.0);
        texels[28..32].fill(1.0);
        assert_eq!(steepest_slope(&field(Border::Tiles(layout), texels.clone())), 0.0);
        assert_eq!(steepest_slope(&field(Border::Wrap, texels)), 8.0);
    }

    #[test]
    fn drawn_heights_stay_the_same() {
        let heights = field(Border::Clamp, (0..32).map(|i| 0.37 * (i % 5) as f32).collect());
        let mut object = Object::new("o", PatchMesh::default()).with_heights(heights.clone(), 0.3);
        fill_half_range(&mut object);
        let scaled = object.heights.unwrap();
        assert!(scaled.map.texels[1] != heights.map.texels[1]);
        let metres = |height: f32, scale: f32| height * scale;
        for (a, b) in heights.map.texels.iter().zip(&scaled.map.texels) {
            assert_eq!(metres(*a, 0.3), metres(*b, object.height_scale));
        }
    }
}
