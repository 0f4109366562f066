//! Text in pictures, in an 8 x 8 pixel font.

use font8x8::{BASIC_FONTS, UnicodeFonts};

use leadr_maps::Rgb8Image;

/// Text colour in sRGB.
const INK: [u8; 3] = [230; 3];

/// Side of a character, pixels, before magnification.
pub const CHARACTER: u32 = 8;

/// Height of a line of text, pixels, before magnification.
pub const LINE: u32 = 10;

/// Writes lines of ASCII text, magnified by `scale`, with their top left corner at `corner`. Text beyond `width` pixels is cut off.
pub fn write_lines(picture: &mut Rgb8Image, corner: [u32; 2], width: u32, scale: u32, lines: &[String]) {
    let fitting = (width / (CHARACTER * scale)) as usize;
    for (row, line) in (0..).zip(lines) {
        for (column, character) in (0..).zip(line.chars().take(fitting)) {
            let glyph = BASIC_FONTS.get(character).unwrap_or_default();
            let side = CHARACTER * scale;
            for pixel in 0..side * side {
                let (x, y) = (pixel % side, pixel / side);
                if glyph[(y / scale) as usize] >> (x / scale) & 1 == 1 {
                    let (x, y) = (corner[0] + column * side + x, corner[1] + row * LINE * scale + y);
                    picture.texels[(y * picture.width + x) as usize] = INK;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_drawn_upright_and_cut_off() {
        let mut picture = Rgb8Image { width: 24, height: 20, texels: vec![[0; 3]; 24 * 20] };
        write_lines(&mut picture, [0, 0], 20, 1, &["LLL".to_owned(), "T".to_owned()]);
        let rows: Vec<String> = picture
            .texels
            .chunks(24)
            .map(|row| row.iter().map(|&texel| if texel == INK { '#' } else { '.' }).collect())
            .collect();
        // The stem of the L is on the left, its foot is at the bottom, and the third letter is outside.
        assert_eq!(rows[2].chars().take(8).collect::<String>(), ".##.....");
        assert_eq!(rows[6].matches('#').count(), 14, "{}", rows.join("\n"));
        assert!(rows.iter().all(|row| row.ends_with("........")));
        assert_eq!(rows[10].chars().take(8).collect::<String>(), "######..", "{}", rows.join("\n"));
    }
}
