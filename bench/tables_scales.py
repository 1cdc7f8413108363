#!/usr/bin/env python3
"""Scenes of other sizes and at other places, against the original: bench/results/scales.md.

The means are those of the slow tests of tests/render/scale_test.cc, which it runs.

usage: tables_scales.py
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LINE = re.compile(r"(\S+), (.+), scale (\S+), moved by (\S+) of its size: (\S+ \+- \S+) of the original")
HEAD = """# Scenes of other sizes and at other places

Written by `bench/tables_scales.py`. Mean of a picture over that of the original with the same samples, and its standard
error. A scene that was moved is compared with itself moved back, since rounding far away bends its shape.

| scene | integrator | scale | moved by (sizes of the scene) | mean ratio |
| --- | --- | ---: | ---: | --- |
"""

program = os.path.join(ROOT, "build/release/bin/render_test")
run = subprocess.run([program, "--gtest_filter=*SlowScaledScenes*"], stdout=subprocess.PIPE, text=True)
rows = [LINE.match(line) for line in run.stdout.splitlines()]
with open(os.path.join(ROOT, "bench/results/scales.md"), "w") as page:
    page.write(HEAD + "".join("| {} | {} | {} | {} | {} |\n".format(*row.groups()) for row in rows if row))
sys.exit(run.returncode)
