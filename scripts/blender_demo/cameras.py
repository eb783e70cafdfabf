# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the demo's cameras stand. Matrices are world_from_camera in OpenGL axes (x right, y up, looking along -z)."""
import math
import random

from mathutils import Matrix, Vector

PHOTO_FOCAL = 620.0 / 640.0  # focal length / picture width: 54.6 degrees across
NERF_ANGLE_X = 0.6911112070083618  # the horizontal field of view of the original NeRF-synthetic sets
NERF_DISTANCE = 3.2  # a view cone of that angle then holds the ball of radius 1.08 around the origin


def look_at(eye, target, roll=0.0):
    back = (eye - target).normalized()
    right = Vector((0, 0, 1)).cross(back).normalized()
    rotation = Matrix((right, back.cross(right), back)).transposed()
    return Matrix.Translation(eye) @ rotation.to_4x4() @ Matrix.Rotation(roll, 4, "Z")


def on_sphere(distance, azimuth, elevation):
    return distance * Vector((math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation),
                              math.sin(elevation)))


def photo_walk(count, seed):
    """One closed turn around the table, rising and sinking as a person does who wants to see all sides."""
    draw = random.Random(seed)
    poses = []
    for i in range(count):
        turn = 2 * math.pi * i / count
        azimuth = turn + math.radians(draw.uniform(-1.5, 1.5)) - 1.2
        elevation = math.radians(29 + 15 * math.sin(3 * turn) + draw.uniform(-2, 2))
        distance = 3.0 + 0.25 * math.sin(2 * turn + 0.7) + draw.uniform(-0.1, 0.1)
        target = Vector((draw.uniform(-0.1, 0.1), draw.uniform(-0.1, 0.1), -0.08 + draw.uniform(-0.08, 0.08)))
        poses.append(look_at(target + on_sphere(distance, azimuth, elevation), target,
                             math.radians(draw.uniform(-3, 3))))
    return poses


def nerf_views(count, offset):
    """A golden-angle spiral, even in height, over the elevations -30 to 75 degrees."""
    low, high = math.sin(math.radians(-30)), math.sin(math.radians(75))
    poses = []
    for i in range(count):
        elevation = math.asin(low + (high - low) * (i + 0.5) / count)
        azimuth = offset + i * math.pi * (3 - math.sqrt(5))
        poses.append(look_at(on_sphere(NERF_DISTANCE, azimuth, elevation), Vector((0, 0, 0))))
    return poses


def cam_from_world_colmap(pose):
    """World to camera, 3x4, COLMAP axes: x right, y down, z forward."""
    return (Matrix.Diagonal((1, -1, -1, 1)) @ pose.inverted())[:3]
