// Open ground from afar: drifts of dust over metres to hundreds of metres, and paths that animals have trodden. Both are sums of plane
// waves, of which a pixel's footprint takes a known part, so they neither repeat nor shimmer.
#ifndef LEADR_FILTER_DRIFTS
#define LEADR_FILTER_DRIFTS

// Variance of a pixel's filter, in squares of its width.
const float PIXEL_VARIANCE = 0.12;
// A wave and the next: lengths grow by this, and directions turn by the golden angle.
const float LONGER = 1.6;
const mat2 TURNED = mat2(-0.7373688, 0.6754903, -0.6754903, -0.7373688);
const int DRIFT_WAVES = 12;
const float SHORTEST_DRIFT = 1.3; // metres
const int PATH_WAVES = 5;
const float SHORTEST_PATH = 31.0;
// Half the width of a path, metres.
const float PATH_WIDTH = 0.45;
// What is left of the soil's albedo on average: the map is that of a dusty place.
const vec3 OPEN_GROUND = vec3(0.82, 0.816, 0.787);

// Crests are as long as waves whose vectors differ by this part keep step. Endless ones would show as rays toward the horizon, where pixels
// are much longer than they are wide.
const float WAVE_SPREAD = 0.2;

// Part of a wave that a pixel lets pass.
float wave_part(vec2 k, mat2 across) {
    vec2 turned = k * across;
    float widest = dot(across[0], across[0]) + dot(across[1], across[1]);
    return exp(-0.5 * PIXEL_VARIANCE * (dot(turned, turned) + WAVE_SPREAD * WAVE_SPREAD * dot(k, k) * widest));
}

// At a place in metres. across: its derivatives by x and y of the image.
vec3 ground_tint(vec2 place, mat2 across) {
    // Straight crests are bent, by less than they would have to be filtered for.
    const vec2 bend_x = vec2(0.036, 0.061), bend_y = vec2(0.067, -0.029);
    vec2 bent = vec2(sin(dot(bend_x, place) + 0.4) * wave_part(bend_x, across), sin(dot(bend_y, place) + 1.9) * wave_part(bend_y, across));
    vec2 p = place + 3.0 * bent;
    float drift = 0.0;
    vec2 k = vec2(6.28318530718 / SHORTEST_DRIFT, 0.0);
    float amplitude = 0.635;
    for (int i = 0; i < DRIFT_WAVES; ++i) {
        drift += amplitude * wave_part(k, across) * cos(dot(k, p) + 3.5 * float(i * i));
        k = TURNED * k / LONGER;
        amplitude *= 1.042;
    }
    // A path runs where a broad wave is 0; its distance is that wave over its slope.
    float level = 0.0, left = 0.0;
    vec2 slope = vec2(0.0);
    k = TURNED * vec2(6.28318530718 / SHORTEST_PATH, 0.0);
    for (int i = 0; i < PATH_WAVES; ++i) {
        float part = wave_part(k, across), phase = dot(k, p) + 1.7 * float(i * i);
        level += part * cos(phase);
        slope -= part * sin(phase) * k;
        left += part;
        k = TURNED * k / LONGER;
    }
    float square = max(dot(slope, slope), 1e-4);
    vec2 over = slope * across;
    // The pixel widens the path by its own extent across it.
    float width = PATH_WIDTH * PATH_WIDTH, wider = width + PIXEL_VARIANCE * dot(over, over) / square;
    float trodden = sqrt(width / wider) * exp(-0.5 * level * level / (square * wider)) * left / float(PATH_WAVES);
    vec3 tint = OPEN_GROUND * (1.0 + 0.08 * drift * vec3(1.0, 1.05, 1.15));
    return clamp(tint * mix(vec3(1.0), vec3(1.38, 1.35, 1.3), trodden), 0.0, 1.3);
}

#endif
