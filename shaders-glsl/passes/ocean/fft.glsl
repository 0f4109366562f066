// Computes the inverse Fourier transform of one line of N samples in place. One work group transforms the line in shared memory. Each
// sample is a vec4 of two complex numbers.
#ifndef LEADR_OCEAN_FFT
#define LEADR_OCEAN_FFT

layout(constant_id = 0) const uint N = 256;     // number of samples, a power of two from 4 on
layout(constant_id = 1) const uint LOG_N = 8;
layout(constant_id = 2) const uint LINES = 1;   // number of lines in `line`, which are transformed in parallel
const uint THREADS = 32;

shared vec4 line[N * LINES];

layout(std430) readonly buffer Twiddles { vec2 twiddles[]; }; // e^{2 pi i j / N}

vec4 complex_product(const vec4 v, const vec2 w) {
    return vec4(v.x * w.x - v.y * w.y, v.x * w.y + v.y * w.x, v.z * w.x - v.w * w.y, v.z * w.y + v.w * w.x);
}

// A line is a table of ROWS x COLUMNS samples. The columns are transformed first, and then the rows. Each thread transforms one column or
// row in registers, because barriers and shared-memory accesses dominate the cost.
const uint LOG_ROWS = (LOG_N + 1u) / 2u, LOG_COLUMNS = LOG_N / 2u;
const uint ROWS = 1u << LOG_ROWS, COLUMNS = 1u << LOG_COLUMNS;

// Returns the index of sample k after the transform.
uint found(const uint k) {
    return ((k & (ROWS - 1u)) << LOG_COLUMNS) | (k >> LOG_ROWS);
}

#define REGISTER_FFT(NAME, SIZE, LOG_SIZE)                                                      \
    void NAME(inout vec4 v[SIZE]) {                                                             \
        [[unroll]] for (uint s = 0u; s < LOG_SIZE; ++s) {                                       \
            [[unroll]] for (uint b = 0u; b < SIZE / 2u; ++b) {                                  \
                uint j = b & ((1u << s) - 1u), low = ((b >> s) << (s + 1u)) | j, high = low + (1u << s); \
                vec4 far = complex_product(v[high], twiddles[j << (LOG_N - s - 1u)]);           \
                v[high] = v[low] - far;                                                         \
                v[low] += far;                                                                  \
            }                                                                                   \
        }                                                                                       \
    }
// Transforms the values in place, from bit-reversed order.
REGISTER_FFT(fft_of_column, ROWS, LOG_ROWS)
REGISTER_FFT(fft_of_row, COLUMNS, LOG_COLUMNS)

uint reversed(const uint i, const uint bits) {
    return bitfieldReverse(i) >> (32u - bits);
}

// Transforms `line`, which holds the input in order. Call the function with all threads, after a barrier. The function leaves sample k of
// the result at found(k), and ends with a barrier.
void inverse_fft(const uint thread) {
    for (uint item = thread; item < LINES * COLUMNS; item += THREADS) {
        uint column = item & (COLUMNS - 1u), first = (item >> LOG_COLUMNS) * N + column;
        vec4 v[ROWS];
        [[unroll]] for (uint i = 0u; i < ROWS; ++i) {
            v[reversed(i, LOG_ROWS)] = line[first + (i << LOG_COLUMNS)];
        }
        fft_of_column(v);
        [[unroll]] for (uint i = 0u; i < ROWS; ++i) {
            line[first + (i << LOG_COLUMNS)] = complex_product(v[i], twiddles[(i * column) & (N - 1u)]);
        }
    }
    barrier();
    for (uint item = thread; item < LINES * ROWS; item += THREADS) {
        uint first = item << LOG_COLUMNS;
        vec4 v[COLUMNS];
        [[unroll]] for (uint i = 0u; i < COLUMNS; ++i) {
            v[reversed(i, LOG_COLUMNS)] = line[first + i];
        }
        fft_of_row(v);
        [[unroll]] for (uint i = 0u; i < COLUMNS; ++i) {
            line[first + i] = v[i];
        }
    }
    barrier();
}

#endif
