"""Compares Mitsuba 3 renderings of `leadr fit --mitsuba` materials with its plugin `measured` and with leadr.

Needs numpy, mitsuba (3.5 or newer) and LLVM (19 or newer, DRJIT_LIBLLVM_PATH). LEADR_SHARED: the shared data;
LEADR_BIN: leadr; SPP: samples; the argument is a folder for pictures. The scene is a sphere of 1 m under constant radiance 0.25 and a lamp of 6 degrees,
seen from 4.8 m, with one bounce. `measured` expects the light as first direction, but a path tracer passes the viewer.
It is therefore rendered both ways: turned (the reference here), and as called."""
import json, math, os, subprocess, sys
from pathlib import Path
import numpy as np
import mitsuba as mi
mi.set_variant("llvm_ad_rgb")
import drjit as dr

OUT, SIZE, SPP = Path(sys.argv[1] if len(sys.argv) > 1 else "out"), 128, int(os.environ.get("SPP", 1024))
LEADR = os.environ.get("LEADR_BIN", "leadr")
WAYS = ["leadr, lobes", "leadr, reference", "measured, turned", "measured, as called", "export"]


class Turned(mi.BSDF):
    """`measured` with viewer and light swapped."""
    def __init__(self, props):
        super().__init__(props)
        self.inner = mi.load_dict(dict(type="measured", filename=props["file"]))
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def eval(self, ctx, si, wo, active=True):
        turned = mi.SurfaceInteraction3f(si)
        turned.wi = wo
        ok = (si.wi.z > 1e-4) & (wo.z > 1e-4)
        value = self.inner.eval(ctx, turned, si.wi, ok & active)
        return dr.select(ok & active, value * wo.z / dr.maximum(si.wi.z, 1e-4), 0)

    def pdf(self, ctx, si, wo, active=True):
        return self.inner.pdf(ctx, si, wo, active)

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def sample(self, ctx, si, sample1, sample2, active=True):
        bs, _ = self.inner.sample(ctx, si, sample1, sample2, active)
        return bs, dr.select(bs.pdf > 0, self.eval(ctx, si, bs.wo, active) / dr.maximum(bs.pdf, 1e-9), 0)

    def traverse(self, callback):
        pass

mi.register_bsdf("turned", Turned)


def environment():
    """leadr: z up, azimuth decreases along a row, rows at (j + 1/2)/H. Mitsuba: rows at j/(H - 1), so it gets 2H + 1."""
    h = 256
    rows, columns = (np.arange(h) + 0.5) / h, 1 - (np.arange(2 * h) + 0.5) / h
    theta, phi = np.meshgrid(rows * math.pi, columns * math.pi, indexing="ij")
    d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    lamp = np.array([math.cos(0.7) * math.cos(-1.6), math.cos(0.7) * math.sin(-1.6), math.sin(0.7)])
    a = np.where((d @ lamp > math.cos(math.radians(3)))[..., None], 120.0, 0.25) * np.ones(3)
    mi.Bitmap(a.astype(np.float32)).write(str(OUT / "lamp.exr"))
    v = np.clip(np.arange(2 * h + 1) / 2 - 0.5, 0, h - 1)
    i = np.minimum(v.astype(int), h - 2)
    f = (v - i)[:, None, None]
    finer = mi.Bitmap((a[i] * (1 - f) + a[i + 1] * f).astype(np.float32))
    turn = mi.ScalarTransform4f([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return dict(type="envmap", bitmap=finer, to_world=turn)


def mitsuba(bsdf, sensor, light):
    """The picture, and the standard error of its pixels relative to their RMS."""
    once = dict(type="path", max_depth=2)
    ball = dict(type="sphere", bsdf=bsdf)
    scene = mi.load_dict(dict(type="scene", integrator=once, sensor=sensor, light=light, ball=ball))
    parts = np.array([np.array(mi.render(scene, spp=64, seed=i)) for i in range(max(2, SPP // 64))])
    return parts.mean(0), math.sqrt(parts.var(0, ddof=1).mean() / len(parts) / (parts.mean(0)**2).mean())


def leadr(fit, camera, name, *flags):
    command = [LEADR, "capture", "--scene", "sphere", "--bare", "--material", fit, "--height-scale", "0", "-q"]
    command += ["--environment", OUT / "lamp.exr", "--camera", camera, "--size", f"{SIZE}x{SIZE}", "-o", OUT / name]
    subprocess.run([*command, *flags], check=True)
    picture = mi.Bitmap(str(OUT / name)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(picture), 0.0


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    t, p = math.radians(60), math.radians(-50)
    position = [4.8 * math.sin(t) * math.cos(p), 4.8 * math.sin(t) * math.sin(p), 4.8 * math.cos(t)]
    camera = OUT / "camera.json"
    camera.write_text(json.dumps(dict(position=position, target=[0, 0, 0], up=[0, 0, 1], fov_degrees=30)))
    film = dict(type="hdrfilm", width=SIZE, height=SIZE, rfilter=dict(type="box"), pixel_format="rgb")
    look = mi.ScalarTransform4f().look_at(position, [0, 0, 0], [0, 0, 1])
    sensor = dict(type="perspective", fov=30, film=film, to_world=look)
    y, x = (np.mgrid[:SIZE, :SIZE] + 0.5 - SIZE / 2) * (2 * math.tan(math.radians(15)) / SIZE)
    inside = np.hypot(x, y) < 0.95 * math.tan(math.asin(1 / 4.8))
    light, sheet = environment(), []
    for file in sorted(Path(os.environ["LEADR_SHARED"], "data/brdf/rgl_bsdf").glob("*_rgb.bsdf")):
        fit, export = OUT / f"{file.stem}.json", OUT / f"{file.stem}.xml"
        subprocess.run([LEADR, "fit", file, "-q", "-o", fit, "--mitsuba", export], check=True)
        pictures = [leadr(fit, camera, f"{file.stem}_lobes.exr"),
                    leadr(fit, camera, f"{file.stem}_reference.exr", "--technique", "reference", "--samples", "256"),
                    mitsuba(dict(type="turned", file=str(file)), sensor, light),
                    mitsuba(dict(type="measured", filename=str(file)), sensor, light),
                    mitsuba(mi.load_string(export.read_text()), sensor, light)]
        truth = pictures[2][0][inside]
        for way, (picture, noise) in zip(WAYS, pictures):
            e = picture[inside] - truth
            mean, rrmse = e.mean() / truth.mean(), math.sqrt((e**2).mean() / (truth**2).mean())
            print(f"| {file.stem} | {way} | {mean:+.3f} | {rrmse:.3f} | {noise:.3f} |", flush=True)
        exposure = 0.7 / np.quantile(truth.mean(-1), 0.9)
        sheet.append(np.concatenate([np.where(inside[..., None], a * exposure, 0.0) for a, _ in pictures], 1))
    shown = mi.Bitmap(np.concatenate(sheet).astype(np.float32))
    shown.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True).write(str(OUT / "side.png"))


if __name__ == "__main__":
    main()
