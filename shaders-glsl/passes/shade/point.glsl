// Point lights and spots.
#ifndef LEADR_SHADE_POINT
#define LEADR_SHADE_POINT

// Fraction of a point light's intensity that reaches a point. Spots fade at the rim of their cone and lights with a range at
// its end, as KHR_lights_punctual recommends. towards: unit, to the light; square: of its distance; falloff:
// PointLight::falloff.
float point_reach(const vec3 towards, const float square, const vec4 falloff, const float inverse_square_range) {
    float cone = clamp(dot(-towards, falloff.xyz) + falloff.w, 0.0, 1.0);
    float part = square * inverse_square_range;
    return cone * cone * clamp(1.0 - part * part, 0.0, 1.0);
}

#endif
