#ifndef LEADR_VISIBLE_DIFFUSE_GLSL
#define LEADR_VISIBLE_DIFFUSE_GLSL

#include "../integrals/diffuse.glsl"
#include "slopes.glsl"

// Computes the diffuse reflection of the visible facets without a grid. With N = (-slope, 1) and n = N / |N|, only the factor
// |N| prevents closed forms. Its inverse is close to a sum of two or three exponentials of |N|^2. An exponential of |N|^2 times
// a Gaussian of slopes is another Gaussian of slopes, whose clamped moments have closed forms. The constants are a
// least-squares fit (examples/11_fit_diffuse_terms.rs) over random surfaces; on flat surfaces the result is exact. terms is 2
// (error 1.2e-3 rms of mean radiance) or 3 (2e-4). Pass a constant to let loops unroll.

// Each row has an exponent, its weight in 1/|N|, and its weight in 1/|N|^2 (in any scale). Each value is linear in the relative spread of
// |N|^2.
vec4 visible_diffuse_exponent(const int i, const int terms) { // (exponent and its slope, weight of 1/|N| and its slope)
    const vec4 two[2] = vec4[2](vec4(0.22494464, -0.0331644, 1.06858219, -0.00712735),
                                vec4(2.04868504, 0.81002255, 1.1378407, 0.80030971));
    const vec4 three[3] = vec4[3](vec4(0.14774869, -0.02798132, 0.88324551, -0.06272688),
                                  vec4(1.51173948, 0.09430317, 1.05317881, 0.31866379),
                                  vec4(5.97573614, 3.11562463, 2.29040276, 0.48355783));
    return terms == 2 ? two[min(i, 1)] : three[i];
}

vec2 visible_diffuse_second(const int i, const int terms) { // (weight of 1/|N|^2 and its slope)
    const vec2 two[2] = vec2[2](vec2(1.0, -0.48494877), vec2(4.51732387, 0.43471584));
    const vec2 three[3] = vec2[3](vec2(1.0, -0.26540236), vec2(4.4142949, 1.2978556), vec2(19.03758878, 4.88965078));
    return terms == 2 ? two[min(i, 1)] : three[i];
}

// Returns the mean of |N|^2, and the standard deviation divided by the mean, for slopes of mean m and covariance S.
vec2 squared_normal_spread(const vec2 m, const vec3 S) {
    float mean = 1.0 + dot(m, m) + S.x + S.y;
    float variance = 4.0 * (S.x * m.x * m.x + S.y * m.y * m.y + 2.0 * S.z * m.x * m.y)
                   + 2.0 * (S.x * S.x + S.y * S.y + 2.0 * S.z * S.z);
    return vec2(mean, sqrt(max(variance, 0.0)) / mean);
}

// The product exp(-t |N|^2) P22(m, S). It is written as a weight times a Gaussian of mean m and covariance S.
struct SlopeGaussian {
    float weight;
    vec2 m;
    vec3 S;
};

// Returns the exact product for t >= 0.
SlopeGaussian damped_gaussian(const vec2 m, const vec3 S, const float t) {
    float tt = 2.0 * t;
    float det = max(S.x * S.y - S.z * S.z, 0.0);
    float scale = 1.0 + tt * (S.x + S.y + tt * det);
    float per = 1.0 / scale;
    vec2 mean = per * (m + tt * vec2(S.y * m.x - S.z * m.y, S.x * m.y - S.z * m.x));
    vec3 cov = per * (S + vec3(tt * det, tt * det, 0.0));
    return SlopeGaussian(exp(-t * (1.0 + dot(m, mean))) * sqrt(per), mean, cov);
}

// Returns E[max(0, x)] of a normal variable x of mean a and standard deviation b. For a(w) and b(w), the result is A(w).
float clamped_mean(const float a, const float b) {
    return max(a, 0.0) + rough_area(a, b);
}

// Returns the moments of the normals visible from wo, like visible_normal_moments.
NormalMoments visible_diffuse_moments(const vec3 wo, vec2 m, vec3 S, const int terms) {
    S = clamp_covariance(S);
    float ao = tilted_area(wo, m, slope_spread(wo, S));
    m = face_viewer(wo, m, S, 2.0 * LEADR_VISIBLE_TAIL);
    vec2 spread = squared_normal_spread(m, S);
    vec3 first = vec3(0.0), diag = vec3(0.0), off = vec3(0.0);
    for (int i = 0; i < terms; ++i) {
        vec4 e = visible_diffuse_exponent(i, terms);
        vec2 second = visible_diffuse_second(i, terms);
        float t = (e.x + e.y * spread.y) / spread.x;
        SlopeGaussian g = damped_gaussian(m, S, t);
        vec2 across = vec2(g.S.x * wo.x + g.S.z * wo.y, g.S.z * wo.x + g.S.y * wo.y);
        float b = sqrt(max(dot(across, wo.xy), 0.0));
        float per_b = 1.0 / max(b, 1e-18);
        float a = ao + 2.0 * t * dot(across, m); // equals meso_area(wo, g.m), but without cancellation
        NormalRamp n = normal_ramp(a * per_b);
        vec2 axis = across * per_b;
        float area = b > 1e-18 ? b * n.ramp : max(a, 0.0);
        // The integrals are over the clamped facet areas: E[1] = area, E[slope] = m area - across Phi, and so on.
        vec2 slope = g.m * area - across * n.cdf;
        float c = g.weight * (e.z + e.w * spread.y);
        float d = g.weight * (second.x + second.y * spread.y);
        first += c * vec3(-slope, area);
        vec2 twice = slope - across * n.cdf;
        float bend = b * n.pdf;
        diag += d * vec3(g.m * twice + g.S.xy * area + axis * axis * bend, area);
        off += d * vec3(-slope.yx, g.m.x * slope.y - across.x * g.m.y * n.cdf + g.S.z * area + axis.x * axis.y * bend);
    }
    // The first moments are divided by the visible area. The second moments are scaled to a trace of one.
    float second_scale = 1.0 / max(diag.x + diag.y + diag.z, 1e-30);
    float area = max(clamped_mean(ao, slope_spread(wo, S)), 1e-30);
    return NormalMoments(first / (area * sqrt(spread.x)), diag * second_scale, off * second_scale);
}

// Returns E[max(0, x) max(0, y)] of two normal variables with means ax and ay, standard deviations bx and by, and covariance k. By
// Plackett's identity, its second derivative with respect to the correlation is the bivariate density at 0. A Gauss-Jacobi rule integrates
// this density.
float clamped_product(const float ax, const float bx, const float ay, const float by, const float k) {
    float px = 1.0 / max(bx, 1e-18), py = 1.0 / max(by, 1e-18);
    float x = ax * px, y = ay * py;
    NormalRamp nx = normal_ramp(x), ny = normal_ramp(y);
    float area_x = bx > 1e-18 ? bx * nx.ramp : max(ax, 0.0);
    float area_y = by > 1e-18 ? by * ny.ramp : max(ay, 0.0);
    float r = clamp(k * px * py, -1.0, 1.0);
    // Beyond 13 standard deviations, the density is 0 in 32 bits.
    x = clamp(x, -13.0, 13.0);
    y = clamp(y, -13.0, 13.0);
    const vec2 at = vec2(0.15505103, 0.64494897), weight = vec2(0.05061786, 0.02895961); // the weights, divided by 2 pi
    vec2 t = at * r, per = inversesqrt(1.0 - t * t);
    vec2 density = per * exp(-0.5 * (x * x + y * y - 2.0 * x * y * t) * per * per);
    return max(area_x * area_y + k * (nx.cdf * ny.cdf + r * dot(weight, density)), 0.0);
}

// Returns the radiance under one light from wi (tangent frame), whose irradiance on a plane facing it is 1, per unit of albedo. The clamped
// cosine is integrated over the visible facets (LEADR eq. 21 without harmonics).
float leadr_diffuse_light_visible(const vec3 wo, const vec3 wi, vec2 m, vec3 S, const bool shadowing, const int terms) {
    S = clamp_covariance(S);
    float ao = tilted_area(wo, m, slope_spread(wo, S));
    m = face_viewer(wo, m, S, 2.0 * LEADR_VISIBLE_TAIL);
    vec2 spread = squared_normal_spread(m, S);
    float sum = 0.0;
    for (int i = 0; i < terms; ++i) {
        vec4 e = visible_diffuse_exponent(i, terms);
        float t = (e.x + e.y * spread.y) / spread.x;
        SlopeGaussian g = damped_gaussian(m, S, t);
        vec2 across = vec2(g.S.x * wo.x + g.S.z * wo.y, g.S.z * wo.x + g.S.y * wo.y);
        float bo = sqrt(max(dot(across, wo.xy), 0.0));
        float bi = slope_spread(wi, g.S);
        sum += g.weight * (e.z + e.w * spread.y)
             * clamped_product(ao + 2.0 * t * dot(across, m), bo, meso_area(wi, g.m), bi, dot(across, wi.xy));
    }
    float mean = sum / (max(clamped_mean(ao, slope_spread(wo, S)), 1e-30) * sqrt(spread.x));
    return shadowing_given_masking(wo, wi, m, S, shadowing) * mean / LEADR_PI;
}

#endif
