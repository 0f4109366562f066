#version 460
// Reads one resource of each descriptor set: y = factor x + term.
layout(local_size_x = 64) in;
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(set = 1, std430) readonly buffer Factors { float factors[]; };
layout(set = 2, std430) readonly buffer Terms { float terms[]; };
layout(push_constant) uniform P { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        y[i] = factors[0] * x[i] + terms[0];
    }
}
