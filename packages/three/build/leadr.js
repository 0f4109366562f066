import { execFile } from 'node:child_process';
import { promisify } from 'node:util';

const command = process.env.LEADR_BIN ?? 'leadr';

/** Writes a model with filtered textures: `leadr bake SOURCE -o FILTERED`. */
export async function bake(source, filtered) {
    try {
        await promisify(execFile)(command, ['bake', source, '-o', filtered]);
    } catch (error) {
        if (error.code === 'ENOENT') throw new Error(`${command}: not found. Set LEADR_BIN to the path of the command leadr`);
        throw new Error(`${command} bake ${source}: ${error.stderr || error.message}`);
    }
}
