"""How far a picture is from the truth."""
import numpy as np

import files
import program
import reliefs
import truth

SLOPES_SCALE = 1.0
LEVELS = [256, 64, 16, 4]  # pixels along a repeat


def compare(reference, picture, mask):
    """rRMSE; bias (relative difference of the means); rRMSE once the bias is divided out; correlation of the luminances."""
    a, b = reference[mask], picture[mask]
    rms = np.sqrt((a**2).mean())
    ratio = b.mean() / a.mean()
    luminance = np.array([0.2126, 0.7152, 0.0722])
    x, y = a @ luminance, b @ luminance
    flat = x.std() < 1e-9 or y.std() < 1e-9
    return dict(
        rrmse=float(np.sqrt(((a - b) ** 2).mean()) / rms),
        bias=float(ratio - 1),
        shape=float(np.sqrt(((a - b / ratio) ** 2).mean()) / rms),
        correlation=None if flat else float(np.corrcoef(x, y)[0, 1]),
    )


def judge(case, ways):
    """Numbers of every way of drawing a case."""
    reference, noise = truth.picture(case)
    mask = case.mask()
    results = {}
    for way, flags in ways.items():
        drawn = program.picture(case, way, flags)
        row = compare(reference, drawn, mask)
        if way.startswith("relief"):  # how much of the error is its own noise: two seeds differ by sqrt(2) of it
            other = program.picture(case, way + " again", [*flags, "--seed", 7])
            row["own_noise"] = compare(drawn, other, mask)["rrmse"] / np.sqrt(2)
        results[way] = {key: value if value is None else round(float(value), 5) for key, value in row.items()}
        print(
            f"{case.name:36} {way:10} rRMSE {100 * row['rrmse']:6.2f} %  bias {100 * row['bias']:+6.2f} %"
            f"  without bias {100 * row['shape']:6.2f} %  correlation {row['correlation'] or 1:.3f}  noise {100 * noise:.2f} %"
            + (f"  its own {100 * row['own_noise']:.2f} %" if "own_noise" in row else ""),
            flush=True,
        )
    return dict(noise=round(noise, 5), ways=results)


def slopes(name):
    """Relative errors of the slope variance along x and y, by level: what leadr has under its pixels and between them, against
    the map's triangles. Seen straight down, so that pixels fill one repeat."""
    truth_variance = reliefs.slope_variance(reliefs.heights(name) * reliefs.HEIGHT * SLOPES_SCALE)
    errors = {}
    for pixels in LEVELS:
        distance = 100.0
        fov = 2 * np.degrees(np.arctan(reliefs.REPEAT / 2 / distance))
        down = dict(position=[0.0, 0.0, distance], target=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0], fov_degrees=fov)
        flags = ["--scene", "plane", "--bare", "--height-map", reliefs.path(name), "--height-scale", SLOPES_SCALE, "--smooth-geometry"]
        flags += ["--size", f"{pixels}x{pixels}", "--samples", 1, "--layers", "covariance,mean-slope"]
        layers = files.channels(program.capture(f"slopes-{name}-{pixels}.exr", "studio", down, *flags))
        for axis, expected in zip("XY", truth_variance):
            found = layers[f"covariance.{axis}{axis}"].mean() + layers[f"mean_slope.{axis}"].var()
            errors[f"{pixels} {axis.lower()}"] = round(float(found / expected - 1), 5)
    print(f"slopes/{name:29}", "  ".join(f"{key}: {100 * e:+.1f} %" for key, e in errors.items()), flush=True)
    return dict(variance=truth_variance, errors=errors)
