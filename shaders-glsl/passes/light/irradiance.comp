// Second half of the SH projection: one invocation per coefficient adds the rows' partial sums in a fixed order (the
// same bytes every run), then the lights that need no masking per pixel (LEADR Algorithm 2, with its first line's
// doubled L00 corrected). Radiance coefficients: the cosine lobe's factors A_l are not applied.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "leadr/integrals/sh.glsl"
layout(local_size_x = 9) in;

struct Light {
    vec4 place; // xyz: unit direction towards the light (w = 0) or world position, metres (w = 1)
    vec4 power; // rgb: irradiance across the beam (w = 0) or radiant intensity (w = 1)
};
layout(std430) readonly buffer Partials { vec4 partials[]; };
layout(std430) writeonly buffer Coefficients { vec4 coefficients[9]; };
layout(push_constant) uniform Push {
    Light lights[3];
    vec3 origin; // where point lights are received, world
    float scale; // of the environment
    uint rows;   // partial sums per coefficient
    uint light_count;
};

void main()
{
    uint k = gl_LocalInvocationID.x;
    vec3 sum = vec3(0.0);
    vec3 lost = vec3(0.0); // Kahan's compensation
    for (uint i = 0u; i < rows; ++i) {
        precise vec3 term = partials[k * rows + i].rgb - lost;
        precise vec3 next = sum + term;
        precise vec3 back = next - sum;
        lost = back - term;
        sum = next;
    }
    sum *= scale;
    for (uint i = 0u; i < light_count; ++i) {
        vec3 to_light = lights[i].place.xyz - lights[i].place.w * origin;
        float squared = dot(to_light, to_light);
        float falloff = lights[i].place.w == 0.0 ? 1.0 : 1.0 / max(squared, 1e-8);
        sum += sh_basis(to_light * inversesqrt(max(squared, 1e-16)))[k] * falloff * lights[i].power.rgb;
    }
    coefficients[k] = vec4(sum, 0.0);
}
