// Geometry of cube maps, as pure functions. The faces are in Vulkan's order +x −x +y −y +z −z. The faces are sampled with world directions
// (z up), which need no conversion.
#ifndef CUBE_GLSL
#define CUBE_GLSL

// Returns the direction, not normalised, through the point (s, t) of a face, each in [-1, 1]. The major component is ±1.
vec3 cube_direction(const int face, const vec2 st)
{
    switch (face) {
    case 0: return vec3(1.0, -st.y, -st.x);
    case 1: return vec3(-1.0, -st.y, st.x);
    case 2: return vec3(st.x, 1.0, st.y);
    case 3: return vec3(st.x, -1.0, -st.y);
    case 4: return vec3(st.x, -st.y, 1.0);
    default: return vec3(-st.x, -st.y, -1.0);
    }
}

// Returns the solid angle (sr) of a square of edge d < 0.1 around (s, t), by the midpoint rule with its second-order term.
float cube_solid_angle_small(const vec2 st, const float d)
{
    float q = 1.0 + dot(st, st);
    return d * d * inversesqrt(q) / q * (1.0 + d * d / 24.0 * (9.0 * q - 15.0) / (q * q));
}

// Returns the solid angle (sr) of a square of any size. The exact form is a difference of four atan, which has only three correct digits
// left in 32 bits at 256². Small squares therefore use the approximation. The error is always below 3e-6.
float cube_solid_angle(const vec2 st, const float d)
{
    if (d < 0.1) return cube_solid_angle_small(st, d);
    vec2 a = st - 0.5 * d;
    vec2 b = st + 0.5 * d;
    return atan(a.x * a.y, sqrt(1.0 + dot(a, a))) + atan(b.x * b.y, sqrt(1.0 + dot(b, b)))
         - atan(b.x * a.y, sqrt(1.0 + b.x * b.x + a.y * a.y)) - atan(a.x * b.y, sqrt(1.0 + a.x * a.x + b.y * b.y));
}

#endif
