#ifndef LEADR_HALF_DIFFERENCE_GLSL
#define LEADR_HALF_DIFFERENCE_GLSL

// Rusinkiewicz' parameterisation of a pair of directions by half vector and difference (thesis eq. 1.8).

struct HalfDifference {
    vec3 wh; // half vector, unit
    vec3 wd; // wi in the frame in which wh is the z axis: Rot_y(-theta_h) Rot_z(-phi_h) wi; wd.z = cos(theta_d)
};

// Returns (sin(theta), cos(phi), sin(phi)) of a direction, with phi = 0 at the poles.
vec3 direction_angles(const vec3 w) {
    float sine = sqrt(w.x * w.x + w.y * w.y);
    return sine < 1e-18 ? vec3(0.0, 1.0, 0.0) : vec3(sine, w.xy / sine);
}

// Converts two directions to half vector and difference. Opposite directions have no half vector, so the highest direction orthogonal to wi
// replaces it.
HalfDifference directions_to_half_difference(const vec3 wo, const vec3 wi) {
    vec3 sum = wi + wo;
    float length2 = dot(sum, sum);
    // sum is (|sum|^2 / 2) wi plus a vector orthogonal to wi. For a short sum, the first term is lost in rounding.
    vec3 across = sum - dot(sum, wi) * wi;
    vec3 a = direction_angles(wi);
    vec3 wh = length2 > 1.0 ? sum * inversesqrt(length2)
        : dot(across, across) > 1e-36 ? normalize(across + 0.5 * length2 * wi) : vec3(-wi.z * a.yz, a.x);
    a = direction_angles(wh);
    float x = a.y * wi.x + a.z * wi.y;
    float y = a.y * wi.y - a.z * wi.x;
    return HalfDifference(wh, vec3(wh.z * x - a.x * wi.z, y, a.x * x + wh.z * wi.z));
}

void half_difference_to_directions(const HalfDifference p, out vec3 wo, out vec3 wi) {
    vec3 a = direction_angles(p.wh);
    float x = p.wh.z * p.wd.x + a.x * p.wd.z;
    wi = vec3(a.y * x - a.z * p.wd.y, a.z * x + a.y * p.wd.y, p.wh.z * p.wd.z - a.x * p.wd.x);
    wo = 2.0 * p.wd.z * p.wh - wi;
}

#endif
