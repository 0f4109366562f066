import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Comparison, daylight, modelLoader } from './index.js';

/** The models, as `npm run build` names them, and the range of the camera's distance in metres. */
const MODELS = {
    varnished: { label: 'Varnished bricks', distances: [0.2, 40] },
    bricks: { label: 'Bricks', distances: [0.2, 40] },
    snail: { label: 'Snail', distances: [0.06, 0.6] },
};
const FIELD = 40;
/** Direction from the target to the camera: oblique, opposite to the sun. */
const VIEW = new THREE.Vector3(-0.35, 0.5, 0.6).normalize();

const at = (id) => document.getElementById(id);
const [line, distance, model, turn, message] = ['line', 'distance', 'model', 'turn', 'message'].map(at);
const canvas = document.querySelector('canvas');

/** Says in the page what went wrong. `document.body.dataset.state` is `loading`, `ready` or `failed`. */
function fail(text) {
    document.body.dataset.state = 'failed';
    message.textContent = text;
}

function start() {
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.toneMapping = THREE.ACESFilmicToneMapping;
    renderer.toneMappingExposure = 0.6;
    const scenes = [new THREE.Scene(), new THREE.Scene()];
    daylight(renderer, ...scenes);
    const comparison = new Comparison(renderer, ...scenes);
    const loader = modelLoader(renderer, './three/examples/jsm/libs/basis/');
    const camera = new THREE.PerspectiveCamera(FIELD, 1, 0.01, 200);
    camera.position.copy(VIEW);
    const controls = new OrbitControls(camera, canvas);
    let shown = [];
    let range = MODELS[Object.keys(MODELS)[0]].distances;

    let waiting = false;
    /** Draws in the next frame. Nothing is drawn while nothing changes. */
    function redraw() {
        if (waiting) return;
        waiting = true;
        requestAnimationFrame(() => {
            waiting = false;
            if (controls.autoRotate) controls.update();
            comparison.draw(camera);
        });
    }

    function place(split) {
        comparison.split = THREE.MathUtils.clamp(split, 0, 1);
        line.style.left = `${100 * comparison.split}%`;
        line.setAttribute('aria-valuenow', Math.round(100 * comparison.split));
        redraw();
    }

    function resize() {
        renderer.setSize(window.innerWidth, window.innerHeight);
        camera.aspect = window.innerWidth / window.innerHeight;
        camera.updateProjectionMatrix();
        redraw();
    }

    /** Equal steps of the slider multiply the distance by equal factors. */
    function move() {
        const [near, far] = range;
        const metres = near * (far / near) ** distance.valueAsNumber;
        camera.position.sub(controls.target).setLength(metres).add(controls.target);
        controls.update();
        redraw();
    }

    function follow() {
        const metres = controls.getDistance();
        const [near, far] = range;
        distance.valueAsNumber = Math.log(metres / near) / Math.log(far / near);
        at('metres').textContent = `${metres.toPrecision(2)} m`;
        redraw();
    }

    let loading = 0;
    async function load() {
        const name = model.value;
        const turnOfThisLoad = ++loading;
        document.body.dataset.state = 'loading';
        message.textContent = 'Loading…';
        const read = (file) =>
            loader.loadAsync(`./models/${file}`).catch((error) => {
                throw new Error(`models/${file}: ${error.message}. Build the page with: npm run build`);
            });
        try {
            const loaded = await Promise.all([read(`${name}.glb`), read(`${name}-filtered.glb`)]);
            // Another model may have been chosen in the meantime.
            if (turnOfThisLoad !== loading) return;
            shown.forEach((old) => old.removeFromParent());
            shown = loaded.map((gltf) => gltf.scene);
            shown.forEach((object, i) => scenes[i].add(object));
            range = MODELS[name].distances;
            [controls.minDistance, controls.maxDistance] = range;
            const middle = new THREE.Box3().setFromObject(shown[0]).getCenter(new THREE.Vector3());
            camera.position.sub(controls.target).add(middle);
            controls.target.copy(middle);
            await Promise.all(scenes.map((scene) => renderer.compileAsync(scene, camera)));
            move();
            comparison.draw(camera);
            message.textContent = '';
            document.body.dataset.state = 'ready';
        } catch (error) {
            if (turnOfThisLoad === loading) fail(error.message);
        }
    }

    line.addEventListener('pointerdown', (event) => line.setPointerCapture(event.pointerId));
    line.addEventListener('pointermove', (event) => {
        if (line.hasPointerCapture(event.pointerId)) place(event.clientX / window.innerWidth);
    });
    line.addEventListener('keydown', (event) => {
        const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
        if (step) place(comparison.split + step);
    });
    distance.addEventListener('input', move);
    turn.addEventListener('change', () => {
        controls.autoRotate = turn.checked;
        redraw();
    });
    // Not below the floor.
    controls.maxPolarAngle = 0.48 * Math.PI;
    controls.autoRotateSpeed = 0.5;
    controls.addEventListener('change', follow);
    model.addEventListener('change', load);
    window.addEventListener('resize', resize);

    for (const [name, { label }] of Object.entries(MODELS)) model.add(new Option(label, name));
    distance.valueAsNumber = 0.75;
    resize();
    place(0.5);
    load();
}

try {
    start();
} catch (error) {
    fail(error.message);
}
