// Storage of the pixels' other surfaces (msaa.comp): below the pixels, each block of OTHERS_BLOCK x OTHERS_BLOCK pixels has a
// block of as many slots, which fill up in squares of 2 x 2, since devices shade these together.
#ifndef LEADR_MSAA
#define LEADR_MSAA
#include "constants.glsl"

const int OTHERS_SLOTS = OTHERS_BLOCK * OTHERS_BLOCK;

// Texel of a slot of a pixel's block, in an image of this height.
ivec2 slot_texel(const ivec2 pixel, const int slot, const int height) {
    int square = slot >> 2;
    ivec2 within = ivec2((square & 3) * 2 + (slot & 1), (square >> 2) * 2 + (slot >> 1 & 1));
    return (pixel & ~(OTHERS_BLOCK - 1)) + within + ivec2(0, height / 2);
}

// The number within its block of the slot at a texel below the pixels.
int slot_of_texel(const ivec2 texel) {
    ivec2 within = texel & (OTHERS_BLOCK - 1);
    return (within.y >> 1) * 16 + (within.x >> 1) * 4 + (within.y & 1) * 2 + (within.x & 1);
}

// The other surfaces of a pixel as one word: the first slot, and the number of samples of each.
uint first_slot_word(const int slot) {
    return uint(min(slot, 255));
}

uint samples_word(const int i, const uint samples) {
    return samples << (8 + 4 * i);
}

int first_slot(const uint others) {
    return int(others & 0xffu);
}

int samples_of(const uint others, const int i) {
    return int(others >> (8 + 4 * i) & 0xfu);
}

#endif
