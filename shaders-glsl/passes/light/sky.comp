// Writes the clear sky into the faces of a cube map, from its tables (crates/leadr-render/src/light/sky.rs,
// `SkyTables::radiance`).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "cube.glsl"
#include "sky.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430) readonly buffer Tables { SkyTables tables; };
layout(rgba32f) uniform writeonly image2DArray cube;
layout(push_constant) uniform Push {
    vec4 sun;      // unit direction to the sun; w: aerosol extinction per km
    vec4 albedo;   // albedo of the ground
    vec4 sunlight; // rgb irradiance above the atmosphere
    uint stage;    // not used by this shader
};

vec3 view_at(const int k, const int row, const int column) { return tables.view[3 * (row * COLUMNS + column) + k].rgb; }

vec3 mixed(const int k, const int row, const int column, const vec2 f)
{
    return mix(mix(view_at(k, row, column), view_at(k, row, column + 1), f.x),
               mix(view_at(k, row + 1, column), view_at(k, row + 1, column + 1), f.x), f.y);
}

vec3 scattered(const float row, const float column, const float nu)
{
    int r = min(int(row), ROWS - 2);
    int c = min(int(column), COLUMNS - 2);
    vec2 f = vec2(column - float(c), row - float(r));
    return phase_of_air(nu) * mixed(0, r, c, f) + phase_of_haze(nu) * mixed(1, r, c, f) + mixed(2, r, c, f);
}

vec3 radiance(const vec3 direction)
{
    // Far below the horizon, the exponential underflows to 0 in 32 bits.
    float ground = direction.z < 0.0 ? 1.0 - exp(direction.z / HORIZON) : 0.0;
    float down = 1.0 - max(direction.z, 0.0);
    float airglow = mix(NIGHT_ZENITH, NIGHT_HORIZON, down * down);
    vec3 night = mix(NIGHT * airglow, NIGHT * albedo.rgb, ground);
    if (ground == 1.0) return sunlight.rgb * (tables.ground.rgb + night);
    vec3 w = direction;
    w.z = max(w.z, 0.0);
    float squared = dot(w, w);
    w = squared > 1e-12 ? w * inversesqrt(squared) : vec3(1.0, 0.0, 0.0);
    float elevation = atan(w.z, length(w.xy));
    float row = sqrt(max(elevation / (PI / 2.0), 0.0)) * float(ROWS - 1);
    float across = w.x * sun.y - w.y * sun.x;
    float along = dot(w.xy, sun.xy);
    float azimuth = across == 0.0 && along == 0.0 ? 0.0 : atan(abs(across), along);
    vec3 sky = scattered(row, azimuth / PI * float(COLUMNS - 1), dot(w, sun.xyz));
    return sunlight.rgb * (mix(sky, tables.ground.rgb, ground) + night);
}

void main()
{
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    int size = imageSize(cube).x;
    if (texel.x >= size || texel.y >= size) return;
    vec2 st = (vec2(texel.xy) + 0.5) * 2.0 / float(size) - 1.0;
    imageStore(cube, texel, vec4(radiance(normalize(cube_direction(texel.z, st))), 1.0));
}
