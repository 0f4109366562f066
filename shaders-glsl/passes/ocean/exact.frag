#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the unfiltered slope for the reference, at the point that the pixel ray hits. The slope follows from the summed gradients and
// Jacobians of all cascades, and not from a sum of their slopes.
#include "../constants.glsl"
#include "cascade.glsl"
#include "water.glsl"
#include "../filter/gbuffer_out.glsl"
#include "../visible.glsl"
#include "leadr/frame.glsl"

uniform usampler2D visible_surface;
uniform sampler2DArray displacement; // Dx, Dy, height, dDx/dy
uniform sampler2DArray slopes;       // gradient, dDx/dx, dDy/dy
layout(std430) readonly buffer Cascades { Cascade cascades[]; };

// The smallest area ratio of a folding surface, as in columns.comp.
const float LEAST_AREA = 0.1;

// Returns the six-point Lagrange weights at u in [0, 1] between the third and the fourth sample. For a wave of six samples, 99 % of the
// variance remains. With linear interpolation, 84 % would remain.
float[6] weights(const float u) {
    float p = u + 2.0, q = u + 1.0, r = u - 1.0, s = u - 2.0, t = u - 3.0;
    return float[6](q * u * r * s * t / -120.0, p * u * r * s * t / 24.0, p * q * r * s * t / -12.0,
                    p * q * u * s * t / 12.0, p * q * u * r * t / -24.0, p * q * u * r * s / 120.0);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 seen = texelFetch(visible_surface, pixel, 0);
    if (object_of(seen.x) != SEA_INDEX) {
        discard;
    }
    vec2 away = uintBitsToFloat(seen.yz), at = away + water.centre.xy;
    ivec3 size = textureSize(slopes, 0);
    vec4 sum = vec4(0.0); // gradient, dDx/dx, dDy/dy
    float mixed = 0.0, stretch = 1.0;
    for (int i = 0; i < size.z; ++i) {
        vec2 coordinates = cascade_texcoord(cascades[i], at) * vec2(size.xy) - 0.5;
        ivec2 base = ivec2(floor(coordinates));
        float x[6] = weights(coordinates.x - float(base.x)), y[6] = weights(coordinates.y - float(base.y));
        vec4 here = vec4(0.0);
        for (int k = 0; k < 36; ++k) {
            ivec3 texel = ivec3((base + ivec2(k % 6, k / 6) - 2) & (size.xy - 1), i);
            float weight = x[k % 6] * y[k / 6];
            here += weight * texelFetch(slopes, texel, 0);
            mixed += weight * texelFetch(displacement, texel, 0).w;
        }
        sum += here;
        stretch += foam_weight(cascades[i]) * (here.z + here.w);
    }
    // The slope is J^-T grad h, plus the curvature of the earth.
    float jxx = 1.0 + sum.z, jyy = 1.0 + sum.w, area = jxx * jyy - mixed * mixed;
    vec2 slope = vec2(jyy * sum.x - mixed * sum.y, jxx * sum.y - mixed * sum.x) / max(area, LEAST_AREA);
    float covered = stretch < water.foam.w ? 1.0 : 0.0;
    vec4 material = vec4(mix(water.color.rgb, water.foam.rgb, covered), mix(water.tail.w, 0.6, covered));
    FilteredSurface sea = filtered_water(slope - away * water.centre.z, water.tail.xyz, material, water.color.w * (1.0 - covered));
    write_gbuffer(sea, pack_surface(sea));
}
