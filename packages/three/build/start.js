import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { PACKAGE } from './paths.js';
import { run } from './run.js';
import { serve } from './server.js';

await run(async () => {
    const folder = join(PACKAGE, 'dist');
    if (!existsSync(join(folder, 'models'))) throw new Error('dist/ is missing or incomplete. Build it with: npm run build');
    const { url } = await serve({ '/': folder }, Number(process.env.PORT ?? 8080));
    console.log(`open ${url}`);
});
