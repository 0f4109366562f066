/** Bytes of `data`, followed by `fill` up to a multiple of 4, as chunks and buffer views of a .glb need. */
function padded(data, fill) {
    return Buffer.concat([data, Buffer.alloc(-data.length & 3, fill)]);
}

function chunk(type, data, fill) {
    const body = padded(data, fill);
    const header = Buffer.alloc(8);
    header.writeUInt32LE(body.length, 0);
    header.write(type, 4, 'latin1');
    return Buffer.concat([header, body]);
}

/**
 * The bytes of a glTF model: a flat rectangle of `size` metres that faces up, with one material whose pictures repeat every metre.
 * `pictures` maps names to PNG files, and `material` returns the glTF material for a function that gives a picture's texture.
 */
export function rectangle({ size: [width, height], pictures, material }) {
    const [x, z] = [width / 2, height / 2];
    const corners = [[-x, z], [x, z], [x, -z], [-x, -z]];
    const floats = (values) => Buffer.from(new Float32Array(values.flat()).buffer);
    const names = Object.keys(pictures);
    const parts = [
        floats(corners.map(([px, pz]) => [px, 0, pz])),
        floats(corners.map(() => [0, 1, 0])),
        // Columns of a picture go along +x, and rows along +z.
        floats(corners),
        Buffer.from(new Uint16Array([0, 1, 2, 0, 2, 3]).buffer),
        ...names.map((name) => pictures[name]),
    ];
    let end = 0;
    const bufferViews = parts.map((part) => {
        const view = { buffer: 0, byteOffset: end, byteLength: part.length };
        end += padded(part, 0).length;
        return view;
    });
    const [FLOAT, SHORT, REPEAT, LINEAR, TRILINEAR] = [5126, 5123, 10497, 9729, 9987];
    const json = {
        asset: { version: '2.0', generator: 'leadr-three' },
        scene: 0,
        scenes: [{ nodes: [0] }],
        nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: 0 }] }],
        accessors: [
            { bufferView: 0, componentType: FLOAT, count: 4, type: 'VEC3', min: [-x, 0, -z], max: [x, 0, z] },
            { bufferView: 1, componentType: FLOAT, count: 4, type: 'VEC3' },
            { bufferView: 2, componentType: FLOAT, count: 4, type: 'VEC2' },
            { bufferView: 3, componentType: SHORT, count: 6, type: 'SCALAR' },
        ],
        materials: [material((name) => ({ index: names.indexOf(name) }))],
        textures: names.map((_, i) => ({ sampler: 0, source: i })),
        images: names.map((name, i) => ({ name, mimeType: 'image/png', bufferView: 4 + i })),
        samplers: [{ wrapS: REPEAT, wrapT: REPEAT, magFilter: LINEAR, minFilter: TRILINEAR }],
        bufferViews,
        buffers: [{ byteLength: end }],
    };
    const extensions = Object.keys(json.materials[0].extensions ?? {});
    if (extensions.length) json.extensionsUsed = extensions;
    const body = Buffer.concat([
        chunk('JSON', Buffer.from(JSON.stringify(json)), ' '),
        chunk('BIN\0', Buffer.concat(parts.map((part) => padded(part, 0))), 0),
    ]);
    const header = Buffer.alloc(12);
    header.write('glTF', 0, 'latin1');
    header.writeUInt32LE(2, 4);
    header.writeUInt32LE(12 + body.length, 8);
    return Buffer.concat([header, body]);
}
