#version 460
// Declares unused resources.
layout(local_size_x = 1) in;
layout(constant_id = 0) const float UNUSED_FACTOR = 1.0;
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(push_constant) uniform P { uint count; };

void main() {
    y[0] = 1.0;
}
