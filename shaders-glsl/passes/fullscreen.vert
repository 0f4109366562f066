#version 460

layout(location = 0) out vec2 out_texcoord; // from 0 to 1, y down

// Draws one triangle that covers the screen.
void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0;
    out_texcoord = corner;
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}
