#version 460
// Tests the probe convention itself: y = 2 x.
layout(local_size_x = 64) in;
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(push_constant) uniform P { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        y[i] = 2.0 * x[i];
    }
}
