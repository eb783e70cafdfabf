# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted-looking procedural materials: patches with clear corners, no fine noise, and nowhere a repeating pattern.

Structure from motion wants corners everywhere, a coarse volume few of them: patches are some 10 to 30 pixels wide.
"""
import bpy


def srgb(text):
    """'rrggbb' in display sRGB to linear RGBA, as Blender's colour sockets want it."""
    channels = [int(text[i:i + 2], 16) / 255 for i in (0, 2, 4)]
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels] + [1.0]


class Graph:
    """Shortens the building of a shader: node("Type", socket=value or another node's output)."""

    def __init__(self, tree):
        self.tree = tree

    def node(self, kind, inputs=None, **settings):
        node = self.tree.nodes.new("ShaderNode" + kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for name, value in (inputs or {}).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[name])
            else:
                node.inputs[name].default_value = value
        return node.outputs

    def mix(self, how, amount, below, above):
        return self.node("MixRGB", {"Fac": amount, "Color1": below, "Color2": above}, blend_type=how)["Color"]

    def cells(self, where, scale):
        """A random number in [0, 1], constant on each Voronoi cell."""
        colour = self.node("TexVoronoi", {"Vector": where, "Scale": scale})["Color"]
        return self.node("SeparateColor", {"Color": colour})[0]

    def ramp(self, value, colours, stepped):
        outputs = self.node("ValToRGB", {"Fac": value})
        ramp = outputs["Color"].node.color_ramp
        ramp.interpolation = "CONSTANT" if stepped else "LINEAR"
        while len(ramp.elements) < len(colours):
            ramp.elements.new(0.5)
        spans = len(colours) if stepped else len(colours) - 1
        for i, colour in enumerate(colours):
            ramp.elements[i].position = i / spans
            ramp.elements[i].color = colour
        return outputs["Color"]


def painted(name, palette, scale, seed, warp=0.35, contrast=0.25, bricks=None, gloss=0.0):
    """Voronoi patches coloured from the palette, edges bent by `warp` (in patch widths), shaded by smaller patches.

    scale: patches per world unit. contrast: strength of the smaller patches.
    bricks: (length, height, joint width [world units], joint colour, strength): bricks or tiles over the patches.
    """
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    g = Graph(material.node_tree)
    where = g.node("TexCoord")["Object"]
    where = g.node("VectorMath", {0: where, 1: (7.3 * seed, -3.1 * seed, 5.7 * seed)}, operation="ADD")["Vector"]
    swirl = g.node("TexNoise", {"Vector": where, "Scale": 1.3 * scale, "Detail": 1.0})["Color"]
    bend = g.node("VectorMath", {0: swirl, "Scale": 2 * warp / scale}, operation="SCALE")["Vector"]
    bent = g.node("VectorMath", {0: where, 1: bend}, operation="ADD")["Vector"]

    colour = g.ramp(g.cells(bent, scale), [srgb(c) for c in palette], stepped=True)
    for finer in (2.2, 0.45):
        ends = [[1 - contrast] * 3 + [1], [1 + contrast] * 3 + [1]]
        shade = g.ramp(g.cells(bent, finer * scale), ends, stepped=False)
        colour = g.mix("MULTIPLY", 1.0, colour, shade)
    if bricks:
        length, height, joint, joint_colour, strength = bricks
        wall = g.node("TexBrick", {"Vector": g.node("TexCoord")["UV"], "Scale": 1.0, "Brick Width": length,
                                   "Row Height": height, "Mortar Size": joint, "Mortar Smooth": 0.2,
                                   "Color1": [0.55] * 3 + [1], "Color2": [1.15] * 3 + [1], "Mortar": srgb("ffffff")})
        colour = g.mix("MULTIPLY", strength, colour, wall["Color"])
        colour = g.mix("MIX", wall["Fac"], colour, srgb(joint_colour))
    near = g.node("BsdfPrincipled", {"Base Color": colour, "Roughness": 0.75 - 0.4 * gloss, "Specular": 0.1 + gloss})
    # Bounced light sees the mean colour alone: no eye can tell, and most of the render time was these textures.
    mean = [sum(channel) / len(palette) for channel in zip(*map(srgb, palette))]
    far = g.node("BsdfDiffuse", {"Color": mean})
    surface = g.node("MixShader", {"Fac": g.node("LightPath")["Is Camera Ray"], 1: far["BSDF"], 2: near["BSDF"]})
    g.node("OutputMaterial", {"Surface": surface["Shader"]})
    return material
