import { join } from 'node:path';
import { PACKAGE } from './paths.js';
import { site } from './site.js';

await site(join(PACKAGE, 'dist'));
console.log('wrote dist/. Look at it with: npm start');
