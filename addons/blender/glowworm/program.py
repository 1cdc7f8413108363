"""Finds and runs the program `glowworm`."""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import bpy


def path():
    """The program: of the add-on's preferences, the environment variable GLOWWORM, or PATH."""
    add_on = bpy.context.preferences.addons.get(__package__)
    chosen = bpy.path.abspath(add_on.preferences.program) if add_on else ''
    found = chosen or os.environ.get('GLOWWORM') or shutil.which('glowworm')
    if not found or not os.path.exists(found):
        raise RuntimeError('The program glowworm is not found: give its path in the preferences of the add-on.')
    return found


def arguments(settings):
    """The options that the panel's settings stand for."""
    out = []
    if settings.samples:
        out += ['--samples', str(settings.samples)]
    if settings.noise:
        out += ['--noise', f'{settings.noise / 100:.6g}']
    if settings.seconds:
        out += ['--time', f'{settings.seconds}s']
    if settings.photons:
        out += ['--photons', str(settings.photons)]
    if settings.is_reference:
        out += ['--integrator', 'path']
    return out + settings.options.split()


def run(command, folder, tick):
    """Runs a command in a folder. tick() is called ten times a second; if it returns True, the command ends early and
    writes what it has. Returns what the command printed; raises RuntimeError if it fails."""
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, cwd=folder, stdout=output, stderr=subprocess.STDOUT)
        stopped = False
        while process.poll() is None:
            time.sleep(0.1)
            if not stopped and tick():
                stopped = True
                process.send_signal(signal.SIGTERM if sys.platform == 'win32' else signal.SIGINT)
        output.seek(0)
        text = output.read().decode(errors='replace')
    if process.returncode != 0 and not stopped:
        raise RuntimeError(text.strip()[-2000:] or f'glowworm ended with status {process.returncode}')
    return text
