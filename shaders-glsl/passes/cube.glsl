// Cube map geometry (pure functions). Faces in Vulkan's order +x −x +y −y +z −z, read with world directions (z up) as they are.
#ifndef CUBE_GLSL
#define CUBE_GLSL

// Unnormalised direction through the point (s, t), each in [-1, 1], of a face; the major component is ±1.
vec3 cube_direction(int face, vec2 st)
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

// Solid angle (sr) of a square of edge d around (s, t): midpoint rule with its second-order term.
// The exact form is a difference of four atan2, which at 256² keeps only three digits in 32 bits.
// Error O(d⁴): 1e-6 at 64².
float cube_solid_angle(vec2 st, float d)
{
    float q = 1.0 + dot(st, st);
    return d * d * inversesqrt(q) / q * (1.0 + d * d / 24.0 * (9.0 * q - 15.0) / (q * q));
}

#endif
