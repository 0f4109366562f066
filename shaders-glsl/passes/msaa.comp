#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// Finds the surfaces under the samples of each pixel, and the samples that each surface covers, so that each surface is shaded once. The
// surface with the most samples is the pixel's own surface. The other surfaces are stored in slots in rows below the image.
#include "msaa.glsl"
#include "reached.glsl"
#include "visible.glsl"
#include "leadr/frame.glsl"
layout(local_size_x = OTHERS_BLOCK, local_size_y = OTHERS_BLOCK) in;

layout(constant_id = 0) const int SAMPLES = 4; // samples in each pixel, at most MOST_MULTISAMPLES

uniform usampler2DMS seen_surface; // see geometry.frag
uniform usampler2DMS seen_footprint;
uniform sampler2DMS seen_depth;
layout(rgba32ui) uniform writeonly uimage2D surface;
layout(rg32ui) uniform writeonly uimage2D footprint;
layout(r32f) uniform writeonly image2D depth;
layout(r32ui) uniform writeonly uimage2D others;
layout(std430) buffer FilledSlots { uint filled_slots[]; }; // number of filled slots in each block
layout(push_constant, std430) uniform MsaaRays { // Rays as in surface_at.
    vec4 x;
    vec4 y;
    vec4 middle; // w: near plane
} rays;

const uint ALL_SAMPLES = (1u << SAMPLES) - 1u;
// The largest distance over which an edge-on triangle is extrapolated to the centre of the pixel, in pixel widths.
const float FARTHEST = 16.0;

mat2 sea_footprint(const uvec2 packed) {
    return mat2(unpackHalf2x16(packed.x), unpackHalf2x16(packed.y));
}

// Stores a surface at sample `i` of the pixel. If `alone` is true, it is the pixel's only surface, and it is evaluated at the centre of the
// pixel. In a pixel with several surfaces, the centre may lie outside the surface. width is the width of a pixel at distance 1.
void store(const ivec2 target, const ivec2 pixel, const int i, const bool alone, const float width) {
    uvec4 seen = texelFetch(seen_surface, pixel, i);
    uvec2 reached = texelFetch(seen_footprint, pixel, i).xy;
    float z = texelFetch(seen_depth, pixel, i).x, middle = uintBitsToFloat(seen.w);
    bool sea = object_of(seen.x) == SEA_INDEX;
    vec2 location = seen.x == 0u ? vec2(0.0) : location_of(sea ? seen.x : reached.x), on_patch = uintBitsToFloat(seen.yz);
    if (alone) {
        on_patch -= sea ? sea_footprint(reached) * location : away_of(reached);
        on_patch = (seen.x & BESIDE) != 0u ? clamp(on_patch, 0.0, 1.0) : on_patch;
    }
    if (alone || location == vec2(0.0)) {
        location = vec2(0.0);
        z = clamp(middle, z / (1.0 + FARTHEST * width), z * (1.0 + FARTHEST * width));
    }
    uint word = seen.x == 0u ? 0u : seen.x & ~BESIDE;
    imageStore(surface, target, uvec4(word, floatBitsToUint(on_patch), pack_position(vec2(pixel) + 0.5 + location)));
    imageStore(footprint, target, uvec4(reached, 0u, 0u));
    imageStore(depth, target, vec4(z));
}

// The properties of a sample that distinguish surfaces.
struct Seen {
    uint word;
    vec3 normal;   // displacement direction
    float away;    // distance along the view axis at the pixel centre, divided by the distance of the near plane
    float facing;  // cosine of the angle between normal and ray, times the length of the ray
};

Seen seen_by(const uvec4 surface, const uvec2 reached, const vec3 ray) {
    Seen seen;
    seen.word = surface.x;
    seen.normal = object_of(surface.x) == SEA_INDEX ? vec3(0.0, 0.0, 1.0) : direction_of(reached);
    seen.away = 1.0 / max(uintBitsToFloat(surface.w), 1e-9);
    seen.facing = dot(seen.normal, ray);
    return seen;
}

// Whether two points on one ray belong to one smooth surface. Along the normal, such points differ by less than a pixel.
bool same_surface(const Seen a, const Seen b, const float width) {
    bool one_object = ((a.word ^ b.word) & (OBJECT_BITS | INSIDE)) == 0u;
    float apart = abs((a.facing + b.facing) * (a.away - b.away));
    bool near_enough = dot(a.normal, b.normal) > SAME_NORMAL && apart < 2.0 * width * min(a.away, b.away);
    return one_object && (near_enough || a.word == 0u);
}

// Returns one of the samples whose bits are set. If possible, its triangle covers other samples of this set as well.
int sample_of_largest(const uint triangles[SAMPLES], const uint samples) {
    int found = findLSB(samples);
    [[unroll]] for (int i = SAMPLES - 2; i >= 0; --i) {
        bool shared_by_others = false;
        [[unroll]] for (int k = i + 1; k < SAMPLES; ++k) {
            shared_by_others = shared_by_others || ((samples >> k & 1u) != 0u && triangles[i] == triangles[k]);
        }
        found = (samples >> i & 1u) != 0u && shared_by_others ? i : found;
    }
    return found;
}

// Lists the surfaces of a pixel that may show more than one surface. Returns the word of the pixel's other surfaces.
uint list_surfaces(const ivec2 pixel, const vec3 ray, const float width) {
    Seen seen[SAMPLES];
    uint triangles[SAMPLES];
    int first[SAMPLES]; // the first sample on the same surface
    [[unroll]] for (int i = 0; i < SAMPLES; ++i) {
        uvec4 surface = texelFetch(seen_surface, pixel, i);
        uvec2 reached = texelFetch(seen_footprint, pixel, i).xy;
        seen[i] = seen_by(surface, reached, ray);
        triangles[i] = reached.x;
        first[i] = i;
        [[unroll]] for (int k = i - 1; k >= 0; --k) {
            first[i] = same_surface(seen[i], seen[k], width) ? first[k] : first[i];
        }
    }
    // The surface with the most samples is the pixel's own surface.
    uint own = 0u, own_samples = 0u, others = 0u, firsts = 0u;
    [[unroll]] for (int i = 0; i < SAMPLES; ++i) {
        uint samples = 0u;
        [[unroll]] for (int k = i; k < SAMPLES; ++k) {
            samples |= first[k] == i ? 1u << k : 0u;
        }
        others |= samples != 0u ? 1u << i : 0u;
        own = bitCount(samples) > bitCount(own_samples) ? uint(i) : own;
        own_samples = bitCount(samples) > bitCount(own_samples) ? samples : own_samples;
        firsts |= uint(first[i]) << (4 * i);
    }
    store(pixel, pixel, sample_of_largest(triangles, own_samples), own_samples == ALL_SAMPLES, width);
    others &= ~(1u << own);

    int count = min(bitCount(others), MOST_OTHERS), height = imageSize(surface).y;
    ivec2 block = pixel / OTHERS_BLOCK;
    int slot = int(atomicAdd(filled_slots[block.y * int(gl_NumWorkGroups.x) + block.x], uint(count)));
    // If a surface has no free slot, its samples count for the pixel's own surface.
    count = min(count, OTHERS_SLOTS - slot);
    uint listed = first_slot_word(slot);
    for (int n = 0; n < count; ++n) {
        int one = findLSB(others);
        others &= others - 1u;
        uint covered = 0u;
        [[unroll]] for (int i = 0; i < SAMPLES; ++i) {
            covered += (firsts >> (4 * i) & 0xfu) == uint(one) ? 1u : 0u;
        }
        store(slot_texel(pixel, slot + n, height), pixel, one, false, width);
        listed |= samples_word(n, covered);
    }
    return listed;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(seen_surface);
    if (any(greaterThanEqual(pixel, size))) {
        imageStore(surface, pixel, uvec4(NOBODY, 0u, 0u, 0u));
        return;
    }
    vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    vec3 ray = rays.middle.xyz + ndc.x * rays.x.xyz + ndc.y * rays.y.xyz;
    float width = 2.0 * length(rays.y.xyz) / float(size.y); // width of a pixel at distance 1

    uvec4 seen = texelFetch(seen_surface, pixel, 0);
    uvec2 reached = texelFetch(seen_footprint, pixel, 0).xy;
    uint triangles[SAMPLES]; // values that identify triangles, like triangle numbers
    Seen surface_seen = seen_by(seen, reached, ray);
    triangles[0] = reached.x;
    bool one = true;
    [[unroll]] for (int i = 1; i < SAMPLES; ++i) {
        uvec4 other = texelFetch(seen_surface, pixel, i);
        uvec2 other_reached = texelFetch(seen_footprint, pixel, i).xy;
        triangles[i] = other_reached.x;
        Seen there = Seen(other.x, surface_seen.normal, 1.0 / max(uintBitsToFloat(other.w), 1e-9), surface_seen.facing);
        bool alike = same_direction(reached, other_reached) || object_of(seen.x) == SEA_INDEX;
        one = one && alike && same_surface(surface_seen, there, width);
    }
    store(pixel, pixel, sample_of_largest(triangles, ALL_SAMPLES), true, width);
    uint listed = 0u;
    // Pixels that fail the test `one` are examined closely. The code uses a loop, because drivers without divergent branches (lavapipe) run
    // both sides of an `if`.
    for (int i = 0; i < (one ? 0 : 1); ++i) {
        listed = list_surfaces(pixel, ray, width);
    }
    imageStore(others, pixel, uvec4(listed, 0u, 0u, 0u));
}
