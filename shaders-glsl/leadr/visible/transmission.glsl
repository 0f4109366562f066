#ifndef LEADR_TRANSMISSION_GLSL
#define LEADR_TRANSMISSION_GLSL

// Computes light that passes through a surface. crates/leadr-reflectance/src/visible/transmission.rs has the derivation.

// Returns the cosine inside a medium of the relative index eta for the cosine outside, or 0 at total reflection.
float refracted_cosine(const float cosine, const float eta) {
    return sqrt(max(1.0 - max(1.0 - cosine * cosine, 0.0) / (eta * eta), 0.0));
}

// Returns the direction in which light from w continues behind a facet of normal n (Walter et al. 2007, eq. 40). eta is the index behind the
// facet divided by the index before it. At total reflection, the direction is tangential.
vec3 refracted(const vec3 w, const vec3 n, const float eta) {
    float cosine = dot(w, n);
    return normalize((cosine / eta - refracted_cosine(cosine, eta)) * n - w / eta);
}

// Returns the direction of a ray behind a solid body, whose far side is that of a sphere about the mean normal n. A facet refracts the ray
// from w into the body.
vec3 passed_solid(const vec3 w, const vec3 facet, const vec3 n, const float eta) {
    vec3 t = refracted(w, facet, eta);
    vec3 outer = n - 2.0 * dot(t, n) * t;
    float cosine = dot(t, outer);
    vec3 inside = t - cosine * outer + max(cosine, sqrt(max(1.0 - 1.0 / (eta * eta), 0.0))) * outer;
    return refracted(-normalize(inside), -outer, 1.0 / eta);
}

// Returns the variance per axis of light that has passed one interface whose facets have this slope variance per axis.
float refracted_variance(const float variance, const float cosine, const float eta) {
    float turn = eta * refracted_cosine(cosine, eta) - cosine;
    return variance * turn * turn / max(cosine, 1e-2);
}

// Returns the variance per axis of light that has passed a thin wall of this roughness.
float thin_variance(const float alpha, const float cosine) {
    return 2.0 * alpha * alpha * cosine;
}

// Returns the fraction of light that a medium lets pass. extinction is per metre, and length in metres (Beer and Lambert).
vec3 attenuation(const vec3 extinction, const float length) {
    return exp(-extinction * length);
}

#endif
