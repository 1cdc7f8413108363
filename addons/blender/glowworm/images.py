"""Image files of a scene: Blender's images where they are files, others written beside the scene."""
import os
import struct
import zlib

import bpy
import numpy

from . import exr

_READ_AS_THEY_ARE = {'.png', '.jpg', '.jpeg', '.exr', '.hdr', '.tif', '.tiff', '.tga', '.bmp', '.webp'}


def pixels_of(image):
    """height x width x channels, first row on top, in the image's own encoding."""
    width, height = image.size
    values = numpy.empty(len(image.pixels), 'f4')
    image.pixels.foreach_get(values)
    return values.reshape(height, width, -1)[::-1]


def has_alpha(image):
    """Whether the file has an alpha that counts."""
    return image.depth in (32, 64, 128) and image.channels == 4 and image.alpha_mode != 'NONE'


def opaque(image, pixels):
    """Colours as Cycles shows them of a texture whose alpha no node uses: times alpha, which is 0 to 1 of linear light."""
    alpha = pixels[:, :, 3:]
    if image.is_float or image.alpha_mode in ('PREMUL', 'CHANNEL_PACKED'):
        return pixels[:, :, :3]
    if image.colorspace_settings.name != 'sRGB':
        return pixels[:, :, :3] * alpha
    encoded = pixels[:, :, :3]
    linear = numpy.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4) * alpha
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def write_png(path, pixels):
    """Writes height x width x (1, 3 or 4) bytes."""
    height, width, channels = pixels.shape
    kind = {1: 0, 3: 2, 4: 6}[channels]

    def chunk(name, data):
        return struct.pack('>I', len(data)) + name + data + struct.pack('>I', zlib.crc32(name + data))

    rows = numpy.zeros((height, 1 + width * channels), 'u1')
    rows[:, 1:] = pixels.reshape(height, -1)
    with open(path, 'wb') as file:
        file.write(b'\x89PNG\r\n\x1a\n')
        file.write(chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, kind, 0, 0, 0)))
        file.write(chunk(b'IDAT', zlib.compress(rows.tobytes(), 6)) + chunk(b'IEND', b''))


class Images:
    """Gives images file names. @param folder: for the files that it writes"""

    def __init__(self, folder):
        self.folder = folder
        self.paths = {}

    def path(self, image, form='own'):
        """The file of an image, or None if it has no pixels.

        form: 'own': its channels; 'opaque': colours times alpha; 'grey': the same as one channel. Files without alpha
        serve all three.
        """
        key = image.name_full, form
        if key not in self.paths:
            self.paths[key] = self._find(image, form)
        return self.paths[key]

    def _find(self, image, form):
        own = bpy.path.abspath(image.filepath, library=image.library)
        as_it_is = image.source == 'FILE' and not image.is_dirty and (form == 'own' or not has_alpha(image))
        if as_it_is and not image.packed_file and os.path.splitext(own)[1].lower() in _READ_AS_THEY_ARE:
            return own if os.path.exists(own) else None
        if image.size[0] == 0 or image.size[1] == 0 or len(image.pixels) == 0:
            return None
        pixels = pixels_of(image)
        if form != 'own' and has_alpha(image):
            pixels = opaque(image, pixels)
        if form == 'grey':
            pixels = pixels[:, :, :3].mean(axis=2, keepdims=True)
        name = os.path.join(self.folder, f'image{len(self.paths)}')
        if image.is_float:
            exr.write(name + '.exr', pixels[:, :, :3] if pixels.shape[2] >= 3 else pixels.repeat(3, axis=2))
            return name + '.exr'
        if pixels.shape[2] == 2:
            pixels = pixels[:, :, :1]
        write_png(name + '.png', numpy.clip(pixels * 255 + 0.5, 0, 255).astype('u1'))
        return name + '.png'
