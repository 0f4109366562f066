"""Base materials: the plane's own, uniform ones of other albedos, and gold."""
from dataclasses import dataclass

import numpy as np

import files

# Linear, and 8-bit where colours of vertices reach leadr's shaders.
PLAIN = tuple(round(c * 255) / 255 for c in (0.27, 0.23, 0.19))


@dataclass(frozen=True)
class Base:
    albedo: tuple = PLAIN  # of the diffuse term; metals have none
    f0: tuple = (0.04, 0.04, 0.04)
    metal: bool = False


def decoded(codes):
    """Linear colour of 8-bit sRGB codes."""
    c = np.array(codes) / 255
    return tuple(np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4).tolist())


# sRGB codes of the uniform colour images: albedo 0.5 and 0.9, and the reflectance of gold at normal incidence.
CODES = {"half": (188, 188, 188), "bright": (243, 243, 243), "gold": (255, 219, 147)}
BASES = {
    "plain": Base(),
    "half": Base(decoded(CODES["half"])),
    "bright": Base(decoded(CODES["bright"])),
    "gold": Base((0.0, 0.0, 0.0), decoded(CODES["gold"]), True),
}


def flags(name):
    """How leadr is asked for a base. A metal comes from a folder, since `--metal` adds an edge tint to Schlick's approximation."""
    if name == "plain":
        return []
    folder = files.OUT / "bases" / name
    images = {"Color": CODES[name], "Metalness": [255 * BASES[name].metal]}
    for role, codes in images.items():
        out = folder / f"{name}_{role}.png"
        if not out.exists():
            files.save_codes(out, np.broadcast_to(np.array(codes, np.uint8), (16, 16, len(codes))))
    return ["--material", folder]
