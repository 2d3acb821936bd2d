"""Steps of the engines that are compared with the portable one, in turn, in one process."""

import bench

SIDE = 256 if bench.options.quick else 1024
engines = ["cpu-portable:1", "cpu:1", "cpu:2"]
devices = bench.output(bench.options.build / "bin" / "pave", "info")
if any(line.startswith("vulkan-compute") and "not usable" not in line for line in devices.splitlines()):
    engines.append("vulkan-compute:2")
report = bench.step("--side", SIDE, "--rounds", 2 if bench.options.quick else 5, *engines)
portable, *others = report["engines"]
for engine in others:
    backend, threads = engine["engine"].split(":")
    bench.pair(f"one step, {SIDE}² px, h = 4, {engine['name']}, {threads} thread{'s' * (threads != '1')}",
               engine["step_s"], "cpu-portable, 1 thread", portable["step_s"])
if "vulkan-compute:2" not in engines:
    bench.skipped("one step, vulkan-compute", "cpu-portable", "no device")
bench.done("engines")
