// Random draws for the reference: points of a square, visible specular directions, and directions on a hemisphere.
#ifndef LEADR_SHADE_DRAWS
#define LEADR_SHADE_DRAWS
#include "leadr/facets/beckmann.glsl"
#include "leadr/facets/beckmann_sampling.glsl"
#include "leadr/facets/projected_area.glsl"
#include "leadr/frame.glsl"
#include "leadr/visible/specular.glsl"

// The solid angle over which a drawn specular direction averages the environment, relative to its share of the lobe among the draws of one
// sample. The draws of all samples overlap, so a fraction suffices. A smaller fraction widens the lobe less.
const float DRAW_WIDTH = 0.125;

uint mixed_bits(uint x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// Applies Owen scrambling to the binary digits, from the highest bit: the digits before a digit decide whether it is flipped. The method
// uses products with even numbers, which carry only upwards (Laine and Karras, "Stratified Sampling for Stochastic Transparency", 2011).
uint owen_scrambled(uint x, const uint seed) {
    x = bitfieldReverse(x) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return bitfieldReverse(x);
}

// Returns point `index` of a sequence in the unit square: the first two Sobol dimensions, scrambled by `seed`. If the square is divided
// into 2^n equal boxes of any shape, each box contains one of the first 2^n points.
vec2 drawn_point(const uint index, const uint seed) {
    uint second = 0u, direction = 0x80000000u;
    for (int bit = 0; bit < 32; ++bit) {
        second ^= (index >> bit & 1u) != 0u ? direction : 0u;
        direction ^= direction >> 1;
    }
    uvec2 digits = uvec2(owen_scrambled(bitfieldReverse(index), mixed_bits(seed)),
                         owen_scrambled(second, mixed_bits(seed ^ 0x9e3779b9u)));
    return (vec2(digits >> 8) + 0.5) / 16777216.0;
}

// The kind of the draws that choose a facet. Lower kinds are for specular directions, the hemisphere, and lights.
const uint FACET_DRAW = 0x100u;

// Returns the seed of a pixel for one kind of draws.
uint draw_seed(const uvec2 pixel, const uint seed, const uint kind) {
    return mixed_bits(pixel.x + mixed_bits(pixel.y + mixed_bits(seed + mixed_bits(kind))));
}

struct DrawnReflection {
    vec3 wi;       // direction that reflects towards wo, in the tangent frame
    float cosine;  // cosine between wo and the half vector
    float density; // density of wi per solid angle
};

// Returns the density per solid angle of wi among the specular directions visible from wo.
float specular_density(const vec3 wo, const vec3 wi, const vec2 m, const vec3 S, const float visible) {
    vec3 h = wo + wi;
    return 0.25 * beckmann_ndf_over(h * inversesqrt(max(dot(h, h), 1e-20)), m, S, max(visible, LEADR_MIN_AREA));
}

DrawnReflection drawn_reflection(const vec3 wo, const vec2 u, const vec2 m, const vec3 S, const float visible) {
    vec3 wn = beckmann_sample_visible(wo, u, m, S);
    float cosine = max(dot(wo, wn), 0.0);
    float density = 0.25 * beckmann_ndf_over(wn, m, S, max(visible, LEADR_MIN_AREA));
    return DrawnReflection(2.0 * cosine * wn - wo, cosine, density);
}

// Returns the solid angle over which one of `count` draws of this density averages the environment.
float drawn_solid_angle(const float density, const int count) {
    return DRAW_WIDTH / (float(count) * max(density, 1e-9));
}

// Returns a direction about the normal z, drawn with the density cosine / pi.
vec3 drawn_cosine(const vec2 u) {
    float r = sqrt(u.x), phi = 6.28318531 * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

#endif
