// Show: one triangle over the whole target.
#version 460

void main() {
    vec2 corner = vec2(gl_VertexIndex == 1 ? 3.0f : -1.0f, gl_VertexIndex == 2 ? 3.0f : -1.0f);
    gl_Position = vec4(corner, 0.0f, 1.0f);
}
