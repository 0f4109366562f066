// Cube map geometry (pure functions). Faces in Vulkan's order +x −x +y −y +z −z, sampled with world directions (z up)
// unchanged.
#ifndef CUBE_GLSL
#define CUBE_GLSL

// Unnormalised direction through the point (s, t), each in [-1, 1], of a face; the major component is ±1.
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

// Solid angle (sr) of a square of edge d < 0.1 around (s, t): the midpoint rule with its second-order term.
float cube_solid_angle_small(const vec2 st, const float d)
{
    float q = 1.0 + dot(st, st);
    return d * d * inversesqrt(q) / q * (1.0 + d * d / 24.0 * (9.0 * q - 15.0) / (q * q));
}

// Solid angle (sr) of any square. The exact form is a difference of four atan, with three digits left in 32 bits at 256²; small
// squares use the approximation instead. Either way the error is below 3e-6.
float cube_solid_angle(const vec2 st, const float d)
{
    if (d < 0.1) return cube_solid_angle_small(st, d);
    vec2 a = st - 0.5 * d;
    vec2 b = st + 0.5 * d;
    return atan(a.x * a.y, sqrt(1.0 + dot(a, a))) + atan(b.x * b.y, sqrt(1.0 + dot(b, b)))
         - atan(b.x * a.y, sqrt(1.0 + b.x * b.x + a.y * a.y)) - atan(a.x * b.y, sqrt(1.0 + a.x * a.x + b.y * b.y));
}

#endif
