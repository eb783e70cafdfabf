# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: builds the scene and writes the parts asked for. Started by scripts/make_demo_scene.py."""
import argparse
import json
import math
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).parent))

import bpy  # noqa: E402

import cameras  # noqa: E402
import ground_truth  # noqa: E402
import pictures  # noqa: E402
import scene as demo  # noqa: E402


def say(text):
    print("demo: " + text, flush=True)


def write_json(path, value):
    path.write_text(json.dumps(value, indent=1) + "\n")


def rounded(matrix):
    return [[round(value, 9) for value in row] for row in matrix]


def set_up_render(samples, seed):
    render, cycles = bpy.context.scene.render, bpy.context.scene.cycles
    render.engine = "CYCLES"
    render.resolution_percentage = 100
    render.use_persistent_data = True
    render.dither_intensity = 0.0
    for name in dir(render):  # Blender would write date, render time and more into the pictures
        if name.startswith("use_stamp_"):
            setattr(render, name, False)
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 3, 2, 1
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_indirect = 2.0
    bpy.context.scene.view_settings.view_transform = "Standard"  # plain sRGB; Filmic would grey the colours


def smooth_the_light():
    """A denoiser for a Blender without one: averages the light, not the colour, over near points of a surface."""
    layer = bpy.context.view_layer
    for name in ("diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct", "glossy_indirect",
                 "glossy_color", "position", "normal"):
        setattr(layer, "use_pass_" + name, True)
    bpy.context.scene.use_nodes = True
    tree = bpy.context.scene.node_tree
    tree.nodes.clear()
    passes = tree.nodes.new("CompositorNodeRLayers").outputs

    def mix(how, first, second):
        node = tree.nodes.new("CompositorNodeMixRGB")
        node.blend_type = how
        for socket, value in zip(node.inputs[1:], (first, second)):
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node.outputs[0]

    blur = tree.nodes.new("CompositorNodeBilateralblur")
    blur.iterations, blur.sigma_space, blur.sigma_color = 1, 4.0, 0.25  # pixels; world units and 0.4 x change of normal
    tree.links.new(mix("ADD", passes["DiffDir"], passes["DiffInd"]), blur.inputs["Image"])
    tree.links.new(mix("ADD", passes["Position"], mix("MULTIPLY", passes["Normal"], (0.4, 0.4, 0.4, 1))),
                   blur.inputs["Determinator"])
    gloss = mix("MULTIPLY", mix("ADD", passes["GlossDir"], passes["GlossInd"]), passes["GlossCol"])
    picture = mix("ADD", mix("MULTIPLY", blur.outputs[0], passes["DiffCol"]), gloss)
    tree.links.new(picture, tree.nodes.new("CompositorNodeComposite").inputs["Image"])


def set_up_camera(width, height, angle_x):
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = width, height
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", angle_x
    data.clip_start, data.clip_end = 0.05, 50
    scene.camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(scene.camera)


def shoot(pose, path):
    scene = bpy.context.scene
    scene.camera.matrix_world = pose
    scene.render.filepath = str(path)
    start = time.monotonic()
    bpy.ops.render.render(write_still=True)
    path.write_bytes(pictures.without_remarks(path.read_bytes()))
    say(f"{path.parent.name}/{path.name} {path.stat().st_size / 1024:.0f} KiB, {time.monotonic() - start:.1f} s")


def make_photos(options, poses):
    width, height = options.width, options.width * 3 // 4
    focal = cameras.PHOTO_FOCAL * width
    files = [f"photos/{i + 1:04d}.jpg" for i in range(len(poses))]
    write_json(options.out / "cameras.json", {
        "width": width, "height": height, "fx": focal, "fy": focal, "cx": width / 2, "cy": height / 2,
        "frames": [{"file": name, "cam_from_world": rounded(cameras.cam_from_world_colmap(pose))}
                   for name, pose in zip(files, poses)]})
    set_up_render(options.samples, options.seed)
    set_up_camera(width, height, 2 * math.atan(0.5 / cameras.PHOTO_FOCAL))
    smooth_the_light()
    image = bpy.context.scene.render.image_settings
    image.file_format, image.color_mode, image.quality = "JPEG", "RGB", options.quality
    for i in range(options.first, len(poses), options.stride):
        bpy.context.scene.cycles.seed = options.seed + i
        shoot(poses[i], options.out / files[i])


def make_nerf(options, room):
    """The subject alone: the table is gone, the room still lights the subject but no camera sees it."""
    for thing in room:
        thing.visible_camera = False
        thing.hide_render = thing.name in ("table", "leg")
    bpy.context.scene.use_nodes = False  # more samples and no smoothing: it knows nothing of transparency
    set_up_render(options.nerf_samples, options.seed)
    set_up_camera(options.nerf_size, options.nerf_size, cameras.NERF_ANGLE_X)
    bpy.context.scene.render.film_transparent = True
    image = bpy.context.scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.compression = "PNG", "RGBA", "8", 100
    for split, count, offset in zip(("train", "val", "test"), options.nerf_views, (0.0, 1.0, 2.1)):
        poses = cameras.nerf_views(count, offset)
        write_json(options.out / "nerf" / f"transforms_{split}.json", {
            "camera_angle_x": cameras.NERF_ANGLE_X,
            "frames": [{"file_path": f"./{split}/r_{i}", "transform_matrix": rounded(pose)}
                       for i, pose in enumerate(poses)]})
        for i, pose in enumerate(poses):
            shoot(pose, options.out / "nerf" / split / f"r_{i}.png")


def make_mesh(options, subject, room, poses):
    table = next(thing for thing in room if thing.name == "table")
    solid = ground_truth.union(subject)
    views = ground_truth.count_views(solid, table, poses, cameras.PHOTO_FOCAL, 0.75)
    ground_truth.write_ply(options.out / "ground_truth.ply", solid, views)
    facts = ground_truth.facts(solid, views, demo.TABLE_Z)
    write_json(options.out / "scene.json", facts)
    say(f"ground_truth.ply: {facts['subject']['faces']} faces, "
        f"{100 * facts['subject']['seen_area_fraction']:.1f} % of the area above the table is seen")


def main():
    parser = argparse.ArgumentParser(prog="blender_demo")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--parts", nargs="+", required=True)
    for name in ("seed", "photos", "width", "samples", "quality", "first", "stride", "nerf-size", "nerf-samples"):
        parser.add_argument(f"--{name}", type=int, required=True)
    parser.add_argument("--nerf-views", type=int, nargs=3, required=True)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    if bpy.app.version >= (4, 0, 0):
        raise RuntimeError(f"Error: Blender {bpy.app.version_string} names shader sockets differently; use Blender 3.x")
    (options.out / "nerf").mkdir(parents=True, exist_ok=True)

    subject, room = demo.build()
    poses = cameras.photo_walk(options.photos, options.seed)
    if "mesh" in options.parts:
        make_mesh(options, subject, room, poses)
    if "photos" in options.parts:
        make_photos(options, poses)
    if "nerf" in options.parts:
        make_nerf(options, room)


main()
