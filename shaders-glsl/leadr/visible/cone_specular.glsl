#ifndef LEADR_CONE_SPECULAR_GLSL
#define LEADR_CONE_SPECULAR_GLSL

#include "../masking/occlusion.glsl"

// Computes the fraction of the specular light that comes from within a cone (crates/leadr-reflectance/src/visible/cone_specular.rs).
// occlusion.glsl defines the cones.

// Returns the fraction of a GGX lobe within a cone of half angle `angle`. `apart` is the angle between the axes of cone and lobe. All
// angles are in radians.
float lobe_in_cone(const float alpha, const float apart, const float angle) {
    vec2 ends = 0.5 * vec2(apart + angle, apart - angle);
    vec2 s = sin(ends), c = max(alpha, 1e-4) * max(cos(ends), 0.0);
    float cap = 0.5 * (atan(s.x, max(c.x, 1e-30)) - atan(s.y, max(c.y, 1e-30)));
    return sin(cap) * sin(cap);
}

// Returns the mean reflected direction of a rough surface. A viewer below the horizon is moved onto the horizon.
vec3 lobe_axis(const float alpha, const vec3 wo) {
    float keep = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
    vec3 axis = vec3(0.0, 0.0, 1.0) + keep * (vec3(-wo.xy, max(wo.z, 0.0)) - vec3(0.0, 0.0, 1.0));
    return axis / max(length(axis), 1e-6);
}

// Returns the fraction of the lobe about `mirror` within a cone. The lobe is narrower across the plane of incidence.
float cone_share(const float alpha, const float cosine, const vec3 mirror, const vec3 axis, const float angle) {
    float along = dot(mirror, axis);
    vec3 across = axis - mirror * along;
    // The two distances are in the plane of incidence and across this plane.
    float flatness = dot(mirror.xy, mirror.xy);
    vec2 outward = mirror.xy * inversesqrt(max(flatness, 1e-20));
    float within = dot(outward, across.xy) * mirror.z - sqrt(flatness) * across.z;
    float beside = (outward.x * across.y - outward.y * across.x) * cosine;
    float sine = sin(angle);
    float away = dot(across, across), wide = 0.2 * sine * sine;
    float inside = flatness < 1e-8 ? away : within * within + beside * beside;
    float narrow = alpha * sqrt((inside + wide * cosine) / max(away + wide, 1e-12));
    float l = sqrt(away);
    return lobe_in_cone(narrow, atan(l, l == 0.0 && along == 0.0 ? 1.0 : along), angle);
}

// Returns the fraction of the specular reflection towards wo that comes from within the cone, 0..1.
float cone_specular(const float alpha, const vec3 wo, const vec4 cone) {
    float c = clamp(wo.z, 0.0, 1.0), a = clamp(alpha, 1e-4, 1.0);
    vec3 mirror = lobe_axis(a, wo);
    float cosine = clamp(cone.w, 0.0, 1.0);
    float open = cone_share(a, c, mirror, vec3(0.0, 0.0, 1.0), 0.5 * LEADR_PI);
    float angle = atan(cone_root(cosine), max(cosine, 1e-30));
    float overlap = clamp(cone_share(a, c, mirror, cone.xyz, angle) / max(open, 1e-6), 0.0, 1.0);
    float t = clamp((a - 0.2) / 0.7, 0.0, 1.0);
    return overlap + (bent_cone_visibility(cone) - overlap) * (t * t * (3.0 - 2.0 * t));
}

// Returns the texture coordinate in a table of cones (ConeTable, 32 x 32 x 8; listing 5). The sampler must filter linearly and clamp to the
// edge.
vec3 cone_table_texcoord(const float n_v, const float gloss, const float cosine) {
    vec3 size = vec3(32.0, 32.0, 8.0);
    return (clamp(vec3(n_v, gloss, cosine), 0.0, 1.0) * (size - 1.0) + 0.5) / size;
}

#endif
