#ifndef LEADR_CONSTANTS_GLSL
#define LEADR_CONSTANTS_GLSL

// Floors and limits that keep every function of this library finite; crates/leadr-reflectance/src/limits.rs explains each.

const float LEADR_PI = 3.14159265358979;
const float LEADR_MIN_VARIANCE = 1e-8;      // smallest variance; smaller variances are raised to it
const float LEADR_MAX_CORRELATION = 0.9998779296875; // 1 - 2^-13, the largest |c_xy| / (sigma_x * sigma_y)
const float LEADR_MAX_SLOPE = 100.0;        // steepest mean slope (89.4 degrees) and largest standard deviation
const float LEADR_MAX_GRADIENT_VARIANCE = 1e18; // largest variance of height derivatives in any unit, so that the product of two is finite
const float LEADR_MIN_AREA = 1e-6;          // smallest visible projected area used as a divisor
const float LEADR_MIN_NORMAL_Z = 1e-4;      // smallest z of a half vector; lower values are raised to it

#endif
