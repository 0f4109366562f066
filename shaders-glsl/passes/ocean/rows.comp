#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Advances the waves to the present time, and transforms the rows. Each work group transforms one row of a cascade.
#include "fft.glsl"
#include "cascade.glsl"
layout(local_size_x = 32) in;

layout(std430) readonly buffer Waves { vec4 waves[]; };      // [cascade][y][x]: amplitude, cycles
layout(std430) readonly buffer Cascades { Cascade cascades[]; };
layout(std430) writeonly buffer Lines { vec4 lines[]; };     // [cascade][y][2][x]

// The fraction of the wave period, 0 to 1, in two parts: 11 bits, whose product with a number of cycles is exact, and the remainder.
layout(push_constant) uniform Push { vec2 moment; };

float wave_phase(const float cycles) {
    return 6.28318530718 * fract(fract(cycles * moment.x) + cycles * moment.y);
}

vec2 complex_product(const vec2 v, const vec2 w) {
    return vec2(v.x * w.x - v.y * w.y, v.x * w.y + v.y * w.x);
}

void main() {
    uint row = gl_WorkGroupID.x, cascade = gl_WorkGroupID.y;
    Cascade c = cascades[cascade];
    uint tile = cascade * N * N;
    for (uint i = gl_LocalInvocationID.x; i < N; i += THREADS) {
        vec4 wave = waves[tile + row * N + i];
        vec4 against = waves[tile + ((N - row) & (N - 1)) * N + ((N - i) & (N - 1))];
        float phase = wave_phase(wave.z), back = wave_phase(against.z);
        // The amplitude at this time is a(k) e^{-i w t} + conj(a(-k)) e^{i w t}.
        vec2 h = complex_product(wave.xy, vec2(cos(phase), -sin(phase)))
               + complex_product(vec2(against.x, -against.y), vec2(cos(back), sin(back)));
        vec2 n = vec2(ivec2(i, row)) - vec2(i < N / 2 ? 0 : N, row < N / 2 ? 0 : N);
        vec2 k = c.wave_step * vec2(c.rotation.x * n.x - c.rotation.y * n.y, c.rotation.y * n.x + c.rotation.x * n.y);
        float inverse = inversesqrt(max(dot(k, k), 1e-20));
        vec2 ih = vec2(-h.y, h.x);
        // Real fields are transformed in pairs: f + i g has the transform F + i G. The displacement is D = i k/|k| h, its derivatives are
        // -k k^T/|k| h, and the gradient is i k h.
        vec2 dx = ih * (k.x * inverse), dy = ih * (k.y * inverse);
        vec2 jxy = -h * (k.x * k.y * inverse), jxx = -h * (k.x * k.x * inverse), jyy = -h * (k.y * k.y * inverse);
        vec2 hx = ih * k.x, hy = ih * k.y;
        line[i] = vec4(h.x - dx.y, h.y + dx.x, dy.x - jxy.y, dy.y + jxy.x);
        line[N + i] = vec4(hx.x - hy.y, hx.y + hy.x, jxx.x - jyy.y, jxx.y + jyy.x);
    }
    barrier();
    inverse_fft(gl_LocalInvocationID.x);
    uint base = 2 * (tile + row * N);
    for (uint i = gl_LocalInvocationID.x; i < LINES * N; i += THREADS) {
        lines[base + i] = line[(i & ~(N - 1u)) + found(i & (N - 1u))];
    }
}
