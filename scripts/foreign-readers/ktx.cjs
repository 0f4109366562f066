// Reads a baked KTX2 with ktx-parse and holds it against what `leadr bake --json` says of it.
const assert = require("node:assert");
const fs = require("node:fs");
const { read } = require("ktx-parse");

const BC5_SNORM = 142;
// Bytes of a number and numbers of a texel, by vkFormat.
const FLOATS = { 76: [2, 1], 83: [2, 2], 97: [2, 4], 100: [4, 1], 103: [4, 2], 109: [4, 4] };

function half(code) {
    const [sign, exponent, rest] = [code >> 15 ? -1 : 1, (code >> 10) & 31, code & 1023];
    if (exponent === 0) return sign * rest * 2 ** -24;
    return sign * (1 + rest / 1024) * 2 ** (exponent - 15);
}

// One channel of a block, BC4_SNORM: two ends, and 3 bits a texel.
function blockChannel(bytes, at) {
    const end = (i) => Math.max(bytes.readInt8(at + i), -127) / 127;
    const [a, b] = [end(0), end(1)];
    const values = [a, b];
    const eight = bytes.readInt8(at) > bytes.readInt8(at + 1);
    for (let i = 1; i < (eight ? 7 : 5); i++) values.push(((eight ? 7 : 5) - i) / (eight ? 7 : 5) * a + i / (eight ? 7 : 5) * b);
    if (!eight) values.push(-1, 1);
    const bits = bytes.readUIntLE(at + 2, 6);
    return Array.from({ length: 16 }, (_, i) => values[Math.floor(bits / 8 ** i) % 8]);
}

// Layers of channels of a level: arrays of width x height numbers, as they are stored.
function channels(file, level, width, height) {
    const bytes = Buffer.from(level.levelData);
    const texels = width * height;
    if (file.vkFormat === BC5_SNORM) {
        const [across, down] = [Math.ceil(width / 4), Math.ceil(height / 4)];
        return Array.from({ length: 2 * file.layerCount }, (_, channel) => {
            const values = new Float64Array(texels);
            for (let block = 0; block < across * down; block++) {
                const at = ((channel >> 1) * across * down + block) * 16 + (channel % 2) * 8;
                blockChannel(bytes, at).forEach((value, i) => {
                    const [x, y] = [(block % across) * 4 + (i % 4), Math.floor(block / across) * 4 + Math.floor(i / 4)];
                    if (x < width && y < height) values[y * width + x] = value;
                });
            }
            return values;
        });
    }
    const [size, count] = FLOATS[file.vkFormat];
    const number = size === 4 ? (i) => bytes.readFloatLE(i) : (i) => half(bytes.readUInt16LE(i));
    return Array.from({ length: count * Math.max(file.layerCount, 1) }, (_, channel) => {
        const first = Math.floor(channel / count) * texels * count + (channel % count);
        return Float64Array.from({ length: texels }, (_, i) => number((first + count * i) * size));
    });
}

const file = read(fs.readFileSync(process.argv[2]));
const said = JSON.parse(fs.readFileSync(process.argv[3], "utf8"));
const words = (key) => {
    const text = file.keyValue[key];
    if (text === undefined) return undefined;
    return (typeof text === "string" ? text : Buffer.from(text).toString()).replace(/\0$/, "").trim().split(/\s+/);
};
const names = words("leadr.channels");
const factors = (words("leadr.factors") ?? names.map(() => "1")).map(Number);
const offsets = (words("leadr.offsets") ?? names.map(() => "0")).map(Number);
assert.deepStrictEqual([file.pixelWidth, file.pixelHeight], said.size);
assert.strictEqual(file.levels.length, said.levels);
assert(file.vkFormat === BC5_SNORM || file.vkFormat in FLOATS);

const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;
let finest = null;
let moved = 0;
file.levels.forEach((level, number) => {
    const [width, height] = [file.pixelWidth, file.pixelHeight].map((n) => Math.max(n >> number, 1));
    const stored = channels(file, level, width, height);
    assert.strictEqual(level.levelData.length, level.uncompressedByteLength);
    // Plain numbers by name: what channels leave over is added.
    const plain = {};
    names.forEach((name, i) => {
        if (name === "-") return;
        const whole = name.replace(/\.rest\d*$/, "");
        const values = (plain[whole] ??= new Float64Array(width * height));
        stored[i].forEach((value, k) => (values[k] += value / (factors[i] ?? 1) + (offsets[i] ?? 0)));
    });
    // Deviations and correlation are not linear: each texel's moments first.
    const second = (x, deviation) => plain[deviation].map((d, k) => d * d + plain[x][k] ** 2);
    for (const [x, deviation, moment] of [["x", "x.deviation", "xx"], ["y", "y.deviation", "yy"], ["B.x", "B.x.deviation", "M.xx"], ["B.y", "B.y.deviation", "M.yy"]]) {
        if (plain[deviation]) plain[moment] = second(x, deviation);
    }
    const means = Object.fromEntries(Object.entries(plain).filter(([name]) => !/deviation|correlation/.test(name)).map(([name, values]) => [name, mean(values)]));
    const squares = Object.fromEntries(Object.entries(plain).map(([name, values]) => [name, Math.sqrt(mean(values.map((v) => v * v)))]));
    finest ??= { means, squares };
    for (const name in means) moved = Math.max(moved, Math.abs(means[name] - finest.means[name]) / (finest.squares[name] + 1e-30));
});
let report = `${said.levels} levels of ${names.filter((n) => n !== "-").length} channels, means move by ${moved.toExponential(1)}`;
if (finest.means.xx !== undefined) {
    const m = finest.means;
    const off = [m.xx - m.x ** 2, m.yy - m.y ** 2].map((v, i) => Math.abs(v / said.slope_variance[i] - 1));
    report += `, variance off by ${Math.max(...off).toExponential(1)}`;
}
console.log(report);
