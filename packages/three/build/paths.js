import { fileURLToPath } from 'node:url';

const at = (path) => fileURLToPath(new URL(path, import.meta.url));

/** This package, three.js, and the repository. */
export const PACKAGE = at('..');
export const THREE = at('../node_modules/three/');
export const REPOSITORY = at('../../..');
