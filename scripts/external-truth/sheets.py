"""Contact sheets: leadr's pictures beside the truth, one row per case."""
import numpy as np
from PIL import Image, ImageDraw

import files
import program
import truth

WIDTH = 192


def display(picture, exposure):
    x = np.maximum(picture * exposure, 0)
    return (np.clip(x * (1 + x / 16) / (1 + x), 0, 1) ** (1 / 2.2) * 255).astype(np.uint8)


def sheet(name, rows):
    """`rows` are cases with the ways that were drawn. Writes `name`.png and returns its path."""
    columns = ["truth"] + sorted({way for _, ways in rows for way in ways}, key=list(rows[0][1]).index)
    heights = [WIDTH * case.size[1] // case.size[0] for case, _ in rows]
    image = Image.new("RGB", (230 + (WIDTH + 4) * len(columns), 20 + sum(heights) + 4 * len(rows)), "white")
    draw = ImageDraw.Draw(image)
    for i, column in enumerate(columns):
        draw.text((234 + (WIDTH + 4) * i, 4), column, fill="black")
    top = 20
    for (case, ways), height in zip(rows, heights):
        reference, _ = truth.picture(case)
        exposure = 1.2 / max(np.percentile(reference[case.mask()], 90), 1e-9)
        draw.text((4, top + 4), case.name.replace("/", "\n"), fill="black")
        for i, column in enumerate(columns):
            picture = reference if column == "truth" else program.picture(case, column, ways[column]) if column in ways else None
            if picture is not None:
                tile = Image.fromarray(display(picture, exposure)).resize((WIDTH, height), Image.Resampling.NEAREST)
                image.paste(tile, (230 + (WIDTH + 4) * i, top))
        top += height + 4
    path = program.folder() / f"sheet-{name}.png"
    image.save(path)
    return path
