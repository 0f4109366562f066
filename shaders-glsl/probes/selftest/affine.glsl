#ifndef SELFTEST_AFFINE_GLSL
#define SELFTEST_AFFINE_GLSL

float selftest_affine(const float x, const float scale, const float shift) {
    return scale * x + shift;
}

#endif
