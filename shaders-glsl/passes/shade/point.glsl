// Point lights and spots.
#ifndef LEADR_SHADE_POINT
#define LEADR_SHADE_POINT

// Returns the fraction of a point light's intensity that reaches a point. Spots fade out at the rim of their cone, and lights with a range
// fade out at the end of the range, as KHR_lights_punctual recommends. towards is the unit vector to the light, square is the squared
// distance, and falloff is PointLight::falloff.
float point_reach(const vec3 towards, const float square, const vec4 falloff, const float inverse_square_range) {
    float cone = clamp(dot(-towards, falloff.xyz) + falloff.w, 0.0, 1.0);
    float part = square * inverse_square_range;
    return cone * cone * clamp(1.0 - part * part, 0.0, 1.0);
}

#endif
