"""Reads a baked EXR with OpenImageIO and holds it against what `leadr bake --json` says of it."""

import json
import sys

import numpy
import OpenImageIO


def levels(path):
    """Pictures of all mip levels, and the names of their channels."""
    file = OpenImageIO.ImageInput.open(path)
    if file is None:
        sys.exit(f"{path}: {OpenImageIO.geterror()}")
    pictures, names, level = [], None, 0
    while file.seek_subimage(0, level):
        names = list(file.spec().channelnames)
        pictures.append(numpy.asarray(file.read_image(0, level, 0, len(names), OpenImageIO.FLOAT), dtype=numpy.float64))
        level += 1
    attributes = {a.name: a.value for a in file.spec().extra_attribs}
    file.close()
    return pictures, names, attributes


def main():
    path, said = sys.argv[1], json.load(open(sys.argv[2]))
    pictures, names, attributes = levels(path)
    factors = numpy.ones(len(names))
    if "leadr.factors" in attributes:
        by_name = dict(zip(attributes["leadr.channels"].split(), attributes["leadr.factors"].split()))
        factors = numpy.array([float(by_name[name]) for name in names])
    sizes = [tuple(picture.shape[1::-1]) for picture in pictures]
    width, height = said["size"]
    assert sizes == [(max(width >> i, 1), max(height >> i, 1)) for i in range(said["levels"])], sizes
    pictures = [picture / factors for picture in pictures]
    if "height.rest" in names:
        # What 16 bits leave over of the height.
        rest = names.index("height.rest")
        for picture in pictures:
            picture[:, :, names.index("height")] += picture[:, :, rest]
            picture[:, :, rest] = 0
    means = [picture.mean(axis=(0, 1)) for picture in pictures]
    scale = numpy.sqrt((pictures[0] ** 2).mean(axis=(0, 1))) + 1e-30
    moved = max(float((abs(mean - means[0]) / scale).max()) for mean in means)
    variance = ""
    at = {name: i for i, name in enumerate(names)}
    if "xx" in at:
        mean = means[0]
        got = mean[at["xx"]] - mean[at["x"]] ** 2, mean[at["yy"]] - mean[at["y"]] ** 2
        want = said["slope_variance"]
        variance = f", variance off by {max(abs(g / w - 1) for g, w in zip(got, want)):.1e}"
    print(f"{len(sizes)} levels of {len(names)} channels, means move by {moved:.1e}{variance}")


main()
