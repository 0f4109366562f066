import * as THREE from 'three';
import { daylight, modelLoader } from '/src/index.js';

const FIELD = 10;
/** Direction from the target to the camera, as in the repository's comparison of filters. */
const VIEW = new THREE.Vector3(0, 0.6, 0.8);
/** The truth has this many samples along each side of a pixel, for each of its passes. */
const SIDE = 16;

const renderer = new THREE.WebGLRenderer();
const loader = modelLoader(renderer, '/three/examples/jsm/libs/basis/');

/** Element `i` of the van der Corput sequence in a base: positions of the samples of successive passes. */
function radicalInverse(i, base) {
    let [value, digit] = [0, 1 / base];
    for (; i > 0; i = Math.floor(i / base), digit /= base) value += (i % base) * digit;
    return value;
}

function materialsOf(object) {
    const materials = new Set();
    object.traverse(({ material }) => material && materials.add(material));
    return [...materials];
}

function texturesOf(object) {
    return new Set(materialsOf(object).flatMap((material) => Object.values(material).filter((value) => value?.isTexture)));
}

/** Linear RGB of a view. `side` samples along each side of a pixel, moved by `jitter` of a sample, are averaged. */
function draw(scene, camera, pixels, side = 1, jitter = [0, 0]) {
    const size = pixels * side;
    const target = new THREE.WebGLRenderTarget(size, size, { type: THREE.FloatType });
    camera.setViewOffset(size, size, ...jitter, size, size);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    const texels = new Float32Array(4 * size * size);
    renderer.readRenderTargetPixels(target, 0, 0, size, size, texels);
    target.dispose();
    const means = new Float64Array(3 * pixels * pixels);
    for (let i = 0; i < size * size; i++) {
        const pixel = Math.floor(i / size / side) * pixels + Math.floor((i % size) / side);
        for (let c = 0; c < 3; c++) means[3 * pixel + c] += texels[4 * i + c] / (side * side);
    }
    return means;
}

/** The mean of pictures with different positions of samples: `from`, `from + 2`, … of the passes. */
function half(scene, camera, pixels, passes, from) {
    const sum = new Float64Array(3 * pixels * pixels);
    for (let pass = from; pass < passes; pass += 2) {
        const jitter = [2, 3].map((base) => radicalInverse(pass + 1, base) - 0.5);
        draw(scene, camera, pixels, SIDE, jitter).forEach((value, i) => (sum[i] += value / (passes / 2)));
    }
    return sum;
}

function view(distance, moved) {
    const camera = new THREE.PerspectiveCamera(FIELD, 1, 0.1, 200);
    camera.position.copy(VIEW).multiplyScalar(distance);
    camera.lookAt(0, 0, 0);
    camera.position.x += moved;
    return camera;
}

/**
 * Pictures of the `variants` of a model under a sun, each from two cameras a third of a pixel apart, and the truth.
 * A variant is a model's address, its `anisotropy` of texture lookups, and a factor of its
 * roughness.
 * The truth is drawn from the finest level of the textures of `source`, in two halves of `passes / 2` pictures.
 */
window.pictures = async ({ source, variants, suns, distances, pixels, passes }) => {
    const scenes = await Promise.all(
        [{ model: source, anisotropy: 1, roughness: 1 }, ...variants].map(async ({ model, anisotropy, roughness }) => {
            const scene = new THREE.Scene();
            scene.add((await loader.loadAsync(model)).scene);
            for (const texture of texturesOf(scene)) texture.anisotropy = anisotropy;
            for (const material of materialsOf(scene)) {
                material.roughness *= roughness;
                if (material.clearcoatRoughness) material.clearcoatRoughness *= roughness;
            }
            return scene;
        }),
    );
    const [truth, ...others] = scenes;
    for (const texture of texturesOf(truth)) Object.assign(texture, { minFilter: THREE.LinearFilter, generateMipmaps: false });
    daylight(renderer, ...scenes);
    const light = (direction) =>
        scenes.forEach((scene) => scene.traverse((object) => object.isDirectionalLight && object.position.set(...direction)));
    const pixel = (2 * Math.tan((FIELD / 360) * Math.PI)) / pixels;
    return suns.flatMap((sun) => {
        light(sun);
        return distances.map((distance) => {
            const cameras = [0, (pixel * distance) / 3].map((moved) => view(distance, moved));
            const pair = (picture) => cameras.map((camera) => Array.from(picture(camera)));
            return {
                distance,
                halves: [0, 1].map((from) => pair((camera) => half(truth, camera, pixels, passes, from))),
                variants: others.map((scene) => pair((camera) => draw(scene, camera, pixels))),
            };
        });
    });
};
