#!/usr/bin/env python3
"""Scenes of other sizes and at other places, against the original: bench/results/scales.md.

The means are those of the slow tests of tests/render/scale_test.cc, which it runs.

usage: tables_scales.py [SEEDS]     pictures of each mean, 16 by default
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LINE = re.compile(r"(\S+), (.+), scale (\S+), moved by (\S+) of its size: (\S+ \+- \S+) of the original")
HEAD = """# Scenes of other sizes and at other places

Written by `bench/tables_scales.py %d`. Mean of that many pictures of 24x24 pixels over that of the original with the same
samples, and its standard error. A scene that was moved is compared with itself moved back, since rounding far away bends
its shape. At scales that are powers of two, from 1e-9 m to 1e12 m, pictures have the same bits (`ScaledScenes`). Moved
by 10,000 sizes, scenes have the bits of themselves moved back (`DistantScenes`).

| scene | integrator | scale | moved by (sizes of the scene) | mean ratio |
| --- | --- | ---: | ---: | --- |
"""

program = os.path.join(ROOT, "build/release/bin/render_test")
seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 16
run = subprocess.run([program, "--gtest_filter=*SlowScaledScenes*"], stdout=subprocess.PIPE, text=True,
                     env={**os.environ, "GLOWWORM_SCALE_SEEDS": str(seeds)})
rows = [LINE.match(line) for line in run.stdout.splitlines()]
with open(os.path.join(ROOT, "bench/results/scales.md"), "w") as page:
    page.write(HEAD % seeds + "".join("| {} | {} | {} | {} | {} |\n".format(*row.groups()) for row in rows if row))
# The tests' bounds are for all seeds.
sys.exit(run.returncode if seeds >= 16 else 0)
