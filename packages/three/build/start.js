import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { PACKAGE } from './paths.js';
import { serve } from './server.js';

const folder = join(PACKAGE, 'dist');
if (!existsSync(join(folder, 'index.html'))) throw new Error('dist/ is missing. Build it with: npm run build');
const { url } = await serve({ '/': folder }, Number(process.env.PORT ?? 8080));
console.log(`open ${url}`);
