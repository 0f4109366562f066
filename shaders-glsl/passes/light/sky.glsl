// The clear sky of crates/leadr-render/src/light/sky.rs in 32 bits. Names and order of the functions are the same. The Rust file has the
// equations and their sources.
#ifndef SKY_GLSL
#define SKY_GLSL
#include "atmosphere.glsl"

const float PI = 3.14159265358979;

float altitude_along(const float h, const float mu, const float t)
{
    float r = EARTH + h;
    float excess = h * (2.0 * EARTH + h) + t * t + 2.0 * r * t * mu;
    return excess / (sqrt(max(EARTH * EARTH + excess, 0.0)) + EARTH);
}

float distance_to_top(const float h, const float mu)
{
    float r = EARTH + h;
    float gap = (ATMOSPHERE - h) * (2.0 * EARTH + ATMOSPHERE + h);
    float b = r * mu;
    float root = sqrt(b * b + max(gap, 0.0));
    return b > 0.0 ? gap / (root + b) : root - b;
}

float distance_to_ground(const float h, const float mu)
{
    float r = EARTH + h;
    float gap = h * (2.0 * EARTH + h);
    float discriminant = r * r * mu * mu - gap;
    return mu >= 0.0 || discriminant < 0.0 ? -1.0 : gap / (sqrt(discriminant) - r * mu);
}

vec3 densities(float h)
{
    h = max(h, 0.0);
    float ozone = max(1.0 - abs(h - OZONE_CENTRE) / OZONE_HALF_WIDTH, 0.0);
    return vec3(exp(-h / AIR_HEIGHT), exp(-h / HAZE_HEIGHT), ozone);
}

vec3 extinction(const vec3 density, const float haze)
{
    return AIR * density.x + HAZE * (haze * density.y) + OZONE * density.z;
}

vec3 scattering_of_haze(const vec3 density, const float haze) { return HAZE * (HAZE_ALBEDO * haze * density.y); }

vec3 share_within(const vec3 x)
{
    return mix((1.0 - exp(-x)) / max(x, 1e-12), 1.0 - x * (0.5 - x / 6.0), lessThan(x, vec3(1e-2)));
}

vec3 sun_transmittance(const float h, const float mu, const float haze)
{
    float ratio = EARTH / (EARTH + h);
    float horizon = -sqrt(max(1.0 - ratio * ratio, 0.0));
    float risen = clamp((mu - horizon) / (2.0 * SUN_RADIUS) + 0.5, 0.0, 1.0);
    if (risen == 0.0) return vec3(0.0);
    float length = distance_to_top(h, mu);
    vec3 depth = vec3(0.0);
    for (int i = 0; i < SUN_STEPS; ++i) {
        float s = (float(i) + 0.5) / float(SUN_STEPS);
        float dt = 3.0 * s * s * length / float(SUN_STEPS);
        depth += dt * densities(altitude_along(h, mu, length * s * s * s));
    }
    return risen * risen * (3.0 - 2.0 * risen) * exp(-extinction(depth, haze));
}

float phase_of_air(const float nu) { return 3.0 / (16.0 * PI) * (1.0 + nu * nu); }

float phase_of_haze(const float nu)
{
    float g = HAZE_ASYMMETRY;
    float g2 = g * g;
    float base = max(1.0 + g2 - 2.0 * g * nu, 1e-6);
    return 3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + nu * nu) / ((2.0 + g2) * base * sqrt(base));
}

// The tables of the sky, per unit of sunlight above the atmosphere.
struct SkyTables {
    vec4 multiple[ALTITUDES];
    vec4 ground;
    vec4 view[ROWS * COLUMNS * 3]; // light scattered by air, by haze, and more than once
};

#endif
