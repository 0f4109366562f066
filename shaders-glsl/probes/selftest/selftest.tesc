#version 460
layout(vertices = 4) out;
layout(constant_id = 0) const float LEVEL = 1.0;

void main() {
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    if (gl_InvocationID == 0) {
        for (int i = 0; i < 4; ++i) {
            gl_TessLevelOuter[i] = LEVEL;
        }
        gl_TessLevelInner[0] = LEVEL;
        gl_TessLevelInner[1] = LEVEL;
    }
}
