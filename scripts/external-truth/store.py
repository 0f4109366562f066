"""The truths that the report's section `outside` compares with: block means of the pictures as shared-exponent colours, one after the
other in a Radiance picture, and what they show as JSON."""
import json

import numpy as np

import files
import truth

FOLDER = files.REPOSITORY / "crates/leadr-lab/src/report/outside"
WIDTH = 256  # of the picture of all of them


def blocks(picture, mask, side):
    """Means of blocks of `side` x `side` pixels; black where a pixel is not judged."""
    h, w = mask.shape
    mean = picture.reshape(h // side, side, w // side, side, 3).mean((1, 3))
    whole = mask.reshape(h // side, side, w // side, side).all((1, 3))
    return np.where(whole[..., None], mean, 0.0)


def rgbe(colors):
    """Radiance's shared-exponent bytes of colours in rows."""
    top = colors.max(-1)
    exponent = np.where(top > 1e-30, np.frexp(np.maximum(top, 1e-30))[1], -128)
    codes = np.floor(colors * np.exp2(8.0 - exponent)[:, None] + 0.5)
    # A mantissa that rounds up to 256 needs the next exponent.
    over = codes.max(-1) > 255
    exponent = exponent + over
    codes = np.floor(colors * np.exp2(8.0 - exponent)[:, None] + 0.5)
    out = np.concatenate([codes, (exponent + 128)[:, None]], -1).astype(np.uint8)
    out[top <= 1e-30] = 0
    return out


def write(chosen):
    texels, index, start = [], [], 0
    for case in chosen:
        # Specular and diffuse light add up to all of it; the report does not draw the others.
        if case.terms == "all" or case.name.startswith(("reference/", "classes/")):
            continue
        reference, noise = truth.picture(case)
        side = 3 if case.scene == "sphere" else 2
        kept = blocks(reference, case.mask(), side)
        facts = case.facts()
        index.append(dict(facts, name=case.name, size=list(case.size), block=side, noise=round(noise, 5), start=start))
        texels.append(kept.reshape(-1, 3))
        start += len(texels[-1])
    codes = rgbe(np.concatenate(texels))
    rows = -(-len(codes) // WIDTH)
    codes = np.concatenate([codes, np.zeros((rows * WIDTH - len(codes), 4), np.uint8)])
    FOLDER.mkdir(parents=True, exist_ok=True)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {rows} +X {WIDTH}\n".encode()
    (FOLDER / "truths.hdr").write_bytes(head + codes.tobytes())
    lines = ",\n".join(json.dumps(entry, sort_keys=True) for entry in index)
    (FOLDER / "truths.json").write_text(f"[\n{lines}\n]\n")
    print(f"stored {len(index)} truths, {(FOLDER / 'truths.hdr').stat().st_size // 1024} KB")
