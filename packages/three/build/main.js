import { join } from 'node:path';
import { PACKAGE } from './paths.js';
import { run } from './run.js';
import { site } from './site.js';

await run(async () => {
    await site(join(PACKAGE, 'dist'));
    console.log('wrote dist/. Look at it with: npm start');
});
