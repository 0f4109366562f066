#ifndef LEADR_FORWARD_SLOPES
#define LEADR_FORWARD_SLOPES
// The slope statistics of the shaded point (LEADR eq. 9), and the densities in section 3.1 of the supplement.
#include "point.glsl"

uniform sampler2D joint_map; // E[hs ht]

struct Slopes {
    vec2 mean;
    vec3 covariance; // xx, yy, xy; includes the roughness of the base
};

Slopes filtered_slopes(const Point point) {
    vec4 moments = texture(slope_map, in_texcoord);
    float joint = texture(joint_map, in_texcoord).x;
    vec3 S = vec3(max(moments.zw - moments.xy * moments.xy, 0.0), joint - moments.x * moments.y);
    S *= vec3(point.scale * point.scale, point.scale.x * point.scale.y);
    S.xy += 0.5 * forward.material.w * forward.material.w;
    return Slopes(moments.xy * point.scale, S);
}

// Returns the density of normals per solid angle (supplement, 3.1).
float beckmann_as_printed(const vec3 wh, const Slopes slopes) {
    vec3 S = slopes.covariance;
    vec2 off = -wh.xy / wh.z - slopes.mean;
    float determinant = S.x * S.y - S.z * S.z;
    float square = (off.x * off.x * S.y + off.y * off.y * S.x - 2.0 * off.x * off.y * S.z) / determinant;
    float z2 = wh.z * wh.z;
    return 0.15915494 * inversesqrt(determinant) * exp(-0.5 * square) / (z2 * z2);
}

#endif
