// Converts an equirectangular image to the faces of a cube map. By convention, z is up, row 0 is at +z, and the centre of the image is in
// the direction +x. u grows clockwise when seen from above, which is to the right of a viewer: u = 1/2 − atan(y, x) / 2π, v = acos(z) / π.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform sampler2D equirect; // linear filter, repeating in u; v stays half a texel away from the poles
layout(rgba32f) uniform writeonly image2DArray cube;
layout(push_constant) uniform Push {
    uint samples; // samples per axis and texel; at least four per source texel, to preserve the energy of a one-pixel sun
};

const float PI = 3.14159265358979;

void main()
{
    int size = imageSize(cube).x;
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (texel.x >= size || texel.y >= size) return;
    float height = float(textureSize(equirect, 0).y);
    float d = 2.0 / float(size * int(samples));
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (uint j = 0u; j < samples; ++j)
        for (uint i = 0u; i < samples; ++i) {
            vec2 st = (vec2(texel.xy * int(samples) + ivec2(i, j)) + 0.5) * d - 1.0;
            vec3 w = cube_direction(texel.z, st);
            float weight = cube_solid_angle(st, d);
            // unlike acos, atan keeps its precision near the poles
            vec2 uv = vec2(0.5 - atan(w.y, w.x) / (2.0 * PI), atan(length(w.xy), w.z) / PI);
            uv.y = clamp(uv.y, 0.5 / height, 1.0 - 0.5 / height);
            sum += weight * textureLod(equirect, uv, 0.0).rgb;
            weights += weight;
        }
    imageStore(cube, texel, vec4(sum / weights, 1.0));
}
