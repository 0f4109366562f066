import * as THREE from 'three';

/** Direction towards the sun, and its irradiance on a surface that faces it. */
export const SUN = { direction: new THREE.Vector3(0.35, 0.7, -0.6).normalize(), irradiance: 6 };

const ZENITH = [0.25, 0.45, 0.9];
const HORIZON = [0.9, 0.95, 1];
const GROUND = [0.12, 0.1, 0.08];
const ROWS = 128;

/** Radiance of the sky or the ground at the sine of an elevation. The transition at the horizon is smooth. */
function radiance(sine) {
    const up = Math.max(sine, 0) ** 0.6;
    const below = THREE.MathUtils.smoothstep(-sine, 0, 0.15);
    return ZENITH.map((zenith, i) => THREE.MathUtils.lerp(THREE.MathUtils.lerp(HORIZON[i], zenith, up), GROUND[i], below));
}

/** Gives `scene` a sky over dark ground, which three.js prefilters, and a sun without an extent. */
export function daylight(renderer, ...scenes) {
    const texels = new Float32Array(ROWS * 2 * ROWS * 4);
    for (let row = 0; row < ROWS; row++) {
        const color = radiance(-Math.cos((Math.PI * (row + 0.5)) / ROWS));
        for (let column = 0; column < 2 * ROWS; column++) texels.set([...color, 1], (row * 2 * ROWS + column) * 4);
    }
    const sky = new THREE.DataTexture(texels, 2 * ROWS, ROWS, THREE.RGBAFormat, THREE.FloatType);
    sky.mapping = THREE.EquirectangularReflectionMapping;
    sky.minFilter = sky.magFilter = THREE.LinearFilter;
    sky.needsUpdate = true;
    const prefilter = new THREE.PMREMGenerator(renderer);
    const environment = prefilter.fromEquirectangular(sky).texture;
    prefilter.dispose();
    for (const scene of scenes) {
        const sun = new THREE.DirectionalLight(0xffffff, SUN.irradiance);
        sun.position.copy(SUN.direction);
        scene.add(sun);
        scene.environment = environment;
        scene.background = sky;
    }
}
