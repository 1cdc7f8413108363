"""Triangles of Blender's evaluated objects."""
import os

import numpy

from . import pbrt


def _values(collection, attribute, kind, width=1):
    out = numpy.empty(len(collection) * width, kind)
    collection.foreach_get(attribute, out)
    return out.reshape(-1, width) if width > 1 else out


def _corner_normals(mesh):
    """The normal of each corner of a face, or None if all faces are flat."""
    smooth = _values(mesh.polygons, 'use_smooth', 'bool')
    if not smooth.any():
        return None
    if hasattr(mesh, 'calc_normals_split'):  # before Blender 4.1
        mesh.calc_normals_split()
        return _values(mesh.loops, 'normal', 'f4', 3)
    return _values(mesh.corner_normals, 'vector', 'f4', 3)


def _joined(corners):
    """Distinct rows of an array, and the index of each row among them."""
    rows = numpy.ascontiguousarray(corners)
    keys = rows.view(numpy.dtype((numpy.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    _, first, place = numpy.unique(keys, return_index=True, return_inverse=True)
    return rows[first], place.ravel()


def write_parts(mesh, folder, stem):
    """Writes a PLY file of each material that a mesh uses. Returns pairs of slot and file."""
    mesh.calc_loop_triangles()
    triangles = mesh.loop_triangles
    if len(triangles) == 0:
        return []
    positions = _values(mesh.vertices, 'co', 'f4', 3)
    loops = _values(triangles, 'loops', 'i4', 3)
    slots = _values(triangles, 'material_index', 'i4')
    columns = [_values(mesh.loops, 'vertex_index', 'i4').astype('f8')[:, None]]
    normals = _corner_normals(mesh)
    if normals is not None:
        columns.append(normals)
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    if layer is not None:
        columns.append(_values(layer.data, 'uv', 'f4', 2))
    corners = numpy.hstack(columns)
    out = []
    for slot in numpy.unique(slots):
        chosen = loops[slots == slot]
        rows, place = _joined(corners[chosen.ravel()])
        path = os.path.join(folder, f'{stem}-{slot}.ply')
        pbrt.write_ply(path, positions[rows[:, 0].astype('i8')], rows[:, 1:4] if normals is not None else None,
                       rows[:, -2:] if layer is not None else None, place.reshape(-1, 3))
        out.append((int(slot), path))
    return out
