import { PNG } from 'pngjs';

/** Side of a drawn pixel in the sheet. */
const SCALE = 4;
const EXPOSURE = 0.5;

function encoded(linear) {
    const value = Math.min(Math.max(EXPOSURE * linear, 0), 1);
    return Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
}

/** A PNG file of square linear pictures, in rows. */
export function sheet(rows, pixels) {
    const side = pixels * SCALE;
    const png = new PNG({ width: side * rows[0].length, height: side * rows.length });
    for (let y = 0; y < png.height; y++) {
        for (let x = 0; x < png.width; x++) {
            const picture = rows[Math.floor(y / side)][Math.floor(x / side)];
            const [px, py] = [x, y].map((v) => Math.floor((v % side) / SCALE));
            // The first row of a read-back is the bottom.
            const at = 3 * ((pixels - 1 - py) * pixels + px);
            png.data.set([...picture.slice(at, at + 3).map(encoded), 255], 4 * (y * png.width + x));
        }
    }
    return PNG.sync.write(png);
}
