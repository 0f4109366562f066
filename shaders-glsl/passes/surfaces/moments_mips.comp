// Computes one mip level of the LEADR maps in 32 bits.
#version 460
#extension GL_GOOGLE_include_directive : require
#define SLOPES_FORMAT rgba32f
#define JOINT_FORMAT r32f
#include "moments_mips.glsl"
