import { cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, posix } from 'node:path';
import { rectangle } from './glb.js';
import { bake } from './leadr.js';
import { pictures, standard } from './material.js';
import { PACKAGE, REPOSITORY, THREE } from './paths.js';

/** Parts of three.js that no import names: the decoder of KTX2 files. */
const DECODER = ['examples/jsm/libs/basis/basis_transcoder.js', 'examples/jsm/libs/basis/basis_transcoder.wasm'];

const importsOf = (source) => [...source.matchAll(/(?:from|import)\s+'([^']+)'/g)].map(([, target]) => target);

/** The path of an import within three.js, or nothing for modules of the page. */
function inThree(target, importer) {
    if (target === 'three') return 'build/three.module.js';
    if (target.startsWith('three/addons/')) return target.replace('three/addons/', 'examples/jsm/');
    return importer && target.startsWith('.') ? posix.join(posix.dirname(importer), target) : undefined;
}

/** All files of three.js that these modules of the page import, directly or through others. */
export function partsOfThree(modules) {
    const found = new Set();
    const open = modules.flatMap((file) => importsOf(readFileSync(file, 'utf8')).map((target) => inThree(target)));
    while (open.length) {
        const part = open.pop();
        if (part === undefined || found.has(part)) continue;
        found.add(part);
        open.push(...importsOf(readFileSync(join(THREE, part), 'utf8')).map((target) => inThree(target, part)));
    }
    return [...found, ...DECODER].sort();
}

/** Writes the models of the page, each with its filtered copy: two floors of bricks, and the snail. */
async function models(folder) {
    mkdirSync(folder, { recursive: true });
    const bricks = pictures(join(REPOSITORY, 'assets/bricks'));
    const floor = (varnish) => rectangle({ size: [24, 24], pictures: bricks, material: standard({ varnish }) });
    const snail = readFileSync(join(REPOSITORY, 'assets/snail.glb'));
    for (const [name, model] of Object.entries({ varnished: floor(true), bricks: floor(false), snail })) {
        const source = join(folder, `${name}.glb`);
        writeFileSync(source, model);
        await bake(source, join(folder, `${name}-filtered.glb`));
    }
}

/** Writes the page with everything that it loads, so that any static host can serve the folder. */
export async function site(folder) {
    const sources = ['index', 'comparison', 'daylight', 'loader', 'page'].map((name) => `src/${name}.js`);
    for (const file of ['index.html', ...sources]) cpSync(join(PACKAGE, file), join(folder, file));
    for (const part of partsOfThree(sources.map((file) => join(PACKAGE, file)))) {
        mkdirSync(dirname(join(folder, 'three', part)), { recursive: true });
        cpSync(join(THREE, part), join(folder, 'three', part));
    }
    cpSync(join(THREE, 'LICENSE'), join(folder, 'three/LICENSE'));
    await models(join(folder, 'models'));
}
