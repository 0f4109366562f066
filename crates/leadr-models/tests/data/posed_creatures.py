"""Positions of posed creatures, computed in double precision with numpy, independently of this crate.

    python crates/leadr-models/tests/data/posed_creatures.py FOLDER > crates/leadr-models/tests/data/posed_creatures.json

FOLDER holds the shared creatures. Reads GLB files with at most four joints per vertex and linear or stepped curves.
"""

import json
import pathlib
import struct
import sys

import numpy as np

FORMATS = {5121: ("B", 1, 255), 5123: ("H", 2, 65535), 5125: ("I", 4, 1), 5126: ("f", 4, 1)}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

# File, part of the animation's name, seconds, and vertices of the skinned mesh by primitive.
CASES = [
    ("fox/Fox.glb", "Walk", 0.35, {0: [0, 700, 1500]}),
    ("trex_lasquetispice/trex_notextures.glb", "run", 4.321, {0: [0, 3000, 7000]}),
    ("trex_quaternius/Trex.glb", "Walk", 0.8, {0: [0, 100], 2: [7], 4: [3]}),
]


class Glb:
    def __init__(self, path):
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]

    def numbers(self, index, unit=False):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        letter, size, most = FORMATS[accessor["componentType"]]
        width = SIZES[accessor["type"]]
        stride = view.get("byteStride", size * width)
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        rows = [struct.unpack_from(f"<{width}{letter}", self.binary, start + i * stride) for i in range(accessor["count"])]
        return np.array(rows, float) / (most if unit else 1)


def rotation(quaternion):
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def slerp(a, b, part):
    cosine = a @ b
    if cosine < 0:
        b, cosine = -b, -cosine
    if cosine > 0.9999999:
        return a + (b - a) * part
    angle = np.arccos(cosine)
    return (np.sin((1 - part) * angle) * a + np.sin(part * angle) * b) / np.sin(angle)


def sample(glb, sampler, seconds, turns):
    mode = sampler.get("interpolation", "LINEAR")
    assert mode in ("LINEAR", "STEP"), mode
    times, values = glb.numbers(sampler["input"])[:, 0], glb.numbers(sampler["output"])
    if seconds <= times[0] or seconds >= times[-1]:
        return values[0 if seconds <= times[0] else -1]
    key = np.searchsorted(times, seconds, side="right") - 1
    if mode == "STEP":
        return values[key]
    part = (seconds - times[key]) / (times[key + 1] - times[key])
    a, b = values[key], values[key + 1]
    return slerp(a, b, part) if turns else a + (b - a) * part


def posed(glb, clip, seconds):
    """The posed positions of the skinned mesh per primitive."""
    nodes = glb.json["nodes"]
    parts = [{**{"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}, **node} for node in nodes]
    animation = next(a for a in glb.json["animations"] if clip in a["name"])
    for channel in animation["channels"]:
        path = channel["target"]["path"]
        sampler = animation["samplers"][channel["sampler"]]
        parts[channel["target"]["node"]][path] = sample(glb, sampler, seconds, path == "rotation")
    parents = {child: i for i, node in enumerate(nodes) for child in node.get("children", [])}

    def world(i):
        if "matrix" in nodes[i]:
            matrix = np.array(nodes[i]["matrix"], float).reshape(4, 4).T
        else:
            matrix = np.eye(4)
            matrix[:3, :3] = rotation(np.array(parts[i]["rotation"], float)) * np.array(parts[i]["scale"], float)
            matrix[:3, 3] = parts[i]["translation"]
        return world(parents[i]) @ matrix if i in parents else matrix

    node = next(n for n in nodes if "mesh" in n and "skin" in n)
    skin = glb.json["skins"][node["skin"]]
    bind = glb.numbers(skin["inverseBindMatrices"])
    joints = np.array([world(j) @ bind[k].reshape(4, 4).T for k, j in enumerate(skin["joints"])])
    for primitive in glb.json["meshes"][node["mesh"]]["primitives"]:
        attributes = primitive["attributes"]
        positions = glb.numbers(attributes["POSITION"])
        names = glb.numbers(attributes["JOINTS_0"]).astype(int)
        weights = glb.numbers(attributes["WEIGHTS_0"], unit=True)
        weights /= weights.sum(axis=1, keepdims=True)
        matrices = np.einsum("vk,vkij->vij", weights, joints[names])
        yield np.einsum("vij,vj->vi", matrices, np.c_[positions, np.ones(len(positions))])[:, :3]


def main():
    folder = pathlib.Path(sys.argv[1])
    cases = []
    for file, clip, seconds, picked in CASES:
        vertices = []
        for number, positions in enumerate(posed(Glb(folder / file), clip, seconds)):
            for vertex in picked.get(number, []):
                at = [float(f"{v:.8g}") for v in positions[vertex]]
                vertices.append({"primitive": number, "vertex": vertex, "position": at})
        cases.append({"file": file, "clip": clip, "seconds": seconds, "vertices": vertices})
    print(json.dumps(cases, indent=1))


main()
