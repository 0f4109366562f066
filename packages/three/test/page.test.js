import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { PNG } from 'pngjs';
import { browser } from '../build/browser.js';
import { serve } from '../build/server.js';
import { site } from '../build/site.js';

const SIZE = { width: 480, height: 320 };
/** Rows of the picture between the names and the panel. */
const ROWS = [60, 240];

let folder, server, chromium;

before(async () => {
    folder = mkdtempSync(join(tmpdir(), 'leadr-three-'));
    await site(folder);
    server = await serve({ '/': folder });
    chromium = await browser();
});

after(async () => {
    await chromium?.close();
    await server?.close();
    rmSync(folder, { recursive: true, force: true });
});

/** The opened page, and the errors and failed requests that it reports. */
async function open(before = async () => {}) {
    const page = await chromium.newPage({ viewport: SIZE });
    const faults = [];
    page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
    page.on('pageerror', (error) => faults.push(error.message));
    await before(page);
    await page.goto(server.url);
    await ready(page);
    return { page, faults };
}

/** Waits until the model is loaded, or until the page says why it is not. */
async function ready(page) {
    await page.waitForFunction(() => ['ready', 'failed'].includes(document.body.dataset.state), undefined, { timeout: 120000 });
}

async function show(page, model) {
    await page.selectOption('#model', model);
    await ready(page);
}

/** Moves the camera with the slider: 0 is near, 1 is far. */
const moveTo = (page, place) => page.locator('#distance').fill(String(place));

/** Drags the line to a fraction of the width. */
async function drag(page, to) {
    const box = await page.locator('#line').boundingBox();
    await page.mouse.move(box.x + box.width / 2, SIZE.height / 2);
    await page.mouse.down();
    await page.mouse.move(to * (SIZE.width - 1), SIZE.height / 2, { steps: 4 });
    await page.mouse.up();
}

/** The drawn picture, once no frame is pending. The line and the panel are hidden. */
async function picture(page) {
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    return PNG.sync.read(await page.screenshot({ style: '#line, .name, #panel { visibility: hidden }' }));
}

/** Mean of `value(i)` over the RGB samples in some columns. */
function meanOver(image, [from, to], value) {
    let [sum, count] = [0, 0];
    for (let y = ROWS[0]; y < ROWS[1]; y++) {
        for (let x = Math.floor(from * image.width); x < Math.floor(to * image.width); x++) {
            for (let c = 0; c < 3; c++, count++) sum += value(4 * (y * image.width + x) + c);
        }
    }
    return sum / count;
}

const brightness = (image, columns) => meanOver(image, columns, (i) => image.data[i]);
const difference = (a, b, columns) => meanOver(a, columns, (i) => Math.abs(a.data[i] - b.data[i]));

/** The same view with the source only and with the filtered model only. */
async function bothOf(page) {
    await drag(page, 1);
    const source = await picture(page);
    await drag(page, 0);
    return [source, await picture(page)];
}

test('the models agree nearby and differ at a distance', async () => {
    const { page, faults } = await open();
    assert.equal(await page.getAttribute('body', 'data-state'), 'ready', await page.textContent('#message'));
    await moveTo(page, 0);
    const near = difference(...(await bothOf(page)), [0, 1]);
    await moveTo(page, 0.75);
    const far = difference(...(await bothOf(page)), [0, 1]);
    console.log(`mean difference in codes: ${near.toFixed(2)} nearby, ${far.toFixed(2)} at a distance`);
    assert.ok(near < 5, `${near} nearby`);
    assert.ok(far > 12 && far > 3 * near, `${far} at a distance, ${near} nearby`);
    assert.deepEqual(faults, []);
    await page.close();
});

test('the line divides the picture where it is dragged', async () => {
    const { page, faults } = await open();
    await moveTo(page, 0.75);
    const [source, filtered] = await bothOf(page);
    await drag(page, 0.3);
    const divided = await picture(page);
    for (const half of [[0, 0.28], [0.32, 1]]) assert.ok(brightness(divided, half) > 40, `${half}: ${brightness(divided, half)}`);
    assert.equal(difference(divided, source, [0, 0.28]), 0);
    assert.equal(difference(divided, filtered, [0.32, 1]), 0);
    assert.ok(difference(divided, source, [0.32, 1]) > 1);
    await page.locator('#line').press('ArrowLeft');
    assert.ok(difference(divided, await picture(page), [0.26, 0.32]) > 1, 'an arrow key moves the line');
    assert.deepEqual(faults, []);
    await page.close();
});

test('every model of the list is drawn', async () => {
    const { page, faults } = await open();
    for (const model of await page.locator('#model option').evaluateAll((options) => options.map(({ value }) => value))) {
        await show(page, model);
        await moveTo(page, 0.2);
        const [source, filtered] = await bothOf(page);
        for (const image of [source, filtered]) assert.ok(brightness(image, [0.3, 0.7]) > 25, `${model}: ${brightness(image, [0.3, 0.7])}`);
        assert.ok(difference(source, filtered, [0, 1]) > 0, `${model}: both are the same`);
    }
    assert.deepEqual(faults, []);
    await page.close();
});

test('a missing model is named', async () => {
    const missing = (page) => page.route('**/*-filtered.glb', (route) => route.fulfill({ status: 404, body: '' }));
    const { page } = await open(missing);
    assert.equal(await page.getAttribute('body', 'data-state'), 'failed');
    assert.match(await page.textContent('#message'), /models\/varnished-filtered\.glb: .*404.*npm run build/s);
    await page.close();
});
