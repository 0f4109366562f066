// Maps linear radiance, after exposure, to linear display light, like crates/leadr-maps/src/tonemap.rs.
#ifndef PASSES_TONEMAP
#define PASSES_TONEMAP

const int TONEMAP_CLAMP = 0;
const int TONEMAP_FILMIC = 1;
const int TONEMAP_ACES = 2;
const int TONEMAP_AGX = 3;

// Applies Narkowicz's filmic fit to each channel.
vec3 filmic(const vec3 x) {
    return min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
}

// Applies Hill's fit of the ACES reference rendering. The matrices are written by columns.
vec3 aces(const vec3 x) {
    const mat3 into = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 out_of = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    vec3 v = into * (2.01 * x);
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);
    return clamp(out_of * v, 0.0, 1.0);
}

// Applies AgX in Wrensch's polynomial form, with its "punchy" grade.
vec3 agx(const vec3 x) {
    const mat3 into = mat3(0.84247906, 0.042328242, 0.042375655, 0.0784336, 0.87846864, 0.0784336, 0.079223745, 0.07916613, 0.879143);
    const mat3 out_of = mat3(1.196879, -0.05289685, -0.05297164, -0.09802088, 1.1519031, -0.09804345, -0.09902974, -0.09896118, 1.1510737);
    vec3 v = into * (2.24 * x);
    v = clamp((log2(clamp(v, 1e-10, 1e10)) + 12.47393) / 16.499999, 0.0, 1.0);
    v = (((((15.5 * v - 40.14) * v + 31.96) * v - 6.868) * v + 0.4298) * v + 0.1191) * v - 0.00232;
    v = pow(max(v, 0.0), vec3(1.35));
    v = mix(vec3(dot(v, vec3(0.2126, 0.7152, 0.0722))), v, 1.4);
    return pow(clamp(out_of * v, 0.0, 1.0), vec3(2.2));
}

vec3 display_light(const int tonemap, const vec3 radiance) {
    vec3 x = clamp(radiance, 0.0, 1e4);
    if (tonemap == TONEMAP_FILMIC) return filmic(x);
    if (tonemap == TONEMAP_ACES) return aces(x);
    if (tonemap == TONEMAP_AGX) return agx(x);
    return min(x, 1.0);
}

// Offsets of a pixel's codes before rounding, from -0.5 to 0.5 codes.
vec3 dither(const uvec2 pixel) {
    uint first = pixel.x * 0xc13fa9a9u + pixel.y * 0x91e10da5u;
    return vec3((uvec3(first) + uvec3(0u, 0x55555555u, 0xaaaaaaaau)) >> 8) / 16777216.0 - 0.5;
}

#endif
