// Vertices of DrawUi: those of Dear ImGui, pulled from a buffer.
#version 460
#extension GL_EXT_scalar_block_layout : require

struct UiVertex {
    vec2 position;  // points of the window
    vec2 uv;
    uint color;  // RGBA, eight bits each, red lowest
};

layout(set = 0, binding = 0, scalar) readonly buffer Vertices { UiVertex at[]; } vertices;
layout(push_constant) uniform Constants { vec2 scale; vec2 offset; } constants;  // points to clip space

layout(location = 0) out vec2 uv;
layout(location = 1) out vec4 color;
layout(location = 2) flat out uint source;

void main() {
    UiVertex vertex = vertices.at[gl_VertexIndex];
    gl_Position = vec4(vertex.position * constants.scale + constants.offset, 0.0f, 1.0f);
    uv = vertex.uv;
    color = unpackUnorm4x8(vertex.color);
    source = uint(gl_InstanceIndex);
}
