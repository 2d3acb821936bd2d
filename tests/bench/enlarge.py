"""Enlarging generated materials: the table of docs/backends.md (Steinhausen et al. 2014, Table 1).

    /usr/bin/python3 tests/bench/enlarge.py BUILD [--classes tile,grooved,gravel] [--sample 128] [--whole 256] [--json FILE]

Of each class a material of 256 x 256 texels is made, 151 x 151 directions; the 128 x 128 of its middle are the sample.
Errors (Eq. 11) are on log Y, U/Y and V/Y together, at texels outside of the sample, over the least that the sample's
components allow: those of their projection. Baselines are computed here, by numpy, from the sample's coefficients."""

import argparse
import json
import pathlib
import sys
import time

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from btf import CLASSES, Laboratory

EPSILON, LEAST = 0.00032, 1e-5
YUV = numpy.float32([[0.299, 0.587, 0.114], [-0.14713, -0.28886, 0.436], [0.615, -0.51499, -0.10001]])


def encode(samples):
    """[...][RGB] to [plane][...], as the library does: grey light is added up to epsilon."""
    rgb = numpy.maximum(samples, 0)
    rgb = rgb + numpy.maximum(EPSILON - rgb @ YUV[0], 0)[..., None]
    y = rgb @ YUV[0] + numpy.float32(LEAST)
    return numpy.stack([numpy.log(y), (rgb @ YUV[1]) / y, (rgb @ YUV[2]) / y])


class Studio(Laboratory):
    def material(self, name, whole, window=None, stored=0):
        params = self.params("pave_btf_synthesis_params", class_of=CLASSES.index(name), texels=whole, seed=7,
                             directions=1, stored=stored)
        params.window = window or [0, 0, 0, 0]
        return self.make(self.c.pave_btf_synthesize, "pave_btf", self.context, params)

    def on_disk(self, btf, path):
        """Written, and mapped from then on."""
        null = self.ffi.NULL
        if self.c.pave_btf_write(self.context, btf, null, str(path).encode()):
            raise RuntimeError(self.ffi.string(self.c.pave_context_message(self.context)).decode())
        self.free("pave_btf", btf)
        return self.make(self.c.pave_btf_read, "pave_btf", self.context, str(path).encode(), null)

    def plan_of(self, btf, pairs):
        views, lights = [self.ffi.new("int32_t[]", [int(f(p, 151)) for p in pairs]) for f in (int.__floordiv__, int.__mod__)]
        return self.make(self.c.pave_btf_plan_of_pairs, "pave_btf_plan", self.context, btf, views, lights, len(pairs))

    def planned(self, sample, count):
        model = self.model([sample], patch=1, validate=0, symmetric=0)
        plan = self.plan(model, samples=count)
        views, lights = [self.ffi.unpack(f(plan), count) for f in (self.c.pave_btf_plan_views, self.c.pave_btf_plan_lights)]
        self.free("pave_btf_plan", plan)
        self.free("pave_btf_model", model)
        return [v * 151 + l for v, l in zip(views, lights)]

    def picture(self, pixels):
        params = self.params("pave_image_params", width=pixels.shape[1], height=pixels.shape[0], channels=3, type=5,
                             encoding=1)
        return self.make(self.c.pave_image_create, "pave_image", self.context, params,
                         self.ffi.from_buffer(numpy.ascontiguousarray(pixels, numpy.float32)))

    def enlarge(self, sample, photographs, plan, mean, **fields):
        out, report = self.ffi.new("pave_btf **"), self.ffi.new("pave_btf_enlargement *")
        report.size = self.ffi.sizeof(report[0])
        null = self.ffi.NULL
        fields.setdefault("passes", 2)
        if self.c.pave_btf_enlarge(self.context, sample, photographs or null, plan or null, mean or null,
                                   self.params("pave_btf_enlarge_params", type=5, **fields), out, report):
            raise RuntimeError(self.ffi.string(self.c.pave_context_message(self.context)).decode())
        return out[0], report

    def factors(self, btf):
        """[pair][component] of each plane, and [y][x][component] of all planes side by side."""
        c, pairs = self.c, self.c.pave_btf_views(btf) * self.c.pave_btf_lights(btf)
        shape = self.c.pave_btf_height(btf), self.c.pave_btf_width(btf)
        left, right = [], []
        for plane in range(3):
            n = c.pave_btf_components(btf, plane)
            left.append(numpy.frombuffer(self.ffi.buffer(c.pave_btf_eigenvectors(btf, plane), 4 * pairs * n),
                                         numpy.float32).reshape(pairs, n).copy())
            right.append(numpy.frombuffer(self.ffi.buffer(c.pave_btf_coefficients(btf, plane),
                                                          4 * shape[0] * shape[1] * n), numpy.float32).reshape(*shape, n))
        return left, numpy.concatenate(right, 2)


class Truth:
    """Blocks of three texels, outside of the sample: a texel, its right and its lower neighbour."""

    def __init__(self, studio, scene, whole, sample, left, count=600):
        chance = numpy.random.default_rng(1)
        first = (whole - sample) // 2
        corners = chance.integers(0, whole - 1, (4 * count, 2))
        inside = ((corners >= first - 1) & (corners < first + sample)).all(1)
        corners = corners[~inside][:count]
        self.at = numpy.stack([corners, corners + [0, 1], corners + [1, 0]], 1)  # [block][3][y, x]
        flat = self.at.reshape(-1, 2)
        one = numpy.empty((151 * 151, 3), numpy.float32)
        self.energy, self.z = numpy.zeros(len(flat)), []
        for y, x in flat:
            studio.c.pave_btf_abrdf(scene, int(x), int(y), studio.ffi.from_buffer("float[]", one))
            planes = encode(one)
            z = numpy.concatenate([left[p].T @ planes[p] for p in range(3)])
            self.energy[len(self.z)] = (planes.astype(float) ** 2).sum() - (z.astype(float) ** 2).sum()
            self.z.append(z)
        self.z = numpy.array(self.z)
        self.values = 3 * 151 * 151

    def coefficients(self, field):
        return field[self.at[..., 0].ravel(), self.at[..., 1].ravel()]

    def error(self, field):
        missed = ((self.coefficients(field) - self.z).astype(float) ** 2).sum(1) + numpy.maximum(self.energy, 0)
        return float(numpy.sqrt(missed / self.values).mean())

    def sharpness(self, field):
        def roughness(z):
            z = z.reshape(-1, 3, z.shape[1])
            return float(((z[:, 1:] - z[:, :1]).astype(float) ** 2).sum())
        return roughness(self.coefficients(field)) / roughness(self.z)


# ---- Baselines ----

def windows(guides, reach):
    padded = numpy.pad(guides, ((reach, reach), (reach, reach), (0, 0)), mode="reflect")
    view = numpy.lib.stride_tricks.sliding_window_view(padded, (2 * reach + 1, 2 * reach + 1), axis=(0, 1))
    return view.reshape(*guides.shape[:2], -1)


def axes(vectors, count):
    mean = vectors.mean(0)
    value, vector = numpy.linalg.eigh(numpy.atleast_2d(numpy.cov((vectors - mean).T)))
    return mean, vector[:, ::-1][:, :count]


def ridge(features, targets, everywhere):
    """Weights of the least squares with a ridge that is chosen by holding out every fourth block of texels."""
    mean, middle = features.mean(0), targets.mean(0)
    f, t = features - mean, targets - middle
    fold = numpy.arange(len(f)) * 16 // len(f) % 4
    best = None
    for share in (1e-5, 1e-4, 1e-3, 1e-2, 1e-1):
        missed = 0
        for k in range(4):
            a = f[fold != k].T @ f[fold != k]
            a[numpy.diag_indices_from(a)] += share * numpy.trace(a) / len(a)
            missed += ((f[fold == k] @ numpy.linalg.solve(a, f[fold != k].T @ t[fold != k]) - t[fold == k]) ** 2).sum()
        if best is None or missed < best[0]:
            best = missed, share
    a = f.T @ f
    a[numpy.diag_indices_from(a)] += best[1] * numpy.trace(a) / len(a)
    return (everywhere - mean) @ numpy.linalg.solve(a, f.T @ t) + middle


def kernel_ridge(features, targets, everywhere):
    chance = numpy.random.default_rng(0)
    pick = chance.permutation(len(features))[:4096]
    f, t, middle = features[pick], targets[pick], targets.mean(0)
    fold = numpy.arange(len(f)) % 4

    def squares(a, b):
        return numpy.maximum((a * a).sum(1)[:, None] + (b * b).sum(1) - 2 * a @ b.T, 0)
    distance = squares(f, f)
    scale, best = numpy.median(distance), None
    for width in (0.5, 1, 2):
        k = numpy.exp(-distance / (2 * width * scale))
        for share in (1e-4, 1e-3, 1e-2):
            missed = 0
            for out in range(4):
                a = k[numpy.ix_(fold != out, fold != out)]
                a[numpy.diag_indices_from(a)] += share * len(a) * 0.01
                w = numpy.linalg.solve(a, t[fold != out] - middle)
                missed += ((k[numpy.ix_(fold == out, fold != out)] @ w - t[fold == out] + middle) ** 2).sum()
            if best is None or missed < best[0]:
                best = missed, width, share
    k = numpy.exp(-distance / (2 * best[1] * scale))
    k[numpy.diag_indices_from(k)] += best[2] * len(k) * 0.01
    w = numpy.linalg.solve(k, t - middle)
    return numpy.exp(-squares(everywhere, f) / (2 * best[1] * scale)) @ w + middle


def baselines(truth, known, seen, given, first):
    """Of each the error and the sharpness at the texels of the truth."""
    whole, sample, n = given.shape[0], known.shape[0], known.shape[2]
    z = known.reshape(-1, n).astype(numpy.float64)
    at = truth.at.reshape(-1, 2)
    out = {}

    def put(name, values):
        field = numpy.zeros((whole, whole, n), numpy.float32)
        field[at[:, 0], at[:, 1]] = values
        out[name] = truth.error(field), truth.sharpness(field)
    put("mean", numpy.broadcast_to(z.mean(0), (len(at), n)))
    put("tiling", known[(at[:, 0] - first) % sample, (at[:, 1] - first) % sample])
    put("texel ridge", ridge(seen.reshape(-1, seen.shape[2]).astype(float), z, given[at[:, 0], at[:, 1]].astype(float)))
    mean, turn = axes(seen.reshape(-1, seen.shape[2]).astype(float), 8)
    patch = [windows(((g - mean) @ turn).astype(numpy.float32), 3) for g in (seen, given)]
    learn, ask = patch[0].reshape(-1, patch[0].shape[2]), patch[1][at[:, 0], at[:, 1]]
    nearest = numpy.concatenate([((learn * learn).sum(1)[None] - 2 * a @ learn.T).argmin(1)
                                 for a in numpy.array_split(ask, 20)])
    put("nearest copy", z[nearest])
    put("patch ridge", ridge(learn.astype(float), z, ask.astype(float)))
    mean, turn = axes(learn[::4].astype(float), 96)
    put("kernel ridge", kernel_ridge((learn - mean) @ turn, z, (ask - mean) @ turn))
    return out


# ---- A class ----

COUNTS = 1, 2, 4, 10, 20, 40


def even_light(studio, scene, whole):
    """The picture from the top view under all lights at once (Eq. 10)."""
    mean = numpy.zeros((whole, whole, 3), numpy.float32)
    picture = numpy.empty_like(mean)
    for light in range(151):
        studio.c.pave_btf_texture(scene, 0, light, studio.ffi.from_buffer("float[]", picture))
        mean += picture / 151
    return studio.picture(mean)


def jobs(kinds, wanted, sets, nested):
    """(photographs, their pairs or None, label, parameters) of every run."""
    counted = {f"random {n}": nested[:n] for n in COUNTS}
    for of, pairs in list(sets.items()) + [("mean", None)]:
        if of not in wanted:
            continue
        if "paper" in kinds:
            yield of, pairs, "paper 1", dict(mode=1, stage=1)
        if "best" in kinds:
            yield of, pairs, "best", {}
        if "look" in kinds and pairs:
            yield of, pairs, "look", dict(aim=1)
    for of, pairs in counted.items():
        if "counts" in kinds and len(pairs) not in (1, 10):
            yield of, pairs, "best", {}
        if "forced" in kinds:
            yield of, pairs, "paper 3", dict(mode=1, stage=3)
        if "forced" in kinds and len(pairs) in (1, 10):
            yield of, pairs, "paper 2", dict(mode=1, stage=2)


def study(studio, name, options, row, keep):
    kinds = options.kinds.split(",")
    first = (options.whole - options.sample) // 2
    scene = studio.material(name, options.whole)
    sample = studio.material(name, options.whole, [first, first, options.sample, options.sample], not options.disk)
    if options.disk:
        sample = studio.on_disk(sample, pathlib.Path(options.disk) / f"{name}-{options.sample}.bdi")
    chance = numpy.random.default_rng(3)
    nested = [0] + [int(p) for p in chance.permutation(151 * 151)[:39]]
    if "planned" in options.sets and "plan" not in row:
        row["plan"] = [int(p) for p in studio.planned(sample, 10)]
        keep()
    sets = {"top": nested[:1], "random": nested[:10], "planned": row.get("plan")}
    even = None
    state = {}

    def put(key, values):
        row[key] = values
        print(name, key, "error %.3f sharpness %.2f, %.0f s" % values, flush=True)
        keep()

    def run(of, pairs, label, fields):
        plan = studio.plan_of(scene, pairs) if pairs else None
        began = time.time()
        out, _ = studio.enlarge(sample, scene if pairs else None, plan, None if pairs else even, x=first, y=first,
                                components=options.components, **fields)
        took = time.time() - began
        left, field = studio.factors(out)
        if not state:
            state["truth"] = Truth(studio, scene, options.whole, options.sample, left)
            state["known"] = field[first:first + options.sample, first:first + options.sample].copy()
            truth = state["truth"]
            row["least"] = float(numpy.sqrt(numpy.maximum(truth.energy, 0) / truth.values).mean())
        truth = state["truth"]
        if label:
            put(f"{of} {label}", (truth.error(field) / row["least"], truth.sharpness(field), took))
        studio.free("pave_btf", out)
        if plan:
            studio.free("pave_btf_plan", plan)

    def guides(pairs):
        """Encoded photographs of the whole, [y][x][photograph, plane]."""
        out = numpy.empty((options.whole, options.whole, 3 * len(pairs)), numpy.float32)
        picture = numpy.empty((options.whole, options.whole, 3), numpy.float32)
        for i, p in enumerate(pairs):
            studio.c.pave_btf_texture(scene, p // 151, p % 151, studio.ffi.from_buffer("float[]", picture))
            out[..., 3 * i:3 * i + 3] = numpy.moveaxis(encode(picture), 0, -1)
        return out

    for of, pairs, label, fields in jobs(kinds, options.sets.split(","), sets, nested):
        if f"{of} {label}" in row:
            continue
        if not pairs and not even:
            even = even_light(studio, scene, options.whole)
        run(of, pairs, label, fields)
    for of, pairs in sets.items() if "baselines" in kinds else ():
        if f"{of} mean" in row or of not in options.sets.split(","):
            continue
        if not state:
            run(of, pairs, "", dict(mode=1, stage=1, levels=1))
        given = guides(pairs)
        seen = given[first:first + options.sample, first:first + options.sample]
        for label, (error, sharp) in baselines(state["truth"], state["known"], seen, given, first).items():
            put(f"{of} {label}", (error / row["least"], sharp, 0))
    if even:
        studio.free("pave_image", even)
    studio.free("pave_btf", scene)
    studio.free("pave_btf", sample)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--classes", default="tile,grooved,gravel")
    parser.add_argument("--sample", type=int, default=128)
    parser.add_argument("--whole", type=int, default=256)
    parser.add_argument("--kinds", default="best,look,paper,baselines",
                        help="and counts: best mode from 2 to 40; forced: the paper's other stages from 1 to 40")
    parser.add_argument("--sets", default="top,random,planned,mean", help="of photographs")
    parser.add_argument("--components", type=int, default=128, help="of luminance, half as many of each other channel")
    parser.add_argument("--disk", help="a folder for samples that are not to be held in memory")
    parser.add_argument("--most", type=float, default=0, help="GiB that the library may take")
    parser.add_argument("--json", help="rows that are in this file already are not run again")
    options = parser.parse_args()
    studio = Studio(pathlib.Path(options.build) / "lib" / "libpave.so", 2, most=int(options.most * 2**30))
    file = pathlib.Path(options.json) if options.json else None
    rows = json.loads(file.read_text()) if file and file.exists() else {}

    def keep():
        if file:
            file.write_text(json.dumps(rows, indent=1))
    for name in options.classes.split(","):
        study(studio, name, options, rows.setdefault(name, {}), keep)


if __name__ == "__main__":
    main()
