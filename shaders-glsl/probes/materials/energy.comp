#version 460
#extension GL_GOOGLE_include_directive : require
layout(std430) readonly buffer Energy { float energy[]; };
#define LEADR_ENERGY_TEXEL(x, y) vec2(energy[2 * ((x) + 33 * (y))], energy[2 * ((x) + 33 * (y)) + 1])
#include "leadr/materials/energy.glsl"
#include "probes/leadr_probe.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= count) return;
    at = gl_GlobalInvocationID.x * 6;
    float alpha = next(), cosine_o = next(), cosine_i = next();
    vec3 f0 = next3();
    vec2 o = energy_albedo(alpha, cosine_o), i = energy_albedo(alpha, cosine_i), average = energy_average(alpha);
    at = gl_GlobalInvocationID.x * 23;
    put(o);
    put(average);
    put(split_albedo(f0, o));
    put(average_fresnel(f0));
    put(compensation_color(f0, average.x));
    put(compensation_lobe(o.x, i.x, average.x));
    put(compensation_scale(f0, o.x));
    put(specular_albedo(f0, o, average.x));
    put(entered(f0, o, average.x));
}
