"""What is compared: spheres, flat planes and reliefs under panoramas."""
import fnmatch
import math
from dataclasses import dataclass, replace

import numpy as np

import bases
import panoramas
import reliefs
import truth

ALPHAS = [0.05, 0.1, 0.3, 0.6]
# angle to the normal, distance (m), field of view (degrees), size, samples per pixel at most, noise at which they end
VIEWS = {
    "near": (45, 0.6, 35, (96, 64), 4096, 0.01),
    "mid": (45, 3.2, 35, (96, 64), 4096, 0.01),
    "far": (45, 8.6, 25, (72, 48), 16384, 0.006),
    "oblique": (75, 15.0, 6, (72, 48), 16384, 0.006),
}
# name: relief, scale, panorama
PLANES = {
    "rock": ("rock", 1.0, "spiaggia"),
    "rock-sunless": ("rock", 1.0, "soft"),
    "walkway": ("walkway", 0.3, "spruit"),
    "leather": ("leather", 0.2, "soft"),
    "studs": ("studs", 1.0, "pixel"),
    "studs-sunless": ("studs", 1.0, "checks"),
}
# Reliefs whose slopes are not Gaussian, and three whose slopes are. Name: scale.
CLASSES = {
    "walkway": 0.3,
    "sheet": 0.5,
    "studs": 1.0,
    "tiles": 1.0,
    "bricks": 1.0,
    "shingles": 1.0,
    "weave": 1.0,
    "blocks": 1.0,
    "rock": 1.0,
    "ground": 0.5,
    "leather": 0.2,
}
FEWER = (18, 12)  # pixels
SUNS = {"sunny": "spiaggia", "sunless": "soft"}
# What is asked of a relief: base, terms, and the length of the truth's paths.
ASKED = {
    "all": ("half", "all", 2),
    "specular": ("half", "specular", 2),
    "metal": ("gold", "specular", 2),
    "bounces-0.5": ("half", "all", 8),
    "bounces-0.9": ("bright", "all", 8),
}
# Bases below a clear coat, their terms, and roughnesses of the coat. Smooth coats over relief have the first.
COATED = {"half": ("all", [0.05, 0.3]), "gold": ("specular", [0.05])}
AZIMUTH = -50  # of all cameras, degrees

# Ways of drawing a case. One sample of the default is what the goals speak of.
SPECULAR_WAYS = {
    "1 sample": ["--samples", 1],
    "4 samples": ["--samples", 4],
    "9 probes": ["--samples", 1, "--probes", 9],
    "5 probes": ["--samples", 1, "--probes", 5],
    "grid 5x5": ["--samples", 1, "--grid", 5],
}
WAYS = {key: SPECULAR_WAYS[key] for key in ("1 sample", "4 samples")}
# The references, by number of samples: drawn where they are asked for, and in the cases made for them.
PLAIN_REFERENCE = {f"reference {n}": ["--technique", "reference", "--samples", n] for n in (16, 64)}
RELIEF_REFERENCE = {
    f"relief {n}": ["--technique", "reference", "--relief-shadows", "--samples", n] for n in (2, 8, 32, 128, 512)
}
OTHERS = {
    "toksvig": ["--samples", 1, "--technique", "toksvig"],
    "clean": ["--samples", 1, "--technique", "clean"],
    "lean": ["--samples", 1, "--technique", "lean"],
    "normal-mip": ["--samples", 1, "--technique", "normal-mip"],
}
NO_KERNEL = {"no pixel kernel": ["--samples", 1, "--pixel-kernel", "off"]}
EVERY_WAY = {**OTHERS, **NO_KERNEL, **SPECULAR_WAYS, **PLAIN_REFERENCE, **RELIEF_REFERENCE}


def camera(angle, distance, fov, height=0.0):
    polar, azimuth = math.radians(angle), math.radians(AZIMUTH)
    away = np.array([math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth), math.cos(polar)])
    position = [float(c) for c in np.array([0, 0, height]) + distance * away]
    return dict(position=position, target=[0.0, 0.0, height], up=[0.0, 0.0, 1.0], fov_degrees=fov)


@dataclass(frozen=True)
class Case:
    """One picture and how leadr is asked for it."""

    name: str  # group/subject/.../terms
    scene: str
    panorama: str
    camera: dict
    size: tuple
    alpha: float
    terms: str  # all, specular, diffuse
    spp: int  # samples per pixel of the truth at most
    relief: str = "studs"
    scale: float = 0.0
    noise: float = 0.01  # where its samples end, if `spp` does not end them before
    base: str = "plain"  # see bases.py
    depth: int = 2  # of the truth's paths: 2 reflects light once
    clear: float = 0.0  # weight of a clear coat
    clear_alpha: float = 0.1
    smooth: bool = False  # whether the coat is smooth over the relief

    def heights(self):
        """Metres."""
        return reliefs.heights(self.relief) * reliefs.HEIGHT * self.scale

    def panorama_file(self):
        return panoramas.path(self.panorama)

    def facts(self):
        fields = ("scene", "panorama", "camera", "size", "alpha", "terms", "relief", "scale")
        # Truths that are kept have no others.
        others = {"base": "plain", "depth": 2, "clear": 0.0, "clear_alpha": 0.1, "smooth": False}
        fields += tuple(field for field, usual in others.items() if getattr(self, field) != usual)
        return {field: getattr(self, field) for field in fields}

    def seen(self):
        """The camera that leadr is given: its plane has the mean height of the relief at z = 0, the truth height 0."""
        lower = 0.0 if self.scale == 0 else float(self.heights().mean())
        return {**self.camera, **{end: [*self.camera[end][:2], self.camera[end][2] - lower] for end in ("position", "target")}}

    def available(self):
        return self.panorama_file() is not None and (self.scale == 0 or reliefs.heights(self.relief) is not None)

    def ways(self):
        if self.name.startswith("reference/"):
            few = PLAIN_REFERENCE if self.scene == "sphere" else RELIEF_REFERENCE
            return {way: flags for way, flags in few.items() if flags[-1] <= 64}
        if self.name.startswith(("classes/", "coat/")):
            return {"1 sample": WAYS["1 sample"]}
        if self.name.startswith("plane/") and self.terms == "all":
            return {**WAYS, **OTHERS}
        if self.scene == "sphere" and self.terms == "specular" and self.alpha <= 0.1:
            return {**SPECULAR_WAYS, **NO_KERNEL}
        return SPECULAR_WAYS if self.terms == "specular" else WAYS

    def flags(self):
        """What leadr is told besides the way. The environment's terms include lights that leadr takes out of it."""
        terms = {"all": "all", "specular": "specular-environment", "diffuse": "diffuse-environment"}[self.terms]
        flags = ["--scene", self.scene, "--bare", "--height-map", reliefs.path(self.relief)]
        flags += ["--height", reliefs.HEIGHT, "--height-scale", self.scale]  # a material has another height by itself
        flags += ["--roughness", self.alpha, "--terms", terms, "--size", f"{self.size[0]}x{self.size[1]}"]
        if self.clear > 0:
            flags += ["--clear-coat", f"{self.clear},{self.clear_alpha}", "--clear-coat-relief", "smooth" if self.smooth else "base"]
        flags += bases.flags(self.base) + (["--interreflection", "on"] if self.depth > 2 else [])
        return flags + (["--atlas-tile", 8] if self.scene == "sphere" else [])

    def mask(self):
        """The pixels that are judged: all of a plane, a sphere without its outline."""
        w, h = self.size
        if self.scene == "sphere":
            y, x = np.mgrid[0:h, 0:w] + 0.5
            tangent = np.hypot(x - w / 2, y - h / 2) * 2 / h * math.tan(math.radians(self.camera["fov_degrees"]) / 2)
            distance = np.linalg.norm(np.array(self.camera["position"]))
            return tangent < 0.95 * math.tan(math.asin(1 / distance))
        eye, target = np.array(self.camera["position"]), np.array(self.camera["target"])
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        down = np.cross(forward, right)
        t = math.tan(math.radians(self.camera["fov_degrees"]) / 2)
        y, x = np.mgrid[0 : h + 1, 0 : w + 1]
        ray = forward + right * ((2 * x / w - 1) * t * w / h)[..., None] + down * ((2 * y / h - 1) * t)[..., None]
        met = eye + ray * ((target[2] - eye[2]) / ray[..., 2])[..., None]
        on = (ray[..., 2] < 0) & (np.abs(met[..., :2]).max(-1) < truth.HALF - 0.15)
        return on[:-1, :-1] & on[1:, :-1] & on[:-1, 1:] & on[1:, 1:]


def spheres():
    seen = camera(60, 4.8, 30)
    for panorama in panoramas.NAMES:
        for alpha in ALPHAS:
            yield Case(f"sphere/{panorama}/{alpha}/specular", "sphere", panorama, seen, (96, 96), alpha, "specular", 8192)
        yield Case(f"sphere/{panorama}/0.3/diffuse", "sphere", panorama, seen, (96, 96), 0.3, "diffuse", 8192)


def flats():
    for panorama in ("spiaggia", "soft", "spruit", "pixel"):
        for angle in (20, 45, 75):
            for terms in ("specular", "diffuse"):
                name = f"flat/{panorama}/{angle}/{terms}"
                yield Case(name, "plane", panorama, camera(angle, 3.0, 20), (16, 12), 0.35, terms, 32768)


def planes():
    for name, (relief, scale, panorama) in PLANES.items():
        h = reliefs.heights(relief)
        height = 0.0 if h is None else float(h.mean() * reliefs.HEIGHT * scale)
        for view, (angle, distance, fov, size, spp, noise) in VIEWS.items():
            for terms in ("all", "specular", "diffuse"):
                seen = camera(angle, distance, fov, height)
                yield Case(f"plane/{name}/{view}/{terms}", "plane", panorama, seen, size, 0.35, terms, spp, relief, scale, noise)


def classes():
    """The far and the oblique view with their pixels, but fewer of them."""
    for relief, scale in CLASSES.items():
        h = reliefs.heights(relief)
        height = 0.0 if h is None else float(h.mean() * reliefs.HEIGHT * scale)
        for light, panorama in SUNS.items():
            for view in ("far", "oblique"):
                angle, distance, fov, size, spp, _ = VIEWS[view]
                fewer = math.tan(math.radians(fov) / 2) * FEWER[1] / size[1]
                seen = camera(angle, distance, math.degrees(2 * math.atan(fewer)), height)
                for asked, (base, terms, depth) in ASKED.items():
                    name = f"classes/{relief}/{light}/{view}/{asked}"
                    yield Case(name, "plane", panorama, seen, FEWER, 0.35, terms, spp, relief, scale, 0.01, base, depth)


def coats():
    """A clear coat over a flat plane, over Gaussian relief and over bricks, whose classes of facets are shaded one by one."""
    for relief, scale in {"flat": 0.0, "rock": 1.0, "bricks": 1.0}.items():
        name, shown = ("studs", "coat/flat") if scale == 0 else (relief, f"coat/{relief}")
        h = reliefs.heights(name)
        height = 0.0 if h is None or scale == 0 else float(h.mean() * reliefs.HEIGHT * scale)
        angle, distance, fov, size, spp, _ = VIEWS["far"]
        seen = camera(angle, distance, math.degrees(2 * math.atan(math.tan(math.radians(fov) / 2) * FEWER[1] / size[1])), height)
        for light, panorama in SUNS.items():
            for base, (terms, alphas) in COATED.items():
                for alpha in alphas:
                    for smooth in (False, True) if scale > 0 and (base, alpha) == ("half", alphas[0]) else (False,):
                        case = f"{shown}/{light}/{base}/{alpha}" + ("/smooth" if smooth else "")
                        yield Case(case, "plane", panorama, seen, FEWER, 0.35, terms, spp, name, scale, 0.02, base, 2, 1.0, alpha, smooth)


def references():
    """Coarse relief, of which a reference can afford many samples, and spheres, which show whether it has a pattern."""
    h = reliefs.heights("rock64")
    height = 0.0 if h is None else float(h.mean() * reliefs.HEIGHT * 1.5)
    seen = camera(45, 4.0, 30, height)
    for panorama in ("spiaggia", "soft"):
        for terms in ("specular", "diffuse"):
            name = f"reference/rock/{panorama}/{terms}"
            yield Case(name, "plane", panorama, seen, (72, 48), 0.35, terms, 8192, "rock64", 1.5)
    for case in spheres():
        if case.panorama in ("spiaggia", "tubes"):
            yield replace(case, name=f"reference/{case.name}")


def chosen(patterns):
    """The cases whose names match one of the patterns (`*` and `?`, or the beginning of the name); all without patterns."""
    every = [*spheres(), *flats(), *planes(), *classes(), *coats(), *references()]
    match = lambda name: any(name.startswith(p) or fnmatch.fnmatch(name, p) for p in patterns)
    return [case for case in every if not patterns or match(case.name)]
