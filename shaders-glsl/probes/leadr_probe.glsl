// Declarations that all probes of the LEADR library share. Invocation i reads x[i * IN ..] and writes y[i * OUT ..].
layout(local_size_x = 64) in;
layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(push_constant) uniform P { uint count; };

uint at;

float next() { return x[at++]; }
vec2 next2() { float a = next(); return vec2(a, next()); }
vec3 next3() { vec2 a = next2(); return vec3(a, next()); }
void put(const float v) { y[at++] = v; }
void put(const vec2 v) { put(v.x); put(v.y); }
void put(const vec3 v) { put(v.xy); put(v.z); }
