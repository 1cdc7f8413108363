"""The preview of the viewport: pictures of growing size and quality by the program, in a folder of their own."""
import os
import shutil
import subprocess
import tempfile

import numpy
from mathutils import Matrix

from . import exr, pbrt, program, scene

# Stages: pixels of the region along a side of a pixel, and options of the render.
_STAGES = ((8, ('--samples', '1', '--gather', '4', '--photons', '20k')),
           (4, ('--samples', '2', '--gather', '8', '--photons', '100k')),
           (2, ('--samples', '4', '--photons', '200k')),
           (1, ('--samples', '8')))


def camera_text(view_matrix, window_matrix, is_perspective):
    """pbrt's camera of a viewport, from the matrices of RegionView3D."""
    window = []
    for axis in (0, 1):
        scale = window_matrix[axis][axis]
        shift = window_matrix[axis][2] if is_perspective else -window_matrix[axis][3]
        window += [(shift - 1) / scale, (shift + 1) / scale]
    place = f'Transform {pbrt.matrix(Matrix.Diagonal((1, 1, -1, 1)) @ view_matrix)}'
    kind = '"perspective" "float fov" [90]' if is_perspective else '"orthographic"'
    return f'{place}\nCamera {kind} "float screenwindow" {pbrt.numbers(window)}'


class Preview:
    """Call update() when the scene has changed and look() for each frame; picture() is the best picture so far."""

    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix='glowworm-preview-')
        self.body = ''
        self.seen = None   # what the pictures show
        self.stage = 0
        self.process = None
        self.pixels = None

    def close(self):
        self._stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def update(self, depsgraph):
        """Takes the scene as it is now."""
        self._stop()
        self.body = scene.Exporter(self.folder, depsgraph).body()
        self.seen = None

    def look(self, camera, width, height):
        """Takes the view and the size of the region in pixels, and goes on with the next stage. Returns whether more
        pictures follow."""
        if (camera, width, height) != self.seen:
            self._stop()
            self.seen, self.stage = (camera, width, height), 0
        if self.process is not None and self.process.poll() is not None:
            self._take()
        if self.process is None and self.stage < len(_STAGES):
            self._start()
        return self.process is not None

    def picture(self):
        """RGBA as an array of rows from the bottom, float; None before the first picture."""
        return self.pixels

    def _path(self, name):
        return os.path.join(self.folder, name)

    def _start(self):
        camera, width, height = self.seen
        each, options = _STAGES[self.stage]
        size = max(width // each, 1), max(height // each, 1)
        film = f'Film "rgb" "integer xresolution" {size[0]} "integer yresolution" {size[1]}'
        with open(self._path('preview.pbrt'), 'w', encoding='utf-8') as file:
            file.write(f'{camera}\n{film}\nWorldBegin\n{self.body}\n')
        command = [program.path(), 'render', self._path('preview.pbrt'), '-o', self._path('preview.exr'), '--precision',
                   'float', '--studio-light', 'off', '--aov', 'alpha', '-q', *options]
        self.process = subprocess.Popen(command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def _take(self):
        _, errors = self.process.communicate()
        status, self.process = self.process.returncode, None
        if status != 0:
            self.stage = len(_STAGES)
            raise RuntimeError(errors.decode(errors='replace').strip()[-2000:] or f'glowworm ended with status {status}')
        channels, _ = exr.read(self._path('preview.exr'))
        self.pixels = numpy.ascontiguousarray(numpy.stack([channels[c][::-1] for c in 'RGBA'], axis=-1), 'f4')
        self.stage += 1

    def _stop(self):
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None
