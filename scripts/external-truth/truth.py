"""The truth: Mitsuba's path tracer on leadr's plane and sphere."""
import hashlib
import json
import math
import time

import drjit as dr
import mitsuba as mi
import numpy as np

import bases
import files
import reliefs

HALF = 4.0  # half the plane's side, metres
CHUNK = 256  # samples per pixel of one of the pictures whose spread tells the noise


def emitter(panorama):
    """leadr has texel centres at (j + 1/2)/H and z up, Mitsuba rows at j/(H - 1) and y up. 2H + 1 rows hold the same piecewise
    linear function exactly."""
    radiance = files.load(panorama)
    h = len(radiance)
    at = np.clip(np.arange(2 * h + 1) / 2 - 0.5, 0, h - 1)
    i = np.minimum(at.astype(int), h - 2)
    f = (at - i)[:, None, None]
    rows = (radiance[i] * (1 - f) + radiance[i + 1] * f).astype(np.float32)
    turn = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.float64)
    return dict(type="envmap", bitmap=mi.Bitmap(rows), to_world=mi.ScalarTransform4f(turn))


def sensor(camera, size):
    return dict(
        type="perspective",
        fov=camera["fov_degrees"],
        fov_axis="y",
        near_clip=1e-3,
        far_clip=1e4,
        to_world=mi.ScalarTransform4f().look_at(origin=camera["position"], target=camera["target"], up=camera["up"]),
        film=dict(type="hdrfilm", width=size[0], height=size[1], rfilter=dict(type="box"), pixel_format="rgb", component_format="float32"),
        sampler=dict(type="independent"),
    )


def smith_lambda(a):
    """Smith's exact Lambda of Gaussian slopes; `a` is cot(theta) / alpha."""
    a = dr.maximum(a, 1e-6)
    return dr.select(a > 12, 0.0, 0.5 * (dr.erf(a) - 1 + dr.exp(-a * a) / (a * math.sqrt(math.pi))))


def schlick(f0, cosine):
    return f0 + (1 - f0) * dr.power(dr.clip(1 - cosine, 0, 1), 5)


CLEAR_F0 = 0.04  # of a clear coat


def mean_fresnel(alpha, f0, count=256):
    """Mean Fresnel term of the mirrors that a viewer sees, at `count` even cosines."""
    node, weight = np.polynomial.hermite_e.hermegauss(60)
    sx, sy = np.meshgrid(node * alpha / math.sqrt(2), node * alpha / math.sqrt(2))
    weight = np.outer(weight, weight)
    means = []
    for cosine in np.maximum(np.linspace(0, 1, count), 1e-3):
        area = np.maximum(cosine - math.sqrt(1 - cosine * cosine) * sx, 0)
        facing = np.minimum(area / np.sqrt(1 + sx**2 + sy**2), 1)
        means.append((weight * area * (f0 + (1 - f0) * (1 - facing) ** 5)).sum() / (weight * area).sum())
    return np.array(means, dtype=np.float32)


class Coat(mi.BSDF):
    """Lambert under Beckmann mirrors in the frame of the facet; Schlick's Fresnel term, height-correlated Smith. The diffuse
    part gets what the visible mirrors leave on average. Mirrors are Mitsuba's own.

    With `clear`, a clear coat of lacquer covers both: Beckmann mirrors of F0 0.04 and their own roughness. The light below passes it
    twice, and what it reflects back down is reflected again. The coat lies in the frame of the facet or, with `smooth`, in the frame
    of the plane. `lacquer` and `below` choose what is drawn."""

    def __init__(self, props):
        super().__init__(props)
        self.alpha = props.get("alpha", 0.35)
        self.specular = props.get("specular", True)
        self.diffuse = props.get("diffuse", True)
        base = bases.BASES[props.get("base", "plain")]
        self.albedo, self.f0 = mi.Color3f(*base.albedo), mi.Color3f(*base.f0)
        self.clear, self.clear_alpha = props.get("clear", 0.0), props.get("clear_alpha", 0.1)
        self.smooth = props.get("smooth", False)
        self.lacquer = self.clear > 0 and props.get("lacquer", True)
        if not props.get("below", True):
            self.specular = self.diffuse = False
        self.clear_distribution = mi.MicrofacetDistribution(mi.MicrofacetType.Beckmann, self.clear_alpha, True)
        self.clear_reflected = mi.Float(mean_fresnel(self.clear_alpha, CLEAR_F0))
        self.distribution = mi.MicrofacetDistribution(mi.MicrofacetType.Beckmann, self.alpha, True)
        self.reflected = mi.Float(mean_fresnel(self.alpha, base.f0[0]))
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags

    def mean_reflected(self, table, cosine):
        at = dr.clip(cosine, 0, 1) * 255
        i = dr.minimum(mi.UInt32(at), 254)
        f = at - mi.Float(i)
        return dr.gather(mi.Float, table, i) * (1 - f) + dr.gather(mi.Float, table, i + 1) * f

    def mirrors(self, wi, wo, f0, alpha, distribution):
        half = dr.normalize(wi + wo)
        hidden = [smith_lambda(w.z / (alpha * dr.sqrt(dr.maximum(w.x * w.x + w.y * w.y, 1e-12)))) for w in (wi, wo)]
        return schlick(f0, dr.dot(wi, half)) * (distribution.eval(half) / ((1 + hidden[0] + hidden[1]) * 4 * wi.z))

    def value(self, si, wi, wo):
        above = (wi.z > 0) & (wo.z > 0)
        total, cosine = mi.Color3f(0), dr.dot(wi, dr.normalize(wi + wo))
        if self.clear > 0:
            o, i = (self.clear * self.mean_reflected(self.clear_reflected, self.over(si, w)) for w in (wi, wo))
            back = self.clear * (CLEAR_F0 + (1 - CLEAR_F0) / 21)
            ends = (1 - o) * (1 - i)
        if self.specular:
            mirrored = self.mirrors(wi, wo, self.f0, self.alpha, self.distribution)
            total += mirrored * (ends / (1 - i * schlick(self.f0, cosine)) if self.clear > 0 else 1)
        if self.diffuse:
            scattered = self.albedo * (wo.z * dr.inv_pi * (1 - self.mean_reflected(self.reflected, wi.z)))
            total += scattered * (ends / (1 - back * self.albedo) if self.clear > 0 else 1)
        if self.lacquer:
            total += self.clear * self.mirrors(wi, wo, mi.Color3f(CLEAR_F0), self.clear_alpha, self.clear_distribution)
        return dr.select(above, total, 0)

    def over(self, si, w):
        """The cosine of a direction to the normal of the coat."""
        return si.to_world(w).z if self.smooth else w.z

    def density(self, wi, wo):
        p, half = mi.Float(0), dr.normalize(wi + wo)
        by_half = 1 / (4 * dr.maximum(dr.dot(wi, half), 1e-9))
        if self.specular:
            p += self.distribution.pdf(wi, half) * by_half
        if self.diffuse:
            p += dr.maximum(wo.z, 0) * dr.inv_pi
        if self.lacquer:
            p += self.clear_distribution.pdf(wi, half) * by_half
        return dr.select((wi.z > 0) & (wo.z > 0), p / (self.specular + self.diffuse + self.lacquer), 0)

    def sample(self, context, si, sample1, sample2, active):
        active &= si.wi.z > 0
        drawn = []
        if self.diffuse:
            drawn.append(mi.warp.square_to_cosine_hemisphere(sample2))
        for there, distribution in ((self.specular, self.distribution), (self.lacquer, self.clear_distribution)):
            if there:
                drawn.append(mi.reflect(si.wi, distribution.sample(si.wi, sample2)[0]))
        wo = drawn[0]
        for k in range(1, len(drawn)):
            wo = dr.select(sample1 < k / len(drawn), wo, drawn[k])
        drawn = dr.zeros(mi.BSDFSample3f)
        drawn.wo, drawn.eta, drawn.pdf = wo, 1.0, self.density(si.wi, wo)
        drawn.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        drawn.sampled_component = 0
        active &= drawn.pdf > 0
        return drawn, dr.select(active, self.value(si, si.wi, wo) / dr.maximum(drawn.pdf, 1e-20), 0)

    def eval(self, context, si, wo, active):
        return self.value(si, si.wi, wo) & active

    def pdf(self, context, si, wo, active):
        return dr.select(active, self.density(si.wi, wo), 0)

    def eval_pdf(self, context, si, wo, active):
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

    def traverse(self, callback):
        pass

    def to_string(self):
        return "Coat[]"


mi.register_bsdf("coat", Coat)


def grid(at, texel, heights):
    """Vertices at `at` texels along both axes."""
    x, y = np.meshgrid(at * texel, at * texel)
    return np.stack([x, y, heights], -1).reshape(-1, 3).astype(np.float32)


def plane(heights, bsdf):
    """The plane's triangles: a vertex per texel of `heights` (metres), as many repeats as 8 m hold, and one in the centre of each
    cell at the mean height of its corners. Two triangles a cell would favour slopes along their diagonals, and diagonals that
    change from cell to cell lock to weaves of even period."""
    n = len(heights)
    texel = reliefs.REPEAT / n
    side = round(2 * HALF / texel)
    at = np.arange(side) - side // 2
    corners = grid(at + 0.5, texel, heights[np.ix_(at % n, at % n)])
    middle = (heights + np.roll(heights, -1, 0) + np.roll(heights, -1, 1) + np.roll(heights, -1, (0, 1))) / 4
    centres = grid(at[:-1] + 1, texel, middle[np.ix_(at[:-1] % n, at[:-1] % n)])
    vertices = np.concatenate([corners, centres])
    cell = np.arange(side - 1)
    a = (cell[:, None] * side + cell).ravel()
    around = [a, a + 1, a + side + 1, a + side]
    centre = len(corners) + np.arange(len(a))
    triangles = np.concatenate([np.stack([around[k], around[(k + 1) % 4], centre], 1) for k in range(4)])
    props = mi.Properties()
    props["bsdf"] = bsdf
    mesh = mi.Mesh("plane", len(vertices), len(triangles), props=props)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = mi.Float(vertices.ravel())
    parameters["faces"] = mi.UInt32(triangles.astype(np.uint32).ravel())
    parameters.update()
    return mesh


def shape(case, **parts):
    terms = dict(specular=case.terms != "diffuse", diffuse=case.terms != "specular" and not bases.BASES[case.base].metal)
    if case.clear > 0:
        terms.update(clear=case.clear, clear_alpha=case.clear_alpha, smooth=case.smooth, lacquer=case.terms != "diffuse")
        terms.update(parts)
    coat = mi.load_dict(dict(type="coat", alpha=case.alpha, base=case.base, **terms))
    if case.scene == "sphere":
        return mi.load_dict(dict(type="sphere", bsdf=coat))
    if case.scale == 0 or parts.get("lacquer"):
        middle = 0.0 if case.scale == 0 else float(case.heights().mean())
        to_world = mi.ScalarTransform4f().translate([0, 0, middle]).scale([HALF, HALF, 1])
        return mi.load_dict(dict(type="rectangle", to_world=to_world, bsdf=coat))
    return plane(case.heights(), coat)


def shapes(case):
    """The surfaces whose pictures add up. A smooth coat lies on a plane of its own, above the relief that it attenuates."""
    if case.clear > 0 and case.smooth and case.scale != 0:
        return [shape(case, lacquer=False, below=True), shape(case, lacquer=True, below=False)]
    return [shape(case)]


def picture(case):
    """The truth of a case and its noise: the standard error of its pixels, root mean square over those that are judged, over the
    root mean square of the picture. Kept, under a name that changes with what it shows."""
    about = dict(case.facts(), spp=case.spp, noise_goal=case.noise)
    if case.scale != 0:
        about["mesh"] = "four triangles a cell"
    key = hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()[:10]
    path = files.OUT / "truth" / f"{case.name.removeprefix('reference/').replace('/', '-')}-{key}.exr"
    meta = path.with_suffix(".json")
    if meta.exists():
        return files.load(path), json.loads(meta.read_text())["noise"]
    start = time.time()
    scenes = [
        mi.load_dict(
            dict(
                type="scene",
                integrator=dict(type="path", max_depth=case.depth, rr_depth=100),
                sensor=sensor(case.camera, case.size),
                light=emitter(case.panorama_file()),
                shape=drawn,
            )
        )
        for drawn in shapes(case)
    ]
    total, square, count, noise, mask = 0.0, 0.0, 0, np.inf, case.mask()
    # At least eight pictures, so that their spread is worth something.
    while count < 8 or (noise > case.noise and count * CHUNK < case.spp):
        part = sum(np.array(mi.render(scene, spp=CHUNK, seed=count)).astype(np.float64) for scene in scenes)
        total, square, count = total + part, square + part * part, count + 1
        mean = total / count
        variance = np.maximum(square / count - mean**2, 0) / max(count - 1, 1)
        noise = float(np.sqrt(variance[mask].mean() / (mean[mask] ** 2).mean()))
    files.save(path, mean)
    meta.write_text(json.dumps(dict(about, noise=noise, samples=count * CHUNK, seconds=time.time() - start)))
    print(f"  truth {case.name}: {time.time() - start:.1f} s, noise {100 * noise:.2f} %", flush=True)
    return mean, noise
