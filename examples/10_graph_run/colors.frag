#version 460
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;
layout(binding = 0) uniform sampler2D state;

void main() {
    float y = texture(state, uv).y;
    vec3 low = mix(vec3(0.02, 0.03, 0.12), vec3(0.1, 0.45, 0.6), smoothstep(0.0, 0.2, y));
    color = vec4(mix(low, vec3(1.0, 0.9, 0.6), smoothstep(0.2, 0.38, y)), 1.0);
}
