"""Makes a Cornell box from arrays, renders it, and shows its layers as pictures."""
import numpy as np

import glowworm


def add_quad(scene, corner, a, b, **options):
    """A parallelogram with the sides a and b; its front is where a and b turn counter-clockwise."""
    corner, a, b = (np.array(v, dtype=np.float32) for v in (corner, a, b))
    scene.add_mesh([corner, corner + a, corner + a + b, corner + b], [[0, 1, 2], [0, 2, 3]], **options)


def add_box(scene, center, size, angle, **options):
    """A box that stands on the floor, turned around the vertical axis by an angle in degrees."""
    cube = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)])
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    scene.add_mesh(cube * size @ turn + center, triangles, **options)


scene = glowworm.SceneBuilder("a Cornell box")
white = scene.add_material(color=0.75, name="white")
red = scene.add_material(color=(0.6, 0.05, 0.05), name="red")
green = scene.add_material(color=(0.1, 0.45, 0.1), name="green")
mirror = scene.add_material("metal", color=0.95, name="mirror")

add_quad(scene, (-1, 0, 1), (2, 0, 0), (0, 0, -2), material=white, name="floor")
add_quad(scene, (-1, 2, -1), (2, 0, 0), (0, 0, 2), material=white, name="ceiling")
add_quad(scene, (-1, 0, -1), (2, 0, 0), (0, 2, 0), material=white, name="back")
add_quad(scene, (-1, 0, 1), (0, 0, -2), (0, 2, 0), material=red, name="left")
add_quad(scene, (1, 0, -1), (0, 0, 2), (0, 2, 0), material=green, name="right")
add_quad(scene, (-0.3, 1.99, -0.3), (0.6, 0, 0), (0, 0, 0.6), material=white, radiance=(17, 12, 6), name="lamp")
add_box(scene, (-0.35, 0, -0.35), (0.6, 1.2, 0.6), 20, material=mirror, name="tall box")
add_box(scene, (0.35, 0, 0.3), (0.6, 0.6, 0.6), -18, material=white, name="short box")
scene.add_camera(glowworm.Camera((0, 1, 4.5), (0, 1, 0), field_of_view=30))
box = scene.build()

picture = glowworm.render(box, size=(128, 128), samples=4, aov=["indirect", "depth"])
picture.write("cornell_box.exr")
picture.write("cornell_box.png")
share = picture["indirect"].mean() / picture.image.mean()
print(f"{box}: {100 * share:.0f}% of the light is indirect")
print(f"rendered in {picture.statistics['time_s']['total']:.2f} s; the pictures are cornell_box.exr and cornell_box.png")
