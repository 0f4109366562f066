// How moments are rounded to the format that holds them. The including file defines HALF where that is 16 bits.
#ifndef LEADR_SURFACES_MOMENTS_STORE
#define LEADR_SURFACES_MOMENTS_STORE

#include "../halves.glsl"

// Variance is a difference of what is stored: where the mean is rounded, second moments follow, so that only their own rounding is lost.
void as_stored(inout vec4 moments, inout float joint)
{
#ifdef HALF
    vec2 mean = vec2(nearest_half(moments.x), nearest_half(moments.y)), moved = mean - moments.xy;
    joint = nearest_half(joint + moments.x * moved.y + moved.x * mean.y);
    vec2 second = moments.zw + moved * (mean + moments.xy);
    moments = vec4(mean, nearest_half(second.x), nearest_half(second.y));
#endif
}

#endif
