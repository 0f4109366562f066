#ifndef LEADR_HORIZON_GLSL
#define LEADR_HORIZON_GLSL

#include "../frame.glsl"
#include "../integrals/sh.glsl"
#include "../slopes/grid.glsl"

// Occlusion by the bumps around a point (crates/leadr-reflectance/src/visible/horizon.rs). For every azimuth v, a unit vector in the
// tangent plane, the tangent of the horizon's elevation is
//     T(v) = m.v + lean.v + sqrt(v^T spread v)
// where m is the mean slope, since the plane of m hides everything below it. A change of coordinates transforms `lean` like a mean slope
// and `spread` like a covariance. `lean` scales with the heights, and `spread` scales with their square.
struct Horizon {
    vec2 lean;
    vec3 spread; // xx, yy, xy
};

// Returns the height of the horizon above the plane of the mean slope, at the distance |v|. The result is never negative.
float horizon_excess(const vec2 v, const Horizon h) {
    float square = v.x * v.x * h.spread.x + v.y * v.y * h.spread.y + 2.0 * v.x * v.y * h.spread.z;
    return max(dot(h.lean, v) + sqrt(max(square, 0.0)), 0.0);
}

// The standard deviation between the elevations of the true horizon and of this smooth form, in units of the horizon's excess.
const float LEADR_HORIZON_RAGGED = 0.13;

// Returns the fraction, 0..1, of a lobe of light about wi that reaches the point, relative to the fraction above the plane of the mean
// slope m. deviation is the standard deviation of the lobe about wi, in radians.
float horizon_visibility(const vec3 wi, const vec2 m, const Horizon h, const float deviation) {
    float plane = wi.z - dot(wi.xy, m);
    float excess = horizon_excess(wi.xy, h);
    // Angles are converted to heights by 1 + tan^2 of the elevation, at the distance |wi.xy|.
    float flat_squared = max(dot(wi.xy, wi.xy), 1e-12);
    float high = wi.z - plane + excess;
    float ragged = LEADR_HORIZON_RAGGED * excess;
    float width = 2.2360680 * sqrt(deviation * deviation * (1.0 + high * high / flat_squared) + ragged * ragged + 1e-12);
    return smoothstep(-width, width, plane - excess) / max(smoothstep(-width, width, plane), 1e-3);
}

// Returns a horizon whose excess over the plane of the mean slope is multiplied by `factor`.
Horizon raised_horizon(const Horizon h, const float factor) {
    return Horizon(h.lean * factor, h.spread * (factor * factor));
}

const int LEADR_HORIZON_AXES = 4; // number of pairs of opposite azimuths

// The directions between the plane of the mean slope and the horizon, which are hidden from the point.
struct Hidden {
    vec3 weight; // 1/pi times the integral of the hidden directions; its dot product with a normal is their irradiance over pi
    float angle; // 1/pi times the solid angle of the hidden directions
};

Hidden horizon_hidden(const vec2 m, const Horizon h) {
    Hidden hidden = Hidden(vec3(0.0), 0.0);
    for (int k = 0; k < 2 * LEADR_HORIZON_AXES; ++k) {
        float azimuth = LEADR_PI * (float(k) + 0.5) / float(LEADR_HORIZON_AXES);
        vec2 v = vec2(cos(azimuth), sin(azimuth));
        float low = dot(m, v), excess = horizon_excess(v, h), high = low + excess;
        vec2 per = 1.0 / (1.0 + vec2(low * low, high * high));
        float between = atan(excess, 1.0 + low * high); // the angle between the two elevations
        hidden.weight += vec3((between - low * per.x + high * per.y) * v, per.x - per.y);
        hidden.angle += 2.0 * (high * sqrt(per.y) - low * sqrt(per.x));
    }
    float each = 0.5 / float(LEADR_HORIZON_AXES);
    return Hidden(hidden.weight * each, hidden.angle * each);
}

// Subtracts the hidden directions from the diffuse radiance `whole` of an environment, per unit of albedo. Hidden directions have the
// radiance of their mean direction. `open` is the fraction of the facets that are open to the environment. Order 2 overshoots, but a pit
// with some visible sky is never black. Therefore, the result is at least half of the value under a constant environment. c has the
// coefficients of the radiance in world space, and f is the tangent frame in world space.
vec3 diffuse_past_horizon(const vec3 whole, const float open, const Hidden hidden, const vec2 m, const Frame f, const vec3 c[9]) {
    vec3 mean = hidden.weight / max(hidden.angle, 1e-6); // mean of the hidden directions, a vector inside the unit sphere
    float share = clamp(dot(hidden.weight, normal_of_slope(m)), 0.0, 1.0);
    vec3 lost = open * share * max(sh_radiance(c, from_frame(f, mean)), 0.0);
    return max(whole - lost, 0.5 * (1.0 - share) * max(whole, 0.0));
}

#endif
