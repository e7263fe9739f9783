#version 460
// Rings that become finer outward, with a colored quarter.
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

void main() {
    vec2 p = 2.0 * uv - 1.0;
    float ring = step(0.0, sin(60.0 * dot(p, p)));
    vec3 paint = p.x > 0.0 && p.y > 0.0 ? vec3(0.95, 0.45, 0.1) : vec3(1.0);
    color = vec4(ring * paint, 1.0);
}
