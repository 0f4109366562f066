"""Height maps: those of the shared data, reduced by box means, and others made here by formulas. The report repeats that of `studs`
in crates/leadr-lab/src/report/outside/reliefs.rs; the last five resemble scans of buildings and fabrics."""
import numpy as np

import files

TEXELS = 256  # along a side
REPEAT = 2.0  # metres along a side
HEIGHT = 0.12  # metres from black to white at scale 1
SHARED = {
    "rock": "Rock003",
    "walkway": "MetalWalkway006",
    "leather": "Leather027",
    "sheet": "SheetMetal001",
    "ground": "Ground054",
}
COARSE = {"rock64": ("rock", 64)}  # the same with fewer texels


def studs():
    """Round studs of eight sizes and a slow wave: steep sides, deep gaps, no noise."""
    at = (np.arange(TEXELS) + 0.5) / TEXELS
    x, y = np.meshgrid(at * 8, at * 8)
    i, j = np.floor(x), np.floor(y)
    radius = 0.26 + 0.03 * np.mod(3 * i + 5 * j, 8)
    square = np.maximum(1 - ((x - i - 0.5) ** 2 + (y - j - 0.5) ** 2) / radius**2, 0)
    return 0.25 + 0.6 * radius * np.sqrt(square) / 0.47 + 0.1 * np.sin(2 * np.pi * (x + 2 * y) / 8)


def cells(across, along, shift=0.0):
    """Texels in rows of cells: indices of column and row, and the position in the cell from 0 to 1. Odd rows start `shift` later."""
    at = (np.arange(TEXELS) + 0.5) / TEXELS
    x, y = np.meshgrid(at * across, at * along)
    j = np.floor(y)
    x = np.mod(x - shift * np.mod(j, 2), across)
    i = np.floor(x)
    return i, j, x - i, y - j


def varied(i, j, seed):
    """A number from -1 to 1 for each cell."""
    return np.random.default_rng(seed).uniform(-1, 1, (64, 64))[i.astype(int), j.astype(int)]


def grain(slope, seed):
    """Noise whose slopes deviate by `slope` along each axis, in metres, smooth over two texels."""
    f = np.fft.fftfreq(TEXELS)
    low = np.exp(-8 * np.pi**2 * (f[:, None] ** 2 + f**2))
    h = np.fft.ifft2(np.fft.fft2(np.random.default_rng(seed).normal(size=(TEXELS, TEXELS))) * low).real
    return h * slope / np.sqrt(np.mean(slope_variance(h)))


def tiles():
    """Overlapping roof tiles. Each rises towards its front edge, over an off-centre ridge; fronts fall at slopes of -0.9 or -1.5."""
    across, along = 8, 6
    i, j, u, v = cells(across, along, 0.5)
    course = REPEAT / along
    rise = 0.25 + 0.02 * varied(i, j, 1)
    fall = np.where(varied(i, j, 2) > 0, 0.9, 1.5)
    front = rise / (rise + fall)  # share of the course in which the tile falls back to its own start
    tilt = course * np.minimum(rise * v, fall * (1 - v))
    ridge = 0.035 * np.sin(np.pi * np.where(u < 0.35, u / 0.7, 0.5 + (u - 0.35) / 1.3)) ** 2
    return tilt + ridge * np.minimum(1, (1 - v) / front) + grain(0.04, 3)


def bricks():
    """Flat, slightly tilted bricks between grooves of mortar."""
    across, along = 6, 12
    i, j, u, v = cells(across, along, 0.5)
    edge = np.minimum(np.minimum(u, 1 - u) * REPEAT / across, np.minimum(v, 1 - v) * REPEAT / along)
    wall = np.clip((edge - 0.008) / 0.012, 0, 1)
    face = 0.018 + 0.004 * varied(i, j, 4) + 0.008 * varied(i, j, 5) * (u - 0.5) + 0.005 * varied(i, j, 6) * (v - 0.5)
    return face * wall + grain(0.07, 7)


def shingles():
    """Flat shingles of uneven thickness, each over the next, with steep fronts and gaps."""
    across, along = 10, 8
    i, j, u, v = cells(across, along, 0.5)
    thick = 0.022 + 0.006 * varied(i, j, 8)
    front = np.clip((1 - v) * REPEAT / along / 0.015, 0, 1)
    side = np.clip((np.minimum(u, 1 - u) * REPEAT / across - 0.003) / 0.008, 0, 1)
    return thick * (0.3 + 0.7 * v) * front * (0.5 + 0.5 * side) + grain(0.06, 9)


def weave():
    """A plain weave with an even period, 16 texels."""
    across = TEXELS // 8
    i, j, u, v = cells(across, across)
    over = np.where(np.mod(i + j, 2) == 0, 1.0, -1.0)
    along_x = over * np.sin(np.pi * u) + np.sin(np.pi * v)
    along_y = -over * np.sin(np.pi * v) + np.sin(np.pi * u)
    return 0.012 * np.maximum(along_x, along_y)


def blocks():
    """Square blocks of two heights, whose walls are one texel wide."""
    i, j, _, _ = cells(16, 16)
    return np.where(varied(i, j, 10) > 0, 0.05, 0.0)


MADE = {"tiles": tiles, "bricks": bricks, "shingles": shingles, "weave": weave, "blocks": blocks}  # metres at scale 1


def heights(name):
    """Heights from 0 to 1, row 0 first; `None` if they need shared data that is not there."""
    if name == "studs":
        return studs().astype(np.float32).astype(np.float64)
    if name in MADE:
        return (MADE[name]() / HEIGHT).astype(np.float32).astype(np.float64)
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
    """The file that leadr is given. It lays the last row of a map at y = 0, the truth the first."""
    out = files.OUT / "reliefs" / f"{name}.exr"
    if not out.exists():
        files.save(out, heights(name)[::-1, :, None])
    return out


def slope_variance(h):
    """Variance along x and along y of the slopes of the triangles, `h` in metres.

    Two of a cell's four triangles have the slope of an edge, the other two the mean of the slopes of both edges along the axis."""
    texel = REPEAT / len(h)
    edges = [(np.roll(h, -1, axis) - h) / texel for axis in (1, 0)]
    return [float(0.5 * (e**2 + (0.5 * (e + np.roll(e, -1, axis))) ** 2).mean()) for axis, e in enumerate(edges)]
