// What the relief around a pixel hides from it: leadr/visible/horizon.glsl for techniques that know of it.
#ifndef LEADR_SHADE_RELIEF
#define LEADR_SHADE_RELIEF
#include "gbuffer.glsl"
#include "settings.glsl"

uniform usampler2D gbuffer_horizon;

Horizon read_horizon(ivec2 pixel) {
    return USES_HORIZON ? unpack_horizon(texelFetch(gbuffer_horizon, pixel, 0).xy) : Horizon(vec2(0.0), vec3(0.0));
}

// Share of the light about wi (tangent frame) that the surrounding relief lets through. deviation: of the light, radians.
float relief_visibility(Surface surface, vec3 wi, float deviation) {
    return USES_HORIZON ? horizon_visibility(wi, surface.mean_slope, surface.horizon, deviation) : 1.0;
}

#endif
