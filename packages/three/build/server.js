import { createReadStream, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, sep } from 'node:path';

const TYPES = {
    '.glb': 'model/gltf-binary',
    '.html': 'text/html; charset=utf-8',
    '.js': 'text/javascript; charset=utf-8',
    '.wasm': 'application/wasm',
};

/** The file for an address below one of the `mounts`, or nothing. */
export function resolve(mounts, address) {
    let path;
    try {
        path = decodeURIComponent(address.split(/[?#]/)[0]);
    } catch {
        return undefined;
    }
    if (path.endsWith('/')) path += 'index.html';
    const prefixes = Object.keys(mounts).sort((a, b) => b.length - a.length);
    const prefix = prefixes.find((candidate) => path.startsWith(candidate));
    if (prefix === undefined || path.includes('\0')) return undefined;
    const file = join(mounts[prefix], path.slice(prefix.length));
    return file.startsWith(join(mounts[prefix], sep)) ? file : undefined;
}

/**
 * Serves files to this machine. `mounts` maps prefixes of addresses to folders; the longest prefix counts.
 * Returns the address and a function that stops the server.
 */
export async function serve(mounts, port = 0) {
    const server = createServer((request, response) => {
        const file = resolve(mounts, request.url);
        if (!file || !statSync(file, { throwIfNoEntry: false })?.isFile()) {
            response.writeHead(404).end('not found');
            return;
        }
        response.writeHead(200, { 'Content-Type': TYPES[extname(file)] ?? 'application/octet-stream', 'Cache-Control': 'no-cache' });
        createReadStream(file).pipe(response);
    });
    await new Promise((done, fail) => server.once('error', fail).listen(port, '127.0.0.1', done));
    const close = () => {
        server.closeAllConnections();
        return new Promise((done) => server.close(done));
    };
    return { url: `http://127.0.0.1:${server.address().port}/`, close };
}
