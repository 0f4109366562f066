import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { PNG } from 'pngjs';

/** Height from black to white in repeats, if a folder has heights but no normals: that of leadr. */
const DEFAULT_HEIGHT = 0.06;
const STEEPEST_RMS_SLOPE = 0.5;

/** A picture's samples from 0 to 1: RGBA. */
function read(path) {
    const { width, height, data } = PNG.sync.read(readFileSync(path), { skipRescale: true });
    const scale = data instanceof Uint16Array ? 65535 : 255;
    return { width, height, at: (i, channel) => data[4 * i + channel] / scale };
}

/** A PNG file of `width` × `height` texels, whose RGB is `color(i)`, from 0 to 1. */
function write(width, height, color) {
    const png = new PNG({ width, height, colorType: 2 });
    for (let i = 0; i < width * height; i++) {
        const rgb = color(i).map((v) => Math.round(255 * Math.min(Math.max(v, 0), 1)));
        png.data.set([...rgb, 255], 4 * i);
    }
    return PNG.sync.write(png, { colorType: 2 });
}

/** Normals of heights that repeat, green up. */
function normalsOf(heights) {
    const { width, height } = heights;
    const texel = (x, y) => heights.at(((y + height) % height) * width + ((x + width) % width), 0);
    const slopes = Array.from({ length: width * height }, (_, i) => {
        const [x, y] = [i % width, Math.floor(i / width)];
        return [(texel(x + 1, y) - texel(x - 1, y)) / 2, (texel(x, y - 1) - texel(x, y + 1)) / 2];
    });
    const rms = Math.sqrt(slopes.reduce((sum, [x, y]) => sum + x * x + y * y, 0) / slopes.length);
    const scale = Math.min(DEFAULT_HEIGHT * width, STEEPEST_RMS_SLOPE / rms);
    return write(width, height, (i) => {
        const [x, y] = slopes[i].map((slope) => slope * scale);
        const length = Math.hypot(x, y, 1);
        return [-x, -y, 1].map((v) => 0.5 + (0.5 * v) / length);
    });
}

/**
 * The pictures of a material folder as a glTF material needs them, each a PNG file of 8 bits: `color`, `normal`, and `orm` with
 * occlusion, roughness and metalness in red, green and blue.
 */
export function pictures(folder) {
    const files = readdirSync(folder);
    const find = (role) => {
        const file = files.find((name) => name.endsWith(`_${role}.png`));
        return file && join(folder, file);
    };
    const needed = (role) => {
        const file = find(role);
        if (!file) throw new Error(`${folder}: no picture *_${role}.png`);
        return file;
    };
    const roughness = read(needed('Roughness'));
    const others = { occlusion: find('AmbientOcclusion'), metalness: find('Metalness') };
    const occlusion = others.occlusion && read(others.occlusion);
    const metalness = others.metalness && read(others.metalness);
    for (const other of [occlusion, metalness]) {
        if (other && (other.width !== roughness.width || other.height !== roughness.height)) {
            throw new Error(`${folder}: pictures differ in size`);
        }
    }
    const { width, height } = roughness;
    const orm = (i) => [occlusion?.at(i, 0) ?? 1, roughness.at(i, 0), metalness?.at(i, 0) ?? 0];
    const color = read(needed('Color'));
    const rgb = ({ at }) => (i) => [0, 1, 2].map((channel) => at(i, channel));
    const normal = find('NormalGL') && read(find('NormalGL'));
    return {
        color: write(color.width, color.height, rgb(color)),
        normal: normal ? write(normal.width, normal.height, rgb(normal)) : normalsOf(read(needed('Displacement'))),
        orm: write(width, height, orm),
    };
}

/** The glTF material of these pictures. With `varnish`, it has a smooth clear coat that follows the normals. */
export const standard = ({ varnish = false } = {}) => (texture) => ({
    pbrMetallicRoughness: { baseColorTexture: texture('color'), metallicRoughnessTexture: texture('orm') },
    normalTexture: texture('normal'),
    occlusionTexture: texture('orm'),
    ...(varnish && {
        extensions: {
            KHR_materials_clearcoat: {
                clearcoatFactor: 1,
                clearcoatRoughnessFactor: 0.1,
                clearcoatNormalTexture: texture('normal'),
            },
        },
    }),
});
