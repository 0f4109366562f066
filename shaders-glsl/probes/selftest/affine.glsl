#ifndef SELFTEST_AFFINE_GLSL
#define SELFTEST_AFFINE_GLSL

float selftest_affine(float x, float scale, float shift) {
    return scale * x + shift;
}

#endif
