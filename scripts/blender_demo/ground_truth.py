# SPDX-License-Identifier: GPL-3.0-or-later
"""The subject's true surface: the union of its parts, and which of it the photos see."""
import struct

import bmesh
import bpy
from mathutils import Vector
from mathutils.bvhtree import BVHTree


def union(things):
    """One closed triangle mesh, without the surface that lies inside a neighbouring part."""
    base = things[0].copy()
    base.data = things[0].data.copy()
    bpy.context.scene.collection.objects.link(base)
    for thing in things[1:]:
        cut = base.modifiers.new(thing.name, "BOOLEAN")
        cut.operation, cut.solver, cut.object = "UNION", "EXACT", thing
    evaluated = base.evaluated_get(bpy.context.evaluated_depsgraph_get())
    solid = bmesh.new()
    solid.from_mesh(evaluated.to_mesh())
    solid.transform(base.matrix_world)
    bpy.data.objects.remove(base)
    bmesh.ops.triangulate(solid, faces=solid.faces)
    # The cuts leave needles; whoever samples or meets this mesh is better off without them.
    bmesh.ops.dissolve_degenerate(solid, edges=solid.edges, dist=5e-4)
    bmesh.ops.triangulate(solid, faces=solid.faces)
    solid.normal_update()
    open_edges = sum(1 for edge in solid.edges if not edge.is_manifold)
    if open_edges:
        raise RuntimeError(f"Error: the union of the subject's parts has {open_edges} edges without two faces")
    if solid.calc_volume(signed=True) <= 0:
        raise RuntimeError("Error: the union of the subject's parts is inside out")
    return solid


def count_views(solid, table, poses, focal, aspect):
    """For each vertex the number of photos in which it lies and is hidden neither by the subject nor by the table."""
    flat = bmesh.new()
    flat.from_mesh(table.data)
    flat.transform(table.matrix_world)
    blockers = [BVHTree.FromBMesh(solid), BVHTree.FromBMesh(flat)]
    eyes = [(pose.translation.copy(), pose.inverted()) for pose in poses]
    counts = []
    for vertex in solid.verts:
        point = vertex.co + 2e-3 * vertex.normal  # off the surface, so that it does not hide itself
        seen = 0
        for eye, cam_from_world in eyes:
            local = cam_from_world @ point
            way = eye - point
            if local.z >= 0 or abs(local.x) * focal > -0.5 * local.z or abs(local.y) * focal > -0.5 * aspect * local.z:
                continue
            if all(tree.ray_cast(point, way, way.length)[0] is None for tree in blockers):
                seen += 1
        counts.append(seen)
    return counts


def write_ply(path, solid, views):
    head = ["ply", "format binary_little_endian 1.0", "comment views: number of photos that see the vertex",
            f"element vertex {len(solid.verts)}", "property float x", "property float y", "property float z",
            "property uchar views", f"element face {len(solid.faces)}", "property list uchar int vertex_indices",
            "end_header"]
    solid.verts.index_update()
    body = [struct.pack("<3fB", *vertex.co, min(count, 255)) for vertex, count in zip(solid.verts, views)]
    body += [struct.pack("<B3i", 3, *(vertex.index for vertex in face.verts)) for face in solid.faces]
    path.write_bytes("\n".join(head).encode() + b"\n" + b"".join(body))


def facts(solid, views, table_z):
    """Bounds and the crop inside which the subject can be judged: from just above the table, where no bottom lies."""
    low = Vector([min(v.co[axis] for v in solid.verts) for axis in range(3)])
    high = Vector([max(v.co[axis] for v in solid.verts) for axis in range(3)])
    margin, lift = 0.05, 0.03
    crop_low = (low[0] - margin, low[1] - margin, table_z + lift)
    crop_high = [value + margin for value in high]
    above = [face for face in solid.faces if all(v.co.z > table_z + lift for v in face.verts)]
    seen = [face for face in above if all(views[v.index] >= 2 for v in face.verts)]
    area = lambda faces: sum(face.calc_area() for face in faces)
    short = lambda values: [round(value, 6) for value in values]
    return {"schema": 1, "up": [0, 0, 1], "table_z": table_z, "subject": {
        "bounds_min": short(low), "bounds_max": short(high), "diagonal": round((high - low).length, 6),
        "crop_min": short(crop_low), "crop_max": short(crop_high), "vertices": len(solid.verts),
        "faces": len(solid.faces), "seen_area_fraction": round(area(seen) / area(above), 4)}}
