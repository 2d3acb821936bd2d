"""What the comparisons share: options, a drawing, rounds in turn, the table and its JSON."""

import argparse
import importlib.util
import json
import pathlib
import subprocess
import time

import numpy

parser = argparse.ArgumentParser()
parser.add_argument("build", type=pathlib.Path, help="where libpave was built")
parser.add_argument("scratch", type=pathlib.Path, help="folder for files; results go to its results/")
parser.add_argument("--quick", action="store_true")
parser.add_argument("--long", action="store_true")
options = parser.parse_args()
rows = []


def waves(side):
    """Black and white bands, side x side, 0 and 255."""
    y, x = numpy.ogrid[:side, :side]
    border = y + 64 * numpy.sin(x * (2 * numpy.pi / 341)).round().astype(int)
    return numpy.where(border // 80 % 2, 255, 0).astype(numpy.uint8)


def available(module):
    return importlib.util.find_spec(module) is not None




def in_turn(jobs, rounds):
    """Calls each of {name: job} in every round. A job returns seconds, or None if it is to be timed from outside. The
    least of each."""
    least = dict.fromkeys(jobs, float("inf"))
    for _ in range(rounds):
        for name, job in jobs.items():
            since = time.perf_counter()
            inside = job()
            took = time.perf_counter() - since if inside is None else inside
            least[name] = min(least[name], took)
    return least


def output(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def step(*arguments):
    """Runs bench_step; its report."""
    return json.loads(output(options.build / "bin" / "bench_step", *arguments))


def pair(what, pave, rival, rival_seconds, note=""):
    """One row: pave's seconds against a rival's."""
    rows.append({"what": what, "pave_s": pave, "rival": rival, "rival_s": rival_seconds,
                 "ratio": pave / rival_seconds, "note": note})
    print(f"| {what} | {1e3 * pave:.1f} ms | {rival} | {1e3 * rival_seconds:.1f} ms | {pave / rival_seconds:.2f} |")


def skipped(what, rival, why):
    rows.append({"what": what, "rival": rival, "skipped": why})
    print(f"| {what} | | {rival} | skipped: {why} | |")


def value(what, amount, unit):
    rows.append({"what": what, "value": amount, "unit": unit})
    print(f"| {what} | {amount:.2f} {unit} | | | |")


def done(name):
    results = options.scratch / "results"
    results.mkdir(exist_ok=True)
    (results / (name + ".json")).write_text(json.dumps(rows))
