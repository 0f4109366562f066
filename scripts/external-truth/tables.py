"""The tables of docs/measurements/outside.md, between its markers, from the numbers kept beside this file."""
import json

import cases
import files
import panoramas
import score

PAGE = files.REPOSITORY / "docs/measurements/outside.md"
KEPT = files.REPOSITORY / "scripts/external-truth/results"
BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"
COLUMNS = ("before", "after")


def read(label):
    path = KEPT / f"{label}.json"
    return json.loads(path.read_text()) if path.exists() else dict(program="", cases={}, slopes={})


def keep(label, found):
    """Adds numbers to those that are kept."""
    merged = read(label)
    merged["program"] = found["program"]
    for name, row in found["cases"].items():
        ways = merged["cases"].get(name, {}).get("ways", {})
        merged["cases"][name] = dict(noise=row["noise"], ways={**ways, **row["ways"]})
    merged["slopes"].update(found["slopes"])
    KEPT.mkdir(exist_ok=True)
    (KEPT / f"{label}.json").write_text(json.dumps(merged, indent=1, sort_keys=True) + "\n")


def percent(value, signed=False):
    if value is None:
        return "–"
    return f"{100 * value:+.1f}" if signed else f"{100 * value:.1f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def pair(results, name, way, key, signed=False):
    """`before → after`."""
    values = [results[c]["cases"].get(name, {}).get("ways", {}).get(way, {}).get(key) for c in COLUMNS]
    return " → ".join(percent(v, signed) for v in values)


def noise(results, name):
    kept = [results[c]["cases"][name]["noise"] for c in COLUMNS if name in results[c]["cases"]]
    return percent(kept[-1]) if kept else "–"


def sphere_tables(results):
    ways = list(cases.SPECULAR_WAYS)
    out = ["### Smooth spheres\n", "Specular rRMSE, %, before → after. The last column is the truth's noise.\n"]
    rows = []
    for panorama in panoramas.NAMES:
        for alpha in cases.ALPHAS:
            name = f"sphere/{panorama}/{alpha}/specular"
            row = [pair(results, name, way, "rrmse") for way in ways]
            rows.append([panorama, str(alpha), *row, noise(results, name)])
    out.append(table(["panorama", "α", *ways, "noise"], rows))
    out.append("Diffuse, one sample, %, before → after.\n")
    rows = []
    for panorama in panoramas.NAMES:
        name = f"sphere/{panorama}/0.3/diffuse"
        rows.append([panorama, pair(results, name, "1 sample", "rrmse"), pair(results, name, "1 sample", "bias", True), noise(results, name)])
    out.append(table(["panorama", "rRMSE", "bias", "noise"], rows))
    return out


def flat_table(results):
    rows = []
    for case in cases.flats():
        _, panorama, angle, terms = case.name.split("/")
        bias = pair(results, case.name, "1 sample", "bias", True)
        rows.append([panorama, f"{angle}°", terms, pair(results, case.name, "1 sample", "rrmse"), bias, noise(results, case.name)])
    return ["### A flat plane\n", "One sample, α 0.35, %, before → after.\n", table(["panorama", "from", "term", "rRMSE", "bias", "noise"], rows)]


def plane_table(results):
    rows = []
    for case in cases.planes():
        _, name, view, terms = case.name.split("/")
        numbers = [pair(results, case.name, "1 sample", "rrmse"), pair(results, case.name, "1 sample", "bias", True)]
        correlations = [results[c]["cases"].get(case.name, {}).get("ways", {}).get("1 sample", {}).get("correlation") for c in COLUMNS]
        numbers.append(" → ".join("–" if v is None else f"{v:.2f}" for v in correlations))
        numbers += [pair(results, case.name, "4 samples", "rrmse"), noise(results, case.name)]
        rows.append([name, view, terms, *numbers])
    head = ["surface", "view", "terms", "rRMSE", "bias", "correlation", "rRMSE, 4 samples", "noise"]
    return ["### Relief\n", "One sample unless the column says four; %, before → after.\n", table(head, rows)]


def class_table(results):
    """Reliefs whose slopes are not Gaussian."""
    def cell(name):
        kept = [results[c]["cases"].get(name, {}).get("ways", {}).get("1 sample") for c in COLUMNS]
        return " → ".join(f"{percent(row['rrmse'])} ({percent(row['bias'], True)})" if row else "–" for row in kept)

    rows = []
    for light in cases.SUNS:
        for view in ("far", "oblique"):
            for relief in cases.CLASSES:
                cells = [cell(f"classes/{relief}/{light}/{view}/{asked}") for asked in cases.ASKED]
                rows.append([light, view, relief, *cells])
    text = "rRMSE (bias) of one sample, %, before → after; the noise of the truths is 1 %. Albedo 0.5, gold without diffuse light; bounces: the truth's paths reflect light up to seven times, at albedo 0.5 and 0.9, and leadr adds `--interreflection on`.\n"
    return ["### Reliefs far from Gaussian\n", text, table(["light", "view", "surface", *cases.ASKED], rows)]


def coat_table(results):
    """Clear coats, as they are now."""
    now = results["after"]["cases"]
    rows = []
    for case in cases.coats():
        _, surface, light, base, alpha, *smooth = case.name.split("/")
        found = now.get(case.name, {}).get("ways", {}).get("1 sample", {})
        row = [surface, "smooth" if smooth else "of the surface", light, base, alpha]
        rows.append(row + [percent(found.get("rrmse")), percent(found.get("bias"), True), noise(results, case.name)])
    text = "One sample at a distance, %, after. The base has α 0.35; its albedo is 0.5, or it is gold.\n"
    return ["### Clear coats\n", text, table(["surface", "relief of the coat", "light", "base", "α of the coat", "rRMSE", "bias", "noise"], rows)]


def technique_table(results):
    """Other techniques, as they are now."""
    now = results["after"]["cases"]
    ways = ["1 sample", *cases.OTHERS]
    rows = []
    for case in cases.planes():
        _, name, view, terms = case.name.split("/")
        if terms == "all":
            found = now.get(case.name, {}).get("ways", {})
            cells = [f"{percent(found.get(way, {}).get('rrmse'))} ({percent(found.get(way, {}).get('bias'), True)})" for way in ways]
            rows.append([name, view, *cells])
    head = ["surface", "view", "leadr", *ways[1:]]
    out = ["### Other techniques\n", "rRMSE and bias of all light together, one sample, %, after.\n", table(head, rows)]
    rows = []
    for panorama in panoramas.NAMES:
        row = [panorama]
        for alpha in cases.ALPHAS[:2]:
            found = now.get(f"sphere/{panorama}/{alpha}/specular", {}).get("ways", {})
            row += [percent(found.get(way, {}).get("rrmse")) for way in ("1 sample", *cases.NO_KERNEL)]
        rows.append(row)
    out.append("Geometric antialiasing, which counts the turn of the sphere under a pixel as roughness (`--pixel-kernel`): specular rRMSE of smooth spheres with it and without, one sample, %.\n")
    out.append(table(["panorama", *(f"α {alpha}, {kind}" for alpha in cases.ALPHAS[:2] for kind in ("with", "without"))], rows))
    return out


def slope_table(results):
    rows = []
    for name in sorted({n for c in COLUMNS for n in results[c]["slopes"]}):
        for axis in "xy":
            row = []
            for pixels in score.LEVELS:
                values = [results[c]["slopes"].get(name, {}).get("errors", {}).get(f"{pixels} {axis}") for c in COLUMNS]
                row.append(" → ".join(percent(v, True) for v in values))
            rows.append([name, axis, *row])
    head = ["map", "along", *(f"{n} pixels a repeat" for n in score.LEVELS)]
    return ["### Slope variance of the maps\n", "Against the triangles, %, before → after.\n", table(head, rows)]


def reference_table(results):
    """The references by number of samples."""
    rows = []
    for case in cases.references():
        ways = [way for way in cases.EVERY_WAY if any(way in results[c]["cases"].get(case.name, {}).get("ways", {}) for c in COLUMNS)]
        for way in ways:
            row = [pair(results, case.name, way, key, key == "bias") for key in ("rrmse", "bias", "own_noise")] + [noise(results, case.name)]
            rows.append([case.name.removeprefix("reference/"), way, *row])
    text = "`relief N`: `--technique reference --relief-shadows` with N samples; `reference N`: without the shadows. *Own noise*: by the difference of two seeds, relative like rRMSE; it is what falls with the number of samples. %, before → after.\n"
    return ["### The references\n", text, table(["case", "drawn as", "rRMSE", "bias", "own noise", "noise of the truth"], rows)]


def write():
    results = {label: read(label) for label in COLUMNS}
    programs = "".join(f"* {label}: {results[label]['program'] or 'not measured'}\n" for label in COLUMNS)
    parts = [programs, *sphere_tables(results), *flat_table(results), *plane_table(results), *class_table(results), *coat_table(results), *technique_table(results), *slope_table(results)]
    parts += reference_table(results)
    page = PAGE.read_text()
    head, rest = page.split(BEGIN)
    PAGE.write_text(head + BEGIN + "\n" + "\n".join(parts) + END + rest.split(END)[1])
