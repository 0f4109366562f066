#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Transforms the columns, and writes the finest level of the maps. Each work group transforms one column of a cascade.
#include "cascade.glsl"
#include "fft.glsl"
layout(local_size_x = 32) in;

layout(std430) readonly buffer Lines { vec4 lines[]; }; // [cascade][y][2][x]
layout(rgba32f) uniform writeonly image2DArray displacement; // Dx, Dy, height, det J
layout(rgba32f) uniform writeonly image2DArray slopes;       // w sx, w sy, w sx^2, w sy^2
layout(rgba32f) uniform writeonly image2DArray joint;        // w sx sy, w, stretch, stretch^2

layout(std430) readonly buffer Cascades { Cascade cascades[]; };

layout(push_constant) uniform Push { float choppiness; };

// For the reference, quantities that are linear in the waves replace the moments. displacement has Dx, Dy, height and dDx/dy. slopes has
// the gradient, dDx/dx and dDy/dy. joint is not written.
layout(constant_id = 3) const bool DERIVATIVES = false;

// The smallest area ratio. Where the surface folds over itself, its slope has no meaning.
const float LEAST_AREA = 0.1;

void main() {
    uint column = gl_WorkGroupID.x, cascade = gl_WorkGroupID.y;
    uint base = 2 * cascade * N * N + column;
    for (uint j = gl_LocalInvocationID.x; j < N; j += THREADS) {
        line[j] = lines[base + 2 * N * j];
        line[N + j] = lines[base + 2 * N * j + N];
    }
    barrier();
    inverse_fft(gl_LocalInvocationID.x);
    for (uint j = gl_LocalInvocationID.x; j < N; j += THREADS) {
        vec4 a = line[found(j)], b = line[N + found(j)];
        ivec3 texel = ivec3(column, j, cascade);
        float height = a.x;
        vec2 moved = choppiness * a.yz, gradient = b.xy;
        if (DERIVATIVES) {
            imageStore(displacement, texel, vec4(moved, height, choppiness * a.w));
            imageStore(slopes, texel, vec4(gradient, choppiness * b.zw));
            continue;
        }
        // J = I + dD/dp is the Jacobian of the displaced surface. The slope of this surface is J^-T grad h = adj(J) grad h / det J.
        float jxx = 1.0 + choppiness * b.z, jyy = 1.0 + choppiness * b.w, jxy = choppiness * a.w;
        float area = jxx * jyy - jxy * jxy;
        vec2 flux = vec2(jyy * gradient.x - jxy * gradient.y, jxx * gradient.y - jxy * gradient.x);
        float held = max(area, LEAST_AREA);
        // Means are taken over the displaced surface, so each sample is weighted by its area: w s = adj(J) grad h.
        imageStore(displacement, texel, vec4(moved, height, area));
        imageStore(slopes, texel, vec4(flux, flux * flux / held));
        float stretch = 1.0 + foam_weight(cascades[cascade]) * (jxx + jyy - 2.0);
        imageStore(joint, texel, vec4(flux.x * flux.y / held, held, stretch, stretch * stretch));
    }
}
