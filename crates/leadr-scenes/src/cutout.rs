//! Fills cutouts with colours. Cutouts are often black in files, and mipmaps would blend this black into the opaque areas.

use super::cover::Texel;

/// A mip level whose texels are means of the covered texels.
struct TexelLevel {
    size: [usize; 2],
    /// The texels of the level, or `None` where nothing is covered.
    texels: Vec<Option<Texel>>,
}

impl TexelLevel {
    /// Computes the next coarser mip level.
    fn coarser(&self) -> Self {
        let [width, height] = self.size;
        let size = self.size.map(|side| side.div_ceil(2));
        let texel = |index: usize| {
            let [x, y] = [2 * (index % size[0]), 2 * (index / size[0])];
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (x + i, y + j));
            let there: Vec<Texel> = four
                .into_iter()
                .filter(|&(x, y)| x < width && y < height)
                .filter_map(|(x, y)| self.texels[y * width + x])
                .collect();
            let weight = 1.0 / there.len().max(1) as f32;
            (!there.is_empty()).then(|| there.iter().fold(Texel::default(), |sum, texel| sum.plus(weight, *texel)))
        };
        Self { size, texels: (0..size[0] * size[1]).map(texel).collect() }
    }
}

/// Replaces uncovered texels by the mean of the nearest `covered` texels. The texels are in the order of rows. The mean over a square of 2ⁿ
/// × 2ⁿ texels is then the mean of its covered texels.
pub fn filled(texels: &[Texel], [width, height]: [u32; 2], covered: impl Fn(usize) -> bool) -> Vec<Texel> {
    let size = [width as usize, height as usize];
    let there = texels.iter().enumerate().map(|(index, texel)| covered(index).then_some(*texel)).collect();
    let mut levels = vec![TexelLevel { size, texels: there }];
    while let Some(last) = levels.last()
        && last.size != [1, 1]
    {
        let coarser = last.coarser();
        levels.push(coarser);
    }
    let at = |mut index: usize| {
        for level in &levels {
            if let Some(texel) = level.texels[index] {
                return texel;
            }
            let [x, y] = [index % level.size[0], index / level.size[0]];
            index = y / 2 * level.size[0].div_ceil(2) + x / 2;
        }
        texels[0]
    };
    (0..texels.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_means_cover_only_covered_pixels() {
        let texel = |red: f32| Texel { albedo: [red, 0.0, 0.0], ..Texel::default() };
        let texels: Vec<Texel> = (0..16).map(|i| texel(if i == 5 { 0.8 } else { 0.1 })).collect();
        let red = |texels: &[Texel]| texels.iter().map(|t| t.albedo[0]).sum::<f32>() / texels.len() as f32;
        let one = filled(&texels, [4, 4], |index| index == 5);
        assert!((red(&one) - 0.8).abs() < 1e-6, "{}", red(&one));
        // The two covered texels of the right half lie in different squares.
        let two = filled(&texels, [4, 4], |index| index == 5 || index == 7);
        assert!((two[0].albedo[0] - 0.8).abs() < 1e-6 && (two[3].albedo[0] - 0.1).abs() < 1e-6);
        assert!((red(&two) - 0.45).abs() < 1e-6, "{}", red(&two));
        // The image has an odd size and no covered texels.
        assert_eq!(
            filled(&texels[..15], [5, 3], |_| false),
            texels[..15].iter().map(|_| texels[0]).collect::<Vec<_>>()
        );
        assert_eq!(filled(&texels[..15], [5, 3], |_| true), texels[..15]);
    }
}
