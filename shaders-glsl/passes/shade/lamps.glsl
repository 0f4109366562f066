// The lamps: point lights, spots, and directional lights beside the sun. The lamps with shadow maps come first.
#ifndef LEADR_SHADE_LAMPS
#define LEADR_SHADE_LAMPS
#include "point.glsl"
#include "sun.glsl"

struct Lamp {
    vec4 position; // xyz: position, and w: 1; or xyz: direction toward a directional light, and w: 0
    vec4 power;    // rgb: intensity, or irradiance of a directional light; w: 1 / range^2, or 0
    vec4 falloff;  // falloff (point_reach)
};

layout(set = 1, std430) readonly buffer Lamps {
    Lamp lamps[];
};

// Returns the number of lamps. cosine is a cosine of the pixel, which adds nothing. A loop bound that depends only on uniforms would make
// lavapipe compile the shader again for every draw. The bound also holds for pixels outside the primitive, whose cosine has any value,
// because lavapipe waits for their loops, too.
int lamp_count(const float cosine) {
    int count = int(lighting.draws.z);
    return min(count + int(0.5 * cosine), count);
}

// Returns the irradiance of a lamp on a plane at `position` that faces the lamp, and the unit vector toward the lamp.
vec3 lamp_irradiance(const Lamp lamp, const vec3 position, out vec3 towards) {
    vec3 d = lamp.position.xyz - lamp.position.w * position;
    float square = max(dot(d, d), 1e-8);
    towards = d * inversesqrt(square);
    return lamp.power.rgb * (point_reach(towards, square, lamp.falloff, lamp.power.w) / square);
}

// Returns the fraction of a lamp that reaches the macrosurface, by its shadow map in this layer. The map covers the bounding sphere of all
// casters, and nothing outside is shadowed.
float lamp_visibility(const int layer, const int number, const vec3 position, const vec3 mesonormal, const vec3 macronormal,
                      const float width) {
    vec4 at = lamps[number].position, shadow = lighting.lamp_shadow[number];
    vec3 towards = normalize(at.xyz - at.w * position);
    vec4 clip = lighting.shadow_from_world[layer] * vec4(position, 1.0);
    float texel = shadow.y * max(clip.w, 1e-6);
    Receiver r = Receiver(position, mesonormal, macronormal, towards, texel);
    // The ratio of a point light's map width to its distance divides the gradients of depth. The width of a directional light's map
    // equals its depth range.
    float wide = shadow.y * float(textureSize(shadow_maps, 0).x);
    float steepest = STEEPEST * (at.w > 0.0 ? wide * clip.z / max(clip.w, 1e-6) : 1.0);
    float lit = map_visibility(layer, r, width, shadow.x, steepest);
    return clip.w > 0.0 ? lit : 1.0;
}

#endif
