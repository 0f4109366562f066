// One level of the environment blurred for few lookups (leadr/visible/kernel.glsl), from the level before it or, for the
// first, from the box mips: a Gaussian of lookups on a hexagonal lattice of angles. No lookup falls on a texel by plan, so
// neither texels nor faces nor corners show.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
#include "leadr/frame.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform samplerCube source;
layout(rgba32f) uniform writeonly image2DArray level;
layout(push_constant) uniform Push {
    float spacing; // of the lattice, in radians
    float falloff; // exponent of the weights per squared distance in units of the spacing
    int rings;     // of the lattice, about the middle; 0 copies
};

const int MAX_RINGS = 6;

void main()
{
    int size = imageSize(level).x;
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (texel.x >= size || texel.y >= size) return;
    Frame about = frame_about(normalize(cube_direction(texel.z, (vec2(texel.xy) + 0.5) * (2.0 / float(size)) - 1.0)));
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    int n = min(rings, MAX_RINGS);
    for (int i = -n; i <= n; ++i) {
        for (int j = max(-n, -n - i); j <= min(n, n - i); ++j) {
            vec2 place = vec2(float(i) + 0.5 * float(j), 0.866025404 * float(j));
            float square = dot(place, place);
            float angle = spacing * sqrt(square);
            // sin(angle) / distance
            float sine = square > 0.0 ? sin(angle) * inversesqrt(square) : 0.0;
            vec3 towards = from_frame(about, vec3(place * sine, cos(angle)));
            // Texels shrink toward the edges of a face. The box mips have some of about the same angle everywhere.
            float major = max(max(abs(towards.x), abs(towards.y)), abs(towards.z));
            float weight = exp(-falloff * square);
            sum += weight * textureLod(source, towards, n > 0 ? -1.5 * log2(major) : 0.0).rgb;
            weights += weight;
        }
    }
    imageStore(level, texel, vec4(sum / weights, 1.0));
}
