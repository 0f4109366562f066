// Computes one level in 32 bits.
#version 460
#extension GL_GOOGLE_include_directive : require
#define LEVEL_FORMAT rgba32f
#include "cube_lobes.glsl"
