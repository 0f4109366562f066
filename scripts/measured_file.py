"""Compares Mitsuba's `measured` material with the RGB table of the same file, for a file that `leadr fit --export FILE.bsdf` wrote.

    pip install mitsuba numpy
    python3 scripts/measured_file.py FILE.bsdf

Each pair of directions has one value per wavelength of the file. The table has three colours, whose spectra are in
crates/leadr-measured/src/rgl_write.rs. The values agree if Mitsuba reads the file as `leadr fit` does.
"""

import struct
import sys

import mitsuba as mi
import numpy as np

GREEN = np.array([0, 0, 0, 0, .25748, .75077, 1, 1, 1, .78922, .20421, 0, 0, 0, 0, 0])
BLUE = np.array([.80912, .90406, .98916, 1, .74252, .24923, 0, 0, 0, .07294, .00191, 0, 0, 0, 0, 0])


def arrays(path):
    """The float arrays of a tensor file."""
    data = open(path, 'rb').read()
    at, found = 18, {}
    for _ in range(struct.unpack_from('<I', data, 14)[0]):
        length, = struct.unpack_from('<H', data, at)
        name = data[at + 2:at + 2 + length].decode()
        at += 2 + length
        axes, kind, offset = struct.unpack_from('<HBQ', data, at)
        shape = struct.unpack_from(f'<{axes}Q', data, at + 11)
        at += 11 + 8 * axes
        if kind == 10:
            found[name] = np.frombuffer(data, np.float32, int(np.prod(shape)), offset).reshape(shape).astype(float)
    return found


def cell(g, x, y):
    h, w = g.shape
    x, y = np.clip(x, 0, 1) * (w - 1), np.clip(y, 0, 1) * (h - 1)
    i, j = min(int(x), w - 2), min(int(y), h - 2)
    return i, j, x - i, y - j


def bilinear(g, x, y):
    i, j, fx, fy = cell(g, x, y)
    return (1 - fy) * ((1 - fx) * g[j, i] + fx * g[j, i + 1]) + fy * ((1 - fx) * g[j + 1, i] + fx * g[j + 1, i + 1])


def sums(v):
    return np.concatenate([[0], np.cumsum(.5 * (v[:-1] + v[1:]))])


def shares(g, x, y):
    """Cumulative sums of a density: before the row, in the row before the point, and over the row."""
    i, j, fx, fy = cell(g, x, y)
    rows = .5 * (g[:, :-1] + g[:, 1:]).sum(1)
    before_rows = sums(rows)
    row = (1 - fy) * g[j] + fy * g[j + 1]
    before = sums(row)
    whole = before_rows[j] + fy * (rows[j] + .5 * fy * (rows[j + 1] - rows[j]))
    return np.array([whole, before[i] + fx * (row[i] + .5 * fx * (row[i + 1] - row[i])), before[-1]]) / before_rows[-1]


def value(a, wi, wo):
    """The reflected colour of an isotropic file, with the cosine of wo."""
    m = (wi + wo) / np.linalg.norm(wi + wo)
    theta_i, theta_m = np.arccos(wi[2]), np.arccos(m[2])
    phi_i, phi_m = np.arctan2(wi[1], wi[0]), np.arctan2(m[1], m[0])
    angles = a['theta_i']
    k = int(np.clip(np.searchsorted(angles, theta_i) - 1, 0, len(angles) - 2))
    t = np.clip((theta_i - angles[k]) / (angles[k + 1] - angles[k]), 0, 1)
    u = np.sqrt(theta_m * 2 / np.pi), ((phi_m - phi_i + np.pi) / (2 * np.pi)) % 1
    rows, before, row = (1 - t) * shares(a['vndf'][0, k], *u) + t * shares(a['vndf'][0, k + 1], *u)
    table = (1 - t) * a['rgb'][0, k] + t * a['rgb'][0, k + 1]
    color = np.array([bilinear(channel, before / row, rows) for channel in table])
    sigma = bilinear(a['sigma'], np.sqrt(theta_i * 2 / np.pi), (phi_i + np.pi) / (2 * np.pi))
    return color * bilinear(a['ndf'], *u) / (4 * sigma)


def main(path):
    mi.set_variant('scalar_spectral')
    a, bsdf = arrays(path), mi.load_dict({'type': 'measured', 'filename': path})
    random, context, at = np.random.default_rng(2), mi.BSDFContext(), mi.SurfaceInteraction3f()

    def above():
        z, phi = random.uniform(.2, 1), random.uniform(0, 2 * np.pi)
        return np.array([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z])

    wrong, whole = 0, 0
    for n in range(400):
        wi, wo = above(), above()
        if n % 2:  # near the mirror direction
            wo = wi * [-1, -1, 1] + .1 * random.normal(size=3)
            wo[2] = abs(wo[2])
            wo /= np.linalg.norm(wo)
        r, g, b = value(a, wi, wo)
        spectrum = r * (1 - GREEN - BLUE) + g * GREEN + b * BLUE
        at.wi, found = wi, []
        for i in range(0, 16, 4):
            at.wavelengths = [float(w) for w in a['wavelengths'][i:i + 4]]
            found += list(bsdf.eval(context, at, wo))
        wrong += ((np.array(found) - spectrum) ** 2).sum()
        whole += (spectrum ** 2).sum()
    print(f'relative rms difference {np.sqrt(wrong / whole):.1e}')


main(sys.argv[1])
