// Inverse Fourier transform of one line of N samples in shared memory, by one work group, in place. Each sample is a vec4:
// two complex numbers side by side.
#ifndef LEADR_OCEAN_FFT
#define LEADR_OCEAN_FFT

layout(constant_id = 0) const uint N = 256;     // samples, a power of two from 4 on
layout(constant_id = 1) const uint LOG_N = 8;
layout(constant_id = 2) const uint LINES = 1;   // lines side by side in `line`
const uint THREADS = 64;

shared vec4 line[N * LINES];

layout(std430) readonly buffer Twiddles { vec2 twiddles[]; }; // e^{2 pi i j / N}

vec4 turn(vec4 v, vec2 w) {
    return vec4(v.x * w.x - v.y * w.y, v.x * w.y + v.y * w.x, v.z * w.x - v.w * w.y, v.z * w.y + v.w * w.x);
}

// Where sample i of the input belongs before the transform.
uint reversed(uint i) {
    return bitfieldReverse(i) >> (32u - LOG_N);
}

// `line` holds the input at its reversed places; call with all threads, after a barrier. Leaves the result in order,
// behind a barrier. Pairs of radix-2 steps are done at once: half the barriers, and they are what costs.
void inverse_fft(uint thread) {
    uint s = 0;
    if ((LOG_N & 1u) != 0u) {
        for (uint b = thread; b < LINES * (N / 2); b += THREADS) {
            vec4 p = line[2 * b], q = line[2 * b + 1];
            line[2 * b] = p + q;
            line[2 * b + 1] = p - q;
        }
        barrier();
        s = 1;
    }
    for (; s < LOG_N; s += 2) {
        uint span = 1u << s;
        for (uint b = thread; b < LINES * (N / 4); b += THREADS) {
            uint j = b & (span - 1);
            uint base = ((b >> s) << (s + 2)) | j;
            vec2 w1 = twiddles[j << (LOG_N - s - 1)], w2 = twiddles[j << (LOG_N - s - 2)];
            vec4 x0 = line[base], x1 = turn(line[base + span], w1);
            vec4 x2 = line[base + 2 * span], x3 = turn(line[base + 3 * span], w1);
            vec4 y0 = x0 + x1, y1 = x0 - x1, y2 = turn(x2 + x3, w2), y3 = turn(x2 - x3, w2);
            y3 = vec4(-y3.y, y3.x, -y3.w, y3.z); // times i
            line[base] = y0 + y2;
            line[base + span] = y1 + y3;
            line[base + 2 * span] = y0 - y2;
            line[base + 3 * span] = y1 - y3;
        }
        barrier();
    }
}

#endif
