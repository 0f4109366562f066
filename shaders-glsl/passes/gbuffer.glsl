// The texels of the G-buffer (GBuffer in Rust), which has 72 bytes per pixel. Mean and covariance of the slopes are packed into texels that
// every technique fetches anyway.
#ifndef LEADR_GBUFFER
#define LEADR_GBUFFER

#include "leadr/frame.glsl"
#include "leadr/visible/horizon.glsl"

const vec4 NO_CONE = vec4(0.0, 0.0, 1.0, -1.0);

const int MOST_CLASSES = 4;
const int MOST_VIEWS = 3;

// The classes of facets under a pixel, such as tops, walls and bottoms, with CLASSES > 1 (leadr/masking/classes.glsl). They have the order
// of the maps.
struct FacetClasses {
    vec4 share;                    // fraction of the mesosurface; the shares sum to one, and a class that is not shaded has 0
    vec2 mean[MOST_CLASSES];       // mean slope, in the frame about the normal
    vec3 covariance[MOST_CLASSES]; // covariance of the slopes
    vec4 material[MOST_CLASSES];   // rgb: linear albedo; a: Beckmann roughness alpha
    // A direction w has the coordinates (dot(s, w.xy), dot(t, w.xy)) / (w.z - dot(offset, w.xy)) in the table of the classes' openness. A
    // relief that is projected along the axes has up to three projections of the table, whose weights sum to one.
    int views;
    vec2 s[MOST_VIEWS];
    vec2 t[MOST_VIEWS];
    float weight[MOST_VIEWS];
    vec2 offset;
    float inside;                  // fraction of the relief's slope variance that the footprint contains
    vec4 correlation[MOST_CLASSES]; // xyz: of the openness towards different directions
    vec4 local[MOST_VIEWS];         // amounts of the local openness in each projection (leadr/masking/classes.glsl)
    vec4 sky_depth;                // optical depth towards the sky
};

// A clear coat, with COATED.
struct Coat {
    float weight;    // covered fraction of the surface
    float alpha;     // Beckmann roughness
    bool own;        // whether the coat has its own relief, otherwise that of the surface
    vec2 mean_slope; // of its own relief, in the frame about the normal of the surface
    vec3 covariance;
};

const Coat NO_COAT = Coat(0.0, 0.5, false, vec2(0.0), vec3(0.0));

// The output of the filter passes for a pixel, for any kind of surface.
struct FilteredSurface {
    vec3 normal;         // displacement direction, in world space
    vec2 mean_slope;     // mean slope, in the frame about the normal
    vec3 covariance;     // covariance of the slopes
    vec4 material;       // rgb: linear albedo; a: Beckmann roughness alpha
    uint fit;            // number of the measured base material, or 0
    vec3 f0;             // reflectance at normal incidence
    float diffuse_f0;    // reflectance of the diffuse base's surface; the metallic fraction has no albedo
    vec3 edge_tint;      // F82 tint of a conductor's reflectance (fresnel_edge_tint)
    vec3 emission;       // emitted radiance, before scaling
    float accessibility;
    bool inside;         // whether a back face is visible
    Horizon horizon;     // horizon of the relief
    vec4 cone;           // replaces the horizon with CONES: vector and share (leadr/masking/occlusion.glsl), tangent frame; w < 0: no cone
    float lod;           // level of detail of the maps
    float joined;        // weight of the joined edge samples, 0 to 1
    float relief;        // relief of an edge sample's object, in metres
    mat2 rotation;       // with PER_LIGHT_KERNEL, the changes of the normal to the next pixels, in the frame about the normal
    Coat coat;
    uint medium;         // number of the medium behind the surface, with TRANSMITS, or 0
    FacetClasses classes; // replaces slopes and material with CLASSES > 1
};

// Packs the displacement direction (octahedral, snorm), the mean slope, and the covariance sxy.
uvec4 pack_slopes(const uint direction, const vec2 mean_slope, const vec3 covariance) {
    return uvec4(direction, floatBitsToUint(mean_slope), floatBitsToUint(covariance.z));
}

// Packs linear albedo and Beckmann roughness alpha as halves, and the variances sxx and syy.
uvec4 pack_material(const vec4 material, const vec3 covariance) {
    return uvec4(packHalf2x16(material.xy), packHalf2x16(material.zw), floatBitsToUint(covariance.xy));
}

vec2 mean_slope_of(const uvec4 slopes) {
    return uintBitsToFloat(slopes.yz);
}

vec3 covariance_of(const uvec4 slopes, const uvec4 material) {
    return uintBitsToFloat(uvec3(material.zw, slopes.w));
}

vec4 material_of(const uvec4 material) {
    return vec4(unpackHalf2x16(material.x), unpackHalf2x16(material.y));
}

// Packs the ambient accessibility, or -1 for back faces, and the level of detail of the maps, as halves.
uint pack_accessibility_lod(const FilteredSurface f) {
    return packHalf2x16(vec2(f.inside ? -1.0 : f.accessibility, f.lod));
}

// Packs the slopes of a coat: the means with 10 bits each, and the standard deviations with 6 bits each, without their correlation.
const float COAT_SLOPES = 4.0; // the largest mean slope
const float COAT_SPREAD = 1.0; // the largest standard deviation

uint pack_coat_slopes(const Coat coat) {
    ivec2 mean = ivec2(round(clamp(coat.mean_slope / COAT_SLOPES, -1.0, 1.0) * 511.0));
    uvec2 spread = uvec2(round(sqrt(clamp(sqrt(max(coat.covariance.xy, 0.0)) / COAT_SPREAD, 0.0, 1.0)) * 63.0));
    return (uint(mean.x) & 0x3ffu) | (uint(mean.y) & 0x3ffu) << 10 | spread.x << 20 | spread.y << 26;
}

// Packs the reflectance at normal incidence as halves, the numbers of the measured material and of the medium, and the reflectance of the
// diffuse base. A coat
// uses bits that are otherwise 0, and half of the bits of the last value: 8 bits for the weight, 8 bits for the square root of the roughness,
// and the slopes.
uvec4 pack_reflection(const FilteredSurface f) {
    uvec4 packed = uvec4(packHalf2x16(f.f0.xy), packHalf2x16(vec2(f.f0.z, 0.0)), f.fit | f.medium << 8, floatBitsToUint(f.diffuse_f0));
    uint weight = uint(round(clamp(f.coat.weight, 0.0, 1.0) * 255.0));
    if (weight > 0u) {
        uint slopes = pack_coat_slopes(f.coat);
        packed.y |= weight << 24 | uint(round(sqrt(clamp(f.coat.alpha, 0.0, 1.0)) * 255.0)) << 16;
        packed.z |= slopes << 16;
        packed.w = (packed.w & 0xffff0000u) | slopes >> 16;
    }
    return packed;
}

// Returns the coat. own is the mark of pack_emission.
Coat coat_of(const uvec4 reflection, const bool own) {
    if (reflection.y >> 24 == 0u) {
        return NO_COAT;
    }
    uint slopes = reflection.z >> 16 | reflection.w << 16;
    ivec2 mean = ivec2(slopes << 22, slopes << 12) >> 22;
    vec2 spread = vec2(slopes >> 20 & 63u, slopes >> 26) / 63.0;
    spread *= spread * COAT_SPREAD;
    float root = float(reflection.y >> 16 & 0xffu) / 255.0;
    return Coat(float(reflection.y >> 24) / 255.0, root * root, own, vec2(mean) * (COAT_SLOPES / 511.0), vec3(spread * spread, 0.0));
}

// Packs the F82 tint of a conductor, 0 to 4, with five bits per channel.
uint pack_edge_tint(const vec3 edge_tint) {
    uvec3 bits = uvec3(round(clamp(edge_tint, 0.0, 4.0) * (31.0 / 4.0)));
    return bits.x | bits.y << 5 | bits.z << 10;
}

vec3 unpack_edge_tint(const uint bits) {
    return vec3(uvec3(bits, bits >> 5, bits >> 10) & 31u) * (4.0 / 31.0);
}

// Packs the emission as halves, the F82 tint, and whether a coat has its own relief.
uvec2 pack_emission(const FilteredSurface f) {
    vec3 emission = clamp(f.emission, 0.0, 6e4);
    uint own = f.coat.weight > 0.0 && f.coat.own ? 0x80000000u : 0u;
    return uvec2(packHalf2x16(emission.xy), packHalf2x16(vec2(emission.z, 0.0)) | pack_edge_tint(f.edge_tint) << 16 | own);
}

vec3 emission_of(const uvec2 packed) {
    return vec3(unpackHalf2x16(packed.x), unpackHalf2x16(packed.y).x);
}

vec3 edge_tint_of(const uvec2 packed) {
    return unpack_edge_tint(packed.y >> 16);
}

vec3 f0_of(const uvec4 reflection) {
    return vec3(unpackHalf2x16(reflection.x), unpackHalf2x16(reflection.y).x);
}

uint fit_of(const uvec4 reflection) {
    return reflection.z & 0xffu;
}

uint medium_number_of(const uvec4 reflection) {
    return reflection.z >> 8 & 0xffu;
}

// Packs the data of a pixel: the weight of its joined edge samples, 0 to 1.
uvec2 pack_surface(const FilteredSurface f) {
    return uvec2(pack_accessibility_lod(f), floatBitsToUint(f.joined));
}

float joined_part_of(const uvec2 surface) {
    return uintBitsToFloat(surface.y);
}

// Packs the data of an edge sample: the relief of its object, in metres.
uvec2 pack_edge(const FilteredSurface f) {
    return uvec2(pack_accessibility_lod(f), floatBitsToUint(f.relief));
}

// Packs the data of an edge sample that will be joined: its area of macrosurface, in square metres, and the relief of its object.
uvec2 pack_joined_edge(const float area, const float relief) {
    return floatBitsToUint(vec2(area, relief));
}

// Packs a standard deviation in 11 bits: a half float without the sign and without four bits of its fraction.
uint pack_deviation(const float deviation) {
    return min((packHalf2x16(vec2(deviation, 0.0)) + 8u) >> 4, 0x7bfu);
}

float unpack_deviation(const uint bits) {
    return unpackHalf2x16((bits & 0x7ffu) << 4).x;
}

// Packs the horizon of the relief: lean as halves, the standard deviations of the spread with 11 bits each, and their correlation with 10
// bits. The result is zero if nothing rises above the plane of the mean slope.
uvec2 pack_horizon(const Horizon h) {
    vec2 deviations = min(sqrt(max(h.spread.xy, 0.0)), 6e4);
    float correlation = clamp(h.spread.z / max(deviations.x * deviations.y, 1e-20), -1.0, 1.0);
    uint signed_ten = uint(int(round(correlation * 511.0))) & 0x3ffu;
    return uvec2(packHalf2x16(clamp(h.lean, -6e4, 6e4)),
                 pack_deviation(deviations.x) | pack_deviation(deviations.y) << 11 | signed_ten << 22);
}

// A cone can replace the horizon, with 16 bits each for x and y, 10 for z, and 11 for the share. The mark is a deviation of all ones, which
// no horizon has.
const uint CONE_MARK = 0x7ffu;

uvec2 pack_cone(const vec4 cone) {
    uint z = uint(int(round(clamp(cone.z, -1.0, 1.0) * 511.0))) & 0x3ffu;
    return uvec2(packSnorm2x16(cone.xy), CONE_MARK | uint(round(clamp(cone.w, 0.0, 1.0) * 2047.0)) << 11 | z << 22);
}

vec4 unpack_cone(const uvec2 packed) {
    if ((packed.y & CONE_MARK) != CONE_MARK) {
        return NO_CONE;
    }
    return vec4(unpackSnorm2x16(packed.x), float(int(packed.y) >> 22) / 511.0, float(packed.y >> 11 & 0x7ffu) / 2047.0);
}

Horizon unpack_horizon(const uvec2 packed) {
    vec2 deviations = vec2(unpack_deviation(packed.y), unpack_deviation(packed.y >> 11));
    float correlation = float(int(packed.y) >> 22) / 511.0;
    return Horizon(unpackHalf2x16(packed.x), vec3(deviations * deviations, correlation * deviations.x * deviations.y));
}

#endif
