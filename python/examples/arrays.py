"""A scene of arrays, a pass of one's own, and why a pixel is what it is."""
import numpy as np

import raygraph as rg

scene = rg.Scene()
paper = scene.add_material("paper", base_color_factor=(0.8, 0.8, 0.8, 1), metallic_factor=0)
gold = scene.add_material("gold", base_color_factor=(1, 0.7, 0.3, 1), roughness_factor=0.3)
scene.add_mesh([[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]], [[0, 1, 2], [0, 2, 3]], material=paper, name="floor")
angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
centers = np.stack([np.cos(angles), np.full(12, 0.2), np.sin(angles)], axis=1)
ring = scene.add_spheres(centers, 0.2, material=gold, name="ring")
camera = rg.look_at((0, 2, 3.5), (0, 0.2, 0), fov=40)
ring.translation = (0, 0.1, 0)
gold.roughness_factor = 0.1
picture = rg.render(scene, spp=16, size=(96, 64), camera=camera, aovs=["depth"])
picture.save("ring.png")

FOG = """#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) readonly uniform image2D color;
layout(set = 0, binding = 1, r32f) readonly uniform image2D depth;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D foggy;
layout(push_constant) uniform Constants { float density; } constants;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(foggy)))) return;
    float clear = exp(-constants.density * imageLoad(depth, pixel).r);
    imageStore(foggy, pixel, mix(vec4(0.5), imageLoad(color, pixel), clear));
}
"""
inputs = {"color": picture["color"], "depth": picture["depth"]}
foggy = rg.run_pass(FOG, inputs, {"foggy": picture["depth"].shape}, constants=np.float32(0.2))["foggy"]
print(foggy.shape, rg.explain(scene, (48, 40), size=(96, 64), camera=camera)["text"].splitlines()[0])
