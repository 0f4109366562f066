#ifndef LEADR_FRAME_GLSL
#define LEADR_FRAME_GLSL

struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
};

// Returns an orthonormal frame whose z axis is the given unit vector (Frisvad 2012; Duff et al. 2017). Below the equator, 1 / (1 + z) is
// computed as (1 - z) / (x^2 + y^2), which keeps full precision down to the only discontinuity, z = (0, 0, -1).
Frame frame_about(const vec3 z) {
    float r2 = dot(z.xy, z.xy);
    float a = z.z >= 0.0 ? 1.0 / (1.0 + z.z) : (1.0 - z.z) / max(r2, 1e-30);
    float xy = -z.x * z.y * a;
    if (z.z < 0.0 && r2 < 1e-30) return Frame(vec3(1, 0, 0), vec3(0, -1, 0), z);
    return Frame(vec3(1.0 - z.x * z.x * a, xy, -z.x), vec3(xy, 1.0 - z.y * z.y * a, -z.y), z);
}

// Transforms a world direction to frame coordinates (to_frame), or frame coordinates to a world direction (from_frame).
vec3 to_frame(const Frame f, const vec3 world) {
    return vec3(dot(world, f.x), dot(world, f.y), dot(world, f.z));
}
vec3 from_frame(const Frame f, const vec3 local) {
    return f.x * local.x + f.y * local.y + f.z * local.z;
}

// Maps a unit vector to [-1, 1]^2 by the octahedral map, or back (Meyer et al. 2010).
vec2 octahedral_encode(const vec3 n) {
    vec2 p = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-30);
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? p : folded;
}
vec3 octahedral_decode(const vec2 e) {
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float t = max(-n.z, 0.0);
    n.xy += vec2(n.x >= 0.0 ? -t : t, n.y >= 0.0 ? -t : t);
    return normalize(n);
}

#endif
