// Storage for the additional surfaces of multisampled pixels (msaa.comp). Each block of OTHERS_BLOCK x OTHERS_BLOCK pixels has a block of
// as many slots, in rows below the image. The slots are filled in squares of 2 x 2, because devices shade such squares together.
#ifndef LEADR_MSAA
#define LEADR_MSAA
#include "constants.glsl"

const int OTHERS_SLOTS = OTHERS_BLOCK * OTHERS_BLOCK;

// Returns the texel of a slot of a pixel's block. height is the height of the image.
ivec2 slot_texel(const ivec2 pixel, const int slot, const int height) {
    int square = slot >> 2;
    ivec2 within = ivec2((square & 3) * 2 + (slot & 1), (square >> 2) * 2 + (slot >> 1 & 1));
    return (pixel & ~(OTHERS_BLOCK - 1)) + within + ivec2(0, height / 2);
}

// Returns the number of a slot within its block, from the slot's texel below the pixels.
int slot_of_texel(const ivec2 texel) {
    ivec2 within = texel & (OTHERS_BLOCK - 1);
    return (within.y >> 1) * 16 + (within.x >> 1) * 4 + (within.y & 1) * 2 + (within.x & 1);
}

// The additional surfaces of a pixel, packed in one word: the first slot, and the number of samples of each surface.
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
