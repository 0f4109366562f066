#ifndef LEADR_NORMAL_LENGTH_GLSL
#define LEADR_NORMAL_LENGTH_GLSL

// Computes the mean length of the normals N = (-slope, 1) of Gaussian slopes, and of its inverse.
// crates/leadr-reflectance/src/facets/normal_length.rs gives the errors.

// Returns the mean of |N|^2, and the square of its standard deviation divided by its mean.
vec2 squared_normal_length(const vec2 m, const vec3 S) {
    float mean = 1.0 + dot(m, m) + S.x + S.y;
    float variance = 4.0 * (S.x * m.x * m.x + S.y * m.y * m.y + 2.0 * S.z * m.x * m.y)
                   + 2.0 * (S.x * S.x + S.y * S.y + 2.0 * S.z * S.z);
    float per = 1.0 / mean;
    return vec2(mean, max(variance, 0.0) * per * per);
}

// Returns E[|N|], the area of the facets per unit of macrosurface.
float mean_normal_length(const vec2 m, const vec3 S) {
    vec2 square = squared_normal_length(m, S);
    return sqrt(square.x) / (1.0 + 0.107 * square.y);
}

// Returns E[1/|N|], the mean cosine between a facet and the macrosurface.
float mean_inverse_normal_length(const vec2 m, const vec3 S) {
    vec2 square = squared_normal_length(m, S);
    return (1.0 + 0.35 * square.y) * inversesqrt(square.x);
}

#endif
