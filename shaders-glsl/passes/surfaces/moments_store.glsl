// How moments are rounded to the format that holds them. The including file defines HALF where that is 16 bits.
#ifndef LEADR_SURFACES_MOMENTS_STORE
#define LEADR_SURFACES_MOMENTS_STORE

#ifdef HALF
// The nearest half float, the even one of two: what drivers do where they store one is left to them. src/maps/halves.rs has a twin.
float nearest_half(float value)
{
    uint bits = floatBitsToUint(value);
    bits += 0xfffu + ((bits >> 13) & 1u);
    float normal = uintBitsToFloat(bits & ~0x1fffu);
    return abs(value) < 6.103515625e-5 ? roundEven(value * 16777216.0) / 16777216.0 : clamp(normal, -65504.0, 65504.0);
}
#endif

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
