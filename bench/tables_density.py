#!/usr/bin/env python3
"""Sums over photons beside nanoflann's radius search, which only finds the pairs: bench/results/density.md.

Runs `density_bench` with 2 million photons and the 10 million query points of 320x320 pixels with 100 gather rays each.
nanoflann and the public sums get the points sorted, and one thread; the density phase of the engine `blocked` sorts them
itself. The rates of a row are medians of runs in turns, over the processor seconds of one thread.

usage: tables_density.py [--runs N] [--simd NAME,...] [SCENE...]     built-in scenes, or files
"""
import argparse
import json
import os
import statistics
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = os.path.join(ROOT, "build/release/bin/density_bench")
SPONZA = os.path.join(ROOT, "../shared/scenes/sponza-dabrovic/pbrt/sponza-sun.pbrt")
SIZE = ["--photons=2000000", "--side=320", "--rays=100"]
FOUND, ONE, EACH = "nanoflann_radius", "public_sum/one_radius", "public_sum/radius_for_each"
PHASE = "estimate/blocked/per_photon/1/real_time"
HEAD = """# Sums over photons beside nanoflann

Written by `bench/tables_density.py`, which says how, on commit %s: million pairs a second of one thread, and in
brackets the range of the ratios of %d runs. A query point sees 45 photons in the mean. %s.

| scene | instructions | nanoflann finds | one radius, summed | over nanoflann | a radius for each photon, summed | over nanoflann | whole density phase | reordering |
| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
"""


def measure(scene, simd, runs):
    """What the program says of itself, and the entries of each benchmark, one for each run."""
    command = [PROGRAM, *SIZE, f"--scene={scene}", f"--simd={simd}", "--benchmark_min_time=0.01",
               f"--benchmark_filter=^({FOUND}|{ONE}|{EACH}|{PHASE})$", "--benchmark_enable_random_interleaving=true",
               f"--benchmark_repetitions={runs}", "--benchmark_format=json"]
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, cwd=ROOT).stdout
    report = json.loads(output)
    found = {}
    for entry in report["benchmarks"]:
        if entry["run_type"] == "iteration":
            found.setdefault(entry["run_name"], []).append(entry)
    return report["context"], found


def row(scene, context, found):
    rates = {name: [1e-6 * entry["pairs"] for entry in entries] for name, entries in found.items()}
    rates[PHASE] = [1e-6 * entry["operations"] * entry["real_time"] / entry["cpu_time"] for entry in found[PHASE]]
    middle = {name: statistics.median(values) for name, values in rates.items()}

    def over(name):
        ratios = [mine / theirs for mine, theirs in zip(rates[name], rates[FOUND])]
        return f"{middle[name] / middle[FOUND]:.1f} ({min(ratios):.1f} to {max(ratios):.1f})"

    share = statistics.median(entry["reorder_share"] for entry in found[PHASE])
    name = os.path.splitext(os.path.basename(scene))[0].removeprefix("builtin:")
    return (f"| {name} | {context['simd']} | {middle[FOUND]:.0f} | {middle[ONE]:.0f} | {over(ONE)} | {middle[EACH]:.0f} | "
            f"{over(EACH)} | {middle[PHASE]:.0f} | {share:.0%} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--simd", type=lambda text: text.split(","), default=["auto", "avx2"])
    parser.add_argument("scenes", nargs="*", metavar="SCENE",
                        default=["builtin:cornell", "builtin:atrium", *([SPONZA] if os.path.exists(SPONZA) else [])])
    options = parser.parse_args()
    lines = []
    for scene in options.scenes:
        for simd in options.simd:
            context, found = measure(scene, simd, options.runs)
            lines.append(row(scene, context, found))
            print(lines[-1], flush=True)
    path = os.path.join(ROOT, "bench/results/density.md")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(HEAD % (context["commit"], options.runs, context["machine"]) + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
