// Rounds moments to their storage format. The including file defines HALF for 16 bits.
#ifndef LEADR_SURFACES_MOMENTS_STORE
#define LEADR_SURFACES_MOMENTS_STORE

#include "../halves.glsl"

// The variance is a difference of stored values. The second moments are adjusted to the rounded mean, so that only their own rounding error
// remains.
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
