#ifndef LEADR_NORMAL_DISTRIBUTION_GLSL
#define LEADR_NORMAL_DISTRIBUTION_GLSL

// Functions of the standard normal distribution, each of which costs one exponential and one division. The rational terms are minimax fits
// made for this project, with a relative error of 3e-7 to 7e-7 over 0..13. All coefficients are positive, so nothing cancels. Beyond 13 the
// density underflows in 32 bits, so the argument is clamped there.

// Returns the density phi(x).
float normal_pdf(const float x) {
    float t = clamp(x, -13.0, 13.0);
    return 0.3989422804 * exp(-0.5 * t * t);
}

// Returns Mills' ratio (1 - Phi(x)) / phi(x) for x >= 0. Beyond x = 14 its accuracy is 1e-4.
float mills_ratio(const float x) {
    float t = clamp(x, 0.0, 1e6);
    float p = 1.25331414 + t * (0.90476948 + t * (0.2980476 + t * 0.04231701));
    float q = 1.0 + t * (1.51977327 + t * (0.95053471 + t * (0.29783986 + t * 0.04232216)));
    return p / q;
}

// Returns 1 - x (1 - Phi(x)) / phi(x) for x >= 0, which is normal_tail_mean divided by the density, so it does not underflow. The variant
// with the suffix _held requires x within 0..1e6.
float tail_mean_ratio_held(const float t) {
    float p = 1.0 + t * (0.55532703 + t * (0.15290028 + t * 0.01936395));
    float q = 1.0 + t * (1.80865213 + t * (1.41958115 + t * (0.61708401 + t * (0.1527089 + t * 0.01936814))));
    return p / q;
}
float tail_mean_ratio(const float x) {
    return tail_mean_ratio_held(clamp(x, 0.0, 1e6));
}

// Returns Mills' ratio and tail_mean_ratio as x / q and y / q with a common denominator q = y + t x, for t within 0..13. The relative error
// of each quotient is 7e-7.
vec2 tail_quotients(const float t) {
    float t2 = t * t;
    return vec2((1.25331473 + 1.24099266 * t) + t2 * ((0.574059982 + 0.143326482 * t) + t2 * 0.0173465204),
                (1.0 + 0.534757579 * t) + t2 * (0.143585567 + 0.0173404136 * t));
}

// Returns E[max(0, u - x)] = phi(x) - x (1 - Phi(x)) for u ~ N(0,1) and x >= 0, the contribution of the tail above x to the mean of a
// clamped variable.
float normal_tail_mean(const float x) {
    float t = clamp(x, 0.0, 13.0);
    return 0.3989422804 * exp(-0.5 * t * t) * tail_mean_ratio_held(t);
}

// Returns Phi(x), the cumulative distribution.
float normal_cdf(const float x) {
    float t = min(abs(x), 13.0);
    float tail = normal_pdf(t) * mills_ratio(t);
    return x < 0.0 ? tail : 1.0 - tail;
}

// The density, the cumulative distribution and the ramp E[max(0, x + u)] = x Phi(x) + phi(x) for u ~ N(0,1). All three are computed
// together with one exponential.
struct NormalRamp {
    float pdf;
    float cdf;
    float ramp;
};

NormalRamp normal_ramp(const float x) {
    float t = min(abs(x), 13.0);
    float pdf = 0.3989422804 * exp(-0.5 * t * t);
    vec2 quotients = tail_quotients(t);
    vec2 tail = quotients * (pdf / (quotients.y + t * quotients.x));
    return NormalRamp(pdf, x < 0.0 ? tail.x : 1.0 - tail.x, max(x, 0.0) + tail.y);
}

// Describes the visible part of max(0, x + u), u ~ N(0,1), by two values: the shift of u towards the viewer, Phi(x) / (x Phi(x) + phi(x)),
// and the fraction that the mean alone contributes, max(x, 0) / (x Phi(x) + phi(x)). Both values together cost one exponential and one
// division. For x < 0, the numerator and the denominator are both multiples of the density. The density can underflow, so numerator and
// denominator are divided by it. x is clamped to at least -13.
struct ClampedLine {
    float lean;
    float front; // fraction that the mean alone contributes, 0..1
};

ClampedLine clamped_line(const float x) {
    float t = min(abs(x), 13.0);
    float pdf = 0.3989422804 * exp(-0.5 * t * t);
    vec2 tail = tail_quotients(t);
    float q = tail.y + t * tail.x;
    float per = 1.0 / (x < 0.0 ? tail.y : x * q + pdf * tail.y);
    return ClampedLine(per * (x < 0.0 ? tail.x : q - pdf * tail.x), per * max(x, 0.0) * q);
}

// Returns the standard normal quantile of u in (0, 1). u is clamped to [2^-25, 1 - 2^-24], the range of Giles' polynomials for the inverse
// error function (2010).
float normal_quantile(float u) {
    u = clamp(u, 2.9802322e-8, 0.99999994);
    float w = -log(4.0 * u * (1.0 - u));
    float p;
    if (w < 5.0) {
        w -= 2.5;
        p = 3.43273939e-7 + w * 2.81022636e-8;
        p = -4.39150654e-6 + w * (-3.5233877e-6 + w * p);
        p = -0.00125372503 + w * (0.00021858087 + w * p);
        p = 1.50140941 + w * (0.246640727 + w * (-0.00417768164 + w * p));
    } else {
        w = sqrt(w) - 3.0;
        p = 0.000100950558 - w * 0.000200214257;
        p = -0.00367342844 + w * (0.00134934322 + w * p);
        p = -0.0076224613 + w * (0.00573950773 + w * p);
        p = 2.83297682 + w * (1.00167406 + w * (0.00943887047 + w * p));
    }
    return 1.41421356 * (2.0 * u - 1.0) * p;
}

#endif
