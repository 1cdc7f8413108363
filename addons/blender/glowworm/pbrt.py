"""Pieces of pbrt text and binary PLY meshes. Nothing here knows Blender."""
import numpy


def quoted(text):
    """A string of pbrt text."""
    return '"' + text.replace('\\', '\\\\').replace('"', '\\"') + '"'


def number(value):
    return f'{float(value):.9g}'


def numbers(values):
    return '[' + ' '.join(number(v) for v in values) + ']'


def parameter(kind, name, value):
    """One parameter, such as `"float eta" [1.5]`. value: a number, a sequence of numbers, a string or a boolean."""
    if isinstance(value, bool):
        text = 'true' if value else 'false'
    elif isinstance(value, str):
        text = quoted(value)
    elif isinstance(value, (int, float)):
        text = '[' + (str(value) if kind == 'integer' else number(value)) + ']'
    else:
        text = numbers(value)
    return f'{quoted(kind + " " + name)} {text}'


def matrix(rows):
    """The 16 numbers of Transform. rows: a 4 x 4 matrix that is applied to columns, as mathutils.Matrix is."""
    return numbers(rows[r][c] for c in range(4) for r in range(4))


def write_ply(path, positions, normals, uvs, triangles):
    """Writes a mesh as binary PLY. normals and uvs may be None; triangles: n x 3 indices."""
    columns = [('x', positions[:, 0]), ('y', positions[:, 1]), ('z', positions[:, 2])]
    if normals is not None:
        columns += [('nx', normals[:, 0]), ('ny', normals[:, 1]), ('nz', normals[:, 2])]
    if uvs is not None:
        columns += [('u', uvs[:, 0]), ('v', uvs[:, 1])]
    vertices = numpy.empty(len(positions), dtype=[(name, '<f4') for name, _ in columns])
    for name, values in columns:
        vertices[name] = values
    faces = numpy.empty(len(triangles), dtype=[('count', 'u1'), ('corners', '<i4', 3)])
    faces['count'] = 3
    faces['corners'] = triangles
    header = ['ply', 'format binary_little_endian 1.0', f'element vertex {len(vertices)}']
    header += [f'property float {name}' for name, _ in columns]
    header += [f'element face {len(faces)}', 'property list uchar int vertex_indices', 'end_header', '']
    with open(path, 'wb') as file:
        file.write('\n'.join(header).encode())
        file.write(vertices.tobytes())
        file.write(faces.tobytes())
