// Computes the three small tables of the clear sky (crates/leadr-render/src/light/sky.rs) in one dispatch each. Stage 0 is multiple
// scattering by altitude (16 groups), stage 1 is the view table (16 groups), and stage 2 is the light on the ground (1 group).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sky.glsl"
layout(local_size_x = 64) in;

layout(std430) buffer Tables { SkyTables tables; };
layout(push_constant) uniform Push {
    vec4 sun;      // unit direction to the sun; w: aerosol extinction per km
    vec4 albedo;   // albedo of the ground
    vec4 sunlight; // not used by this shader, which shares the block with sky.comp
    uint stage;
};

shared vec3 sums[2][64];

vec3 multiple_along(const float h)
{
    float x = sqrt(clamp(h / ATMOSPHERE, 0.0, 1.0)) * float(ALTITUDES - 1);
    int i = min(int(x), ALTITUDES - 2);
    return mix(tables.multiple[i].rgb, tables.multiple[i + 1].rgb, x - float(i));
}

struct Scattered {
    vec3 air;
    vec3 haze;
    vec3 multiple;
    vec3 transmittance;
};

Scattered march(const float h, const float mu, const float mu_sun, const float nu, const float length, float haze, const bool isotropic)
{
    Scattered sum = Scattered(vec3(0.0), vec3(0.0), vec3(0.0), vec3(1.0));
    float r = EARTH + h;
    for (int i = 0; i < VIEW_STEPS; ++i) {
        float s0 = float(i) / float(VIEW_STEPS);
        float s1 = float(i + 1) / float(VIEW_STEPS);
        float t0 = length * s0 * s0;
        float t1 = length * s1 * s1;
        float t = 0.5 * (t0 + t1);
        float dt = t1 - t0;
        float height = max(altitude_along(h, mu, t), 0.0);
        vec3 density = densities(height);
        vec3 sigma = extinction(density, haze);
        vec3 weight = sum.transmittance * share_within(sigma * dt) * dt;
        vec3 light = sun_transmittance(height, (r * mu_sun + t * nu) / (EARTH + height), haze);
        vec3 air = AIR * density.x;
        vec3 aerosol = scattering_of_haze(density, haze);
        sum.air += weight * light * air;
        sum.haze += weight * light * aerosol;
        sum.multiple += weight * (air + aerosol) * (isotropic ? vec3(1.0) : multiple_along(height));
        sum.transmittance *= exp(-sigma * dt);
    }
    return sum;
}

vec2 view_cosines(const float row, const float column)
{
    float s = row / float(ROWS - 1);
    float elevation = PI / 2.0 * s * s;
    float mu = sin(elevation);
    return vec2(mu, mu * sun.z + cos(elevation) * length(sun.xy) * cos(PI * column / float(COLUMNS - 1)));
}

void multiple_scattering(const int altitude, const int direction)
{
    float s = float(altitude) / float(ALTITUDES - 1);
    float h = ATMOSPHERE * s * s;
    float haze = sun.w;
    float mu = (2.0 * float(direction / SPHERE_STEPS) + 1.0) / float(SPHERE_STEPS) - 1.0;
    float phi = PI * (float(direction % SPHERE_STEPS) + 0.5) / float(SPHERE_STEPS);
    float nu = mu * sun.z + sqrt(1.0 - mu * mu) * length(sun.xy) * cos(phi);
    float ground = distance_to_ground(h, mu);
    float path = ground >= 0.0 ? ground : distance_to_top(h, mu);
    Scattered ray = march(h, mu, sun.z, nu, path, haze, true);
    vec3 second = (ray.air + ray.haze) / (4.0 * PI);
    if (ground >= 0.0) {
        float mu_there = ((EARTH + h) * sun.z + path * nu) / EARTH;
        second += ray.transmittance * sun_transmittance(0.0, mu_there, haze) * max(mu_there, 0.0) * albedo.rgb / PI;
    }
    sums[0][direction] = second;
    sums[1][direction] = ray.multiple / (4.0 * PI);
    barrier();
    if (direction == 0) {
        vec3 light = vec3(0.0);
        vec3 kept = vec3(0.0);
        for (int i = 0; i < 64; ++i) {
            light += sums[0][i];
            kept += sums[1][i];
        }
        float weight = 4.0 * PI / float(SPHERE_STEPS * SPHERE_STEPS);
        tables.multiple[altitude] = vec4(light * weight / (4.0 * PI) / (1.0 - kept * weight), 0.0);
    }
}

void view_entry(const int entry)
{
    vec2 cosines = view_cosines(float(entry / COLUMNS), float(entry % COLUMNS));
    Scattered ray = march(0.0, cosines.x, sun.z, cosines.y, distance_to_top(0.0, cosines.x), sun.w, false);
    tables.view[3 * entry] = vec4(ray.air, 0.0);
    tables.view[3 * entry + 1] = vec4(ray.haze, 0.0);
    tables.view[3 * entry + 2] = vec4(ray.multiple, 0.0);
}

void light_on_ground(const int row)
{
    vec3 sum = vec3(0.0);
    if (row < ROWS - 1) {
        float span = PI / 2.0 / float((ROWS - 1) * (ROWS - 1)) * float(2 * row + 1);
        for (int column = 0; column < COLUMNS; ++column) {
            vec2 cosines = view_cosines(float(row) + 0.5, float(column));
            float edge = column == 0 || column == COLUMNS - 1 ? 0.5 : 1.0;
            float weight = edge * 2.0 * PI / float(COLUMNS - 1) * span * cosines.x
                         * sqrt(max(1.0 - cosines.x * cosines.x, 0.0));
            int low = 3 * (row * COLUMNS + column);
            int high = low + 3 * COLUMNS;
            sum += weight * 0.5 * (phase_of_air(cosines.y) * (tables.view[low] + tables.view[high]).rgb
                                 + phase_of_haze(cosines.y) * (tables.view[low + 1] + tables.view[high + 1]).rgb
                                 + (tables.view[low + 2] + tables.view[high + 2]).rgb);
        }
    }
    sums[0][row] = sum;
    barrier();
    if (row == 0) {
        vec3 light = sun_transmittance(0.0, sun.z, sun.w) * max(sun.z, 0.0);
        for (int i = 0; i < ROWS - 1; ++i) light += sums[0][i];
        tables.ground = vec4(albedo.rgb / PI * light, 0.0);
    }
}

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    int group = int(gl_WorkGroupID.x);
    // `stage` is uniform over the dispatch, so the barriers are in uniform control flow
    if (stage == 0u) multiple_scattering(group, lane);
    else if (stage == 1u) view_entry(64 * group + lane);
    else light_on_ground(lane);
}
