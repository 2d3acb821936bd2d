"""Judges maps and models of a pavement by other means than the library's:

    maps.py maps STONES.svg FOLDER     number, coverage, normals, occlusion of a folder that was written as EXR
    maps.py crop WHOLE PART            the part's images are the crop of the whole's
    maps.py wraps WHOLE PART           the same, where the whole repeats
    maps.py model FILE.glb [STONES]    a file of glTF 2.0 whose stones are closed, and as many"""
import io
import json
import re
import struct
import sys
import zlib

import numpy as np
from PIL import Image
from shapely.geometry import Polygon, box


def read_exr(path):
    """Channels of a scan line file, ZIP or bare, as OpenEXR describes it."""
    data, at, head = open(path, "rb").read(), 8, {}
    assert data[:4] == b"\x76\x2f\x31\x01"
    while data[at]:
        end = data.index(b"\0", at)
        name, at = data[at:end].decode(), end + 1
        at = data.index(b"\0", at) + 1
        size, = struct.unpack_from("<i", data, at)
        head[name], at = data[at + 4:at + 4 + size], at + 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", head["dataWindow"])
    width, height, rows = x1 - x0 + 1, y1 - y0 + 1, {0: 1, 2: 1, 3: 16}[head["compression"][0]]
    channels, c = [], 0
    while head["channels"][c]:
        end = head["channels"].index(b"\0", c)
        channels.append((head["channels"][c:end].decode(), struct.unpack_from("<i", head["channels"], end + 1)[0]))
        c = end + 17
    kinds = {0: "<u4", 1: "<f2", 2: "<f4"}
    out = {name: np.zeros((height, width), kinds[kind]) for name, kind in channels}
    line = sum(np.dtype(kinds[kind]).itemsize for _, kind in channels) * width
    for offset in struct.unpack_from("<%dQ" % -(-height // rows), data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        count = min(rows, height - (y - y0))
        raw = data[offset + 8:offset + 8 + size]
        if size < line * count:
            raw = np.frombuffer(zlib.decompress(raw), np.uint8).astype(np.int64)
            raw[1:] -= 128
            raw = (np.cumsum(raw) & 255).astype(np.uint8)
            half, mixed = (len(raw) + 1) // 2, np.empty(len(raw), np.uint8)
            mixed[0::2], mixed[1::2] = raw[:half], raw[half:]
            raw = mixed.tobytes()
        place = 0
        for row in range(count):
            for name, kind in channels:
                n = width * np.dtype(kinds[kind]).itemsize
                out[name][y - y0 + row] = np.frombuffer(raw[place:place + n], kinds[kind])
                place += n
    return out


def read_stones(path):
    text = open(path).read()
    for number, part, points in re.findall(r'<polygon id="s(\d+)(?:-(\d+))?" points="([^"]*)"', text):
        yield int(number), int(part or 0), np.array([[float(v) for v in p.split(",")] for p in points.split()])


def inside(ring, x, y):
    """Even-odd at points."""
    found = np.zeros(np.broadcast(x, y).shape, bool)
    for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, 0)):
        if ay != by:
            found ^= ((ay <= y) != (by <= y)) & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return found


def judge_numbers(about, maps, stones):
    """Every px's stone, but for centres that lie on a side as far as the grid of 1/1000 px of the maps can tell."""
    scale, ids = about["maps"]["scale"], np.zeros(maps["id"]["id"].shape, np.int64)
    for number, part, ring in stones:
        ring = ring * scale - [about["x"], about["y"]]
        low, high = np.maximum(np.floor(ring.min(0)).astype(int), 0), np.ceil(ring.max(0)).astype(int)
        x, y = np.arange(low[0], min(high[0], ids.shape[1])) + 0.5, np.arange(low[1], min(high[1], ids.shape[0])) + 0.5
        if len(x) and len(y):
            ids[low[1]:high[1], low[0]:high[0]][inside(ring, x[None], y[:, None])] = (number + 1) * 16 + part
    mine = maps["id"]["id"].astype(np.int64) * 16 + maps["id"]["part"]
    off, whole = mine != ids, float(scale).is_integer()
    assert (mine > 0).mean() > 0.5 and off.mean() <= (0 if whole else 1e-4), off.sum()
    assert not off.any() or np.abs(maps["mask"]["Y"][off].astype(float) - 0.5).max() < 0.01


def judge_coverage(about, maps, stones):
    scale, mask = about["maps"]["scale"], maps["mask"]["Y"].astype(float)
    sums = np.zeros(mask.shape)
    for _, _, ring in stones:
        ring = ring * scale - [about["x"], about["y"]]
        polygon = Polygon(ring)
        convex = polygon.convex_hull.area - polygon.area < 1e-9
        low, high = np.floor(ring.min(0)).astype(int), np.ceil(ring.max(0)).astype(int)
        corners = inside(ring, np.arange(low[0], high[0] + 1)[None], np.arange(low[1], high[1] + 1)[:, None])
        for x in range(low[0], high[0]):
            for y in range(low[1], high[1]):
                if 0 <= x < mask.shape[1] and 0 <= y < mask.shape[0]:
                    within = convex and corners[y - low[1]:, x - low[0]:][:2, :2].all()
                    sums[y, x] += 1 if within else polygon.intersection(box(x, y, x + 1, y + 1)).area
    error = np.abs(mask - np.clip(sums, 0, 1)).max()
    assert error < 0.5 / 255 + 0.001, error  # the map has 8 bits, and half floats hold them


def judge_normals(about, maps):
    height, scale = maps["height"]["Y"].astype(np.float64), about["maps"]["scale"]
    across = (height[1:-1, 2:] - height[1:-1, :-2]) / 2 * scale
    down = (height[2:, 1:-1] - height[:-2, 1:-1]) / 2 * scale
    n = np.dstack([-across, down if about["maps"]["normal"] == "up" else -down, np.ones_like(down)])
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    mine = np.dstack([maps["normal"][c][1:-1, 1:-1].astype(np.float64) for c in "RGB"]) * 2 - 1
    assert np.abs(mine - n).max() < 4e-5, np.abs(mine - n).max()
    assert np.abs(np.linalg.norm(mine, axis=2) - 1).max() < 1e-4
    assert about["height_lowest"] - 1e-5 <= height.min() and height.max() <= about["height_highest"] + 1e-5


def judge_occlusion(about, maps):
    """At some px, every px within reach looked at, over 64 ways."""
    height, scale = maps["height"]["Y"].astype(np.float64), about["maps"]["scale"]
    reach, errors = about["maps"]["occlusion"] * about["maps"]["half_side"] * scale, []
    rim, chance = int(reach) + 1, np.random.default_rng(1)
    for _ in range(60):
        x, y = chance.integers(rim, height.shape[1] - rim), chance.integers(rim, height.shape[0] - rim)
        sky = 0
        for way in np.arange(64) * 2 * np.pi / 64:
            far = np.arange(1, reach, 0.5)
            dx, dy = np.rint(far * np.cos(way)).astype(int), np.rint(far * np.sin(way)).astype(int)
            rise = (height[y + dy, x + dx] - height[y, x]) * scale / np.maximum(np.hypot(dx, dy), 1)
            sky += 1 / (1 + max(rise.max(), 0) ** 2) / 64
        errors.append(float(maps["occlusion"]["Y"][y, x]) - sky)
    assert abs(np.mean(errors)) < 0.05 and np.sqrt(np.mean(np.square(errors))) < 0.1, (np.mean(errors), np.std(errors))


def judge_maps(svg, folder):
    about = json.load(open(folder + "/maps.json"))
    maps = {name: read_exr(folder + "/" + file) for name, file in about["files"].items()}
    stones = list(read_stones(svg))
    for name, channels in maps.items():
        assert all(c.shape == (about["height"], about["width"]) for c in channels.values()), name
    judge_numbers(about, maps, stones)
    judge_coverage(about, maps, stones)
    judge_normals(about, maps)
    judge_occlusion(about, maps)
    print(f"{len(stones)} stones, {about['width']} x {about['height']} px: numbers, coverage, normals, occlusion")


def load(folder):
    about = json.load(open(folder + "/maps.json"))
    images = {}
    for name, file in about["files"].items():
        path = folder + "/" + file
        found = read_exr(path) if file.endswith(".exr") else {"": np.asarray(Image.open(path))}
        images.update({(name, c): pixels for c, pixels in found.items()})
    return about, images


def judge_crop(whole, part, wraps):
    a, images = load(whole)
    b, parts = load(part)
    x, y = b["x"] - a["x"], b["y"] - a["y"]
    rows, columns = np.arange(y, y + b["height"]), np.arange(x, x + b["width"])
    if wraps:
        rows, columns = rows % a["height"], columns % a["width"]
    for key, pixels in parts.items():
        assert np.array_equal(images[key][np.ix_(rows, columns)], pixels), key
    print(f"{part}: {b['width']} x {b['height']} px at {x}, {y} of {whole}")


class Model:
    """A GLB file, taken apart as the standard says; every number in its bounds."""

    def __init__(self, path):
        data = open(path, "rb").read()
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.json = json.loads(data[20:20 + size])
        more, kind = struct.unpack_from("<I4s", data, 20 + size)
        self.bytes = data[28 + size:]
        assert kind == b"BIN\0" and len(self.bytes) == more == self.json["buffers"][0]["byteLength"]
        assert self.json["asset"]["version"] == "2.0" and len(self.json["buffers"]) == 1
        last = 0
        for view in self.json["bufferViews"]:
            assert view["byteOffset"] % 4 == 0 and view["byteOffset"] >= last and view["byteLength"] > 0
            last = view["byteOffset"] + view["byteLength"]
            assert last <= more
        mesh, = self.json["meshes"]
        self.primitive, = mesh["primitives"]

    def numbers(self, accessor):
        a = self.json["accessors"][accessor]
        view = self.json["bufferViews"][a["bufferView"]]
        kind = {5126: "<f4", 5125: "<u4"}[a["componentType"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[a["type"]]
        assert a["count"] * width * 4 == view["byteLength"]
        found = np.frombuffer(self.bytes, kind, a["count"] * width, view["byteOffset"]).reshape(-1, width)
        if "min" in a:
            assert np.array_equal(np.float32(a["min"]), found.min(0)) and np.array_equal(np.float32(a["max"]), found.max(0))
        return found

    def attribute(self, name):
        return self.numbers(self.primitive["attributes"][name])

    def picture(self, texture):
        source = self.json["images"][self.json["textures"][texture["index"]]["source"]]
        view = self.json["bufferViews"][source["bufferView"]]
        assert source["mimeType"] == "image/png"
        return Image.open(io.BytesIO(self.bytes[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]))


def judge_solids(position, normal, triangles):
    """Closed, outwards, and no triangle without area; returns the number of stones."""
    _, weld = np.unique(position, axis=0, return_inverse=True)
    corners = position[triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    assert area.min() > 0, area.min()
    assert ((across / area[:, None])[:, None] * normal[triangles]).sum(2).min() > 0, "a normal points inwards"
    welded = weld.reshape(-1)[triangles]
    edges = np.concatenate([welded[:, [0, 1]], welded[:, [1, 2]], welded[:, [2, 0]]])
    there = np.sort(edges[:, 0].astype(np.int64) << 32 | edges[:, 1])
    back = np.sort(edges[:, 1].astype(np.int64) << 32 | edges[:, 0])
    assert len(np.unique(there)) == len(there), "an edge has two sides of one way"
    assert np.array_equal(there, back), "a stone is open"
    parent = np.arange(welded.max() + 1)
    while True:  # the least number spreads over each stone
        least = np.minimum.reduce([parent[welded[:, i]] for i in range(3)])
        new = parent.copy()
        for i in range(3):
            np.minimum.at(new, welded[:, i], least)
        if np.array_equal(new, parent):
            break
        parent = new
    stone = parent[welded[:, 0]]
    volume = np.zeros(len(parent))
    np.add.at(volume, stone, (corners[:, 0] * across).sum(1) / 6)
    assert volume[np.unique(stone)].min() > 0, "a stone is inside out"
    return len(np.unique(stone))


def judge_model(path, stones=None):
    model = Model(path)
    position, normal = model.attribute("POSITION"), model.attribute("NORMAL")
    triangles = model.numbers(model.primitive["indices"]).reshape(-1, 3)
    assert triangles.max() < len(position) and np.isfinite(position).all()
    assert len(np.unique(triangles)) == len(position), "a vertex is not used"
    assert np.abs(np.linalg.norm(normal.astype(np.float64), axis=1) - 1).max() < 1e-6
    floor = len(np.unique(position[triangles[-2:]][:, :, 1])) == 1 and triangles[-1].max() == len(position) - 1
    found = judge_solids(position, normal, triangles[:-2] if floor else triangles)
    assert stones is None or found == int(stones), (found, stones)
    material = model.json["materials"][model.primitive["material"]]
    if "COLOR_0" in model.primitive["attributes"]:
        colour = model.attribute("COLOR_0")
        assert colour.min() >= 0 and colour.max() <= 1 and colour.std() > 0 and "images" not in model.json
    else:
        uv = model.attribute("TEXCOORD_0")
        assert uv.min() >= 0 and uv.max() <= 1
        pictures = [model.picture(material["pbrMetallicRoughness"][key])
                    for key in ("baseColorTexture", "metallicRoughnessTexture")]
        pictures += [model.picture(material["normalTexture"])] if "normalTexture" in material else []
        assert len({p.size for p in pictures}) == 1
        assert np.asarray(pictures[1])[..., 2].max() == 0, "stone is no metal"
    print(f"{path}: {found} closed stones, {len(position)} vertices, {len(triangles)} triangles"
          + (", a floor" if floor else ""))


if __name__ == "__main__":
    verb, *rest = sys.argv[1:]
    {"maps": judge_maps, "crop": lambda a, b: judge_crop(a, b, False), "wraps": lambda a, b: judge_crop(a, b, True),
     "model": judge_model}[verb](*rest)
