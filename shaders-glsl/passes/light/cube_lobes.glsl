// Computes one level of the blurred environment that shading samples with few lookups (leadr/visible/kernel.glsl). The source is the
// previous level or, for the first blurred levels, the box mips. A Gaussian kernel of 19 lookups lies on a hexagonal lattice about the
// texel: the centre, and three rings of six lookups. The lattice is not aligned with the texels, so texels, faces and corners of the cube
// remain invisible.
#extension GL_EXT_control_flow_attributes : require
#include "cube.glsl"
#include "../halves.glsl"
#include "leadr/frame.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform samplerCube source;
layout(LEVEL_FORMAT) uniform writeonly image2DArray level;
layout(push_constant) uniform Push {
    vec4 weights;   // weight of the central lookup, and of each lookup of the three rings; all weights sum to 1
    vec3 tangents;  // tangents of the angles between the centre and the lookups of each ring
    float lod;      // level of detail of the lookups at the centre of a face
    float coarsens; // 1 if the source has coarser mips for the edges of a face, else 0
    float widening; // if it has none: ratio of the variances of lookups and lattice; the lookups' variance shrinks with the texels
};

// The offsets of the first ring, at distance 1, and of the second ring, at distance sqrt(3). The third ring has the offsets of the first
// ring at distance 2.
const vec2 SIXTHS[6] = vec2[](vec2(1.0, 0.0), vec2(0.5, 0.866025404), vec2(-0.5, 0.866025404),
                              vec2(-1.0, 0.0), vec2(-0.5, -0.866025404), vec2(0.5, -0.866025404));
const vec2 BETWEEN[6] = vec2[](vec2(0.866025404, 0.5), vec2(0.0, 1.0), vec2(-0.866025404, 0.5),
                               vec2(-0.866025404, -0.5), vec2(0.0, -1.0), vec2(0.866025404, -0.5));

void store(const ivec3 texel, vec3 radiance)
{
#ifdef HALF
    radiance = vec3(nearest_half(radiance.r), nearest_half(radiance.g), nearest_half(radiance.b));
#endif
    imageStore(level, texel, vec4(radiance, 1.0));
}

void main()
{
    int size = imageSize(level).x;
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (texel.x >= size || texel.y >= size) return;
    vec3 through = cube_direction(texel.z, (vec2(texel.xy) + 0.5) * (2.0 / float(size)) - 1.0);
    // Toward the edges of a face, texels shrink to this fraction of their size along one direction, and to its square root along the other.
    // Coarser mips or, without them, a wider lattice compensate for the lookups' lost variance.
    float share = 1.0 / dot(through, through);
    Frame about = frame_about(through * sqrt(share));
    float mip = lod - 0.75 * coarsens * log2(share);
    float reach = sqrt(1.0 + widening * (1.0 - 0.5 * share * (1.0 + share)));
    vec3 sum = weights[0] * textureLod(source, about.z, mip).rgb;
    // The finest level is an unchanged copy.
    if (weights[0] == 1.0) {
        store(texel, sum);
        return;
    }
    [[unroll]] for (int star = 0; star < 3; ++star) {
        vec3 x = reach * tangents[star] * about.x;
        vec3 y = reach * tangents[star] * about.y;
        vec3 ring = vec3(0.0);
        [[unroll]] for (int i = 0; i < 6; ++i) {
            vec2 offset = star == 1 ? BETWEEN[i] : SIXTHS[i];
            ring += textureLod(source, about.z + offset.x * x + offset.y * y, mip).rgb;
        }
        sum += weights[star + 1] * ring;
    }
    store(texel, sum);
}
