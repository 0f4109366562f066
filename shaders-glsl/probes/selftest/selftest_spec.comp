#version 460
#extension GL_GOOGLE_include_directive : require
// Tests specialisation constants, includes from both folders, and a struct shared with Rust.
#include "affine.glsl"
#include "probes/selftest/affine.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const float SCALE = 1.0;
layout(constant_id = 1) const int SHIFT = 0;
layout(constant_id = 2) const bool NEGATE = false;
layout(constant_id = 3) const uint LIMIT = 0xffffffffu;

struct Item {
    vec3 position;
    float weight;
    mat4 frame;
    vec2 extent;
};
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(std430) readonly buffer Items { uint items_used; Item items[]; };
layout(std140) uniform Settings { vec4 offset; float gain[3]; };
layout(push_constant) uniform P { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= min(count, LIMIT)) {
        return;
    }
    float value = selftest_affine(x[i], SCALE, float(SHIFT));
    Item item = items[items_used];
    y[i] = (NEGATE ? -value : value) + item.weight * item.frame[3].w + item.extent.y + offset.x * gain[2];
}
