export { Comparison } from './comparison.js';
export { modelLoader } from './loader.js';
export { daylight, SUN } from './daylight.js';
