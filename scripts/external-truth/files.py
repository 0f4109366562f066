"""Where pictures come from and go to. LEADR_SHARED leads to the shared data, as for the tests; OUT is set by the command."""
import os
from pathlib import Path

import mitsuba as mi
import numpy as np

OUT = Path()
REPOSITORY = Path(__file__).resolve().parents[2]


def shared(name):
    """A file of the shared data, or `None`."""
    root = os.environ.get("LEADR_SHARED")
    found = Path(root) / "data" / name if root else None
    return found if found is not None and found.exists() else None


def save(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    mi.Bitmap(np.ascontiguousarray(array, dtype=np.float32)).write(str(path))


def save_codes(path, array):
    """8-bit codes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    mi.Bitmap(np.ascontiguousarray(array)).write(str(path))


def load(path):
    """Linear RGB."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(bitmap).astype(np.float64)


def channels(path):
    """All channels of an EXR by name."""
    bitmap = mi.Bitmap(str(path))
    names = [field.name for field in bitmap.struct_()]
    texels = np.array(bitmap).astype(np.float64).reshape(bitmap.height(), bitmap.width(), -1)
    return {name: texels[..., i] for i, name in enumerate(names)}


def codes(path):
    return np.array(mi.Bitmap(str(path)))
