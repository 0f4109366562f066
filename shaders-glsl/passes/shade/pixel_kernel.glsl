// The kernels that the rotation of the macrosurface under a pixel adds to the slopes, with PER_LIGHT_KERNEL (Tokuyoshi & Kaplanyan 2019).
#ifndef LEADR_SHADE_PIXEL_KERNEL
#define LEADR_SHADE_PIXEL_KERNEL
#include "lighting.glsl"
#include "leadr/slopes/geometric_antialiasing.glsl"
#include "leadr/slopes/statistics.glsl"

// The smallest cosine of the viewer at which a position moves on the surface from pixel to pixel.
const float LEAST_MOVING_COSINE = 0.05;

// Returns the change of the half vector wh to the next pixel, in the frame of this pixel. step is the step of the ray to the next pixel for
// rays of length 1 along the view axis, and rotation is the change of the normal. length_h is the length of wo + wi.
vec3 half_vector_change(const Surface surface, const Light light, const vec3 wh, const float length_h, const vec3 step, const vec2 rotation) {
    vec3 wo = surface.wo;
    vec3 reach = surface.position - lighting.camera_position.xyz;
    vec3 axis = cross(lighting.rays[0].xyz, lighting.rays[1].xyz);
    float along = abs(dot(reach, axis)) / max(abs(dot(lighting.rays[2].xyz, axis)), 1e-20);
    vec3 moved = to_frame(surface.frame, step) * along;
    vec3 change = (wo * dot(wo, moved) - moved) * inversesqrt(max(dot(reach, reach), 1e-12));
    if (light.nearness > 0.0) {
        vec3 on_surface = moved - wo * (moved.z / max(wo.z, LEAST_MOVING_COSINE));
        change += (light.wi * dot(light.wi, on_surface) - on_surface) * light.nearness;
    }
    change = (change - wh * dot(wh, change)) / max(length_h, 1e-4);
    // A direction rotates against the frame.
    return change + vec3(-rotation * wh.z, dot(rotation, wh.xy));
}

// Returns the kernel of a light, as a covariance of slopes.
vec3 light_kernel(const Surface surface, const Light light) {
    vec3 h = surface.wo + light.wi;
    float length_h = length(h);
    vec3 wh = h / max(length_h, 1e-10);
    vec2 pixel = 2.0 / lighting.viewport.xy;
    return half_vector_kernel(wh, half_vector_change(surface, light, wh, length_h, lighting.rays[0].xyz * pixel.x, pixel_rotation[0]),
                              half_vector_change(surface, light, wh, length_h, lighting.rays[1].xyz * pixel.y, pixel_rotation[1]));
}

// Returns the covariance of the slopes with the kernel of the normal, for light without one direction.
vec3 with_normal_kernel(const Surface surface) {
    vec3 curvature = add_macro_curvature(vec3(0.0), -pixel_rotation[0], -pixel_rotation[1]);
    vec3 S = surface.slope_covariance;
    return S + kernel_over(tilt_kernel(curvature, surface.mean_slope), add_roughness(S, surface.alpha));
}

#endif
