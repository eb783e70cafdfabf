# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scene: a still life (the subject, inside [-1, 1]^3, z up) on a round table in a painted room."""
import math

import bpy
from mathutils import Matrix, Vector

import shapes
from materials import painted, srgb

TABLE_Z = -0.7
FLOOR_Z = -2.1
CEILING_Z = 3.0
ROOM = 4.4  # half the width of the room


def add(name, mesh, material, place=Matrix(), smooth=True):
    """Adds a mesh, moved by `place`. Texture coordinates: the object's own for patches, box projection for bricks."""
    data = bpy.data.meshes.new(name)
    vertices, faces = mesh
    data.from_pydata(vertices, [], faces)
    uv = data.uv_layers.new(name="box")
    for polygon in data.polygons:
        polygon.use_smooth = smooth
        across = max(range(3), key=lambda axis: abs(polygon.normal[axis]))
        keep = {0: (1, 2), 1: (0, 2), 2: (0, 1)}[across]
        for corner in polygon.loop_indices:
            point = data.vertices[data.loops[corner].vertex_index].co
            uv.data[corner].uv = [point[axis] for axis in keep]
    data.use_auto_smooth = smooth  # keeps rims and feet crisp
    data.auto_smooth_angle = math.radians(50)
    data.materials.append(material)
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = place
    bpy.context.scene.collection.objects.link(thing)
    return thing


def at(x, y, z=TABLE_Z, turn=0.0):
    return Matrix.Translation((x, y, z)) @ Matrix.Rotation(math.radians(turn), 4, "Z")


def build_subject():
    """Closed meshes that cut into each other where they join, so that their union is one solid per group."""
    things = []

    # The smooth part: a turned vase with a shallow mouth; a deep one would hide surface from every camera.
    glaze = painted("glaze", ["2f6f8f", "3f86a0", "5fa3a8", "d9c9a0", "c98f5a", "3a5f86"], 6.5, 1, 0.5, 0.12,
                    gloss=0.25)
    outline = shapes.smooth_curve([(0.19, 0), (0.23, 0.06), (0.34, 0.30), (0.31, 0.54), (0.17, 0.76), (0.15, 0.86),
                                   (0.21, 0.96)], 6)
    mouth = shapes.smooth_curve([(0.19, 0.98), (0.155, 0.955), (0.10, 0.89), (0.03, 0.87)], 4)
    profile = [(0, 0), (0.12, 0), *[p[:2] for p in outline], *[p[:2] for p in mouth], (0, 0.868)]
    things.append(add("vase", shapes.lathe(profile, 64), glaze, at(-0.38, 0.30)))

    # The thin part: a wire from the vase's mouth, in a bow over the group, with a bead at its end.
    stripes = painted("wire", ["e8e2d0", "b03030", "e8e2d0", "303848"], 13, 2, 0.1, 0.1)
    bow = shapes.smooth_curve([(-0.38, 0.30, 0.10), (-0.37, 0.29, 0.45), (-0.22, 0.20, 0.76), (0.10, 0.0, 0.86),
                               (0.38, -0.18, 0.70), (0.46, -0.22, 0.48)], 10)
    things.append(add("wire", shapes.tube(bow, 0.02, 12), stripes))
    bead = painted("bead", ["c8402f", "e0b040", "a83040", "e08040"], 13, 3, 0.3, 0.2)
    things.append(add("bead", shapes.sphere(0.095, 20, 32), bead, at(0.465, -0.222, 0.42)))

    # The hole: a stone ring, standing on a block of bricks.
    clay = painted("clay", ["b5563c", "a34a38", "c4694a", "8f4436"], 7, 4, 0.3, 0.2,
                   bricks=(0.17, 0.085, 0.008, "d8cdb8", 0.7))
    block = shapes.box((-0.32, -0.17, 0), (0.32, 0.17, 0.255))
    things.append(add("block", block, clay, at(0.40, 0.40, turn=24), smooth=False))
    stone = painted("stone", ["8a8f7a", "b8b49a", "6f7a6a", "a39c7c", "d0c8a8"], 11, 5, 0.4, 0.25)
    things.append(add("ring", shapes.torus(0.27, 0.085, 72, 28), stone, at(0.40, 0.40, TABLE_Z + 0.585, turn=24)))

    # A mug with a handle (a second, smaller hole).
    enamel = painted("enamel", ["e6dcc4", "d8a048", "5a7a4a", "e6dcc4", "7a4a6a"], 11, 6, 0.25, 0.12, gloss=0.15)
    mug = [(0, 0), (0.10, 0), (0.185, 0), (0.205, 0.02), *[(0.21, 0.02 + 0.07 * k) for k in range(1, 5)],
           (0.213, 0.36), (0.205, 0.37), (0.19, 0.365), (0.185, 0.35), *[(0.182, 0.35 - 0.07 * k) for k in range(1, 3)],
           (0.17, 0.17), (0.09, 0.165), (0, 0.165)]
    things.append(add("mug", shapes.lathe(mug, 56), enamel, at(0.36, -0.36, turn=-35)))
    handle = shapes.smooth_curve([(0.19, 0, 0.31), (0.27, 0, 0.325), (0.345, 0, 0.27), (0.345, 0, 0.15),
                                  (0.28, 0, 0.085), (0.19, 0, 0.08)], 7)
    things.append(add("handle", shapes.tube(handle, 0.03, 16), enamel, at(0.36, -0.36, turn=-35)))

    # A ball, sunk a little so that it rests on a spot and not on a point.
    skin = painted("ball", ["c9a227", "3b6ea5", "d8d0c0", "9c3d54", "4a8a6a"], 7, 7, 0.2, 0.12, gloss=0.15)
    things.append(add("ball", shapes.sphere(0.27, 36, 56), skin, at(-0.36, -0.42, TABLE_Z + 0.262)))
    return things


def build_room():
    """Table, floor, walls, ceiling and pictures on the walls: no pixel of a photo looks into the void."""
    things = []
    oak = painted("table", ["a07a52", "8f6a48", "b08c60", "a9825a", "7c5d44", "b89a70"], 7, 11, 0.3, 0.13,
                  bricks=(0.52, 0.26, 0.012, "4f4234", 0.6))
    top = [(0, -0.12), (1.0, -0.12), (1.60, -0.12), (1.66, -0.09), (1.66, -0.03), (1.63, 0), (0.8, 0), (0, 0)]
    things.append(add("table", shapes.lathe(top, 96), oak, at(0, 0)))
    leg = [(0, 0), (0.65, 0), (0.65, 0.08), (0.22, 0.2), (0.18, 0.7), (0.28, 1.3), (0, 1.3)]
    things.append(add("leg", shapes.lathe(leg, 48), oak, at(0, 0, FLOOR_Z)))

    low, high = (-ROOM, -ROOM, FLOOR_Z), (ROOM, ROOM, CEILING_Z)
    looks = {
        "floor": painted("floor", ["6f6a74", "8a8078", "5a6470", "98908a", "7a5f58"], 2.2, 12, 0.3, 0.2,
                         bricks=(1.1, 0.55, 0.025, "3c3a40", 0.6)),
        "ceiling": painted("ceiling", ["d8d2c4", "c8c8c8", "e0d8c0", "b8c0c4"], 1.6, 13, 0.5, 0.15),
        "south": painted("south", ["5f7f8a", "7a98a0", "48687a", "93a8a4"], 2.0, 14, 0.08, 0.18),
        "north": painted("north", ["a8845a", "b89870", "94704c", "c4ac84"], 2.2, 15, 0.2, 0.15,
                         bricks=(0.8, 0.4, 0.03, "6a5a48", 0.6)),
        "west": painted("west", ["6f8a5c", "86a070", "58744c", "9fae80"], 2.0, 16, 0.6, 0.18),
        "east": painted("east", ["96606a", "aa7a7c", "7c4c5a", "bc9490"], 2.0, 17, 0.4, 0.18),
    }
    vertices, faces = shapes.inside_out(shapes.box(low, high))
    for side, face in zip(("floor", "ceiling", "south", "north", "west", "east"), faces):
        corners = [vertices[i] for i in face]
        things.append(add(side, (corners, [(0, 1, 2, 3)]), looks[side], smooth=False))

    palettes = [["d8b04a", "a8402f", "2f4a6a", "e0d4b8"], ["2f6a5a", "d8c8a0", "c8683f", "3a3f58"],
                ["c0506a", "e8d0b0", "4a6a9a", "d89a4a"], ["e0d8c8", "4f7a8a", "b8863f", "6a3f4a"]]
    for i in range(8):
        wall, half = divmod(i, 2)
        side = 1.5 if half else -1.7
        width, height, middle = (0.85, 0.65, 0.35) if (i + wall) % 2 else (0.6, 0.9, 0.1)
        paint = painted(f"picture{i}", palettes[(i + wall) % 4], 2.8, 20 + i, 0.3, 0.15)
        frame = painted(f"frame{i}", ["54422f", "6a5238", "463626"], 4, 30 + i, 0.2, 0.15)
        place = Matrix.Rotation(math.pi / 2 * wall, 4, "Z") @ Matrix.Translation((side, ROOM, middle))
        for part, look, edge, front in ((f"frame{i}", frame, 0.09, -0.05), (f"picture{i}", paint, 0, -0.07)):
            panel = shapes.box((-width - edge, front, -height - edge), (width + edge, 0.1, height + edge))
            things.append(add(part, panel, look, place, smooth=False))
    return things


def add_lights():
    """Large soft lights, unseen by the camera; a weak one from below keeps undersides readable."""
    for name, place, aim, size, power, tint in (
            ("key", (-2.4, -2.2, 2.6), (0, 0, -0.3), 2.4, 250, "fff0dc"),
            ("fill", (2.8, 1.6, 2.4), (0, 0, -0.3), 2.6, 110, "e4eeff"),
            ("room", (0, 0, 2.9), (0, 0, 0), 6.0, 290, "fff8f0"),
            ("low", (0, 0, FLOOR_Z + 0.1), (0, 0, CEILING_Z), 8.0, 110, "fff4e8")):
        light = bpy.data.lights.new(name, "AREA")
        light.size, light.energy, light.color = size, power, srgb(tint)[:3]
        thing = bpy.data.objects.new(name, light)
        way = Vector(aim) - Vector(place)
        thing.matrix_world = Matrix.Translation(place) @ way.to_track_quat("-Z", "Y").to_matrix().to_4x4()
        thing.visible_camera = False
        thing.visible_glossy = name == "key"  # one faint highlight
        bpy.context.scene.collection.objects.link(thing)


def build():
    """Empties the file and builds all; returns (subject objects, surrounding objects)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    subject, room = build_subject(), build_room()
    add_lights()
    bpy.context.scene.world = bpy.data.worlds.new("dark")
    bpy.context.scene.world.color = (0, 0, 0)
    bpy.context.view_layer.update()
    return subject, room
