# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed triangle and quad meshes as (vertices, faces), faces anticlockwise seen from outside."""
import math

from mathutils import Vector


def lathe(profile, sides):
    """Turns a profile of (radius, z), from the axis below to the axis above, around z; only the ends have radius 0."""
    vertices = [Vector((0, 0, profile[0][1]))]
    for radius, z in profile[1:-1]:
        vertices += [Vector((radius * math.cos(2 * math.pi * k / sides), radius * math.sin(2 * math.pi * k / sides), z))
                     for k in range(sides)]
    vertices.append(Vector((0, 0, profile[-1][1])))
    ring = lambda i, k: 1 + i * sides + k % sides
    last = len(profile) - 3
    faces = [(0, ring(0, k + 1), ring(0, k)) for k in range(sides)]
    for i in range(last):
        faces += [(ring(i, k), ring(i, k + 1), ring(i + 1, k + 1), ring(i + 1, k)) for k in range(sides)]
    faces += [(ring(last, k), ring(last, k + 1), len(vertices) - 1) for k in range(sides)]
    return vertices, faces


def sphere(radius, rings, sides):
    angles = [math.pi * (i / rings - 0.5) for i in range(rings + 1)]
    return lathe([(radius * math.cos(a), radius * math.sin(a)) for a in angles], sides)


def tube(path, radius, sides, closed=False):
    """A round tube along a path; its cross-section is carried along without twist."""
    count = len(path)
    tangents = []
    for i in range(count):
        before = path[i - 1] if i > 0 or closed else path[i]
        after = path[(i + 1) % count] if i + 1 < count or closed else path[i]
        tangents.append((after - before).normalized())
    normal = tangents[0].orthogonal().normalized()
    vertices = []
    for point, tangent in zip(path, tangents):
        normal = (normal - tangent * normal.dot(tangent)).normalized()
        across = tangent.cross(normal)
        vertices += [point + radius * (math.cos(2 * math.pi * k / sides) * normal +
                                       math.sin(2 * math.pi * k / sides) * across) for k in range(sides)]
    ring = lambda i, k: (i % count) * sides + k % sides
    faces = [(ring(i, k), ring(i, k + 1), ring(i + 1, k + 1), ring(i + 1, k))
             for i in range(count if closed else count - 1) for k in range(sides)]
    if not closed:
        faces.append(tuple(ring(0, k) for k in reversed(range(sides))))
        faces.append(tuple(ring(count - 1, k) for k in range(sides)))
    return vertices, faces


def torus(major, minor, around, sides):
    """A ring standing upright in the x-z plane (a planar path, so the section closes without a jump)."""
    path = [Vector((major * math.cos(2 * math.pi * i / around), 0, major * math.sin(2 * math.pi * i / around)))
            for i in range(around)]
    return tube(path, minor, sides, closed=True)


def box(low, high):
    vertices = [Vector((x, y, z)) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    return vertices, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def inside_out(mesh):
    return mesh[0], [tuple(reversed(face)) for face in mesh[1]]


def smooth_curve(points, steps):
    """Catmull-Rom through the points: each span in equal steps, the ends included."""
    points = [Vector(p).to_3d() for p in points]
    padded = [2 * points[0] - points[1], *points, 2 * points[-1] - points[-2]]
    curve = []
    for i in range(len(points) - 1):
        a, b, c, d = padded[i:i + 4]
        for k in range(steps):
            t = k / steps
            curve.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t +
                                (3 * b - a - 3 * c + d) * t ** 3))
    return curve + [points[-1]]
