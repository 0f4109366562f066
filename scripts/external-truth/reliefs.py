"""Height maps: those of the shared data, reduced by box means, and one made here by a formula that
crates/leadr-lab/src/report/outside/reliefs.rs repeats."""
import numpy as np

import files

TEXELS = 256  # along a side
REPEAT = 2.0  # metres along a side
HEIGHT = 0.12  # metres from black to white at scale 1
SHARED = {"rock": "Rock003", "walkway": "MetalWalkway006", "leather": "Leather027"}
COARSE = {"rock64": ("rock", 64)}  # the same with fewer texels


def studs():
    """Round studs of eight sizes and a slow wave: steep sides, deep gaps, no noise."""
    at = (np.arange(TEXELS) + 0.5) / TEXELS
    x, y = np.meshgrid(at * 8, at * 8)
    i, j = np.floor(x), np.floor(y)
    radius = 0.26 + 0.03 * np.mod(3 * i + 5 * j, 8)
    square = np.maximum(1 - ((x - i - 0.5) ** 2 + (y - j - 0.5) ** 2) / radius**2, 0)
    return 0.25 + 0.6 * radius * np.sqrt(square) / 0.47 + 0.1 * np.sin(2 * np.pi * (x + 2 * y) / 8)


def heights(name):
    """Heights from 0 to 1, row 0 first; `None` if they need shared data that is not there."""
    if name == "studs":
        return studs().astype(np.float32).astype(np.float64)
    name, side = COARSE.get(name, (name, TEXELS))
    source = files.shared(f"displacement/{SHARED[name]}/{SHARED[name]}_1K-PNG_Displacement.png")
    if source is None:
        return None
    raw = files.codes(source)
    texels = raw.astype(np.float64) / np.iinfo(raw.dtype).max
    texels = texels[..., 0] if texels.ndim == 3 else texels
    k = texels.shape[0] // side
    return texels.reshape(side, k, side, k).mean((1, 3)).astype(np.float32).astype(np.float64)


def path(name):
    """The file that leadr is given."""
    out = files.OUT / "reliefs" / f"{name}.exr"
    if not out.exists():
        files.save(out, heights(name)[..., None])
    return out


def slope_variance(h):
    """Variance along x and along y of the slopes of the triangles (both diagonals' mean), `h` in metres.

    A triangle's slope along an axis is that of its edge along that axis, and each edge bounds two triangles."""
    texel = REPEAT / len(h)
    return [float((((np.roll(h, -1, axis) - h) / texel) ** 2).mean()) for axis in (1, 0)]
