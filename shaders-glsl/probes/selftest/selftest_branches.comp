#version 460
// Tests every way in which a constant can affect control flow.
layout(local_size_x = 64) in;
layout(constant_id = 0) const int WAY = 0;
layout(constant_id = 1) const bool EARLY = false;
layout(constant_id = 2) const float LIMIT = 1.0;
layout(constant_id = 3) const uint TURNS = 3u;
layout(constant_id = 4) const bool ONCE = true;

const int STEP = WAY == 3 ? 2 : WAY + 1;

layout(std430) readonly buffer In { float x[]; };
layout(std430) writeonly buffer Out { float y[]; };
layout(push_constant) uniform P { uint count; };

// In GLSL, a comparison of floats is not a constant expression.
bool is_far() {
    return LIMIT > 2.0 || WAY == 3;
}

// A switch with a fall-through and a nested break.
float switched(float v) {
    switch (WAY) {
        case 0: v += 1.0; break;
        case 1: v += 2.0;
        case 2:
            if (v > 4.0) {
                v -= 10.0;
                break;
            }
            v *= 3.0;
            break;
        default: return -v;
    }
    return v + 0.5;
}

// Constants can end this loop at once or after some iterations. If they do not, a run-time value ends the loop.
float looped(float v) {
    for (uint i = 0u; i < TURNS; ++i) {
        if (EARLY && i == 1u) {
            return v + 100.0;
        }
        if (WAY == 2) {
            continue;
        }
        for (int j = 0; j < 3; ++j) {
            if (is_far()) {
                break;
            }
            v += float(STEP);
        }
        if (v > 20.0) {
            break;
        }
    }
    return v;
}

float at_least_once(float v) {
    int turns = 0;
    do {
        v = v * 0.5 + 1.0;
        ++turns;
    } while (!ONCE && turns < 4);
    while (is_far()) {
        v -= 3.0;
        if (v < 0.0) {
            break;
        }
    }
    return v;
}

bool either(const bool a, bool b) {
    b = b && ONCE;
    return a || b;
}

void choose(const int way, inout bool chosen, out int steps) {
    if (way == 1) {
        chosen = !chosen;
    }
    steps = way + 1;
}

// These constants reach a branch through calls, through written parameters, and through variables with several values.
float called(float v) {
    bool chosen = EARLY;
    int steps;
    choose(WAY, chosen, steps);
    if (chosen) {
        v += 1.0;
    }
    for (int i = 0; i < steps; ++i) {
        v += 0.5;
    }
    bool later = false;
    if (v > 2.0) {
        later = either(EARLY, chosen);
    }
    if (later) {
        v = -v;
    }
    bool sometimes;
    if (WAY == 1) {
        sometimes = v > 3.0;
    }
    if (WAY == 1 && sometimes) {
        v += 8.0;
    }
    return either(WAY == 2, false) ? v - 2.0 : v;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) {
        return;
    }
    float v = x[i];
    if (LIMIT < 0.0) {
        y[i] = EARLY && v > 2.0 ? 7.0 : -7.0;
        return;
    }
    v = switched(v);
    if (!EARLY || v > LIMIT) {
        v = looped(v);
    } else if (TURNS % 2u == 1u) {
        v += 0.25;
    }
    y[i] = called(at_least_once(v));
}
