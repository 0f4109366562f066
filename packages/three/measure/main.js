/**
 * Prints how far three.js' pictures of a source model and of its filtered copy are from the truth.
 *   npm run measure                 the bricks of this repository, and scanned materials if LEADR_SHARED names their folder
 *   npm run measure -- Rock003 …    only these
 */
import { mkdirSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { browser } from '../build/browser.js';
import { rectangle } from '../build/glb.js';
import { bake } from '../build/leadr.js';
import { pictures, standard } from '../build/material.js';
import { PACKAGE, REPOSITORY, THREE } from '../build/paths.js';
import { run } from '../build/run.js';
import { serve } from '../build/server.js';
import { errors } from './metrics.js';
import { sheet } from './sheet.js';

const SCANS = ['SheetMetal001', 'MetalWalkway006', 'Leather027', 'Rock003'];
/** Directions towards the sun: opposite to the camera, at its side, and behind it. */
const SUNS = [[0.35, 0.7, -0.6], [0.8, 0.5, 0.3], [-0.3, 0.6, 0.7]];
const DISTANCES = [1, 4, 16];
const PIXELS = 64;
const PASSES = 2;
const ANISOTROPIES = [1, 16];
/** Factors of the roughness of the filtered model, to find the error of the best single roughness. */
const FACTORS = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

const OUT = join(PACKAGE, 'out');

function folders() {
    const all = [join(REPOSITORY, 'assets/bricks')];
    if (process.env.LEADR_SHARED) all.push(...SCANS.map((name) => join(process.env.LEADR_SHARED, 'data/displacement', name)));
    else console.error('LEADR_SHARED is not set: scanned materials are skipped');
    const names = process.argv.slice(2);
    for (const name of names) {
        if (all.some((folder) => basename(folder) === name)) continue;
        throw new Error(`${name}: no such material. Available: ${all.map((folder) => basename(folder)).join(', ')}`);
    }
    return all.filter((folder) => !names.length || names.includes(basename(folder)));
}

/** Writes the source and the filtered model of a material folder. The bricks are varnished, because they are rough. */
async function models(folder) {
    const name = basename(folder);
    const source = join(OUT, `${name}.glb`);
    const material = standard({ varnish: name === 'bricks' });
    writeFileSync(source, rectangle({ size: [32, 32], pictures: pictures(folder), material }));
    await bake(source, join(OUT, `${name}-filtered.glb`));
    return { source: `/models/${name}.glb`, filtered: `/models/${name}-filtered.glb` };
}

const average = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

/** Means over the views of one distance, of all variants. */
function means(views) {
    const each = (of) => views[0].variants.map((_, i) => average(views.map((view) => of(view.variants[i]))));
    const noise = { rrmse: average(views.map((view) => view.noise.rrmse)), flicker: average(views.map((view) => view.noise.flicker)) };
    return { rrmse: each((v) => v.rrmse), bias: each((v) => v.bias), flicker: each((v) => v.flicker), noise };
}

/** Three digits at most, without the zero before the point. */
const number = (value) => (Math.abs(value) < 0.9995 ? value.toFixed(3).replace(/^(-?)0/, '$1') : value.toPrecision(3)).replace('-', '−');

function row(name, distance, { rrmse, bias, flicker, noise }, first, best) {
    const pair = (values) => [values[first], values[first + 1]].map(number).join(' | ');
    const ratio = (values) => number(values[first + 1] / values[first]);
    const cells = [name, distance, pair(rrmse), ratio(rrmse), best && number(best(rrmse)), pair(bias), pair(flicker), ratio(flicker)];
    cells.push(number(noise.rrmse), number(noise.flicker));
    return `| ${cells.filter((cell) => cell !== undefined).join(' | ')} |`;
}

function table(results, anisotropy) {
    const first = 2 * ANISOTROPIES.indexOf(anisotropy);
    // Factors are tried without anisotropy only.
    const best = first === 0 ? (rrmse) => Math.min(rrmse[1], ...rrmse.slice(2 * ANISOTROPIES.length)) : undefined;
    const headings = ['material', 'distance', 'rRMSE, source', 'filtered', 'ratio', best && 'best roughness', 'bias, source', 'filtered'];
    headings.push('flicker, source', 'filtered', 'ratio', 'noise of the rRMSE', 'of the flicker');
    const kept = headings.filter(Boolean);
    const lines = [`| ${kept.join(' | ')} |`, `|${kept.map(() => '---|').join('')}`];
    for (const { name, views } of results) {
        for (const distance of DISTANCES) {
            lines.push(row(name, `${distance} m`, means(views.filter((view) => view.distance === distance)), first, best));
        }
        lines.push(row(name, 'mean', means(views), first, best));
    }
    return lines.join('\n');
}

/** Measures one material, and writes a sheet of its pictures under the first sun: truth, source and filtered. */
async function material(page, folder) {
    const name = basename(folder);
    console.error(`${name}: filtering`);
    const { source, filtered } = await models(folder);
    console.error(`${name}: drawing`);
    const variants = [
        ...ANISOTROPIES.flatMap((anisotropy) => [source, filtered].map((model) => ({ model, anisotropy, roughness: 1 }))),
        ...FACTORS.map((roughness) => ({ model: filtered, anisotropy: 1, roughness })),
    ];
    const request = { source, variants, suns: SUNS, distances: DISTANCES, pixels: PIXELS, passes: PASSES };
    const drawn = await page.evaluate((request) => window.pictures(request), request);
    const views = drawn.map((view) => ({ distance: view.distance, ...errors(view) }));
    const shown = drawn.slice(0, DISTANCES.length).map((view, i) => [views[i].truth, view.variants[0][0], view.variants[1][0]]);
    writeFileSync(join(OUT, `${name}.png`), sheet(shown, PIXELS));
    return { name, views };
}

async function measure() {
    const chosen = folders();
    mkdirSync(OUT, { recursive: true });
    const server = await serve({ '/three/': THREE, '/src/': join(PACKAGE, 'src'), '/measure/': join(PACKAGE, 'measure'), '/models/': OUT });
    let chromium;
    try {
        chromium = await browser();
        const page = await chromium.newPage();
        page.on('pageerror', (error) => console.error(error));
        await page.goto(`${server.url}measure/`);
        await page.waitForFunction(() => window.pictures);
        const results = [];
        for (const folder of chosen) results.push(await material(page, folder));
        for (const anisotropy of ANISOTROPIES) console.log(`\nAnisotropy ${anisotropy}:\n\n${table(results, anisotropy)}`);
    } finally {
        await chromium?.close();
        await server.close();
    }
}

await run(measure);
