// Computes level 0 of the LEADR maps in 16 bits.
#version 460
#extension GL_GOOGLE_include_directive : require
#define HALF
#define SLOPES_FORMAT rgba16f
#define JOINT_FORMAT r16f
#include "moments.glsl"
