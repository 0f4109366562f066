// Evaluates the beach under the sea. The input is a point and a reach, and the output is offshore, ground, height, slope and foam.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../passes/ocean/shore.glsl"
layout(local_size_x = 64) in;
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(std140) uniform Beach { Shore shore; };
layout(push_constant) uniform P { uint count; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    vec2 point = vec2(x[3 * i], x[3 * i + 1]);
    float offshore = shore_offshore(shore, point);
    ShoreWater w = shore_water(shore, point, x[3 * i + 2]);
    y[7 * i] = offshore;
    y[7 * i + 1] = shore_ground(shore, offshore);
    y[7 * i + 2] = w.height;
    y[7 * i + 3] = w.slope.x;
    y[7 * i + 4] = w.slope.y;
    y[7 * i + 5] = shore_foam(w, x[3 * i + 2]);
    y[7 * i + 6] = w.depth;
}
