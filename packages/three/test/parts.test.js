import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { rectangle } from '../build/glb.js';
import { pictures, standard } from '../build/material.js';
import { PACKAGE } from '../build/paths.js';
import { resolve, serve } from '../build/server.js';
import { partsOfThree } from '../build/site.js';
import { bias, errors, flicker, rrmse } from '../measure/metrics.js';

/** A grey picture of 8 bits. */
function grey(size, value) {
    const png = new PNG({ width: size, height: size });
    for (let i = 0; i < size * size; i++) png.data.set([...Array(3).fill(value(i % size, Math.floor(i / size))), 255], 4 * i);
    return PNG.sync.write(png);
}

function inFolder(files, act) {
    const folder = mkdtempSync(join(tmpdir(), 'leadr-three-'));
    try {
        for (const [name, data] of Object.entries(files)) writeFileSync(join(folder, name), data);
        return act(folder);
    } finally {
        rmSync(folder, { recursive: true });
    }
}

test('a model has the lengths and the offsets that glTF requires', () => {
    const parts = { color: Buffer.from('abc'), normal: Buffer.from('defgh'), orm: Buffer.from('i') };
    const glb = rectangle({ size: [4, 2], pictures: parts, material: standard({ varnish: true }) });
    assert.equal(glb.readUInt32LE(8), glb.length);
    const jsonLength = glb.readUInt32LE(12);
    const json = JSON.parse(glb.toString('utf8', 20, 20 + jsonLength));
    const body = glb.subarray(28 + jsonLength);
    assert.equal(glb.readUInt32LE(20 + jsonLength), body.length);
    assert.equal(json.buffers[0].byteLength, body.length);
    for (const view of json.bufferViews) assert.equal(view.byteOffset % 4, 0);
    const image = ({ bufferView }) => json.bufferViews[bufferView];
    const stored = json.images.map(image).map((view) => body.toString('utf8', view.byteOffset, view.byteOffset + view.byteLength));
    assert.deepEqual(stored, ['abc', 'defgh', 'i']);
    assert.deepEqual(json.extensionsUsed, ['KHR_materials_clearcoat']);
});

test('normals of heights point away from the slope', () => {
    const size = 8;
    // Heights rise to the right and towards the top, except across the seams.
    const right = grey(size, (x) => 36 * x);
    const up = grey(size, (x, y) => 36 * (size - 1 - y));
    const normal = (heights) =>
        inFolder({ 'a_Color.png': heights, 'a_Roughness.png': heights, 'a_Displacement.png': heights }, (folder) => {
            const { data } = PNG.sync.read(pictures(folder).normal);
            return [...data.subarray(4 * (3 * size + 3), 4 * (3 * size + 3) + 3)];
        });
    const [fromRight, fromUp] = [right, up].map(normal);
    assert.ok(fromRight[0] < 122 && Math.abs(fromRight[1] - 127.5) < 1 && fromRight[2] > 200, `${fromRight}`);
    assert.ok(Math.abs(fromUp[0] - 127.5) < 1 && fromUp[1] < 122 && fromUp[2] > 200, `${fromUp}`);
});

test('roughness and metalness go into their channels, and bad folders are refused', () => {
    const files = { 'a_Color.png': grey(4, () => 9), 'a_NormalGL.png': grey(4, () => 128), 'a_Roughness.png': grey(4, () => 50) };
    const { data } = inFolder({ ...files, 'a_Metalness.png': grey(4, () => 200) }, (folder) => PNG.sync.read(pictures(folder).orm));
    assert.deepEqual([...data.subarray(0, 3)], [255, 50, 200]);
    assert.throws(() => inFolder({ 'a_Color.png': files['a_Color.png'] }, pictures), /no picture \*_Roughness\.png/);
    assert.throws(() => inFolder({ ...files, 'a_Metalness.png': grey(8, () => 0) }, pictures), /differ in size/);
});

test('the page brings what it imports of three.js', () => {
    const parts = partsOfThree([join(PACKAGE, 'src/page.js'), join(PACKAGE, 'src/loader.js')]);
    for (const part of ['build/three.core.js', 'examples/jsm/utils/WorkerPool.js', 'examples/jsm/libs/basis/basis_transcoder.wasm']) {
        assert.ok(parts.includes(part), part);
    }
    assert.ok(parts.length < 20, parts.join(' '));
});

test('the server stays in its folders', async () => {
    const mounts = { '/': '/a', '/three/': '/b/c' };
    assert.equal(resolve(mounts, '/x.js?y#z'), '/a/x.js');
    assert.equal(resolve(mounts, '/three/build/x.js'), '/b/c/build/x.js');
    assert.equal(resolve(mounts, '/'), '/a/index.html');
    for (const address of ['/../etc/passwd', '/three/../../etc/passwd', '/%2e%2e/x', '/%', '/a%00b']) {
        assert.equal(resolve(mounts, address), undefined, address);
    }
    const server = await serve({ '/': join(PACKAGE, 'src') });
    assert.equal((await fetch(`${server.url}index.js`)).status, 200);
    assert.equal((await fetch(`${server.url}missing.js`)).status, 404);
    await server.close();
});

test('errors of known pictures', () => {
    const truth = [1, 2, 2];
    assert.equal(rrmse(truth, truth), 0);
    assert.ok(Math.abs(rrmse(truth, [2, 2, 2]) - 1 / 3) < 1e-12);
    assert.ok(Math.abs(bias(truth, [2, 2, 2]) - 0.2) < 1e-12);
    // A change that the truth has too is no flicker.
    assert.equal(flicker([truth, [2, 3, 3]], [[0, 0, 0], [1, 1, 1]]), 0);
    assert.ok(Math.abs(flicker([[2, 2], [2, 2]], [[1, 1], [2, 0]]) - 0.5) < 1e-12);
});

test('the noise of the truth is not part of an error', () => {
    // Both halves are a third off, in opposite directions. Their mean is right.
    const half = (sign) => Array(2).fill([3 + sign, 3 - sign]);
    const views = (picture) => errors({ halves: [half(1), half(-1)], variants: [[picture, picture]] });
    assert.ok(Math.abs(views([3, 3]).noise.rrmse - 1 / 3) < 1e-12);
    assert.equal(views([3, 3]).variants[0].rrmse, 0);
    const { rrmse } = views([5, 5]).variants[0];
    assert.ok(Math.abs(rrmse - Math.sqrt(4 / 9 - 1 / 9)) < 1e-12);
});
