"""Renders a glTF file by Cycles as compare.py says; run by `blender -b --factory-startup -P cycles_render.py -- JOB.json`.

The job: scene, camera (ten numbers, or null: the file's), environment (or null), size, lambert, pattern, threads,
and `pictures`, a list of {samples, seed, output}. Prints a line `cpu SECONDS` for each picture: user and
system time of the whole process while it was rendered, with the preparation of the scene.
"""
import json
import math
import resource
import sys

import bpy
import numpy
from mathutils import Matrix, Vector


# The importer of Blender 3.4 says numpy.bool, which numpy 1.24 has no more
numpy.bool = bool


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def make_lambert(material):
    """Base color and emission as one diffuse closure and one emission, nothing else."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    principled = next(n for n in nodes if n.type == "BSDF_PRINCIPLED")
    color = tuple(principled.inputs["Base Color"].default_value)
    emission = tuple(principled.inputs["Emission"].default_value)
    strength = principled.inputs["Emission Strength"].default_value
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = color
    result = diffuse.outputs[0]
    if strength > 0.0 and max(emission[:3]) > 0.0:
        emit = nodes.new("ShaderNodeEmission")
        emit.inputs["Color"].default_value = emission
        emit.inputs["Strength"].default_value = strength
        both = nodes.new("ShaderNodeAddShader")
        links.new(result, both.inputs[0])
        links.new(emit.outputs[0], both.inputs[1])
        result = both.outputs[0]
    links.new(result, output.inputs["Surface"])


def set_camera(scene, numbers):
    """Ten numbers as of `raygraph render --camera`: eye, target, up in glTF's axes, vertical angle in degrees."""
    def from_gltf(x, y, z):
        return Vector((x, -z, y))
    eye, target, up = (from_gltf(*numbers[i : i + 3]) for i in (0, 3, 6))
    back = (eye - target).normalized()
    right = up.cross(back).normalized()
    data = bpy.data.cameras.new("compared")
    data.sensor_fit = "VERTICAL"
    data.angle = math.radians(numbers[9])
    data.clip_start = 1.0e-4
    node = bpy.data.objects.new("compared", data)
    node.matrix_world = Matrix.Translation(eye) @ Matrix((right, back.cross(right), back)).transposed().to_4x4()
    scene.collection.objects.link(node)
    scene.camera = node


def set_world(scene, environment):
    world = bpy.data.worlds.new("compared")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.0
    background.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    if environment:
        texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(environment)
        world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def main():
    job = json.load(open(sys.argv[sys.argv.index("--") + 1]))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=job["scene"])
    scene = bpy.context.scene
    if job["lambert"]:
        for material in bpy.data.materials:
            if material.use_nodes:
                make_lambert(material)
    if job["camera"]:
        set_camera(scene, job["camera"])
    elif scene.camera is None:
        scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    set_world(scene, job["environment"])

    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.resolution_percentage = 100
    scene.render.threads_mode = "FIXED"
    scene.render.threads = job["threads"]
    scene.render.use_persistent_data = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "ZIP"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.sampling_pattern = job["pattern"]
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    bounces = 1024  # the most; paths end by roulette, as those of raygraph do
    cycles.max_bounces = bounces
    cycles.diffuse_bounces = bounces
    cycles.glossy_bounces = bounces
    cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces = 64
    for picture in job["pictures"]:
        cycles.samples = picture["samples"]
        cycles.seed = picture["seed"]
        before = cpu_seconds()
        bpy.ops.render.render()
        print("cpu", cpu_seconds() - before, flush=True)
        bpy.data.images["Render Result"].save_render(picture["output"])


main()
