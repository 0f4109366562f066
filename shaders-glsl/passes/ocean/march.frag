#version 460
#extension GL_GOOGLE_include_directive : require
// Computes the geometry of the sea for the reference. One ray per pixel is intersected with the waves of all cascades at full resolution,
// including horizontal displacement. Like the rasterised sea, the shader writes the rest position and the depth of the hit.
#include "../constants.glsl"
#include "../visible.glsl"
#include "cascade.glsl"

layout(std140) uniform View {
    vec4 rays[3]; // world direction through NDC (x, y): rays[2] + x rays[0] + y rays[1], of length 1 along the view axis
    vec4 eye;     // height above the water at rest; 1 / (2 radius of the earth); near plane; largest height of the waves
    vec4 centre;  // world xy of the eye
} view;
layout(std430) readonly buffer Cascades { Cascade cascades[]; };
layout(std430) readonly buffer Limits { vec2 limits[]; }; // for each cascade: largest height of the later cascades together,
                                                                        // and largest slope of all cascades up to this one
uniform sampler2DArray displacement;               // Dx, Dy, height

layout(location = 0) in vec2 in_texcoord;

layout(location = 0) out uvec4 out_surface;
layout(location = 1) out uvec2 out_footprint;

const int MOST_STEPS = 6000; // some software drivers stop loops after 65,535 iterations, including those of inner loops

vec3 moved_at(const vec2 rest, const int i) {
    return textureLod(displacement, vec3(cascade_texcoord(cascades[i], view.centre.xy + rest), float(i)), 0.0).xyz;
}

vec3 moved(const vec2 rest) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < cascades.length(); ++i) {
        sum += moved_at(rest, i);
    }
    return sum;
}

// Returns the height of the displaced sea above a point. The function searches for the rest position that the waves displace to this point,
// starting with a guess of the displacement.
float surface_height(const vec2 position, const int turns, inout vec2 shift) {
    float height = 0.0;
    for (int i = 0; i < turns; ++i) {
        vec3 d = moved(position - shift);
        shift = d.xy;
        height = d.z;
    }
    return height;
}

void main() {
    vec2 ndc = in_texcoord * 2.0 - 1.0;
    vec3 ray = view.rays[2].xyz + ndc.x * view.rays[0].xyz + ndc.y * view.rays[1].xyz;
    float stretch = length(ray);
    vec3 u = ray / stretch;

    // The height of the ray above the sea at rest is a s^2 + b s + c. The ray lies within the height of the waves from `begin` to `end`.
    float a = dot(u.xy, u.xy) * view.eye.y, b = u.z, c = view.eye.x, bound = view.eye.w;
    float discriminant = b * b - 4.0 * a * (c - bound);
    if (discriminant < 0.0 || (b >= 0.0 && c > bound)) {
        discard;
    }
    float root = sqrt(discriminant);
    float begin = c > bound ? 2.0 * (c - bound) / (root - b) : 0.0, end = (root - b) / (2.0 * max(a, 1e-12));

    int count = cascades.length();
    float s = begin, before = begin, gap_before = 0.0, gap = 0.0;
    vec2 shift = vec2(0.0);
    bool hit = false;
    for (int n = 0; n < MOST_STEPS && s < end; ++n) {
        vec2 position = u.xy * s, rest = position - shift;
        float height = (a * s + b) * s + c, smallest = 0.004 + 1e-5 * s, advance = 0.0;
        gap = height;
        vec2 sum = vec2(0.0);
        for (int i = 0; i < count; ++i) {
            vec3 d = moved_at(rest, i);
            gap -= d.z;
            sum += d.xy;
            vec2 limit = limits[i];
            // The shorter waves are small compared with the gap, so the step uses the long waves only.
            if (gap > 2.0 * limit.x) {
                advance = (gap - limit.x) / (abs(b + 2.0 * a * s) + limit.y);
                if (i + 1 < count && advance > 4.0 * smallest) {
                    break;
                }
            }
        }
        if (gap <= 0.0) {
            // The displacement belongs to the previous point, so it is evaluated again before the hit is accepted.
            sum = shift;
            gap = height - surface_height(position, 3, sum);
            if (gap <= 0.0) {
                hit = true;
                shift = sum;
                break;
            }
            advance = 0.0;
        }
        before = s;
        gap_before = gap;
        shift = sum;
        s += max(advance, smallest);
    }
    if (!hit) {
        discard;
    }
    // Secant and bisection steps alternate to narrow the interval between the last point above the water and the first point below.
    float low = before, high = s;
    float above = gap_before, below = gap;
    for (int n = 0; n < 6 && high > low; ++n) {
        float t = (n & 1) == 0 ? clamp(above / max(above - below, 1e-12), 0.05, 0.95) : 0.5;
        float middle = mix(low, high, t);
        vec2 at = shift;
        float g = (a * middle + b) * middle + c - surface_height(u.xy * middle, 2, at);
        if (g > 0.0) {
            low = middle;
            above = g;
        } else {
            high = middle;
            below = g;
            shift = at;
        }
    }
    surface_height(u.xy * high, 4, shift);
    vec2 rest = u.xy * high - shift;

    out_surface = uvec4(SEA_INDEX << OBJECT_SHIFT, floatBitsToUint(rest), 0u);
    out_footprint = uvec2(0u);
    gl_FragDepth = min(view.eye.z * stretch / max(high, 1e-6), 1.0);
}
