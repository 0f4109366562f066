// What the relief around a pixel hides from it: leadr/visible/horizon.glsl for techniques that know of it.
#ifndef LEADR_SHADE_RELIEF
#define LEADR_SHADE_RELIEF
#include "surface.glsl"
#include "settings.glsl"

// Share of the light about wi (tangent frame) that the surrounding relief lets through. deviation: of the light, radians.
float relief_visibility(Surface surface, vec3 wi, float deviation) {
    return USES_HORIZON ? horizon_visibility(wi, surface.mean_slope, surface.horizon, deviation) : 1.0;
}

#endif
