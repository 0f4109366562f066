#ifndef LEADR_SH_GLSL
#define LEADR_SH_GLSL

// Real spherical harmonics up to order 2 (Ramamoorthi & Hanrahan 2001), with coefficients in the order L00, L1-1, L10, L11, L2-2, L2-1,
// L20, L21, L22. Directions and coefficients must be in the same frame. In this library, this is world space.

float[9] sh_basis(const vec3 d) {
    return float[9](0.28209479, 0.48860251 * d.y, 0.48860251 * d.z, 0.48860251 * d.x, 1.09254843 * d.x * d.y,
                    1.09254843 * d.y * d.z, 0.31539157 * (3.0 * d.z * d.z - 1.0), 1.09254843 * d.x * d.z,
                    0.54627422 * (d.x * d.x - d.y * d.y));
}

// Returns the radiance from direction d. If d is the mean of several directions, it is shorter than 1 and the terms of order 1 and 2 are
// smaller.
vec3 sh_radiance(const vec3 c[9], const vec3 d) {
    vec3 q = d * d;
    return 0.28209479 * c[0] + 0.48860251 * (c[1] * d.y + c[2] * d.z + c[3] * d.x)
         + 1.09254843 * (c[4] * (d.x * d.y) + c[5] * (d.y * d.z) + c[7] * (d.x * d.z))
         + c[6] * (0.31539157 * (2.0 * q.z - q.x - q.y)) + c[8] * (0.54627422 * (q.x - q.y));
}

// Adds a light from the unit direction wi. `irradiance` is its irradiance on a plane facing it (LEADR Algorithm 2). By an erratum, that
// equation of the paper has L00 on both sides.
void sh_add_light(inout vec3 c[9], const vec3 wi, const vec3 irradiance) {
    float basis[9] = sh_basis(wi);
    for (int i = 0; i < 9; ++i) c[i] += basis[i] * irradiance;
}

// Returns the irradiance from radiance coefficients c, averaged over normals with the mean n and the second moments diag = E[xx, yy, zz],
// off = E[yz, xz, xy]. The factors A_l of the cosine convolution are pi, 2 pi/3 and pi/4. The result is linear in the moments. The elements
// of diag must sum to 1.
vec3 sh_irradiance_moments(const vec3 c[9], const vec3 n, const vec3 diag, const vec3 off) {
    return 0.88622693 * c[0] + 1.02332671 * (c[3] * n.x + c[1] * n.y + c[2] * n.z)
         + 0.85808553 * (c[4] * off.z + c[7] * off.y + c[5] * off.x)
         + c[6] * (0.74312386 * diag.z - 0.24770795) + c[8] * (0.42904277 * (diag.x - diag.y));
}

// Returns the irradiance on a plane of unit normal n.
vec3 sh_irradiance(const vec3 c[9], const vec3 n) {
    return sh_irradiance_moments(c, n, n * n, n.yzx * n.zxy);
}

// Returns the order-2 irradiance from one light of unit irradiance, as a polynomial of the cosine. The result equals that of sh_add_light
// followed by sh_irradiance.
float sh_irradiance_light(const float cosine) {
    return 0.09375 + cosine * (0.5 + 0.46875 * cosine);
}

// Returns the clamped cosine minus its order-2 part.
float sh_irradiance_rest(const float cosine) {
    return max(cosine, 0.0) - sh_irradiance_light(cosine);
}

// Returns the damping factor of irradiance of orders above 2, for normals with the mean n. The factor is exact for the lowest band, 4, if
// diffusion spreads the normals.
float sh_rest_damping(const vec3 n) {
    float square = min(dot(n, n), 1.0), fourth = square * square;
    return fourth * fourth * square;
}

#endif
