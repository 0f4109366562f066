// Computes one level in 16 bits.
#version 460
#extension GL_GOOGLE_include_directive : require
#define HALF
#define LEVEL_FORMAT rgba16f
#include "cube_lobes.glsl"
