#ifndef LEADR_HALVES
#define LEADR_HALVES

// Returns the nearest half float, with ties to even. Vulkan leaves the rounding of image stores to drivers, so this function defines it.
// crates/leadr-maps/src/halves.rs has the same function.
float nearest_half(const float value)
{
    uint bits = floatBitsToUint(value);
    bits += 0xfffu + ((bits >> 13) & 1u);
    float normal = uintBitsToFloat(bits & ~0x1fffu);
    return abs(value) < 6.103515625e-5 ? roundEven(value * 16777216.0) / 16777216.0 : clamp(normal, -65504.0, 65504.0);
}

#endif
