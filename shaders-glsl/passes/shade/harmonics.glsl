// The environment as spherical harmonics of order 2.
#ifndef LEADR_SHADE_HARMONICS
#define LEADR_SHADE_HARMONICS

// Coefficients of radiance in world space; w is 0 (light/irradiance.comp).
layout(set = 1, std430) readonly buffer Harmonics { vec4 harmonics[9]; };

vec3[9] environment_sh() {
    vec3 c[9];
    for (int i = 0; i < 9; ++i) {
        c[i] = harmonics[i].rgb;
    }
    return c;
}

#endif
