#version 450

#include "leadr/shading.glsl"
#include "leadr/slopes/map.glsl"
#include "leadr/visible/shadowed_environment.glsl"
#include "leadr/visible/shadowed_specular.glsl"

// Draws a plane z = 0 with a baked material under a sun and a sky.

layout(set = 0, binding = 0) uniform View {
    vec4 eye;        // position of the camera in metres
    vec4 corner;     // ray through the centre of the top left pixel
    vec4 across;     // change of the ray per pixel, to the right and down
    vec4 down;
    vec4 sun;        // direction to the sun
    vec4 irradiance; // irradiance on a plane that faces the sun
    vec4 sky[9];     // spherical harmonics of the sky's radiance
    vec4 scales;     // repeat of the material in metres; metres per unit of height
};
layout(set = 0, binding = 1) uniform Baked {
    vec4 scale[3];   // factors on the values of the file: first layer, second layer, colour
    vec4 color_layer;
};
layout(set = 0, binding = 2) uniform texture2DArray baked;
layout(set = 0, binding = 3) uniform sampler repeating;

layout(location = 0) out vec4 radiance;

const int TAPS = 16;
const int PROBES = 16;
const vec3 F0 = vec3(0.04);

// Returns the sky blurred by a kernel of this variance, in radians squared. Harmonics of order l decay as in heat diffusion. Harmonics of
// order 2 decay slightly less.
vec3 blurred_sky(vec3 c[9], vec3 direction, float variance) {
    return max(sh_radiance(c, normalize(direction) * exp(-variance)), 0.0);
}

// The means of the baked channels over a pixel. The means are averages of boxes along the pixel's longer side.
struct Footprint {
    vec4 first;
    vec4 second;
    vec3 color;
};

Footprint footprint(vec2 texcoord, vec2 ds, vec2 dt, vec2 size) {
    vec2 longer = dot(ds, ds) > dot(dt, dt) ? ds : dt;
    vec2 shorter = dot(ds, ds) > dot(dt, dt) ? dt : ds;
    float lod = log2(max(max(length(longer * size) / float(TAPS), length(shorter * size)), 1.0));
    Footprint sum = Footprint(vec4(0.0), vec4(0.0), vec3(0.0));
    for (int i = 0; i < TAPS; ++i) {
        vec2 at = texcoord + longer * ((float(i) + 0.5) / float(TAPS) - 0.5);
        sum.first += textureLod(sampler2DArray(baked, repeating), vec3(at, 0.0), lod);
        sum.second += textureLod(sampler2DArray(baked, repeating), vec3(at, 1.0), lod);
        sum.color += textureLod(sampler2DArray(baked, repeating), vec3(at, color_layer.x), lod).rgb;
    }
    float per = 1.0 / float(TAPS);
    return Footprint(sum.first * scale[0] * per, sum.second * scale[1] * per, sum.color * scale[2].rgb * per);
}

// Returns the light of the sky on the surface. The specular term uses probes, and the diffuse term uses one irradiance lookup.
vec3 environment(LeadrSurface surface, vec3 wo, Frame frame, vec3 c[9]) {
    vec2 m = surface.mean_slope;
    vec3 relief = clamp_covariance(surface.slope_covariance);
    vec3 specular_s = add_facet_roughness(relief, surface.roughness, wo, m);
    VisibleProbes probes = visible_probes(LEADR_SHADOWING_CORRELATED, wo, m, specular_s, probe_kernel(PROBES));
    DirectionArea o = direction_area(wo, probes.m, probes.cholesky);
    float f0 = dot(surface.f0, vec3(1.0 / 3.0));
    vec3 reflected = vec3(0.0);
    float lit = 0.0;
    for (int i = 0; i < PROBES; ++i) {
        VisibleProbe p = visible_probe(probes, wo, probe_node(PROBES, i, probes.wide));
        LitProbe l = lit_probe(LEADR_SHADOWING_CORRELATED, probes, o, wo, f0, p);
        vec3 weight = surface.f0 * l.lit + (grazing_reflectance(surface.f0) - surface.f0) * l.grazing;
        reflected += p.weight * weight * blurred_sky(c, from_frame(frame, l.wi), l.narrowing * p.variance);
        lit += p.weight * l.lit;
    }
    BentNormal bent = bent_normal(wo, m, relief);
    vec3 diffuse = shadowed_diffuse_environment(bent, frame, c, vec3(0.0));
    vec3 fresnel = surface.f0 + (grazing_reflectance(surface.f0) - surface.f0) * probes.grazing;
    return surface.albedo * (1.0 - fresnel) * diffuse + reflected / max(lit, 1.0);
}

void main() {
    vec3 c[9];
    for (int i = 0; i < 9; ++i) c[i] = sky[i].rgb;
    vec2 pixel = gl_FragCoord.xy - 0.5;
    vec3 ray = corner.xyz + across.xyz * pixel.x + down.xyz * pixel.y;
    if (ray.z > -1e-4) {
        radiance = vec4(blurred_sky(c, ray, 0.0), 1.0);
        return;
    }
    // The intersection of the ray with the plane, and its change per pixel, are in texture coordinates. The rows of the map run along -y.
    vec2 per_metre = vec2(1.0, -1.0) / scales.x;
    float back = -eye.z / ray.z;
    vec2 texcoord = per_metre * (eye.xy + back * ray.xy);
    vec2 ds = per_metre * (back * (across.xy - ray.xy * (across.z / ray.z)));
    vec2 dt = per_metre * (back * (down.xy - ray.xy * (down.z / ray.z)));
    Footprint seen = footprint(texcoord, ds, dt, vec2(textureSize(sampler2DArray(baked, repeating), 0).xy));

    Frame frame = Frame(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    SlopeMap map = slope_map(frame.x / per_metre.x, frame.y / per_metre.y, frame.x, frame.y, frame.z);
    vec3 covariance = covariance_from_moments(seen.first.xy, vec3(seen.first.zw, seen.second.x));
    LeadrSurface surface;
    surface.mean_slope = map_mean_slope(map, scales.y * seen.first.xy);
    surface.slope_covariance = map_covariance(map, scale_height(covariance, scales.y));
    surface.roughness = sqrt(max(seen.second.z, 0.0)); // alpha squared is averaged (LEADR 4.1)
    surface.albedo = seen.color;
    surface.f0 = F0;
    vec3 wo = -normalize(ray);
    vec3 light = irradiance.rgb * leadr_light(surface, wo, sun.xyz);
    radiance = vec4(light + environment(surface, wo, frame, c), 1.0);
}
