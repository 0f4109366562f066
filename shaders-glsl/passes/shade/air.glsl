// Haze between the viewer and a distant surface: the light that the air takes is replaced by that of the sky at the horizon.
#ifndef LEADR_SHADE_AIR
#define LEADR_SHADE_AIR

// Clear air in front of the viewer, metres. Objects this near look exactly as without air.
const float CLEAR_AIR = 30.0;

// Radiance of a surface at the end of `reach` (world, metres). extinction: per metre, 0 without an analytic sky; faces: size of
// the cube's faces, whose texels just above the horizon are looked up.
vec3 through_air(const vec3 radiance, const vec3 reach, const vec3 extinction, samplerCube sky, const float face_size) {
    float hazy = extinction.g > 0.0 ? length(reach) - CLEAR_AIR : 0.0;
    vec3 result = radiance;
    // A loop, since drivers without divergent branches (lavapipe) run both sides of an `if`.
    for (int i = 0; i < (hazy > 0.0 ? 1 : 0); ++i) {
        vec3 horizon = textureLod(sky, vec3(reach.xy, length(reach.xy) / face_size), 0.0).rgb;
        result = mix(horizon, radiance, exp(-extinction * hazy));
    }
    return result;
}

#endif
