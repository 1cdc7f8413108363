#!/usr/bin/env python3
"""Measures one picture on many machines, and models more of them: bench/results/many-machines.md. As root, network
namespaces with addresses and folders of their own stand for machines; otherwise all ranks are on one.

usage: tables_machines.py [PROGRAM]
"""
import os
import pathlib
import platform
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/glowworm").resolve()
SIZE, PIXELS = "320x180", 320 * 180
SHARED = ["render", "builtin:atrium", "--size", SIZE, "--precision", "float", "-q"]
FEW = ["--gather", "4", "--photons", "20k", "--threads", "1"]
MACHINES = 3
NODE_CORES, NETWORK = 32, 1.25e9  # of the model: cores, and bytes a second into rank 0
BIG_SLOTS = 7680 * 4320 * 1000  # 8K, 1000 samples
AGENT = """#!/bin/bash
host=$1; shift
exec ip netns exec gwm$((${host##*.} - 1)) unshare -m -u bash -c \
  "hostname machine${host##*.}; mount -t tmpfs own /mnt; cd /mnt; $*"
"""


def run(arguments, **more):
    """Runs the program; returns its processor seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([PROGRAM, *arguments], check=True, **more)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def ip(words, check=True):
    subprocess.run(["ip", *words.split()], check=check, stderr=None if check else subprocess.DEVNULL)


def remove_machines():
    for i in range(MACHINES):
        ip(f"netns del gwm{i}", check=False)


def make_machines():
    """Namespaces gwm0 and so on, with the addresses 10.77.1.1 and so on, on one bridge."""
    remove_machines()
    ip("netns add gwm0")
    ip("-n gwm0 link set lo up")
    ip("-n gwm0 link add br0 type bridge")
    ip("-n gwm0 addr add 10.77.1.1/24 dev br0")
    ip("-n gwm0 link set br0 up")
    for i in range(1, MACHINES):
        ip(f"netns add gwm{i}")
        ip(f"link add gwp{i} netns gwm0 type veth peer name eth0 netns gwm{i}")
        ip(f"-n gwm0 link set gwp{i} master br0 up")
        ip(f"-n gwm{i} addr add 10.77.1.{i + 1}/24 dev eth0")
        ip(f"-n gwm{i} link set eth0 up")
        ip(f"-n gwm{i} link set lo up")


def mpirun(folder, ranks, arguments):
    """Starts the program as ranks, each on its own machine if there are any."""
    words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)]
    if os.geteuid() == 0:
        agent = folder / "agent"
        agent.write_text(AGENT, encoding="utf-8")
        agent.chmod(0o755)
        hosts = ",".join(f"10.77.1.{i + 1}:1" for i in range(ranks))
        words = ["ip", "netns", "exec", "gwm0", *words, "-H", hosts, "-wdir", str(folder), "--mca", "plm_rsh_agent",
                 str(agent), "--mca", "btl", "tcp,self", "--mca", "btl_tcp_if_include", "10.77.1.0/24", "--mca",
                 "oob_tcp_if_include", "10.77.1.0/24"]
    return subprocess.Popen([*words, str(PROGRAM), *arguments], cwd=folder, stderr=subprocess.DEVNULL)


def ranks_of(output):
    """Processes of a render by rank."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and (entry / "comm").read_text().strip() == "glowworm" and \
                    output.encode() in (entry / "cmdline").read_bytes():
                rank = re.search(rb"OMPI_COMM_WORLD_RANK=(\d+)", (entry / "environ").read_bytes())
                if rank:
                    found[int(rank[1])] = int(entry.name)
        except OSError:
            pass
    return found


def peak_megabytes(process):
    try:
        text = pathlib.Path(f"/proc/{process}/status").read_text(encoding="utf-8")
        return int(re.search(r"VmHWM:\s+(\d+)", text)[1]) / 1e3
    except (OSError, TypeError):
        return 0


def sent_bytes(machine):
    out = subprocess.run(["ip", "netns", "exec", f"gwm{machine}", "cat", "/sys/class/net/eth0/statistics/tx_bytes"],
                         capture_output=True, text=True, check=True)
    return int(out.stdout)


def efficiency(folder):
    """Returns the processor seconds that each part of a render repeats, and those of a sample of a pixel."""
    one, two = (run(["render", "builtin:atrium", "--size", "1280x720", "--samples", "16", "--part", part, "-q", "-o",
                     folder / "a.part"]) for part in ("1/16", "1/8"))
    each = two - one
    return max(one - each, 0), each / (1280 * 720)


def traffic(folder):
    """Returns a row for each rank: bytes sent for a sample of a pixel, and peak megabytes."""
    samples, peaks = 8, {}
    before = [sent_bytes(i) for i in range(1, MACHINES)] if os.geteuid() == 0 else []
    job = mpirun(folder, MACHINES, [*SHARED, *FEW, "--samples", str(samples), "-o", "traffic.exr"])
    while job.poll() is None:
        for rank, process in ranks_of("traffic.exr").items():
            peaks[rank] = max(peaks.get(rank, 0), peak_megabytes(process))
        time.sleep(0.1)
    sent = [sent_bytes(i) - b for i, b in zip(range(1, MACHINES), before)]
    return [(rank, sent[rank - 1] / 1e6 if rank and sent else None, peaks[rank]) for rank in sorted(peaks)], samples


def fault(folder, name, number):
    """Renders by ranks, of which one gets a signal. Returns mpirun's status, its seconds after that, and whether the
    picture, if need be after --resume, has the bits of one process."""
    arguments = [*SHARED, *FEW, "--samples", "64", "-o", f"{name}.exr", f"--resume={name}.checkpoint"]
    job = mpirun(folder, MACHINES, arguments)
    while 1 not in ranks_of(f"{name}.exr") or not (folder / f"{name}.checkpoint").exists():
        time.sleep(0.1)
    start = time.monotonic()
    os.kill(ranks_of(f"{name}.exr")[1], number)
    status = job.wait()
    seconds = time.monotonic() - start
    if not (folder / f"{name}.exr").exists():
        run(arguments, cwd=folder)
    compared = subprocess.run([PROGRAM, "compare", folder / f"{name}.exr", folder / "alone.exr"], capture_output=True,
                              text=True, check=True).stdout
    return status, seconds, re.search(r"largest\s+0\n", compared) is not None


def merge(folder):
    """Returns the seconds and peak megabytes of merging 2 and 8 parts of 1920 x 1080 pixels."""
    rows = []
    for i in range(1, 9):
        run(["render", "builtin:cornell", "--size", "1920x1080", "--samples", "8", "--gather", "1", "--photons", "20k",
             "--aov", "albedo,normal,depth,direct,indirect,position,object-id", "--part", f"{i}/8", "-q", "-o",
             folder / f"{i}.part"])
    for count in (2, 8):
        parts = [str(folder / f"{i + 1}.part") for i in range(count)]
        out = subprocess.run(["/usr/bin/time", "-f", "%e %M", PROGRAM, "merge", *parts, "-q", "-o",
                              folder / "merged.exr"], capture_output=True, text=True, check=True).stderr.split()
        rows.append((count, float(out[-2]), float(out[-1]) / 1e3))
    return rows


def text_of(repeated, each, rows, samples, faults, merged):
    big = [(n, (repeated + each * BIG_SLOTS / n) / NODE_CORES, BIG_SLOTS * 76 / NETWORK) for n in (1, 16, 256, 4096)]
    whole = repeated + each * 1280 * 720 * 16
    lines = [
        "# One picture on many machines", "",
        f"Written by `bench/tables_machines.py` on {platform.machine()}, {os.cpu_count()} cores.", "",
        "## Parts", "",
        f"Each part repeats {repeated:.2f} processor seconds (loading, photons, map, guides). A sample of a pixel of "
        f"the atrium takes {each * 1e6:.1f} us. So n parts of 1280x720 pixels with 16 samples have the efficiency:", "",
        "| parts | one render's processor seconds over those of all parts |", "| ---: | ---: |",
        *(f"| {n} | {whole / (whole + (n - 1) * repeated):.2f} |" for n in (2, 8, 16)), "",
        "| parts of 1920x1080 merged, with layers | s | MB |", "| ---: | ---: | ---: |",
        *(f"| {n} | {s:.1f} | {m:.0f} |" for n, s, m in merged), "",
        "`merge` holds one film and blocks of a part, so its memory does not grow with the parts.", "",
        "## Ranks", "",
        f"{MACHINES} ranks, atrium, {SIZE}, {samples} samples. Photons are not sent: each rank traces all of them.", "",
        "| rank | MB sent | peak MB |", "| ---: | ---: | ---: |",
        *(f"| {r} | {'' if sent is None else f'{sent:.1f}'} | {peak:.0f} |" for r, sent, peak in rows), "",
        "A sample of a pixel is 76 bytes in the message of its task, 12 more for each light group or the places of "
        f"hits; all are {PIXELS * samples * 76 / 1e6:.1f} MB here.", "",
        "## Faults", "",
        "| rank 1 of 3 is | status of mpirun | s until it ends | same bits, by --resume if it did not finish |",
        "| --- | ---: | ---: | --- |",
        *(f"| {name} | {status} | {s:.0f} | {'yes' if same else 'no'} |" for name, (status, s, same) in faults), "",
        "## Model", "",
        f"A picture of 7680x4320 pixels with 1000 samples, on nodes of {NODE_CORES} such cores, and a network that "
        f"brings {NETWORK / 1e9:.2f} GB/s to rank 0:", "",
        "| nodes | computing, s | receiving at rank 0, s | ranks, efficiency | parts, efficiency |",
        "| ---: | ---: | ---: | ---: | ---: |",
        *(f"| {n} | {c:.0f} | {0 if n == 1 else r:.0f} | {big[0][1] / n / max(c, 0 if n == 1 else r):.2f} | "
          f"{big[0][1] / n / c:.2f} |" for n, c, r in big), "",
        f"Ranks stop scaling at {big[0][1] / big[1][2]:.0f} nodes, where rank 0 receives all the time. Sending sums of "
        "the samples of a task, or collecting in a tree, would move that point. Parts do not send samples; what they "
        "repeat bounds them, and merging, which a tree of `merge -o x.part` divides.", ""]
    return "\n".join(lines)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if os.geteuid() == 0:
            make_machines()
        try:
            repeated, each = efficiency(folder)
            rows, samples = traffic(folder)
            run([*SHARED, *FEW, "--samples", "64", "-o", folder / "alone.exr"])
            faults = [(what, fault(folder, what, number))
                      for what, number in (("killed", signal.SIGKILL), ("stopped", signal.SIGSTOP))]
            merged = merge(folder)
        finally:
            if os.geteuid() == 0:
                remove_machines()
    out = ROOT / "bench/results/many-machines.md"
    out.write_text(text_of(repeated, each, rows, samples, faults, merged), encoding="utf-8")


if __name__ == "__main__":
    main()
