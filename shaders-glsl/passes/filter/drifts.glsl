// Open ground: drifts of dust over metres to hundreds of metres, and trodden paths. Drifts are octaves of noise, and paths are a sum of
// plane waves. Drifts and paths are filtered analytically over the pixel's footprint, so they neither repeat nor shimmer.
#ifndef LEADR_FILTER_DRIFTS
#define LEADR_FILTER_DRIFTS

// The variance of the pixel filter, in squared pixel widths.
const float PIXEL_VARIANCE = 0.12;
// The ratio of consecutive wavelengths. From wave to wave, the direction rotates by the golden angle.
const float LONGER = 1.6;
const mat2 ROTATION = mat2(-0.7373688, 0.6754903, -0.6754903, -0.7373688);
const int DRIFTS = 8;
const float LARGEST_DRIFT = 102.4; // width of a lattice cell in metres; each octave halves the width
const int PATH_WAVES = 5;
const float SHORTEST_PATH = 31.0;
// Half the width of a path, in metres.
const float PATH_WIDTH = 0.45;
// The mean fraction of the soil's albedo that remains. The fraction is below 1, because the soil map shows a dusty area.
const vec3 OPEN_GROUND = vec3(0.82, 0.816, 0.787);

// The relative spread of the wave vectors, which limits the length of the wave crests. Unlimited crests would be visible as rays toward the
// horizon, where footprints are very long.
const float WAVE_SPREAD = 0.2;

// Returns the fraction of a wave's amplitude that passes the pixel filter.
float wave_part(const vec2 k, const mat2 across) {
    vec2 rotated = k * across;
    float widest = dot(across[0], across[0]) + dot(across[1], across[1]);
    return exp(-0.5 * PIXEL_VARIANCE * (dot(rotated, rotated) + WAVE_SPREAD * WAVE_SPREAD * dot(k, k) * widest));
}

// Returns three random numbers in [-1, 1] for a corner of the lattice.
vec3 corner_numbers(const ivec2 corner, const uint seed) {
    uint n = uint(corner.x) * 0x9e3779b1u ^ uint(corner.y) * 0x85ebca6bu ^ seed * 0x27d4eb2fu;
    n = (n ^ (n >> 16)) * 0x7feb352du;
    n = (n ^ (n >> 15)) * 0x846ca68bu;
    n ^= n >> 16;
    return vec3(uvec3(n, n >> 11, n >> 22) & uvec3(0x7ffu, 0x7ffu, 0x3ffu)) * vec3(2.0 / 2047.0, 2.0 / 2047.0, 2.0 / 1023.0) - 1.0;
}

// Returns the noise of one lattice corner at the offset `from`, from the gradient and the value of this corner. The amplitude of the value
// makes the noise as strong at corners as between them.
float corner_noise(const ivec2 corner, const uint seed, const vec2 from) {
    vec3 numbers = corner_numbers(corner, seed);
    return dot(numbers.xy, from) + 0.408 * numbers.z;
}

// Returns noise of variance 1 on a lattice whose cells have the width 1.
float lattice_noise(const vec2 at, const uint seed) {
    vec2 cell = floor(at), f = at - cell;
    ivec2 c = ivec2(cell);
    vec2 fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    vec2 left = vec2(corner_noise(c, seed, f), corner_noise(c + ivec2(0, 1), seed, f - vec2(0.0, 1.0)));
    vec2 right = vec2(corner_noise(c + ivec2(1, 0), seed, f - vec2(1.0, 0.0)), corner_noise(c + 1, seed, f - 1.0));
    vec2 row = mix(left, right, fade.x);
    return 4.24 * mix(row.x, row.y, fade.y);
}

// Returns the fraction of lattice noise that passes the pixel filter. The fraction is estimated for waves of 1.7 cells along the longer
// axis of the footprint.
float noise_part(const float cell, const float widest) {
    float k = 6.28318530718 / (1.7 * cell);
    return exp(-0.5 * PIXEL_VARIANCE * k * k * widest);
}

// Returns the factor on the albedo at a position in metres. across has the derivatives of the position by x and y of the image.
vec3 ground_tint(const vec2 position, const mat2 across) {
    // Two waves bend the straight crests, too little to affect the filtering.
    const vec2 bend_x = vec2(0.036, 0.061), bend_y = vec2(0.067, -0.029);
    vec2 bent = vec2(sin(dot(bend_x, position) + 0.4) * wave_part(bend_x, across),
                     sin(dot(bend_y, position) + 1.9) * wave_part(bend_y, across));
    vec2 p = position + 3.0 * bent;
    float drift = 0.0, height = 0.84, cell = LARGEST_DRIFT;
    float widest = dot(across[0], across[0]) + dot(across[1], across[1]);
    // The lattice of each octave is rotated, so that the rows of different octaves do not align.
    mat2 rotated = mat2(1.0);
    for (int i = 0; i < DRIFTS; ++i) {
        float part = noise_part(cell, widest);
        if (part < 0.01) {
            break;
        }
        drift += height * part * lattice_noise(rotated * position / cell, uint(i));
        rotated = ROTATION * rotated;
        cell *= 0.5;
        height /= 1.062;
    }
    // A path runs along the zeros of a broad wave. The distance to the path is the wave's value divided by its slope.
    float level = 0.0, left = 0.0;
    vec2 slope = vec2(0.0);
    vec2 k = ROTATION * vec2(6.28318530718 / SHORTEST_PATH, 0.0);
    for (int i = 0; i < PATH_WAVES; ++i) {
        float part = wave_part(k, across), phase = dot(k, p) + 1.7 * float(i * i);
        level += part * cos(phase);
        slope -= part * sin(phase) * k;
        left += part;
        k = ROTATION * k / LONGER;
    }
    float square = max(dot(slope, slope), 1e-4);
    vec2 over = slope * across;
    // The path is widened by the extent of the pixel's footprint across the path.
    float width = PATH_WIDTH * PATH_WIDTH, wider = width + PIXEL_VARIANCE * dot(over, over) / square;
    float trodden = sqrt(width / wider) * exp(-0.5 * level * level / (square * wider)) * left / float(PATH_WAVES);
    vec3 tint = OPEN_GROUND * (1.0 + 0.08 * drift * vec3(1.0, 1.05, 1.15));
    return clamp(tint * mix(vec3(1.0), vec3(1.38, 1.35, 1.3), trodden), 0.0, 1.3);
}

#endif
