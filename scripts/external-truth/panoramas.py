"""Panoramas that light the cases: those of the shared data, and hard ones made here by formulas that
crates/leadr-lab/src/report/outside/panoramas.rs repeats."""
import numpy as np

import files

WIDTH, HEIGHT = 1024, 512
SHARED = {
    "spiaggia": "spiaggia_di_mondello_1k",
    "spruit": "spruit_sunrise_1k",
    "studio": "studio_pmndrs_1k",
    "night": "night_pmndrs_1k",
}
CUT = 4.0  # radiance above which the soft panorama is cut


def directions():
    """Unit directions of the texel centres: u = 1/2 - azimuth / 2 pi, v = angle from +z / pi."""
    azimuth = (0.5 - (np.arange(WIDTH) + 0.5) / WIDTH) * 2 * np.pi
    polar = (np.arange(HEIGHT)[:, None] + 0.5) / HEIGHT * np.pi
    return np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)), -1)


def dusk():
    """A sky that is brighter near its top, over brown ground."""
    z = directions()[..., 2:]
    return np.where(z > 0, np.array([0.25, 0.35, 0.55]) * (0.4 + 0.6 * z), np.array([0.20, 0.17, 0.13]))


def pixel():
    """One texel of 100,000 in the dusk."""
    radiance = dusk()
    radiance[150, 300] = [1e5, 9e4, 8e4]
    return radiance


def tubes():
    """A row of eight upright tubes, two texels (0.7 degrees) wide and 35 degrees long."""
    radiance = 0.2 * dusk()
    for k in range(8):
        radiance[120:220, 200 + 24 * k : 202 + 24 * k] = [[160, 200, 240], [240, 200, 160]][k % 2]
    return radiance


def lamps():
    """Discs of equal flux and half angles of 1 to 16 degrees, each of another colour."""
    radiance, d = 0.05 * dusk(), directions()
    for k, color in enumerate(([1, 0.3, 0.2], [0.3, 1, 0.3], [0.3, 0.4, 1], [1, 0.9, 0.3], [0.8, 0.8, 0.8])):
        azimuth, height, half = np.radians(70.0 * k - 150), np.radians(20.0 + 12 * k), np.radians(2.0**k)
        centre = [np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)]
        radiance = np.where((d @ centre > np.cos(half))[..., None], np.array(color) / (1 - np.cos(half)) / 10, radiance)
    return radiance


def checks():
    """Bright and dark squares of 11.25 degrees: much detail and no lamp."""
    bright = (np.arange(HEIGHT)[:, None] // 32 + np.arange(WIDTH) // 32) % 2 == 0
    return np.where(bright[..., None], [1.6, 1.5, 1.4], [0.08, 0.1, 0.12])


MADE = {"pixel": pixel, "tubes": tubes, "lamps": lamps, "checks": checks}
NAMES = ["spiaggia", "spruit", "studio", "night", "soft", *MADE]


def path(name):
    """The file of a panorama, made if it is not there; `None` if it needs shared data that is not there."""
    out = files.OUT / "panoramas" / f"{name}.exr"
    if name in SHARED:
        return files.shared(f"env/{SHARED[name]}.hdr")
    if not out.exists():
        if name == "soft":  # the first panorama without its sun
            source = path("spiaggia")
            if source is None:
                return None
            radiance = files.load(source)
            radiance = radiance * np.minimum(1, CUT / np.maximum(radiance.max(-1, keepdims=True), 1e-9))
        else:
            radiance = MADE[name]()
        files.save(out, radiance)
    return out
