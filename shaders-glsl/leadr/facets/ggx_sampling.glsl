#ifndef LEADR_GGX_SAMPLING_GLSL
#define LEADR_GGX_SAMPLING_GLSL

#include "projected_area.glsl"
#include "../slopes/grid.glsl"

// Samples visible GGX normals exactly by spherical caps (Dupuy & Benyoub 2023), whether the viewer is above or below the mesosurface.
// crates/leadr-reflectance/src/facets/ggx_sampling.rs has the proof.

// Returns a visible normal for u in [0, 1)^2, distributed as ggx_vndf(wo, wn, m, A).
vec3 ggx_sample_visible(const vec3 wo, vec2 u, const vec2 m, const vec3 A) {
    u.x = clamp(u.x, 0.0, 0.99999994);
    vec3 c = slope_cholesky(vec3(max(A.xy, LEADR_MIN_VARIANCE), A.z));
    // o = (t, a) / |(t, a)| is the direction to the viewer on the standard surface.
    vec2 t = vec2(c.x * wo.x + c.y * wo.y, c.z * wo.y);
    float a = meso_area(wo, m);
    float b = length(t);
    vec2 e = b > 1e-18 ? t / b : vec2(1.0, 0.0);
    float top = max(max(abs(a), b), 1e-18);
    float len = top * length(vec2(a, b) / top);
    float cosine = a / len;
    float sine = b / len;
    float above = max(a > 0.0 ? 1.0 + cosine : sine * (b / (len - a)), 1e-12); // 1 + o.z
    float below = a > 0.0 ? sine * (b / (len + a)) : 1.0 - cosine;             // 1 - o.z
    // i is uniform in the cap i.z > -o.z. This form of h = i + o avoids cancellation when i is nearly opposite to o.
    float height = (1.0 - u.x) * above;
    float sine_i = sqrt(u.x * above * (height + below));
    float half_cos = sin(LEADR_PI * (0.5 - u.y));
    float half_sin = cos(LEADR_PI * (0.5 - u.y));
    float along = height * (below - u.x * above) / max(sine + sine_i, 1e-18) + 2.0 * sine_i * half_cos * half_cos;
    float across = 2.0 * sine_i * half_sin * half_cos;
    vec2 h = vec2(e.x * along - e.y * across, e.y * along + e.x * across);
    // The result is the slope m + C (-h / height), multiplied by -height. h is scaled first, because some devices flush the squares of very
    // small values to 0.
    vec3 along_normal = vec3(vec2(c.x * h.x, c.y * h.x + c.z * h.y) - m * height, height);
    return normalize(along_normal / max(max(abs(along_normal.x), abs(along_normal.y)), height));
}

#endif
