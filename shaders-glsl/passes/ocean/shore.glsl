// The sea at a beach that rises toward +x (crates/leadr-render/src/surfaces/ocean/shore.rs): height of the sand, damping of waves above the
// sand, breaking swell, swash and foam. All functions are pure.
#ifndef LEADR_OCEAN_SHORE
#define LEADR_OCEAN_SHORE

struct Shore {
    vec4 profile;        // slope at the waterline; height of the berm; reach and scale of the deepening (shore_ground)
    vec4 line_amplitude; // amplitudes of the waterline's bends, in metres
    vec4 line_step;      // wave numbers of the bends along y, in rad/m
    vec4 line_phase;
    vec4 swell;          // at the waterline: phase in cycles, whole cycles before this phase; period in s; height of the run-up in metres
    vec4 bed;            // rgb: albedo of wet sand
    vec4 extinction;     // rgb: extinction of the water, per metre
    vec4 calm[2];        // for each cascade: depth in metres at which its waves have 63 % of their height
};

const float SHORE_GRAVITY = 9.81;

// Returns the distance from the waterline in metres, positive toward the sea. The coordinate along the coast is -y.
float shore_offshore(const Shore shore, vec2 point) {
    point = -point;
    return point.x - dot(shore.line_amplitude, sin(shore.line_step * point.y + shore.line_phase));
}

// Returns the height of the sand above the water at rest.
float shore_ground(const Shore shore, const float offshore) {
    float reach = shore.profile.z;
    if (offshore > 0.0) {
        return -shore.profile.w * (pow(offshore + reach, 2.0 / 3.0) - pow(reach, 2.0 / 3.0));
    }
    return shore.profile.y * (1.0 - exp(offshore * shore.profile.x / shore.profile.y));
}

// Returns the fraction of their height that the waves of cascade i have in water of this depth.
float shore_calm(const Shore shore, const int i, const float depth) {
    return 1.0 - exp(-max(depth, 0.0) / shore.calm[(i >> 2) & 1][i & 3]);
}

// Returns the phase lead of the swell along the coast, in cycles, and its derivative.
vec2 shore_early(const float y) {
    return vec2(0.13 * sin(0.17 * y + 0.7) + 0.07 * sin(0.37 * y + 2.0), 0.0221 * cos(0.17 * y + 0.7) + 0.0259 * cos(0.37 * y + 2.0));
}

// Returns the relative height of the n-th wave of the swell.
float shore_set(const float n, const float y) {
    return 0.7 + 0.3 * sin(2.4 * n + 0.11 * y);
}

// Returns the height of the water at the waterline, above its rest level.
float shore_swash(const Shore shore, const float y) {
    float turns = shore.swell.x + shore_early(y).x, n = floor(turns), u = turns - n;
    // The water of the run-up falls back on a parabola.
    return shore.swell.w * (0.25 + 0.75 * shore_set(n + shore.swell.y, y) * 4.0 * u * (1.0 - u));
}

struct ShoreWater {
    float height;   // height of swash and swell above the rest level
    float depth;    // depth of the water, down to the sand
    vec2 slope;     // slope of the height
    float variance; // variance of the slopes along x that averaging over `reach` removes
    float foam;     // amount of foam, 0 to 1
    vec2 drift;     // coordinate of the foam texture, which moves with the water
};

// Returns the water above a point, averaged over `reach` metres.
ShoreWater shore_water(const Shore shore, vec2 point, const float reach) {
    ShoreWater w;
    float s = shore_offshore(shore, point);
    point = -point;
    float ground = shore_ground(shore, s), sea = max(s, 0.0);
    float swash = shore_swash(shore, point.y), fade = exp(-sea / 6.0);
    w.height = swash * fade;
    w.slope = vec2(s > 0.0 ? -w.height / 6.0 : 0.0, 0.0);
    w.drift = vec2(s + (w.height - 0.4 * shore.swell.w * fade) / shore.profile.x, point.y);

    // The swell has crests at whole phases. In shallow water, the depth determines the speed of every wave.
    float still = max(-ground, 0.0), film = max(w.height - ground, 0.0);
    float scale = sqrt(SHORE_GRAVITY * shore.profile.w);
    vec2 early = shore_early(point.y);
    float turns = shore.swell.x + early.x + 1.5 * still / (shore.profile.w * scale * shore.swell.z);
    float n = floor(turns + 0.5), u = turns - n, set = shore_set(n + shore.swell.y, point.y);
    float rate = 1.0 / (shore.swell.z * scale * pow(sea + shore.profile.z, 1.0 / 3.0)); // cycles per metre
    float breaking = 1.0 - smoothstep(0.5, 1.3, still / set);
    float front = mix(0.12, 0.035, breaking), back = 0.15, width = u < 0.0 ? front : back;
    float height = 0.6 * set * film / (1.0 + film * sqrt(film));
    float crest = height * exp(-u * u / (width * width));
    float seen = 1.0 / (1.0 + reach * reach);
    w.height += crest * seen;
    w.slope += seen * crest * (-2.0 * u / (width * width)) * vec2(s > 0.0 ? rate : 0.0, early.y);
    w.slope = -w.slope;
    w.variance = (1.0 - seen * seen) * height * height * rate * rate * 0.627 * (1.0 / front + 1.0 / back);
    w.depth = w.height - ground;

    float trail = u < 0.0 ? exp(-u * u / (0.6 * front * front)) : exp(-u / 0.2);
    float edge = exp(-max(w.depth, 0.0) / 0.035);
    float phase = fract(shore.swell.x + early.x);
    w.foam = 1.0 - (1.0 - 0.95 * breaking * trail * smoothstep(0.0, 0.25, film)) * (1.0 - edge * mix(0.9, 0.45, phase));
    return w;
}

vec2 shore_hash(const ivec2 cell) {
    uvec2 v = uvec2(cell) * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> 16u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> 16u;
    return vec2(v >> 8u) / 16777216.0;
}

// Returns the distance to the nearest border between bubbles. There is one bubble per unit square.
float shore_bubbles(const vec2 p) {
    ivec2 cell = ivec2(floor(p));
    float first = 9.0, second = 9.0;
    for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
            ivec2 c = cell + ivec2(i, j);
            float d = distance(p, vec2(c) + 0.1 + 0.8 * shore_hash(c));
            second = min(second, max(d, first));
            first = min(first, d);
        }
    }
    return second - first;
}

// Returns the foam coverage over `reach` metres. The foam is a lace of bubbles that closes as the foam grows.
float shore_foam(const ShoreWater w, const float reach) {
    if (w.foam < 0.02) {
        return 0.0;
    }
    // The foam is torn into patches and stretched along the coast.
    float patches = 0.5 + 0.25 * sin(1.9 * w.drift.x + 1.3 * sin(0.8 * w.drift.y)) + 0.25 * sin(1.1 * w.drift.y - 0.9 * w.drift.x + 2.0 * sin(0.5 * w.drift.x));
    float wide = clamp(w.foam * (0.45 + 0.9 * patches), 0.0, 1.0), covered = 0.0;
    for (int octave = 0; octave < 3; ++octave) {
        float size = octave == 0 ? 0.42 : (octave == 1 ? 0.19 : 0.07);
        vec2 bent = w.drift + 0.35 * size * sin(w.drift.yx * (2.3 / size) + vec2(0.0, 1.7));
        float blur = 0.1 + reach / size;
        float lace = 1.0 - smoothstep(wide - blur, wide + blur, shore_bubbles(bent * vec2(1.0, 0.7) / size));
        covered += (octave == 0 ? 0.4 : 0.3) * mix(lace, 1.0 - exp(-3.0 * wide), clamp(reach / size - 0.3, 0.0, 1.0));
    }
    return covered * min(6.0 * w.foam, 1.0);
}

#endif
