#ifndef LEADR_SLOPE_PACKING_GLSL
#define LEADR_SLOPE_PACKING_GLSL

#include "../fma.glsl"
#include "moments.glsl"

// Packs slope moments into texels for LEADR, LEAN and three forms of CLEAN. crates/leadr-reflectance/src/slopes/packing.rs
// compares the forms of CLEAN and proves the conservative form.

// Returns the variances of S along its principal axes. The larger variance is first.
vec2 principal_variances(const vec3 S) {
    float h = 0.5 * (S.x - S.y);
    float major = 0.5 * (S.x + S.y) + sqrt(h * h + S.z * S.z);
    return vec2(major, max(fma(S.x, S.y, -S.z * S.z), 0.0) / max(major, 1e-30));
}

// Returns the larger principal variance of the moments, without clamping their correlation.
float major_variance(const SlopeMoments a) {
    vec2 v = max(vec2(fma(-a.first.x, a.first.x, a.second.x), fma(-a.first.y, a.first.y, a.second.y)), 0.0);
    return principal_variances(vec3(v, fma(-a.first.x, a.first.y, a.second.z))).x;
}

// Packs the texels of the two textures of a LEADR map: (E[x], E[y], E[x^2], E[y^2]) and (E[xy], height).
void pack_leadr(const SlopeMoments m, const float height, out vec4 a, out vec2 b) {
    a = vec4(m.first, m.second.xy);
    b = vec2(m.second.z, height);
}
SlopeMoments unpack_leadr(const vec4 a, const vec2 b, out float height) {
    height = b.y;
    return SlopeMoments(a.xy, vec3(a.zw, b.x));
}

// Packs LEAN moments in fixed point: (E[x], E[y], E[x^2], E[y^2], E[xy]) as fractions in 0..1, with slopes in units of `limit`.
float[5] pack_lean(const SlopeMoments a, const float limit) {
    vec2 first = clamp(0.5 + 0.5 * a.first / limit, 0.0, 1.0);
    vec3 second = a.second / (limit * limit);
    second = clamp(vec3(second.xy, 0.5 + 0.5 * second.z), 0.0, 1.0);
    return float[5](first.x, first.y, second.x, second.y, second.z);
}
SlopeMoments unpack_lean(const float p[5], const float limit) {
    return SlopeMoments((vec2(p[0], p[1]) * 2.0 - 1.0) * limit, vec3(p[2], p[3], 2.0 * p[4] - 1.0) * (limit * limit));
}

// Returns the largest error of a variance after pack_lean in fixed point with `levels` steps (255 for 8 bits).
float lean_error(const float limit, const float levels) {
    float q = 1.0 / levels;
    return (3.0 + q) * q * limit * limit;
}

// Packs CLEAN moments as mean slope and one number, in three forms: Baker's form (thesis eq. 3.18), the form with the thesis's larger
// radius, and the conservative form.
vec3 pack_clean(const SlopeMoments a) {
    return vec3(a.first, a.second.x + a.second.y);
}
vec3 pack_clean_major(const SlopeMoments a) {
    return vec3(a.first, dot(a.first, a.first) + 2.0 * major_variance(a));
}
vec3 pack_clean_conservative(const SlopeMoments a) {
    return vec3(a.first, dot(a.first, a.first) + major_variance(a));
}

// Returns the isotropic covariance of packed moments: clean_covariance unpacks the first two forms, and clean_conservative_covariance
// unpacks the third.
vec3 clean_covariance(const vec3 p) {
    return vec3(vec2(0.5 * max(fma(-p.x, p.x, fma(-p.y, p.y, p.z)), 0.0)), 0.0);
}
vec3 clean_conservative_covariance(const vec3 p) {
    return vec3(vec2(max(fma(-p.x, p.x, fma(-p.y, p.y, p.z)), 0.0)), 0.0);
}

#endif
