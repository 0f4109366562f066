#ifndef LEADR_CONSTANTS_GLSL
#define LEADR_CONSTANTS_GLSL

// Floors and limits that keep the results of this library finite. crates/leadr-reflectance/src/limits.rs explains each of them.

const float LEADR_PI = 3.14159265358979;
const float LEADR_MIN_VARIANCE = 1e-8;      // the smallest variance; smaller values are raised to it
const float LEADR_MAX_CORRELATION = 0.9998779296875; // 1 - 2^-13, the largest magnitude of the correlation c_xy / (sigma_x * sigma_y)
const float LEADR_MAX_SLOPE = 100.0;        // the limit of mean slopes (89.4 degrees) and of standard deviations
const float LEADR_MAX_GRADIENT_VARIANCE = 1e18; // the largest variance of height derivatives, so that the product of two is finite
const float LEADR_MIN_AREA = 1e-6;          // the smallest visible projected area that is used as a divisor
const float LEADR_MIN_NORMAL_Z = 1e-4;      // the smallest z of a half vector; smaller values are raised to it

#endif
