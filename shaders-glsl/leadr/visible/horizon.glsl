#ifndef LEADR_HORIZON_GLSL
#define LEADR_HORIZON_GLSL

#include "../frame.glsl"
#include "../integrals/sh.glsl"
#include "../slopes/grid.glsl"

// Occlusion by the bumps around a point (crates/leadr-reflectance/src/visible/horizon.rs). For every azimuth v (unit, in the tangent
// plane) the tangent of the horizon's elevation is
//     T(v) = m.v + lean.v + sqrt(v^T spread v)
// where m is the mean slope: nothing below its plane is visible in any case. Under a change of coordinates `lean` transforms as a mean
// slope and `spread` as a covariance; they scale with the heights and their square.
struct Horizon {
    vec2 lean;
    vec3 spread; // xx, yy, xy
};

// Height of the horizon above the plane of the mean slope, at the distance |v|. Not negative.
float horizon_excess(const vec2 v, const Horizon h) {
    float square = v.x * v.x * h.spread.x + v.y * v.y * h.spread.y + 2.0 * v.x * v.y * h.spread.z;
    return max(dot(h.lean, v) + sqrt(max(square, 0.0)), 0.0);
}

// Standard deviation of the true horizon's elevation from this smooth form, in units of its excess.
const float LEADR_HORIZON_RAGGED = 0.13;

// Share of a lobe of light about wi that reaches the point, relative to its part above the plane of the mean slope m: 0..1.
// deviation: of the lobe from wi, radians.
float horizon_visibility(const vec3 wi, const vec2 m, const Horizon h, const float deviation) {
    float plane = wi.z - dot(wi.xy, m);
    float excess = horizon_excess(wi.xy, h);
    // From angles to heights: 1 + tan^2 of the elevation, at the distance |wi.xy|.
    float flat_squared = max(dot(wi.xy, wi.xy), 1e-12);
    float high = wi.z - plane + excess;
    float ragged = LEADR_HORIZON_RAGGED * excess;
    float width = 2.2360680 * sqrt(deviation * deviation * (1.0 + high * high / flat_squared) + ragged * ragged + 1e-12);
    return smoothstep(-width, width, plane - excess) / max(smoothstep(-width, width, plane), 1e-3);
}

// The horizon with its excess multiplied by `factor`.
Horizon raised_horizon(const Horizon h, const float factor) {
    return Horizon(h.lean * factor, h.spread * (factor * factor));
}

const int LEADR_HORIZON_AXES = 4; // pairs of opposite azimuths

// The directions between the plane of the mean slope and the horizon, which are hidden.
struct Hidden {
    vec3 weight; // (1/pi) of their sum over solid angle: dot with a normal, their irradiance in units of pi
    float angle; // (1/pi) of their solid angle
};

Hidden horizon_hidden(const vec2 m, const Horizon h) {
    Hidden hidden = Hidden(vec3(0.0), 0.0);
    for (int k = 0; k < 2 * LEADR_HORIZON_AXES; ++k) {
        float azimuth = LEADR_PI * (float(k) + 0.5) / float(LEADR_HORIZON_AXES);
        vec2 v = vec2(cos(azimuth), sin(azimuth));
        float low = dot(m, v), excess = horizon_excess(v, h), high = low + excess;
        vec2 per = 1.0 / (1.0 + vec2(low * low, high * high));
        float between = atan(excess, 1.0 + low * high); // the angle between both elevations
        hidden.weight += vec3((between - low * per.x + high * per.y) * v, per.x - per.y);
        hidden.angle += 2.0 * (high * sqrt(per.y) - low * sqrt(per.x));
    }
    float each = 0.5 / float(LEADR_HORIZON_AXES);
    return Hidden(hidden.weight * each, hidden.angle * each);
}

// Diffuse radiance `whole` of an environment, per unit of albedo, minus the hidden directions, which have the radiance of their
// mean direction; `open`: share of the facets that see the environment. At least half of the value under a constant
// environment, because order 2 overshoots and a pit with some visible sky is never black. c: radiance coefficients in the
// world; f: the tangent frame in the world.
vec3 diffuse_past_horizon(const vec3 whole, const float open, const Hidden hidden, const vec2 m, const Frame f, const vec3 c[9]) {
    vec3 mean = hidden.weight / max(hidden.angle, 1e-6); // of the hidden directions, inside the unit sphere
    float share = clamp(dot(hidden.weight, normal_of_slope(m)), 0.0, 1.0);
    vec3 lost = open * share * max(sh_radiance(c, from_frame(f, mean)), 0.0);
    return max(whole - lost, 0.5 * (1.0 - share) * max(whole, 0.0));
}

#endif
